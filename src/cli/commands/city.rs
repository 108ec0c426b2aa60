//! `skyshed city`: makes or converts a city, and draws it.

use skyshed_request::CityRequest;

use crate::cli::args::output::checked_files;
use crate::cli::args::scene::scene_files;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::conversion::{Conversion, FORMATS};
use crate::picture::Look;

/// Answers a request.
///
/// # Errors
/// Errors of the request, the scene and the files.
pub(in crate::cli) fn run(request: &CityRequest, run: &Run) -> Result<()> {
    let outputs = checked_files(&request.out, None, (&FORMATS, &scene_files(request.scene.word(), &request.reading)))?;
    let look = Look::checked(&request.picture, &request.out.writing, &outputs)?;
    let city = match &run.given {
        Some(scene) => Conversion::of(scene.clone(), run.command()),
        None => Conversion::open(&run.reader(&request.reading), request.scene.word(), run.command())?,
    };
    city.check_memory(&outputs)?;
    run.emit(&city, &outputs, (&request.out, &look))
}
