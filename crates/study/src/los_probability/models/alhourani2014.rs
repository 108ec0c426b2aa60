//! Al-Hourani, Kandeepan and Lardner 2014: a sigmoid of the elevation angle.
//!
//! ```text
//! P(θ) = 1 / (1 + a·exp(−b(θ − a))),   θ in degrees                             (5)
//! a, b = Σⱼ₌₀..₃ Σᵢ₌₀..₃₋ⱼ Cᵢⱼ (αβ)^i γ^j                                       (6)
//! ```
//!
//! It is a smooth fit to the product of [`itu`](super::itu) for four cities. The staircase of that
//! product depends less and less on the height as the height grows.
//!
//! Trap: the letter's tables of C label the columns i and the rows j, which together with (6) makes
//! the columns powers of αβ. That gives b < 0 for all four cities of the fit. With the *rows* as
//! powers of αβ and the columns as powers of γ, the tables give pairs in general use, which the
//! letter does not print: (4.88, 0.43), (9.61, 0.16), (12.08, 0.11), (27.23, 0.08). Both are here:
//! the polynomial, and the rounded pairs, which differ from it by up to 0.025 in P.
//!
//! The letter states no domain. a and b stay above 0 for αβ up to about 460 (γ = 8) or 275
//! (γ = 50). Beyond, b < 0 and the curve falls with the elevation angle, so such cities are
//! refused. The four cities of the fit have αβ from 75 to 150 and γ from 8 to 50. The sigmoid is
//! not 0 at 0° and does not reach 1 at 90° (0.85 for high-rise).

use super::card::{
    Card, Environment, ModelLink, ModelValue, OutsideDomain, alpha_beta, off_the_street, outside, theta_within,
};
use crate::city::BuiltUp;
use crate::quantity::tidy;

pub(super) const POLYNOMIAL: Card = Card {
    id: "alhourani2014",
    name: "Al-Hourani 2014",
    source: "A. Al-Hourani, S. Kandeepan and S. Lardner, Optimal LAP altitude for maximum coverage, IEEE Wireless \
             Commun. Lett. 3(6), 569–572, 2014, eqs. (5) and (6), the tables for a and b read with rows as \
             powers of αβ",
    domain: "Elevation angles from 0° to 90° and cities for which the polynomial gives a > 0 and b > 0; fitted to four \
             cities, and used with care for αβ outside 50 to 300 per km² or γ outside 8 to 50 m.",
    about: "A function of the elevation angle, αβ and γ, for receivers at street level; a smooth fit to the product of \
            ITU-R P.1410.",
    p_los: polynomial,
};

pub(super) const TABLE: Card = Card {
    id: "alhourani2014-table",
    name: "Al-Hourani 2014, rounded",
    source: "A. Al-Hourani, S. Kandeepan and S. Lardner, Optimal LAP altitude for maximum coverage, IEEE Wireless \
             Commun. Lett. 3(6), 569–572, 2014, eq. (5), with the values of eq. (6) rounded to two decimals, as they \
             are used in the literature",
    domain: "Elevation angles from 0° to 90° in the suburban, urban, dense-urban or high-rise environment.",
    about: "A function of the elevation angle for each of four environments, for receivers at street level; a smooth \
            fit to the product of ITU-R P.1410.",
    p_los: table,
};

/// C of eq. (6) for a, as printed: row i, column j is the coefficient of (αβ)^i γ^j.
const FOR_A: [[f64; 4]; 4] = [
    [9.34e-1, 2.30e-1, -2.25e-3, 1.86e-5],
    [1.97e-2, 2.44e-3, 6.58e-6, 0.0],
    [-1.24e-4, -3.34e-6, 0.0, 0.0],
    [2.73e-7, 0.0, 0.0, 0.0],
];

/// C of eq. (6) for b, in the same order.
const FOR_B: [[f64; 4]; 4] = [
    [1.17, -7.56e-2, 1.98e-3, -1.78e-5],
    [-5.79e-3, 1.81e-4, -1.65e-6, 0.0],
    [1.73e-5, -2.02e-7, 0.0, 0.0],
    [-2.00e-8, 0.0, 0.0, 0.0],
];

/// Range of αβ \[1/km²\] around the 75 to 150 of the fitted cities.
const FITTED_ALPHA_BETA: std::ops::RangeInclusive<f64> = 50.0..=300.0;
/// Range of γ of the fitted cities \[m\].
const FITTED_GAMMA: std::ops::RangeInclusive<f64> = 8.0..=50.0;

/// Returns the parameters (a, b) of the sigmoid by the polynomial of eq. (6), for a and b in
/// degrees.
///
/// Outside of the model's domain one of them is not above 0.
pub fn parameters(city: &BuiltUp) -> (f64, f64) {
    let (alpha_beta, gamma) = (alpha_beta(city), city.height_scale);
    let horner = |coefficients: [f64; 4], x: f64| coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c);
    let z = |c: &[[f64; 4]; 4]| horner(c.map(|row| horner(row, gamma)), alpha_beta);
    (z(&FOR_A), z(&FOR_B))
}

fn polynomial(link: &ModelLink) -> Result<ModelValue, OutsideDomain> {
    let (alpha_beta, gamma) = (alpha_beta(&link.built_up), link.built_up.height_scale);
    let (a, b) = parameters(&link.built_up);
    if !(a > 0.0 && b > 0.0) {
        return outside(format!(
            "the polynomial gives a = {a:.4}, b = {b:.4} at αβ = {}, γ = {gamma} m, wanted both above 0",
            tidy(alpha_beta)
        ));
    }
    let p = sigmoid(link, a, b)?;
    let fitted = FITTED_ALPHA_BETA.contains(&alpha_beta) && FITTED_GAMMA.contains(&gamma);
    let extrapolated = (!fitted).then(|| {
        format!("fitted to αβ from 50 to 300, γ from 8 to 50 m, the city has αβ = {}, γ = {gamma} m", tidy(alpha_beta))
    });
    Ok(ModelValue::new(p, [extrapolated, off_the_street(link)]))
}

fn table(link: &ModelLink) -> Result<ModelValue, OutsideDomain> {
    let (a, b) = match Environment::of(&link.built_up)? {
        Environment::Suburban => (4.88, 0.43),
        Environment::Urban => (9.61, 0.16),
        Environment::DenseUrban => (12.08, 0.11),
        Environment::HighRise => (27.23, 0.08),
    };
    Ok(ModelValue::new(sigmoid(link, a, b)?, [off_the_street(link)]))
}

/// Evaluates eq. (5).
fn sigmoid(link: &ModelLink, a: f64, b: f64) -> Result<f64, OutsideDomain> {
    theta_within(link, 0.0, 90.0)?;
    Ok(1.0 / (1.0 + a * libm::exp(-b * (link.theta_deg - a))))
}
