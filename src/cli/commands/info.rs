//! `skyshed info`: the content of a file, its faults, and remedies.

use std::path::Path;

use skyshed_request::{InfoRequest, json};

use crate::cli::args::output::{checked_files, plain_look};
use crate::cli::args::scene::scene_files;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::error::Error;
use crate::survey::{FORMATS, TILE_FORMATS, facts_of, options_of_other};

/// Answers a request.
///
/// # Errors
/// Errors of the request, the scene and the files.
pub(in crate::cli) fn run(request: &InfoRequest, run: &Run) -> Result<()> {
    let (word, reader) = (request.scene.word(), run.reader(&request.reading));
    if let Some(used) = options_of_other(Path::new(word)) {
        let of_all = ["output", "json", "overwrite", "threads", "max_memory", "quiet"];
        let why = format!("for {}, which is no scene", word.display());
        json::refuse_others(&json::set_members(request), &[used, &of_all].concat(), &why).map_err(Error::from)?;
    }
    let formats = if request.info.tile.is_some() { &TILE_FORMATS[..] } else { &FORMATS[..] };
    let outputs = checked_files(&request.out, None, (formats, &scene_files(word, &request.reading)))?;
    let facts = facts_of(&reader, word, request.info.tile, &run.command())?;
    run.emit(&*facts, &outputs, (&request.out, &plain_look(&request.out)))
}
