//! Maps of a scene with heights of buildings redrawn from their errors: how far P_LoS may be from
//! that of the known heights.
//!
//! Errors are drawn by the ids of buildings, so a building has the same ones in every part of a
//! scene and in any order. A raster does not tell buildings apart:
//!
//! * In a block model, blocks of one height that touch share an error.
//! * Elsewhere errors are a random field of some correlation length, with the same standard
//!   deviation everywhere. It has normal numbers at the nodes of a square grid of that length, and
//!   is bilinear between them.
//!
//! Nobody comes into range, or leaves it. A receiver on a roof moves with it, and on a surface
//! model alone each with its cell.

use std::borrow::Cow;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::drawn_links::DrawnErrors;
use crate::coverage::view::{Mapper, MovedRoofs, Threads, View};
use crate::coverage::{Control, Uav};
use crate::disjoint_sets::DisjointSets;
use crate::error::{MapError, Result};
use crate::height_field::HeightField;
use crate::los::{HeightErrors, OwnErrors};
use crate::quantity::STEPS_PER_UNIT;
use crate::raster::{BitGrid, set_bits};

/// Correlation length of errors of a raster that is no block model, where none is given \[m\].
pub const CORRELATION_M: f64 = 20.0;

/// The shortest correlation length \[m\]: shorter ones are those of single cells.
const SHORTEST_M: f64 = 0.1;

/// Words of random numbers that are set aside for one normal number, which seldom takes more than
/// one.
const WORDS: u128 = 16;

/// A scene with heights to be redrawn.
#[derive(Debug, Clone)]
pub struct RedrawnHeights {
    errors: HeightErrors,
    random: ChaCha8Rng,
    share: Share,
}

/// Parts of a scene that have an error of their own.
#[derive(Debug, Clone)]
enum Share {
    /// Each building of a scene of footprints: a number that follows from its id.
    Buildings(Vec<u64>),
    /// Blocks of cells of a raster.
    ///
    /// The number of each cell's block, from 1, 0 of cells that are no building; and a number that
    /// follows from where each block begins.
    Blocks(Vec<u32>, Vec<u64>),
    /// The nodes of a grid over a raster, so many cells apart from the corner of what it was cut
    /// from; and which cells are buildings.
    Nodes(NodeGrid, BitGrid),
}

/// Receivers in line of sight of some UAVs, once for each time that heights were drawn.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RedrawnCounts {
    /// Receivers of each UAV, in range by the known heights.
    pub receivers: Vec<u64>,
    /// Receivers in line of sight: of each draw, of each UAV.
    pub los: Vec<Vec<u64>>,
}

impl RedrawnHeights {
    /// Makes ready. `length_m` is the correlation length of a raster \[m\]. Without one, blocks
    /// share errors in a block model, and the length is [`CORRELATION_M`] elsewhere.
    ///
    /// `None` if there is not one error for each building that is a length, or the correlation
    /// length is below 0.1 m.
    pub fn of(field: &HeightField, errors: &HeightErrors, length_m: Option<f64>, seed: u64) -> Option<Self> {
        let length_of_cells_m = length_m.unwrap_or(CORRELATION_M);
        if !errors.are_valid(field.n_buildings()) || length_of_cells_m.is_nan() || length_of_cells_m < SHORTEST_M {
            return None;
        }
        let share = if field.prisms().is_some() {
            let n_buildings = u32::try_from(field.n_buildings()).ok()?;
            Share::Buildings((0..n_buildings).map(|building| stream_of(field.building_id(building))).collect())
        } else if matches!(errors.own, OwnErrors::ByBuilding(_)) {
            return None;
        } else if let Some((blocks, streams)) = length_m.is_none().then(|| block_model(field)).flatten() {
            Share::Blocks(blocks, streams)
        } else {
            let grid = field.grid();
            let cell = [grid.cell_width(), grid.cell_height()].map(|units| units * grid.meters_per_unit());
            let nodes = NodeGrid { spacing: cell.map(|cell| length_of_cells_m / cell), first: grid.first_of_whole() };
            Share::Nodes(nodes, field.cells_of_buildings().clone())
        };
        Some(RedrawnHeights { errors: errors.clone(), random: ChaCha8Rng::seed_from_u64(seed), share })
    }

    /// Returns the errors of heights in a draw \[1/1024 m\]: by the numbers of buildings, or by the
    /// cells of a raster.
    pub fn errors(&self, draw: u32) -> Vec<i32> {
        let mut random = self.random.clone();
        let mut normal = |stream: u64| -> f64 {
            random.set_stream(stream);
            random.set_word_pos(u128::from(draw) * WORDS);
            StandardNormal.sample(&mut random)
        };
        let shared = self.errors.shared_m * normal(0);
        let steps = |own: f64| {
            #[expect(clippy::cast_possible_truncation, reason = "saturates, and no roof is as high")]
            let steps = ((shared + own) * f64::from(STEPS_PER_UNIT)).round() as i32;
            steps
        };
        // Cells do not tell buildings apart.
        let of_cells_m = if let OwnErrors::Same(m) = self.errors.own { m } else { 0.0 };
        let mut own = |own_m: f64, stream: u64| if own_m > 0.0 { own_m * normal(stream) } else { 0.0 };
        match &self.share {
            Share::Buildings(streams) => {
                streams.iter().zip(0..).map(|(stream, k)| steps(own(self.errors.own_m(k), *stream))).collect()
            }
            Share::Blocks(blocks, streams) => {
                let errors: Vec<i32> = streams.iter().map(|stream| steps(own(of_cells_m, *stream))).collect();
                let error = |block: &u32| block.checked_sub(1).map_or(0, |block| errors[block as usize]);
                blocks.iter().map(error).collect()
            }
            Share::Nodes(nodes, buildings) => field_of(nodes, buildings, |node| own(of_cells_m, node), steps),
        }
    }

    /// Returns the scene with the errors of a draw, receivers on roofs of footprints moved with the
    /// building below each; `None` if a roof would leave ±32 768 m.
    fn redrawn(&self, field: &HeightField, draw: u32, buildings: Option<&[(usize, u32)]>) -> Option<MovedRoofs> {
        let errors = self.errors(draw);
        let Share::Buildings(_) = &self.share else { return MovedRoofs::by_cell(field, |cell| errors[cell]) };
        let moved = MovedRoofs::by_building(field, |building| errors[building as usize])?;
        let Some(buildings) = buildings else { return Some(moved) };
        let mut roofs = field.roofs_of_cells().to_vec();
        buildings.iter().for_each(|(cell, building)| roofs[*cell] += errors[*building as usize]);
        Some(moved.with_receivers_on(roofs))
    }
}

/// Returns the blocks of a raster, each of all building cells of one height that touch.
///
/// `None` of a surface that was measured, most of whose cells differ from their neighbors. For each
/// cell the number of its block, from 1. For each block a number that follows from where it begins
/// in the whole that the raster was cut from.
fn block_model(field: &HeightField) -> Option<(Vec<u32>, Vec<u64>)> {
    const CELLS_PER_BLOCK: u64 = 8;
    let (buildings, n_cols) = (field.cells_of_buildings(), field.grid().n_cols());
    let tops = field.roofs_of_cells();
    let mut sets = DisjointSets::new(tops.len());
    for (row, col) in buildings.cells() {
        let cell = row * n_cols + col;
        let west = (col > 0 && buildings.contains(row, col - 1)).then(|| cell - 1);
        let north = (row > 0 && buildings.contains(row - 1, col)).then(|| cell - n_cols);
        for near in west.into_iter().chain(north).filter(|near| tops[*near] == tops[cell]) {
            sets.join(cell, near);
        }
    }
    let (first_row, first_col) = field.grid().first_of_whole();
    let mut streams = Vec::new();
    let mut blocks = vec![0_u32; tops.len()];
    for (row, col) in buildings.cells() {
        let cell = row * n_cols + col;
        let first = sets.root(cell);
        if first == cell {
            // 0 is the stream of what all share.
            streams.push(((row + first_row) as u64) << 32 | (col + first_col + 1) as u64);
            blocks[cell] = u32::try_from(streams.len()).unwrap_or(u32::MAX);
        } else {
            blocks[cell] = blocks[first];
        }
    }
    (streams.len() as u64 * CELLS_PER_BLOCK <= buildings.count()).then_some((blocks, streams))
}

/// A grid of nodes over a raster.
#[derive(Debug, Clone)]
struct NodeGrid {
    /// Cells from node to node, across and down.
    spacing: [f64; 2],
    /// First row and column of the raster in the whole that it was cut from.
    first: (usize, usize),
}

/// Returns a random field over the cells of a raster: `node(stream)` is the error of a node of a
/// grid.
fn field_of(
    NodeGrid { spacing, first }: &NodeGrid,
    buildings: &BitGrid,
    mut node: impl FnMut(u64) -> f64,
    steps: impl Fn(f64) -> i32 + Sync,
) -> Vec<i32> {
    let (n_rows, n_cols) = (buildings.n_rows(), buildings.n_cols());
    // The node before the middle of a cell, and how far that is on the way to the next one.
    let along = |cells: std::ops::Range<usize>, spacing: f64| -> Vec<(usize, f64)> {
        #[expect(
            clippy::cast_precision_loss,
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "cells of a grid"
        )]
        let at = |cell: usize| {
            let at = (cell as f64 + 0.5) / spacing;
            (at.floor() as usize, at - at.floor())
        };
        cells.map(at).collect()
    };
    let (rows, cols) = (along(first.0..first.0 + n_rows, spacing[1]), along(first.1..first.1 + n_cols, spacing[0]));
    let from = |of: &[(usize, f64)]| of.first().map_or(0, |(node, _)| *node);
    let (north, west) = (from(&rows), from(&cols));
    let count = |of: &[(usize, f64)]| of.last().map_or(0, |(node, _)| node + 2 - from(of));
    let (nodes_down, nodes_across) = (count(&rows), count(&cols));
    // 0 is the stream of what all share.
    let nodes: Vec<f64> = (0..nodes_down * nodes_across)
        .map(|k| node(((north + k / nodes_across) as u64) << 32 | (west + k % nodes_across + 1) as u64))
        .collect();
    let mut errors = vec![0; n_rows * n_cols];
    errors.par_chunks_mut(n_cols.max(1)).enumerate().for_each(|(row, errors)| {
        let (down, v) = (rows[row].0 - north, rows[row].1);
        for col in set_bits(buildings.row(row)) {
            let (across, u) = (cols[col].0 - west, cols[col].1);
            let at = down * nodes_across + across;
            let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
            let of = [nodes[at], nodes[at + 1], nodes[at + nodes_across], nodes[at + nodes_across + 1]];
            let sum: f64 = weights.iter().zip(of).map(|(w, error)| w * error).sum();
            let squares: f64 = weights.iter().map(|w| w * w).sum();
            errors[col] = steps(sum / squares.sqrt());
        }
    });
    errors
}

/// Returns a number that follows from an id, never 0: FNV-1a.
fn stream_of(id: &str) -> u64 {
    let hash = id
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    hash.max(1)
}

impl RedrawnCounts {
    /// Returns the shares of receivers in line of sight of a UAV between which the middle `part` of
    /// all draws is; NaN without a receiver.
    ///
    /// The quantile p of n sorted numbers is at (n + 1) p. Of n draws and one more of the same
    /// kind, this one is within the interval with probability `part`.
    pub fn interval(&self, uav: usize, part: f64) -> (f64, f64) {
        interval_of(self.shares(uav).collect(), part)
    }

    /// Returns the numbers between which the share of a second UAV less that of a first one is in
    /// the middle `part` of all draws. Both share each draw; NaN where one has no receiver.
    pub fn interval_of_difference(&self, (first, second): (usize, usize), part: f64) -> (f64, f64) {
        interval_of(self.shares(first).zip(self.shares(second)).map(|(first, second)| second - first).collect(), part)
    }

    /// Returns the share of receivers of a UAV that it sees, draw by draw.
    #[expect(clippy::cast_precision_loss, reason = "counts are below 2^53")]
    fn shares(&self, uav: usize) -> impl Iterator<Item = f64> {
        self.los.iter().map(move |of| of[uav] as f64 / self.receivers[uav] as f64)
    }
}

/// Returns the middle part of some numbers.
fn interval_of(mut shares: Vec<f64>, part: f64) -> (f64, f64) {
    shares.sort_unstable_by(f64::total_cmp);
    #[expect(clippy::cast_precision_loss, reason = "counts are below 2^53")]
    let quantile = |p: f64| {
        let at = ((shares.len() + 1) as f64 * p - 1.0).clamp(0.0, (shares.len().max(1) - 1) as f64);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the draws")]
        let below = at.floor() as usize;
        match (shares.get(below), shares.get(below + 1)) {
            (Some(a), Some(b)) => a + (b - a) * (at - at.floor()),
            (Some(a), None) => *a,
            _ => f64::NAN,
        }
    };
    (quantile((1.0 - part) / 2.0), quantile(f64::midpoint(1.0, part)))
}

impl Mapper<'_> {
    /// Counts the receivers that each of some UAVs sees in each of `n` draws of the heights of the
    /// same scene, from the first draw on.
    ///
    /// Cost: for each draw the prisms sorted into buckets, or a copy of the raster, and the line of
    /// sight of a map for each UAV. Of flat footprints and receivers on the ground: two maps for
    /// each UAV, and a walk for each receiver whose answer is not the same in all draws. All
    /// threads of the current pool share the work.
    ///
    /// # Errors
    /// E118 if a roof would leave ±32 768 m, and those of [`Mapper::seen_from`].
    pub fn redrawn(&self, uavs: &[Uav], heights: &RedrawnHeights, n: u32, control: &Control) -> Result<RedrawnCounts> {
        let views = uavs.iter().map(|uav| self.seen_from(uav)).collect::<Result<Vec<View<'_>>>>()?;
        let in_range: Vec<Vec<Cow<'_, BitGrid>>> =
            views.iter().map(|view| view.receivers().map(|of_kind| of_kind.in_range()).collect()).collect();
        let receivers = in_range.iter().map(|kinds| kinds.iter().map(|cells| cells.count()).sum()).collect();
        let buildings = self.buildings_of_roofs();
        let is_of_buildings = matches!(heights.share, Share::Buildings(_)) && buildings.is_none();
        if is_of_buildings && DrawnErrors::can_hold(self.field(), n as usize) {
            let draws: Vec<Vec<i32>> = (0..n).into_par_iter().map(|draw| heights.errors(draw)).collect();
            let drawn = DrawnErrors::of(self.field(), &draws).ok_or(MapError::HeightErrors)?;
            let count = |(view, in_range): (&View<'_>, &Vec<Cow<'_, BitGrid>>)| {
                control.check()?;
                view.los_by_draw(&drawn, in_range, control)
            };
            let of_uavs = views.par_iter().zip(&in_range).map(count).collect::<Result<Vec<Vec<u64>>>>()?;
            let los = (0..n as usize).map(|draw| of_uavs.iter().map(|of| of[draw]).collect()).collect();
            return Ok(RedrawnCounts { receivers, los });
        }
        let of_draw = |draw: u32| {
            control.check()?;
            let moved = heights.redrawn(self.field(), draw, buildings.as_deref()).ok_or(MapError::HeightErrors)?;
            let count = |(view, in_range): (&View<'_>, &Vec<Cow<'_, BitGrid>>)| {
                let redrawn = view.with_roofs(&moved)?;
                let kinds = redrawn.receivers().zip(in_range);
                let los = kinds.map(|(of_kind, in_range)| of_kind.los(in_range, Threads::All));
                Ok(los.reduce(|all, of_kind| all.or(&of_kind)).map_or(0, |los| los.count()))
            };
            views.iter().zip(&in_range).map(count).collect()
        };
        let los = (0..n).into_par_iter().map(of_draw).collect::<Result<Vec<Vec<u64>>>>()?;
        Ok(RedrawnCounts { receivers, los })
    }

    /// Returns the building below each receiver on a roof of footprints, with its cell; `None`
    /// without such receivers.
    fn buildings_of_roofs(&self) -> Option<Vec<(usize, u32)>> {
        let kind = (0..self.receivers.len()).find(|kind| self.stands_on_roofs(*kind))?;
        let (positions, n_cols) = (self.positions(), self.field().grid().n_cols());
        let building = |(row, col): (usize, usize)| {
            Some((row * n_cols + col, self.field().building_at(&positions.center(row, col))?))
        };
        Some(self.receivers[kind].cells.cells().filter_map(building).collect())
    }
}
