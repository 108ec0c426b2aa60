//! Positions of the receivers of `shadow`: the columns and rows of a grid on the lattice of the
//! prisms.

use super::geometry::as_f64;

/// The receivers' positions in the plane.
#[derive(Debug, Clone)]
pub struct ShadowGrid {
    pub(in super::super) xs: Vec<i64>,
    pub(in super::super) ys: Vec<i64>,
    /// Distance of neighboring columns and rows, on average \[lattice steps\].
    pub(super) steps: (f64, f64),
    /// Largest distance of a column from its place at the average spacing \[columns\].
    pub(super) unevenness: f64,
}

impl ShadowGrid {
    /// Makes a grid from the lattice positions of its columns, ascending, and of its rows,
    /// descending.
    pub fn new(xs: Vec<i64>, ys: Vec<i64>) -> Self {
        let spacing = |v: &[i64]| match (v.first(), v.last()) {
            (Some(a), Some(b)) if a != b => as_f64(b - a).abs() / as_f64(v.len() - 1),
            _ => 1.0,
        };
        let steps = (spacing(&xs), spacing(&ys));
        let deviation = |(col, x): (usize, &i64)| (as_f64(x - xs[0]) / steps.0 - as_f64(col)).abs();
        let unevenness = xs.iter().enumerate().map(deviation).fold(0.0, f64::max);
        // Positions are integers: if they are evenly spaced, so is the average, and nothing above
        // was rounded. Otherwise there were two roundings, each relative to at most the number of
        // columns.
        let rounding = 2.0 * f64::EPSILON * as_f64(xs.len());
        let unevenness = if unevenness > 0.0 { unevenness + rounding } else { 0.0 };
        ShadowGrid { xs, ys, steps, unevenness }
    }
}
