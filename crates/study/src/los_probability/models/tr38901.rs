//! 3GPP TR 38.901: users on the ground and in low buildings, seen by a base station.
//!
//! With the ground distance d in meters, the part of it outdoors, and the user's height h:
//!
//! ```text
//! RMa   1 for d ≤ 10,  exp(−(d − 10)/1000)
//! UMi   1 for d ≤ 18,  18/d + exp(−d/36)(1 − 18/d)
//! UMa   1 for d ≤ 18,  [18/d + exp(−d/63)(1 − 18/d)] · [1 + C′ (5/4)(d/100)³ exp(−d/150)]
//!       C′ = 0 for h ≤ 13,  ((h − 13)/10)^1.5 for 13 < h ≤ 23
//! ```
//!
//! Here the UAV is the user, and the receiver on the ground replaces the base station (RMa 35 m,
//! UMa 25 m, UMi 10 m high). For a receiver on the street the value is an analogy and carries a
//! caution. The built-up parameters have no effect. C′ is not defined above 23 m, so UMa is refused
//! there. RMa and UMi have no height in Table 7.4.2-1. Table 7.4.1-1 has them for users at 1 to
//! 10 m (RMa) and 1.5 to 22.5 m (UMi); beyond, values carry a caution.

use super::card::{Card, ModelLink, ModelValue, not_a_base_station, outside};

pub(super) const RMA: Card = Card {
    id: "tr38901_rma",
    name: "3GPP 38.901 RMa",
    source: "3GPP TR 38.901, Table 7.4.2-1, RMa",
    domain: "Any ground distance; made for users 1 to 10 m above the ground.",
    about: "A function of the ground distance; the UAV is the user of a rural base station at 35 m.",
    p_los: |link| {
        let cautions = [users_at(link, 1.0, 10.0), not_a_base_station(link, 35.0)];
        Ok(ModelValue::new(rma(link.distance_m), cautions))
    },
};

pub(super) const UMA: Card = Card {
    id: "tr38901_uma",
    name: "3GPP 38.901 UMa",
    source: "3GPP TR 38.901, Table 7.4.2-1, UMa",
    domain: "Any ground distance and UAVs up to 23 m; made for users 1.5 to 23 m above the ground.",
    about: "A function of the ground distance and the UAV's height; the UAV is the user of an urban macro base station \
            at 25 m.",
    p_los: |link| {
        if link.uav_height_m > UMA_HIGHEST_M {
            return outside(format!("the UAV is at {} m, wanted at most {UMA_HIGHEST_M} m", link.uav_height_m));
        }
        let cautions = [users_at(link, 1.5, UMA_HIGHEST_M), not_a_base_station(link, 25.0)];
        Ok(ModelValue::new(uma(link.distance_m, link.uav_height_m), cautions))
    },
};

pub(super) const UMI: Card = Card {
    id: "tr38901_umi",
    name: "3GPP 38.901 UMi",
    source: "3GPP TR 38.901, Table 7.4.2-1, UMi street canyon",
    domain: "Any ground distance; made for users 1.5 to 22.5 m above the ground.",
    about: "A function of the ground distance; the UAV is the user of an urban micro base station at 10 m.",
    p_los: |link| {
        let cautions = [users_at(link, 1.5, 22.5), not_a_base_station(link, 10.0)];
        Ok(ModelValue::new(umi(link.distance_m), cautions))
    },
};

/// Height of the highest user for whom C′ is defined \[m\].
const UMA_HIGHEST_M: f64 = 23.0;

fn users_at(link: &ModelLink, low: f64, high: f64) -> Option<String> {
    let h = link.uav_height_m;
    (!(low..=high).contains(&h)).then(|| format!("made for users at {low} to {high} m, the UAV is at {h} m"))
}

/// Returns P for rural macro; d in meters.
pub(super) fn rma(d: f64) -> f64 {
    if d <= 10.0 { 1.0 } else { libm::exp(-(d - 10.0) / 1000.0) }
}

/// Returns P for urban macro; d and h in meters, h ≤ 23.
pub(super) fn uma(d: f64, h: f64) -> f64 {
    let c = if h <= 13.0 {
        0.0
    } else {
        let x = (h - 13.0) / 10.0;
        x * x.sqrt()
    };
    let hundreds = d / 100.0;
    let higher = 1.0 + c * 1.25 * hundreds * hundreds * hundreds * libm::exp(-d / 150.0);
    street(d, 18.0, 63.0) * if d <= 18.0 { 1.0 } else { higher }
}

/// Returns P for an urban micro street canyon; d in meters.
pub(super) fn umi(d: f64) -> f64 {
    street(d, 18.0, 36.0)
}

/// Returns the form common to urban models: 1 up to d₁, then d₁/d + exp(−d/p₁)(1 − d₁/d).
pub(super) fn street(d: f64, d1: f64, p1: f64) -> f64 {
    if d <= d1 { 1.0 } else { d1 / d + libm::exp(-d / p1) * (1.0 - d1 / d) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_height_never_hides_a_user_of_uma() {
        for d in 1..2000 {
            for h in 13..23 {
                let (low, high) = (uma(f64::from(d), f64::from(h)), uma(f64::from(d), f64::from(h + 1)));
                assert!(low <= high && high <= 1.0, "{d} m, {h} m: {low}, {high}");
            }
        }
    }
}
