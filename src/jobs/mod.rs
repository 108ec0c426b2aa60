//! Units of work of a map for schedulers: the list of units, their states, and their merged
//! results.
//!
//! Nothing here runs a unit, and nothing is remembered. A unit is done if its files exist, and each
//! file records the unit that it belongs to.

mod forecast;
mod merged;
mod stac;
mod status;

use serde::Serialize;

pub(crate) use merged::{MergeDocument, MergedRow};
pub(crate) use status::StatusDocument;

use std::path::{Path, PathBuf};

use crate::answer::{CommandFacts, Output, RunFacts, document_of};
use skyshed_request::{MapRequest, PROGRAM_OPTIONS, json};

use crate::error::{Error, RequestError, Result};
use crate::export::Format;
use crate::map::{Given, MapJob, Outcome, Part, Purpose, UnitRuns, Units};
use crate::progress::Progress;
use crate::report::Report;
use crate::scene::Scene;
use forecast::forecast;

/// Formats that all units are merged into.
pub(crate) const FORMATS: [Format; 6] =
    [Format::Csv, Format::Parquet, Format::Json, Format::Vrt, Format::GeoJson, Format::Stdout];

/// Map in units of work.
pub(crate) struct Jobs<'a> {
    job: &'a MapJob,
    runs: UnitRuns<'a>,
    units: Units,
}

/// Unit of work before it is run.
#[allow(rustdoc::broken_intra_doc_links, reason = "schemas name units in brackets")]
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct PlannedUnit {
    /// Kind of document and its version.
    pub schema: &'static str,
    /// Name of the unit: the name of its UAV, or `tile ROW,COL`.
    pub name: String,
    /// Hash of all that its files depend on.
    pub unit: String,
    /// Value of `--shard` that runs this unit alone; null if a shard or a tile was requested.
    pub shard: Option<String>,
    /// Files of the unit.
    pub files: Vec<String>,
    /// Estimated time on one thread [s].
    pub seconds: f64,
    /// Estimated memory [bytes].
    pub memory_bytes: u64,
}

impl PlannedUnit {
    /// Schema of its document.
    const SCHEMA: &'static str = "skyshed/jobs-plan/1";
}

impl<'a> Jobs<'a> {
    /// Returns the units of a map.
    ///
    /// # Errors
    /// E116 if it has none; errors of the scene and of the UAVs.
    pub(crate) fn of(job: &'a MapJob, scene: Option<Scene>, progress: &'a Progress) -> Result<Jobs<'a>> {
        let runs = UnitRuns::of(job, scene, (Purpose::Tell, progress))?.ok_or(RequestError::NoUnits)?;
        let units = runs.units()?.ok_or(RequestError::NoUnits)?;
        Ok(Jobs { job, runs, units })
    }

    /// Returns the units as lines of JSON, one after the other.
    ///
    /// Cost: proportional to their number.
    ///
    /// # Errors
    /// E105, as [`Jobs::planned`].
    pub(crate) fn plan(&self) -> Result<impl Iterator<Item = String>> {
        Ok(self.planned()?.map(|(_, planned)| document_of(&planned).to_string()))
    }

    /// Returns the units, each with its UAV or its tile.
    ///
    /// # Errors
    /// E105 for names of files that are not UTF-8: another program could not find them.
    pub(crate) fn planned(&self) -> Result<impl Iterator<Item = (&Part, PlannedUnit)>> {
        if let Some(path) = self.job.outputs.iter().find(|path| path.to_str().is_none()) {
            return Err(RequestError::NotUnicode(path.display().to_string()).into());
        }
        let is_all = self.job.uavs.shard.is_none() && self.job.tiles.only.is_empty();
        let n = self.units.parts.len();
        Ok(self.units.parts.iter().zip(1..).map(move |(part, k): (&Part, usize)| {
            let unit = self.runs.unit(&self.units, part);
            let (seconds, memory_bytes) = forecast(&unit, &self.units);
            let planned = PlannedUnit {
                schema: PlannedUnit::SCHEMA,
                name: part.name(),
                unit: unit.hash,
                shard: is_all.then(|| format!("{k}/{n}")),
                files: unit.job.outputs.iter().map(|path| path.display().to_string()).collect(),
                seconds,
                memory_bytes,
            };
            (part, planned)
        }))
    }

    /// Refuses outputs that are files of units.
    ///
    /// # Errors
    /// E105.
    pub(crate) fn refuse_own_files(&self, outputs: &[Output]) -> Result<()> {
        let named = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
        let wanted: Vec<PathBuf> = outputs.iter().map(|(path, _)| named(path)).collect();
        for part in &self.units.parts {
            let own = self.runs.unit(&self.units, part).job.outputs;
            if let Some(path) = own.iter().find(|path| wanted.contains(&named(path))) {
                return Err(RequestError::FileOfUnit { path: path.display().to_string(), unit: part.name() }.into());
            }
        }
        Ok(())
    }

    /// Returns the facts about the run for documents.
    fn facts(&self, command: CommandFacts) -> RunFacts {
        RunFacts {
            command,
            method: None,
            scene_name: self.job.word.display().to_string(),
            grid: self.units.grid.clone(),
            sources: self.units.uavs.sources.clone(),
            seed: None,
            warnings: self.units.uavs.warnings.clone(),
            unit: None,
        }
    }
}

/// A whole request of a map: scene, UAVs, question and files, as the program runs it. It runs at once
/// or, with `{site}` or `{row}` and `{col}` in the names of its files, in units of work.
///
/// ```
/// use skyshed::prelude::*;
/// use skyshed::{Job, MapRequest};
///
/// let folder = std::env::temp_dir().join("skyshed-job");
/// std::fs::create_dir_all(&folder).expect("a folder");
/// let file = folder.join("{site}.csv");
/// let request = MapRequest::default().scene("itu:urban").size(200.0).uav(["50,50,80", "150,50,80"]);
/// let job = Job::of(request.output([file]).overwrite(true))?;
/// assert_eq!(job.units()?.len(), 2);
/// assert_eq!(job.run()?.mapped, 2);
/// # Ok::<(), skyshed::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Job {
    job: MapJob,
    progress: std::sync::Arc<Progress>,
}

/// Counts of the units of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct JobCounts {
    /// Units whose files were made.
    pub mapped: u64,
    /// Units whose files existed, made by the same run.
    pub existing: u64,
}

impl Job {
    /// Checks a request.
    ///
    /// # Errors
    /// E1xx for values that are wrong by themselves, and for options that change nothing.
    pub fn of(request: MapRequest) -> Result<Job> {
        json::refuse(&json::set_members(&request), &PROGRAM_OPTIONS, "for a caller, who has the answer")?;
        let command = CommandFacts::of(Vec::new(), Some(json::set_members(&request)));
        Ok(Job { job: MapJob::of(request, command)?, progress: std::sync::Arc::default() })
    }

    /// Sets a token that reports the progress, and can stop the work from another thread.
    #[must_use]
    pub fn progress(self, progress: &std::sync::Arc<Progress>) -> Job {
        Job { progress: std::sync::Arc::clone(progress), ..self }
    }

    /// Maps everything, and writes the files. A map without units counts as one.
    ///
    /// # Errors
    /// Errors of the scene, the UAVs, the question and the files; of units the first error, after all
    /// others are done.
    pub fn run(&self) -> Result<JobCounts> {
        let mut counts = JobCounts::default();
        let Some(runs) = UnitRuns::of(&self.job, None, (Purpose::Map, &self.progress))? else {
            self.job.run(Given::default(), &self.progress)?;
            return Ok(JobCounts { mapped: 1, existing: 0 });
        };
        runs.run(&mut |outcome| {
            match outcome {
                Outcome::Done(..) | Outcome::Together(_) => counts.mapped += 1,
                Outcome::There | Outcome::AllThere => counts.existing += 1,
                Outcome::Warnings(_) | Outcome::Abandoned | Outcome::Failed(_) => {}
            }
            Ok::<(), Error>(())
        })?;
        Ok(counts)
    }

    /// Returns the units of work, without running them.
    ///
    /// # Errors
    /// E105 for files whose names are not UTF-8; E116 for a map without units; errors of the scene
    /// and of the UAVs.
    pub fn units(&self) -> Result<Vec<PlannedUnit>> {
        let jobs = Jobs::of(&self.job, None, &self.progress)?;
        Ok(jobs.planned()?.map(|(_, unit)| unit).collect())
    }

    /// Returns the units that are done, missing and broken. The document is `skyshed/jobs-status/1`.
    ///
    /// # Errors
    /// As [`Job::units`].
    pub fn status(&self) -> Result<Report> {
        let jobs = Jobs::of(&self.job, None, &self.progress)?;
        Ok(Report::new(jobs.status(CommandFacts::default()), &[Format::Json, Format::Stdout]))
    }

    /// Returns all units together: a table of the UAVs, or of tiles a mosaic.
    ///
    /// # Errors
    /// As [`Job::units`]; E6xx if a unit is missing or broken.
    pub fn merged(&self) -> Result<Report> {
        let jobs = Jobs::of(&self.job, None, &self.progress)?;
        Ok(Report::new(jobs.merged(CommandFacts::default())?, &FORMATS))
    }
}
