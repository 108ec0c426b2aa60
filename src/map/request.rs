//! What a caller of the library asks of a map, setting by setting: it becomes a plan.

use std::marker::PhantomData;
use std::sync::Arc;

use super::coverages::{Coverage, Coverages};
use super::plan::{Held, MapPlan, PartOf, Prepared};
use crate::city::Antenna;
use crate::coverage::{SiteCoverage, Tally};
use crate::error::Result;
use crate::export::Layer;
use crate::height_errors::AskedErrors;
use crate::los::MethodChoice;
use crate::progress::Progress;
use crate::scene::Scene;
use crate::sight::{AskedSight, Receivers};
use crate::uav::{Uav, UavsFound};

impl Scene {
    /// Asks what one UAV sees.
    pub fn coverage(&self, uav: Uav) -> CoverageRequest<Coverage> {
        CoverageRequest::new(self, vec![uav])
    }

    /// Asks what each of some UAVs sees, and all of them together.
    ///
    /// ```
    /// use skyshed::{Height, Scene, Uav};
    ///
    /// let city = Scene::options().size_m(200.0).open("itu:urban")?;
    /// let uavs = [40.0, 160.0].map(|x| Uav::new(x, 100.0, Height::agl(80.0)));
    /// let seen = city.coverages(uavs).radius_m(150.0).run()?;
    /// let best = seen.sites().iter().map(|site| site.tally.los).max().unwrap_or(0);
    /// assert!(seen.union().los >= best);
    /// # Ok::<(), skyshed::Error>(())
    /// ```
    pub fn coverages(&self, uavs: impl IntoIterator<Item = Uav>) -> CoverageRequest<Coverages> {
        CoverageRequest::new(self, uavs.into_iter().collect())
    }
}

/// What is asked of a map: for whom, how far, which layers. `Answer` is [`Coverage`] of one UAV, [`Coverages`] of many.
#[derive(Debug, Clone)]
#[must_use = "nothing is made before `run`"]
pub struct CoverageRequest<Answer> {
    scene: Scene,
    uavs: Vec<Uav>,
    asked: AskedSight,
    heights: AskedErrors,
    layers: Vec<Layer>,
    tolerance: Option<f64>,
    tells_zones: bool,
    keeps_masks: bool,
    progress: Arc<Progress>,
    answer: PhantomData<fn() -> Answer>,
}

impl<Answer> CoverageRequest<Answer> {
    fn new(scene: &Scene, uavs: Vec<Uav>) -> Self {
        CoverageRequest {
            scene: scene.clone(),
            uavs,
            asked: AskedSight::default(),
            heights: AskedErrors::default(),
            layers: vec![Layer::Los],
            tolerance: None,
            tells_zones: false,
            keeps_masks: false,
            progress: Arc::default(),
            answer: PhantomData,
        }
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

    /// The layers to make. Default: line of sight alone. Pictures show the first.
    pub fn layers(mut self, layers: impl IntoIterator<Item = Layer>) -> Self {
        self.layers = layers.into_iter().collect();
        self
    }

    /// Standard deviations of the errors of heights \[m\]: of each building alone, and of what all share. Default: none. P_LoS has an interval then.
    pub fn height_errors_m(mut self, own_m: f64, shared_m: f64) -> Self {
        (self.heights.own_m, self.heights.shared_m) = (own_m, shared_m);
        self
    }

    /// Of how many of these standard deviations the layer [`Layer::Sure`] is. Default: 2.
    pub fn sigma(mut self, sigma: f64) -> Self {
        self.heights.sigma = sigma;
        self
    }

    /// The engine. Default: the fastest exact one for the scene.
    pub fn method(mut self, method: MethodChoice) -> Self {
        self.asked.method = method;
        self
    }

    /// How far P_LoS of any UAV may be off, above 0 and below 1: the map is made on the coarsest cells for which that is so
    /// with 99 % confidence.
    pub fn tolerance(mut self, p_los: f64) -> Self {
        self.tolerance = Some(p_los);
        self
    }

    /// Counts by zone too, which cost as much as a map.
    pub fn zones(mut self) -> Self {
        self.tells_zones = true;
        self
    }

    /// A token that tells how far the map is, and can stop it from another thread.
    pub fn progress(mut self, progress: &Arc<Progress>) -> Self {
        self.progress = Arc::clone(progress);
        self
    }

    fn prepared(self) -> Result<(Prepared, Arc<Progress>)> {
        let CoverageRequest { asked, heights, layers, tolerance, tells_zones, .. } = self;
        let (sight, heights) = (asked.checked()?, heights.checked()?);
        let plan = MapPlan { sight, heights, layers, tolerance, tells_zones };
        Ok((plan.prepare(self.scene, &UavsFound::of(&self.uavs)?, PartOf::default())?, self.progress))
    }

    fn make(self, each: impl FnMut(&SiteCoverage)) -> Result<Coverages> {
        let held = Held { keeps_masks: self.keeps_masks, ..Held::default() };
        let (prepared, progress) = self.prepared()?;
        prepared.run(held, &progress, |_| {}, each)
    }
}

impl CoverageRequest<Coverage> {
    /// Makes the map.
    ///
    /// # Errors
    /// E2xx if the UAV cannot be there (inside a building, below the ground, outside of what the engines can hold);
    /// E113 for
    /// numbers out of range; E118 if the method cannot decide the scene; E501 if the map does not fit in memory.
    pub fn run(mut self) -> Result<Coverage> {
        self.keeps_masks = true;
        self.make(|_| {}).map(Coverage)
    }
}

impl CoverageRequest<Coverages> {
    /// Keeps the mask of each UAV, a byte for each cell. Without it `Coverages::mask` is `None`: only counts and what
    /// all see
    /// together are held.
    pub fn keep_masks(mut self) -> Self {
        self.keeps_masks = true;
        self
    }

    /// Makes the maps, several at once.
    ///
    /// # Errors
    /// As that of one UAV; E207 if two UAVs have one name.
    pub fn run(self) -> Result<Coverages> {
        self.make(|_| {})
    }

    /// Counts what each UAV sees and makes no mask: receivers in range, and those of them in line of sight. The other counts of a tally stay 0.
    ///
    /// ```
    /// use skyshed::{Height, Scene, Uav};
    ///
    /// let city = Scene::options().size_m(150.0).open("itu:urban")?;
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

    /// Makes the maps and hands over each UAV's mask as it is made, with the UAV's index; none is kept.
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
