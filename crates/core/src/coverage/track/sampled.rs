//! A track decided step by step.
//!
//! The track is walked in steps of at most a given length, and every step's end is decided as any
//! link is. Where two neighbors differ, the change between them is found by halving down to a
//! lattice step. A stretch that begins and ends between two neighbors is missed.

use super::super::explained_link::{indoors_below, margin_m};
use super::super::view::SceneView;
use super::{LegStretch, TrackHeight, TrackState, TrackVertex};
use crate::height_field::Station;
use crate::los::link_least_receiver_heights;
use crate::quantity::{STEPS_PER_UNIT, VOID};
use crate::raster::GeoRef;

/// Line of sight at a place of a track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackPoint {
    /// Leg that it is on, counted from 0, and the fraction of the way along it.
    pub leg: (usize, f64),
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

impl SceneView<'_> {
    /// Decides a leg of a track at both ends and at least every `step` \[CRS units\] between them;
    /// upright parts count in meters.
    ///
    /// # Panics
    /// For a step that is not above 0.
    pub fn along_leg(&self, (leg, ends): (usize, [&TrackVertex; 2]), step: f64) -> Vec<TrackPoint> {
        assert!(step > 0.0, "a track is walked in steps");
        let along = Along { view: self, ends };
        let n = f64::from(steps_of(self.field().grid(), ends, step));
        let mut t = 0.0;
        let mut points = Vec::new();
        while t <= n {
            points.push(along.point((leg, t / n), t <= 0.0 || t >= n));
            t += 1.0;
        }
        points
    }

    /// Returns the stretches of a leg that was decided at some points. What begins and ends between
    /// two of them is missed.
    pub fn stretches_between(&self, ends: [&TrackVertex; 2], points: &[TrackPoint]) -> Vec<LegStretch> {
        let along = Along { view: self, ends };
        let length = length_of(self.field().grid(), ends);
        let (mut stretches, mut start) = (Vec::new(), 0.0);
        let mut push = |from: f64, to: f64, state: TrackState| {
            if to > from {
                stretches.push(LegStretch { at: [from, to], state, obstacle: None });
            }
        };
        for pair in points.windows(2) {
            if pair[0].state != pair[1].state {
                let change = along.change(&pair[0], &pair[1], length);
                push(start, change, pair[0].state);
                start = change;
            }
        }
        if let Some(last) = points.last() {
            push(start, 1.0, last.state);
        }
        stretches
    }
}

/// Returns the length of a leg in space \[CRS units\].
fn length_of(grid: &GeoRef, [from, to]: [&TrackVertex; 2]) -> f64 {
    let across = (to.position[0] - from.position[0]).hypot(to.position[1] - from.position[1]);
    match (from.height, to.height) {
        (TrackHeight::AboveDatum(a), TrackHeight::AboveDatum(b)) => {
            #[expect(clippy::cast_precision_loss, reason = "heights are at most 2^27 steps")]
            let up_m = (b - a) as f64 / f64::from(STEPS_PER_UNIT);
            across.hypot(up_m / grid.meters_per_unit())
        }
        _ => across,
    }
}

/// Returns the number of steps that a leg is walked in.
fn steps_of(grid: &GeoRef, ends: [&TrackVertex; 2], step: f64) -> u32 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive, and bounded by the caller")]
    let n = (length_of(grid, ends) / step).ceil().max(1.0) as u32;
    n
}

/// A leg of a track in a view.
struct Along<'a> {
    view: &'a SceneView<'a>,
    ends: [&'a TrackVertex; 2],
}

impl Along<'_> {
    fn position(&self, t: f64) -> [f64; 2] {
        let [from, to] = self.ends.map(|end| end.position);
        if t >= 1.0 { to } else { [0, 1].map(|k| from[k] + t * (to[k] - from[k])) }
    }

    /// Returns the receiver at a fraction of the way, at the height as it is seen; else its state.
    fn receiver(&self, t: f64) -> Result<Station, TrackState> {
        let field = self.view.field();
        let [x, y] = self.position(t);
        let place = field.place(x, y);
        let ground = field.ground_at(&place);
        if ground == VOID {
            return Err(TrackState::Nodata);
        }
        let receiver = match self.ends.map(|end| end.height) {
            [TrackHeight::AboveDatum(a), TrackHeight::AboveDatum(b)] => {
                #[expect(clippy::cast_possible_truncation, clippy::cast_precision_loss, reason = "between two heights")]
                let z = a + (t * (b - a) as f64).round() as i64;
                self.view.lowered(&Station { place, z })
            }
            [TrackHeight::AboveGround(height), _] | [_, TrackHeight::AboveGround(height)] => {
                Station { place, z: i64::from(ground) + i64::from(height) }
            }
        };
        let least = i64::from(indoors_below(field, &place)).max(i64::from(ground));
        if receiver.z >= least { Ok(receiver) } else { Err(TrackState::Inside) }
    }

    fn state(&self, t: f64) -> TrackState {
        match self.receiver(t) {
            Err(state) => state,
            Ok(receiver) if self.view.is_los(&receiver) => TrackState::Los,
            Ok(_) => TrackState::Nlos,
        }
    }

    fn point(&self, leg: (usize, f64), is_vertex: bool) -> TrackPoint {
        let position = self.position(leg.1);
        let receiver = match self.receiver(leg.1) {
            Ok(receiver) => receiver,
            Err(state) => return TrackPoint { leg, position, z: None, state, margin_m: None, is_vertex },
        };
        let field = self.view.field();
        let least = link_least_receiver_heights(field, &self.view.uav().station, &receiver);
        let state = if least.is_los { TrackState::Los } else { TrackState::Nlos };
        let margin_m = margin_m(&least, receiver.z, f64::from(field.ground_at(&receiver.place)));
        let z = Some(receiver.z + i64::from(self.view.lowered_by(&receiver.place)));
        TrackPoint { leg, position, z, state, margin_m, is_vertex }
    }

    /// Finds where the state of the first point ends between two neighbors, by halving, to a
    /// lattice step of a leg of some length.
    fn change(&self, a: &TrackPoint, b: &TrackPoint, length: f64) -> f64 {
        let (mut low, mut high) = (a.leg.1, b.leg.1);
        let finest = 1.0 / f64::from(STEPS_PER_UNIT);
        while (high - low) * length > finest {
            let t = 0.5 * (low + high);
            if self.state(t) == a.state {
                low = t;
            } else {
                high = t;
            }
        }
        0.5 * (low + high)
    }
}
