//! How low a UAV may hover and still see a given share.

use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::{Candidate, Score, Scorer};
use crate::coverage::Control;
use crate::error::Result;

/// What was found over one place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LeastHeight {
    /// The candidate: the lowest that reaches the share, else the highest of the place.
    pub candidate: usize,
    /// Its score.
    pub score: Score,
    /// Whether it reaches the share.
    pub reaches: bool,
}

/// For each place the lowest of its candidates that sees at least `share` (0 to 1) of the wanted receivers, by binary
/// search; places in the order of their first candidates.
///
/// A link never becomes NLoS by raising the UAV and range is horizontal, so over one place the share never falls with the
/// height, and the outcome is that of trying every height. Shares are compared as they are printed: as doubles.
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
    let find = |place: &Vec<usize>| {
        let at = |k: usize| {
            let score = scorer.score(&candidates[place[k]].uav)?;
            let reaches = score.share().is_some_and(|p| p >= share);
            Result::Ok(LeastHeight { candidate: place[k], score, reaches })
        };
        // Invariant: all before `low` are too low, and `found` is the highest not yet ruled out.
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
        control.done.fetch_add(place.len() as u64, Ordering::Relaxed);
        Ok(found)
    };
    of_place.par_iter().map(find).collect()
}
