//! 3GPP TR 38.811: satellites and high-altitude platforms, a table over the elevation angle.
//!
//! P in percent, at elevation angles from 10° to 90°:
//!
//! | environment | 10° | 20° | 30° | 40° | 50° | 60° | 70° | 80° | 90° |
//! |---|---|---|---|---|---|---|---|---|---|
//! | dense urban | 28.2 | 33.1 | 39.8 | 46.8 | 53.7 | 61.2 | 73.8 | 82.0 | 98.1 |
//! | urban | 24.6 | 38.6 | 49.3 | 61.3 | 72.6 | 80.5 | 91.9 | 96.8 | 99.2 |
//! | suburban and rural | 78.2 | 86.9 | 91.9 | 92.9 | 93.5 | 94.0 | 94.9 | 95.2 | 99.8 |
//!
//! Network simulators (ns-3, Simu5G) take the nearest of these angles: a staircase, with halves
//! rounded up. Linear interpolation is an extension, also in use. Below 10° both keep the value at
//! 10° and add a caution; overhead P is not 1. There is no table for high-rise. The table was made
//! for platforms from 8 km up, so for a UAV it is an analogy. Oddity: at 10° the dense urban city
//! has more line of sight than the urban one.

use super::card::{
    Card, Environment, ModelLink, ModelValue, OutsideDomain, below_platforms, off_the_street, outside, theta_within,
};

pub(super) const NEAREST: Card = Card {
    id: "tr38811",
    name: "3GPP 38.811",
    source: "3GPP TR 38.811, Table 6.6.1-1, at the nearest of its elevation angles",
    domain: "Elevation angles from 0° to 90° (tabulated from 10°) in the suburban, urban or dense-urban environment; \
             made for platforms from 8 km up.",
    about: "A function of the elevation angle for each of three environments, for receivers at street level; a \
            staircase of ten degrees, averaged over azimuths and places.",
    p_los: |link| {
        let row = row(link)?;
        value(link, row[index(link.theta_deg.max(LOWEST_DEG), f64::round)])
    },
};

pub(super) const LINEAR: Card = Card {
    id: "tr38811-linear",
    name: "3GPP 38.811, linear",
    source: "3GPP TR 38.811, Table 6.6.1-1, interpolated linearly, which is an extension",
    domain: "Elevation angles from 0° to 90° (tabulated from 10°) in the suburban, urban or dense-urban environment; \
             made for platforms from 8 km up.",
    about: "A function of the elevation angle for each of three environments, for receivers at street level; averaged \
            over azimuths and places.",
    p_los: |link| {
        let row = row(link)?;
        let theta = link.theta_deg.max(LOWEST_DEG);
        let below = index(theta, f64::floor);
        let share = theta / STEP_DEG - (below as f64 + 1.0);
        // Above 80° the next entry is that at 90°, and at 90° nothing is missing.
        let above = row[(below + 1).min(row.len() - 1)];
        value(link, row[below] + (above - row[below]) * share)
    },
};

/// First elevation angle of the table \[deg\].
const LOWEST_DEG: f64 = 10.0;
/// Step between elevation angles of the table \[deg\].
const STEP_DEG: f64 = 10.0;

/// Returns P in percent at 10°, 20°, …, 90°.
fn row(link: &ModelLink) -> Result<[f64; 9], OutsideDomain> {
    theta_within(link, 0.0, 90.0)?;
    Ok(match Environment::of(&link.built_up)? {
        Environment::Suburban => [78.2, 86.9, 91.9, 92.9, 93.5, 94.0, 94.9, 95.2, 99.8],
        Environment::Urban => [24.6, 38.6, 49.3, 61.3, 72.6, 80.5, 91.9, 96.8, 99.2],
        Environment::DenseUrban => [28.2, 33.1, 39.8, 46.8, 53.7, 61.2, 73.8, 82.0, 98.1],
        Environment::HighRise => {
            return outside("the city is high-rise, wanted suburban, urban or dense-urban, which have a table".into());
        }
    })
}

/// Returns the index in a row of an elevation angle from 10° to 90°, brought to a whole step.
fn index(theta_deg: f64, whole: fn(f64) -> f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 9 by the check in `row`")]
    let step = whole(theta_deg / STEP_DEG) as usize;
    step - 1
}

fn value(link: &ModelLink, percent: f64) -> Result<ModelValue, OutsideDomain> {
    let below_the_table = (link.theta_deg < LOWEST_DEG)
        .then(|| format!("tabulated from {LOWEST_DEG}°, the elevation angle is {}°", link.theta_deg));
    Ok(ModelValue::new(percent / 100.0, [below_the_table, below_platforms(link), off_the_street(link)]))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_near, link};
    use super::*;

    fn both(name: &str, theta: f64) -> [f64; 2] {
        [NEAREST, LINEAR].map(|card| (card.p_los)(&link(name, theta)).unwrap().p_los)
    }

    #[test]
    fn between_its_angles_one_steps_and_the_other_interpolates() {
        let [nearest, linear] = both("urban", 24.9);
        assert_near(nearest, 0.386, 1e-15);
        assert_near(linear, 0.386 + 0.49 * 0.107, 1e-12);
        assert_near(both("urban", 25.0)[0], 0.493, 1e-15);
        assert_near(both("urban", 84.9)[0], 0.968, 1e-15);
        assert_near(both("urban", 85.0)[0], 0.992, 1e-15);
    }
}
