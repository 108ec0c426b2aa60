//! What is found of placements and their pairs.

use crate::answer::Position;
use crate::city_statistics::bootstrap::RatioEstimate;
use crate::coverage::{MarginStats, PairCounts, Tally};
use crate::height_errors::HeightsOfDifference;
use crate::los_probability::estimate::FEWEST_CLUSTERS;
use crate::map::SiteFacts;
use crate::quantity::counted;
use crate::zones::Zone;

/// Groups of receivers: all, and those of each zone in the order of [`Zone::ALL`].
pub(crate) const N_GROUPS: usize = 5;

/// The words for the groups of receivers in tables.
pub(crate) fn group_names() -> [&'static str; N_GROUPS] {
    let [a, b, c, d] = Zone::ALL.map(Zone::name);
    ["all", a, b, c, d]
}

/// P_LoS of some receivers with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GroupShare {
    /// Receivers.
    pub(crate) receivers: u64,
    /// Those in line of sight.
    pub(crate) los: u64,
    /// Share of the receivers in line of sight.
    pub(crate) p_los: RatioEstimate,
}

/// Where a placement's mask comes from.
#[derive(Debug, Clone)]
pub(crate) enum Origin {
    /// A UAV, mapped in this run.
    Uav(Box<SiteFacts>),
    /// The mask of an earlier run.
    File {
        /// Its file.
        path: String,
        /// Where its UAV was, if the file says so.
        place: Option<Position>,
    },
}

/// Margins of a placement, from every so manyth receiver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MarginFacts {
    /// Every how manyth receiver in row order was asked.
    pub(crate) every: usize,
    /// By group; `None` where none of the sample is in it.
    pub(crate) groups: [Option<MarginStats>; N_GROUPS],
}

/// One placement as reported.
#[derive(Debug, Clone)]
pub(crate) struct PlacementFacts {
    /// Name, unique in a run.
    pub(crate) id: String,
    /// Where its mask comes from.
    pub(crate) origin: Origin,
    /// Counts of the mask.
    pub(crate) tally: Tally,
    /// By group.
    pub(crate) groups: [GroupShare; N_GROUPS],
    /// Margins; a mask alone has none.
    pub(crate) margins: Option<MarginFacts>,
}

impl PlacementFacts {
    /// Where its UAV is, if that is known.
    pub(crate) fn position(&self) -> Option<Position> {
        match &self.origin {
            Origin::Uav(site) => Some(site.position()),
            Origin::File { place, .. } => *place,
        }
    }

    /// Its heights above the datum and above the ground \[m\], as far as they are known.
    pub(super) fn heights(&self) -> [Option<f64>; 2] {
        match &self.origin {
            Origin::Uav(site) => [Some(site.height_amsl_m), site.height_agl_m],
            Origin::File { .. } => [None; 2],
        }
    }
}

/// Two placements compared on some receivers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GroupDifference {
    /// What either sees.
    pub(crate) counts: PairCounts,
    /// P_LoS of the second less that of the first, over the receivers of both.
    pub(crate) difference: RatioEstimate,
}

/// Two placements compared.
#[derive(Debug, Clone)]
pub(crate) struct PairFacts {
    /// The first, as an index of the placements.
    pub(crate) first: usize,
    /// The second.
    pub(crate) second: usize,
    /// By group.
    pub(crate) groups: [GroupDifference; N_GROUPS],
    /// What of the difference errors of heights explain, where heights may be off.
    pub(crate) heights: Option<HeightsOfDifference>,
}

/// How intervals were made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct IntervalFacts {
    /// Confidence, such as 0.95.
    pub(crate) confidence: f64,
    /// Edge of a block of ground \[m\].
    pub(crate) block_m: f64,
    /// Seed of the resampling.
    pub(crate) seed: u64,
}

/// Why a value has no interval.
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
