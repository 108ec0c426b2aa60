//! Curve of P_LoS given by its points: measurements, or a model without a public formula.

use std::ops::RangeInclusive;

use super::card::{OutsideDomain, outside};

/// Variable of a [`UserCurve`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CurveAxis {
    /// Elevation angle \[deg\], column `theta_deg`.
    Theta,
    /// Ground distance \[m\], column `distance_m`.
    Distance,
}

impl CurveAxis {
    /// Returns the name of its column.
    pub fn column(self) -> &'static str {
        match self {
            CurveAxis::Theta => "theta_deg",
            CurveAxis::Distance => "distance_m",
        }
    }

    /// Returns the range of its values.
    pub fn range(self) -> RangeInclusive<f64> {
        match self {
            CurveAxis::Theta => 0.0..=90.0,
            CurveAxis::Distance => 0.0..=f64::MAX,
        }
    }
}

/// P_LoS over the elevation angle or the ground distance: linear between its rows, refused beyond.
#[derive(Debug, Clone, PartialEq)]
pub struct UserCurve {
    name: String,
    axis: CurveAxis,
    /// Rows (angle or distance, P_LoS), ascending, at least two.
    points: Vec<(f64, f64)>,
}

impl UserCurve {
    /// Makes a curve from its rows, in any order: elevation angle \[0 to 90 deg\] or ground
    /// distance \[m, ≥ 0\], and P_LoS.
    ///
    /// Returns `None` unless there are two rows or more, all in range, each angle or distance once.
    pub fn new(name: &str, axis: CurveAxis, mut points: Vec<(f64, f64)>) -> Option<Self> {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let is_good = |(at, p): &(f64, f64)| axis.range().contains(at) && (0.0..=1.0).contains(p);
        let are_apart = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let is_curve = points.len() >= 2 && points.iter().all(is_good) && are_apart;
        is_curve.then(|| UserCurve { name: name.to_string(), axis, points })
    }

    /// Returns the name of the curve.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the variable of the curve.
    pub fn axis(&self) -> CurveAxis {
        self.axis
    }

    /// Returns its rows: elevation angle \[deg\] or ground distance \[m\], ascending, and P_LoS.
    pub fn points(&self) -> &[(f64, f64)] {
        &self.points
    }

    /// Returns the first and last elevation angle \[deg\] or ground distance \[m\] of the curve.
    pub fn range(&self) -> (f64, f64) {
        (self.points[0].0, self.points[self.points.len() - 1].0)
    }

    /// Returns the value at the elevation angle \[deg\] or ground distance \[m\], by its axis.
    pub fn p_los(&self, theta_deg: f64, distance_m: f64) -> std::result::Result<f64, OutsideDomain> {
        let (at, what, unit) = match self.axis {
            CurveAxis::Theta => (theta_deg, "elevation angle", "°"),
            CurveAxis::Distance => (distance_m, "ground distance", " m"),
        };
        let (first, last) = self.range();
        if !(first..=last).contains(&at) {
            return outside(format!("the {what} is {at}{unit}, wanted {first}{unit} to {last}{unit}"));
        }
        // The first row beyond `at`, or the last row.
        let above = self.points.partition_point(|(x, _)| *x <= at).min(self.points.len() - 1);
        let ((x0, p0), (x1, p1)) = (self.points[above - 1], self.points[above]);
        let share = (at - x0) / (x1 - x0);
        Ok(p0 * (1.0 - share) + p1 * share)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::assert_near;
    use super::*;

    #[test]
    fn a_curve_is_linear_between_its_rows_and_refused_beyond() {
        let curve = UserCurve::new("c", CurveAxis::Theta, vec![(90.0, 1.0), (10.0, 0.2), (30.0, 0.4)]).unwrap();
        assert_eq!((curve.name(), curve.axis(), curve.range()), ("c", CurveAxis::Theta, (10.0, 90.0)));
        for (theta, p) in [(10.0, 0.2), (15.0, 0.25), (30.0, 0.4), (60.0, 0.7), (90.0, 1.0)] {
            assert_near(curve.p_los(theta, 0.0).unwrap(), p, 1e-15);
        }
        for theta in [9.99, 90.01, f64::NAN] {
            assert!(curve.p_los(theta, 0.0).unwrap_err().reason.contains("wanted 10° to 90°"));
        }
        let curve = UserCurve::new("c", CurveAxis::Distance, vec![(0.0, 1.0), (100.0, 0.5)]).unwrap();
        assert_near(curve.p_los(-5.0, 25.0).unwrap(), 0.875, 1e-15);
        assert!(curve.p_los(45.0, 101.0).unwrap_err().reason.contains("101 m, wanted 0 m to 100 m"));
    }

    #[test]
    fn what_is_no_curve_is_none() {
        for points in [
            vec![],
            vec![(1.0, 0.5)],
            vec![(1.0, 0.5), (1.0, 0.6)],
            vec![(1.0, 0.5), (91.0, 0.6)],
            vec![(1.0, 0.5), (2.0, 1.1)],
        ] {
            assert_eq!(UserCurve::new("c", CurveAxis::Theta, points), None);
        }
    }
}
