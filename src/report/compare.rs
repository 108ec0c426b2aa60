//! Placements side by side: `skyshed/compare/1`, and its tables.

use serde_json::{Map, Value, json};

use super::position::PositionCells;
use super::{Position, RunFacts, SiteFacts, Timing};
use crate::coverage::{GRAZING_M, MarginStats, PairCounts, Tally};
use crate::los_probability::bootstrap::{RESAMPLINGS, RatioEstimate};
use crate::los_probability::estimate::FEWEST_CLUSTERS;
use crate::quantity::counted;
use crate::zones::Zone;

/// Groups of receivers: all, and those of each zone in the order of [`Zone::ALL`].
pub const N_GROUPS: usize = 5;

/// The words for the groups of receivers in tables.
pub fn group_names() -> [&'static str; N_GROUPS] {
    let [a, b, c, d] = Zone::ALL.map(Zone::name);
    ["all", a, b, c, d]
}

/// P_LoS of some receivers with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroupShare {
    /// Receivers.
    pub receivers: u64,
    /// Those in line of sight.
    pub los: u64,
    /// Their share.
    pub p_los: RatioEstimate,
}

/// Where a placement's mask comes from.
#[derive(Debug, Clone)]
pub enum Origin {
    /// A UAV, mapped in this run.
    Uav(Box<SiteFacts>),
    /// The mask of an earlier run.
    File {
        /// Its file.
        path: String,
        /// Where its UAV was, if the file says so.
        place: Option<Position>,
    },
}

/// Margins of a placement, from every so manyth receiver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarginFacts {
    /// Every how manyth receiver in row order was asked.
    pub every: usize,
    /// By group; `None` where none of the sample is in it.
    pub groups: [Option<MarginStats>; N_GROUPS],
}

/// One placement as reported.
#[derive(Debug, Clone)]
pub struct PlacementFacts {
    /// Name, unique in a run.
    pub id: String,
    /// Where its mask comes from.
    pub origin: Origin,
    /// Counts of the mask.
    pub tally: Tally,
    /// By group.
    pub groups: [GroupShare; N_GROUPS],
    /// Margins; a mask alone has none.
    pub margins: Option<MarginFacts>,
}

/// Two placements compared on some receivers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroupDifference {
    /// What either sees.
    pub counts: PairCounts,
    /// P_LoS of the second less that of the first, over the receivers of both.
    pub difference: RatioEstimate,
}

/// Two placements compared.
#[derive(Debug, Clone)]
pub struct PairFacts {
    /// The first, as an index of the placements.
    pub first: usize,
    /// The second.
    pub second: usize,
    /// By group.
    pub groups: [GroupDifference; N_GROUPS],
}

/// How intervals were made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct IntervalFacts {
    /// Confidence, such as 0.95.
    pub confidence: f64,
    /// Edge of a block of ground \[m\].
    pub block_m: f64,
    /// Seed of the resampling.
    pub seed: u64,
}

/// Placements side by side, as reported.
#[derive(Debug, Clone)]
pub struct CompareReport {
    /// The run.
    pub facts: RunFacts,
    /// Height of the receivers above what they stand on \[m\].
    pub rx_height_m: f64,
    /// Which cells hold receivers.
    pub receivers: &'static str,
    /// Range \[m\], if it is limited.
    pub radius_m: Option<f64>,
    /// How intervals were made.
    pub intervals: IntervalFacts,
    /// Whether the zones of the scene are known.
    pub has_zones: bool,
    /// The placements.
    pub placements: Vec<PlacementFacts>,
    /// All pairs, the first always before the second.
    pub pairs: Vec<PairFacts>,
    /// All placements together.
    pub union: Tally,
    /// Receivers of any placement that 0, 1, 2 … of them see.
    pub seen_by: Vec<u64>,
    /// Receivers that exactly the placements of each set see, bit k for placement k; `None` for too many.
    pub sets: Option<Vec<u64>>,
    /// Digest of the masks in order, see [`super::digest`].
    pub digest: String,
}

/// What an interval of this document says, in words.
const MEANING: &str = "blocks of ground are drawn with replacement, the same ones for all placements; an interval says how \
                       far a value would move over other ground of this kind, not how wrong the heights are";

/// Why a value has no interval.
fn reason_without_interval(estimate: &RatioEstimate) -> String {
    match estimate.blocks {
        n if n < FEWEST_CLUSTERS => {
            format!("{} with receivers, wanted at least {FEWEST_CLUSTERS}", counted(n, "block", "blocks"))
        }
        _ => "too many resamplings hold no such receiver".to_string(),
    }
}

/// A value under its name, its interval or the reason why there is none, and the blocks behind it.
fn estimate_json(object: &mut Map<String, Value>, name: &str, estimate: &RatioEstimate) {
    object.insert(name.into(), estimate.value.into());
    object.insert("ci_low".into(), estimate.interval.map(|i| i.0).into());
    object.insert("ci_high".into(), estimate.interval.map(|i| i.1).into());
    object.insert("blocks".into(), estimate.blocks.into());
    if estimate.value.is_none() {
        object.insert("reason".into(), "no receiver".into());
    } else if estimate.interval.is_none() {
        object.insert("reason".into(), reason_without_interval(estimate).into());
    }
}

impl GroupShare {
    fn json(&self) -> Map<String, Value> {
        let mut object = Map::new();
        object.insert("receivers".into(), self.receivers.into());
        object.insert("los".into(), self.los.into());
        estimate_json(&mut object, "p_los", &self.p_los);
        object
    }
}

impl GroupDifference {
    fn json(&self) -> Map<String, Value> {
        let mut object = Map::new();
        object.insert("compared".into(), self.counts.compared().into());
        object.insert("both".into(), self.counts.both.into());
        object.insert("only_first".into(), self.counts.only_first.into());
        object.insert("only_second".into(), self.counts.only_second.into());
        object.insert("neither".into(), self.counts.neither.into());
        object.insert("receivers_of_first_only".into(), self.counts.receivers_of_first.into());
        object.insert("receivers_of_second_only".into(), self.counts.receivers_of_second.into());
        estimate_json(&mut object, "difference", &self.difference);
        object.insert("exceeds".into(), self.difference.exceeds().into());
        object
    }
}

fn margins_json(margins: &MarginStats) -> Map<String, Value> {
    let mut object = Map::new();
    object.insert("receivers".into(), margins.receivers.into());
    for (name, value) in ["q05_m", "median_m", "q95_m"].into_iter().zip(margins.quantiles) {
        object.insert(name.into(), finite(value).into());
    }
    if margins.quantiles.iter().any(|q| !q.is_finite()) {
        object.insert("reason".into(), "no receiver height is enough there".into());
    }
    object.insert("grazing".into(), margins.grazing.into());
    object.insert("grazing_share".into(), grazing_share(margins).into());
    object
}

fn finite(value: f32) -> Option<f64> {
    value.is_finite().then(|| f64::from(value))
}

fn grazing_share(margins: &MarginStats) -> f64 {
    margins.grazing as f64 / margins.receivers as f64
}

impl PlacementFacts {
    /// Where its UAV is, if that is known.
    pub fn position(&self) -> Option<Position> {
        match &self.origin {
            Origin::Uav(site) => Some(site.position()),
            Origin::File { place, .. } => *place,
        }
    }

    /// Its heights above the datum and above the ground \[m\], as far as they are known.
    fn heights(&self) -> [Option<f64>; 2] {
        match &self.origin {
            Origin::Uav(site) => [Some(site.height_amsl_m), site.height_agl_m],
            Origin::File { .. } => [None; 2],
        }
    }
}

impl CompareReport {
    /// Whether any P_LoS or difference of two has an interval.
    pub fn has_intervals(&self) -> bool {
        let shares = self.placements.iter().flat_map(|p| &p.groups).map(|g| &g.p_los);
        let differences = self.pairs.iter().flat_map(|p| &p.groups).map(|g| &g.difference);
        shares.chain(differences).any(|estimate| estimate.interval.is_some())
    }

    /// The document `skyshed/compare/1`; without `timing` it is the same for equal runs.
    pub fn document(&self, timing: Option<Timing>) -> Value {
        let mut document = self.facts.head("skyshed/compare/1");
        document.insert("rx_height_m".into(), self.rx_height_m.into());
        document.insert("receivers".into(), self.receivers.into());
        document.insert("radius_m".into(), self.radius_m.into());
        let intervals = json!({
            "method": "block bootstrap",
            "confidence": self.intervals.confidence,
            "block_m": self.intervals.block_m,
            "resamplings": RESAMPLINGS,
            "seed": self.intervals.seed,
            "meaning": self.meaning(),
        });
        document.insert("intervals".into(), intervals);
        document.insert("verdict".into(), self.verdict().into());
        document.insert("placements".into(), self.placements.iter().map(|p| self.placement_json(p)).collect());
        document.insert("pairs".into(), self.pairs.iter().map(|p| self.pair_json(p)).collect());
        document.insert("union".into(), super::documents::tally_json(&self.union).into());
        document.insert("seen_by".into(), self.seen_by.clone().into());
        document.insert("sets".into(), self.sets_json());
        if let Some(timing) = timing {
            document.insert("timing_s".into(), timing.json());
        }
        document.insert("warnings".into(), self.facts.warnings());
        document.insert("digest".into(), self.digest.clone().into());
        Value::Object(document)
    }

    /// Zones by their names; null where none are known.
    fn zones_json<T>(&self, groups: &[T; N_GROUPS], json: impl Fn(&T) -> Value) -> Value {
        if !self.has_zones {
            return Value::Null;
        }
        let zones = group_names().into_iter().zip(groups).skip(1);
        zones.map(|(name, group)| (name.to_string(), json(group))).collect::<Map<_, _>>().into()
    }

    fn placement_json(&self, placement: &PlacementFacts) -> Value {
        let mut object = Map::new();
        object.insert("id".into(), placement.id.clone().into());
        match &placement.origin {
            Origin::Uav(site) => {
                site.position().tell(&mut object);
                object.insert("height_amsl_m".into(), site.height_amsl_m.into());
                object.insert("height_agl_m".into(), site.height_agl_m.into());
                object.insert("placement".into(), site.placement.into());
            }
            Origin::File { path, place } => {
                object.insert("mask".into(), path.clone().into());
                match place {
                    Some(place) => place.tell(&mut object),
                    None => object.extend(["x", "y"].map(|name| (name.to_string(), Value::Null))),
                }
            }
        }
        object.extend(placement.groups[0].json());
        if placement.tally.p_los().is_none() {
            object.insert("reason".into(), placement.tally.reason().into());
        }
        object.insert("zones".into(), self.zones_json(&placement.groups, |g| g.json().into()));
        let none = || json!({"receivers": 0, "reason": "no receiver"});
        let stats = |stats: &Option<MarginStats>| stats.as_ref().map_or_else(none, |s| margins_json(s).into());
        match &placement.margins {
            Some(margins) => {
                let mut of_all = Map::new();
                of_all.insert("every".into(), margins.every.into());
                of_all.insert("grazing_within_m".into(), GRAZING_M.into());
                of_all.extend(stats(&margins.groups[0]).as_object().cloned().unwrap_or_default());
                of_all.insert("zones".into(), self.zones_json(&margins.groups, stats));
                object.insert("margins".into(), of_all.into());
            }
            None => {
                object.insert("margins".into(), Value::Null);
                object.insert("margins_reason".into(), NO_MARGINS.into());
            }
        }
        object.into()
    }

    fn pair_json(&self, pair: &PairFacts) -> Value {
        let mut object = Map::new();
        object.insert("first".into(), self.placements[pair.first].id.clone().into());
        object.insert("second".into(), self.placements[pair.second].id.clone().into());
        object.extend(pair.groups[0].json());
        object.insert("zones".into(), self.zones_json(&pair.groups, |g| g.json().into()));
        object.into()
    }

    fn sets_json(&self) -> Value {
        let Some(sets) = &self.sets else { return Value::Null };
        let ids = |set: usize| {
            let is_in = |k: &usize| set >> k & 1 == 1;
            (0..self.placements.len()).filter(is_in).map(|k| self.placements[k].id.as_str()).collect::<Vec<_>>()
        };
        let told = sets.iter().enumerate().filter(|(_, n)| **n > 0);
        told.map(|(set, n)| json!({"bits": set, "seen_by_exactly": ids(set), "receivers": n})).collect()
    }

    /// The groups that tables tell: those of zones only where zones are known.
    pub fn n_told(&self) -> usize {
        if self.has_zones { N_GROUPS } else { 1 }
    }

    /// The table: a row per placement and zone, then one per pair and zone.
    pub fn table(&self) -> Vec<Vec<String>> {
        let positions = PositionCells::of(self.placements.iter().filter_map(PlacementFacts::position));
        let header = format!(
            "row,first,second,zone,{},height_amsl_m,height_agl_m,receivers,los,p_los,difference,ci_low,ci_high,exceeds,\
             blocks,both,only_first,only_second,neither,receivers_of_first_only,receivers_of_second_only,margin_q05_m,\
             margin_median_m,margin_q95_m,margin_grazing_share,margin_receivers,rx_height_m,radius_m,block_m,method",
            positions.names()
        );
        let header: Vec<String> = header.split(',').map(str::to_string).collect();
        let run = [
            self.rx_height_m.to_string(),
            optional(self.radius_m),
            self.intervals.block_m.to_string(),
            self.facts.method_name(),
        ];
        let mut rows = vec![header];
        for placement in &self.placements {
            for (k, name) in group_names().into_iter().enumerate().take(self.n_told()) {
                let group = &placement.groups[k];
                let mut row = vec!["placement".to_string(), placement.id.clone(), String::new(), name.to_string()];
                row.extend(positions.cells(placement.position()));
                row.extend(placement.heights().map(optional));
                row.extend([group.receivers.to_string(), group.los.to_string(), optional(group.p_los.value)]);
                row.push(String::new());
                row.extend(interval_cells(&group.p_los));
                row.extend([String::new(), group.p_los.blocks.to_string()]);
                row.extend(std::iter::repeat_n(String::new(), 6));
                row.extend(margin_cells(placement.margins.and_then(|m| m.groups[k])));
                rows.push(row.into_iter().chain(run.clone()).collect());
            }
        }
        for pair in &self.pairs {
            let [first, second] = [pair.first, pair.second].map(|k| self.placements[k].id.clone());
            for (k, name) in group_names().into_iter().enumerate().take(self.n_told()) {
                let group = &pair.groups[k];
                let mut row = vec!["pair".to_string(), first.clone(), second.clone(), name.to_string()];
                row.extend(positions.cells(None));
                row.extend([None; 2].map(optional));
                row.extend([group.counts.compared().to_string(), String::new(), String::new()]);
                row.push(optional(group.difference.value));
                row.extend(interval_cells(&group.difference));
                row.push(group.difference.exceeds().map_or(String::new(), |e| e.to_string()));
                row.push(group.difference.blocks.to_string());
                let c = &group.counts;
                let counts =
                    [c.both, c.only_first, c.only_second, c.neither, c.receivers_of_first, c.receivers_of_second];
                row.extend(counts.map(|n| n.to_string()));
                row.extend(margin_cells(None));
                rows.push(row.into_iter().chain(run.clone()).collect());
            }
        }
        rows
    }

    /// What an interval says, and what the maps are worth.
    pub fn meaning(&self) -> String {
        let is_saved = self.placements.iter().any(|p| matches!(p.origin, Origin::File { .. }));
        match self.facts.method {
            Some(method) if !method.is_exact() => format!("{MEANING}, nor how far {} is off", method.name()),
            _ if is_saved => format!("{MEANING}, nor how far the saved maps are off"),
            _ => format!("{MEANING}: over the ground shown the maps are exact"),
        }
    }

    /// Why there is no interval at all; `None` if there is any.
    pub fn reason_without_intervals(&self) -> Option<String> {
        let shares = self.placements.iter().flat_map(|p| p.groups.iter().map(|g| &g.p_los));
        let differences = self.pairs.iter().flat_map(|p| p.groups.iter().map(|g| &g.difference));
        let has_any = shares.chain(differences).any(|estimate| estimate.interval.is_some());
        let first = self.placements.first().filter(|_| !has_any)?;
        Some(reason_without_interval(&first.groups[0].p_los))
    }

    /// One sentence: which placement is best, by how much, and whether that is clear.
    pub fn verdict(&self) -> String {
        let share =
            |k: usize| (u128::from(self.placements[k].tally.los), u128::from(self.placements[k].tally.receivers));
        let mut order: Vec<usize> = (0..self.placements.len()).filter(|k| share(*k).1 > 0).collect();
        let compare = |a: &usize, b: &usize| (share(*a).0 * share(*b).1).cmp(&(share(*b).0 * share(*a).1));
        order.sort_by(|a, b| compare(b, a));
        let id = |k: usize| self.placements[k].id.as_str();
        let p_los = |k: usize| self.placements[k].tally.p_los().map_or(String::new(), |p| format!("{p:.4}"));
        let (best, next) = match order[..] {
            [] => return "No placement has a receiver, so that none is best.".into(),
            [only] => return format!("{} alone has receivers: P_LoS {}.", id(only), p_los(only)),
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
                // Over the receivers of both the other may be ahead.
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

    /// A sentence on a pair: which sees more, by how much, and whether that exceeds its interval.
    pub fn sentence(&self, pair: &PairFacts) -> String {
        let [first, second] = [pair.first, pair.second].map(|k| self.placements[k].id.as_str());
        let group = &pair.groups[0];
        let Some(difference) = group.difference.value else {
            return format!("{first} → {second}: no cell is a receiver of both.");
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
        format!("{first} → {second}: {way}; {verdict}.")
    }
}

/// A difference of P_LoS with four decimals, its sign, and a true minus.
pub fn signed(difference: f64) -> String {
    format!("{difference:+.4}").replace('-', "−")
}

/// Why a mask has no margins.
const NO_MARGINS: &str = "a saved mask says who is in line of sight, not by how much";

fn optional(value: Option<f64>) -> String {
    value.map_or(String::new(), |v| v.to_string())
}

fn interval_cells(estimate: &RatioEstimate) -> [String; 2] {
    [optional(estimate.interval.map(|i| i.0)), optional(estimate.interval.map(|i| i.1))]
}

/// Quantiles, grazing share and sample of some margins.
fn margin_cells(margins: Option<MarginStats>) -> [String; 5] {
    let Some(margins) = margins else { return std::array::from_fn(|_| String::new()) };
    let [low, median, high] = margins.quantiles.map(|q| optional(finite(q)));
    [low, median, high, grazing_share(&margins).to_string(), margins.receivers.to_string()]
}
