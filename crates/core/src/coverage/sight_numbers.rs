//! Numbers of a request for line of sight, as they are typed, and which of them can be.

use std::borrow::Cow;

use crate::city::{Antenna, AntennaFault};
use crate::height_field::Curvature;
use crate::quantity::{OutOfRange, height_steps, tidy};

/// Numbers of a request for line of sight, not yet checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SightNumbers {
    /// Height of the receivers above what they stand on \[m\].
    pub rx_height_m: f64,
    /// Largest horizontal distance \[m\]; `None` without a limit.
    pub radius_m: Option<f64>,
    /// Receivers that the antenna of a UAV serves.
    pub antenna: Antenna,
    /// K of a curved earth; `None`, and infinity, for a flat one.
    pub earth_k: Option<f64>,
}

/// Numbers of a request for line of sight as maps take them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CheckedNumbers {
    /// Height of the receivers \[1/1024 m\].
    pub rx_height: i32,
    /// The antenna.
    pub antenna: Antenna,
    /// The curve of the earth; `None` for a flat one.
    pub curvature: Option<Curvature>,
}

/// The first number that cannot be.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NumberFault {
    /// A height, a distance or K.
    #[error(transparent)]
    Range(#[from] OutOfRange),
    /// A number of the antenna.
    #[error(transparent)]
    Antenna(#[from] AntennaFault),
}

impl SightNumbers {
    /// Refuses numbers out of range.
    ///
    /// # Errors
    /// The first number that cannot be.
    pub fn checked(self) -> Result<CheckedNumbers, NumberFault> {
        let SightNumbers { rx_height_m, radius_m, antenna, earth_k } = self;
        let rx_height = receiver_height(rx_height_m)?;
        if let Some(r) = radius_m {
            check_radius(r)?;
        }
        let curvature = match earth_k {
            // An earth without an end is flat.
            Some(k) if k == f64::INFINITY => None,
            Some(k) => Some(Curvature::of_earth_k(k).ok_or_else(|| out_of_range("K of the earth", k, "above 0"))?),
            None => None,
        };
        let antenna = antenna.checked()?;
        match (antenna.min_radius_m, radius_m) {
            (Some(min), Some(r)) if min > r => {
                Err(out_of_range("the least radius", min, format!("at most the radius, {} m", tidy(r))).into())
            }
            _ => Ok(CheckedNumbers { rx_height, antenna, curvature }),
        }
    }
}

/// Returns the height of receivers on the lattice \[1/1024 m\].
///
/// # Errors
/// A height out of range.
pub fn receiver_height(height_m: f64) -> Result<i32, OutOfRange> {
    let steps = height_steps(height_m).filter(|h| *h >= 0);
    steps.ok_or_else(|| out_of_range("the receivers' height", height_m, "0 m to 32768 m"))
}

/// Refuses a radius \[m\] within which there is nothing.
///
/// # Errors
/// A radius out of range.
pub fn check_radius(radius_m: f64) -> Result<(), OutOfRange> {
    // No number at all is not above 0 either.
    if radius_m > 0.0 { Ok(()) } else { Err(out_of_range("the radius", radius_m, "above 0 m")) }
}

/// Refuses an error of heights \[m\] that is no length, or larger than any city has. `what` names
/// it.
///
/// # Errors
/// An error of heights out of range.
pub fn check_height_error(what: &'static str, error_m: f64) -> Result<(), OutOfRange> {
    let is_fine = (0.0..=1000.0).contains(&error_m);
    if is_fine { Ok(()) } else { Err(out_of_range(what, error_m, "0 m to 1000 m")) }
}

fn out_of_range(what: &'static str, found: f64, wanted: impl Into<Cow<'static, str>>) -> OutOfRange {
    OutOfRange { what, found, wanted: wanted.into() }
}
