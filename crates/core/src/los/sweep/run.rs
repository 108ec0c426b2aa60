//! The whole sweep: every quadrant, wedge by wedge, and the cells close to the UAV.

use std::borrow::Cow;

use fearless_simd::Level;
use rayon::prelude::*;

use super::super::{columns_least_receiver_height, columns_los};
use super::candidates::Candidates;
use super::columns_reader::{ColumnsReader, StreamedHeights, StreamedScene};
use super::frame::{Asked, CELL, Frame, Quadrant, as_i64, near_cells, parts};
use super::output::{Output, WedgeOutput};
use super::row_source::{FromReader, InMemory, RowBuffer, RowSource, Stand, Tiles};
use super::suspects::Suspects;
use super::undecided::Recall;
use super::wedge::{Passing, Wedge};
use crate::dispatch;
use crate::error::Result;
use crate::height_field::{Columns, SeenHeights, TileMaxima};
use crate::quantity::LatticePoint;
use crate::raster::{BitGrid, CellWindow};

/// The results of a sweep.
#[derive(Debug, Clone)]
pub struct Swept {
    /// The wanted cells in line of sight.
    pub los: BitGrid,
    /// The least height of a receiver over the center of each wanted cell that is in line of sight
    /// \[1/1024 m above the datum\], if requested. It is that of [`columns_least_receiver_height`]
    /// if that is above the requested start height; else any height not above the start.
    pub least_heights: Option<Vec<f64>>,
    /// The number of wanted cells that the bounds left undecided.
    pub undecided: u64,
}

/// Heights of the receivers at the cell centers of the columns.
#[derive(Debug, Clone, Copy)]
pub enum ReceiverHeights<'a> {
    /// All at one height \[1/1024 m above the datum\].
    Flat(i32),
    /// Above a base for each cell, row by row from the north-west \[1/1024 m\].
    Over {
        /// Base heights of the receivers.
        base: SeenHeights<'a>,
        /// Height of receivers above their base.
        above: i32,
        /// A lower bound of `base`.
        lowest: i32,
        /// An upper bound of `base`.
        highest: i32,
        /// The highest of `base` by tile, if that is not the tops; computed if not given.
        tiles: Option<&'a TileMaxima>,
    },
}

impl ReceiverHeights<'_> {
    /// Returns bounds on the lowest and the highest receiver.
    fn range(&self) -> (i64, i64) {
        match self {
            ReceiverHeights::Flat(z) => (i64::from(*z), i64::from(*z)),
            ReceiverHeights::Over { lowest, highest, above, .. } => {
                (i64::from(*lowest) + i64::from(*above), i64::from(*highest) + i64::from(*above))
            }
        }
    }
}

/// Decides which of the `wanted` receivers within `window` are in line of sight of `uav`: equal to
/// [`columns_los`] for each. With `heights_from`, also finds the least height in line of sight over
/// each. That height is valid if it is above `heights_from` \[1/1024 m above the datum\].
///
/// The grid `wanted` has the shape of the columns. Threads of the current pool share the work;
/// neither their number nor `level` changes the result.
pub fn sweep_los(
    columns: &Columns,
    uav: LatticePoint,
    receivers: ReceiverHeights<'_>,
    wanted: &BitGrid,
    window: CellWindow,
    heights_from: Option<i64>,
    level: Level,
) -> Swept {
    let shape = (columns.n_rows(), columns.n_cols());
    let Some(asked) = asked(shape, (uav, columns.max_top()), receivers.range(), window, heights_from) else {
        return Swept { los: wanted.clone(), least_heights: no_heights(wanted, heights_from), undecided: 0 };
    };
    let (stand, bases, own_tiles) = match receivers {
        ReceiverHeights::Flat(z) => (Stand::Flat(z), None, None),
        ReceiverHeights::Over { base, above, .. } if base.is(&columns.seen_tops()) => {
            (Stand::OnTops(above), None, None)
        }
        ReceiverHeights::Over { base, above, tiles, .. } => {
            let tiles = tiles.map_or_else(|| Cow::Owned(base.tiles()), Cow::Borrowed);
            (Stand::OnBases(above), Some(base), Some(tiles))
        }
    };
    let tiles = Some(Tiles { tops: columns.tiles(), bases: own_tiles.as_deref() });
    let source = InMemory { columns, bases, level };
    let output = Output::new(wanted, heights_from.is_some());
    let frames: Vec<Frame> = Quadrant::ALL.into_iter().filter_map(|quadrant| Frame::new(&asked, quadrant)).collect();
    let parts = parts(shape.0.max(shape.1));
    let frames = frames.iter().map(|frame| (frame, output.wanted_bins(frame)));
    let wedges: Vec<(&Frame, u32, i64)> =
        frames.flat_map(|(frame, bins)| (-parts..parts).map(move |part| (frame, bins, part))).collect();
    wedges.into_par_iter().for_each(|(frame, bins, part)| {
        let passing = Passing { frame, stand, tiles, with_heights: heights_from.is_some() };
        let out = WedgeOutput::new(&output, frame);
        let passed = if heights_from.is_some() {
            let Some(wedge) = Wedge::new((part, parts), bins, Candidates::new) else { return };
            pass_strips(&source, &passing, &mut [(wedge, out)], level, &|_| true)
        } else {
            let Some(wedge) = Wedge::new((part, parts), bins, |n_bins| Suspects::new(columns, n_bins)) else { return };
            pass_strips(&source, &passing, &mut [(wedge, out)], level, &|_| true)
        };
        passed.expect("rows in memory can be lent");
    });
    decide_near(&source, &asked, stand, &output).expect("rows in memory can be read");
    let (los, undecided, least_heights) = output.into_parts();
    Swept { los, least_heights, undecided }
}

/// Decides which of the wanted receivers are in line of sight, as [`sweep_los`] does for columns in
/// memory.
///
/// A quadrant is passed outward in strips of rows, each read once. The callback `passed` gets the
/// number of cells just passed, and returns whether to continue. After it has returned `false`, the
/// result is meaningless. Threads of the current pool share each strip.
///
/// # Errors
/// Errors of the reader.
pub fn streamed_sweep_los(scene: &StreamedScene<'_>, passed: &(dyn Fn(u64) -> bool + Sync)) -> Result<Swept> {
    let StreamedScene { columns, uav, receivers, wanted, window, limits, level, heights_from, .. } = *scene;
    let Some(asked) = asked(columns.shape(), (uav, scene.max_top), receivers.range(), window, heights_from) else {
        return Ok(Swept { los: wanted.clone(), least_heights: no_heights(wanted, heights_from), undecided: 0 });
    };
    let stand = match receivers {
        StreamedHeights::Flat(z) => Stand::Flat(z),
        StreamedHeights::Over { is_top: true, above, .. } => Stand::OnTops(above),
        StreamedHeights::Over { above, .. } => Stand::OnBases(above),
    };
    let source = FromReader { columns, receivers, strip: limits.lines.max(1), level };
    let output = Output::new(wanted, heights_from.is_some());
    for frame in Quadrant::ALL.into_iter().filter_map(|quadrant| Frame::new(&asked, quadrant)) {
        let passing = Passing { frame: &frame, stand, tiles: None, with_heights: heights_from.is_some() };
        let parts = parts(usize::try_from(frame.n_lateral).unwrap_or(0).max(frame.n_rows()));
        let bins = output.wanted_bins(&frame);
        let wedge = |part| Some((Wedge::new((part, parts), bins, Candidates::new)?, WedgeOutput::new(&output, &frame)));
        let mut wedges: Vec<_> = (-parts..parts).filter_map(wedge).collect();
        pass_strips(&source, &passing, &mut wedges, level, passed)?;
    }
    decide_near(columns, &asked, stand, &output)?;
    let (los, undecided, least_heights) = output.into_parts();
    Ok(Swept { los, least_heights, undecided })
}

/// Makes the request of a sweep. Returns `None` if no top is above both ends of any link, or above
/// the start height of least heights.
fn asked(
    shape: (usize, usize),
    (uav, max_top): (LatticePoint, i32),
    receivers: (i64, i64),
    window: CellWindow,
    heights_from: Option<i64>,
) -> Option<Asked> {
    let lowest = receivers.0.min(heights_from.unwrap_or(i64::MAX));
    // The height above which no row can change a result: that of the receivers, all of which are
    // hidden, or of the tops for least heights.
    let highest = if heights_from.is_some() { i64::from(max_top) } else { receivers.1 };
    (i64::from(max_top) > uav.z.min(lowest)).then_some(Asked {
        shape,
        uav,
        max_top,
        heights: (lowest, highest),
        window,
    })
}

/// Returns the least heights if nothing obstructs.
fn no_heights(wanted: &BitGrid, heights_from: Option<i64>) -> Option<Vec<f64>> {
    heights_from.map(|_| vec![f64::NEG_INFINITY; wanted.n_rows() * wanted.n_cols()])
}

/// Passes all rows of a quadrant with some of its wedges, strip by strip.
fn pass_strips<R: Recall>(
    source: &dyn RowSource,
    passing: &Passing<'_>,
    wedges: &mut [(Wedge<R>, WedgeOutput<'_, '_>)],
    level: Level,
    passed: &(dyn Fn(u64) -> bool + Sync),
) -> Result<()> {
    let frame = passing.frame;
    let mut buffer = RowBuffer::default();
    let mut row = 0;
    while row < frame.n_rows() && !wedges.iter().all(|(wedge, _)| wedge.is_done(passing)) {
        let strip = row..frame.end_of_strip(row, source.strip(frame));
        row = strip.end;
        let (near, far) = (frame.near(strip.start), frame.far(strip.end - 1));
        let reaches = wedges.iter().map(|(wedge, _)| wedge.reach(passing, near, far)).filter(|(low, high)| low < high);
        // Empty if the bins pass beside the raster.
        let (low, high) = reaches.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap_or((0, 0));
        let lateral = usize::try_from(low).unwrap_or(0)..usize::try_from(high).unwrap_or(0);
        let n_cells = strip.len() * lateral.len();
        let rows = source.rows(frame, strip, lateral, &mut buffer)?;
        wedges.par_iter_mut().for_each(|(wedge, out)| {
            dispatch!(level, simd => wedge.pass(simd, passing, &rows, out));
        });
        if !passed(n_cells as u64) {
            return Ok(());
        }
    }
    wedges.iter_mut().for_each(|(_, out)| out.flush());
    Ok(())
}

/// Decides by `ray` the cells around the UAV that no wedge decides.
fn decide_near(reader: &dyn ColumnsReader, asked: &Asked, stand: Stand, output: &Output<'_>) -> Result<()> {
    let (rows, cols) = near_cells(asked);
    if rows.is_empty() || cols.is_empty() {
        return Ok(());
    }
    let window = CellWindow { row: rows.start, col: cols.start, n_rows: rows.len(), n_cols: cols.len() };
    let (mut tops, mut bases) = (Vec::new(), Vec::new());
    reader.read_tops(window, &mut tops)?;
    if let Stand::OnBases(_) = stand {
        reader.read_bases(window, &mut bases)?;
    }
    let columns = Columns::new(rows.len(), cols.len(), tops);
    let origin = (as_i64(cols.start) * CELL, as_i64(asked.shape.0 - rows.end) * CELL);
    let uav = LatticePoint { x: asked.uav.x - origin.0, y: asked.uav.y - origin.1, z: asked.uav.z };
    for row in rows.clone() {
        for col in cols.clone().filter(|col| output.wanted.contains(row, *col)) {
            let (near_row, near_col) = (row - rows.start, col - cols.start);
            let cell = near_row * cols.len() + near_col;
            let z = match stand {
                Stand::Flat(z) => i64::from(z),
                Stand::OnTops(above) => i64::from(columns.tops()[cell]) + i64::from(above),
                Stand::OnBases(above) => i64::from(bases[cell]) + i64::from(above),
            };
            let (x, y) = columns.center(near_row, near_col);
            let receiver = LatticePoint { x, y, z };
            if columns_los(&columns, uav, receiver) {
                output.add(row, col);
            }
            if output.heights.is_some() {
                let least = columns_least_receiver_height(&columns, uav, receiver);
                output.set_height(row, col, least.height_steps());
            }
        }
    }
    Ok(())
}
