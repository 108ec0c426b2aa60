//! Fit of a statistical city to a real one: α, β, γ from its buildings, and the goodness of fit.

use crate::city::BuiltUp;
use crate::los_probability::product::rayleigh_cdf;

/// Estimated built-up parameters, with the heights that they describe.
#[derive(Debug, Clone, PartialEq)]
pub struct BuiltUpFit {
    /// α: share of the cells that are buildings; β: buildings per area; γ: maximum-likelihood scale
    /// of the heights, γ² = ΣH²/(2n).
    pub built_up: BuiltUp,
    /// Building heights \[m\], ascending.
    pub heights: Vec<f64>,
    /// Standard error of γ \[m\]: γ/(2√n).
    pub height_scale_error: f64,
    /// Kolmogorov–Smirnov distance: the largest difference between the shares of buildings below a
    /// height, in the city and by the Rayleigh distribution.
    pub distance: f64,
    /// Height of that largest difference \[m\].
    pub farthest_m: f64,
}

impl BuiltUpFit {
    /// Fits a city whose built-up share of `area_km2` is given; `None` without building or open
    /// ground.
    pub fn of(built_up_ratio: f64, mut heights: Vec<f64>, area_km2: f64) -> Option<Self> {
        heights.retain(|h| *h > 0.0);
        heights.sort_by(f64::total_cmp);
        let built_up = BuiltUp::estimated(built_up_ratio, &heights, area_km2)?;
        let n = heights.len() as f64;
        let (mut distance, mut farthest_m) = (0.0, 0.0);
        for (k, h) in heights.iter().enumerate() {
            let expected = rayleigh_cdf(*h, built_up.height_scale);
            // The share jumps at each height: it is compared on both sides.
            for share in [k as f64 / n, (k + 1) as f64 / n] {
                if (share - expected).abs() > distance {
                    (distance, farthest_m) = ((share - expected).abs(), *h);
                }
            }
        }
        let height_scale_error = built_up.height_scale / (2.0 * n.sqrt());
        Some(BuiltUpFit { built_up, heights, height_scale_error, distance, farthest_m })
    }

    /// Returns the share of buildings not higher than `h` \[m\].
    pub fn share_up_to(&self, h: f64) -> f64 {
        self.heights.partition_point(|x| *x <= h) as f64 / self.heights.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_generated_city_fits_and_one_of_equal_heights_does_not() {
        let urban = BuiltUp::named("urban").expect("a known name");
        let mut drawn = urban.heights(4);
        let heights: Vec<f64> = (0..2500).map(|k| drawn.meters(k / 50, k % 50)).collect();
        let fit = BuiltUpFit::of(0.3, heights, 5.0).expect("a city");
        assert!((fit.built_up.height_scale - 15.0).abs() < 4.0 * fit.height_scale_error);
        assert!((fit.built_up.buildings_per_km2 - 500.0).abs() < 1e-9);
        // 99 % of Kolmogorov's distances are below 1.63/√n.
        assert!(fit.distance < 1.63 / 50.0, "{}", fit.distance);
        assert!((fit.share_up_to(fit.heights[1249]) - 0.5).abs() < 1e-9);

        let alike = BuiltUpFit::of(0.3, vec![20.0; 100], 1.0).expect("a city");
        // γ = 20/√2, so that F(20) = 1 − 1/e.
        assert!((alike.distance - (1.0 - (-1.0_f64).exp())).abs() < 1e-9);
        assert_eq!(BuiltUpFit::of(0.3, vec![0.0], 1.0), None);
    }
}
