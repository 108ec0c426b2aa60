//! The perturbation test of a scene: what turns when the UAV or all roofs move by one lattice step, and how many receivers
//! are near to grazing.

use std::path::Path;
use std::time::Instant;

use super::{FORMATS, StressArgs, answer};
use crate::cli::args::OutputArgs;
use crate::cli::plan::{input_paths, ready, uavs_asked};
use crate::cli::{interrupt, messages};
use crate::error::{Error, Result};
use crate::export::{Batch, Format, Layer, OutputRules, check_outputs, with_suffix};
use crate::map::{Held, MapDrawing, MapPlan};
use crate::quantity::counted;
use crate::report::{MapReport, NEAR_M, StressSceneReport, Timing};
use crate::words::{picture_provenance, pretty};

/// Margins are taken of this many receivers at most: each costs a walk.
const MARGIN_SAMPLE: usize = 65_536;

pub(super) fn run(args: &StressArgs, command: Vec<String>) -> Result<()> {
    let start = Instant::now();
    let plan = MapPlan {
        receivers: args.receivers,
        rx_height_m: args.rx_height,
        radius_m: args.engine.radius,
        method: args.engine.method,
        layers: vec![Layer::Stability],
        ..MapPlan::default()
    };
    plan.check()?;
    let inputs = input_paths(&args.scene);
    let rules = OutputRules { allowed: &FORMATS, inputs: &inputs, overwrite: args.out.overwrite, bare: false };
    let outputs = check_outputs(&args.output, rules)?;
    args.words.refuse_without_picture(&outputs)?;
    let Some(uav) = &args.uav else {
        return Err(Error::usage(108, "no UAV: wanted `--uav X,Y,H`"));
    };
    let uavs = uavs_asked(std::slice::from_ref(uav), None, (false, false))?;
    let scene = ready(&args.scene)?;
    let found = uavs.read(scene.grid())?;
    let prepared = plan.prepare(scene, found, None)?;
    let progress = interrupt::progress(args.out.quiet);
    let held = Held { keeps_masks: true, ..Held::default() };
    let before_los = Instant::now();
    let mut map = messages::with_progress(&progress, "receivers", args.out.quiet, || {
        prepared.run(held, &progress, |_| {}, |_| {})
    })?;
    let margins = map.margin_sample(MARGIN_SAMPLE)?;
    map.scene.timing.los = before_los.elapsed().as_secs_f64();
    map.report.facts.command = command;
    let report = StressSceneReport { map: MapReport { idle: None, ..map.report.clone() }, margins };
    let timing = Timing { total: start.elapsed().as_secs_f64(), ..map.scene.timing };

    let before_write = Instant::now();
    interrupt::begin_writing();
    let mut batch = Batch::new(args.out.overwrite).asking(interrupt::check);
    let drawing = MapDrawing { of: &map, words: &args.words, counts: None, note: None };
    for (path, format) in &outputs {
        add((&report, timing), (&drawing, &args.out), &mut batch, (path, *format))?;
    }
    let files = batch.commit()?;
    let write = before_write.elapsed().as_secs_f64();
    let timing = Timing { write, total: start.elapsed().as_secs_f64(), ..timing };
    if !args.out.quiet {
        messages::warnings(&report.map.facts.warnings);
        say(&report, timing);
    }
    messages::wrote(&files, args.out.quiet);
    answer(args, &outputs, || report.document(Some(timing)), || report.table())
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
            Ok(batch.add(&with_suffix(path, ".json"), pretty(&report.document(None)).as_bytes())?)
        }
        // The time of writing is not known before the file is written.
        Format::Json => Ok(batch.add(path, pretty(&report.document(Some(timing))).as_bytes())?),
        Format::Png | Format::Svg | Format::Pdf => Ok(batch.add(path, &drawing.draw(format, &provenance())?)?),
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
