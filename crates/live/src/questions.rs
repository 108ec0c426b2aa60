//! What the page asks. Positions are in units of the scene's reference system, names that end in `_m` in meters.

use serde::{Deserialize, Serialize};
use skyshed_core::city::{Antenna, Site};
use skyshed_core::coverage::SightNumbers;
use skyshed_core::height_field::Curvature;
use skyshed_core::quantity::Height;

/// A question of the page.
#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case")]
pub enum Question {
    /// Coverage of some UAVs.
    Map {
        /// They, in order.
        uavs: Vec<Uav>,
        /// For whom.
        sight: Sight,
        /// What the picture shows.
        shown: Shown,
    },
    /// The digest of the masks of the last map, or of one of them.
    Digest {
        /// Which UAV; all without one.
        #[serde(default)]
        which: Option<usize>,
    },
    /// What was typed into a field, read as the program reads its command line; nothing changes. A number is to go with all
    /// others of the last map.
    Read {
        /// Which.
        field: Field,
        /// What was typed.
        text: String,
        /// East of the UAV that a height is to be of.
        x: f64,
        /// North of it.
        y: f64,
    },
    /// What is at a position.
    Cell {
        /// East.
        x: f64,
        /// North.
        y: f64,
        /// Whose margin, by its place in the last map.
        which: usize,
    },
    /// The link to the receiver of the cell at a position.
    Link {
        /// Which UAV of the last map.
        which: usize,
        /// East.
        x: f64,
        /// North.
        y: f64,
    },
    /// Begins P_LoS against the height of a UAV of the last map; `curve_rows` goes on.
    Curve {
        /// Which.
        which: usize,
    },
    /// Goes on with the curve by so many rows.
    CurveRows {
        /// How many.
        rows: usize,
    },
    /// Begins to look for the best place around a UAV of the last map; `best_next` goes on.
    Best {
        /// Which.
        which: usize,
        /// How far around it.
        radius_m: f64,
    },
    /// Goes on with the next place.
    BestNext,
    /// What several sets of UAVs see together, against one of them.
    Compare {
        /// The sets.
        kept: Vec<Kept>,
        /// The one that others are held against.
        base: usize,
    },
    /// The mask of a UAV of the last map, or of all together, as the picture.
    Mask {
        /// Which.
        which: Option<usize>,
    },
}

/// A field of the page for a height, a number or two.
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
    /// How far around a UAV the best place is looked for.
    SearchRadius,
}

/// A UAV as the page knows it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Uav {
    /// Its name.
    pub id: String,
    /// East.
    pub x: f64,
    /// North.
    pub y: f64,
    /// Its height.
    pub height: AskedHeight,
}

impl Uav {
    /// As the engines know it.
    pub(crate) fn site(&self) -> Site {
        Site::new(self.id.clone(), (self.x, self.y), self.height.into())
    }
}

/// A height, and what it is above.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AskedHeight {
    /// What it is above.
    pub kind: HeightKind,
    /// How high \[m\].
    pub m: f64,
}

/// What a height is above.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HeightKind {
    /// The ground there.
    Agl,
    /// The roof there.
    Roof,
    /// The datum.
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

/// For whom a map is made.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Sight {
    /// Height of the receivers above what they stand on.
    pub rx_height_m: f64,
    /// Which cells hold receivers.
    pub receivers: Receivers,
    /// Largest horizontal distance, if there is one.
    pub radius_m: Option<f64>,
    /// What the antennas of all UAVs serve, if not all: the least distance \[m\], two azimuths, two elevations and the beam \[deg\].
    #[serde(default)]
    pub antenna: Option<[Option<f64>; 6]>,
    /// K of a curved earth, if it is not taken as flat.
    #[serde(default)]
    pub earth_k: Option<f64>,
    /// How far heights of buildings may be off \[m\], if that is to be told of one UAV.
    #[serde(default)]
    pub height_error_m: Option<f64>,
}

impl Sight {
    /// The curve of the earth, if it has one.
    pub(crate) fn curvature(&self) -> Option<Curvature> {
        self.earth_k.and_then(Curvature::of_earth_k)
    }

    /// Its numbers, not yet checked.
    pub(crate) fn numbers(&self) -> SightNumbers {
        let Sight { rx_height_m, radius_m, earth_k, .. } = *self;
        SightNumbers { rx_height_m, radius_m, antenna: self.antenna(), earth_k }
    }

    /// What the antennas of all UAVs serve.
    pub(crate) fn antenna(&self) -> Antenna {
        let [min_radius_m, from, to, low, high, beam_deg] = self.antenna.unwrap_or_default();
        let pair = |a: Option<f64>, b: Option<f64>| a.zip(b).map(|(a, b)| [a, b]);
        Antenna { min_radius_m, sector_deg: pair(from, to), elevation_deg: pair(low, high), beam_deg }
    }
}

/// Which cells hold receivers.
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

/// What the picture shows.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct Shown {
    /// Of whom.
    pub layer: Layer,
    /// Which UAV, for one alone.
    pub which: usize,
}

/// Of whom a picture is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Layer {
    /// One UAV.
    One,
    /// What any sees.
    Union,
    /// How many see a cell.
    Count,
    /// Which of up to four see it.
    Who,
}

/// UAVs that were kept, and for whom.
#[derive(Debug, Clone, Deserialize)]
pub struct Kept {
    /// They.
    pub uavs: Vec<Uav>,
    /// For whom.
    pub sight: Sight,
}
