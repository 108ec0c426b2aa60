//! Report of a search: the document `skyshed/place/1`, its table and its points.

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

/// Value of a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PlaceValue {
    /// Numbers of receivers in range and in line of sight.
    Counts(Score),
    /// Weights of the receivers in range and in line of sight. Only their ratio has a meaning.
    Weighted(Score),
    /// Margin of the worst receiver, or an upper bound on it; `None` without a receiver.
    Margin(Option<WorstMargin>),
}

/// A place in a report.
#[derive(Debug, Clone)]
pub(crate) struct PlaceFacts {
    /// Rank from 1, or number in the order of choice.
    pub(crate) rank: usize,
    /// Name of the place; `None` without one.
    pub(crate) id: Option<String>,
    /// East \[CRS units\].
    pub(crate) x: f64,
    /// North \[CRS units\].
    pub(crate) y: f64,
    /// Longitude and latitude \[deg\]; `None` if the place was not read in degrees.
    pub(crate) lonlat: Option<[f64; 2]>,
    /// Height above the datum \[m\].
    pub(crate) height_amsl_m: f64,
    /// Height above the ground \[m\]; `None` where no ground is known.
    pub(crate) height_agl_m: Option<f64>,
    /// Zone below the UAV; `ground` or `rooftop` where zones are not known.
    pub(crate) placement: &'static str,
    /// Value of the place.
    pub(crate) value: PlaceValue,
    /// Difference of P_LoS to the best place with heights redrawn; `None` without height errors.
    pub(crate) heights: Option<HeightsOfDifference>,
}

impl PlaceFacts {
    /// Returns the facts of a candidate, without a name.
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

    /// Returns the position.
    pub(crate) fn position(&self) -> Position {
        Position { x: self.x, y: self.y, lonlat: self.lonlat }
    }

    /// Returns the height in words.
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

/// Reason for a missing value without receivers.
pub(crate) const NO_RECEIVER: &str = "no wanted receiver";

/// A choice of several UAVs in a report.
#[derive(Debug, Clone)]
pub(crate) struct SeveralFacts {
    /// Number of UAVs requested.
    pub(crate) count: usize,
    /// The choice, its coverage and the bound.
    pub(crate) cover: Cover,
    /// Chosen places, in the order of choice.
    pub(crate) places: Vec<PlaceFacts>,
}

impl SeveralFacts {
    /// Returns `value` as a share of all wanted receivers.
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

/// Report of a search.
#[derive(Debug, Clone)]
pub(crate) struct PlaceReport {
    pub(crate) facts: RunFacts,
    /// Receivers, range and antenna of the maps.
    pub(crate) sight: SightPlan,
    pub(crate) goal: Goal,
    /// Standard deviations of building height errors.
    pub(crate) height_errors: HeightErrorsPlan,
    /// Distance between neighboring candidate places \[m\]; `None` for places of a file.
    pub(crate) step_m: Option<f64>,
    /// Heights that were tried, in the order of the plan; empty where each candidate has its own.
    pub(crate) heights: Vec<String>,
    /// Least height above roof or ground directly below \[m\].
    pub(crate) clearance_m: f64,
    /// Numbers of candidates that were left out, by reason.
    pub(crate) skipped: Skipped,
    /// Candidates, best first. For a least height: the lowest candidate over each place that
    /// reaches the share.
    pub(crate) ranked: Vec<PlaceFacts>,
    /// Number of candidates that were tried.
    pub(crate) n_candidates: u64,
    /// Number of ranks that documents list.
    pub(crate) top: usize,
    /// Best place, or the reason for having none.
    pub(crate) winner: Result<PlaceFacts, String>,
    /// End point of the local search, and the number of places that it tried.
    pub(crate) refined: Option<(PlaceFacts, u64)>,
    /// Choice of several UAVs; `None` for one UAV.
    pub(crate) several: Option<SeveralFacts>,
    /// Digest of the ranked places, see [`place_digest`].
    pub(crate) digest: String,
}

/// Returns the `f64` that the shortest decimal form of a margin denotes.
fn shortest(margin: f32) -> f64 {
    margin.to_string().parse().unwrap_or(f64::from(margin))
}

/// Converts a number of receivers.
fn count(n: u128) -> u64 {
    u64::try_from(n).unwrap_or(u64::MAX)
}

/// Returns the SHA-256 of the values of the ranked places. Each place contributes x, y and the
/// height above the datum (f64), then its value. Values are seen and wanted (u64; u128 for weights)
/// or the margin (f32). Numbers are little endian.
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
    /// Returns the document. Pictures, rasters and the files beside tables store it without places.
    pub(crate) fn document(&self, with_places: bool, timing_s: Option<Timing>) -> Value {
        let s = self.skipped;
        document_of(&SearchDocument {
            head: self.facts.head("skyshed/place/1"),
            sight: self.sight.facts(),
            height_errors: self.height_errors.document(),
            // All wanted receivers, so that a place at the border gains nothing from having few in
            // range.
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

    /// Returns the table: the choice of several UAVs, then up to `most` candidates, best first,
    /// then the refined place.
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

    /// Returns the choice of several UAVs, the best places and the refined place as GeoJSON points
    /// in the scene's CRS. A point's id is the name of its place. If a name occurs again, its id
    /// also holds the kind and the rank.
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
