//! `skyshed chart`: speed against accuracy on the user's own scene.

use std::path::PathBuf;

use skyshed_request::{ChartOptions, ChartRequest, filled, json};

use crate::chart::{ChartPlan, FORMATS, PlosChartPlan};
use crate::cli::args::output::checked_files;
use crate::cli::args::scene::scene_files;
use crate::cli::failure::{Failure, Result, refusal_with};
use crate::cli::run::Run;
use crate::error::{Error, ErrorRepr, RequestError};
use crate::picture::Look;
use crate::scene::built_up;
use crate::sight::SightPlan;
use crate::uav::UavsAsked;

/// Options that the P_LoS methods of a generated city can use.
const OF_P_LOS: [&str; 18] = [
    "scene",
    "plos",
    "theta",
    "height",
    "rx_height",
    "time",
    "seed",
    "csv",
    "title",
    "width",
    "dpi",
    "output",
    "json",
    "overwrite",
    "csv_text",
    "threads",
    "max_memory",
    "quiet",
];

/// Answers a request.
///
/// # Errors
/// Errors of the request, the scene and the files.
pub(in crate::cli) fn run(request: &ChartRequest, run: &Run) -> Result<()> {
    let (options, defaults) = (&request.chart, ChartOptions::defaults());
    let csv = request.table.csv.clone().map(PathBuf::from);
    let time_s = filled(options.time, defaults.time);
    let inputs: Vec<PathBuf> = scene_files(request.scene.word(), &request.reading)
        .into_iter()
        .chain(request.uavs.uavs.iter().map(|table| table.path().to_path_buf()))
        .collect();
    let outputs = checked_files(&request.out, csv.as_ref(), (&FORMATS, &inputs))?;
    let look = Look::checked(&request.picture, &request.out.writing, &outputs)?;
    // Methods are timed with one thread, unless more are requested.
    let threads = request.out.effort.threads.unwrap_or(1);
    let chart = match options.plos {
        true => plan_of_p_los(request, threads)?.run(run.command(), &run.progress)?,
        false => {
            let (sight, peers) = (SightPlan::of(&request.sight)?, options.peers);
            let plan = ChartPlan { sight, peers, time_s, threads };
            plan.check()?;
            let without = "`--plos` charts the P_LoS methods of a generated city without one";
            let asked = UavsAsked::some_of(&request.uavs, request.reading.options.hash).map_err(|error| match error
                .repr()
            {
                ErrorRepr::Request(RequestError::NoUav) => refusal_with(108, Failure::from(error).to_string(), without),
                _ => error.into(),
            })?;
            let scene = run.open_word(request.scene.word(), &request.reading)?;
            let found = asked.read(scene.grid())?;
            plan.run(scene, &found, run.command(), &run.progress)?
        }
    };
    run.emit(&chart, &outputs, (&request.out, &look))
}

fn plan_of_p_los(request: &ChartRequest, threads: u16) -> Result<PlosChartPlan> {
    let (options, defaults) = (&request.chart, ChartOptions::defaults());
    let city = request.scene.word().display().to_string();
    let Some(built_up) = built_up(request.scene.word()) else {
        let text = format!("`--plos` has no meaning for {city}: it charts a generated city");
        let hint = "`chart itu:α,β,γ --plos`; of footprints `skyshed info` gives α, β, γ";
        return Err(refusal_with(116, text, hint));
    };
    json::refuse_others(&json::set_members(request), &OF_P_LOS, "with `plos`, which maps no scene")
        .map_err(Error::from)?;
    Ok(PlosChartPlan {
        city,
        built_up: built_up?,
        theta_deg: filled(options.theta, defaults.theta),
        height_m: filled(options.height, defaults.height).0,
        rx_height_m: request.sight.receiver.rx_height_m(),
        seed: request.reading.options.seed_or_default(),
        time_s: filled(options.time, defaults.time),
        threads,
    })
}
