//! `skyshed sample`: what UAVs over each zone see on average.

use std::path::PathBuf;

use clap::Args;

use crate::cli::args::output::{OutputArgs, PictureArgs};
use crate::cli::args::scene::SceneArgs;
use crate::cli::args::sight::SightArgs;
use crate::cli::args::words::{number, zone_and_count};
use crate::cli::failure::{Result, refusal};
use crate::cli::run::Run;
use crate::placements::heights;
use crate::quantity::Height;
use crate::sample::{FORMATS, SamplePlan};
use crate::scene::built_up;
use crate::zones::Zone;

#[derive(Debug, Args)]
#[command(mut_arg("size", |a| a.help("Edge length of a generated city [m], default 1000; with a radius that of the ground that \
placements are over, and the city goes on around it")))]
#[command(mut_arg("output", |a| a.help("File to write: .png .svg .pdf .csv .json; repeat for more").long_help("File to write, by extension: .png .svg .pdf (bars with intervals), .csv, .json, `-` \
for JSON on standard output; repeat for more. Without any the table goes to standard output")))]
#[command(
    after_help = "Example: skyshed sample itu:urban --zones street:50,crossroad:50,rooftop:50 --height 60,100 --radius 300"
)]
pub(in crate::cli) struct SampleArgs {
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    /// Over which zones, and how many placements over each: street:200,crossroad:200,rooftop:200
    #[arg(long, value_name = "ZONE:N,…", value_delimiter = ',', value_parser = zone_and_count, required = true,
          help_heading = "Sample")]
    zones: Vec<(Zone, usize)>,
    /// Heights of the UAVs above ground (120, 400ft), separated by commas, or A:B:S with both ends included [m]
    #[arg(long, value_name = "H,…", allow_hyphen_values = true, help_heading = "Sample")]
    height: String,
    /// Placements stand over the middles of a generated city's crossroads, streets and buildings
    #[arg(long, help_heading = "Sample")]
    centers: bool,
    /// Generated cities to sample, from `--seed` on; each has N placements per zone, and intervals are over cities
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=100_000),
          help_heading = "Sample")]
    cities: u64,
    /// Confidence of the intervals
    #[arg(long, value_name = "C", value_parser = number, default_value = "0.95", help_heading = "Sample",
          hide_short_help = true)]
    ci: f64,
    /// Edge of the blocks of ground that are resampled for the intervals over one city [m]; default: an eighth of the
    /// city, at least 100 m
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true, help_heading = "Sample",
          hide_short_help = true)]
    block: Option<f64>,
    #[command(flatten, next_help_heading = "Sample")]
    sight: SightArgs,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
    /// Write the table to this file
    #[arg(long, value_name = "FILE", help_heading = "Output", hide_short_help = true)]
    csv: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArgs,
}

impl SampleArgs {
    pub(in crate::cli) fn run(&self, run: &Run) -> Result<()> {
        if built_up(&self.scene.scene).is_some() {
            run.typed.refuse(&["ground"], "for heights above the ground of a generated city")?;
        }
        let above_ground = |height: Height| match height {
            Height::AboveGround(h) => Ok(h),
            other => {
                let text = format!("`--height` is `{other}`, wanted heights above ground: places of a sample differ");
                Err(refusal(113, text))
            }
        };
        let options = self.scene.reading.options()?;
        let plan = SamplePlan {
            word: self.scene.scene.clone(),
            given: run.given.clone(),
            size_m: self.scene.reading.size.unwrap_or(1000.0),
            scene: options,
            sight: self.sight.checked()?,
            zones: self.zones.clone(),
            heights_m: heights(&self.height)?.into_iter().map(above_ground).collect::<Result<_>>()?,
            is_centered: self.centers,
            n_cities: self.cities,
            seed: self.scene.reading.seed,
            confidence: self.ci,
            block_m: self.block,
        };
        plan.check()?;
        let outputs = self.out.checked_with(self.csv.as_ref(), &FORMATS, &self.scene.files())?;
        let look = self.picture.look(&self.out, &outputs)?;
        let sample = plan.take(run.words(), &run.progress)?;
        run.emit(&sample, &outputs, (&self.out, &look))
    }
}
