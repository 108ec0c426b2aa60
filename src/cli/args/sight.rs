//! `--uav`, `--uavs`, `--rx-height`, `--receivers`, `--radius`, `--method`: their words and their defaults.

use std::path::PathBuf;

use clap::Args;

use super::words::{RECEIVERS, fraction, length, number, one_of, pair};
use crate::city::{Antenna, Site};
use crate::cli::failure::{Result, refusal, refusal_with};
use crate::los::MethodChoice;
use crate::quantity::{Height, parse_number};
use crate::sight::{AskedSight, Receivers, Sight};
use crate::uav::UavsAsked;

/// Some UAVs.
#[derive(Debug, Clone, Args)]
pub(crate) struct UavsArgs {
    /// A UAV: x, y and height, as 120, 150amsl or 30roof; repeat for more
    ///
    /// x and y are in the scene's CRS; heights are 120, 120agl, 30roof, 150amsl, 400ft.
    #[arg(long, value_name = "X,Y,H", allow_hyphen_values = true)]
    pub(crate) uav: Vec<String>,
    /// UAVs from a table (.csv) or points (.geojson)
    ///
    /// Columns are x,y,h or lon,lat,h; `-` is standard input.
    #[arg(long, value_name = "FILE")]
    pub(crate) uavs: Option<PathBuf>,
    /// Leave out rows of the table that cannot be read, with a warning that names them
    #[arg(long, requires = "uavs", hide_short_help = true)]
    skip_bad: bool,
}

impl UavsArgs {
    /// Where they are told; those of the command line are well-formed.
    pub(crate) fn asked(&self, hash: bool) -> Result<UavsAsked> {
        let typed = self.uav.iter().enumerate().map(|(k, text)| parse_uav(text, (k + 1).to_string()));
        let typed = typed.collect::<Result<_>>()?;
        Ok(UavsAsked { typed, table: self.uavs.clone(), skips_bad: self.skip_bad, hash, shard: None })
    }

    /// Where they are told, of which there must be some; `without` says how the command does without.
    pub(crate) fn some(&self, hash: bool, without: Option<&str>) -> Result<UavsAsked> {
        if self.uav.is_empty() && self.uavs.is_none() {
            let text = "no UAV: wanted `--uav X,Y,H` or `--uavs FILE`";
            return Err(without.map_or_else(|| refusal(108, text), |remedy| refusal_with(108, text, remedy)));
        }
        self.asked(hash)
    }
}

/// A UAV as typed: `X,Y,H`.
///
/// E102: a text that is no UAV.
pub(crate) fn parse_uav(text: &str, id: String) -> Result<Site> {
    let wrong = |found: String| {
        refusal_with(
            102,
            format!("cannot read `--uav {text}`: {found}"),
            "write X,Y,H, for example `500,500,100` or `691549.7,5334762.2,30roof`",
        )
    };
    let parts: Vec<&str> = text.split(',').collect();
    let [x, y, h] = parts[..] else { return Err(wrong(format!("found {} values, wanted X,Y,H", parts.len()))) };
    let x = parse_number(x).map_err(|e| wrong(format!("x: {e}")))?;
    let y = parse_number(y).map_err(|e| wrong(format!("y: {e}")))?;
    Ok(Site::new(id, (x, y), h.parse().map_err(wrong)?))
}

/// A receiver as typed: `X,Y[,H]`.
///
/// E103: a text that is no receiver.
pub(crate) fn parse_receiver(text: &str, rx_height_m: f64) -> Result<((f64, f64), Height)> {
    let wrong = |found: String| {
        refusal_with(
            103,
            format!("cannot read `--rx {text}`: {found}"),
            "write X,Y or X,Y,H, for example `630,480` or `620,480,1.5roof`",
        )
    };
    let parts: Vec<&str> = text.split(',').collect();
    let (x, y, h) = match parts[..] {
        [x, y] => (x, y, None),
        [x, y, h] => (x, y, Some(h)),
        _ => return Err(wrong(format!("found {} values, wanted X,Y or X,Y,H", parts.len()))),
    };
    let x = parse_number(x).map_err(|e| wrong(format!("x: {e}")))?;
    let y = parse_number(y).map_err(|e| wrong(format!("y: {e}")))?;
    let height = h.map_or(Ok(Height::AboveGround(rx_height_m)), str::parse).map_err(wrong)?;
    Ok(((x, y), height))
}

/// The height of receivers.
#[derive(Debug, Clone, Args)]
pub(crate) struct RxHeightArgs {
    /// Height of the receivers above ground or roof [m]
    #[arg(long = "rx-height", value_name = "M", value_parser = length, default_value = "1.5", allow_hyphen_values = true)]
    pub(crate) rx_height: f64,
}

impl RxHeightArgs {
    /// Receivers of this height on open ground, at any distance, by the fastest exact engine.
    pub(crate) fn sight(&self, earth: &EarthArgs) -> Result<Sight> {
        let (rx_height_m, earth_k) = (self.rx_height, earth.earth_k());
        Ok(AskedSight { rx_height_m, earth_k, ..AskedSight::default() }.checked()?)
    }
}

/// What the antennas of UAVs serve, unless a table of them says so.
#[derive(Debug, Clone, Args)]
pub(crate) struct AntennaArgs {
    /// Least horizontal distance from the UAV to a receiver [m]
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true, hide_short_help = true)]
    min_radius: Option<f64>,
    /// Azimuths of receivers in range, clockwise from grid north [deg]: 90,180 is the south-east
    ///
    /// From the first to before the second, so that 90,180 and 180,90 share no receiver. Like `--min-radius`, `--elevation` and `--beam` it
    /// says who is in range, never what blocks; columns `min_radius`, `sector`, `elevation` and `beam` of `--uavs` say so of each UAV.
    #[arg(long, value_name = "AZ0,AZ1", value_parser = pair, allow_hyphen_values = true, hide_short_help = true)]
    sector: Option<[f64; 2]>,
    /// Elevations of receivers in range, from the UAV's horizontal, negative below [deg]
    #[arg(long, value_name = "LO,HI", value_parser = pair, allow_hyphen_values = true, hide_short_help = true)]
    elevation: Option<[f64; 2]>,
    /// Full angle of a cone straight down with the receivers in range [deg]
    #[arg(long, value_name = "DEG", value_parser = number, allow_hyphen_values = true, hide_short_help = true)]
    beam: Option<f64>,
}

impl AntennaArgs {
    fn antenna(&self) -> Antenna {
        let AntennaArgs { min_radius, sector, elevation, beam } = *self;
        Antenna { min_radius_m: min_radius, sector_deg: sector, elevation_deg: elevation, beam_deg: beam }
    }
}

/// The curve of the earth.
#[derive(Debug, Clone, Args)]
pub(crate) struct EarthArgs {
    /// Curved earth of K times its radius: 4/3 for radio, 7/6 for light, 1 without refraction, inf for none
    ///
    /// At a distance d the earth is lower by d²/(2·K·6 371 008.8 m). Without it the earth is flat.
    #[arg(long, value_name = "K", value_parser = fraction, allow_hyphen_values = true, hide_short_help = true)]
    earth_k: Option<f64>,
    /// 1/K of a curved earth, GDAL's word for it: 0.85714 for light, 0.75 for radio, 0 for none
    #[arg(long, value_name = "C", value_parser = number, allow_hyphen_values = true, conflicts_with = "earth_k",
          hide_short_help = true)]
    curvature_coefficient: Option<f64>,
}

impl EarthArgs {
    pub(crate) fn earth_k(&self) -> Option<f64> {
        self.earth_k.or(self.curvature_coefficient.map(|c| 1.0 / c))
    }
}

/// How line of sight is asked for.
#[derive(Debug, Clone, Args)]
pub(crate) struct SightArgs {
    #[command(flatten)]
    rx: RxHeightArgs,
    /// Which cells hold receivers: ground, street, roof, all …
    ///
    /// ground (all open), street, crossroad, courtyard, roof, all.
    #[arg(long, value_name = "WHERE", value_parser = one_of(RECEIVERS), default_value = "ground",
          hide_possible_values = true)]
    receivers: Receivers,
    /// Largest horizontal distance from the UAV to a receiver [m]
    #[arg(long, value_name = "M", value_parser = number, allow_hyphen_values = true)]
    radius: Option<f64>,
    #[command(flatten)]
    antenna: AntennaArgs,
    #[command(flatten)]
    earth: EarthArgs,
    /// Engine; auto is the fastest exact one
    ///
    /// ray (one ray per receiver), sweep (rasters) and shadow (footprints, rasters of flat blocks) are exact; step:K (a
    /// sample every K cells), xdraw and r2 (rasters) are approximate.
    #[arg(long, value_name = "METHOD", default_value = "auto")]
    method: MethodChoice,
}

impl SightArgs {
    /// As the library takes it; numbers out of range are refused.
    pub(crate) fn checked(&self) -> Result<Sight> {
        let SightArgs { rx, receivers, radius, antenna, earth, method } = self;
        let asked = AskedSight {
            receivers: *receivers,
            rx_height_m: rx.rx_height,
            radius_m: *radius,
            antenna: antenna.antenna(),
            earth_k: earth.earth_k(),
            method: *method,
        };
        Ok(asked.checked()?)
    }

    /// Height of the receivers \[m\].
    pub(crate) fn rx_height_m(&self) -> f64 {
        self.rx.rx_height
    }

    /// The engine.
    pub(crate) fn method(&self) -> MethodChoice {
        self.method
    }
}
