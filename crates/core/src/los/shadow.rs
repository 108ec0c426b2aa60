//! `shadow` over prisms: casts the shadow of every convex piece on the receivers, row by row, into a set of bits.
//!
//! **Method.** Let u be the UAV, F a convex footprint with its roof at H, and let receivers stand at height z. A receiver
//! at p is hidden by this prism alone if and only if some point u + t(p − u), 0 < t < 1, of the ray lies in the interior
//! of F while the ray is below the roof there: h_U + t(z − h_U) < H. With s = 1/t > 1 the hidden set is the union of all
//! u + s(F° − u) over the s that the heights admit:
//!
//! ```text
//!   H ≤ z and H ≤ h_U    nothing
//!   z < H < h_U          1 < s < f, f = (h_U − z)/(h_U − H)     the roof's shadow on the plane z
//!   H ≥ h_U and H ≥ z    1 < s                                  no end
//!   h_U < H < z          g < s, g = (z − h_U)/(H − h_U)         no end, and it begins behind the building
//!   ⇒ always near < s < far, with near = 1 or g, and far = f or ∞; near may be larger where another hides what is nearer
//! ```
//!
//! **Half-planes.** Let edge A→B of the counterclockwise F have direction E, and let K = E × (A − u). Inside F,
//! E × (p − u) > K; u itself is outside of the edge's line if K > 0 (the edge *faces* u), inside if K < 0. Scaled by s
//! about u the edge bounds E × (p − u) > s·K. A point of the cone over F from u leaves through edges that do not face u
//! and enters through those that do, so it is hidden if and only if it is inside the facing edges at s = near, inside the
//! others at s = far (if there is an end), and inside the cone, whose sides are the lines from u through the two vertices
//! where facing edges meet others. An edge whose line passes through u (K = 0) is such a side itself; over F there is no
//! facing edge and the cone is the whole plane. So the hidden set is an open convex set: an intersection of half-planes
//! E × q > K', q = p − u. Along a row of cells each of them is one bound on the column, `at + per_q·q_y`: the hidden cells
//! of the row lie between the largest of the western and the smallest of the eastern bounds.
//!
//! **Exactness.** Coordinates, E, K and the rows' q_y are integers (K and products of differences below 2^55 in i64); the
//! bounds are computed in doubles, in one order of operations at every SIMD level, with an error proven to be below a
//! margin (`shadow_outline::ROUNDING`) of about 1e-11 cells. Cells farther from all bounds than the margin are decided.
//! The few others are put down as *doubts*, and `ray` is asked about those that are wanted and that no other
//! shadow has hidden by the end: it alone knows whether the wall or diagonal that they look along is shared. Nothing else
//! can be hidden: where the ray is blocked only by several pieces together it runs along an edge of two of them, so the
//! receiver lies on a bounding line (K = 0) of both, in the closure of both shadows, and is a doubt. Where centers of cells
//! do not lie evenly on the lattice (cells of 0.3 m) the margin grows by the largest deviation.
//!
//! **Differing heights** ([`shadow_los_relief`]). Solved for z, the half-plane of an edge at s = f (or g) reads
//! z < h_U + (E × q)·(H − h_U)/K: below the plane through the UAV and the far (near) upper edge. So within the cone and
//! behind the near edges a prism hides the receivers below the lowest of these planes, and below its roof if that is below
//! the UAV: its ceiling. The least of several planes is concave, so its values at the corners of a tile bound it there: tiles
//! whose receivers are all below are filled as before, tiles whose receivers are all above are left out, and in the others
//! eight receivers at a time are compared with the planes, again with a proven margin and doubts. Higher receivers are
//! hidden by less, so the outline on the lowest bounds all. Where many receivers stand at the lowest height (flat ground
//! with roofs) they are cast first, as one level. A ceiling kept per cell in doubles was not taken: every shadow would write
//! 64 times the memory and no ground would ever be dark.
//!
//! **Cost.** Proportional to the rows of the shadows, not their cells: a set of bits is cleared 64 cells at a time. Seen from
//! above all receivers, where shadows are long, casters behind the horizon are left out and the shadows of the others begin where
//! what stands before them hides no more ([`super::shadow_horizon`]), so that most of the ground is cleared about once. Blocks of
//! neighboring casters go nearest first, one sector of azimuths after the other, so that the far ones find their ground dark:
//! 64 rows of a shadow are skipped where no wanted cell is left in the tiles of 64 × 64 cells that they meet, and whole blocks
//! likewise.

use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;

use super::prisms_ray::prisms_los;
use super::shadow_cast::Cast;
use super::shadow_ceiling::Ceiling;
use super::shadow_grid::ShadowGrid;
use super::shadow_outline::{Outline, Plane, Reach};
use super::shadow_spans::{LANES, Lanes, as_f64, below_ceiling, bits_outside, clear, for_each_bit, maybe_spans, spans};
use crate::height_field::{Casters, Prisms};
use crate::quantity::LatticePoint;
use crate::raster::BitGrid;

/// Rows, and columns, of a tile: one word of bits.
const TILE: usize = 64;

/// Words a row that a shadow counted as narrow may meet.
const NARROW: usize = 3;

/// Everything about shadows that is the same for many UAVs.
#[derive(Debug, Clone, Copy)]
pub struct ShadowScene<'a> {
    /// What hides receivers.
    pub prisms: &'a Prisms,
    /// What casts shadows: all casters of the prisms, or those that matter.
    pub casters: &'a Casters,
    /// Where receivers stand.
    pub grid: &'a ShadowGrid,
    /// The cells to decide, of the same shape as the grid.
    pub wanted: &'a BitGrid,
    /// Vector instructions to use; the outcome is the same at all levels.
    pub level: Level,
    /// Bands of rows that are worked on in parallel in the current pool; the outcome is the same for any number.
    pub n_bands: usize,
}

/// The cells in line of sight of a UAV.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShadowLos {
    /// The wanted cells that are in line of sight.
    pub los: BitGrid,
    /// How many they are.
    pub count: u64,
    /// Receivers on the boundary of a shadow that `ray` was asked about.
    pub asked: u64,
}

/// Finds the wanted cells whose receivers, all at height `z` \[1/1024 m above the datum\], are in line of sight of `uav`
/// past the prisms: cell for cell what [`prisms_los`] says.
///
/// Cost: the rows of the shadows; see the module. Positions may differ by at most 2^27 lattice steps along each axis (not
/// checked).
pub fn shadow_los(scene: &ShadowScene<'_>, uav: LatticePoint, z: i64) -> ShadowLos {
    match plane_of(scene.grid, scene.wanted, uav) {
        Some(plane) => {
            let cast = Cast::new(scene.casters, &plane, (z, z));
            cast_all(scene, scene.wanted.in_rows(plane.rows.0..plane.rows.1), &plane, &Receivers::Level(z), &cast)
        }
        None => nothing(scene),
    }
}

/// Like [`shadow_los`], for `cells` in place of the wanted ones of the scene.
pub(super) fn shadow_los_among(scene: &ShadowScene<'_>, cells: BitGrid, uav: LatticePoint, z: i64) -> BitGrid {
    match plane_of(scene.grid, &cells, uav) {
        Some(plane) => {
            let cast = Cast::new(scene.casters, &plane, (z, z));
            cast_all(scene, cells, &plane, &Receivers::Level(z), &cast).los
        }
        None => cells,
    }
}

/// Like [`shadow_los`] for receivers at differing heights: `height(row, col)` \[1/1024 m above the datum\] of each wanted
/// cell.
///
/// Cost: where a quarter or more of the receivers stand at the lowest height (flat ground), those cost no more than by
/// [`shadow_los`]; the others one comparison, eight at a time, for each shadow that their tile does not settle.
pub fn shadow_los_relief(
    scene: &ShadowScene<'_>,
    uav: LatticePoint,
    height: &(impl Fn(usize, usize) -> i32 + Sync),
) -> ShadowLos {
    let wanted = scene.wanted;
    let width = wanted.words_per_row() * 64;
    let mut heights = vec![0.0; wanted.n_rows() * width];
    let (lowest, highest) = heights
        .par_chunks_mut(width.max(1))
        .enumerate()
        .map(|(row, heights)| {
            let mut range = (i32::MAX, i32::MIN);
            for_each_bit(wanted.row(row), 0, wanted.n_cols(), |col| {
                let z = height(row, col);
                range = (range.0.min(z), range.1.max(z));
                heights[col] = f64::from(z);
            });
            range
        })
        .reduce(|| (i32::MAX, i32::MIN), |a, b| (a.0.min(b.0), a.1.max(b.1)));
    let Some(plane) = plane_of(scene.grid, wanted, uav) else { return nothing(scene) };
    let cast = Cast::new(scene.casters, &plane, (i64::from(lowest), i64::from(highest)));
    // Receivers on flat ground are one level, those on roofs the rest.
    let (mut level, mut rest) = (BitGrid::new(wanted.n_rows(), wanted.n_cols()), wanted.clone());
    for row in 0..wanted.n_rows() {
        let words = row * wanted.words_per_row()..(row + 1) * wanted.words_per_row();
        let (level, rest) = (&mut level.words_mut()[words.clone()], &mut rest.words_mut()[words]);
        for (k, (level, rest)) in level.iter_mut().zip(rest).enumerate() {
            let mut lowest_of_word = 0;
            for (bit, z) in heights[row * width + k * 64..][..64].iter().enumerate() {
                lowest_of_word |= u64::from(*z <= f64::from(lowest)) << bit;
            }
            *level = *rest & lowest_of_word;
            *rest &= !*level;
        }
    }
    let relief = Receivers::Relief { heights, width };
    if level.count() * 4 < wanted.count() {
        return cast_all(scene, wanted.in_rows(plane.rows.0..plane.rows.1), &plane, &relief, &cast);
    }
    let on_some = |wanted: &BitGrid, receivers: &Receivers| match plane_of(scene.grid, wanted, uav) {
        Some(plane) => {
            let cells = wanted.in_rows(plane.rows.0..plane.rows.1);
            cast_all(&ShadowScene { wanted, ..*scene }, cells, &plane, receivers, &cast)
        }
        None => nothing(&ShadowScene { wanted, ..*scene }),
    };
    let one = on_some(&level, &Receivers::Level(i64::from(lowest)));
    let all = on_some(&rest, &relief);
    ShadowLos { los: all.los.or(&one.los), count: all.count + one.count, asked: all.asked + one.asked }
}

/// How high receivers stand \[1/1024 m above the datum\].
pub(super) enum Receivers {
    Level(i64),
    /// By cell, `width` to the row, whole words of cells; 0 where none is wanted.
    Relief {
        heights: Vec<f64>,
        width: usize,
    },
}

impl Receivers {
    #[inline(always)]
    fn at(&self, row: usize, col: usize) -> i64 {
        match self {
            Receivers::Level(z) => *z,
            Receivers::Relief { heights, width } => {
                #[expect(clippy::cast_possible_truncation, reason = "came from an i32")]
                let z = heights[row * width + col] as i64;
                z
            }
        }
    }
}

/// What is found where no cell is wanted.
fn nothing(scene: &ShadowScene<'_>) -> ShadowLos {
    ShadowLos { los: scene.wanted.clone(), count: 0, asked: 0 }
}

/// Casts shadows on receivers of a scene; `los` are all the cells that hold one, and become those in line of sight.
fn cast_all(
    scene: &ShadowScene<'_>,
    mut los: BitGrid,
    plane: &Plane,
    receivers: &Receivers,
    cast: &Cast<'_>,
) -> ShadowLos {
    let at_uav = cells_at_uav(scene.grid, plane, &los);
    let words_per_row = los.words_per_row();
    let n_tiles = (plane.rows.1 - plane.rows.0).div_ceil(TILE);
    let rows_per_band = n_tiles.div_ceil(scene.n_bands.max(1)) * TILE;
    let (first, end) = (plane.rows.0 * words_per_row, plane.rows.1 * words_per_row);
    let in_band = |(k, words): (usize, &mut [u64])| {
        let first = plane.rows.0 + k * rows_per_band;
        let rows = (first, first + words.len() / words_per_row);
        let job = BandJob { scene, plane, receivers, rows, at_uav: &at_uav };
        dispatch!(scene.level, simd => job.cast(simd, cast, words))
    };
    let bands = &mut los.words_mut()[first..end];
    let counts = if n_tiles * TILE <= rows_per_band {
        in_band((0, bands))
    } else {
        let counts = bands.par_chunks_mut(rows_per_band * words_per_row).enumerate().map(in_band);
        counts.reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1))
    };
    ShadowLos { los, count: counts.0, asked: counts.1 }
}

/// The rows and the columns between which all cells of a set lie that are within some; `None` without any.
pub(super) fn extent_of(cells: &BitGrid, rows: (usize, usize), cols: (usize, usize)) -> Option<(Span, Span)> {
    let (first_word, end_word) = (cols.0 / 64, cols.1.div_ceil(64));
    let is_used = |row: &usize| cells.row(*row)[first_word..end_word].iter().any(|w| *w != 0);
    let first = (rows.0..rows.1).find(is_used)?;
    let last = (first..rows.1).rev().find(is_used)?;
    // PERF: row by row, as they lie in memory.
    let mut used = cells.row(first)[first_word..end_word].to_vec();
    for row in first + 1..=last {
        used.iter_mut().zip(&cells.row(row)[first_word..end_word]).for_each(|(used, word)| *used |= word);
    }
    let west = used.iter().position(|w| *w != 0)?;
    let east = used.iter().rposition(|w| *w != 0)?;
    let first_col = (first_word + west) * 64 + used[west].trailing_zeros() as usize;
    let end_col = (first_word + east) * 64 + 64 - used[east].leading_zeros() as usize;
    Some(((first, last + 1), (first_col, end_col)))
}

/// The first of some rows or columns, and the one after the last.
type Span = (usize, usize);

/// The plane as seen from a UAV; `None` if no cell is wanted.
pub(super) fn plane_of(grid: &ShadowGrid, wanted: &BitGrid, uav: LatticePoint) -> Option<Plane> {
    let (rows, cols) = extent_of(wanted, (0, wanted.n_rows()), (0, wanted.n_cols()))?;
    Some(Plane::new(grid, uav, rows, cols))
}

/// The wanted cells right below or above the UAV, of which no shadow tells.
pub(super) fn cells_at_uav(grid: &ShadowGrid, plane: &Plane, wanted: &BitGrid) -> Vec<(usize, usize)> {
    let (x, y) = (plane.uav.x, plane.uav.y);
    let cols = grid.xs.partition_point(|at| *at < x)..grid.xs.partition_point(|at| *at <= x);
    let rows = grid.ys.partition_point(|at| *at > y)..grid.ys.partition_point(|at| *at >= y);
    let within = |cells: std::ops::Range<usize>, (first, end): Span| cells.start.max(first)..cells.end.min(end);
    within(rows, plane.rows)
        .flat_map(|row| within(cols.clone(), plane.cols).map(move |col| (row, col)))
        .filter(|(row, col)| wanted.contains(*row, *col))
        .collect()
}

/// One band of rows.
pub(super) struct BandJob<'a> {
    pub(super) scene: &'a ShadowScene<'a>,
    pub(super) plane: &'a Plane,
    pub(super) receivers: &'a Receivers,
    pub(super) rows: (usize, usize),
    /// The wanted cells right below or above the UAV.
    pub(super) at_uav: &'a [(usize, usize)],
}

/// A run of cells of a row that are on the boundary of some shadow, or so near that rounding matters.
struct Doubt {
    row: u32,
    cols: (u32, u32),
}

/// What changes while a band is worked on.
pub(super) struct Band<'a> {
    /// Wanted cells that are not yet hidden.
    words: &'a mut [u64],
    words_per_row: usize,
    /// For each tile, rows known to hold no such cell any more.
    closed_rows: Vec<u8>,
    doubts: Vec<Doubt>,
    /// Words of the present row of tiles, and whether all their receivers are surely below the present ceiling.
    tiles_to_do: Vec<(usize, bool)>,
}

impl BandJob<'_> {
    /// Clears the cells that the blocks of casters hide; returns how many are left and how many were asked about.
    #[inline(always)]
    fn cast<S: Simd>(&self, simd: S, cast: &Cast<'_>, words: &mut [u64]) -> (u64, u64) {
        let mut band = Band::new(words, self.scene.wanted.words_per_row());
        let tiles = self.tile_heights();
        if let Some((lowest, highest)) = self.heights(&tiles) {
            let mut outline = Outline::default();
            let mut ceiling = Ceiling::default();
            for block in cast.blocks() {
                let Some(reach) = Reach::new(self.plane.uav.z, block.max_top, lowest) else { continue };
                let [w, s, e, n] = block.bounds;
                let box_ring = [[w, s], [e, s], [e, n], [w, n]];
                let is_in_view = outline.cast(self.plane, &box_ring, block.bounds, reach.from(block.begin));
                if !is_in_view || self.is_dark(&outline, &mut band) {
                    continue;
                }
                for (caster, ring, begin) in cast.of_block(block) {
                    let Some(reach) = Reach::new(self.plane.uav.z, caster.top, lowest) else { break };
                    if outline.cast(self.plane, ring, caster.bounds, reach.from(begin)) {
                        if lowest == highest {
                            self.hide(simd, &outline, &mut band);
                        } else {
                            ceiling.cast(self.plane, ring, caster.top);
                            self.hide_relief(simd, &outline, &ceiling, &tiles, &mut band);
                        }
                    }
                }
            }
        }
        let asked = self.settle(&mut band);
        (band.words.iter().map(|w| u64::from(w.count_ones())).sum(), asked)
    }

    /// The lowest and the highest receiver of each tile, the wrong way around where there is none; nothing for receivers
    /// at one level.
    fn tile_heights(&self) -> Vec<(f64, f64)> {
        let Receivers::Relief { heights, width } = self.receivers else { return Vec::new() };
        let wanted = self.scene.wanted;
        let words_per_row = wanted.words_per_row();
        let n_tiles = (self.rows.1 - self.rows.0).div_ceil(TILE) * words_per_row;
        let mut tiles = vec![(f64::INFINITY, f64::NEG_INFINITY); n_tiles];
        for row in self.rows.0..self.rows.1 {
            for_each_bit(wanted.row(row), 0, wanted.n_cols(), |col| {
                let z = heights[row * width + col];
                let tile = &mut tiles[(row - self.rows.0) / TILE * words_per_row + col / 64];
                *tile = (tile.0.min(z), tile.1.max(z));
            });
        }
        tiles
    }

    /// The lowest and the highest receiver of the band, if there is one.
    fn heights(&self, tiles: &[(f64, f64)]) -> Option<(i64, i64)> {
        if let Receivers::Level(z) = self.receivers {
            return Some((*z, *z));
        }
        let (low, high) = tiles.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        #[expect(clippy::cast_possible_truncation, reason = "came from an i32")]
        let range = (low as i64, high as i64);
        (low <= high).then_some(range)
    }

    /// The strips of an outline: rows `.0..=.1` of one row of tiles, clipped to the band.
    #[inline(always)]
    fn strips(&self, rows: (usize, usize)) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (first, end) = (rows.0.max(self.rows.0), rows.1.min(self.rows.1));
        let origin = self.rows.0;
        let mut row = first;
        std::iter::from_fn(move || {
            (row < end).then(|| {
                let from = row;
                row = (origin + ((from - origin) / TILE + 1) * TILE).min(end);
                (from, row - 1)
            })
        })
    }

    /// Whether no wanted cell that the outline may meet is left.
    #[inline(always)]
    fn is_dark(&self, outline: &Outline, band: &mut Band<'_>) -> bool {
        let rows = outline.rows(self.plane).maybe;
        self.strips(rows).all(|(first, last)| match outline.columns_between(self.plane, first, last) {
            None => true,
            Some(cols) => band.is_closed((first - self.rows.0) / TILE, cols),
        })
    }

    /// Clears the cells of one shadow on receivers at one height.
    ///
    /// PERF: most shadows are a few words wide. There each word of eight rows gets its mask without a branch (vectorized),
    /// which took a quarter off all times (AVX-512): whether a span begins, ends or is empty in a word is a coin toss.
    #[inline(always)]
    pub(super) fn hide<S: Simd>(&self, simd: S, outline: &Outline, band: &mut Band<'_>) {
        let rows = outline.rows(self.plane);
        let is_short = rows.maybe.1 - rows.maybe.0.min(rows.maybe.1) <= TILE;
        let words_per_row = band.words_per_row;
        for (first, last) in self.strips(rows.maybe) {
            let cols =
                if is_short { outline.columns(self.plane) } else { outline.columns_between(self.plane, first, last) };
            let Some(cols) = cols else { continue };
            if band.is_closed((first - self.rows.0) / TILE, cols) {
                continue;
            }
            let (first_word, last_word) = (cols.0 / 64, (cols.1 - 1) / 64);
            let is_narrow = last_word - first_word < NARROW;
            let mut row = first;
            while row <= last {
                let n = (last + 1 - row).min(LANES);
                let spans = spans(simd, self.plane, outline, row);
                let rows_of_band = &mut band.words[(row - self.rows.0) * words_per_row..];
                if !spans.is_all_sure || row < rows.sure.0 || row + n > rows.sure.1 {
                    let maybe = maybe_spans(simd, self.plane, outline, row);
                    self.hide_in_doubt(&spans.sure, &maybe, (row, n), rows.sure, band);
                } else if is_narrow {
                    for word in first_word..=last_word {
                        let base = word as u64 * 64;
                        let kept: [u64; LANES] =
                            std::array::from_fn(|k| bits_outside(spans.sure.0[k], spans.sure.1[k], base));
                        for (words, kept) in rows_of_band.chunks_exact_mut(words_per_row).zip(&kept[..n]) {
                            words[word] &= kept;
                        }
                    }
                } else {
                    for (k, words) in rows_of_band.chunks_exact_mut(words_per_row).take(n).enumerate() {
                        clear(words, spans.sure.0[k], spans.sure.1[k]);
                    }
                }
                row += LANES;
            }
        }
    }

    /// The same where some of `n` rows from `row` on have cells in doubt.
    #[inline(never)]
    fn hide_in_doubt(
        &self,
        inner: &Lanes,
        outer: &Lanes,
        (row, n): (usize, usize),
        sure: (usize, usize),
        band: &mut Band<'_>,
    ) {
        for k in 0..n {
            let (maybe, mut inner) = ((outer.0[k], outer.1[k]), (inner.0[k], inner.1[k]));
            if row + k < sure.0 || row + k >= sure.1 || inner.0 >= inner.1 {
                inner = (maybe.1, maybe.1);
            }
            clear(band.row_mut(row + k - self.rows.0), inner.0, inner.1);
            band.doubt(row + k, maybe.0, inner.0);
            band.doubt(row + k, inner.1, maybe.1);
        }
    }

    /// Clears the cells of one shadow on receivers at differing heights; the outline is that on the lowest of all.
    #[inline(always)]
    fn hide_relief<S: Simd>(
        &self,
        simd: S,
        outline: &Outline,
        ceiling: &Ceiling,
        tiles: &[(f64, f64)],
        band: &mut Band<'_>,
    ) {
        let Receivers::Relief { heights, width } = self.receivers else { return };
        let rows = outline.rows(self.plane);
        let words_per_row = band.words_per_row;
        for (first, last) in self.strips(rows.maybe) {
            let Some(cols) = outline.columns_between(self.plane, first, last) else { continue };
            let tile_row = (first - self.rows.0) / TILE;
            band.tiles_to_do.clear();
            for word in cols.0 / 64..=(cols.1 - 1) / 64 {
                if band.is_closed(tile_row, (word * 64, word * 64 + 1)) {
                    continue;
                }
                let (lowest, highest) = tiles[tile_row * words_per_row + word];
                let ends = (as_f64(word * 64), as_f64(word * 64 + 63));
                let (low, high) = ceiling.range((self.plane.q[first], self.plane.q[last]), ends);
                if lowest < ceiling.cap && lowest <= high {
                    band.tiles_to_do.push((word, highest < low && highest < ceiling.cap));
                }
            }
            if band.tiles_to_do.is_empty() {
                continue;
            }
            for row in (first..=last).step_by(LANES) {
                let n = (last + 1 - row).min(LANES);
                let spans = spans(simd, self.plane, outline, row);
                let is_all_sure = spans.is_all_sure && row >= rows.sure.0 && row + n <= rows.sure.1;
                let maybe = if is_all_sure { None } else { Some(maybe_spans(simd, self.plane, outline, row)) };
                for k in 0..n {
                    let is_sure_row = row + k >= rows.sure.0 && row + k < rows.sure.1;
                    for t in 0..band.tiles_to_do.len() {
                        let (word, is_below) = band.tiles_to_do[t];
                        let at = (row + k - self.rows.0) * words_per_row + word;
                        let (open, base) = (band.words[at], word as u64 * 64);
                        let inside = |lanes: &Lanes| open & !bits_outside(lanes.0[k], lanes.1[k], base);
                        let sure = if is_sure_row { inside(&spans.sure) } else { 0 };
                        let maybe = maybe.as_ref().map_or(0, inside) & !sure;
                        if sure | maybe == 0 {
                            continue;
                        }
                        let (below, near) = if is_below {
                            (u64::MAX, 0)
                        } else {
                            let heights = &heights[(row + k) * width + word * 64..][..64];
                            below_ceiling(simd, ceiling, self.plane.q[row + k], as_f64(word * 64), heights)
                        };
                        band.words[at] &= !(sure & below);
                        let doubts = sure & near | maybe & (below | near);
                        if doubts != 0 {
                            band.doubt_bits(row + k, word, doubts);
                        }
                    }
                }
            }
        }
    }

    /// Asks `ray` about all doubts that are still open, and about the cell right below or above the UAV.
    pub(super) fn settle(&self, band: &mut Band<'_>) -> u64 {
        let (uav, grid) = (self.plane.uav, self.scene.grid);
        let mut cells: Vec<(usize, usize)> =
            self.at_uav.iter().copied().filter(|(row, _)| (self.rows.0..self.rows.1).contains(row)).collect();
        for doubt in std::mem::take(&mut band.doubts) {
            let row = doubt.row as usize;
            let cols = (doubt.cols.0 as usize, doubt.cols.1 as usize);
            for_each_bit(band.row_mut(row - self.rows.0), cols.0, cols.1, |col| cells.push((row, col)));
        }
        cells.sort_unstable();
        cells.dedup();
        for &(row, col) in &cells {
            let receiver = LatticePoint { x: grid.xs[col], y: grid.ys[row], z: self.receivers.at(row, col) };
            let is_los = prisms_los(self.scene.prisms, uav, receiver);
            let word = &mut band.row_mut(row - self.rows.0)[col / 64];
            *word = *word & !(1 << (col % 64)) | u64::from(is_los) << (col % 64);
        }
        cells.len() as u64
    }
}

impl<'a> Band<'a> {
    /// A band of rows of `words_per_row` words each, in which nothing is hidden yet.
    pub(super) fn new(words: &'a mut [u64], words_per_row: usize) -> Self {
        let n_tiles = (words.len() / words_per_row.max(1)).div_ceil(TILE) * words_per_row;
        Band { words, words_per_row, closed_rows: vec![0; n_tiles], doubts: Vec::new(), tiles_to_do: Vec::new() }
    }

    #[inline(always)]
    fn row_mut(&mut self, row: usize) -> &mut [u64] {
        &mut self.words[row * self.words_per_row..(row + 1) * self.words_per_row]
    }

    fn doubt(&mut self, row: usize, first: u64, end: u64) {
        if first < end {
            let narrow = |v: u64| u32::try_from(v).unwrap_or(u32::MAX);
            self.doubts.push(Doubt { row: narrow(row as u64), cols: (narrow(first), narrow(end)) });
        }
    }

    #[cold]
    fn doubt_bits(&mut self, row: usize, word: usize, mut bits: u64) {
        while bits != 0 {
            let col = word as u64 * 64 + u64::from(bits.trailing_zeros());
            self.doubt(row, col, col + 1);
            bits &= bits - 1;
        }
    }

    /// Whether no wanted cell is left in the tiles of a row of tiles that hold columns `cols.0..cols.1`.
    ///
    /// PERF: bits are only ever cleared, so rows found empty stay so; each tile remembers how many, and all the
    /// questions about a tile together look at each of its rows once, and once at its first row that is not empty.
    #[inline(always)]
    fn is_closed(&mut self, tile_row: usize, cols: (usize, usize)) -> bool {
        let n_rows = (self.words.len() / self.words_per_row - tile_row * TILE).min(TILE);
        let mut word = cols.0 / 64;
        while word * 64 < cols.1 {
            let closed_rows = &mut self.closed_rows[tile_row * self.words_per_row + word];
            let mut row = usize::from(*closed_rows);
            while row < n_rows && self.words[(tile_row * TILE + row) * self.words_per_row + word] == 0 {
                row += 1;
            }
            *closed_rows = u8::try_from(row).unwrap_or(u8::MAX);
            if row < n_rows {
                return false;
            }
            word += 1;
        }
        true
    }
}
