//! `skyshed link`: one link, decided and explained.

use clap::Args;

use crate::answer::Answer;
use crate::cli::args::output::{OutputArgs, PictureArgs};
use crate::cli::args::scene::SceneArgs;
use crate::cli::args::sight::{EarthArgs, RxHeightArgs, parse_receiver, parse_uav};
use crate::cli::args::words::number;
use crate::cli::failure::{Result, refusal};
use crate::cli::run::Run;
use crate::link::FORMATS;
use crate::quantity::tidy;
use crate::sight::AskedSight;
use crate::uav::Uav;

#[derive(Debug, Args)]
#[command(mut_arg("output", |a| a.help("File to write: .png .svg .pdf .json").long_help("Side view of the link (.png, .svg, .pdf) or its document (.json), `-` for JSON on \
standard output; repeat for more. Without any the answer goes to standard output")))]
#[command(after_help = "Example: skyshed link itu:urban --uav 500,500,100 --rx 630,480")]
pub(in crate::cli) struct LinkArgs {
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    /// The UAV: x, y in the scene's CRS and height (120, 120agl, 30roof, 150amsl)
    #[arg(long, value_name = "X,Y,H", allow_hyphen_values = true, help_heading = "Link")]
    uav: String,
    /// The receiver: x, y and height (1.5, 1.5roof, 30amsl); `--rx-height` above ground without one
    #[arg(long, value_name = "X,Y[,H]", allow_hyphen_values = true, help_heading = "Link")]
    rx: String,
    #[command(flatten, next_help_heading = "Link")]
    height: RxHeightArgs,
    /// Refuse a receiver that is farther away [m]
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true, help_heading = "Link")]
    radius: Option<f64>,
    #[command(flatten, next_help_heading = "Link")]
    earth: EarthArgs,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
    #[command(flatten)]
    picture: PictureArgs,
}

impl LinkArgs {
    pub(in crate::cli) fn run(&self, run: &Run) -> Result<()> {
        run.typed.refuse(&["data_area"], "for a link: its ends are where they are put")?;
        let site = parse_uav(&self.uav, "1".into())?;
        let asked = AskedSight {
            rx_height_m: self.height.rx_height,
            radius_m: self.radius,
            earth_k: self.earth.earth_k(),
            ..AskedSight::default()
        };
        let sight = asked.checked()?;
        let radius_m = sight.radius_m();
        let (receiver, height) = parse_receiver(&self.rx, self.height.rx_height)?;
        let outputs = self.out.checked(&FORMATS, &self.scene.files())?;
        let look = self.picture.look(&self.out, &outputs)?;
        let uav = Uav::new(site.x, site.y, site.height).named(site.id);
        let mut link = run.open(&self.scene)?.curved_link(uav, (receiver, height), sight.curvature())?;
        link.facts.command = run.words();
        if let Some(radius) = radius_m.filter(|radius| link.distance_m() > *radius) {
            let distance = tidy(link.distance_m());
            let text = format!("the receiver is {distance} m from the UAV, wanted within `--radius {radius}`");
            return Err(refusal(208, text));
        }
        run.emit(&link as &dyn Answer, &outputs, (&self.out, &look))
    }
}
