//! What can be typed after `skyshed place`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::super::args::{EngineArgs, OutputArgs, SceneArgs, number};
use super::super::sample::SampleArgs;
use super::super::typed::length;
use crate::map::Receivers;
use crate::picture::PictureWords;
use crate::zones::Zone;

#[derive(Debug, Args)]
pub(in crate::cli) struct PlaceArgs {
    /// Distance between candidate places: the centers of square cells over the scene [m]
    #[arg(long, value_name = "M", value_parser = number, default_value = "20", allow_hyphen_values = true)]
    pub(super) step: f64,
    /// Heights to try (120, 120agl, 30roof, 150amsl, 400ft), separated by commas, or A:B:S with both ends included [m]
    #[arg(long, value_name = "H,…", allow_hyphen_values = true, required_unless_present = "candidates")]
    pub(super) height: Option<String>,
    /// Only candidates over these zones, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', value_name = "ZONE,…")]
    pub(super) over: Vec<ZoneArg>,
    /// Only candidates inside of these polygons (.geojson)
    #[arg(long, value_name = "FILE")]
    pub(super) within: Option<PathBuf>,
    /// No candidates inside of these polygons (.geojson)
    #[arg(long, value_name = "FILE")]
    pub(super) keep_out: Option<PathBuf>,
    /// Candidates from a table (.csv with x,y,h or lon,lat,h, and optionally id) or points (.geojson; `-` is standard input)
    /// instead of a grid, told by their names; their own heights count if `--height` is not given
    #[arg(long, value_name = "FILE", conflicts_with = "step")]
    pub(super) candidates: Option<PathBuf>,
    /// Leave out rows of the candidates that cannot be read, with a warning that names them
    #[arg(long, requires = "candidates")]
    pub(super) skip_bad: bool,
    /// At least so high above the roof or ground directly below [m]
    #[arg(long, value_name = "M", value_parser = number, default_value = "0", allow_hyphen_values = true)]
    pub(super) clearance: f64,
    /// What to make large: p_los, the share seen of all receivers of `--receivers`, in range or not, or margin, of the worst
    /// receiver in range; of those only in (street), (crossroad), (courtyard), (rooftop), (area); p_los(weights); with
    /// `--minimize height` a share to reach, such as p_los>=0.8
    #[arg(long, value_name = "GOAL", default_value = "p_los")]
    pub(super) goal: String,
    /// Polygons (.geojson) whose receivers count for the goals p_los(area) and margin(area)
    #[arg(long, value_name = "FILE")]
    pub(super) area: Option<PathBuf>,
    /// Raster of weights such as population for the goal p_los(weights): a receiver counts what the cell that holds it says
    #[arg(long, value_name = "FILE")]
    pub(super) weights: Option<PathBuf>,
    /// Instead of the largest share, the least height that reaches the share of the goal
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(super) minimize: Option<MinimizeArg>,
    /// Number of UAVs that are to see most together, of all receivers of the goal whatever the radius
    #[arg(short = 'k', long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    pub(super) count: u16,
    /// Ranks that documents and points list
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..))]
    pub(super) top: u16,
    /// Height of the receivers above ground or roof [m]
    #[arg(long, value_name = "M", value_parser = length, default_value = "1.5", allow_hyphen_values = true)]
    pub(super) rx_height: f64,
    /// Which cells hold receivers; a goal of a zone has its own
    #[arg(long, value_enum, default_value = "ground")]
    pub(super) receivers: Receivers,
    /// File to write, by extension: .csv (those chosen, then all candidates, ranked), .json, .geojson (the best ones), .png .svg .pdf (where to
    /// hover), .tif (the same as numbers), `-` for JSON on standard output; repeat for more. Without any the best ranks of the
    /// table go to standard output
    #[arg(short, long = "output", value_name = "FILE")]
    pub(super) output: Vec<PathBuf>,
    /// Write the table to this file, whatever its name
    #[arg(long, value_name = "FILE")]
    pub(super) csv: Option<PathBuf>,
    /// What the winner sees, or those chosen together: a coverage map (.png .svg .pdf .tif)
    #[arg(long, value_name = "FILE")]
    pub(super) map: Option<PathBuf>,
    #[command(flatten)]
    pub(super) words: PictureWords,
    #[command(flatten)]
    pub(super) sample: SampleArgs,
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    #[command(flatten)]
    pub(in crate::cli) engine: EngineArgs,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum MinimizeArg {
    /// The UAV's height
    Height,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ZoneArg {
    /// Open ground that is neither crossroad nor courtyard
    Street,
    /// Where three or more streets meet
    Crossroad,
    /// Open ground that buildings enclose
    Courtyard,
    /// Buildings
    Rooftop,
}

impl ZoneArg {
    pub(super) fn zone(self) -> Zone {
        match self {
            ZoneArg::Street => Zone::Street,
            ZoneArg::Crossroad => Zone::Crossroad,
            ZoneArg::Courtyard => Zone::Courtyard,
            ZoneArg::Rooftop => Zone::Rooftop,
        }
    }
}
