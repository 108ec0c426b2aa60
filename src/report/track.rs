//! Line of sight along a track as reported: the document `skyshed/track/1` and its table.

use serde_json::{Map, Value, json};

use super::documents::RunFacts;
use crate::coverage::{Track, TrackState};
use crate::quantity::meters;

/// A track as reported.
#[derive(Debug, Clone)]
pub struct TrackReport {
    /// The run.
    pub facts: RunFacts,
    /// Height of the users above ground \[m\].
    pub rx_height_m: f64,
    /// Longest step between two decided places \[m\].
    pub every_m: f64,
    /// The UAV: x, y \[CRS units\] and height above the datum \[m\].
    pub uav: [f64; 3],
    /// The track.
    pub track: Track,
}

/// The word of a state in documents and tables.
fn word(state: TrackState) -> &'static str {
    match state {
        TrackState::Los => "los",
        TrackState::Nlos => "nlos",
        TrackState::NoReceiver => "no_receiver",
    }
}

impl TrackReport {
    /// Length of the track in a state \[m\].
    pub fn length_m(&self, state: TrackState) -> f64 {
        self.track.length(state) * self.facts.meters_per_unit
    }

    /// Share of the track with line of sight, of what has receivers; `None` without any.
    pub fn share(&self) -> Option<f64> {
        let (los, nlos) = (self.length_m(TrackState::Los), self.length_m(TrackState::Nlos));
        (los + nlos > 0.0).then(|| los / (los + nlos))
    }

    /// The longest stretch without line of sight \[m\].
    pub fn longest_without_m(&self) -> f64 {
        let without = self.track.stretches.iter().filter(|s| s.state == TrackState::Nlos);
        without.map(|s| (s.along[1] - s.along[0]) * self.facts.meters_per_unit).fold(0.0, f64::max)
    }

    /// Ground distance from the UAV \[m\] and elevation angle \[deg\] at a place; `None` where there is no user.
    fn view(&self, position: [f64; 2], z: Option<i64>) -> Option<(f64, f64)> {
        let z = meters(i32::try_from(z?).ok()?);
        let distance = (position[0] - self.uav[0]).hypot(position[1] - self.uav[1]) * self.facts.meters_per_unit;
        Some((distance, (self.uav[2] - z).atan2(distance).to_degrees()))
    }

    /// The document `skyshed/track/1`; the same for equal runs.
    pub fn document(&self) -> Value {
        let mut document = self.head();
        let unit = self.facts.meters_per_unit;
        let stretch = |s: &crate::coverage::Stretch| {
            json!({"state": word(s.state), "from_m": s.along[0] * unit, "to_m": s.along[1] * unit,
                   "length_m": (s.along[1] - s.along[0]) * unit})
        };
        document.insert("stretches".into(), self.track.stretches.iter().map(stretch).collect::<Vec<_>>().into());
        let point = |p: &crate::coverage::TrackPoint| {
            let view = self.view(p.position, p.z);
            json!({
                "along_m": p.along * unit, "x": p.position[0], "y": p.position[1], "vertex": p.is_vertex,
                "height_amsl_m": p.z.and_then(|z| i32::try_from(z).ok()).map(meters),
                "state": word(p.state), "margin_m": p.margin_m,
                "distance_m": view.map(|v| v.0), "elevation_deg": view.map(|v| v.1),
            })
        };
        document.insert("points".into(), self.track.points.iter().map(point).collect::<Vec<_>>().into());
        self.close(document)
    }

    /// The document without the points, as stored in pictures and beside tables.
    pub fn provenance(&self) -> Value {
        self.close(self.head())
    }

    fn head(&self) -> Map<String, Value> {
        let mut document = self.facts.head("skyshed/track/1");
        document.insert("uav".into(), json!({"x": self.uav[0], "y": self.uav[1], "height_amsl_m": self.uav[2]}));
        document.insert("rx_height_m".into(), self.rx_height_m.into());
        document.insert("every_m".into(), self.every_m.into());
        let total = [TrackState::Los, TrackState::Nlos, TrackState::NoReceiver].map(|s| self.length_m(s));
        document.insert(
            "length_m".into(),
            json!({"total": total.iter().sum::<f64>(), "los": total[0], "nlos": total[1], "no_receiver": total[2]}),
        );
        document.insert("p_los".into(), self.share().into());
        if self.share().is_none() {
            document.insert("reason".into(), "no place of the track holds a receiver".into());
        }
        document.insert("longest_without_m".into(), self.longest_without_m().into());
        document
    }

    fn close(&self, mut document: Map<String, Value>) -> Value {
        document.insert("warnings".into(), self.facts.warnings());
        Value::Object(document)
    }

    /// The table: one row per decided place.
    pub fn table(&self) -> Vec<Vec<String>> {
        let header = "along_m,x,y,vertex,height_amsl_m,state,margin_m,distance_m,elevation_deg";
        let mut rows = vec![header.split(',').map(str::to_string).collect::<Vec<_>>()];
        let cell = |v: Option<f64>| v.map_or(String::new(), |v| v.to_string());
        rows.extend(self.track.points.iter().map(|p| {
            let view = self.view(p.position, p.z);
            vec![
                (p.along * self.facts.meters_per_unit).to_string(),
                p.position[0].to_string(),
                p.position[1].to_string(),
                p.is_vertex.to_string(),
                cell(p.z.and_then(|z| i32::try_from(z).ok()).map(meters)),
                word(p.state).to_string(),
                cell(p.margin_m),
                cell(view.map(|v| v.0)),
                cell(view.map(|v| v.1)),
            ]
        }));
        rows
    }
}
