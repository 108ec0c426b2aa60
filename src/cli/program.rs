//! The program and its commands, as they are typed.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};

use skyshed_request::words::with_defaults;
use skyshed_request::{
    CityRequest, CompareRequest, InfoRequest, LimitsRequest, LinkRequest, LiveRequest, MapRequest, OutputOptions,
    PlaceRequest, Reading, SampleRequest, TrackRequest, ZonesRequest,
};

use super::commands::{
    ChartArgs, CompletionsArgs, JobsArgs, PlosArgs, StressArgs, city, compare, info, limits, link, live, map, place,
    sample, track, zones,
};
use super::run::Run;
use super::typed::{Typed, paths_of};
use crate::cli::args::words::is_standard_input;
use crate::cli::failure::Result;

/// Exact line-of-sight coverage maps: what a hovering UAV can see of a city.
#[derive(Debug, Parser)]
#[command(name = "skyshed", version, propagate_version = true, max_term_width = 110)]
#[command(after_help = "\
SCENE is a generated city (itu:urban, itu:0.3,500,15), a raster (.tif, .asc, .vrt, or a folder of
tiles), footprints (.geojson, .shp, .fgb, .gpkg, .city.json) or a mesh (.obj, .ply).
Heights are above ground unless written 150amsl or 30roof; lengths are in meters, heights also in
feet: 400ft, 400ft amsl. Without `-o` the answer goes to standard output.

Examples:
  skyshed map itu:urban --uav 500,500,100 -o coverage.png
  skyshed map dsm.tif --terrain dtm.tif --uav 691549.7,5334762.2,60 -o coverage.tif
  skyshed info buildings.geojson
  skyshed place itu:urban --height 60,100 --step 50 -o hover.png

Exit codes: 0 done, 1 internal fault, 2 usage, 3 bad input or output file, 4 bad site or zone,
5 over a limit, 6 a check failed, 130 interrupted.")]
pub(super) struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Coverage of one or many UAVs over every cell of a scene
    Map(Box<MapRequest>),
    /// One link: line of sight, or the obstacle in its way
    Link(Box<LinkRequest>),
    /// Line of sight along a user's track, and how long the stretches without are
    Track(Box<TrackRequest>),
    /// Make or convert a city, and draw it
    City(Box<CityRequest>),
    /// What a file is: size, CRS, heights and faults of a scene; what UAVs or an output hold
    Info(Box<InfoRequest>),
    /// Streets, crossroads, courtyards and rooftops: counts, a map, polygons
    Zones(Box<ZonesRequest>),
    /// What limits the P_LoS of a map: cells, terrain, positions, heights
    Limits(Box<LimitsRequest>),
    /// Probability of line of sight: exact products, simulators, models, real cities
    Plos(Box<PlosArgs>),
    /// Where to hover: candidates ranked, refined, or chosen together
    Place(Box<PlaceRequest>),
    /// P_LoS averaged over placements of each zone, with intervals
    Sample(Box<SampleRequest>),
    /// Placements side by side: maps, differences, a page to swipe over
    Compare(Box<CompareRequest>),
    /// One page in which a UAV is dragged over the city, and the exact coverage follows
    Live(Box<LiveRequest>),
    /// Speed against accuracy of every method on a scene
    Chart(Box<ChartArgs>),
    /// Where methods fail, on small scenes full of ties; what in a scene hangs by a step
    Stress(Box<StressArgs>),
    /// A map in units of work for schedulers: which there are, which are done, what all come to
    Jobs(Box<JobsArgs>),
    /// Words for a shell that completes what is typed, or a man page
    Completions(CompletionsArgs),
}

/// How many tables are to be read from standard input.
fn standard_inputs(matches: &ArgMatches) -> usize {
    let tables = ["uavs", "candidates", "track"].into_iter();
    let tables = tables.flat_map(|id| paths_of(matches, id)).map(PathBuf::into_os_string);
    let curves = matches.try_get_many::<OsString>("curve").ok().flatten().into_iter().flatten().cloned();
    tables.chain(curves).filter(is_standard_input).count()
}

/// Returns `true` if any command has a flag of this name.
pub(super) fn is_flag(name: &str) -> bool {
    Cli::command().get_subcommands().any(|command| command.get_arguments().any(|flag| flag.get_id() == name))
}

impl Cli {
    /// Returns the program with its commands, flags and defaults.
    pub(super) fn program() -> clap::Command {
        Cli::command().mut_subcommands(|command| {
            let defaults = skyshed_request::defaults_of(command.get_name());
            with_defaults(command, &defaults)
        })
    }

    /// Parses the words of a command line, the program's name first. Addresses lose their secrets.
    pub(super) fn from_words(words: &[OsString]) -> std::result::Result<(Cli, Typed), clap::Error> {
        // PERF: defaults are needed in help texts alone.
        let asks_help = words.iter().any(|word| word == "-h" || word == "--help" || word == "help");
        let mut command = if asks_help { Cli::program() } else { Cli::command() };
        let matches = command.try_get_matches_from_mut(words.iter().map(|word| skyshed_io::told(word)))?;
        let typed = matches.subcommand().map_or_else(Typed::default, |(_, matches)| Typed::of(matches));
        if matches.subcommand().is_some_and(|(_, matches)| standard_inputs(matches) > 1) {
            let text = "`-` is given for two tables, wanted one: standard input can be read once";
            return Err(command.error(clap::error::ErrorKind::ArgumentConflict, text));
        }
        Ok((Cli::from_arg_matches(&matches).map_err(|e| e.format(&mut command))?, typed))
    }

    /// What is asked of a map, if a map is asked for.
    pub(super) fn map(&self) -> Option<&MapRequest> {
        if let Command::Map(args) = &self.command { Some(args) } else { None }
    }

    /// The scenes, how they are read, and where results go; nothing of a command that has none.
    pub(super) fn shared(&self) -> Option<(Vec<&OsStr>, &Reading, &OutputOptions)> {
        Some(match &self.command {
            Command::Map(a) => (vec![a.scene.word()], &a.reading, &a.out),
            Command::Link(a) => (vec![a.scene.word()], &a.reading, &a.out),
            Command::Track(a) => (vec![a.scene.word()], &a.reading, &a.out),
            Command::City(a) => (vec![a.scene.word()], &a.reading, &a.out),
            Command::Info(a) => (vec![a.scene.word()], &a.reading, &a.out),
            Command::Zones(a) => (vec![a.scene.word()], &a.reading, &a.out),
            Command::Limits(a) => (vec![a.scene.word()], &a.reading, &a.out),
            Command::Plos(a) => (a.scenes.iter().map(OsString::as_os_str).collect(), &a.reading, &a.out),
            Command::Place(a) => (vec![a.scene.word()], &a.reading, &a.out),
            Command::Sample(a) => (vec![a.scene.word()], &a.reading, &a.out),
            Command::Compare(a) => (vec![a.scene.word()], &a.reading, &a.out),
            Command::Live(a) => (vec![a.scene.word()], &a.reading, &a.out),
            Command::Chart(a) => (vec![a.scene.scene.as_os_str()], &a.scene.reading, &a.out),
            Command::Stress(a) => (a.scene.iter().map(OsString::as_os_str).collect(), &a.reading, &a.out),
            // What is read and asked is told by the words of the map.
            Command::Jobs(_) | Command::Completions(_) => return None,
        })
    }

    /// Whether nothing is said but errors.
    pub(super) fn is_quiet(&self) -> bool {
        let jobs = matches!(&self.command, Command::Jobs(args) if args.out.effort.quiet);
        jobs || self.shared().is_some_and(|(.., out)| out.effort.quiet)
    }

    /// Whether something other than a city is drawn at random: links, blocks, scenes.
    pub(super) fn draws(&self) -> bool {
        matches!(
            self.command,
            Command::Plos(_) | Command::Sample(_) | Command::Compare(_) | Command::Chart(_) | Command::Stress(_)
        )
    }

    /// Does what was asked for.
    pub(super) fn run(&self, run: &Run) -> Result<()> {
        if !matches!(self.command, Command::Map(_) | Command::Place(_) | Command::Compare(_)) {
            run.typed.refuse(&["height_error_field"], "but for `map`, `place` and `compare`")?;
        }
        match &self.command {
            Command::Map(request) => map::run(request, run),
            Command::Link(request) => link::run(request, run),
            Command::Track(request) => track::run(request, run),
            Command::City(request) => city::run(request, run),
            Command::Info(request) => info::run(request, run),
            Command::Zones(request) => zones::run(request, run),
            Command::Limits(request) => limits::run(request, run),
            Command::Plos(args) => args.run(run),
            Command::Place(request) => place::run(request, run),
            Command::Sample(request) => sample::run(request, run),
            Command::Compare(request) => compare::run(request, run),
            Command::Live(request) => live::run(request, run),
            Command::Chart(args) => args.run(run),
            Command::Stress(args) => args.run(run),
            Command::Jobs(args) => args.run(run),
            Command::Completions(args) => args.run(Cli::program()),
        }
    }
}
