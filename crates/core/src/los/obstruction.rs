//! The least visible height at a place and the obstacle that sets it, compared exactly.

use std::cmp::Ordering;

use crate::quantity::{BLOCKS_ALL, LatticePoint};

use super::cell_walk::Crossing;
use super::sag::Sag;

/// The obstacle number of flat ground over a curved earth.
pub const HORIZON: usize = usize::MAX;

/// Factor that makes a bound computed in doubles, negative as seen from the UAV, too high rather
/// than too low.
///
/// The few roundings of 2^-53 each, on both sides of a comparison, are far below 1e-12.
pub(super) const BOUND_MARGIN: f64 = 1.0 - 1e-12;

/// The least receiver height at a place from which the link is LoS.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LeastHeight {
    /// Nothing is in the way at any height.
    Clear,
    /// The receiver must be at least this high; the obstruction sets the bound.
    At(Obstruction),
}

/// An interval of the ray over one obstacle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Obstruction {
    /// Index of the cell ([`crate::height_field::Columns::tops`]) or of the piece, or [`HORIZON`].
    pub obstacle: usize,
    /// Top of the obstacle \[1/1024 m above the datum\].
    pub top: i32,
    /// Start of the interval, as a fraction of the way from the receiver to the UAV.
    pub near: f64,
    /// End of the interval, as a fraction of the way from the receiver to the UAV.
    pub far: f64,
    bound: Bound,
}

/// The bound of an interval on the receiver's height: `z_U + num/den + rise`, or no height at all.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bound {
    uav_z: i64,
    num: i128,
    /// Positive; 0 means that no receiver height is enough.
    den: i128,
    /// Rounded part of the bound: the rise for a curved earth, or the whole bound of sloped roofs
    /// along a wall; 0 if the bound is exact.
    rise: f64,
}

impl LeastHeight {
    /// Returns the least visible height \[1/1024 m above the datum\]: −∞ if clear, +∞ if no height
    /// is enough.
    pub fn height_steps(&self) -> f64 {
        match self {
            LeastHeight::Clear => f64::NEG_INFINITY,
            LeastHeight::At(o) => o.bound.value(),
        }
    }

    /// Returns `true` if a receiver at height `z` \[1/1024 m\] is at or above the least visible
    /// height. Exact over a flat earth with flat roofs.
    pub fn is_met_by(&self, z: i64) -> bool {
        match self {
            LeastHeight::Clear => true,
            LeastHeight::At(o) => o.bound.is_met_by(z),
        }
    }

    /// Returns the lowest lattice height \[1/1024 m above the datum\] at or above the least visible
    /// height; exact. It is the lowest `i64` if clear, and `None` if no height is enough. Valid
    /// over a flat earth with flat roofs only.
    pub fn lowest_step(&self) -> Option<i64> {
        match self {
            LeastHeight::Clear => Some(i64::MIN),
            LeastHeight::At(o) if o.bound.den == 0 => None,
            LeastHeight::At(o) => {
                let Bound { uav_z, num, den, .. } = o.bound;
                // Rounded up; heights are below 2^28, so clamped values are out of reach of every
                // height.
                let above = (-(-num).div_euclid(den)).clamp(-(1 << 40), 1 << 40);
                i64::try_from(above).ok().map(|above| uav_z + above)
            }
        }
    }

    /// Returns the least visible height above the UAV \[1/1024 m\], usually negative: −∞ if clear,
    /// +∞ if no height is enough.
    pub(super) fn above_uav(&self) -> f64 {
        match self {
            LeastHeight::Clear => f64::NEG_INFINITY,
            LeastHeight::At(o) => o.bound.above_uav(),
        }
    }

    /// Raises the least visible height to the bound of `other`. On a tie the obstruction nearer to
    /// the receiver stays.
    pub(super) fn raise(&mut self, other: Obstruction) {
        let higher = match self {
            LeastHeight::Clear => true,
            LeastHeight::At(o) => match other.bound.compare(&o.bound) {
                Ordering::Greater => true,
                Ordering::Equal => other.near < o.near,
                Ordering::Less => false,
            },
        };
        if higher {
            *self = LeastHeight::At(other);
        }
    }
}

impl Obstruction {
    /// Makes an interval of the ray from `near` to `far` over an obstacle with the given top.
    ///
    /// Both crossings are measured from the UAV. `near` is the end towards the receiver,
    /// `0 < near ≤ 1`. `far` is the end towards the UAV, `0 ≤ far < near`.
    pub(super) fn new(obstacle: usize, top: i32, uav: LatticePoint, near: Crossing, far: Crossing) -> Self {
        let excess = i64::from(top) - uav.z;
        // A roof below the UAV hides the cone behind its far edge (the one towards the receiver). A
        // roof above the UAV hides everything below the plane through its near edge.
        let at = if excess <= 0 { near } else { far };
        // Behind a nodata cell that blocks everything no height is enough.
        let den = if top == BLOCKS_ALL { 0 } else { i128::from(at.n) };
        let bound = Bound { uav_z: uav.z, num: i128::from(excess) * i128::from(at.d), den, rise: 0.0 };
        let from_receiver = |c: Crossing| ratio(i128::from(c.d - c.n), i128::from(c.d));
        Obstruction { obstacle, top, near: from_receiver(near), far: from_receiver(far), bound }
    }

    /// Makes an interval of the ray that demands a height of `num / den` above the UAV of the
    /// receiver. A denominator of 0 means that no height is enough. Crossings are measured from the
    /// UAV, the one towards the receiver first.
    pub(super) fn of_bound(
        obstacle: usize,
        top: i32,
        uav_z: i64,
        (num, den): (i128, i128),
        (near, far): (Crossing, Crossing),
    ) -> Self {
        let from_receiver = |c: Crossing| ratio(i128::from(c.d - c.n), i128::from(c.d));
        let bound = Bound { uav_z, num, den, rise: 0.0 };
        Obstruction { obstacle, top, near: from_receiver(near), far: from_receiver(far), bound }
    }

    /// Raises the bound to a rounded height above the UAV, if that is more.
    pub(super) fn or_more(self, above_uav: f64) -> Self {
        if self.bound.above_uav() >= above_uav {
            return self;
        }
        Obstruction { bound: Bound { num: 0, den: 1, rise: above_uav, ..self.bound }, ..self }
    }

    /// Adds the sag of the link to the bound. At the fraction s of the way from the UAV it demands
    /// `(H − z_U)/s + b(1 − s)` above the UAV. This is largest at an end of the interval, or at
    /// `√((z_U − H)/b)` in between.
    pub(super) fn over_curve(self, uav: LatticePoint, sag: Sag) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "a difference of heights, at most 2^28")]
        let excess = (i64::from(self.top) - uav.z) as f64;
        let (from, to) = (1.0 - self.far, 1.0 - self.near);
        let s = if excess >= 0.0 { from } else { sag.binding(-excess).max(from).min(to) };
        let rise = sag.rise_at_end(s);
        if s > from && s < to {
            let bound = Bound { num: 0, den: 1, rise: excess / s + rise, ..self.bound };
            return Obstruction { near: 1.0 - s, far: 1.0 - s, bound, ..self };
        }
        // A roof below the UAV may bind at its end towards the UAV, beyond the horizon.
        if excess < 0.0 && s < to {
            let bound = Bound { num: 0, den: 1, rise: excess / s + rise, ..self.bound };
            return Obstruction { near: self.far, bound, ..self };
        }
        Obstruction { bound: Bound { rise, ..self.bound }, ..self }
    }

    /// Returns the flat ground of a curved earth as an obstruction of a link; `None` if it is below
    /// the link for every height of the end.
    pub(super) fn of_horizon(ground: i32, uav: LatticePoint, sag: Sag) -> Option<Self> {
        #[expect(clippy::cast_precision_loss, reason = "a difference of heights, at most 2^28")]
        let below = (uav.z - i64::from(ground)) as f64;
        let s = sag.binding(below);
        (0.0..1.0).contains(&s).then(|| {
            let straight = if below > 0.0 { -below / s } else { 0.0 };
            let bound = Bound { uav_z: uav.z, num: 0, den: 1, rise: straight + sag.rise_at_end(s) };
            Obstruction { obstacle: HORIZON, top: ground, near: 1.0 - s, far: 1.0 - s, bound }
        })
    }
}

/// Returns `true` if an interval surely binds less than a height `above_uav`, by two products of
/// doubles. Returns `false` if rounding leaves a doubt. Crossings are measured as in
/// [`Obstruction::new`].
///
/// PERF: over columns nearly every cell is ruled out here; the exact bound costs twenty times as
/// much.
#[inline]
pub(super) fn surely_binds_less(top: i32, uav_z: i64, near: Crossing, far: Crossing, above_uav: f64) -> bool {
    let excess = i64::from(top) - uav_z;
    if top == BLOCKS_ALL {
        return false;
    }
    let at = if excess <= 0 { near } else { far };
    #[expect(clippy::cast_precision_loss, reason = "differences of at most 2^56, compared with a margin")]
    let (bound, height) = (excess as f64 * at.d as f64, above_uav * at.n as f64);
    // Infinite or undefined products leave a doubt, since every comparison with NaN is false.
    bound < height - (1.0 - BOUND_MARGIN) * (bound.abs() + height.abs())
}

impl Bound {
    fn value(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "heights are far below 2^53")]
        let uav_z = self.uav_z as f64;
        uav_z + self.above_uav()
    }

    fn above_uav(&self) -> f64 {
        if self.den == 0 { f64::INFINITY } else { ratio(self.num, self.den) + self.rise }
    }

    fn is_met_by(&self, z: i64) -> bool {
        #[expect(clippy::cast_precision_loss, reason = "heights are far below 2^53")]
        let is_above = |least: f64| (z - self.uav_z) as f64 >= least;
        match self.rise {
            _ if self.den == 0 => false,
            0.0 => i128::from(z - self.uav_z) * self.den >= self.num,
            _ => is_above(self.above_uav()),
        }
    }

    /// Orders two bounds from the same UAV exactly.
    fn compare(&self, other: &Bound) -> Ordering {
        debug_assert_eq!(self.uav_z, other.uav_z);
        match (self.den == 0, other.den == 0) {
            (true, true) => return Ordering::Equal,
            (true, false) => return Ordering::Greater,
            (false, true) => return Ordering::Less,
            (false, false) => {}
        }
        let (a, b) = (self.above_uav(), other.above_uav());
        // Far apart even if every conversion and division above erred by 2^-50.
        let is_curved = self.rise != 0.0 || other.rise != 0.0;
        if is_curved || (a - b).abs() > 1e-12 * (a.abs() + b.abs()) {
            return a.total_cmp(&b);
        }
        compare_ratios((self.num, self.den), (other.num, other.den))
    }
}

#[expect(clippy::cast_precision_loss, reason = "the quotient is reported, or compared with a margin")]
fn ratio(num: i128, den: i128) -> f64 {
    num as f64 / den as f64
}

/// Orders `a.0/a.1` and `b.0/b.1` exactly, for positive denominators, by continued fractions: no
/// product overflows.
pub(super) fn compare_ratios(mut a: (i128, i128), mut b: (i128, i128)) -> Ordering {
    loop {
        let (qa, qb) = (a.0.div_euclid(a.1), b.0.div_euclid(b.1));
        if qa != qb {
            return qa.cmp(&qb);
        }
        let (ra, rb) = (a.0.rem_euclid(a.1), b.0.rem_euclid(b.1));
        match (ra == 0, rb == 0) {
            (true, true) => return Ordering::Equal,
            (true, false) => return Ordering::Less,
            (false, true) => return Ordering::Greater,
            // a < b  ⇔  ra/da < rb/db  ⇔  db/rb < da/ra
            (false, false) => (a, b) = ((b.1, rb), (a.1, ra)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_compare_exactly_where_doubles_cannot_tell() {
        let big = (1_i128 << 80) + 1;
        assert_eq!(compare_ratios((big, 1 << 40), (1 << 80, 1 << 40)), Ordering::Greater);
        assert_eq!(compare_ratios((-7, 3), (-14, 6)), Ordering::Equal);
        assert_eq!(compare_ratios((-7, 3), (-6, 3)), Ordering::Less);
        assert_eq!(compare_ratios((1, 3), (333_333_333_333_333, 1_000_000_000_000_000)), Ordering::Greater);
    }
}
