//! Pareto front of cost and error.

/// Returns the indices of the points (cost, error) that no other point dominates, by rising cost
/// and falling error.
///
/// A point dominates another if it is not worse in cost and error and better in one of them. Of
/// equal points the first counts. Points that are not finite are left out.
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|k| points[*k].0.is_finite() && points[*k].1.is_finite()).collect();
    order.sort_by(|a, b| points[*a].0.total_cmp(&points[*b].0).then(points[*a].1.total_cmp(&points[*b].1)));
    let mut least = f64::INFINITY;
    order.retain(|k| {
        let is_better = points[*k].1 < least;
        least = least.min(points[*k].1);
        is_better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_holds_what_nothing_beats() {
        // By hand: (1, 5) is cheapest; (2, 5) costs more and is no better; (3, 1) is better; (4, 2)
        // is beaten by it; (5, 0) errs least; its equal comes later.
        let points = [(4.0, 2.0), (1.0, 5.0), (5.0, 0.0), (3.0, 1.0), (2.0, 5.0), (5.0, 0.0), (f64::NAN, 0.0)];
        assert_eq!(pareto_front(&points), [1, 3, 2]);
        assert_eq!(pareto_front(&[(1.0, 2.0), (1.0, 1.0)]), [1]);
        assert_eq!(pareto_front(&[]), [0_usize; 0]);
    }
}
