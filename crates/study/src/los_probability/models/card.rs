//! Input and output of a model, its card, and the checks that several models share.

use std::fmt;

use super::super::setting::{Reach, Setting};
use crate::city::BuiltUp;
use crate::quantity::tidy;

/// Link as the models know it. Nothing is derived: each model uses those of its angle, distance and
/// heights that are in its formula.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelLink {
    /// Built-up parameters of the city.
    pub built_up: BuiltUp,
    /// Height of the UAV above the ground \[m\], ≥ 0.
    pub uav_height_m: f64,
    /// Height of the receiver above the ground \[m\], ≥ 0.
    pub rx_height_m: f64,
    /// Elevation angle of the UAV seen from the receiver \[deg above the horizon\], −90 to 90.
    pub theta_deg: f64,
    /// Ground distance between UAV and receiver \[m\], ≥ 0.
    pub distance_m: f64,
    /// Azimuth \[deg\], 0 straight across the street; `None` for the mean over all azimuths.
    pub phi_deg: Option<f64>,
}

impl ModelLink {
    /// Returns the link of a setting.
    ///
    /// # Errors
    /// The reason why there is none: users over an area have no single angle and distance.
    pub fn of(setting: &Setting) -> Result<ModelLink, &'static str> {
        let Reach::Ring { distance_m, theta_deg } = setting.reach else {
            return Err("it is a function of one angle or distance, not of an area");
        };
        Ok(ModelLink {
            built_up: setting.built_up,
            uav_height_m: setting.uav_height_m,
            rx_height_m: setting.rx_height_m,
            theta_deg,
            distance_m,
            phi_deg: setting.phi_deg,
        })
    }
}

/// Value of a model for a link.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelValue {
    /// Probability of line of sight, 0 to 1.
    pub p_los: f64,
    /// Reason to use the value with care: the model was not made for such a link.
    pub caution: Option<String>,
}

impl ModelValue {
    /// Makes a value with its reasons for care, and clamps rounding errors to 0 and 1.
    pub(super) fn new<const N: usize>(p_los: f64, cautions: [Option<String>; N]) -> Self {
        let cautions: Vec<String> = cautions.into_iter().flatten().collect();
        let caution = (!cautions.is_empty()).then(|| cautions.join("; "));
        ModelValue { p_los: p_los.clamp(0.0, 1.0), caution }
    }
}

/// Refusal of a link outside of a model's domain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutsideDomain {
    /// Value that was found, and the wanted one.
    pub reason: String,
}

impl fmt::Display for OutsideDomain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.reason)
    }
}

impl std::error::Error for OutsideDomain {}

pub(super) fn outside<T>(reason: String) -> Result<T, OutsideDomain> {
    Err(OutsideDomain { reason })
}

/// Description and function of one model.
pub(super) struct Card {
    pub(super) id: &'static str,
    pub(super) name: &'static str,
    pub(super) source: &'static str,
    pub(super) domain: &'static str,
    pub(super) about: &'static str,
    pub(super) p_los: fn(&ModelLink) -> Result<ModelValue, OutsideDomain>,
}

/// Checks the conditions that hold for every model.
pub(super) fn check(link: &ModelLink) -> Result<(), OutsideDomain> {
    for (name, v) in [("the UAV's height", link.uav_height_m), ("the receiver's height", link.rx_height_m)] {
        if !(v.is_finite() && v >= 0.0) {
            return outside(format!("{name} is {v} m, wanted at least 0 m above the ground"));
        }
    }
    if !(link.distance_m.is_finite() && link.distance_m >= 0.0) {
        return outside(format!("the ground distance is {} m, wanted at least 0 m", link.distance_m));
    }
    theta_within(link, -90.0, 90.0)?;
    if let Some(phi) = link.phi_deg.filter(|phi| !phi.is_finite()) {
        return outside(format!("the azimuth is {phi}°, wanted a finite number"));
    }
    let BuiltUp { built_up_ratio, buildings_per_km2, height_scale } = link.built_up;
    let positive = |v: f64| v > 0.0 && v.is_finite();
    if !(positive(built_up_ratio) && built_up_ratio < 1.0 && positive(buildings_per_km2) && positive(height_scale)) {
        return outside(format!("the city has {}, wanted 0 < α < 1, β > 0, γ > 0", link.built_up));
    }
    Ok(())
}

pub(super) fn theta_within(link: &ModelLink, low: f64, high: f64) -> Result<(), OutsideDomain> {
    if (low..=high).contains(&link.theta_deg) {
        return Ok(());
    }
    outside(format!("the elevation angle is {}°, wanted {low}° to {high}°", link.theta_deg))
}

/// Returns the height of the UAV above the receiver \[m\], > 0.
pub(super) fn height_above_receiver(link: &ModelLink) -> Result<f64, OutsideDomain> {
    let h = link.uav_height_m - link.rx_height_m;
    if h > 0.0 {
        return Ok(h);
    }
    outside(format!(
        "the UAV is at {} m, wanted above the receiver, which is at {} m",
        link.uav_height_m, link.rx_height_m
    ))
}

/// Returns αβ \[1/km²\]; [`super::itu`] has √(αβ) buildings per kilometer.
pub(super) fn alpha_beta(city: &BuiltUp) -> f64 {
    city.built_up_ratio * city.buildings_per_km2
}

/// Environment of published fits and tables, one of four.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Environment {
    Suburban,
    Urban,
    DenseUrban,
    HighRise,
}

impl Environment {
    pub(super) const ALL: [(Environment, &'static str); 4] = [
        (Environment::Suburban, "suburban"),
        (Environment::Urban, "urban"),
        (Environment::DenseUrban, "dense-urban"),
        (Environment::HighRise, "high-rise"),
    ];

    /// Returns the environment with exactly these built-up parameters. A fit does not cover cities
    /// between two environments.
    pub(super) fn of(city: &BuiltUp) -> Result<Self, OutsideDomain> {
        let known = Self::ALL.into_iter().find(|(_, name)| BuiltUp::named(name).as_ref() == Some(city));
        let Some((environment, _)) = known else {
            return outside(format!("the city has {city}, which is none of the environments of the model"));
        };
        Ok(environment)
    }
}

/// Highest receiver on a street \[m\]: one story, the step of h_UT = 3(n − 1) + 1.5 m from floor to
/// floor (3GPP TR 36.873, Table 6-1).
const STREET_LEVEL_M: f64 = 3.0;

/// Returns the caution of models of receivers on the street, if it applies.
pub(super) fn off_the_street(link: &ModelLink) -> Option<String> {
    (link.rx_height_m > STREET_LEVEL_M)
        .then(|| format!("made for receivers at street level, the receiver is at {} m", tidy(link.rx_height_m)))
}

/// Lowest high-altitude platform \[m\] (3GPP TR 38.811, section 4.1: 8 km to 50 km).
const LOWEST_PLATFORM_M: f64 = 8000.0;

/// Returns the caution of models of high-altitude platforms, if it applies.
pub(super) fn below_platforms(link: &ModelLink) -> Option<String> {
    (link.uav_height_m < LOWEST_PLATFORM_M)
        .then(|| format!("made for platforms from 8 km up, the UAV is at {} m", tidy(link.uav_height_m)))
}

/// Returns the caution of models with a base station of height `height_m` \[m\] whose user is the
/// UAV, if it applies.
pub(super) fn not_a_base_station(link: &ModelLink, height_m: f64) -> Option<String> {
    (link.rx_height_m <= STREET_LEVEL_M).then(|| {
        format!(
            "made for a base station at {height_m} m, the receiver is at street level, {} m",
            tidy(link.rx_height_m)
        )
    })
}
