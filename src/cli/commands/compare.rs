//! `skyshed compare`: placements side by side.

use std::path::PathBuf;

use clap::Args;

use crate::cli::args::height_errors::HeightErrorArgs;
use crate::cli::args::output::{OutputArgs, PictureArgs};
use crate::cli::args::scene::SceneArgs;
use crate::cli::args::sight::{SightArgs, UavsArgs};
use crate::cli::args::words::number;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::comparison::{ComparisonPlan, FORMATS, check_number};
use crate::export::Format;
use crate::scene::SceneOptions;

#[derive(Debug, Args)]
#[command(mut_arg("output", |a| a.help("File to write: .html .png .svg .pdf .tif .csv .json; repeat for more").long_help("File to write, by extension: .html (a page to swipe over, in one file), .png .svg .pdf \
(all maps on one sheet), .tif (masks, differences, count), .csv, .json, `-` for JSON on standard output; repeat for more. \
Without any the table goes to standard output")))]
#[command(after_help = "Example: skyshed compare itu:urban --uav 500,500,100 --uav 560,440,100 -o compare.html")]
pub(in crate::cli) struct CompareArgs {
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    #[command(flatten, next_help_heading = "Placements")]
    uavs: UavsArgs,
    /// A saved map on the scene's grid (.tif or .asc with the classes of `skyshed map`), named after its file; repeat for
    /// more
    #[arg(long, value_name = "FILE", help_heading = "Placements")]
    mask: Vec<PathBuf>,
    #[command(flatten, next_help_heading = "Placements")]
    sight: SightArgs,
    #[command(flatten, next_help_heading = "Placements")]
    heights: HeightErrorArgs,
    /// Edge of the blocks of ground that are resampled for intervals [m]
    #[arg(long, value_name = "M", value_parser = number, default_value = "50", allow_hyphen_values = true,
          help_heading = "Placements")]
    block: f64,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
    /// Write the table to this file
    #[arg(long, value_name = "FILE", help_heading = "Output", hide_short_help = true)]
    csv: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArgs,
}

impl CompareArgs {
    pub(in crate::cli) fn run(&self, run: &Run) -> Result<()> {
        let reading = &self.scene.reading;
        let inputs = [self.scene.files(), self.mask.clone(), self.uavs.uavs.iter().cloned().collect()].concat();
        let outputs = self.out.checked_with(self.csv.as_ref(), &FORMATS, &inputs)?;
        let look = self.picture.look(&self.out, &outputs)?;
        let plan = ComparisonPlan {
            sight: self.sight.checked()?,
            heights: self.heights.checked(None)?,
            masks: self.mask.clone(),
            hash: reading.hash,
            block_m: self.block,
            seed: reading.seed,
            scene_words: self.scene.words(&run.typed),
            draws_pairs: outputs.iter().any(|(_, format)| *format == Format::GeoTiff),
        };
        plan.check()?;
        if self.uavs.uav.len() < 2 && self.uavs.uavs.is_none() {
            run.typed.refuse(
                &["height_error", "height_bias", "height_error_field"],
                "without two UAVs: saved maps are not made anew",
            )?;
        }
        let asked = self.uavs.asked(reading.hash)?;
        if asked.table.is_none() && self.mask.is_empty() {
            check_number(asked.typed.len())?;
        }
        // The page has a door to the live page of the same place.
        let keeps_solids = outputs.iter().any(|(_, format)| *format == Format::Html);
        let options = SceneOptions { keeps_solids, ..reading.options()? };
        let scene = options.open(&self.scene.scene)?;
        let found = asked.read(scene.grid())?;
        let comparison = plan.compare(scene, &found, run.words(), &run.progress)?;
        run.emit(&comparison, &outputs, (&self.out, &look))
    }
}
