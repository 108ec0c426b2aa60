//! The command line: what was typed becomes a plan, the plan runs, results go out.
//!
//! `args` holds what can be typed, `plan` what it means, one module per command what it does, `messages` what is
//! said on standard error, `interrupt` what Ctrl-C does.

mod args;
mod chart;
mod city;
mod compare;
mod hints;
mod info;
mod interrupt;
mod link;
mod map;
mod messages;
mod method_looks;
mod place;
mod plan;
mod plos;
mod repairs;
mod sample;
mod sample_plot;
mod stress;
mod track;
mod typed;
mod zones;

use std::ffi::OsString;
use std::process::ExitCode;

use crate::error::{Error, MOST_FOUND, Result, shortened};
use crate::memory;

/// Runs the program on the words of a command line and returns its exit code.
pub fn run(words: impl IntoIterator<Item = OsString>) -> ExitCode {
    let words: Vec<OsString> = words.into_iter().collect();
    let cli = match args::Cli::from_words(&words) {
        Ok(cli) => cli,
        Err(refusal) => return refuse(&refusal),
    };
    interrupt::listen();
    let command = words.iter().skip(1).map(|w| w.to_string_lossy().into_owned()).collect();
    match dispatch(cli, command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => fail(&error),
    }
}

fn fail(error: &Error) -> ExitCode {
    messages::error(error);
    ExitCode::from(error.class().exit_code())
}

fn dispatch(cli: args::Cli, command: Vec<String>) -> Result<()> {
    memory::limit(cli.command.max_memory(), interrupt::give_up)?;
    plan::check_scene(&cli.command)?;
    repairs::check(cli.command.scene())?;
    let words = command.clone();
    match &cli.command {
        args::Command::Map(args) => in_pool(args.out.threads, || map::run(args, command)),
        args::Command::Link(args) => in_pool(args.out.threads, || link::run(args, command)),
        args::Command::City(args) => in_pool(args.out.threads, || city::run(args, command)),
        args::Command::Place(args) => in_pool(args.out.threads, || place::run(args, command)),
        args::Command::Plos(args) => in_pool(args.out.threads, || plos::run(args, command)),
        args::Command::Compare(args) => in_pool(args.out.threads, || compare::run(args, command)),
        args::Command::Stress(args) => in_pool(args.out.threads, || stress::run(args, command)),
        args::Command::Chart(args) => in_pool(args.out.threads, || chart::run(args, command)),
        args::Command::Info(args) => in_pool(args.out.threads, || info::run(args, command)),
    }?;
    repairs::write(cli.command.scene(), words)
}

/// Threads for each core beyond which more are of no use.
const MOST_THREADS_PER_CORE: usize = 4;

/// Runs `work` with the given number of threads, or as many as the environment says (`RAYON_NUM_THREADS`), but no more than
/// are of use; one for each core where nothing is said.
///
/// # Errors
/// E503 if the system gives no thread.
fn in_pool(threads: Option<u16>, work: impl FnOnce() -> Result<()> + Send) -> Result<()> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let of_environment = || std::env::var("RAYON_NUM_THREADS").ok()?.parse().ok().filter(|n| *n > 0);
    let wanted = threads.map(usize::from).or_else(of_environment).unwrap_or(cores);
    let n_threads = wanted.min(MOST_THREADS_PER_CORE * cores);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().map_err(|e| {
        let text = format!("cannot start {n_threads} threads: {e}");
        Error::limit(503, text).with_hint("fewer with `-j N`, or allow this user more processes (`ulimit -u`)")
    })?;
    pool.install(work)
}

/// Help and version go to standard output; a usage error is put in the words of all other errors.
fn refuse(refusal: &clap::Error) -> ExitCode {
    use clap::error::{ContextKind, ContextValue, ErrorKind};
    let mut text = refusal.to_string();
    for kind in [ContextKind::InvalidValue, ContextKind::InvalidArg, ContextKind::InvalidSubcommand] {
        if let Some(ContextValue::String(found)) = refusal.get(kind) {
            text = text.replace(found.as_str(), &shortened(found, MOST_FOUND));
        }
    }
    match refusal.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => match messages::answer(&text) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => fail(&error),
        },
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => fail(
            &Error::usage(
                101,
                "no command, wanted one of `map`, `link`, `city`, `info`, `plos`, `compare`, `place`, `chart` and `stress`",
            )
            .with_hint("skyshed --help"),
        ),
        _ => {
            let text = text.strip_prefix("error: ").unwrap_or(&text);
            let (first, rest) = text.split_once("\n\n").unwrap_or((text, ""));
            // Missing arguments are listed on lines of their own; an error is one line.
            let first = first.split('\n').map(str::trim).collect::<Vec<_>>().join(" ");
            let mut error = Error::usage(101, first);
            // Of clap's tips only those that name what was probably meant; its usage line names the command.
            let similar = rest.lines().map(str::trim).find(|l| l.starts_with("tip: a similar"));
            let command = rest.lines().find_map(|l| l.trim().strip_prefix("Usage: "));
            let help = command.map(|usage| {
                let words: Vec<&str> = usage.split(' ').take_while(|w| !w.starts_with(['[', '<', '-'])).collect();
                format!("{} --help", words.join(" "))
            });
            let hints = [similar.map(|tip| tip.replace("tip: ", "")), help];
            let hints: Vec<String> = hints.into_iter().flatten().collect();
            if !hints.is_empty() {
                error = error.with_hint(hints.join("; "));
            }
            fail(&error)
        }
    }
}
