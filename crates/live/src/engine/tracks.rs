//! Walks and flights over the scene of a page.

use skyshed_core::coverage::{self, StretchSums, TrackStretches, Way, WayHeights, WayRun};
use skyshed_core::quantity::{MAX_EXTENT_UNITS, height_steps};

use super::{Engine, Found};
use crate::answers::{StretchFacts, StretchObstacle, TrackFacts, TrackPlace};
use crate::questions::PageTrack;

/// Places at which heights along tracks are sampled.
const PLACES: f64 = 1500.0;

impl Engine {
    /// Keeps tracks whose links from all over the scene fit the lattice.
    pub(super) fn take_tracks(&mut self, tracks: Vec<PageTrack>) -> Result<(), String> {
        let grid = self.field.grid();
        let corners = [(grid.x_min(), grid.y_min()), (grid.x_max(), grid.y_max())];
        for (x, y, ..) in tracks.iter().flat_map(|track| &track.vertices) {
            let is_near = |corner| self.field.span_units(corner, (*x, *y)) <= MAX_EXTENT_UNITS;
            if !corners.into_iter().all(is_near) {
                return Err(format!("the track is too far away at ({x}, {y})"));
            }
        }
        self.tracks = tracks;
        Ok(())
    }

    /// Returns the tracks, with walks at the height of the receivers.
    fn ways(&self) -> Result<Vec<Way>, String> {
        let walk = height_steps(self.sight.sight.receiver.rx_height_m());
        let ways = self.tracks.iter().map(|track| track.way(walk?));
        ways.collect::<Option<_>>().ok_or_else(|| "a track with heights beyond ±32 768 m".to_string())
    }

    pub(super) fn stretches(&self, which: Option<usize>, every_m: f64) -> Result<TrackFacts, String> {
        if every_m.is_nan() || every_m <= 0.0 {
            return Err(format!("a step of {every_m} m along a track"));
        }
        let found: Vec<&Found> = match which {
            Some(which) => self.found(which).into_iter().collect(),
            None => self.hovering().collect(),
        };
        if found.is_empty() {
            return Ok(TrackFacts::default());
        }
        let observers: Vec<coverage::Uav> = found.into_iter().map(|found| found.uav.clone()).collect();
        let ways = self.ways()?;
        let unit = self.field.grid().meters_per_unit();
        let curved = self.sight.curvature().map(|curvature| (curvature, every_m / unit));
        let TrackStretches { all, .. } =
            TrackStretches::find(self.field, (&ways, &observers), curved).map_err(|e| e.to_string())?;
        let StretchSums { length_m, time_s, longest_without_m, longest_without_s } = all.sums();
        let starts = Way::starts(&ways, unit);
        Ok(TrackFacts {
            stretches: all.runs().map(|run| self.stretch(run, (&ways, &starts))).collect(),
            lengths_m: length_m,
            times_s: time_s,
            longest_without_m,
            longest_without_s,
            every_m: curved.map(|_| every_m),
        })
    }

    fn stretch(&self, run: WayRun<'_>, (ways, starts): (&[Way], &[f64])) -> StretchFacts {
        let (first, last) = (run.first(), run.last());
        let ends = run.0.iter().map(|stretch| (stretch.leg, stretch.at[0])).chain([(last.leg, last.at[1])]);
        let obstacle = run.obstacle().and_then(|obstacle| self.field.leg_obstacle(obstacle)).map(|(kind, [x, y])| {
            let (kind, name) = self.named(kind);
            StretchObstacle { kind, name, x, y }
        });
        StretchFacts {
            state: first.state.name(),
            along_m: run.along_m().map(|m| starts[first.way] + m),
            time_s: run.time_s(),
            places: ends.map(|(leg, t)| ways[first.way].place(leg, t).0).collect(),
            obstacle,
        }
    }

    pub(super) fn track_heights(&self) -> Result<Vec<TrackPlace>, String> {
        let walk_m = self.sight.sight.receiver.rx_height_m();
        let known = |m: f64| m.is_finite().then_some(m);
        let place = |at: WayHeights| TrackPlace {
            along_m: at.along_m,
            time_s: at.time_s,
            x: at.position[0],
            y: at.position[1],
            user_m: at.user_m,
            ground_m: known(at.ground_m),
            roof_m: known(at.roof_m),
        };
        Ok(WayHeights::sample(self.field, &self.ways()?, (walk_m, PLACES)).into_iter().map(place).collect())
    }
}
