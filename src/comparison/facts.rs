//! Facts of placements and of their pairs.

use crate::answer::Position;
use crate::city_statistics::bootstrap::RatioEstimate;
use crate::coverage::{MarginStats, PairCounts, Tally};
use crate::height_errors::HeightsOfDifference;
use crate::los_probability::estimate::FEWEST_CLUSTERS;
use crate::map::SiteFacts;
use crate::quantity::counted;
use crate::zones::Zone;

/// Number of groups of receivers: all, and those of each zone in the order of [`Zone::ALL`].
pub(crate) const N_GROUPS: usize = 5;

/// Returns the words for the groups of receivers in tables.
pub(crate) fn group_names() -> [&'static str; N_GROUPS] {
    let [a, b, c, d] = Zone::ALL.map(Zone::name);
    ["all", a, b, c, d]
}

/// P_LoS of some receivers with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GroupShare {
    /// Receivers.
    pub(crate) receivers: u64,
    /// Receivers in line of sight.
    pub(crate) los: u64,
    /// Share of the receivers in line of sight.
    pub(crate) p_los: RatioEstimate,
}

/// Origin of a placement's mask.
#[derive(Debug, Clone)]
pub(crate) enum Origin {
    /// A UAV, mapped in this run.
    Uav(Box<SiteFacts>),
    /// A mask of an earlier run.
    File {
        /// Path of the file.
        path: String,
        /// Position of the UAV, if the file holds it.
        place: Option<Position>,
    },
}

/// Margins of a sample of a placement's receivers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MarginFacts {
    /// Step between sampled receivers, in row order.
    pub(crate) every: usize,
    /// Statistics by group; `None` for a group without a sampled receiver.
    pub(crate) groups: [Option<MarginStats>; N_GROUPS],
}

/// One placement in a report.
#[derive(Debug, Clone)]
pub(crate) struct PlacementFacts {
    /// Name, unique in a run.
    pub(crate) id: String,
    /// Origin of the mask.
    pub(crate) origin: Origin,
    /// Counts of the mask.
    pub(crate) tally: Tally,
    /// P_LoS by group.
    pub(crate) groups: [GroupShare; N_GROUPS],
    /// Margins; `None` for a saved mask.
    pub(crate) margins: Option<MarginFacts>,
}

impl PlacementFacts {
    /// Returns the position of the UAV, if it is known.
    pub(crate) fn position(&self) -> Option<Position> {
        match &self.origin {
            Origin::Uav(site) => Some(site.position()),
            Origin::File { place, .. } => *place,
        }
    }

    /// Returns the heights above the datum and above the ground \[m\], as far as they are known.
    pub(super) fn heights(&self) -> [Option<f64>; 2] {
        match &self.origin {
            Origin::Uav(site) => [Some(site.height_amsl_m), site.height_agl_m],
            Origin::File { .. } => [None; 2],
        }
    }
}

/// Comparison of two placements on some receivers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GroupDifference {
    /// Receivers, counted by which of the two placements sees them.
    pub(crate) counts: PairCounts,
    /// P_LoS of the second less that of the first, over the receivers of both.
    pub(crate) difference: RatioEstimate,
}

/// Comparison of two placements.
#[derive(Debug, Clone)]
pub(crate) struct PairFacts {
    /// Index of the first placement.
    pub(crate) first: usize,
    /// Index of the second placement.
    pub(crate) second: usize,
    /// Comparison by group.
    pub(crate) groups: [GroupDifference; N_GROUPS],
    /// Interval of the difference with heights redrawn; `None` without height errors.
    pub(crate) heights: Option<HeightsOfDifference>,
}

/// Settings of the intervals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct IntervalFacts {
    /// Confidence, such as 0.95.
    pub(crate) confidence: f64,
    /// Edge of a block of ground \[m\].
    pub(crate) block_m: f64,
    /// Seed of the resampling.
    pub(crate) seed: u64,
}

/// Returns the reason why a value has no interval.
pub(super) fn reason_without_interval(estimate: &RatioEstimate) -> String {
    match estimate.blocks {
        n if n > 0 && estimate.value.is_none() => "a UAV is over no data".to_string(),
        n if n < FEWEST_CLUSTERS => {
            format!("{} with receivers, wanted at least {FEWEST_CLUSTERS}", counted(n, "block", "blocks"))
        }
        _ => "too many resamplings hold no such receiver".to_string(),
    }
}

pub(super) fn finite(value: f32) -> Option<f64> {
    value.is_finite().then(|| f64::from(value))
}

pub(super) fn grazing_share(margins: &MarginStats) -> f64 {
    margins.grazing as f64 / margins.receivers as f64
}
