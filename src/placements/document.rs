//! The document, the table and the points of a search: where to hover.

use schemars::JsonSchema;
use serde::Serialize;

use crate::answer::{Head, PositionFields, Timing, WarningFacts};
use crate::height_errors::{HeightErrorsDocument, HeightsOfDifference};
use crate::sight::SightFacts;

/// Where to hover.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SearchDocument<'a> {
    #[serde(flatten)]
    pub(super) head: Head,
    #[serde(flatten)]
    pub(super) sight: SightFacts,
    /// How far heights of buildings may be off, where that was told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) height_errors: Option<HeightErrorsDocument>,
    /// What shares are shares of.
    pub(super) share_of: &'static str,
    /// What is made large.
    pub(super) goal: &'a str,
    /// The candidates.
    pub(super) candidates: CandidatesDocument<'a>,
    #[serde(flatten)]
    pub(super) found: Option<FoundDocument>,
    /// Seconds spent; not in what is stored in pictures and rasters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) timing_s: Option<Timing>,
    /// What was odd.
    pub(super) warnings: Vec<WarningFacts>,
    /// SHA-256 of the values of the ranked places.
    pub(super) digest: &'a str,
}

/// Candidates of a search.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct CandidatesDocument<'a> {
    /// Distance between their places [m]; null for places of a file.
    pub(super) step_m: Option<f64>,
    /// Heights that were tried; empty where each place has its own.
    pub(super) heights: &'a [String],
    /// Least height above roof or ground directly below [m].
    pub(super) clearance_m: f64,
    /// Candidates that were asked for.
    pub(super) asked: u64,
    /// Those that were tried.
    pub(super) tried: u64,
    /// Those that were left out.
    pub(super) skipped: SkippedDocument,
}

/// Candidates that were left out.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct SkippedDocument {
    /// Over ground without data.
    pub(super) no_data: u64,
    /// Outside of the area.
    pub(super) outside: u64,
    /// Over another zone.
    pub(super) other_zone: u64,
    /// Inside of an area to keep out of.
    pub(super) keep_out: u64,
    /// Without the ground or roof that the height is above.
    pub(super) no_base: u64,
    /// Inside of a building or below the ground.
    pub(super) inside: u64,
    /// Too near to roof or ground.
    pub(super) clearance: u64,
}

/// What a search found.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct FoundDocument {
    /// The best place; null without one.
    pub(super) winner: Option<PlaceDocument>,
    /// Why there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reason: Option<String>,
    /// Where a search between the candidates ended.
    pub(super) refined: Option<PlaceDocument>,
    /// The best places.
    pub(super) ranked: Vec<PlaceDocument>,
    /// Several UAVs together.
    pub(super) several: Option<SeveralDocument>,
}

/// A place.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub(super) struct PlaceDocument {
    /// Rank from 1, or number in the order of choice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) rank: Option<usize>,
    /// Name, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) id: Option<String>,
    #[serde(flatten)]
    pub(super) position: PositionFields,
    /// Height above the datum [m].
    pub(super) height_amsl_m: f64,
    /// Height above the ground [m]; null where none is known.
    pub(super) height_agl_m: Option<f64>,
    /// What is below: a zone, or ground or rooftop where zones are not known.
    pub(super) placement: &'static str,
    /// Receivers of the goal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) receivers: Option<u64>,
    /// Those in line of sight.
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
    /// Bound on that margin, of a place that is not among the best [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) margin_upper_bound_m: Option<Option<f32>>,
    /// Why a value is missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reason: Option<&'static str>,
    /// Places that the search tried.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) tried: Option<u64>,
    /// What a chosen place adds to those before it, as a share of all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) gain: Option<Option<f64>>,
    /// What the chosen places so far cover, as a share of all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) covered: Option<Option<f64>>,
}

/// Several UAVs together; shares are of all wanted receivers, at any distance.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct SeveralDocument {
    /// How many were asked for.
    pub(super) count: usize,
    /// The choice, in its order.
    pub(super) chosen: Vec<PlaceDocument>,
    /// What they cover.
    pub(super) p_los: Option<f64>,
    /// What no choice of as many candidates exceeds.
    pub(super) bound: Option<f64>,
    /// How far the choice may be below the best, as a share of the bound.
    pub(super) gap: Option<f64>,
    /// Why there is no share.
    pub(super) reason: Option<&'static str>,
}

/// A row of a search's table.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PlaceRow {
    /// chosen (one of several UAVs), candidate, or refined (where a search between candidates ended).
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
    /// What is below: a zone, or ground or rooftop where zones are not known.
    pub(super) placement: &'static str,
    /// Receivers of the goal.
    pub(super) receivers: Option<u64>,
    /// Those in line of sight.
    pub(super) los: Option<u64>,
    /// Share of the receivers in line of sight, by weight where receivers have weights.
    pub(super) p_los: Option<f64>,
    /// Lower end of the interval of P_LoS less that of the best with heights redrawn, where they may be off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) heights_low: Option<f64>,
    /// Upper end of the same.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) heights_high: Option<f64>,
    /// Whether it does not hold 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) exceeds_heights: Option<bool>,
    /// Margin of the worst receiver [m].
    pub(super) margin_m: Option<f64>,
    /// Bound on that margin, of a place that is not among the best [m].
    pub(super) margin_upper_bound_m: Option<f64>,
    /// What a chosen place adds to those before it, as a share of all.
    pub(super) gain: Option<f64>,
    /// What the chosen places so far cover, as a share of all.
    pub(super) covered: Option<f64>,
}
