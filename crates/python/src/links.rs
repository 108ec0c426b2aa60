//! Links: one at once, or between lists as arrays.

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use skyshed::cli;
use skyshed::request::Receiver;
use skyshed::{Height, LinkArray, Uav};

use crate::answers::{Told, told};
use crate::errors::Failure;
use crate::members;
use crate::pool::watched;
use crate::scene::{AskedHeight, AskedUav, height_of, uavs_of};

/// Obstruction: kind, id, row, column, east, north, height of the ray, height of the obstacle.
type Obstruction = (&'static str, Option<String>, Option<usize>, Option<usize>, f64, f64, f64, Option<f64>);

/// Line of sight, margin, distance, elevation, obstruction, warnings.
pub(crate) type QuickLink = (bool, Option<f64>, f64, f64, Option<Obstruction>, Vec<Told>);

/// A receiver as it is asked for: east, north, height.
pub(crate) type AskedReceiver = (f64, f64, Option<AskedHeight>);

/// Arrays by their names, faults of UAVs and of receivers by their places, warnings.
pub(crate) type LinkTable<'py> = (Bound<'py, PyDict>, Vec<(usize, String)>, Vec<(usize, String)>, Vec<Told>);

/// Decides one link, in this thread.
pub(crate) fn link(scene: &skyshed::Scene, uav: (f64, f64, AskedHeight), rx: AskedReceiver) -> PyResult<QuickLink> {
    let uav = Uav::new(uav.0, uav.1, height_of(uav.2)?);
    let default = || Ok(Height::agl(Receiver::default().rx_height_m()));
    let height = rx.2.map_or_else(default, height_of)?;
    let link = scene.link(uav, (rx.0, rx.1), height).map_err(Failure::from)?;
    let obstruction = link
        .obstruction()
        .map(|of| (of.kind, of.id.clone(), of.row, of.col, of.x, of.y, of.ray_height_m, of.roof_height_m));
    let warnings = told(link.warnings().get(scene.warnings().len()..).unwrap_or_default());
    Ok((link.los(), link.margin_m(), link.distance_m(), link.elevation_deg(), obstruction, warnings))
}

/// Decides links between UAVs and receivers.
pub(crate) fn links<'py>(
    py: Python<'py>,
    (scene, uavs): (skyshed::Scene, Vec<AskedUav>),
    receivers: Vec<AskedReceiver>,
    options: &str,
    watch: Option<Py<PyAny>>,
) -> PyResult<LinkTable<'py>> {
    let (uavs, options) = (uavs_of(uavs)?, members(options)?);
    let receiver = |(x, y, height): AskedReceiver| Ok(((x, y), height.map(height_of).transpose()?));
    let receivers = receivers.into_iter().map(receiver).collect::<Result<Vec<_>, Failure>>()?;
    let found = watched(py, watch, move |_| Ok(cli::links((scene, &uavs), &receivers, options)?))?;
    let arrays = PyDict::new(py);
    for (name, array) in found.arrays {
        match array {
            LinkArray::U8(values, shape) => arrays.set_item(name, PyArray1::from_vec(py, values).reshape(shape)?)?,
            LinkArray::F64(values, shape) => arrays.set_item(name, PyArray1::from_vec(py, values).reshape(shape)?)?,
        }
    }
    let [of_uavs, of_receivers] = found.faults;
    Ok((arrays, of_uavs, of_receivers, told(&found.warnings)))
}
