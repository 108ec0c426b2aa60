//! Report of a sample by zone: the document `skyshed/sample/1` and its table.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::answer::{Head, Rows, RunFacts, WarningFacts, document_of, rows, warnings_of};
use crate::los_probability::estimate::{Estimate, FEWEST_CLUSTERS};
use crate::sight::{SightFacts, SightPlan, antenna_words};
use crate::zones::Zone;

/// P_LoS of receivers in one zone from placements over another.
#[derive(Debug, Clone)]
pub(crate) struct SampledRow {
    /// Zone below the UAVs.
    pub(crate) placement: Zone,
    /// Height of the UAVs above ground \[m\].
    pub(crate) height_m: f64,
    /// Zone of the receivers; `None` for all receivers.
    pub(crate) receivers: Option<Zone>,
    /// Placements that were mapped, in all cities together.
    pub(crate) n_placements: usize,
    /// Placements left out because they are inside a building at this height.
    pub(crate) n_inside: usize,
    /// Placements left out because the border of the data cuts their disc, or because they have no
    /// ground.
    pub(crate) n_cut: usize,
    /// P_LoS.
    pub(crate) estimate: Estimate,
}

impl SampledRow {
    /// Returns the word for the receivers in tables.
    pub(crate) fn receivers_name(&self) -> &'static str {
        self.receivers.map_or("all", Zone::name)
    }

    /// Returns the reason for a missing P_LoS or interval.
    pub(crate) fn reason(&self) -> Option<String> {
        let zone = self.placement.name();
        match self.estimate {
            Estimate { p_los: None, .. } if self.n_placements == 0 && self.n_inside > 0 => {
                Some(format!("every sampled {zone} place is inside a building at this height"))
            }
            Estimate { p_los: None, .. } if self.n_placements == 0 && self.n_cut > 0 => {
                Some(format!("no {zone} place was found whose disc lies in the data"))
            }
            Estimate { p_los: None, .. } if self.n_placements == 0 => Some(format!("the scene has no {zone} place")),
            Estimate { p_los: None, .. } => Some("no receiver of the kind is in range".into()),
            Estimate { interval: None, .. } => Some(format!(
                "no interval: it needs at least {FEWEST_CLUSTERS} cities, or {FEWEST_CLUSTERS} placements and blocks of one"
            )),
            _ => None,
        }
    }
}

/// Report of sampled placements.
#[derive(Debug, Clone)]
pub(crate) struct SampledReport {
    pub(crate) facts: RunFacts,
    pub(crate) sight: SightPlan,
    /// Number of generated cities; 1 for a city in a file.
    pub(crate) n_cities: u64,
    /// `true` for placements over the middles of the zones' parts.
    pub(crate) is_centered: bool,
    /// Edge of a block of ground \[m\].
    pub(crate) block_m: f64,
    /// Confidence of the intervals.
    pub(crate) confidence: f64,
    /// The values.
    pub(crate) rows: Vec<SampledRow>,
}

impl SampledReport {
    /// Returns the name of the clusters that the intervals rest on, resampled or independent.
    pub(crate) fn clusters(&self) -> &'static str {
        if self.n_cities > 1 { "cities" } else { "blocks of ground and placements" }
    }

    /// Returns the document. Pictures, and the files beside tables, store it without rows.
    pub(crate) fn document(&self, with_rows: bool) -> Value {
        document_of(&SampleDocument {
            head: self.facts.head("skyshed/sample/1"),
            sight: self.sight.facts(),
            cities: self.n_cities,
            discs: self.sight.radius_m().map(|_| "whole: the disc of each placement lies in the data"),
            places: if self.is_centered { "centers" } else { "anywhere in the zone" },
            interval: IntervalFacts { confidence: self.confidence, clusters: self.clusters(), block_m: self.block_m },
            rows: with_rows.then(|| self.rows.iter().map(|row| self.row(row)).collect()),
            warnings: warnings_of(&self.facts.warnings),
        })
    }

    /// Returns the table: one row per placement zone, height and receivers.
    pub(crate) fn table(&self) -> Rows {
        rows(self.rows.iter().map(|row| self.row(row)))
    }

    fn row(&self, row: &SampledRow) -> SampleRow {
        let e = &row.estimate;
        SampleRow {
            placement: row.placement.name(),
            height_m: row.height_m,
            receivers_zone: row.receivers_name(),
            radius_m: self.sight.radius_m(),
            antenna: antenna_words(self.sight.antenna()),
            rx_height_m: self.sight.rx_height_m(),
            cities: self.n_cities,
            placements: row.n_placements,
            inside_building: row.n_inside,
            p_los: e.p_los,
            ci_low: e.interval.map(|i| i.0),
            ci_high: e.interval.map(|i| i.1),
            std_error: e.std_error,
            samples: e.samples,
            clusters: e.clusters,
            reason: row.reason(),
            disc_cut: row.n_cut,
        }
    }
}

/// P_LoS by zone of sampled placements.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SampleDocument {
    #[serde(flatten)]
    head: Head,
    #[serde(flatten)]
    sight: SightFacts,
    /// Number of cities.
    cities: u64,
    /// Discs that count, where a radius is given.
    discs: Option<&'static str>,
    /// Position of the placements in their zone.
    places: &'static str,
    /// Basis of the intervals.
    interval: IntervalFacts,
    /// The values; absent in the copies that pictures and tables store.
    #[serde(skip_serializing_if = "Option::is_none")]
    rows: Option<Vec<SampleRow>>,
    /// Warnings.
    warnings: Vec<WarningFacts>,
}

/// Basis of the intervals.
#[derive(Debug, Serialize, JsonSchema)]
struct IntervalFacts {
    /// Confidence, such as 0.95.
    confidence: f64,
    /// Clusters that are resampled or independent.
    clusters: &'static str,
    /// Edge of a block of ground [m].
    block_m: f64,
}

/// A row of the table of a sample.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SampleRow {
    /// Zone below the UAVs.
    placement: &'static str,
    /// Height of the UAVs above ground [m].
    height_m: f64,
    /// Zone of the receivers, or all.
    receivers_zone: &'static str,
    /// Largest horizontal distance from the UAV [m]; empty without a limit.
    radius_m: Option<f64>,
    /// Limits of the antenna, in words; empty without limits.
    antenna: Option<String>,
    /// Height of the receivers above the surface they stand on [m].
    rx_height_m: f64,
    /// Number of cities.
    cities: u64,
    /// Placements that were mapped, in all cities together.
    placements: usize,
    /// Placements left out inside a building at this height.
    inside_building: usize,
    /// Share of receivers in line of sight.
    p_los: Option<f64>,
    /// Lower end of the interval of that share.
    ci_low: Option<f64>,
    /// Upper end of the interval of that share.
    ci_high: Option<f64>,
    /// Standard error of that share.
    std_error: Option<f64>,
    /// Receivers that were decided.
    samples: u64,
    /// Clusters behind the interval.
    clusters: u64,
    /// Reason for a missing value or interval.
    reason: Option<String>,
    /// Placements left out because the border of the data cuts their disc, or without ground.
    disc_cut: usize,
}
