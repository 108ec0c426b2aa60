//! `skyshed chart`: speed against accuracy on the user's own scene.

use std::path::PathBuf;

use clap::Args;

use skyshed_request::{OutputOptions, PictureOptions, Sight, Uavs};

use crate::chart::{ChartPlan, FORMATS, PlosChartPlan};
use crate::cli::args::output::checked_files;
use crate::cli::args::scene::SceneArgs;
use crate::cli::args::words::{length, number};
use crate::cli::failure::{Failure, Result, refusal_with};
use crate::cli::run::Run;
use crate::error::{Error, RequestError};
use crate::picture::Look;
use crate::scene::built_up;
use crate::sight::SightPlan;
use crate::uav::UavsAsked;

#[derive(Debug, Args)]
#[command(mut_arg("output", |a| a.help("File to write: .png .svg .pdf .csv .json; repeat for more").long_help("File to write, by extension: .png .svg .pdf (picture), .csv, .json, `-` for JSON on \
standard output; repeat for more. Without any the table goes to standard output")))]
#[command(after_help = "Example: skyshed chart itu:urban --size 300 --uav 150,150,100 --time 0.05 -o chart.png")]
pub(in crate::cli) struct ChartArgs {
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    #[command(flatten, next_help_heading = "Contest")]
    uavs: Uavs,
    #[command(flatten, next_help_heading = "Contest")]
    sight: Sight,
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
    pub(in crate::cli) out: OutputOptions,
    /// Write the table to this file
    #[arg(long, value_name = "FILE", help_heading = "Output", hide_short_help = true)]
    csv: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureOptions,
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
        let inputs: Vec<PathBuf> =
            self.scene.files().into_iter().chain(self.uavs.uavs.clone().map(Into::into)).collect();
        let outputs = checked_files(&self.out, self.csv.as_ref(), (&FORMATS, &inputs))?;
        let look = Look::checked(&self.picture, &self.out.writing, &outputs)?;
        // Timed with one thread, unless more are asked for.
        let threads = self.out.effort.threads.unwrap_or(1);
        let chart = match self.plos {
            true => self.plan_of_p_los(run, threads)?.run(run.words(), &run.progress)?,
            false => {
                let (sight, peers, time_s) = (SightPlan::of(&self.sight)?, self.peers, self.time);
                let plan = ChartPlan { sight, peers, time_s, threads };
                plan.check()?;
                let without = "`--plos` charts the P_LoS methods of a generated city without one";
                let asked =
                    UavsAsked::some_of(&self.uavs, self.scene.reading.options.hash).map_err(|error| match error {
                        Error::Request(RequestError::NoUav) => {
                            refusal_with(108, Failure::from(error).to_string(), without)
                        }
                        error => error.into(),
                    })?;
                let scene = run.open(&self.scene)?;
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
            rx_height_m: self.sight.receiver.rx_height_m(),
            seed: self.scene.reading.options.seed_or_default(),
            time_s: self.time,
            threads,
        })
    }
}
