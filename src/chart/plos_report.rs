//! Report of effort against accuracy of P_LoS: `skyshed/chart/1` of a generated city, and its
//! table.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::report::{CHART_SCHEMA, Cost, CostDocument, MEANING, Meaning};
use crate::accuracy::front::pareto_front;
use crate::accuracy::plos_cost::{PlosAnswer, PlosWay};
use crate::answer::{CommandFacts, Rows, WarningFacts, document_of, rows, warnings_of};
use crate::error::Warning;
use crate::los_probability::estimate::Estimate;
use crate::los_probability::setting::Setting;
use crate::words::version;

/// One method of P_LoS with its result.
#[derive(Debug, Clone)]
pub(super) struct PlosChartRow {
    /// The method.
    pub(super) way: PlosWay,
    /// Cost and answer, or the reason for having no answer.
    pub(super) result: Result<(Cost, PlosAnswer), String>,
}

/// Report of a chart of the methods of P_LoS.
#[derive(Debug, Clone)]
pub(super) struct PlosChartReport {
    /// Command line and question.
    pub(super) command: CommandFacts,
    /// City as the user wrote it.
    pub(super) city: String,
    /// Setting of P_LoS.
    pub(super) setting: Setting,
    /// Seed of everything random.
    pub(super) seed: u64,
    /// Threads of the timed runs.
    pub(super) threads: u16,
    /// The converged product.
    pub(super) reference: Estimate,
    /// Methods that had their turn.
    pub(super) rows: Vec<PlosChartRow>,
    /// Number of planned methods.
    pub(super) planned: usize,
    /// Warnings.
    pub(super) warnings: Vec<Warning>,
}

impl PlosChartReport {
    /// Returns `true` if the user ended the run before all methods had their turn.
    pub(super) fn is_interrupted(&self) -> bool {
        self.rows.len() < self.planned
    }

    /// Returns P_LoS of a row less that of the converged product.
    pub(super) fn p_los_error(&self, row: &PlosChartRow) -> Option<f64> {
        Some(row.result.as_ref().ok()?.1.p_los()? - self.reference.p_los?)
    }

    /// Returns the error of a row: its standard error, or the absolute bias of a model.
    pub(super) fn error(&self, row: &PlosChartRow) -> Option<f64> {
        match &row.result.as_ref().ok()?.1 {
            PlosAnswer::Estimate(estimate) => estimate.std_error,
            PlosAnswer::Model(_) => self.p_los_error(row).map(f64::abs),
        }
    }

    /// Returns the CPU time \[s\] and the error of a row; `None` where one of them is missing.
    pub(super) fn place(&self, row: &PlosChartRow) -> Option<(f64, f64)> {
        let cpu_s = row.result.as_ref().ok()?.0.cpu_s?;
        Some((cpu_s, self.error(row)?)).filter(|(cpu_s, _)| *cpu_s > 0.0)
    }

    /// Returns the rows on the Pareto front of CPU time and error, by rising CPU time.
    pub(super) fn front(&self) -> Vec<usize> {
        let places = self.rows.iter().map(|row| self.place(row).unwrap_or((f64::NAN, f64::NAN)));
        pareto_front(&places.collect::<Vec<_>>())
    }

    /// Returns the document. Pictures, and the files beside tables, store it without contestants
    /// and times.
    pub(super) fn document(&self, with_rows: bool) -> Value {
        let (setting, city) = (&self.setting, self.setting.built_up);
        let front = self.front();
        let row = |(k, row): (usize, &PlosChartRow)| self.row_document(row, front.contains(&k));
        document_of(&PlosChartDocument {
            schema: CHART_SCHEMA,
            version: version(),
            command: self.command.clone(),
            kind: "p_los",
            city: self.city.clone(),
            built_up: ParametersDocument {
                alpha: city.built_up_ratio,
                beta_per_km2: city.buildings_per_km2,
                gamma_m: city.height_scale,
            },
            seed: self.seed,
            height_m: setting.uav_height_m,
            rx_height_m: setting.rx_height_m,
            theta_deg: setting.theta_deg(),
            users: setting.users.name(),
            placement: setting.placement.name(),
            threads: self.threads,
            interrupted: self.is_interrupted(),
            reference: ReferenceDocument {
                method: "product",
                p_los: self.reference.p_los,
                std_error: self.reference.std_error,
                samples: self.reference.samples,
            },
            meaning: MEANING,
            contestants: with_rows.then(|| self.rows.iter().enumerate().map(row).collect()),
            warnings: warnings_of(&self.warnings),
        })
    }

    fn row_document(&self, row: &PlosChartRow, pareto: bool) -> WayDocument {
        let (cost, answer) = row.result.as_ref().map_or((None, None), |(cost, answer)| (Some(cost), Some(answer)));
        let estimate = answer.and_then(estimate_of);
        WayDocument {
            method: row.way.method(),
            parameters: row.way.parameters(),
            cost: cost.map_or_else(CostDocument::default, Cost::document),
            p_los: answer.and_then(PlosAnswer::p_los),
            std_error: estimate.and_then(|e| e.std_error),
            std_error_reason: (answer.is_some() && estimate.is_none()).then_some("a model tells no error"),
            p_los_error: self.p_los_error(row),
            samples: estimate.map(|e| e.samples),
            clusters: estimate.map(|e| e.clusters),
            reason: row.result.as_ref().err().cloned(),
            pareto,
        }
    }

    /// Returns the table: one row for each method.
    pub(super) fn table(&self) -> Rows {
        rows(self.rows.iter().map(|row| {
            let (cost, answer) = row.result.as_ref().map_or((None, None), |(cost, answer)| (Some(cost), Some(answer)));
            let estimate = answer.and_then(estimate_of);
            PlosChartTableRow {
                method: row.way.method(),
                parameters: row.way.parameters(),
                cpu_s: cost.and_then(|cost| cost.cpu_s),
                wall_s: cost.map(|cost| cost.wall_s),
                peak_mb: cost.and_then(|cost| cost.peak_mb),
                std_error: estimate.and_then(|e| e.std_error),
                p_los: answer.and_then(PlosAnswer::p_los),
                p_los_error: self.p_los_error(row),
                samples: estimate.map(|e| e.samples),
                clusters: estimate.map(|e| e.clusters),
                runs: cost.map(|cost| cost.runs),
                reason: row.result.as_ref().err().cloned(),
            }
        }))
    }
}

fn estimate_of(answer: &PlosAnswer) -> Option<&Estimate> {
    match answer {
        PlosAnswer::Estimate(estimate) => Some(estimate),
        PlosAnswer::Model(_) => None,
    }
}

/// Effort against accuracy of P_LoS of a generated city; it holds times of the machine.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PlosChartDocument {
    /// Kind of document and its version.
    schema: &'static str,
    /// Version of the program.
    version: &'static str,
    #[serde(flatten)]
    command: CommandFacts,
    /// p_los, or scene for contestants on a scene.
    kind: &'static str,
    /// City as the user wrote it.
    city: String,
    /// Parameters of the city.
    built_up: ParametersDocument,
    /// Seed of everything random.
    seed: u64,
    /// Height of the UAV above ground [m].
    height_m: f64,
    /// Height of the receivers above ground [m].
    rx_height_m: f64,
    /// Elevation angle of the UAV [deg].
    theta_deg: Option<f64>,
    /// Users that count.
    users: &'static str,
    /// Place of the UAV.
    placement: &'static str,
    /// Threads of the timed runs.
    threads: u16,
    /// true if the run ended before all methods had their turn.
    interrupted: bool,
    /// The converged product.
    reference: ReferenceDocument,
    /// Meaning of the numbers.
    meaning: Meaning,
    /// The methods; absent in the copies that pictures and tables store.
    #[serde(skip_serializing_if = "Option::is_none")]
    contestants: Option<Vec<WayDocument>>,
    /// Warnings.
    warnings: Vec<WarningFacts>,
}

/// Parameters of ITU-R P.1410.
#[derive(Debug, Serialize, JsonSchema)]
struct ParametersDocument {
    /// Share of the ground that is built on.
    alpha: f64,
    /// Buildings per km².
    beta_per_km2: f64,
    /// Scale of the Rayleigh distribution of heights [m].
    gamma_m: f64,
}

/// The converged product.
#[derive(Debug, Serialize, JsonSchema)]
struct ReferenceDocument {
    /// product.
    method: &'static str,
    /// P_LoS.
    p_los: Option<f64>,
    /// Standard error of P_LoS.
    std_error: Option<f64>,
    /// Links behind P_LoS.
    samples: u64,
}

/// A method of P_LoS.
#[derive(Debug, Serialize, JsonSchema)]
struct WayDocument {
    /// The method.
    method: &'static str,
    /// Effort of the method.
    parameters: String,
    #[serde(flatten)]
    cost: CostDocument,
    /// P_LoS.
    p_los: Option<f64>,
    /// Standard error of P_LoS.
    std_error: Option<f64>,
    /// Reason for having no standard error.
    #[serde(skip_serializing_if = "Option::is_none")]
    std_error_reason: Option<&'static str>,
    /// P_LoS less that of the converged product.
    p_los_error: Option<f64>,
    /// Links behind P_LoS.
    samples: Option<u64>,
    /// Independent groups of links.
    clusters: Option<u64>,
    /// Reason for a missing value.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
    /// true if no method is better in both cost and error.
    pareto: bool,
}

/// A row of the table of methods of P_LoS.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PlosChartTableRow {
    /// The method.
    method: &'static str,
    /// Effort of the method.
    parameters: String,
    /// User CPU time of one run [s].
    cpu_s: Option<f64>,
    /// Wall time of one run [s].
    wall_s: Option<f64>,
    /// Largest resident set of the process during the first run [MB].
    peak_mb: Option<f64>,
    /// Standard error of P_LoS; empty for models.
    std_error: Option<f64>,
    /// P_LoS.
    p_los: Option<f64>,
    /// P_LoS less that of the converged product.
    p_los_error: Option<f64>,
    /// Links behind P_LoS.
    samples: Option<u64>,
    /// Independent groups of links.
    clusters: Option<u64>,
    /// Runs that were timed.
    runs: Option<u32>,
    /// Reason for a missing value.
    reason: Option<String>,
}
