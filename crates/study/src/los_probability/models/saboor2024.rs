//! Saboor, Vinogradov, Cui, Al-Hourani and Pollin 2024: rows of buildings across a street, azimuth
//! 0.
//!
//! ```text
//! P = ∏ᵢ₌₁..n { 1 − γ√(π/2)/(s·tan θ) · [ erf(k₂ tan θ/(√2 γ)) − erf(k₁ tan θ/(√2 γ)) ] }
//! k₁ = (i − 1)(s + w),   k₂ = k₁ + s,   n = ⌊h / ((s + w)·tan θ)⌋
//! ```
//!
//! A receiver stands anywhere across a street of width s, with equal probability. The ray runs
//! straight across, over one row of buildings after the other. Each factor is the mean, over the
//! receiver's place, of the probability that row i is lower than the ray at its near edge. Only
//! φ = 0 is here: the part of the model for other azimuths could not be checked.
//!
//! Traps: all factors grow with the distance of the receiver from the first row. So the mean of
//! their product is larger than the product of their means (suburban, 10°: 0.0215 against 0.0170).
//! And n leaves out the last row, so P is 1 if the UAV is nearer than one period s + w, at any
//! height. Heights are taken above the receiver, who stands at street level.

use std::f64::consts::{PI, SQRT_2};

use super::card::{Card, ModelLink, ModelValue, OutsideDomain, height_above_receiver, off_the_street, outside};

pub(super) const CARD: Card = Card {
    id: "saboor2024",
    name: "Saboor 2024, φ = 0",
    source: "A. Saboor, E. Vinogradov, Z. Cui, A. Al-Hourani and S. Pollin, A geometry-based modelling approach for the \
             line-of-sight probability in UAV communications, IEEE Open J. Commun. Soc. 5, 364–378, 2024; the part for \
             φ = 0",
    domain: "Any α, β, γ, any ground distance and a UAV above the receiver, straight across the street (φ = 0); \
             receivers at street level.",
    about: "A function of the ground distance, the height above the receiver and α, β, γ at azimuth 0; averaged over \
            receivers across one street.",
    p_los,
};

/// Largest relative deficit with which r/(s + w) still counts as a whole number: some thousand
/// times the rounding error of the few operations before.
const ROUNDING: f64 = 1e-12;

fn p_los(link: &ModelLink) -> Result<ModelValue, OutsideDomain> {
    let phi = link.phi_deg;
    if let Some(phi) = phi.filter(|phi| (phi % 180.0).abs() > 0.0) {
        return outside(format!("the azimuth is {phi}°, wanted 0°, straight across the street"));
    }
    let averaged = phi.is_none().then(|| "for φ = 0, straight across the street, not a mean over azimuths".to_string());
    let h = height_above_receiver(link)?;
    let (s, period, gamma) = (link.built_up.street_width(), link.built_up.period(), link.built_up.height_scale);
    let n_rows = (link.distance_m / period * (1.0 + ROUNDING)).floor();
    let mut p = 1.0;
    if n_rows >= 1.0 {
        // r ≥ s + w, so it is no division by 0.
        let tan_theta = h / link.distance_m;
        let scaled = |k: f64| libm::erf(k * tan_theta / (SQRT_2 * gamma));
        let factor = gamma * (PI / 2.0).sqrt() / (s * tan_theta);
        let mut row = 0.0;
        while row < n_rows {
            let (near, far) = (row * period, row * period + s);
            let blocked = factor * (scaled(far) - scaled(near));
            p *= 1.0 - blocked;
            // Farther rows are lower still under the ray, or P is already 0.
            if blocked <= 0.0 || p <= 0.0 {
                break;
            }
            row += 1.0;
        }
    }
    Ok(ModelValue::new(p, [averaged, off_the_street(link)]))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_near, link};
    use super::*;

    fn across(name: &str, theta: f64) -> ModelLink {
        ModelLink { phi_deg: Some(0.0), ..link(name, theta) }
    }

    #[test]
    fn a_row_that_ends_under_the_uav_counts() {
        // tan 60° = √3 and s + w = 100/√3 m: r is exactly one period.
        let mut link = across("dense", 60.0);
        for r in [link.distance_m.next_down(), link.distance_m, link.distance_m.next_up()] {
            link.distance_m = r;
            assert_near(p_los(&link).unwrap().p_los, 0.266622, 5e-7);
        }
    }

    #[test]
    fn a_factor_is_the_mean_over_the_street() {
        // One row: the mean over u of the probability that a Rayleigh height is below u·tan θ.
        let link = across("urban", 60.0);
        let (s, gamma) = (link.built_up.street_width(), link.built_up.height_scale);
        let mean: f64 = (0..20_000)
            .map(|k| {
                let ray = (f64::from(k) + 0.5) / 20_000.0 * s * link.uav_height_m / link.distance_m;
                1.0 - (-ray * ray / (2.0 * gamma * gamma)).exp()
            })
            .sum::<f64>()
            / 20_000.0;
        assert_near(p_los(&link).unwrap().p_los, mean, 1e-8);
    }
}
