//! Least heights past prisms: every caster raises those of the cells that it can stand in the way of.
//!
//! **Of receivers.** Within the cone over its footprint and behind the near edges a prism hides the receivers below all
//! planes through the UAV and the far upper edges (the near ones of a roof above the UAV), and below its roof if that is below the UAV:
//! `h_U + (H − h_U)·(E × q)/K`, in the words of [`super`]. A receiver's least height is the largest of what the casters ask for.
//!
//! **Of the UAV.** Seen from a receiver at height z the ray over the point t of the way from the UAV's place (t = K/(E × q) on an edge)
//! reaches that place at `z + (H − z)·(E × q)/(E × q − K)` if it grazes the roof there. A roof above the receiver binds at its far edge,
//! the one next to the receiver, a lower one at its near edge; the ray crosses the edge whose height is the least of these.
//!
//! **Sloped roofs.** The planes go through the UAV and both ends of an edge, each at its own height ([`super::sloped`]): with α and β below the UAV they
//! are `h_U − (α·(E × q) + (α − β)·(A × q))/K`, and the roof's own plane comes with them where the UAV is above it. Seen from a receiver the ray
//! grazes the roof at either end of its way over it: where it crosses the near edge, of all the one with the least E × q/K, and where it crosses the far
//! one, of all the one with the greatest. The higher of both heights counts.
//!
//! **Exactness.** E × q, K and their difference are integers below 2^53, which doubles hold, so that heights err by a few roundings of
//! themselves; [`GridHeights`] tells where these may matter, and a walk along the link (`ray`) is asked there. Not known (NaN) are the
//! cell at the UAV, those close behind or below a sloped roof for heights of the UAV, and those on a side of a cone, or so near that rounding matters, if its height is above that of all sure casters.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};
use rayon::prelude::*;

use super::super::grid_heights::GridHeights;
use super::geometry::{as_f64, cross, distance_squared, sub};
use super::horizon::sort_by_horizon;
use super::outline::{LANES, Outline, Reach};
use super::plane::Plane;
use super::scene::{Receivers, ShadowScene, cells_at_uav};
use super::spans::{Lanes, maybe_spans, spans};
use crate::dispatch;
use crate::height_field::{Caster, CasterBlock, Casters, RoofPlane};
use crate::quantity::LatticePoint;

/// Bands of rows to a thread, so that none waits long for another.
const BANDS_PER_THREAD: usize = 4;

/// How much longer a link may be than its part beyond a sloped roof, so that heights of the UAV are told.
const OFTEN: f64 = 256.0;

/// Doubles hold integers up to twice this: E × q and K are two products each, and their difference is four.
const EXACT: i64 = 1 << 52;

/// Which end of the links has its least heights found.
enum HeightsOf {
    /// That of receivers, as far as it is above this \[1/1024 m above the datum\].
    Receivers { from: i64 },
    /// That of the UAV over its place, as far as it is above `from`, by receivers between two heights.
    Uav { from: i64, receivers: Receivers, range: (i64, i64) },
}

/// The least height of a receiver over each wanted cell from which it is in line of sight of `uav` past the prisms, wherever that is
/// above `from` \[1/1024 m above the datum\]: what [`prisms_least_receiver_height`](super::super::prisms_least_receiver_height) finds,
/// but for rounding.
///
/// Cost: the cells of all shadows, however often they overlap. `None` if the scene is so wide, and a block of casters so large, that the
/// product of both lengths is above 2^51, so that doubles may not hold E × q − K.
pub fn shadow_least_receiver_heights(scene: &ShadowScene<'_>, uav: LatticePoint, from: i64) -> Option<GridHeights> {
    least_heights(scene, uav, &HeightsOf::Receivers { from })
}

/// The least height of a UAV at `uav`'s position from which it sees the receiver of each wanted cell past the prisms, wherever that is
/// above `from` \[1/1024 m above the datum\]: what [`prisms_least_height`](super::super::prisms_least_height) finds, but for rounding.
/// `height(row, col)` is that of the receiver \[1/1024 m above the datum\]; the UAV's own plays no part.
///
/// Cost: the cells of the cones behind all casters; `None` as by [`shadow_least_receiver_heights`].
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

/// For each caster, whether it sets the height of anyone: of receivers those behind the horizon do not.
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

/// Whether E × q and K are exact for all casters and cells.
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
    // From corners of sloped roofs there are products of distances.
    let longest = if scene.prisms.are_sloped() { longest.max(farthest) } else { longest };
    farthest * longest <= EXACT / 2
}

/// What the terms of heights over sloped roofs sum up to at most, beyond these heights \[1/1024 m\]: a term is the height of a corner against the
/// other end of the link, as often as the link is longer than its part up to there; where that is more often than [`OFTEN`], a height of the
/// UAV is not told.
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
    /// The largest magnitude of what the heights are above.
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

fn as_column(v: u64) -> usize {
    usize::try_from(v).unwrap_or(usize::MAX)
}

/// What is the same for all casters.
struct Cast<'a> {
    scene: &'a ShadowScene<'a>,
    heights_of: &'a HeightsOf,
    /// By the number of a caster, whether it is cast.
    is_cast: Vec<bool>,
    /// East of the UAV, by column and up to a whole vector \[lattice steps\], exact.
    east: Vec<f64>,
    per_row: usize,
    at_uav: Vec<(usize, usize)>,
}

/// A cell of which a caster may or may not stand in the way, and how high it would be.
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

    /// Makes an outline that of what a caster sets heights of; `false` if it has no cell.
    #[inline(always)]
    fn outline(&self, plane: &Plane, caster: &Caster, reach: Reach, outline: &mut Outline) -> bool {
        let casters = self.scene.casters;
        match self.heights_of {
            HeightsOf::Receivers { from } => outline.cast_roof(plane, (casters, caster), reach, from - 1),
            HeightsOf::Uav { .. } => outline.cast(plane, casters.ring(caster), caster.bounds, reach),
        }
    }

    /// Where a roof at `top` sets heights that are asked for; `None` if nowhere.
    #[inline(always)]
    fn reach(&self, plane: &Plane, top: i32) -> Option<Reach> {
        match self.heights_of {
            // A step lower than asked for: where the shadow ends, doubts are below what matters.
            HeightsOf::Receivers { from } => Reach::new(plane.uav.z, top, from - 1),
            // A roof that is below all receivers asks for no height above its own.
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

    /// Remembers the cells whose heights are not known, and leaves those of the others.
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

    /// Remembers the cells of some rows that may be in an outline or not.
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
        for k in 0..n {
            let row = first + k;
            let (maybe, mut inner) = ((outer.0[k], outer.1[k]), (inner.0[k], inner.1[k]));
            if row < sure.0 || row >= sure.1 || inner.0 >= inner.1 {
                inner = (maybe.1, maybe.1);
            }
            for col in (maybe.0..inner.0).chain(inner.1..maybe.1) {
                let col = as_column(col);
                let heights: [f64; LANES] = self.heights(simd, plane, edges, (row, col / LANES * LANES)).into();
                let cell = (row - plane.rows.0) * self.per_row + col;
                let height = heights[col % LANES];
                let height = if height.is_nan() { f64::INFINITY } else { height };
                doubts.push(Doubt { cell, height });
            }
        }
    }

    /// The heights of a caster at the cells of a row from a column on.
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

/// The edges of a caster, as seen from the UAV.
#[derive(Debug, Default)]
struct Edges {
    far: Vec<Edge>,
    near: Vec<Edge>,
    /// Top \[1/1024 m above the datum\].
    top: f64,
    /// The top above the UAV \[1/1024 m\].
    rise: f64,
    /// Its plane, if it is sloped.
    sloped: Option<SlopedTop>,
}

/// The plane of a sloped top: height at the UAV's place above the UAV, and rise to the east and the north \[1/1024 m\].
#[derive(Debug, Clone, Copy)]
struct SlopedTop {
    above_uav: f64,
    rise: [f64; 2],
}

/// A step E, and K = E × (A − u).
#[derive(Debug, Clone, Copy)]
struct Edge {
    east: f64,
    north: f64,
    k: f64,
    /// Rise to K, of a sloped top that of A above the UAV.
    slope: f64,
    /// A, where it begins.
    from: [f64; 2],
    /// Height of A \[1/1024 m above the datum\].
    height: f64,
    /// What B is above A \[1/1024 m\].
    climb: f64,
}

impl Edge {
    /// A × q.
    #[inline(always)]
    fn cross_from<S: Simd>(&self, simd: S, (east, north): (f64x8<S>, f64)) -> f64x8<S> {
        f64x8::splat(simd, self.from[0] * north) - f64x8::splat(simd, self.from[1]) * east
    }

    /// E × q.
    #[inline(always)]
    fn cross<S: Simd>(&self, simd: S, (east, north): (f64x8<S>, f64)) -> f64x8<S> {
        f64x8::splat(simd, self.east * north) - f64x8::splat(simd, self.north) * east
    }
}

impl Edges {
    #[inline(always)]
    fn of(&mut self, plane: &Plane, casters: &Casters, caster: &Caster) {
        let (ring, heights) = (casters.ring(caster), casters.heights(caster));
        let (ux, uy) = (plane.uav.x, plane.uav.y);
        self.far.clear();
        self.near.clear();
        self.top = f64::from(caster.top);
        self.rise = as_f64(i64::from(caster.top) - plane.uav.z);
        let from_uav = |v: [i32; 2]| [i64::from(v[0]) - ux, i64::from(v[1]) - uy];
        self.sloped = heights.map(|heights| {
            let roof = RoofPlane::through(ring, heights);
            let area = as_f64(roof.area());
            #[expect(clippy::cast_precision_loss, reason = "rounded, within the terms that are reckoned with")]
            let above_uav = -(roof.above(plane.uav) as f64) / area;
            SlopedTop { above_uav, rise: roof.rise().map(|rise| as_f64(rise) / area) }
        });
        let height = |k: usize| heights.map_or(self.top, |heights| f64::from(heights[k]));
        let last = ring.len() - 1;
        let (mut a, mut height_a) = (from_uav(ring[last]), height(last));
        for (k, &vertex) in ring.iter().enumerate() {
            let (b, height_b) = (from_uav(vertex), height(k));
            let edge = sub(b, a);
            let k = cross(edge, a);
            let of_side = if k < 0 { &mut self.far } else { &mut self.near };
            if k != 0 {
                let k = as_f64(k);
                of_side.push(Edge {
                    east: as_f64(edge[0]),
                    north: as_f64(edge[1]),
                    k,
                    slope: (height_a - as_f64(plane.uav.z)) / k,
                    from: a.map(as_f64),
                    height: height_a,
                    climb: height_b - height_a,
                });
            }
            (a, height_a) = (b, height_b);
        }
    }

    /// The least heights of receivers at some places from the UAV, above it.
    #[inline(always)]
    fn of_receivers<S: Simd>(&self, simd: S, q: (f64x8<S>, f64)) -> f64x8<S> {
        if let Some(top) = &self.sloped {
            return self.of_receivers_over(simd, q, top);
        }
        let (edges, cap) = if self.rise <= 0.0 { (&self.far, self.rise) } else { (&self.near, f64::INFINITY) };
        let mut least = f64x8::splat(simd, cap);
        for edge in edges {
            least = least.min(edge.cross(simd, q) * f64x8::splat(simd, edge.slope));
        }
        least
    }

    /// Those past a sloped top.
    #[inline(always)]
    fn of_receivers_over<S: Simd>(&self, simd: S, q: (f64x8<S>, f64), top: &SlopedTop) -> f64x8<S> {
        let splat = |v: f64| f64x8::splat(simd, v);
        let (edges, mut least) = if top.above_uav > 0.0 {
            (&self.near, splat(f64::INFINITY))
        } else {
            (&self.far, splat(top.above_uav + top.rise[1] * q.1) + splat(top.rise[0]) * q.0)
        };
        // In the plane of the roof nothing but that plane tells.
        if top.above_uav == 0.0 {
            return least;
        }
        for edge in edges {
            let turn = edge.cross_from(simd, q) * splat(edge.climb / edge.k);
            least = least.min(edge.cross(simd, q) * splat(edge.slope) - turn);
        }
        least
    }

    /// The least heights of the UAV past a sloped top; NaN where rounding may matter.
    #[inline(always)]
    fn of_uav_over<S: Simd>(&self, simd: S, q: (f64x8<S>, f64), z: f64x8<S>, top: &SlopedTop) -> f64x8<S> {
        let splat = |v: f64| f64x8::splat(simd, v);
        let (zero, infinite, unknown) = (splat(0.0), splat(f64::INFINITY), splat(f64::NAN));
        // At which part of the way, as often as that is less, the ray crosses an edge, and the UAV's height if it grazes the roof there.
        let at = |edge: &Edge| {
            let cross = edge.cross(simd, q);
            let behind = cross - splat(edge.k);
            let over = (splat(edge.height) - z) * cross - edge.cross_from(simd, q) * splat(edge.climb);
            let height = z + over / behind;
            let is_close = cross.abs().simd_gt((behind * splat(OFTEN)).abs());
            (cross / splat(edge.k), is_close.select(unknown, height))
        };
        // Above its own roof the UAV is as high as that at least.
        let own = splat(self.top - self.rise + top.above_uav);
        let (mut near, mut of_near) = (infinite, own);
        for edge in &self.near {
            let (part, height) = at(edge);
            let is_first = part.simd_lt(near);
            (near, of_near) = (is_first.select(part, near), is_first.select(height, of_near));
        }
        let (mut far, mut of_far) = (splat(1.0), zero);
        for edge in &self.far {
            let (part, height) = at(edge);
            let is_last = part.simd_gt(far);
            (far, of_far) = (is_last.select(part, far), is_last.select(height, of_far));
        }
        // Over the footprint a receiver is below its roof, where no height is enough, or above it.
        let roof = splat(self.top - self.rise + top.above_uav + top.rise[1] * q.1) + splat(top.rise[0]) * q.0;
        let (below, margin) = (roof - z, splat(1.0 / 64.0));
        let within = below.simd_gt(margin).select(infinite, below.simd_lt(-margin).select(of_near, unknown));
        let is_within = far.simd_le(splat(1.0));
        let past = of_near.max_precise(of_far);
        let past = (of_near.simd_eq(of_near) & of_far.simd_eq(of_far)).select(past, unknown);
        is_within.select(within, past)
    }

    /// The least heights of the UAV for receivers at some places from it and heights `z`.
    #[inline(always)]
    fn of_uav<S: Simd>(&self, simd: S, q: (f64x8<S>, f64), z: f64x8<S>) -> f64x8<S> {
        if let Some(top) = &self.sloped {
            return self.of_uav_over(simd, q, z, top);
        }
        let zero = f64x8::splat(simd, 0.0);
        let rise = f64x8::splat(simd, self.top) - z;
        // Over the footprint a receiver below the roof has no edge between it and the building: no height is enough.
        let infinite = f64x8::splat(simd, f64::INFINITY);
        let (mut far, mut near) = (infinite, rise);
        for edge in &self.far {
            let cross = edge.cross(simd, q);
            let behind = cross - f64x8::splat(simd, edge.k);
            far = far.min(behind.simd_lt(zero).select(rise * cross / behind, infinite));
        }
        if !rise.simd_gt(zero).all_true() {
            for edge in &self.near {
                let cross = edge.cross(simd, q);
                let behind = cross - f64x8::splat(simd, edge.k);
                near = near.min(behind.simd_gt(zero).select(rise * cross / behind, rise));
            }
        }
        z + rise.simd_gt(zero).select(far, near)
    }
}
