//! Recommendation ITU-R P.1410: a product over equally spaced buildings.
//!
//! ```text
//! P = ∏ₙ₌₀..m [ 1 − exp( −(h_tx − (n + ½)(h_tx − h_rx)/(m + 1))² / (2γ²) ) ]
//! m = ⌊r√(αβ) − 1⌋,   r in km
//! ```
//!
//! m + 1 buildings stand between the two ends, in the middles of m + 1 equal parts of the way. Each
//! is lower than the ray there with the probability of a Rayleigh height. For fixed heights P
//! depends on r only through m. It is a staircase with steps at r = k/√(αβ) km. Before the first
//! step the product is empty (m = −1) and P is 1, so at r = 0 too.
//!
//! Trap: the count √(αβ) per kilometer is that of a ray along the rows of the grid. A ray of random
//! direction crosses 4/π times as many buildings. A building is struck at its edge, not in the
//! middle of a cell. So the model gives too much line of sight at most elevation angles.

use super::card::{Card, ModelLink, ModelValue, OutsideDomain, alpha_beta};
use crate::city::BuiltUp;

pub(super) const CARD: Card = Card {
    id: "itu",
    name: "ITU-R P.1410",
    source: "Recommendation ITU-R P.1410, section 2.1.5, as written in A. Al-Hourani, S. Kandeepan and S. Lardner, \
             Optimal LAP altitude for maximum coverage, IEEE Wireless Commun. Lett. 3(6), 569–572, 2014, eq. (4)",
    domain: "Any α, β, γ, any two heights and any ground distance.",
    about: "A function of the ground distance, both heights and α, β, γ; a staircase in the distance, for buildings at \
            equal distances instead of a place in a city.",
    p_los,
};

/// Returns the index m of the last building between the two ends, −1 without one. m = ⌊r√(αβ) − 1⌋
/// with the ground distance r in kilometers and β in 1/km².
pub fn m(distance_m: f64, city: &BuiltUp) -> i64 {
    #[expect(clippy::cast_possible_truncation, reason = "saturates, far beyond any distance on Earth")]
    let m = (distance_m / 1000.0 * alpha_beta(city).sqrt() - 1.0).floor() as i64;
    m
}

fn p_los(link: &ModelLink) -> Result<ModelValue, OutsideDomain> {
    let m = m(link.distance_m, &link.built_up);
    let (h_tx, h_rx, gamma) = (link.uav_height_m, link.rx_height_m, link.built_up.height_scale);
    let lower_than_the_ray = |n: i64| {
        let ray = h_tx - (n as f64 + 0.5) * (h_tx - h_rx) / (m as f64 + 1.0);
        -libm::expm1(-ray * ray / (2.0 * gamma * gamma))
    };
    let mut p = 1.0;
    for n in 0..=m {
        p *= lower_than_the_ray(n);
        // A product of probabilities stays 0.
        if p <= 0.0 {
            break;
        }
    }
    Ok(ModelValue::new(p, []))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_near, city, link};
    use super::*;

    #[test]
    fn there_is_no_building_before_the_first_step_and_at_no_distance() {
        let urban = city("urban");
        // 1/√(αβ) = 81.65 m.
        assert_eq!([0.0, 81.6, 81.7, 163.2, 163.4].map(|r| m(r, &urban)), [-1, -1, 0, 0, 1]);
        let close = ModelLink { distance_m: 81.6, ..link("urban", 50.0) };
        assert_near(p_los(&close).unwrap().p_los, 1.0, 0.0);
        assert_near(p_los(&link("urban", 90.0)).unwrap().p_los, 1.0, 0.0);
    }

    #[test]
    fn the_two_ends_may_be_exchanged() {
        let down = ModelLink { rx_height_m: 12.0, ..link("dense", 10.0) };
        let up = ModelLink { uav_height_m: 12.0, rx_height_m: 100.0, ..down };
        assert_near(p_los(&down).unwrap().p_los, p_los(&up).unwrap().p_los, 1e-15);
    }
}
