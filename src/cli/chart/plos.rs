//! `skyshed chart itu:… --plos`: the ways to P_LoS of a generated city, each with its cost and its error.

use std::path::PathBuf;
use std::sync::atomic::Ordering;

use super::measure::measured;
use super::write::{Chart, write};
use super::{ChartArgs, in_turns, refuse_typed, show, threads};
use crate::accuracy::plos_cost::{PlosWay, reference};
use crate::city::BuiltUp;
use crate::cli::{interrupt, messages};
use crate::error::{Result, Warning};
use crate::export::Format;
use crate::los_probability::setting::{Placement, Setting, Users};
use crate::report::{PlosChartReport, PlosChartRow};

/// Elevation angle without `--theta` \[deg\].
const THETA_DEG: f64 = 45.0;
/// Height of the UAV without `--height` \[m\].
const HEIGHT_M: f64 = 100.0;

pub(super) fn run(
    args: &ChartArgs,
    command: Vec<String>,
    built_up: BuiltUp,
    outputs: &[(PathBuf, Format)],
) -> Result<()> {
    refuse_typed(args, &["uav", "uavs"], "with `--plos`, which averages over all places")?;
    let of_a_scene = ["receivers", "peers", "radius", "method", "cell", "size", "ground", "hash"];
    refuse_typed(args, &of_a_scene, "with `--plos`, which maps no scene")?;
    let of_files =
        ["terrain", "extent", "crs", "building_threshold", "height_field", "top_field", "missing", "nodata_as"];
    refuse_typed(args, &of_files, "for a generated city")?;
    let uav_height_m = args.height.unwrap_or(HEIGHT_M);
    let setting = Setting {
        built_up,
        uav_height_m,
        rx_height_m: args.rx_height,
        reach: Setting::reach_at_elevation(args.theta.unwrap_or(THETA_DEG), uav_height_m, args.rx_height)?,
        phi_deg: None,
        users: Users::Outdoor,
        placement: Placement::Anywhere,
        uav_clear_of_roof: false,
    };
    let seed = args.scene.seed;
    let reference = reference(&setting, seed);
    let ways = PlosWay::all();
    if !args.out.quiet {
        messages::note(&format!("converged product; {} contestants to come", ways.len()));
    }
    interrupt::begin_pieces();
    let rows = in_turns(args, ways.len(), |control| {
        let mut rows = Vec::new();
        for way in ways.iter().copied() {
            if interrupt::wants_to_stop() {
                break;
            }
            let (answer, cost) = measured(args.time, || way.answer(&setting, seed));
            rows.push(PlosChartRow { way, result: answer.map(|answer| (cost, answer)) });
            control.done.fetch_add(1, Ordering::Relaxed);
        }
        rows
    })?;
    let silent = rows.iter().filter_map(|row| Some((row.way, row.result.as_ref().err()?)));
    let warnings =
        silent.map(|(way, reason)| Warning::new(210, format!("`{}` is left out: {reason}", way.method()))).collect();
    let report = PlosChartReport {
        command,
        city: args.scene.scene.to_string(),
        setting,
        seed,
        threads: usize::from(threads(args)),
        reference,
        rows,
        planned: ways.len(),
        warnings,
    };
    let chart = Chart {
        document: report.document(),
        provenance: report.provenance(),
        table: report.table(),
        picture: show::of_plos(args, &report),
        said: report.rows.iter().filter_map(|row| in_words(row, &report)).collect(),
        warnings: &report.warnings,
        is_interrupted: report.is_interrupted(),
    };
    write(args, &chart, outputs)
}

/// A row in words; nothing for one without an answer, of which a warning tells.
fn in_words(row: &PlosChartRow, report: &PlosChartReport) -> Option<String> {
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
