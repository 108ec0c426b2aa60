//! Change of P_LoS over many UAV positions when maps are simpler, compared position by position.

use crate::los_probability::estimate::{Count, FEWEST_CLUSTERS, student_quantile};

/// Measured difference of one value of P_LoS.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Paired {
    /// P_LoS of the simpler maps minus that of the exact ones, over the positions compared.
    pub difference: f64,
    /// Bound on the absolute difference over all positions.
    pub bound: f64,
}

/// Returns the difference of two ratios Σ los / Σ receivers, of simpler and of exact maps from the
/// same positions. The bound on its size fails with probability `risk` on either side.
///
/// `counts` are (simpler, exact) for each of the positions compared, which were drawn at random. If
/// `are_all`, they are all positions and nothing is uncertain. The bound is Student's over the
/// linearized differences of positions, as for a ratio of clusters. `None` if either map has no
/// receiver, or if too few positions have one.
pub fn paired_difference(counts: &[(Count, Count)], are_all: bool, risk: f64) -> Option<Paired> {
    let sum = |of: &dyn Fn(&(Count, Count)) -> u64| counts.iter().map(of).sum::<u64>() as f64;
    let (los, receivers) = (sum(&|c| c.0.los), sum(&|c| c.0.receivers));
    let (exact_los, exact_receivers) = (sum(&|c| c.1.los), sum(&|c| c.1.receivers));
    if receivers == 0.0 || exact_receivers == 0.0 {
        return None;
    }
    let (p_los, exact) = (los / receivers, exact_los / exact_receivers);
    let difference = p_los - exact;
    if are_all {
        return Some(Paired { difference, bound: difference.abs() });
    }
    let n = counts.iter().filter(|c| c.0.receivers + c.1.receivers > 0).count();
    if (n as u64) < FEWEST_CLUSTERS {
        return None;
    }
    let moved = |c: &(Count, Count)| {
        (c.0.los as f64 - p_los * c.0.receivers as f64) / receivers
            - (c.1.los as f64 - exact * c.1.receivers as f64) / exact_receivers
    };
    let n = n as f64;
    let variance = n / (n - 1.0) * counts.iter().map(|c| moved(c).powi(2)).sum::<f64>();
    let bound = difference.abs() + student_quantile(1.0 - 2.0 * risk, n - 1.0) * variance.sqrt();
    Some(Paired { difference, bound })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(los: u64, receivers: u64) -> Count {
        Count { receivers, los }
    }

    #[test]
    fn differences_are_of_sums_and_their_spread_is_over_positions() {
        // Exact: 1/2 everywhere; simpler: 1/2 from half of the positions, 3/4 from the others.
        let counts: Vec<(Count, Count)> =
            (0..20).map(|k| (count(if k % 2 == 0 { 2 } else { 3 }, 4), count(8, 16))).collect();
        let all = paired_difference(&counts, true, 0.01).expect("receivers");
        assert!((all.difference - 0.125).abs() < 1e-15 && (all.bound - 0.125).abs() < 1e-15);
        // Each position is ±1/8 off the mean of differences: the standard error is 1/8 / √19.
        let some = paired_difference(&counts, false, 0.005).expect("receivers");
        let reach = student_quantile(0.99, 19.0) * 0.125 / 19.0_f64.sqrt();
        assert!((some.bound - 0.125 - reach).abs() < 1e-12, "{some:?}");
        assert_eq!(paired_difference(&counts[..9], false, 0.005), None);
        assert_eq!(paired_difference(&[(count(0, 0), count(1, 2))], true, 0.01), None);
    }
}
