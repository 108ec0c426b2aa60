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

use crate::answer::{Output, RunFacts, document_of};
use crate::error::{RequestError, Result};
use crate::map::{MapJob, Part, Purpose, UnitRuns, Units};
use crate::progress::Progress;
use crate::scene::Scene;
use forecast::forecast;

/// Map in units of work.
pub(crate) struct Jobs<'a> {
    job: &'a MapJob,
    runs: UnitRuns<'a>,
    units: Units,
}

/// Unit of work before it is run.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub(crate) struct PlannedUnit {
    /// Kind of document and its version.
    schema: &'static str,
    /// Name of the unit: the name of its UAV, or `tile ROW,COL`.
    pub(crate) name: String,
    /// Hash of all that its files depend on.
    unit: String,
    /// Value of `--shard` that runs this unit alone; null if a shard or a tile was requested.
    shard: Option<String>,
    /// Files of the unit.
    files: Vec<String>,
    /// Estimated time on one thread [s].
    pub(crate) seconds: f64,
    /// Estimated memory [bytes].
    memory_bytes: u64,
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
    pub(crate) fn plan(&self) -> impl Iterator<Item = String> {
        self.planned().map(|(_, planned)| document_of(&planned).to_string())
    }

    /// Returns the units, each with its UAV or its tile.
    pub(crate) fn planned(&self) -> impl Iterator<Item = (&Part, PlannedUnit)> {
        let is_all = self.job.uavs.shard.is_none() && self.job.tiles.only.is_empty();
        let n = self.units.parts.len();
        self.units.parts.iter().zip(1..).map(move |(part, k): (&Part, usize)| {
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
        })
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
    fn facts(&self, command: Vec<String>) -> RunFacts {
        RunFacts {
            command,
            method: None,
            scene_name: self.job.word.display().to_string(),
            grid: self.units.grid.clone(),
            sources: self.units.uavs.sources.clone(),
            seed: None,
            warnings: self.units.uavs.warnings.clone(),
            request: None,
            unit: None,
        }
    }
}
