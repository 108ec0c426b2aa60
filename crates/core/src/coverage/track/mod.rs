//! Line of sight along a track: a walk or a flight below or around UAVs.
//!
//! A track is made of straight legs. Over a flat earth its stretches are exact: where they begin and
//! end is computed, not searched ([`TrackLeg`]). Over a curved earth it is decided step by step
//! ([`SceneView::along_leg`](super::SceneView::along_leg)).

mod leg;
mod sampled;
mod stretches;
mod way;

pub use leg::{LegStretch, TrackLeg};
pub use sampled::TrackPoint;
pub use stretches::{StretchSums, TrackStretches, WayRun, WayStretch, WayStretches};
pub use way::{LegSpan, Way, WayHeights, WayVertex};

/// A vertex of a track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackVertex {
    /// Position \[CRS units\].
    pub position: [f64; 2],
    /// Height of the receiver.
    pub height: TrackHeight,
}

/// Height of a receiver at a vertex. Both ends of a leg have one kind of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrackHeight {
    /// Above the ground, all along the leg \[1/1024 m\].
    AboveGround(i32),
    /// Above the datum, straight between vertices \[1/1024 m\].
    AboveDatum(i64),
}

/// State of a receiver at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TrackState {
    /// Line of sight.
    Los,
    /// None.
    Nlos,
    /// Inside a building or below the ground: no receiver.
    Inside,
    /// No ground is known there: no receiver.
    Nodata,
}

impl TrackState {
    /// All states.
    pub const ALL: [TrackState; 4] = [TrackState::Los, TrackState::Nlos, TrackState::Inside, TrackState::Nodata];

    /// Returns the word for it in documents and tables.
    pub fn name(self) -> &'static str {
        match self {
            TrackState::Los => "los",
            TrackState::Nlos => "nlos",
            TrackState::Inside => "inside",
            TrackState::Nodata => "nodata",
        }
    }

    /// Returns `true` where there is a receiver.
    pub fn has_receiver(self) -> bool {
        matches!(self, TrackState::Los | TrackState::Nlos)
    }
}
