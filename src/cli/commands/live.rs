//! `skyshed live`: a page in which a UAV is dragged over the city.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::args::output::{OutputArgs, PictureArgs};
use crate::cli::args::scene::SceneArgs;
use crate::cli::args::sight::{SightArgs, UavsArgs};
use crate::cli::failure::{Result, refusal};
use crate::cli::run::Run;
use crate::cli::say;
use crate::export::Format;
use crate::live::{FORMATS, LivePage, LivePlan};

#[derive(Debug, Args)]
#[command(mut_arg("output", |a| a.help("File to write: .html .json; without any the page is opened").long_help("Page to write (.html), what it holds (.json), `-` for JSON on standard output; repeat for \
more. Without any the page is written to the folder for temporary files, and opened")))]
#[command(after_help = "Example: skyshed live maps/munich.geojson -o munich.html")]
pub(in crate::cli) struct LiveArgs {
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    #[command(flatten, next_help_heading = "Start")]
    uavs: UavsArgs,
    #[command(flatten, next_help_heading = "Start")]
    sight: SightArgs,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
    #[command(flatten)]
    picture: PictureArgs,
}

impl LiveArgs {
    pub(in crate::cli) fn run(&self, run: &Run) -> Result<()> {
        run.typed.refuse(&["method"], "for a page: it uses the fastest exact engine")?;
        run.typed.refuse(&["width", "dpi"], "for a page, which is as wide as its window")?;
        let mut outputs = self.out.checked(&FORMATS, &self.scene.files())?;
        let opens = outputs.is_empty() && !self.out.json;
        if opens {
            outputs.push((temporary(&self.scene.scene)?, Format::Html));
        }
        let look = self.picture.look(&self.out, &outputs)?;
        let plan = LivePlan {
            uavs: self.uavs.asked(self.scene.reading.hash)?,
            sight: self.sight.checked()?,
            scene_words: self.scene.words(&run.typed),
            command: run.words(),
        };
        let page = LivePage::open(&self.scene.reading.options()?, &self.scene.scene, plan)?;
        if !opens {
            return run.emit(&page, &outputs, (&self.out, &look));
        }
        run.emit(&page, &outputs, (&self.out, &look))?;
        if open::that_detached(&outputs[0].0).is_err() {
            say::note("no browser could be started: open the file in one");
        }
        Ok(())
    }
}

/// The page of a scene in a new folder for temporary files, which stays.
///
/// # Errors
/// E401.
fn temporary(scene: &OsStr) -> Result<PathBuf> {
    let stem = Path::new(scene).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name: String = stem.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
    let folder = tempfile::Builder::new().prefix("skyshed-").tempdir();
    let folder = folder.map_err(|e| refusal(401, format!("cannot make a folder for the page: {e}")))?;
    Ok(folder.keep().join(format!("{name}.html")))
}
