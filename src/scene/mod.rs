//! A scene made ready for rays, and how it is read.

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
pub(crate) use reading::{FoundRepairs, built_up, is_raster, is_raster_scene};

use crate::answer::{RunFacts, Timing};
use crate::error::{Result, Warning};
use crate::height_field::{Built, HeightField};
use crate::los::Method;
use crate::memory::{FIELD_BYTES_PER_CELL, check_memory};
use crate::picture::Look;
use crate::raster::{CellWindow, GeoRef};
use crate::zones::ZoneMap;

/// A city ready for rays: footprints, a surface model, a mesh or a generated city, over a grid of cells.
///
/// Copies share the city. Positions and extents are in units of the scene's reference system, names that end in `_m` in
/// meters. A
/// file in degrees is refused (E310) unless it is brought into another system.
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
    /// As it was asked for: a path, or the word for a generated city.
    pub(crate) word: String,
    pub(crate) name: String,
    pub(crate) field: Arc<HeightField>,
    /// Its zones, once they are found.
    pub(crate) zones: Arc<OnceLock<Option<Arc<ZoneMap>>>>,
    /// What it was built from, if that was to be kept.
    pub(crate) solids: Option<Arc<Solids>>,
    pub(crate) sources: Vec<Source>,
    /// Whom pictures must credit.
    pub(crate) attribution: Option<String>,
    /// Footprints without heights, where there are any.
    pub(crate) heights: Option<HeightSources>,
    pub(crate) built_up: Option<BuiltUp>,
    /// The seed of everything random about it.
    pub(crate) seed: u64,
    pub(crate) warnings: Vec<Warning>,
    pub(crate) timing: Timing,
}

impl Scene {
    /// Opens any scene that the program reads: see [`SceneReader::open`].
    ///
    /// # Errors
    /// As that.
    pub fn open(word: impl AsRef<OsStr>) -> Result<Scene> {
        Scene::options().open(word)
    }

    /// Returns a reader of scenes with all options at their defaults.
    pub fn options() -> SceneReader {
        SceneReader::default()
    }

    /// A scene that was read since `start`, with its height field.
    pub(crate) fn built(
        options: &SceneReader,
        (word, scene): (&OsStr, City),
        mut warnings: Vec<Warning>,
        start: Instant,
    ) -> Result<Scene> {
        let read_s = start.elapsed().as_secs_f64();
        let City { name, grid, solids, built_up, sources, attribution, heights } = scene;
        // Heights of a raster are there already.
        if matches!(solids, Solids::Vector { .. }) {
            check_memory(&word.display(), &grid, FIELD_BYTES_PER_CELL)?;
        }
        // Those of a raster are in its field.
        let is_kept = options.keeps_solids && matches!(solids, Solids::Vector { .. });
        let kept = is_kept.then(|| Arc::new(solids.clone()));
        let Built { field, warnings: odd } = HeightField::build(&grid, solids);
        warnings.extend(odd.into_iter().map(Warning::Core));
        let build = start.elapsed().as_secs_f64() - read_s;
        Ok(Scene {
            word: word.display().to_string(),
            name,
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

    /// A field alone, with what was said of it.
    pub(crate) fn of_field(name: String, field: HeightField, warnings: Vec<Warning>) -> Scene {
        Scene {
            word: name.clone(),
            name,
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

    /// Cuts a raster scene to some of its cells; others are left whole.
    pub(crate) fn cut(&mut self, window: CellWindow) {
        if window != self.grid().window()
            && let Some(part) = self.field.part(window)
        {
            self.replace_field(part);
        }
    }

    /// Leaves the receivers of a window alone: a raster keeps the cells around, which stand in the way.
    pub(crate) fn keep_for(&mut self, receivers: CellWindow, around: CellWindow) {
        match self.field.prisms() {
            Some(_) => self.show(receivers),
            None => self.cut(around),
        }
    }

    /// Leaves the receivers of a window alone, and of a raster nothing else.
    pub(crate) fn show(&mut self, window: CellWindow) {
        if window != self.grid().window() {
            let shown = self.field.shown(window);
            self.replace_field(shown);
        }
    }

    /// What it was built from; `None` of footprints that were not kept.
    pub(crate) fn solids(&self) -> Option<Cow<'_, Solids>> {
        let of_raster = || self.field.solids_of(self.grid().window()).map(Cow::Owned);
        self.solids.as_deref().map(Cow::Borrowed).or_else(of_raster)
    }

    /// Takes another field for its own.
    pub(crate) fn replace_field(&mut self, field: HeightField) {
        (self.field, self.solids, self.zones) = (Arc::new(field), None, Arc::default());
    }

    /// What it is called in titles.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The cells: shape, extent, reference system.
    pub fn grid(&self) -> &GeoRef {
        self.field.grid()
    }

    /// What was odd about its files.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Its zones (streets, crossroads, courtyards, rooftops), found once; `None` where no building is known.
    pub fn zones(&self) -> Option<Arc<ZoneMap>> {
        let find = || ZoneMap::if_known(&self.field, self.built_up.as_ref()).map(Arc::new);
        self.zones.get_or_init(find).clone()
    }

    /// What documents say of a run over it.
    pub(crate) fn facts(&self, method: Option<Method>) -> RunFacts {
        RunFacts {
            command: Vec::new(),
            method,
            scene_name: self.name.clone(),
            grid: self.grid().clone(),
            sources: self.sources.clone(),
            seed: self.built_up.map(|_| self.seed),
            warnings: self.warnings.clone(),
            request: None,
            unit: None,
        }
    }

    /// What limits the truth of a picture of it.
    pub(crate) fn limits_in_words(&self) -> Option<String> {
        limits::limits_in_words(self.heights.as_ref(), &self.field, &self.warnings)
    }

    /// The last lines of a caption: what limits the truth of a picture of it, and whom to credit.
    pub(crate) fn last_lines(&self, look: &Look) -> Vec<String> {
        self.limits_in_words().into_iter().chain(look.credit(self.attribution.as_ref())).collect()
    }
}
