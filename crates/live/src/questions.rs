//! Questions of the page.
//!
//! Positions are in units of the scene's reference system. Names that end in `_m` are in meters.

use serde::{Deserialize, Serialize};
use skyshed_core::city::{Antenna, Site};
use skyshed_core::coverage::SightNumbers;
use skyshed_core::height_field::Curvature;
use skyshed_core::quantity::Height;

/// A question of the page.
#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case")]
pub enum Question {
    /// Coverage by some UAVs.
    Map {
        /// UAVs, in order.
        uavs: Vec<Uav>,
        /// Receivers, range, antennas and earth.
        sight: Sight,
        /// Layer that the picture shows.
        shown: Shown,
    },
    /// Digest of the masks of the last map, or of one of them.
    Digest {
        /// Index of the UAV; all without one.
        #[serde(default)]
        which: Option<usize>,
    },
    /// Text of a field, read as the program reads its command line; nothing changes. A number has
    /// to fit all others of the last map.
    Read {
        /// Field.
        field: Field,
        /// Text as typed.
        text: String,
        /// East of the UAV whose height is read.
        x: f64,
        /// North of this UAV.
        y: f64,
    },
    /// Facts about a cell, given by a position.
    Cell {
        /// East.
        x: f64,
        /// North.
        y: f64,
        /// Index in the last map of the UAV whose margin is returned.
        which: usize,
    },
    /// Link to the receiver of the cell at a position.
    Link {
        /// Index of the UAV in the last map.
        which: usize,
        /// East.
        x: f64,
        /// North.
        y: f64,
    },
    /// Begins P_LoS against the height of a UAV of the last map; `curve_rows` continues.
    Curve {
        /// Index of the UAV.
        which: usize,
    },
    /// Continues the curve by some rows.
    CurveRows {
        /// Number of rows.
        rows: usize,
    },
    /// Begins the search for the best place around a UAV of the last map; `best_next` continues.
    Best {
        /// Index of the UAV.
        which: usize,
        /// Radius of the search.
        radius_m: f64,
    },
    /// Continues with the next place.
    BestNext,
    /// Comparison of several sets of UAVs with one of them.
    Compare {
        /// Sets of UAVs.
        kept: Vec<Kept>,
        /// Index of the set that all are compared with.
        base: usize,
    },
    /// Mask of a UAV of the last map, or of all together, as the picture.
    Mask {
        /// Index of the UAV; all without one.
        which: Option<usize>,
    },
}

/// Field of the page for a height, a number or two.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "as the program calls them")]
pub enum Field {
    Height,
    RxHeight,
    Radius,
    MinRadius,
    Sector,
    Elevation,
    Beam,
    EarthK,
    HeightError,
    /// Radius of the search for the best place around a UAV.
    SearchRadius,
}

/// UAV as the page knows it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Uav {
    /// Name.
    pub id: String,
    /// East.
    pub x: f64,
    /// North.
    pub y: f64,
    /// Height.
    pub height: AskedHeight,
}

impl Uav {
    /// Returns the site of the UAV, as engines know it.
    pub(crate) fn site(&self) -> Site {
        Site::new(self.id.clone(), (self.x, self.y), self.height.into())
    }
}

/// Height, with the level that it is above.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AskedHeight {
    /// Level that it is above.
    pub kind: HeightKind,
    /// Height above this level \[m\].
    pub m: f64,
}

/// Level that a height is above.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HeightKind {
    /// Ground below the UAV.
    Agl,
    /// Roof below the UAV.
    Roof,
    /// Vertical datum.
    Amsl,
}

impl From<AskedHeight> for Height {
    fn from(asked: AskedHeight) -> Height {
        match asked.kind {
            HeightKind::Agl => Height::agl(asked.m),
            HeightKind::Roof => Height::roof(asked.m),
            HeightKind::Amsl => Height::amsl(asked.m),
        }
    }
}

impl From<Height> for AskedHeight {
    fn from(height: Height) -> AskedHeight {
        let (kind, m) = match height {
            Height::AboveGround(m) => (HeightKind::Agl, m),
            Height::AboveRoof(m) => (HeightKind::Roof, m),
            Height::AboveDatum(m) => (HeightKind::Amsl, m),
        };
        AskedHeight { kind, m }
    }
}

/// Receivers, range, antennas and earth of a map.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Sight {
    /// Height of the receivers above the ground or roof below them.
    pub rx_height_m: f64,
    /// Kind of cells that hold receivers.
    pub receivers: Receivers,
    /// Largest horizontal distance, if there is one.
    pub radius_m: Option<f64>,
    /// Limits of the antennas of all UAVs: the least distance \[m\], two azimuths, two elevations
    /// and the beam \[deg\]. `None` without limits.
    #[serde(default)]
    pub antenna: Option<[Option<f64>; 6]>,
    /// Factor k of a curved earth; `None` for a flat one.
    #[serde(default)]
    pub earth_k: Option<f64>,
    /// Largest error of the heights of buildings \[m\], if its effect on a UAV is to be shown.
    #[serde(default)]
    pub height_error_m: Option<f64>,
}

impl Sight {
    /// Returns the curvature of the earth, if it has one.
    pub(crate) fn curvature(&self) -> Option<Curvature> {
        self.earth_k.and_then(Curvature::of_earth_k)
    }

    /// Returns its numbers, not yet checked.
    pub(crate) fn numbers(&self) -> SightNumbers {
        let Sight { rx_height_m, radius_m, earth_k, .. } = *self;
        SightNumbers { rx_height_m, radius_m, antenna: self.antenna(), earth_k }
    }

    /// Returns the limits of the antennas of all UAVs.
    pub(crate) fn antenna(&self) -> Antenna {
        let [min_radius_m, from, to, low, high, beam_deg] = self.antenna.unwrap_or_default();
        let pair = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| [a, b]);
        Antenna { min_radius_m, sector_deg: pair(from, to), elevation_deg: pair(low, high), beam_deg }
    }
}

/// Kind of cells that hold receivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "as the program calls them")]
pub enum Receivers {
    Ground,
    Street,
    Crossroad,
    Courtyard,
    Roof,
    All,
    Air,
}

/// Content of the picture.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct Shown {
    /// Layer.
    pub layer: Layer,
    /// Index of the UAV, for the layer of one UAV.
    pub which: usize,
}

/// Layer of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Layer {
    /// One UAV.
    One,
    /// Cells that any UAV sees.
    Union,
    /// Number of UAVs that see a cell.
    Count,
    /// UAVs, of up to four, that see a cell.
    Who,
}

/// UAVs that were kept, with their receivers and range.
#[derive(Debug, Clone, Deserialize)]
pub struct Kept {
    /// UAVs.
    pub uavs: Vec<Uav>,
    /// Receivers, range, antennas and earth.
    pub sight: Sight,
}
