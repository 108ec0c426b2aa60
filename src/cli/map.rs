//! `skyshed map`: coverage of one or many UAVs.

use std::path::PathBuf;
use std::time::Instant;

use super::args::{LayerArg, MapArgs};
use super::expected::Expected;
use super::height_curve::{CurvePlan, Curves};
use super::map_drawing::draws_each;
use super::map_files::{MaskFile, Writer, check_flags, mask_values, written_at_once};
use super::map_sites::SiteRuns;
use super::map_streamed::{StreamedRun, reason_for_strips};
use super::memory::{FIELD_BYTES_PER_CELL, check_memory};
use super::messages::WarningsOfRuns;
use super::outside::{place_uav, warn_of_uavs_outside};
use super::plan::{Ready, checked_radius, input_paths, is_raster_scene, ready, receiver_height, warn_of_flat_earth};
use super::receivers::{Asked, check_receivers, warn_of_no_receivers};
use super::tables::{UavsAsked, UavsFound};
use super::tolerance::{checked_tolerance, in_words as tolerance_in_words, simplify};
use super::words::{idle_in_words, pretty};
use super::{interrupt, messages};
use crate::coverage::{
    Control, HeightLayers, KeepMasks, ManyMaps, MapOptions, Mapper, SiteCoverage, Tally, Uav, maps_at_once,
};
use crate::error::{Error, Result, Warning};
use crate::export::{Batch, Format, Layer, OutputRules, bare_name, check_layers, check_outputs};
use crate::los::Method;
use crate::quantity::{counted, tidy};
use crate::raster::{CellWindow, GeoRef};
use crate::read::StreamedSurface;
use crate::render::Mark;
use crate::report::{MapReport, MaskDigest, RunFacts, SiteFacts, Timing, zone_tallies};
use crate::scene::GivenSite;

/// Formats of `skyshed map`.
const FORMATS: [Format; 14] = [
    Format::Png,
    Format::Svg,
    Format::Pdf,
    Format::GeoTiff,
    Format::Exr,
    Format::AsciiGrid,
    Format::Bil,
    Format::Npz,
    Format::Kmz,
    Format::Csv,
    Format::Json,
    Format::GeoJson,
    Format::FlatGeobuf,
    Format::Stdout,
];

/// What a run is given that was read before.
#[derive(Default)]
pub(super) struct Given<'a> {
    /// The UAVs, instead of those that were typed.
    pub(super) uavs: Option<UavsFound>,
    /// The scene, instead of the one that was typed.
    pub(super) scene: GivenScene<'a>,
    /// The grid of which the scene may be a part.
    pub(super) grid: Option<&'a GeoRef>,
    /// What the run is one of, for `--resume`.
    pub(super) unit: Option<String>,
    /// Where warnings go that other runs may give too.
    pub(super) batch: Option<&'a mut WarningsOfRuns>,
}

/// A scene that was read before, or is still to be read.
#[derive(Default)]
pub(super) enum GivenScene<'a> {
    /// Read it.
    #[default]
    Typed,
    /// In memory.
    InMemory(Box<Ready>),
    /// In tiles on disk, with what was said of it.
    OnDisk(&'a StreamedSurface, Vec<Warning>),
}

pub(super) fn run(args: &MapArgs, command: Vec<String>) -> Result<()> {
    if args.strips && (!is_raster_scene(&args.scene) || args.scene.project.is_some()) {
        return Err(Error::usage(116, "`--strips` has no meaning but for a raster in its own system"));
    }
    match SiteRuns::of(args)? {
        Some(runs) => runs.run(command),
        None => run_one(args, command, Given::default()),
    }
}

/// Maps all UAVs together, into files that appear together.
pub(super) fn run_one(args: &MapArgs, command: Vec<String>, given: Given<'_>) -> Result<()> {
    let start = Instant::now();
    let rx_height = receiver_height(args.rx_height)?;
    let radius_m = checked_radius(args.engine.radius)?;
    let inputs: Vec<PathBuf> = input_paths(&args.scene).into_iter().chain(args.uavs.clone()).collect();
    let outputs = check_outputs(
        &args.output,
        OutputRules { allowed: &FORMATS, inputs: &inputs, overwrite: args.out.overwrite, bare: args.bare },
    )?;
    let curve_plan = CurvePlan::of(args, &inputs, &FORMATS)?;
    let prints_table = outputs.is_empty() && !args.out.json && !curve_plan.is_wanted();
    if args.bare && !outputs.iter().any(|(_, format)| *format == Format::Png) {
        return Err(Error::usage(116, "`--bare` has no meaning without a .png output"));
    }
    let names_layout = args.scene.typed.iter().any(|typed| typed == "tif_layout");
    if names_layout && !outputs.iter().any(|(_, format)| *format == Format::GeoTiff) {
        return Err(Error::usage(116, "`--tif-layout` has no meaning without a .tif output"));
    }
    // A pixel of a bare file is a cell: it has neither words nor a size.
    let is_drawn = |(_, format): &&(PathBuf, Format)| !(args.bare && *format == Format::Png);
    let files: Vec<_> = outputs.iter().filter(is_drawn).chain(curve_plan.outputs()).cloned().collect();
    args.words.refuse_without_picture(&files)?;
    let tolerance = checked_tolerance(args.tolerance, args.engine.method)?;
    let Given { uavs: given_uavs, scene: given_scene, grid: whole_grid, unit, batch: other_runs } = given;
    let asked_uavs = uavs_asked(args)?;
    let read_uavs = |grid: &GeoRef| given_uavs.map_or_else(|| asked_uavs.read(grid), Ok);
    let layers = layers(&args.layers);
    let mut scene = match given_scene {
        GivenScene::InMemory(scene) => *scene,
        GivenScene::Typed if reason_for_strips(args).is_none() => ready(&args.scene)?,
        not_in_memory => {
            let (outputs, layers) = (&outputs[..], &layers[..]);
            let run = StreamedRun { args, command, outputs, layers, rx_height, radius_m, start, unit, other_runs };
            return match not_in_memory {
                GivenScene::OnDisk(scene, warnings) => run.over(scene, warnings, read_uavs),
                _ => run.read(read_uavs),
            };
        }
    };
    let UavsFound { sites, sources, warnings } = read_uavs(scene.field.grid())?;
    scene.sources.extend(sources);
    scene.warnings.extend(warnings);
    let grid = whole_grid.unwrap_or(scene.field.grid());
    warn_of_uavs_outside(&sites, grid, &mut scene.warnings);
    if args.bare {
        check_bare_names(&sites, &outputs, args.out.overwrite)?;
    }
    for (path, format) in &outputs {
        check_layers(&layers, sites.len(), path, *format)?;
    }
    check_flags(args, &scene, &outputs)?;
    if args.gdal_values && (layers != [Layer::Los] || sites.len() > 1) {
        let names: Vec<&str> = layers.iter().map(|layer| layer.name()).collect();
        let text = format!(
            "`--gdal-values` writes line of sight of one UAV, found `--layers {}` of {}",
            names.join(","),
            counted(sites.len() as u64, "UAV", "UAVs")
        );
        return Err(Error::usage(107, text).with_hint("choose one UAV and `--layers los`"));
    }
    let before_build = Instant::now();
    let radius = radius_m.map(|r| scene.crs_units(r));
    let place = |site: &GivenSite| place_uav(site, &scene.field, whole_grid.unwrap_or(scene.field.grid()), radius);
    let mut uavs: Vec<Uav> = sites.iter().map(place).collect::<Result<_>>()?;
    check_receivers(args.receivers, &scene.field)?;
    let asked = Asked { receivers: args.receivers, rx_height, radius, engine: &args.engine };
    let tolerance = match tolerance {
        Some(tolerance) => Some(simplify(&mut scene, &mut uavs, &asked, (tolerance, args.scene.seed))?),
        None => None,
    };
    // Zones cost as much as a map: they are found where a table or a document tells them.
    let tells_zones = args.out.json
        || prints_table
        || args.receivers.zone().is_some()
        || outputs.iter().any(|(_, f)| matches!(f, Format::Csv | Format::Json | Format::GeoJson | Format::Stdout))
        || curve_plan.outputs().iter().any(|(_, f)| *f == Format::Json);
    let zones = if tells_zones { scene.zones() } else { None };
    warn_of_flat_earth(&uavs, scene.field.grid(), radius, &mut scene.warnings);
    let options = MapOptions {
        layers: HeightLayers {
            margin: layers.contains(&Layer::Margin),
            least_receiver_height: layers.contains(&Layer::LeastReceiverHeight),
            least_height: layers.contains(&Layer::LeastHeight),
            stability: layers.contains(&Layer::Stability),
        },
        ..asked.options(scene.field.grid(), zones.as_ref())
    };

    // Masks are kept for what is written cell by cell, unless that is done while they are made; for counts they are laid over
    // each other and dropped.
    let shows_masks = |f: Format| holds_masks(f, args) || f.is_picture() && draws_each(&layers);
    let keeps_masks =
        uavs.len() == 1 || args.bare || curve_plan.is_wanted() || outputs.iter().any(|(_, f)| shows_masks(*f));
    let n_measures = layers.iter().filter(|layer| layer.is_measure()).count();
    let is_shifted = layers.contains(&Layer::Stability);
    let direct = written_at_once(&outputs, &layers, args)
        .filter(|_| uavs.len() == 1 && zones.is_none() && !curve_plan.is_wanted());
    let (keep, n_held) = match (direct, keeps_masks) {
        (Some(_), _) => (KeepMasks::Never, 0),
        (None, true) => (KeepMasks::Always, uavs.len()),
        (None, false) => (KeepMasks::UntilTold, uavs.len().min(maps_at_once())),
    };
    let bytes_per_cell = n_held
        .saturating_mul(1 + 4 * n_measures)
        .saturating_add(if uavs.len() > 1 { OVERLAY_BYTES_PER_CELL } else { 0 })
        .saturating_add(if args.polygons.is_some() { OUTLINE_BYTES_PER_CELL } else { 0 })
        .saturating_add(curve_plan.bytes_per_cell())
        .saturating_add(encoding_bytes_per_cell(&outputs, &layers, uavs.len()))
        .saturating_add(if is_shifted { 2 * FIELD_BYTES_PER_CELL } else { 0 });
    check_memory(&args.scene.scene, scene.field.grid(), bytes_per_cell)?;
    let mut mapper = Mapper::new(&scene.field, &options)?;
    let idle = mapper.drop_idle(&uavs);
    if !args.out.quiet {
        let grid = scene.field.grid();
        let disc = radius.map_or(f64::INFINITY, |r| std::f64::consts::PI * r * r);
        let n_in_range = (disc / (grid.cell_width() * grid.cell_height())).min(grid.n_cells() as f64);
        let method = (mapper.method().0, rayon::current_num_threads());

        let expected =
            Expected::of(method, (grid.n_cells(), n_in_range), (uavs.len(), n_measures), bytes_per_cell).words();
        expected.iter().for_each(|words| messages::note(words));
    }
    let control = Control::default();
    scene.timing.build += before_build.elapsed().as_secs_f64();
    let before_los = Instant::now();
    let total = scene.field.grid().n_cells() as u64 * uavs.len() as u64;
    let mut digest = MaskDigest::new(scene.field.grid());
    let mut facts: Vec<SiteFacts> = Vec::with_capacity(uavs.len());
    let mut batch = Batch::new(args.out.overwrite);
    let mut file = direct.map(|path| MaskFile::new(path, mask_values(args)));
    let mapped = messages::with_progress(&control, (total, "receivers"), args.out.quiet, || {
        let each_part = |cells: &[u8]| match &mut file {
            None => digest.add(cells),
            Some(file) => {
                let write = || file.push(&mut batch, scene.field.grid(), cells, &control);
                rayon::join(|| digest.add(cells), write);
            }
        };
        let each_site = |site: &SiteCoverage| {
            let lonlat = sites[facts.len()].lonlat;
            facts.push(SiteFacts { lonlat, ..SiteFacts::of(site, zones.as_ref()) });
        };
        mapper.map_many(&uavs, keep, &control, each_part, each_site)
    });
    let file = file.map(MaskFile::written).transpose()?.flatten();
    let ManyMaps { sites: coverages, overlay } = mapped?;
    let (method, why) = mapper.method();
    drop(mapper);
    scene.timing.los = before_los.elapsed().as_secs_f64();

    warn_of_no_receivers(&coverages, &mut scene.warnings);
    let report = MapReport {
        facts: RunFacts { unit, ..scene.facts(command, Some(method)) },
        rx_height_m: args.rx_height,
        receivers: args.receivers.name(),
        radius_m,
        union_zones: match (&overlay, facts.as_slice()) {
            (None, [only]) => only.zones,
            (overlay, _) => overlay.as_ref().and_then(|o| zones.as_ref().map(|zones| zone_tallies(zones, o.union()))),
        },
        sites: facts,
        union: match (&overlay, coverages.as_slice()) {
            (None, [only]) => only.tally,
            (overlay, _) => overlay.as_ref().map_or(Tally::default(), |o| Tally::of_mask(o.union())),
        },
        tolerance,
        idle: (idle.footprints > 0).then_some(idle),
        digest: digest.finish(),
    };
    let curves = curve_plan.make(args, &scene, &coverages, &report)?;
    let before_write = Instant::now();
    let timing = Timing { total: start.elapsed().as_secs_f64(), ..scene.timing };
    interrupt::begin_writing();
    let job = Writer {
        args,
        scene: &scene,
        coverages: &coverages,
        overlay: overlay.as_ref(),
        layers: &layers,
        report: &report,
        timing,
    };
    match file {
        Some(strips) => {
            interrupt::check()?;
            let provenance = report.document(None).to_string();
            strips.finish(&mut batch, (scene.field.grid(), uavs[0].id.as_str(), provenance.as_str()))?;
        }
        None => outputs.iter().try_for_each(|(path, format)| job.add(&mut batch, path, *format))?,
    }
    for (path, format) in curve_plan.outputs() {
        for (file, bytes) in
            curves.iter().map(|c| c.encode(&scene, path, *format)).collect::<Result<Vec<_>>>()?.concat()
        {
            interrupt::check()?;
            batch.add(&file, &bytes)?;
        }
    }
    let written = batch.commit()?;
    scene.timing.write = before_write.elapsed().as_secs_f64();
    scene.timing.total = start.elapsed().as_secs_f64();

    if !args.out.quiet {
        let of_curves = curves.as_ref().map_or(&[][..], Curves::warnings);
        messages::warnings_of_run(other_runs, &sites[0].id, &[&report.facts.warnings, of_curves].concat());
        report.idle.iter().filter(|idle| idle.dropped() > 0).for_each(|idle| messages::note(&idle_in_words(idle)));
        report.tolerance.iter().for_each(|facts| messages::note(&tolerance_in_words(facts)));
        say_results(&report, why, scene.timing);
        curves.iter().for_each(Curves::say);
    }
    messages::wrote(&written, args.out.quiet);
    if args.out.json || outputs.iter().any(|(_, f)| *f == Format::Stdout) {
        return messages::answer(&pretty(&report.document(Some(scene.timing))));
    }
    if prints_table {
        return messages::answer(&String::from_utf8_lossy(&args.out.table(&report.table())?));
    }
    Ok(())
}

/// Where the UAVs are told; those of the command line are well-formed.
pub(super) fn uavs_asked(args: &MapArgs) -> Result<UavsAsked<'_>> {
    if args.uav.is_empty() && args.uavs.is_none() {
        return Err(Error::usage(108, "no UAV: wanted `--uav X,Y,H` or `--uavs FILE`"));
    }
    let asked =
        UavsAsked { typed: &args.uav, table: args.uavs.as_deref(), skip_bad: args.skip_bad, hash: args.scene.hash };
    asked.typed_sites().map(|_| asked)
}

/// Whether a file tells of each UAV cell by cell.
fn holds_masks(format: Format, args: &MapArgs) -> bool {
    match format {
        Format::GeoTiff | Format::Exr | Format::AsciiGrid | Format::Bil | Format::Npz => true,
        Format::Kmz | Format::FlatGeobuf => true,
        Format::GeoJson => args.polygons.is_some(),
        _ => false,
    }
}

fn layers(typed: &[LayerArg]) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    for layer in typed {
        let layer = match layer {
            LayerArg::Los => Layer::Los,
            LayerArg::Margin => Layer::Margin,
            LayerArg::LeastReceiverHeight => Layer::LeastReceiverHeight,
            LayerArg::LeastHeight => Layer::LeastHeight,
            LayerArg::Stability => Layer::Stability,
            LayerArg::Count => Layer::Count,
            LayerArg::Which => Layer::Which,
        };
        if !layers.contains(&layer) {
            layers.push(layer);
        }
    }
    layers
}

/// Refuses bare pictures of several sites that would share a name or replace a file, before any work.
fn check_bare_names(sites: &[GivenSite], outputs: &[(PathBuf, Format)], overwrite: bool) -> Result<()> {
    let mut names = std::collections::HashMap::new();
    for (path, _) in outputs.iter().filter(|(_, f)| *f == Format::Png && sites.len() > 1) {
        for site in sites {
            let name = bare_name(path, &site.id);
            if let Some(other) = names.insert(name.clone(), &site.id) {
                return Err(Error::site(
                    207,
                    format!("sites `{other}` and `{}` would share the file {}", site.id, name.display()),
                ));
            }
            if !overwrite && name.exists() {
                return Err(Error::usage(106, format!("cannot write {}: it exists", name.display()))
                    .with_hint("`--overwrite` replaces it"));
            }
        }
    }
    Ok(())
}

/// What the largest of the outputs takes for each cell while it is made, of maps of `n_sites` UAVs.
pub(super) fn encoding_bytes_per_cell(outputs: &[(PathBuf, Format)], layers: &[Layer], n_sites: usize) -> usize {
    /// Of a picture: heights, relief, colors.
    const PICTURE: usize = 9;
    /// Of the layers that hold all UAVs together.
    const OF_ALL: usize = 8;
    let n_measures = layers.iter().filter(|layer| layer.is_measure()).count();
    let n_of_all = layers.iter().filter(|layer| matches!(layer, Layer::Count | Layer::Which)).count();
    let of_format = |format: Format| match format {
        Format::Png | Format::Svg | Format::Pdf | Format::Kmz => PICTURE,
        // Masks as numbers of 4 bytes; measures are numbers already.
        Format::Exr => n_sites.saturating_mul(4).saturating_add(OF_ALL * n_of_all),
        // All in one array for each layer.
        Format::Npz => n_sites.saturating_mul(1 + 4 * n_measures).saturating_add(OF_ALL * n_of_all),
        Format::AsciiGrid | Format::Bil => 4,
        _ => 0,
    };
    outputs.iter().map(|(_, format)| of_format(*format)).max().unwrap_or(0)
}

/// What finding the connected parts of a class takes: the number of each cell's part, and the edges around it.
const OUTLINE_BYTES_PER_CELL: usize = 5;

/// What all masks laid over each other take.
const OVERLAY_BYTES_PER_CELL: usize = 5;

/// The cells of a window, row by row.
pub(super) fn crop<T: Copy>(cells: &[T], n_cols: usize, window: CellWindow) -> Vec<T> {
    let rows = cells.chunks_exact(n_cols).skip(window.row).take(window.n_rows);
    rows.flat_map(|row| row[window.col..window.col + window.n_cols].iter().copied()).collect()
}

/// The mark of a UAV at a place, on a map of a grid.
pub(super) fn mark<'a>(shown: &GeoRef, (x, y): (f64, f64), label: &'a str, height: &'a str) -> Mark<'a> {
    let (col, row) = ((x - shown.x_min()) / shown.cell_width(), (shown.y_max() - y) / shown.cell_height());
    Mark { label, height, col, row }
}

pub(super) fn undrawable(cause: String) -> Error {
    Error::internal(403, format!("cannot draw the picture: {cause}"))
}

pub(super) fn height_words(site: &SiteFacts) -> String {
    match site.height_agl_m {
        Some(agl) => format!("{} m above ground", tidy(agl)),
        None => format!("{} m above the datum", tidy(site.height_amsl_m)),
    }
}

/// Tells what was found, and how.
pub(super) fn say_results(report: &MapReport, why: &str, timing: Timing) {
    for site in &report.sites {
        let share = site.tally.p_los().map_or("undefined".to_string(), |p| format!("{p:.4}"));
        messages::note(&format!(
            "UAV {}: P_LoS {share}, {} of {} receivers",
            site.id, site.tally.los, site.tally.receivers
        ));
    }
    messages::note(&format!(
        "method {} ({}; {why}): line of sight {:.3} s of {:.2} s",
        report.facts.method_name(),
        report.facts.method.map_or("", Method::exactness),
        timing.los,
        timing.total
    ));
}
