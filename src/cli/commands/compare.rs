//! `skyshed compare`: placements side by side.

use std::path::PathBuf;

use skyshed_request::{CompareRequest, json};

use crate::cli::args::output::checked_files;
use crate::cli::args::scene::{scene_files, scene_words};
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::comparison::{ComparisonPlan, FORMATS, check_heights, check_number};
use crate::export::Format;
use crate::picture::Look;
use crate::scene::SceneReader;
use crate::uav::UavsAsked;

/// Answers a request.
///
/// # Errors
/// Errors of the request, the scene and the files.
pub(in crate::cli) fn run(request: &CompareRequest, run: &Run) -> Result<()> {
    let csv = request.table.csv.clone().map(PathBuf::from);
    let reading = &request.reading;
    let asked = UavsAsked::of(&request.uavs, reading.options.hash)?;
    let masks = request.compare.mask.iter().map(|path| path.0.clone()).collect();
    let inputs =
        [scene_files(request.scene.word(), &request.reading), masks, asked.file().into_iter().collect()].concat();
    let outputs = checked_files(&request.out, csv.as_ref(), (&FORMATS, &inputs))?;
    let look = Look::checked(&request.picture, &request.out.writing, &outputs)?;
    let plan = ComparisonPlan {
        scene_words: scene_words(request.scene.word(), &request.reading),
        draws_pairs: outputs.iter().any(|(_, format)| *format == Format::GeoTiff),
        ..ComparisonPlan::of((&request.sight, &request.heights), &request.compare, &reading.options)?
    };
    if request.uavs.uavs.is_none() {
        check_heights(&json::set_members(request), request.uavs.uav.len())?;
    }
    if asked.table.is_none() && request.compare.mask.is_empty() {
        check_number(asked.typed.len())?;
    }
    // The page has a link to the live page of the same place.
    let keeps_solids = outputs.iter().any(|(_, format)| *format == Format::Html);
    let options = SceneReader { keeps_solids, ..run.reader(reading) };
    let scene = run.given.clone().map_or_else(|| options.open(request.scene.word()), Ok)?;
    let found = asked.read(scene.grid())?;
    let comparison = plan.compare(scene, &found, run.command(), &run.progress)?;
    run.emit(&comparison, &outputs, (&request.out, &look))
}
