//! The worst case: how far the worst receiver is below line of sight.

use std::collections::VecDeque;
use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::{Candidate, interrupted};
use crate::coverage::{Control, Mapper};
use crate::error::Result;

/// The least margin of a candidate, or a bound on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstMargin {
    /// The least margin over the wanted receivers in range \[m\], as the layer `margin` holds it; an upper bound of it if
    /// not `exact`. −∞ where no receiver height is enough.
    pub margin_m: f32,
    /// Whether all receivers were asked.
    pub exact: bool,
}

/// Candidates between two looks at what is known so far: the same on every machine, so that results are too.
const BATCH: usize = 64;
/// Receivers that were the worst for others, and are asked first.
const MOST_HARD: usize = 64;

/// The least margin of each candidate, `None` without a receiver in range. The `n_exact` largest are exact, equal ones
/// in the order of the candidates; of the others some are upper bounds, below all of those.
///
/// A candidate is given up once its running minimum is below the `n_exact`th best that is known. The receivers that were
/// worst for earlier candidates are asked first, so most candidates are given up after a few.
///
/// # Errors
/// Only [`crate::error::ErrorClass::Interrupted`], when `control.stop` was set.
pub fn worst_margins(
    mapper: &Mapper<'_>,
    candidates: &[Candidate],
    n_exact: usize,
    control: &Control,
) -> Result<Vec<Option<WorstMargin>>> {
    let mut found: Vec<Option<WorstMargin>> = Vec::with_capacity(candidates.len());
    let mut best: Vec<f32> = Vec::new();
    let mut hard: VecDeque<(usize, usize)> = VecDeque::new();
    for batch in candidates.chunks(BATCH) {
        if control.stop.load(Ordering::Relaxed) {
            return Err(interrupted());
        }
        let enough = best.get(n_exact.saturating_sub(1)).copied().unwrap_or(f32::NEG_INFINITY);
        let hard_now: Vec<(usize, usize)> = hard.iter().copied().collect();
        let worst: Vec<_> = batch.par_iter().map(|c| mapper.worst_margin(&c.uav, &hard_now, enough)).collect();
        for worst in worst {
            found.push(worst.map(|w| WorstMargin { margin_m: w.margin_m, exact: w.exact }));
            let Some(worst) = worst else { continue };
            if worst.exact {
                let at = best.partition_point(|m| *m >= worst.margin_m);
                best.insert(at, worst.margin_m);
                best.truncate(n_exact);
            }
            if !hard.contains(&worst.cell) {
                hard.push_front(worst.cell);
                hard.truncate(MOST_HARD);
            }
        }
        control.done.fetch_add(batch.len() as u64, Ordering::Relaxed);
    }
    Ok(found)
}
