//! `skyshed map`: coverage of one or many UAVs.

use std::path::PathBuf;

use serde_json::json;
use skyshed_request::MapRequest;

use crate::answer::{Answer, CommandFacts, Spent};
use crate::cli::args::output::{is_told, plain_look};
use crate::cli::failure::{Failure, Result, refusal_with};
use crate::cli::interrupt;
use crate::cli::run::Run;
use crate::cli::say::{self, WarningsOfRuns};
use crate::error::ErrorKind;
use crate::map::{Done, Given, MapJob, Outcome, Purpose, SITE, UnitRuns, names_tile};
use crate::quantity::counted;
use crate::scene::SceneReader;
use crate::words::pretty;

/// Makes the requested map.
///
/// # Errors
/// Errors of the request, the scene, the UAVs and the files.
pub(in crate::cli) fn run(request: &MapRequest, run: &Run) -> Result<()> {
    let names_units = |path: &PathBuf| path.to_string_lossy().contains(SITE) || names_tile(path);
    let job = job_of(request, run, run.command())?;
    let runs = UnitRuns::of(&job, run.given.clone(), (Purpose::Map, &run.progress))?;
    if request.out.files.json && job.files().any(names_units) {
        let text = "`--json` has no meaning beside files that are named after UAVs or tiles";
        return Err(refusal_with(
            116,
            text,
            "`-o NAME-{site}.json` writes a document for each UAV, `-o NAME-{row}-{col}.json` for each tile",
        ));
    }
    match &runs {
        Some(runs) => run_sites(&job, run, runs),
        None => tell(&job, run, &job.run(Given { scene: run.given_scene(), ..Given::default() }, &run.progress)?),
    }
}

/// Returns a request as a job of this program, which lists repairs if that was requested.
///
/// # Errors
/// Errors of the request.
pub(super) fn job_of(request: &MapRequest, run: &Run, command: CommandFacts) -> Result<MapJob> {
    let job = MapJob::of(request.clone(), command)?;
    let repairs = run.list_for(&request.reading);
    Ok(MapJob { scene: SceneReader { repairs, ..job.scene }, ..job })
}

/// Returns `true` for one tile whose files are not named after it: a map like any other.
fn is_one_tile(job: &MapJob) -> bool {
    job.tiles.only.len() == 1 && !job.outputs.iter().any(|path| names_tile(path))
}

/// Prints or keeps the answer and the names of its files.
fn tell(job: &MapJob, run: &Run, done: &Done) -> Result<()> {
    if run.keeps {
        run.keep(done, Spent::default(), done.written.clone());
        return Ok(());
    }
    run.tell(done, Spent::default());
    say::wrote(&done.written, run.is_quiet);
    if is_told(&job.request.out) {
        return say::answer(&pretty(&done.document(None)));
    }
    if job.files().next().is_none() {
        return say::answer(&done.text(&plain_look(&job.request.out))?);
    }
    Ok(())
}

/// Runs each UAV or tile; warnings that several have in common are printed once, at the end.
fn run_sites(job: &MapJob, run: &Run, runs: &UnitRuns<'_>) -> Result<()> {
    let mut sites = Sites {
        job,
        run,
        warnings: Vec::new(),
        said: WarningsOfRuns::default(),
        n: [0; 3],
        is_by_unit: true,
        is_of_tiles: !job.tiles.only.is_empty() || job.outputs.iter().any(|path| names_tile(path)),
    };
    let outcome = runs.run(&mut |outcome| sites.add(outcome));
    let is_interrupted = outcome.as_ref().is_err_and(|e| e.kind() == ErrorKind::Interrupted);
    sites.tell(outcome.is_err(), is_interrupted);
    outcome
}

/// Results of the runs so far, by UAV or tile.
struct Sites<'a> {
    job: &'a MapJob,
    run: &'a Run,
    /// Warnings about all UAVs.
    warnings: Vec<crate::error::Warning>,
    /// Warnings about single UAVs or tiles.
    said: WarningsOfRuns,
    /// Numbers of units: mapped, existing already, failed.
    n: [u64; 3],
    is_by_unit: bool,
    is_of_tiles: bool,
}

impl Sites<'_> {
    fn add(&mut self, outcome: Outcome<'_>) -> Result<()> {
        match outcome {
            Outcome::Warnings(found) => self.warnings = found.to_vec(),
            Outcome::Done(part, done) => {
                if is_one_tile(self.job) {
                    self.is_by_unit = false;
                    return tell(self.job, self.run, done);
                }
                self.n[0] += 1;
                self.said.add(&part.name(), done.warnings());
                if !self.run.is_quiet {
                    done.notes(Spent::default()).iter().for_each(|note| say::note(note));
                }
                say::wrote(&done.written, self.run.is_quiet);
                interrupt::end_writing()?;
            }
            Outcome::There => self.n[1] += 1,
            Outcome::Abandoned => {
                self.n[2] += 1;
                interrupt::give_up_writing()?;
            }
            Outcome::Failed(_) if self.run.keeps => {}
            Outcome::Failed(error) => say::failure(&Failure::Library(error.clone())),
            Outcome::Together(done) => {
                self.is_by_unit = false;
                tell(self.job, self.run, done)?;
            }
            Outcome::AllThere => {
                self.is_by_unit = false;
                if !self.run.is_quiet {
                    say::note("nothing to do: the files are there, made by the same run");
                }
            }
        }
        Ok(())
    }

    fn tell(&self, is_failed: bool, is_interrupted: bool) {
        let [mapped, there, not_mapped] = self.n;
        if self.run.keeps {
            self.run.keep_counts(json!({"mapped": mapped, "there": there, "not_mapped": not_mapped}), &self.warnings);
            return;
        }
        let nothing_began = self.n == [0; 3];
        if self.run.is_quiet || !self.is_by_unit || (is_failed && nothing_began) {
            return;
        }
        if !is_interrupted {
            let [n_done, n_there, n_not] = self.n;
            let (one, many) = if self.is_of_tiles { ("tile", "tiles") } else { ("UAV", "UAVs") };
            let skipped = if n_there > 0 { format!(", {n_there} there already") } else { String::new() };
            let others = if n_not > 0 { format!(", {n_not} not") } else { String::new() };
            say::note(&format!("{} mapped{skipped}{others}", counted(n_done, one, many)));
        }
        say::warnings(&self.warnings);
        self.said.say(if self.is_of_tiles { "tiles" } else { "UAVs" });
    }
}
