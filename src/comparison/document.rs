//! Serialized forms of a comparison of placements: the document and the rows of its table.

use schemars::JsonSchema;
use serde::Serialize;

use super::facts::{GroupDifference, GroupShare, finite, grazing_share, reason_without_interval};
use crate::answer::{Head, PositionFields, Share, Timing, WarningFacts};
use crate::city_statistics::bootstrap::RatioEstimate;
use crate::coverage::MarginStats;
use crate::height_errors::{HeightErrorsDocument, HeightsOfDifference};
use crate::sight::SightFacts;

/// Comparison of placements.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct CompareDocument {
    #[serde(flatten)]
    pub(super) head: Head,
    #[serde(flatten)]
    pub(super) sight: SightFacts,
    /// Standard deviations of building height errors; absent without any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) height_errors: Option<HeightErrorsDocument>,
    /// Method of the intervals.
    pub(super) intervals: IntervalsDocument,
    /// Sentence on the best placement, its lead, and the clarity of that lead.
    pub(super) verdict: String,
    /// The placements.
    pub(super) placements: Vec<PlacementDocument>,
    /// All pairs, the first always before the second.
    pub(super) pairs: Vec<PairDocument>,
    /// Receivers that at least one placement sees.
    pub(super) union: Share,
    /// Receivers of any placement that 0, 1, 2 … of them see.
    pub(super) seen_by: Vec<u64>,
    /// Receivers by the set of placements that see them; null for too many placements.
    pub(super) sets: Option<Vec<SetDocument>>,
    /// Seconds spent; absent in the copies that pictures and rasters store.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) timing_s: Option<Timing>,
    /// Warnings.
    pub(super) warnings: Vec<WarningFacts>,
    /// SHA-256 of columns, rows (u64, little endian) and each placement's mask, north row first.
    pub(super) digest: String,
}

/// Method of the intervals.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct IntervalsDocument {
    /// block bootstrap.
    pub(super) method: &'static str,
    /// Confidence, such as 0.95.
    pub(super) confidence: f64,
    /// Edge of a block of ground [m].
    pub(super) block_m: f64,
    /// Number of resamplings.
    pub(super) resamplings: u64,
    /// Seed of the resampling.
    pub(super) seed: u64,
    /// Meaning of an interval.
    pub(super) meaning: String,
}

/// Values for the receivers of each zone.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ByZone<D> {
    pub(super) street: D,
    pub(super) crossroad: D,
    pub(super) courtyard: D,
    pub(super) rooftop: D,
}

/// A placement.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct PlacementDocument {
    /// Name.
    pub(super) id: String,
    /// File of a saved mask.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mask: Option<String>,
    #[serde(flatten)]
    pub(super) position: PositionFields,
    /// Height of the UAV above the datum [m]; null for a saved mask.
    pub(super) height_amsl_m: Option<f64>,
    /// Height of the UAV above the ground [m]; null where no ground is known.
    pub(super) height_agl_m: Option<f64>,
    /// Zone or surface below the UAV; null for a saved mask.
    pub(super) placement: Option<&'static str>,
    #[serde(flatten)]
    pub(super) all: ShareDocument,
    /// Values by zone of the receivers; null where no zone is known.
    pub(super) zones: Option<ByZone<ShareDocument>>,
    /// Margins of a sample of receivers; null for a saved mask.
    pub(super) margins: Option<MarginsDocument>,
    /// Reason for having no margins.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) margins_reason: Option<&'static str>,
}

/// An interval and its basis.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(super) struct IntervalDocument {
    /// Lower end of the interval.
    pub(super) ci_low: Option<f64>,
    /// Upper end of the interval.
    pub(super) ci_high: Option<f64>,
    /// Blocks with receivers.
    pub(super) blocks: u64,
    /// Reason for a missing value or interval.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reason: Option<String>,
}

impl IntervalDocument {
    pub(super) fn of(estimate: &RatioEstimate) -> Self {
        let reason = match (estimate.value, estimate.interval) {
            (None, _) if estimate.blocks == 0 => Some("no receiver".to_string()),
            (_, None) => Some(reason_without_interval(estimate)),
            _ => None,
        };
        let (ci_low, ci_high) = (estimate.interval.map(|i| i.0), estimate.interval.map(|i| i.1));
        IntervalDocument { ci_low, ci_high, blocks: estimate.blocks, reason }
    }
}

/// P_LoS of some receivers.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ShareDocument {
    /// Receivers.
    pub(super) receivers: u64,
    /// Receivers in line of sight.
    pub(super) los: u64,
    /// Share of the receivers in line of sight.
    #[serde(rename = "p_los")]
    pub(super) value: Option<f64>,
    #[serde(flatten)]
    pub(super) p_los: IntervalDocument,
}

impl ShareDocument {
    pub(super) fn of(group: &GroupShare) -> Self {
        let GroupShare { receivers, los, p_los } = group;
        ShareDocument { receivers: *receivers, los: *los, value: p_los.value, p_los: IntervalDocument::of(p_los) }
    }
}

/// Margins: receiver height less the least height in line of sight.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct MarginsDocument {
    /// Step between sampled receivers, in row order.
    pub(super) every: usize,
    /// Largest margin, in absolute value, that counts as near grazing [m].
    pub(super) grazing_within_m: f32,
    #[serde(flatten)]
    pub(super) all: MarginDocument,
    /// Values by zone of the receivers; null where no zone is known.
    pub(super) zones: Option<ByZone<MarginDocument>>,
}

/// Margins of some receivers.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub(super) struct MarginDocument {
    /// Sampled receivers.
    pub(super) receivers: u64,
    /// 5 % quantile [m]; null where no receiver height is enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) q05_m: Option<Option<f64>>,
    /// Median [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) median_m: Option<Option<f64>>,
    /// 95 % quantile [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) q95_m: Option<Option<f64>>,
    /// Receivers near grazing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) grazing: Option<u64>,
    /// Share of the sampled receivers near grazing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) grazing_share: Option<f64>,
    /// Reason for a missing value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reason: Option<&'static str>,
}

impl MarginDocument {
    pub(super) fn of(margins: &Option<MarginStats>) -> Self {
        let Some(margins) = margins else {
            return MarginDocument { reason: Some("no receiver"), ..MarginDocument::default() };
        };
        let [q05_m, median_m, q95_m] = margins.quantiles.map(|q| Some(finite(q)));
        let is_short = margins.quantiles.iter().any(|q| !q.is_finite());
        MarginDocument {
            receivers: margins.receivers,
            q05_m,
            median_m,
            q95_m,
            grazing: Some(margins.grazing),
            grazing_share: Some(grazing_share(margins)),
            reason: is_short.then_some("no receiver height is enough there"),
        }
    }
}

/// Comparison of two placements.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct PairDocument {
    /// Name of the first placement.
    pub(super) first: String,
    /// Name of the second placement.
    pub(super) second: String,
    #[serde(flatten)]
    pub(super) all: DifferenceDocument,
    /// Values by zone of the receivers; null where no zone is known.
    pub(super) zones: Option<ByZone<DifferenceDocument>>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub(super) heights: Option<HeightsOfDifference>,
}

/// Comparison of two placements on some receivers.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct DifferenceDocument {
    /// Receivers of both.
    pub(super) compared: u64,
    /// Receivers that both see.
    pub(super) both: u64,
    /// Receivers that only the first sees.
    pub(super) only_first: u64,
    /// Receivers that only the second sees.
    pub(super) only_second: u64,
    /// Receivers that neither sees.
    pub(super) neither: u64,
    /// Receivers of the first that are none of the second.
    pub(super) receivers_of_first_only: u64,
    /// Receivers of the second that are none of the first.
    pub(super) receivers_of_second_only: u64,
    /// P_LoS of the second less that of the first, over the receivers of both.
    pub(super) difference: Option<f64>,
    #[serde(flatten)]
    pub(super) interval: IntervalDocument,
    /// true if the interval excludes 0; null without one.
    pub(super) exceeds: Option<bool>,
}

impl DifferenceDocument {
    pub(super) fn of(group: &GroupDifference) -> Self {
        let GroupDifference { counts: c, difference } = group;
        DifferenceDocument {
            compared: c.compared(),
            both: c.both,
            only_first: c.only_first,
            only_second: c.only_second,
            neither: c.neither,
            receivers_of_first_only: c.receivers_of_first,
            receivers_of_second_only: c.receivers_of_second,
            difference: difference.value,
            interval: IntervalDocument::of(difference),
            exceeds: difference.exceeds(),
        }
    }
}

/// Receivers that exactly some placements see.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct SetDocument {
    /// Bits of the set: bit k for placement k.
    pub(super) bits: usize,
    /// Names of the placements.
    pub(super) seen_by_exactly: Vec<String>,
    /// Receivers.
    pub(super) receivers: u64,
}

/// A row of the table of a comparison: a placement, or a pair of them.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub(crate) struct CompareRow {
    /// placement or pair.
    pub(super) row: &'static str,
    /// Name of the placement, or of the first of a pair.
    pub(super) first: String,
    /// Name of the second of a pair.
    pub(super) second: String,
    /// Zone of the receivers, or all.
    pub(super) zone: &'static str,
    #[serde(flatten)]
    pub(super) position: PositionFields,
    /// Height of the UAV above the datum [m].
    pub(super) height_amsl_m: Option<f64>,
    /// Height of the UAV above the ground [m].
    pub(super) height_agl_m: Option<f64>,
    /// Receivers; for a pair the receivers of both.
    pub(super) receivers: u64,
    /// Receivers in line of sight.
    pub(super) los: Option<u64>,
    /// Share of the receivers in line of sight.
    pub(super) p_los: Option<f64>,
    /// P_LoS of the second less that of the first, over the receivers of both.
    pub(super) difference: Option<f64>,
    /// Lower end of the interval of P_LoS, or of the difference.
    pub(super) ci_low: Option<f64>,
    /// Upper end of the interval of P_LoS, or of the difference.
    pub(super) ci_high: Option<f64>,
    /// true if the interval of a difference excludes 0.
    pub(super) exceeds: Option<bool>,
    /// Lower end of the interval of the difference with heights redrawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) heights_low: Option<f64>,
    /// Upper end of the interval of the difference with heights redrawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) heights_high: Option<f64>,
    /// true if the interval with heights redrawn excludes 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) exceeds_heights: Option<bool>,
    /// Blocks with receivers.
    pub(super) blocks: u64,
    /// Receivers that both see.
    pub(super) both: Option<u64>,
    /// Receivers that only the first sees.
    pub(super) only_first: Option<u64>,
    /// Receivers that only the second sees.
    pub(super) only_second: Option<u64>,
    /// Receivers that neither sees.
    pub(super) neither: Option<u64>,
    /// Receivers of the first that are none of the second.
    pub(super) receivers_of_first_only: Option<u64>,
    /// Receivers of the second that are none of the first.
    pub(super) receivers_of_second_only: Option<u64>,
    /// 5 % quantile of the margins [m].
    pub(super) margin_q05_m: Option<f64>,
    /// Median of the margins [m].
    pub(super) margin_median_m: Option<f64>,
    /// 95 % quantile of the margins [m].
    pub(super) margin_q95_m: Option<f64>,
    /// Share of receivers within 1 m of grazing.
    pub(super) margin_grazing_share: Option<f64>,
    /// Receivers whose margins were computed.
    pub(super) margin_receivers: Option<u64>,
    /// Height of the receivers above the surface they stand on [m].
    pub(super) rx_height_m: f64,
    /// Largest horizontal distance from the UAV [m]; empty without a limit.
    pub(super) radius_m: Option<f64>,
    /// Limits of the antenna, in words; empty without limits.
    pub(super) antenna: Option<String>,
    /// Edge of a block of ground [m].
    pub(super) block_m: f64,
    /// Engine that decided line of sight.
    pub(super) method: String,
}
