//! Questions of the page.
//!
//! Positions are in units of the scene's reference system. Names that end in `_m` are in meters.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value};
use skyshed_core::city::Site;
use skyshed_core::coverage::{TrackHeight, TrackVertex, Way, WayVertex};
use skyshed_core::height_field::Curvature;
use skyshed_core::quantity::{Height, height_steps, meters};
use skyshed_core::raster::GeoRef;
use skyshed_request::json::{MemberFault, from_members};
use skyshed_request::{HeightErrors, Range, Receiver, Receivers, Sight};

/// A question of the page.
#[derive(Debug, Clone, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case")]
pub enum Question {
    /// Coverage by some UAVs.
    Map {
        /// UAVs, in order.
        uavs: Vec<Uav>,
        /// Receivers, range, antennas and earth.
        #[serde(deserialize_with = "read_sight")]
        sight: PageSight,
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
        /// Option of the sight, `height` of a UAV, or `search_radius` around the best place.
        field: String,
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
    /// Replaces the tracks of the page.
    Tracks {
        /// Tracks, in order.
        tracks: Vec<PageTrack>,
    },
    /// Stretches of the tracks that a UAV of the last map sees, or at least one of them.
    Stretches {
        /// Index of the UAV; all together without one.
        which: Option<usize>,
        /// Step by which stretches are decided over a curved earth.
        every_m: f64,
    },
    /// Heights along the tracks, and of what is below.
    TrackHeights,
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

/// Walk or flight of a user.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PageTrack {
    /// Name.
    pub name: Option<String>,
    /// East, north, height above the datum \[m\], time \[s\]; a walk has no heights and follows the ground.
    pub vertices: Vec<(f64, f64, Option<f64>, Option<f64>)>,
}

impl From<&Way> for PageTrack {
    fn from(way: &Way) -> PageTrack {
        let vertex = |of: &WayVertex| {
            let TrackVertex { position: [x, y], height } = of.vertex;
            let height_m = match height {
                TrackHeight::AboveDatum(z) => i32::try_from(z).ok().map(meters),
                TrackHeight::AboveGround(_) => None,
            };
            (x, y, height_m, of.time_s)
        };
        PageTrack { name: way.name.clone(), vertices: way.vertices.iter().map(vertex).collect() }
    }
}

impl PageTrack {
    /// Returns the way; a walk is at a height above the ground \[1/1024 m\]. `None` with heights
    /// beyond the lattice, or at some vertices alone.
    pub(crate) fn way(&self, walk: i32) -> Option<Way> {
        let has_heights = self.vertices.iter().all(|(_, _, height_m, _)| height_m.is_some());
        let vertex = |&(x, y, height_m, time_s): &(f64, f64, Option<f64>, Option<f64>)| {
            let height = match height_m {
                Some(m) if has_heights => TrackHeight::AboveDatum(i64::from(height_steps(m)?)),
                Some(_) => return None,
                None => TrackHeight::AboveGround(walk),
            };
            Some(WayVertex { vertex: TrackVertex { position: [x, y], height }, time_s, is_given: true })
        };
        let vertices = self.vertices.iter().map(vertex).collect::<Option<_>>()?;
        Some(Way { name: self.name.clone(), vertices })
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

/// Sight of a map of the page: options of the program.
///
/// `height_error` is the largest error of the heights of buildings here, if its effect on a UAV is
/// to be shown.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PageSight {
    /// Receivers, range, antennas and earth.
    #[serde(flatten)]
    pub sight: Sight,
    /// Errors of the heights of buildings.
    #[serde(flatten)]
    pub heights: HeightErrors,
}

impl PageSight {
    /// Returns the sight that a page starts with, unless it is told another.
    pub(crate) fn start() -> PageSight {
        let mut start = PageSight::default();
        start.sight.receiver = Receiver::DEFAULTS;
        start.sight.range.receivers = Range::DEFAULTS.receivers;
        start
    }

    /// Reads the members of a sight.
    ///
    /// # Errors
    /// Words about a member that does not exist, changes nothing on the page, or has a value that
    /// cannot be.
    pub(crate) fn from_members(members: Map<String, Value>) -> Result<PageSight, String> {
        let idle =
            members.iter().find(|(name, value)| ["height_bias", "method"].contains(&name.as_str()) && !value.is_null());
        if let Some((name, _)) = idle {
            return Err(format!("`{name}`, which changes nothing on a page"));
        }
        from_members(members).map_err(|MemberFault { member, reason }| {
            reason.unwrap_or_else(|| format!("`{member}`, which is no option of a page"))
        })
    }

    /// Returns the curvature of the earth, if it has one.
    pub(crate) fn curvature(&self) -> Option<Curvature> {
        self.sight.earth.k().and_then(Curvature::of_earth_k)
    }

    /// Returns the cells that hold receivers.
    pub(crate) fn receivers(&self) -> Receivers {
        self.sight.range.receiver_cells()
    }

    /// Returns the range in units of a grid; `None` without a limit.
    pub(crate) fn radius_on(&self, grid: &GeoRef) -> Option<f64> {
        self.sight.range.radius.map(|r| r / grid.meters_per_unit())
    }
}

fn read_sight<'de, D: Deserializer<'de>>(deserializer: D) -> Result<PageSight, D::Error> {
    PageSight::from_members(Map::deserialize(deserializer)?).map_err(D::Error::custom)
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
    #[serde(deserialize_with = "read_sight")]
    pub sight: PageSight,
}
