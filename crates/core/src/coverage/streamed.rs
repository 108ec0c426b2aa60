//! Maps of scenes that are read window by window: what [`super::Mapper`] says of the same scene in memory.

use std::ops::Range as Rows;
use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::cell_classes::{RowSets, write_classes};
use super::cell_heights::with_margin;
use super::curved::check_drop;
use super::elevation::RowElevations;
use super::range::{Heights, Range};
use super::row_bands::{Row, split};
use super::{Control, MapOptions, Receivers, SiteCoverage, Tally, Uav};
use crate::city::{Ground, Solids, WindowedBase, WindowedSolids, row_bands};
use crate::error::{Error, Fault, MapError, Result};
use crate::height_field::{Drops, GridPositions, HeightField, Station};
use crate::los::{
    ColumnsReader, GridReceivers, MethodChoice, StreamLimits, StreamedHeights, StreamedScene, streamed_sweep_los,
};
use crate::quantity::{MAX_EXTENT_UNITS, VOID};
use crate::raster::{BitGrid, CellWindow, GeoRef, set_bits};
use crate::simd::SimdLevel;

/// A scene that is read window by window, and options, made ready for any number of UAVs.
///
/// Memory is two bits for each cell and kind of receiver, and a strip of the scene; with layers of heights also 8 bytes for
/// each cell and kind, and 4 for each layer.
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

/// What receivers stand on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stand {
    Ground,
    Roof,
    /// Over all ground that is free at their height.
    Air,
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
    /// The least height over each cell of a receiver in line of sight \[1/1024 m\], if layers are asked for.
    least_heights: Option<Vec<f64>>,
}

/// A band of whole rows of a map that is being made.
struct Band<'b> {
    uav: &'b Uav,
    range: &'b Range<'b>,
    decided: &'b [Decided],
    /// What is in the band, and its first row.
    field: &'b HeightField,
    first_row: usize,
    /// The receivers in it, kind by kind.
    receivers: Vec<GridReceivers<'b>>,
    /// How much lower it is than over a flat earth.
    drops: Option<&'b Drops>,
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
    /// E118 if the options ask for another engine than `sweep`, or for layers other than margins and
    /// least receiver heights; E502 for more cells a side than a
    /// lattice has; those of the scene; and that of [`super::Mapper::map`] when `control.stop` was set.
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
        let stands: &[Stand] = match options.receivers {
            Receivers::Ground => &[Stand::Ground],
            Receivers::Roof => &[Stand::Roof],
            Receivers::All => &[Stand::Ground, Stand::Roof],
            Receivers::Air => &[Stand::Air],
        };
        let mut cells: Vec<BitGrid> = stands.iter().map(|_| BitGrid::new(grid.n_rows(), grid.n_cols())).collect();
        let mut ranges = vec![(i32::MAX, i32::MIN); stands.len()];
        let (mut max_top, mut lowest_known) = (VOID, None);
        for window in row_bands(grid) {
            control.check()?;
            let field = HeightField::build(&grid.part(window), scene.solids(window)?).field;
            max_top = max_top.max(field.max_top());
            lowest_known = lowest_known.into_iter().chain(field.lowest_known()).min();
            for ((stand, cells), range) in stands.iter().zip(&mut cells).zip(&mut ranges) {
                let receivers = receivers_of(&field, *stand, options);
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
        let receivers = receivers.collect();
        let mut xs: Vec<f64> = (0..grid.n_cols()).map(|col| grid.world_from_cell(0, col).0).collect();
        xs.resize(grid.n_cols().div_ceil(64) * 64, 0.0);
        let positions = GridPositions::on_cells(grid);
        Ok(StreamedMapper {
            scene,
            options,
            receivers,
            max_top,
            lowest_known,
            xs,
            positions,
            limits: StreamLimits::default(),
        })
    }

    /// Maps what a UAV sees, and hands the mask to `visit`, a few whole rows at a time from the north; the coverage that is
    /// returned holds the layers of heights, but no mask.
    ///
    /// # Errors
    /// Those of the scene and of `visit`, and that of [`super::Mapper::map`] when `control.stop` was set.
    pub fn map(
        &self,
        uav: &Uav,
        control: &Control,
        mut visit: impl FnMut(Rows<usize>, &[u8]) -> Result<()>,
    ) -> Result<SiteCoverage> {
        let grid = self.scene.grid();
        let n_cols = grid.n_cols();
        let is_flat = matches!(self.scene.base(), WindowedBase::Flat(_));
        let heights = Heights::of_all(self.receivers.iter().map(|receivers| {
            let (lowest, highest) = receivers.heights.range();
            Heights { lowest, highest, are_flat: is_flat && receivers.stand != Stand::Roof }
        }));
        let drops = self.drops(uav);
        if let Some(drops) = &drops {
            check_drop(drops.most_m(grid.window()), self.lowest_known)?;
        }
        let most = drops.as_ref().map_or(0, |drops| drops.most(grid.window()));
        let heights =
            Heights { lowest: heights.lowest - most, are_flat: heights.are_flat && drops.is_none(), ..heights };
        let range = Range::of(&self.positions, uav, self.options, heights);
        let decided: Vec<Decided> = self
            .receivers
            .iter()
            .map(|receivers| self.decide((uav, drops.as_ref()), receivers, &range, control))
            .collect::<Result<_>>()?;
        let layers = self.options.layers;
        let layer = |wanted: bool| if wanted { vec![f32::NAN; grid.n_cells()] } else { Vec::new() };
        let (mut margin, mut least_receiver_height) = (layer(layers.margin), layer(layers.least_receiver_height));
        let mut heights =
            split(&mut margin, grid.n_rows(), n_cols).zip(split(&mut least_receiver_height, grid.n_rows(), n_cols));
        let mut total = Tally::default();
        let mut mask = Vec::new();
        for window in row_bands(grid) {
            control.check()?;
            let field = self.band(window, drops.as_ref())?;
            let receivers = self.receivers.iter().map(|r| receivers_of(&field, r.stand, self.options)).collect();
            let (first_row, drops) = (window.row, drops.as_ref());
            let band = Band { uav, range: &range, decided: &decided, field: &field, first_row, receivers, drops };
            mask.resize(window.n_rows * n_cols, 0);
            let rows = mask.chunks_mut(n_cols).zip(heights.by_ref());
            let mut rows: Vec<Row<'_>> = rows
                .map(|(mask, (margin, least_receiver_height))| Row {
                    mask,
                    margin,
                    least_receiver_height,
                    least_height: &mut [],
                })
                .collect();
            let tallies = rows.par_iter_mut().enumerate().map(|(k, row)| self.fill(&band, k, row));
            total = total.plus(&tallies.reduce(Tally::default, |a, b| a.plus(&b)));
            drop(rows);
            visit(window.row..window.row + window.n_rows, &mask)?;
        }
        drop(heights);
        let some = |wanted: bool, values: Vec<f32>| wanted.then_some(values);
        Ok(SiteCoverage {
            margin: some(layers.margin, margin),
            least_receiver_height: some(layers.least_receiver_height, least_receiver_height),
            ..SiteCoverage::of_tally(uav, total)
        })
    }

    /// Fills row `k` of a band.
    fn fill(&self, band: &Band<'_>, k: usize, out: &mut Row<'_>) -> Tally {
        let grid = self.scene.grid();
        let (row, n_cols) = (band.first_row + k, grid.n_cols());
        let Station { place, z } = &band.uav.station;
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
                out.set_heights(col, (band.drops.map_or(least, |drops| drops.raised(least, (row, col))), margin));
            }
        }
        tally.add_others(&sets, n_cols);
        write_classes(&sets, out.mask);
        tally
    }

    /// The receivers of one kind that are in range.
    fn in_range(&self, receivers: &StreamedReceivers, range: &Range<'_>, drops: Option<&Drops>) -> Result<BitGrid> {
        let (lowest, highest) = receivers.heights.range();
        let heights = (lowest - drops.map_or(0, |drops| drops.most(self.scene.grid().window())), highest);
        let mut wanted = range.cut_between(&receivers.cells, heights);
        if heights.0 < heights.1 && range.limits_elevations() {
            // The heights of single receivers are in the scene alone.
            for window in row_bands(self.scene.grid()) {
                let field = self.band(window, drops)?;
                range.drop_beyond(&receivers_of(&field, receivers.stand, self.options), window.row, &mut wanted);
            }
        }
        Ok(wanted)
    }

    /// How much lower cells are, as a UAV sees them over a curved earth.
    fn drops(&self, uav: &Uav) -> Option<Drops> {
        let MapOptions { curvature, meters_per_unit, .. } = *self.options;
        Some(Drops::new(&self.positions, &uav.station.place, curvature?, meters_per_unit))
    }

    /// Some rows of the scene, as seen over a curved earth.
    fn band(&self, window: CellWindow, drops: Option<&Drops>) -> Result<HeightField> {
        let field = HeightField::build(&self.scene.grid().part(window), self.scene.solids(window)?).field;
        let bent = drops.and_then(|drops| {
            let of_band = drops.of_rows(window.row..window.row + window.n_rows);
            field.bent_raster(of_band)
        });
        Ok(bent.unwrap_or(field))
    }

    /// The grid of receivers.
    pub fn grid(&self) -> &GeoRef {
        self.scene.grid()
    }

    /// The receivers in range, those in line of sight, and the least heights over their cells.
    fn decide(
        &self,
        (uav, drops): (&Uav, Option<&Drops>),
        receivers: &StreamedReceivers,
        range: &Range<'_>,
        control: &Control,
    ) -> Result<Decided> {
        let layers = self.options.layers;
        let wanted = match range.is_everywhere() {
            true => None,
            false => Some(self.in_range(receivers, range, drops)?),
        };
        let flat = Columns(self.scene);
        let most = drops.map_or(0, |drops| i32::try_from(drops.most(range.window())).unwrap_or(i32::MAX));
        let (heights, of_one) = match (drops, receivers.heights) {
            (Some(_), StreamedHeights::Flat(z)) => {
                (StreamedHeights::Over { is_top: false, above: 0, range: (z.saturating_sub(most), z) }, Some(z))
            }
            (Some(_), StreamedHeights::Over { is_top, above, range: (low, high) }) => {
                (StreamedHeights::Over { is_top, above, range: (low.saturating_sub(most), high) }, None)
            }
            (None, heights) => (heights, None),
        };
        let curved = drops.map(|drops| CurvedColumns { flat: &flat, drops, base: of_one });
        let columns: &dyn ColumnsReader = curved.as_ref().map_or(&flat, |curved| curved);
        let scene = StreamedScene {
            columns,
            max_top: self.max_top,
            uav: uav.station.on_columns(),
            receivers: heights,
            wanted: wanted.as_ref().unwrap_or(&receivers.cells),
            window: range.window(),
            heights_from: layers.has_heights().then_some(i64::from(receivers.lowest_base) - i64::from(most)),
            limits: self.limits,
            level: SimdLevel::new(),
        };
        let swept = streamed_sweep_los(&scene, &|n_cells| {
            control.done.fetch_add(n_cells, Ordering::Relaxed);
            !control.stop.load(Ordering::Relaxed)
        })?;
        control.check()?;
        Ok(Decided { wanted, los: swept.los, least_heights: swept.least_heights })
    }
}

/// Columns as a UAV sees them over a curved earth.
struct CurvedColumns<'a> {
    flat: &'a dyn ColumnsReader,
    drops: &'a Drops,
    /// The one base of all receivers over a flat earth, if it is one \[1/1024 m above the datum\].
    base: Option<i32>,
}

impl ColumnsReader for CurvedColumns<'_> {
    fn shape(&self) -> (usize, usize) {
        self.flat.shape()
    }

    fn read_tops(&self, window: CellWindow, tops: &mut Vec<i32>) -> Result<()> {
        self.flat.read_tops(window, tops)?;
        self.drops.lower(tops, window);
        Ok(())
    }

    fn read_bases(&self, window: CellWindow, bases: &mut Vec<i32>) -> Result<()> {
        match self.base {
            Some(base) => {
                bases.clear();
                bases.resize(window.n_rows * window.n_cols, base);
            }
            None => self.flat.read_bases(window, bases)?,
        }
        self.drops.lower(bases, window);
        Ok(())
    }
}

/// The receivers of one kind in a part of the scene.
fn receivers_of<'f>(field: &'f HeightField, stand: Stand, options: &MapOptions) -> GridReceivers<'f> {
    match stand {
        Stand::Ground => GridReceivers::new(&field.cells().open, field.ground_of_cells(), options.rx_height),
        Stand::Roof => GridReceivers::new(&field.cells().building, field.roof_of_cells(), options.rx_height),
        Stand::Air => {
            let free = field.free_above_ground(options.rx_height);
            GridReceivers::new(free, field.ground_of_cells(), options.rx_height)
        }
    }
}

/// How high receivers are, given the lowest and the highest of what they stand on.
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
