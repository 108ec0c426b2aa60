//! What a caller of the library asks of a search, setting by setting: it becomes a plan.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;

use super::report::{PlaceFacts, PlaceValue};
use super::{CandidatesFrom, FORMATS, Goal, Placements, SearchPlan};
use crate::answer::{Answer, Spent, add_outputs};
use crate::city::Antenna;
use crate::error::{Result, Warning};
use crate::export::{Batch, OutputRules, check_outputs};
use crate::height_errors::AskedErrors;
use crate::los::MethodChoice;
use crate::picture::Look;
use crate::progress::Progress;
use crate::quantity::Height;
use crate::scene::Scene;
use crate::sight::{AskedSight, Receivers};
use crate::uav::Uav;

impl Scene {
    /// Asks where a UAV sees most, at any of some heights, over the centers of square cells.
    pub fn placements(&self, heights: impl IntoIterator<Item = Height>) -> PlacementsRequest {
        PlacementsRequest {
            scene: self.clone(),
            heights: heights.into_iter().collect(),
            asked: AskedSight::default(),
            height_errors: AskedErrors::default(),
            goal: "p_los".into(),
            from: CandidatesFrom::Grid { step_m: 20.0 },
            clearance_m: 0.0,
            count: 1,
            progress: Arc::default(),
        }
    }
}

/// What is asked of a search: which places, for whom, how many UAVs.
#[derive(Debug, Clone)]
#[must_use = "nothing is searched before `run`"]
pub struct PlacementsRequest {
    scene: Scene,
    heights: Vec<Height>,
    asked: AskedSight,
    height_errors: AskedErrors,
    goal: String,
    from: CandidatesFrom,
    clearance_m: f64,
    count: usize,
    progress: Arc<Progress>,
}

impl PlacementsRequest {
    /// The distance between candidate places \[m\]. Default: 20.
    pub fn step_m(self, step_m: f64) -> Self {
        PlacementsRequest { from: CandidatesFrom::Grid { step_m }, ..self }
    }

    /// Candidates from a table (`.csv` with x, y and h) or points (`.geojson`), instead of a grid.
    pub fn candidates(self, path: impl Into<PathBuf>) -> Self {
        PlacementsRequest { from: CandidatesFrom::File { path: path.into(), skips_bad: false }, ..self }
    }

    /// What to make large: `p_los`, or `margin` of the worst receiver, alone or of a zone, such as `p_los(street)`.
    /// Default: `p_los`.
    pub fn goal(self, goal: impl Into<String>) -> Self {
        PlacementsRequest { goal: goal.into(), ..self }
    }

    /// The largest horizontal distance from a UAV to a receiver \[m\]. Default: unlimited.
    pub fn radius_m(mut self, radius_m: f64) -> Self {
        self.asked.radius_m = Some(radius_m);
        self
    }

    /// What the antennas of UAVs serve that have none of their own. Default: all.
    pub fn antenna(mut self, antenna: Antenna) -> Self {
        self.asked.antenna = antenna;
        self
    }

    /// A curved earth of K times its radius: 4/3 for radio, 7/6 for light. Default: a flat one.
    pub fn earth_k(mut self, k: f64) -> Self {
        self.asked.earth_k = Some(k);
        self
    }

    /// Standard deviations of the errors of heights \[m\]: of each building alone, and of what all share. Default: none. Places that are no worse than
    /// these allow are told then.
    pub fn height_errors_m(mut self, own_m: f64, shared_m: f64) -> Self {
        (self.height_errors.own_m, self.height_errors.shared_m) = (own_m, shared_m);
        self
    }

    /// The height of the receivers above ground or roof \[m\]. Default: 1.5.
    pub fn receiver_height_m(mut self, height_m: f64) -> Self {
        self.asked.rx_height_m = height_m;
        self
    }

    /// Which cells hold receivers. Default: open ground.
    pub fn receivers(mut self, receivers: Receivers) -> Self {
        self.asked.receivers = receivers;
        self
    }

    /// The engine. Default: the fastest exact one for the scene.
    pub fn method(mut self, method: MethodChoice) -> Self {
        self.asked.method = method;
        self
    }

    /// The least height above the roof or ground directly below \[m\]. Default: 0.
    pub fn clearance_m(self, clearance_m: f64) -> Self {
        PlacementsRequest { clearance_m, ..self }
    }

    /// How many UAVs are to see most together. Default: 1.
    pub fn count(self, count: usize) -> Self {
        PlacementsRequest { count: count.max(1), ..self }
    }

    /// A token that tells how far the search is, and can stop it from another thread.
    pub fn progress(self, progress: &Arc<Progress>) -> Self {
        PlacementsRequest { progress: Arc::clone(progress), ..self }
    }

    /// Searches.
    ///
    /// # Errors
    /// E101 for a goal that is none; E113 for numbers out of range; E117 for zones of a surface model alone; E209 if no
    /// candidate is left; E501, E502 for too many.
    pub fn run(self) -> Result<Placements> {
        let plan = SearchPlan {
            height_errors: self.height_errors.checked()?,
            shard: None,
            sight: self.asked.checked()?,
            goal: Goal::parse(&self.goal)?,
            from: self.from,
            heights: self.heights,
            over: Vec::new(),
            within: None,
            keep_out: None,
            clearance_m: self.clearance_m,
            area: None,
            weights: None,
            count: self.count,
            top: 10,
            hash: false,
            map: None,
        };
        plan.search(self.scene, Vec::new(), &self.progress)
    }
}

impl Placements {
    /// The candidates, best first, with heights above the datum whatever was asked.
    pub fn ranked(&self) -> impl ExactSizeIterator<Item = Uav> {
        self.report.ranked.iter().map(uav_of)
    }

    /// The best candidate, with its height above the datum; `None` if no receiver is wanted, or none reaches the goal.
    pub fn best(&self) -> Option<Uav> {
        self.report.winner.as_ref().ok().map(uav_of)
    }

    /// Those chosen to see most together, in the order of choice; the best alone if one was asked for.
    pub fn chosen(&self) -> Vec<Uav> {
        match &self.report.several {
            Some(several) => several.places.iter().map(uav_of).collect(),
            None => self.best().into_iter().collect(),
        }
    }

    /// The share of the wanted receivers that a candidate sees; `None` for another goal, or for a UAV that is not among
    /// [`Placements::ranked`].
    pub fn share(&self, uav: Uav) -> Option<f64> {
        let place = self.report.ranked.iter().find(|place| uav_of(place) == uav)?;
        match place.value {
            PlaceValue::Counts(score) | PlaceValue::Weighted(score) => score.share(),
            PlaceValue::Margin(_) => None,
        }
    }

    /// What was odd.
    pub fn warnings(&self) -> &[Warning] {
        Answer::warnings(self)
    }

    /// The document `skyshed/place/1`.
    pub fn document(&self) -> Value {
        Answer::document(self, Some(Spent::default()))
    }

    /// Writes a file, whose extension says what: a picture of where to hover (.png .svg .pdf), the same as numbers
    /// (.tif), a
    /// table (.csv), a document (.json), the best as points (.geojson).
    ///
    /// # Errors
    /// E104–E109 for a file that cannot be written so; E106 if it exists; E401 if writing fails.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let rules = OutputRules { allowed: &FORMATS, inputs: &[], overwrite: false, bare: false };
        let outputs = check_outputs(&[path.as_ref().into()], rules)?;
        let mut batch = Batch::new(false);
        add_outputs(self, &mut batch, &outputs, (&Look::default(), Spent::default()))?;
        Ok(batch.commit().map(|_| ())?)
    }
}

/// A place as a UAV, at its height above the datum.
fn uav_of(place: &PlaceFacts) -> Uav {
    let uav = Uav::new(place.x, place.y, Height::AboveDatum(place.height_amsl_m));
    match &place.id {
        Some(id) => uav.named(id.clone()),
        None => uav,
    }
}
