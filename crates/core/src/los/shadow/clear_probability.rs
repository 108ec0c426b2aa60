//! The probability that receivers are in line of sight past buildings whose heights have
//! independent errors.
//!
//! **Method.** A ray that falls from the UAV to a receiver comes nearest to a roof where it leaves
//! the building, at the far edge. With the symbols of [`super`], let q be the receiver from the UAV
//! and Z its height below the UAV. The far edge is at the fraction t = K/(E × q) of the way, the
//! least of all far edges (and 1 over the footprint). The building may be higher by
//! `h_U − Z·t − H`. Of several pieces of a building the least counts.
//!
//! The error of each building is normal, so the link is clear with the product of Φ(room/σ) over
//! the buildings. As with shadows the factors are computed building by building, over the shadow
//! that it casts with six standard deviations added. Outside of it, the factor is 1.
//!
//! An error that all buildings share makes their factors dependent. Given its value they are
//! independent again, so the product is found for values at even steps and weighted. The integrand
//! is smooth over `w = 1/√(1/τ² + n/σ²)` for n buildings, the shared deviation τ and the least own
//! deviation σ. With steps of w the trapezoidal rule is good to exp(−2π²), some 10⁻⁹.
//!
//! **Exactness.** Rooms err by some 10⁻⁹ steps, Φ by 3·10⁻⁷. A shared error beyond four and a half
//! deviations is left out, which is 7·10⁻⁶. No value is given for receivers on the side of a cone
//! or at a wall, where pieces of two buildings may hide them only together. Nor is one given for a
//! receiver right below the UAV.

use std::sync::OnceLock;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};
use rayon::prelude::*;

use super::super::height_errors::{
    CERTAIN, HeightErrors, MOST_BUILDINGS, MOST_VALUES, SHARED_CERTAIN, TABLE_STEPS, TIE,
};
use super::geometry::{as_f64, cross, sub};
use super::outline::Outline;
use super::plane::Plane;
use super::reach::{LANES, Reach};
use super::scene::{Receivers, ShadowScene, cells_at_uav};
use super::spans::{Lanes, as_column, doubtful, maybe_spans, spans};
use super::words::{bits_outside, for_each_bit};
use crate::dispatch;
use crate::height_field::Piece;
use crate::overlay::bounds_of;
use crate::quantity::LatticePoint;
use crate::raster::BitGrid;

/// Largest count of numbers that a band holds for all values of a shared error (4 MB), unless eight
/// rows need more.
const BAND: usize = 1 << 20;

/// Probabilities of the cells of a grid.
#[derive(Debug, Clone)]
pub struct ClearProbabilities {
    /// Row by row, 1 if nothing is in the way; NaN if no value is given.
    p: Vec<f64>,
    per_row: usize,
    first_row: usize,
}

impl ClearProbabilities {
    /// Returns the probability of a wanted cell; `None` if no value is given.
    #[inline]
    pub fn of(&self, row: usize, col: usize) -> Option<f64> {
        let p = self.p[(row - self.first_row) * self.per_row + col];
        (!p.is_nan()).then_some(p)
    }
}

/// Returns the probability that each wanted cell is in line of sight of `uav`.
///
/// The function `own` returns the standard deviation of a building's own height error, 0 or more.
/// The deviation `shared` is that of an error of all buildings. The function `height(row, col)`
/// returns the height of the receiver \[1/1024 m\].
///
/// Cost: the wanted cells in the shadows of buildings that are six standard deviations higher, for
/// each value of a shared error.
///
/// Returns `None` in these cases:
///
/// * A receiver is not below the UAV.
/// * There are sloped roofs, or the earth is curved.
/// * A shared error has very many values, because a building has hardly any error of its own.
pub fn shadow_clear_probabilities(
    scene: &ShadowScene<'_>,
    uav: LatticePoint,
    height: &(impl Fn(usize, usize) -> i32 + Sync),
    errors: &HeightErrors,
) -> Option<ClearProbabilities> {
    let (relief, (lowest, highest)) = Receivers::relief(scene.wanted, height);
    let per_row = scene.wanted.words_per_row() * 64;
    let Some(plane) = scene.plane(scene.wanted, uav) else {
        return Some(ClearProbabilities { p: Vec::new(), per_row, first_row: 0 });
    };
    if i64::from(highest) >= uav.z || scene.prisms.are_sloped() || scene.prisms.earth().is_some() {
        return None;
    }
    let receivers = if lowest == highest { Receivers::Level(lowest.into()) } else { relief };
    let n_cols = scene.wanted.n_cols();
    let (first, end) = plane.rows;
    let mut p = vec![1.0; (end - first) * per_row];
    let east = (0..per_row).map(|col| as_f64(scene.grid.xs[col.min(n_cols - 1)] - uav.x)).collect();
    let buildings: Vec<&[Piece]> = scene.prisms.pieces().chunk_by(|a, b| a.building == b.building).collect();
    let least = buildings
        .iter()
        .filter_map(|b| b.first())
        .map(|piece| errors.own_steps(piece.building))
        .fold(f64::INFINITY, f64::min);
    let values = shared_values(errors.shared_steps(), least)?;
    let at_uav = cells_at_uav(scene.grid, &plane, scene.wanted);
    let rows_per_band = (BAND / (per_row * values.len()).max(1) / LANES).clamp(1, 16) * LANES;
    let lowest = lowest.into();
    let cast = Cast { scene, receivers, lowest, buildings, errors, values, east, per_row, at_uav };
    p.par_chunks_mut(rows_per_band * per_row).enumerate().for_each(|(k, p)| {
        let first = first + k * rows_per_band;
        let mut plane = plane.clone();
        plane.narrow_to(scene.grid, (first, first + p.len() / per_row), plane.cols);
        dispatch!(scene.level, simd => cast.band(simd, &plane, p));
    });
    Some(ClearProbabilities { p, per_row, first_row: first })
}

/// Returns values of a shared error with their weights; `None` if they are very many.
fn shared_values(shared: f64, least_own: f64) -> Option<Vec<(f64, f64)>> {
    if shared <= 0.0 {
        return Some(vec![(0.0, 1.0)]);
    }
    let smooth = 1.0 / (1.0 / (shared * shared) + MOST_BUILDINGS / (least_own * least_own)).sqrt();
    let n = (SHARED_CERTAIN * shared / smooth).ceil();
    if n.is_nan() || 2.0 * n > MOST_VALUES {
        return None;
    }
    let step = SHARED_CERTAIN * shared / n;
    #[expect(clippy::cast_possible_truncation, reason = "at most half of the most values")]
    let n = n as i32;
    let weight = |t: f64| libm::exp(-0.5 * (t / shared) * (t / shared));
    let all: f64 = (-n..=n).map(|k| weight(f64::from(k) * step)).sum();
    Some((-n..=n).map(|k| f64::from(k) * step).map(|t| (t, weight(t) / all)).collect())
}

/// The values that all buildings share.
struct Cast<'a> {
    scene: &'a ShadowScene<'a>,
    receivers: Receivers,
    lowest: i64,
    buildings: Vec<&'a [Piece]>,
    errors: &'a HeightErrors,
    /// Values of the shared error, each with its weight.
    values: Vec<(f64, f64)>,
    /// East of the UAV, by column and up to a whole word \[lattice steps\].
    east: Vec<f64>,
    per_row: usize,
    at_uav: Vec<(usize, usize)>,
}

/// A far edge: its step E, and K.
struct FarEdge {
    east: f64,
    north: f64,
    k: f64,
}

/// The state of a band during processing.
struct Band {
    /// Room of a building of several pieces at each cell; infinite if none of them is in the way.
    rooms: Vec<f64>,
    /// Rows and columns in which one of them is in the way.
    touched: Vec<(usize, (usize, usize))>,
    /// Cells without a value.
    unknown: BitGrid,
    far: Vec<FarEdge>,
}

impl Cast<'_> {
    #[inline(always)]
    fn band<S: Simd>(&self, simd: S, plane: &Plane, p: &mut [f64]) {
        let n_rows = plane.rows.1 - plane.rows.0;
        let mut band = Band {
            rooms: vec![f64::INFINITY; p.len()],
            touched: Vec::new(),
            unknown: BitGrid::new(n_rows, self.scene.wanted.n_cols()),
            far: Vec::new(),
        };
        let phi = normal_table();
        // The product for each value of the shared error, cell by cell.
        let n_values = self.values.len();
        let mut products = vec![1.0_f32; p.len() * n_values];
        let mut outline = Outline::default();
        for building in &self.buildings {
            let Some(first) = building.first() else { continue };
            let (own, shared) = (self.errors.own_steps(first.building), self.errors.shared_steps());
            let (per_step, certain) = (1.0 / own, CERTAIN * own + SHARED_CERTAIN * shared);
            #[expect(clippy::cast_possible_truncation, reason = "saturates")]
            let reach = (CERTAIN * (own + shared)).ceil() as i32;
            for piece in *building {
                let Some(of_piece) = Reach::new(plane.uav.z, piece.top.saturating_add(reach), self.lowest) else {
                    continue;
                };
                let ring = self.scene.prisms.ring(piece);
                if outline.cast(plane, ring, bounds_of(ring), of_piece) {
                    self.rooms_of(simd, plane, &outline, piece, &mut band);
                }
            }
            for (row, (from, to)) in band.touched.drain(..) {
                let at = (row - plane.rows.0) * self.per_row;
                for_each_bit(self.scene.wanted.row(row), from, to, |col| {
                    let room = std::mem::replace(&mut band.rooms[at + col], f64::INFINITY);
                    let products = &mut products[(at + col) * n_values..][..n_values];
                    if own > 0.0 {
                        if room >= certain {
                            return;
                        }
                        for (product, (value, _)) in products.iter_mut().zip(&self.values) {
                            #[expect(clippy::cast_possible_truncation, reason = "probabilities of seven digits")]
                            let factor = phi.at((room - value) * per_step) as f32;
                            *product *= factor;
                        }
                    } else if room.abs() < TIE {
                        band.unknown.insert(row - plane.rows.0, col);
                    } else if room < 0.0 {
                        products.fill(0.0);
                    }
                });
            }
        }
        for (p, products) in p.iter_mut().zip(products.chunks_exact(n_values)) {
            *p = products.iter().zip(&self.values).map(|(product, (_, weight))| f64::from(*product) * weight).sum();
        }
        for (row, col) in self.at_uav.iter().filter(|(row, _)| (plane.rows.0..plane.rows.1).contains(row)) {
            band.unknown.insert(row - plane.rows.0, *col);
        }
        for (row, col) in band.unknown.cells() {
            p[row * self.per_row + col] = f64::NAN;
        }
    }

    /// Lowers the rooms of the cells behind a piece.
    #[inline(always)]
    fn rooms_of<S: Simd>(&self, simd: S, plane: &Plane, outline: &Outline, piece: &Piece, band: &mut Band) {
        self.far_edges(plane, piece, &mut band.far);
        let rows = outline.rows(plane);
        for first in (rows.maybe.0..rows.maybe.1).step_by(LANES) {
            let n = (rows.maybe.1 - first).min(LANES);
            let spans = spans(simd, plane, outline, first);
            if !spans.is_all_sure || first < rows.sure.0 || first + n > rows.sure.1 {
                let maybe = maybe_spans(simd, plane, outline, first);
                self.doubt((&spans.sure, &maybe, rows.sure), (first, n), plane.rows.0, &mut band.unknown);
            }
            for k in 0..n {
                let row = first + k;
                let (from, to) = (as_column(spans.sure.0[k]), as_column(spans.sure.1[k]));
                if from >= to || row < rows.sure.0 || row >= rows.sure.1 {
                    continue;
                }
                band.touched.push((row, (from, to)));
                let wanted = self.scene.wanted.row(row);
                let rooms = &mut band.rooms[(row - plane.rows.0) * self.per_row..][..self.per_row];
                for (word, bits) in wanted.iter().enumerate().take(to.div_ceil(64)).skip(from / 64) {
                    let base = word * 64;
                    let inside = bits & !bits_outside(from as u64, to as u64, base as u64);
                    for group in 0..64 / LANES {
                        let bits = inside >> (group * LANES) & 0xFF;
                        if bits != 0 {
                            let col = base + group * LANES;
                            let found = self.rooms_at(simd, plane, (row, col), f64::from(piece.top), &band.far);
                            let known = &mut rooms[col..col + LANES];
                            for (lane, (known, found)) in known.iter_mut().zip(found).enumerate() {
                                let is_in = bits >> lane & 1 != 0;
                                *known = if is_in && found < *known { found } else { *known };
                            }
                        }
                    }
                }
            }
        }
    }

    /// Finds the far edges of a piece as the UAV sees it.
    #[inline(always)]
    fn far_edges(&self, plane: &Plane, piece: &Piece, far: &mut Vec<FarEdge>) {
        let ring = self.scene.prisms.ring(piece);
        let from_uav = |v: [i32; 2]| [i64::from(v[0]) - plane.uav.x, i64::from(v[1]) - plane.uav.y];
        far.clear();
        let mut a = from_uav(ring[ring.len() - 1]);
        for &vertex in ring {
            let b = from_uav(vertex);
            let edge = sub(b, a);
            let k = cross(edge, a);
            if k < 0 {
                far.push(FarEdge { east: as_f64(edge[0]), north: as_f64(edge[1]), k: as_f64(k) });
            }
            a = b;
        }
    }

    /// Returns how far a piece may rise for eight receivers of a row.
    #[inline(always)]
    fn rooms_at<S: Simd>(
        &self,
        simd: S,
        plane: &Plane,
        (row, col): (usize, usize),
        top: f64,
        far: &[FarEdge],
    ) -> [f64; LANES] {
        let splat = |v: f64| f64x8::splat(simd, v);
        let (east, north) = (f64x8::from_slice(simd, &self.east[col..col + LANES]), plane.q[row]);
        let mut t = splat(1.0);
        for edge in far {
            // Behind the edge both are negative; before it the quotient is above 1 or below 0.
            let cross = splat(edge.east * north) - splat(edge.north) * east;
            let part = splat(edge.k) / cross;
            t = cross.simd_lt(splat(edge.k)).select(t.min(part), t);
        }
        let uav_z = as_f64(plane.uav.z);
        let z = match &self.receivers {
            Receivers::Level(z) => splat(as_f64(*z)),
            Receivers::Relief { heights, width } => f64x8::from_slice(simd, &heights[row * width + col..][..LANES]),
        };
        (splat(uav_z - top) - (splat(uav_z) - z) * t).into()
    }

    /// Records the wanted cells of some rows that may be inside or outside of an outline.
    #[cold]
    #[inline(never)]
    fn doubt(
        &self,
        (inner, outer, sure): (&Lanes, &Lanes, (usize, usize)),
        (first, n): (usize, usize),
        first_row: usize,
        unknown: &mut BitGrid,
    ) {
        for (row, cols) in doubtful(inner, outer, sure, (first, n)) {
            for_each_bit(self.scene.wanted.row(row), cols.start, cols.end, |col| unknown.insert(row - first_row, col));
        }
    }
}

/// The distribution of a normal error, interpolated between values at even steps.
struct NormalTable(Vec<f64>);

fn normal_table() -> &'static NormalTable {
    static TABLE: OnceLock<NormalTable> = OnceLock::new();
    TABLE.get_or_init(|| {
        #[expect(clippy::cast_possible_truncation, reason = "a few thousand")]
        let n = (2.0 * CERTAIN * TABLE_STEPS) as i32;
        let x = |k: i32| f64::from(k) / TABLE_STEPS - CERTAIN;
        NormalTable((0..=n + 1).map(|k| 0.5 * libm::erfc(-x(k) * std::f64::consts::FRAC_1_SQRT_2)).collect())
    })
}

impl NormalTable {
    /// Returns the probability that an error is at most `x` standard deviations.
    #[inline(always)]
    fn at(&self, x: f64) -> f64 {
        if x >= CERTAIN {
            return 1.0;
        }
        if x <= -CERTAIN {
            return 0.0;
        }
        let place = (x + CERTAIN) * TABLE_STEPS;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the table")]
        let k = place as usize;
        let (low, high) = (self.0[k], self.0[k + 1]);
        low + (high - low) * (place - k as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_distribution() {
        let table = normal_table();
        for k in -7000..7000 {
            let x = f64::from(k) / 1000.3;
            let wanted = 0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2);
            assert!((table.at(x) - wanted).abs() < 3e-7, "{x}");
        }
    }
}
