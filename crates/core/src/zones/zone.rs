//! The four zones, their words, codes and colors.

crate::words! {
    /// Kind of place in a city, in the order of their codes.
    pub enum Zone {
        /// Open ground that is neither crossroad nor courtyard
        Street = "street",
        /// Open ground at which three or more streets meet
        Crossroad = "crossroad",
        /// Open ground that buildings enclose
        Courtyard = "courtyard",
        /// Buildings
        Rooftop = "rooftop",
    }
}

/// The code of a cell without a zone: nodata, or any cell of a surface model alone, which shows no
/// buildings.
pub const NONE: u8 = 0;

impl Zone {
    /// Its number in rasters, from 1.
    pub fn code(self) -> u8 {
        match self {
            Zone::Street => 1,
            Zone::Crossroad => 2,
            Zone::Courtyard => 3,
            Zone::Rooftop => 4,
        }
    }

    /// Returns its color as red, green, blue: sand, purple, green, gray. They differ in lightness,
    /// so that color-blind readers can distinguish them.
    pub fn color(self) -> [u8; 3] {
        match self {
            Zone::Street => [0xF0, 0xE3, 0xB8],
            Zone::Crossroad => [0x88, 0x22, 0x66],
            Zone::Courtyard => [0x44, 0xA0, 0x7E],
            Zone::Rooftop => [0xC3, 0xC6, 0xC9],
        }
    }

    /// Returns the zone with this number; `None` for [`NONE`] and numbers above 4.
    pub(crate) fn of_code(code: u8) -> Option<Zone> {
        Zone::ALL.into_iter().find(|zone| zone.code() == code)
    }
}

/// Number of codes: those of the zones and [`NONE`].
pub const N_CODES: usize = 5;
