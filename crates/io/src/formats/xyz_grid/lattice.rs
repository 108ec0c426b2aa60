//! Lattice of points that come in any order.
//!
//! Neighbours in a row or a column mostly follow one another, so the least distance between points
//! that follow one another is the size of a cell. Written positions are rounded: all distances below
//! one and a half times the least are taken for one cell, and their mean counts. The first and the
//! last position then give the size to the last digit. Each point is compared with the lattice while
//! the heights are read.

use super::irregular;
use crate::error::{Error, Result};
use crate::input::Input;
use crate::raster::GeoRef;

/// Largest distance of a point from the center of its cell \[cells\].
const MOST_OFF: f64 = 0.02;
/// Cells of a grid, for each of its points and in addition to those.
const MOST_CELLS: (f64, f64) = (256.0, 65_536.0);

/// Facts about the points of a file.
#[derive(Debug, Default)]
pub(super) struct Survey {
    axes: [Steps; 2],
    n_points: u64,
    is_from_south: bool,
}

/// Lattice on which points lie.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lattice {
    /// West to east, and south to north.
    axes: [Axis; 2],
}

/// Positions along a coordinate.
#[derive(Debug, Clone, Copy)]
struct Axis {
    first: f64,
    step: f64,
    n: usize,
}

impl Survey {
    /// Adds the point of a line.
    pub(super) fn add(&mut self, point: [f64; 2], line: u64) {
        self.is_from_south |= self.n_points > 0 && point[1] > self.axes[1].last;
        for (steps, v) in self.axes.iter_mut().zip(point) {
            steps.add(v, line);
        }
        self.n_points += 1;
    }

    pub(super) fn n_points(&self) -> u64 {
        self.n_points
    }

    /// Returns `true` if no point lies north of the one before it.
    pub(super) fn is_from_north(&self) -> bool {
        !self.is_from_south
    }

    /// Returns the lattice of the points.
    ///
    /// # Errors
    /// E303 for a file without points; E307 for a single point, and for points so irregular that
    /// their grid would have far more cells than points.
    pub(super) fn lattice(&self, input: &Input) -> Result<Lattice> {
        if self.n_points == 0 {
            return Err(Error::truncated(input, "it holds no point, wanted lines of x, y and z"));
        }
        let [x, y] = &self.axes;
        let Some(either) = x.step().or(y.step()) else {
            let what = format!("all its points lie at {}, {}, wanted those of a grid", x.least, y.least);
            return Err(irregular(input, what, x.line));
        };
        // A single row or column has square cells.
        let sides = [x.axis(x.step().unwrap_or(either)), y.axis(y.step().unwrap_or(either))];
        let n_cells: f64 = sides.iter().map(|(_, n)| n).product();
        #[expect(clippy::cast_precision_loss, reason = "a bound")]
        let most = MOST_CELLS.0 * self.n_points as f64 + MOST_CELLS.1;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 1, at most the bound")]
        let axis = |steps: &Steps, (step, n): (f64, f64)| Axis { first: steps.least, step, n: n as usize };
        let lattice = Lattice { axes: [axis(x, sides[0]), axis(y, sides[1])] };
        // NaN is no number of cells.
        if n_cells <= most { Ok(lattice) } else { Err(self.crowded(input, sides)) }
    }

    /// Returns the error of points that are too few for their grid.
    fn crowded(&self, input: &Input, [(_, n_cols), (_, n_rows)]: [(f64, f64); 2]) -> Error {
        let [x, y] = &self.axes;
        let (name, steps) = if n_cols >= n_rows { ("x", x) } else { ("y", y) };
        let what = format!(
            "its {name} is {} from that of the point before, and {name} reaches from {} to {}, so that the {} points \
             would lie in {n_cols} columns x {n_rows} rows; wanted points on a regular grid",
            steps.shortest, steps.least, steps.most, self.n_points
        );
        irregular(input, what, steps.line)
    }

    /// Returns the error of points on a lattice that is no grid.
    pub(super) fn irregular(&self, input: &Input, lattice: &Lattice) -> Error {
        let [x, y] = lattice.axes;
        let what = format!(
            "{} columns x {} rows of {} x {} at {}, {} are no grid",
            x.n, y.n, x.step, y.step, x.first, y.first
        );
        irregular(input, what, self.axes[0].line)
    }
}

/// Distances along a coordinate between points that follow one another.
#[derive(Debug)]
struct Steps {
    last: f64,
    /// Least and greatest position.
    least: f64,
    most: f64,
    /// Shortest distance, and its line.
    shortest: f64,
    line: u64,
    /// Sum and number of distances of about that length.
    sum: f64,
    n: u64,
}

impl Default for Steps {
    fn default() -> Self {
        let (least, most) = (f64::INFINITY, f64::NEG_INFINITY);
        Steps { last: f64::NAN, least, most, shortest: f64::INFINITY, line: 1, sum: 0.0, n: 0 }
    }
}

impl Steps {
    #[inline]
    fn add(&mut self, v: f64, line: u64) {
        self.least = self.least.min(v);
        self.most = self.most.max(v);
        let step = (v - self.last).abs();
        // Four units in the last place are rounding. Of the first point the distance is NaN.
        if step > 4.0 * f64::EPSILON * v.abs().max(self.last.abs()) && step < 1.5 * self.shortest {
            if 1.5 * step < self.shortest {
                (self.sum, self.n) = (0.0, 0);
            }
            if step < self.shortest {
                (self.shortest, self.line) = (step, line);
            }
            self.sum += step;
            self.n += 1;
        }
        self.last = v;
    }

    /// Returns the mean distance of neighbours; `None` where all positions are the same.
    #[expect(clippy::cast_precision_loss, reason = "lines of a file are far fewer than 2^53")]
    fn step(&self) -> Option<f64> {
        (self.n > 0).then(|| self.sum / self.n as f64)
    }

    /// Returns the size of a cell, and the number of cells that neighbours at about `step` need.
    fn axis(&self, step: f64) -> (f64, f64) {
        let n_steps = ((self.most - self.least) / step).round();
        if n_steps == 0.0 {
            return (step, 1.0);
        }
        let exact = (self.most - self.least) / n_steps;
        // The shortest number that no point tells from it is the one that was meant.
        let rounded = (0..9).map(|n| (exact * f64::powi(10.0, n)).round() / f64::powi(10.0, n));
        let is_like = |step: &f64| *step > 0.0 && (step - exact).abs() * n_steps < 1e-6 * exact;
        (rounded.into_iter().find(is_like).unwrap_or(exact), n_steps + 1.0)
    }
}

impl Lattice {
    /// Returns row and column of a point; the error says how far it lies off.
    #[inline]
    pub(super) fn cell(&self, point: [f64; 2]) -> std::result::Result<(usize, usize), String> {
        let [x, y] = self.axes;
        match (x.index(point[0]), y.index(point[1])) {
            (Some(col), Some(south)) => Ok((y.n - 1 - south, col)),
            _ => Err(format!(
                "the point {}, {} is on no lattice of {} x {} through {}, {}",
                point[0], point[1], x.step, y.step, x.first, y.first
            )),
        }
    }

    /// Returns the grid whose cells have the points in their middle.
    pub(super) fn georef(&self) -> Option<GeoRef> {
        let [x, y] = self.axes;
        let north = y.first + y.step * (y.n as f64 - 1.0);
        let corner = (x.first - 0.5 * x.step, north + 0.5 * y.step);
        GeoRef::new(corner, (x.step, y.step), (y.n, x.n), None)
    }
}

impl Axis {
    #[inline]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "compared with the number of cells")]
    fn index(&self, v: f64) -> Option<usize> {
        let at = (v - self.first) / self.step;
        let index = at.round();
        ((at - index).abs() <= MOST_OFF && index >= 0.0 && index < self.n as f64).then_some(index as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the lattice of points in an order, or the error in words.
    fn lattice(points: &[[f64; 2]]) -> std::result::Result<Lattice, String> {
        let mut survey = Survey::default();
        (1..).zip(points).for_each(|(line, point)| survey.add(*point, line));
        survey.lattice(&"g.xyz".into()).map_err(|e| e.to_string())
    }

    #[test]
    fn rounded_positions_of_thirds_are_a_grid_of_thirds() {
        let at = |k: u32| (f64::from(k) / 3.0 * 1000.0).round() / 1000.0;
        let points: Vec<[f64; 2]> = (0..40).flat_map(|y| (0..3000).map(move |x| [at(x), at(y)])).collect();
        let lattice = lattice(&points).expect("a grid");
        assert_eq!((lattice.axes[0].n, lattice.axes[1].n), (3000, 40));
        assert!((lattice.axes[0].step - 1.0 / 3.0).abs() < 1e-6, "{lattice:?}");
        assert!(points.iter().all(|point| lattice.cell(*point).is_ok()));
    }

    #[test]
    fn decimal_steps_stay_decimal() {
        let points: Vec<[f64; 2]> = (0..120).map(|k| [690_000.05 + f64::from(k) * 0.1, 5_335_000.05]).collect();
        let lattice = lattice(&points).expect("a grid");
        assert_eq!((lattice.axes[0].step, lattice.axes[0].n, lattice.axes[1].n), (0.1, 120, 1));
    }

    #[test]
    fn what_is_no_grid_is_refused() {
        let spiral: Vec<[f64; 2]> = (0..500).map(f64::from).map(|t| [t * t.cos() * 1e3, t * t.sin() * 1e3]).collect();
        assert!(lattice(&spiral).is_err_and(|e| e.contains("regular grid")));
        assert!(lattice(&[[1e300, 0.0], [0.0, 1.0], [1.0, 1.0]]).is_err_and(|e| e.contains("regular grid")));
        assert!(lattice(&[[-1e308, 0.0], [1e308, 1.0], [1.0, 1.0]]).is_err());
        assert!(lattice(&[[3.0, 4.0]]).is_err_and(|e| e.contains("all its points lie at 3, 4")));
        assert!(lattice(&[]).is_err_and(|e| e.contains("no point")));
    }
}
