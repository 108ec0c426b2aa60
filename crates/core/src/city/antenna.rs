//! The antenna of a UAV: the distances and directions that it serves, as typed.

use std::fmt::Write as _;

use crate::quantity::tidy;

/// Limits of a UAV's antenna. A receiver beyond them is out of range. The antenna limits range and
/// blocks nothing.
///
/// A field that is `None` sets no limit, or leaves it to the run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Antenna {
    /// Least horizontal distance to a receiver \[m\], included.
    pub min_radius_m: Option<f64>,
    /// Azimuths of receivers \[deg from grid north\], clockwise from the first (included) to the
    /// second (excluded). A sector and its complement together serve every receiver exactly once. A
    /// receiver straight above or below the UAV is to the north.
    pub sector_deg: Option<[f64; 2]>,
    /// Least and largest elevation angle of receivers \[deg above the UAV's horizontal, negative
    /// below\], both included.
    pub elevation_deg: Option<[f64; 2]>,
    /// Full angle of a cone straight down \[deg\], its surface included.
    pub beam_deg: Option<f64>,
    /// Largest distance in space to a receiver \[m\], included.
    pub slant_range_m: Option<f64>,
}

/// The fault of an antenna: the value's name, what was found and what was wanted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{what}: found {found}, wanted {wanted}")]
pub struct AntennaFault {
    /// The name of the value.
    pub what: &'static str,
    /// The value as typed.
    pub found: String,
    /// The permitted values.
    pub wanted: &'static str,
}

impl Antenna {
    /// Fills in the limits that are `None` from another antenna.
    #[must_use]
    pub fn or(self, other: Antenna) -> Antenna {
        Antenna {
            min_radius_m: self.min_radius_m.or(other.min_radius_m),
            sector_deg: self.sector_deg.or(other.sector_deg),
            elevation_deg: self.elevation_deg.or(other.elevation_deg),
            beam_deg: self.beam_deg.or(other.beam_deg),
            slant_range_m: self.slant_range_m.or(other.slant_range_m),
        }
    }

    /// Refuses values out of range.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn checked(self) -> Result<Antenna, AntennaFault> {
        let fault = |what, found: String, wanted| Err(AntennaFault { what, found, wanted });
        let pair = |[a, b]: [f64; 2]| format!("{},{}", tidy(a), tidy(b));
        match self.min_radius_m {
            Some(r) if !(r.is_finite() && r >= 0.0) => return fault("the least radius", tidy(r), "0 m or more"),
            _ => {}
        }
        match self.slant_range_m {
            Some(r) if !(r.is_finite() && r > 0.0) => return fault("the slant range", tidy(r), "above 0 m"),
            _ => {}
        }
        if let Some([from, to]) = self.sector_deg {
            let is_azimuth = |v: f64| (-360.0..=360.0).contains(&v);
            let is_empty = to <= from && (to - from).rem_euclid(360.0) == 0.0;
            if !is_azimuth(from) || !is_azimuth(to) || is_empty {
                let wanted = "two azimuths from −360° to 360° that differ, clockwise from the first, 0,360 for all";
                return fault("the sector", pair([from, to]), wanted);
            }
        }
        if let Some([low, high]) = self.elevation_deg
            && !(-90.0 <= low && low <= high && high <= 90.0)
        {
            return fault("the elevation", pair([low, high]), "two angles from −90° to 90°, the lower one first");
        }
        match self.beam_deg {
            Some(b) if !(b > 0.0 && b <= 360.0) => fault("the beam", tidy(b), "above 0° and at most 360°"),
            _ => Ok(self),
        }
    }

    /// Returns the elevation angles served \[deg\], from elevation and beam together; `None` if all
    /// are.
    pub fn elevations_deg(&self) -> Option<[f64; 2]> {
        // The cone around straight down holds every direction no higher than its side.
        let beam = self.beam_deg.map(|b| [-90.0, b / 2.0 - 90.0]);
        match (self.elevation_deg, beam) {
            (Some(a), Some(b)) => Some([a[0].max(b[0]), a[1].min(b[1])]),
            (a, b) => a.or(b),
        }
    }

    /// Returns `true` if heights of receivers decide who is in range.
    pub fn limits_heights(&self) -> bool {
        self.elevations_deg().is_some() || self.slant_range_m.is_some()
    }

    /// Describes the antenna for captions; empty if it serves all receivers.
    pub fn in_words(&self) -> String {
        let mut words = String::new();
        let deg = |v: f64| tidy(v).replace('-', "−");
        if let Some(r) = self.min_radius_m {
            let _ = write!(words, ", from {} m on", tidy(r));
        }
        if let Some([from, to]) = self.sector_deg {
            let _ = write!(words, ", azimuths {}° to {}°", deg(from), deg(to));
        }
        if let Some([low, high]) = self.elevation_deg {
            let _ = write!(words, ", elevations {}° to {}°", deg(low), deg(high));
        }
        if let Some(b) = self.beam_deg {
            let _ = write!(words, ", beam {}°", deg(b));
        }
        if let Some(r) = self.slant_range_m {
            let _ = write!(words, ", slant range {} m", tidy(r));
        }
        words.trim_start_matches(", ").to_string()
    }
}
