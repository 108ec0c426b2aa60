//! Limits of range that depend on the heights of receivers: elevations, and the distance in space.

use std::cmp::Ordering;

use super::bearings::Elevations;
use crate::city::Antenna;
use crate::quantity::STEPS_PER_UNIT;

/// Elevations and the distance in space that leave a receiver in range.
#[derive(Debug, Clone, Copy)]
pub(super) struct HeightLimits {
    elevations: Option<Elevations>,
    slant: Option<SlantRange>,
}

/// Largest distance in space. Squares are in units of 2⁻³² of the square of a step of height.
#[derive(Debug, Clone, Copy)]
struct SlantRange {
    /// Square of a step of distance along x.
    step_squared: i128,
    /// Square of the range.
    squared: i128,
}

/// Fractional bits of the squares of a [`SlantRange`].
const FRACTION_BITS: u32 = 32;

impl HeightLimits {
    /// Returns the limits of an antenna where a step of distance along x is so long \[m\]; `None` if heights
    /// limit nothing.
    pub(super) fn of(antenna: Antenna, step_m: f64) -> Option<Self> {
        let step = step_m * f64::from(STEPS_PER_UNIT);
        let elevations = antenna.elevations_deg().map(|of| Elevations::new(of, step));
        let slant = antenna.slant_range_m.map(|range_m| SlantRange::new(range_m * f64::from(STEPS_PER_UNIT), step));
        (elevations.is_some() || slant.is_some()).then_some(HeightLimits { elevations, slant })
    }

    /// Returns `true` for a receiver in range `rise` \[1/1024 m\] above the place, at a horizontal distance of
    /// this square.
    pub(super) fn holds(&self, rise: i64, squared: i128) -> bool {
        self.elevations.is_none_or(|elevations| elevations.compare(rise, squared) == Ordering::Equal)
            && self.slant.is_none_or(|slant| slant.holds(rise, squared))
    }

    /// Returns `true` if no receiver is in range there between two heights above the place \[1/1024 m\]: those
    /// of cells that are too far, or else too near.
    pub(super) fn excludes(&self, (lowest, highest): (i64, i64), squared: i128, far: bool) -> bool {
        // Of receivers below the place elevations rise with the distance, of those above it they
        // fall.
        let by_elevations = self.elevations.is_some_and(|elevations| {
            let is_too_low = (highest < 0) != far && elevations.compare(highest, squared) == Ordering::Less;
            is_too_low || (lowest > 0) != far && elevations.compare(lowest, squared) == Ordering::Greater
        });
        let nearest = 0.clamp(lowest, highest.max(lowest));
        by_elevations || far && self.slant.is_some_and(|slant| !slant.holds(nearest, squared))
    }
}

impl SlantRange {
    /// Returns the range and the step of distance, both in steps of height.
    fn new(range: f64, step: f64) -> Self {
        let whole = |square: f64| {
            #[expect(clippy::cast_possible_truncation, reason = "a range beyond every scene becomes the largest one")]
            let whole = (square * (1_u64 << FRACTION_BITS) as f64).round() as i128;
            whole
        };
        SlantRange { step_squared: whole(step * step), squared: whole(range * range) }
    }

    fn holds(self, rise: i64, squared: i128) -> bool {
        // EXACT: squared distances are at most 2^56, rises below 2^28, so that sums are below 2^122 up to steps
        // of 32 m. Beyond, at distances that saturate, nothing is in range.
        let rise_squared = (i128::from(rise) * i128::from(rise)) << FRACTION_BITS;
        squared.saturating_mul(self.step_squared).saturating_add(rise_squared) <= self.squared
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_receiver_at_just_the_slant_range_is_in_range() {
        let of = |range_m: f64, step_m: f64| {
            HeightLimits::of(Antenna { slant_range_m: Some(range_m), ..Antenna::default() }, step_m).expect("a limit")
        };
        // A step of distance is one of height, and 3² + 4² = 5².
        let range = of(5.0, 1.0 / 1024.0);
        for (rise, along, holds) in [(3072, 4096, true), (-3072, 4096, true), (3073, 4096, false), (0, 5120, true)] {
            assert_eq!(range.holds(rise, along * along), holds, "{rise} {along}");
        }
        assert!(!range.holds(5121, 0) && range.holds(-5120, 0));
        // Steps of 2 m.
        let wide = of(5.0, 2.0);
        assert!(wide.holds(3072, 4) && !wide.holds(3073, 4));
        // Farther than any number holds is everywhere.
        assert!(of(1e300, 1.0).holds(1 << 28, 1 << 56));
    }

    #[test]
    fn what_is_excluded_holds_no_receiver() {
        let range = HeightLimits::of(Antenna { slant_range_m: Some(5.0), ..Antenna::default() }, 1.0).expect("a limit");
        for (lowest, highest) in [(-9, -4), (-4, 2), (1, 3), (3, 9)] {
            for along in 0..8_i128 {
                let any = (lowest..=highest).any(|rise| range.holds(1024 * rise, along * along));
                let between = (1024 * lowest, 1024 * highest);
                assert_eq!(range.excludes(between, along * along, true), !any, "{lowest} {highest} {along}");
                assert!(!range.excludes(between, along * along, false));
            }
        }
    }
}
