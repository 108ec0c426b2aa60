//! `shadow` over a raster that is a block model: its plateaus are prisms, and receivers stand on
//! the ground or on them.
//!
//! **Why.** Many rasters of cities are block models on a grid along their walls, generated ones
//! above all: 17 million cells, 8500 blocks. The union of the columns above the lowest height is
//! that of as many prisms, whose shadows cost about a third of a sweep over the cells.
//!
//! **Receivers.** Receivers at one height are one level, as on flat ground. So are receivers on the
//! plateaus of the height that most cells have. [`super`] decides them. Each other plateau is a
//! level of its own, mostly of few cells.
//!
//! If such a plateau is below the UAV, the horizon often decides all its receivers: all hidden, or
//! all in line of sight. It also selects the prisms that can hide any receiver
//! ([`super::horizon`]). For the remaining plateaus the sky is wide, and only obstacles between the
//! plateau and the UAV can hide a part of it. They are the prisms in the buckets that meet the hull
//! of both, from the plateau on, until every ray is above the highest top. Their shadows are cast
//! on the plateau's cells alone.
//!
//! **Exactness.** Shadows are those of [`super`], with their margins and doubts. Bounds on the
//! obstacles in between are computed in doubles and widened by a lattice step, far more than they
//! can err.
//!
//! Doubts are decided by [`prisms_los`]. For two points that are not below the lowest height, the
//! prisms block the link if and only if the columns do. The exception is the receiver's own cell,
//! which is exempt among columns and not among prisms. It matters if the ray is below the top of
//! the own cell inside of it. That holds for receivers that stand below that top. It also holds for
//! receivers that look down on a UAV below them so steeply that the ray dips below their roof
//! before it has left the cell. Both are decided by [`columns_los`].

use std::ops::ControlFlow;

use fearless_simd::{Level, Simd};

use crate::dispatch;
use rayon::prelude::*;

use super::super::columns_ray::columns_los;
use super::super::prisms_ray::prisms_los;
use super::between::{Between, Visits};
use super::grid::ShadowGrid;
use super::horizon::{Sight, sort_by_horizon};
use super::map::{shadow_los, shadow_los_among};
use super::outline::{Outline, Rows};
use super::plane::Plane;
use super::reach::{LANES, Reach};
use super::scene::{ShadowScene, flat_plane_of};
use super::spans::{maybe_spans, spans};
use super::words::{bits_outside, clear, for_each_bit};
use crate::height_field::{Columns, Plateau, Plateaus, Prisms};
use crate::quantity::{LatticePoint, STEPS_PER_UNIT};
use crate::raster::{BitGrid, CellWindow, bits_between};

/// Bands of rows to a thread, so that no thread waits long for another.
const BANDS_PER_THREAD: usize = 4;

/// Half the edge of a cell \[lattice steps\].
const HALF_CELL: i64 = STEPS_PER_UNIT as i64 / 2;

/// The receivers' heights on a raster of plateaus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OnPlateaus {
    /// All at one height \[1/1024 m above the datum\].
    Level(i64),
    /// This far above the top of their cell \[1/1024 m\].
    Above(i32),
}

/// Data of a raster of plateaus that are the same for many UAVs.
#[derive(Debug, Clone, Copy)]
pub struct PlateauScene<'a> {
    /// The raster.
    pub columns: &'a Columns,
    /// The raster as plateaus.
    pub plateaus: &'a Plateaus,
    /// The centers of its cells.
    pub grid: &'a ShadowGrid,
    /// The cells to decide, of the same shape.
    pub wanted: &'a BitGrid,
    /// A window that holds these cells, and all cells between them and the UAV.
    pub window: CellWindow,
    /// Vector instructions to use; the result is the same at all levels.
    pub level: Level,
    /// Bands of rows that are processed in parallel in the current pool; the result is the same for
    /// any number.
    pub n_bands: usize,
}

impl PlateauScene<'_> {
    /// Makes a scene of some prisms over its grid.
    fn with_prisms<'a>(&'a self, prisms: &'a Prisms) -> ShadowScene<'a> {
        let PlateauScene { grid, wanted, level, n_bands, .. } = *self;
        ShadowScene { prisms, casters: prisms.casters(), grid, wanted, level, n_bands }
    }
}

/// Returns the wanted cells whose receivers are in line of sight of `uav`; every cell is equal to
/// [`columns_los`].
///
/// Neither the UAV nor a receiver may be below the lowest plateau (not checked).
///
/// Cost: the rows of the shadows of plateaus before the horizon. Each separate plateau that the
/// horizon does not decide adds the obstacles between it and the UAV. Each receiver whose own cell
/// is in the way adds a ray (see the module).
pub fn plateaus_los(scene: &PlateauScene<'_>, uav: LatticePoint, receivers: OnPlateaus) -> BitGrid {
    let view = &PlateauView::new(scene, uav, receivers);
    let plateaus = scene.plateaus;
    let height = |top: i32| match receivers {
        OnPlateaus::Level(z) => z,
        OnPlateaus::Above(above) => i64::from(top) + i64::from(above),
    };
    let at_level = |z: i64| scene.with_prisms(view.prisms_for(plateaus, z));
    let mut los = match receivers {
        OnPlateaus::Level(z) => shadow_los(&at_level(z), uav, z).los,
        OnPlateaus::Above(above) => {
            let Some(plane) = flat_plane_of(scene.grid, scene.wanted, uav) else { return scene.wanted.clone() };
            let mut on_ground = scene.wanted.in_rows(plane.rows.0..plane.rows.1);
            plateaus.apart().iter().for_each(|plateau| clear_plateau(&mut on_ground, plateau, plane.rows));
            let z = height(plateaus.ground());
            let mut los = shadow_los_among(&at_level(z), on_ground, uav, z);
            on_plateaus_apart(scene, view, (&plane, above), &mut los);
            los
        }
    };
    ask_columns(scene, uav, &height, &mut los);
    los
}

/// A UAV's view of a raster of plateaus.
#[derive(Debug)]
struct PlateauView {
    uav: LatticePoint,
    /// The prisms of the window that may hide a receiver below the UAV; `None` for all prisms of
    /// the raster.
    before_horizon: Option<Prisms>,
    /// The horizon's result for the receivers on each separate plateau; empty if they are at one
    /// level.
    apart: Vec<Sight>,
}

impl PlateauView {
    fn new(scene: &PlateauScene<'_>, uav: LatticePoint, receivers: OnPlateaus) -> Self {
        let PlateauScene { plateaus, window, .. } = *scene;
        let nothing_known = PlateauView { uav, before_horizon: None, apart: Vec::new() };
        let (apart, above) = match receivers {
            OnPlateaus::Level(z) if z >= uav.z => return nothing_known,
            OnPlateaus::Level(_) => (&[][..], 0),
            OnPlateaus::Above(above) => (plateaus.apart(), above),
        };
        let overlaps =
            |(first, end): (u32, u32), from: usize, n: usize| (first as usize) < from + n && end as usize > from;
        let is_in_window = |plateau: &Plateau| {
            overlaps(plateau.rows, window.row, window.n_rows) && overlaps(plateau.cols, window.col, window.n_cols)
        };
        let raised: Vec<&Plateau> = plateaus.raised().iter().filter(|plateau| is_in_window(plateau)).collect();
        let receivers_on = |plateau: &Plateau| (plateaus.ring(plateau), i64::from(plateau.top) + i64::from(above));
        // The remaining prisms cast their shadows later, once they are joined.
        let sorted = sort_by_horizon(
            (uav, 0.0),
            uav.z,
            raised.iter().map(|plateau| (plateaus.ring(plateau), (plateau.top, plateau.top))),
            apart.iter().filter(|plateau| is_in_window(plateau)).map(receivers_on),
        );
        let (mut prisms, mut groups) = (sorted.prisms.iter(), sorted.groups.iter());
        let before_horizon = (raised.len() < plateaus.raised().len() || sorted.prisms.iter().any(Option::is_none))
            .then(|| plateaus.prisms_of(|plateau| is_in_window(plateau) && prisms.next().is_some_and(Option::is_some)));
        let sight = |plateau: &Plateau| if is_in_window(plateau) { groups.next().copied() } else { None };
        let apart = apart.iter().map(sight).map(|sight| sight.unwrap_or(Sight::Some)).collect();
        PlateauView { before_horizon, apart, ..nothing_known }
    }

    /// Returns the prisms that may hide receivers at a height.
    fn prisms_for<'a>(&'a self, plateaus: &'a Plateaus, z: i64) -> &'a Prisms {
        self.before_horizon.as_ref().filter(|_| z < self.uav.z).unwrap_or_else(|| plateaus.prisms())
    }
}

/// Decides by the columns the receivers whose own cell is in the way among prisms, but exempt among
/// columns.
fn ask_columns(scene: &PlateauScene<'_>, uav: LatticePoint, height: &(impl Fn(i32) -> i64 + Sync), los: &mut BitGrid) {
    let of_plateau = |plateau: &Plateau| -> Vec<(usize, usize, LatticePoint)> {
        let (z, top) = (height(plateau.top), i64::from(plateau.top));
        let is_inside = top > z;
        let mut asked = Vec::new();
        if !is_inside && (z <= uav.z || top <= uav.z) {
            return asked;
        }
        for row in plateau.rows.0 as usize..plateau.rows.1 as usize {
            let words = scene.wanted.row(row);
            for_each_bit(words, plateau.cols.0 as usize, plateau.cols.1 as usize, |col| {
                let receiver = LatticePoint { x: scene.grid.xs[col], y: scene.grid.ys[row], z };
                let length = (uav.x - receiver.x).abs().max((uav.y - receiver.y).abs());
                // EXACT: heights differ by at most 2^28, positions by at most 2^27.
                if is_inside || (z - uav.z) * HALF_CELL > (z - top) * length {
                    asked.push((row, col, receiver));
                }
            });
        }
        asked
    };
    let asked: Vec<_> = scene.plateaus.raised().par_iter().flat_map_iter(of_plateau).collect();
    let is_los = |(_, _, receiver): &(usize, usize, LatticePoint)| columns_los(scene.columns, uav, *receiver);
    let answers: Vec<bool> = asked.par_iter().map(is_los).collect();
    asked.iter().zip(answers).for_each(|((row, col, _), is_los)| los.set(*row, *col, is_los));
}

/// Adds the receivers on separate plateaus that are in line of sight.
fn on_plateaus_apart(scene: &PlateauScene<'_>, view: &PlateauView, (plane, above): (&Plane, i32), los: &mut BitGrid) {
    let words_per_row = los.words_per_row();
    let (first, end) = plane.rows;
    let rows_per_band = (end - first).div_ceil(scene.n_bands.max(1) * BANDS_PER_THREAD);
    let words = &mut los.words_mut()[first * words_per_row..end * words_per_row];
    let bands = words.par_chunks_mut((rows_per_band * words_per_row).max(1)).enumerate();
    bands.for_each(|(k, words)| {
        let rows = (first + k * rows_per_band, first + k * rows_per_band + words.len() / words_per_row);
        let job = BandApart { scene, view, above, rows };
        dispatch!(scene.level, simd => job.cast(simd, plane.clone(), words));
    });
}

/// The receivers on separate plateaus in some rows.
struct BandApart<'a> {
    scene: &'a PlateauScene<'a>,
    view: &'a PlateauView,
    above: i32,
    rows: (usize, usize),
}

impl BandApart<'_> {
    /// Adds the receivers in line of sight to the words of the rows.
    #[inline(always)]
    fn cast<S: Simd>(&self, simd: S, mut plane: Plane, words: &mut [u64]) {
        let words_per_row = self.scene.wanted.words_per_row();
        let mut cells = PlateauCells::default();
        let mut outline = Outline::default();
        let mut visits = Visits::default();
        for (plateau, sight) in self.scene.plateaus.apart().iter().zip(&self.view.apart) {
            let narrow = |(first, end): (u32, u32)| (first as usize, end as usize);
            let ((first, end), cols) = (narrow(plateau.rows), narrow(plateau.cols));
            if first >= self.rows.1 {
                break;
            }
            let rows = (first.max(self.rows.0), end.min(self.rows.1));
            if *sight == Sight::None || rows.0 >= rows.1 || !cells.fill(self.scene.wanted, rows, cols) {
                continue;
            }
            if *sight == Sight::Some {
                plane.narrow_to(self.scene.grid, rows, cols);
                let z = i64::from(plateau.top) + i64::from(self.above);
                self.hide(simd, &plane, z, &mut cells, (&mut outline, &mut visits));
            }
            for (row, cells) in (rows.0..rows.1).zip(cells.words.chunks_exact(cells.words_per_row)) {
                let from = (row - self.rows.0) * words_per_row + cols.0 / 64;
                words[from..][..cells.len()].iter_mut().zip(cells).for_each(|(word, cells)| *word |= cells);
            }
        }
    }

    /// Keeps the cells of a plateau, with receivers at height `z`, that are in line of sight.
    #[inline(always)]
    fn hide<S: Simd>(
        &self,
        simd: S,
        plane: &Plane,
        z: i64,
        cells: &mut PlateauCells,
        (outline, visits): (&mut Outline, &mut Visits),
    ) {
        let (grid, uav) = (self.scene.grid, self.view.uav);
        let prisms = self.view.prisms_for(self.scene.plateaus, z);
        let (rows, cols) = (plane.rows, plane.cols);
        let bounds = [grid.xs[cols.0], grid.ys[rows.1 - 1], grid.xs[cols.1 - 1], grid.ys[rows.0]];
        visits.begin(prisms);
        let walk = Between::new(uav, bounds, z).visit(prisms, visits, |piece| {
            let ring = prisms.ring(piece);
            let ([west, south], [east, north]) = (ring[0], ring[2]);
            match Reach::new(uav.z, piece.top, z) {
                Some(reach) if outline.cast(plane, ring, [west, south, east, north], reach) => {
                    cells.hide(simd, plane, outline)
                }
                _ => ControlFlow::Continue(()),
            }
        });
        if walk.is_continue() {
            cells.settle((prisms, grid), uav, z);
        }
    }
}

/// The cells of a plateau that are not yet hidden.
#[derive(Debug, Default)]
struct PlateauCells {
    /// Row by row, from the word of its first column to that of its last.
    words: Vec<u64>,
    words_per_row: usize,
    first_word: usize,
    rows: (usize, usize),
    /// Rows, and columns of them, on the boundary of some shadow, or so near that rounding matters.
    doubts: Vec<(usize, (u64, u64))>,
}

impl PlateauCells {
    /// Makes these the wanted cells of some rows and columns; returns `false` if there are none.
    #[inline(always)]
    fn fill(&mut self, wanted: &BitGrid, rows: (usize, usize), cols: (usize, usize)) -> bool {
        let (first, end) = (cols.0 / 64, cols.1.div_ceil(64));
        (self.first_word, self.words_per_row, self.rows) = (first, end - first, rows);
        self.words.clear();
        self.doubts.clear();
        for row in rows.0..rows.1 {
            let words = wanted.row(row)[first..end].iter().zip(first..end);
            self.words.extend(words.map(|(cells, word)| cells & bits_between(cols.0, cols.1, word)));
        }
        self.words.iter().any(|word| *word != 0)
    }

    /// Clears the cells inside an outline; breaks if none remains.
    #[inline(always)]
    fn hide<S: Simd>(&mut self, simd: S, plane: &Plane, outline: &Outline) -> ControlFlow<()> {
        let Rows { maybe, sure } = outline.rows(plane);
        if maybe.0 >= maybe.1 || outline.columns_between(plane, maybe.0, maybe.1 - 1).is_none() {
            return ControlFlow::Continue(());
        }
        for row in (maybe.0..maybe.1).step_by(LANES) {
            let n = (maybe.1 - row).min(LANES);
            let spans = spans(simd, plane, outline, row);
            let words = &mut self.words[(row - self.rows.0) * self.words_per_row..][..n * self.words_per_row];
            if spans.is_all_sure && row >= sure.0 && row + n <= sure.1 {
                for word in 0..self.words_per_row {
                    // PERF: eight masks at once.
                    let base = (self.first_word + word) as u64 * 64;
                    let kept: [u64; LANES] =
                        std::array::from_fn(|k| bits_outside(spans.sure.0[k], spans.sure.1[k], base));
                    for (cells, kept) in words.chunks_exact_mut(self.words_per_row).zip(&kept) {
                        cells[word] &= kept;
                    }
                }
                continue;
            }
            let maybe = maybe_spans(simd, plane, outline, row);
            let origin = self.first_word as u64 * 64;
            for (k, words) in words.chunks_exact_mut(self.words_per_row).enumerate() {
                let is_sure_row = row + k >= sure.0 && row + k < sure.1;
                let (from, to) = (maybe.0[k], maybe.1[k]);
                let (first, end) = match (spans.sure.0[k], spans.sure.1[k]) {
                    (first, end) if is_sure_row && first < end => (first, end),
                    _ => (to, to),
                };
                if first < end {
                    clear(words, first - origin, end - origin);
                }
                self.doubts.extend([(row + k, (from, first)), (row + k, (end, to))].iter().filter(|d| d.1.0 < d.1.1));
            }
        }
        match self.words.iter().all(|word| *word == 0) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    /// Decides by `ray` all doubts that are still open.
    fn settle(&mut self, (prisms, grid): (&Prisms, &ShadowGrid), uav: LatticePoint, z: i64) {
        let mut ask = |row: usize, col: usize| {
            let word = &mut self.words[(row - self.rows.0) * self.words_per_row + col / 64 - self.first_word];
            let bit = 1 << (col % 64);
            let receiver = LatticePoint { x: grid.xs[col], y: grid.ys[row], z };
            if *word & bit != 0 && !prisms_los(prisms, uav, receiver) {
                *word &= !bit;
            }
        };
        for (row, (first, end)) in &self.doubts {
            for col in *first..*end {
                ask(*row, usize::try_from(col).unwrap_or(usize::MAX));
            }
        }
    }
}

/// Removes the cells of a plateau from a set that has cells only in rows `first..end`.
fn clear_plateau(cells: &mut BitGrid, plateau: &Plateau, (first, end): (usize, usize)) {
    let words_per_row = cells.words_per_row();
    for row in (plateau.rows.0 as usize).max(first)..(plateau.rows.1 as usize).min(end) {
        let words = &mut cells.words_mut()[row * words_per_row..][..words_per_row];
        clear(words, u64::from(plateau.cols.0), u64::from(plateau.cols.1));
    }
}
