//! Published models of the probability of line of sight (P_LoS): sources, domains and traps.
//!
//! The models serve for comparison and decide nothing. A model knows a city by three numbers
//! ([`crate::city::BuiltUp`]) or by a name, and a link by a few more ([`ModelLink`]). Values of
//! models differ in meaning:
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
//! A model refuses links outside of its domain ([`OutsideDomain`]). If it has a value but was not
//! made for the link, the value carries a caution. All values are computed with the functions of
//! the crate `libm`, so that they are equal on every machine.
//!
//! One model is missing on purpose: the closed form of I. Mohammed, I. B. Collings and S. V. Hanly.
//! Its paper, "Line of sight probability prediction for UAV communication", IEEE ICC Workshops
//! 2021, has no public formula to check. A [`UserCurve`], read from a table of its values, can
//! replace it, and [`mohammed2023`] is its authors' later model.
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
//! # Ok::<(), skyshed_study::Error>(())
//! ```

pub mod alhourani2014;
mod card;
pub mod holis2008;
pub mod itu;
pub mod kang2019;
pub mod mohammed2023;
pub mod saboor2024;
pub mod tr36777;
pub mod tr38811;
pub mod tr38901;
mod user_curve;

use card::{Card, check};
pub use card::{ModelLink, ModelValue, OutsideDomain};
pub use user_curve::{CurveAxis, UserCurve};

/// A published model of P_LoS.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Model {
    /// Step-wise product of Recommendation ITU-R P.1410: [`itu`].
    Itu,
    /// Sigmoid with parameters from the letter's polynomial: [`alhourani2014`].
    AlHourani2014,
    /// Sigmoid with the rounded parameters in general use: [`alhourani2014`].
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

    /// Returns the id on the command line and in tables, for example `alhourani2014-table`.
    pub fn id(self) -> &'static str {
        self.card().id
    }

    /// Returns the model with this id; upper and lower case, `-` and `_` are equal.
    pub fn from_id(id: &str) -> Option<Self> {
        let plain = |id: &str| id.trim().to_lowercase().replace('_', "-");
        let wanted = plain(id);
        Model::ALL.into_iter().find(|model| plain(model.id()) == wanted)
    }

    /// Returns a short name for legends.
    pub fn name(self) -> &'static str {
        self.card().name
    }

    /// Returns the publication, with equation or table if known.
    pub fn source(self) -> &'static str {
        self.card().source
    }

    /// Returns the links that have a value, and those that the model was made for; one sentence.
    pub fn domain(self) -> &'static str {
        self.card().domain
    }

    /// Returns the variables of the model, and those that its value is averaged over; one sentence.
    pub fn about(self) -> &'static str {
        self.card().about
    }

    /// Returns the probability of line of sight of a link.
    pub fn p_los(self, link: &ModelLink) -> Result<ModelValue, OutsideDomain> {
        check(link)?;
        (self.card().p_los)(link)
    }
}

#[cfg(test)]
mod tests;
