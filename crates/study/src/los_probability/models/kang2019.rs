//! Kang, Joung, Ahn and Kang 2019: the ITU product without its staircase.
//!
//! ```text
//! P = exp( −√(παβ/2) · (rγ/h) · erf(h/(√2 γ)) ),   r in km
//! ```
//!
//! The exponent is −√(αβ) ∫₀..r exp(−(hx/r)²/(2γ²)) dx. Buildings are placed at random along the
//! ray, √(αβ) per kilometer as in [`itu`](super::itu). Each blocks with the probability that a
//! Rayleigh height reaches the ray. For h ≫ γ only the elevation angle matters:
//! P = exp(−√(παβ/2)·γ·cot θ).
//!
//! The formula was read in another implementation and derived again as above, not read in the
//! letter. h is taken above the receiver. Building heights are, too, as if the receiver stood on
//! the ground. At 90° P is 1.

use std::f64::consts::{PI, SQRT_2};

use super::card::{Card, ModelLink, ModelValue, OutsideDomain, alpha_beta, height_above_receiver, off_the_street};

pub(super) const CARD: Card = Card {
    id: "kang2019",
    name: "Kang 2019",
    source: "H. Kang, J. Joung, J. Ahn and J. Kang, Secrecy-aware altitude optimization for quasi-static UAV base \
             station without eavesdropper location information, IEEE Commun. Lett. 23(5), 851–854, 2019",
    domain: "Any α, β, γ, any ground distance and a UAV above the receiver; receivers at street level.",
    about: "A function of the ground distance, the height above the receiver and α, β, γ, for buildings at random along \
            the ray instead of a place in a city.",
    p_los,
};

fn p_los(link: &ModelLink) -> Result<ModelValue, OutsideDomain> {
    let h = height_above_receiver(link)?;
    let gamma = link.built_up.height_scale;
    let rate = (PI * alpha_beta(&link.built_up) / 2.0).sqrt();
    let exponent = rate * (link.distance_m / 1000.0) * gamma / h * libm::erf(h / (SQRT_2 * gamma));
    Ok(ModelValue::new(libm::exp(-exponent), [off_the_street(link)]))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_near, city, link};
    use super::*;

    #[test]
    fn the_exponent_is_the_integral_of_the_blocking_rate() {
        let link = ModelLink { uav_height_m: 60.0, distance_m: 250.0, ..link("high-rise", 20.0) };
        let (n, gamma) = (20_000, link.built_up.height_scale);
        let mean: f64 = (0..n)
            .map(|k| {
                let ray = link.uav_height_m * (f64::from(k) + 0.5) / f64::from(n);
                (-ray * ray / (2.0 * gamma * gamma)).exp()
            })
            .sum::<f64>()
            / f64::from(n);
        let integral = (-(alpha_beta(&city("high-rise")).sqrt() * 0.25 * mean)).exp();
        assert_near(p_los(&link).unwrap().p_los, integral, 1e-8);
    }
}
