//! The plane of a sloped roof, in integers.

use std::cmp::Ordering;

use crate::quantity::{LatticePoint, VOID};

/// Corners of one sloped roof differ by at most this along each axis \[lattice steps\]: 1024 m.
/// Decisions about links are products of integers then that 128 bits hold.
pub const MAX_ROOF_STEPS: i32 = 1 << 20;

/// The plane through the upper edges of a convex piece whose corners have heights of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RoofPlane {
    /// A corner: position \[lattice steps\] and height \[1/1024 m above the datum\].
    corner: [i64; 3],
    /// Rise of the plane along one step to the east and to the north, times `area`.
    rise: [i64; 2],
    /// Twice the area of the triangle of the first three corners, above 0.
    area: i64,
}

impl RoofPlane {
    /// Returns the plane through the first three corners of a ring that turns left at the second.
    #[inline]
    pub fn through(ring: &[[i32; 2]], heights: &[i32]) -> RoofPlane {
        let corner = |k: usize| [ring[k][0], ring[k][1], heights[k]].map(i64::from);
        let [a, b, c] = [corner(0), corner(1), corner(2)];
        let to = |p: [i64; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
        let ([bx, by, bz], [cx, cy, cz]) = (to(b), to(c));
        RoofPlane { corner: a, rise: [bz * cy - cz * by, cz * bx - bz * cx], area: bx * cy - by * cx }
    }

    /// Returns how far a point is above the plane, times [`area`](RoofPlane::area); exact.
    #[inline]
    pub fn above(&self, p: LatticePoint) -> i128 {
        let [x, y, z] = self.corner;
        let straight = i128::from(p.z - z) * i128::from(self.area);
        straight - i128::from(self.rise[0]) * i128::from(p.x - x) - i128::from(self.rise[1]) * i128::from(p.y - y)
    }

    /// Returns the factor of distances above the plane.
    #[inline]
    pub fn area(&self) -> i64 {
        self.area
    }

    /// Returns the rise of the plane along one step to the east and to the north, times
    /// [`area`](RoofPlane::area).
    #[inline]
    pub fn rise(&self) -> [i64; 2] {
        self.rise
    }

    /// Returns the lowest lattice height that is not below the plane at a position within the roof
    /// \[1/1024 m above the datum\]. Lattice heights are below the plane if and only if they are
    /// below this.
    #[inline]
    pub fn lowest_above(&self, x: i64, y: i64) -> i32 {
        let above = self.above(LatticePoint { x, y, z: 0 });
        i32::try_from(-above.div_euclid(i128::from(self.area))).unwrap_or(VOID)
    }

    /// Returns the height of the plane at a position within the roof; exact.
    pub(super) fn exact_height(&self, x: i64, y: i64) -> RoofHeight {
        RoofHeight { num: -self.above(LatticePoint { x, y, z: 0 }), den: self.area }
    }

    /// Its height at a position \[1/1024 m above the datum\], rounded.
    #[expect(clippy::cast_precision_loss, reason = "rounded")]
    pub fn height(&self, x: f64, y: f64) -> f64 {
        let [cx, cy, z] = self.corner.map(|v| v as f64);
        z + (self.rise[0] as f64 * (x - cx) + self.rise[1] as f64 * (y - cy)) / self.area as f64
    }

    /// Returns a key that no other plane has.
    pub(super) fn key(&self) -> [i128; 4] {
        let [x, y] = self.rise.map(i128::from);
        let at_zero = -self.above(LatticePoint { x: 0, y: 0, z: 0 });
        let all = [x, y, at_zero, i128::from(self.area)];
        let divisor = all.iter().fold(0, |a, b| common_divisor(a, *b));
        all.map(|v| v / divisor.max(1))
    }
}

/// An exact height of a roof: `num / den` \[1/1024 m above the datum\].
///
/// Within a roof `num` is below 2^70 and `den` at most 2^41, so heights compare in 128 bits.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RoofHeight {
    /// Numerator.
    pub(crate) num: i128,
    /// Denominator, above 0.
    pub(crate) den: i64,
}

impl RoofHeight {
    /// Returns the height of a flat roof.
    pub(super) fn level(top: i32) -> RoofHeight {
        RoofHeight { num: i128::from(top), den: 1 }
    }
}

impl Ord for RoofHeight {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.num * i128::from(other.den)).cmp(&(other.num * i128::from(self.den)))
    }
}

impl PartialOrd for RoofHeight {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for RoofHeight {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for RoofHeight {}

/// Returns the greatest common divisor of two integers, of 0 and another that other.
fn common_divisor(a: i128, b: i128) -> i128 {
    let (mut a, mut b) = (a.abs(), b.abs());
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_holds_its_corners_and_tells_which_lattice_heights_are_below_it() {
        // Rises by 1 in 3 to the east, and falls by 1 in 2 to the north.
        let ring = [[-4, 7], [5, 7], [-1, 13]];
        let plane = RoofPlane::through(&ring, &[100, 103, 98]);
        for ([x, y], z) in ring.iter().zip([100, 103, 98]) {
            assert_eq!(plane.above(LatticePoint { x: i64::from(*x), y: i64::from(*y), z }), 0);
        }
        assert_eq!(plane.above(LatticePoint { x: -4, y: 7, z: 101 }), i128::from(plane.area()));
        // 100 + 1/3, 100 + 2/3 − 1/2, 100 − 1/2.
        assert_eq!([(-3, 7), (-2, 8), (-4, 8)].map(|(x, y)| plane.lowest_above(x, y)), [101, 101, 100]);
        assert_eq!(plane.lowest_above(-1, 7), 101);
        let other = RoofPlane::through(&[[5, 7], [-1, 13], [-4, 7]], &[103, 98, 100]);
        assert_eq!(plane.key(), other.key());
        assert_ne!(plane.key(), RoofPlane::through(&ring, &[101, 104, 99]).key());
    }
}
