//! Scenes: opened, made of arrays or buildings, asked.

use std::ffi::OsString;
use std::sync::atomic::AtomicBool;

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use skyshed::cli;
use skyshed::{Antenna, Height, SceneReader, Source, Uav};
use skyshed_core::raster::GeoRef;
use skyshed_io::read::HeldBuilding;

use crate::answers::{Maps, Told, told};
use crate::arrays::{Heights, Rows, held};
use crate::errors::Failure;
use crate::links::{self, AskedReceiver, LinkTable, QuickLink};
use crate::members;
use crate::place::{Place, place_of};
use crate::pool::{lent, watched};

/// A city ready for rays; copies share it.
#[pyclass(frozen, module = "skyshed._skyshed")]
pub(crate) struct Scene(skyshed::Scene);

/// A height as it is asked for: above ground \[m\], or in words such as `30roof`.
#[derive(FromPyObject)]
pub(crate) enum AskedHeight {
    Above(f64),
    Said(String),
}

/// Limits of an antenna: least distance, azimuths, elevations, beam, slant range.
pub(crate) type AskedAntenna = (Option<f64>, Option<[f64; 2]>, Option<[f64; 2]>, Option<f64>, Option<f64>);

/// A UAV as it is asked for: east, north, height, name, its own antenna, from when to when it is up.
pub(crate) type AskedUav = (f64, f64, AskedHeight, Option<String>, AskedAntenna, [Option<String>; 2]);

/// An array: its name, west edge, width of a cell, north edge, height of a cell, what stands for no height, and whether its
/// bytes are turned around.
type Lent<'py> = (String, Heights<'py>, (f64, f64, f64, f64), Option<String>, Option<f64>, bool);

struct Held<'py> {
    name: String,
    array: Heights<'py>,
    place: (f64, f64, f64, f64),
    crs: Option<String>,
    nodata: Option<f64>,
    is_swapped: bool,
}

impl<'py> From<Lent<'py>> for Held<'py> {
    fn from((name, array, place, crs, nodata, is_swapped): Lent<'py>) -> Self {
        Held { name, array, place, crs, nodata, is_swapped }
    }
}

impl Held<'_> {
    fn georef(&self) -> Result<GeoRef, Failure> {
        let (west, width, north, height) = self.place;
        let crs = self.crs.as_deref().map(skyshed_io::crs::parse).transpose();
        let crs = crs.map_err(|error| cli::Refusal::from(error).about("crs"))?;
        let (n_rows, n_cols) = self.array.shape;
        GeoRef::new((west, north), (width, height), (n_rows, n_cols), crs).ok_or_else(|| {
            let cells = format!("{n_rows}×{n_cols} cells of {width} × {height} from ({west}, {north})");
            cli::Refusal::of_grid(format!("transform: {cells} are no grid")).into()
        })
    }

    fn rows<'a>(&'a self, stop: &'a AtomicBool) -> Rows<'a> {
        self.array.rows(self.is_swapped, self.nodata, stop)
    }
}

/// Returns the height that was asked for.
pub(crate) fn height_of(asked: AskedHeight) -> Result<Height, Failure> {
    match asked {
        AskedHeight::Above(height_m) => Ok(Height::agl(height_m)),
        AskedHeight::Said(text) => Ok(text.parse().map_err(|text: String| cli::Refusal::of_uav(&text))?),
    }
}

pub(crate) fn uavs_of(asked: Vec<AskedUav>) -> Result<Vec<Uav>, Failure> {
    let uav = |(x, y, height, name, (min_radius_m, sector_deg, elevation_deg, beam_deg, slant_range_m), [from, to]): AskedUav| {
        let height = height_of(height)?;
        let antenna = Antenna { min_radius_m, sector_deg, elevation_deg, beam_deg, slant_range_m };
        let up = skyshed_io::read::up_time(from.as_deref(), to.as_deref());
        let up = up.map_err(|text| cli::Refusal::of_uav(&text))?;
        let uav = Uav::new(x, y, height).with_antenna(antenna).up(up);
        Ok(match name {
            Some(name) => uav.named(name),
            None => uav,
        })
    };
    asked.into_iter().map(uav).collect()
}

fn kept(options: &str) -> Result<SceneReader, Failure> {
    Ok(cli::scene_reader(members(options)?)?.keeps_footprints())
}

impl Scene {
    /// Returns the scene, which shares all that it holds.
    pub(crate) fn shared(&self) -> skyshed::Scene {
        self.0.clone()
    }
}

#[pymethods]
impl Scene {
    /// Opens a file, or makes a generated city.
    #[staticmethod]
    #[pyo3(signature = (word, options, watch=None))]
    fn open(py: Python<'_>, word: OsString, options: &str, watch: Option<Py<PyAny>>) -> PyResult<Scene> {
        let reader = kept(options)?;
        watched(py, watch, move |_| Ok(Scene(reader.open(word)?)))
    }

    /// A scene of heights.
    #[staticmethod]
    fn of_heights(py: Python<'_>, surface: Lent<'_>, terrain: Option<Lent<'_>>, options: &str) -> PyResult<Scene> {
        let options = kept(options)?;
        let (surface, terrain) = (Held::from(surface), terrain.map(Held::from));
        let stop = AtomicBool::new(false);
        let parts = [Some(&surface), terrain.as_ref()].into_iter().flatten();
        let parts: Vec<(String, GeoRef, Rows<'_>)> = parts
            .map(|part| Ok((part.name.clone(), part.georef()?, part.rows(&stop))))
            .collect::<Result<_, Failure>>()?;
        let held = lent(py, &stop, || {
            parts.iter().map(|(name, georef, rows)| held(name, georef.clone(), rows)).collect::<Result<Vec<_>, _>>()
        })?;
        let name = surface.name.clone();
        watched(py, None, move |_| {
            let mut held = held.into_iter();
            let surface = held.next().ok_or_else(|| Failure::Fault("no surface".into()))?;
            Ok(Scene(options.of_heights(&name, surface, held.next())?))
        })
    }

    /// A scene of buildings: well-known binary, heights and names.
    #[staticmethod]
    fn of_buildings(
        py: Python<'_>,
        name: String,
        wkb: Vec<Py<PyBytes>>,
        heights: PyReadonlyArray1<'_, f64>,
        ids: Option<Vec<String>>,
        options: &str,
    ) -> PyResult<Scene> {
        let options = kept(options)?;
        let wkb: Vec<Vec<u8>> = wkb.iter().map(|bytes| bytes.as_bytes(py).to_vec()).collect();
        let heights = heights.as_array().to_vec();
        watched(py, None, move |_| {
            let named = |k: usize| ids.as_ref().and_then(|ids| ids.get(k).cloned());
            let buildings = wkb.iter().zip(&heights).enumerate();
            let buildings: Vec<HeldBuilding<'_>> =
                buildings.map(|(k, (wkb, height))| HeldBuilding { id: named(k), wkb, height: *height }).collect();
            Ok(Scene(options.of_buildings(&name, &buildings)?))
        })
    }

    /// The scene of packed bytes.
    #[staticmethod]
    fn unpacked(py: Python<'_>, name: String, bytes: Vec<u8>, crs: Option<String>) -> PyResult<Scene> {
        watched(py, None, move |_| Ok(Scene(skyshed::Scene::unpacked(&name, &bytes, crs.as_deref())?)))
    }

    /// Data that the scene was built from, as bytes.
    fn packed(&self, py: Python<'_>) -> PyResult<Py<PyBytes>> {
        let scene = self.0.clone();
        let packed =
            watched(py, None, move |_| scene.packed().ok_or_else(|| Failure::Fault("nothing was kept".into())))?;
        Ok(PyBytes::new(py, &packed).unbind())
    }

    /// Coverage of some UAVs.
    #[pyo3(signature = (uavs, options, keeps_masks, watch=None))]
    fn maps(
        &self,
        py: Python<'_>,
        uavs: Vec<AskedUav>,
        options: &str,
        keeps_masks: bool,
        watch: Option<Py<PyAny>>,
    ) -> PyResult<Maps> {
        let (scene, uavs, options) = (self.0.clone(), uavs_of(uavs)?, members(options)?);
        watched(py, watch, move |progress| {
            Ok(Maps::from(cli::coverages((scene, &uavs), options, keeps_masks, progress)?))
        })
    }

    /// `P_LoS` of each UAV; NaN where it is undefined.
    #[pyo3(signature = (uavs, options, watch=None))]
    fn p_los<'py>(
        &self,
        py: Python<'py>,
        uavs: Vec<AskedUav>,
        options: &str,
        watch: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (scene, uavs, options) = (self.0.clone(), uavs_of(uavs)?, members(options)?);
        let p_los = watched(py, watch, move |progress| Ok(cli::p_los((scene, &uavs), options, progress)?))?;
        Ok(PyArray1::from_iter(py, p_los.into_iter().map(|p| p.unwrap_or(f64::NAN))))
    }

    /// One link.
    fn link(&self, uav: (f64, f64, AskedHeight), rx: AskedReceiver) -> PyResult<QuickLink> {
        links::link(&self.0, uav, rx)
    }

    /// Links between UAVs and receivers.
    #[pyo3(signature = (uavs, receivers, options, watch=None))]
    fn links<'py>(
        &self,
        py: Python<'py>,
        uavs: Vec<AskedUav>,
        receivers: Vec<AskedReceiver>,
        options: &str,
        watch: Option<Py<PyAny>>,
    ) -> PyResult<LinkTable<'py>> {
        links::links(py, (self.0.clone(), uavs), receivers, options, watch)
    }

    /// The live page, with a track by its path, or by a name and bytes.
    fn live_page(
        &self,
        py: Python<'_>,
        uavs: Vec<AskedUav>,
        track: Option<(OsString, Option<Vec<u8>>)>,
        word: OsString,
        options: &str,
    ) -> PyResult<String> {
        let (scene, uavs, options) = (self.0.clone(), uavs_of(uavs)?, members(options)?);
        let track = track.map(|(name, bytes)| match bytes {
            Some(bytes) => Source::held(name, bytes),
            None => Source::from(name),
        });
        watched(py, None, move |_| Ok(cli::live_page(&scene, (&uavs, track), (&word, options))?))
    }

    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    #[getter]
    fn place(&self) -> Place {
        place_of(self.0.grid())
    }

    #[getter]
    fn warnings(&self) -> Vec<Told> {
        told(self.0.warnings())
    }
}
