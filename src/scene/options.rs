//! Reader of scenes: the options of a question, and settings that a run adds.

use std::sync::{Arc, OnceLock};

use skyshed_request::{GroundChoice, SceneOptions};

use super::reading::FoundRepairs;

/// Reader of scenes.
///
/// An option that is not set has the default of the program. An option that does not apply to the
/// kind of scene is an error.
///
/// ```
/// use skyshed::prelude::*;
///
/// let city = Scene::options().size(200.0).seed(7).open("itu:urban")?;
/// assert_eq!(city.grid().n_cells(), 200 * 200);
/// # Ok::<(), skyshed::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct SceneReader {
    /// Options of the question.
    pub(crate) options: SceneOptions,
    /// Width of the additional ground around a generated city \[m\].
    pub(crate) margin_m: f64,
    /// `true` if the position of a generated city's cells is drawn together with its heights.
    pub(crate) draws_cells: bool,
    /// `true` if footprints are kept as they were read, for a live page and for bytes.
    pub(crate) keeps_solids: bool,
    /// Box of a raster that is read: west, south, east, north \[CRS units\]; `None` reads all of
    /// it.
    pub(crate) around: Option<[f64; 4]>,
    /// Box outside of which no footprint matters: west, south, east, north \[CRS units\].
    pub(crate) within: Option<[f64; 4]>,
    /// `true` if faults of footprints are reported where the program would refuse them.
    pub(crate) tells_faults: bool,
    /// List of everything that was mended or left out.
    pub(crate) repairs: Option<Arc<OnceLock<FoundRepairs>>>,
}

impl SceneReader {
    /// Keeps footprints as they were read, for [`crate::Scene::live_page`] and
    /// [`crate::Scene::packed`].
    #[must_use]
    pub fn keeps_footprints(self) -> Self {
        SceneReader { keeps_solids: true, ..self }
    }

    /// Returns the height of flat ground, if that is set \[m above the datum\].
    pub(crate) fn flat_ground_m(&self) -> Option<f64> {
        match self.options.ground {
            Some(GroundChoice::Flat(height_m)) => Some(height_m),
            _ => None,
        }
    }
}

impl From<SceneOptions> for SceneReader {
    fn from(options: SceneOptions) -> Self {
        SceneReader { options, ..SceneReader::default() }
    }
}

impl AsMut<SceneOptions> for SceneReader {
    fn as_mut(&mut self) -> &mut SceneOptions {
        &mut self.options
    }
}
