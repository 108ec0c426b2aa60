//! Antennas of UAVs.

use skyshed_core::city;

use crate::part::part;

part! {
    /// Receivers that the antennas of UAVs serve, unless a table of UAVs says so.
    #[derive(Copy)]
    pub struct Antenna, SetAntenna {
        /// Least horizontal distance from the UAV to a receiver [m]
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true, hide_short_help = true)]
        min_radius: Option<f64>,
        /// Azimuths of receivers in range, clockwise from grid north [deg]: 90,180 is the south-east
        ///
        /// From the first to before the second, so that 90,180 and 180,90 share no receiver. Like `--min-radius`, `--elevation`, `--beam` and `--slant-range`
        /// it says who is in range, never what blocks; columns of these names in `--uavs` (`slant_range`) say so of each UAV.
        #[arg(long, value_name = "AZ0,AZ1", value_parser = crate::words::pair, allow_hyphen_values = true, hide_short_help = true)]
        sector: Option<[f64; 2]>,
        /// Elevations of receivers in range, from the UAV's horizontal, negative below [deg]
        #[arg(long, value_name = "LO,HI", value_parser = crate::words::pair, allow_hyphen_values = true, hide_short_help = true)]
        elevation: Option<[f64; 2]>,
        /// Full angle of a cone straight down with the receivers in range [deg]
        #[arg(long, value_name = "DEG", value_parser = crate::words::number, allow_hyphen_values = true, hide_short_help = true)]
        beam: Option<f64>,
        /// Largest distance in space from the UAV to a receiver [m]
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true, hide_short_help = true)]
        slant_range: Option<f64>,
    }
}

impl Antenna {
    /// Returns the antenna as the engines take it.
    pub fn served(&self) -> city::Antenna {
        let Antenna { min_radius, sector, elevation, beam, slant_range } = *self;
        city::Antenna {
            min_radius_m: min_radius,
            sector_deg: sector,
            elevation_deg: elevation,
            beam_deg: beam,
            slant_range_m: slant_range,
        }
    }
}

impl From<city::Antenna> for Antenna {
    fn from(antenna: city::Antenna) -> Self {
        let city::Antenna { min_radius_m, sector_deg, elevation_deg, beam_deg, slant_range_m } = antenna;
        Antenna {
            min_radius: min_radius_m,
            sector: sector_deg,
            elevation: elevation_deg,
            beam: beam_deg,
            slant_range: slant_range_m,
        }
    }
}
