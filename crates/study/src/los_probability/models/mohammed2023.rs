//! Mohammed, Gopalam, Collings and Hanly 2023: only the first building along the ray counts.
//!
//! The distance X from an outdoor receiver to the first building is taken as exponential with rate
//! Λ₁, its height as Rayleigh. P is the probability that the ray clears it. With the widths w of
//! buildings and s of streets,
//!
//! ```text
//! Λ₁ = (1/s)·( 613/753 − (901/2116)(s/w) + (1258/8477)(s/w)² − (239/10712)(s/w)³ )
//! ρ  = (h_tx − h_rx)² / (2γ²r²)
//! P  = 1 − ∫₀..r Λ₁ e^(−Λ₁x) e^(−ρx²) dx
//!    = 1 − Λ₁ √π/(2√ρ) · e^(Λ₁²/(4ρ)) · [ erf((2ρr + Λ₁)/(2√ρ)) − erf(Λ₁/(2√ρ)) ]
//! ```
//!
//! Trap: the exponent's sign is plus, as the integral shows. An implementation has it "corrected"
//! to minus, which is wrong by up to 0.99.
//!
//! Trap: at low elevation angles the two erf are both 1, their difference is lost and P becomes 1.
//! The code uses x = Λ₁/(2√ρ), q = √ρ·r = h/(√2 γ) and the scaled function
//! erfcx(x) = e^(x²)·erfc(x), and computes
//!
//! ```text
//! P = 1 − √π·x·[ erfcx(x) − e^(−Λ₁r − q²)·erfcx(x + q) ]
//! ```
//!
//! This neither overflows nor cancels. At r = 0, x is 0 and P is 1.
//!
//! The model measures all heights from the receiver, so buildings too stand on its level: h_rx is
//! taken as 0. Formula and coefficients were read in another implementation, which notes
//! 0.25 ≤ s/w ≤ 2.5, and the form was derived again. Λ₁ stays above 0 for s/w up to about 4.1, and
//! other cities are refused.

use std::f64::consts::{PI, SQRT_2};

use super::card::{Card, ModelLink, ModelValue, OutsideDomain, height_above_receiver, off_the_street, outside};
use crate::city::BuiltUp;
use crate::quantity::tidy;

pub(super) const CARD: Card = Card {
    id: "mohammed2023",
    name: "Mohammed 2023",
    source: "I. Mohammed, S. Gopalam, I. B. Collings and S. V. Hanly, Closed form approximations for UAV line-of-sight \
             probability in urban environments, IEEE Access 11, 40162–40174, 2023; the closed form of the \
             first-building LoS probability",
    domain: "Any γ, any ground distance and a UAV above the receiver, for streets of 0.25 to 2.5 building widths; \
             receivers outdoors at street level.",
    about: "A function of the ground distance, the height above the receiver and α, β, γ; averaged over outdoor \
            receivers and azimuths.",
    p_los,
};

/// Range of s/w for which the polynomial of Λ₁ was fitted.
const FITTED_STREETS: std::ops::RangeInclusive<f64> = 0.25..=2.5;

/// Returns the rate Λ₁ of the distance to the first building \[1/m\].
fn first_building_rate(city: &BuiltUp) -> f64 {
    let (s, w) = (city.street_width(), city.building_width());
    let x = s / w;
    (613.0 / 753.0 + x * (-901.0 / 2116.0 + x * (1258.0 / 8477.0 - x * (239.0 / 10712.0)))) / s
}

fn p_los(link: &ModelLink) -> Result<ModelValue, OutsideDomain> {
    let h = height_above_receiver(link)?;
    let (rate, r) = (first_building_rate(&link.built_up), link.distance_m);
    let streets = link.built_up.street_width() / link.built_up.building_width();
    if !(rate.is_finite() && rate > 0.0) {
        return outside(format!(
            "streets are {} building widths wide, where the fit has no value; it was made for 0.25 to 2.5",
            tidy(streets)
        ));
    }
    let q = h / (SQRT_2 * link.built_up.height_scale);
    let x = rate * r / (2.0 * q);
    let p = 1.0 - PI.sqrt() * x * (erfcx(x) - libm::exp(-rate * r - q * q) * erfcx(x + q));
    let extrapolated = (!FITTED_STREETS.contains(&streets))
        .then(|| format!("fitted to streets of 0.25 to 2.5 building widths, here they are {}", tidy(streets)));
    Ok(ModelValue::new(p, [extrapolated, off_the_street(link)]))
}

/// Least x of the continued fraction, at which 24 of its levels are exact to the last digits.
const FAR: f64 = 10.0;

/// Returns the scaled complementary error function e^(x²)·erfc(x), for x ≥ 0.
///
/// e^(x²) overflows at x = 26.7, so large x use the continued fraction of Laplace:
/// √π·erfcx(x) = 1/(x + (1/2)/(x + (2/2)/(x + (3/2)/(x + …)))) (Abramowitz & Stegun, Handbook of
/// Mathematical Functions, eq. 7.1.14).
fn erfcx(x: f64) -> f64 {
    if x < FAR {
        return libm::exp(x * x) * libm::erfc(x);
    }
    let tail = (1..=24).rev().fold(x, |tail, k| x + 0.5 * f64::from(k) / tail);
    1.0 / (PI.sqrt() * tail)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{CITIES, assert_near, link};
    use super::*;

    #[test]
    fn the_closed_form_is_the_integral() {
        for name in CITIES {
            for theta in [0.5, 5.0, 20.0, 45.0, 80.0] {
                let link = link(name, theta);
                let (rate, r) = (first_building_rate(&link.built_up), link.distance_m);
                let q = link.uav_height_m / (SQRT_2 * link.built_up.height_scale);
                // Simpson's rule over the part where the first factor is above e^−40.
                let (end, n) = (r.min(40.0 / rate), 4000);
                let density = |x: f64| rate * (-rate * x - (q * x / r) * (q * x / r)).exp();
                let weighted = |k: i32| {
                    let weight = if k == 0 || k == n { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
                    weight * density(end * f64::from(k) / f64::from(n))
                };
                let integral = (0..=n).map(weighted).sum::<f64>() * end / f64::from(n) / 3.0;
                assert_near(p_los(&link).unwrap().p_los, 1.0 - integral, 1e-8);
            }
        }
    }

    #[test]
    fn the_scaled_error_function_is_smooth_where_its_form_changes() {
        // Continued fraction and product agree to 13 digits around the change.
        let by_product = |x: f64| libm::exp(x * x) * libm::erfc(x);
        for x in [10.0, 10.5, 12.0, 15.0] {
            assert_near(erfcx(x) / by_product(x), 1.0, 1e-13);
        }
        assert_near(erfcx(0.0), 1.0, 0.0);
        // √π·x·erfcx(x) = 1 − 1/(2x²) + 3/(4x⁴) − …
        assert_near(PI.sqrt() * 100.0 * erfcx(100.0), 1.0 - 0.5e-4 + 0.75e-8 - 1.875e-12, 1e-14);
        assert!(erfcx(1e300) > 0.0);
    }
}
