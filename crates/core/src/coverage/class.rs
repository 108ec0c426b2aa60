//! Values of the mask of one UAV. A cell of several kinds has the first of 255, 3, 2 that holds;
//! 0 and 1 are receivers in range.

/// The receiver is not in line of sight.
pub const NLOS: u8 = 0;
/// The receiver is in line of sight.
pub const LOS: u8 = 1;
/// The cell holds no receiver (a building, or outside the chosen receivers).
pub const NOT_A_RECEIVER: u8 = 2;
/// Farther from the UAV than the radius.
pub const OUT_OF_RANGE: u8 = 3;
/// No height is known.
pub const NODATA: u8 = 255;

/// Returns the color of a class as red, green, blue, opacity: blue and orange of Okabe & Ito 2008,
/// gray for what is neither.
pub fn color(value: u8) -> [u8; 4] {
    match value {
        NLOS => [0xE6, 0x9F, 0x00, 0xFF],
        LOS => [0x00, 0x72, 0xB2, 0xFF],
        NOT_A_RECEIVER => [0xC3, 0xC6, 0xC9, 0xFF],
        OUT_OF_RANGE => [0xE9, 0xED, 0xF0, 0xFF],
        _ => [0xFF, 0xFF, 0xFF, 0x00],
    }
}

/// Every class with its name, in order of value.
pub const NAMES: [(u8, &str); 5] = [
    (NLOS, "NLoS"),
    (LOS, "LoS"),
    (NOT_A_RECEIVER, "not a receiver"),
    (OUT_OF_RANGE, "out of range"),
    (NODATA, "nodata"),
];
