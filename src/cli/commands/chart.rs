//! `skyshed chart`: speed against accuracy on the user's own scene.

use std::path::PathBuf;

use clap::Args;

use crate::chart::{ChartPlan, FORMATS, PlosChartPlan};
use crate::cli::args::output::{OutputArgs, PictureArgs};
use crate::cli::args::scene::SceneArgs;
use crate::cli::args::sight::{SightArgs, UavsArgs};
use crate::cli::args::words::{length, number};
use crate::cli::failure::{Result, refusal_with};
use crate::cli::run::Run;
use crate::scene::built_up;

#[derive(Debug, Args)]
#[command(mut_arg("output", |a| a.help("File to write: .png .svg .pdf .csv .json; repeat for more").long_help("File to write, by extension: .png .svg .pdf (picture), .csv, .json, `-` for JSON on \
standard output; repeat for more. Without any the table goes to standard output")))]
#[command(after_help = "Example: skyshed chart itu:urban --size 300 --uav 150,150,100 --time 0.05 -o chart.png")]
pub(in crate::cli) struct ChartArgs {
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    #[command(flatten, next_help_heading = "Contest")]
    uavs: UavsArgs,
    #[command(flatten, next_help_heading = "Contest")]
    sight: SightArgs,
    /// Other programs, too: `gdal_viewshed` if it is found on the PATH, with its own files read and written
    #[arg(long, help_heading = "Contest")]
    peers: bool,
    /// Time each contestant for at least so long, and at least three times; those above half a second once [s]
    #[arg(long, value_name = "S", value_parser = number, default_value = "0.2", allow_hyphen_values = true,
          help_heading = "Contest")]
    time: f64,
    /// The P_LoS methods of a generated city instead: standard error, or the bias of a model, against CPU time
    #[arg(long, help_heading = "Contest")]
    plos: bool,
    /// With `--plos`: elevation angle of the UAV [deg]; default 45, where no model is at an end of its range
    #[arg(long, value_name = "DEG", value_parser = number, allow_hyphen_values = true, requires = "plos",
          help_heading = "Contest", hide_short_help = true)]
    theta: Option<f64>,
    /// With `--plos`: height of the UAV above ground [m]; default 100
    #[arg(long, value_name = "M", value_parser = length, allow_hyphen_values = true, requires = "plos",
          help_heading = "Contest", hide_short_help = true)]
    height: Option<f64>,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
    /// Write the table to this file
    #[arg(long, value_name = "FILE", help_heading = "Output", hide_short_help = true)]
    csv: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArgs,
}

/// What the P_LoS methods of a generated city can use.
const OF_P_LOS: [&str; 18] = [
    "scene",
    "plos",
    "theta",
    "height",
    "rx_height",
    "time",
    "seed",
    "csv",
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
];

impl ChartArgs {
    pub(in crate::cli) fn run(&self, run: &Run) -> Result<()> {
        let inputs: Vec<PathBuf> = self.scene.files().into_iter().chain(self.uavs.uavs.clone()).collect();
        let outputs = self.out.checked_with(self.csv.as_ref(), &FORMATS, &inputs)?;
        let look = self.picture.look(&self.out, &outputs)?;
        // Timed with one thread, unless more are asked for.
        let threads = self.out.threads.unwrap_or(1);
        let chart = match self.plos {
            true => self.plan_of_p_los(run, threads)?.run(run.words(), &run.progress)?,
            false => {
                let (sight, peers, time_s) = (self.sight.checked()?, self.peers, self.time);
                let plan = ChartPlan { sight, peers, time_s, threads };
                plan.check()?;
                let without = "`--plos` charts the P_LoS methods of a generated city without one";
                let asked = self.uavs.some(self.scene.reading.hash, Some(without))?;
                let scene = self.scene.open()?;
                let found = asked.read(scene.grid())?;
                plan.run(scene, &found, run.words(), &run.progress)?
            }
        };
        run.emit(&chart, &outputs, (&self.out, &look))
    }

    fn plan_of_p_los(&self, run: &Run, threads: u16) -> Result<PlosChartPlan> {
        let city = self.scene.scene.display().to_string();
        let Some(built_up) = built_up(&self.scene.scene) else {
            let text = format!("`--plos` has no meaning for {city}: it charts a generated city");
            let hint = "`chart itu:α,β,γ --plos`; of footprints `skyshed info` gives α, β, γ";
            return Err(refusal_with(116, text, hint));
        };
        run.typed.refuse_others(&OF_P_LOS, "with `--plos`, which maps no scene")?;
        Ok(PlosChartPlan {
            city,
            built_up: built_up?,
            theta_deg: self.theta.unwrap_or(45.0),
            height_m: self.height.unwrap_or(100.0),
            rx_height_m: self.sight.rx_height_m(),
            seed: self.scene.reading.seed,
            time_s: self.time,
            threads,
        })
    }
}
