//! Least heights at which a UAV still sees a given share.

use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::{Candidate, Score, Scorer};
use crate::coverage::Control;
use crate::error::Result;

/// Result over one place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LeastHeight {
    /// Candidate: the lowest that reaches the share, else the highest of the place.
    pub candidate: usize,
    /// Its score.
    pub score: Score,
    /// `true` if it reaches the share.
    pub reaches: bool,
}

/// Finds for each place the lowest candidate that sees at least `share` (0 to 1) of the wanted
/// receivers. Places are in the order of their first candidates. Shares are compared as doubles, as
/// they are printed.
///
/// A link never becomes NLoS by raising the UAV, and range is horizontal if no antenna limits
/// elevations. Then the share over one place never falls with the height, and a binary search finds
/// it. Over other places every height is tried, from the lowest on.
pub fn least_heights(
    scorer: &Scorer<'_>,
    candidates: &[Candidate],
    share: f64,
    control: &Control,
) -> Result<Vec<LeastHeight>> {
    let n_places = candidates.iter().map(|c| c.spot.place + 1).max().unwrap_or(0);
    let mut of_place: Vec<Vec<usize>> = vec![Vec::new(); n_places];
    (0..candidates.len()).for_each(|k| of_place[candidates[k].spot.place].push(k));
    of_place.iter_mut().for_each(|place| place.sort_by_key(|k| candidates[*k].uav.station.z));
    of_place.retain(|place| !place.is_empty());
    of_place.sort_by_key(|place| place.iter().min().copied());
    let find = |place: &Vec<usize>| -> Result<LeastHeight> {
        let at = |k: usize| {
            let score = scorer.score(&candidates[place[k]].uav)?;
            let reaches = score.share().is_some_and(|p| p >= share);
            Result::Ok(LeastHeight { candidate: place[k], score, reaches })
        };
        let limits_heights = |k: &usize| candidates[*k].uav.antenna.limits_heights();
        if scorer.mapper.limits_heights() || place.iter().any(limits_heights) {
            for k in 0..place.len() - 1 {
                control.check()?;
                let tried = at(k)?;
                if tried.reaches {
                    return Ok(tried);
                }
            }
            return at(place.len() - 1);
        }
        // Invariant: all before `low` are too low; `found` is the lowest known to reach the share,
        // or the highest of all.
        let (mut low, mut high) = (0, place.len() - 1);
        let mut found = at(high)?;
        while found.reaches && low < high {
            control.check()?;
            let middle = low + (high - low) / 2;
            let tried = at(middle)?;
            if tried.reaches {
                (high, found) = (middle, tried);
            } else {
                low = middle + 1;
            }
        }
        Ok(found)
    };
    let counted = |place: &Vec<usize>| {
        let found = find(place)?;
        control.done.fetch_add(place.len() as u64, Ordering::Relaxed);
        Ok(found)
    };
    of_place.par_iter().map(counted).collect()
}
