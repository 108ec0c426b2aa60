//! The program and its commands, as they are typed.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};

use super::args::output::OutputArgs;
use super::args::scene::ReadingArgs;
use super::args::words::is_standard_input;
use super::commands::{
    ChartArgs, CityArgs, CompareArgs, CompletionsArgs, InfoArgs, JobsArgs, LimitsArgs, LinkArgs, LiveArgs, MapArgs,
    PlaceArgs, PlosArgs, SampleArgs, StressArgs, TrackArgs, ZonesArgs,
};
use super::run::Run;
use super::typed::Typed;
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
    Map(Box<MapArgs>),
    /// One link: line of sight, or the obstacle in its way
    Link(Box<LinkArgs>),
    /// Line of sight along a user's track, and how long the stretches without are
    Track(Box<TrackArgs>),
    /// Make or convert a city, and draw it
    City(Box<CityArgs>),
    /// What a file is: size, CRS, heights and faults of a scene; what UAVs or an output hold
    Info(Box<InfoArgs>),
    /// Streets, crossroads, courtyards and rooftops: counts, a map, polygons
    Zones(Box<ZonesArgs>),
    /// What limits the P_LoS of a map: cells, terrain, positions, heights
    Limits(Box<LimitsArgs>),
    /// Probability of line of sight: exact products, simulators, models, real cities
    Plos(Box<PlosArgs>),
    /// Where to hover: candidates ranked, refined, or chosen together
    Place(Box<PlaceArgs>),
    /// P_LoS averaged over placements of each zone, with intervals
    Sample(Box<SampleArgs>),
    /// Placements side by side: maps, differences, a page to swipe over
    Compare(Box<CompareArgs>),
    /// One page in which a UAV is dragged over the city, and the exact coverage follows
    Live(Box<LiveArgs>),
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
    let tables = tables.filter_map(|id| matches.try_get_one::<PathBuf>(id).ok().flatten());
    let tables = tables.map(|path| path.clone().into_os_string());
    let curves = matches.try_get_many::<OsString>("curve").ok().flatten().into_iter().flatten().cloned();
    tables.chain(curves).filter(is_standard_input).count()
}

impl Cli {
    /// Parses the words of a command line, the program's name first.
    pub(super) fn from_words(words: &[OsString]) -> std::result::Result<(Cli, Typed), clap::Error> {
        // An address may hold what nobody else must read.
        let words = words.iter().map(|word| skyshed_io::told(word));
        let mut command = Cli::command();
        let matches = command.try_get_matches_from_mut(words)?;
        let typed = matches.subcommand().map_or_else(Typed::default, |(_, matches)| Typed::of(matches));
        if matches.subcommand().is_some_and(|(_, matches)| standard_inputs(matches) > 1) {
            let text = "`-` is given for two tables, wanted one: standard input can be read once";
            return Err(command.error(clap::error::ErrorKind::ArgumentConflict, text));
        }
        Ok((Cli::from_arg_matches(&matches).map_err(|e| e.format(&mut command))?, typed))
    }

    /// What is asked of a map, if a map is asked for.
    pub(super) fn map(&self) -> Option<&MapArgs> {
        if let Command::Map(args) = &self.command { Some(args) } else { None }
    }

    /// The scenes, how they are read, and where results go; nothing of a command that has none.
    pub(super) fn shared(&self) -> Option<(Vec<&OsString>, &ReadingArgs, &OutputArgs)> {
        Some(match &self.command {
            Command::Map(a) => (vec![&a.scene.scene], &a.scene.reading, &a.out),
            Command::Link(a) => (vec![&a.scene.scene], &a.scene.reading, &a.out),
            Command::Track(a) => (vec![&a.scene.scene], &a.scene.reading, &a.out),
            Command::City(a) => (vec![&a.scene.scene], &a.scene.reading, &a.out),
            Command::Info(a) => (vec![&a.scene.scene], &a.scene.reading, &a.out),
            Command::Zones(a) => (vec![&a.scene.scene], &a.scene.reading, &a.out),
            Command::Limits(a) => (vec![&a.scene.scene], &a.scene.reading, &a.out),
            Command::Plos(a) => (a.scenes.iter().collect(), &a.reading, &a.out),
            Command::Place(a) => (vec![&a.scene.scene], &a.scene.reading, &a.out),
            Command::Sample(a) => (vec![&a.scene.scene], &a.scene.reading, &a.out),
            Command::Compare(a) => (vec![&a.scene.scene], &a.scene.reading, &a.out),
            Command::Live(a) => (vec![&a.scene.scene], &a.scene.reading, &a.out),
            Command::Chart(a) => (vec![&a.scene.scene], &a.scene.reading, &a.out),
            Command::Stress(a) => (a.scene.iter().collect(), &a.reading, &a.out),
            // What is read and asked is told by the words of the map.
            Command::Jobs(_) | Command::Completions(_) => return None,
        })
    }

    /// Whether nothing is said but errors.
    pub(super) fn is_quiet(&self) -> bool {
        let jobs = matches!(&self.command, Command::Jobs(args) if args.out.quiet);
        jobs || self.shared().is_some_and(|(.., out)| out.quiet)
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
            Command::Map(args) => args.run(run),
            Command::Link(args) => args.run(run),
            Command::Track(args) => args.run(run),
            Command::City(args) => args.run(run),
            Command::Info(args) => args.run(run),
            Command::Zones(args) => args.run(run),
            Command::Limits(args) => args.run(run),
            Command::Plos(args) => args.run(run),
            Command::Place(args) => args.run(run),
            Command::Sample(args) => args.run(run),
            Command::Compare(args) => args.run(run),
            Command::Live(args) => args.run(run),
            Command::Chart(args) => args.run(run),
            Command::Stress(args) => args.run(run),
            Command::Jobs(args) => args.run(run),
            Command::Completions(args) => args.run(Cli::command()),
        }
    }
}
