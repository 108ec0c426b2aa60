//! Effort against accuracy of P_LoS: `skyshed/chart/1` of a generated city, and its table.

use serde_json::{Map, Value, json};

use super::chart::{CHART_SCHEMA, Cost, meaning, text, with_front};
use crate::accuracy::front::pareto_front;
use crate::accuracy::plos_cost::{PlosAnswer, PlosWay};
use crate::error::Warning;
use crate::los_probability::estimate::Estimate;
use crate::los_probability::setting::Setting;

/// One way to P_LoS with its result.
#[derive(Debug, Clone)]
pub struct PlosChartRow {
    /// The way.
    pub way: PlosWay,
    /// What it costs and what it says, or why it says nothing.
    pub result: Result<(Cost, PlosAnswer), String>,
}

/// A chart of the ways to P_LoS as reported.
#[derive(Debug, Clone)]
pub struct PlosChartReport {
    /// The words of the command line.
    pub command: Vec<String>,
    /// The city as typed.
    pub city: String,
    /// What is asked.
    pub setting: Setting,
    /// Seed of everything random.
    pub seed: u64,
    /// Threads of the timed runs.
    pub threads: usize,
    /// The converged product.
    pub reference: Estimate,
    /// The ways that had their turn.
    pub rows: Vec<PlosChartRow>,
    /// How many were to have it.
    pub planned: usize,
    /// Warnings.
    pub warnings: Vec<Warning>,
}

impl PlosChartReport {
    /// Whether the user ended the run before all ways had their turn.
    pub fn is_interrupted(&self) -> bool {
        self.rows.len() < self.planned
    }

    /// P_LoS of a row less that of the converged product.
    pub fn p_los_error(&self, row: &PlosChartRow) -> Option<f64> {
        Some(row.result.as_ref().ok()?.1.p_los()? - self.reference.p_los?)
    }

    /// How far a row errs: its standard error, or the size of a model's bias.
    pub fn error(&self, row: &PlosChartRow) -> Option<f64> {
        match &row.result.as_ref().ok()?.1 {
            PlosAnswer::Estimate(estimate) => estimate.std_error,
            PlosAnswer::Model(_) => self.p_los_error(row).map(f64::abs),
        }
    }

    /// CPU time \[s\] and error of a row; `None` where one of them is missing.
    pub fn place(&self, row: &PlosChartRow) -> Option<(f64, f64)> {
        let cpu_s = row.result.as_ref().ok()?.0.cpu_s?;
        Some((cpu_s, self.error(row)?)).filter(|(cpu_s, _)| *cpu_s > 0.0)
    }

    /// Rows on the Pareto front of CPU time and error, by rising CPU time.
    pub fn front(&self) -> Vec<usize> {
        let places = self.rows.iter().map(|row| self.place(row).unwrap_or((f64::NAN, f64::NAN)));
        pareto_front(&places.collect::<Vec<_>>())
    }

    /// The document; it holds times of this machine.
    pub fn document(&self) -> Value {
        let mut document = self.head();
        let rows = self.rows.iter().map(|row| self.row_json(row));
        document.insert("contestants".into(), with_front(rows, &self.front()));
        self.close(document)
    }

    /// The document without contestants and times, as stored in pictures and beside tables.
    pub fn provenance(&self) -> Value {
        self.close(self.head())
    }

    fn head(&self) -> Map<String, Value> {
        let setting = &self.setting;
        let mut document = Map::new();
        document.insert("schema".into(), CHART_SCHEMA.into());
        document.insert("version".into(), env!("CARGO_PKG_VERSION").into());
        document.insert("command".into(), self.command.clone().into());
        document.insert("kind".into(), "p_los".into());
        document.insert("city".into(), self.city.clone().into());
        let city = setting.built_up;
        let parameters =
            json!({"alpha": city.built_up_ratio, "beta_per_km2": city.buildings_per_km2, "gamma_m": city.height_scale});
        document.insert("built_up".into(), parameters);
        document.insert("seed".into(), self.seed.into());
        document.insert("height_m".into(), setting.uav_height_m.into());
        document.insert("rx_height_m".into(), setting.rx_height_m.into());
        document.insert("theta_deg".into(), setting.theta_deg().into());
        document.insert("users".into(), setting.users.name().into());
        document.insert("placement".into(), setting.placement.name().into());
        document.insert("threads".into(), self.threads.into());
        document.insert("interrupted".into(), self.is_interrupted().into());
        let reference = json!({
            "method": "product", "p_los": self.reference.p_los, "std_error": self.reference.std_error,
            "samples": self.reference.samples,
        });
        document.insert("reference".into(), reference);
        document.insert("meaning".into(), meaning());
        document
    }

    fn close(&self, mut document: Map<String, Value>) -> Value {
        let warnings: Vec<Value> = self.warnings.iter().map(|w| json!({"code": w.code(), "text": w.text()})).collect();
        document.insert("warnings".into(), warnings.into());
        Value::Object(document)
    }

    fn row_json(&self, row: &PlosChartRow) -> Map<String, Value> {
        let mut object = Map::new();
        object.insert("method".into(), row.way.method().into());
        object.insert("parameters".into(), row.way.parameters().into());
        match &row.result {
            Ok((cost, answer)) => {
                object.extend(cost.json());
                let estimate = estimate_of(answer);
                object.insert("p_los".into(), answer.p_los().into());
                object.insert("std_error".into(), estimate.and_then(|e| e.std_error).into());
                if estimate.is_none() {
                    object.insert("std_error_reason".into(), "a model tells no error".into());
                }
                object.insert("p_los_error".into(), self.p_los_error(row).into());
                object.insert("samples".into(), estimate.map(|e| e.samples).into());
                object.insert("clusters".into(), estimate.map(|e| e.clusters).into());
            }
            Err(reason) => {
                let names = ["cpu_s", "wall_s", "peak_mb", "p_los", "std_error", "p_los_error", "samples", "clusters"];
                object.extend(names.map(|name| (name.to_string(), Value::Null)));
                object.insert("reason".into(), reason.clone().into());
            }
        }
        object
    }

    /// The table: one row per way.
    pub fn table(&self) -> Vec<Vec<String>> {
        let header = "method,parameters,cpu_s,wall_s,peak_mb,std_error,p_los,p_los_error,samples,clusters,runs,reason";
        let mut rows = vec![header.split(',').map(str::to_string).collect::<Vec<_>>()];
        rows.extend(self.rows.iter().map(|row| {
            let (cost, answer) = row.result.as_ref().map_or((None, None), |(cost, answer)| (Some(cost), Some(answer)));
            let estimate = answer.and_then(estimate_of);
            let mut line = vec![row.way.method().to_string(), row.way.parameters()];
            line.extend(Cost::cells(cost));
            line.extend([
                text(estimate.and_then(|e| e.std_error)),
                text(answer.and_then(PlosAnswer::p_los)),
                text(self.p_los_error(row)),
                text(estimate.map(|e| e.samples)),
                text(estimate.map(|e| e.clusters)),
                text(cost.map(|cost| cost.runs)),
                text(row.result.as_ref().err()),
            ]);
            line
        }));
        rows
    }
}

fn estimate_of(answer: &PlosAnswer) -> Option<&Estimate> {
    match answer {
        PlosAnswer::Estimate(estimate) => Some(estimate),
        PlosAnswer::Model(_) => None,
    }
}
