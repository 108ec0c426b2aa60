//! Live page of a scene: one file in which the user drags a UAV over the city, and the exact
//! coverage follows.

use std::ffi::OsStr;
use std::path::Path;
use std::time::Instant;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};
use skyshed_io::Input;
use skyshed_live::pack::{MOST_CELLS, MOST_FOOTPRINTS, PackedZones, is_small_enough, pack};
use skyshed_live::{MOST_UAVS, questions};

use crate::answer::{Answer, CommandFacts, Head, RunFacts, Spent, WarningFacts, document_of, warnings_of};
use crate::city::{GivenSite, Site, Solids};
use crate::coverage;
use crate::crs::wkt_of;
use crate::error::{Error, FitsPage, LimitError, RequestError, Result, Warning};
use crate::export::{Batch, Format};
use crate::link::check_extent;
use crate::memory::Needs;
use crate::picture::{Look, program};
use crate::quantity::{Height, counted, meters};
use crate::raster::GeoRef;
use crate::read::surface_grid;
use crate::render;
use crate::scene::{Scene, SceneReader, built_up, is_raster_scene};
use crate::sight::{SightFacts, SightPlan};
use crate::track::{self, TrackAsked};
use crate::uav::{Uav, UavsAsked, UavsFound};
use crate::words::title_of;
use skyshed_request::json::set_members;
use skyshed_request::{SetSceneOptions, Sight, Source, TrackOptions};

/// Output formats of a page.
pub(crate) const FORMATS: [Format; 3] = [Format::Html, Format::Json, Format::Stdout];

/// Longest page \[bytes\].
const MOST_BYTES: usize = 25_000_000;
/// Height of the UAV if the request names none \[m\].
const START_HEIGHT_M: f64 = 120.0;

/// Plan of a page: its first UAVs and settings.
#[derive(Debug, Clone)]
pub(crate) struct LivePlan {
    /// UAVs; without any there is one in the middle.
    pub(crate) uavs: UavsAsked,
    /// Walk or flight that the page shows.
    pub(crate) track: Option<TrackAsked>,
    /// Receivers, range and antenna.
    pub(crate) sight: SightPlan,
    /// Words of the scene and of its options, for a command line.
    pub(crate) scene_words: Vec<String>,
    /// Command line and question.
    pub(crate) command: CommandFacts,
}

/// Live page of a scene.
#[derive(Debug)]
pub(crate) struct LivePage {
    facts: RunFacts,
    scene: Scene,
    /// `true` if the page holds only a part of the named scene.
    is_part: bool,
    packed: Vec<u8>,
    uavs: Vec<questions::Uav>,
    tracks: Tracks,
    sight: SightPlan,
    scene_words: Vec<String>,
}

/// Tracks that a page shows.
#[derive(Debug, Default)]
struct Tracks {
    paths: Vec<questions::PageTrack>,
    /// Step by which they are decided over a curved earth \[m\].
    every_m: f64,
}

impl Scene {
    /// Returns one HTML page in which the user drags UAVs over the scene, and the exact coverage
    /// follows.
    ///
    /// Engine and scene are in the page, so no server is needed. Without a UAV there is one in the
    /// middle. A walk or a flight is shown from the side. The command line that the page shows has
    /// the options `words` of the scene. Footprints need [`SceneReader::keeps_footprints`].
    ///
    /// # Errors
    /// E2xx for UAVs or a track that cannot be there; errors of the track's file; E505 for a scene
    /// that is too large.
    pub fn live_page(&self, uavs: &[Uav], track: Option<Source>, words: Vec<String>) -> Result<String> {
        let sight = SightPlan::of(&Sight::default())?;
        let scene = &mut self.clone();
        let asked = track.map(|file| TrackAsked::of((Input::of(&file), false, false), &TrackOptions::default()));
        let tracks = Tracks::read(asked.transpose()?.as_ref(), scene, sight.rx_height())?;
        let page = LivePage::with_uavs(scene, UavsFound::of(uavs)?, sight, words)?;
        LivePage { tracks, ..page }.html(&Look::default())
    }
}

/// Document of a live page.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct LiveDocument {
    #[serde(flatten)]
    head: Head,
    #[serde(flatten)]
    sight: SightFacts,
    /// UAVs at the start of the page.
    uavs: Vec<LiveUav>,
    /// Warnings.
    warnings: Vec<WarningFacts>,
}

/// A UAV at the start of a page.
#[derive(Debug, Serialize, JsonSchema)]
struct LiveUav {
    /// Name of the UAV.
    id: String,
    /// East [units of the scene's reference system].
    x: f64,
    /// North [units of the scene's reference system].
    y: f64,
    /// Height as typed: 120agl, 30roof, 150amsl.
    height: String,
}

impl LivePage {
    /// Reads a scene, and prepares it for a page.
    ///
    /// # Errors
    /// Errors of the scene and of its UAVs; E505 for a scene that is too large for a page.
    pub(crate) fn open(options: &SceneReader, word: &OsStr, plan: LivePlan) -> Result<LivePage> {
        let start = Instant::now();
        let mut warnings = Vec::new();
        let part = part_in_range(options, word, &plan)?;
        let options = &SceneReader { around: part, keeps_solids: true, ..options.clone() };
        let city = options.read(word, &mut warnings)?;
        if !is_small_enough(&city.grid, &city.solids) {
            let n_footprints = match &city.solids {
                Solids::Vector { footprints, .. } => footprints.len(),
                Solids::Raster { .. } => 0,
            };
            return Err(too_large((options, is_raster_scene(word)), word, &city.grid, n_footprints));
        }
        let mut scene = Scene::built(options, (word, city), warnings, start)?;
        let found = plan.uavs.read(scene.grid())?;
        let tracks = Tracks::read(plan.track.as_ref(), &mut scene, plan.sight.rx_height())?;
        let page = LivePage::with_uavs(&mut scene, found, plan.sight, plan.scene_words)?;
        let facts = RunFacts { command: plan.command, ..page.facts };
        Ok(LivePage { facts, is_part: part.is_some(), tracks, ..page })
    }

    /// Returns the page of a scene with some UAVs, or with one in the middle.
    fn with_uavs(scene: &mut Scene, found: UavsFound, sight: SightPlan, scene_words: Vec<String>) -> Result<LivePage> {
        let placed = scene.place(&found, None, &sight)?;
        let found = found.over(&scene.field)?.into_owned();
        if found.sites.len() > MOST_UAVS {
            return Err(LimitError::PageUavs { n: found.sites.len(), most: MOST_UAVS }.into());
        }
        let mut sites: Vec<Site> = found
            .sites
            .into_iter()
            .map(|given| given.site)
            .filter(|site| placed.iter().any(|uav| uav.id == site.id))
            .collect();
        if sites.is_empty() {
            sites.push(in_the_middle(scene));
        }
        LivePage::of(scene, &sites, sight, scene_words)
    }

    /// Returns the page of a scene with kept solids, and with UAVs that are checked already.
    ///
    /// # Errors
    /// E902 without solids; E113 for antennas that differ; E505 for a scene that is too large.
    pub(crate) fn of(scene: &Scene, uavs: &[Site], sight: SightPlan, scene_words: Vec<String>) -> Result<LivePage> {
        let (grid, n_footprints) = (scene.grid(), scene.field.n_buildings());
        // Too large a scene is refused before it is copied.
        if grid.n_cells() > MOST_CELLS || n_footprints > MOST_FOOTPRINTS {
            let edge_m = (grid.x_max() - grid.x_min()) * grid.meters_per_unit();
            let options = SceneReader::default().size(edge_m);
            let is_of_cells = scene.field.prisms().is_none();
            return Err(too_large((&options, is_of_cells), OsStr::new(&scene.word), grid, n_footprints));
        }
        let sight = one_antenna(uavs, sight)?;
        Needs::LIVE.check(scene)?;
        let solids = scene.solids().ok_or(Error::fault("a live page needs the solids of its scene"))?;
        let zones = scene.zones()?.map(|zones| PackedZones::of(zones.codes(), &scene.field.cells().open));
        let packed = pack(scene.grid(), &solids, zones.as_ref());
        let scene = Scene { solids: None, ..scene.clone() };
        let uavs = uavs.iter().map(asked).collect();
        let (facts, tracks) = (scene.facts(None), Tracks::default());
        Ok(LivePage { facts, scene, is_part: false, packed, uavs, tracks, sight, scene_words })
    }

    /// Returns the page.
    ///
    /// # Errors
    /// E505 if it is too long.
    pub(crate) fn html(&self, look: &Look) -> Result<String> {
        let title = look.title_or(|| title_of(&format!("What a UAV sees of {}", self.scene.name)));
        let html = render::live_page(&render::LivePage {
            title: &title,
            generator: &program(),
            facts: &self.facts_of_page(&title, look),
            scene: &self.packed,
        });
        if html.len() > MOST_BYTES {
            let name = self.scene.word.clone();
            return Err(
                LimitError::PageBytes { name, mb: html.len() / 1_000_000, most_mb: MOST_BYTES / 1_000_000 }.into()
            );
        }
        Ok(html)
    }

    /// Returns the facts for the script of the page.
    fn facts_of_page(&self, title: &str, look: &Look) -> Value {
        let sight = questions::PageSight { sight: self.sight.of_page(), ..Default::default() };
        let defaults = SightPlan::of(&Sight::default()).map(|plan| set_members(&plan.of_page())).unwrap_or_default();
        let grid = self.scene.grid();
        let crs = grid
            .crs()
            .map(|crs| json!({"label": crs.label(), "name": crs.name(), "epsg": crs.epsg(), "wkt": wkt_of(crs)}));
        let layer = if self.uavs.len() > 1 { questions::Layer::Count } else { questions::Layer::One };
        json!({
            "name": self.scene.name,
            "word": self.scene.word,
            "title": title,
            "program": program(),
            "command": self.scene_words,
            "grid": {
                "x_min": grid.x_min(), "y_max": grid.y_max(),
                "cell_width": grid.cell_width(), "cell_height": grid.cell_height(),
                "n_cols": grid.n_cols(), "n_rows": grid.n_rows(),
                "meters_per_unit": grid.meters_per_unit(),
            },
            "crs": crs,
            "limits": self.scene.limits_in_words().into_iter().collect::<Vec<_>>(),
            "attribution": look.credit(self.scene.attribution.as_ref()),
            "is_part": self.is_part,
            "surface_only": self.scene.field.is_surface_only(),
            "most_uavs": MOST_UAVS,
            "defaults": defaults,
            "start": {"uavs": self.uavs, "sight": sight, "layer": layer},
            "tracks": self.tracks.paths,
            "track_every_m": self.tracks.every_m,
        })
    }
}

impl Answer for LivePage {
    fn document(&self, _: Option<Spent>) -> Value {
        let uav = |uav: &questions::Uav| LiveUav {
            id: uav.id.clone(),
            x: uav.x,
            y: uav.y,
            height: Height::from(uav.height).to_string(),
        };
        document_of(&LiveDocument {
            head: self.facts.head("skyshed/live/1"),
            sight: self.sight.facts(),
            uavs: self.uavs.iter().map(uav).collect(),
            warnings: warnings_of(&self.facts.warnings),
        })
    }

    fn warnings(&self) -> &[Warning] {
        &self.facts.warnings
    }

    fn notes(&self, _: Spent) -> Vec<String> {
        let grid = self.scene.grid();
        let uavs = counted(self.uavs.len() as u64, "UAV", "UAVs");
        vec![format!("{}×{} cells, {uavs}; drag with the pointer", grid.n_cols(), grid.n_rows())]
    }

    fn add(&self, batch: &mut Batch, path: &Path, _: Format, look: &Look) -> Result<()> {
        Ok(batch.add(path, self.html(look)?.as_bytes())?)
    }
}

impl Tracks {
    /// Reads a track over a scene, if there is one; a walk is `rx_height` above the ground \[1/1024 m\].
    ///
    /// # Errors
    /// Errors of the file; E2xx for a vertex that cannot be there, or too far from the scene.
    fn read(asked: Option<&TrackAsked>, scene: &mut Scene, rx_height: i32) -> Result<Tracks> {
        let Some(asked) = asked else { return Ok(Tracks::default()) };
        let grid = scene.field.grid().clone();
        let paths = asked.read(&grid, &mut scene.warnings)?;
        scene.sources.push(asked.source()?);
        for corner in [(grid.x_min(), grid.y_min()), (grid.x_max(), grid.y_max())] {
            let site = Site::new("1", corner, Height::agl(0.0));
            track::places(&paths.lines).try_for_each(|[x, y]| check_extent(scene, &site, (x, y)))?;
        }
        let ways = track::ways_of(paths, (&scene.field, asked), rx_height, &mut scene.warnings)?;
        Ok(Tracks { paths: ways.iter().map(questions::PageTrack::from).collect(), every_m: asked.every_m })
    }
}

/// Sets the antenna of all UAVs, of which a page has one.
fn one_antenna(uavs: &[Site], sight: SightPlan) -> Result<SightPlan> {
    let antenna = |uav: &Site| uav.antenna.or(sight.antenna());
    let first = uavs.first().map_or(sight.antenna(), antenna);
    match uavs.iter().find(|uav| antenna(uav) != first) {
        Some(other) => Err(RequestError::PageAntennas { a: uavs[0].id.clone(), b: other.id.clone() }.into()),
        None => Ok(sight.with_antenna(first)),
    }
}

/// Converts a site for the page.
fn asked(site: &Site) -> questions::Uav {
    questions::Uav { id: site.id.clone(), x: site.x, y: site.y, height: site.height.into() }
}

/// Returns a UAV over the middle of a scene, or above the whole scene if the middle is no place for
/// one.
fn in_the_middle(scene: &Scene) -> Site {
    let (grid, field) = (scene.grid(), &scene.field);
    let (x, y) = grid.world_from_cell(grid.n_rows() / 2, grid.n_cols() / 2);
    let site = |height| Site::new("1", (x, y), height);
    let above_ground = site(Height::agl(START_HEIGHT_M));
    match coverage::Uav::place(&above_ground, field, None) {
        Ok(_) => above_ground,
        Err(_) => site(Height::amsl((meters(field.max_top().max(0)) + 20.0).ceil())),
    }
}

/// Returns the box of a raster in range of the UAVs, west, south, east, north. `None` for a scene
/// that a page can hold whole.
///
/// # Errors
/// E505 without UAVs or a range; errors of the file and of the UAVs.
fn part_in_range(options: &SceneReader, word: &OsStr, plan: &LivePlan) -> Result<Option<[f64; 4]>> {
    // A raster that is brought into another reference system is read whole.
    if !is_raster_scene(word) || options.options.project.is_some() {
        return Ok(None);
    }
    let grid = surface_grid(Path::new(word), &options.of_raster()?)?;
    if grid.n_cells() <= MOST_CELLS {
        return Ok(None);
    }
    let reach = plan.sight.radius_on(&grid);
    let found = plan.uavs.read(&grid)?;
    let around = |s: &GivenSite| reach.map(|r| [s.x - r, s.y - r, s.x + r, s.y + r]);
    let paths = plan.track.as_ref().map(|track| track.read(&grid, &mut Vec::new())).transpose()?;
    let below = paths.iter().flat_map(|paths| track::places(&paths.lines)).map(|[x, y]| [x, y, x, y]);
    let join = |a: [f64; 4], b: [f64; 4]| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])];
    let in_range = found.sites.iter().filter_map(around).reduce(join);
    let part = in_range.map(|of_uavs| below.fold(of_uavs, join));
    let most_cells_a_side = (MOST_CELLS as f64).sqrt();
    // The window in range may be a cell or two larger.
    let radius_m = ((most_cells_a_side / 2.0 - 2.0) * meters_per_cell(&grid)).floor();
    let name = word.display().to_string();
    let fits = FitsPage::Range { radius_m };
    let (n, what, most) = (grid.n_cells(), "cells", MOST_CELLS);
    part.map(Some).ok_or_else(|| LimitError::PageCity { name, n, what, most, fits }.into())
}

/// Returns E505: a city that a page cannot hold, with what would fit. `is_of_cells` marks a scene
/// of cells, which has no other extent.
fn too_large((options, is_of_cells): (&SceneReader, bool), word: &OsStr, grid: &GeoRef, n_footprints: usize) -> Error {
    let (n, what, most) = match n_footprints {
        n if n > MOST_FOOTPRINTS => (n, "footprints", MOST_FOOTPRINTS),
        _ => (grid.n_cells(), "cells", MOST_CELLS),
    };
    // Share of each side that fits, if the city is evenly spread.
    let part = (most as f64 / n as f64).sqrt();
    let larger_m = (10.0 * meters_per_cell(grid) / part).ceil() / 10.0;
    let cell_m = (what == "cells").then_some(larger_m);
    let fits = if built_up(word).is_some() {
        FitsPage::Size { size_m: (options.city_edge_m() * part).floor(), cell_m }
    } else if is_of_cells {
        FitsPage::Cells { cell_m: larger_m }
    } else {
        FitsPage::Extent { extent: middle(grid, part), cell_m }
    };
    LimitError::PageCity { name: word.display().to_string(), n, what, most, fits }.into()
}

/// Returns the longer side of a cell \[m\].
fn meters_per_cell(grid: &GeoRef) -> f64 {
    grid.cell_width().max(grid.cell_height()) * grid.meters_per_unit()
}

/// Returns the middle of a grid, with a share `part` of each side: west, south, east, north, in
/// whole units.
fn middle(grid: &GeoRef, part: f64) -> [f64; 4] {
    let span = |low: f64, high: f64| {
        let (center, half) = ((low + high) / 2.0, (high - low) / 2.0 * part);
        ((center - half).ceil(), (center + half).floor())
    };
    let ((west, east), (south, north)) = (span(grid.x_min(), grid.x_max()), span(grid.y_min(), grid.y_max()));
    [west, south, east, north]
}
