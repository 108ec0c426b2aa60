//! Line of sight along a user's track.
//!
//! The track is walked in steps of at most a given length, and every step's end is decided as any
//! link is. Where two neighbors differ, the change between them is found by halving down to a
//! lattice step. So the ends of a stretch without line of sight are exact to 1/1024 unit. A stretch
//! that begins and ends between two neighbors is missed; only the length of a step bounds it.

use super::explained_link::{indoors_below, margin_m};
use super::view::SceneView;
use crate::height_field::Station;
use crate::los::link_least_receiver_heights;
use crate::quantity::{STEPS_PER_UNIT, VOID};

/// Line of sight at a place of a track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackPoint {
    /// Distance from the start along the track \[CRS units\].
    pub along: f64,
    /// Position \[CRS units\].
    pub position: [f64; 2],
    /// Height of the user above the datum \[1/1024 m\]; `None` where no ground is known.
    pub z: Option<i64>,
    /// State of the user there.
    pub state: TrackState,
    /// Height of the user less the least height in line of sight \[m\]; `None` inside buildings,
    /// where no ground is known, and where no height is enough.
    pub margin_m: Option<f64>,
    /// A place of the track itself, and not one between.
    pub is_vertex: bool,
}

/// State of a user at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrackState {
    /// Line of sight.
    Los,
    /// None.
    Nlos,
    /// The place is inside a building, or no ground is known there: no receiver.
    NoReceiver,
}

/// A part of a track in one state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// Distances from the start along the track at which it begins and ends \[CRS units\].
    pub along: [f64; 2],
    /// The state.
    pub state: TrackState,
}

/// Line of sight along a track.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// The places that were decided, in order.
    pub points: Vec<TrackPoint>,
    /// The track cut where its state changes; together they are all of it.
    pub stretches: Vec<Stretch>,
}

impl Track {
    /// Returns the length of the track in a state \[CRS units\].
    pub fn length(&self, state: TrackState) -> f64 {
        self.stretches.iter().filter(|s| s.state == state).map(|s| s.along[1] - s.along[0]).sum()
    }
}

impl SceneView<'_> {
    /// Walks a track below the UAV: users `rx_height` \[1/1024 m\] above ground, decided at least
    /// every `step` \[CRS units\].
    ///
    /// # Panics
    /// With fewer than two places, or a step that is not above 0.
    pub fn along_track(&self, places: &[[f64; 2]], rx_height: i32, step: f64) -> Track {
        assert!(places.len() >= 2 && step > 0.0, "a track has two places and is walked in steps");
        let walker = Walker { view: self, rx_height };
        let mut points = vec![walker.point(0.0, places[0], true)];
        let mut start = 0.0;
        for ends in places.windows(2) {
            let [from, to] = [ends[0], ends[1]];
            let length = (to[0] - from[0]).hypot(to[1] - from[1]);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "positive, and bounded by the caller"
            )]
            let n = (length / step).ceil().max(1.0) as u32;
            for k in 1..=n {
                let t = f64::from(k) / f64::from(n);
                let position = [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])];
                points.push(walker.point(start + t * length, position, k == n));
            }
            start += length;
        }
        let mut stretches = vec![Stretch { along: [0.0, 0.0], state: points[0].state }];
        for pair in points.windows(2) {
            if pair[0].state != pair[1].state {
                let change = walker.change(&pair[0], &pair[1]);
                if let Some(last) = stretches.last_mut() {
                    last.along[1] = change;
                }
                stretches.push(Stretch { along: [change, change], state: pair[1].state });
            }
        }
        if let Some(last) = stretches.last_mut() {
            last.along[1] = start;
        }
        Track { points, stretches }
    }
}

struct Walker<'a> {
    view: &'a SceneView<'a>,
    rx_height: i32,
}

impl Walker<'_> {
    /// Returns the user at a position, at the height as it is seen, if there can be one.
    fn receiver(&self, [x, y]: [f64; 2]) -> Option<Station> {
        let field = self.view.field();
        let place = field.place(x, y);
        let ground = field.ground_at(&place);
        let z = i64::from(ground) + i64::from(self.rx_height);
        (ground != VOID && z >= i64::from(indoors_below(field, &place))).then_some(Station { place, z })
    }

    fn state(&self, position: [f64; 2]) -> TrackState {
        match self.receiver(position) {
            None => TrackState::NoReceiver,
            Some(receiver) if self.view.is_los(&receiver) => TrackState::Los,
            Some(_) => TrackState::Nlos,
        }
    }

    fn point(&self, along: f64, position: [f64; 2], is_vertex: bool) -> TrackPoint {
        let Some(receiver) = self.receiver(position) else {
            return TrackPoint { along, position, z: None, state: TrackState::NoReceiver, margin_m: None, is_vertex };
        };
        let field = self.view.field();
        let least = link_least_receiver_heights(field, &self.view.uav().station, &receiver);
        let state = if least.is_los { TrackState::Los } else { TrackState::Nlos };
        let margin_m = margin_m(&least, receiver.z, f64::from(field.ground_at(&receiver.place)));
        let z = Some(receiver.z + i64::from(self.view.lowered_by(&receiver.place)));
        TrackPoint { along, position, z, state, margin_m, is_vertex }
    }

    /// Finds where the state of the first point ends between two neighbors, by halving, to a
    /// lattice step.
    fn change(&self, a: &TrackPoint, b: &TrackPoint) -> f64 {
        let (mut low, mut high) = (0.0, 1.0);
        let length = b.along - a.along;
        let finest = 1.0 / f64::from(STEPS_PER_UNIT);
        while (high - low) * length > finest {
            let t = 0.5 * (low + high);
            let at = |k: usize| a.position[k] + t * (b.position[k] - a.position[k]);
            if self.state([at(0), at(1)]) == a.state {
                low = t;
            } else {
                high = t;
            }
        }
        a.along + 0.5 * (low + high) * length
    }
}
