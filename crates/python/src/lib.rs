//! The extension module of the Python package `skyshed`: scenes, maps and questions as plain calls. `python/skyshed` makes them
//! pleasant; words of options are those of the command line.

mod arrays;
mod answers;
mod errors;
mod links;
mod place;
mod pool;
mod scene;

use std::ffi::OsString;
use std::sync::Arc;

use pyo3::prelude::*;
use skyshed::Source;
use skyshed::cli::Members;

use errors::Failure;

#[pymodule(gil_used = false)]
mod _skyshed {
    #[pymodule_export]
    use super::answers::{Found, Maps};
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::{ask, limit_memory, main, map_tile, normalized, plan_units, raster_grid};
}

/// An input in memory: the option that it stands for, its name, its bytes.
type HeldInput = (String, String, Vec<u8>);

/// A unit of work: its name, its tile, its UAVs by their places in the list of all, and its time on one thread \[s\].
type PlannedUnit = (String, Option<(usize, usize)>, Vec<usize>, f64);

/// Reads options that are one object of JSON.
fn members(options: &str) -> Result<Members, Failure> {
    serde_json::from_str(options).map_err(|error| Failure::Fault(format!("options are no object of JSON: {error}")))
}

/// Answers a command of the program with options by their names, over a scene in memory or over the one that they name.
#[pyfunction]
#[pyo3(signature = (command, options, scene=None, watch=None, held=Vec::new()))]
fn ask(
    py: Python<'_>,
    command: String,
    options: &str,
    scene: Option<&scene::Scene>,
    watch: Option<Py<PyAny>>,
    held: Vec<HeldInput>,
) -> PyResult<answers::Found> {
    let (options, scene) = (members(options)?, scene.map(scene::Scene::shared));
    let held = held.into_iter().map(|(option, name, bytes)| (option, Source::held(name, bytes))).collect();
    let ask = move |progress: &Watched| Ok(skyshed::cli::ask((&command, options), (scene, held), progress)?);
    pool::watched(py, watch, ask).map(answers::Found::from)
}

/// Returns the options of a request as documents record them.
#[pyfunction]
fn normalized(py: Python<'_>, command: String, options: &str) -> PyResult<String> {
    let options = members(options)?;
    pool::watched(py, None, move |_| {
        Ok(serde_json::Value::Object(skyshed::cli::normalized(&command, options)?).to_string())
    })
}

/// Returns the units of work of a map of the UAVs of a table.
#[pyfunction]
fn plan_units(
    py: Python<'_>,
    options: &str,
    scene: Option<&scene::Scene>,
    uavs: Vec<u8>,
) -> PyResult<Vec<PlannedUnit>> {
    let (options, scene) = (members(options)?, scene.map(scene::Scene::shared));
    pool::watched(py, None, move |progress| {
        let units = skyshed::cli::plan_units(options, (scene, Source::held("uavs.csv", uavs)), progress)?;
        Ok(units.into_iter().map(|unit| (unit.name, unit.tile, unit.uavs, unit.seconds)).collect())
    })
}

/// Returns what the UAVs of a table see together of one tile.
#[pyfunction]
fn map_tile(py: Python<'_>, options: &str, scene: Option<&scene::Scene>, uavs: Vec<u8>) -> PyResult<answers::Maps> {
    let (options, scene) = (members(options)?, scene.map(scene::Scene::shared));
    pool::watched(py, None, move |progress| {
        let uavs = Source::held("uavs.csv", uavs);
        Ok(answers::Maps::from(skyshed::cli::map_tile(options, (scene, uavs), progress)?))
    })
}

/// Returns the grid of a raster that is read in parts; ``None`` of any other scene.
#[pyfunction]
fn raster_grid(py: Python<'_>, word: OsString, options: &str) -> PyResult<Option<place::Place>> {
    let options = members(options)?;
    pool::watched(py, None, move |_| Ok(skyshed::cli::raster_grid(&word, options)?.map(|grid| place::place_of(&grid))))
}

/// Refuses work that would take this process above so many bytes.
#[pyfunction]
fn limit_memory(bytes: u64) {
    skyshed::cli::limit_memory(bytes);
}

/// Runs the program on a command line and returns its exit code.
#[pyfunction]
fn main(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| skyshed::cli::exit_code(words))
}

/// Token that watches a run.
type Watched = Arc<skyshed::Progress>;
