//! `skyshed limits`: what limits the P_LoS of a map, and what the map needs.

use clap::Args;

use crate::cli::args::output::OutputArgs;
use crate::cli::args::scene::SceneArgs;
use crate::cli::args::sight::{SightArgs, UavsArgs};
use crate::cli::args::words::number;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::limits::{FORMATS, LimitsPlan};
use crate::scene::SceneOptions;

#[derive(Debug, Args)]
#[command(mut_arg("output", |a| a.help("File to write: .csv .json; repeat for more").long_help("File to write, by extension: .csv (what limits P_LoS), .json, `-` for JSON on standard \
output; repeat for more. Without any the answer goes to standard output")))]
#[command(after_help = "Example: skyshed limits itu:urban --uav 500,500,100 --radius 300")]
pub(in crate::cli) struct LimitsArgs {
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    #[command(flatten, next_help_heading = "Map")]
    uavs: UavsArgs,
    #[command(flatten, next_help_heading = "Map")]
    sight: SightArgs,
    /// How far the UAV may be from where it should be, sideways and in height [m]
    #[arg(long, value_name = "M", value_parser = number, default_value = "1", allow_hyphen_values = true,
          help_heading = "Uncertainty")]
    uav_error: f64,
    /// How far the heights of all buildings may be off [m]
    #[arg(long, value_name = "M", value_parser = number, default_value = "1", allow_hyphen_values = true,
          help_heading = "Uncertainty")]
    height_error: f64,
    /// Other cities of a generated kind that tell how much one city of many matters
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(2..=1000),
          help_heading = "Uncertainty")]
    cities: u16,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
}

impl LimitsArgs {
    pub(in crate::cli) fn run(&self, run: &Run) -> Result<()> {
        let plan = LimitsPlan {
            sight: self.sight.checked()?,
            uav_error_m: self.uav_error,
            height_error_m: self.height_error,
            n_cities: self.cities,
        };
        let asked = self.uavs.some(self.scene.reading.hash, None)?;
        let inputs: Vec<_> = self.scene.files().into_iter().chain(asked.table.clone()).collect();
        let outputs = self.out.checked(&FORMATS, &inputs)?;
        // What is wrong with a file is told, not refused.
        let options = SceneOptions { tells_faults: true, ..self.scene.reading.options()? };
        let limits = plan.find((&options, &self.scene.scene), &asked, run.words())?;
        run.emit(&limits, &outputs, (&self.out, &self.out.look()))
    }
}
