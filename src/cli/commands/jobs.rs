//! `skyshed jobs`: a map in units of work for schedulers: their list, their states, and their
//! merged results.

use std::ffi::OsString;

use clap::{Args, Command, FromArgMatches};

use skyshed_request::{MapRequest, OutputOptions, json};

use super::map::job_of;
use crate::answer::{Answer, CommandFacts};
use crate::cli::args::output::{checked_files, plain_look};
use crate::cli::failure::{Result, refusal, refusal_with};
use crate::cli::run::{Run, check_scenes};
use crate::cli::say;
use crate::error::Error;
use crate::jobs::{FORMATS, Jobs};
use crate::memory;
use crate::threads::in_pool;
use skyshed_request::words::one_of;

skyshed_core::words! {
    /// Question about the units.
    enum Asked {
        /// A line of JSON for each unit: its name, its files, the word for `--shard` that runs it, time and memory
        Plan = "plan",
        /// Units that are done, missing and broken; exit code 6 unless all are done
        Status = "status",
        /// All units together: a table of the UAVs (.csv, .parquet), a document (.json), and of tiles a mosaic (.vrt) and a
        /// STAC item (.geojson)
        Merge = "merge",
    }
}

#[derive(Debug, Args)]
#[command(mut_arg("output", |a| a.help("File to merge into: .csv .parquet .json .vrt .geojson; repeat for more").long_help("File \
to merge into, by extension: a table of the UAVs (.csv, .parquet), a document (.json); of tiles also a mosaic (.vrt) and a STAC item \
(.geojson). Repeat for more; without any the table goes to standard output")))]
#[command(after_help = "\
Example: skyshed jobs plan map maps/munich.geojson --uavs maps/sites.csv --radius 300 -o '{site}.tif'")]
pub(in crate::cli) struct JobsArgs {
    /// Answer about the units
    #[arg(value_name = "WHAT", value_parser = one_of::<Asked>())]
    asked: Asked,
    #[command(flatten)]
    pub(in crate::cli) out: OutputOptions,
    /// `map` and the words behind it, as they are typed to run all units: names of files hold `{site}`, or `{row}` and `{col}`
    #[arg(value_name = "MAP", required = true, trailing_var_arg = true, allow_hyphen_values = true)]
    map: Vec<OsString>,
}

impl JobsArgs {
    pub(in crate::cli) fn run(&self, run: &Run) -> Result<()> {
        memory::limit(self.out.effort.max_memory)?;
        match self.asked {
            Asked::Merge => {}
            Asked::Status => json::refuse(
                &json::set_members(&self.out),
                &["output", "overwrite", "csv_text"],
                "for what is told of units",
            )
            .map_err(Error::from)?,
            Asked::Plan => {
                json::refuse(
                    &json::set_members(&self.out),
                    &["output", "overwrite", "csv_text", "json"],
                    "for a plan, which is lines of JSON",
                )
                .map_err(Error::from)?;
            }
        }
        in_pool(self.out.effort.threads, || self.answer(run))?
    }

    fn answer(&self, run: &Run) -> Result<()> {
        let words: Vec<_> = self.map.iter().map(|word| skyshed_io::told(word)).collect();
        let Some((_, words)) = words.split_first().filter(|(first, _)| &***first == "map") else {
            let found = self.map.first().map_or_else(String::new, |word| word.display().to_string());
            return Err(refusal_with(
                101,
                format!("found `{found}`, wanted `map`"),
                "jobs are those of a map: `skyshed jobs plan map SCENE --uavs FILE -o NAME-{site}.tif`",
            ));
        };
        let flags = MapRequest::augment_args(Command::new("map")).no_binary_name(true);
        let parsed = flags.try_get_matches_from(words).and_then(|matches| MapRequest::from_arg_matches(&matches));
        let map = &parsed.map_err(|e| refusal(101, first_line(&e)))?;
        check_scenes(&[map.scene.word()])?;
        let words = self.map.iter().map(|word| skyshed_io::told(word).to_string_lossy().into_owned()).collect();
        let command = CommandFacts::of(words, Some(json::set_members(map)));
        let job = job_of(map, run, command)?;
        let jobs = Jobs::of(&job, None, &run.progress)?;
        match self.asked {
            Asked::Plan => jobs.plan()?.try_for_each(|line| say::plain_answer(format!("{line}\n").as_bytes())),
            Asked::Status => {
                let status = jobs.status(run.command());
                run.emit(&status, &[], (&self.out, &plain_look(&self.out)))?;
                Ok(status.check()?)
            }
            Asked::Merge => {
                let inputs = [job.inputs.clone(), job.uavs.file().into_iter().collect()].concat();
                let outputs = checked_files(&self.out, None, (&FORMATS, &inputs))?;
                jobs.refuse_own_files(&outputs)?;
                let merged = jobs.merged(run.command())?;
                run.emit(&merged as &dyn Answer, &outputs, (&self.out, &plain_look(&self.out)))
            }
        }
    }
}

/// Returns the parser's fault in one line, without the usage that follows.
fn first_line(error: &clap::Error) -> String {
    let text = error.to_string();
    let line = text.lines().next().unwrap_or_default();
    line.strip_prefix("error: ").unwrap_or(line).to_string()
}
