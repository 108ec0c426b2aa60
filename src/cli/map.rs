//! `skyshed map`: coverage of one or many UAVs.

use super::args::MapArgs;
use super::interrupt;
use super::messages::{self, WarningsOfRuns};
use super::plan::{self, input_paths, scene_options};
use crate::error::{Error, Result};
use crate::export::{Layer, MaskValues};
use crate::map::{CurvePlan, Done, Given, MapJob, MapPlan, Outcome, SaveOptions, SiteRuns, file_table};
use crate::quantity::counted;
use crate::scene::is_raster_scene;
use crate::uav::UavsAsked;
use crate::words::pretty;

pub(super) fn run(args: &MapArgs, command: Vec<String>) -> Result<()> {
    if args.strips && (!is_raster_scene(args.scene.scene.as_ref()) || args.scene.project.is_some()) {
        return Err(Error::usage(116, "`--strips` has no meaning but for a raster in its own system"));
    }
    let names_sites = |path: &std::path::PathBuf| path.to_string_lossy().contains(crate::map::SITE);
    let job = job(args, command)?;
    let progress = interrupt::progress(args.out.quiet);
    let runs = SiteRuns::of(&job, &progress)?;
    if args.out.json && job.outputs.iter().chain(&job.curve.outputs).any(names_sites) {
        let text = "`--json` has no meaning beside files with `{site}` in their names";
        return Err(Error::usage(116, text).with_hint("`-o NAME-{site}.json` writes a document for each UAV"));
    }
    messages::with_progress(&progress, "receivers", args.out.quiet, || match &runs {
        Some(runs) => by_site(args, runs),
        None => tell(args, &job.run(Given::default(), &progress)?),
    })
}

/// What was typed, as a job.
fn job(args: &MapArgs, command: Vec<String>) -> Result<MapJob> {
    let mut layers: Vec<Layer> = Vec::new();
    args.layers.iter().for_each(|layer| {
        if !layers.contains(layer) {
            layers.push(*layer)
        }
    });
    Ok(MapJob {
        word: args.scene.scene.as_ref().to_os_string(),
        scene: scene_options(&args.scene)?,
        inputs: input_paths(&args.scene),
        uavs: uavs_of(args)?,
        plan: MapPlan {
            receivers: args.receivers,
            rx_height_m: args.rx_height,
            radius_m: args.engine.radius,
            method: args.engine.method,
            layers,
            tolerance: args.tolerance,
            tells_zones: false,
        },
        save: SaveOptions {
            overwrite: args.out.overwrite,
            bare: args.bare,
            tif_layout: args.tif_layout,
            mask_values: if args.gdal_values { MaskValues::Gdal } else { MaskValues::Classes },
            polygons: args.polygons,
            simplify_m: args.simplify,
            csv_text: args.out.csv_text,
            words: args.words.clone(),
        },
        outputs: args.output.clone(),
        curve: CurvePlan { outputs: args.height_curve.clone(), heights: args.curve_heights },
        is_told: args.out.json || (args.output.is_empty() && args.height_curve.is_empty()),
        strips: args.strips,
        scratch: args.scratch.clone(),
        resume: args.resume,
        command,
    })
}

/// Where the UAVs are told; those of the command line are well-formed.
fn uavs_of(args: &MapArgs) -> Result<UavsAsked> {
    if args.uav.is_empty() && args.uavs.is_none() {
        return Err(Error::usage(108, "no UAV: wanted `--uav X,Y,H` or `--uavs FILE`"));
    }
    plan::uavs_asked(&args.uav, args.uavs.as_ref(), (args.skip_bad, args.scene.hash))
}

/// Tells what was found and written.
fn tell(args: &MapArgs, done: &Done) -> Result<()> {
    if !args.out.quiet {
        messages::warnings(&done.warnings());
        say(done);
    }
    messages::wrote(&done.written, args.out.quiet);
    let wants_document = args.out.json || args.output.iter().any(|path| path.as_os_str() == "-");
    if wants_document {
        return messages::answer(&pretty(&done.report.document(Some(done.timing))));
    }
    if args.output.is_empty() && args.height_curve.is_empty() {
        return messages::answer(&String::from_utf8_lossy(&file_table(&done.report, args.out.csv_text)?));
    }
    Ok(())
}

fn say(done: &Done) {
    let notes = done.in_words();
    notes.iter().for_each(|note| messages::note(note));
    let curves = done.curves.iter().flat_map(|curves| curves.in_words());
    curves.for_each(|note| messages::note(&note));
}

/// A run for each UAV; what several have in common is told once, at the end.
fn by_site(args: &MapArgs, runs: &SiteRuns<'_>) -> Result<()> {
    let quiet = args.out.quiet;
    let (mut warnings, mut said) = (Vec::new(), WarningsOfRuns::default());
    let (mut n_done, mut n_there, mut n_not) = (0_u64, 0_u64, 0_u64);
    let mut is_by_site = true;
    let outcome = runs.run(&mut |outcome| {
        match outcome {
            Outcome::Warnings(found) => warnings = found.to_vec(),
            Outcome::Done(uav, done) => {
                n_done += 1;
                said.add(uav, &done.warnings());
                if !quiet {
                    say(done);
                }
                messages::wrote(&done.written, quiet);
                interrupt::end_writing()?;
            }
            Outcome::There => n_there += 1,
            Outcome::Abandoned => {
                n_not += 1;
                interrupt::give_up_writing()?;
            }
            Outcome::Failed(error) => messages::error(error),
            Outcome::Together(done) => {
                is_by_site = false;
                tell(args, done)?;
            }
            Outcome::AllThere => {
                is_by_site = false;
                if !quiet {
                    messages::note("nothing to do: the files are there, made by the same run");
                }
            }
        }
        Ok(())
    });
    let is_interrupted = outcome.as_ref().is_err_and(|e| e.class() == crate::error::ErrorClass::Interrupted);
    if !quiet && is_by_site {
        if !is_interrupted {
            let skipped = if n_there > 0 { format!(", {n_there} there already") } else { String::new() };
            let others = if n_not > 0 { format!(", {n_not} not") } else { String::new() };
            messages::note(&format!("{} mapped{skipped}{others}", counted(n_done, "UAV", "UAVs")));
        }
        messages::warnings(&warnings);
        said.say();
    }
    outcome
}
