//! `skyshed place`: where to hover.
//!
//! `args` holds what can be typed, `goal` what a goal asks, `inputs` the areas, weights and candidates, `search` what is
//! worth what, `outputs` the files, `picture` the heat map, `winner_map` what the winner sees.

mod args;
mod goal;
mod inputs;
mod outputs;
mod picture;
mod search;
mod winner_map;

use std::path::PathBuf;
use std::time::Instant;

use super::messages;
use super::plan::{input_paths, outputs_with_table, ready};
use super::sample::SampleJob;
use crate::coverage::{MapOptions, Mapper, Receivers, Uav, UavGrid};
use crate::error::{Error, Result};
use crate::export::{Format, OutputRules, check_outputs};
use crate::map::{Asked, Expected, check_receivers, checked_radius, receiver_height};
use crate::memory::check_memory;
use crate::placement::Weights;
use crate::quantity::{Height, height_steps};
use crate::report::{PlaceReport, Timing};
use crate::scene::Scene;
use crate::scene::limits::warn_of_flat_earth;
use crate::words::pretty;
use crate::zones::{Zone, ZoneMap};

pub(super) use args::PlaceArgs;
use goal::{Goal, Whom};
use inputs::Inputs;
use search::Search;

/// Formats of `skyshed place`.
const FORMATS: [Format; 8] = [
    Format::Png,
    Format::Svg,
    Format::Pdf,
    Format::GeoTiff,
    Format::Csv,
    Format::Json,
    Format::GeoJson,
    Format::Stdout,
];

pub(super) fn run(args: &PlaceArgs, command: Vec<String>) -> Result<()> {
    if !args.sample.sample.is_empty() {
        return sampled(args, command);
    }
    let start = Instant::now();
    let goal = Goal::of(args)?;
    let heights = args.height.as_deref().map(goal::heights).transpose()?;
    check(args, heights.as_deref())?;
    let rx_height = receiver_height(args.rx_height)?;
    let radius_m = checked_radius(args.engine.radius)?;
    let clearance = height_steps(args.clearance)
        .filter(|c| *c >= 0)
        .ok_or_else(|| Error::usage(113, format!("`--clearance` is `{}`, wanted 0 m to 32768 m", args.clearance)))?;
    let (outputs, map) = outputs_of(args, &FORMATS)?;

    let mut scene = ready(&args.scene)?;
    let needs_zones = !args.over.is_empty() || matches!(goal.whom, Whom::Zone(_)) || args.receivers.zone().is_some();
    if scene.field.is_surface_only() && needs_zones {
        let text = "zones of a surface model alone: no building is known, so no zone is";
        return Err(Error::usage(117, text).with_hint("give `--terrain FILE` or `--ground Z`"));
    }
    check_receivers(args.receivers, &scene.field)?;
    let zones = scene.zones();
    let mut warnings = Vec::new();
    let mut inputs = Inputs::read(args, goal, heights, &scene, &mut warnings)?;
    scene.warnings.append(&mut warnings);
    scene.sources.append(&mut inputs.sources);
    let radius = radius_m.map(|r| scene.crs_units(r));
    let over: Vec<Zone> = args.over.iter().map(|z| z.zone()).collect();
    let rules = inputs.rules(zones.as_ref().map(|zones| (over.as_slice(), zones)), clearance, radius);
    let candidates = inputs.candidates(&scene.field, &rules)?;
    // The corners see farthest.
    let farthest: Vec<Uav> =
        candidates.kept.first().iter().chain(&candidates.kept.last()).map(|c| c.uav.clone()).collect();
    warn_of_flat_earth(&farthest, scene.field.grid(), radius, &mut scene.warnings);

    let asked = Asked { receivers: args.receivers, rx_height, radius, method: args.engine.method };
    let options = options(asked, goal, &scene, zones.as_ref(), &inputs);
    let n_uavs = candidates.kept.len();
    let n_cells = scene.field.grid().n_cells();
    let sets = if args.count > 1 { n_uavs.saturating_mul(n_cells.div_ceil(8)) } else { 0 };
    let (held, of_place) = match &inputs.weights {
        Some(_) => (Weights::BYTES_PER_CELL, UavGrid::BYTES_PER_WEIGHED_PLACE_AND_THREAD),
        None => (0, UavGrid::BYTES_PER_PLACE_AND_THREAD),
    };
    let of_candidate = CANDIDATE_BYTES + of_place * rayon::current_num_threads();
    let per_cell = held + (sets + n_uavs.saturating_mul(of_candidate)).div_ceil(n_cells);
    check_memory(&args.scene.scene, scene.field.grid(), per_cell)?;
    let mapper = Mapper::new(&scene.field, &options)?;
    if !args.out.quiet {
        let grid = scene.field.grid();
        let disc = radius.map_or(f64::INFINITY, |r| std::f64::consts::PI * r * r);
        let n_in_range = (disc / (grid.cell_width() * grid.cell_height())).min(n_cells as f64);
        let method = (mapper.method().0, rayon::current_num_threads());
        let expected = Expected::of(method, (n_cells, n_in_range), (n_uavs, 0), per_cell).words();
        expected.iter().for_each(|words| messages::note(words));
    }
    let before_los = Instant::now();
    let search = Search {
        args,
        goal,
        field: &scene.field,
        rules: &rules,
        candidates: &candidates,
        mapper: &mapper,
        weights: inputs.weights.as_ref(),
        places: inputs.places.as_ref(),
        sites: &inputs.sites,
    };
    let found = search.run()?;
    scene.timing.los = before_los.elapsed().as_secs_f64();
    let report = PlaceReport {
        facts: scene.facts(command, Some(mapper.method().0)),
        rx_height_m: args.rx_height,
        receivers: match goal.whom {
            Whom::Zone(zone) => zone.name(),
            _ => args.receivers.name(),
        },
        radius_m,
        goal: args.goal.clone(),
        step_m: inputs.places.as_ref().map(|_| args.step),
        heights: inputs.heights.iter().map(ToString::to_string).collect(),
        clearance_m: args.clearance,
        skipped: candidates.skipped,
        digest: crate::report::place_digest(&found.ranked),
        ranked: found.ranked,
        n_candidates: n_uavs as u64,
        top: usize::from(args.top),
        winner: found.winner,
        refined: found.refined,
        several: found.several,
    };
    let timing = Timing { total: start.elapsed().as_secs_f64(), ..scene.timing };
    let job = outputs::Writer {
        args,
        goal,
        scene: &scene,
        mapper: &mapper,
        report: &report,
        places: inputs.places.as_ref(),
        heat: &found.heat,
        winners: &found.winners,
        timing,
    };
    let files = job.write(&outputs, map.as_ref())?;
    say((args, goal), &report, (start, &scene.timing), (&outputs, &files))
}

/// Refuses what makes no sense together, before any work.
fn check(args: &PlaceArgs, heights: Option<&[Height]>) -> Result<()> {
    if args.step <= 0.0 {
        return Err(Error::usage(113, format!("`--step` is `{}`, wanted above 0 m", args.step)));
    }
    if args.minimize.is_some() && !heights.is_some_and(goal::have_one_reference) {
        let text = "`--minimize height` compares the heights of `--height`: wanted all above the same";
        return Err(Error::usage(113, text).with_hint("--height 20:200:10"));
    }
    Ok(())
}

/// A file to write, checked.
type Output = (PathBuf, Format);

/// The files to write, checked: those of `-o` and `--csv`, and the map of the winner.
fn outputs_of(args: &PlaceArgs, allowed: &[Format]) -> Result<(Vec<Output>, Option<Output>)> {
    let files = [&args.candidates, &args.within, &args.keep_out, &args.area, &args.weights];
    let inputs: Vec<PathBuf> =
        input_paths(&args.scene).into_iter().chain(files.into_iter().flatten().cloned()).collect();
    let rules = OutputRules { allowed, inputs: &inputs, overwrite: args.out.overwrite, bare: false };
    let outputs = outputs_with_table(&args.output, args.csv.as_ref(), rules)?;
    let is_spatial = |format: &Format| format.is_picture() || *format == Format::GeoTiff;
    if let Some((path, _)) = outputs.iter().find(|(_, f)| args.candidates.is_some() && is_spatial(f)) {
        let text = format!("cannot write {}: only candidates on a grid make a picture or a raster", path.display());
        return Err(Error::usage(109, text).with_hint("-o places.geojson"));
    }
    let mut map = None;
    if let Some(path) = &args.map {
        if !Format::of(path).is_ok_and(|format| is_spatial(&format)) {
            let text = format!("cannot write {}: `--map` writes a map", path.display());
            return Err(Error::usage(105, text).with_hint("wanted .png, .svg, .pdf or .tif"));
        }
        let others: Vec<PathBuf> = outputs.iter().map(|(path, _)| path.clone()).collect();
        let all: Vec<PathBuf> = others.iter().cloned().chain([path.clone()]).collect();
        map = check_outputs(&all, OutputRules { allowed: &FORMATS, ..rules })?.pop();
    }
    let all: Vec<Output> = outputs.iter().cloned().chain(map.clone()).collect();
    args.words.refuse_without_picture(&all)?;
    Ok((outputs, map))
}

/// The options of the maps: the receivers of the goal.
fn options(asked: Asked, goal: Goal, scene: &Scene, zones: Option<&ZoneMap>, inputs: &Inputs) -> MapOptions {
    let options = asked.options(scene.field.grid(), zones);
    match goal.whom {
        Whom::Zone(Zone::Rooftop) => MapOptions { receivers: Receivers::Roof, within: None, ..options },
        Whom::Zone(zone) => {
            MapOptions { receivers: Receivers::Ground, within: zones.map(|z| z.cells(zone)), ..options }
        }
        Whom::Receivers | Whom::Area | Whom::Weights => {
            let of_area = inputs.area.as_ref().map(|area| area.cells(scene.field.grid()));
            let within = match (options.within.clone(), of_area) {
                (Some(a), Some(b)) => Some(a.and(&b)),
                (a, b) => a.or(b),
            };
            MapOptions { within, ..options }
        }
    }
}

/// Says what was found.
fn say(
    (args, goal): (&PlaceArgs, Goal),
    report: &PlaceReport,
    (start, spent): (Instant, &Timing),
    (outputs, files): (&[Output], &[PathBuf]),
) -> Result<()> {
    let timing = Timing { total: start.elapsed().as_secs_f64(), ..*spent };
    if !args.out.quiet {
        messages::warnings(&report.facts.warnings);
        outputs::in_words(report, goal).iter().for_each(|line| messages::note(line));
        messages::note(&format!(
            "method {}: search {:.3} s of {:.2} s",
            report.facts.method_in_words(),
            timing.los,
            timing.total
        ));
    }
    messages::wrote(files, args.out.quiet);
    if args.out.json || outputs.iter().any(|(_, f)| *f == Format::Stdout) {
        return messages::answer(&pretty(&report.document(Some(timing))));
    }
    if !files.is_empty() {
        return Ok(());
    }
    // Of thousands of candidates the best are an answer.
    let mut table = report.table();
    let (is_candidate, mut n_candidates) = (|row: &[String]| row[0] == "candidate", 0);
    table.retain(|row| {
        n_candidates += usize::from(is_candidate(row));
        !is_candidate(row) || n_candidates <= report.top
    });
    messages::answer(&String::from_utf8_lossy(&args.out.table(&table)?))
}

/// `--sample`: statistics by zone instead of a search.
fn sampled(args: &PlaceArgs, command: Vec<String>) -> Result<()> {
    let of_a_search = [
        "step",
        "over",
        "within",
        "keep_out",
        "candidates",
        "clearance",
        "goal",
        "area",
        "weights",
        "minimize",
        "count",
        "top",
        "map",
    ];
    if let Some(name) = of_a_search.iter().find(|name| args.scene.typed.iter().any(|typed| typed == *name)) {
        let text = format!("`--{}` has no meaning with `--sample`, which searches nothing", name.replace('_', "-"));
        return Err(Error::usage(116, text));
    }
    let heights = args.height.as_deref().map(goal::heights).transpose()?.unwrap_or_default();
    let above_ground = |height: &Height| match height {
        Height::AboveGround(h) => Ok(*h),
        other => {
            let text = format!("`--height` is `{other}`, wanted heights above ground: places of a sample differ");
            Err(Error::usage(113, text))
        }
    };
    let heights_m: Vec<f64> = heights.iter().map(above_ground).collect::<Result<_>>()?;
    let (outputs, _) = outputs_of(args, &SampleJob::FORMATS)?;
    let job = SampleJob {
        sample: &args.sample,
        scene: &args.scene,
        engine: &args.engine,
        out: &args.out,
        outputs: &outputs,
        heights_m: &heights_m,
        rx_height_m: args.rx_height,
        receivers: args.receivers,
        words: &args.words,
    };
    job.run(command)
}

/// What a candidate takes with all that is said of it.
const CANDIDATE_BYTES: usize = 400;
