//! Report of a comparison: the document `skyshed/compare/1` and its table.

use serde_json::Value;

use super::document::{
    ByZone, CompareDocument, CompareRow, DifferenceDocument, IntervalsDocument, MarginDocument, MarginsDocument,
    PairDocument, PlacementDocument, SetDocument, ShareDocument,
};
use super::facts::{
    GroupDifference, IntervalFacts, N_GROUPS, Origin, PairFacts, PlacementFacts, finite, grazing_share, group_names,
    reason_without_interval,
};
use crate::answer::{Rows, RunFacts, Timing, document_of, rows, warnings_of};
use crate::city_statistics::bootstrap::{RESAMPLINGS, RatioEstimate};
use crate::coverage::{GRAZING_M, Tally};
use crate::height_errors::HeightErrorsPlan;
use crate::quantity;
use crate::sight::{SightPlan, antenna_words};

/// Report of a comparison of placements.
#[derive(Debug, Clone)]
pub(crate) struct CompareReport {
    /// Facts of the run.
    pub(crate) facts: RunFacts,
    /// Receivers, range and antenna of the maps.
    pub(crate) sight: SightPlan,
    /// Settings of the intervals.
    pub(crate) intervals: IntervalFacts,
    /// `true` if the zones of the scene are known.
    pub(crate) has_zones: bool,
    /// The placements.
    pub(crate) placements: Vec<PlacementFacts>,
    /// All pairs, the first always before the second.
    pub(crate) pairs: Vec<PairFacts>,
    /// Standard deviations of building height errors.
    pub(crate) heights: HeightErrorsPlan,
    /// Counts of the overlay of all placements.
    pub(crate) union: Tally,
    /// Receivers of any placement that 0, 1, 2 … of them see.
    pub(crate) seen_by: Vec<u64>,
    /// Receivers by the exact set of placements that see them, bit k for placement k; `None` for
    /// too many placements.
    pub(crate) sets: Option<Vec<u64>>,
    /// Digest of the masks in order, see [`crate::map::MaskDigest`].
    pub(crate) digest: String,
}

/// Meaning of an interval, in words.
const MEANING: &str = "blocks of ground are drawn with replacement, the same ones for all placements; an interval says how \
                       far a value would move over other ground of this kind, not how wrong the heights are";

/// Returns a difference of P_LoS with four decimals, its sign, and a true minus.
pub(crate) fn signed(difference: f64) -> String {
    quantity::signed(difference, 4)
}

/// Reason why a saved mask has no margins.
const NO_MARGINS: &str = "a saved mask says who is in line of sight, not by how much";

impl CompareReport {
    /// Returns `true` if any P_LoS or difference has an interval.
    pub(crate) fn has_intervals(&self) -> bool {
        let shares = self.placements.iter().flat_map(|p| &p.groups).map(|g| &g.p_los);
        let differences = self.pairs.iter().flat_map(|p| &p.groups).map(|g| &g.difference);
        shares.chain(differences).any(|estimate| estimate.interval.is_some())
    }

    /// Returns the document. Without `timing_s` it is the same for equal runs.
    pub(crate) fn document(&self, timing_s: Option<Timing>) -> Value {
        document_of(&CompareDocument {
            head: self.facts.head("skyshed/compare/1"),
            sight: self.sight.facts(),
            height_errors: self.heights.document(),
            intervals: IntervalsDocument {
                method: "block bootstrap",
                confidence: self.intervals.confidence,
                block_m: self.intervals.block_m,
                resamplings: RESAMPLINGS,
                seed: self.intervals.seed,
                meaning: self.meaning(),
            },
            verdict: self.verdict(),
            placements: self.placements.iter().map(|p| self.placement(p)).collect(),
            pairs: self.pairs.iter().map(|p| self.pair(p)).collect(),
            union: (&self.union).into(),
            seen_by: self.seen_by.clone(),
            sets: self.sets(),
            timing_s,
            warnings: warnings_of(&self.facts.warnings),
            digest: self.digest.clone(),
        })
    }

    /// Returns values for the receivers of each zone; `None` where no zone is known.
    fn by_zone<T, D>(&self, groups: &[T; N_GROUPS], of: impl Fn(&T) -> D) -> Option<ByZone<D>> {
        let [_, street, crossroad, courtyard, rooftop] = groups;
        self.has_zones.then(|| ByZone {
            street: of(street),
            crossroad: of(crossroad),
            courtyard: of(courtyard),
            rooftop: of(rooftop),
        })
    }

    fn placement(&self, placement: &PlacementFacts) -> PlacementDocument {
        let [height_amsl_m, height_agl_m] = placement.heights();
        let (mask, over) = match &placement.origin {
            Origin::Uav(site) => (None, Some(site.placement)),
            Origin::File { path, .. } => (Some(path.clone()), None),
        };
        let mut all = ShareDocument::of(&placement.groups[0]);
        if placement.tally.p_los().is_none() {
            all.p_los.reason = Some(placement.tally.reason().into());
        }
        PlacementDocument {
            id: placement.id.clone(),
            mask,
            position: placement.position().into(),
            height_amsl_m,
            height_agl_m,
            placement: over,
            all,
            zones: self.by_zone(&placement.groups, ShareDocument::of),
            margins: placement.margins.as_ref().map(|margins| MarginsDocument {
                every: margins.every,
                grazing_within_m: GRAZING_M,
                all: MarginDocument::of(&margins.groups[0]),
                zones: self.by_zone(&margins.groups, MarginDocument::of),
            }),
            margins_reason: placement.margins.is_none().then_some(NO_MARGINS),
        }
    }

    fn pair(&self, pair: &PairFacts) -> PairDocument {
        PairDocument {
            first: self.placements[pair.first].id.clone(),
            second: self.placements[pair.second].id.clone(),
            all: DifferenceDocument::of(&pair.groups[0]),
            zones: self.by_zone(&pair.groups, DifferenceDocument::of),
            heights: pair.heights,
        }
    }

    fn sets(&self) -> Option<Vec<SetDocument>> {
        let ids = |set: usize| {
            let is_in = |k: &usize| set >> k & 1 == 1;
            (0..self.placements.len()).filter(is_in).map(|k| self.placements[k].id.clone()).collect()
        };
        let told = self.sets.as_ref()?.iter().enumerate().filter(|(_, n)| **n > 0);
        Some(told.map(|(bits, n)| SetDocument { bits, seen_by_exactly: ids(bits), receivers: *n }).collect())
    }

    /// Returns the number of groups in tables: all receivers, and each zone if zones are known.
    pub(crate) fn n_told(&self) -> usize {
        if self.has_zones { N_GROUPS } else { 1 }
    }

    /// Returns the table: one row for each placement and zone, then one for each pair and zone.
    pub(crate) fn table(&self) -> Rows {
        let groups = || group_names().into_iter().enumerate().take(self.n_told());
        let of_placement = |placement: &PlacementFacts| {
            let row = |(k, zone): (usize, &'static str)| {
                let (group, margins) = (&placement.groups[k], placement.margins.and_then(|m| m.groups[k]));
                let [height_amsl_m, height_agl_m] = placement.heights();
                CompareRow {
                    position: placement.position().into(),
                    height_amsl_m,
                    height_agl_m,
                    los: Some(group.los),
                    p_los: group.p_los.value,
                    margin_q05_m: margins.and_then(|m| finite(m.quantiles[0])),
                    margin_median_m: margins.and_then(|m| finite(m.quantiles[1])),
                    margin_q95_m: margins.and_then(|m| finite(m.quantiles[2])),
                    margin_grazing_share: margins.map(|m| grazing_share(&m)),
                    margin_receivers: margins.map(|m| m.receivers),
                    ..self.row(("placement", &placement.id, zone), group.receivers, &group.p_los)
                }
            };
            groups().map(row).collect::<Vec<_>>()
        };
        let of_pair = |pair: &PairFacts| {
            let row = |(k, zone): (usize, &'static str)| {
                let GroupDifference { counts: c, difference } = &pair.groups[k];
                CompareRow {
                    second: self.placements[pair.second].id.clone(),
                    difference: difference.value,
                    exceeds: difference.exceeds(),
                    heights_low: pair.heights.filter(|_| k == 0).map(|heights| heights.low()),
                    heights_high: pair.heights.filter(|_| k == 0).map(|heights| heights.high()),
                    exceeds_heights: pair.heights.filter(|_| k == 0).map(|heights| heights.exceeds()),
                    both: Some(c.both),
                    only_first: Some(c.only_first),
                    only_second: Some(c.only_second),
                    neither: Some(c.neither),
                    receivers_of_first_only: Some(c.receivers_of_first),
                    receivers_of_second_only: Some(c.receivers_of_second),
                    ..self.row(("pair", &self.placements[pair.first].id, zone), c.compared(), difference)
                }
            };
            groups().map(row).collect::<Vec<_>>()
        };
        rows(self.placements.iter().flat_map(of_placement).chain(self.pairs.iter().flat_map(of_pair)))
    }

    /// Returns the part that rows of placements and of pairs have in common.
    fn row(
        &self,
        (row, first, zone): (&'static str, &str, &'static str),
        receivers: u64,
        estimate: &RatioEstimate,
    ) -> CompareRow {
        CompareRow {
            row,
            first: first.to_string(),
            zone,
            receivers,
            ci_low: estimate.interval.map(|i| i.0),
            ci_high: estimate.interval.map(|i| i.1),
            blocks: estimate.blocks,
            rx_height_m: self.sight.rx_height_m(),
            radius_m: self.sight.radius_m(),
            antenna: antenna_words(self.sight.antenna()),
            block_m: self.intervals.block_m,
            method: self.facts.method_name(),
            ..CompareRow::default()
        }
    }

    /// Returns the meaning of an interval, and the accuracy of the maps.
    pub(crate) fn meaning(&self) -> String {
        let is_saved = self.placements.iter().any(|p| matches!(p.origin, Origin::File { .. }));
        match self.facts.method {
            Some(method) if !method.is_exact() => format!("{MEANING}, nor how far {} is off", method.name()),
            _ if is_saved => format!("{MEANING}, nor how far the saved maps are off"),
            _ => format!("{MEANING}: over the ground shown the maps are exact"),
        }
    }

    /// Returns the reason for having no interval at all; `None` if there is one.
    pub(crate) fn reason_without_intervals(&self) -> Option<String> {
        let shares = self.placements.iter().flat_map(|p| p.groups.iter().map(|g| &g.p_los));
        let differences = self.pairs.iter().flat_map(|p| p.groups.iter().map(|g| &g.difference));
        let has_any = shares.chain(differences).any(|estimate| estimate.interval.is_some());
        let first = self.placements.first().filter(|_| !has_any)?;
        Some(reason_without_interval(&first.groups[0].p_los))
    }

    /// Returns one sentence: the best placement, its lead, and the clarity of that lead.
    pub(crate) fn verdict(&self) -> String {
        let share =
            |k: usize| (u128::from(self.placements[k].tally.los), u128::from(self.placements[k].tally.receivers));
        let has_p_los = |k: &usize| self.placements[*k].tally.p_los().is_some();
        let mut order: Vec<usize> = (0..self.placements.len()).filter(has_p_los).collect();
        let compare = |a: &usize, b: &usize| (share(*a).0 * share(*b).1).cmp(&(share(*b).0 * share(*a).1));
        order.sort_by(|a, b| compare(b, a));
        let id = |k: usize| self.placements[k].id.as_str();
        let p_los = |k: usize| self.placements[k].tally.p_los().map_or(String::new(), |p| format!("{p:.4}"));
        let (best, next) = match order[..] {
            [] => return "No placement has a P_LoS, so none is best.".into(),
            [only] => return format!("{} alone has a P_LoS: {}.", id(only), p_los(only)),
            [best, next, ..] => (best, next),
        };
        if compare(&best, &next).is_eq() {
            let equal: Vec<&str> = order.iter().filter(|k| compare(k, &best).is_eq()).map(|k| id(*k)).collect();
            return format!("{} are equally good: P_LoS {} each.", equal.join(", "), p_los(best));
        }
        let (first, second) = (best.min(next), best.max(next));
        let Some(pair) = self.pairs.iter().find(|pair| (pair.first, pair.second) == (first, second)) else {
            return format!("{} is best: P_LoS {}.", id(best), p_los(best));
        };
        let (counts, mut estimate) = (&pair.groups[0].counts, pair.groups[0].difference);
        if best == first {
            estimate.value = estimate.value.map(|v| -v);
            estimate.interval = estimate.interval.map(|(low, high)| (-high, -low));
        }
        let by = match estimate.value {
            None => {
                return format!(
                    "{} is best: P_LoS {}, the next {} with {}; no cell is a receiver of both.",
                    id(best),
                    p_los(best),
                    id(next),
                    p_los(next)
                );
            }
            Some(v) if counts.receivers_of_first + counts.receivers_of_second > 0 => {
                format!("{} for {}, over the receivers of both {}", p_los(next), id(next), signed(v))
            }
            Some(v) if v < 0.000_05 => format!("less than 0.0001 more than {}", id(next)),
            Some(v) => format!("{v:.4} more than {}", id(next)),
        };
        let clear = match (estimate.interval, estimate.exceeds()) {
            (Some((low, high)), Some(exceeds)) => {
                let percent = 100.0 * self.intervals.confidence;
                // Over the receivers of both, the other may be ahead.
                let verdict = match (exceeds, high < 0.0) {
                    (true, true) => format!("over these {} is ahead", id(next)),
                    (true, false) => "the difference is clear".to_string(),
                    (false, _) => "the difference is not clear".to_string(),
                };
                let holds = if exceeds { "does not hold" } else { "holds" };
                format!("{verdict}: its {percent:.0} % interval, {} to {}, {holds} 0", signed(low), signed(high))
            }
            _ => format!("whether the difference is clear is not known: {}", reason_without_interval(&estimate)),
        };
        format!("{} is best: P_LoS {}, {by}; {clear}.", id(best), p_los(best))
    }

    /// Returns a sentence on a pair: the change of P_LoS, and its interval.
    pub(crate) fn sentence(&self, pair: &PairFacts) -> String {
        let [first, second] = [pair.first, pair.second].map(|k| self.placements[k].id.as_str());
        let group = &pair.groups[0];
        let Some(difference) = group.difference.value else {
            return match group.difference.blocks {
                0 => format!("{first} → {second}: no cell is a receiver of both."),
                _ => format!("{first} → {second}: {}.", reason_without_interval(&group.difference)),
            };
        };
        let way = match group.counts.gain() {
            0 => "P_LoS is the same".to_string(),
            gain => format!("P_LoS {} by {:.4}", if gain > 0 { "rises" } else { "falls" }, difference.abs()),
        };
        let verdict = match (group.difference.interval, group.difference.exceeds()) {
            (Some((low, high)), Some(exceeds)) => {
                let percent = 100.0 * self.intervals.confidence;
                let verdict = if exceeds {
                    "does not hold 0, so the difference exceeds it"
                } else {
                    "holds 0, so the difference does not exceed it"
                };
                format!("its {percent:.0} % interval, {} to {}, {verdict}", signed(low), signed(high))
            }
            _ => format!("no interval: {}", reason_without_interval(&group.difference)),
        };
        let heights = pair.heights.map_or(String::new(), |heights| format!("; {}", heights.in_words()));
        format!("{first} → {second}: {way}; {verdict}{heights}.")
    }
}
