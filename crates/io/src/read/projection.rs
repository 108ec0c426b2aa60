//! Which reference system a scene is brought into, from degrees into meters as a rule; and its footprints on their way.

use std::path::Path;

use super::building::{Buildings, bounds};
use crate::crs;
use crate::crs::{Transformation, utm_for};
use crate::error::{Error, Result, Warning};
use crate::raster::{Crs, CrsKind};

/// Where to.
#[derive(Debug, Clone, PartialEq)]
pub enum Projection {
    /// From degrees into the zone of UTM that the middle of the data lies in; what is in a projection stays.
    Auto,
    /// Into this one.
    To(Crs),
}

impl Projection {
    /// `auto`, or what [`crs::parse`] knows.
    ///
    /// # Errors
    /// E310 if the system is not known.
    pub fn parse(text: &str) -> Result<Projection> {
        if text == "auto" { Ok(Projection::Auto) } else { crs::parse(text).map(Projection::To) }
    }

    /// Where data in `from` around `middle` are to go; `from` itself where they stay.
    pub(super) fn target(&self, from: &Crs, middle: (f64, f64)) -> Result<Crs> {
        match self {
            Projection::To(to) => Ok(to.clone()),
            Projection::Auto if !matches!(from.kind(), CrsKind::Geographic) => Ok(from.clone()),
            Projection::Auto => {
                let wgs84 = crs::from_epsg(4326)?;
                let (lon, lat) = Transformation::new(from, &wgs84, middle)?.apply(middle)?;
                crs::from_epsg(utm_for(lon, lat))
            }
        }
    }
}

/// The refusal to project what is in no known system.
pub(super) fn no_crs(path: &Path) -> Error {
    let text = format!("cannot project {}: it names no coordinate reference system", path.display());
    Error::file(310, text).with_hint("say which it is: `--crs EPSG:n`")
}

/// Takes all positions into the wanted system, and says so; returns the system that they are in afterwards.
///
/// Without a system of their own, positions that can be degrees are taken for longitude and latitude.
///
/// # Errors
/// E310 if there is no way from the one system to the other, or it is not known what the positions are in.
pub(super) fn project(
    path: &Path,
    raw: &mut Buildings,
    from: Option<Crs>,
    projection: &Projection,
    warnings: &mut Vec<Warning>,
) -> Result<Option<Crs>> {
    let Some([west, south, east, north]) = raw.bounds() else { return Ok(from) };
    let may_be_degrees = west >= -180.0 && east <= 180.0 && south >= -90.0 && north <= 90.0;
    let from = match from {
        Some(from) => from,
        None if may_be_degrees => crs::from_epsg(4326)?,
        None => return Err(no_crs(path)),
    };
    let middle = ((west + east) / 2.0, (south + north) / 2.0);
    let to = projection.target(&from, middle)?;
    if from == to {
        return Ok(Some(to));
    }
    let way = Transformation::new(&from, &to, middle)?;
    for position in raw.footprints.iter_mut().flat_map(|f| &mut f.polygons).flatten().flatten() {
        let (x, y) = way.apply((position[0], position[1]))?;
        *position = [x, y];
    }
    if bounds(raw.footprints.iter().flat_map(|f| &f.polygons)).is_some() {
        let text = format!("{}: brought from {} to {} ({})", path.display(), from.label(), to.label(), to.name());
        warnings.push(Warning::new(335, text));
    }
    Ok(Some(to))
}
