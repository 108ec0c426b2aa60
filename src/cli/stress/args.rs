//! What can be typed after `skyshed stress`.

use std::path::PathBuf;

use clap::Args;

use crate::accuracy::stress::{FAMILIES, Family};
use crate::cli::args::{EngineArgs, OutputArgs, SceneArgs};
use crate::cli::typed::length;
use crate::map::Receivers;
use crate::picture::PictureWords;

#[derive(Debug, Args)]
#[command(mut_arg("scene", |a| a.required(false).default_value("").hide_default_value(true).help(
    "A scene whose stability is asked for, with `--uav`: generated city (itu:…), raster (.tif, .asc) or footprints \
     (.geojson). Without one, all methods are tried on families of small scenes where methods fail"
)))]
pub(in crate::cli) struct StressArgs {
    /// Only these families of scenes, separated by commas, such as cell-slits,prism-walls; default all
    #[arg(long, value_name = "NAME,…", value_parser = family, value_delimiter = ',')]
    pub(super) families: Vec<&'static str>,
    /// Scenes of each family
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(super) scenes: u32,
    /// The UAV over SCENE: x, y in its CRS and height (120, 120agl, 30roof, 150amsl, 400ft)
    #[arg(long, value_name = "X,Y,H", allow_hyphen_values = true)]
    pub(super) uav: Option<String>,
    /// Height of the receivers of SCENE above ground or roof [m]
    #[arg(long, value_name = "M", value_parser = length, default_value = "1.5", allow_hyphen_values = true)]
    pub(super) rx_height: f64,
    /// Which cells of SCENE hold receivers
    #[arg(long, value_enum, default_value = "ground")]
    pub(super) receivers: Receivers,
    /// File to write, by extension: .png .svg .pdf (failure rates by family and method; of SCENE a map of what turns), .csv,
    /// .json, `-` for JSON on standard output; repeat for more. Without any the table goes to standard output
    #[arg(short, long = "output", value_name = "FILE")]
    pub(super) output: Vec<PathBuf>,
    #[command(flatten)]
    pub(super) words: PictureWords,
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    #[command(flatten)]
    pub(in crate::cli) engine: EngineArgs,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
}

fn family(name: &str) -> Result<&'static str, String> {
    let known = || FAMILIES.iter().map(|family| family.name).collect::<Vec<_>>().join(", ");
    Family::named(name.trim()).map(|family| family.name).ok_or_else(|| format!("wanted one of {}", known()))
}
