//! Placement request of the library, which becomes a plan.

use std::path::Path;
use std::sync::Arc;

use serde_json::Value;

use skyshed_request::{
    Antenna, CandidateOptions, Earth, GoalOptions, HeightErrors, Heights, PlaceFiles, PlaceQuestion, Range, Receiver,
    SaveOptions, SetCandidateOptions,
};

use super::report::{PlaceFacts, PlaceValue};
use super::{FORMATS, Placements, SearchPlan};
use crate::answer::{Answer, CommandFacts, Spent, saved};
use crate::error::{Result, Warning};
use crate::progress::Progress;
use crate::quantity::Height;
use crate::scene::Scene;
use crate::uav::Uav;

impl Scene {
    /// Requests a search for the places from which a UAV sees most. Candidates are the centers of
    /// square cells, at each of the heights.
    pub fn placements(&self, heights: impl IntoIterator<Item = Height>) -> PlacementsRequest {
        let question = PlaceQuestion::default().height(heights.into_iter().collect::<Heights>());
        PlacementsRequest { scene: self.clone(), question, progress: Arc::default() }
    }
}

/// Request of placement over a scene. Traits of [`crate::prelude`] set its options:
/// [candidates](CandidateOptions), [goal](GoalOptions), [receiver](Receiver), [range](Range),
/// [antenna](Antenna), [earth](Earth), [errors of heights](HeightErrors). Unset ones have the defaults of
/// [`crate::request::defaults`].
#[derive(Debug, Clone)]
#[must_use = "nothing is searched before `run`"]
pub struct PlacementsRequest {
    scene: Scene,
    question: PlaceQuestion,
    progress: Arc<Progress>,
}

skyshed_request::holds! {
    PlacementsRequest: question.candidates CandidateOptions, question.goal GoalOptions, question.sight.receiver Receiver,
    question.sight.range Range, question.sight.antenna Antenna, question.sight.earth Earth, question.heights HeightErrors
}

impl PlacementsRequest {
    /// Sets a token that reports the progress of the search and can stop it from another thread.
    pub fn progress(self, progress: &Arc<Progress>) -> Self {
        PlacementsRequest { progress: Arc::clone(progress), ..self }
    }

    /// Runs the search.
    ///
    /// # Errors
    /// E101, E108, E113 and E116 for a question that makes no sense; E117 for zones of a surface
    /// model alone; E209 without a candidate; E501, E502 for too many candidates.
    pub fn run(self) -> Result<Placements> {
        let plan = SearchPlan::of(&self.question, &PlaceFiles::default(), false)?;
        plan.search(self.scene, CommandFacts::default(), &self.progress)
    }
}

impl Placements {
    /// Returns the candidates, best first. Their heights are above the datum, in whatever way they
    /// were requested. Candidates inside of buildings are left out; the document counts them as
    /// `skipped`.
    pub fn ranked(&self) -> impl ExactSizeIterator<Item = Uav> {
        self.report.ranked.iter().map(uav_of)
    }

    /// Returns the best candidate, with its height above the datum. `None` if no receiver is wanted
    /// or no candidate reaches the goal. A finer search around it is [`Placements::refined`].
    pub fn best(&self) -> Option<Uav> {
        self.report.winner.as_ref().ok().map(uav_of)
    }

    /// Returns the end of a search around the best candidate, in steps down to a cell, and its share
    /// of the wanted receivers.
    ///
    /// There is none for several UAVs, for goals that are no shares, and for candidates of a file.
    pub fn refined(&self) -> Option<(Uav, Option<f64>)> {
        self.report.refined.as_ref().map(|(place, _)| (uav_of(place), share_of(place)))
    }

    /// Returns the UAVs that together see most, in the order of choice. For one UAV this is the
    /// best candidate.
    pub fn chosen(&self) -> Vec<Uav> {
        match &self.report.several {
            Some(several) => several.places.iter().map(uav_of).collect(),
            None => self.best().into_iter().collect(),
        }
    }

    /// Returns the share of the wanted receivers that a candidate sees. `None` for another goal,
    /// and for a UAV that is not in [`Placements::ranked`].
    pub fn share(&self, uav: Uav) -> Option<f64> {
        share_of(self.report.ranked.iter().find(|place| uav_of(place) == uav)?)
    }

    /// Returns the warnings.
    pub fn warnings(&self) -> &[Warning] {
        Answer::warnings(self)
    }

    /// Returns the document `skyshed/place/1`.
    pub fn document(&self) -> Value {
        Answer::document(self, Some(Spent::default()))
    }

    /// Writes a file in the format of its extension. A picture (.png .svg .pdf) is a heat map, a
    /// raster (.tif) holds its values. The others are a table (.csv), a document (.json), and the
    /// best places as points (.geojson).
    ///
    /// # Errors
    /// E104–E109 for a file that cannot be written so; E106 if it exists; E401 if writing fails.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        saved(self, &FORMATS, path.as_ref(), &SaveOptions::default())
    }

    /// Writes a file as `save` does, with options of pictures and of writing.
    ///
    /// # Errors
    /// As `save`; E116 for options of maps, and for a look without a picture.
    pub fn save_with(&self, path: impl AsRef<Path>, options: &SaveOptions) -> Result<()> {
        saved(self, &FORMATS, path.as_ref(), options)
    }
}

fn share_of(place: &PlaceFacts) -> Option<f64> {
    match place.value {
        PlaceValue::Counts(score) | PlaceValue::Weighted(score) => score.share(),
        PlaceValue::Margin(_) => None,
    }
}

/// Returns a place as a UAV, at its height above the datum.
fn uav_of(place: &PlaceFacts) -> Uav {
    let uav = Uav::new(place.x, place.y, Height::AboveDatum(place.height_amsl_m));
    match &place.id {
        Some(id) => uav.named(id.clone()),
        None => uav,
    }
}
