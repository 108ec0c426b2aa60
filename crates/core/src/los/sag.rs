//! The sag of a link over a curved earth, and a test for a link below a roof.
//!
//! Heights are measured from the datum, which is curved like the earth, so a straight ray is a
//! curve in them. At the fraction t of the way it is lower by b·t(1 − t) than the line between the
//! heights of its ends. Here b = L²/2KR for a length L. Over a roof at H the difference is a convex
//! quadratic in t:
//!
//! ```text
//!   f(t) = (h_U − H) + t·dz − b·t(1 − t),   least at t* = (b − dz)/2b,   f(t*) = (h_U − H) − (b − dz)²/4b
//! ```
//!
//! The ray is below the roof somewhere on an interval if and only if f is negative at an end of it,
//! or at t* in between. The ends are quotients of integers and b is a fraction of integers, so all
//! three tests are comparisons of integer products.

use ethnum::I256;

use super::cell_walk::Crossing;
use crate::height_field::{Bulge, CurvedGround};

/// The sag of one link.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sag {
    bulge: Bulge,
    /// Square of the length in the plane \[lattice steps\].
    length_squared: i64,
    /// b \[1/1024 m\].
    scale: f64,
}

/// Relative error of the filter in doubles, several times that of its few operations.
const FILTER: f64 = 1e-14;

impl Sag {
    /// Returns the sag of a link with this extent in the plane \[lattice steps\]; `None` over a
    /// flat earth.
    #[inline]
    pub(super) fn new(earth: Option<CurvedGround>, dx: i64, dy: i64) -> Option<Sag> {
        let CurvedGround { bulge, .. } = earth?;
        let length_squared = dx * dx + dy * dy;
        #[expect(clippy::cast_precision_loss, reason = "used with a margin")]
        let scale = bulge.coefficient() * length_squared as f64;
        Some(Sag { bulge, length_squared, scale })
    }

    /// Returns b, rounded \[1/1024 m\].
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }

    /// Returns the largest sag \[1/1024 m\], rounded up.
    pub(super) fn most(&self) -> i64 {
        #[expect(clippy::cast_possible_truncation, reason = "farther than all heights")]
        let most = (self.scale * (0.25 * (1.0 + FILTER))).ceil().min(1e12) as i64;
        most
    }

    /// Returns the largest sag between two fractions of the way \[1/1024 m\], up to rounding.
    #[inline]
    pub(super) fn most_between(&self, from: f64, to: f64) -> f64 {
        let middle = 0.5_f64.clamp(from.min(to), to.max(from));
        self.scale * middle * (1.0 - middle)
    }

    /// Returns the rise at the end of a link that makes up for its sag at fraction t of the way
    /// from the pivot: b(1 − t).
    pub(super) fn rise_at_end(&self, t: f64) -> f64 {
        self.scale * (1.0 - t)
    }

    /// Returns the fraction of the way at which an obstacle `below` the pivot \[1/1024 m\] needs
    /// the highest end.
    pub(super) fn binding(&self, below: f64) -> f64 {
        (below / self.scale).sqrt()
    }

    /// Returns `true` if a link that begins `above` a roof and rises by `dz` \[1/1024 m\] is below
    /// it somewhere between two fractions of the way. Exact.
    pub(super) fn dips(&self, above: i64, dz: i64, from: Crossing, to: Crossing) -> bool {
        #[expect(clippy::cast_precision_loss, reason = "filtered: decided in integers where rounding could matter")]
        let [a, z, from_t, to_t] = [above as f64, dz as f64, from.n as f64 / from.d as f64, to.n as f64 / to.d as f64];
        let b = self.scale;
        let size = a.abs() + z.abs() + b;
        let at = |t: f64| a + t * z - b * t * (1.0 - t);
        let ends = at(from_t).min(at(to_t));
        let lowest = 0.5 - z / (2.0 * b);
        if ends < -FILTER * size {
            return true;
        }
        let may_turn = lowest > from_t - 1e-9 && lowest < to_t + 1e-9;
        if ends > FILTER * size && (!may_turn || at(lowest.clamp(0.0, 1.0)) > FILTER * size) {
            return false;
        }
        self.is_below_at(above, dz, from) || self.is_below_at(above, dz, to) || self.dips_between(above, dz, from, to)
    }

    /// Returns `true` if the link is below the roof at its lowest point, and that is strictly
    /// between two fractions of the way. Exact.
    pub(super) fn dips_between(&self, above: i64, dz: i64, from: Crossing, to: Crossing) -> bool {
        // t* > n/d  ⇔  (b − dz)·d > 2b·n, all times 2^shift.
        let (b, fall) = (self.b(), self.b() - (wide(dz) << self.bulge.shift()));
        let is_after = |c: Crossing| fall * wide(c.d) > b * wide(2 * c.n);
        let is_before = |c: Crossing| fall * wide(c.d) < b * wide(2 * c.n);
        // If it turns in between, |dz| is below b, so the square is at most 2^180.
        is_after(from) && is_before(to) && wide(4 * above) * b * (I256::ONE << self.bulge.shift()) < fall * fall
    }

    /// Returns `true` if the link is below the roof at a fraction of the way.
    ///
    /// Exact: lengths are up to 2^28, heights up to 2^27 and fractions up to 2^57, so all products
    /// are below 2^254.
    fn is_below_at(&self, above: i64, dz: i64, at: Crossing) -> bool {
        let (n, d) = (wide(at.n), wide(at.d));
        let straight = (wide(above) * d + n * wide(dz)) * d;
        (straight << self.bulge.shift()) < self.b() * n * (d - n)
    }

    /// Returns b times 2^shift.
    fn b(&self) -> I256 {
        wide(self.length_squared) * I256::from(self.bulge.mantissa())
    }
}

fn wide(v: i64) -> I256 {
    I256::from(v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::height_field::Curvature;

    /// Returns the sag of a link of 2^20 steps over an earth so curved that it sags by 1024 steps
    /// in the middle: b = 4096.
    fn sag() -> Sag {
        let earth_k = (1_u64 << 40) as f64 / (2.0 * 6_371_008.8 * 4096.0 * 1024.0);
        let bulge = Bulge::new(Curvature::of_earth_k(earth_k).expect("above 0"), 1.0).expect("bends");
        let sag = Sag::new(Some(CurvedGround { bulge, ground: None }), 1 << 20, 0).expect("curved");
        assert!((sag.scale - 4096.0).abs() < 1e-5, "{}", sag.scale);
        sag
    }

    #[test]
    fn a_level_link_dips_by_a_quarter_of_b_in_the_middle_and_nowhere_more() {
        let (sag, end) = (sag(), |n: i64| Crossing { n, d: 8 });
        // Rounded up.
        assert_eq!(sag.most(), 1025);
        assert!(sag.dips(1023, 0, end(0), end(8)) && sag.dips(1023, 0, end(3), end(5)));
        assert!(!sag.dips(1025, 0, end(0), end(8)) && !sag.dips(1023, 0, end(0), end(3)));
        // At an eighth of the way it is lower by 448.
        assert!(sag.dips(447, 0, end(0), end(1)) && !sag.dips(449, 0, end(0), end(1)));
        assert!(sag.dips(447, 0, end(7), end(8)) && !sag.dips(449, 0, end(7), end(8)));
        assert!(sag.dips_between(1023, 0, end(0), end(8)) && !sag.dips_between(1023, 0, end(4), end(8)));
        // Steeper than the curve there is no lowest place between the ends.
        assert!(!sag.dips_between(0, -4100, end(0), end(8)) && sag.dips(0, -4100, end(0), end(8)));
    }
}
