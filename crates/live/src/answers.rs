//! What the engine answers, as the page reads it. Positions are in units of the scene's reference system, names that end in
//! `_m` in meters.

use serde::Serialize;

/// What is said of a scene once it is built.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Opened {
    /// Whether it has zones.
    pub has_zones: bool,
    /// Whether there are buildings.
    pub has_buildings: bool,
    /// Whether there are cells without data.
    pub has_no_data: bool,
}

/// What was found of a map.
#[derive(Debug, Clone, Serialize)]
pub struct Mapped {
    /// UAV by UAV.
    pub uavs: Vec<Seen>,
    /// All together.
    pub all: Together,
    /// Whether the picture has cells out of range.
    pub has_out_of_range: bool,
}

/// What one UAV sees.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub enum Seen {
    /// Where it hovers, and how many receivers it sees.
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
        /// Why there is no P_LoS though there are receivers.
        reason: Option<&'static str>,
        /// Receivers that are surely in line of sight, and those that hang on heights, where these may be off.
        sure: Option<[u64; 2]>,
        zones: Option<ByZone>,
    },
    /// Why it cannot hover there, and from which height on it could.
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

/// Receivers, and those in line of sight.
#[derive(Debug, Clone, Copy, Default, Serialize)]
#[expect(missing_docs, reason = "as the type says")]
pub struct Counts {
    pub receivers: u64,
    pub los: u64,
}

/// What all UAVs see together.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Together {
    /// Receivers of any.
    pub receivers: u64,
    /// Receivers that any sees.
    pub los: u64,
    /// Receivers that exactly 0, 1, 2, … see.
    pub seen_by: Vec<u64>,
    /// Why there is no P_LoS though there are receivers.
    pub reason: Option<&'static str>,
}

/// A cell.
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
    /// Whether each UAV of the last map sees its receiver; null without one in range.
    pub sees: Vec<Option<bool>>,
    pub margin_m: Option<f64>,
}

/// A link.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub enum LinkFacts {
    /// Decided.
    Found {
        ok: True,
        los: bool,
        margin_m: Option<f64>,
        distance_m: f64,
        elevation_deg: f64,
        uav: End,
        receiver: End,
        obstruction: Option<Obstruction>,
        /// Ground and roofs below it; distances count from the UAV.
        steps: Vec<Step>,
    },
    /// There is no receiver, or no UAV.
    Refused { ok: False, words: String },
}

/// An end of a link.
#[derive(Debug, Clone, Copy, Serialize)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub struct End {
    pub x: f64,
    pub y: f64,
    pub amsl_m: f64,
}

/// What stands in the way of a link.
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

/// A stretch below a link, with its heights where it starts and where it ends.
#[derive(Debug, Clone, Copy, Serialize)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub struct Step {
    pub from_m: f64,
    pub to_m: f64,
    pub heights_m: [f64; 2],
    pub kind: &'static str,
}

/// P_LoS against height, or how far it is.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub enum CurveFacts {
    /// How much is done.
    Going { share: f64 },
    /// Heights above the datum at which receivers come into sight, with the number in sight from there up.
    Done { done: True, receivers: u64, ground_m: Option<f64>, lowest_m: f64, heights_m: Vec<f64>, los: Vec<u64> },
}

/// The best place so far.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct BestFacts {
    /// How much is done.
    pub share: f64,
    /// Places that were tried and where the UAV can hover.
    pub tried: usize,
    /// The best of them.
    pub best: Option<BestPlace>,
    /// Whether there is nothing left to try.
    pub done: bool,
}

/// A place and what a UAV there sees.
#[derive(Debug, Clone, Copy, Serialize)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub struct BestPlace {
    pub x: f64,
    pub y: f64,
    pub los: u64,
    pub receivers: u64,
}

/// One set of UAVs against another.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "named as in the program's documents")]
pub enum ComparedFacts {
    /// Cells in sight here and not there are gained, the reverse are lost. `reason` says why there is no P_LoS.
    Found {
        ok: True,
        receivers: u64,
        los: u64,
        p_los: Option<f64>,
        reason: Option<&'static str>,
        gained: u64,
        lost: u64,
    },
    /// A UAV cannot hover there.
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
