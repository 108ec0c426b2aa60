//! How far heights of buildings may be off, as it is asked for and told.

use schemars::JsonSchema;
use serde::Serialize;
use skyshed_request::HeightErrors;

use crate::coverage::{
    self, HoversOver, MapOptions, Mapper, OwnErrors, RedrawnCounts, RedrawnHeights, SiteCoverage, Uav,
    check_height_error,
};
use crate::error::{Error, Result};
use crate::height_field::HeightField;
use crate::progress::Progress;
use crate::quantity::{meters, tidy};

/// Times that heights are redrawn for an interval of P_LoS.
const DRAWS: u32 = 200;
/// What they are drawn from.
const SEED: u64 = 1;
/// Standard deviations that the layer `sure` allows for, unless another number is set.
const SIGMA: f64 = 2.0;
/// How many of the redrawn maps an interval holds.
const PART: f64 = 0.95;

/// Standard deviations of errors of heights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HeightErrorsPlan {
    /// Of each building alone \[m\].
    pub(crate) own_m: f64,
    /// Of what all share \[m\].
    pub(crate) shared_m: f64,
    /// Of how many of them the layer `sure` is.
    pub(crate) sigma: f64,
    /// Whether buildings of the scene tell their own.
    pub(crate) by_building: bool,
}

impl Default for HeightErrorsPlan {
    /// None.
    fn default() -> Self {
        HeightErrorsPlan { own_m: 0.0, shared_m: 0.0, sigma: SIGMA, by_building: false }
    }
}

impl HeightErrorsPlan {
    /// Checks errors of heights and a number of their standard deviations, and fills in the defaults.
    ///
    /// # Errors
    /// E113 for a number that is no length.
    pub(crate) fn of(errors: &HeightErrors, sigma: Option<f64>) -> Result<Self> {
        let (own_m, shared_m) = (errors.height_error.unwrap_or(0.0), errors.height_bias.unwrap_or(0.0));
        let sigma = sigma.unwrap_or(SIGMA);
        check_height_error("the error of heights", own_m)?;
        check_height_error("the bias of heights", shared_m)?;
        if !(0.0..=10.0).contains(&sigma) {
            return Err(Error::number("the number of standard deviations", sigma, "0 to 10"));
        }
        Ok(HeightErrorsPlan { own_m, shared_m, sigma, by_building: false })
    }

    /// Whether heights may be off at all.
    pub(crate) fn are_any(self) -> bool {
        self.own_m > 0.0 || self.shared_m > 0.0 || self.by_building
    }

    /// These, and those that buildings of a scene tell.
    #[must_use]
    pub(crate) fn over(self, field: &HeightField) -> Self {
        HeightErrorsPlan { by_building: field.building_errors().is_some(), ..self }
    }

    /// The options of a map of a scene, with these errors.
    #[must_use]
    pub(crate) fn on(self, field: &HeightField, options: MapOptions) -> MapOptions {
        MapOptions { height_errors: self.errors(field), sigma: self.sigma, ..options }
    }

    /// Those of a scene; buildings that tell none have that which is told for all.
    fn errors(self, field: &HeightField) -> coverage::HeightErrors {
        let own = match field.building_errors().filter(|_| self.by_building) {
            Some(of) => OwnErrors::ByBuilding(of.iter().map(|steps| steps.map_or(self.own_m, meters)).collect()),
            None => OwnErrors::Same(self.own_m),
        };
        coverage::HeightErrors { own, shared_m: self.shared_m }
    }

    /// What captions say of them; nothing without any.
    pub(crate) fn in_words(self) -> Option<String> {
        let own = match (self.by_building, self.own_m > 0.0) {
            (true, _) => Some("what each tells".to_string()),
            (false, is_any) => is_any.then(|| format!("{} m each", tidy(self.own_m))),
        };
        let shared = (self.shared_m > 0.0).then(|| format!("{} m in common", tidy(self.shared_m)));
        let words: Vec<String> = own.into_iter().chain(shared).collect();
        (!words.is_empty()).then(|| format!("Heights of buildings off by {} (standard deviation)", words.join(" and ")))
    }

    /// What each of some UAVs sees with heights redrawn; nothing without errors.
    pub(crate) fn redrawn(
        self,
        mapper: &Mapper<'_>,
        uavs: &[Uav],
        progress: &Progress,
    ) -> Result<Option<RedrawnCounts>> {
        // Numbering the blocks of a raster passes all its cells: only where errors were given.
        if !self.are_any() {
            return Ok(None);
        }
        let Some(heights) = RedrawnHeights::of(mapper.field(), &self.errors(mapper.field()), None, SEED) else {
            return Ok(None);
        };
        Ok(Some(mapper.redrawn(uavs, &heights, DRAWS, progress.control())?))
    }

    /// Between which shares P_LoS of each of some UAVs is, with heights redrawn; nothing without errors, and none of a UAV without receivers.
    pub(crate) fn intervals(
        self,
        mapper: &Mapper<'_>,
        uavs: &[Uav],
        progress: &Progress,
    ) -> Result<Vec<Option<IntervalFacts>>> {
        let Some(counts) = self.redrawn(mapper, uavs, progress)? else { return Ok(Vec::new()) };
        let of = |uav: usize| {
            let (low, high) = counts.interval(uav, PART);
            let has_p_los = counts.receivers[uav] > 0 && uavs[uav].placement != HoversOver::Nodata;
            has_p_los.then_some(IntervalFacts { p_los_low: low, p_los_high: high })
        };
        Ok((0..uavs.len()).map(of).collect())
    }

    /// As documents tell them; nothing without any.
    pub(crate) fn document(self) -> Option<HeightErrorsDocument> {
        let HeightErrorsPlan { own_m, shared_m, sigma, by_building } = self;
        self.are_any().then_some(HeightErrorsDocument { own_m, by_building, shared_m, sigma, draws: DRAWS, part: PART })
    }
}

/// How far heights of buildings may be off, and what was made of it.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(crate) struct HeightErrorsDocument {
    /// Standard deviation of the error of each building alone [m].
    own_m: f64,
    /// Whether buildings tell their own, and that is for those that tell none.
    by_building: bool,
    /// Standard deviation of the error that all buildings share [m].
    shared_m: f64,
    /// Of how many standard deviations the layer `sure` is.
    sigma: f64,
    /// Times that heights were redrawn for intervals of P_LoS.
    draws: u32,
    /// How many of the redrawn maps an interval holds, as a part of all.
    part: f64,
}

/// Between which shares P_LoS is with heights redrawn.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub(crate) struct IntervalFacts {
    /// Lower end of the interval of P_LoS.
    p_los_low: f64,
    /// Upper end of the interval of P_LoS.
    p_los_high: f64,
}

impl IntervalFacts {
    /// The interval in words.
    pub(crate) fn in_words(&self) -> String {
        format!("{:.4} to {:.4} in 95 % of redrawn maps", self.p_los_low, self.p_los_high)
    }

    pub(crate) fn low(&self) -> f64 {
        self.p_los_low
    }

    pub(crate) fn high(&self) -> f64 {
        self.p_los_high
    }
}

/// Between which numbers the difference of two P_LoS is with heights redrawn, the same ones for both.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub(crate) struct HeightsOfDifference {
    /// Lower end of the interval of the difference of P_LoS with heights redrawn.
    heights_low: f64,
    /// Upper end of the same.
    heights_high: f64,
    /// Whether it does not hold 0: heights do not explain the difference.
    exceeds_heights: bool,
}

impl HeightsOfDifference {
    /// That of a pair of UAVs, by their places among those that were redrawn; nothing if one has no receiver.
    pub(crate) fn of(counts: &RedrawnCounts, pair: (usize, usize)) -> Option<Self> {
        if counts.receivers[pair.0].min(counts.receivers[pair.1]) == 0 {
            return None;
        }
        let (low, high) = counts.interval_of_difference(pair, PART);
        let exceeds_heights = low > 0.0 || high < 0.0;
        Some(HeightsOfDifference { heights_low: low, heights_high: high, exceeds_heights })
    }

    pub(crate) fn low(&self) -> f64 {
        self.heights_low
    }

    pub(crate) fn high(&self) -> f64 {
        self.heights_high
    }

    pub(crate) fn exceeds(&self) -> bool {
        self.exceeds_heights
    }

    /// What a sentence on a difference says of it.
    pub(crate) fn in_words(&self) -> &'static str {
        if self.exceeds_heights {
            "it is larger than errors of heights allow"
        } else {
            "it is smaller than errors of heights allow"
        }
    }
}

/// What hangs on the heights of buildings, for one UAV.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub(crate) struct UncertainFacts {
    /// With the layer `sure`: receivers that are never in line of sight, that surely are, and that may be.
    #[serde(skip_serializing_if = "Option::is_none")]
    sure: Option<SureFacts>,
    /// With the layer `p-los`: the mean of the probabilities of all receivers, which is the mean of P_LoS.
    #[serde(skip_serializing_if = "Option::is_none")]
    p_los_mean: Option<f64>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub(crate) interval: Option<IntervalFacts>,
}

/// Receivers by what is sure of them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub(crate) struct SureFacts {
    /// Never in line of sight.
    never: u64,
    /// Surely in line of sight.
    surely: u64,
    /// Perhaps in line of sight.
    possibly: u64,
}

impl UncertainFacts {
    /// The facts of the layers of a coverage; nothing without any.
    pub(crate) fn of(site: &SiteCoverage) -> Option<UncertainFacts> {
        let count = |cells: &[f32], value: f32| cells.iter().filter(|v| v.total_cmp(&value).is_eq()).count() as u64;
        let sure = site.sure.as_deref().map(|cells| SureFacts {
            never: count(cells, 0.0),
            surely: count(cells, 1.0),
            possibly: count(cells, 2.0),
        });
        let p_los_mean = site.p_los.as_deref().filter(|_| !site.tally.is_over_nodata).and_then(|cells| {
            let known = cells.iter().filter(|p| !p.is_nan());
            let (sum, n) = known.fold((0.0, 0_u32), |(sum, n), p| (sum + f64::from(*p), n + 1));
            (n > 0).then(|| sum / f64::from(n))
        });
        (sure.is_some() || p_los_mean.is_some()).then_some(UncertainFacts { sure, p_los_mean, interval: None })
    }

    /// The facts with an interval.
    pub(crate) fn with(of: Option<UncertainFacts>, interval: Option<IntervalFacts>) -> Option<UncertainFacts> {
        let none = UncertainFacts { sure: None, p_los_mean: None, interval: None };
        match interval {
            None => of,
            Some(_) => Some(UncertainFacts { interval, ..of.unwrap_or(none) }),
        }
    }
}
