//! `skyshed place`: where to hover.

use std::path::PathBuf;

use clap::Args;

use crate::answer::Output;
use crate::cli::args::height_errors::HeightErrorArgs;
use crate::cli::args::output::{OutputArgs, PictureArgs};
use crate::cli::args::scene::SceneArgs;
use crate::cli::args::sight::SightArgs;
use crate::cli::args::words::{Words, ZONES, number, one_of, shard};
use crate::cli::failure::{Result, refusal, refusal_with};
use crate::cli::run::Run;
use crate::export::Format;
use crate::placements::{CandidatesFrom, FORMATS, Goal, SearchPlan, Whom, have_one_reference, heights};
use crate::uav::Shard;
use crate::zones::Zone;

const MINIMIZE: Words<()> = &[("height", "The UAV's height", ())];

#[derive(Debug, Args)]
#[command(mut_arg("output", |a| a.help("File to write: .png .svg .pdf .tif .csv .json .geojson; repeat for more").long_help("File to write, by extension: .csv (those chosen, then all candidates, ranked), .json, \
.geojson (the best ones), .png .svg .pdf (where to hover), .tif (the same as numbers), `-` for JSON on standard output; repeat \
for more. Without any the best ranks of the table go to standard output")))]
#[command(after_help = "Example: skyshed place itu:urban --height 60,100 --step 50 -o hover.png")]
pub(in crate::cli) struct PlaceArgs {
    #[command(flatten)]
    pub(in crate::cli) scene: SceneArgs,
    /// Heights to try, such as 60,100 or 60:120:20 [m]
    ///
    /// Each as 120, 120agl, 30roof, 150amsl or 400ft, separated by commas, or A:B:S with both ends included.
    #[arg(
        long,
        value_name = "H,…",
        allow_hyphen_values = true,
        required_unless_present = "candidates",
        help_heading = "Candidates"
    )]
    height: Option<String>,
    /// Distance between candidate places: the centers of square cells over the scene [m]
    #[arg(long, value_name = "M", value_parser = number, default_value = "20", allow_hyphen_values = true,
          help_heading = "Candidates")]
    step: f64,
    /// Only candidates over these zones, separated by commas
    #[arg(long, value_name = "ZONE,…", value_parser = one_of(ZONES), value_delimiter = ',', help_heading = "Candidates",
          hide_short_help = true)]
    over: Vec<Zone>,
    /// Only candidates inside of these polygons (.geojson)
    #[arg(long, value_name = "FILE", help_heading = "Candidates", hide_short_help = true)]
    within: Option<PathBuf>,
    /// No candidates inside of these polygons (.geojson)
    #[arg(long, value_name = "FILE", help_heading = "Candidates", hide_short_help = true)]
    keep_out: Option<PathBuf>,
    /// Candidates from a table (.csv) or points (.geojson) instead of a grid
    ///
    /// Columns are x,y,h or lon,lat,h; `-` is standard input. They are told by their names (a column id); their own heights count if `--height` is not given.
    #[arg(long, value_name = "FILE", conflicts_with = "step", help_heading = "Candidates")]
    candidates: Option<PathBuf>,
    /// Leave out rows of the candidates that cannot be read, with a warning that names them
    #[arg(long, requires = "candidates", help_heading = "Candidates", hide_short_help = true)]
    skip_bad: bool,
    /// Only the K-th of N nearly equal parts of the candidates, in their order; nothing is refined: for schedulers that hand out
    /// numbers
    #[arg(long, value_name = "K/N", value_parser = shard, help_heading = "Candidates", hide_short_help = true)]
    shard: Option<Shard>,
    /// At least so high above the roof or ground directly below [m]
    #[arg(long, value_name = "M", value_parser = number, default_value = "0", allow_hyphen_values = true,
          help_heading = "Candidates", hide_short_help = true)]
    clearance: f64,
    /// What to make large, such as p_los, p_los(street), margin, p_los>=0.8
    ///
    /// p_los is the share seen of all receivers of `--receivers`, in range or not; margin that of the worst receiver in range;
    /// of those only in (street), (crossroad), (courtyard), (rooftop), (area); p_los(weights); with `--minimize height` a share
    /// to reach, such as p_los>=0.8.
    #[arg(long, value_name = "GOAL", default_value = "p_los", help_heading = "Goal")]
    goal: String,
    /// Polygons (.geojson) whose receivers count for the goals p_los(area) and margin(area)
    #[arg(long, value_name = "FILE", help_heading = "Goal", hide_short_help = true)]
    area: Option<PathBuf>,
    /// Raster of scores for the goal p_los(weights): each receiver counts the whole value of the cell that holds it; no persons per cell, which many receivers would share
    #[arg(long, value_name = "FILE", help_heading = "Goal", hide_short_help = true)]
    weights: Option<PathBuf>,
    /// Instead of the largest share, the least height that reaches the share of the goal
    #[arg(long, value_name = "WHAT", value_parser = one_of(MINIMIZE), help_heading = "Goal", hide_short_help = true)]
    minimize: Option<()>,
    /// Number of UAVs that are to see most together, of all receivers of the goal whatever the radius
    #[arg(short = 'k', long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..),
          help_heading = "Goal")]
    count: u16,
    #[command(flatten, next_help_heading = "Goal")]
    sight: SightArgs,
    #[command(flatten, next_help_heading = "Goal")]
    height_errors: HeightErrorArgs,
    #[command(flatten)]
    pub(in crate::cli) out: OutputArgs,
    /// Write the table to this file
    #[arg(long, value_name = "FILE", help_heading = "Output", hide_short_help = true)]
    csv: Option<PathBuf>,
    /// What the winner sees, or those chosen together: a coverage map (.png .svg .pdf .tif)
    #[arg(long, value_name = "FILE", help_heading = "Output", hide_short_help = true)]
    map: Option<PathBuf>,
    /// Ranks that documents and points list
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..),
          help_heading = "Output", hide_short_help = true)]
    top: u16,
    #[command(flatten)]
    picture: PictureArgs,
}

impl PlaceArgs {
    pub(in crate::cli) fn run(&self, run: &Run) -> Result<()> {
        let plan = self.plan()?;
        plan.check()?;
        if matches!(plan.goal.whom, Whom::Zone(_)) {
            run.typed.refuse(&["receivers"], "with the goal of a zone")?;
        }
        let beside: Vec<PathBuf> = plan.files().map(PathBuf::from).collect();
        let inputs = [self.scene.files(), beside].concat();
        let (outputs, map) = self.outputs(&inputs)?;
        let all: Vec<Output> = outputs.iter().chain(&map).cloned().collect();
        let look = self.picture.look(&self.out, &all)?;
        let found = plan.search(run.open(&self.scene)?, run.words(), &run.progress)?;
        run.emit(&found, &all, (&self.out, &look))
    }

    fn plan(&self) -> Result<SearchPlan> {
        let goal = Goal::parse(&self.goal)?;
        if self.shard.is_some() && (self.count > 1 || self.map.is_some() || self.minimize.is_some()) {
            let text = "`--shard` has no meaning with `--count`, `--map` or `--minimize`, which look at all candidates";
            return Err(refusal(116, text));
        }
        let heights = self.height.as_deref().map(heights).transpose()?;
        let from = match &self.candidates {
            Some(path) => CandidatesFrom::File { path: path.clone(), skips_bad: self.skip_bad },
            None => CandidatesFrom::Grid { step_m: self.step },
        };
        match (self.minimize, goal.at_least) {
            (Some(()), None) => {
                let text = format!("the goal is `{}`, wanted a share to reach with `--minimize height`", self.goal);
                return Err(refusal_with(101, text, "for example `--goal p_los>=0.8 --minimize height`"));
            }
            (None, Some(_)) => {
                let text = format!("the goal `{}` names a share, but not what to minimize", self.goal);
                return Err(refusal_with(101, text, "add `--minimize height`"));
            }
            _ => {}
        }
        if self.minimize.is_some() && !heights.as_deref().is_some_and(have_one_reference) {
            let text = "`--minimize height` compares the heights of `--height`: wanted all above the same";
            return Err(refusal_with(113, text, "for example `--height 20:200:10`"));
        }
        Ok(SearchPlan {
            sight: self.sight.checked()?,
            height_errors: self.height_errors.checked(None)?,
            goal,
            from,
            heights: heights.unwrap_or_default(),
            over: self.over.clone(),
            within: self.within.clone(),
            keep_out: self.keep_out.clone(),
            clearance_m: self.clearance,
            area: self.area.clone(),
            weights: self.weights.clone(),
            shard: self.shard,
            count: usize::from(self.count),
            top: usize::from(self.top),
            hash: self.scene.reading.hash,
            map: self.map.clone(),
        })
    }

    /// The files to write, checked: those of `-o` and `--csv`, and the map of the winner.
    fn outputs(&self, inputs: &[PathBuf]) -> Result<(Vec<Output>, Option<Output>)> {
        let outputs = self.out.checked_with(self.csv.as_ref(), &FORMATS, inputs)?;
        let is_spatial = |format: &Format| format.is_picture() || *format == Format::GeoTiff;
        if let Some((path, _)) = outputs.iter().find(|(_, f)| self.candidates.is_some() && is_spatial(f)) {
            let text = format!("cannot write {}: only candidates on a grid make a picture or a raster", path.display());
            return Err(refusal_with(109, text, "write them as points: `-o places.geojson`"));
        }
        let Some(path) = &self.map else { return Ok((outputs, None)) };
        if !Format::of(path).is_ok_and(|format| is_spatial(&format)) {
            let text = format!("cannot write {}: `--map` writes a map", path.display());
            return Err(refusal_with(105, text, "wanted .png, .svg, .pdf or .tif"));
        }
        let files = [self.out.output.clone(), vec![path.clone()]].concat();
        let map = OutputArgs { output: files, ..self.out.clone() }.checked(&FORMATS, inputs)?.pop();
        Ok((outputs, map))
    }
}
