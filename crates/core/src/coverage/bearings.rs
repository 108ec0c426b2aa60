//! Directions in whole numbers: sectors of azimuths and elevations, into which receivers fall
//! exactly.
//!
//! The direction of an angle is rounded once, to 30 bits; it knows that steps along x, y and
//! heights differ in length. From there on receivers are compared with it in integers.

use std::cmp::Ordering;

/// The longest component of a direction.
const LONG: f64 = (1_u64 << 30) as f64;

/// Steps to the east and to the north.
pub(super) type Steps = (i64, i64);

/// Azimuths from one direction, clockwise, to before another.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sector {
    pub(super) from: Steps,
    pub(super) to: Steps,
    /// At most half a turn: the half turn from its begin without that from its end. Otherwise all
    /// but the half turn from its end without that from its begin.
    pub(super) is_narrow: bool,
    /// Direction in which a receiver at the place itself counts.
    at_place: Steps,
}

impl Sector {
    /// Returns the sector from one azimuth to another \[deg clockwise from north\], on a lattice
    /// with steps of these lengths; `None` for whole turns.
    pub(super) fn new([from, to]: [f64; 2], step_lengths: (f64, f64)) -> Option<Self> {
        let width = (to - from).rem_euclid(360.0);
        let toward = |azimuth: f64| direction(azimuth, step_lengths);
        (width > 0.0).then(|| Sector {
            from: toward(from),
            to: toward(to),
            is_narrow: width <= 180.0,
            at_place: (0, 1),
        })
    }

    /// Returns the sector seen from its other end: the directions of places that have a receiver at
    /// this one in the sector.
    pub(super) fn reversed(self) -> Self {
        let back = |(x, y): Steps| (-x, -y);
        Sector { from: back(self.from), to: back(self.to), at_place: back(self.at_place), ..self }
    }

    /// Returns whether steps lead from a direction, clockwise, to before the opposite one.
    pub(super) fn is_in_half_turn(&self, start: Steps, steps: Steps) -> bool {
        let (x, y) = if steps == (0, 0) { self.at_place } else { steps };
        // EXACT: steps are at most 2^28, directions 2^30.
        let clockwise = x * start.1 - y * start.0;
        clockwise > 0 || clockwise == 0 && x * start.0 + y * start.1 > 0
    }
}

/// Returns the direction of an azimuth in steps, scaled up. Opposite azimuths, and those mirrored
/// at an axis, have such directions.
fn direction(azimuth: f64, (step_x, step_y): (f64, f64)) -> Steps {
    let turn = azimuth.rem_euclid(360.0);
    // Within the first quarter.
    let (quarter, rest) = (turn.div_euclid(90.0), turn.rem_euclid(90.0));
    // Sines beyond 45° by the cosine of the rest: then both halves are alike.
    let (small, large) = (rest.min(90.0 - rest).to_radians(), rest > 45.0);
    let (sin, cos) = if large { (small.cos(), small.sin()) } else { (small.sin(), small.cos()) };
    let (east, north) = match quarter {
        q if q < 1.0 => (sin, cos),
        q if q < 2.0 => (cos, -sin),
        q if q < 3.0 => (-sin, -cos),
        _ => (-cos, sin),
    };
    let (x, y) = (east / step_x, north / step_y);
    let scale = LONG / x.abs().max(y.abs());
    (rounded(x * scale), rounded(y * scale))
}

#[expect(clippy::cast_possible_truncation, reason = "at most 2^30")]
fn rounded(v: f64) -> i64 {
    v.round() as i64
}

/// Elevations from one angle to another, both included.
#[derive(Debug, Clone, Copy)]
pub(super) struct Elevations {
    low: Slope,
    high: Slope,
}

/// The direction of an elevation: steps of distance along x, and of height.
#[derive(Debug, Clone, Copy)]
struct Slope {
    along: i64,
    up: i64,
}

impl Elevations {
    /// Returns elevations between two angles \[deg above the horizontal\], where a step along x is
    /// `step` steps of height long.
    pub(super) fn new([low, high]: [f64; 2], step: f64) -> Self {
        let slope = |angle: f64| {
            let (sin, cos) = match angle {
                a if a.abs() > 45.0 => {
                    ((90.0 - a.abs()).to_radians().cos().copysign(a), (90.0 - a.abs()).to_radians().sin())
                }
                a => (a.to_radians().sin(), a.to_radians().cos()),
            };
            let (along, up) = (cos / step, sin);
            let scale = LONG / along.max(up.abs());
            Slope { along: rounded(along * scale), up: rounded(up * scale) }
        };
        Elevations { low: slope(low), high: slope(high) }
    }

    /// Compares a point `rise` \[1/1024 m\] above, at a distance of this square, with the
    /// elevations: below, among or above them.
    pub(super) fn compare(&self, rise: i64, squared: i128) -> Ordering {
        if self.low.compare(rise, squared) == Ordering::Less {
            Ordering::Less
        } else if self.high.compare(rise, squared) == Ordering::Greater {
            Ordering::Greater
        } else {
            Ordering::Equal
        }
    }
}

impl Slope {
    /// Compares the elevation of a point with this one.
    fn compare(&self, rise: i64, squared: i128) -> Ordering {
        if squared == 0 && rise != 0 {
            // Straight above or below, at ±90°.
            let is_same = self.along == 0 && (self.up > 0) == (rise > 0);
            return if is_same { Ordering::Equal } else { rise.cmp(&0) };
        }
        // EXACT: rises are below 2^28, squared distances at most 2^56, so all products are at most
        // 2^116.
        let (a, b) = (i128::from(rise) * i128::from(self.along), i128::from(self.up));
        let (a_squared, b_squared) = (a * a * a.signum(), b * b * b.signum() * squared);
        a_squared.cmp(&b_squared)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_exact_along_axes_and_diagonals_and_turn_over_with_the_angle() {
        let of = |azimuth: f64| direction(azimuth, (1.0, 1.0));
        let long = 1 << 30;
        assert_eq!(
            [0.0, 90.0, 180.0, 270.0, 360.0, -90.0].map(of),
            [(0, long), (long, 0), (0, -long), (-long, 0), (0, long), (-long, 0)]
        );
        assert_eq!([45.0, 135.0, 225.0, -45.0].map(of), [(long, long), (long, -long), (-long, -long), (-long, long)]);
        for azimuth in [0.1, 12.5, 30.0, 44.9, 45.1, 60.0, 89.7] {
            let (x, y) = of(azimuth);
            assert_eq!(of(azimuth + 180.0), (-x, -y), "{azimuth}");
            assert_eq!((of(-azimuth), of(180.0 - azimuth)), ((-x, y), (x, -y)), "{azimuth}");
        }
    }

    #[test]
    fn a_sector_and_its_complement_share_nothing_and_leave_nothing_out() {
        for (from, to) in [(0.0, 90.0), (-30.0, 30.0), (10.0, 190.0), (350.0, 349.0), (45.0, 225.0), (12.3, 12.4)] {
            let contains = |sector: &Sector, steps: Steps| {
                let [from, to] = [sector.from, sector.to].map(|start| sector.is_in_half_turn(start, steps));
                if sector.is_narrow { from && !to } else { from || !to }
            };
            let [sector, rest] = [[from, to], [to, from]].map(|s| Sector::new(s, (1.0, 1.0)).expect("a part"));
            for x in -9..=9 {
                for y in -9..=9 {
                    assert_ne!(contains(&sector, (x, y)), contains(&rest, (x, y)), "{from} {to}: {x} {y}");
                    let seen_back = contains(&sector.reversed(), (-x, -y));
                    assert_eq!(contains(&sector, (x, y)), seen_back, "{from} {to}: {x} {y}");
                }
            }
        }
        assert!(Sector::new([0.0, 360.0], (1.0, 1.0)).is_none());
    }

    #[test]
    fn elevations_include_both_ends() {
        let all = Elevations::new([-90.0, 90.0], 1.0);
        let below = Elevations::new([-45.0, 0.0], 1.0);
        for (rise, distance, of_all, of_below) in [
            (-7, 7, Ordering::Equal, Ordering::Equal),
            (-8, 7, Ordering::Equal, Ordering::Less),
            (0, 7, Ordering::Equal, Ordering::Equal),
            (1, 7, Ordering::Equal, Ordering::Greater),
            (-1, 0, Ordering::Equal, Ordering::Less),
            (5, 0, Ordering::Equal, Ordering::Greater),
            (0, 0, Ordering::Equal, Ordering::Equal),
        ] {
            assert_eq!(all.compare(rise, distance * distance), of_all, "{rise} {distance}");
            assert_eq!(below.compare(rise, distance * distance), of_below, "{rise} {distance}");
        }
        let above = Elevations::new([90.0, 90.0], 1.0);
        assert_eq!([-5, 5].map(|rise| above.compare(rise, 0)), [Ordering::Less, Ordering::Equal]);
        // Steps of 2 m: as far is half as many.
        assert_eq!(Elevations::new([-45.0, -45.0], 2.0).compare(-14, 49), Ordering::Equal);
    }
}
