//! What can be typed after `skyshed compare`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::args::{EngineArgs, OutputArgs, SceneArgs, number};
use crate::cli::typed::length;
use crate::map::Receivers;
use crate::picture::PictureWords;

#[derive(Debug, Args)]
pub(in crate::cli) struct CompareArgs {
    /// A UAV: x, y in the scene's CRS and height (120, 120agl, 30roof, 150amsl, 400ft); repeat for more
    #[arg(long, value_name = "X,Y,H", allow_hyphen_values = true)]
    pub(in crate::cli) uav: Vec<String>,
    /// UAVs from a table (.csv with x,y,h or lon,lat,h) or points (.geojson); `-` is standard input
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) uavs: Option<PathBuf>,
    /// Leave out rows of the table that cannot be read, with a warning that names them
    #[arg(long, requires = "uavs")]
    pub(in crate::cli) skip_bad: bool,
    /// A saved map on the scene's grid (.tif or .asc with the classes of `skyshed map`), named after its file; repeat for
    /// more
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) mask: Vec<PathBuf>,
    /// Height of the receivers above ground or roof [m]
    #[arg(long, value_name = "M", value_parser = length, default_value = "1.5", allow_hyphen_values = true)]
    pub(in crate::cli) rx_height: f64,
    /// Which cells hold receivers
    #[arg(long, value_enum, default_value = "ground")]
    pub(in crate::cli) receivers: Receivers,
    /// Edge of the blocks of ground that are resampled for intervals [m]
    #[arg(long, value_name = "M", value_parser = number, default_value = "50", allow_hyphen_values = true)]
    pub(in crate::cli) block: f64,
    /// File to write, by extension: .html (a page to swipe over, in one file), .png .svg .pdf (all maps on one sheet), .tif
    /// (masks, differences, count), .csv, .json, `-` for JSON on standard output; repeat for more. Without any the table
    /// goes to standard output
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
