//! Errors of heights of buildings, and how closely probabilities under them are found.
//!
//! The top of building i is h_i + e_i + t: an error of its own, normal with standard deviation σ_i, and one
//! that all buildings share, normal with standard deviation τ. All are independent, with mean 0. Ground,
//! and where buildings are, is as it is known.

use std::sync::Arc;

use crate::quantity::STEPS_PER_UNIT;

/// Standard deviations of the errors that buildings have of their own \[m\].
#[derive(Debug, Clone, PartialEq)]
pub enum OwnErrors {
    /// One for all.
    Same(f64),
    /// One for each building, by its number.
    ByBuilding(Arc<[f64]>),
}

/// Errors of heights of buildings: normal ones of mean 0.
///
/// Probabilities under them are good to about 10⁻⁵, and to 2·10⁻⁴ for errors of 1 m along walls with
/// sloped roofs, where rooms are whole steps of the lattice. All tolerances behind that:
///
/// | constant | value | meaning | changes a probability by |
/// |---|---|---|---|
/// | `CERTAIN` | 6 | deviations beyond which errors are left out | 2·10⁻⁹ |
/// | `SHARED_CERTAIN` | 4.5 | the same of a shared error, where shadows are cast for its values | 7·10⁻⁶ |
/// | `STEP` | 0.75 | equal steps over all errors, against the shortest deviation | e^(−2π²/STEP²), 10⁻¹⁵ |
/// | `PART` | 1.5 | parts of five nodes between breaks, against the shortest deviation | 10⁻⁵ |
/// | `MOST_AT_STEP` | 3 | buildings on a link for which steps are that long, half beyond | – |
/// | `TINY` | 0.01 | own errors against others below which they are none | 10⁻⁵ |
/// | `MOST_BUILDINGS` | 4 | buildings on a link for which steps over shared errors are chosen | 10⁻⁸; a dozen 10⁻⁵ |
/// | `MOST_VALUES` | 96 | values of a shared error; more cost as much as walks | 0 |
/// | `TIE` | 10⁻³ steps | rooms of a building without an error that need a walk | 0 |
/// | `TABLE_STEPS` | 512 | values of Φ to a deviation, between which it is linear | 3·10⁻⁷ |
#[derive(Debug, Clone, PartialEq)]
pub struct HeightErrors {
    /// Errors of each building alone.
    pub own: OwnErrors,
    /// Standard deviation of the error that all buildings share \[m\].
    pub shared_m: f64,
}

pub(crate) const CERTAIN: f64 = 6.0;
pub(crate) const SHARED_CERTAIN: f64 = 4.5;
pub(crate) const STEP: f64 = 0.75;
pub(crate) const PART: f64 = 1.5;
pub(crate) const MOST_AT_STEP: usize = 3;
pub(crate) const TINY: f64 = 0.01;
pub(crate) const MOST_BUILDINGS: f64 = 4.0;
pub(crate) const MOST_VALUES: f64 = 96.0;
pub(crate) const TIE: f64 = 1e-3;
pub(crate) const TABLE_STEPS: f64 = 512.0;

impl Default for HeightErrors {
    /// Returns errors of 0.
    fn default() -> Self {
        HeightErrors::same(0.0, 0.0)
    }
}

impl HeightErrors {
    /// Returns errors of one size for all buildings: standard deviations of their own errors, and of the
    /// shared one \[m\].
    pub fn same(own_m: f64, shared_m: f64) -> Self {
        HeightErrors { own: OwnErrors::Same(own_m), shared_m }
    }

    /// Tells whether all are numbers that are not negative, one for each building.
    pub fn are_valid(&self, n_buildings: usize) -> bool {
        let is_valid = |m: &f64| *m >= 0.0 && m.is_finite();
        let own = match &self.own {
            OwnErrors::Same(m) => is_valid(m),
            OwnErrors::ByBuilding(of) => of.len() == n_buildings && of.iter().all(is_valid),
        };
        own && is_valid(&self.shared_m)
    }

    /// Returns the standard deviation of the error that a building has of its own \[m\].
    #[inline]
    pub fn own_m(&self, building: u32) -> f64 {
        match &self.own {
            OwnErrors::Same(m) => *m,
            OwnErrors::ByBuilding(of) => of[building as usize],
        }
    }

    /// Returns the standard deviation of the error of a building's height \[m\].
    pub fn of_building_m(&self, building: u32) -> f64 {
        self.own_m(building).hypot(self.shared_m)
    }

    /// Returns the standard deviation of a building's own error \[1/1024 m\].
    #[inline]
    pub(crate) fn own_steps(&self, building: u32) -> f64 {
        self.own_m(building) * f64::from(STEPS_PER_UNIT)
    }

    /// Returns the standard deviation of the shared error \[1/1024 m\].
    pub(crate) fn shared_steps(&self) -> f64 {
        self.shared_m * f64::from(STEPS_PER_UNIT)
    }
}
