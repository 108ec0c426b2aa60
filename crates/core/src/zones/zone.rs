//! The four zones, their words, codes and colors.

/// What a place in a city is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Zone {
    /// Open ground that is neither of the next two.
    Street,
    /// Where three or more streets meet.
    Crossroad,
    /// Open ground that one block encloses.
    Courtyard,
    /// A building.
    Rooftop,
}

/// The code of a cell without a zone: nodata, or a surface model alone, in which no building is known.
pub const NONE: u8 = 0;

impl Zone {
    /// All zones in the order of their codes.
    pub const ALL: [Zone; 4] = [Zone::Street, Zone::Crossroad, Zone::Courtyard, Zone::Rooftop];

    /// The word for it in tables and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Zone::Street => "street",
            Zone::Crossroad => "crossroad",
            Zone::Courtyard => "courtyard",
            Zone::Rooftop => "rooftop",
        }
    }

    /// The zone of a word.
    pub fn named(name: &str) -> Option<Zone> {
        Zone::ALL.into_iter().find(|zone| zone.name() == name)
    }

    /// Its number in rasters, from 1.
    pub fn code(self) -> u8 {
        match self {
            Zone::Street => 1,
            Zone::Crossroad => 2,
            Zone::Courtyard => 3,
            Zone::Rooftop => 4,
        }
    }

    /// Its color as red, green, blue: sand, purple, green, gray, distinct in lightness for any eyes.
    pub fn color(self) -> [u8; 3] {
        match self {
            Zone::Street => [0xF0, 0xE3, 0xB8],
            Zone::Crossroad => [0x88, 0x22, 0x66],
            Zone::Courtyard => [0x44, 0xA0, 0x7E],
            Zone::Rooftop => [0xC3, 0xC6, 0xC9],
        }
    }

    /// The zone with this number; [`NONE`] and numbers above 4 are none.
    pub(crate) fn of_code(code: u8) -> Option<Zone> {
        Zone::ALL.into_iter().find(|zone| zone.code() == code)
    }
}

/// Number of codes: those of the zones and [`NONE`].
pub const N_CODES: usize = 5;
