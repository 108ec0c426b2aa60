//! Coverage maps: for every cell of a grid, what one UAV sees of the receiver there.
//!
//! The result of a map is a mask of [`class`]es, a tally of them and, on request, layers of heights. Results do not
//! depend on the number of threads: every cell is decided alone and all sums are integer counts.

mod cell_classes;
mod cell_heights;
mod elevation;
mod height_curve;
mod idle;
mod layers;
mod many;
mod map;
mod margins;
mod options;
mod pairs;
mod polygons;
mod place_sums;
mod range;
mod row_bands;
mod stability;
mod streamed;
mod tally;
mod track;
mod uav;
mod uav_grid;

pub use cell_heights::surface_under;
pub use height_curve::HeightCurve;
pub use idle::IdleFootprints;
pub use layers::{Overlay, which_layer};
pub use many::{KeepMasks, ManyMaps, maps_at_once};
pub use map::{Mapper, Seen, SiteCoverage, WorstReceiver, map_site};
pub use margins::{GRAZING_M, MarginSample, MarginStats};
pub use options::{Control, HeightLayers, MapOptions, Receivers};
pub use pairs::{CellGroups, MOST_SETS, PairCounts, count_pairs, count_sets, difference, difference_layer};
pub use polygons::{CoveragePolygon, PolygonOptions, coverage_polygons};
pub use range::any_in_range;
pub use stability::{Move, Stability, Turned};
pub use streamed::StreamedMapper;
pub use tally::{BAND_DEGREES, ElevationBand, Tally};
pub use track::{Stretch, Track, TrackPoint, TrackState, along_track};
pub use uav::{Placement, Uav, height_over};
pub use uav_grid::UavGrid;

/// Values of a mask. 255 wins over 3, 3 over 2, 2 over 0 and 1.
pub mod class {
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

    /// The color of a class as red, green, blue, opacity: blue and orange of Okabe & Ito 2008, gray for what is neither.
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
}
