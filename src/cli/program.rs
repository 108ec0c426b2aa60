//! Program and commands, as they are typed.

use std::ffi::{OsStr, OsString};

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use serde_json::{Map, Value};
use skyshed_request::words::with_defaults;
use skyshed_request::{
    ChartRequest, CityRequest, CompareRequest, FilePath, InfoRequest, LimitsRequest, LinkRequest, LiveRequest,
    MapRequest, PlaceQuestion, PlaceRequest, PlosRequest, SampleRequest, Source, StressRequest, TrackRequest,
    ZonesRequest, json,
};

use super::commands::{
    CompletionsArgs, JobsArgs, chart, city, compare, info, limits, link, live, map, place, plos, sample, stress, track,
    zones,
};
use super::keywords::{Members, read};
use super::run::{Run, Shared};
use crate::cli::failure::{Result, refusal};
use crate::error::Error;

/// Exact line-of-sight coverage maps: what a hovering UAV can see of a city.
#[derive(Debug, Parser)]
#[command(name = "skyshed", version, propagate_version = true, max_term_width = 110)]
#[command(after_help = "\
SCENE is a generated city (itu:urban, itu:0.3,500,15), a raster (.tif, .asc, .xyz, .vrt), buildings
(.geojson, .city.json, .gml, .parquet, .osm.pbf, .shp, .fgb, .gpkg), a point cloud (.las, .laz) or a
mesh (.obj, .ply), also in .gz or .zip; a folder, or A+B, of several files of one format is one scene.
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
    /// Facts of a file: size, CRS, heights and faults of a scene; content of UAVs and outputs
    Info(Box<InfoRequest>),
    /// Streets, crossroads, courtyards and rooftops: counts, a map, polygons
    Zones(Box<ZonesRequest>),
    /// Limits of the P_LoS of a map: cells, terrain, positions, heights
    Limits(Box<LimitsRequest>),
    /// Probability of line of sight: exact products, simulators, models, real cities
    Plos(Box<PlosRequest>),
    /// Best places to hover: candidates ranked, refined, or chosen together
    Place(Box<PlaceRequest>),
    /// P_LoS averaged over placements of each zone, with intervals
    Sample(Box<SampleRequest>),
    /// Placements side by side: maps, differences, a page to swipe over
    Compare(Box<CompareRequest>),
    /// One page in which a UAV is dragged over the city, and the exact coverage follows
    Live(Box<LiveRequest>),
    /// Speed against accuracy of every method on a scene
    Chart(Box<ChartRequest>),
    /// Failures of methods on small scenes full of ties; cells of a scene that hang by a step
    Stress(Box<StressRequest>),
    /// A map in units of work for schedulers: which there are, which are done, what all come to
    Jobs(Box<JobsArgs>),
    /// Words for a shell that completes what is typed, or a man page
    Completions(CompletionsArgs),
}

/// Returns the number of tables to be read from standard input.
fn standard_inputs(members: &Map<String, Value>) -> usize {
    let is_standard_input = |path: &&Value| path.as_str().is_some_and(|path| path == "-" || path.ends_with("=-"));
    let tables = ["uavs", "candidates", "track"].into_iter().filter_map(|name| members.get(name));
    let curves = members.get("curve").and_then(Value::as_array).into_iter().flatten();
    tables.chain(curves).filter(is_standard_input).count()
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
    pub(super) fn from_words(words: &[OsString]) -> std::result::Result<Cli, clap::Error> {
        // PERF: defaults are needed in help texts alone.
        let asks_help = words.iter().any(|word| word == "-h" || word == "--help" || word == "help");
        let mut command = if asks_help { Cli::program() } else { Cli::command() };
        let matches = command.try_get_matches_from_mut(words.iter().map(|word| skyshed_io::told(word)))?;
        let cli = Cli::from_arg_matches(&matches).map_err(|e| e.format(&mut command))?;
        if cli.shared().is_some_and(|shared| standard_inputs(&shared.members()) > 1) {
            let text = "`-` is given for two tables, wanted one: standard input can be read once";
            return Err(command.error(clap::error::ErrorKind::ArgumentConflict, text));
        }
        Ok(cli)
    }

    /// Reads the request of a command from options by their names.
    pub(super) fn of_request(command: &str, options: Members) -> Result<Cli> {
        macro_rules! requests {
            ($($name:literal $Command:ident),+) => {
                match command {
                    $($name => Command::$Command(Box::new(read(options)?)),)+
                    _ => return Err(refusal(101, format!("found the command `{command}`, wanted one that answers"))),
                }
            };
        }
        let command = requests!(
            "map" Map, "link" Link, "track" Track, "city" City, "info" Info, "zones" Zones, "limits" Limits, "plos" Plos,
            "place" Place, "sample" Sample, "compare" Compare, "live" Live, "chart" Chart, "stress" Stress
        );
        Ok(Cli { command })
    }

    /// Sets an input in memory, which no word can name.
    pub(super) fn hold(&mut self, option: &str, source: Source) {
        match (&mut self.command, option) {
            (Command::Map(map), "uavs") => map.uavs.uavs = Some(source),
            (Command::Compare(compare), "uavs") => compare.uavs.uavs = Some(source),
            (Command::Limits(limits), "uavs") => limits.uavs.uavs = Some(source),
            (Command::Track(track), "track") => track.track.track = Some(source),
            (Command::Live(live), "uavs") => live.uavs.uavs = Some(source),
            (Command::Live(live), "track") => live.track.track = Some(source),
            (Command::Place(place), _) => {
                let PlaceQuestion { candidates, goal, .. } = &mut place.question;
                match option {
                    "candidates" => candidates.candidates = Some(source),
                    "within" => candidates.within = Some(source),
                    "keep_out" => candidates.keep_out = Some(source),
                    "area" => goal.area = Some(source),
                    _ => {}
                }
            }
            _ => {}
        }
    }

    /// Returns the parts that requests share; `None` for a command that has none.
    pub(super) fn shared(&self) -> Option<Shared<'_>> {
        macro_rules! shared {
            ($request:expr, $scenes:expr) => {
                Shared {
                    scenes: $scenes,
                    reading: &$request.reading,
                    out: &$request.out,
                    read_members: Box::new(|| json::set_members(&**$request)),
                }
            };
        }
        fn words(paths: &[FilePath]) -> Vec<&OsStr> {
            paths.iter().map(|path| path.as_os_str()).collect()
        }
        Some(match &self.command {
            Command::Map(r) => shared!(r, vec![r.scene.word()]),
            Command::Link(r) => shared!(r, vec![r.scene.word()]),
            Command::Track(r) => shared!(r, vec![r.scene.word()]),
            Command::City(r) => shared!(r, vec![r.scene.word()]),
            Command::Info(r) => shared!(r, vec![r.scene.word()]),
            Command::Zones(r) => shared!(r, vec![r.scene.word()]),
            Command::Limits(r) => shared!(r, vec![r.scene.word()]),
            Command::Plos(r) => shared!(r, words(&r.plos.scenes)),
            Command::Place(r) => shared!(r, vec![r.scene.word()]),
            Command::Sample(r) => shared!(r, vec![r.scene.word()]),
            Command::Compare(r) => shared!(r, vec![r.scene.word()]),
            Command::Live(r) => shared!(r, vec![r.scene.word()]),
            Command::Chart(r) => shared!(r, vec![r.scene.word()]),
            Command::Stress(r) => shared!(r, r.stress.scene.iter().map(|word| word.as_os_str()).collect()),
            // The words of a map hold the scene and the options.
            Command::Jobs(_) | Command::Completions(_) => return None,
        })
    }

    /// Returns `true` if nothing but errors is printed.
    pub(super) fn is_quiet(&self) -> bool {
        let jobs = matches!(&self.command, Command::Jobs(args) if args.out.effort.quiet);
        jobs || self.shared().is_some_and(|shared| shared.out.effort.quiet)
    }

    /// Returns `true` if something other than a city is drawn at random: links, blocks, scenes.
    pub(super) fn draws(&self) -> bool {
        matches!(
            self.command,
            Command::Plos(_) | Command::Sample(_) | Command::Compare(_) | Command::Chart(_) | Command::Stress(_)
        )
    }

    /// Runs the command.
    pub(super) fn run(&self, run: &Run) -> Result<()> {
        if !matches!(self.command, Command::Map(_) | Command::Place(_) | Command::Compare(_))
            && self.shared().is_some_and(|shared| shared.reading.options.height_error_field.is_some())
        {
            return Err(Error::idle("height_error_field", "but for `map`, `place` and `compare`").into());
        }
        match &self.command {
            Command::Map(request) => map::run(request, run),
            Command::Link(request) => link::run(request, run),
            Command::Track(request) => track::run(request, run),
            Command::City(request) => city::run(request, run),
            Command::Info(request) => info::run(request, run),
            Command::Zones(request) => zones::run(request, run),
            Command::Limits(request) => limits::run(request, run),
            Command::Plos(request) => plos::run(request, run),
            Command::Place(request) => place::run(request, run),
            Command::Sample(request) => sample::run(request, run),
            Command::Compare(request) => compare::run(request, run),
            Command::Live(request) => live::run(request, run),
            Command::Chart(request) => chart::run(request, run),
            Command::Stress(request) => stress::run(request, run),
            Command::Jobs(args) => args.run(run),
            Command::Completions(args) => args.run(Cli::program()),
        }
    }
}
