//! `skyshed limits`: limits of the P_LoS of a map, and the needs of the map.

use skyshed_request::LimitsRequest;

use crate::cli::args::output::{checked_files, plain_look};
use crate::cli::args::scene::scene_files;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::limits::{FORMATS, LimitsPlan};
use crate::scene::SceneReader;
use crate::uav::UavsAsked;

/// Answers a request.
///
/// # Errors
/// Errors of the request, the scene and the files.
pub(in crate::cli) fn run(request: &LimitsRequest, run: &Run) -> Result<()> {
    let plan = LimitsPlan::of(&request.sight, &request.limits)?;
    let asked = UavsAsked::some_of(&request.uavs, request.reading.options.hash)?;
    let inputs: Vec<_> = scene_files(request.scene.word(), &request.reading).into_iter().chain(asked.file()).collect();
    let outputs = checked_files(&request.out, None, (&FORMATS, &inputs))?;
    // Faults of a file are reported, not refused.
    let options = SceneReader { tells_faults: true, ..run.reader(&request.reading) };
    let limits = match &run.given {
        Some(scene) => plan.find_over(scene.clone(), &asked.read(scene.grid())?, run.command())?,
        None => plan.find((&options, request.scene.word()), &asked, run.command())?,
    };
    run.emit(&limits, &outputs, (&request.out, &plain_look(&request.out)))
}
