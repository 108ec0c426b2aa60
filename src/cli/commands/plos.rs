//! `skyshed plos`: probability of line of sight.

use std::path::PathBuf;

use skyshed_request::PlosRequest;

use crate::cli::args::output::checked_files;
use crate::cli::args::scene::scene_files;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::picture::Look;
use crate::plos::{FORMATS, PlosPlan, curve_path};
use crate::scene::built_up;

/// Answers a request.
///
/// # Errors
/// Errors of the request, the cities and the files.
pub(in crate::cli) fn run(request: &PlosRequest, run: &Run) -> Result<()> {
    let words = request.plos.scenes.iter().map(|word| word.as_os_str());
    let files = words.filter(|word| built_up(word).is_none()).flat_map(|word| scene_files(word, &request.reading));
    let curves = request.plos.curve.iter().filter_map(|word| curve_path(word.as_os_str()));
    let inputs: Vec<PathBuf> = files.chain(curves).collect();
    let csv = request.table.csv.clone().map(PathBuf::from);
    let outputs = checked_files(&request.out, csv.as_ref(), (&FORMATS, &inputs))?;
    let look = Look::checked(&request.picture, &request.out.writing, &outputs)?;
    let is_drawn = outputs.iter().any(|(_, format)| format.is_picture());
    let options = run.reader(&request.reading);
    let plan = PlosPlan { options, ..PlosPlan::of(request, is_drawn, run.command())? };
    run.emit(&plan.run()?, &outputs, (&request.out, &look))
}
