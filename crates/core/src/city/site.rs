//! A site: a position and a height as typed, before a scene is known.

use super::{Antenna, UpTime};
use crate::quantity::Height;

/// The record of a UAV: a name, a position in the scene's CRS and a height.
#[derive(Debug, Clone, PartialEq)]
pub struct Site {
    /// Name, unique in a run.
    pub id: String,
    /// East \[CRS units\].
    pub x: f64,
    /// North \[CRS units\].
    pub y: f64,
    /// Height with its reference.
    pub height: Height,
    /// Its own antenna.
    pub antenna: Antenna,
    /// Time in which it is up; `None` for always.
    pub up: Option<UpTime>,
}

impl Site {
    /// Makes a site without limits of its own, so that it takes the antenna of the run, and is always up.
    pub fn new(id: impl Into<String>, (x, y): (f64, f64), height: Height) -> Self {
        Site { id: id.into(), x, y, height, antenna: Antenna::default(), up: None }
    }
}

/// A site as the user gave it.
#[derive(Debug, Clone, PartialEq)]
pub struct GivenSite {
    /// The site.
    pub site: Site,
    /// Its longitude and latitude \[deg\], if the user gave these.
    pub lonlat: Option<[f64; 2]>,
}

impl std::ops::Deref for GivenSite {
    type Target = Site;

    fn deref(&self) -> &Site {
        &self.site
    }
}

impl std::borrow::Borrow<Site> for GivenSite {
    fn borrow(&self) -> &Site {
        &self.site
    }
}

impl From<Site> for GivenSite {
    /// Makes a site given in the scene's CRS.
    fn from(site: Site) -> Self {
        GivenSite { site, lonlat: None }
    }
}
