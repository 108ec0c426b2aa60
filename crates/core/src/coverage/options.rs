//! Options of maps, and how running work is watched and stopped.

use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::city::Antenna;
use crate::error::{Error, Result};
use crate::height_field::{Curvature, HeightField, StandsOn};
use crate::los::{HeightErrors, MethodChoice};
use crate::quantity::STEPS_PER_UNIT;
use crate::raster::{BitGrid, CellWindow};

/// Cells that hold receivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Receivers {
    /// All cells of open ground.
    #[default]
    Ground,
    /// Building cells only, standing on the roof.
    Roof,
    /// Both.
    All,
    /// Over all ground, also where a building is that reaches no higher: places of a drone at a
    /// height above the ground.
    Air,
}

impl Receivers {
    /// Lists the kinds of receivers by what they stand on.
    pub(super) fn stands(self) -> &'static [Stand] {
        match self {
            Receivers::Ground => &[Stand::Ground],
            Receivers::Roof => &[Stand::Roof],
            Receivers::All => &[Stand::Ground, Stand::Roof],
            Receivers::Air => &[Stand::Air],
        }
    }
}

/// Kind of receivers by what they stand on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stand {
    Ground,
    Roof,
    /// Over all ground that is free at their height.
    Air,
}

impl Stand {
    /// Returns the cells that hold receivers at a height above what they stand on \[1/1024 m\].
    pub(super) fn cells(self, field: &HeightField, rx_height: i32) -> Cow<'_, BitGrid> {
        match self {
            Stand::Ground => Cow::Borrowed(&field.cells().open),
            Stand::Roof => Cow::Borrowed(&field.cells().building),
            Stand::Air => Cow::Owned(field.free_above_ground(rx_height)),
        }
    }

    /// Returns the heights that they stand on.
    pub(super) fn heights(self, field: &HeightField) -> StandsOn<'_> {
        match self {
            Stand::Ground | Stand::Air => field.ground_of_cells(),
            Stand::Roof => field.roof_of_cells(),
        }
    }
}

/// Options of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct MapOptions {
    /// Height of the receivers above what they stand on \[1/1024 m\].
    pub rx_height: i32,
    /// Cells that hold receivers.
    pub receivers: Receivers,
    /// Only cells of this set hold receivers, if there is one: those of a zone or an area.
    pub within: Option<BitGrid>,
    /// Window of the cells with answers: masks, layers and counts hold these alone. Cells outside of
    /// it can still hide receivers. `None` for all cells.
    pub window: Option<CellWindow>,
    /// Largest horizontal distance from the UAV to a cell center \[CRS units\].
    pub radius: Option<f64>,
    /// Antenna of UAVs that have none of their own.
    pub antenna: Antenna,
    /// The curve of the earth, if it is not taken as flat.
    pub curvature: Option<Curvature>,
    /// Length of a CRS unit \[m\], for elevation angles and antennas.
    pub meters_per_unit: f64,
    /// Errors of heights of buildings, for the layers that depend on them.
    pub height_errors: HeightErrors,
    /// Standard deviations of these that bound the layer `sure`.
    pub sigma: f64,
    /// Layers to make.
    pub layers: HeightLayers,
    /// Engine that decides.
    pub method: MethodChoice,
}

impl Default for MapOptions {
    /// Returns receivers 1.5 m above open ground, at any distance, in a CRS in meters; the mask
    /// alone.
    fn default() -> Self {
        MapOptions {
            rx_height: 3 * STEPS_PER_UNIT / 2,
            receivers: Receivers::Ground,
            within: None,
            window: None,
            radius: None,
            antenna: Antenna::default(),
            curvature: None,
            meters_per_unit: 1.0,
            height_errors: HeightErrors::default(),
            sigma: 2.0,
            layers: HeightLayers::default(),
            method: MethodChoice::Auto,
        }
    }
}

/// The layers of one UAV beside its mask: of heights, and of how stable its answers are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HeightLayers {
    /// Receiver height less the least visible height.
    pub margin: bool,
    /// Least receiver height in line of sight.
    pub least_receiver_height: bool,
    /// Least UAV height, over its place, that sees the receiver.
    pub least_height: bool,
    /// Number of eight moves by one lattice step that turn the answer, see [`super::Stability`].
    pub stability: bool,
    /// Who is in line of sight whatever heights are within their errors, and who may be.
    pub sure: bool,
    /// Probability of line of sight, with errors of heights.
    pub p_los: bool,
}

impl HeightLayers {
    /// Returns whether any of them needs the whole scene in memory.
    pub(super) fn need_all_in_memory(self) -> bool {
        self.least_height || self.stability || self.sure || self.p_los
    }

    /// Returns whether a link must be walked for any of them.
    pub(super) fn has_heights(self) -> bool {
        self.margin || self.least_receiver_height || self.least_height
    }
}

/// Progress out of, and the wish to stop into, running work: whatever takes one fails with
/// [`Error::Interrupted`] once `stop` was set.
#[derive(Debug, Default)]
pub struct Control {
    /// Cells decided so far.
    pub done: AtomicU64,
    /// Set it to stop at the next row.
    pub stop: AtomicBool,
}

impl Control {
    /// Returns whether the work is to stop.
    pub(super) fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Fails if the work is to stop.
    pub fn check(&self) -> Result<()> {
        if self.is_stopped() { Err(Error::Interrupted) } else { Ok(()) }
    }
}
