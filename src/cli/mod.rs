//! Command line: typed words become a plan of the library, the plan runs, and its answer is printed
//! or written.
//!
//! * `program` holds the commands.
//! * `args` holds flags that commands share.
//! * `commands` has one file for each command.
//! * `run` does the work that all commands share.
//! * `say` prints to standard error and standard output.
//! * `interrupt` handles Ctrl-C.
//! * `failure` and `refusal` turn errors into texts with codes.
//! * `hints` adds remedies to errors and warnings.
//! * `ask` lets another program run commands.
//! * `allocator` ends the program where memory is refused.

mod allocator;
mod args;
mod ask;
mod commands;
mod failure;
mod found;
mod hints;
mod interrupt;
mod keywords;
mod program;
mod progress_line;
mod refusal;
mod run;
mod say;

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use crate::answer::CommandFacts;
use crate::cli::args::scene::scene_files;
use crate::cli::failure::Result;
use crate::memory;
use crate::threads::in_pool;
pub use allocator::Allocator;
pub use ask::{
    Links, PlannedUnit, Refusal, ask, coverages, height_curves, hint_of, left_out, limit_memory, links, live_page,
    map_tile, normalized, p_los, plan_units, raster_grid, save_options, scene_reader,
};
pub use found::Found;
pub use keywords::Members;
use program::Cli;
use run::{RepairsFile, Run, check_scenes, check_text, check_use};

/// Runs the program on the words of a command line and returns its exit code.
pub fn run(words: impl IntoIterator<Item = OsString>) -> ExitCode {
    ExitCode::from(exit_code(words))
}

/// Runs the program on the words of a command line and returns its exit code as a number.
pub fn exit_code(words: impl IntoIterator<Item = OsString>) -> u8 {
    allocator::set_up();
    memory::on_refusal(interrupt::give_up);
    let words: Vec<OsString> = words.into_iter().collect();
    let done = match Cli::from_words(&words) {
        Ok(cli) => {
            interrupt::listen();
            let command = words.iter().skip(1).map(|w| skyshed_io::told(w).to_string_lossy().into_owned()).collect();
            execute(&cli, command)
        }
        Err(refusal) => refusal::answer(&refusal),
    };
    match done {
        Ok(()) => 0,
        Err(failure) => {
            let failure = interrupt::in_words(failure);
            say::failure(&failure);
            failure.kind().exit_code()
        }
    }
}

fn execute(cli: &Cli, command: Vec<String>) -> Result<()> {
    let shared = cli.shared();
    let is_quiet = cli.is_quiet();
    let progress = Arc::new(interrupt::progress(is_quiet));
    let members = shared.as_ref().map(|shared| shared.members());
    let command = CommandFacts::of(command, members);
    let run = Run { is_quiet, keeps: false, ..Run::asked(command, Instant::now(), &progress) };
    let Some(shared) = shared else { return cli.run(&run) };
    let out = shared.out;
    memory::limit(out.effort.max_memory)?;
    check_scenes(&shared.scenes)?;
    check_use(&shared, cli.draws())?;
    let repairs = RepairsFile::of(&shared)?;
    check_text(out, repairs.as_ref())?;
    let files: Vec<PathBuf> = shared.scenes.iter().flat_map(|scene| scene_files(scene, shared.reading)).collect();
    in_pool(out.effort.threads, || progress_line::with_progress(&run.progress, is_quiet, &files, || cli.run(&run)))??;
    repairs.map_or(Ok(()), |repairs| repairs.write(&run))
}
