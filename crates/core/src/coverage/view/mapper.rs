//! A scene and options made ready for any number of UAVs.

use std::borrow::Cow;
use std::sync::Arc;

use super::moved_roofs::{HeightBounds, MovedRoofs, UncertainHeights};
use super::scene::check_roofs;
use crate::coverage::elevation::padded_xs;
use crate::coverage::{HeightLayers, MapOptions};
use crate::error::{MapError, Result};
use crate::height_field::{Casters, GridPositions, HeightField, Station};
use crate::los::{GridLos, GridReceivers, Method, ShadowGrid, UavPositions, WrongMethod};
use crate::quantity::LatticePoint;
use crate::raster::BitGrid;

/// Scene and options made ready for any number of UAVs.
///
/// Questions about one UAV are methods of its [`View`](super::View), made by [`Mapper::seen_from`].
/// Nothing else can reach the engines.
#[derive(Debug)]
pub struct Mapper<'a> {
    pub(in crate::coverage) field: &'a HeightField,
    pub(in crate::coverage) options: MapOptions,
    /// Engine whose work all threads share.
    pub(super) engine: GridLos<'a>,
    /// Engine for many UAVs, each of which has a thread of its own.
    pub(super) alone: GridLos<'a>,
    why: &'static str,
    /// Receivers, kind by kind, as [`Receivers::stands`](crate::coverage::Receivers) lists them.
    pub(in crate::coverage) receivers: Vec<GridReceivers<'a>>,
    /// World x of the columns of cells, whole words of them \[CRS units\].
    pub(super) xs: Vec<f64>,
    pub(in crate::coverage) layers: LayerScenes,
}

/// Scenes with moved roofs that layers of maps ask for.
#[derive(Debug, Default)]
pub(in crate::coverage) struct LayerScenes {
    /// Roofs a step higher and a step lower, each `None` if one would leave ±32 768 m; for the
    /// layer of stability.
    pub(in crate::coverage) by_one_step: Option<[Option<MovedRoofs>; 2]>,
    /// Bounds on heights for the layer `sure`.
    pub(in crate::coverage) sure: Option<HeightBounds>,
    /// Errors of heights for the layer `p_los`.
    pub(in crate::coverage) p_los: Option<UncertainHeights>,
}

impl<'a> Mapper<'a> {
    /// Makes ready what does not depend on the UAV.
    ///
    /// # Errors
    /// E118 if the options ask for an engine that cannot decide this scene, for layers of heights
    /// beside an approximate one, or for roofs that slope over a curved earth.
    pub fn new(field: &'a HeightField, options: &MapOptions) -> Result<Self> {
        let (method, why) = Method::choose(field, options.method).map_err(refused)?;
        if !method.is_exact() && options.layers != HeightLayers::default() {
            return Err(MapError::ApproximateLayers { method: method.name() }.into());
        }
        if options.curvature.is_some() {
            check_roofs(field)?;
        }
        let shape = (field.grid().n_rows(), field.grid().n_cols());
        let window = options.window.map(|window| BitGrid::of_window(shape, window));
        let sets: Vec<&BitGrid> = options.within.iter().chain(&window).collect();
        let receivers = options.receivers.stands().iter().map(|stand| {
            let all = stand.cells(field, options.rx_height);
            let cells = sets.iter().fold(all, |cells, set| Cow::Owned(cells.into_owned().and(set)));
            GridReceivers::new(cells, stand.heights(field), options.rx_height)
        });
        let receivers = receivers.collect();
        let engine = GridLos::new(field, method).map_err(refused)?;
        let mut alone = engine.clone();
        alone.is_one_band = true;
        let by_one_step = || [1, -1].map(|step| MovedRoofs::by_building(field, |_| step));
        let layers = LayerScenes { by_one_step: options.layers.stability.then(by_one_step), ..LayerScenes::default() };
        let (options, xs) = (options.clone(), padded_xs(field.grid()));
        Ok(Mapper { field, options, engine, alone, why, receivers, xs, layers })
    }

    /// Makes ready the layers that depend on errors of heights: maps have none without this.
    ///
    /// # Errors
    /// E118 for errors that cannot be, and for probabilities of a raster.
    pub fn with_height_errors(mut self) -> Result<Self> {
        let MapOptions { height_errors, sigma, layers, .. } = &self.options;
        if layers.p_los && self.field.prisms().is_none() {
            return Err(MapError::RasterProbabilities.into());
        }
        let bounds = || HeightBounds::within(self.field, height_errors, *sigma).ok_or(MapError::HeightErrors);
        let errors = || UncertainHeights::of(self.field, height_errors).ok_or(MapError::HeightErrors);
        self.layers.sure = layers.sure.then(bounds).transpose()?;
        self.layers.p_los = layers.p_los.then(errors).transpose()?;
        Ok(self)
    }

    /// Returns the scene.
    pub fn field(&self) -> &'a HeightField {
        self.field
    }

    /// Returns the engine that decides, and why it was chosen.
    pub fn method(&self) -> (Method, &'static str) {
        (self.engine.method(), self.why)
    }

    /// Returns whether heights of receivers leave some out of range of the antenna of the run.
    pub fn limits_heights(&self) -> bool {
        self.options.antenna.limits_heights()
    }

    /// Returns the cells that hold receivers, in range or not.
    pub fn receiver_cells(&self) -> BitGrid {
        let grid = self.field.grid();
        let none = BitGrid::new(grid.n_rows(), grid.n_cols());
        self.receivers.iter().fold(none, |all, receivers| all.or(&receivers.cells))
    }

    /// Returns positions of the receivers.
    pub(in crate::coverage) fn positions(&self) -> &GridPositions {
        self.engine.positions()
    }

    /// Casts the shadows of these alone: none that is left out may hide a receiver from a UAV that
    /// will be asked about.
    pub(in crate::coverage) fn cast_only(&mut self, casters: Casters) {
        let casters = Some(Arc::new(casters));
        self.engine.casters.clone_from(&casters);
        self.alone.casters = casters;
    }

    /// Returns positions of UAVs over a grid, all at height `z` \[1/1024 m above the datum\], as
    /// receivers see them.
    ///
    /// `None` over a curved earth, where each UAV sees heights of its own, and unless the engine is
    /// `shadow` and knows these receivers.
    pub(in crate::coverage) fn uav_positions<'g>(&'g self, grid: &'g ShadowGrid, z: i64) -> Option<UavPositions<'g>> {
        let is_flat = self.options.curvature.is_none();
        is_flat.then(|| self.engine.uav_positions(grid, z, &self.receivers)).flatten()
    }

    /// Returns the number of casters, if the engine is `shadow`.
    pub(in crate::coverage) fn n_casters(&self) -> Option<usize> {
        self.engine.n_casters()
    }

    /// Returns an end of a link on the lattice of what casts shadows.
    pub(in crate::coverage) fn on_shadows(&self, station: &Station) -> LatticePoint {
        self.engine.on_shadows(station)
    }
}

/// Turns a method for other scenes into an error of maps.
pub(super) fn refused(wrong: WrongMethod) -> MapError {
    MapError::Method { why: wrong.why, instead: wrong.instead.name() }
}
