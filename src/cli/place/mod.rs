//! `skyshed place`: where to hover.
//!
//! `args` holds what can be typed, `goal` what a goal asks, `inputs` the areas, weights and candidates, `search` what is
//! worth what, `outputs` the files, `picture` the heat map.

mod args;
mod goal;
mod inputs;
mod outputs;
mod picture;
mod search;

use std::path::PathBuf;
use std::time::Instant;

use super::expected::Expected;
use super::plan::{
    FIELD_BYTES_PER_CELL, check_memory, checked_radius, input_paths, meters_per_unit, ready, receiver_height,
    refuse_words_without_picture, warn_of_flat_earth,
};
use super::words::pretty;
use super::{args as common, interrupt, messages};
use crate::coverage::{MapOptions, Mapper, Receivers, Uav};
use crate::error::{Error, Result};
use crate::export::{Batch, Format, OutputRules, check_outputs};
use crate::los::MethodChoice;
use crate::quantity::{height_steps, tidy};
use crate::report::{PlaceReport, Timing};
use crate::zones::Zone;

pub(super) use args::PlaceArgs;
use goal::{Goal, Whom};
use inputs::Inputs;
use search::Search;

/// Formats of `skyshed place`.
const FORMATS: [Format; 7] =
    [Format::Png, Format::Svg, Format::GeoTiff, Format::Csv, Format::Json, Format::GeoJson, Format::Stdout];

pub(super) fn run(args: &PlaceArgs, command: Vec<String>) -> Result<()> {
    let start = Instant::now();
    let goal = Goal::of(args)?;
    let heights = args.height.as_deref().map(goal::heights).transpose()?;
    let rx_height = receiver_height(args.rx_height)?;
    let radius_m = checked_radius(args.engine.radius)?;
    let clearance = height_steps(args.clearance)
        .filter(|c| *c >= 0)
        .ok_or_else(|| Error::usage(113, format!("`--clearance` is `{}`, wanted 0 m to 32768 m", args.clearance)))?;
    if args.step <= 0.0 {
        return Err(Error::usage(113, format!("`--step` is `{}`, wanted above 0 m", args.step)));
    }
    if args.minimize.is_some() && !heights.as_deref().is_some_and(goal::have_one_reference) {
        let text = "`--minimize height` compares the heights of `--height`: wanted all above the same";
        return Err(Error::usage(113, text).with_hint("--height 20:200:10"));
    }
    let files = [&args.candidates, &args.within, &args.keep_out, &args.area, &args.weights];
    let inputs: Vec<PathBuf> =
        input_paths(&args.scene).into_iter().chain(files.into_iter().flatten().cloned()).collect();
    let rules = OutputRules { allowed: &FORMATS, inputs: &inputs, overwrite: args.out.overwrite, bare: false };
    let outputs = check_outputs(&args.output, rules)?;
    refuse_words_without_picture(&args.title, &args.attribution, &outputs)?;
    let is_spatial = |format: &Format| matches!(format, Format::Png | Format::Svg | Format::GeoTiff);
    if let Some((path, _)) = outputs.iter().find(|(_, f)| args.candidates.is_some() && is_spatial(f)) {
        let text = format!("cannot write {}: only candidates on a grid make a picture or a raster", path.display());
        return Err(Error::usage(109, text).with_hint("-o places.geojson"));
    }

    let mut scene = ready(&args.scene, args.engine.max_memory)?;
    let needs_zones = !args.over.is_empty() || matches!(goal.whom, Whom::Zone(zone) if zone != Zone::Rooftop);
    let asks_zones = needs_zones || args.receivers.zone().is_some();
    if scene.field.is_surface_only() && (asks_zones || goal.whom == Whom::Zone(Zone::Rooftop)) {
        let text = "zones of a surface model alone: no building is known, so no zone is";
        return Err(Error::usage(117, text).with_hint("give `--terrain FILE` or `--ground Z`"));
    }
    super::receivers::check_receivers(args.receivers, &scene.field)?;
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

    let (kind, within) = match goal.whom {
        Whom::Zone(Zone::Rooftop) => (Receivers::Roof, None),
        Whom::Zone(zone) => (Receivers::Ground, zones.as_ref().map(|z| z.cells(zone))),
        Whom::Receivers | Whom::Area | Whom::Weights => {
            let kind = match args.receivers {
                common::ReceiversArg::Roof => Receivers::Roof,
                common::ReceiversArg::All => Receivers::All,
                _ => Receivers::Ground,
            };
            let of_zone = args.receivers.zone().and_then(|zone| zones.as_ref().map(|z| z.cells(zone)));
            let of_area = inputs.area.as_ref().map(|area| area.cells(scene.field.grid()));
            (
                kind,
                match (of_zone, of_area) {
                    (Some(a), Some(b)) => Some(a.and(&b)),
                    (a, b) => a.or(b),
                },
            )
        }
    };
    let options = MapOptions {
        rx_height,
        receivers: kind,
        within,
        radius,
        meters_per_unit: meters_per_unit(scene.field.grid()),
        method: match args.engine.method {
            common::Method::Auto => MethodChoice::Auto,
            common::Method::Ray => MethodChoice::Ray,
            common::Method::Sweep => MethodChoice::Sweep,
            common::Method::Shadow => MethodChoice::Shadow,
        },
        ..MapOptions::default()
    };
    let n_uavs = candidates.kept.len();
    let grid = scene.field.grid();
    let n_cells = grid.n_cells();
    let sets = if args.count > 1 { n_uavs.saturating_mul(n_cells.div_ceil(8)) } else { 0 };
    let held = if inputs.weights.is_some() { 4 } else { 0 };
    let per_cell = held + (sets + n_uavs.saturating_mul(CANDIDATE_BYTES)).div_ceil(n_cells);
    check_memory(&args.scene.scene, grid, (FIELD_BYTES_PER_CELL, per_cell), args.engine.max_memory)?;
    let mapper = Mapper::new(&scene.field, &options)?;
    if !args.out.quiet {
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
        step: inputs.places.as_ref().map(|places| places.grid.cell_width()),
    };
    let found = search.run()?;
    scene.timing.los = before_los.elapsed().as_secs_f64();
    let (method, _) = mapper.method();
    let report = PlaceReport {
        facts: scene.facts(command, method.name()),
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

    let before_write = Instant::now();
    scene.timing.total = start.elapsed().as_secs_f64();
    interrupt::begin_writing();
    let mut batch = Batch::new(args.out.overwrite);
    let job = outputs::Writer {
        args,
        goal,
        scene: &scene,
        report: &report,
        places: inputs.places.as_ref(),
        heat: &found.heat,
        timing: scene.timing,
    };
    for (path, format) in &outputs {
        job.add(&mut batch, path, *format)?;
    }
    batch.commit()?;
    let timing =
        Timing { write: before_write.elapsed().as_secs_f64(), total: start.elapsed().as_secs_f64(), ..scene.timing };
    if !args.out.quiet {
        messages::warnings(&report.facts.warnings);
        for line in outputs::in_words(&report) {
            messages::note(&line);
        }
        messages::note(&format!(
            "method {} (exact): search {} s of {} s",
            report.facts.method,
            tidy(timing.los),
            tidy(timing.total)
        ));
    }
    if args.out.json || outputs.iter().any(|(_, f)| *f == Format::Stdout) {
        messages::answer(&pretty(&report.document(Some(timing))))?;
    }
    Ok(())
}

/// What a candidate takes with all that is said of it.
const CANDIDATE_BYTES: usize = 400;
