//! The job of `skyshed map`: its plan, its outputs, and the notes printed once it is done.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use skyshed_request::{FilePath, MapRequest, Position, SaveOptions, TileIndex, Uavs, json};

use super::curve::{CurvePlan, Curves};
use super::needs::MapNeeds;
use super::over_time::{OverTime, OverTimePlan};
use super::plan::MapPlan;
use super::report::MapReport;
use super::tiles::{ROW_AND_COL, Tile, TilesAsked};
use super::tolerance::in_words as tolerance_in_words;
use crate::answer::{Answer, CommandFacts, Output, Rows, Spent, Timing};
use crate::city::{Antenna, GivenSite, Site};
use crate::error::{Error, Result, Warning};
use crate::export::{Batch, Format};
use crate::los::Method;
use crate::picture::Look;
use crate::raster::GeoRef;
use crate::read::StreamedSurface;
use crate::read::named_files;
use crate::scene::{Scene, SceneReader, is_raster_scene};
use crate::uav::{UavsAsked, UavsFound};
use crate::words::{capitalized, idle_in_words, p_los_words};

/// UAV or tile of a unit of work, as the unit's request and command name it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PartWords {
    pub(super) uav: Option<Position>,
    pub(super) tile: Option<TileIndex>,
}

/// Request of a map with all of its parts checked.
#[derive(Debug, Clone)]
pub(crate) struct MapJob {
    /// The request; of a unit of work, the request narrowed to that unit.
    pub(crate) request: MapRequest,
    /// Scene: a path, or the word for a generated city.
    pub(crate) word: OsString,
    /// Reader of the scene.
    pub(crate) scene: SceneReader,
    /// The scene's word, then the other files that the scene is read from.
    pub(crate) inputs: Vec<PathBuf>,
    pub(crate) uavs: UavsAsked,
    pub(crate) plan: MapPlan,
    pub(crate) save: SaveOptions,
    pub(crate) outputs: Vec<PathBuf>,
    pub(crate) curve: CurvePlan,
    pub(crate) over_time: OverTimePlan,
    /// Requested tiles. They are units of work if file names hold `{row}` and `{col}`, or if single
    /// tiles are named.
    pub(crate) tiles: TilesAsked,
    /// Words of the command line, for documents.
    pub(crate) command: CommandFacts,
}

/// Inputs that a run receives from its caller instead of reading them.
#[derive(Default)]
pub(crate) struct Given<'a> {
    /// UAVs to map instead of the requested ones.
    pub(crate) uavs: Option<UavsFound>,
    pub(crate) scene: GivenScene<'a>,
    /// Grid of the whole scene; the scene of this run may be a part of it.
    pub(crate) grid: Option<&'a GeoRef>,
    /// Tile to map, with the number of UAVs in the whole list.
    pub(crate) tile: Option<(&'a Tile, usize)>,
    /// Hash of the unit of work that this run performs; `None` for a run that is no unit.
    pub(crate) unit: Option<String>,
}

/// Scene of a run: in memory, on disk, or still to be read.
#[derive(Default)]
pub(crate) enum GivenScene<'a> {
    /// Not read yet: the run reads it.
    #[default]
    Asked,
    InMemory(Box<Scene>),
    /// In tiles on disk, with the warnings of reading it.
    OnDisk(&'a StreamedSurface, Vec<Warning>),
}

/// Map whose files are written.
#[derive(Debug)]
pub(crate) struct Done {
    pub(crate) report: MapReport,
    pub(crate) timing: Timing,
    /// Reason for the choice of the method, in words.
    pub(crate) why: &'static str,
    pub(crate) curves: Option<Curves>,
    pub(crate) over_time: Option<OverTime>,
    pub(crate) written: Vec<PathBuf>,
    /// All warnings: those of the map, then those of the curves.
    pub(crate) warnings: Vec<Warning>,
}

impl Done {
    pub(super) fn of(
        report: MapReport,
        timing: Timing,
        why: &'static str,
        (curves, over_time): (Option<Curves>, Option<OverTime>),
        written: Vec<PathBuf>,
    ) -> Done {
        let of_curves = curves.as_ref().map_or(&[][..], |curves| curves.warnings());
        let warnings = [&report.facts.warnings, of_curves].concat();
        Done { report, timing, why, curves, over_time, written, warnings }
    }
}

/// Document, table and notes of a map whose files are written already: `add` writes nothing.
impl Answer for Done {
    fn document(&self, _: Option<Spent>) -> serde_json::Value {
        self.report.document(self.report.timing(self.timing))
    }

    fn table(&self) -> Rows {
        self.report.table()
    }

    fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    fn notes(&self, spent: Spent) -> Vec<String> {
        let report = &self.report;
        let dropped = report.idle.iter().filter(|idle| idle.dropped() > 0).map(idle_in_words);
        let mut notes: Vec<String> = dropped.chain(report.tolerance.iter().map(tolerance_in_words)).collect();
        let receivers = report.sight.receivers();
        let (who, whom) = (capitalized(receivers.other_end()), receivers.noun());
        notes.extend(report.sites.iter().map(|site| {
            let share = p_los_words(site.tally.p_los());
            let interval = site.uncertain.and_then(|uncertain| uncertain.interval);
            let interval = interval.map_or(String::new(), |interval| format!(" ({})", interval.in_words()));
            format!("{who} {}: P_LoS {share}{interval}, {} of {} {whom}", site.id, site.tally.los, site.tally.receivers)
        }));
        notes.push(format!(
            "method {} ({}; {}): line of sight {:.3} s of {:.2} s",
            report.facts.method_name(),
            report.facts.method.map_or("", Method::exactness),
            self.why,
            self.timing.los,
            self.timing.total
        ));
        notes.extend(self.curves.iter().flat_map(|curves| curves.notes(spent)));
        notes.extend(self.over_time.iter().flat_map(|over_time| over_time.notes(spent)));
        notes
    }

    fn add(&self, _: &mut Batch, _: &Path, _: Format, _: &Look) -> Result<()> {
        Ok(())
    }
}

/// Returns `true` if the name of a file holds the row or the column of a tile.
pub(crate) fn names_tile(path: &Path) -> bool {
    ROW_AND_COL.iter().any(|word| path.to_string_lossy().contains(word))
}

impl MapJob {
    /// Checks the parts of a request.
    ///
    /// # Errors
    /// E1xx for values that are wrong by themselves, and for options that change nothing.
    pub(crate) fn of(request: MapRequest, command: CommandFacts) -> Result<MapJob> {
        let word = PathBuf::from(request.scene.word());
        let paths = |files: &[FilePath]| files.iter().map(|path| path.0.clone()).collect::<Vec<PathBuf>>();
        let options = &request.reading.options;
        let outputs = paths(&request.out.files.output);
        let curve = CurvePlan {
            outputs: paths(&request.curve.height_curve),
            heights: request.curve.curve_heights.map(|range| range.0),
        };
        let over_time = OverTimePlan { outputs: paths(&request.time.over_time) };
        let uavs = UavsAsked { shard: request.units.shard, ..UavsAsked::some_of(&request.uavs, options.hash)? };
        let plan = MapPlan { over_time: over_time.is_wanted(), ..MapPlan::of(&request.coverage)? };
        // Curve files count as pictures too; bare .png files do not. Names without a known format
        // are refused later.
        let is_bare = |path: &&PathBuf| request.forms.bare && Format::of(path).is_ok_and(|f| f == Format::Png);
        let files = outputs.iter().filter(|path| !is_bare(path)).chain(&curve.outputs);
        let files: Vec<Output> = files.filter_map(|path| Some((path.clone(), Format::of(path).ok()?))).collect();
        Look::checked(&request.picture, &request.out.writing, &files)?;
        let job = MapJob {
            inputs: named_files(&word).into_iter().chain(options.files().map(|path| path.0.clone())).collect(),
            word: word.into_os_string(),
            scene: options.clone().into(),
            uavs,
            plan,
            save: request.save_options(),
            outputs,
            curve,
            over_time,
            tiles: TilesAsked::of(request.units.tile_size, &request.units.tile),
            command,
            request,
        };
        job.check_units()?;
        Ok(job)
    }

    /// Refuses options of strips where the scene allows none, options of tiles without tiles, and questions of
    /// time to a shard.
    fn check_units(&self) -> Result<()> {
        let (memory, units) = (&self.request.memory, &self.request.units);
        if !is_raster_scene(&self.word) || self.scene.options.project.is_some() {
            const WHY: &str = "but for a raster in its own system";
            if memory.strips {
                return Err(Error::idle("strips", WHY));
            }
            if memory.scratch.is_some() {
                return Err(Error::idle("scratch", WHY));
            }
        }
        if let Some(option) = self.plan.option_of_time().filter(|_| units.shard.is_some()) {
            return Err(Error::idle(option, "with a shard: it is about all UAVs"));
        }
        if units.tile_size.is_some() && units.tile.is_empty() && !self.outputs.iter().any(|path| names_tile(path)) {
            return Err(Error::idle("tile_size", "without tiles"));
        }
        Ok(())
    }

    /// Returns `true` if counts are printed: with `--json`, or if no file is written.
    pub(super) fn is_told(&self) -> bool {
        self.request.out.files.json || self.files().next().is_none()
    }

    /// Returns all files of the run: those of the map, of its curves and of its counts over time.
    pub(crate) fn files(&self) -> impl Iterator<Item = &PathBuf> {
        self.outputs.iter().chain(&self.curve.outputs).chain(&self.over_time.outputs)
    }

    /// Returns the job of one UAV or of one tile; `files` gives its outputs names of their own.
    ///
    /// Its request and its command hold no table and no batch. The command lists the flags of the
    /// question sorted by name, then the antenna, then the UAV or the tile.
    pub(super) fn of_part(
        &self,
        files: impl Fn(&[PathBuf]) -> Vec<PathBuf>,
        antenna: Antenna,
        part: &PartWords,
    ) -> MapJob {
        let mut request = self.request.clone();
        request.reading.options.hash = false;
        request.uavs = Uavs { uav: part.uav.iter().map(ToString::to_string).collect(), ..Uavs::default() };
        request.coverage.sight.antenna = antenna.into();
        request.units.tile = part.tile.into_iter().collect();
        let mut flags = request.clone();
        (flags.scene, flags.uavs, flags.out, flags.units.tile) = Default::default();
        flags.coverage.sight.antenna = Default::default();
        let mut flags = json::question(json::set_members(&flags));
        flags.sort_keys();
        let antenna = json::set_members(&request.coverage.sight.antenna);
        let uav = part.uav.map(|uav| ["--uav".into(), uav.to_string()]);
        let tile = part.tile.map(|tile| ["--tile".into(), tile.to_string()]);
        let scene = request.scene.word().display().to_string();
        let words = ["map".into(), scene].into_iter().chain(json::words(&flags)).chain(json::words(&antenna));
        let words = words.chain(uav.into_iter().chain(tile).flatten()).collect();
        let command = CommandFacts::of(words, Some(json::set_members(&request)));
        let curve = CurvePlan { outputs: files(&self.curve.outputs), ..self.curve.clone() };
        MapJob { request, outputs: files(&self.outputs), curve, command, ..self.clone() }
    }

    /// Returns `true` if only the part of the scene in range is read: of a raster in its own
    /// system, with a radius or a slant range and without zones.
    pub(super) fn reads_range_alone(&self) -> bool {
        let is_limited = self.plan.sight.is_near() && !self.plan.needs_zones();
        is_limited && is_raster_scene(&self.word) && self.scene.options.project.is_none()
    }

    /// Returns this job over the part of a raster in range of some UAVs.
    pub(super) fn of_range(&self, sites: &[GivenSite], grid: &GeoRef) -> MapJob {
        let around = self.plan.sight.box_in_range(sites, grid);
        MapJob { scene: SceneReader { around, ..self.scene.clone() }, ..self.clone() }
    }

    /// Returns the reader of the scene, with a limit on the footprints that are read.
    ///
    /// The limit keeps all footprints that a link can meet. It applies to a scene with an extent and
    /// without zones, if every UAV is typed. Links stay in the box around the extent and the UAVs, and
    /// as near to the extent as the radius.
    pub(super) fn scene_in_reach(&self) -> SceneReader {
        /// Shortest unit of any system, since the system is not known yet \[m\].
        const SHORTEST_UNIT_M: f64 = 0.25;
        /// Cells at the border of the extent, and roundings \[CRS units\].
        const MARGIN: f64 = 100.0;
        // UAVs of a table are not read yet.
        let limit = |extent: [f64; 4]| {
            (self.uavs.table.is_none() && !self.plan.needs_zones()).then(|| {
                let [west, south, east, north] = around(extent, self.uavs.typed.iter().map(|site| [site.x, site.y]));
                // The surface below a distant UAV is needed too.
                let reach = self.plan.sight.radius_m().map(|m| m / SHORTEST_UNIT_M);
                let reach = reach.filter(|reach| self.uavs.typed.iter().all(|site| is_near(site, extent, *reach)));
                let [w, s, e, n] = extent;
                let reach = reach.unwrap_or(f64::INFINITY);
                let [w, s, e, n] = [w - reach, s - reach, e + reach, n + reach];
                [west.max(w) - MARGIN, south.max(s) - MARGIN, east.min(e) + MARGIN, north.min(n) + MARGIN]
            })
        };
        SceneReader { within: self.scene.options.extent.and_then(limit), ..self.scene.clone() }
    }

    /// Returns the bytes per cell that a map of one UAV takes beside the scene.
    pub(crate) fn bytes_per_cell(&self, n_cells: usize) -> f64 {
        MapNeeds::of_one(n_cells, &self.plan.layers, &self.known_outputs()).bytes_per_cell()
    }

    /// Returns the outputs whose format is known by their names.
    pub(super) fn known_outputs(&self) -> Vec<Output> {
        self.outputs.iter().filter_map(|path| Some((path.clone(), Format::of(path).ok()?))).collect()
    }

    /// Returns the path of a scene that is a file.
    pub(super) fn path(&self) -> &Path {
        Path::new(&self.word)
    }
}

/// Returns `true` for a UAV no farther from an extent than some distance.
fn is_near(site: &Site, [west, south, east, north]: [f64; 4], reach: f64) -> bool {
    (west - reach..=east + reach).contains(&site.x) && (south - reach..=north + reach).contains(&site.y)
}

/// Returns the box around another one and some places.
fn around(extent: [f64; 4], places: impl Iterator<Item = [f64; 2]>) -> [f64; 4] {
    places.fold(extent, |[west, south, east, north], [x, y]| [west.min(x), south.min(y), east.max(x), north.max(y)])
}
