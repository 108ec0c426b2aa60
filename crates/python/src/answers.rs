//! Answers: maps whose arrays are borrowed, not copied, and documents with tables.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::ndarray::ArrayView2;
use numpy::{Element, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use skyshed::cli;
use skyshed::{Coverages, Layer, Warning};

use crate::errors::{Failure, in_python};
use crate::members;
use crate::place::{Place, place_of};
use crate::pool::watched;

/// A warning: code and text.
pub(crate) type Told = (String, String);

pub(crate) fn told(warnings: &[Warning]) -> Vec<Told> {
    let words = |warning: &Warning| {
        let hint = cli::hint_of(warning).map_or_else(String::new, |hint| format!(" ({hint})"));
        in_python(&format!("{warning}{hint}"))
    };
    warnings.iter().map(|warning| (warning.code(), words(warning))).collect()
}

/// An answer in words and numbers.
#[pyclass(frozen, get_all, module = "skyshed._skyshed")]
pub(crate) struct Found {
    /// The document as JSON.
    document: String,
    table: Vec<Vec<String>>,
    warnings: Vec<Told>,
    files: Vec<PathBuf>,
}

impl From<cli::Found> for Found {
    fn from(found: cli::Found) -> Found {
        let cli::Found { document, table, warnings, files } = found;
        Found { document: document.to_string(), table, warnings: told(&warnings), files }
    }
}

/// Coverage of some UAVs.
#[pyclass(frozen, module = "skyshed._skyshed")]
pub(crate) struct Maps(Arc<Coverages>);

impl From<Coverages> for Maps {
    fn from(coverages: Coverages) -> Maps {
        Maps(Arc::new(coverages))
    }
}

impl Maps {
    /// Cells of one of the maps as an array that cannot be written, without a copy.
    fn lent<'py, T: Element>(this: &Bound<'py, Self>, cells: &[T]) -> PyResult<Bound<'py, PyArray2<T>>> {
        let grid = this.get().0.grid();
        let view = ArrayView2::from_shape((grid.n_rows(), grid.n_cols()), cells)
            .map_err(|_| Failure::Fault("a layer has another shape than its grid".into()))?;
        #[expect(unsafe_code, reason = "rust-numpy has no other way to lend memory")]
        // SAFETY: the cells belong to the maps, which never change and live as long as the array, whose owner they are.
        let array = unsafe { PyArray2::borrow_from_array(&view, this.clone().into_any()) };
        // Not by a borrow of rust-numpy: the same cells may be lent and read elsewhere.
        array.call_method1("setflags", (false,))?;
        Ok(array)
    }
}

fn no_such() -> PyErr {
    PyIndexError::new_err("no such map, or it was not kept")
}

#[pymethods]
impl Maps {
    /// The classes of one UAV.
    fn mask<'py>(slf: &Bound<'py, Self>, site: usize) -> PyResult<Bound<'py, PyArray2<u8>>> {
        Maps::lent(slf, slf.get().0.mask(site).ok_or_else(no_such)?)
    }

    /// A layer of one UAV.
    fn layer<'py>(slf: &Bound<'py, Self>, site: usize, name: &str) -> PyResult<Option<Bound<'py, PyArray2<f32>>>> {
        use Layer::{LeastHeight, LeastReceiverHeight, Margin, PLos, Stability, Sure};
        let layers = [Margin, LeastReceiverHeight, LeastHeight, Stability, Sure, PLos];
        let layer = layers.into_iter().find(|layer| layer.name() == name);
        let cells = layer.and_then(|layer| slf.get().0.layer(site, layer));
        cells.map(|cells| Maps::lent(slf, cells)).transpose()
    }

    /// The classes of all UAVs together.
    fn union<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        Maps::lent(slf, slf.get().0.union_mask().ok_or_else(no_such)?)
    }

    /// Number of UAVs that see each cell.
    fn count<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let grid = self.0.grid();
        let counts = numpy::PyArray1::from_vec(py, self.0.count());
        counts.reshape([grid.n_rows(), grid.n_cols()])
    }

    /// A layer of all UAVs together, if that was asked for.
    fn together<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let maps = &slf.get().0;
        let measure = match name {
            "all" => return Ok(Maps::lent(slf, maps.all_mask().ok_or_else(no_such)?)?.into_any()),
            "best-server" => return Ok(Maps::lent(slf, maps.best_server().ok_or_else(no_such)?)?.into_any()),
            "uptime" => maps.uptime(),
            "gap" => maps.gap(),
            _ => None,
        };
        Ok(Maps::lent(slf, measure.ok_or_else(no_such)?)?.into_any())
    }

    /// UAVs that cannot be at their place and were left out, by their ids, and why.
    #[getter]
    fn left_out(&self) -> Vec<(String, String)> {
        cli::left_out(&self.0)
    }

    /// The document as JSON.
    fn document(&self) -> String {
        self.0.document().to_string()
    }

    /// Receivers in range of each UAV.
    fn receivers(&self) -> Vec<u64> {
        self.0.sites().iter().map(|site| site.tally.receivers).collect()
    }

    /// `P_LoS` of each UAV; NaN where it is undefined.
    fn p_los(&self) -> Vec<f64> {
        self.0.sites().iter().map(|site| site.tally.p_los().unwrap_or(f64::NAN)).collect()
    }

    /// `P_LoS` of all UAVs together; NaN where it is undefined.
    fn union_p_los(&self) -> f64 {
        self.0.union().p_los().unwrap_or(f64::NAN)
    }

    #[getter]
    fn ids(&self) -> Vec<String> {
        self.0.sites().iter().map(|site| site.id.clone()).collect()
    }

    #[getter]
    fn digest(&self) -> &str {
        self.0.digest()
    }

    #[getter]
    fn place(&self) -> Place {
        place_of(self.0.grid())
    }

    #[getter]
    fn warnings(&self) -> Vec<Told> {
        told(self.0.warnings())
    }

    /// Writes files.
    fn save(&self, py: Python<'_>, paths: Vec<PathBuf>, options: &str) -> PyResult<()> {
        let (maps, options) = (Arc::clone(&self.0), members(options)?);
        watched(py, None, move |_| {
            let options = cli::save_options(options, &paths)?;
            Ok(maps.save_all(&paths, &options)?)
        })
    }

    /// The picture as PNG.
    fn picture(&self, py: Python<'_>, options: &str) -> PyResult<Py<PyBytes>> {
        let (maps, options) = (Arc::clone(&self.0), members(options)?);
        let png = watched(py, None, move |_| Ok(maps.png(&cli::save_options(options, &["map.png".into()])?)?))?;
        Ok(PyBytes::new(py, &png).unbind())
    }

    /// P_LoS against the height of each UAV.
    #[pyo3(signature = (heights, watch=None))]
    fn height_curves(&self, py: Python<'_>, heights: Option<[f64; 3]>, watch: Option<Py<PyAny>>) -> PyResult<Found> {
        let maps = Arc::clone(&self.0);
        watched(py, watch, move |progress| Ok(cli::height_curves(&maps, heights, progress)?)).map(Found::from)
    }
}
