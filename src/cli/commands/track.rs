//! `skyshed track`: line of sight along a walk or a flight.

use std::path::PathBuf;

use skyshed_io::Input;
use skyshed_request::{TrackRequest, Uavs, json};

use crate::cli::args::output::checked_files;
use crate::cli::args::scene::scene_files;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::export::{OutputRules, check_outputs};
use crate::picture::Look;
use crate::track::{FORMATS, STRETCH_FORMATS, TrackAsked, TrackPlan};
use crate::uav::UavsAsked;

/// Answers a request.
///
/// # Errors
/// Errors of the request, the scene and the files.
pub(in crate::cli) fn run(request: &TrackRequest, run: &Run) -> Result<()> {
    run.refuse_data_area(&json::set_members(request))?;
    let (options, hash) = (&request.track, request.reading.options.hash);
    let skips_bad = request.uavs.skip_bad;
    // Bad rows may be those of the track alone.
    let asked = Uavs { skip_bad: skips_bad && request.uavs.uavs.is_some(), ..request.uavs.clone() };
    let uavs = UavsAsked::some_of(&asked, hash)?;
    let track = options.track.as_ref().map_or_else(|| Input::path(""), Input::of);
    let of_user = (&request.receiver, &request.earth);
    let track = TrackAsked::of((track, skips_bad, hash), options)?;
    let mut plan = TrackPlan::of(uavs, track, of_user)?;
    plan.stretch_files = request.stretches.stretches.iter().map(|path| path.0.clone()).collect();
    let files = plan.uavs.file().into_iter().chain(plan.track.file.file().map(PathBuf::from));
    let inputs: Vec<PathBuf> = scene_files(request.scene.word(), &request.reading).into_iter().chain(files).collect();
    let mut outputs = checked_files(&request.out, None, (&FORMATS, &inputs))?;
    let look = Look::checked(&request.picture, &request.out.writing, &outputs)?;
    let taken: Vec<PathBuf> = inputs.iter().chain(outputs.iter().map(|(path, _)| path)).cloned().collect();
    let overwrite = request.out.writing.overwrite;
    let rules = OutputRules { allowed: &STRETCH_FORMATS, inputs: &taken, overwrite, bare: false };
    outputs.extend(check_outputs(&plan.stretch_files, rules)?);
    let walk = plan.walk(run.open_word(request.scene.word(), &request.reading)?, run.command())?;
    run.emit(&walk, &outputs, (&request.out, &look))
}
