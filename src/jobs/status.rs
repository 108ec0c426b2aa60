//! State of the units of work: done, missing or broken.

use std::path::Path;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::Jobs;
use crate::answer::{Answer, CommandFacts, Head, RunFacts, Spent, document_of};
use crate::error::{CheckError, Error, Restart, Result, Warning};
use crate::export::{Batch, Format};
use crate::map::Found;
use crate::picture::Look;
use crate::quantity::counted;

/// State of all units.
#[derive(Debug)]
pub(crate) struct Status {
    facts: RunFacts,
    n_units: usize,
    /// Names of units without files, or without some of them.
    missing: Vec<String>,
    /// Units with files that are not theirs, or not whole: name and reason.
    broken: Vec<(String, String)>,
    /// Kind of run that completes the open units.
    by: Restart,
}

/// Units of work that are done, missing and broken.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct StatusDocument {
    #[serde(flatten)]
    head: Head,
    /// Number of units.
    units: usize,
    /// Number of units whose files exist.
    done: usize,
    /// Names of units without files, or without some of them.
    missing: Vec<String>,
    /// Units with a file that another run made, or that is cut short or damaged.
    broken: Vec<BrokenUnit>,
}

/// Unit with a file that cannot stay.
#[derive(Debug, Serialize, JsonSchema)]
struct BrokenUnit {
    /// Name of the unit.
    name: String,
    /// Reason why the file cannot stay.
    why: String,
}

impl Jobs<'_> {
    /// Returns the state of all units, read from their files.
    pub(crate) fn status(&self, command: CommandFacts) -> Status {
        let of_part = |part| {
            let unit = self.runs.unit(&self.units, part);
            let state = unit.found();
            (part.name(), state)
        };
        let states: Vec<(String, Result<Found>)> = self.units.parts.par_iter().map(of_part).collect();
        let facts = self.facts(command);
        let mut status =
            Status { facts, n_units: states.len(), missing: Vec::new(), broken: Vec::new(), by: Restart::Resumes };
        for (name, state) in states {
            match state {
                Ok(Found::All) => {}
                Ok(Found::Some | Found::Nothing) => status.missing.push(name),
                Ok(Found::Damaged(file)) => {
                    status.broken.push((name, format!("{} is cut short or damaged", file.display())));
                }
                Err(why) => {
                    status.by = match (status.by, why.code().as_str()) {
                        (Restart::Blocked, _) => Restart::Blocked,
                        (_, "E106") => Restart::Replaces,
                        _ => Restart::Blocked,
                    };
                    status.broken.push((name, why.to_string()));
                }
            }
        }
        status
    }
}

impl Status {
    /// Returns the number of units that are not done.
    fn n_open(&self) -> usize {
        self.missing.len() + self.broken.len()
    }

    /// Refuses a run with units that are not done.
    ///
    /// # Errors
    /// E603, which names the first broken unit, or else the first missing one.
    pub(crate) fn check(&self) -> Result<()> {
        let broken = self.broken.first().map(|(name, why)| (name.as_str(), why.as_str()));
        let first = broken.or_else(|| self.missing.first().map(|name| (name.as_str(), "it has no files yet")));
        let Some((name, why)) = first else { return Ok(()) };
        let (n_open, n_units, by) = (self.n_open(), self.n_units, self.by);
        Err(CheckError::OpenUnits { n_open, n_units, name: name.into(), why: why.into(), by }.into())
    }

    fn n_done(&self) -> usize {
        self.n_units - self.n_open()
    }
}

impl Answer for Status {
    fn document(&self, _: Option<Spent>) -> Value {
        let broken = self.broken.iter().map(|(name, why)| BrokenUnit { name: name.clone(), why: why.clone() });
        document_of(&StatusDocument {
            head: self.facts.head("skyshed/jobs-status/1"),
            units: self.n_units,
            done: self.n_done(),
            missing: self.missing.clone(),
            broken: broken.collect(),
        })
    }

    fn warnings(&self) -> &[Warning] {
        &self.facts.warnings
    }

    fn is_in_words(&self) -> bool {
        true
    }

    fn text(&self, _: &Look) -> Result<String> {
        let units = counted(self.n_units as u64, "unit", "units");
        let (done, missing, broken) = (self.n_done(), self.missing.len(), self.broken.len());
        let mut text = format!("{units}: {done} done, {missing} missing, {broken} broken\n");
        self.missing.iter().for_each(|name| text += &format!("missing {name}\n"));
        self.broken.iter().for_each(|(name, why)| text += &format!("broken {name}: {why}\n"));
        Ok(text)
    }

    fn add(&self, _: &mut Batch, _: &Path, _: Format, _: &Look) -> Result<()> {
        Err(Error::fault("a status is a document or words"))
    }
}
