//! 3GPP TR 36.777: aerial users of a mobile network.
//!
//! With the ground distance d and the UAV's height h in meters, P is 1 for d ≤ d₁ and
//! d₁/d + exp(−d/p₁)(1 − d₁/d) beyond:
//!
//! | scenario | h | p₁ | d₁ |
//! |---|---|---|---|
//! | RMa-AV | 10 < h ≤ 40 | max(15021·log₁₀h − 16053, 1000) | max(1350.8·log₁₀h − 1602, 18) |
//! | | 40 < h ≤ 300 | P = 1 | |
//! | UMa-AV | 22.5 < h ≤ 100 | 4300·log₁₀h − 3800 | max(460·log₁₀h − 700, 18) |
//! | | 100 < h ≤ 300 | P = 1 | |
//! | UMi-AV | 22.5 < h ≤ 300 | 233.98·log₁₀h − 0.95 | max(294.05·log₁₀h − 432.94, 18) |
//!
//! From 1.5 m up to the first row of a scenario the value is that of [`tr38901`]. P jumps at the
//! limits of the rows (UMa-AV at 1 km: 0.045 at 22.5 m, 0.616 just above). UMi-AV has no height
//! from which it is 1.
//!
//! Trap: the ground end is a base station on a mast or roof (RMa 35 m, UMa 25 m, UMi 10 m), the UAV
//! is its user. For a receiver on the street the value is an analogy and carries a caution. The
//! built-up parameters have no effect.

use super::card::{Card, ModelLink, ModelValue, OutsideDomain, not_a_base_station, outside};
use super::tr38901::{self, street};

pub(super) const RMA_AV: Card = Card {
    id: "tr36777_rma_av",
    name: "3GPP 36.777 RMa-AV",
    source: "3GPP TR 36.777, Annex B, Table B-1, RMa-AV",
    domain: "UAVs at 1.5 to 300 m and any ground distance.",
    about: "A function of the ground distance and the UAV's height; the UAV is the user of a rural base station at 35 m.",
    p_los: |link| value(link, rma_av, 35.0),
};

pub(super) const UMA_AV: Card = Card {
    id: "tr36777_uma_av",
    name: "3GPP 36.777 UMa-AV",
    source: "3GPP TR 36.777, Annex B, Table B-1, UMa-AV",
    domain: "UAVs at 1.5 to 300 m and any ground distance.",
    about: "A function of the ground distance and the UAV's height; the UAV is the user of an urban macro base station \
            at 25 m.",
    p_los: |link| value(link, uma_av, 25.0),
};

pub(super) const UMI_AV: Card = Card {
    id: "tr36777_umi_av",
    name: "3GPP 36.777 UMi-AV",
    source: "3GPP TR 36.777, Annex B, Table B-1, UMi-AV",
    domain: "UAVs at 1.5 to 300 m and any ground distance.",
    about: "A function of the ground distance and the UAV's height; the UAV is the user of an urban micro base station \
            at 10 m.",
    p_los: |link| value(link, umi_av, 10.0),
};

/// Heights of aerial users \[m\] (Table B-1).
const HEIGHTS: std::ops::RangeInclusive<f64> = 1.5..=300.0;

fn value(link: &ModelLink, formula: fn(f64, f64) -> f64, station_m: f64) -> Result<ModelValue, OutsideDomain> {
    if !HEIGHTS.contains(&link.uav_height_m) {
        return outside(format!("the UAV is at {} m, wanted 1.5 m to 300 m", link.uav_height_m));
    }
    Ok(ModelValue::new(formula(link.distance_m, link.uav_height_m), [not_a_base_station(link, station_m)]))
}

fn rma_av(d: f64, h: f64) -> f64 {
    if h <= 10.0 {
        return tr38901::rma(d);
    }
    if h > 40.0 {
        return 1.0;
    }
    let log_h = libm::log10(h);
    street(d, (1350.8 * log_h - 1602.0).max(18.0), (15021.0 * log_h - 16053.0).max(1000.0))
}

fn uma_av(d: f64, h: f64) -> f64 {
    if h <= 22.5 {
        return tr38901::uma(d, h);
    }
    if h > 100.0 {
        return 1.0;
    }
    let log_h = libm::log10(h);
    street(d, (460.0 * log_h - 700.0).max(18.0), 4300.0 * log_h - 3800.0)
}

fn umi_av(d: f64, h: f64) -> f64 {
    if h <= 22.5 {
        return tr38901::umi(d);
    }
    let log_h = libm::log10(h);
    street(d, (294.05 * log_h - 432.94).max(18.0), 233.98 * log_h - 0.95)
}

#[cfg(test)]
mod tests {
    use super::super::tests::assert_near;
    use super::*;

    #[test]
    fn a_limit_belongs_to_the_band_below_it() {
        for d in [5.0, 100.0, 4000.0] {
            assert_near(rma_av(d, 10.0), tr38901::rma(d), 0.0);
            assert_near(uma_av(d, 22.5), tr38901::uma(d, 22.5), 0.0);
            assert_near(umi_av(d, 22.5), tr38901::umi(d), 0.0);
        }
        assert!(rma_av(4000.0, 40.0) < 1.0 && uma_av(4000.0, 100.0) < 1.0 && umi_av(4000.0, 300.0) < 1.0);
        assert_near(rma_av(4000.0, 40.001), 1.0, 0.0);
        assert_near(uma_av(4000.0, 100.001), 1.0, 0.0);
    }
}
