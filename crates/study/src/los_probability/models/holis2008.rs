//! Holis and Pechac 2008: a fit of the elevation angle for high-altitude platforms.
//!
//! ```text
//! P(θ) = [ a − (a − b) / (1 + ((θ − c)/d)^e) ] / 100,   θ in degrees
//! ```
//!
//! The fit has five numbers for each of four environments. It comes from a study at 2 to 6 GHz of
//! platforms in the stratosphere and users at street level, for elevation angles from 1° to 89°.
//! All four curves reach 0.9998 to 1.0000 at 90°, so 90° is allowed; below 1° is refused.

use super::card::{
    Card, Environment, ModelLink, ModelValue, OutsideDomain, below_platforms, off_the_street, theta_within,
};

pub(super) const CARD: Card = Card {
    id: "holis2008",
    name: "Holis 2008",
    source: "J. Holis and P. Pechac, Elevation dependent shadowing model for mobile communications via high altitude \
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
