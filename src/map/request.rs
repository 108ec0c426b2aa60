//! Request of a map by a caller of the library, setting by setting; it becomes a plan.

use std::marker::PhantomData;
use std::sync::Arc;

use skyshed_request::{Antenna, CoverageQuestion, Earth, HeightErrors, MapOptions, Range, Receiver};

use super::coverages::{Coverage, Coverages};
use super::plan::{Held, MapPlan, PartOf, Prepared};
use crate::coverage::{SiteCoverage, Tally};
use crate::error::Result;
use crate::progress::Progress;
use crate::scene::Scene;
use crate::uav::{Uav, UavsFound};

impl Scene {
    /// Begins a request of the coverage by one UAV.
    pub fn coverage(&self, uav: Uav) -> CoverageRequest<Coverage> {
        CoverageRequest::new(self, vec![uav])
    }

    /// Begins a request of the coverage by each of some UAVs, and by all of them together.
    ///
    /// ```
    /// use skyshed::prelude::*;
    ///
    /// let city = Scene::options().size(200.0).open("itu:urban")?;
    /// let uavs = [40.0, 160.0].map(|x| Uav::new(x, 100.0, Height::agl(80.0)));
    /// let seen = city.coverages(uavs).radius(150.0).run()?;
    /// let best = seen.sites().iter().map(|site| site.tally.los).max().unwrap_or(0);
    /// assert!(seen.union().los >= best);
    /// # Ok::<(), skyshed::Error>(())
    /// ```
    pub fn coverages(&self, uavs: impl IntoIterator<Item = Uav>) -> CoverageRequest<Coverages> {
        CoverageRequest::new(self, uavs.into_iter().collect())
    }
}

/// Request of a map: receivers, range, layers. `Answer` is [`Coverage`] of one UAV, [`Coverages`]
/// of many.
///
/// Traits of [`crate::prelude`] set its options: [receiver](skyshed_request::Receiver),
/// [range](skyshed_request::Range), [antenna](skyshed_request::Antenna), [earth](skyshed_request::Earth),
/// [errors of heights](skyshed_request::HeightErrors), [layers](skyshed_request::MapOptions). Unset ones
/// have the defaults of [`crate::request::defaults`].
#[derive(Debug, Clone)]
#[must_use = "nothing is made before `run`"]
pub struct CoverageRequest<Answer> {
    scene: Scene,
    uavs: Vec<Uav>,
    question: CoverageQuestion,
    keeps_masks: bool,
    progress: Arc<Progress>,
    answer: PhantomData<fn() -> Answer>,
}

impl<Answer> CoverageRequest<Answer> {
    /// Replaces the whole question, for example by one that was read from JSON.
    pub fn question(mut self, question: CoverageQuestion) -> Self {
        self.question = question;
        self
    }

    fn new(scene: &Scene, uavs: Vec<Uav>) -> Self {
        CoverageRequest {
            scene: scene.clone(),
            uavs,
            question: CoverageQuestion::default(),
            keeps_masks: false,
            progress: Arc::default(),
            answer: PhantomData,
        }
    }

    /// Sets the token that reports the progress of the map, and can stop it from another thread.
    pub fn progress(mut self, progress: &Arc<Progress>) -> Self {
        self.progress = Arc::clone(progress);
        self
    }

    fn prepared(self) -> Result<(Prepared, Arc<Progress>)> {
        let plan = MapPlan::of(&self.question)?;
        Ok((plan.prepare(self.scene, &UavsFound::of(&self.uavs)?, PartOf::default())?, self.progress))
    }

    fn make(self, each: impl FnMut(&SiteCoverage)) -> Result<Coverages> {
        let held = Held { keeps_masks: self.keeps_masks, ..Held::default() };
        let (prepared, progress) = self.prepared()?;
        prepared.run(held, &progress, |_| {}, each)
    }
}

skyshed_request::holds! {
    CoverageRequest<Answer> where Answer: question.sight.receiver Receiver, question.sight.range Range,
    question.sight.antenna Antenna, question.sight.earth Earth, question.heights HeightErrors, question.map MapOptions
}

impl CoverageRequest<Coverage> {
    /// Makes the map.
    ///
    /// # Errors
    /// E2xx if the UAV cannot be there (inside a building, below the ground, outside of what the
    /// engines can hold); E113 for numbers out of range; E118 if the method cannot decide the
    /// scene; E501 if the map does not fit in memory.
    pub fn run(mut self) -> Result<Coverage> {
        self.keeps_masks = true;
        self.make(|_| {}).map(Coverage)
    }
}

impl CoverageRequest<Coverages> {
    /// Keeps the mask of each UAV, a byte for each cell. Otherwise [`Coverages::mask`] is `None`:
    /// only counts and the union are kept.
    pub fn keep_masks(mut self) -> Self {
        self.keeps_masks = true;
        self
    }

    /// Makes the maps, several at once.
    ///
    /// # Errors
    /// As for one UAV; E207 if two UAVs have one name.
    pub fn run(self) -> Result<Coverages> {
        self.make(|_| {})
    }

    /// Counts the receivers in range of each UAV and the ones in line of sight, without a mask. All
    /// other counts of a tally stay 0.
    ///
    /// ```
    /// use skyshed::prelude::*;
    ///
    /// let city = Scene::options().size(150.0).open("itu:urban")?;
    /// let uavs = [40.0, 110.0].map(|x| Uav::new(x, 75.0, Height::agl(60.0)));
    /// let counts = city.coverages(uavs.clone()).run_counts()?;
    /// let maps = city.coverages(uavs).run()?;
    /// assert!(counts.iter().zip(maps.sites()).all(|(c, site)| c.p_los() == site.tally.p_los()));
    /// # Ok::<(), skyshed::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`CoverageRequest::run`].
    pub fn run_counts(self) -> Result<Vec<Tally>> {
        let (prepared, progress) = self.prepared()?;
        prepared.count(&progress)
    }

    /// Makes the maps and passes each UAV's mask to `each` as it is made, with the UAV's index. No
    /// mask is kept.
    ///
    /// # Errors
    /// As [`CoverageRequest::run`].
    pub fn run_each(self, mut each: impl FnMut(usize, &[u8])) -> Result<Coverages> {
        let mut k = 0;
        self.make(|site| {
            each(k, &site.mask);
            k += 1;
        })
    }
}
