//! `skyshed zones`: streets, crossroads, courtyards and rooftops.

use clap::Args;

use crate::cli::args::output::{OutputArgs, PictureArgs};
use crate::cli::args::scene::SceneArgs;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::zone_files::{FORMATS, ZoneFiles};

#[derive(Debug, Args)]
#[command(mut_arg("output", |a| a.help("File to write: .png .svg .pdf .tif .geojson .json; repeat for more").long_help("File to write, by extension: a map of the zones (.png .svg .pdf), a raster (.tif), \
polygons (.geojson), their counts (.json), `-` for JSON on standard output; repeat for more")))]
#[command(after_help = "Example: skyshed zones maps/munich.geojson -o zones.png")]
pub(in crate::cli) struct ZonesArgs {
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
    #[command(flatten)]
    picture: PictureArgs,
}

impl ZonesArgs {
    pub(in crate::cli) fn run(&self, run: &Run) -> Result<()> {
        let outputs = self.out.checked(&FORMATS, &self.scene.files())?;
        let look = self.picture.look(&self.out, &outputs)?;
        let zones = ZoneFiles::of(self.scene.open()?, run.words())?;
        run.emit(&zones, &outputs, (&self.out, &look))
    }
}
