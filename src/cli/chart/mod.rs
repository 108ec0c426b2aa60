//! `skyshed chart`: speed against accuracy on the user's own scene.
//!
//! `args` holds what can be typed, `scene` the contestants on a scene, `plos` those for P_LoS, `measure` what they cost,
//! `peers` other programs, `show` the pictures, `write` the files.

mod args;
mod measure;
mod peers;
mod plos;
mod scene;
mod show;
mod write;

use std::path::PathBuf;

pub(super) use args::ChartArgs;

use super::in_pool;
use super::interrupt;
use super::messages;
use super::plan::{input_paths, outputs_with_table};
use crate::coverage::Control;
use crate::error::{Error, Result};
use crate::export::{Format, OutputRules};

/// Formats of `skyshed chart`.
const FORMATS: [Format; 6] = [Format::Png, Format::Svg, Format::Pdf, Format::Csv, Format::Json, Format::Stdout];

/// Longest time that a contestant may be asked to take \[s\].
const LONGEST_S: f64 = 60.0;

pub(super) fn run(args: &ChartArgs, command: Vec<String>) -> Result<()> {
    if !(0.0..=LONGEST_S).contains(&args.time) {
        return Err(Error::usage(113, format!("`--time` is `{}`, wanted 0 s to {LONGEST_S} s", args.time)));
    }
    let outputs = outputs(args)?;
    match (args.plos, args.scene.scene.built_up()) {
        (true, Some(built_up)) => plos::run(args, command, built_up?, &outputs),
        (true, None) => {
            let text = format!("`--plos` has no meaning for {}: it charts a generated city", args.scene.scene);
            Err(Error::usage(116, text).with_hint("`skyshed info` tells α, β, γ of a city: chart itu:α,β,γ --plos"))
        }
        (false, _) => scene::run(args, command, &outputs),
    }
}

/// The files to write, checked before any work.
fn outputs(args: &ChartArgs) -> Result<Vec<(PathBuf, Format)>> {
    let inputs: Vec<PathBuf> = input_paths(&args.scene).into_iter().chain(args.uavs.clone()).collect();
    let rules = OutputRules { allowed: &FORMATS, inputs: &inputs, overwrite: args.out.overwrite, bare: false };
    let outputs = outputs_with_table(&args.output, args.csv.as_ref(), rules)?;
    args.words.refuse_without_picture(&outputs)?;
    Ok(outputs)
}

/// Refuses flags that were typed and mean nothing here.
fn refuse_typed(args: &ChartArgs, names: &[&str], why: &str) -> Result<()> {
    match names.iter().find(|name| args.scene.typed.iter().any(|typed| typed == *name)) {
        Some(name) => Err(Error::usage(116, format!("`--{}` has no meaning {why}", name.replace('_', "-")))),
        None => Ok(()),
    }
}

/// Threads of the timed runs: one, unless more are asked for.
fn threads(args: &ChartArgs) -> u16 {
    args.out.threads.unwrap_or(1)
}

/// Runs `work`, which has a turn for each of `n` contestants, on the threads of the timed runs, under a progress bar.
fn in_turns<T: Send>(args: &ChartArgs, n: usize, work: impl FnOnce(&Control) -> T + Send) -> Result<T> {
    let progress = interrupt::progress(args.out.quiet);
    let control = progress.control();
    let mut done = None;
    in_pool(Some(threads(args)), || {
        let turns = || work(control);
        progress.begin(n as u64);
        done = Some(messages::with_progress(&progress, "contestants", args.out.quiet, turns));
        Ok(())
    })?;
    done.ok_or_else(|| Error::internal(903, "cannot run the contestants"))
}
