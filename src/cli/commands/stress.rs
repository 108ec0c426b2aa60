//! `skyshed stress`: where methods fail, on families of scenes; and where the answers of a scene hang by a step.

use std::ffi::OsString;

use clap::Args;

use skyshed_request::{OutputOptions, PictureOptions, Reading, Sight};

use crate::accuracy::stress::{FAMILIES, Family};
use crate::cli::args::output::checked_files;
use crate::cli::args::scene::scene_files;
use crate::cli::failure::Result;
use crate::cli::run::Run;
use crate::picture::Look;
use crate::sight::SightPlan;
use crate::stress::{FORMATS, Stress, StressScene};
use crate::uav::UavsFound;
use crate::uav::site_of;

#[derive(Debug, Args)]
#[command(mut_arg("output", |a| a.help("File to write: .png .svg .pdf .csv .json; repeat for more").long_help("File to write, by extension: .png .svg .pdf (failure rates by family and method; of \
SCENE a map of what turns), .csv, .json, `-` for JSON on standard output; repeat for more. Without any the table goes to \
standard output")))]
#[command(after_help = "Example: skyshed stress --scenes 4 -o failures.png")]
pub(in crate::cli) struct StressArgs {
    /// A scene whose stability is asked for, with `--uav`: generated city, raster, footprints or mesh. Without one, all methods
    /// are tried on families of small scenes where methods fail
    #[arg(value_name = "SCENE", requires = "uav")]
    pub(in crate::cli) scene: Option<OsString>,
    /// Only these families of scenes, separated by commas, such as cell-slits,prism-walls; default all
    #[arg(long, value_name = "NAME,…", value_parser = family, value_delimiter = ',', help_heading = "Families",
          conflicts_with = "scene")]
    families: Vec<&'static str>,
    /// Scenes of each family
    #[arg(long, value_name = "N", default_value_t = 128, value_parser = clap::value_parser!(u32).range(1..=100_000),
          help_heading = "Families", conflicts_with = "scene")]
    scenes: u32,
    /// The UAV over SCENE: x, y in its CRS and height (120, 120agl, 30roof, 150amsl, 400ft)
    #[arg(long, value_name = "X,Y,H", allow_hyphen_values = true, help_heading = "Map", requires = "scene")]
    uav: Option<String>,
    #[command(flatten, next_help_heading = "Map")]
    sight: Sight,
    #[command(flatten)]
    pub(in crate::cli) reading: Reading,
    #[command(flatten)]
    pub(in crate::cli) out: OutputOptions,
    #[command(flatten)]
    picture: PictureOptions,
}

/// What families of scenes can use.
const OF_FAMILIES: [&str; 15] = [
    "families",
    "scenes",
    "seed",
    "method",
    "title",
    "width",
    "dpi",
    "output",
    "json",
    "overwrite",
    "csv_text",
    "threads",
    "max_memory",
    "quiet",
    "repairs",
];

impl StressArgs {
    pub(in crate::cli) fn run(&self, run: &Run) -> Result<()> {
        let files = self.scene.as_ref().map_or_else(Vec::new, |scene| scene_files(scene, &self.reading));
        let outputs = checked_files(&self.out, None, (&FORMATS, &files))?;
        let look = Look::checked(&self.picture, &self.out.writing, &outputs)?;
        let (Some(word), Some(uav)) = (&self.scene, &self.uav) else {
            run.typed.refuse_others(&OF_FAMILIES, "without a scene")?;
            let effort = (self.scenes, self.reading.options.seed_or_default());
            let stress = Stress::run(&self.families, self.sight.range.engine(), effort, run.words())?;
            run.emit(&stress, &outputs, (&self.out, &look))?;
            return Ok(stress.check()?);
        };
        let sites = vec![site_of(uav, "1".into())?.into()];
        let found = UavsFound { sites, ..UavsFound::default() };
        let sight = SightPlan::of(&self.sight)?;
        let scene = run.reader(&self.reading).open(word)?;
        let stability = StressScene::run(scene, &found, sight, run.words(), &run.progress)?;
        run.emit(&stability, &outputs, (&self.out, &look))
    }
}

fn family(name: &str) -> std::result::Result<&'static str, String> {
    let known = || FAMILIES.iter().map(|family| family.name).collect::<Vec<_>>().join(", ");
    Family::named(name.trim()).map(|family| family.name).ok_or_else(|| format!("wanted one of {}", known()))
}
