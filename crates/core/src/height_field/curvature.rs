//! The curve of the earth, and how far it falls away on the lattice of prisms.

use crate::quantity::STEPS_PER_UNIT;

/// Mean radius of the Earth \[m\], of the ellipsoid WGS 84.
pub const EARTH_RADIUS_M: f64 = 6_371_008.8;

/// The curve of the earth, as rays see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Curvature {
    earth_k: f64,
}

impl Curvature {
    /// Returns the curve of an earth with K times its radius, K above 0; `None` of other numbers.
    pub fn of_earth_k(earth_k: f64) -> Option<Self> {
        (earth_k.is_finite() && earth_k > 0.0).then_some(Curvature { earth_k })
    }

    /// Returns K, by which the radius of the earth is multiplied.
    pub fn earth_k(self) -> f64 {
        self.earth_k
    }

    /// Returns how far the earth falls away at a distance \[m\].
    pub fn drop_m(self, distance_m: f64) -> f64 {
        distance_m * distance_m / (2.0 * self.earth_k * EARTH_RADIUS_M)
    }
}

/// Fall of the earth on the lattice of prisms: `coefficient · d²` \[1/1024 m\] at a distance of d
/// lattice steps.
///
/// The coefficient is 1024 s²/2KR, with steps of s meters. It is rounded once, to a fraction that
/// integers hold, which puts the drop off by less than a part in 2^31. What prisms hide is exact
/// about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bulge {
    mantissa: u32,
    shift: u32,
}

/// Fractions have at most so many binary digits, so that 256 bits hold what is compared.
const MOST_SHIFT: i32 = 110;

impl Bulge {
    /// Returns the fall of a curvature on a lattice of whose steps 1024 are so many meters; `None`
    /// for one so small that no height differs.
    pub fn new(curvature: Curvature, meters_per_unit: f64) -> Option<Self> {
        let steps = f64::from(STEPS_PER_UNIT);
        let coefficient = steps * curvature.drop_m(meters_per_unit / steps);
        // The power of two by which 32 bits stand before the point.
        #[expect(clippy::cast_possible_truncation, reason = "exponents of doubles are small")]
        let shift = 31_i32.saturating_sub(coefficient.log2().floor() as i32).clamp(0, MOST_SHIFT);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let mantissa = (coefficient * 2_f64.powi(shift)).round() as u32;
        (mantissa > 0).then_some(Bulge { mantissa, shift: shift.unsigned_abs() })
    }

    /// Returns the numerator of the coefficient.
    pub(crate) fn mantissa(self) -> u32 {
        self.mantissa
    }

    /// Returns the power of two below it.
    pub(crate) fn shift(self) -> u32 {
        self.shift
    }

    /// Returns the coefficient, exact.
    pub fn coefficient(self) -> f64 {
        f64::from(self.mantissa) * 2_f64.powi(-self.shift.cast_signed())
    }
}
