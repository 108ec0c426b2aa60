//! Refusal of reference systems that cannot be combined, or are not metric.

use std::fmt::Display;

use crate::crs::is_web_mercator;
use crate::error::{Error, InputKind, Namer, Pair, ReadFault, Result, two_crs};
use crate::input::Input;
use crate::raster::{Crs, CrsKind};

/// Refuses to combine files in different CRSs, compared by EPSG code, or by definition where
/// neither has one. A file without a CRS is taken to be in that of the other.
///
/// # Errors
/// E311.
pub fn refuse_two_crs(
    (a_name, a): (impl Display, Option<&Crs>),
    (b_name, b): (impl Display, Option<&Crs>),
    pair: Pair,
) -> Result<()> {
    match (a, b) {
        (Some(a), Some(b)) if !a.same_as(b) => Err(two_crs((a_name, a), (b_name, b), pair)),
        _ => Ok(()),
    }
}

/// Refuses a CRS in degrees; `bounds` is `[west, south, east, north]`.
pub(crate) fn refuse_degrees(what: &Input, crs: &Crs, bounds: [f64; 4], kind: InputKind) -> Result<()> {
    match crs.kind() {
        CrsKind::Geographic => {
            let center = ((bounds[0] + bounds[2]) / 2.0, (bounds[1] + bounds[3]) / 2.0);
            Err(Error::read(what, ReadFault::Degrees { crs: crs.label(), kind, center }))
        }
        CrsKind::Projected { .. } | CrsKind::Other => Ok(()),
    }
}

/// Refuses web Mercator for footprints: their lengths would be stretched.
pub(super) fn refuse_web_mercator(what: &Input, crs: Option<&Crs>, named_by: Namer) -> Result<()> {
    match crs.filter(|crs| is_web_mercator(crs)) {
        Some(crs) => Err(Error::read(what, ReadFault::WebMercator { crs: crs.label(), named_by })),
        None => Ok(()),
    }
}
