//! Scores of candidates on a grid of places: all those at one height together, if that is faster.

use std::collections::BTreeMap;

use super::{Candidate, PlaceGrid, Score, Scorer, scores};
use crate::coverage::{Control, Uav};
use crate::error::Result;
use crate::los::Method;

/// Scores candidates over a grid of places, in their order. The results equal those of [`scores`].
/// Candidates at one height are counted together if the engine is `shadow` and that is faster, else
/// by [`scores`].
///
/// Adds the number of candidates to `control.done` as it proceeds.
pub fn scores_over_grid(
    scorer: &Scorer<'_>,
    places: &PlaceGrid,
    candidates: &[Candidate],
    control: &Control,
) -> Result<Vec<Score>> {
    let mut found = vec![Score::default(); candidates.len()];
    let mut one_by_one: Vec<usize> = Vec::new();
    for at_height in by_height(candidates).into_values() {
        match together(scorer, places, (candidates, &at_height), control)? {
            Some(scores) => at_height.iter().zip(scores).for_each(|(k, score)| found[*k] = score),
            None => one_by_one.extend(at_height),
        }
    }
    let uavs: Vec<&Uav> = one_by_one.iter().map(|k| &candidates[*k].uav).collect();
    for (k, score) in one_by_one.iter().zip(scores(scorer, &uavs, control)?) {
        found[*k] = score;
    }
    Ok(found)
}

/// Estimates the time \[s\] of one thread for [`scores_over_grid`], or for [`scores`] without a
/// grid. `None` unless the engine is `shadow` over a flat earth.
pub fn scoring_s(scorer: &Scorer<'_>, places: Option<&PlaceGrid>, candidates: &[Candidate]) -> Option<f64> {
    let one_us = scorer.mapper.counting_one_us()?;
    let Some(places) = places else {
        #[expect(clippy::cast_precision_loss, reason = "an estimate")]
        let n = candidates.len() as f64;
        return Some(n * one_us * 1e-6);
    };
    let of_height = |at_height: &Vec<usize>| {
        let uavs = at_height.iter().map(|k| (candidates[*k].spot.place, &candidates[*k].uav));
        let costs = scorer.mapper.uav_grid(&places.grid, uavs).map(|uavs| scorer.mapper.counting_us(&uavs));
        #[expect(clippy::cast_precision_loss, reason = "an estimate")]
        let one_by_one = at_height.len() as f64 * one_us;
        costs.map_or(one_by_one, |[together, one_by_one]| together.min(one_by_one))
    };
    Some(by_height(candidates).values().map(of_height).sum::<f64>() * 1e-6)
}

/// Returns the indices of candidates by their height above the datum.
fn by_height(candidates: &[Candidate]) -> BTreeMap<i64, Vec<usize>> {
    let mut of_heights: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
    for (k, candidate) in candidates.iter().enumerate() {
        of_heights.entry(candidate.uav.station.z).or_default().push(k);
    }
    of_heights
}

/// Counts candidates at one height together and returns their scores; `None` if that is slower.
fn together(
    scorer: &Scorer<'_>,
    places: &PlaceGrid,
    (candidates, at_height): (&[Candidate], &[usize]),
    control: &Control,
) -> Result<Option<Vec<Score>>> {
    if scorer.mapper.method().0 != Method::Shadow {
        return Ok(None);
    }
    let uavs = at_height.iter().map(|k| (candidates[*k].spot.place, &candidates[*k].uav));
    let uav_grid = scorer.mapper.uav_grid(&places.grid, uavs);
    let Some(uav_grid) = uav_grid.filter(|uavs| scorer.mapper.is_counted_sooner(uavs)) else { return Ok(None) };
    let weight = |cell: usize| scorer.weights.map_or(1_u128, |weights| weights.of_cell(cell));
    let counts = scorer.mapper.count_grid(&uav_grid, &weight, control)?;
    let score = |seen: u128| Score { wanted: scorer.wanted, seen };
    Ok(counts.map(|seen| at_height.iter().map(|k| score(seen[candidates[*k].spot.place])).collect()))
}
