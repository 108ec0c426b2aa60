//! The search itself: values of all candidates, the best one, a local search around it, and several
//! UAVs together.

use skyshed_request::{Measure, Whom};

use super::plan::SearchPlan;
use super::report::{NO_RECEIVER, PlaceFacts, PlaceValue, SeveralFacts};
use crate::city::GivenSite;
use crate::coverage::{Control, Mapper, Uav, WorstReceiver};
use crate::error::Result;
use crate::height_field::HeightField;
use crate::placement::{
    Candidate, CandidateRules, Candidates, PlaceGrid, Score, Scorer, SeenSets, Weights, WorstMargin, cover,
    least_heights, ranked, ranked_margins, refined, scores, scores_over_grid, scoring_s, worst_margins,
};
use crate::progress::Progress;

/// Inputs of a search.
#[derive(Debug)]
pub(super) struct Search<'a> {
    pub(super) plan: &'a SearchPlan,
    pub(super) field: &'a HeightField,
    pub(super) rules: &'a CandidateRules<'a>,
    pub(super) candidates: &'a Candidates,
    pub(super) mapper: &'a Mapper<'a>,
    pub(super) weights: Option<&'a Weights>,
    /// Grid of the candidate places; `None` if they come from a file.
    pub(super) places: Option<&'a PlaceGrid>,
    /// Places of a file, by number; empty for candidates on a grid.
    pub(super) sites: &'a [GivenSite],
}

/// Results of a search.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) ranked: Vec<PlaceFacts>,
    pub(super) winner: std::result::Result<PlaceFacts, String>,
    pub(super) refined: Option<(PlaceFacts, u64)>,
    pub(super) several: Option<SeveralFacts>,
    /// Places of the candidates and the value that the heat map shows there. It is the best value
    /// over all heights, or the least height that reaches the share.
    pub(super) heat: Vec<(usize, f32)>,
    /// The winner, or the UAVs chosen together.
    pub(super) winners: Vec<Uav>,
}

impl Search<'_> {
    pub(super) fn run(&self, progress: &Progress) -> Result<Found> {
        let control = progress.control();
        progress.begin(self.candidates.kept.len() as u64);
        let goal = &self.plan.goal;
        let found = match (goal.measure, goal.at_least) {
            (Measure::Margin, _) => self.by_margin(control),
            (Measure::Share, Some(share)) => self.by_height(share, control),
            (Measure::Share, None) => self.by_share(control),
        };
        progress.end();
        found
    }

    /// Estimates the time of the search on one thread \[s\]; `None` if it is unknown.
    pub(super) fn cpu_seconds(&self) -> Option<f64> {
        /// Cost of storing the seen receivers of a UAV, relative to counting them.
        const SET: f64 = 2.5;
        match (self.plan.goal.measure, self.plan.goal.at_least) {
            (Measure::Share, None) if self.plan.count > 1 => Some(SET * scoring_s(&self.scorer(), None, self.kept())?),
            (Measure::Share, None) => scoring_s(&self.scorer(), self.places, self.kept()),
            _ => None,
        }
    }

    fn scorer(&self) -> Scorer<'_> {
        Scorer::new(self.mapper, self.weights)
    }

    fn value(&self, score: Score) -> PlaceValue {
        if self.plan.goal.whom == Whom::Weights { PlaceValue::Weighted(score) } else { PlaceValue::Counts(score) }
    }

    fn kept(&self) -> &[Candidate] {
        &self.candidates.kept
    }

    /// Returns the facts of a candidate, with the name and position of its site in a file.
    fn fact(&self, rank: usize, candidate: usize, value: PlaceValue) -> PlaceFacts {
        let candidate = &self.kept()[candidate];
        let given = self.sites.get(candidate.spot.place);
        PlaceFacts {
            id: given.map(|site| site.id.clone()),
            lonlat: given.and_then(|site| site.lonlat),
            ..PlaceFacts::of(rank, candidate, value)
        }
    }

    /// Returns the UAV of a candidate, under the name of its site in a file.
    fn uav(&self, candidate: usize) -> Uav {
        let candidate = &self.kept()[candidate];
        let id = self.sites.get(candidate.spot.place).map_or(String::new(), |site| site.id.clone());
        Uav { id, ..candidate.uav.clone() }
    }

    fn by_share(&self, control: &Control) -> Result<Found> {
        let mut sets = None;
        let scores = match self.places {
            _ if self.plan.count > 1 => {
                let (scores, all) = SeenSets::of(&self.scorer(), self.kept(), control)?;
                sets = Some(all);
                scores
            }
            Some(places) => scores_over_grid(&self.scorer(), places, self.kept(), control)?,
            None => scores(&self.scorer(), &self.kept().iter().map(|c| &c.uav).collect::<Vec<_>>(), control)?,
        };
        let order = ranked(&scores);
        let fact = |(rank, k): (usize, &usize)| self.fact(rank + 1, *k, self.value(scores[*k]));
        let facts: Vec<PlaceFacts> = order.iter().enumerate().map(fact).collect();
        let best = order.first().copied().filter(|k| scores[*k].wanted > 0);
        let refined = match best {
            Some(k) => self.refined(&self.kept()[k], scores[k])?,
            None => None,
        };
        let heat = self.heat(scores.iter().map(|s| s.share().map(narrow)).collect());
        let mut winners: Vec<Uav> = best.iter().map(|k| self.uav(*k)).collect();
        let mut several = None;
        if let Some(sets) = sets {
            let (facts, uavs) = self.several(&sets, &scores, control)?;
            (several, winners) = (Some(facts), uavs);
        }
        Ok(Found {
            winner: facts.first().filter(|_| best.is_some()).cloned().ok_or_else(|| NO_RECEIVER.to_string()),
            ranked: facts,
            refined,
            several,
            heat,
            winners,
        })
    }

    /// Returns the longest and the shortest step of the local search: the distance of the
    /// candidates, and the size of a cell. Places of a file and parts of the candidates have none.
    fn steps(&self) -> Option<(f64, f64)> {
        let grid = self.field.grid();
        let places = self.places.filter(|_| self.plan.shard.is_none());
        places.map(|places| (places.grid.cell_width(), grid.cell_width().min(grid.cell_height())))
    }

    fn refined(&self, from: &Candidate, score: Score) -> Result<Option<(PlaceFacts, u64)>> {
        let Some(steps) = self.steps() else { return Ok(None) };
        let scorer = self.scorer();
        let better = |uav: &Uav, best: &Score| scorer.score(uav).ok().filter(|score| score.compare(best).is_gt());
        let found = refined(self.field, self.rules, (from, score), steps, better)?;
        Ok(Some((PlaceFacts::of(0, &found.candidate, self.value(found.score)), found.tried)))
    }

    fn refined_margin(&self, from: &Candidate) -> Result<Option<(PlaceFacts, u64)>> {
        let worst = self.mapper.seen_from(&from.uav)?.worst_margin(&[]);
        let (Some(steps), Some(worst)) = (self.steps(), worst) else {
            return Ok(None);
        };
        // The worst receiver of this place usually rules out another place at once.
        let better = |uav: &Uav, best: &WorstReceiver| {
            let view = self.mapper.seen_from(uav).ok()?;
            let at_most = view.least_margin_among(&[best.cell]);
            if at_most.is_some_and(|margin| margin <= best.margin_m) {
                return None;
            }
            view.worst_margin(&[best.cell]).filter(|worst| worst.margin_m > best.margin_m)
        };
        let found = refined(self.field, self.rules, (from, worst), steps, better)?;
        let margin = WorstMargin { margin_m: found.score.margin_m, exact: true };
        Ok(Some((PlaceFacts::of(0, &found.candidate, PlaceValue::Margin(Some(margin))), found.tried)))
    }

    /// Chooses the candidates that together see most.
    fn several(&self, sets: &SeenSets, scores: &[Score], control: &Control) -> Result<(SeveralFacts, Vec<Uav>)> {
        let count = self.plan.count;
        let cover = cover(sets, count, control)?;
        let place = |(k, chosen): (usize, &crate::placement::Chosen)| {
            self.fact(k + 1, chosen.set, self.value(scores[chosen.set]))
        };
        let places = cover.chosen.iter().enumerate().map(place).collect();
        let uavs = cover.chosen.iter().map(|chosen| self.uav(chosen.set)).collect();
        Ok((SeveralFacts { count, cover, places }, uavs))
    }

    fn by_height(&self, share: f64, control: &Control) -> Result<Found> {
        let mut found = least_heights(&self.scorer(), self.kept(), share, control)?;
        let level = |candidate: usize| self.kept()[candidate].spot.level;
        let heat = found.iter().filter(|f| f.reaches).map(|f| {
            let spot = self.kept()[f.candidate].spot;
            (spot.place, narrow(spot.height.value()))
        });
        let heat = heat.collect();
        found.sort_by(|a, b| {
            let by_height = if a.reaches && b.reaches {
                level(a.candidate).cmp(&level(b.candidate))
            } else {
                std::cmp::Ordering::Equal
            };
            let by_share = b.score.compare(&a.score);
            b.reaches.cmp(&a.reaches).then(by_height).then(by_share).then(a.candidate.cmp(&b.candidate))
        });
        let fact =
            |(rank, f): (usize, &crate::placement::LeastHeight)| self.fact(rank + 1, f.candidate, self.value(f.score));
        let facts: Vec<PlaceFacts> = found.iter().enumerate().map(fact).collect();
        let winner = match (found.first(), facts.first()) {
            (Some(first), Some(facts)) if first.reaches => Ok(facts.clone()),
            (Some(first), _) => Err(match first.score.share() {
                Some(p) => format!("no candidate reaches {share}; the best, at its highest, sees {p:.4}"),
                None => NO_RECEIVER.to_string(),
            }),
            (None, _) => Err(NO_RECEIVER.to_string()),
        };
        let reaching = found.first().filter(|first| first.reaches);
        let winners = reaching.map(|first| self.uav(first.candidate)).into_iter().collect();
        Ok(Found { ranked: facts, winner, refined: None, several: None, heat, winners })
    }

    fn by_margin(&self, control: &Control) -> Result<Found> {
        let margins = worst_margins(self.mapper, self.kept(), self.plan.top, control)?;
        let order = ranked_margins(&margins);
        let fact = |(rank, k): (usize, &usize)| self.fact(rank + 1, *k, PlaceValue::Margin(margins[*k]));
        let facts: Vec<PlaceFacts> = order.iter().enumerate().map(fact).collect();
        let best = order.first().copied().filter(|k| margins[*k].is_some());
        let refined = match best {
            Some(k) => self.refined_margin(&self.kept()[k])?,
            None => None,
        };
        Ok(Found {
            winner: facts.first().filter(|_| best.is_some()).cloned().ok_or_else(|| NO_RECEIVER.to_string()),
            ranked: facts,
            refined,
            several: None,
            heat: self.heat(margins.iter().map(|m| m.map(|m| m.margin_m).filter(|m| m.is_finite())).collect()),
            winners: best.map(|k| self.uav(k)).into_iter().collect(),
        })
    }

    /// Returns the largest value over each place.
    fn heat(&self, values: Vec<Option<f32>>) -> Vec<(usize, f32)> {
        let mut best: std::collections::BTreeMap<usize, f32> = std::collections::BTreeMap::new();
        for (candidate, value) in self.kept().iter().zip(values) {
            let Some(value) = value else { continue };
            let at = best.entry(candidate.spot.place).or_insert(value);
            *at = at.max(value);
        }
        best.into_iter().collect()
    }
}

#[expect(clippy::cast_possible_truncation, reason = "for a picture and a raster of floats")]
fn narrow(v: f64) -> f32 {
    v as f32
}
