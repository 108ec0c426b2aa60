//! Scenes, ready for line of sight, and their readers.

pub(crate) mod limits;
mod held;
mod options;
mod reading;
pub(crate) mod placing;
pub(crate) mod results;

use std::borrow::Cow;
use std::ffi::OsStr;
use std::sync::{Arc, OnceLock};
use std::time::Instant;

use crate::city::{BuiltUp, City, HeightSources, Solids, Source};
pub use options::SceneReader;
pub(crate) use reading::{FoundRepairs, built_up, files_of, format_of, has_heights_above_datum, is_raster_scene};

use crate::answer::{CommandFacts, RunFacts, Timing};
use crate::error::{Result, Warning};
use crate::height_field::{Built, HeightField};
use crate::los::Method;
use crate::memory::{FIELD_BYTES_PER_CELL, Needs, check_memory};
use crate::picture::Look;
use crate::raster::{CellWindow, GeoRef};
use crate::zones::ZoneMap;

/// A city ready for line of sight: footprints, a surface model, a mesh or a generated city, over a
/// grid of cells.
///
/// Copies share the city. Positions and extents are in units of the scene's reference system, names
/// that end in `_m` in meters. A file in degrees is refused (E310) unless it is brought into
/// another system.
///
/// ```
/// use skyshed::prelude::*;
///
/// let city = Scene::options().size(200.0).seed(7).open("itu:urban")?;
/// let seen = city.coverage(Uav::new(100.0, 100.0, Height::agl(120.0))).run()?;
/// assert!(seen.p_los().is_some_and(|p| p > 0.5));
/// # Ok::<(), skyshed::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Scene {
    /// The word that the user wrote: a path, or a generated city.
    pub(crate) word: String,
    pub(crate) name: String,
    /// Options that the scene was read with.
    pub(crate) options: Arc<SceneReader>,
    pub(crate) field: Arc<HeightField>,
    /// Zones, once they are found.
    pub(crate) zones: Arc<OnceLock<skyshed_core::Result<Option<Arc<ZoneMap>>>>>,
    /// The data that the scene was built from, if it was kept.
    pub(crate) solids: Option<Arc<Solids>>,
    pub(crate) sources: Vec<Source>,
    /// Attribution that pictures must show.
    pub(crate) attribution: Option<String>,
    /// Sources of the heights of footprints.
    pub(crate) heights: Option<HeightSources>,
    pub(crate) built_up: Option<BuiltUp>,
    /// Seed of everything random in the scene.
    pub(crate) seed: u64,
    pub(crate) warnings: Vec<Warning>,
    pub(crate) timing: Timing,
}

impl Scene {
    /// Opens any scene that the program reads: see [`SceneReader::open`].
    ///
    /// # Errors
    /// As [`SceneReader::open`].
    pub fn open(word: impl AsRef<OsStr>) -> Result<Scene> {
        Scene::options().open(word)
    }

    /// Returns a reader of scenes with all options at their defaults.
    pub fn options() -> SceneReader {
        SceneReader::default()
    }

    /// Builds a scene from a city that was read since `start`.
    pub(crate) fn built(
        options: &SceneReader,
        (word, scene): (&OsStr, City),
        mut warnings: Vec<Warning>,
        start: Instant,
    ) -> Result<Scene> {
        let read_s = start.elapsed().as_secs_f64();
        let City { name, grid, solids, built_up, sources, attribution, heights } = scene;
        // Heights of a raster are in memory already.
        if matches!(solids, Solids::Vector { .. }) {
            check_memory(&word.display(), &grid, FIELD_BYTES_PER_CELL)?;
        }
        // The solids of a raster are in its field.
        let is_kept = options.keeps_solids && matches!(solids, Solids::Vector { .. });
        let kept = is_kept.then(|| Arc::new(solids.clone()));
        let Built { field, warnings: odd } = HeightField::build(&grid, solids);
        warnings.extend(odd.into_iter().map(Warning::from));
        let build = start.elapsed().as_secs_f64() - read_s;
        Ok(Scene {
            word: word.display().to_string(),
            name,
            options: Arc::new(options.clone()),
            field: Arc::new(field),
            zones: Arc::default(),
            solids: kept,
            sources,
            attribution,
            heights,
            built_up,
            seed: options.options.seed_or_default(),
            warnings,
            timing: Timing { read: read_s, build, ..Timing::default() },
        })
    }

    /// Wraps a height field, with its warnings.
    pub(crate) fn of_field(name: String, field: HeightField, warnings: Vec<Warning>) -> Scene {
        Scene {
            word: name.clone(),
            name,
            options: Arc::default(),
            field: Arc::new(field),
            zones: Arc::default(),
            solids: None,
            sources: Vec::new(),
            attribution: None,
            heights: None,
            built_up: None,
            seed: 1,
            warnings,
            timing: Timing::default(),
        }
    }

    /// Cuts a raster scene to some of its cells. Other scenes stay whole.
    pub(crate) fn cut(&mut self, window: CellWindow) {
        if window != self.grid().window()
            && let Some(part) = self.field.part(window)
        {
            self.replace_field(part);
        }
    }

    /// Keeps only the receivers of a window. A raster also keeps the cells `around`, which may
    /// obstruct.
    pub(crate) fn keep_for(&mut self, receivers: CellWindow, around: CellWindow) {
        match self.field.prisms() {
            Some(_) => self.show(receivers),
            None => self.cut(around),
        }
    }

    /// Keeps only the receivers of a window, and only these cells of a raster.
    pub(crate) fn show(&mut self, window: CellWindow) {
        if window != self.grid().window() {
            let shown = self.field.shown(window);
            self.replace_field(shown);
        }
    }

    /// Returns the data that the scene was built from; `None` for footprints that were not kept.
    pub(crate) fn solids(&self) -> Option<Cow<'_, Solids>> {
        let of_raster = || self.field.solids_of(self.grid().window()).map(Cow::Owned);
        self.solids.as_deref().map(Cow::Borrowed).or_else(of_raster)
    }

    /// Replaces the field, and drops everything derived from the old one.
    pub(crate) fn replace_field(&mut self, field: HeightField) {
        (self.field, self.solids, self.zones) = (Arc::new(field), None, Arc::default());
    }

    /// Returns the name in titles.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the grid of cells: shape, extent, reference system.
    pub fn grid(&self) -> &GeoRef {
        self.field.grid()
    }

    /// Returns the warnings about the scene's files.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Returns the zones (streets, crossroads, courtyards, rooftops), computed once. `None` where
    /// no building is known.
    ///
    /// # Errors
    /// E501 if they take more memory than there is; E504 for outlines that cross one another too
    /// often.
    pub fn zones(&self) -> Result<Option<Arc<ZoneMap>>> {
        if self.zones.get().is_none() {
            Needs::ZONES.check(self)?;
        }
        let find = || Ok(ZoneMap::if_known(&self.field, self.built_up.as_ref())?.map(Arc::new));
        Ok(self.zones.get_or_init(find).clone()?)
    }

    /// Returns the facts of a run over the scene, for documents.
    pub(crate) fn facts(&self, method: Option<Method>) -> RunFacts {
        RunFacts {
            command: CommandFacts::default(),
            method,
            scene_name: self.name.clone(),
            grid: self.grid().clone(),
            sources: self.sources.clone(),
            seed: self.built_up.map(|_| self.seed),
            warnings: self.warnings.clone(),
            unit: None,
        }
    }

    /// Returns the limits of the accuracy of its pictures, in words.
    pub(crate) fn limits_in_words(&self) -> Option<String> {
        limits::limits_in_words(self.heights.as_ref(), &self.field, &self.warnings)
    }

    /// Returns the last lines of a caption: limits of the accuracy, and the attribution.
    pub(crate) fn last_lines(&self, look: &Look) -> Vec<String> {
        self.limits_in_words().into_iter().chain(look.credit(self.attribution.as_ref())).collect()
    }
}
