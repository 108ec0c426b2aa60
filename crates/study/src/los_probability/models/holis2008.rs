//! Holis and Pechac 2008: a fit of the elevation angle for high-altitude platforms.
//!
//! ```text
//! P(θ) = [ a − (a − b) / (1 + ((θ − c)/d)^e) ] / 100,   θ in degrees
//! ```
//!
//! Five numbers for each of four environments, from a study at 2 to 6 GHz of platforms in the stratosphere and users at
//! street level, for elevation angles from 1° to 89°. All four curves come to 0.9998 to 1.0000 at 90°, so 90° is allowed;
//! below 1° is refused.

use super::card::{
    Card, Environment, ModelLink, ModelValue, OutsideDomain, below_platforms, off_the_street, theta_within,
};

pub(super) const CARD: Card = Card {
    id: "holis2008",
    name: "Holis 2008",
    source: "P. Holis and P. Pechac, Elevation dependent shadowing model for mobile communications via high altitude \
             platforms in built-up areas, IEEE Trans. Antennas Propag. 56(4), 1078–1084, 2008; environments of Table I",
    domain: "Elevation angles from 1° to 90° (fitted up to 89°) in the suburban, urban, dense-urban or high-rise \
             environment; made for high-altitude platforms.",
    about: "A function of the elevation angle for each of four environments, for receivers at street level; averaged \
            over azimuths and places.",
    p_los,
};

fn p_los(link: &ModelLink) -> Result<ModelValue, OutsideDomain> {
    let [a, b, c, d, e] = match Environment::of(&link.built_up)? {
        Environment::Suburban => [101.6, 0.0, 0.0, 3.25, 1.241],
        Environment::Urban => [120.0, 0.0, 0.0, 24.30, 1.229],
        Environment::DenseUrban => [187.3, 0.0, 0.0, 82.10, 1.478],
        Environment::HighRise => [352.0, -1.37, -53.0, 173.80, 4.670],
    };
    theta_within(link, 1.0, 90.0)?;
    let percent = a - (a - b) / (1.0 + libm::pow((link.theta_deg - c) / d, e));
    Ok(ModelValue::new(percent / 100.0, [below_platforms(link), off_the_street(link)]))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{NAMED, assert_near, link};
    use super::*;

    #[test]
    fn all_curves_reach_one_overhead() {
        for name in NAMED {
            assert_near(p_los(&link(name, 90.0)).unwrap().p_los, 1.0, 3e-4);
        }
    }

    #[test]
    fn quoted_values_are_met() {
        for (name, theta, p) in [
            ("suburban", 10.0, 0.8142),
            ("urban", 10.0, 0.3017),
            ("dense", 30.0, 0.3451),
            ("high-rise", 20.0, 0.0468),
            ("high-rise", 90.0, 0.9998),
        ] {
            assert_near(p_los(&link(name, theta)).unwrap().p_los, p, 5.001e-5);
        }
    }

    #[test]
    fn below_one_degree_and_other_cities_are_refused() {
        assert!(p_los(&link("urban", 0.99)).unwrap_err().reason.contains("wanted 1° to 90°"));
        assert!(p_los(&link("ghent", 30.0)).is_err());
        assert!(p_los(&link("urban", 1.0)).is_ok());
    }

    #[test]
    fn a_drone_is_no_high_altitude_platform() {
        assert!(p_los(&link("urban", 30.0)).unwrap().caution.unwrap().contains("the UAV is at 100 m"));
        let platform = ModelLink { uav_height_m: 20_000.0, ..link("urban", 30.0) };
        assert_eq!(p_los(&platform).unwrap().caution, None);
    }
}
