//! Plan of a search: the question with all defaults filled in, and checks across its options.

use std::path::PathBuf;

use skyshed_io::Input;

use crate::error::{Error, RequestError, Result};
use crate::height_errors::HeightErrorsPlan;
use crate::quantity::{Height, height_steps};
use crate::sight::SightPlan;
use crate::zones::Zone;
use skyshed_request::{
    FilePath, Goal, Measure, PlaceFiles, PlaceQuestion, Shard, Source, Whom, filled, have_one_reference,
};

/// Source of the candidates.
#[derive(Debug, Clone)]
pub(crate) enum CandidatesFrom {
    /// The centers of square cells over the scene.
    Grid {
        /// Distance between neighboring centers \[m\].
        step_m: f64,
    },
    /// A table or points.
    File {
        input: Input,
        /// `true` if rows that cannot be read are left out.
        skips_bad: bool,
    },
}

/// Goal of a search, its candidates and its files.
#[derive(Debug, Clone)]
pub(crate) struct SearchPlan {
    pub(crate) sight: SightPlan,
    /// Standard deviations of building height errors.
    pub(crate) height_errors: HeightErrorsPlan,
    pub(crate) goal: Goal,
    pub(crate) from: CandidatesFrom,
    /// Heights to try; empty where candidates have their own.
    pub(crate) heights: Vec<Height>,
    /// Zones that candidates must be over; empty for no restriction.
    pub(crate) over: Vec<Zone>,
    /// Polygons that candidates must be inside.
    pub(crate) within: Option<Input>,
    /// Polygons that candidates must be outside.
    pub(crate) keep_out: Option<Input>,
    /// Least height above roof or ground directly below \[m\].
    pub(crate) clearance_m: f64,
    /// Polygons whose receivers count.
    pub(crate) area: Option<Input>,
    /// Raster of receiver weights.
    pub(crate) weights: Option<PathBuf>,
    /// Part of the candidates to search, without refinement; `None` for all candidates.
    pub(crate) shard: Option<Shard>,
    /// Number of UAVs to place together.
    pub(crate) count: usize,
    /// Number of ranks that documents and points list.
    pub(crate) top: usize,
    /// `true` if input files of any size are hashed.
    pub(crate) hash: bool,
    /// File for a map of the winners' coverage.
    pub(crate) map: Option<PathBuf>,
}

impl SearchPlan {
    /// Checks a question and fills in its defaults. `files` are the outputs of the run.
    ///
    /// # Errors
    /// E1xx.
    pub(crate) fn of(question: &PlaceQuestion, files: &PlaceFiles, hash: bool) -> Result<SearchPlan> {
        question.check()?;
        let PlaceQuestion { candidates, goal, sight, heights } = question;
        let (defaults, path) = (PlaceQuestion::defaults(), |path: &Option<FilePath>| path.clone().map(PathBuf::from));
        let input = |source: &Option<Source>| source.as_ref().map(Input::of);
        if candidates.shard.is_some() && files.map.is_some() {
            return Err(Error::idle("shard", "with `map`, which looks at all candidates"));
        }
        let from = match &candidates.candidates {
            Some(source) => CandidatesFrom::File { input: Input::of(source), skips_bad: candidates.skip_bad },
            None => CandidatesFrom::Grid { step_m: filled(candidates.step, defaults.candidates.step) },
        };
        let plan = SearchPlan {
            sight: SightPlan::of(sight)?,
            height_errors: HeightErrorsPlan::of(heights, None)?,
            goal: question.goal(),
            from,
            heights: candidates.height.clone().unwrap_or_default().0,
            over: candidates.over.clone(),
            within: input(&candidates.within),
            keep_out: input(&candidates.keep_out),
            clearance_m: filled(candidates.clearance, defaults.candidates.clearance),
            area: input(&goal.area),
            weights: path(&goal.weights),
            shard: candidates.shard,
            count: filled(goal.count, defaults.goal.count).into(),
            top: filled(files.top, Some(10)).into(),
            hash,
            map: path(&files.map),
        };
        plan.check()?;
        Ok(plan)
    }

    /// Returns the inputs beside the scene.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = Input> {
        let candidates = match &self.from {
            CandidatesFrom::File { input, .. } => Some(input.clone()),
            CandidatesFrom::Grid { .. } => None,
        };
        let areas = [&self.within, &self.keep_out, &self.area].into_iter().flatten().cloned();
        candidates.into_iter().chain(areas).chain(self.weights.as_deref().map(Input::path))
    }

    /// Checks numbers and combinations of options, before any work.
    ///
    /// # Errors
    /// E108, E113, E116.
    pub(crate) fn check(&self) -> Result<()> {
        let needs = |option| Err(RequestError::GoalNeeds { goal: self.goal.text.clone(), option }.into());
        let idle = |option, why: &str| Err(Error::idle(option, why));
        match (self.goal.whom, &self.area, &self.weights) {
            (Whom::Area, None, _) => return needs("area"),
            (Whom::Weights, _, None) => return needs("weights"),
            (whom, Some(_), _) if whom != Whom::Area => {
                return idle("area", "without the goal p_los(area) or margin(area)");
            }
            (whom, _, Some(_)) if whom != Whom::Weights => return idle("weights", "without the goal p_los(weights)"),
            _ => {}
        }
        self.check_heights(self.height_errors)?;
        if self.count > 1 && self.goal.measure == Measure::Margin {
            return idle("count", "with the goal margin: several UAVs have no margin in common");
        }
        if self.count > 1 && self.goal.at_least.is_some() {
            return idle("count", "where the least height is looked for");
        }
        if let CandidatesFrom::Grid { step_m } = self.from
            && step_m <= 0.0
        {
            return Err(Error::number("the step between places", step_m, "above 0 m"));
        }
        let compares = !self.heights.is_empty() && have_one_reference(&self.heights);
        if self.goal.at_least.is_some() && !compares {
            return Err(RequestError::MixedHeights.into());
        }
        self.clearance().map(|_| ())
    }

    /// Refuses errors of heights where no shares of receivers are compared.
    ///
    /// # Errors
    /// E116.
    pub(super) fn check_heights(&self, errors: HeightErrorsPlan) -> Result<()> {
        let Goal { measure, at_least, whom, .. } = &self.goal;
        let compares = *measure == Measure::Share && at_least.is_none() && *whom != Whom::Weights;
        let compares = compares && self.count == 1 && self.top > 1 && self.shard.is_none();
        let option = match errors {
            _ if compares => return Ok(()),
            HeightErrorsPlan { own_m, .. } if own_m > 0.0 => "height_error",
            HeightErrorsPlan { shared_m, .. } if shared_m > 0.0 => "height_bias",
            HeightErrorsPlan { by_building: true, .. } => "height_error_field",
            _ => return Ok(()),
        };
        Err(Error::idle(
            option,
            "but for one UAV that is to see the largest share of receivers, held against other places (`top`) of one run",
        ))
    }

    /// Returns the clearance in height steps of the lattice.
    pub(super) fn clearance(&self) -> Result<i32> {
        height_steps(self.clearance_m)
            .filter(|c| *c >= 0)
            .ok_or_else(|| Error::number("the clearance", self.clearance_m, "0 m to 32768 m"))
    }
}
