//! Reference system that a scene is projected to, as a rule from degrees to meters.

use crate::crs;
use crate::crs::{Transformation, is_web_mercator, utm_for};
use crate::error::Result;
use crate::raster::{Crs, CrsKind};

/// Target of a projection.
#[derive(Debug, Clone, PartialEq)]
pub enum Projection {
    /// The UTM zone at the middle of the data, for data in degrees or web Mercator. Data in another
    /// projection stay.
    Auto,
    /// This system.
    To(Crs),
}

impl Projection {
    /// Parses `auto`, or a notation that [`crs::parse`] reads.
    ///
    /// # Errors
    /// E310 if the system is not known.
    pub fn parse(text: &str) -> Result<Projection> {
        if text == "auto" { Ok(Projection::Auto) } else { crs::parse(text).map(Projection::To) }
    }

    /// Returns the target of data in `from` around `middle`; `from` itself where they stay.
    pub(super) fn target(&self, from: &Crs, middle: (f64, f64)) -> Result<Crs> {
        match self {
            Projection::To(to) => Ok(to.clone()),
            Projection::Auto if !matches!(from.kind(), CrsKind::Geographic) && !is_web_mercator(from) => {
                Ok(from.clone())
            }
            Projection::Auto => {
                let wgs84 = crs::from_epsg(4326)?;
                let (lon, lat) = Transformation::new(from, &wgs84, middle)?.apply(middle)?;
                crs::from_epsg(utm_for(lon, lat))
            }
        }
    }
}
