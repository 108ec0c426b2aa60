//! `skyshed zones`: streets, crossroads, courtyards and rooftops.

use skyshed_request::ZonesRequest;

use crate::cli::args::output::checked_files;
use crate::cli::args::scene::scene_files;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::memory::Needs;
use crate::picture::Look;
use crate::zone_files::{FORMATS, ZoneFiles};

/// Answers a request.
///
/// # Errors
/// Errors of the request, the scene and the files.
pub(in crate::cli) fn run(request: &ZonesRequest, run: &Run) -> Result<()> {
    let outputs = checked_files(&request.out, None, (&FORMATS, &scene_files(request.scene.word(), &request.reading)))?;
    let look = Look::checked(&request.picture, &request.out.writing, &outputs)?;
    let scene = run.open_word(request.scene.word(), &request.reading)?;
    outputs.iter().try_for_each(|(_, format)| Needs::of_zones(*format, scene.grid()).check(&scene))?;
    let zones = ZoneFiles::of(scene, run.command())?;
    run.emit(&zones, &outputs, (&request.out, &look))
}
