//! A ray over a sloped roof. Both are straight, so the ray comes nearest to the roof at an end of
//! their common interval.
//!
//! Let c(t) be the ray's height above the plane of the roof, times twice the area of a triangle of
//! it. Then c is an integer at the UAV (t = 0) and at the receiver (t = 1), and linear in between:
//!
//! ```text
//!   c(n/d)·d = c_U·(d − n) + c_R·n,      blocked on an interval  ⇔  c < 0 at one of its ends
//! ```
//!
//! Two roofs along a wall block the ray where it is below both. If the ray is below a roof
//! anywhere, it is so on a part of the interval that begins at one of its ends. Both parts meet
//! unless they begin at opposite ends and are too short.
//!
//! A receiver of unknown height sees the UAV past the roof at t from
//! `h_U − (c_U·(1/t − 1) + c)/area` up. Here c is that at the receiver's place at the UAV's height.
//! This is a straight line in 1/t, so it is highest at an end again.
//!
//! Sizes: roofs span at most 2^20 steps ([`MAX_ROOF_STEPS`](crate::height_field::MAX_ROOF_STEPS)),
//! so c is below 2^77 and d below 2^49. All products are below 2^127, those of two roofs below
//! 2^155.

use std::cmp::Ordering;

use ethnum::I256;

use super::cell_walk::Crossing;
use super::obstruction::{Obstruction, compare_ratios};
use crate::height_field::RoofPlane;
use crate::quantity::LatticePoint;

/// A ray over the plane of a roof.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slope {
    /// Height of the UAV above the plane, times `area`.
    uav: i128,
    /// Height of the receiver above the plane, times `area`.
    receiver: i128,
    /// Twice the area of the triangle that defines the plane; above 0.
    area: i64,
    /// The UAV's height \[1/1024 m above the datum\].
    uav_z: i64,
    /// Height of the receiver above the UAV \[1/1024 m\].
    rise: i64,
}

impl Slope {
    #[inline]
    pub(super) fn over(plane: &RoofPlane, uav: LatticePoint, receiver: LatticePoint) -> Slope {
        let (above_uav, above_receiver) = (plane.above(uav), plane.above(receiver));
        Slope { uav: above_uav, receiver: above_receiver, area: plane.area(), uav_z: uav.z, rise: receiver.z - uav.z }
    }

    /// Makes the slope of a flat roof.
    pub(super) fn level(top: i32, uav: LatticePoint, receiver: LatticePoint) -> Slope {
        let above = |p: LatticePoint| i128::from(p.z - i64::from(top));
        Slope { uav: above(uav), receiver: above(receiver), area: 1, uav_z: uav.z, rise: receiver.z - uav.z }
    }

    /// Returns the ray's height above the plane at a fraction of the way from the UAV, times `area`
    /// and the denominator.
    #[inline]
    fn above(&self, at: Crossing) -> i128 {
        self.uav * i128::from(at.d - at.n) + self.receiver * i128::from(at.n)
    }

    /// Returns `true` if the ray is below the plane there. Exact.
    #[inline]
    fn is_below(&self, at: Crossing) -> bool {
        // PERF: four conversions in place of two products of 128 bits; doubles are off by less than
        // 4·2^-53 of both products.
        #[expect(clippy::cast_precision_loss, reason = "filtered: decided in i128 where rounding could matter")]
        let (a, b) = (self.uav as f64 * (at.d - at.n) as f64, self.receiver as f64 * at.n as f64);
        let sum = a + b;
        if sum.abs() > 1e-15 * (a.abs() + b.abs()) { sum < 0.0 } else { self.above(at) < 0 }
    }

    /// Returns `true` if the roof blocks the ray between two fractions of the way.
    #[inline]
    pub(super) fn is_blocked(&self, far: Crossing, near: Crossing) -> bool {
        self.is_below(near) || self.is_below(far)
    }

    /// Returns by how much the roof may rise without blocking the ray there, rounded down \[1/1024
    /// m\].
    pub(super) fn room(&self, far: Crossing, near: Crossing) -> i64 {
        let room = |at: Crossing| self.above(at).div_euclid(i128::from(self.area) * i128::from(at.d));
        // Beyond all heights the exact number does not matter.
        i64::try_from(room(far).min(room(near)).clamp(-(1 << 40), 1 << 40)).unwrap_or(0)
    }

    /// Returns `true` if this roof and another together block a ray along the wall between them.
    pub(super) fn is_blocked_with(&self, other: &Slope, far: Crossing, near: Crossing) -> bool {
        let at = |at: Crossing| (self.is_below(at), other.is_below(at));
        match (at(far), at(near)) {
            ((true, true), _) | (_, (true, true)) => true,
            // The ray is below one roof from one end to its level point, and below the other roof
            // from the other end.
            ((true, false), (false, true)) => other.is_below_where_level(self),
            ((false, true), (true, false)) => self.is_below_where_level(other),
            _ => false,
        }
    }

    /// Returns `true` if this roof is above the ray at the point where the ray is level with
    /// `other`.
    fn is_below_where_level(&self, other: &Slope) -> bool {
        // The other is level at t = U/(U − R), where U and R have opposite signs. This roof's c
        // there has the sign of (u·(−R) + r·U)/(U − R).
        let wide = |v: i128| I256::from(v);
        let above = wide(self.receiver) * wide(other.uav) - wide(self.uav) * wide(other.receiver);
        let divisor = other.uav - other.receiver;
        if divisor > 0 { above < I256::ZERO } else { above > I256::ZERO }
    }

    /// Returns by how much each of both roofs may rise alone until they block a ray along the wall
    /// between them \[1/1024 m\].
    ///
    /// The place that counts is where the lower of both is highest relative to the ray. The result
    /// is rounded if that is between the ends.
    pub(super) fn rooms_with(&self, other: &Slope, far: Crossing, near: Crossing) -> [i64; 2] {
        let at = |at: Crossing| [self.room(at, at), other.room(at, at)];
        let (of_far, of_near) = (at(far), at(near));
        let mut rooms = if of_far[0].max(of_far[1]) <= of_near[0].max(of_near[1]) { of_far } else { of_near };
        #[expect(clippy::cast_precision_loss, reason = "rounded, and put right below")]
        let above = |slope: &Slope, at: Crossing| slope.above(at) as f64 / (at.d as f64 * slope.area as f64);
        let difference = |at: Crossing| above(self, at) - above(other, at);
        let (from, to) = (difference(far), difference(near));
        if from * to < 0.0 {
            let t = from / (from - to);
            let level = (above(self, far) * (1.0 - t) + above(self, near) * t).floor();
            #[expect(clippy::cast_possible_truncation, reason = "between two heights")]
            let level = level as i64;
            if level < rooms[0].max(rooms[1]) {
                rooms = [level; 2];
            }
        }
        if self.is_blocked_with(other, far, near) {
            rooms.map(|room| room.min(-1))
        } else if rooms[0] < 0 && rooms[1] < 0 {
            [0, rooms[1]]
        } else {
            rooms
        }
    }

    /// Returns the bound of the roof on the receiver over an interval.
    pub(super) fn obstruction(&self, piece: usize, far: Crossing, near: Crossing) -> Obstruction {
        let (of_far, of_near) = (self.demand(far), self.demand(near));
        self.binding(piece, (far, near), if is_more(of_far, of_near) { (of_far, far) } else { (of_near, near) })
    }

    /// Returns the bound of this roof and another together on the receiver of a ray along the wall
    /// between them. It is rounded if both demand the same between the ends.
    pub(super) fn obstruction_with(&self, other: &Slope, piece: usize, far: Crossing, near: Crossing) -> Obstruction {
        let less = |at: Crossing| {
            let (a, b) = (self.demand(at), other.demand(at));
            if is_more(a, b) { b } else { a }
        };
        let (of_far, of_near) = (less(far), less(near));
        let binding = if is_more(of_far, of_near) { (of_far, far) } else { (of_near, near) };
        let known = self.binding(piece, (far, near), binding);
        let order = |at: Crossing| compare(self.demand(at), other.demand(at));
        if order(far) == order(near).reverse() && order(near) != Ordering::Equal {
            let [(a, at_a), (b, at_b)] = [self.line(), other.line()];
            return known.or_more(at_a + a * (at_b - at_a) / (a - b));
        }
        known
    }

    /// Returns the height above the UAV that the roof demands of the receiver, as a straight line
    /// in 1/t: its slope, and its value at 0.
    #[expect(clippy::cast_precision_loss, reason = "rounded")]
    fn line(&self) -> (f64, f64) {
        let area = self.area as f64;
        let level = self.receiver - i128::from(self.rise) * i128::from(self.area);
        (-(self.uav as f64) / area, (self.uav - level) as f64 / area)
    }

    /// Returns the height above the UAV that the roof demands of the receiver at a fraction of the
    /// way, as numerator and denominator. With denominator 0, no height is enough if the numerator
    /// is positive; otherwise any height is.
    fn demand(&self, at: Crossing) -> (i128, i128) {
        // Height above the plane of the receiver's place at the UAV's height.
        let level = self.receiver - i128::from(self.rise) * i128::from(self.area);
        let num = -(self.uav * i128::from(at.d - at.n) + level * i128::from(at.n));
        (num, i128::from(self.area) * i128::from(at.n))
    }

    fn binding(
        &self,
        piece: usize,
        (far, near): (Crossing, Crossing),
        ((num, den), at): ((i128, i128), Crossing),
    ) -> Obstruction {
        // The height of the roof at the binding end.
        let level = self.receiver - i128::from(self.rise) * i128::from(self.area);
        let below_uav = (self.uav * i128::from(at.d - at.n) + level * i128::from(at.n))
            .div_euclid(i128::from(self.area) * i128::from(at.d));
        let top = i32::try_from(i128::from(self.uav_z) - below_uav).unwrap_or(i32::MAX);
        Obstruction::of_bound(piece, top, self.uav_z, (num, den), (near, far))
    }
}

/// Returns `true` if demand `a` is more than demand `b`.
fn is_more(a: (i128, i128), b: (i128, i128)) -> bool {
    compare(a, b) == Ordering::Greater
}

/// Orders two demands; exact. At the UAV a roof above it demands every height, any other roof none.
fn compare(a: (i128, i128), b: (i128, i128)) -> Ordering {
    match (a.1, b.1) {
        (0, 0) => a.0.signum().cmp(&b.0.signum()),
        (0, _) if a.0 > 0 => Ordering::Greater,
        (0, _) => Ordering::Less,
        (_, 0) => compare(b, a).reverse(),
        _ => compare_ratios(a, b),
    }
}
