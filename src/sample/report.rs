//! P_LoS by zone of sampled placements as reported: the document `skyshed/sample/1` and its table.

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
    /// What the UAVs hover over.
    pub(crate) placement: Zone,
    /// Height of the UAVs above ground \[m\].
    pub(crate) height_m: f64,
    /// Where the receivers are; `None`: all of them.
    pub(crate) receivers: Option<Zone>,
    /// Placements that were mapped, in all cities together.
    pub(crate) n_placements: usize,
    /// Placements that were left out because they are inside a building at this height.
    pub(crate) n_inside: usize,
    /// Placements that were tried and left out because their disc is cut by the border of the data.
    pub(crate) n_cut: usize,
    /// P_LoS.
    pub(crate) estimate: Estimate,
}

impl SampledRow {
    /// The word for the receivers in tables.
    pub(crate) fn receivers_name(&self) -> &'static str {
        self.receivers.map_or("all", Zone::name)
    }

    /// Why there is no P_LoS, or no interval.
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

/// A study of sampled placements.
#[derive(Debug, Clone)]
pub(crate) struct SampledReport {
    pub(crate) facts: RunFacts,
    pub(crate) sight: SightPlan,
    /// Cities that were drawn; 1 for a city in a file.
    pub(crate) n_cities: u64,
    /// Whether placements are over the middles of the zones' parts.
    pub(crate) is_centered: bool,
    /// Edge of a block of ground \[m\].
    pub(crate) block_m: f64,
    /// Confidence of the intervals.
    pub(crate) confidence: f64,
    /// The values.
    pub(crate) rows: Vec<SampledRow>,
}

impl SampledReport {
    /// What is resampled, or is independent, behind the intervals.
    pub(crate) fn clusters(&self) -> &'static str {
        if self.n_cities > 1 { "cities" } else { "blocks of ground and placements" }
    }

    /// The document; without the rows it is stored in pictures and beside tables.
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

    /// The table: one row per placement zone, height and receivers.
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
    /// Cities that were drawn.
    cities: u64,
    /// Which discs are counted, where a radius is given.
    discs: Option<&'static str>,
    /// Where placements are in their zone.
    places: &'static str,
    /// What is behind the intervals.
    interval: IntervalFacts,
    /// The values; not in what is stored in pictures and beside tables.
    #[serde(skip_serializing_if = "Option::is_none")]
    rows: Option<Vec<SampleRow>>,
    /// What was odd.
    warnings: Vec<WarningFacts>,
}

/// What is behind intervals.
#[derive(Debug, Serialize, JsonSchema)]
struct IntervalFacts {
    /// Confidence, such as 0.95.
    confidence: f64,
    /// What is resampled, or is independent.
    clusters: &'static str,
    /// Edge of a block of ground [m].
    block_m: f64,
}

/// A row of a sample's table.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SampleRow {
    /// What the UAVs hover over.
    placement: &'static str,
    /// Height of the UAVs above ground [m].
    height_m: f64,
    /// Zone of the receivers, or all.
    receivers_zone: &'static str,
    /// Largest horizontal distance from the UAV [m]; empty without a limit.
    radius_m: Option<f64>,
    /// What antennas serve, in words; empty if that is all.
    antenna: Option<String>,
    /// Height of the receivers above what they stand on [m].
    rx_height_m: f64,
    /// Cities that were drawn.
    cities: u64,
    /// Placements that were mapped, in all cities together.
    placements: usize,
    /// Placements left out inside a building at this height.
    inside_building: usize,
    /// Share of receivers in line of sight.
    p_los: Option<f64>,
    /// Lower end of its interval.
    ci_low: Option<f64>,
    /// Upper end of its interval.
    ci_high: Option<f64>,
    /// Its standard error.
    std_error: Option<f64>,
    /// Receivers that were decided.
    samples: u64,
    /// Clusters behind the interval.
    clusters: u64,
    /// Why a value or its interval is missing.
    reason: Option<String>,
    /// Placements left out because their disc is cut by the border of the data.
    disc_cut: usize,
}
