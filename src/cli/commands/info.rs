//! `skyshed info`: what a file is, what is wrong with it, and what to do with it.
//!
//! A scene is told in full; files of UAVs and tracks, and what this program wrote, by what they hold. Any other file is
//! refused by the reader of scenes, which says what kind of file it is.

use std::path::Path;

use clap::Args;

use crate::answer::Answer;
use crate::cli::args::output::OutputArgs;
use crate::cli::args::scene::SceneArgs;
use crate::cli::args::words::number;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::survey::{FORMATS, Output, Places, Survey, TILE_FORMATS};

#[derive(Debug, Args)]
#[command(mut_arg("scene", |a| a.help("A scene, as of any command; a file of UAVs or of a track (.csv, .geojson); or a file \
that this program wrote")))]
#[command(mut_arg("output", |a| a.help("File to write: .json, with `--tile` also .tif .csv; repeat for more").long_help("File to write, by extension: .json; with `--tile` also a raster of α, β, γ (.tif) or \
their table (.csv); `-` for JSON on standard output; repeat for more")))]
#[command(after_help = "Example: skyshed info maps/munich.geojson")]
pub(in crate::cli) struct InfoArgs {
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    /// Also α, β and γ of squares of this size, from the north-west corner [m]
    ///
    /// A raster (.tif) or a table (.csv); squares that the extent cuts have the values of what is left of them.
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true, help_heading = "Scene")]
    tile: Option<f64>,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
}

impl InfoArgs {
    pub(in crate::cli) fn run(&self, run: &Run) -> Result<()> {
        let (path, words) = (Path::new(&self.scene.scene), run.words());
        if let Some(output) = Output::of(path, &words) {
            return self.tell(run, &output, &["scene"]);
        }
        if let Some(places) = Places::of(path, self.scene.reading.crs()?, &words)? {
            return self.tell(run, &places, &["scene", "crs"]);
        }
        let formats = if self.tile.is_some() { &TILE_FORMATS[..] } else { &FORMATS[..] };
        let outputs = self.out.checked(formats, &self.scene.files())?;
        let survey = Survey::open(&self.scene.reading.options()?, &self.scene.scene, self.tile, words)?;
        run.emit(&survey, &outputs, (&self.out, &self.out.look()))
    }

    /// Answers for a file that is no scene.
    fn tell(&self, run: &Run, answer: &dyn Answer, used: &[&str]) -> Result<()> {
        let of_all = ["output", "json", "overwrite", "threads", "max_memory", "quiet"];
        let path = Path::new(&self.scene.scene);
        let why = format!("for {}, which is no scene", path.display());
        run.typed.refuse_others(&[used, &of_all].concat(), &why)?;
        let outputs = self.out.checked(&FORMATS, &[path.to_path_buf()])?;
        run.emit(answer, &outputs, (&self.out, &self.out.look()))
    }
}
