//! Text that `skyshed place` prints: the best places, the bound, and the candidates left out.

use skyshed_request::Whom;

use super::report::{PlaceFacts, PlaceReport, PlaceValue};
use crate::quantity::tidy;

/// Returns the value of a place in words.
fn value_words(place: &PlaceFacts, receivers: &str) -> String {
    match place.value {
        PlaceValue::Counts(score) => match score.share() {
            Some(p) => format!("P_LoS {p:.4}, {} of {} {receivers}", score.seen, score.wanted),
            None => "P_LoS undefined".into(),
        },
        PlaceValue::Weighted(score) => {
            score.share().map_or("P_LoS undefined".into(), |p| format!("weighted P_LoS {p:.4}"))
        }
        PlaceValue::Margin(Some(m)) if m.margin_m.is_finite() => {
            format!("worst margin {} m", tidy(f64::from(m.margin_m)))
        }
        PlaceValue::Margin(_) => "no receiver height is enough for the worst".into(),
    }
}

/// Returns the position of a place in words, with its name if it has one.
fn at_words(place: &PlaceFacts) -> String {
    let name = place.id.as_ref().map_or(String::new(), |id| format!("{id} "));
    name + &place.position().in_words()
}

/// Returns a place in words.
fn place_words(place: &PlaceFacts, receivers: &str) -> String {
    let value = value_words(place, receivers);
    format!("{} at {} over {}: {value}", place.height_words(), at_words(place), place.placement)
}

/// Returns the receivers that count for a goal, in words.
fn wanted(report: &PlaceReport) -> String {
    let receivers = report.sight.receivers().name();
    let receivers = if receivers == "all" { "ground and roof" } else { receivers };
    let area = if report.goal.whom == Whom::Area { " in the area" } else { "" };
    format!("{receivers} receivers{area}")
}

/// Returns all wanted receivers in words, at any distance.
fn all_wanted(report: &PlaceReport) -> String {
    let weight = if report.goal.whom == Whom::Weights { "the weight of " } else { "" };
    format!("{weight}all {}{}", wanted(report), in_range_or_not(report))
}

/// Returns a remark that shares include receivers out of range; empty without a range.
fn in_range_or_not(report: &PlaceReport) -> &'static str {
    if report.sight.is_limited() { ", in range or not" } else { "" }
}

/// Returns a search in words: the winner, the refined place, several UAVs with bound and gap, and
/// the candidates left out.
pub(super) fn in_words(report: &PlaceReport) -> Vec<String> {
    let receivers = wanted(report) + in_range_or_not(report);
    let mut lines = vec![match &report.winner {
        Ok(winner) => format!("best of {} candidates: {}", report.n_candidates, place_words(winner, &receivers)),
        Err(reason) => format!("no winner among {} candidates: {reason}", report.n_candidates),
    }];
    let told: Vec<&PlaceFacts> = report.ranked.iter().filter(|place| place.heights.is_some()).collect();
    if !told.is_empty() {
        let as_good = told.iter().filter(|place| place.heights.is_some_and(|heights| !heights.exceeds()));
        let ranks: Vec<String> = as_good.map(|place| place.rank.to_string()).collect();
        let (n, next) = (ranks.len(), told.len());
        let which = if ranks.is_empty() { String::new() } else { format!(": ranks {}", ranks.join(", ")) };
        lines.push(format!("of the next {next} places {n} may be as good, with errors of heights as told{which}"));
    }
    let refined = |(place, tried): &(PlaceFacts, u64)| {
        format!("refined ({tried} more places): {}", place_words(place, &receivers))
    };
    lines.extend(report.refined.iter().map(refined));
    if let Some(several) = &report.several {
        let share = |v: u128| several.share(v).map_or("undefined".to_string(), |p| format!("{p:.4}"));
        let chosen: Vec<String> = several.places.iter().map(at_words).collect();
        let most = match several.cover.gap() {
            Some(gap) if gap > 0.0 => format!("more than {} (gap {:.2} %)", share(several.cover.bound), 100.0 * gap),
            Some(_) => "more (optimal)".to_string(),
            None => "any".to_string(),
        };
        lines.push(format!(
            "{} UAVs see together {} of {}; no {} of these candidates see {most}: {}",
            several.places.len(),
            share(several.cover.covered()),
            all_wanted(report),
            several.count,
            chosen.join(", ")
        ));
    }
    let skipped: Vec<String> =
        report.skipped.reasons().iter().filter(|r| r.1 > 0).map(|(why, n)| format!("{n} {why}")).collect();
    if !skipped.is_empty() {
        lines.push(format!("left out: {}", skipped.join(", ")));
    }
    lines
}
