//! Methods of P_LoS of a generated city, each with its cost and its error.

use skyshed_request::{Placement, Users};

use super::measure::measured;
use super::plos_report::{PlosChartReport, PlosChartRow};
use super::{Chart, Contest, in_turns};
use crate::accuracy::plos_cost::{PlosWay, reference};
use crate::answer::CommandFacts;
use crate::city::BuiltUp;
use crate::error::{OddRun, Result};
use crate::los_probability::setting::Setting;
use crate::progress::Progress;

/// Plan of a chart of P_LoS of a generated city.
#[derive(Debug)]
pub(crate) struct PlosChartPlan {
    /// City as the user wrote it, and its parameters.
    pub(crate) city: String,
    pub(crate) built_up: BuiltUp,
    /// Elevation angle of the UAV \[deg\].
    pub(crate) theta_deg: f64,
    /// Heights of UAV and receivers above ground \[m\].
    pub(crate) height_m: f64,
    pub(crate) rx_height_m: f64,
    pub(crate) seed: u64,
    /// Least time for each contestant \[s\].
    pub(crate) time_s: f64,
    /// Threads of the timed runs.
    pub(crate) threads: u16,
}

impl PlosChartPlan {
    /// Computes P_LoS by all methods.
    ///
    /// # Errors
    /// E113, E120 for numbers out of range; E503.
    pub(crate) fn run(&self, command: CommandFacts, progress: &Progress) -> Result<Chart> {
        super::check_time(self.time_s)?;
        let setting = Setting {
            built_up: self.built_up,
            uav_height_m: self.height_m,
            rx_height_m: self.rx_height_m,
            reach: Setting::reach_at_elevation(self.theta_deg, self.height_m, self.rx_height_m)?,
            phi_deg: None,
            users: Users::Outdoor,
            placement: Placement::Anywhere,
            uav_clear_of_roof: false,
        };
        let reference = reference(&setting, self.seed);
        let ways = PlosWay::all();
        (progress.note)(&format!("converged product; {} contestants to come", ways.len()));
        (progress.begin_pieces)();
        let rows = in_turns(self.threads, ways.len(), progress, || {
            let mut rows = Vec::new();
            for way in ways.iter().copied() {
                if progress.is_stopped() {
                    break;
                }
                let (answer, cost) = measured(self.time_s, progress, || way.answer(&setting, self.seed));
                rows.push(PlosChartRow { way, result: answer.map(|answer| (cost, answer)) });
                progress.advance();
            }
            rows
        })?;
        let silent = rows.iter().filter_map(|row| Some((row.way, row.result.as_ref().err()?)));
        let left_out = |(way, why): (PlosWay, &String)| OddRun::LeftOut(way.method().into(), why.clone()).into();
        let warnings = silent.map(left_out).collect();
        let report = PlosChartReport {
            command,
            city: self.city.clone(),
            setting,
            seed: self.seed,
            threads: self.threads,
            reference,
            rows,
            planned: ways.len(),
            warnings,
        };
        Ok(Chart { contest: Contest::PLos(Box::new(report)) })
    }
}

/// Returns a row in words. `None` for a method without an answer, which a warning reports.
pub(super) fn in_words(row: &PlosChartRow, report: &PlosChartReport) -> Option<String> {
    let (cost, answer) = row.result.as_ref().ok()?;
    let number = |value: Option<f64>| value.map_or("undefined".to_string(), |v| format!("{v:.6}"));
    let name = [row.way.method().to_string(), row.way.parameters()].join(" ");
    let cpu = cost.cpu_s.map_or("unknown".to_string(), |cpu| format!("{:.4} ms", 1e3 * cpu));
    Some(format!(
        "{}: P_LoS {}, error {}, CPU time {cpu}",
        name.trim_end(),
        number(answer.p_los()),
        number(report.error(row))
    ))
}
