//! The document and the tables of a track.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::{Seen, TrackWalk};
use crate::answer::{Head, WarningFacts, document_of, warnings_of};
use crate::coverage::{StretchSums, TrackPoint, WayRun, WayStretch};
use crate::height_field::Curvature;
use crate::link::{EndFacts, ObstacleFacts};
use crate::quantity::meters;

/// Line of sight along a track.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct TrackDocument {
    #[serde(flatten)]
    head: Head,
    /// The UAV; null where there are several.
    uav: Option<EndFacts>,
    /// Height of the user above ground [m]; null for a track with heights of its own.
    rx_height_m: Option<f64>,
    /// Effective earth radius factor k; null over a flat earth.
    earth_k: Option<f64>,
    /// Longest step between two decided places [m].
    every_m: f64,
    /// true if stretches are computed, false if they are found by steps, as over a curved earth.
    exact_stretches: bool,
    /// Line of sight from the best UAV at each place.
    #[serde(flatten)]
    seen: SeenDocument,
    /// Line of sight from each UAV.
    observers: Vec<ObserverDocument>,
    /// Decided places, in order; absent in the copies that pictures and tables store.
    #[serde(skip_serializing_if = "Option::is_none")]
    points: Option<Vec<PointRow>>,
    /// Warnings.
    warnings: Vec<WarningFacts>,
}

/// Line of sight along a track from one UAV, or from the best of several.
#[derive(Debug, Serialize, JsonSchema)]
struct SeenDocument {
    /// Lengths of the track in space [m].
    length_m: Lengths,
    /// Times [s]; null for a track without times.
    time_s: Option<Lengths>,
    /// Share of the length in line of sight, of the part with receivers; null without any.
    p_los: Option<f64>,
    /// Share of the time in line of sight, of the part with receivers; null without times.
    p_los_by_time: Option<f64>,
    /// Reason for having no share.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'static str>,
    /// Longest stretch without line of sight [m].
    longest_without_m: f64,
    /// Longest time without line of sight [s]; null for a track without times.
    longest_without_s: Option<f64>,
    /// Stretches of one state, in order; absent in the copies that pictures and tables store.
    #[serde(skip_serializing_if = "Option::is_none")]
    stretches: Option<Vec<StretchRow>>,
}

/// Line of sight along a track from one UAV.
#[derive(Debug, Serialize, JsonSchema)]
struct ObserverDocument {
    /// Id of the UAV.
    id: String,
    #[serde(flatten)]
    at: EndFacts,
    #[serde(flatten)]
    seen: SeenDocument,
}

/// Sums by state.
#[derive(Debug, Serialize, JsonSchema)]
struct Lengths {
    /// Whole track.
    total: f64,
    /// Part in line of sight.
    los: f64,
    /// Part not in line of sight.
    nlos: f64,
    /// Part inside buildings, below or without a ground.
    no_receiver: f64,
    /// Part inside buildings or below the ground.
    inside: f64,
    /// Part without a known ground.
    nodata: f64,
}

impl Lengths {
    fn of([los, nlos, inside, nodata]: [f64; 4]) -> Lengths {
        let no_receiver = inside + nodata;
        Lengths { total: los + nlos + no_receiver, los, nlos, no_receiver, inside, nodata }
    }
}

/// A stretch of a track.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct StretchRow {
    /// Path of the file, counted from 1.
    path: usize,
    /// Name of the path in the file.
    path_name: Option<String>,
    /// Id of the UAV; empty for all together.
    uav: String,
    /// Leg of the path, counted from 1; null for a stretch that may cross several.
    leg: Option<usize>,
    /// los, nlos, inside (a building, or below the ground) or nodata.
    state: &'static str,
    /// Beginning along the path in space [m].
    from_m: f64,
    /// End along the path [m].
    to_m: f64,
    /// Length [m].
    length_m: f64,
    /// Beginning since the start of the path [s]; null without times.
    from_s: Option<f64>,
    /// End since the start of the path [s].
    to_s: Option<f64>,
    /// Beginning, east [units of the scene's reference system].
    from_x: f64,
    /// Beginning, north [units of the scene's reference system].
    from_y: f64,
    /// Beginning, height above the datum [m]; null for a walk, which follows the ground.
    from_z: Option<f64>,
    /// End, east [units of the scene's reference system].
    to_x: f64,
    /// End, north [units of the scene's reference system].
    to_y: f64,
    /// End, height above the datum [m].
    to_z: Option<f64>,
    /// Kind of the obstacle that hides most of it: building, terrain, cell or nodata.
    obstacle: Option<&'static str>,
    /// Id of that building, or row and column of that cell.
    obstacle_id: Option<String>,
    /// Middle of that obstacle, east [units of the scene's reference system].
    obstacle_x: Option<f64>,
    /// Middle of that obstacle, north [units of the scene's reference system].
    obstacle_y: Option<f64>,
}

/// A decided place of a track.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PointRow {
    /// Distance from the beginning along the track [m].
    along_m: f64,
    /// East [units of the scene's reference system].
    x: f64,
    /// North [units of the scene's reference system].
    y: f64,
    /// true for a place of the file, false for one between two of them.
    vertex: bool,
    /// Height of the user above the datum [m].
    height_amsl_m: Option<f64>,
    /// los, nlos, inside (a building, or below the ground) or nodata.
    state: &'static str,
    /// User's height less the least height in line of sight [m].
    margin_m: Option<f64>,
    /// Horizontal distance from the UAV [m].
    distance_m: Option<f64>,
    /// Elevation angle of the UAV [deg].
    elevation_deg: Option<f64>,
    /// Id of the UAV.
    uav: String,
    /// Path of the file, counted from 1.
    path: usize,
    /// Time since the start of the path [s]; null without times.
    time_s: Option<f64>,
}

impl TrackWalk {
    fn end_of(&self, observer: usize) -> EndFacts {
        let uav = &self.uavs[observer];
        let place = &uav.station.place;
        EndFacts { x: place.x, y: place.y, height_amsl_m: uav.height_amsl_m() }
    }

    fn stretch_row(&self, uav: &str, run: WayRun<'_>, leg: Option<usize>) -> StretchRow {
        let (first, last, [from_m, to_m]) = (run.first(), run.last(), run.along_m());
        let (from, from_z) = self.ways[first.way].place(first.leg, first.at[0]);
        let (to, to_z) = self.ways[last.way].place(last.leg, last.at[1]);
        let obstacle = run.obstacle().and_then(|obstacle| self.scene.field.leg_obstacle(obstacle));
        let facts = obstacle.map(|(kind, _)| ObstacleFacts::of(&self.scene.field, kind));
        let cell = |facts: &ObstacleFacts| facts.cell.map(|(row, col)| format!("{row},{col}"));
        StretchRow {
            path: first.way + 1,
            path_name: self.ways[first.way].name.clone(),
            uav: uav.to_string(),
            leg,
            state: first.state.name(),
            from_m,
            to_m,
            length_m: run.length_m(),
            from_s: run.time_s().map(|[from, _]| from),
            to_s: run.time_s().map(|[_, to]| to),
            from_x: from[0],
            from_y: from[1],
            from_z,
            to_x: to[0],
            to_y: to[1],
            to_z,
            obstacle: facts.as_ref().map(|facts| facts.kind),
            obstacle_id: facts.as_ref().and_then(|facts| facts.id.clone().or_else(|| cell(facts))),
            obstacle_x: obstacle.map(|(_, [x, _])| x),
            obstacle_y: obstacle.map(|(_, [_, y])| y),
        }
    }

    /// Returns the stretches of each UAV leg by leg, then of all together if there are several.
    pub(crate) fn stretch_rows(&self) -> Vec<StretchRow> {
        self.told_stretches()
            .map(|(uav, stretch)| self.stretch_row(uav, WayRun(std::slice::from_ref(stretch)), Some(stretch.leg + 1)))
            .collect()
    }

    /// Returns the stretches leg by leg with the id of their UAV, empty for all together.
    pub(super) fn told_stretches(&self) -> impl Iterator<Item = (&str, &WayStretch)> {
        let each = self
            .uavs
            .iter()
            .zip(&self.each)
            .flat_map(|(uav, seen)| seen.stretches.0.iter().map(|s| (uav.id.as_str(), s)));
        let all = (self.uavs.len() > 1)
            .then_some(&self.all)
            .into_iter()
            .flat_map(|seen| seen.stretches.0.iter().map(|s| ("", s)));
        each.chain(all)
    }

    fn seen_document(&self, uav: &str, seen: &Seen, with_places: bool) -> SeenDocument {
        let Seen { stretches, sums } = seen;
        let p_los = seen.share();
        SeenDocument {
            length_m: Lengths::of(sums.length_m),
            time_s: sums.time_s.map(Lengths::of),
            p_los,
            p_los_by_time: sums.time_s.and_then(StretchSums::share),
            reason: p_los.is_none().then_some("no place of the track holds a receiver"),
            longest_without_m: sums.longest_without_m,
            longest_without_s: sums.longest_without_s,
            stretches: with_places.then(|| stretches.runs().map(|run| self.stretch_row(uav, run, None)).collect()),
        }
    }

    /// Returns the decided places of all UAVs; none where they cannot be found.
    pub(super) fn point_rows(&self) -> Vec<PointRow> {
        let Ok(points) = self.points() else { return Vec::new() };
        let mut rows = Vec::new();
        for (observer, of_ways) in points.iter().enumerate() {
            let end = self.end_of(observer);
            for (way, of_way) in of_ways.iter().enumerate() {
                let spans = self.ways[way].spans(self.facts.unit_m());
                rows.extend(of_way.iter().map(|point| {
                    let (along_m, time_s) = spans[point.leg.0].at(point.leg.1);
                    self.point((observer, end), (way, along_m, time_s), point)
                }));
            }
        }
        rows
    }

    fn point(
        &self,
        (observer, end): (usize, EndFacts),
        (way, along_m, time_s): (usize, f64, Option<f64>),
        p: &TrackPoint,
    ) -> PointRow {
        let ([x, y], unit) = (p.position, self.facts.unit_m());
        let height_amsl_m = p.z.and_then(|z| i32::try_from(z).ok()).map(meters);
        let distance_m = height_amsl_m.map(|_| (x - end.x).hypot(y - end.y) * unit);
        let rise = height_amsl_m.map(|z| end.height_amsl_m - z);
        let given = &self.ways[way].vertices[p.leg.0 + usize::from(p.leg.1 >= 1.0)];
        PointRow {
            along_m,
            x,
            y,
            vertex: p.is_vertex && given.is_given,
            height_amsl_m,
            state: p.state.name(),
            margin_m: p.margin_m,
            distance_m,
            elevation_deg: rise.zip(distance_m).map(|(rise, distance)| rise.atan2(distance).to_degrees()),
            uav: self.uavs[observer].id.clone(),
            path: way + 1,
            time_s,
        }
    }

    pub(super) fn as_document(&self, with_places: bool) -> Value {
        let observers = self.uavs.iter().zip(&self.each).enumerate().map(|(k, (uav, seen))| ObserverDocument {
            id: uav.id.clone(),
            at: self.end_of(k),
            seen: self.seen_document(&uav.id, seen, with_places),
        });
        let only = if let [only] = &self.uavs[..] { only.id.as_str() } else { "" };
        document_of(&TrackDocument {
            head: self.facts.head("skyshed/track/1"),
            uav: (self.uavs.len() == 1).then(|| self.end_of(0)),
            rx_height_m: self.rx_height_m,
            earth_k: self.curvature.map(Curvature::earth_k),
            every_m: self.every_m,
            exact_stretches: self.curvature.is_none(),
            seen: self.seen_document(only, &self.all, with_places),
            observers: observers.collect(),
            points: with_places.then(|| self.point_rows()),
            warnings: warnings_of(&self.facts.warnings),
        })
    }
}
