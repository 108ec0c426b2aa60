//! Questions about a scene that need no type of their own, and their answers.

use std::ffi::OsStr;
use std::fmt;
use std::path::Path;
use std::sync::Arc;

use serde_json::Value;
use skyshed_io::Input;
use skyshed_request::{
    Antenna, CompareOptions, Earth, HeightErrors, LimitsOptions, Range, Receiver, SampleOptions, SaveOptions, Sight,
    Source, TrackOptions, json,
};

use crate::answer::{Answer, CommandFacts, saved};
use crate::comparison::{self, ComparisonPlan, check_heights, check_number};
use crate::conversion::{self, Conversion};
use crate::error::{Result, Warning};
use crate::export::Format;
use crate::limits::{self, LimitsPlan};
use crate::picture::Look;
use crate::progress::Progress;
use crate::sample::{self, SamplePlan};
use crate::scene::{Scene, SceneReader};
use crate::survey;
use crate::track::{self, TrackAsked, TrackPlan};
use crate::uav::{Uav, UavsAsked, UavsFound};
use crate::zone_files::{self, ZoneFiles};

/// Answer to a question that has no type of its own: a document, a table, a text and files.
///
/// ```
/// use skyshed::prelude::*;
///
/// let city = Scene::options().size(200.0).open("itu:urban")?;
/// let zones = city.zone_report()?;
/// let document = zones.document();
/// assert!(document["street"]["share"].as_f64().is_some_and(|share| share > 0.3));
/// # Ok::<(), skyshed::Error>(())
/// ```
pub struct Report {
    answer: Box<dyn Answer + Send + Sync>,
    formats: &'static [Format],
}

impl fmt::Debug for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Report").field("schema", &self.document()["schema"]).finish_non_exhaustive()
    }
}

impl Report {
    pub(crate) fn new(answer: impl Answer + Send + Sync + 'static, formats: &'static [Format]) -> Report {
        Report { answer: Box::new(answer), formats }
    }

    /// Returns the document, whose schema is in `docs/schema` of the repository.
    pub fn document(&self) -> Value {
        self.answer.document(None)
    }

    /// Returns the table, its header first; empty if the answer has none.
    pub fn table(&self) -> Vec<Vec<String>> {
        self.answer.table()
    }

    /// Returns the answer as the program prints it: in words, or as a table (CSV) of `compare` and
    /// `sample`. The verdict of `compare` is the member `verdict` of the document.
    ///
    /// # Errors
    /// If a table cannot be written.
    pub fn text(&self) -> Result<String> {
        self.answer.text(&Look::default())
    }

    /// Returns the warnings.
    pub fn warnings(&self) -> &[Warning] {
        self.answer.warnings()
    }

    /// Writes a file in the format of its extension.
    ///
    /// # Errors
    /// E104–E109 for a file that cannot be written so; E106 if it exists; E401 if writing fails.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        saved(&*self.answer, self.formats, path.as_ref(), &SaveOptions::default())
    }

    /// Writes a file as `save` does, with options of pictures and of writing.
    ///
    /// # Errors
    /// As `save`; E116 for options of maps, and for a look without a picture.
    pub fn save_with(&self, path: impl AsRef<Path>, options: &SaveOptions) -> Result<()> {
        saved(&*self.answer, self.formats, path.as_ref(), options)
    }
}

/// Request of a report about a scene. Traits of [`crate::prelude`] set its options, [`crate::request`]
/// describes them:
///
/// | request | options |
/// |---|---|
/// | [`Scene::limits`], [`Scene::sample`] | [receiver](crate::request::Receiver), [range](crate::request::Range), [antenna](crate::request::Antenna), [earth](crate::request::Earth), and [`LimitsOptions`] or [`SampleOptions`] |
/// | [`Scene::compare`] | the same, [errors of heights](HeightErrors), and [`CompareOptions`] |
/// | [`Scene::track`] | [receiver](crate::request::Receiver), [earth](crate::request::Earth), and [`TrackOptions`] |
#[derive(Debug, Clone)]
#[must_use = "nothing is computed before `run`"]
pub struct ReportRequest<Options> {
    scene: Scene,
    uavs: Vec<Uav>,
    sight: Sight,
    heights: HeightErrors,
    options: Options,
    progress: Arc<Progress>,
}

// Each request holds the parts that change its answer, and no others.
skyshed_request::holds!(ReportRequest<LimitsOptions>: sight.receiver Receiver, sight.range Range,
    sight.antenna Antenna, sight.earth Earth, options LimitsOptions);
skyshed_request::holds!(ReportRequest<CompareOptions>: sight.receiver Receiver, sight.range Range,
    sight.antenna Antenna, sight.earth Earth, heights HeightErrors, options CompareOptions);
skyshed_request::holds!(ReportRequest<SampleOptions>: sight.receiver Receiver, sight.range Range,
    sight.antenna Antenna, sight.earth Earth, options SampleOptions);
skyshed_request::holds!(ReportRequest<Track>: sight.receiver Receiver, sight.earth Earth, options.options TrackOptions);

/// UAVs, the places of a user in order, and options of a walk or a flight along them.
#[derive(Debug, Clone)]
pub struct Track {
    uavs: Vec<Uav>,
    places: Input,
    options: TrackOptions,
}

impl<Options> ReportRequest<Options> {
    fn new(scene: &Scene, uavs: impl IntoIterator<Item = Uav>, options: Options) -> Self {
        ReportRequest {
            scene: scene.clone(),
            uavs: uavs.into_iter().collect(),
            sight: Sight::default(),
            heights: HeightErrors::default(),
            options,
            progress: Arc::default(),
        }
    }
}

impl Scene {
    /// Requests the limits of a map of some UAVs: the effect of cells, terrain, roofs, and of errors
    /// of positions and heights. The document is `skyshed/limits/1`.
    pub fn limits(&self, uavs: impl IntoIterator<Item = Uav>) -> ReportRequest<LimitsOptions> {
        ReportRequest::new(self, uavs, LimitsOptions::default())
    }

    /// Requests a comparison of UAVs, and of saved masks (`mask`): counts, and differences with
    /// intervals. The document is `skyshed/compare/1`.
    pub fn compare(&self, uavs: impl IntoIterator<Item = Uav>) -> ReportRequest<CompareOptions> {
        ReportRequest::new(self, uavs, CompareOptions::default())
    }

    /// Requests P_LoS averaged over placements of zones (`zones`) at some heights (`height`). The
    /// document is `skyshed/sample/1`.
    pub fn sample(&self) -> ReportRequest<SampleOptions> {
        ReportRequest::new(self, [], SampleOptions::default())
    }

    /// Requests line of sight along the way of a user below a UAV: places (x, y) in order. The
    /// document is `skyshed/track/1`.
    ///
    /// ```
    /// use skyshed::prelude::*;
    ///
    /// let city = Scene::options().size(200.0).open("itu:urban")?;
    /// let uav = Uav::new(100.0, 100.0, Height::agl(120.0));
    /// let walk = city.track(uav, [(20.0, 10.0), (180.0, 10.0)]).every(2.0).run()?;
    /// assert_eq!(walk.document()["schema"], "skyshed/track/1");
    /// # Ok::<(), skyshed::Error>(())
    /// ```
    pub fn track(&self, uav: Uav, places: impl IntoIterator<Item = (f64, f64)>) -> ReportRequest<Track> {
        let rows = places.into_iter().fold(String::from("x,y\n"), |rows, (x, y)| format!("{rows}{x},{y}\n"));
        let places = Input::bytes("track.csv", rows.into_bytes());
        ReportRequest::new(self, [], Track { uavs: vec![uav], places, options: TrackOptions::default() })
    }

    /// Requests line of sight of UAVs along the walks or flights of a file: .csv .geojson .gpx .kml
    /// .plan .waypoints. The document is `skyshed/track/1`.
    pub fn track_file(&self, uavs: impl IntoIterator<Item = Uav>, file: impl Into<Source>) -> ReportRequest<Track> {
        let places = Input::of(&file.into());
        let uavs = uavs.into_iter().collect();
        ReportRequest::new(self, [], Track { uavs, places, options: TrackOptions::default() })
    }

    /// Returns streets, crossroads, courtyards and rooftops: cells, areas and shares. Files hold a
    /// map of them. The document is `skyshed/zones/1`.
    ///
    /// # Errors
    /// E117 for a surface model alone.
    pub fn zone_report(&self) -> Result<Report> {
        Ok(Report::new(ZoneFiles::of(self.clone(), CommandFacts::default())?, &zone_files::FORMATS))
    }

    /// Returns the city itself, whose files are a drawing (.png .svg .pdf), heights (.tif .asc),
    /// footprints (.geojson), a scene of Mitsuba (.xml) or boxes of ns-3 (.csv). Footprints need
    /// [`SceneReader::keeps_footprints`].
    pub fn city_report(&self) -> Report {
        Report::new(Conversion::of(self.clone(), CommandFacts::default()), &conversion::FORMATS)
    }
}

impl SceneReader {
    /// Returns the facts of a file, as `skyshed info` does: the size, heights and faults of a scene,
    /// or the content of UAVs, tracks and outputs of this program.
    ///
    /// ```
    /// let facts = skyshed::Scene::options().info("itu:urban")?;
    /// assert_eq!(facts.document()["cols"], 1000);
    /// # Ok::<(), skyshed::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`SceneReader::open`]; E116 for options that such a file cannot use.
    pub fn info(&self, word: impl AsRef<OsStr>) -> Result<Report> {
        let answer = survey::facts_of(self, word.as_ref(), None, &CommandFacts::default())?;
        Ok(Report { answer, formats: &survey::FORMATS })
    }
}

impl ReportRequest<LimitsOptions> {
    /// Maps the UAVs in several ways. Rectangular footprints are counted in a scene that was opened
    /// with [`SceneReader::keeps_footprints`].
    ///
    /// # Errors
    /// E113 for numbers out of range; E118 for an engine that cannot decide the scene; E2xx for UAVs
    /// that cannot be there.
    pub fn run(self) -> Result<Report> {
        let plan = LimitsPlan::of(&self.sight, &self.options)?;
        let limits = plan.find_over(self.scene, &UavsFound::of(&self.uavs)?, CommandFacts::default())?;
        Ok(Report::new(limits, &limits::FORMATS))
    }
}

impl ReportRequest<CompareOptions> {
    /// Sets a token that reports the progress, and can stop the work from another thread.
    pub fn progress(self, progress: &Arc<Progress>) -> Self {
        ReportRequest { progress: Arc::clone(progress), ..self }
    }

    /// Maps the UAVs and compares them.
    ///
    /// # Errors
    /// E108 for fewer than two placements; E113, E116, E118 for an impossible question; E2xx for UAVs
    /// that cannot be there; E3xx for masks that cannot be read.
    pub fn run(self) -> Result<Report> {
        let reading = &self.scene.options.options;
        let plan = ComparisonPlan::of((&self.sight, &self.heights), &self.options, reading)?;
        check_number(self.uavs.len() + plan.masks.len())?;
        check_heights(&json::set_members(&self.heights), self.uavs.len())?;
        let found = UavsFound::of(&self.uavs)?;
        let comparison = plan.compare(self.scene, &found, CommandFacts::default(), &self.progress)?;
        Ok(Report::new(comparison, &comparison::FORMATS))
    }
}

impl ReportRequest<SampleOptions> {
    /// Sets a token that reports the progress, and can stop the work from another thread.
    pub fn progress(self, progress: &Arc<Progress>) -> Self {
        ReportRequest { progress: Arc::clone(progress), ..self }
    }

    /// Maps the placements. A generated city is made as large as whole discs need.
    ///
    /// # Errors
    /// E113, E116 for an impossible question; E2xx for zones without a place; E5xx for too many.
    pub fn run(self) -> Result<Report> {
        let word = self.scene.word.clone();
        let given = self.scene.built_up.is_none().then(|| self.scene.clone());
        let options = SceneReader::clone(&self.scene.options);
        let plan = SamplePlan::of((OsStr::new(&word), given), options, (&self.sight, &self.options))?;
        Ok(Report::new(plan.take(CommandFacts::default(), &self.progress)?, &sample::FORMATS))
    }
}

impl ReportRequest<Track> {
    /// Walks the track.
    ///
    /// # Errors
    /// E113 for a step out of range; E2xx for a UAV or a place that cannot be there; E502 for too
    /// many steps.
    pub fn run(self) -> Result<Report> {
        let Track { uavs, places, options } = &self.options;
        let of_user = (&self.sight.receiver, &self.sight.earth);
        let track = TrackAsked::of((places.clone(), false, false), options)?;
        let plan = TrackPlan::of(UavsAsked::held(uavs)?, track, of_user)?;
        Ok(Report::new(plan.walk(self.scene, CommandFacts::default())?, &track::FORMATS))
    }
}
