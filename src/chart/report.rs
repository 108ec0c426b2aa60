//! Report of speed against accuracy: `skyshed/chart/1` of a scene, and its table.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::accuracy::chart::{Family, Truth};
use crate::accuracy::comparison::Comparison;
use crate::accuracy::front::pareto_front;
use crate::answer::{
    Head, Position, PositionFields, Rows, RunFacts, WarningFacts, digest_words, document_of, rows, warnings_of,
};
use crate::coverage::Uav;
use crate::digest::Sha256;
use crate::sight::{SightFacts, SightPlan};

/// Schema of charts.
pub(super) const CHART_SCHEMA: &str = "skyshed/chart/1";

/// Cost of a contestant on the machine of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cost {
    /// User CPU time of one run \[s\]; `None` where the system does not report it.
    pub(super) cpu_s: Option<f64>,
    /// Wall time of one run \[s\].
    pub(super) wall_s: f64,
    /// Peak of resident memory during the first run \[MB\]; `None` where the system does not report
    /// it.
    pub(super) peak_mb: Option<f64>,
    /// Runs that were timed.
    pub(super) runs: u32,
}

/// Cost of a contestant on the machine of the run.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub(super) struct CostDocument {
    /// User CPU time of one run over all UAVs, with the scene read and prepared before [s].
    cpu_s: Option<f64>,
    /// Wall time of one run [s].
    wall_s: Option<f64>,
    /// Largest resident set of the process during the first run [MB].
    peak_mb: Option<f64>,
    /// Runs that were timed.
    #[serde(skip_serializing_if = "Option::is_none")]
    runs: Option<u32>,
    /// Reason for missing CPU time.
    #[serde(skip_serializing_if = "Option::is_none")]
    cpu_reason: Option<&'static str>,
    /// Reason for a missing peak of memory.
    #[serde(skip_serializing_if = "Option::is_none")]
    peak_reason: Option<&'static str>,
}

/// Meaning of the numbers of a chart.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Meaning {
    /// Meaning of CPU time.
    cpu_s: &'static str,
    /// Meaning of wall time.
    wall_s: &'static str,
    /// Meaning of the peak of memory.
    peak_mb: &'static str,
    /// Meaning of runs.
    runs: &'static str,
}

pub(super) const MEANING: Meaning = Meaning {
    cpu_s: "user time of all threads for one run over all UAVs, the scene read and made ready; the median of groups of runs \
            after a warm-up, or the first run where it takes long; a peer is a whole process",
    wall_s: "time on the clock for the same",
    peak_mb: "largest resident set of the process meanwhile, the program and the scene included, with what the allocator \
              kept from before; of a peer its own",
    runs: "runs that were timed",
};

impl Cost {
    pub(super) fn document(&self) -> CostDocument {
        let cpu_reason = self.cpu_s.is_none().then_some("the system does not tell CPU time");
        let no_peak = "the system does not let a process count its peak memory anew";
        CostDocument {
            cpu_s: self.cpu_s,
            wall_s: Some(self.wall_s),
            peak_mb: self.peak_mb,
            runs: Some(self.runs),
            cpu_reason,
            peak_reason: self.peak_mb.is_none().then_some(no_peak),
        }
    }
}

/// Result of a contestant.
#[derive(Debug, Clone)]
pub(super) struct ChartRow {
    /// The engine as it is typed, or the program.
    pub(super) method: String,
    /// Cells of the contestant, and versions; empty for the scene itself.
    pub(super) parameters: String,
    /// Short name for pictures.
    pub(super) label: String,
    /// Family of the contestant.
    pub(super) family: Family,
    /// Cost and counts, or the reason for having no answer.
    pub(super) result: Result<(Cost, Comparison), String>,
}

impl ChartRow {
    /// Returns the CPU time per receiver of the scene \[ns\] and the share of wrong receivers;
    /// `None` where one of them is missing.
    pub(super) fn place(&self) -> Option<(f64, f64)> {
        let (cost, counts) = self.result.as_ref().ok()?;
        let cpu_ns = 1e9 * cost.cpu_s? / (counts.receivers + counts.unanswered) as f64;
        Some((cpu_ns, counts.wrong_share()?)).filter(|(cpu_ns, _)| cpu_ns.is_finite() && *cpu_ns > 0.0)
    }
}

/// Report of a chart of a scene.
#[derive(Debug, Clone)]
pub(super) struct ChartReport {
    pub(super) facts: RunFacts,
    pub(super) sight: SightPlan,
    /// UAVs, each with longitude and latitude \[deg\] if it was read in degrees.
    pub(super) uavs: Vec<(Uav, Option<[f64; 2]>)>,
    /// The exact answer.
    pub(super) truth: Truth,
    /// `true` if a UAV is over no data, which makes P_LoS undefined.
    pub(super) is_over_nodata: bool,
    /// Threads of the timed runs.
    pub(super) threads: u16,
    /// Cost of reading each height once and writing the mask once, for all UAVs.
    pub(super) floor: Cost,
    /// Contestants that had their turn.
    pub(super) rows: Vec<ChartRow>,
    /// Number of planned contestants.
    pub(super) planned: usize,
}

impl ChartReport {
    /// Returns `true` if the user ended the run before all contestants had their turn.
    pub(super) fn is_interrupted(&self) -> bool {
        self.rows.len() < self.planned
    }

    /// Returns the memory floor per receiver \[ns of CPU time\].
    pub(super) fn floor_ns(&self) -> Option<f64> {
        let receivers = self.truth.receivers();
        let floor = 1e9 * self.floor.cpu_s? / receivers as f64;
        (receivers > 0 && floor > 0.0).then_some(floor)
    }

    /// Returns the rows on the Pareto front of CPU time and wrong receivers, by rising CPU time.
    pub(super) fn front(&self) -> Vec<usize> {
        let places = self.rows.iter().map(|row| row.place().unwrap_or((f64::NAN, f64::NAN)));
        pareto_front(&places.collect::<Vec<_>>())
    }

    /// Returns the SHA-256 of everything that does not depend on the machine. Each row except peers
    /// contributes a line of method, parameters and counts.
    fn digest(&self) -> String {
        let mut hasher = Sha256::default();
        for row in self.rows.iter().filter(|row| row.family != Family::Peer) {
            let counts = row.result.as_ref().map(|(_, counts)| format!("{:?}", count_cells(counts)));
            hasher.update(format!("{},{},{counts:?}\n", row.method, row.parameters));
        }
        digest_words(hasher)
    }

    /// Returns the document. Pictures, and the files beside tables, store it without contestants
    /// and times.
    pub(super) fn document(&self, with_rows: bool) -> Value {
        let uav = |(uav, lonlat): &(Uav, Option<[f64; 2]>)| UavDocument {
            id: uav.id.clone(),
            position: Position { x: uav.station.place.x, y: uav.station.place.y, lonlat: *lonlat }.into(),
            height_amsl_m: uav.height_amsl_m(),
            height_agl_m: uav.height_agl_m,
            placement: uav.placement.name(),
        };
        let front = self.front();
        let row = |(k, row): (usize, &ChartRow)| self.row_document(row, front.contains(&k));
        let p_los = self.truth.p_los().filter(|_| !self.is_over_nodata);
        let no_p_los = if self.is_over_nodata { "a UAV is over no data" } else { "no receiver in range" };
        let mut head = self.facts.head(CHART_SCHEMA);
        // The document uses this key for the exact answer.
        head.exact = None;
        document_of(&ChartDocument {
            head,
            kind: "scene",
            sight: self.sight.facts(),
            threads: self.threads,
            interrupted: self.is_interrupted(),
            uavs: self.uavs.iter().map(uav).collect(),
            exact: ExactDocument {
                method: self.truth.method.name().into_owned(),
                receivers: self.truth.receivers(),
                los: self.truth.los(),
                p_los,
                links_checked_by_ray: self.truth.checked,
                reason: p_los.is_none().then_some(no_p_los),
            },
            meaning: MEANING,
            memory_floor: with_rows.then(|| self.floor.document()),
            contestants: with_rows.then(|| self.rows.iter().enumerate().map(row).collect()),
            warnings: warnings_of(&self.facts.warnings),
            digest: self.digest(),
        })
    }

    fn row_document(&self, row: &ChartRow, pareto: bool) -> ContestantDocument {
        let (cost, counts) = row.result.as_ref().map_or((None, None), |(cost, counts)| (Some(cost), Some(counts)));
        let no_share = counts.is_some_and(|counts| counts.wrong_share().is_none());
        ContestantDocument {
            method: row.method.clone(),
            parameters: row.parameters.clone(),
            family: row.family.name(),
            cost: cost.map_or_else(CostDocument::default, Cost::document),
            cpu_ns_per_receiver: cost.map(|_| row.place().map(|place| place.0)),
            counts: CountsDocument::of(counts),
            wrong_share: counts.and_then(Comparison::wrong_share),
            p_los: counts.and_then(Comparison::p_los),
            p_los_error: counts.and_then(|counts| self.truth.p_los_error(counts)),
            reason: match &row.result {
                Err(reason) => Some(reason.clone()),
                Ok(_) => no_share.then(|| "no receiver that both answer".to_string()),
            },
            pareto,
        }
    }

    /// Returns the table: one row for each contestant. Missing values are empty, with a reason.
    pub(super) fn table(&self) -> Rows {
        rows(self.rows.iter().map(|row| {
            let (cost, counts) = row.result.as_ref().map_or((None, None), |(cost, counts)| (Some(cost), Some(counts)));
            let CountsDocument { wrong_cells, receivers, false_los, false_nlos, unanswered, own_receivers, own_los } =
                CountsDocument::of(counts);
            ChartTableRow {
                method: row.method.clone(),
                parameters: row.parameters.clone(),
                cpu_s: cost.and_then(|cost| cost.cpu_s),
                wall_s: cost.map(|cost| cost.wall_s),
                peak_mb: cost.and_then(|cost| cost.peak_mb),
                wrong_cells,
                receivers,
                false_los,
                false_nlos,
                p_los: counts.and_then(Comparison::p_los),
                p_los_error: counts.and_then(|counts| self.truth.p_los_error(counts)),
                unanswered,
                own_receivers,
                own_los,
                runs: cost.map(|cost| cost.runs),
                family: row.family.name(),
                reason: row.result.as_ref().err().cloned(),
            }
        }))
    }
}

/// Returns the counts in the order of the table.
fn count_cells(counts: &Comparison) -> [u64; 7] {
    [
        counts.wrong(),
        counts.receivers,
        counts.false_los,
        counts.false_nlos,
        counts.unanswered,
        counts.own_receivers,
        counts.own_los,
    ]
}

/// Speed against accuracy on a scene; it holds times of the machine.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ChartDocument {
    #[serde(flatten)]
    head: Head,
    /// scene, or p_los for the methods of P_LoS of a generated city.
    kind: &'static str,
    #[serde(flatten)]
    sight: SightFacts,
    /// Threads of the timed runs.
    threads: u16,
    /// true if the run ended before all contestants had their turn.
    interrupted: bool,
    /// The UAVs.
    uavs: Vec<UavDocument>,
    /// The exact answer.
    exact: ExactDocument,
    /// Meaning of the numbers.
    meaning: Meaning,
    /// Cost of reading each height once and writing the mask once.
    #[serde(skip_serializing_if = "Option::is_none")]
    memory_floor: Option<CostDocument>,
    /// The contestants; absent in the copies that pictures and tables store.
    #[serde(skip_serializing_if = "Option::is_none")]
    contestants: Option<Vec<ContestantDocument>>,
    /// Warnings.
    warnings: Vec<WarningFacts>,
    /// SHA-256 of everything that does not depend on the machine.
    digest: String,
}

/// A UAV.
#[derive(Debug, Serialize, JsonSchema)]
struct UavDocument {
    /// Name.
    id: String,
    #[serde(flatten)]
    position: PositionFields,
    /// Height above the datum [m].
    height_amsl_m: f64,
    /// Height above the ground [m]; null where no ground is known.
    height_agl_m: Option<f64>,
    /// Surface below the UAV: ground or rooftop.
    placement: &'static str,
}

/// The exact answer.
#[derive(Debug, Serialize, JsonSchema)]
struct ExactDocument {
    /// Engine that computed it.
    method: String,
    /// Receivers of all UAVs.
    receivers: u64,
    /// Receivers in line of sight.
    los: u64,
    /// Share of the receivers in line of sight.
    p_los: Option<f64>,
    /// Links that a ray confirms; null where rays decided all links.
    links_checked_by_ray: Option<u64>,
    /// Reason for having no share.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'static str>,
}

/// A contestant.
#[derive(Debug, Serialize, JsonSchema)]
struct ContestantDocument {
    /// The engine as it is typed, or the program.
    method: String,
    /// Cells of the contestant, and versions.
    parameters: String,
    /// Family of the contestant.
    family: &'static str,
    #[serde(flatten)]
    cost: CostDocument,
    /// CPU time per receiver [ns].
    #[serde(skip_serializing_if = "Option::is_none")]
    cpu_ns_per_receiver: Option<Option<f64>>,
    #[serde(flatten)]
    counts: CountsDocument,
    /// Share of wrong receivers.
    wrong_share: Option<f64>,
    /// P_LoS over the contestant's own receivers.
    p_los: Option<f64>,
    /// P_LoS less that of the exact method.
    p_los_error: Option<f64>,
    /// Reason for a missing value.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    /// true if no contestant is better in both cost and error.
    pareto: bool,
}

/// Errors of a contestant.
#[derive(Debug, Default, Serialize, JsonSchema)]
struct CountsDocument {
    /// Receivers decided wrongly.
    wrong_cells: Option<u64>,
    /// Receivers that the contestant and the exact answer have in common.
    receivers: Option<u64>,
    /// Wrong receivers that the contestant calls LoS.
    false_los: Option<u64>,
    /// Wrong receivers that the contestant calls NLoS.
    false_nlos: Option<u64>,
    /// Receivers that the contestant does not answer.
    unanswered: Option<u64>,
    /// Receivers of the contestant itself.
    own_receivers: Option<u64>,
    /// Its own receivers in line of sight.
    own_los: Option<u64>,
}

impl CountsDocument {
    fn of(counts: Option<&Comparison>) -> Self {
        let Some(counts) = counts else { return CountsDocument::default() };
        let [wrong_cells, receivers, false_los, false_nlos, unanswered, own_receivers, own_los] =
            count_cells(counts).map(Some);
        CountsDocument { wrong_cells, receivers, false_los, false_nlos, unanswered, own_receivers, own_los }
    }
}

/// A row of the table of a chart.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ChartTableRow {
    /// The engine as it is typed, or the program.
    method: String,
    /// Cells of the contestant, and versions; empty for the scene itself.
    parameters: String,
    /// User CPU time of one run [s].
    cpu_s: Option<f64>,
    /// Wall time of one run [s].
    wall_s: Option<f64>,
    /// Largest resident set of the process during the first run [MB].
    peak_mb: Option<f64>,
    /// Receivers decided wrongly.
    wrong_cells: Option<u64>,
    /// Receivers that the contestant and the exact answer have in common.
    receivers: Option<u64>,
    /// Wrong receivers that the contestant calls LoS.
    false_los: Option<u64>,
    /// Wrong receivers that the contestant calls NLoS.
    false_nlos: Option<u64>,
    /// P_LoS over the contestant's own receivers.
    p_los: Option<f64>,
    /// P_LoS less that of the exact method.
    p_los_error: Option<f64>,
    /// Receivers that the contestant does not answer.
    unanswered: Option<u64>,
    /// Receivers of the contestant itself.
    own_receivers: Option<u64>,
    /// Its own receivers in line of sight.
    own_los: Option<u64>,
    /// Runs that were timed.
    runs: Option<u32>,
    /// Family of the contestant.
    family: &'static str,
    /// Reason for having no answer.
    reason: Option<String>,
}
