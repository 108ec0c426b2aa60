//! Errors of building heights: as requested, in documents, and in captions.

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

/// Number of redrawn maps for an interval of P_LoS.
const DRAWS: u32 = 200;
/// Seed of the redrawn heights.
const SEED: u64 = 1;
/// Default number of standard deviations that the layer `sure` allows for.
const SIGMA: f64 = 2.0;
/// Share of the redrawn maps that an interval holds.
const PART: f64 = 0.95;

/// Standard deviations of errors of building heights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HeightErrorsPlan {
    /// Standard deviation of the error of each building alone \[m\].
    pub(crate) own_m: f64,
    /// Standard deviation of the error that all buildings share \[m\].
    pub(crate) shared_m: f64,
    /// Number of standard deviations that the layer `sure` allows for.
    pub(crate) sigma: f64,
    /// `true` if buildings of the scene have errors of their own.
    pub(crate) by_building: bool,
}

impl Default for HeightErrorsPlan {
    /// Returns no errors.
    fn default() -> Self {
        HeightErrorsPlan { own_m: 0.0, shared_m: 0.0, sigma: SIGMA, by_building: false }
    }
}

impl HeightErrorsPlan {
    /// Checks errors of heights and a number of their standard deviations, and fills in the
    /// defaults.
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

    /// Returns `true` if heights may be off at all.
    pub(crate) fn are_any(self) -> bool {
        self.own_m > 0.0 || self.shared_m > 0.0 || self.by_building
    }

    /// Adds the errors that buildings of a scene have themselves.
    #[must_use]
    pub(crate) fn over(self, field: &HeightField) -> Self {
        HeightErrorsPlan { by_building: field.building_errors().is_some(), ..self }
    }

    /// Returns the options of a map of a scene, with these errors.
    #[must_use]
    pub(crate) fn on(self, field: &HeightField, options: MapOptions) -> MapOptions {
        MapOptions { height_errors: self.errors(field), sigma: self.sigma, ..options }
    }

    /// Returns the errors of a scene. Buildings without an error of their own get the common one.
    fn errors(self, field: &HeightField) -> coverage::HeightErrors {
        let own = match field.building_errors().filter(|_| self.by_building) {
            Some(of) => OwnErrors::ByBuilding(of.iter().map(|steps| steps.map_or(self.own_m, meters)).collect()),
            None => OwnErrors::Same(self.own_m),
        };
        coverage::HeightErrors { own, shared_m: self.shared_m }
    }

    /// Returns the errors in words, for captions; `None` without errors.
    pub(crate) fn in_words(self) -> Option<String> {
        let own = match (self.by_building, self.own_m > 0.0) {
            (true, _) => Some("what each tells".to_string()),
            (false, is_any) => is_any.then(|| format!("{} m each", tidy(self.own_m))),
        };
        let shared = (self.shared_m > 0.0).then(|| format!("{} m in common", tidy(self.shared_m)));
        let words: Vec<String> = own.into_iter().chain(shared).collect();
        (!words.is_empty()).then(|| format!("Heights of buildings off by {} (standard deviation)", words.join(" and ")))
    }

    /// Counts the receivers that each UAV sees with heights redrawn; `None` without errors.
    pub(crate) fn redrawn(
        self,
        mapper: &Mapper<'_>,
        uavs: &[Uav],
        progress: &Progress,
    ) -> Result<Option<RedrawnCounts>> {
        // Numbering the blocks of a raster visits all its cells, so it is done only where errors
        // are set.
        if !self.are_any() {
            return Ok(None);
        }
        let Some(heights) = RedrawnHeights::of(mapper.field(), &self.errors(mapper.field()), None, SEED) else {
            return Ok(None);
        };
        Ok(Some(mapper.redrawn(uavs, &heights, DRAWS, progress.control())?))
    }

    /// Returns the interval of P_LoS of each UAV with heights redrawn. The list is empty without
    /// errors, and holds `None` for a UAV without P_LoS.
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

    /// Returns the errors for documents; `None` without errors.
    pub(crate) fn document(self) -> Option<HeightErrorsDocument> {
        let HeightErrorsPlan { own_m, shared_m, sigma, by_building } = self;
        self.are_any().then_some(HeightErrorsDocument { own_m, by_building, shared_m, sigma, draws: DRAWS, part: PART })
    }
}

/// Errors of building heights, and their use.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(crate) struct HeightErrorsDocument {
    /// Standard deviation of the error of each building alone [m].
    own_m: f64,
    /// true if buildings have errors of their own; the others have the common one.
    by_building: bool,
    /// Standard deviation of the error that all buildings share [m].
    shared_m: f64,
    /// Number of standard deviations that the layer `sure` allows for.
    sigma: f64,
    /// Number of redrawn maps for intervals of P_LoS.
    draws: u32,
    /// Share of the redrawn maps that an interval holds.
    part: f64,
}

/// Interval of P_LoS with heights redrawn.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub(crate) struct IntervalFacts {
    /// Lower end of the interval of P_LoS.
    p_los_low: f64,
    /// Upper end of the interval of P_LoS.
    p_los_high: f64,
}

impl IntervalFacts {
    /// Returns the interval in words.
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

/// Interval of the difference of two P_LoS with heights redrawn, the same heights for both.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub(crate) struct HeightsOfDifference {
    /// Lower end of the interval of the difference of P_LoS with heights redrawn.
    heights_low: f64,
    /// Upper end of the interval of the difference of P_LoS with heights redrawn.
    heights_high: f64,
    /// true if the interval excludes 0: errors of heights do not explain the difference.
    exceeds_heights: bool,
}

impl HeightsOfDifference {
    /// Returns the interval of a pair of UAVs, by their indices among the redrawn ones. `None` if
    /// one has no receiver.
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

    /// Returns the clause on heights for a sentence about the difference.
    pub(crate) fn in_words(&self) -> &'static str {
        if self.exceeds_heights {
            "it is larger than errors of heights allow"
        } else {
            "it is smaller than errors of heights allow"
        }
    }
}

/// Effect of errors of building heights on the map of one UAV.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub(crate) struct UncertainFacts {
    /// For the layer `sure`: receivers never, surely, and perhaps in line of sight.
    #[serde(skip_serializing_if = "Option::is_none")]
    sure: Option<SureFacts>,
    /// For the layer `p-los`: mean probability over all receivers, which is the mean of P_LoS.
    #[serde(skip_serializing_if = "Option::is_none")]
    p_los_mean: Option<f64>,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub(crate) interval: Option<IntervalFacts>,
}

/// Receivers by the certainty of their answer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub(crate) struct SureFacts {
    /// Receivers never in line of sight.
    never: u64,
    /// Receivers surely in line of sight.
    surely: u64,
    /// Receivers perhaps in line of sight.
    possibly: u64,
}

impl UncertainFacts {
    /// Returns the facts of the layers of a coverage; `None` without such layers.
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

    /// Adds an interval to the facts.
    pub(crate) fn with(of: Option<UncertainFacts>, interval: Option<IntervalFacts>) -> Option<UncertainFacts> {
        let none = UncertainFacts { sure: None, p_los_mean: None, interval: None };
        match interval {
            None => of,
            Some(_) => Some(UncertainFacts { interval, ..of.unwrap_or(none) }),
        }
    }
}
