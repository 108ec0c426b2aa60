//! `skyshed track`: line of sight along a user's track.

use std::path::PathBuf;

use clap::Args;

use crate::cli::args::output::{OutputArgs, PictureArgs};
use crate::cli::args::scene::SceneArgs;
use crate::cli::args::sight::{EarthArgs, RxHeightArgs, parse_uav};
use crate::cli::args::words::number;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::track::{FORMATS, TrackPlan};

#[derive(Debug, Args)]
#[command(mut_arg("output", |a| a.help("File to write: .png .svg .pdf .csv .json; repeat for more").long_help("A strip of line of sight below the height that would be enough (.png, .svg, .pdf), \
the document (.json), a table (.csv), `-` for JSON on standard output; repeat for more")))]
#[command(after_help = "Example: skyshed track itu:urban --uav 500,500,100 --track walk.csv -o walk.png")]
pub(in crate::cli) struct TrackArgs {
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    /// The UAV: x, y in the scene's CRS and height (120, 120agl, 30roof, 150amsl)
    #[arg(long, value_name = "X,Y,H", allow_hyphen_values = true, help_heading = "Track")]
    uav: String,
    /// The user's places in order, from a table (.csv with x,y or lon,lat; `-` is standard input) or a line (.geojson)
    #[arg(long, value_name = "FILE", help_heading = "Track")]
    track: PathBuf,
    /// Leave out rows of the track that cannot be read, with a warning that names them
    #[arg(long, help_heading = "Track")]
    skip_bad: bool,
    /// Longest step along the track between two decided places [m]; what begins and ends within a step is missed
    #[arg(long, value_name = "M", value_parser = number, default_value = "1", allow_hyphen_values = true,
          help_heading = "Track")]
    every: f64,
    #[command(flatten, next_help_heading = "Track")]
    height: RxHeightArgs,
    #[command(flatten, next_help_heading = "Track")]
    earth: EarthArgs,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
    #[command(flatten)]
    picture: PictureArgs,
}

impl TrackArgs {
    pub(in crate::cli) fn run(&self, run: &Run) -> Result<()> {
        run.typed.refuse(&["data_area"], "for a link: its ends are where they are put")?;
        let plan = TrackPlan {
            uav: parse_uav(&self.uav, "1".into())?,
            file: self.track.clone(),
            skips_bad: self.skip_bad,
            hash: self.scene.reading.hash,
            every_m: self.every,
            sight: self.height.sight(&self.earth)?,
        };
        plan.check()?;
        let inputs = [self.scene.files(), vec![self.track.clone()]].concat();
        let outputs = self.out.checked(&FORMATS, &inputs)?;
        let look = self.picture.look(&self.out, &outputs)?;
        let walk = plan.walk(self.scene.open()?, run.words())?;
        run.emit(&walk, &outputs, (&self.out, &look))
    }
}
