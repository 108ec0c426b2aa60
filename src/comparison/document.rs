//! The document and the table of placements side by side, as types.

use schemars::JsonSchema;
use serde::Serialize;

use super::facts::{GroupDifference, GroupShare, finite, grazing_share, reason_without_interval};
use crate::answer::{Head, PositionFields, Share, Timing, WarningFacts};
use crate::city_statistics::bootstrap::RatioEstimate;
use crate::coverage::MarginStats;
use crate::height_errors::{HeightErrorsDocument, HeightsOfDifference};
use crate::sight::SightFacts;

/// Placements side by side.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct CompareDocument {
    #[serde(flatten)]
    pub(super) head: Head,
    #[serde(flatten)]
    pub(super) sight: SightFacts,
    /// How far heights of buildings may be off, where that was told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) height_errors: Option<HeightErrorsDocument>,
    /// How intervals were made.
    pub(super) intervals: IntervalsDocument,
    /// Which placement is best, by how much, and whether that is clear.
    pub(super) verdict: String,
    /// The placements.
    pub(super) placements: Vec<PlacementDocument>,
    /// All pairs, the first always before the second.
    pub(super) pairs: Vec<PairDocument>,
    /// What at least one placement sees.
    pub(super) union: Share,
    /// Receivers of any placement that 0, 1, 2 … of them see.
    pub(super) seen_by: Vec<u64>,
    /// Receivers by the set of placements that see them; null for too many.
    pub(super) sets: Option<Vec<SetDocument>>,
    /// Seconds spent; not in what is stored in pictures and rasters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) timing_s: Option<Timing>,
    /// What was odd.
    pub(super) warnings: Vec<WarningFacts>,
    /// SHA-256 of columns, rows (u64, little endian) and each placement's mask, north row first.
    pub(super) digest: String,
}

/// How intervals were made.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct IntervalsDocument {
    /// block bootstrap.
    pub(super) method: &'static str,
    /// Confidence, such as 0.95.
    pub(super) confidence: f64,
    /// Edge of a block of ground [m].
    pub(super) block_m: f64,
    /// How often blocks were drawn.
    pub(super) resamplings: u64,
    /// Seed of the drawing.
    pub(super) seed: u64,
    /// What an interval says.
    pub(super) meaning: String,
}

/// What is said of the receivers of each zone.
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
    /// Height of the UAV above the ground [m]; null where none is known.
    pub(super) height_agl_m: Option<f64>,
    /// What the UAV hovers over; null for a saved mask.
    pub(super) placement: Option<&'static str>,
    #[serde(flatten)]
    pub(super) all: ShareDocument,
    /// By zone of the receivers; null where none is known.
    pub(super) zones: Option<ByZone<ShareDocument>>,
    /// Margins of a sample of receivers; null for a saved mask.
    pub(super) margins: Option<MarginsDocument>,
    /// Why there are no margins.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) margins_reason: Option<&'static str>,
}

/// An interval and what is behind it.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(super) struct IntervalDocument {
    /// Lower end of the interval.
    pub(super) ci_low: Option<f64>,
    /// Upper end of the interval.
    pub(super) ci_high: Option<f64>,
    /// Blocks with receivers.
    pub(super) blocks: u64,
    /// Why the value, or its interval, is missing.
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
    /// Those in line of sight.
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
    /// Every how manyth receiver in row order was asked.
    pub(super) every: usize,
    /// How near to grazing a receiver counts as such [m].
    pub(super) grazing_within_m: f32,
    #[serde(flatten)]
    pub(super) all: MarginDocument,
    /// By zone of the receivers; null where none is known.
    pub(super) zones: Option<ByZone<MarginDocument>>,
}

/// Margins of some receivers.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub(super) struct MarginDocument {
    /// Receivers that were asked.
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
    /// Share of the receivers in line of sight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) grazing_share: Option<f64>,
    /// Why something is missing.
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

/// Two placements compared.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct PairDocument {
    /// Name of the first.
    pub(super) first: String,
    /// Name of the second.
    pub(super) second: String,
    #[serde(flatten)]
    pub(super) all: DifferenceDocument,
    /// By zone of the receivers; null where none is known.
    pub(super) zones: Option<ByZone<DifferenceDocument>>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub(super) heights: Option<HeightsOfDifference>,
}

/// Two placements compared on some receivers.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct DifferenceDocument {
    /// Receivers of both.
    pub(super) compared: u64,
    /// Those that both see.
    pub(super) both: u64,
    /// Those that only the first sees.
    pub(super) only_first: u64,
    /// Those that only the second sees.
    pub(super) only_second: u64,
    /// Those that neither sees.
    pub(super) neither: u64,
    /// Receivers of the first that are none of the second.
    pub(super) receivers_of_first_only: u64,
    /// Receivers of the second that are none of the first.
    pub(super) receivers_of_second_only: u64,
    /// P_LoS of the second less that of the first, over the receivers of both.
    pub(super) difference: Option<f64>,
    #[serde(flatten)]
    pub(super) interval: IntervalDocument,
    /// Whether the interval does not hold 0; null without one.
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
    /// Bit k for placement k.
    pub(super) bits: usize,
    /// Their names.
    pub(super) seen_by_exactly: Vec<String>,
    /// Receivers.
    pub(super) receivers: u64,
}

/// A row of a comparison's table: a placement, or a pair of them.
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
    /// Receivers; of a pair those of both.
    pub(super) receivers: u64,
    /// Those in line of sight.
    pub(super) los: Option<u64>,
    /// Share of the receivers in line of sight.
    pub(super) p_los: Option<f64>,
    /// P_LoS of the second less that of the first, over the receivers of both.
    pub(super) difference: Option<f64>,
    /// Lower end of the interval of P_LoS, or of the difference.
    pub(super) ci_low: Option<f64>,
    /// Upper end of the same.
    pub(super) ci_high: Option<f64>,
    /// Whether the interval of a difference does not hold 0.
    pub(super) exceeds: Option<bool>,
    /// Lower end of the interval of the difference with heights redrawn, where they may be off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) heights_low: Option<f64>,
    /// Upper end of the same.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) heights_high: Option<f64>,
    /// Whether it does not hold 0.
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
    /// Receivers whose margins were asked for.
    pub(super) margin_receivers: Option<u64>,
    /// Height of the receivers above what they stand on [m].
    pub(super) rx_height_m: f64,
    /// Largest horizontal distance from the UAV [m]; empty without a limit.
    pub(super) radius_m: Option<f64>,
    /// What antennas serve, in words; empty if that is all.
    pub(super) antenna: Option<String>,
    /// Edge of a block of ground [m].
    pub(super) block_m: f64,
    /// Engine that decided line of sight.
    pub(super) method: String,
}
