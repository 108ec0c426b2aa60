//! A search between the candidates: from the winner in ever smaller steps.

use super::candidates::candidate;
use super::{Candidate, CandidateRules, Score, Scorer, Spot};
use crate::error::Result;
use crate::height_field::HeightField;

/// Where a search ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Refined {
    /// The best place that it saw.
    pub candidate: Candidate,
    /// Its score.
    pub score: Score,
    /// Number of places that it tried.
    pub tried: u64,
}

/// A compass search at constant height: the best of the four places a step to the north, east, south and west as long as
/// that is better, then half the step, from `step` down to `least` \[CRS units\]. Places outside the scene or against the
/// rules are left out. It climbs, so it may end short of the best place of all.
///
/// # Errors
/// As [`super::Candidates::of`].
pub fn refined(
    scorer: &Scorer<'_>,
    field: &HeightField,
    rules: &CandidateRules<'_>,
    (start, score): (&Candidate, Score),
    (step, least): (f64, f64),
) -> Result<Refined> {
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
            let score = scorer.score(&candidate.uav);
            best.tried += 1;
            if score.compare(&best.score).is_gt() {
                (best.candidate, best.score, improved) = (candidate, score, true);
            }
        }
        if !improved {
            reach /= 2.0;
        }
    }
    Ok(best)
}
