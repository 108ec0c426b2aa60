//! Serialized forms of a placement search: the document, the rows of its table and its points.

use schemars::JsonSchema;
use serde::Serialize;

use crate::answer::{Head, PositionFields, Timing, WarningFacts};
use crate::height_errors::{HeightErrorsDocument, HeightsOfDifference};
use crate::sight::SightFacts;

/// Document of a placement search.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SearchDocument<'a> {
    #[serde(flatten)]
    pub(super) head: Head,
    #[serde(flatten)]
    pub(super) sight: SightFacts,
    /// Standard deviations of building height errors; absent without any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) height_errors: Option<HeightErrorsDocument>,
    /// Receivers that shares are relative to.
    pub(super) share_of: &'static str,
    /// Goal that the search maximizes or minimizes.
    pub(super) goal: &'a str,
    /// Candidates and the rules that they obey.
    pub(super) candidates: CandidatesDocument<'a>,
    #[serde(flatten)]
    pub(super) found: Option<FoundDocument>,
    /// Seconds spent; absent in the copies that pictures and rasters store.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) timing_s: Option<Timing>,
    /// Warnings.
    pub(super) warnings: Vec<WarningFacts>,
    /// SHA-256 of the values of the ranked places.
    pub(super) digest: &'a str,
}

/// Candidates of a search.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct CandidatesDocument<'a> {
    /// Distance between neighboring places [m]; null for places of a file.
    pub(super) step_m: Option<f64>,
    /// Heights that were tried; empty where each place has its own.
    pub(super) heights: &'a [String],
    /// Least height above roof or ground directly below [m].
    pub(super) clearance_m: f64,
    /// Candidates before any was left out.
    pub(super) asked: u64,
    /// Candidates that were tried.
    pub(super) tried: u64,
    /// Candidates that were left out, by reason.
    pub(super) skipped: SkippedDocument,
}

/// Numbers of candidates that were left out, by reason.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct SkippedDocument {
    /// Candidates over ground without data.
    pub(super) no_data: u64,
    /// Candidates outside the area.
    pub(super) outside: u64,
    /// Candidates over another zone.
    pub(super) other_zone: u64,
    /// Candidates inside a keep-out area.
    pub(super) keep_out: u64,
    /// Candidates without the ground or roof that their height refers to.
    pub(super) no_base: u64,
    /// Candidates inside a building or below the ground.
    pub(super) inside: u64,
    /// Candidates below the least clearance above roof or ground.
    pub(super) clearance: u64,
}

/// Results of a search.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct FoundDocument {
    /// Best place; null if there is none.
    pub(super) winner: Option<PlaceDocument>,
    /// Reason for having no best place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reason: Option<String>,
    /// End point of the local search that starts at the best candidate.
    pub(super) refined: Option<PlaceDocument>,
    /// Best places, in order.
    pub(super) ranked: Vec<PlaceDocument>,
    /// Choice of several UAVs together.
    pub(super) several: Option<SeveralDocument>,
}

/// A place.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub(super) struct PlaceDocument {
    /// Rank from 1, or number in the order of choice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) rank: Option<usize>,
    /// Name of the place; absent if it has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) id: Option<String>,
    #[serde(flatten)]
    pub(super) position: PositionFields,
    /// Height above the datum [m].
    pub(super) height_amsl_m: f64,
    /// Height above the ground [m]; null where no ground is known.
    pub(super) height_agl_m: Option<f64>,
    /// Zone below the UAV; ground or rooftop where zones are not known.
    pub(super) placement: &'static str,
    /// Receivers of the goal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) receivers: Option<u64>,
    /// Receivers in line of sight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) los: Option<u64>,
    /// Share of the receivers in line of sight, by weight where receivers have weights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) p_los: Option<Option<f64>>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub(super) heights: Option<HeightsOfDifference>,
    /// Margin of the worst receiver [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) margin_m: Option<Option<f32>>,
    /// Upper bound on the worst margin [m], for a place that is not among the best.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) margin_upper_bound_m: Option<Option<f32>>,
    /// Reason for a missing value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reason: Option<&'static str>,
    /// Places that the local search tried.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) tried: Option<u64>,
    /// Share of all wanted receivers that this place adds to the places chosen before it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) gain: Option<Option<f64>>,
    /// Share of all wanted receivers that the places chosen so far cover.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) covered: Option<Option<f64>>,
}

/// Several UAVs together; shares are of all wanted receivers, at any distance.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct SeveralDocument {
    /// Number of UAVs requested.
    pub(super) count: usize,
    /// Chosen places, in the order of choice.
    pub(super) chosen: Vec<PlaceDocument>,
    /// Share of all wanted receivers that the choice covers.
    pub(super) p_los: Option<f64>,
    /// Upper bound on the share that any choice of this many candidates covers.
    pub(super) bound: Option<f64>,
    /// Largest possible distance of the choice from the best one, as a share of the bound.
    pub(super) gap: Option<f64>,
    /// Reason for having no share.
    pub(super) reason: Option<&'static str>,
}

/// A row of the table of a search.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PlaceRow {
    /// chosen (one of several UAVs), candidate, or refined (end of the local search).
    pub(super) kind: &'static str,
    /// Rank from 1, or number in the order of choice.
    pub(super) rank: Option<usize>,
    /// Name, where places have names.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) id: Option<String>,
    #[serde(flatten)]
    pub(super) position: PositionFields,
    /// Height above the datum [m].
    pub(super) height_amsl_m: f64,
    /// Height above the ground [m].
    pub(super) height_agl_m: Option<f64>,
    /// Zone below the UAV; ground or rooftop where zones are not known.
    pub(super) placement: &'static str,
    /// Receivers of the goal.
    pub(super) receivers: Option<u64>,
    /// Receivers in line of sight.
    pub(super) los: Option<u64>,
    /// Share of the receivers in line of sight, by weight where receivers have weights.
    pub(super) p_los: Option<f64>,
    /// Lower end of the interval of P_LoS less that of the best place, with heights redrawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) heights_low: Option<f64>,
    /// Upper end of the interval of P_LoS less that of the best place, with heights redrawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) heights_high: Option<f64>,
    /// true if that interval excludes 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) exceeds_heights: Option<bool>,
    /// Margin of the worst receiver [m].
    pub(super) margin_m: Option<f64>,
    /// Upper bound on the worst margin [m], for a place that is not among the best.
    pub(super) margin_upper_bound_m: Option<f64>,
    /// Share of all wanted receivers that this place adds to the places chosen before it.
    pub(super) gain: Option<f64>,
    /// Share of all wanted receivers that the places chosen so far cover.
    pub(super) covered: Option<f64>,
}
