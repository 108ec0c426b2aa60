//! Worst case of candidates: the least margin of their receivers.

use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::Candidate;
use crate::coverage::{Control, Mapper};
use crate::error::Result;

/// Least margin of a candidate, or a bound on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstMargin {
    /// Least margin over the wanted receivers in range \[m\], as in the layer `margin`; an upper
    /// bound of it if not `exact`. −∞ if no receiver height is enough.
    pub margin_m: f32,
    /// `true` if all receivers were checked.
    pub exact: bool,
}

/// Number of candidates between two updates of the bounds; a constant, so that results are, too.
const BATCH: usize = 8;

/// Finds the least margin of each candidate; `None` without a receiver in range. The `n_exact`
/// largest are exact, equal ones in the order of the candidates. Some of the rest are upper bounds,
/// none above the exact ones.
///
/// The worst receivers of one candidate are checked for all candidates, which bounds each from
/// above. The candidates with the highest bounds are checked for all receivers, until enough exact
/// values are as high as every remaining bound. So few candidates are decided in full.
///
/// Cost: some walks per candidate, and a walk to each receiver for those few.
pub fn worst_margins(
    mapper: &Mapper<'_>,
    candidates: &[Candidate],
    n_exact: usize,
    control: &Control,
) -> Result<Vec<Option<WorstMargin>>> {
    let unknown = WorstMargin { margin_m: f32::INFINITY, exact: false };
    let mut found: Vec<Option<WorstMargin>> = vec![Some(unknown); candidates.len()];
    let mut known_hard: Vec<(usize, usize)> = Vec::new();
    loop {
        control.check()?;
        let order = ranked_margins(&found);
        let open: Vec<usize> =
            order.into_iter().take(n_exact).filter(|k| found[*k].is_some_and(|w| !w.exact)).take(BATCH).collect();
        if open.is_empty() {
            break;
        }
        let worst = |k: &usize| Ok(mapper.seen_from(&candidates[*k].uav)?.worst_margin(&known_hard));
        let worst: Vec<_> = open.par_iter().map(worst).collect::<Result<_>>()?;
        let mut new_hard = Vec::new();
        for (k, worst) in open.iter().zip(worst) {
            found[*k] = worst.map(|w| WorstMargin { margin_m: w.margin_m, exact: true });
            new_hard.extend(worst.map(|w| w.cell).filter(|cell| !known_hard.contains(cell)));
            control.done.fetch_add(1, Ordering::Relaxed);
        }
        new_hard.sort_unstable();
        new_hard.dedup();
        found.par_iter_mut().zip(candidates).try_for_each(|(found, candidate)| -> Result<()> {
            if let Some(bound) = found.as_mut().filter(|w| !w.exact) {
                let least = mapper.seen_from(&candidate.uav)?.least_margin_among(&new_hard);
                bound.margin_m = least.map_or(bound.margin_m, |m| m.min(bound.margin_m));
            }
            Ok(())
        })?;
        known_hard.extend(new_hard);
    }
    Ok(found)
}

/// Returns the indices of margins and bounds, the highest first, equal ones in the order of the
/// candidates. Candidates without a receiver come last.
pub fn ranked_margins(found: &[Option<WorstMargin>]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..found.len()).collect();
    order.sort_by(|a, b| match (found[*a], found[*b]) {
        (Some(a), Some(b)) => b.margin_m.total_cmp(&a.margin_m),
        (a, b) => b.is_some().cmp(&a.is_some()),
    });
    order
}
