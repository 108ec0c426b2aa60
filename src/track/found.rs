//! Stretches of ways, seen by each observer and by all together.

use rayon::prelude::*;

use super::way::{LegSpan, Way};
use crate::coverage::{LegStretch, SceneView, TrackLeg, TrackPoint, TrackState, TrackVertex, Uav};
use crate::error::Result;
use crate::height_field::{Curvature, HeightField};
use crate::los::LegObstacle;

/// A stretch of one leg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WayStretch {
    /// Way and leg of it, counted from 0.
    pub(super) way: usize,
    pub(super) leg: usize,
    /// Fractions of the leg.
    pub(super) at: [f64; 2],
    /// Distances along the way \[m\].
    pub(super) along_m: [f64; 2],
    /// Times since its start \[s\].
    pub(super) time_s: Option<[f64; 2]>,
    pub(super) state: TrackState,
    pub(super) obstacle: Option<LegObstacle>,
}

/// Stretches of one state that follow each other along a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Run<'a>(pub(super) &'a [WayStretch]);

impl Run<'_> {
    pub(super) fn first(&self) -> &WayStretch {
        &self.0[0]
    }

    pub(super) fn last(&self) -> &WayStretch {
        &self.0[self.0.len() - 1]
    }

    /// Returns its ends along the way \[m\].
    pub(super) fn along_m(&self) -> [f64; 2] {
        [self.first().along_m[0], self.last().along_m[1]]
    }

    /// Returns its ends since the start of the way \[s\].
    pub(super) fn time_s(&self) -> Option<[f64; 2]> {
        self.first().time_s.zip(self.last().time_s).map(|([from, _], [_, to])| [from, to])
    }

    pub(super) fn length_m(&self) -> f64 {
        let [from, to] = self.along_m();
        to - from
    }

    pub(super) fn duration_s(&self) -> Option<f64> {
        self.time_s().map(|[from, to]| to - from)
    }

    /// Returns the obstacle of its longest stretch.
    pub(super) fn obstacle(&self) -> Option<LegObstacle> {
        let length_m = |of: &WayStretch| of.along_m[1] - of.along_m[0];
        self.0.iter().max_by(|a, b| length_m(a).total_cmp(&length_m(b)))?.obstacle
    }
}

/// Stretches of all ways, in their order, leg by leg.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Stretches(pub(super) Vec<WayStretch>);

/// Sums of stretches.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Sums {
    /// Length of each state \[m\], in the order of [`TrackState::ALL`].
    pub(super) length_m: [f64; 4],
    /// Time in each state \[s\], if the ways have times.
    pub(super) time_s: Option<[f64; 4]>,
    /// Longest stretch without line of sight \[m\], and the longest time \[s\].
    pub(super) longest_without_m: f64,
    pub(super) longest_without_s: Option<f64>,
}

impl Sums {
    pub(super) fn length(&self, state: TrackState) -> f64 {
        TrackState::ALL.iter().zip(self.length_m).find(|(of, _)| **of == state).map_or(0.0, |(_, m)| m)
    }

    /// Returns the share in line of sight of what has receivers; `None` without any.
    pub(super) fn share(of: [f64; 4]) -> Option<f64> {
        let [los, nlos, ..] = of;
        (los + nlos > 0.0).then(|| los / (los + nlos))
    }
}

impl Stretches {
    /// Returns the runs of one state along a way, which may cross legs.
    pub(super) fn runs(&self) -> impl Iterator<Item = Run<'_>> {
        self.0.chunk_by(|a, b| (a.way, a.state) == (b.way, b.state)).map(Run)
    }

    /// Returns the runs of a state.
    pub(super) fn runs_of(&self, state: TrackState) -> impl Iterator<Item = Run<'_>> {
        self.runs().filter(move |run| run.first().state == state)
    }

    pub(super) fn sums(&self) -> Sums {
        let has_times = self.0.iter().any(|stretch| stretch.time_s.is_some());
        // The sum of no numbers at all is −0.
        let sum = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |sum, value| sum + value);
        let length_m = TrackState::ALL.map(|state| sum(&mut self.runs_of(state).map(|run| run.length_m())));
        let times_s = || TrackState::ALL.map(|state| sum(&mut self.runs_of(state).filter_map(|run| run.duration_s())));
        let without = || self.runs_of(TrackState::Nlos);
        Sums {
            length_m,
            time_s: has_times.then(times_s),
            longest_without_m: without().map(|run| run.length_m()).fold(0.0, f64::max),
            longest_without_s: has_times.then(|| without().filter_map(|run| run.duration_s()).fold(0.0, f64::max)),
        }
    }
}

/// A leg of a way: its number, its ends, and where it is along the way.
struct WayLeg<'a> {
    way: usize,
    leg: usize,
    ends: [&'a TrackVertex; 2],
    span: LegSpan,
}

impl WayLeg<'_> {
    /// Returns stretches of the leg that have a length or a time.
    fn told(&self, stretches: Vec<LegStretch>) -> impl Iterator<Item = WayStretch> {
        let of = |LegStretch { at, state, obstacle }: LegStretch| {
            let [(from_m, from_s), (to_m, to_s)] = at.map(|t| self.span.at(t));
            let time_s = from_s.zip(to_s).map(|(from, to)| [from, to]);
            let (way, leg) = (self.way, self.leg);
            WayStretch { way, leg, at, along_m: [from_m, to_m], time_s, state, obstacle }
        };
        let has_size = |run: Run<'_>| run.length_m() > 0.0 || run.duration_s().is_some_and(|duration| duration > 0.0);
        stretches.into_iter().map(of).filter(move |stretch| has_size(Run(std::slice::from_ref(stretch))))
    }
}

fn legs_of<'a>(ways: &'a [Way], meters_per_unit: f64) -> Vec<WayLeg<'a>> {
    let of_way = |(way, of): (usize, &'a Way)| {
        let spans = of.spans(meters_per_unit);
        let leg = move |(leg, (ends, span))| WayLeg { way, leg, ends, span };
        of.legs().zip(spans).enumerate().map(leg).collect::<Vec<_>>()
    };
    ways.iter().enumerate().flat_map(of_way).collect()
}

/// Finds the stretches of ways for each observer, and for all together, exactly. Over a curved earth
/// they are decided every `step` \[CRS units\].
///
/// # Errors
/// E118 for an earth so curved that heights would leave the lattice.
pub(super) fn find(
    field: &HeightField,
    (ways, observers): (&[Way], &[Uav]),
    curved: Option<(Curvature, f64)>,
) -> Result<(Vec<Stretches>, Stretches)> {
    let legs = legs_of(ways, field.grid().meters_per_unit());
    match curved {
        None => Ok(find_exactly(field, &legs, observers)),
        Some(curved) => find_by_steps(field, &legs, observers, curved),
    }
}

fn find_exactly(field: &HeightField, legs: &[WayLeg<'_>], observers: &[Uav]) -> (Vec<Stretches>, Stretches) {
    // PERF: pairs of legs and observers are shared among threads; a track may be one leg.
    let over: Vec<TrackLeg> = legs.par_iter().map(|leg| TrackLeg::between(field, leg.ends)).collect();
    let n = legs.len();
    let pair = |k: usize| over[k % n].hidden_from(field, &observers[k / n].station);
    let hidden: Vec<_> = (0..n * observers.len()).into_par_iter().map(pair).collect();
    let of = |observer: usize| {
        let of_leg =
            |(k, leg): (usize, &WayLeg<'_>)| leg.told(over[k].stretches(&hidden[observer * n + k])).collect::<Vec<_>>();
        Stretches(legs.iter().enumerate().flat_map(of_leg).collect())
    };
    let each: Vec<Stretches> = (0..observers.len()).into_par_iter().map(of).collect();
    if let [only] = &each[..] {
        return (vec![only.clone()], only.clone());
    }
    let all = legs.iter().enumerate().flat_map(|(k, leg)| {
        let of_each = (0..observers.len()).map(|observer| &hidden[observer * n + k][..]);
        leg.told(over[k].stretches(&TrackLeg::hidden_from_all(of_each))).collect::<Vec<_>>()
    });
    let all = Stretches(all.collect());
    (each, all)
}

fn find_by_steps(
    field: &HeightField,
    legs: &[WayLeg<'_>],
    observers: &[Uav],
    (curvature, step): (Curvature, f64),
) -> Result<(Vec<Stretches>, Stretches)> {
    let of = |uav: &Uav| -> Result<Vec<Vec<LegStretch>>> {
        let view = SceneView::of(field, uav, Some(curvature))?;
        let stretches = |leg: &WayLeg<'_>| view.stretches_between(leg.ends, &view.along_leg((leg.leg, leg.ends), step));
        Ok(legs.iter().map(stretches).collect())
    };
    let found: Vec<Vec<Vec<LegStretch>>> = observers.par_iter().map(of).collect::<Result<_>>()?;
    let told = |of_legs: &[Vec<LegStretch>]| {
        Stretches(legs.iter().zip(of_legs).flat_map(|(leg, own)| leg.told(own.clone()).collect::<Vec<_>>()).collect())
    };
    let each: Vec<Stretches> = found.iter().map(|of_legs| told(of_legs)).collect();
    if let [only] = &each[..] {
        return Ok((vec![only.clone()], only.clone()));
    }
    let union: Vec<Vec<LegStretch>> =
        (0..legs.len()).map(|k| best_of(found.iter().map(|of_legs| &of_legs[k][..]))).collect();
    let all = told(&union);
    Ok((each, all))
}

/// Returns the stretches of a leg for several observers together: line of sight where one has it.
fn best_of<'a>(of_each: impl Iterator<Item = &'a [LegStretch]> + Clone) -> Vec<LegStretch> {
    let mut ends: Vec<f64> = of_each.clone().flatten().flat_map(|stretch| stretch.at).collect();
    ends.sort_unstable_by(f64::total_cmp);
    ends.dedup();
    let mut best: Vec<LegStretch> = Vec::new();
    for pair in ends.windows(2) {
        let middle = 0.5 * (pair[0] + pair[1]);
        let holds = |stretch: &&&LegStretch| stretch.at[0] <= middle && middle < stretch.at[1];
        let states = of_each.clone().filter_map(|own| own.iter().find(|s| holds(&s)).map(|s| s.state));
        let Some(state) = states.min() else { continue };
        match best.last_mut().filter(|last| last.state == state) {
            Some(last) => last.at[1] = pair[1],
            None => best.push(LegStretch { at: [pair[0], pair[1]], state, obstacle: None }),
        }
    }
    best
}

/// Decides places of ways for one observer: all vertices, and between them every `step`
/// \[CRS units\].
///
/// # Errors
/// As [`find`].
pub(super) fn points(
    field: &HeightField,
    (ways, observer): (&[Way], &Uav),
    (curvature, step): (Option<Curvature>, f64),
) -> Result<Vec<Vec<TrackPoint>>> {
    let view = SceneView::of(field, observer, curvature)?;
    let of_way = |way: &Way| {
        let of_leg = |(leg, ends): (usize, [&TrackVertex; 2])| {
            // The end of a leg is the start of the next one.
            let points = view.along_leg((leg, ends), step);
            points.into_iter().skip(usize::from(leg > 0))
        };
        way.legs().enumerate().flat_map(of_leg).collect()
    };
    Ok(ways.par_iter().map(of_way).collect())
}
