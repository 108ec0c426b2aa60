//! Reference systems that cannot be combined, or are no metric ones: refused.

use std::fmt::Display;

use crate::crs::{InputKind, degrees_refusal};
use crate::error::{Error, Result};
use crate::input::Input;
use crate::raster::{Crs, CrsKind};

/// Refuses to combine files in different CRSs, told apart by EPSG code, or by definition where neither has one; `remedy`
/// is the command that reprojects one of them. A CRS that is not known is taken for the other's.
pub fn refuse_two_crs(
    (a_path, a): (impl Display, Option<&Crs>),
    (b_path, b): (impl Display, Option<&Crs>),
    remedy: impl Fn(&Crs, &Crs) -> String,
) -> Result<()> {
    let (Some(a), Some(b)) = (a, b) else { return Ok(()) };
    if a.same_as(b) {
        return Ok(());
    }
    let (a_label, b_label) = (a.label(), b.label());
    let text = format!("cannot combine {a_path} in {a_label} with {b_path} in {b_label}: wanted one CRS");
    Err(Error::file(311, text).with_hint(remedy(a, b)))
}

/// Refuses a CRS in degrees, with the command that fixes it; `bounds` is `[west, south, east, north]`.
pub(crate) fn refuse_degrees(what: &Input, crs: &Crs, bounds: [f64; 4], kind: InputKind) -> Result<()> {
    match crs.kind() {
        CrsKind::Geographic => {
            let center = ((bounds[0] + bounds[2]) / 2.0, (bounds[1] + bounds[3]) / 2.0);
            Err(degrees_refusal(&what.to_string(), crs, kind, center))
        }
        CrsKind::Projected { .. } | CrsKind::Other => Ok(()),
    }
}
