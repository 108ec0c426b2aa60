//! `skyshed city`: makes or converts a city, and draws it.

use clap::Args;

use crate::cli::args::output::{OutputArgs, PictureArgs};
use crate::cli::args::scene::SceneArgs;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::conversion::{Conversion, FORMATS};

#[derive(Debug, Args)]
#[command(mut_arg("output", |a| a.help("File to write: .png .svg .pdf .tif .asc .geojson .xml .csv .json; repeat for more").long_help("File to write, by extension: .png .svg .pdf (plan and 3-D view), .tif .asc (surface \
heights), .geojson (footprints), .xml (scene of Mitsuba and Sionna RT, with meshes), .csv (boxes of ns-3), .json \
(parameters); repeat for more. Without any what the city is goes to standard output")))]
#[command(after_help = "Example: skyshed city itu:urban --size 400 -o city.png -o city.geojson")]
pub(in crate::cli) struct CityArgs {
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
    #[command(flatten)]
    picture: PictureArgs,
}

impl CityArgs {
    pub(in crate::cli) fn run(&self, run: &Run) -> Result<()> {
        let outputs = self.out.checked(&FORMATS, &self.scene.files())?;
        let look = self.picture.look(&self.out, &outputs)?;
        let city = match &run.given {
            Some(scene) => Conversion::of(scene.clone(), run.words()),
            None => Conversion::open(&self.scene.reading.options()?, &self.scene.scene, run.words())?,
        };
        run.emit(&city, &outputs, (&self.out, &look))
    }
}
