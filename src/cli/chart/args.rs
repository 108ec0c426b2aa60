//! What can be typed after `skyshed chart`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::args::{EngineArgs, OutputArgs, SceneArgs, number};
use crate::cli::typed::length;
use crate::map::Receivers;
use crate::picture::PictureWords;

#[derive(Debug, Args)]
pub(in crate::cli) struct ChartArgs {
    /// A UAV: x, y in the scene's CRS and height (120, 120agl, 30roof, 150amsl, 400ft); repeat for more, whose counts are summed
    #[arg(long, value_name = "X,Y,H", allow_hyphen_values = true)]
    pub(in crate::cli) uav: Vec<String>,
    /// UAVs from a table (.csv with x,y,h or lon,lat,h) or points (.geojson); `-` is standard input
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) uavs: Option<PathBuf>,
    /// Leave out rows of the table that cannot be read, with a warning that names them
    #[arg(long, requires = "uavs")]
    pub(in crate::cli) skip_bad: bool,
    /// Height of the receivers above ground or roof [m]
    #[arg(long, value_name = "M", value_parser = length, default_value = "1.5", allow_hyphen_values = true)]
    pub(in crate::cli) rx_height: f64,
    /// Which cells hold receivers: ground, roof or all
    #[arg(long, value_enum, default_value = "ground")]
    pub(in crate::cli) receivers: Receivers,
    /// Other programs, too: `gdal_viewshed` if it is found on the PATH, with its own files read and written
    #[arg(long)]
    pub(in crate::cli) peers: bool,
    /// The P_LoS methods of a generated city instead: standard error, or the bias of a model, against CPU time
    #[arg(long)]
    pub(in crate::cli) plos: bool,
    /// With `--plos`: elevation angle of the UAV [deg]; default 45, where no model is at an end of its range
    #[arg(long, value_name = "DEG", value_parser = number, allow_hyphen_values = true)]
    pub(in crate::cli) theta: Option<f64>,
    /// With `--plos`: height of the UAV above ground [m]; default 100
    #[arg(long, value_name = "M", value_parser = length, allow_hyphen_values = true)]
    pub(in crate::cli) height: Option<f64>,
    /// Time each contestant for at least so long, and at least three times; those above half a second once [s]
    #[arg(long, value_name = "S", value_parser = number, default_value = "0.2", allow_hyphen_values = true)]
    pub(in crate::cli) time: f64,
    /// File to write, by extension: .png .svg .pdf (picture), .csv, .json, `-` for JSON on standard output; repeat for more.
    /// Without any the table goes to standard output
    #[arg(short, long = "output", value_name = "FILE")]
    pub(in crate::cli) output: Vec<PathBuf>,
    /// Write the table to this file
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) csv: Option<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) words: PictureWords,
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    #[command(flatten)]
    pub(in crate::cli) engine: EngineArgs,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
}
