//! Receivers, range and earth: the parts of every question about line of sight.

use skyshed_core::coverage::{self, SightNumbers};
use skyshed_core::height_field::HeightField;
use skyshed_core::los::MethodChoice;
use skyshed_core::quantity::{VOID, meters};
use skyshed_core::words;
use skyshed_core::zones::Zone;

use crate::part::{group, part};
use crate::{Antenna, EarthFactor, Fault, Meters, filled};

words! {
    /// Cells that hold receivers.
    #[non_exhaustive]
    pub enum Receivers {
        /// All cells of open ground
        Ground = "ground",
        /// Open ground that is neither crossroad nor courtyard
        Street = "street",
        /// Open ground at which three or more streets meet
        Crossroad = "crossroad",
        /// Open ground that buildings enclose
        Courtyard = "courtyard",
        /// Building cells, standing on the roof
        Roof = "roof",
        /// Ground and roofs
        All = "all",
        /// Over all ground, lower buildings included: where a drone may be
        Air = "air",
    }
    default Ground
}

part! {
    /// Height of the receivers.
    #[derive(Copy)]
    pub struct Receiver, SetReceiver {
        /// Height of the receivers above ground or roof [m]
        #[arg(long, value_name = "M", allow_hyphen_values = true)]
        rx_height: Option<Meters>,
    }
}

impl Receiver {
    /// Defaults of the fields.
    pub const DEFAULTS: Receiver = Receiver { rx_height: Some(Meters(1.5)) };

    /// Returns the height of the receivers above ground or roof \[m\].
    pub fn rx_height_m(&self) -> f64 {
        filled(self.rx_height, Receiver::DEFAULTS.rx_height).0
    }
}

part! {
    /// Cells that hold receivers, the range of UAVs and the engine.
    #[derive(Copy)]
    pub struct Range, SetRange {
        /// Cells that hold receivers: ground, street, roof, all …
        ///
        /// ground (all open), street, crossroad, courtyard, roof, all.
        #[arg(long, value_name = "WHERE", value_parser = crate::words::one_of::<Receivers>(), hide_possible_values = true)]
        receivers: Option<Receivers>,
        /// Largest horizontal distance from the UAV to a receiver [m]
        #[arg(long, value_name = "M", value_parser = crate::words::number, allow_hyphen_values = true)]
        radius: Option<f64>,
        /// Engine; auto is the fastest exact one
        ///
        /// ray (one ray per receiver), sweep (rasters) and shadow (footprints, rasters of flat blocks) are exact; step:K (a
        /// sample every K cells), xdraw and r2 (rasters) are approximate.
        #[arg(long, value_name = "METHOD")]
        method: Option<MethodChoice>,
    }
}

impl Range {
    /// Defaults of the fields.
    pub const DEFAULTS: Range =
        Range { receivers: Some(Receivers::Ground), radius: None, method: Some(MethodChoice::Auto) };

    /// Returns the cells that hold receivers.
    pub fn receiver_cells(&self) -> Receivers {
        filled(self.receivers, Range::DEFAULTS.receivers)
    }

    /// Returns the engine.
    pub fn engine(&self) -> MethodChoice {
        filled(self.method, Range::DEFAULTS.method)
    }
}

part! {
    /// Curve of the earth.
    #[derive(Copy)]
    pub struct Earth, SetEarth {
        /// Curved earth of K times its radius: 4/3 for radio, 7/6 for light, 1 without refraction, inf for none
        ///
        /// At a distance d the earth is lower by d²/(2·K·6 371 008.8 m). Without it the earth is flat.
        #[arg(long, value_name = "K", allow_hyphen_values = true, hide_short_help = true)]
        earth_k: Option<EarthFactor>,
        /// 1/K of a curved earth, GDAL's word for it: 0.85714 for light, 0.75 for radio, 0 for none
        #[arg(long, value_name = "C", value_parser = crate::words::number, allow_hyphen_values = true, conflicts_with = "earth_k",
              hide_short_help = true)]
        curvature_coefficient: Option<f64>,
    }
}

impl Earth {
    /// Returns K, if the earth is curved.
    pub fn k(&self) -> Option<f64> {
        self.earth_k.map(|k| k.0).or(self.curvature_coefficient.map(|c| 1.0 / c))
    }

    /// Refuses both spellings at once.
    ///
    /// # Errors
    /// E116.
    pub fn check(&self) -> crate::Result<()> {
        match (self.earth_k, self.curvature_coefficient) {
            (Some(_), Some(_)) => Err(Fault::idle("curvature_coefficient", "beside `earth_k`, which says the same")),
            _ => Ok(()),
        }
    }
}

group! {
    /// Question of line of sight: receivers, range, antennas and earth.
    pub struct Sight {
        /// Height of the receivers.
        receiver: Receiver,
        /// Cells with receivers, range and engine.
        range: Range,
        /// Antennas of UAVs without one of their own.
        antenna: Antenna,
        /// Curve of the earth.
        earth: Earth,
    }
}

impl Copy for Sight {}

crate::holds!(Sight: receiver Receiver, range Range, antenna Antenna, earth Earth);

impl Sight {
    /// Returns the numbers, for engines to check.
    ///
    /// # Errors
    /// E116 for two options that set the curve of the earth.
    pub fn numbers(&self) -> crate::Result<SightNumbers> {
        self.earth.check()?;
        Ok(SightNumbers {
            rx_height_m: self.receiver.rx_height_m(),
            radius_m: self.range.radius,
            antenna: self.antenna.served(),
            earth_k: self.earth.k(),
        })
    }
}

impl Receivers {
    /// Returns the zone that these receivers are limited to, if they are.
    pub fn zone(self) -> Option<Zone> {
        match self {
            Receivers::Street => Some(Zone::Street),
            Receivers::Crossroad => Some(Zone::Crossroad),
            Receivers::Courtyard => Some(Zone::Courtyard),
            Receivers::Ground | Receivers::Roof | Receivers::All | Receivers::Air => None,
        }
    }

    /// Returns the cells of a map that hold them; those of a zone are some of open ground.
    pub fn cells(self) -> coverage::Receivers {
        match self {
            Receivers::Roof => coverage::Receivers::Roof,
            Receivers::All => coverage::Receivers::All,
            Receivers::Air => coverage::Receivers::Air,
            Receivers::Ground | Receivers::Street | Receivers::Crossroad | Receivers::Courtyard => {
                coverage::Receivers::Ground
            }
        }
    }

    /// Returns the name of the other end of their links: `UAV`, or `observer` of places in the air.
    pub fn other_end(self) -> &'static str {
        if self == Receivers::Air { "observer" } else { "UAV" }
    }

    /// Returns the name of the other end with its article.
    pub fn an_other_end(self) -> &'static str {
        if self == Receivers::Air { "an observer" } else { "a UAV" }
    }

    /// Returns the noun that counts of receivers have.
    pub fn noun(self) -> &'static str {
        if self == Receivers::Air { "places in the air" } else { "receivers" }
    }

    /// Returns `true` if the other end, at a place and a height above the datum \[m\], is an observer on
    /// the ground or a roof. The live page draws the line at the same height.
    pub fn has_observer(self, field: &HeightField, (x, y): (f64, f64), height_amsl_m: f64) -> bool {
        const OBSERVER_BELOW_M: f64 = 20.0;
        let place = field.place(x, y);
        let below = field.roof_at(&place).unwrap_or_else(|| field.ground_at(&place));
        self == Receivers::Air && below != VOID && height_amsl_m - meters(below) < OBSERVER_BELOW_M
    }

    /// Returns the plural names of cells with a receiver, and of cells that hold none and have no class
    /// of their own in a picture.
    pub fn cell_names(self, field: &HeightField) -> (&'static str, &'static str) {
        match self {
            _ if field.is_surface_only() => ("surface cells", "Nodata"),
            Receivers::Ground => ("open-ground cells", "Buildings"),
            Receivers::Street => ("street cells", "Buildings"),
            Receivers::Crossroad => ("crossroad cells", "Buildings"),
            Receivers::Courtyard => ("courtyard cells", "Buildings"),
            Receivers::Roof => ("roof cells", "Open ground"),
            Receivers::All => ("cells", "Nodata"),
            Receivers::Air => ("places in the air", "Higher buildings"),
        }
    }
}
