//! `shadow` seen from the ground: finds which of many UAV positions at one height are in line of
//! sight of a receiver.
//!
//! **Line of sight has no direction.** An obstacle that hides a UAV from a receiver hides the
//! receiver from the UAV. So a grid of UAV positions at one height is to a receiver what a grid of
//! receivers is to a UAV, and [`super`] decides it. Mostly the receiver is below the roofs and the
//! positions are above them. Then shadows begin behind the buildings and have no end (the fourth
//! case there).
//!
//! For many positions this direction is the cheaper one. From a street little of the sky is
//! visible, and the walls along the street hide the rest; from above most buildings hide something.
//!
//! **Tiles of receivers.** Neighbors see nearly the same. A position that one convex prism hides
//! from all four corners of a tile is hidden from every receiver inside. Two facts prove it. Seen
//! from a position, the places that the prism hides are convex, being the shadow of a convex body
//! on a plane. And from a position above, a receiver is hidden if one right above it is, so the
//! greatest height of the tile's receivers is enough. These positions are left out for the whole
//! tile (its *umbra*).
//!
//! A caster is left out, too, if it can hide none of the remaining positions from any receiver of
//! the tile ([`Outline::cast_around`]). Both steps are repeated from large tiles to small ones. In
//! the end few positions and few casters remain for each receiver.
//!
//! **Exactness.** Only positions surely inside of all four shadows are in the umbra. The outline
//! around a caster holds its closed shadows from everywhere in the tile. The caster may share a
//! wall with another one, along which only `ray` can decide. If it is left out, that wall runs
//! through no remaining position. Remaining positions are decided as by [`crate::los`], doubts by
//! `ray`.

use fearless_simd::{Level, Simd};

use crate::dispatch;

use super::band::{Band, BandJob};
use super::geometry::distance_squared;
use super::grid::ShadowGrid;
use super::outline::Outline;
use super::plane::Plane;
use super::reach::{LANES, Reach};
use super::scene::{Receivers, ShadowScene, cells_at_uav, extent_of};
use super::spans::{maybe_spans, spans};
use super::words::{bits_outside, clear};
use crate::height_field::{Caster, Casters, Prisms};
use crate::quantity::LatticePoint;
use crate::raster::{BitGrid, bits_between};

/// Number of casters after which the extent of the remaining positions is measured again.
const CASTERS_A_LOOK: usize = 8;

/// UAV positions at one height over a grid, and the prisms that may hide them.
#[derive(Debug, Clone, Copy)]
pub struct UavPositions<'a> {
    /// The prisms that hide positions.
    pub prisms: &'a Prisms,
    /// The casters of shadows: all casters of the prisms, or those that matter.
    pub casters: &'a Casters,
    /// Grid of the positions.
    pub grid: &'a ShadowGrid,
    /// Height of the positions \[1/1024 m above the datum\].
    pub z: i64,
    /// Vector instructions to use; the result is the same at all levels.
    pub level: Level,
}

/// A box that holds some receivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReceiverTile {
    /// West, south, east and north \[lattice steps\].
    pub bounds: [i64; 4],
    /// Heights of the lowest and the highest receiver \[1/1024 m above the datum\].
    pub heights: (i64, i64),
}

/// Positions that receivers of a tile may see, and the casters that may hide them from some of
/// these receivers.
#[derive(Debug, Clone)]
pub struct InView {
    /// Positions that are not hidden from the whole tile.
    pub positions: BitGrid,
    casters: Vec<u32>,
}

impl UavPositions<'_> {
    /// Returns what receivers anywhere may see of some positions.
    pub fn anywhere(&self, asked: &BitGrid) -> InView {
        InView { positions: asked.clone(), casters: (0_u32..).zip(self.casters.all()).map(|(k, _)| k).collect() }
    }

    /// Restricts the view from anywhere to the positions of some rows and columns, and to the
    /// casters between them and a tile.
    pub fn near(&self, tile: &ReceiverTile, (rows, cols): ((usize, usize), (usize, usize)), whole: &InView) -> InView {
        let mut positions = BitGrid::new(self.grid.ys.len(), self.grid.xs.len());
        let words_per_row = positions.words_per_row();
        for row in rows.0..rows.1 {
            let words = &mut positions.words_mut()[row * words_per_row..][..words_per_row];
            for (word, (near, whole)) in words.iter_mut().zip(whole.positions.row(row)).enumerate() {
                *near = whole & bits_between(cols.0, cols.1, word);
            }
        }
        if rows.0 >= rows.1 || cols.0 >= cols.1 {
            return InView { positions, casters: Vec::new() };
        }
        let [west, south, east, north] = tile.bounds;
        let (west, east) = (west.min(self.grid.xs[cols.0]), east.max(self.grid.xs[cols.1 - 1]));
        let (south, north) = (south.min(self.grid.ys[rows.1 - 1]), north.max(self.grid.ys[rows.0]));
        let is_between = |k: &u32| {
            let [w, s, e, n] = self.caster(*k).0.bounds.map(i64::from);
            w <= east && e >= west && s <= north && n >= south
        };
        InView { positions, casters: whole.casters.iter().copied().filter(is_between).collect() }
    }

    /// Narrows the view from a larger tile, or from anywhere, to a tile inside it.
    pub fn from_tile(&self, tile: &ReceiverTile, whole: &InView) -> InView {
        dispatch!(self.level, simd => self.narrowed(simd, tile, whole))
    }

    /// Keeps in `asked`, positions in view from a tile, those in line of sight of a receiver inside
    /// the tile.
    ///
    /// The receiver, or every position, must be outside of all buildings (not checked). Tiles do
    /// not know that a receiver inside of one sees a UAV at the very same point.
    pub fn los(&self, in_view: &InView, receiver: LatticePoint, asked: &mut BitGrid) {
        dispatch!(self.level, simd => self.hide(simd, in_view, receiver, asked));
    }

    fn caster(&self, k: u32) -> (&Caster, &[[i32; 2]]) {
        let caster = &self.casters.all()[k as usize];
        (caster, self.casters.ring(caster))
    }

    fn scene<'b>(&'b self, wanted: &'b BitGrid) -> ShadowScene<'b> {
        let UavPositions { prisms, casters, grid, level, .. } = *self;
        ShadowScene { prisms, casters, grid, wanted, level, n_bands: 1 }
    }

    #[inline(always)]
    fn narrowed<S: Simd>(&self, simd: S, tile: &ReceiverTile, whole: &InView) -> InView {
        let nothing =
            || InView { positions: BitGrid::new(self.grid.ys.len(), self.grid.xs.len()), casters: Vec::new() };
        let scene = self.scene(&whole.positions);
        let [west, south, east, north] = tile.bounds;
        let (lowest, highest) = tile.heights;
        let Some(plane) = scene.plane(scene.wanted, LatticePoint { x: west, y: south, z: highest }) else {
            return nothing();
        };
        let corners = [(west, south), (east, south), (east, north), (west, north)];
        let mut planes = corners.map(|(x, y)| plane.seen_from(self.grid, LatticePoint { x, y, z: highest }));
        let size = [east - west, north - south];
        let mut left = whole.positions.clone();
        let mut kept = Vec::new();
        let (mut around, mut of_corners) = (Outline::default(), <[Outline; 4]>::default());
        for k in self.nearest_first(&whole.casters, tile) {
            let (caster, ring) = self.caster(k);
            let Some(reach) = Reach::new(lowest, caster.top, self.z) else { continue };
            if !around.cast_around(&planes[0], size, ring, caster.bounds, reach)
                || is_dark(simd, &planes[0], &around, &left)
            {
                continue;
            }
            kept.push(k);
            if let Some(reach) = Reach::new(highest, caster.top, self.z) {
                let mut is_any_hidden = true;
                for (plane, outline) in planes.iter().zip(&mut of_corners) {
                    is_any_hidden = is_any_hidden && outline.cast_roof(plane, (self.casters, caster), reach, self.z);
                }
                if is_any_hidden {
                    clear_umbra(simd, &planes, &of_corners, &mut left);
                }
            }
            if kept.len() % CASTERS_A_LOOK == 0 {
                let Some((rows, cols)) = extent_of(&left, planes[0].rows, planes[0].cols) else { return nothing() };
                planes.iter_mut().for_each(|plane| plane.narrow_to(self.grid, rows, cols));
            }
        }
        InView { positions: left, casters: kept }
    }

    /// Returns casters by their distance from the middle of a tile.
    fn nearest_first(&self, casters: &[u32], tile: &ReceiverTile) -> Vec<u32> {
        let [west, south, east, north] = tile.bounds;
        let middle = (west.midpoint(east), south.midpoint(north));
        let key = |k: &u32| (distance_squared(self.caster(*k).0.bounds, middle), *k);
        let mut order: Vec<_> = casters.iter().map(key).collect();
        order.sort_unstable();
        order.into_iter().map(|(_, k)| k).collect()
    }

    #[inline(always)]
    fn hide<S: Simd>(&self, simd: S, in_view: &InView, receiver: LatticePoint, asked: &mut BitGrid) {
        let wanted = asked.clone();
        let scene = self.scene(&wanted);
        let Some(plane) = scene.plane(scene.wanted, receiver) else { return };
        let (words_per_row, n_rows) = (wanted.words_per_row(), wanted.n_rows());
        let (receivers, at_uav) = (&Receivers::Level(self.z), &cells_at_uav(scene.grid, &plane, scene.wanted));
        let job = BandJob { scene: &scene, plane: &plane, receivers, rows: (0, n_rows), at_uav };
        let mut left = Band::new(asked.words_mut(), words_per_row);
        let mut outline = Outline::default();
        for &k in &in_view.casters {
            let (caster, _) = self.caster(k);
            let Some(reach) = Reach::new(receiver.z, caster.top, self.z) else { continue };
            if outline.cast_roof(&plane, (self.casters, caster), reach, self.z) {
                job.hide(simd, &outline, &mut left);
            }
        }
        job.settle(&mut left);
    }
}

/// Clears the cells that are surely inside of all four outlines.
#[inline(always)]
fn clear_umbra<S: Simd>(simd: S, planes: &[Plane; 4], outlines: &[Outline; 4], cells: &mut BitGrid) {
    let rows = planes.iter().zip(outlines).fold((0, usize::MAX), |rows, (plane, outline)| {
        let (first, end) = outline.rows(plane).sure;
        (rows.0.max(first), rows.1.min(end))
    });
    let words_per_row = cells.words_per_row();
    let mut row = rows.0;
    while row < rows.1 {
        // PERF: in a loop, since closures of the standard library may stay calls, compiled for no
        // instruction set.
        let mut sure = [([0; LANES], [0; LANES]); 4];
        for (sure, (plane, outline)) in sure.iter_mut().zip(planes.iter().zip(outlines)) {
            *sure = spans(simd, plane, outline, row).sure;
        }
        let words = cells.words_mut()[row * words_per_row..].chunks_exact_mut(words_per_row);
        for (k, words) in words.take((rows.1 - row).min(LANES)).enumerate() {
            let first = sure.iter().fold(0, |first, s| first.max(s.0[k]));
            let end = sure.iter().fold(u64::MAX, |end, s| end.min(s.1[k]));
            clear(words, first, end);
        }
        row += LANES;
    }
}

/// Returns `true` if no cell of a set may be inside of an outline.
#[inline(always)]
fn is_dark<S: Simd>(simd: S, plane: &Plane, outline: &Outline, cells: &BitGrid) -> bool {
    let rows = outline.rows(plane).maybe;
    let (first_word, end_word) = (plane.cols.0 / 64, plane.cols.1.div_ceil(64));
    let mut row = rows.0;
    while row < rows.1 {
        let maybe = maybe_spans(simd, plane, outline, row);
        let mut any = 0;
        for k in 0..(rows.1 - row).min(LANES) {
            for (word, bits) in cells.row(row + k)[first_word..end_word].iter().enumerate() {
                let base = (first_word + word) as u64 * 64;
                any |= bits & !bits_outside(maybe.0[k], maybe.1[k], base);
            }
        }
        if any != 0 {
            return false;
        }
        row += LANES;
    }
    true
}
