//! Maps of scenes that are read window by window: what [`super::Mapper`] says of the same scene in memory.

use std::ops::Range as Rows;
use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::cell_classes::{RowSets, write_classes};
use super::elevation::RowElevations;
use super::range::Range;
use super::{Control, HeightLayers, MapOptions, Receivers, SiteCoverage, Tally, Uav};
use crate::city::{Ground, Solids, WindowedBase, WindowedSolids, row_bands};
use crate::error::{Error, Fault, MapError, Result};
use crate::height_field::{GridPositions, HeightField};
use crate::los::{
    ColumnsReader, GridReceivers, MethodChoice, StreamLimits, StreamedHeights, StreamedScene, streamed_sweep_los,
};
use crate::quantity::{MAX_EXTENT_UNITS, VOID};
use crate::raster::{BitGrid, CellWindow, GeoRef};
use crate::simd::SimdLevel;

/// A scene that is read window by window, and options, made ready for any number of UAVs.
///
/// Memory is two bits for each cell and kind of receiver, and a strip of the scene.
#[derive(Debug)]
pub struct StreamedMapper<'a, S> {
    scene: &'a S,
    options: &'a MapOptions,
    receivers: Vec<StreamedReceivers>,
    max_top: i32,
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
}

/// Receivers of one kind.
#[derive(Debug)]
struct StreamedReceivers {
    stand: Stand,
    cells: BitGrid,
    heights: StreamedHeights,
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
    /// E118 if the options ask for another engine than `sweep`, or for more than the mask; E502 for more cells a side than a
    /// lattice has; those of the scene; and that of [`super::Mapper::map`] when `control.stop` was set.
    pub fn new(scene: &'a S, options: &'a MapOptions, control: &Control) -> Result<Self> {
        if !matches!(options.method, MethodChoice::Auto | MethodChoice::Sweep) {
            return Err(MapError::StreamedMethod.into());
        }
        if options.layers != HeightLayers::default() || options.within.is_some() {
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
        };
        let mut cells: Vec<BitGrid> = stands.iter().map(|_| BitGrid::new(grid.n_rows(), grid.n_cols())).collect();
        let mut ranges = vec![(i32::MAX, i32::MIN); stands.len()];
        let mut max_top = VOID;
        for window in row_bands(grid) {
            control.check()?;
            let field = HeightField::build(&grid.part(window), scene.solids(window)?).field;
            max_top = max_top.max(field.max_top());
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
        });
        let receivers = receivers.collect();
        let mut xs: Vec<f64> = (0..grid.n_cols()).map(|col| grid.world_from_cell(0, col).0).collect();
        xs.resize(grid.n_cols().div_ceil(64) * 64, 0.0);
        let positions = GridPositions::on_cells(grid);
        Ok(StreamedMapper { scene, options, receivers, max_top, xs, positions, limits: StreamLimits::default() })
    }

    /// Maps what a UAV sees, and hands the mask to `visit`, a few whole rows at a time from the north; the coverage that is
    /// returned holds none.
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
        let range = Range::of(&self.positions, &uav.station.place, self.options.radius);
        let decided: Vec<(Option<BitGrid>, BitGrid)> = self
            .receivers
            .iter()
            .map(|receivers| self.decide(uav, receivers, &range, control))
            .collect::<Result<_>>()?;
        let mut total = Tally::default();
        let mut mask = Vec::new();
        for window in row_bands(grid) {
            control.check()?;
            let field = HeightField::build(&grid.part(window), self.scene.solids(window)?).field;
            let in_band: Vec<GridReceivers<'_>> =
                self.receivers.iter().map(|r| receivers_of(&field, r.stand, self.options)).collect();
            mask.resize(window.n_rows * n_cols, 0);
            let tally = mask
                .par_chunks_mut(n_cols)
                .enumerate()
                .map(|(k, mask)| {
                    let row = window.row + k;
                    let mut tally = Tally::default();
                    let mut sets = RowSets::new(field.cells(), k, range.cols(row));
                    for ((receivers, (wanted, los)), here) in self.receivers.iter().zip(&decided).zip(&in_band) {
                        let wanted = wanted.as_ref().unwrap_or(&receivers.cells).row(row);
                        sets.add(wanted, los.row(row));
                        let elevations = RowElevations {
                            xs: &self.xs,
                            n_cols,
                            uav: (uav.station.place.x, uav.station.place.y, uav.station.z),
                            y: grid.world_from_cell(row, 0).1,
                            meters_per_unit: self.options.meters_per_unit,
                            receivers: here,
                            first_cell: k * n_cols,
                        };
                        tally.add_receivers(&elevations, wanted, los.row(row));
                    }
                    tally.add_others(&sets, n_cols);
                    write_classes(&sets, mask);
                    tally
                })
                .reduce(Tally::default, |a, b| a.plus(&b));
            total = total.plus(&tally);
            visit(window.row..window.row + window.n_rows, &mask)?;
        }
        Ok(SiteCoverage::of_tally(uav, total))
    }

    /// The grid of receivers.
    pub fn grid(&self) -> &GeoRef {
        self.scene.grid()
    }

    /// The receivers in range, where not all are, and those in line of sight.
    fn decide(
        &self,
        uav: &Uav,
        receivers: &StreamedReceivers,
        range: &Range,
        control: &Control,
    ) -> Result<(Option<BitGrid>, BitGrid)> {
        let wanted = (!range.is_everywhere()).then(|| range.cut(&receivers.cells));
        let scene = StreamedScene {
            columns: &Columns(self.scene),
            max_top: self.max_top,
            uav: uav.station.on_columns(),
            receivers: receivers.heights,
            wanted: wanted.as_ref().unwrap_or(&receivers.cells),
            window: range.window(),
            heights_from: None,
            limits: self.limits,
            level: SimdLevel::new(),
        };
        let swept = streamed_sweep_los(&scene, &|n_cells| {
            control.done.fetch_add(n_cells, Ordering::Relaxed);
            !control.stop.load(Ordering::Relaxed)
        })?;
        control.check()?;
        Ok((wanted, swept.los))
    }
}

/// The receivers of one kind in a part of the scene.
fn receivers_of<'f>(field: &'f HeightField, stand: Stand, options: &MapOptions) -> GridReceivers<'f> {
    match stand {
        Stand::Ground => GridReceivers::new(&field.cells().open, field.ground_of_cells(), options.rx_height),
        Stand::Roof => GridReceivers::new(&field.cells().building, field.roof_of_cells(), options.rx_height),
    }
}

/// How high receivers are, given the lowest and the highest of what they stand on.
fn heights_of(stand: Stand, base: WindowedBase, (low, high): (i32, i32), above: i32) -> StreamedHeights {
    match (stand, base) {
        (Stand::Ground, WindowedBase::Flat(z)) => StreamedHeights::Flat(z + above),
        _ if low > high => StreamedHeights::Flat(above),
        _ if low == high => StreamedHeights::Flat(low + above),
        (Stand::Ground, WindowedBase::Terrain) => StreamedHeights::Over { is_top: false, above, range: (low, high) },
        _ => StreamedHeights::Over { is_top: true, above, range: (low, high) },
    }
}
