//! Which reference system a scene is brought into, from degrees into meters as a rule; and its footprints on their way.

use crate::crs;
use crate::crs::{Transformation, is_web_mercator, utm_for};
use crate::error::Result;
use crate::raster::{Crs, CrsKind};

/// Where to.
#[derive(Debug, Clone, PartialEq)]
pub enum Projection {
    /// From degrees and web Mercator into the zone of UTM that the middle of the data lies in; what is in another
    /// projection stays.
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
