//! `skyshed info`: the content of a file, its faults, and remedies.
//!
//! A scene is described in full. Files of UAVs, tracks and outputs of this program are described by
//! their content. The reader of scenes refuses any other file and names its kind.

use std::path::Path;

use skyshed_request::{InfoRequest, json};

use crate::answer::Answer;
use crate::cli::args::output::{checked_files, plain_look};
use crate::cli::args::scene::scene_files;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::error::Error;
use crate::survey::{FORMATS, Output, Places, Survey, TILE_FORMATS};

/// Answers a request.
///
/// # Errors
/// Errors of the request, the scene and the files.
pub(in crate::cli) fn run(request: &InfoRequest, run: &Run) -> Result<()> {
    let (path, words) = (Path::new(request.scene.word()), run.words());
    if let Some(output) = Output::of(path, &words) {
        return tell(request, run, &output, &["scene"]);
    }
    if let Some(places) = Places::of(path, run.reader(&request.reading).crs()?, &words)? {
        return tell(request, run, &places, &["scene", "crs"]);
    }
    let formats = if request.info.tile.is_some() { &TILE_FORMATS[..] } else { &FORMATS[..] };
    let outputs = checked_files(&request.out, None, (formats, &scene_files(request.scene.word(), &request.reading)))?;
    let survey = Survey::open(&run.reader(&request.reading), request.scene.word(), request.info.tile, words)?;
    run.emit(&survey, &outputs, (&request.out, &plain_look(&request.out)))
}

/// Answers for a file that is no scene.
fn tell(request: &InfoRequest, run: &Run, answer: &dyn Answer, used: &[&str]) -> Result<()> {
    let of_all = ["output", "json", "overwrite", "threads", "max_memory", "quiet"];
    let path = Path::new(request.scene.word());
    let why = format!("for {}, which is no scene", path.display());
    json::refuse_others(&json::set_members(request), &[used, &of_all].concat(), &why).map_err(Error::from)?;
    let outputs = checked_files(&request.out, None, (&FORMATS, &[path.to_path_buf()]))?;
    run.emit(answer, &outputs, (&request.out, &plain_look(&request.out)))
}
