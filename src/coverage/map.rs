//! Maps: every receiver of the grid against one UAV, or against many with the scene made ready once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

use super::cell_classes::{RowSets, write_classes};
use super::elevation::RowElevations;
use super::range::Range;
use super::stability::{Decided, ShiftedRoofs};
use super::{Stability, Tally, Uav};
use crate::error::{Error, ErrorClass, Result};
use crate::height_field::{Casters, GridPositions, HeightField, Place, Station};
use crate::los::{GridLos, GridReceivers, Method, MethodChoice, link_ceilings, link_least_heights, link_los};
use crate::quantity::{MAX_HEIGHT_M, STEPS_PER_UNIT, VOID, meters};
use crate::raster::{BitGrid, LargeVec, set_bits};

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
    /// Only cells of this set hold receivers, if there is one: those of a zone or an area.
    pub within: Option<BitGrid>,
    /// Largest horizontal distance from the UAV to a cell center \[CRS units\].
    pub radius: Option<f64>,
    /// Length of a CRS unit \[m\], for elevation angles.
    pub meters_per_unit: f64,
    /// Which layers of heights to make.
    pub layers: HeightLayers,
    /// Which engine decides; all are exact but those that say they are not.
    pub method: MethodChoice,
}

impl Default for MapOptions {
    /// Receivers 1.5 m above open ground, at any distance, in a CRS in meters; the mask alone.
    fn default() -> Self {
        MapOptions {
            rx_height: 3 * STEPS_PER_UNIT / 2,
            receivers: Receivers::Ground,
            within: None,
            radius: None,
            meters_per_unit: 1.0,
            layers: HeightLayers::default(),
            method: MethodChoice::Auto,
        }
    }
}

/// The layers of one UAV beside its mask: of heights, and of how stable its answers are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HeightLayers {
    /// Receiver height less ceiling.
    pub margin: bool,
    /// Least receiver height in line of sight.
    pub ceiling: bool,
    /// Least UAV height, over its place, that sees the receiver.
    pub least_height: bool,
    /// How many of eight moves by one lattice step turn the answer, see [`Stability`].
    pub stability: bool,
}

impl HeightLayers {
    /// Whether a link must be walked for any of them.
    fn has_heights(self) -> bool {
        self.margin || self.ceiling || self.least_height
    }
}

/// The coverage of one UAV: shape `[n_rows, n_cols]` each, columns running fastest, row 0 north.
#[derive(Debug, Clone)]
pub struct SiteCoverage {
    /// The UAV.
    pub uav: Uav,
    /// Classes of [`super::class`].
    pub mask: LargeVec<u8>,
    /// Receiver height less ceiling \[m\]; ≥ 0 exactly where LoS, NaN where there is no receiver.
    pub margin: Option<Vec<f32>>,
    /// Least receiver height in line of sight \[m above the datum\], never below what the receiver stands on.
    pub ceiling: Option<Vec<f32>>,
    /// Least UAV height over its place that sees the receiver \[m above the datum\], never below the surface there; +∞
    /// where none within ±32 768 m does.
    pub least_height: Option<Vec<f32>>,
    /// How stable the answers are.
    pub stability: Option<Stability>,
    /// Counts.
    pub tally: Tally,
}

/// What a UAV sees, as sets of cells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Seen {
    /// The receivers in range.
    pub receivers: BitGrid,
    /// Those in line of sight.
    pub los: BitGrid,
}

/// Progress out of, and the wish to stop into, a running map.
#[derive(Debug, Default)]
pub struct Control {
    /// Cells decided so far.
    pub done: AtomicU64,
    /// Set it to stop at the next row.
    pub stop: AtomicBool,
}

/// Maps what one UAV sees: [`Mapper::new`] and [`Mapper::map`] in one.
///
/// # Errors
/// As those two.
pub fn map_site(field: &HeightField, uav: &Uav, options: &MapOptions, control: &Control) -> Result<SiteCoverage> {
    Mapper::new(field, options)?.map(uav, control)
}

/// A scene and options made ready for any number of UAVs.
#[derive(Debug)]
pub struct Mapper<'a> {
    field: &'a HeightField,
    options: &'a MapOptions,
    engine: GridLos<'a>,
    /// The same, for many UAVs of which each has a thread of its own.
    alone: GridLos<'a>,
    why: &'static str,
    /// Receivers on the ground, on roofs, or both.
    receivers: Vec<GridReceivers<'a>>,
    /// World x of the columns of cells, whole words of them \[CRS units\].
    xs: Vec<f64>,
    /// The scene with other roofs, where stability is asked for.
    roofs: Option<Box<ShiftedRoofs>>,
}

impl<'a> Mapper<'a> {
    /// Makes ready what does not depend on the UAV.
    ///
    /// # Errors
    /// E118 if the options ask for an engine that cannot decide this scene, or for layers of heights beside an approximate
    /// one.
    pub fn new(field: &'a HeightField, options: &'a MapOptions) -> Result<Self> {
        let (method, why) = Method::choose(field, options.method).map_err(|wrong| {
            Error::usage(118, format!("the method that was asked for cannot decide this scene: {}", wrong.why))
                .with_hint(format!("`--method auto` takes `{}` here; `ray` decides any scene", wrong.instead.name()))
        })?;
        if !method.is_exact() && options.layers != HeightLayers::default() {
            let text =
                format!("layers of heights with `{method}`, which is approximate: they are exact, and would not agree");
            return Err(Error::usage(118, text).with_hint("`--method auto`, or `--layers los` alone"));
        }
        let cells = field.cells();
        let within = |cells: &BitGrid| match &options.within {
            Some(within) => cells.clone().and(within),
            None => cells.clone(),
        };
        let ground = || GridReceivers::new(within(&cells.open), field.ground_of_cells(), options.rx_height);
        let roof = || GridReceivers::new(within(&cells.building), field.roof_of_cells(), options.rx_height);
        let receivers = match options.receivers {
            Receivers::Ground => vec![ground()],
            Receivers::Roof => vec![roof()],
            Receivers::All => vec![ground(), roof()],
        };
        let n_cols = field.grid().n_cols();
        let mut xs: Vec<f64> = (0..n_cols).map(|col| field.grid().world_from_cell(0, col).0).collect();
        xs.resize(n_cols.div_ceil(64) * 64, 0.0);
        let engine = GridLos::new(field, method);
        let alone = engine.clone().in_one_band();
        let roofs = options.layers.stability.then(|| Box::new(ShiftedRoofs::of(field)));
        Ok(Mapper { field, options, engine, alone, why, receivers, xs, roofs })
    }

    /// The engine that decides, and why it was chosen.
    pub fn method(&self) -> (Method, &'static str) {
        (self.engine.method(), self.why)
    }

    /// The cells that hold receivers, in range or not.
    pub fn receiver_cells(&self) -> BitGrid {
        let grid = self.field.grid();
        let none = BitGrid::new(grid.n_rows(), grid.n_cols());
        self.receivers.iter().fold(none, |all, receivers| all.or(&receivers.cells))
    }

    /// The engine, shared by all threads.
    pub(super) fn engine(&self) -> &GridLos<'a> {
        &self.engine
    }

    /// Range \[CRS units\], if it is limited.
    pub(super) fn radius(&self) -> Option<f64> {
        self.options.radius
    }

    /// Casts the shadows of these alone.
    pub(super) fn cast_only(&mut self, casters: Casters) {
        let casters = Arc::new(casters);
        self.engine = self.engine.clone().with_casters(Arc::clone(&casters));
        self.alone = self.alone.clone().with_casters(casters);
    }

    /// Number of cells of the grid.
    pub(super) fn n_cells(&self) -> usize {
        self.field.grid().n_cells()
    }

    /// Number of columns of the grid.
    pub(super) fn n_cols(&self) -> usize {
        self.field.grid().n_cols()
    }

    /// The scene.
    pub(super) fn field(&self) -> &'a HeightField {
        self.field
    }

    /// Receivers on the ground, on roofs, or both.
    pub(super) fn receivers(&self) -> &[GridReceivers<'a>] {
        &self.receivers
    }

    /// Positions of the receivers.
    pub(super) fn positions(&self) -> &GridPositions {
        self.engine.positions()
    }

    /// How many receivers a UAV has in range, and how many of them are in line of sight: what [`Mapper::map`] counts,
    /// without a mask. For many UAVs at once: each is the work of one thread.
    pub fn count(&self, uav: &Uav) -> (u64, u64) {
        let range = Range::of(self.field.grid(), &uav.station.place, self.options.radius);
        self.receivers.iter().fold((0, 0), |sum, receivers| {
            let (wanted, los) = self.decide(&self.alone, uav, (receivers, &range));
            (sum.0 + wanted.as_ref().unwrap_or(&receivers.cells).count(), sum.1 + los.count())
        })
    }

    /// The receivers that a UAV has in range, and those of them in line of sight, as sets of cells.
    pub fn seen(&self, uav: &Uav) -> Seen {
        let grid = self.field.grid();
        let range = Range::of(grid, &uav.station.place, self.options.radius);
        let none = || BitGrid::new(grid.n_rows(), grid.n_cols());
        self.receivers.iter().fold(Seen { receivers: none(), los: none() }, |sum, receivers| {
            let (wanted, los) = self.decide(&self.alone, uav, (receivers, &range));
            let wanted = wanted.as_ref().unwrap_or(&receivers.cells);
            Seen { receivers: sum.receivers.or(wanted), los: sum.los.or(&los) }
        })
    }

    /// The cells that hold receivers in range of a UAV.
    pub fn receivers_in_range(&self, uav: &Uav) -> BitGrid {
        Range::of(self.field.grid(), &uav.station.place, self.options.radius).cut(&self.receiver_cells())
    }

    /// Whether the receiver of a row and column is in line of sight, in range or not, by one exact ray; `None` without a
    /// receiver there.
    pub fn is_los(&self, uav: &Uav, (row, col): (usize, usize)) -> Option<bool> {
        let (receivers, _) = self.receivers_at((row, col)).next()?;
        let cell = row * self.field.grid().n_cols() + col;
        let receiver = Station { place: self.engine.positions().center(row, col), z: receivers.height(cell) };
        Some(link_los(self.field, &uav.station, &receiver))
    }

    /// The receivers in range, where not all are, and those in line of sight.
    fn decide(&self, engine: &GridLos<'_>, uav: &Uav, (receivers, range): (&GridReceivers<'_>, &Range)) -> Decided {
        let wanted = (!range.is_everywhere()).then(|| range.cut(&receivers.cells));
        let los = {
            let wanted = wanted.as_ref().unwrap_or(&receivers.cells);
            engine.los(&uav.station, receivers, wanted, range.window())
        };
        (wanted, los)
    }

    /// Maps what a UAV sees.
    ///
    /// Cost: that of the engine (see [`crate::los`]), plus a walk per receiver and solid for the layers of heights. Shared
    /// by all threads of the current pool.
    ///
    /// # Errors
    /// Only [`ErrorClass::Interrupted`], when `control.stop` was set.
    pub fn map(&self, uav: &Uav, control: &Control) -> Result<SiteCoverage> {
        self.map_in_parts(uav, control, None)
    }

    /// The same, calling `each_part` with one part of the mask after another, from the north, while others are made.
    pub(super) fn map_in_parts(
        &self,
        uav: &Uav,
        control: &Control,
        each_part: Option<EachPart<'_>>,
    ) -> Result<SiteCoverage> {
        let grid = self.field.grid();
        let (n_rows, n_cols) = (grid.n_rows(), grid.n_cols());
        let range = Range::of(grid, &uav.station.place, self.options.radius);
        let decided: Vec<Decided> = self
            .receivers
            .iter()
            .map(|receivers| {
                if control.stop.load(Ordering::Relaxed) {
                    return (None, BitGrid::new(n_rows, n_cols));
                }
                self.decide(&self.engine, uav, (receivers, &range))
            })
            .collect();

        let layers = self.options.layers;
        let layer = |wanted: bool| if wanted { vec![f32::NAN; grid.n_cells()] } else { Vec::new() };
        let mut mask = LargeVec::<u8>::zeroed(grid.n_cells());
        let mut margin = layer(layers.margin);
        let mut ceiling = layer(layers.ceiling);
        let mut least_height = layer(layers.least_height);
        let heights = CellHeights::new(self.field, uav, self.options);
        let rows = split(&mut mask, n_rows, n_cols)
            .zip(split(&mut margin, n_rows, n_cols))
            .zip(split(&mut ceiling, n_rows, n_cols))
            .zip(split(&mut least_height, n_rows, n_cols))
            .map(|(((mask, margin), ceiling), least_height)| Row { mask, margin, ceiling, least_height })
            .enumerate();
        let fill = |(row, out): (usize, &mut Row<'_>)| {
            let mut tally = Tally::default();
            if control.stop.load(Ordering::Relaxed) {
                return tally;
            }
            let mut sets = RowSets::new(self.field.cells(), row, range.cols(row));
            for (receivers, (wanted, los)) in self.receivers.iter().zip(&decided) {
                let wanted = wanted.as_ref().unwrap_or(&receivers.cells).row(row);
                sets.add(wanted, los.row(row));
                tally.add_receivers(&self.elevations(uav, receivers, row), wanted, los.row(row));
                if layers.has_heights() {
                    heights.fill(out, self.engine.positions(), receivers, row, (wanted, los.row(row)));
                }
            }
            tally.add_others(&sets, n_cols);
            write_classes(&sets, out.mask);
            control.done.fetch_add(n_cols as u64, Ordering::Relaxed);
            tally
        };
        let is_stopped = || control.stop.load(Ordering::Relaxed);
        let tally = match each_part {
            Some(each_part) => {
                // Rows enough for every thread, also of wide grids.
                let n_at_once = BAND_CELLS.div_ceil(n_cols).max(8 * rayon::current_num_threads());
                in_bands(rows, n_at_once, fill, &mut |cells| {
                    if !is_stopped() {
                        each_part(cells)
                    }
                })
            }
            None => in_bands(rows, n_rows, fill, &mut |_| {}),
        };
        if control.stop.load(Ordering::Relaxed) {
            return Err(interrupted());
        }
        let stability =
            self.roofs.as_ref().map(|roofs| self.stability((uav, &range), &decided, roofs, control)).transpose()?;
        let some = |wanted: bool, values: Vec<f32>| wanted.then_some(values);
        Ok(SiteCoverage {
            uav: uav.clone(),
            tally,
            mask,
            margin: some(layers.margin, margin),
            ceiling: some(layers.ceiling, ceiling),
            least_height: some(layers.least_height, least_height),
            stability,
        })
    }

    /// The receiver in range with the least margin, the first of equal ones among those of `first` and then row by row;
    /// `None` without any.
    ///
    /// Cost: a walk along each link; on the calling thread.
    pub fn worst_margin(&self, uav: &Uav, first: &[(usize, usize)]) -> Option<WorstReceiver> {
        let range = Range::of(self.field.grid(), &uav.station.place, self.options.radius);
        let all = self.receivers.iter().flat_map(|receivers| {
            let rows = 0..receivers.cells.n_rows();
            rows.flat_map(move |row| set_bits(receivers.cells.row(row)).map(move |col| (receivers, (row, col))))
        });
        let hard = first.iter().flat_map(|cell| self.receivers_at(*cell));
        let mut worst: Option<WorstReceiver> = None;
        for (receivers, cell) in hard.chain(all).filter(|(_, cell)| range.contains(*cell)) {
            let margin_m = self.margin_at(uav, receivers, cell);
            if worst.is_none_or(|w| margin_m < w.margin_m) {
                worst = Some(WorstReceiver { margin_m, cell });
            }
        }
        worst
    }

    /// The least margin of the receivers of some cells that are in range \[m\]; `None` if none is.
    pub fn least_margin_among(&self, uav: &Uav, cells: &[(usize, usize)]) -> Option<f32> {
        let range = Range::of(self.field.grid(), &uav.station.place, self.options.radius);
        let in_range = cells.iter().filter(|cell| range.contains(**cell)).flat_map(|cell| self.receivers_at(*cell));
        in_range.map(|(receivers, cell)| self.margin_at(uav, receivers, cell)).min_by(f32::total_cmp)
    }

    /// The receivers of a cell, on the ground or on the roof.
    fn receivers_at(&self, cell: (usize, usize)) -> impl Iterator<Item = (&GridReceivers<'a>, (usize, usize))> {
        self.receivers.iter().filter(move |r| r.cells.contains(cell.0, cell.1)).map(move |r| (r, cell))
    }

    fn margin_at(&self, uav: &Uav, receivers: &GridReceivers<'_>, (row, col): (usize, usize)) -> f32 {
        let cell = row * self.field.grid().n_cols() + col;
        let receiver = Station { place: self.engine.positions().center(row, col), z: receivers.height(cell) };
        ceiling_and_margin(self.field, uav, &receiver, receivers.base(cell)).1
    }

    fn elevations<'b>(&'b self, uav: &Uav, receivers: &'b GridReceivers<'b>, row: usize) -> RowElevations<'b> {
        let grid = self.field.grid();
        RowElevations {
            xs: &self.xs,
            n_cols: grid.n_cols(),
            uav: (uav.station.place.x, uav.station.place.y, uav.station.z),
            y: grid.world_from_cell(row, 0).1,
            meters_per_unit: self.options.meters_per_unit,
            receivers,
            first_cell: row * grid.n_cols(),
        }
    }
}

/// The error of work that was told to stop.
pub(crate) fn interrupted() -> Error {
    Error::new(ErrorClass::Interrupted, 130, "interrupted; nothing was written")
}

/// One row of every output; rows of layers that are not wanted are empty.
struct Row<'a> {
    mask: &'a mut [u8],
    margin: &'a mut [f32],
    ceiling: &'a mut [f32],
    least_height: &'a mut [f32],
}

/// What takes one part of a mask after another.
pub(super) type EachPart<'a> = &'a mut (dyn FnMut(&[u8]) + Send);

/// Cells of a band of rows that is handed over at once.
const BAND_CELLS: usize = 1 << 20;

/// Fills rows band by band, and hands each band over while the next one is filled; the sum of what `fill` counts.
fn in_bands<'a>(
    mut rows: impl Iterator<Item = (usize, Row<'a>)>,
    n_at_once: usize,
    fill: impl Fn((usize, &mut Row<'a>)) -> Tally + Sync,
    each_part: EachPart<'_>,
) -> Tally {
    let mut tally = Tally::default();
    let mut filled: Vec<(usize, Row<'a>)> = Vec::new();
    loop {
        let mut band: Vec<(usize, Row<'a>)> = rows.by_ref().take(n_at_once).collect();
        let (of_band, ()) = rayon::join(
            || {
                let rows = band.par_iter_mut().map(|(row, out)| fill((*row, out)));
                rows.reduce(Tally::default, |a, b| a.plus(&b))
            },
            || filled.iter().for_each(|(_, row)| each_part(row.mask)),
        );
        tally = tally.plus(&of_band);
        filled = band;
        if filled.is_empty() {
            return tally;
        }
    }
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

/// The layers of heights, cell by cell.
struct CellHeights<'a> {
    field: &'a HeightField,
    uav: &'a Uav,
    layers: HeightLayers,
    /// Lowest height that a UAV may have at its place \[1/1024 m\].
    surface_under_uav: i32,
}

impl<'a> CellHeights<'a> {
    fn new(field: &'a HeightField, uav: &'a Uav, options: &MapOptions) -> Self {
        CellHeights { field, uav, layers: options.layers, surface_under_uav: surface_under(field, &uav.station.place) }
    }

    /// Fills the layers of a row for some receivers, of which those in `los` are in line of sight.
    fn fill(
        &self,
        out: &mut Row<'_>,
        positions: &GridPositions,
        receivers: &GridReceivers<'_>,
        row: usize,
        (wanted, los): (&[u64], &[u64]),
    ) {
        let first = row * self.field.grid().n_cols();
        for col in set_bits(wanted) {
            let receiver = Station { place: positions.center(row, col), z: receivers.height(first + col) };
            let is_los = los[col / 64] >> (col % 64) & 1 == 1;
            if self.layers.margin || self.layers.ceiling {
                let base = receivers.base(first + col);
                let (ceiling, margin) = ceiling_and_margin(self.field, self.uav, &receiver, base);
                debug_assert_eq!(is_los, margin >= 0.0);
                if let Some(v) = out.ceiling.get_mut(col) {
                    *v = narrow(ceiling);
                }
                if let Some(v) = out.margin.get_mut(col) {
                    *v = margin;
                }
            }
            if let Some(v) = out.least_height.get_mut(col) {
                let (b, t) = link_least_heights(self.field, &self.uav.station, &receiver);
                let least = b.height_steps().max(t.height_steps()).max(floor_of(self.surface_under_uav));
                let least = least / f64::from(STEPS_PER_UNIT);
                *v = if least > MAX_HEIGHT_M { f32::INFINITY } else { narrow(least) };
            }
        }
    }
}

/// The ceiling of a receiver \[m above the datum\], not below what it stands on, and its margin \[m\], whose sign is exact.
pub(super) fn ceiling_and_margin(field: &HeightField, uav: &Uav, receiver: &Station, base: i32) -> (f64, f32) {
    let (b, t) = link_ceilings(field, &uav.station, receiver);
    let is_los = b.is_met_by(receiver.z) && t.is_met_by(receiver.z);
    let ceiling = b.height_steps().max(t.height_steps()).max(f64::from(base)) / f64::from(STEPS_PER_UNIT);
    #[expect(clippy::cast_precision_loss, reason = "heights are at most 2^27 steps")]
    let height = receiver.z as f64 / f64::from(STEPS_PER_UNIT);
    // The sign is decided exactly; rounding to f32 must not turn it.
    let margin = narrow(height - ceiling);
    (ceiling, if is_los { margin.max(0.0) + 0.0 } else { margin.min(-f32::MIN_POSITIVE) })
}

/// The receiver of a UAV with the least margin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstReceiver {
    /// Its margin \[m\], as the layer `margin` holds it; −∞ where no receiver height is enough.
    pub margin_m: f32,
    /// Its row and column.
    pub cell: (usize, usize),
}

/// The surface that a UAV at a place must not be below \[1/1024 m\]: the ground, or the roof or surface there; [`VOID`] if
/// none is known.
pub fn surface_under(field: &HeightField, place: &Place) -> i32 {
    field.ground_at(place).max(field.inside_prisms_below(place)).max(field.inside_columns_below(place))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_are_filled_and_handed_over_in_order_whatever_the_bands() {
        for n_rows in [0, 1, 2, 7, 64] {
            for n_at_once in [1, 2, 5, 63, 64, 65] {
                let mut mask = vec![0_u8; 3 * n_rows];
                let rows = mask.chunks_mut(3).map(|mask| Row {
                    mask,
                    margin: &mut [],
                    ceiling: &mut [],
                    least_height: &mut [],
                });
                let fill = |(row, out): (usize, &mut Row<'_>)| {
                    out.mask.fill(u8::try_from(row).expect("few rows") + 1);
                    Tally::of_mask(&[0])
                };
                let mut found = Vec::new();
                let tally = in_bands(rows.enumerate(), n_at_once, fill, &mut |part| found.extend_from_slice(part));
                let expected: Vec<u8> = (1..).flat_map(|row| [row; 3]).take(3 * n_rows).collect();
                assert_eq!((found, tally.receivers), (expected, n_rows as u64), "{n_rows} rows, {n_at_once} at once");
            }
        }
    }
}
