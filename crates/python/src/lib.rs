//! The extension module of the Python package `skyshed`: scenes, maps and questions as plain calls. `python/skyshed` makes them
//! pleasant; words of options are those of the command line.

mod arrays;
mod answers;
mod errors;
mod pool;
mod scene;

use std::ffi::OsString;
use std::sync::Arc;

use pyo3::prelude::*;

#[pymodule(gil_used = false)]
mod _skyshed {
    #[pymodule_export]
    use super::answers::{Found, Maps};
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::{ask, limit_memory, main, raster_grid};
}

/// Asks a command of the program in its words.
#[pyfunction]
#[pyo3(signature = (words, watch=None))]
fn ask(py: Python<'_>, words: Vec<OsString>, watch: Option<Py<PyAny>>) -> PyResult<answers::Found> {
    pool::watched(py, watch, move |progress| Ok(skyshed::cli::ask(words, (None, Vec::new()), progress)?))
        .map(answers::Found::from)
}

/// Where the cells lie of a scene of which a run reads no more than it needs; ``None`` of any other.
#[pyfunction]
fn raster_grid(py: Python<'_>, word: OsString, words: Vec<OsString>) -> PyResult<Option<scene::Place>> {
    pool::watched(py, None, move |_| Ok(skyshed::cli::raster_grid(&word, &words)?.map(|grid| scene::place_of(&grid))))
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

/// What a run is watched by.
type Watched = Arc<skyshed::Progress>;
