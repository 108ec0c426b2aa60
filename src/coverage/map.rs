//! One map: every receiver of the grid against one UAV.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

use super::{Tally, Uav, class};
use crate::error::{Error, ErrorClass, Result};
use crate::height_field::{CellKind, HeightField, Station};
use crate::los::{link_ceilings, link_least_heights, link_los};
use crate::quantity::{MAX_HEIGHT_M, STEPS_PER_UNIT, VOID, meters};

/// Which cells hold receivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Receivers {
    /// All cells of open ground.
    #[default]
    Ground,
    /// Building cells only, standing on the roof.
    Roof,
    /// Both.
    All,
}

/// How a map is made.
#[derive(Debug, Clone, PartialEq)]
pub struct MapOptions {
    /// Height of the receivers above what they stand on \[1/1024 m\].
    pub rx_height: i32,
    /// Which cells hold receivers.
    pub receivers: Receivers,
    /// Largest horizontal distance from the UAV to a cell center \[CRS units\].
    pub radius: Option<f64>,
    /// Length of a CRS unit \[m\], for elevation angles.
    pub meters_per_unit: f64,
    /// Which layers of heights to make.
    pub layers: HeightLayers,
}

impl Default for MapOptions {
    /// Receivers 1.5 m above open ground, at any distance, in a CRS in meters; the mask alone.
    fn default() -> Self {
        MapOptions {
            rx_height: 3 * STEPS_PER_UNIT / 2,
            receivers: Receivers::Ground,
            radius: None,
            meters_per_unit: 1.0,
            layers: HeightLayers::default(),
        }
    }
}

/// The layers of heights of one UAV, beside its mask.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HeightLayers {
    /// Receiver height less ceiling.
    pub margin: bool,
    /// Least receiver height in line of sight.
    pub ceiling: bool,
    /// Least UAV height, over its place, that sees the receiver.
    pub least_height: bool,
}

/// The coverage of one UAV: shape `[n_rows, n_cols]` each, columns running fastest, row 0 north.
#[derive(Debug, Clone)]
pub struct SiteCoverage {
    /// The UAV.
    pub uav: Uav,
    /// Classes of [`class`].
    pub mask: Vec<u8>,
    /// Receiver height less ceiling \[m\]; ≥ 0 exactly where LoS, NaN where there is no receiver.
    pub margin: Option<Vec<f32>>,
    /// Least receiver height in line of sight \[m above the datum\], never below what the receiver stands on.
    pub ceiling: Option<Vec<f32>>,
    /// Least UAV height over its place that sees the receiver \[m above the datum\], never below the surface there; +∞
    /// where none within ±32 768 m does.
    pub least_height: Option<Vec<f32>>,
    /// Counts.
    pub tally: Tally,
}

/// Progress out of, and the wish to stop into, a running map.
#[derive(Debug, Default)]
pub struct Control {
    /// Cells decided so far.
    pub done: AtomicU64,
    /// Set it to stop at the next row.
    pub stop: AtomicBool,
}

/// Maps what one UAV sees.
///
/// Cost: one ray per receiver, shared by all threads of the current pool.
///
/// # Errors
/// Only [`ErrorClass::Interrupted`], when `control.stop` was set.
pub fn map_site(field: &HeightField, uav: &Uav, options: &MapOptions, control: &Control) -> Result<SiteCoverage> {
    let grid = field.grid();
    let (n_rows, n_cols) = (grid.n_rows(), grid.n_cols());
    let positions = field.positions();
    let layer = |wanted: bool| if wanted { vec![f32::NAN; grid.n_cells()] } else { Vec::new() };
    let mut mask = vec![class::NODATA; grid.n_cells()];
    let mut margin = layer(options.layers.margin);
    let mut ceiling = layer(options.layers.ceiling);
    let mut least_height = layer(options.layers.least_height);
    let cell = CellJob::new(field, uav, options);

    let rows: Vec<Row<'_>> = split(&mut mask, n_rows, n_cols)
        .zip(split(&mut margin, n_rows, n_cols))
        .zip(split(&mut ceiling, n_rows, n_cols))
        .zip(split(&mut least_height, n_rows, n_cols))
        .map(|(((mask, margin), ceiling), least_height)| Row { mask, margin, ceiling, least_height })
        .collect();
    let tallies: Vec<Tally> = rows
        .into_par_iter()
        .enumerate()
        .map(|(row, out)| {
            let mut tally = Tally::default();
            if control.stop.load(Ordering::Relaxed) {
                return tally;
            }
            for col in 0..n_cols {
                let found = cell.decide(row * n_cols + col, positions.center(row, col));
                out.mask[col] = found.class;
                if let Some(v) = out.margin.get_mut(col) {
                    *v = found.margin;
                }
                if let Some(v) = out.ceiling.get_mut(col) {
                    *v = found.ceiling;
                }
                if let Some(v) = out.least_height.get_mut(col) {
                    *v = found.least_height;
                }
                tally.add(found.class, found.rise, found.distance);
            }
            control.done.fetch_add(n_cols as u64, Ordering::Relaxed);
            tally
        })
        .collect();
    if control.stop.load(Ordering::Relaxed) {
        return Err(Error::new(ErrorClass::Interrupted, 130, "interrupted; nothing was written"));
    }
    let some = |wanted: bool, values: Vec<f32>| wanted.then_some(values);
    Ok(SiteCoverage {
        uav: uav.clone(),
        tally: tallies.iter().fold(Tally::default(), |sum, t| sum.plus(t)),
        mask,
        margin: some(options.layers.margin, margin),
        ceiling: some(options.layers.ceiling, ceiling),
        least_height: some(options.layers.least_height, least_height),
    })
}

/// One row of every output; rows of layers that are not wanted are empty.
struct Row<'a> {
    mask: &'a mut [u8],
    margin: &'a mut [f32],
    ceiling: &'a mut [f32],
    least_height: &'a mut [f32],
}

/// The rows of a layer, or as many empty rows.
fn split<T>(cells: &mut [T], n_rows: usize, n_cols: usize) -> impl Iterator<Item = &mut [T]> {
    let width = if cells.is_empty() { 0 } else { n_cols };
    let mut rest = cells;
    (0..n_rows).map(move |_| {
        let (row, tail) = std::mem::take(&mut rest).split_at_mut(width);
        rest = tail;
        row
    })
}

/// What is the same for all cells of a map.
struct CellJob<'a> {
    field: &'a HeightField,
    uav: &'a Uav,
    options: &'a MapOptions,
    /// Lowest height that a UAV may have at its place \[1/1024 m\].
    surface_under_uav: i32,
}

/// What was found at one cell.
struct Found {
    class: u8,
    margin: f32,
    ceiling: f32,
    least_height: f32,
    /// Height of the UAV above the receiver \[m\].
    rise: f64,
    /// Horizontal distance \[m\].
    distance: f64,
}

impl<'a> CellJob<'a> {
    fn new(field: &'a HeightField, uav: &'a Uav, options: &'a MapOptions) -> Self {
        let place = &uav.station.place;
        let surface_under_uav =
            field.ground_at(place).max(field.inside_prisms_below(place)).max(field.inside_columns_below(place));
        CellJob { field, uav, options, surface_under_uav }
    }

    fn decide(&self, index: usize, place: crate::height_field::Place) -> Found {
        let uav = &self.uav.station;
        let to_uav = (uav.place.x - place.x, uav.place.y - place.y);
        let distance_squared = to_uav.0 * to_uav.0 + to_uav.1 * to_uav.1;
        let mut found = Found {
            class: class::NODATA,
            margin: f32::NAN,
            ceiling: f32::NAN,
            least_height: f32::NAN,
            rise: 0.0,
            distance: distance_squared.sqrt() * self.options.meters_per_unit,
        };
        let stands_on = match (self.field.cell_kind(index, &place), self.options.receivers) {
            (CellKind::Void, _) => return found,
            (CellKind::Open(ground), Receivers::Ground | Receivers::All) => Some(ground),
            (CellKind::Building(roof), Receivers::Roof | Receivers::All) => Some(roof),
            (CellKind::Open(_), Receivers::Roof) | (CellKind::Building(_), Receivers::Ground) => None,
        };
        if self.options.radius.is_some_and(|r| distance_squared > r * r) {
            found.class = class::OUT_OF_RANGE;
            return found;
        }
        let Some(stands_on) = stands_on else {
            found.class = class::NOT_A_RECEIVER;
            return found;
        };
        let receiver = Station { place, z: i64::from(stands_on) + i64::from(self.options.rx_height) };
        #[expect(clippy::cast_precision_loss, reason = "heights are at most 2^27 steps")]
        let rise = (uav.z - receiver.z) as f64 / f64::from(STEPS_PER_UNIT);
        found.rise = rise;

        let layers = self.options.layers;
        let is_los = if layers.margin || layers.ceiling {
            let (b, t) = link_ceilings(self.field, uav, &receiver);
            let is_los = b.is_met_by(receiver.z) && t.is_met_by(receiver.z);
            let lowest = f64::from(stands_on);
            let ceiling = b.height_steps().max(t.height_steps()).max(lowest) / f64::from(STEPS_PER_UNIT);
            #[expect(clippy::cast_precision_loss, reason = "heights are at most 2^27 steps")]
            let height = receiver.z as f64 / f64::from(STEPS_PER_UNIT);
            found.ceiling = narrow(ceiling);
            // The sign is decided exactly; rounding to f32 must not turn it.
            found.margin = narrow(height - ceiling);
            found.margin = if is_los { found.margin.max(0.0) + 0.0 } else { found.margin.min(-f32::MIN_POSITIVE) };
            is_los
        } else {
            link_los(self.field, uav, &receiver)
        };
        if layers.least_height {
            let (b, t) = link_least_heights(self.field, uav, &receiver);
            let least = b.height_steps().max(t.height_steps()).max(floor_of(self.surface_under_uav));
            let least = least / f64::from(STEPS_PER_UNIT);
            found.least_height = if least > MAX_HEIGHT_M { f32::INFINITY } else { narrow(least) };
        }
        found.class = if is_los { class::LOS } else { class::NLOS };
        found
    }
}

/// A surface as the least height over it; nothing known bounds nothing but the lattice.
fn floor_of(surface: i32) -> f64 {
    if surface == VOID {
        -MAX_HEIGHT_M * f64::from(STEPS_PER_UNIT)
    } else {
        meters(surface) * f64::from(STEPS_PER_UNIT)
    }
}

#[expect(clippy::cast_possible_truncation, reason = "layers are stored as f32, 4 mm at 32 km")]
fn narrow(v: f64) -> f32 {
    v as f32
}
