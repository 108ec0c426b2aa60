//! Receivers that an antenna serves, in integers: they lie exactly on its directions and distances.

use crate::city::Antenna;
use crate::quantity::{LatticePoint, STEPS_PER_UNIT};

/// Edge of a cell of a board in lattice steps, which is also the number of steps to the meter.
pub(super) const CELL: i64 = STEPS_PER_UNIT as i64;

/// Receivers that an antenna serves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Served {
    /// First azimuth of the sector and the one before which it ends, clockwise from north \[45°\],
    /// 0 to 7; they differ.
    pub eighths: [i64; 2],
    /// Least horizontal distance \[cells\].
    pub least: i64,
    /// `true` if receivers more than 45° below the horizontal are excluded.
    pub is_flat: bool,
}

impl Served {
    /// Returns `true` if it serves a receiver, by the definitions of [`Antenna`].
    pub fn holds(self, uav: LatticePoint, receiver: LatticePoint) -> bool {
        let (east, north) = (receiver.x - uav.x, receiver.y - uav.y);
        let squared = east * east + north * north;
        let below = uav.z - receiver.z;
        let is_flat_enough = !self.is_flat || below <= 0 || below * below <= squared;
        let [from, to] = self.eighths;
        let after = (eighth(east, north) - from).rem_euclid(8);
        let least = self.least * CELL;
        after < (to - from).rem_euclid(8) && squared >= least * least && is_flat_enough
    }

    /// Returns the antenna as an option of the command line gives it.
    pub(super) fn antenna(self) -> Antenna {
        let as_f64 = |v: i64| f64::from(u32::try_from(v).unwrap_or(u32::MAX));
        Antenna {
            min_radius_m: Some(as_f64(self.least)),
            sector_deg: Some(self.eighths.map(|eighth| 45.0 * as_f64(eighth))),
            elevation_deg: self.is_flat.then_some([-45.0, 90.0]),
            beam_deg: None,
            slant_range_m: None,
        }
    }
}

/// Returns the last multiple of 45° up to a direction, clockwise from north; 0 for straight down.
fn eighth(east: i64, north: i64) -> i64 {
    // Turned back by quarters until it is in the first quadrant.
    let (mut right, mut ahead, mut quarters) = (east, north, 0);
    while (right, ahead) != (0, 0) && !(right >= 0 && ahead > 0) {
        (right, ahead) = (-ahead, right);
        quarters += 1;
    }
    2 * quarters + i64::from(right >= ahead && right > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_in_the_eighth_that_they_begin() {
        let around = [
            (0, 9),
            (1, 9),
            (5, 5),
            (9, 5),
            (9, 0),
            (9, -1),
            (5, -5),
            (4, -5),
            (0, -2),
            (-1, -2),
            (-3, -3),
            (-9, -2),
            (-4, 0),
            (-4, 1),
            (-7, 7),
            (-1, 4),
        ];
        for (k, (east, north)) in (0..).zip(around) {
            assert_eq!(eighth(east, north), k / 2, "({east}, {north})");
        }
        assert_eq!(eighth(0, 0), 0);
    }
}
