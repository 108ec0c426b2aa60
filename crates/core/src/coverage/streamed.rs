//! Maps of scenes that are read window by window: the same as [`super::Mapper`] makes of scenes in
//! memory.

use std::ops::Range as Rows;
use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::cell_classes::{RowSets, write_classes};
use super::cell_heights::with_margin;
use super::elevation::{RowElevations, padded_xs};
use super::options::Stand;
use super::output_rows::{HeightRows, Row, summed};
use super::range::{Heights, Range};
use super::view::WindowedView;
use super::{Control, MapOptions, SiteCoverage, Tally, Uav};
use crate::city::{Ground, Solids, WindowedBase, WindowedSolids, strips};
use crate::error::{Error, Fault, MapError, Result};
use crate::height_field::{GridPositions, HeightField, Station};
use crate::los::{
    ColumnsReader, GridReceivers, MethodChoice, StreamLimits, StreamedHeights, StreamedScene, streamed_sweep_los,
};
use crate::quantity::{MAX_EXTENT_UNITS, VOID};
use crate::raster::{BitGrid, CellWindow, GeoRef, set_bits};
use crate::simd::SimdLevel;

/// Scene that is read window by window, and options, made ready for any number of UAVs.
///
/// Memory is two bits for each cell and kind of receiver, and a strip of the scene. Layers of
/// heights take 8 bytes more for each cell and kind, and 4 for each layer.
#[derive(Debug)]
pub struct StreamedMapper<'a, S> {
    scene: &'a S,
    options: &'a MapOptions,
    receivers: Vec<StreamedReceivers>,
    max_top: i32,
    /// The lowest known top, if there is any.
    lowest_known: Option<i32>,
    /// World x of the columns of cells, whole words of them \[CRS units\].
    xs: Vec<f64>,
    positions: GridPositions,
    /// Limits to what is held in memory: no result depends on them.
    pub limits: StreamLimits,
}

/// Receivers of one kind.
#[derive(Debug)]
struct StreamedReceivers {
    stand: Stand,
    cells: BitGrid,
    heights: StreamedHeights,
    /// The lowest of what they stand on \[1/1024 m above the datum\].
    lowest_base: i32,
}

/// Receivers of one kind that a UAV has in range.
struct Decided {
    /// `None` if all are in range.
    wanted: Option<BitGrid>,
    los: BitGrid,
    /// Least height over each cell of a receiver in line of sight \[1/1024 m\], if layers are asked
    /// for.
    least_heights: Option<Vec<f64>>,
}

/// Band of whole rows of a map that is being made.
struct Band<'b> {
    view: &'b WindowedView<'b>,
    range: &'b Range<'b>,
    decided: &'b [Decided],
    /// The scene in the band, and its first row.
    field: &'b HeightField,
    first_row: usize,
    /// The receivers in it, kind by kind.
    receivers: Vec<GridReceivers<'b>>,
}

/// The windows of a scene as the sweep reads them.
struct Columns<'a, S>(&'a S);

impl<S: WindowedSolids> Columns<'_, S> {
    fn parts(&self, window: CellWindow) -> Result<(Vec<i32>, Option<Vec<i32>>)> {
        match self.0.solids(window)? {
            Solids::Raster { surface, ground: Ground::Terrain(terrain), .. } => {
                Ok((surface.into_cells().into_vec(), Some(terrain.into_cells().into_vec())))
            }
            Solids::Raster { surface, .. } => Ok((surface.into_cells().into_vec(), None)),
            Solids::Vector { .. } => Err(Error::Fault(Fault::NoRaster)),
        }
    }
}

impl<S: WindowedSolids> ColumnsReader for Columns<'_, S> {
    fn shape(&self) -> (usize, usize) {
        (self.0.grid().n_rows(), self.0.grid().n_cols())
    }

    fn read_tops(&self, window: CellWindow, tops: &mut Vec<i32>) -> Result<()> {
        *tops = self.parts(window)?.0;
        Ok(())
    }

    fn read_bases(&self, window: CellWindow, bases: &mut Vec<i32>) -> Result<()> {
        *bases = self.parts(window)?.1.unwrap_or_default();
        Ok(())
    }
}

impl<'a, S: WindowedSolids> StreamedMapper<'a, S> {
    /// Makes ready what does not depend on the UAV: reads the scene once.
    ///
    /// # Errors
    /// E118 if the options ask for another engine than `sweep`, or for layers other than margins
    /// and least receiver heights; E502 for more cells a side than a lattice has; those of the
    /// scene; and that of [`super::View::map`] when `control.stop` was set.
    pub fn new(scene: &'a S, options: &'a MapOptions, control: &Control) -> Result<Self> {
        if !matches!(options.method, MethodChoice::Auto | MethodChoice::Sweep) {
            return Err(MapError::StreamedMethod.into());
        }
        if options.layers.need_all_in_memory() || options.within.is_some() {
            return Err(MapError::StreamedLayers.into());
        }
        let grid = scene.grid();
        if grid.n_rows().max(grid.n_cols()) as f64 > MAX_EXTENT_UNITS {
            return Err(MapError::StreamedCells { n_cols: grid.n_cols(), n_rows: grid.n_rows() }.into());
        }
        let stands = options.receivers.stands();
        let mut cells: Vec<BitGrid> = stands.iter().map(|_| BitGrid::new(grid.n_rows(), grid.n_cols())).collect();
        let mut ranges = vec![(i32::MAX, i32::MIN); stands.len()];
        let (mut max_top, mut lowest_known) = (VOID, None);
        for window in strips(grid) {
            control.check()?;
            let field = HeightField::build(&grid.part(window), scene.solids(window)?).field;
            max_top = max_top.max(field.max_top());
            lowest_known = lowest_known.into_iter().chain(field.lowest_known()).min();
            for ((stand, cells), range) in stands.iter().zip(&mut cells).zip(&mut ranges) {
                let receivers = receivers_of(&field, *stand, options.rx_height);
                let per_row = cells.words_per_row();
                let words = window.row * per_row..(window.row + window.n_rows) * per_row;
                cells.words_mut()[words].copy_from_slice(receivers.cells.words());
                if let (Some(_), ((low, high), _)) = (receivers.lowest(), receivers.range()) {
                    *range = (range.0.min(low), range.1.max(high));
                }
            }
        }
        let receivers = stands.iter().zip(cells).zip(ranges).map(|((stand, cells), range)| StreamedReceivers {
            stand: *stand,
            cells,
            heights: heights_of(*stand, scene.base(), range, options.rx_height),
            lowest_base: if range.0 > range.1 { 0 } else { range.0 },
        });
        let (receivers, xs, positions) = (receivers.collect(), padded_xs(grid), GridPositions::on_cells(grid));
        let limits = StreamLimits::default();
        Ok(StreamedMapper { scene, options, receivers, max_top, lowest_known, xs, positions, limits })
    }

    /// Maps what a UAV sees, and hands the mask to `visit`, a few whole rows at a time from the
    /// north. The coverage that is returned holds the layers of heights, but no mask.
    ///
    /// # Errors
    /// Errors of the scene and of `visit`, E118 for an earth so curved that heights would leave the
    /// lattice, and that of [`super::View::map`] when `control.stop` was set.
    pub fn map(
        &self,
        uav: &Uav,
        control: &Control,
        mut visit: impl FnMut(Rows<usize>, &[u8]) -> Result<()>,
    ) -> Result<SiteCoverage> {
        let grid = self.scene.grid();
        let earth = (self.options.curvature, self.options.meters_per_unit);
        let view = WindowedView::of(uav, &self.positions, earth, self.lowest_known)?;
        let is_flat = !view.is_curved() && matches!(self.scene.base(), WindowedBase::Flat(_));
        let most = view.most_drop(grid.window());
        let heights = Heights::of_all(self.receivers.iter().map(|receivers| {
            let (lowest, highest) = receivers.heights.range();
            Heights { lowest: lowest - most, highest, are_flat: is_flat && receivers.stand != Stand::Roof }
        }));
        let range = Range::of(&self.positions, uav, self.options, heights);
        let decided = self.receivers.iter().map(|receivers| self.decide(&view, receivers, &range, control));
        let decided: Vec<Decided> = decided.collect::<Result<_>>()?;
        let mut heights = HeightRows::new(self.options.layers, grid.n_rows(), grid.n_cols());
        let mut total = Tally::default();
        let mut mask = Vec::new();
        for window in strips(grid) {
            control.check()?;
            let field = self.band(&view, window)?;
            let of_kind = |of: &StreamedReceivers| receivers_of(&field, of.stand, self.options.rx_height);
            let receivers = self.receivers.iter().map(of_kind).collect();
            let first_row = window.row;
            let band = Band { view: &view, range: &range, decided: &decided, field: &field, first_row, receivers };
            mask.resize(window.n_rows * grid.n_cols(), 0);
            let rows = window.row..window.row + window.n_rows;
            let mut out: Vec<Row<'_>> = heights.rows(rows.clone(), &mut mask).collect();
            total = total.plus(&summed(out.par_iter_mut().enumerate().map(|(k, row)| self.fill(&band, k, row))));
            drop(out);
            visit(rows, &mask)?;
        }
        let [margin, least_receiver_height, _] = heights.into_layers();
        Ok(SiteCoverage { margin, least_receiver_height, ..SiteCoverage::of_tally(uav, total) })
    }

    /// Fills row `k` of a band.
    fn fill(&self, band: &Band<'_>, k: usize, out: &mut Row<'_>) -> Tally {
        let grid = self.scene.grid();
        let (row, n_cols) = (band.first_row + k, grid.n_cols());
        let Station { place, z } = &band.view.uav().station;
        let mut tally = Tally::default();
        let mut sets = RowSets::new(band.field.cells(), k, (band.range, row));
        for ((receivers, decided), here) in self.receivers.iter().zip(band.decided).zip(&band.receivers) {
            let (wanted, los) = (decided.wanted.as_ref().unwrap_or(&receivers.cells).row(row), decided.los.row(row));
            sets.add(receivers.cells.row(row), wanted, los);
            let elevations = RowElevations {
                xs: &self.xs,
                n_cols,
                uav: (place.x, place.y, *z),
                y: grid.world_from_cell(row, 0).1,
                meters_per_unit: self.options.meters_per_unit,
                receivers: here,
                first_cell: k * n_cols,
            };
            tally.add_receivers(&elevations, wanted, los);
            let Some(heights) = &decided.least_heights else { continue };
            for col in set_bits(wanted) {
                let is_los = los[col / 64] >> (col % 64) & 1 == 1;
                let (cell, height) = (k * n_cols + col, heights[row * n_cols + col]);
                let (least, margin) = with_margin(height, here.height(cell), here.base(cell), is_los);
                out.set_heights(col, (band.view.raised(least, (row, col)), margin));
            }
        }
        tally.add_others(&sets, n_cols);
        write_classes(&sets, out.mask);
        tally
    }

    /// Returns the receivers of one kind that are in range.
    fn in_range(&self, view: &WindowedView<'_>, receivers: &StreamedReceivers, range: &Range<'_>) -> Result<BitGrid> {
        let (lowest, highest) = receivers.heights.range();
        let heights = (lowest - view.most_drop(self.scene.grid().window()), highest);
        let mut wanted = range.cut_between(&receivers.cells, heights);
        if heights.0 < heights.1 && range.limits_heights() {
            // The heights of single receivers are in the scene alone.
            for window in strips(self.scene.grid()) {
                let field = self.band(view, window)?;
                let receivers = receivers_of(&field, receivers.stand, self.options.rx_height);
                range.drop_beyond(&receivers, window.row, &mut wanted);
            }
        }
        Ok(wanted)
    }

    /// Reads some rows of the scene as a UAV sees them.
    fn band(&self, view: &WindowedView<'_>, window: CellWindow) -> Result<HeightField> {
        let field = HeightField::build(&self.scene.grid().part(window), self.scene.solids(window)?).field;
        Ok(view.rows(field, window.row..window.row + window.n_rows))
    }

    /// Returns the grid of receivers.
    pub fn grid(&self) -> &GeoRef {
        self.scene.grid()
    }

    /// Returns the receivers of one kind in range, those in line of sight, and least heights over
    /// their cells.
    fn decide(
        &self,
        view: &WindowedView<'_>,
        receivers: &StreamedReceivers,
        range: &Range<'_>,
        control: &Control,
    ) -> Result<Decided> {
        let wanted = match range.is_everywhere() {
            true => None,
            false => Some(self.in_range(view, receivers, range)?),
        };
        let flat = Columns(self.scene);
        let (columns, heights) = view.seen(&flat, receivers.heights, range.window());
        let lowest = i64::from(receivers.lowest_base) - view.most_drop(range.window());
        let scene = StreamedScene {
            columns: &columns,
            max_top: self.max_top,
            uav: view.uav().station.on_columns(),
            receivers: heights,
            wanted: wanted.as_ref().unwrap_or(&receivers.cells),
            window: range.window(),
            heights_from: self.options.layers.has_heights().then_some(lowest),
            limits: self.limits,
            level: SimdLevel::new(),
        };
        let swept = streamed_sweep_los(&scene, &|n_cells| {
            control.done.fetch_add(n_cells, Ordering::Relaxed);
            !control.is_stopped()
        })?;
        control.check()?;
        Ok(Decided { wanted, los: swept.los, least_heights: swept.least_heights })
    }
}

/// Returns the receivers of one kind in a part of the scene.
fn receivers_of(field: &HeightField, stand: Stand, rx_height: i32) -> GridReceivers<'_> {
    GridReceivers::new(stand.cells(field, rx_height), stand.heights(field), rx_height)
}

/// Returns the heights of receivers, given the lowest and the highest of what they stand on.
fn heights_of(stand: Stand, base: WindowedBase, (low, high): (i32, i32), above: i32) -> StreamedHeights {
    match (stand, base) {
        (Stand::Ground | Stand::Air, WindowedBase::Flat(z)) => StreamedHeights::Flat(z + above),
        _ if low > high => StreamedHeights::Flat(above),
        _ if low == high => StreamedHeights::Flat(low + above),
        (Stand::Ground | Stand::Air, WindowedBase::Terrain) => {
            StreamedHeights::Over { is_top: false, above, range: (low, high) }
        }
        _ => StreamedHeights::Over { is_top: true, above, range: (low, high) },
    }
}
