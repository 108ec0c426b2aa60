//! Placement of UAVs: candidates, ranked, searched and bounded, and the average view from each kind
//! of place.
//!
//! A *candidate* is a place with a height. Candidates are tried lowest height first, and over each
//! height row by row from the north-west; that order breaks every tie. Each is decided by the exact
//! engines of [`crate::coverage`], so the best candidate found is the best of all candidates.
//! [`refined`] searches between the candidates. It reports its result and never replaces the
//! winner.
//!
//! * [`Candidates`]: the places and heights that can be flown, and the reasons against all others.
//! * [`Scorer`], [`scores`] and [`scores_over_grid`]: the share of the wanted receivers that each
//!   candidate sees, by number or by weight.
//! * [`least_heights`]: for each place the least height of a list that reaches a share.
//! * [`worst_margins`]: the least margin over all wanted receivers, largest if no receiver is far
//!   out of sight.
//! * [`SampledCounts`]: P_LoS by zone of the placement and of the receivers, from sampled
//!   placements.
//! * [`SeenSets`] and [`cover()`]: several UAVs that together see most, with an upper bound on any
//!   choice.
//!
//! Sums are integers (weights count multiples of a power of two), so threads change nothing.

mod candidates;
mod cover;
mod exact_cover;
mod least_height;
mod margin;
mod over_grid;
mod refine;
mod sampled;
mod score;
mod seen_sets;

pub use candidates::{Candidate, CandidateRules, Candidates, PlaceGrid, Skipped, Spot};
pub use cover::{Chosen, Cover, cover, greedy_cover};
pub use least_height::{LeastHeight, least_heights};
pub use margin::{WorstMargin, ranked_margins, worst_margins};
pub use over_grid::{scores_over_grid, scoring_s};
pub use refine::{Refined, refined};
pub use sampled::{
    Drawn, DrawnPlaces, MOST_CUT, ReceiverParts, SampledCounts, WholeDiscs, count_by_part, middles_of, over_cities,
};
pub use score::{Score, Scorer, Weights, ranked, scores};
pub use seen_sets::SeenSets;
