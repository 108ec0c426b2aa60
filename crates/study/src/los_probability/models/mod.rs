//! Published models of the probability of line of sight (P_LoS), each with its source, domain and traps.
//!
//! They are here to be compared with, not to decide anything: a model knows a city by three numbers
//! ([`BuiltUp`]) or by a name, and a link by a few more ([`ModelLink`]). They do not all answer the same question:
//!
//! | models | a function of | averaged over |
//! |---|---|---|
//! | [`itu`], [`kang2019`] | ground distance, heights, α, β, γ | nothing: buildings have no place, only a number per distance |
//! | [`mohammed2023`] | ground distance, heights, α, β, γ | outdoor receivers and azimuths |
//! | [`saboor2024`] | ground distance, heights, α, β, γ | receivers across one street, azimuth φ = 0 only |
//! | [`alhourani2014`] | elevation angle, αβ, γ or environment | nothing: a smooth fit to [`itu`] |
//! | [`holis2008`], [`tr38811`] | elevation angle, environment | receivers and azimuths |
//! | [`tr36777`], [`tr38901`] | ground distance, UAV height | a cell of a network: the UAV is the user of a base station |
//!
//! A model that is asked outside of its domain refuses ([`OutsideDomain`]); where it still has a value but was not made
//! for the link, the value carries a caution. All values are computed with the functions of the crate `libm`, so that
//! they are the same on every machine.
//!
//! One model is missing on purpose. The closed form of I. Mohammed, I. B. Collings and S. V. Hanly, "Line of sight
//! probability prediction for UAV communication", IEEE ICC Workshops 2021, has no public formula that could be checked;
//! a [`UserCurve`], read from a table of its values, takes its place, and [`mohammed2023`] is its authors' later model.
//!
//! # Examples
//!
//! ```
//! use skyshed_study::los_probability::models::{Model, ModelLink};
//! use skyshed_core::city::BuiltUp;
//!
//! let urban = BuiltUp::new(0.3, 500.0, 15.0)?;
//! let mut link = ModelLink {
//!     built_up: urban,
//!     uav_height_m: 100.0,
//!     rx_height_m: 0.0,
//!     theta_deg: 30.0,
//!     distance_m: 173.205081,
//!     phi_deg: None,
//! };
//! assert!((Model::Itu.p_los(&link).expect("urban").p_los - 0.750645).abs() < 1e-6);
//!
//! // The polynomial was fitted for far less dense cities than the center of Ghent.
//! link.built_up = BuiltUp::new(0.435, 4679.0, 8.8)?;
//! let refusal = Model::AlHourani2014.p_los(&link).expect_err("Ghent is outside");
//! assert!(refusal.to_string().contains("αβ = 2035"));
//! # Ok::<(), skyshed_core::Error>(())
//! ```

use std::fmt;

use super::setting::{Reach, Setting};
use crate::city::BuiltUp;
use crate::quantity::tidy;

pub mod alhourani2014;
pub mod holis2008;
pub mod itu;
pub mod kang2019;
pub mod mohammed2023;
pub mod saboor2024;
pub mod tr36777;
pub mod tr38811;
pub mod tr38901;
mod user_curve;

pub use user_curve::{CurveAxis, UserCurve};

/// A published model of P_LoS.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Model {
    /// Step-wise product of Recommendation ITU-R P.1410: [`itu`].
    Itu,
    /// Sigmoid with parameters from the letter's polynomial: [`alhourani2014`].
    AlHourani2014,
    /// Sigmoid with the rounded parameters in use everywhere: [`alhourani2014`].
    AlHourani2014Table,
    /// Elevation fit for high-altitude platforms: [`holis2008`].
    Holis2008,
    /// First-building closed form: [`mohammed2023`].
    Mohammed2023,
    /// Exponential of the continuous ITU product: [`kang2019`].
    Kang2019,
    /// Product of averages over a street, azimuth 0: [`saboor2024`].
    Saboor2024,
    /// Rural macro, aerial users: [`tr36777`].
    Tr36777RmaAv,
    /// Urban macro, aerial users: [`tr36777`].
    Tr36777UmaAv,
    /// Urban micro, aerial users: [`tr36777`].
    Tr36777UmiAv,
    /// Rural macro, users on the ground: [`tr38901`].
    Tr38901Rma,
    /// Urban macro, users on the ground: [`tr38901`].
    Tr38901Uma,
    /// Urban micro street canyon, users on the ground: [`tr38901`].
    Tr38901Umi,
    /// Table for non-terrestrial networks at the nearest ten degrees: [`tr38811`].
    Tr38811,
    /// Table for non-terrestrial networks, interpolated: [`tr38811`].
    Tr38811Linear,
}

/// One link as the models know it. Nothing is derived: the elevation angle, the distance and the heights are those of
/// one link, and each model takes of them what its formula names.
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
    /// Ground distance between the two \[m\], ≥ 0.
    pub distance_m: f64,
    /// Azimuth \[deg\], 0 straight across the street; `None` for the mean over all azimuths.
    pub phi_deg: Option<f64>,
}

impl ModelLink {
    /// The link of a setting.
    ///
    /// # Errors
    /// Why there is none: users over an area have no one angle and distance.
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

/// What a model says of a link.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelValue {
    /// Probability of line of sight, 0 to 1.
    pub p_los: f64,
    /// Why the value is to be taken with care: the link is not of the kind that the model was made for.
    pub caution: Option<String>,
}

impl ModelValue {
    /// A value and the reasons for care; what rounding put beyond 0 or 1 is brought back.
    fn new<const N: usize>(p_los: f64, cautions: [Option<String>; N]) -> Self {
        let cautions: Vec<String> = cautions.into_iter().flatten().collect();
        let caution = (!cautions.is_empty()).then(|| cautions.join("; "));
        ModelValue { p_los: p_los.clamp(0.0, 1.0), caution }
    }
}

/// A model was asked outside of its domain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OutsideDomain {
    /// What was found, and what was wanted.
    pub reason: String,
}

impl fmt::Display for OutsideDomain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.reason)
    }
}

impl std::error::Error for OutsideDomain {}

fn outside<T>(reason: String) -> Result<T, OutsideDomain> {
    Err(OutsideDomain { reason })
}

/// What a family's file tells of one model.
struct Card {
    id: &'static str,
    name: &'static str,
    source: &'static str,
    domain: &'static str,
    about: &'static str,
    p_los: fn(&ModelLink) -> Result<ModelValue, OutsideDomain>,
}

impl Model {
    /// Every model, in the order of tables and legends.
    pub const ALL: [Model; 15] = [
        Model::Itu,
        Model::AlHourani2014,
        Model::AlHourani2014Table,
        Model::Holis2008,
        Model::Mohammed2023,
        Model::Kang2019,
        Model::Saboor2024,
        Model::Tr36777RmaAv,
        Model::Tr36777UmaAv,
        Model::Tr36777UmiAv,
        Model::Tr38901Rma,
        Model::Tr38901Uma,
        Model::Tr38901Umi,
        Model::Tr38811,
        Model::Tr38811Linear,
    ];

    fn card(self) -> &'static Card {
        match self {
            Model::Itu => &itu::CARD,
            Model::AlHourani2014 => &alhourani2014::POLYNOMIAL,
            Model::AlHourani2014Table => &alhourani2014::TABLE,
            Model::Holis2008 => &holis2008::CARD,
            Model::Mohammed2023 => &mohammed2023::CARD,
            Model::Kang2019 => &kang2019::CARD,
            Model::Saboor2024 => &saboor2024::CARD,
            Model::Tr36777RmaAv => &tr36777::RMA_AV,
            Model::Tr36777UmaAv => &tr36777::UMA_AV,
            Model::Tr36777UmiAv => &tr36777::UMI_AV,
            Model::Tr38901Rma => &tr38901::RMA,
            Model::Tr38901Uma => &tr38901::UMA,
            Model::Tr38901Umi => &tr38901::UMI,
            Model::Tr38811 => &tr38811::NEAREST,
            Model::Tr38811Linear => &tr38811::LINEAR,
        }
    }

    /// The word for the model on the command line and in tables, for example `alhourani2014-table`.
    pub fn id(self) -> &'static str {
        self.card().id
    }

    /// The model with this id; upper and lower case, `-` and `_` are the same.
    pub fn from_id(id: &str) -> Option<Self> {
        let plain = |id: &str| id.trim().to_lowercase().replace('_', "-");
        let wanted = plain(id);
        Model::ALL.into_iter().find(|model| plain(model.id()) == wanted)
    }

    /// A short name for legends.
    pub fn name(self) -> &'static str {
        self.card().name
    }

    /// The publication, with equation or table where it is known.
    pub fn source(self) -> &'static str {
        self.card().source
    }

    /// For which links the model has a value, and for which of them it was made; one sentence.
    pub fn domain(self) -> &'static str {
        self.card().domain
    }

    /// Of what the model is a function, and what its value is averaged over; one sentence.
    pub fn about(self) -> &'static str {
        self.card().about
    }

    /// The probability of line of sight of a link.
    ///
    /// # Errors
    /// [`OutsideDomain`] where the model has no value: what was found and what was wanted.
    pub fn p_los(self, link: &ModelLink) -> Result<ModelValue, OutsideDomain> {
        check(link)?;
        (self.card().p_los)(link)
    }
}

/// What holds for every link of every model.
fn check(link: &ModelLink) -> Result<(), OutsideDomain> {
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

fn theta_within(link: &ModelLink, low: f64, high: f64) -> Result<(), OutsideDomain> {
    if (low..=high).contains(&link.theta_deg) {
        return Ok(());
    }
    outside(format!("the elevation angle is {}°, wanted {low}° to {high}°", link.theta_deg))
}

/// Height of the UAV above the receiver \[m\], > 0.
fn height_above_receiver(link: &ModelLink) -> Result<f64, OutsideDomain> {
    let h = link.uav_height_m - link.rx_height_m;
    if h > 0.0 {
        return Ok(h);
    }
    outside(format!(
        "the UAV is at {} m, wanted above the receiver, which is at {} m",
        link.uav_height_m, link.rx_height_m
    ))
}

/// αβ \[1/km²\], of which the square root is the number of buildings per kilometer in [`itu`].
fn alpha_beta(city: &BuiltUp) -> f64 {
    city.built_up_ratio * city.buildings_per_km2
}

/// One of the four environments that fits and tables are made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Environment {
    Suburban,
    Urban,
    DenseUrban,
    HighRise,
}

impl Environment {
    const ALL: [(Environment, &'static str); 4] = [
        (Environment::Suburban, "suburban"),
        (Environment::Urban, "urban"),
        (Environment::DenseUrban, "dense-urban"),
        (Environment::HighRise, "high-rise"),
    ];

    /// The environment with exactly these built-up parameters: a fit says nothing of cities between two of them.
    fn of(city: &BuiltUp) -> Result<Self, OutsideDomain> {
        let known = Self::ALL.into_iter().find(|(_, name)| BuiltUp::named(name).as_ref() == Some(city));
        let Some((environment, _)) = known else {
            return outside(format!("the city has {city}, wanted suburban, urban, dense-urban or high-rise"));
        };
        Ok(environment)
    }
}

/// The highest receiver that stands on a street \[m\]: one story, by which h_UT = 3(n − 1) + 1.5 m rises from floor to
/// floor (3GPP TR 36.873, Table 6-1).
const STREET_LEVEL_M: f64 = 3.0;

/// For models of receivers on the street.
fn off_the_street(link: &ModelLink) -> Option<String> {
    (link.rx_height_m > STREET_LEVEL_M)
        .then(|| format!("made for receivers at street level, the receiver is at {} m", tidy(link.rx_height_m)))
}

/// The lowest high-altitude platform \[m\] (3GPP TR 38.811, section 4.1: 8 km to 50 km).
const LOWEST_PLATFORM_M: f64 = 8000.0;

/// For models of high-altitude platforms.
fn below_platforms(link: &ModelLink) -> Option<String> {
    (link.uav_height_m < LOWEST_PLATFORM_M)
        .then(|| format!("made for platforms from 8 km up, the UAV is at {} m", tidy(link.uav_height_m)))
}

/// For models of the UAV as the user of a base station of this height \[m\].
fn not_a_base_station(link: &ModelLink, height_m: f64) -> Option<String> {
    (link.rx_height_m <= STREET_LEVEL_M).then(|| {
        format!(
            "made for a base station at {height_m} m, the receiver is at street level, {} m",
            tidy(link.rx_height_m)
        )
    })
}

#[cfg(test)]
mod tests;
