//! Least heights past prisms: every caster raises the heights of the cells that it can hide, by its
//! demands ([`super::caster_heights`]).
//!
//! **Exactness.** E × q, K and their difference are integers below 2^53, which doubles hold. So
//! heights err by a few roundings of themselves. [`GridHeights`] finds the cells where these may
//! matter; there a walk along the link (`ray`) decides. Heights are unknown (NaN) in these cells:
//!
//! * the cell at the UAV,
//! * for heights of the UAV, cells close behind or below a sloped roof,
//! * cells on a side of a cone, or so near that rounding matters, if its height is above that of
//!   all sure casters.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};
use rayon::prelude::*;

use super::super::grid_heights::GridHeights;
use super::caster_heights::{Edges, OFTEN};
use super::geometry::{as_f64, distance_squared};
use super::horizon::sort_by_horizon;
use super::outline::Outline;
use super::plane::Plane;
use super::reach::{LANES, Reach};
use super::scene::{Receivers, ShadowScene, cells_at_uav};
use super::spans::{Lanes, as_column, doubtful, maybe_spans, spans};
use crate::dispatch;
use crate::height_field::{Caster, CasterBlock};
use crate::quantity::LatticePoint;

/// Bands of rows to a thread, so that no thread waits long for another.
const BANDS_PER_THREAD: usize = 4;

/// Half the range of integers that doubles hold: E × q and K are two products each, and their
/// difference is four.
const EXACT: i64 = 1 << 52;

/// The end of the links whose least heights are requested.
enum HeightsOf {
    /// Heights of receivers, as far as they are above `from` \[1/1024 m above the datum\].
    Receivers { from: i64 },
    /// Heights of the UAV over its place, as far as they are above `from`; the receivers are
    /// between the heights of `range`.
    Uav { from: i64, receivers: Receivers, range: (i64, i64) },
}

/// Returns the least height of a receiver over each wanted cell at which it is in line of sight of
/// `uav` past the prisms. It holds if it is above `from` \[1/1024 m above the datum\]. Up to
/// rounding it is equal to
/// [`prisms_least_receiver_height`](super::super::prisms_least_receiver_height).
///
/// Cost: the cells of all shadows, however often they overlap.
///
/// Returns `None` if the product of the width of the scene and the size of a block of casters is
/// above 2^51. Doubles may not hold E × q − K then.
pub fn shadow_least_receiver_heights(scene: &ShadowScene<'_>, uav: LatticePoint, from: i64) -> Option<GridHeights> {
    least_heights(scene, uav, &HeightsOf::Receivers { from })
}

/// Returns the least height of a UAV at `uav`'s position at which it sees the receiver of each
/// wanted cell past the prisms. It holds if it is above `from` \[1/1024 m above the datum\]. Up to
/// rounding it is equal to [`prisms_least_height`](super::super::prisms_least_height).
///
/// The function `height(row, col)` returns the receiver's height \[1/1024 m above the datum\]; the
/// UAV's own height plays no part.
///
/// Cost: the cells of the cones behind all casters. Returns `None` in the same cases as
/// [`shadow_least_receiver_heights`].
pub fn shadow_least_heights(
    scene: &ShadowScene<'_>,
    uav: LatticePoint,
    from: i64,
    height: &(impl Fn(usize, usize) -> i32 + Sync),
) -> Option<GridHeights> {
    let (relief, (lowest, highest)) = Receivers::relief(scene.wanted, height);
    let range = (i64::from(lowest), i64::from(highest));
    let receivers = if lowest == highest { Receivers::Level(range.0) } else { relief };
    least_heights(scene, uav, &HeightsOf::Uav { from, receivers, range })
}

fn least_heights(scene: &ShadowScene<'_>, uav: LatticePoint, heights_of: &HeightsOf) -> Option<GridHeights> {
    let n_cols = scene.wanted.n_cols();
    let per_row = n_cols.next_multiple_of(LANES);
    let largest = as_f64(uav.z.abs().max(heights_of.largest()));
    let Some(plane) = scene.plane(scene.wanted, uav) else {
        return Some(GridHeights::rounded(Vec::new(), per_row, 0, largest));
    };
    if !are_products_exact(scene, &plane) {
        return None;
    }
    let largest = largest + terms_of_slopes(scene, &plane, heights_of);
    let (first, end) = plane.rows;
    let mut heights = vec![f64::NEG_INFINITY; (end - first) * per_row];
    let east = (0..per_row).map(|col| as_f64(scene.grid.xs[col.min(n_cols - 1)] - uav.x)).collect();
    let at_uav = cells_at_uav(scene.grid, &plane, scene.wanted);
    let cast = Cast { scene, heights_of, is_cast: are_cast(scene, uav, heights_of), east, per_row, at_uav };
    let rows_per_band = (end - first).div_ceil(scene.n_bands * BANDS_PER_THREAD).next_multiple_of(LANES);
    heights.par_chunks_mut(rows_per_band * per_row).enumerate().for_each(|(k, heights)| {
        let first = first + k * rows_per_band;
        let mut plane = plane.clone();
        plane.narrow_to(scene.grid, (first, first + heights.len() / per_row), plane.cols);
        dispatch!(scene.level, simd => cast.band(simd, &plane, heights));
    });
    Some(GridHeights::rounded(heights, per_row, first, largest))
}

/// Returns for each caster whether it sets any height. For receivers, casters behind the horizon
/// set none.
fn are_cast(scene: &ShadowScene<'_>, uav: LatticePoint, heights_of: &HeightsOf) -> Vec<bool> {
    let casters = scene.casters.all();
    if let HeightsOf::Uav { .. } = heights_of {
        return vec![true; casters.len()];
    }
    let prisms = casters.iter().map(|caster| (scene.casters.ring(caster), scene.casters.range(caster)));
    let no_groups = std::iter::empty::<([[i32; 2]; 0], i64)>();
    let sorted = sort_by_horizon((uav, 0.0), i64::MAX, prisms, no_groups);
    sorted.prisms.iter().map(Option::is_some).collect()
}

/// Returns `true` if E × q and K are exact for all casters and cells.
fn are_products_exact(scene: &ShadowScene<'_>, plane: &Plane) -> bool {
    let (ux, uy) = (plane.uav.x, plane.uav.y);
    let (xs, ys) = (&scene.grid.xs, &scene.grid.ys);
    let ends = |ends: &[i64], at: i64| ends.first().into_iter().chain(ends.last()).map(|v| (v - at).abs()).max();
    let mut farthest = ends(xs, ux).max(ends(ys, uy)).unwrap_or(0);
    let mut longest = 0;
    for block in scene.casters.blocks() {
        let [w, s, e, n] = block.bounds.map(i64::from);
        farthest = farthest.max((w - ux).abs()).max((e - ux).abs()).max((s - uy).abs()).max((n - uy).abs());
        longest = longest.max(e - w).max(n - s);
    }
    // Corners of sloped roofs add products of distances.
    let longest = if scene.prisms.are_sloped() { longest.max(farthest) } else { longest };
    farthest * longest <= EXACT / 2
}

/// Returns an upper bound on the sum of the terms of heights over sloped roofs, beyond these
/// heights \[1/1024 m\].
///
/// A term is the height of a corner relative to the other end of the link, times the ratio of the
/// link's length to its part up to there. If that ratio is above [`OFTEN`], a height of the UAV is
/// not given.
fn terms_of_slopes(scene: &ShadowScene<'_>, plane: &Plane, heights_of: &HeightsOf) -> f64 {
    let casters = scene.casters;
    let of_caster = |caster: &Caster| {
        let (low, high) = casters.range(caster);
        match heights_of {
            HeightsOf::Receivers { .. } => {
                let below = (plane.uav.z - i64::from(low)).abs().max((plane.uav.z - i64::from(high)).abs());
                let distance = as_f64(distance_squared(caster.bounds, (plane.uav.x, plane.uav.y))).sqrt();
                2.0 * as_f64(below) * plane.farthest() / distance.max(1.0)
            }
            HeightsOf::Uav { range: (lowest, highest), .. } => {
                let most = (i64::from(high) - lowest).abs().max((i64::from(low) - highest).abs());
                2.0 * as_f64(most) * OFTEN
            }
        }
    };
    let sloped = casters.all().iter().filter(|caster| casters.heights(caster).is_some());
    sloped.map(of_caster).fold(0.0, f64::max)
}

impl HeightsOf {
    /// Returns the largest magnitude of the heights that the results are relative to.
    fn largest(&self) -> i64 {
        match self {
            HeightsOf::Receivers { .. } => 0,
            HeightsOf::Uav { range: (lowest, highest), .. } => lowest.abs().max(highest.abs()),
        }
    }
}

fn numbers_of(block: &CasterBlock) -> std::ops::Range<usize> {
    let numbers = block.numbers();
    numbers.start as usize..numbers.end as usize
}

/// Data that are the same for all casters.
struct Cast<'a> {
    scene: &'a ShadowScene<'a>,
    heights_of: &'a HeightsOf,
    /// By the number of a caster, `true` if it is cast.
    is_cast: Vec<bool>,
    /// East of the UAV, by column and up to a whole vector \[lattice steps\], exact.
    east: Vec<f64>,
    per_row: usize,
    at_uav: Vec<(usize, usize)>,
}

/// A cell that a caster may or may not hide, and its height if it does.
struct Doubt {
    cell: usize,
    height: f64,
}

impl Cast<'_> {
    /// Raises the heights of the rows of a plane past all casters.
    #[inline(always)]
    fn band<S: Simd>(&self, simd: S, plane: &Plane, heights: &mut [f64]) {
        let mut outline = Outline::default();
        let mut edges = Edges::default();
        let mut doubts = Vec::new();
        let casters = self.scene.casters;
        for block in casters.blocks().iter().filter(|block| plane.meets(block.bounds, self.reach(plane, block.max_top)))
        {
            for (caster, is_cast) in casters.of_block(block).iter().zip(&self.is_cast[numbers_of(block)]) {
                let Some(reach) = self.reach(plane, caster.top) else { break };
                if *is_cast && self.outline(plane, caster, reach, &mut outline) {
                    edges.of(plane, casters, caster);
                    self.raise(simd, plane, (&outline, &edges), heights, &mut doubts);
                }
            }
        }
        if let HeightsOf::Receivers { .. } = self.heights_of {
            let uav_z = as_f64(plane.uav.z);
            heights.iter_mut().for_each(|height| *height += uav_z);
            doubts.iter_mut().for_each(|doubt| doubt.height += uav_z);
        }
        for Doubt { cell, height } in doubts {
            if heights[cell] < height {
                heights[cell] = f64::NAN;
            }
        }
        for (row, col) in self.at_uav.iter().filter(|(row, _)| (plane.rows.0..plane.rows.1).contains(row)) {
            heights[(row - plane.rows.0) * self.per_row + col] = f64::NAN;
        }
    }

    /// Makes an outline of the cells whose heights a caster sets; returns `false` if it has no
    /// cell.
    #[inline(always)]
    fn outline(&self, plane: &Plane, caster: &Caster, reach: Reach, outline: &mut Outline) -> bool {
        let casters = self.scene.casters;
        match self.heights_of {
            HeightsOf::Receivers { from } => outline.cast_roof(plane, (casters, caster), reach, from - 1),
            HeightsOf::Uav { .. } => outline.cast(plane, casters.ring(caster), caster.bounds, reach),
        }
    }

    /// Returns the reach of a roof at `top` over which it sets requested heights; `None` if it sets
    /// none.
    #[inline(always)]
    fn reach(&self, plane: &Plane, top: i32) -> Option<Reach> {
        match self.heights_of {
            // A step lower than requested: where the shadow ends, doubts are below the heights that
            // matter.
            HeightsOf::Receivers { from } => Reach::new(plane.uav.z, top, from - 1),
            // A roof below all receivers demands no height above its own.
            HeightsOf::Uav { from, range: (lowest, _), .. } => {
                (i64::from(top) > *from.min(lowest)).then_some(Reach::ENDLESS)
            }
        }
    }

    /// Raises the heights at the cells of an outline to those of its caster.
    #[inline(always)]
    fn raise<S: Simd>(
        &self,
        simd: S,
        plane: &Plane,
        (outline, edges): (&Outline, &Edges),
        heights: &mut [f64],
        doubts: &mut Vec<Doubt>,
    ) {
        let rows = outline.rows(plane);
        for first in (rows.maybe.0..rows.maybe.1).step_by(LANES) {
            let n = (rows.maybe.1 - first).min(LANES);
            let spans = spans(simd, plane, outline, first);
            if !spans.is_all_sure || first < rows.sure.0 || first + n > rows.sure.1 {
                let maybe = maybe_spans(simd, plane, outline, first);
                self.doubt(simd, plane, edges, (&spans.sure, &maybe, rows.sure), (first, n), doubts);
            }
            for k in 0..n {
                let row = first + k;
                let (from, to) = (spans.sure.0[k], spans.sure.1[k]);
                if from >= to || row < rows.sure.0 || row >= rows.sure.1 {
                    continue;
                }
                let of_row = &mut heights[(row - plane.rows.0) * self.per_row..][..self.per_row];
                let (from, to) = (as_column(from), as_column(to));
                for col in (from / LANES * LANES..to).step_by(LANES) {
                    let mut height = self.heights(simd, plane, edges, (row, col));
                    if col < from || col + LANES > to {
                        let lane = f64x8::from_slice(simd, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
                        let col = f64x8::splat(simd, as_f64(col)) + lane;
                        let is_in =
                            col.simd_ge(f64x8::splat(simd, as_f64(from))) & col.simd_lt(f64x8::splat(simd, as_f64(to)));
                        height = is_in.select(height, f64x8::splat(simd, f64::NEG_INFINITY));
                    }
                    if edges.sloped.is_some() && !height.simd_eq(height).all_true() {
                        height = self.doubt_unknown(simd, plane, (row, col), height, doubts);
                    }
                    let known = &mut of_row[col..col + LANES];
                    height.max(f64x8::from_slice(simd, known)).store_slice(known);
                }
            }
        }
    }

    /// Records the cells with unknown heights, and keeps the known heights.
    #[cold]
    #[inline(never)]
    fn doubt_unknown<S: Simd>(
        &self,
        simd: S,
        plane: &Plane,
        (row, col): (usize, usize),
        heights: f64x8<S>,
        doubts: &mut Vec<Doubt>,
    ) -> f64x8<S> {
        let mut known: [f64; LANES] = heights.into();
        for (k, height) in known.iter_mut().enumerate().filter(|(_, height)| height.is_nan()) {
            let cell = (row - plane.rows.0) * self.per_row + col + k;
            doubts.push(Doubt { cell, height: f64::INFINITY });
            *height = f64::NEG_INFINITY;
        }
        f64x8::from_slice(simd, &known)
    }

    /// Records the cells of some rows that may be inside or outside of an outline.
    #[cold]
    #[inline(never)]
    fn doubt<S: Simd>(
        &self,
        simd: S,
        plane: &Plane,
        edges: &Edges,
        (inner, outer, sure): (&Lanes, &Lanes, (usize, usize)),
        (first, n): (usize, usize),
        doubts: &mut Vec<Doubt>,
    ) {
        for (row, cols) in doubtful(inner, outer, sure, (first, n)) {
            for col in cols {
                let heights: [f64; LANES] = self.heights(simd, plane, edges, (row, col / LANES * LANES)).into();
                let cell = (row - plane.rows.0) * self.per_row + col;
                let height = heights[col % LANES];
                let height = if height.is_nan() { f64::INFINITY } else { height };
                doubts.push(Doubt { cell, height });
            }
        }
    }

    /// Returns the heights of a caster at the cells of a row from a column on.
    #[inline(always)]
    fn heights<S: Simd>(&self, simd: S, plane: &Plane, edges: &Edges, (row, col): (usize, usize)) -> f64x8<S> {
        let q = (f64x8::from_slice(simd, &self.east[col..col + LANES]), plane.q[row]);
        match self.heights_of {
            HeightsOf::Receivers { .. } => edges.of_receivers(simd, q),
            HeightsOf::Uav { receivers, .. } => {
                let z = match receivers {
                    Receivers::Level(z) => f64x8::splat(simd, as_f64(*z)),
                    Receivers::Relief { heights, width } => {
                        f64x8::from_slice(simd, &heights[row * width + col..][..LANES])
                    }
                };
                edges.of_uav(simd, q, z)
            }
        }
    }
}
