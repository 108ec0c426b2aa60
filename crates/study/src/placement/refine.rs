//! Search between the candidates: from the winner in ever smaller steps.

use super::candidates::candidate;
use super::{Candidate, CandidateRules, Spot};
use crate::coverage::Uav;
use crate::error::Result;
use crate::height_field::HeightField;

/// Result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Refined<S> {
    /// Best place of the search.
    pub candidate: Candidate,
    /// Score of that place.
    pub score: S,
    /// Number of places tried.
    pub tried: u64,
}

/// Runs a compass search at constant height. It moves to the best of the four places a step to the
/// north, east, south and west while that is better, then halves the step. Steps go from half of
/// `step` down to `least` \[CRS units\]. Places outside the scene or against the rules are left
/// out. The search climbs, so it may end short of the best place of all.
///
/// `better(uav, best)` returns the score of a UAV if that is better than the best so far.
pub fn refined<S>(
    field: &HeightField,
    rules: &CandidateRules<'_>,
    (start, score): (&Candidate, S),
    (step, least): (f64, f64),
    better: impl Fn(&Uav, &S) -> Option<S>,
) -> Result<Refined<S>> {
    let grid = field.grid();
    let mut best = Refined { candidate: start.clone(), score, tried: 0 };
    let mut reach = step / 2.0;
    while reach >= least {
        let from = best.candidate.spot;
        let mut improved = false;
        for (dx, dy) in [(0.0, reach), (reach, 0.0), (0.0, -reach), (-reach, 0.0)] {
            let spot = Spot { x: from.x + dx, y: from.y + dy, ..from };
            let is_inside =
                spot.x > grid.x_min() && spot.x < grid.x_max() && spot.y > grid.y_min() && spot.y < grid.y_max();
            if !is_inside {
                continue;
            }
            let Ok(candidate) = candidate(&spot, field, rules)? else { continue };
            best.tried += 1;
            if let Some(score) = better(&candidate.uav, &best.score) {
                (best.candidate, best.score, improved) = (candidate, score, true);
            }
        }
        if !improved {
            reach /= 2.0;
        }
    }
    Ok(best)
}
