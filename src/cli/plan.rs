//! What was typed, resolved: the scene read and built, sites placed, numbers checked.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use super::args::{Base, Command, HeightUnitArg, Missing, Nodata, SceneArgs};
use super::info::results_in;
use super::memory::{ANY_WORK, FIELD_BYTES_PER_CELL, cells_of, check_bytes, check_memory};
use super::repairs::keep;
use super::words::title_of;
use crate::coverage::Uav;
use crate::crs;
use crate::error::{Error, Result, Warning};
use crate::export::{Format, OutputRules, check_outputs};
use crate::formats::RasterFile;
use crate::height_field::HeightField;
use crate::los::Method;
use crate::quantity::{Height, height_steps, parse_number};
use crate::raster::{Crs, GeoRef};
use crate::read::{
    BaseRule, DataAreaChoice, FootprintOptions, HeightUnit, MeshOptions, MissingHeight, SurfaceOptions, SystemSaid,
    VectorFormat, compare_vertical, read_footprints, read_footprints_and_repairs, read_mesh, read_surface, vertical_of,
};
use crate::report::{RunFacts, Timing};
use crate::scene::{BuiltUp, BuiltUpCity, HeightGap, NodataAs, Scene, Site, Solids, Source};
use crate::zones::ZoneMap;

/// A scene ready for rays, and what is known about where it came from.
#[derive(Debug, Clone)]
pub(super) struct Ready {
    pub(super) name: String,
    /// Shared by the runs of many UAVs.
    pub(super) field: Arc<HeightField>,
    pub(super) sources: Vec<Source>,
    /// Whom pictures must credit.
    pub(super) attribution: Option<String>,
    /// Footprints without heights, where there are any.
    pub(super) height_gap: Option<HeightGap>,
    pub(super) built_up: Option<BuiltUp>,
    pub(super) seed: Option<u64>,
    pub(super) warnings: Vec<Warning>,
    pub(super) timing: Timing,
}

/// Refuses a scene that is no file but the name of a built-up environment, which stands behind `itu:`.
///
/// # Errors
/// E301.
pub(super) fn check_scene(command: &Command) -> Result<()> {
    let more = if let Command::Plos(args) = command { &args.more_cities[..] } else { &[] };
    for scene in std::iter::once(&command.scene().scene).chain(more) {
        let word = format!("itu:{scene}");
        if matches!(BuiltUpCity::parse_built_up(&word), Some(Ok(_))) && !Path::new(scene).exists() {
            let text = format!("cannot read {scene}: no such file");
            return Err(Error::file(301, text).with_hint(format!("`{word}` is a generated city")));
        }
    }
    Ok(())
}

/// Reads a scene without building it.
pub(super) fn read_scene(args: &SceneArgs, warnings: &mut Vec<Warning>) -> Result<Scene> {
    if let Some(built_up) = args.scene.built_up() {
        let city = BuiltUpCity {
            built_up: built_up?,
            size_m: args.size,
            margin_m: args.margin_m,
            cell_m: args.cell.unwrap_or(1.0),
            seed: args.seed,
            ground_m: args.ground.unwrap_or(0.0),
        };
        let of_files = ["terrain", "extent", "crs", "project", "building_threshold", "nodata_as"];
        refuse_flags(args, "a generated city", &OF_FOOTPRINTS)?;
        refuse_flags(args, "a generated city", &of_files)?;
        if let Some(bytes) = city.memory() {
            check_bytes(&args.scene, "its buildings and cells", bytes)?;
        }
        return city.scene();
    }
    if let Some((grid, bytes)) = size_of_raster(args) {
        check_bytes(&args.scene, &cells_of(&grid), bytes.saturating_add(ANY_WORK))?;
    }
    let scene = read_file(args, warnings)?;
    warn_of_raster(args, warnings)?;
    Ok(scene)
}

/// Warns of what else a raster says of its values than that they are heights, and of what these are above.
pub(super) fn warn_of_raster(args: &SceneArgs, warnings: &mut Vec<Warning>) -> Result<()> {
    warn_of_results(args, warnings);
    warn_of_heights(args, warnings)
}

/// Warns of a raster that this program wrote for something else than heights.
fn warn_of_results(args: &SceneArgs, warnings: &mut Vec<Warning>) {
    let path = Path::new(&args.scene);
    if let Some(schema) = Some(path).filter(|path| is_raster(path)).and_then(results_in) {
        let text = format!(
            "{}: it holds results of this program ({schema}), not heights; its values are read as heights (`skyshed info` \
             tells what it is)",
            path.display()
        );
        warnings.push(Warning::new(373, text));
    }
}

/// Compares what the heights of a raster scene and of its terrain are above.
fn warn_of_heights(args: &SceneArgs, warnings: &mut Vec<Warning>) -> Result<()> {
    let scene = Path::new(&args.scene);
    let (Some(terrain), true) = (&args.terrain, is_raster(scene)) else { return Ok(()) };
    let said = if args.crs.is_some() { SystemSaid::ByUser } else { SystemSaid::ByFiles };
    let [of_scene, of_terrain] = [scene, terrain].map(vertical_of);
    compare_vertical((scene, of_scene.as_ref()), (terrain, of_terrain.as_ref()), said, warnings)
}

/// The extension of a path in lower case.
fn extension_of(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Whether a scene of this name is read as a raster: any file that is neither footprints nor a mesh.
pub(super) fn is_raster(path: &Path) -> bool {
    let extension = extension_of(path);
    VectorFormat::of_extension(&extension).is_none() && !["obj", "ply"].contains(&extension.as_str())
}

/// Whether a scene as typed is a raster.
pub(super) fn is_raster_scene(args: &SceneArgs) -> bool {
    args.scene.built_up().is_none() && is_raster(Path::new(&args.scene))
}

/// The grid of a scene that is a raster in its own system, and the bytes that it takes in memory, by its header. What is wrong
/// with the file is told where it is read.
///
/// These are 5 for each cell, its height and what zone it may be of; what a terrain takes; and an unpacked strip or tile.
pub(super) fn size_of_raster(args: &SceneArgs) -> Option<(GeoRef, u64)> {
    // What is brought into another system is put together in memory.
    if !is_raster_scene(args) || args.project.is_some() {
        return None;
    }
    let file = RasterFile::open(Path::new(&args.scene), &mut Vec::new()).ok()?;
    if file.is_empty() {
        return None;
    }
    let (grid, n_cells) = (file.georef(), file.georef().n_cells() as u64);
    // All of a terrain is read, and if it is on another grid brought to that of the surface.
    let below = args.terrain.as_deref().and_then(|path| RasterFile::open(path, &mut Vec::new()).ok());
    let of_terrain = below.map_or(0, |below| {
        let n_below = below.georef().n_cells() as u64;
        let n_brought = if n_below == n_cells { 0 } else { n_cells };
        n_below.saturating_add(n_brought).saturating_mul(4).saturating_add(below.block_bytes())
    });
    let bytes = n_cells.saturating_mul(5).saturating_add(of_terrain).saturating_add(file.block_bytes());
    Some((grid.clone(), bytes))
}

/// Reads the scene of a file.
fn read_file(args: &SceneArgs, warnings: &mut Vec<Warning>) -> Result<Scene> {
    let path = Path::new(&args.scene);
    let (crs, nodata_as) = (typed_crs(args)?, nodata_as(args));
    match VectorFormat::of_extension(&extension_of(path)) {
        Some(format) => {
            if format != VectorFormat::GeoPackage {
                refuse_flags(args, "a file that is no GeoPackage", &["layer"])?;
            }
            let options = footprint_options(args, crs, nodata_as)?;
            if args.repairs.is_none() {
                return read_footprints(path, &options, warnings);
            }
            let (scene, repairs) = read_footprints_and_repairs(path, &options, warnings)?;
            keep(args, &scene, repairs, warnings);
            Ok(scene)
        }
        None if !is_raster(path) => {
            refuse_flags(args, "a mesh", &["size", "project"])?;
            refuse_flags(args, "a mesh", &OF_FOOTPRINTS)?;
            let surface = surface_options(args, crs, nodata_as)?;
            read_mesh(path, &MeshOptions { surface, extent: args.extent, cell_m: args.cell }, warnings)
        }
        None => read_surface(path, &raster_options(args)?, warnings),
    }
}

/// How a raster is to be read.
pub(super) fn raster_options(args: &SceneArgs) -> Result<SurfaceOptions> {
    refuse_flags(args, "a raster", &["extent", "size"])?;
    refuse_flags(args, "a raster", &OF_FOOTPRINTS)?;
    if args.project.is_none() {
        refuse_flags(args, "a raster without `--project`", &["cell"])?;
    }
    let surface = surface_options(args, typed_crs(args)?, nodata_as(args))?;
    Ok(SurfaceOptions { project: args.project.clone(), cell_m: args.cell, ..surface })
}

/// The CRS that was typed.
fn typed_crs(args: &SceneArgs) -> Result<Option<Crs>> {
    args.crs.as_deref().map(crs::parse).transpose().map_err(|e| Error::usage(115, format!("`--crs`: {e}")))
}

fn nodata_as(args: &SceneArgs) -> NodataAs {
    match args.nodata_as {
        Nodata::Block => NodataAs::Block,
        Nodata::Clear => NodataAs::Clear,
    }
}

/// How a surface is to be read.
fn surface_options(args: &SceneArgs, crs: Option<Crs>, nodata_as: NodataAs) -> Result<SurfaceOptions> {
    if args.terrain.is_none() && args.ground.is_none() {
        refuse_flags(args, "a surface without `--terrain` or `--ground`", &["building_threshold"])?;
    }
    Ok(SurfaceOptions {
        terrain: args.terrain.clone(),
        ground_m: args.ground,
        building_threshold_m: args.building_threshold,
        nodata_as,
        crs,
        always_hash: args.hash,
        ..SurfaceOptions::default()
    })
}

/// Flags that only footprints can use.
const OF_FOOTPRINTS: [&str; 8] =
    ["height_field", "top_field", "height_unit", "levels_field", "missing", "layer", "base", "data_area"];

/// How footprints are to be read.
fn footprint_options(args: &SceneArgs, crs: Option<Crs>, nodata_as: NodataAs) -> Result<FootprintOptions> {
    refuse_flags(args, "footprints", &["size", "building_threshold"])?;
    if args.terrain.is_none() {
        refuse_flags(args, "footprints without `--terrain`", &["nodata_as", "base"])?;
    }
    if args.missing != Some(Missing::Levels) {
        refuse_flags(args, "footprints without `--missing levels`", &["levels_field"])?;
    }
    Ok(FootprintOptions {
        height_field: args.height_field.clone(),
        top_field: args.top_field.clone(),
        height_unit: match args.height_unit {
            HeightUnitArg::M => HeightUnit::Meters,
            HeightUnitArg::Ft => HeightUnit::Feet,
        },
        levels_field: args.levels_field.clone(),
        missing: match args.missing {
            None => MissingHeight::Few,
            Some(Missing::Fail) => MissingHeight::Fail,
            Some(Missing::Drop) => MissingHeight::Drop,
            Some(Missing::Levels) => MissingHeight::Levels,
            Some(Missing::Median) => MissingHeight::Median,
        },
        layer: args.layer.clone(),
        terrain: args.terrain.clone(),
        ground_m: args.ground,
        extent: args.extent,
        cell_m: args.cell,
        crs,
        project: args.project.clone(),
        nodata_as,
        base: match args.base {
            Base::Lowest => BaseRule::Lowest,
            Base::Mean => BaseRule::Mean,
            Base::Highest => BaseRule::Highest,
        },
        data_area: match (args.data_area_file(), &args.data_area) {
            (Some(path), _) => DataAreaChoice::Within(path),
            (None, Some(word)) if word.as_os_str() == "all" => DataAreaChoice::All,
            (None, _) => DataAreaChoice::Auto,
        },
        always_hash: args.hash,
    })
}

/// An ignored input is an error, never silence.
fn refuse_flags(args: &SceneArgs, what: &str, without_meaning: &[&str]) -> Result<()> {
    match without_meaning.iter().find(|name| args.typed.iter().any(|typed| typed == *name)) {
        Some(name) => Err(Error::usage(116, format!("`--{}` has no meaning for {what}", name.replace('_', "-")))),
        None => Ok(()),
    }
}

/// Reads a scene and builds its height field.
pub(super) fn ready(args: &SceneArgs) -> Result<Ready> {
    let start = Instant::now();
    let mut warnings = Vec::new();
    let scene = read_scene(args, &mut warnings)?;
    built(args, (scene, warnings), start)
}

/// A scene that was read since `start`, with its height field.
pub(super) fn built(args: &SceneArgs, (scene, mut warnings): (Scene, Vec<Warning>), start: Instant) -> Result<Ready> {
    let read = start.elapsed().as_secs_f64();
    let Scene { name, grid, solids, built_up, sources, attribution, height_gap } = scene;
    // Heights of a raster are there already.
    if matches!(solids, Solids::Vector { .. }) {
        check_memory(&args.scene, &grid, FIELD_BYTES_PER_CELL)?;
    }
    let field = HeightField::build(&grid, solids, &mut warnings);
    let build = start.elapsed().as_secs_f64() - read;
    let seed = built_up.map(|_| args.seed);
    Ok(Ready {
        name,
        field: Arc::new(field),
        sources,
        attribution,
        height_gap,
        built_up,
        seed,
        warnings,
        timing: Timing { read, build, ..Timing::default() },
    })
}

impl Ready {
    /// What documents say of this run.
    pub(super) fn facts(&self, command: Vec<String>, method: Option<Method>) -> RunFacts {
        RunFacts {
            command,
            method,
            scene_name: self.name.clone(),
            grid: self.field.grid().clone(),
            meters_per_unit: self.field.grid().meters_per_unit(),
            sources: self.sources.clone(),
            seed: self.seed,
            warnings: self.warnings.clone(),
            unit: None,
        }
    }

    /// What limits the truth of a picture of the scene.
    pub(super) fn limits_in_words(&self) -> Option<String> {
        limits_in_words(self.height_gap.as_ref(), &self.field, &self.warnings)
    }

    /// The zones of the scene; none where no building is known.
    pub(super) fn zones(&self) -> Option<ZoneMap> {
        ZoneMap::if_known(&self.field, self.built_up.as_ref())
    }

    /// A length in meters as CRS units.
    pub(super) fn crs_units(&self, meters: f64) -> f64 {
        meters / self.field.grid().meters_per_unit()
    }
}

/// What limits the truth of a picture of a scene, in words: pictures travel without what was said beside them.
pub(super) fn limits_in_words(gap: Option<&HeightGap>, field: &HeightField, warnings: &[Warning]) -> Option<String> {
    let mut limits: Vec<String> = Vec::new();
    if let Some(gap) = gap {
        let share = 100.0 * gap.area_share;
        limits.push(format!("{share:.1} % of the footprint area has no height: {}", gap.done));
    }
    if let Some(outside) = field.outside_data() {
        #[expect(clippy::cast_precision_loss, reason = "a share for reading")]
        let share = 100.0 * outside.count() as f64 / field.grid().n_cells() as f64;
        limits.push(format!("no data beyond the footprints ({share:.0} % of the extent)"));
    }
    if field.is_surface_only() {
        limits.push("a surface model alone: receivers stand on roofs and trees too".into());
    }
    if warnings.iter().any(|warning| warning.code() == FLAT_EARTH) {
        limits.push("the earth is taken as flat".into());
    }
    (!limits.is_empty()).then(|| title_of(&limits.join("; ")))
}

/// The input files that a scene names, for the refusal to overwrite them.
pub(super) fn input_paths(args: &SceneArgs) -> Vec<PathBuf> {
    std::iter::once(PathBuf::from(&args.scene)).chain(args.terrain.clone()).chain(args.data_area_file()).collect()
}

/// A UAV as typed: `X,Y,H`.
pub(super) fn parse_uav(text: &str, id: String) -> Result<Site> {
    let wrong = |found: String| {
        Error::usage(102, format!("cannot read `--uav {text}`: {found}"))
            .with_hint("write X,Y,H, for example 500,500,100 or 691549.7,5334762.2,30roof")
    };
    let parts: Vec<&str> = text.split(',').collect();
    let [x, y, h] = parts[..] else { return Err(wrong(format!("found {} values, wanted X,Y,H", parts.len()))) };
    let x = parse_number(x).map_err(|e| wrong(format!("x: {e}")))?;
    let y = parse_number(y).map_err(|e| wrong(format!("y: {e}")))?;
    Ok(Site { id, x, y, height: h.parse().map_err(wrong)? })
}

/// A receiver as typed: `X,Y[,H]`.
pub(super) fn parse_receiver(text: &str, rx_height_m: f64) -> Result<(f64, f64, Height)> {
    let wrong = |found: String| {
        Error::usage(103, format!("cannot read `--rx {text}`: {found}"))
            .with_hint("write X,Y or X,Y,H, for example 630,480 or 620,480,1.5roof")
    };
    let parts: Vec<&str> = text.split(',').collect();
    let (x, y, h) = match parts[..] {
        [x, y] => (x, y, None),
        [x, y, h] => (x, y, Some(h)),
        _ => return Err(wrong(format!("found {} values, wanted X,Y or X,Y,H", parts.len()))),
    };
    let x = parse_number(x).map_err(|e| wrong(format!("x: {e}")))?;
    let y = parse_number(y).map_err(|e| wrong(format!("y: {e}")))?;
    let height = h.map_or(Ok(Height::AboveGround(rx_height_m)), str::parse).map_err(wrong)?;
    Ok((x, y, height))
}

/// A receiver height on the lattice.
pub(super) fn receiver_height(meters: f64) -> Result<i32> {
    height_steps(meters)
        .filter(|h| *h >= 0)
        .ok_or_else(|| Error::usage(113, format!("`--rx-height` is `{meters}`, wanted 0 m to 32768 m")))
}

/// A range in meters: above zero.
pub(super) fn checked_radius(radius: Option<f64>) -> Result<Option<f64>> {
    match radius {
        Some(r) if r <= 0.0 => Err(Error::usage(113, format!("`--radius` is `{r}`, wanted above 0 m"))),
        other => Ok(other),
    }
}

/// The code of the warning of a flat earth.
const FLAT_EARTH: &str = "W201";

/// Mean radius of the Earth \[m\].
const EARTH_RADIUS_M: f64 = 6_371_000.0;

/// Warns where the flat earth of every engine matters: the horizon's drop d²/2R exceeds a meter.
pub(super) fn warn_of_flat_earth(uavs: &[Uav], grid: &GeoRef, radius: Option<f64>, warnings: &mut Vec<Warning>) {
    let unit = grid.meters_per_unit();
    let farthest = uavs
        .iter()
        .map(|uav| {
            let place = &uav.station.place;
            let dx = (grid.x_max() - place.x).abs().max((grid.x_min() - place.x).abs());
            let dy = (grid.y_max() - place.y).abs().max((grid.y_min() - place.y).abs());
            dx.hypot(dy) * unit
        })
        .fold(0.0, f64::max)
        .min(radius.map_or(f64::INFINITY, |r| r * unit));
    warn_of_drop(farthest, warnings);
}

/// Warns likewise where UAVs and receivers may be anywhere on a grid, but no farther apart than some meters.
pub(super) fn warn_of_drop_across(grid: &GeoRef, most_m: f64, warnings: &mut Vec<Warning>) {
    let across = (grid.x_max() - grid.x_min()).hypot(grid.y_max() - grid.y_min()) * grid.meters_per_unit();
    warn_of_drop(across.min(most_m), warnings);
}

/// Warns likewise of receivers up to so far away \[m\].
pub(super) fn warn_of_drop(farthest: f64, warnings: &mut Vec<Warning>) {
    let drop = farthest * farthest / (2.0 * EARTH_RADIUS_M);
    if drop > 1.0 {
        warnings.push(Warning::new(
            201,
            format!("the earth is taken as flat; at {farthest:.0} m, the farthest receiver, it drops by {drop:.1} m"),
        ));
    }
}

/// The outputs, and after them the table of `--csv FILE`, all checked together.
pub(super) fn outputs_with_table(
    outputs: &[PathBuf],
    csv: Option<&PathBuf>,
    rules: OutputRules<'_>,
) -> Result<Vec<(PathBuf, Format)>> {
    if let Some(path) = csv.filter(|path| !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"))) {
        let text = format!("cannot write {}: `--csv` writes a table", path.display());
        return Err(Error::usage(105, text).with_hint("give it a name that ends in .csv"));
    }
    let all: Vec<PathBuf> = outputs.iter().chain(csv).cloned().collect();
    check_outputs(&all, rules)
}
