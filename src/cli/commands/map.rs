//! `skyshed map`: coverage of one or many UAVs.

use serde_json::json;

use super::map_args::MapArgs;
use crate::answer::{Answer, Spent};
use crate::cli::failure::{Failure, Result, refusal_with};
use crate::cli::interrupt;
use crate::cli::run::Run;
use crate::cli::say::{self, WarningsOfRuns};
use crate::cli::typed::Typed;
use crate::error::ErrorClass;
use crate::export::{Format, Layer, MaskValues};
use crate::map::{
    CurvePlan, Done, Given, MapJob, MapPlan, Outcome, Purpose, ROW_AND_COL, SITE, SaveOptions, TilesAsked, UnitRuns,
};
use crate::picture::Look;
use crate::quantity::counted;
use crate::scene::is_raster_scene;
use crate::uav::UavsAsked;
use crate::words::pretty;

/// What is said of a batch and its files, not of what a UAV sees.
const OF_BATCH: [&str; 23] = [
    "scene",
    "min_radius",
    "sector",
    "elevation",
    "beam",
    "uav",
    "uavs",
    "skip_bad",
    "shard",
    "tile",
    "output",
    "height_curve",
    "json",
    "overwrite",
    "csv_text",
    "threads",
    "max_memory",
    "quiet",
    "repairs",
    "resume",
    "strips",
    "scratch",
    "hash",
];

/// Whether the name of a file holds the row or the column of a tile.
fn names_tile(path: &std::path::Path) -> bool {
    ROW_AND_COL.iter().any(|word| path.to_string_lossy().contains(word))
}

impl MapArgs {
    pub(in crate::cli) fn run(&self, run: &Run) -> Result<()> {
        let names_units = |path: &std::path::PathBuf| path.to_string_lossy().contains(SITE) || names_tile(path);
        let job = self.job(&run.typed, run.words())?;
        if !is_raster_scene(&job.word) || job.scene.project.is_some() {
            run.typed.refuse(&["strips", "scratch"], "but for a raster in its own system")?;
        }
        if !job.plan.layers.contains(&Layer::Sure) {
            run.typed.refuse(&["sigma"], "without the layer `sure`")?;
        }
        if self.tile.is_empty() && !job.outputs.iter().any(|path| names_tile(path)) {
            run.typed.refuse(&["tile_size"], "without tiles")?;
        }
        let runs = UnitRuns::of(&job, run.given.clone(), (Purpose::Map, &run.progress))?;
        if self.out.json && job.outputs.iter().chain(&job.curve.outputs).any(names_units) {
            let text = "`--json` has no meaning beside files that are named after UAVs or tiles";
            return Err(refusal_with(
                116,
                text,
                "`-o NAME-{site}.json` writes a document for each UAV, `-o NAME-{row}-{col}.json` for each tile",
            ));
        }
        match &runs {
            Some(runs) => self.run_sites(run, runs),
            None => self.tell(run, &job.run(Given { scene: run.given_scene(), ..Given::default() }, &run.progress)?),
        }
    }

    /// What was typed, as a job.
    pub(super) fn job(&self, typed: &Typed, command: Vec<String>) -> Result<MapJob> {
        Ok(MapJob {
            word: self.scene.scene.clone(),
            scene: self.scene.reading.options()?,
            inputs: self.scene.files(),
            uavs: UavsAsked { shard: self.shard, ..self.uavs.some(self.scene.reading.hash, None)? },
            plan: self.plan()?,
            save: self.save_options()?,
            outputs: self.out.output.clone(),
            curve: CurvePlan { outputs: self.height_curve.clone(), heights: self.curve_heights },
            is_told: self.out.json || (self.out.output.is_empty() && self.height_curve.is_empty()),
            strips: self.strips,
            scratch: self.scratch.clone(),
            resume: self.resume,
            tiles: TilesAsked::of_words(self.tile_size, &self.tile),
            command,
            unit_command: ["map".into(), self.scene.scene.display().to_string()]
                .into_iter()
                .chain(typed.flags_but(&OF_BATCH))
                .collect(),
        })
    }

    /// What is asked of each UAV.
    pub(in crate::cli) fn plan(&self) -> Result<MapPlan> {
        let mut layers: Vec<Layer> = Vec::new();
        self.layers.iter().for_each(|layer| {
            if !layers.contains(layer) {
                layers.push(*layer)
            }
        });
        let (sight, heights) = (self.sight.checked()?, self.heights.checked(self.sigma)?);
        Ok(MapPlan { sight, heights, layers, tolerance: self.tolerance, tells_zones: self.zones })
    }

    /// In which form files are written.
    pub(in crate::cli) fn save_options(&self) -> Result<SaveOptions> {
        Ok(SaveOptions {
            overwrite: self.out.overwrite,
            bare: self.bare,
            tif_layout: self.tif_layout,
            mask_values: if self.gdal_values { MaskValues::Gdal } else { MaskValues::Classes },
            polygons: self.polygons,
            simplify_m: self.simplify,
            look: self.look()?,
        })
    }

    /// How files look; those of the curve are pictures, too. Names that are no files are refused later.
    fn look(&self) -> Result<Look> {
        let is_bare = |path: &&std::path::PathBuf| self.bare && Format::of(path).is_ok_and(|f| f == Format::Png);
        let files = self.out.output.iter().filter(|path| !is_bare(path)).chain(&self.height_curve);
        let outputs: Vec<_> = files.filter_map(|path| Some((path.clone(), Format::of(path).ok()?))).collect();
        self.picture.look(&self.out, &outputs)
    }

    /// Whether one tile is asked for, whose files are not named after it: a map like any other.
    fn is_one_tile(&self) -> bool {
        self.tile.len() == 1 && !self.out.output.iter().any(|path| names_tile(path))
    }

    /// Tells what was found and written.
    fn tell(&self, run: &Run, done: &Done) -> Result<()> {
        if run.keeps {
            run.keep(done, Spent::default(), done.written.clone());
            return Ok(());
        }
        run.tell(done, Spent::default());
        say::wrote(&done.written, run.is_quiet);
        if self.out.is_told() {
            return say::answer(&pretty(&done.document(None)));
        }
        if self.out.output.is_empty() && self.height_curve.is_empty() {
            return say::answer(&done.text(&self.out.look())?);
        }
        Ok(())
    }

    /// A run for each UAV; what several have in common is told once, at the end.
    fn run_sites(&self, run: &Run, runs: &UnitRuns<'_>) -> Result<()> {
        let mut sites = Sites {
            args: self,
            run,
            warnings: Vec::new(),
            said: WarningsOfRuns::default(),
            n: [0; 3],
            is_by_unit: true,
            is_of_tiles: !self.tile.is_empty() || self.out.output.iter().any(|path| names_tile(path)),
        };
        let outcome = runs.run(&mut |outcome| sites.add(outcome));
        let is_interrupted = outcome.as_ref().is_err_and(|e| e.class() == ErrorClass::Interrupted);
        sites.tell(outcome.is_err(), is_interrupted);
        outcome
    }
}

/// What became of the runs for each UAV so far.
struct Sites<'a> {
    args: &'a MapArgs,
    run: &'a Run,
    /// What was said of all UAVs.
    warnings: Vec<crate::error::Warning>,
    /// What was said of single ones.
    said: WarningsOfRuns,
    /// UAVs that were mapped, that were there, that were not mapped.
    n: [u64; 3],
    is_by_unit: bool,
    is_of_tiles: bool,
}

impl Sites<'_> {
    fn add(&mut self, outcome: Outcome<'_>) -> Result<()> {
        match outcome {
            Outcome::Warnings(found) => self.warnings = found.to_vec(),
            Outcome::Done(part, done) => {
                if self.args.is_one_tile() {
                    self.is_by_unit = false;
                    return self.args.tell(self.run, done);
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
                self.args.tell(self.run, done)?;
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
