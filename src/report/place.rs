//! Where to hover as reported: the document `skyshed/place/1`, its table and its points.

use serde_json::{Map, Value, json};

use super::documents::{RunFacts, Timing, digest_words};
use super::features::feature_collection;
use super::position::{Position, PositionCells};
use crate::digest::Sha256;
use crate::placement::{Candidate, Cover, Score, Skipped, WorstMargin};

/// What a place is worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlaceValue {
    /// Receivers in range and how many of them are seen.
    Counts(Score),
    /// The same by weight: only the share has a meaning.
    Weighted(Score),
    /// The margin of the worst receiver, or a bound on it; `None` without a receiver.
    Margin(Option<WorstMargin>),
}

/// A place as reported.
#[derive(Debug, Clone)]
pub struct PlaceFacts {
    /// Its rank from 1, or its number in the order of choice.
    pub rank: usize,
    /// Its name, if it has one.
    pub id: Option<String>,
    /// East \[CRS units\].
    pub x: f64,
    /// North \[CRS units\].
    pub y: f64,
    /// Longitude and latitude \[deg\], if it was given by these.
    pub lonlat: Option<[f64; 2]>,
    /// Height above the datum \[m\].
    pub height_amsl_m: f64,
    /// Height above the ground \[m\], if one is known there.
    pub height_agl_m: Option<f64>,
    /// The zone below it where zones are known, else `ground` or `rooftop`.
    pub placement: &'static str,
    /// What it is worth.
    pub value: PlaceValue,
}

impl PlaceFacts {
    /// The facts of a candidate, which has no name.
    pub fn of(rank: usize, candidate: &Candidate, value: PlaceValue) -> Self {
        let uav = &candidate.uav;
        PlaceFacts {
            rank,
            id: None,
            x: uav.station.place.x,
            y: uav.station.place.y,
            lonlat: None,
            height_amsl_m: uav.height_amsl_m(),
            height_agl_m: uav.height_agl_m,
            placement: candidate.zone.map_or(uav.placement.name(), crate::zones::Zone::name),
            value,
        }
    }

    /// P_LoS, if that is what the place is worth.
    pub fn p_los(&self) -> Option<f64> {
        match self.value {
            PlaceValue::Counts(score) | PlaceValue::Weighted(score) => score.share(),
            PlaceValue::Margin(_) => None,
        }
    }

    /// Where it is.
    pub fn position(&self) -> Position {
        Position { x: self.x, y: self.y, lonlat: self.lonlat }
    }

    fn json(&self) -> Map<String, Value> {
        let mut object = Map::new();
        object.insert("rank".into(), self.rank.into());
        object.extend(self.id.clone().map(|id| ("id".to_string(), id.into())));
        self.position().tell(&mut object);
        object.insert("height_amsl_m".into(), self.height_amsl_m.into());
        object.insert("height_agl_m".into(), self.height_agl_m.into());
        object.insert("placement".into(), self.placement.into());
        match self.value {
            PlaceValue::Counts(score) => {
                object.insert("receivers".into(), count(score.wanted).into());
                object.insert("los".into(), count(score.seen).into());
                object.insert("p_los".into(), score.share().into());
            }
            PlaceValue::Weighted(score) => {
                object.insert("p_los".into(), score.share().into());
            }
            PlaceValue::Margin(margin) => {
                let finite = margin.map(|m| m.margin_m).filter(|m| m.is_finite());
                let key = if margin.is_none_or(|m| m.exact) { "margin_m" } else { "margin_upper_bound_m" };
                object.insert(key.into(), finite.into());
                if margin.is_some() && finite.is_none() {
                    object.insert("reason".into(), "no receiver height is enough somewhere".into());
                }
            }
        }
        let has_none = match self.value {
            PlaceValue::Counts(score) | PlaceValue::Weighted(score) => score.wanted == 0,
            PlaceValue::Margin(margin) => margin.is_none(),
        };
        if has_none {
            object.insert("reason".into(), NO_RECEIVER.into());
        }
        object
    }

    /// Receivers, those seen, P_LoS, margin and its upper bound, as cells of a table.
    fn cells(&self) -> [String; 5] {
        let number = |v: Option<f64>| v.map_or(String::new(), |v| v.to_string());
        let mut cells: [String; 5] = Default::default();
        cells[2] = number(self.p_los());
        match self.value {
            PlaceValue::Counts(score) => {
                (cells[0], cells[1]) = (score.wanted.to_string(), score.seen.to_string());
            }
            PlaceValue::Weighted(_) | PlaceValue::Margin(None) => {}
            PlaceValue::Margin(Some(m)) => {
                let finite = m.margin_m.is_finite().then(|| m.margin_m.to_string());
                cells[if m.exact { 3 } else { 4 }] = finite.unwrap_or_default();
            }
        }
        cells
    }
}

/// Why nothing is worth anything.
pub const NO_RECEIVER: &str = "no wanted receiver";

/// Several UAVs together, as reported.
#[derive(Debug, Clone)]
pub struct SeveralFacts {
    /// How many were asked for.
    pub count: usize,
    /// The choice, with what it covers and the bound.
    pub cover: Cover,
    /// The chosen places, in the order of choice.
    pub places: Vec<PlaceFacts>,
}

impl SeveralFacts {
    /// What a value is of all wanted receivers.
    pub fn share(&self, value: u128) -> Option<f64> {
        Score { wanted: self.cover.wanted, seen: value }.share()
    }
}

/// A search as reported.
#[derive(Debug, Clone)]
pub struct PlaceReport {
    /// The run.
    pub facts: RunFacts,
    /// Height of the receivers above what they stand on \[m\].
    pub rx_height_m: f64,
    /// Which cells hold receivers.
    pub receivers: &'static str,
    /// Range \[m\], if it is limited.
    pub radius_m: Option<f64>,
    /// The goal as typed.
    pub goal: String,
    /// Distance of the candidate places \[m\], if they are on a grid.
    pub step_m: Option<f64>,
    /// The heights tried, lowest first; empty where each candidate has its own.
    pub heights: Vec<String>,
    /// Clearance above what is directly below \[m\].
    pub clearance_m: f64,
    /// How many candidates were left out and why.
    pub skipped: Skipped,
    /// The candidates, best first; with a share to reach, the lowest that reaches it over each place.
    pub ranked: Vec<PlaceFacts>,
    /// How many candidates there are.
    pub n_candidates: u64,
    /// How many ranks documents list.
    pub top: usize,
    /// The best, or why there is none.
    pub winner: Result<PlaceFacts, String>,
    /// Where a search between the candidates ended, and how many places it tried.
    pub refined: Option<(PlaceFacts, u64)>,
    /// Several UAVs together, if they were asked for.
    pub several: Option<SeveralFacts>,
    /// Digest of what was found, see [`place_digest`].
    pub digest: String,
}

/// A number of receivers.
fn count(n: u128) -> u64 {
    u64::try_from(n).unwrap_or(u64::MAX)
}

/// SHA-256 of the values of the ranked places: per place its x and y (f64), its height above the datum (f64) and its value,
/// seen and wanted (u64, weights u128) or margin (f32); little endian.
pub fn place_digest(ranked: &[PlaceFacts]) -> String {
    let mut hasher = Sha256::default();
    for place in ranked {
        [place.x, place.y, place.height_amsl_m].iter().for_each(|v| hasher.update(v.to_le_bytes()));
        match place.value {
            PlaceValue::Counts(score) => {
                [score.seen, score.wanted].iter().for_each(|n| hasher.update(count(*n).to_le_bytes()));
            }
            PlaceValue::Weighted(score) => {
                [score.seen, score.wanted].iter().for_each(|n| hasher.update(n.to_le_bytes()));
            }
            PlaceValue::Margin(margin) => hasher.update(margin.map_or(f32::NAN, |m| m.margin_m).to_le_bytes()),
        }
    }
    digest_words(hasher)
}

impl PlaceReport {
    /// The document `skyshed/place/1`; without `timing` it is the same for equal runs.
    pub fn document(&self, timing: Option<Timing>) -> Value {
        let mut document = self.head();
        let (winner, reason) = match &self.winner {
            Ok(winner) => (Value::Object(winner.json()), None),
            Err(reason) => (Value::Null, Some(reason.clone())),
        };
        document.insert("winner".into(), winner);
        document.extend(reason.map(|reason| ("reason".to_string(), reason.into())));
        let refined = self.refined.as_ref().map(|(place, tried)| {
            let mut object = place.json();
            object.remove("rank");
            object.insert("tried".into(), (*tried).into());
            Value::Object(object)
        });
        document.insert("refined".into(), refined.into());
        let top = self.ranked.iter().take(self.top).map(|p| Value::Object(p.json()));
        document.insert("ranked".into(), top.collect::<Vec<_>>().into());
        document.insert("several".into(), self.several.as_ref().map(several_json).into());
        if let Some(t) = timing {
            document.insert("timing_s".into(), t.json());
        }
        self.close(document)
    }

    /// The document without what was found, as stored in pictures and rasters and beside tables.
    pub fn provenance(&self) -> Value {
        self.close(self.head())
    }

    fn head(&self) -> Map<String, Value> {
        let mut document = self.facts.head("skyshed/place/1");
        document.insert("rx_height_m".into(), self.rx_height_m.into());
        document.insert("receivers".into(), self.receivers.into());
        document.insert("radius_m".into(), self.radius_m.into());
        // A place at the border gains nothing by having few in range.
        document.insert("share_of".into(), "all wanted receivers, in range or not".into());
        document.insert("goal".into(), self.goal.clone().into());
        let s = self.skipped;
        document.insert(
            "candidates".into(),
            json!({
                "step_m": self.step_m, "heights": self.heights, "clearance_m": self.clearance_m,
                "asked": self.n_candidates + s.total(), "tried": self.n_candidates,
                "skipped": {"no_data": s.no_data, "outside": s.outside, "other_zone": s.other_zone, "keep_out": s.keep_out,
                            "no_base": s.no_base, "inside": s.inside, "clearance": s.clearance},
            }),
        );
        document
    }

    fn close(&self, mut document: Map<String, Value>) -> Value {
        document.insert("warnings".into(), self.facts.warnings());
        document.insert("digest".into(), self.digest.clone().into());
        Value::Object(document)
    }

    /// The table: the choice of several in its order, then the candidates best first, then the refined place. Candidates
    /// that have names have a column for these.
    pub fn table(&self) -> Vec<Vec<String>> {
        let positions = PositionCells::of(self.ranked.iter().map(PlaceFacts::position));
        let has_names = self.ranked.iter().any(|place| place.id.is_some());
        let header = format!(
            "kind,rank,{}{},height_amsl_m,height_agl_m,placement,receivers,los,p_los,margin_m,margin_upper_bound_m,gain,\
             covered",
            if has_names { "id," } else { "" },
            positions.names()
        );
        let mut rows = vec![header.split(',').map(str::to_string).collect::<Vec<_>>()];
        let mut push = |kind: &str, rank: String, place: &PlaceFacts, cover: [String; 2]| {
            let mut row = vec![kind.to_string(), rank];
            row.extend(has_names.then(|| place.id.clone().unwrap_or_default()));
            row.extend(positions.cells(Some(place.position())));
            row.push(place.height_amsl_m.to_string());
            row.push(place.height_agl_m.map_or(String::new(), |v| v.to_string()));
            row.push(place.placement.to_string());
            row.extend(place.cells());
            row.extend(cover);
            rows.push(row);
        };
        if let Some(several) = &self.several {
            for (place, chosen) in several.places.iter().zip(&several.cover.chosen) {
                let share = |v: u128| several.share(v).map_or(String::new(), |p| p.to_string());
                push("chosen", place.rank.to_string(), place, [share(chosen.gain), share(chosen.covered)]);
            }
        }
        let none = || [String::new(), String::new()];
        self.ranked.iter().for_each(|place| push("candidate", place.rank.to_string(), place, none()));
        if let Some((place, _)) = &self.refined {
            push("refined", String::new(), place, none());
        }
        rows
    }

    /// The choice of several, the best places and the refined one as GeoJSON points, in the scene's CRS. Their ids are their
    /// names; one that occurs again, chosen and ranked or at several heights, is told with its kind and rank.
    pub fn geojson(&self) -> Value {
        let mut names = std::collections::HashSet::new();
        let mut features: Vec<Value> = Vec::new();
        let mut push = |kind: &str, number: String, place: &PlaceFacts| {
            let id = match &place.id {
                Some(name) if names.insert(name.clone()) => name.clone(),
                Some(name) => format!("{name}, {kind} {}", place.rank),
                None => number,
            };
            let mut properties = place.json();
            properties.insert("id".into(), id.into());
            properties.insert("kind".into(), kind.into());
            features.push(json!({"type": "Feature", "properties": properties,
                                 "geometry": {"type": "Point", "coordinates": [place.x, place.y]}}));
        };
        let chosen = self.several.iter().flat_map(|s| &s.places);
        chosen.for_each(|place| push("chosen", format!("chosen {}", place.rank), place));
        self.ranked.iter().take(self.top).for_each(|place| push("candidate", place.rank.to_string(), place));
        self.refined.iter().for_each(|(place, _)| push("refined", "refined".into(), place));
        feature_collection(&self.facts.grid, self.provenance(), features)
    }
}

/// The choice: `covered`, `gain` and `bound` as shares of all wanted receivers, at any distance.
fn several_json(several: &SeveralFacts) -> Value {
    let cover = &several.cover;
    let chosen = several.places.iter().zip(&cover.chosen).map(|(place, chosen)| {
        let mut object = place.json();
        object.insert("gain".into(), several.share(chosen.gain).into());
        object.insert("covered".into(), several.share(chosen.covered).into());
        Value::Object(object)
    });
    json!({
        "count": several.count,
        "chosen": chosen.collect::<Vec<_>>(),
        "p_los": several.share(cover.covered()),
        "bound": several.share(cover.bound),
        "gap": cover.gap(),
        "reason": if cover.wanted == 0 { Some(NO_RECEIVER) } else { None },
    })
}
