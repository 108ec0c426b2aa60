//! The live page of a scene: one file in which a UAV is dragged over the city, and the exact coverage follows.

use std::ffi::OsStr;
use std::path::Path;
use std::time::Instant;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};
use skyshed_live::pack::{PackedZones, pack};
use skyshed_live::page::Page;
use skyshed_live::questions;

use crate::answer::{Answer, Head, RunFacts, Spent, WarningFacts, document_of, warnings_of};
use crate::city::{Site, Solids};
use crate::coverage;
use crate::crs::wkt_of;
use crate::error::{Error, LimitError, Result, Warning};
use crate::export::{Batch, Format};
use crate::picture::{Look, program};
use crate::quantity::{Height, counted, meters, tidy};
use crate::raster::GeoRef;
use crate::read::surface_grid;
use crate::scene::{Scene, SceneOptions, is_raster_scene};
use crate::sight::{Receivers, Sight, SightFacts};
use crate::uav::UavsAsked;
use crate::words::title_of;

/// Formats of a page.
pub(crate) const FORMATS: [Format; 3] = [Format::Html, Format::Json, Format::Stdout];

/// The most cells that a page holds: 16 million, of 4096 × 4096.
const MOST_CELLS: usize = 1 << 24;
/// The most footprints.
const MOST_FOOTPRINTS: usize = 300_000;
/// The longest page \[bytes\].
const MOST_BYTES: usize = 25_000_000;
/// The most UAVs.
const MOST_UAVS: usize = 32;

/// How high the UAV hovers where none was named \[m\].
const START_HEIGHT_M: f64 = 120.0;

/// What a page begins with.
#[derive(Debug, Clone)]
pub(crate) struct LivePlan {
    /// UAVs; without any there is one in the middle.
    pub(crate) uavs: UavsAsked,
    /// For whom.
    pub(crate) sight: Sight,
    /// Words of the scene and how it is read, for a command line.
    pub(crate) scene_words: Vec<String>,
    /// The words of the command line.
    pub(crate) command: Vec<String>,
}

/// The live page of a scene.
#[derive(Debug)]
pub(crate) struct LivePage {
    facts: RunFacts,
    scene: Scene,
    packed: Vec<u8>,
    uavs: Vec<questions::Uav>,
    sight: Sight,
    scene_words: Vec<String>,
}

/// What a page holds.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct LiveDocument {
    #[serde(flatten)]
    head: Head,
    #[serde(flatten)]
    sight: SightFacts,
    /// UAVs that it begins with.
    uavs: Vec<LiveUav>,
    /// What was odd.
    warnings: Vec<WarningFacts>,
}

/// A UAV that a page begins with.
#[derive(Debug, Serialize, JsonSchema)]
struct LiveUav {
    /// Its name.
    id: String,
    /// East [units of the scene's reference system].
    x: f64,
    /// North [units of the scene's reference system].
    y: f64,
    /// Its height as typed: 120agl, 30roof, 150amsl.
    height: String,
}

impl LivePage {
    /// Reads a scene, and makes it ready for a page.
    ///
    /// # Errors
    /// Those of the scene and of its UAVs; E505 of what is too large for a page.
    pub(crate) fn open(options: &SceneOptions, word: &OsStr, plan: LivePlan) -> Result<LivePage> {
        let start = Instant::now();
        let mut warnings = Vec::new();
        let around = part_in_range(options, word, &plan)?;
        let options = &SceneOptions { around, keeps_solids: true, ..options.clone() };
        let city = options.read(word, &mut warnings)?;
        check_size(&word.display().to_string(), &city.grid, &city.solids)?;
        let mut scene = Scene::built(options, (word, city), warnings, start)?;
        let found = plan.uavs.read(scene.grid())?;
        scene.place(&found, None, &plan.sight)?;
        if found.sites.len() > MOST_UAVS {
            return Err(LimitError::PageUavs { n: found.sites.len(), most: MOST_UAVS }.into());
        }
        let mut sites: Vec<Site> = found.sites.into_iter().map(|given| given.site).collect();
        if sites.is_empty() {
            sites.push(in_the_middle(&scene));
        }
        let page = LivePage::of(&scene, &sites, plan.sight, plan.scene_words)?;
        Ok(LivePage { facts: RunFacts { command: plan.command, ..page.facts }, ..page })
    }

    /// The page of a scene whose solids were kept, with UAVs that can be where they are.
    ///
    /// # Errors
    /// E505 of what is too large for a page.
    pub(crate) fn of(scene: &Scene, uavs: &[Site], sight: Sight, scene_words: Vec<String>) -> Result<LivePage> {
        let solids = scene.solids.clone().ok_or(Error::Fault("a live page needs the solids of its scene"))?;
        check_size(&scene.word, scene.grid(), &solids)?;
        let zones = scene.zones().map(|zones| PackedZones::of(zones.codes(), &scene.field.cells().open));
        let packed = pack(scene.grid(), &solids, zones.as_ref());
        let scene = Scene { solids: None, ..scene.clone() };
        let uavs = uavs.iter().map(asked).collect();
        Ok(LivePage { facts: scene.facts(None), scene, packed, uavs, sight, scene_words })
    }

    /// The page.
    ///
    /// # Errors
    /// E505 if it is too long.
    pub(crate) fn html(&self, look: &Look) -> Result<String> {
        let title = look.title_or(|| title_of(&format!("What a UAV sees of {}", self.scene.name)));
        let page = Page {
            title: &title,
            generator: &program(),
            facts: &self.facts_of_page(&title, look),
            scene: &self.packed,
        };
        let html = page.html();
        if html.len() > MOST_BYTES {
            let name = self.scene.word.clone();
            return Err(
                LimitError::PageBytes { name, mb: html.len() / 1_000_000, most_mb: MOST_BYTES / 1_000_000 }.into()
            );
        }
        Ok(html)
    }

    /// What the script of the page is told.
    fn facts_of_page(&self, title: &str, look: &Look) -> Value {
        let grid = self.scene.grid();
        let crs = grid
            .crs()
            .map(|crs| json!({"label": crs.label(), "name": crs.name(), "epsg": crs.epsg(), "wkt": wkt_of(crs)}));
        let sight = questions::Sight {
            rx_height_m: self.sight.rx_height_m(),
            receivers: match self.sight.receivers() {
                Receivers::Ground => questions::Receivers::Ground,
                Receivers::Street => questions::Receivers::Street,
                Receivers::Crossroad => questions::Receivers::Crossroad,
                Receivers::Courtyard => questions::Receivers::Courtyard,
                Receivers::Roof => questions::Receivers::Roof,
                Receivers::All => questions::Receivers::All,
            },
            radius_m: self.sight.radius_m(),
        };
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
            "start": {"uavs": self.uavs, "sight": sight, "layer": layer},
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

/// A site as the page knows it.
fn asked(site: &Site) -> questions::Uav {
    questions::Uav { id: site.id.clone(), x: site.x, y: site.y, height: site.height.into() }
}

/// A UAV over the middle of a scene, or above all of it where the middle is no place for one.
fn in_the_middle(scene: &Scene) -> Site {
    let (grid, field) = (scene.grid(), &scene.field);
    let (x, y) = grid.world_from_cell(grid.n_rows() / 2, grid.n_cols() / 2);
    let site = |height| Site { id: "1".into(), x, y, height };
    let above_ground = site(Height::agl(START_HEIGHT_M));
    match coverage::Uav::place(&above_ground, field, None) {
        Ok(_) => above_ground,
        Err(_) => site(Height::amsl((meters(field.max_top().max(0)) + 20.0).ceil())),
    }
}

/// The box of a raster that is in range of UAVs, west, south, east, north, where a page cannot hold all of it.
fn part_in_range(options: &SceneOptions, word: &OsStr, plan: &LivePlan) -> Result<Option<[f64; 4]>> {
    if !is_raster_scene(word) || options.project.is_some() {
        return Ok(None);
    }
    let grid = surface_grid(Path::new(word), &options.of_raster()?)?;
    let Some(radius) = plan.sight.radius_on(&grid).filter(|_| grid.n_cells() > MOST_CELLS) else { return Ok(None) };
    let found = plan.uavs.read(&grid)?;
    let boxes = found.sites.iter().map(|s| [s.x - radius, s.y - radius, s.x + radius, s.y + radius]);
    Ok(boxes.reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]))
}

/// Refuses what a page cannot hold, and says what would fit.
///
/// # Errors
/// E505.
fn check_size(word: &str, grid: &GeoRef, solids: &Solids) -> Result<()> {
    let name = word.to_string();
    let footprints = match solids {
        Solids::Vector { footprints, .. } => footprints.len(),
        Solids::Raster { .. } => 0,
    };
    if footprints > MOST_FOOTPRINTS {
        let part = (MOST_FOOTPRINTS as f64 / footprints as f64).sqrt();
        return Err(LimitError::PageFootprints {
            name,
            n: footprints,
            most: MOST_FOOTPRINTS,
            extent: middle(grid, part),
        }
        .into());
    }
    let n = grid.n_cells();
    if n > MOST_CELLS {
        let part = (MOST_CELLS as f64 / n as f64).sqrt();
        let cell_m = grid.cell_width().max(grid.cell_height()) * grid.meters_per_unit() / part;
        let is_raster = matches!(solids, Solids::Raster { .. });
        let cell = tidy((cell_m * 10.0).ceil() / 10.0);
        return Err(
            LimitError::PageCells { name, n, most: MOST_CELLS, cell, extent: middle(grid, part), is_raster }.into()
        );
    }
    Ok(())
}

/// The middle of a grid, of so much of each side: west, south, east, north, in whole units.
fn middle(grid: &GeoRef, part: f64) -> String {
    let span = |low: f64, high: f64| {
        let (center, half) = ((low + high) / 2.0, (high - low) / 2.0 * part);
        ((center - half).ceil(), (center + half).floor())
    };
    let ((west, east), (south, north)) = (span(grid.x_min(), grid.x_max()), span(grid.y_min(), grid.y_max()));
    format!("{west},{south},{east},{north}")
}
