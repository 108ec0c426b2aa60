//! Where to hover as reported: the document `skyshed/place/1`, its table and its points.

use serde_json::Value;

use skyshed_request::Goal;

use super::document::{
    CandidatesDocument, FoundDocument, PlaceDocument, PlaceRow, SearchDocument, SeveralDocument, SkippedDocument,
};
use crate::answer::{
    Position, Rows, RunFacts, Timing, digest_words, document_of, feature, feature_collection, rows, warnings_of,
};
use crate::digest::Sha256;
use crate::height_errors::{HeightErrorsPlan, HeightsOfDifference};
use crate::placement::{Candidate, Cover, Score, Skipped, WorstMargin};
use crate::sight::SightPlan;

/// What a place is worth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PlaceValue {
    /// Receivers in range and how many of them are seen.
    Counts(Score),
    /// Weights of the receivers in range and of those that are seen: only the share has a meaning.
    Weighted(Score),
    /// The margin of the worst receiver, or a bound on it; `None` without a receiver.
    Margin(Option<WorstMargin>),
}

/// A place as reported.
#[derive(Debug, Clone)]
pub(crate) struct PlaceFacts {
    /// Its rank from 1, or its number in the order of choice.
    pub(crate) rank: usize,
    /// Its name, if it has one.
    pub(crate) id: Option<String>,
    /// East \[CRS units\].
    pub(crate) x: f64,
    /// North \[CRS units\].
    pub(crate) y: f64,
    /// Longitude and latitude \[deg\], if it was given by these.
    pub(crate) lonlat: Option<[f64; 2]>,
    /// Height above the datum \[m\].
    pub(crate) height_amsl_m: f64,
    /// Height above the ground \[m\], if one is known there.
    pub(crate) height_agl_m: Option<f64>,
    /// The zone below it where zones are known, else `ground` or `rooftop`.
    pub(crate) placement: &'static str,
    /// What it is worth.
    pub(crate) value: PlaceValue,
    /// How much less than the best it sees with heights redrawn, where they may be off.
    pub(crate) heights: Option<HeightsOfDifference>,
}

impl PlaceFacts {
    /// The facts of a candidate, which has no name.
    pub(crate) fn of(rank: usize, candidate: &Candidate, value: PlaceValue) -> Self {
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
            heights: None,
        }
    }

    /// Where it is.
    pub(crate) fn position(&self) -> Position {
        Position { x: self.x, y: self.y, lonlat: self.lonlat }
    }

    /// The height in words.
    pub(crate) fn height_words(&self) -> String {
        crate::words::height_words(self.height_agl_m, self.height_amsl_m)
    }

    fn document(&self) -> PlaceDocument {
        let mut place = PlaceDocument {
            rank: Some(self.rank),
            id: self.id.clone(),
            position: self.position().into(),
            height_amsl_m: self.height_amsl_m,
            height_agl_m: self.height_agl_m,
            placement: self.placement,
            heights: self.heights,
            ..PlaceDocument::default()
        };
        match self.value {
            PlaceValue::Counts(score) => {
                (place.receivers, place.los) = (Some(count(score.wanted)), Some(count(score.seen)));
                place.p_los = Some(score.share());
            }
            PlaceValue::Weighted(score) => place.p_los = Some(score.share()),
            PlaceValue::Margin(margin) => {
                let finite = margin.map(|m| m.margin_m).filter(|m| m.is_finite());
                let is_exact = margin.is_none_or(|m| m.exact);
                (place.margin_m, place.margin_upper_bound_m) =
                    if is_exact { (Some(finite), None) } else { (None, Some(finite)) };
                place.reason =
                    (margin.is_some() && finite.is_none()).then_some("no receiver height is enough somewhere");
            }
        }
        let has_none = match self.value {
            PlaceValue::Counts(score) | PlaceValue::Weighted(score) => score.wanted == 0,
            PlaceValue::Margin(margin) => margin.is_none(),
        };
        if has_none {
            place.reason = Some(NO_RECEIVER);
        }
        place
    }

    fn row(&self, kind: &'static str, rank: Option<usize>, cover: [Option<f64>; 2]) -> PlaceRow {
        let PlaceDocument { receivers, los, p_los, margin_m, margin_upper_bound_m, .. } = self.document();
        let [gain, covered] = cover;
        PlaceRow {
            kind,
            rank,
            id: self.id.clone(),
            position: self.position().into(),
            height_amsl_m: self.height_amsl_m,
            height_agl_m: self.height_agl_m,
            placement: self.placement,
            receivers,
            los,
            p_los: p_los.flatten(),
            margin_m: margin_m.flatten().map(shortest),
            margin_upper_bound_m: margin_upper_bound_m.flatten().map(shortest),
            heights_low: self.heights.map(|heights| heights.low()),
            heights_high: self.heights.map(|heights| heights.high()),
            exceeds_heights: self.heights.map(|heights| heights.exceeds()),
            gain,
            covered,
        }
    }
}

/// Why nothing is worth anything.
pub(crate) const NO_RECEIVER: &str = "no wanted receiver";

/// Several UAVs together, as reported.
#[derive(Debug, Clone)]
pub(crate) struct SeveralFacts {
    /// How many were asked for.
    pub(crate) count: usize,
    /// The choice, with what it covers and the bound.
    pub(crate) cover: Cover,
    /// The chosen places, in the order of choice.
    pub(crate) places: Vec<PlaceFacts>,
}

impl SeveralFacts {
    /// What a value is of all wanted receivers.
    pub(crate) fn share(&self, value: u128) -> Option<f64> {
        Score { wanted: self.cover.wanted, seen: value }.share()
    }
}

impl SeveralDocument {
    fn of(several: &SeveralFacts) -> Self {
        let cover = &several.cover;
        let chosen = several.places.iter().zip(&cover.chosen).map(|(place, chosen)| PlaceDocument {
            gain: Some(several.share(chosen.gain)),
            covered: Some(several.share(chosen.covered)),
            ..place.document()
        });
        SeveralDocument {
            count: several.count,
            chosen: chosen.collect(),
            p_los: several.share(cover.covered()),
            bound: several.share(cover.bound),
            gap: cover.gap(),
            reason: (cover.wanted == 0).then_some(NO_RECEIVER),
        }
    }
}

/// A search as reported.
#[derive(Debug, Clone)]
pub(crate) struct PlaceReport {
    pub(crate) facts: RunFacts,
    /// Whose sight counts.
    pub(crate) sight: SightPlan,
    pub(crate) goal: Goal,
    /// How far heights of buildings may be off.
    pub(crate) height_errors: HeightErrorsPlan,
    /// Distance of the candidate places \[m\], if they are on a grid.
    pub(crate) step_m: Option<f64>,
    /// The heights tried, lowest first; empty where each candidate has its own.
    pub(crate) heights: Vec<String>,
    /// Clearance above what is directly below \[m\].
    pub(crate) clearance_m: f64,
    /// How many candidates were left out and why.
    pub(crate) skipped: Skipped,
    /// The candidates, best first; with a share to reach, the lowest that reaches it over each place.
    pub(crate) ranked: Vec<PlaceFacts>,
    /// How many candidates there are.
    pub(crate) n_candidates: u64,
    /// How many ranks documents list.
    pub(crate) top: usize,
    /// The best, or why there is none.
    pub(crate) winner: Result<PlaceFacts, String>,
    /// Where a search between the candidates ended, and how many places it tried.
    pub(crate) refined: Option<(PlaceFacts, u64)>,
    /// Several UAVs together, if they were asked for.
    pub(crate) several: Option<SeveralFacts>,
    /// Digest of what was found, see [`place_digest`].
    pub(crate) digest: String,
}

/// The number that the shortest digits of a margin say.
fn shortest(margin: f32) -> f64 {
    margin.to_string().parse().unwrap_or(f64::from(margin))
}

/// A number of receivers.
fn count(n: u128) -> u64 {
    u64::try_from(n).unwrap_or(u64::MAX)
}

/// SHA-256 of the values of the ranked places: per place its x and y (f64), its height above the datum (f64) and its value,
/// seen and wanted (u64, weights u128) or margin (f32); little endian.
pub(crate) fn place_digest(ranked: &[PlaceFacts]) -> String {
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
    /// The document; without what was found it is stored in pictures and rasters and beside tables.
    pub(crate) fn document(&self, with_places: bool, timing_s: Option<Timing>) -> Value {
        let s = self.skipped;
        document_of(&SearchDocument {
            head: self.facts.head("skyshed/place/1"),
            sight: self.sight.facts(),
            height_errors: self.height_errors.document(),
            // A place at the border gains nothing by having few in range.
            share_of: "all wanted receivers, in range or not",
            goal: &self.goal.text,
            candidates: CandidatesDocument {
                step_m: self.step_m,
                heights: &self.heights,
                clearance_m: self.clearance_m,
                asked: self.n_candidates + s.total(),
                tried: self.n_candidates,
                skipped: SkippedDocument {
                    no_data: s.no_data,
                    outside: s.outside,
                    other_zone: s.other_zone,
                    keep_out: s.keep_out,
                    no_base: s.no_base,
                    inside: s.inside,
                    clearance: s.clearance,
                },
            },
            found: with_places.then(|| self.found()),
            timing_s,
            warnings: warnings_of(&self.facts.warnings),
            digest: &self.digest,
        })
    }

    fn found(&self) -> FoundDocument {
        let refined =
            |(place, tried): &(PlaceFacts, u64)| PlaceDocument { rank: None, tried: Some(*tried), ..place.document() };
        FoundDocument {
            winner: self.winner.as_ref().ok().map(PlaceFacts::document),
            reason: self.winner.as_ref().err().cloned(),
            refined: self.refined.as_ref().map(refined),
            ranked: self.ranked.iter().take(self.top).map(PlaceFacts::document).collect(),
            several: self.several.as_ref().map(SeveralDocument::of),
        }
    }

    /// The table: the choice of several in its order, then the candidates best first, at most so many, then the refined place.
    pub(crate) fn table(&self, most: usize) -> Rows {
        let chosen = |several: &SeveralFacts| {
            let of = |(place, chosen): (&PlaceFacts, &crate::placement::Chosen)| {
                let shares = [several.share(chosen.gain), several.share(chosen.covered)];
                place.row("chosen", Some(place.rank), shares)
            };
            several.places.iter().zip(&several.cover.chosen).map(of).collect::<Vec<_>>()
        };
        let ranked = self.ranked.iter().take(most).map(|place| place.row("candidate", Some(place.rank), [None; 2]));
        let refined = self.refined.iter().map(|(place, _)| place.row("refined", None, [None; 2]));
        rows(self.several.iter().flat_map(chosen).chain(ranked).chain(refined))
    }

    /// The choice of several, the best places and the refined one as GeoJSON points, in the scene's CRS. Their ids are their
    /// names; one that occurs again, chosen and ranked or at several heights, is told with its kind and rank.
    pub(crate) fn geojson(&self) -> Value {
        let mut names = std::collections::HashSet::new();
        let mut features: Vec<Value> = Vec::new();
        let mut push = |kind: &str, number: String, place: &PlaceFacts| {
            let id = match &place.id {
                Some(name) if names.insert(name.clone()) => name.clone(),
                Some(name) => format!("{name}, {kind} {}", place.rank),
                None => number,
            };
            let mut properties = document_of(&PlaceDocument { id: Some(id), ..place.document() });
            properties["kind"] = kind.into();
            features.push(feature(properties, Some(("Point", vec![place.x, place.y].into()))));
        };
        let chosen = self.several.iter().flat_map(|s| &s.places);
        chosen.for_each(|place| push("chosen", format!("chosen {}", place.rank), place));
        self.ranked.iter().take(self.top).for_each(|place| push("candidate", place.rank.to_string(), place));
        self.refined.iter().for_each(|(place, _)| push("refined", "refined".into(), place));
        feature_collection(&self.facts.grid, self.document(false, None), features)
    }
}
