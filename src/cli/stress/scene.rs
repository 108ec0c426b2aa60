//! The perturbation test of a scene: what turns when the UAV or all roofs move by one lattice step, and how many receivers
//! are near to grazing.

use std::path::Path;
use std::time::Instant;

use super::{FORMATS, StressArgs, answer};
use crate::cli::args::OutputArgs;
use crate::cli::map_drawing::MapDrawing;
use crate::cli::memory::{FIELD_BYTES_PER_CELL, check_memory};
use crate::cli::outside::{place_uav, warn_of_uavs_outside};
use crate::cli::plan::{checked_radius, input_paths, parse_uav, ready, receiver_height, warn_of_flat_earth};
use crate::cli::receivers::{Asked, check_receivers};
use crate::cli::words::{picture_provenance, pretty};
use crate::cli::{interrupt, messages};
use crate::coverage::{Control, HeightLayers, MapOptions, Mapper};
use crate::error::{Error, Result, Warning};
use crate::export::{Batch, Format, Layer, OutputRules, check_outputs, with_suffix};
use crate::quantity::counted;
use crate::report::{MapReport, NEAR_M, SiteFacts, StressSceneReport, Timing, digest};

/// Margins are taken of this many receivers at most: each costs a walk.
const MARGIN_SAMPLE: usize = 65_536;

/// Bytes per cell of a map with its stability, and of two scenes with other roofs.
const BYTES_PER_CELL: usize = 5 + 2 * FIELD_BYTES_PER_CELL;

pub(super) fn run(args: &StressArgs, command: Vec<String>) -> Result<()> {
    let start = Instant::now();
    let rx_height = receiver_height(args.rx_height)?;
    let radius_m = checked_radius(args.engine.radius)?;
    let inputs = input_paths(&args.scene);
    let rules = OutputRules { allowed: &FORMATS, inputs: &inputs, overwrite: args.out.overwrite, bare: false };
    let outputs = check_outputs(&args.output, rules)?;
    args.words.refuse_without_picture(&outputs)?;
    let Some(uav) = &args.uav else {
        return Err(Error::usage(108, "no UAV: wanted `--uav X,Y,H`"));
    };
    let site = parse_uav(uav, "1".into())?;

    let mut scene = ready(&args.scene)?;
    warn_of_uavs_outside(std::slice::from_ref(&site), scene.field.grid(), &mut scene.warnings);
    let radius = radius_m.map(|r| scene.crs_units(r));
    let uav = place_uav(&site, &scene.field, scene.field.grid(), radius)?;
    check_receivers(args.receivers, &scene.field)?;
    let zones = args.receivers.zone().and_then(|_| scene.zones());
    warn_of_flat_earth(std::slice::from_ref(&uav), scene.field.grid(), radius, &mut scene.warnings);
    let asked = Asked { receivers: args.receivers, rx_height, radius, engine: &args.engine };
    let layers = HeightLayers { stability: true, ..HeightLayers::default() };
    let options = MapOptions { layers, ..asked.options(scene.field.grid(), zones.as_ref()) };
    check_memory(&args.scene.scene, scene.field.grid(), BYTES_PER_CELL)?;

    let before_los = Instant::now();
    let mapper = Mapper::new(&scene.field, &options)?;
    let control = Control::default();
    let total = scene.field.grid().n_cells() as u64;
    let coverage =
        messages::with_progress(&control, (total, "receivers"), args.out.quiet, || mapper.map(&uav, &control))?;
    let margins = mapper.margin_sample(&coverage, MARGIN_SAMPLE);
    let method = mapper.method().0;
    drop(mapper);
    scene.timing.los = before_los.elapsed().as_secs_f64();
    if coverage.tally.receivers == 0 {
        let text = format!("the UAV has no receiver: {}; nothing can turn", coverage.tally.reason());
        scene.warnings.push(Warning::new(202, text));
    }
    let map = MapReport {
        tolerance: None,
        idle: None,
        facts: scene.facts(command, Some(method)),
        rx_height_m: args.rx_height,
        receivers: args.receivers.name(),
        radius_m,
        sites: vec![SiteFacts::of(&coverage, zones.as_ref())],
        union: coverage.tally,
        union_zones: None,
        digest: digest(scene.field.grid(), std::iter::once(coverage.mask.as_slice())),
    };
    let report = StressSceneReport { map, margins };
    let timing = Timing { total: start.elapsed().as_secs_f64(), ..scene.timing };

    let before_write = Instant::now();
    interrupt::begin_writing();
    let mut batch = Batch::new(args.out.overwrite);
    let drawing = MapDrawing {
        scene: &scene,
        coverages: std::slice::from_ref(&coverage),
        overlay: None,
        layers: &[Layer::Stability],
        report: &report.map,
        receivers: args.receivers,
        words: &args.words,
        counts: None,
        note: None,
    };
    for (path, format) in &outputs {
        interrupt::check()?;
        add((&report, timing), (&drawing, &args.out), &mut batch, (path, *format))?;
    }
    let files = batch.commit()?;
    scene.timing.write = before_write.elapsed().as_secs_f64();
    scene.timing.total = start.elapsed().as_secs_f64();
    if !args.out.quiet {
        messages::warnings(&report.map.facts.warnings);
        say(&report, scene.timing);
    }
    messages::wrote(&files, args.out.quiet);
    answer(args, &outputs, || report.document(Some(scene.timing)), || report.table())
}

fn add(
    (report, timing): (&StressSceneReport, Timing),
    (drawing, out): (&MapDrawing<'_>, &OutputArgs),
    batch: &mut Batch,
    (path, format): (&Path, Format),
) -> Result<()> {
    let provenance = || picture_provenance(&report.document(None));
    match format {
        Format::Csv => {
            batch.add(path, &out.table(&report.table())?)?;
            batch.add(&with_suffix(path, ".json"), pretty(&report.document(None)).as_bytes())
        }
        // The time of writing is not known before the file is written.
        Format::Json => batch.add(path, pretty(&report.document(Some(timing))).as_bytes()),
        Format::Png | Format::Svg | Format::Pdf => batch.add(path, &drawing.draw(format, &provenance())?),
        _ => Ok(()),
    }
}

/// What turns, and what is near to grazing, in words.
fn say(report: &StressSceneReport, timing: Timing) {
    for site in &report.map.sites {
        let (los, receivers) = (site.tally.los, site.tally.receivers);
        messages::note(&format!("{los} of {} in line of sight", counted(receivers, "receiver", "receivers")));
        for (which, turned) in site.stability.iter().flat_map(|s| &s.moves) {
            let name = which.name().replace('_', " ");
            messages::note(&match turned {
                Ok(turned) => format!("{name} by a lattice step: {} gained, {} lost", turned.gained, turned.lost),
                Err(reason) => format!("{name} by a lattice step: impossible, {reason}"),
            });
        }
        if let Some(stability) = &site.stability {
            messages::note(&format!("{} by any of the eight moves", turn(stability.cells)));
        }
    }
    let sampled = report.margins.margins.len() as u64;
    let every = match report.margins.every {
        1 => String::new(),
        n => format!(", every {n}th receiver"),
    };
    for (reach, n) in NEAR_M.into_iter().zip(report.near()) {
        messages::note(&format!("within {reach} m of grazing: {n} of {sampled}{every}"));
    }
    messages::note(&format!(
        "method {}: nine maps and the margins in {:.3} s of {:.2} s",
        report.map.facts.method_in_words(),
        timing.los,
        timing.total
    ));
}

fn turn(n: u64) -> String {
    if n == 1 { "1 receiver is turned".into() } else { format!("{n} receivers are turned") }
}
