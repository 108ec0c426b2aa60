//! `skyshed track`: line of sight along a user's track.

use std::path::PathBuf;

use skyshed_io::Input;
use skyshed_request::{TrackRequest, json};

use crate::cli::args::output::checked_files;
use crate::cli::args::scene::scene_files;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::picture::Look;
use crate::track::{FORMATS, TrackPlan};
use crate::uav::site_of;

/// Answers a request.
///
/// # Errors
/// Errors of the request, the scene and the files.
pub(in crate::cli) fn run(request: &TrackRequest, run: &Run) -> Result<()> {
    run.refuse_data_area(&json::set_members(request))?;
    let options = &request.track;
    let uav = site_of(options.uav.as_deref().unwrap_or_default(), "1".into())?;
    let track = options.track.as_ref().map_or_else(|| Input::path(""), Input::of);
    let of_user = (&request.receiver, &request.earth);
    let plan = TrackPlan::of(uav, (track, request.reading.options.hash), options, of_user)?;
    let track = plan.track.file().map(PathBuf::from);
    let inputs: Vec<PathBuf> = scene_files(request.scene.word(), &request.reading).into_iter().chain(track).collect();
    let outputs = checked_files(&request.out, None, (&FORMATS, &inputs))?;
    let look = Look::checked(&request.picture, &request.out.writing, &outputs)?;
    let walk = plan.walk(run.open_word(request.scene.word(), &request.reading)?, run.command())?;
    run.emit(&walk, &outputs, (&request.out, &look))
}
