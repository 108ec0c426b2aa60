//! `skyshed place`: search for places to hover at.

use std::path::PathBuf;

use skyshed_request::{PlaceRequest, SetFiles};

use crate::answer::Output;
use crate::cli::args::output::checked_files;
use crate::cli::args::scene::scene_files;
use crate::cli::failure::{Result, refusal_with};
use crate::cli::run::Run;
use crate::export::Format;
use crate::picture::Look;
use crate::placements::{FORMATS, SearchPlan};

/// Searches for places.
///
/// # Errors
/// Errors of the request, the scene and the files.
pub(in crate::cli) fn run(request: &PlaceRequest, run: &Run) -> Result<()> {
    let plan = SearchPlan::of(&request.question, &request.files, request.reading.options.hash)?;
    let scene = request.scene.word();
    let beside: Vec<PathBuf> = plan.inputs().filter_map(|input| input.file().map(PathBuf::from)).collect();
    let inputs = [scene_files(scene, &request.reading), beside].concat();
    let (outputs, map) = outputs(request, &inputs)?;
    let all: Vec<Output> = outputs.iter().chain(&map).cloned().collect();
    let look = Look::checked(&request.picture, &request.out.writing, &all)?;
    let found = plan.search(run.open_word(scene, &request.reading)?, run.command(), &run.progress)?;
    run.emit(&found, &all, (&request.out, &look))
}

/// Returns the files to write, checked: the files of `-o` and `--csv`, and the map of the winner.
fn outputs(request: &PlaceRequest, inputs: &[PathBuf]) -> Result<(Vec<Output>, Option<Output>)> {
    let csv = request.table.csv.clone().map(PathBuf::from);
    let outputs = checked_files(&request.out, csv.as_ref(), (&FORMATS, inputs))?;
    let is_spatial = |format: &Format| format.is_picture() || *format == Format::GeoTiff;
    if let Some((path, _)) =
        outputs.iter().find(|(_, f)| request.question.candidates.candidates.is_some() && is_spatial(f))
    {
        let text = format!("cannot write {}: only candidates on a grid make a picture or a raster", path.display());
        return Err(refusal_with(109, text, "write them as points: `-o places.geojson`"));
    }
    let Some(path) = &request.files.map else { return Ok((outputs, None)) };
    if !Format::of(path).is_ok_and(|format| is_spatial(&format)) {
        let text = format!("cannot write {}: `--map` writes a map", path.display());
        return Err(refusal_with(105, text, "wanted .png, .svg, .pdf or .tif"));
    }
    let files = [request.out.files.output.clone(), vec![path.clone()]].concat();
    let map = checked_files(&request.out.clone().output(files), None, (&FORMATS, inputs))?.pop();
    Ok((outputs, map))
}
