//! Answers of the engine, as the page reads them.
//!
//! Positions are in units of the scene's reference system. Names that end in `_m` are in meters.

use serde::Serialize;

/// Description of a scene once it is built.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Opened {
    /// `true` if it has zones.
    pub has_zones: bool,
    /// `true` if it has buildings.
    pub has_buildings: bool,
    /// `true` if it has cells without data.
    pub has_no_data: bool,
}

/// Answer to a map.
#[derive(Debug, Clone, Serialize)]
pub struct Mapped {
    /// Answers by UAV.
    pub uavs: Vec<Seen>,
    /// All UAVs together.
    pub all: Together,
    /// `true` if the picture has cells out of range.
    pub has_out_of_range: bool,
}

/// Coverage by one UAV.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub enum Seen {
    /// Position of the UAV, and the receivers that it sees.
    Found {
        ok: True,
        amsl_m: f64,
        agl_m: Option<f64>,
        /// Height above the ground or roof below, if one is known there.
        above_m: Option<f64>,
        over: &'static str,
        receivers: u64,
        los: u64,
        p_los: Option<f64>,
        /// Reason why there is no P_LoS though there are receivers.
        reason: Option<&'static str>,
        /// Receivers that are surely in line of sight, and receivers that depend on the heights of
        /// buildings; `None` without an error of heights.
        sure: Option<[u64; 2]>,
        zones: Option<ByZone>,
    },
    /// Reason why the UAV cannot hover there, and the lowest height at which it could.
    Refused { ok: False, code: String, words: String, lowest_amsl_m: Option<f64> },
}

/// Receivers by zone.
#[derive(Debug, Clone, Copy, Serialize)]
#[expect(missing_docs, reason = "the zones of the program")]
pub struct ByZone {
    pub street: Counts,
    pub crossroad: Counts,
    pub courtyard: Counts,
    pub rooftop: Counts,
}

/// Receivers in range, and receivers in line of sight.
#[derive(Debug, Clone, Copy, Default, Serialize)]
#[expect(missing_docs, reason = "as the type says")]
pub struct Counts {
    pub receivers: u64,
    pub los: u64,
}

/// Coverage by all UAVs together.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Together {
    /// Receivers in range of any UAV.
    pub receivers: u64,
    /// Receivers that any UAV sees.
    pub los: u64,
    /// Number of receivers that exactly 0, 1, 2, … UAVs see.
    pub seen_by: Vec<u64>,
    /// Reason why there is no P_LoS though there are receivers.
    pub reason: Option<&'static str>,
}

/// Facts about a cell.
#[derive(Debug, Clone, Serialize)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub struct CellFacts {
    pub inside: bool,
    pub row: usize,
    pub col: usize,
    pub ground_m: Option<f64>,
    pub roof_m: Option<f64>,
    pub kind: &'static str,
    pub zone: Option<&'static str>,
    /// `true` for each UAV of the last map that sees the cell's receiver; null without one in
    /// range.
    pub sees: Vec<Option<bool>>,
    pub margin_m: Option<f64>,
}

/// Facts about a link.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub enum LinkFacts {
    /// The link is decided.
    Found {
        ok: True,
        los: bool,
        margin_m: Option<f64>,
        distance_m: f64,
        elevation_deg: f64,
        uav: End,
        receiver: End,
        obstruction: Option<Obstruction>,
        /// Ground and roofs below the link; distances count from the UAV.
        steps: Vec<Step>,
    },
    /// The link lacks a receiver or a UAV.
    Refused { ok: False, words: String },
}

/// End of a link.
#[derive(Debug, Clone, Copy, Serialize)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub struct End {
    pub x: f64,
    pub y: f64,
    pub amsl_m: f64,
}

/// Obstacle of a link.
#[derive(Debug, Clone, Serialize)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub struct Obstruction {
    pub kind: &'static str,
    pub name: Option<String>,
    pub x: f64,
    pub y: f64,
    pub ray_height_m: f64,
    pub roof_height_m: Option<f64>,
}

/// Stretch below a link, with the heights at its start and at its end.
#[derive(Debug, Clone, Copy, Serialize)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub struct Step {
    pub from_m: f64,
    pub to_m: f64,
    pub heights_m: [f64; 2],
    pub kind: &'static str,
}

/// Stretches of the tracks of a page.
#[derive(Debug, Clone, Default, Serialize)]
pub struct TrackFacts {
    /// Stretches in order; none if no UAV hovers.
    pub stretches: Vec<StretchFacts>,
    /// Lengths in line of sight, without it, inside buildings or below the ground, and over no data \[m\].
    pub lengths_m: [f64; 4],
    /// Times alike \[s\]; `None` if the tracks have none.
    pub times_s: Option<[f64; 4]>,
    /// Longest stretch without line of sight \[m\].
    pub longest_without_m: f64,
    /// Longest time without line of sight \[s\].
    pub longest_without_s: Option<f64>,
    /// Step by which stretches are decided over a curved earth \[m\]; otherwise they are exact.
    pub every_m: Option<f64>,
}

/// Stretch of one state of a track.
#[derive(Debug, Clone, Serialize)]
pub struct StretchFacts {
    /// `los`, `nlos`, `inside` or `nodata`.
    pub state: &'static str,
    /// Distances along all tracks, which follow each other, at which it begins and ends \[m\].
    pub along_m: [f64; 2],
    /// Times since the start of its track \[s\].
    pub time_s: Option<[f64; 2]>,
    /// Positions of its beginning, of the vertices in it, and of its end.
    pub places: Vec<[f64; 2]>,
    /// Obstacle that hides most of it from one UAV.
    pub obstacle: Option<StretchObstacle>,
}

/// Obstacle of a stretch, at its middle.
#[derive(Debug, Clone, Serialize)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub struct StretchObstacle {
    pub kind: &'static str,
    pub name: Option<String>,
    pub x: f64,
    pub y: f64,
}

/// Heights at a place of a track.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct TrackPlace {
    /// Distance along all tracks, which follow each other \[m\].
    pub along_m: f64,
    /// Time since the start of its track \[s\].
    pub time_s: Option<f64>,
    /// East.
    pub x: f64,
    /// North.
    pub y: f64,
    /// Height of the user above the datum \[m\].
    pub user_m: f64,
    /// Ground above the datum, if it is known \[m\].
    pub ground_m: Option<f64>,
    /// Roof above the datum, where there is a building \[m\].
    pub roof_m: Option<f64>,
}

/// P_LoS against height, or the progress of its making.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub enum CurveFacts {
    /// Share of the rows that is done.
    Going { share: f64 },
    /// Heights above the datum at which receivers come into sight, with the number in sight from
    /// there up.
    Done { done: True, receivers: u64, ground_m: Option<f64>, lowest_m: f64, heights_m: Vec<f64>, los: Vec<u64> },
}

/// Best place so far.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct BestFacts {
    /// Share of the places that is done.
    pub share: f64,
    /// Number of places tried at which the UAV can hover.
    pub tried: usize,
    /// Best of these places.
    pub best: Option<BestPlace>,
    /// `true` if no place is left to try.
    pub done: bool,
}

/// Place, with the counts of a UAV there.
#[derive(Debug, Clone, Copy, Serialize)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub struct BestPlace {
    pub x: f64,
    pub y: f64,
    pub los: u64,
    pub receivers: u64,
}

/// One set of UAVs, compared with another.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub enum ComparedFacts {
    /// Cells in sight here and not there are gained; the reverse are lost. `reason` says why there
    /// is no P_LoS.
    Found {
        ok: True,
        receivers: u64,
        los: u64,
        p_los: Option<f64>,
        reason: Option<&'static str>,
        gained: u64,
        lost: u64,
    },
    /// A UAV of the set cannot hover at its place.
    Refused { ok: False, words: String },
}

/// Always true in JSON.
#[derive(Debug, Clone, Copy)]
pub struct True;

/// Always false in JSON.
#[derive(Debug, Clone, Copy)]
pub struct False;

impl Serialize for True {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bool(true)
    }
}

impl Serialize for False {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bool(false)
    }
}
