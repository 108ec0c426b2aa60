//! Stretches of ways, as each observer and all together see them.

use rayon::prelude::*;

use super::super::{SceneView, Uav};
use super::{LegSpan, LegStretch, TrackLeg, TrackPoint, TrackState, TrackVertex, Way};
use crate::error::Result;
use crate::height_field::{Curvature, HeightField};
use crate::los::LegObstacle;

/// A stretch of one leg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WayStretch {
    /// Way, counted from 0.
    pub way: usize,
    /// Leg of the way, counted from 0.
    pub leg: usize,
    /// Fractions of the leg at which it begins and ends.
    pub at: [f64; 2],
    /// Distances along the way at which it begins and ends \[m\].
    pub along_m: [f64; 2],
    /// Times since the start of the way at which it begins and ends \[s\].
    pub time_s: Option<[f64; 2]>,
    /// The state.
    pub state: TrackState,
    /// Obstacle that hides most of it, if it is hidden from one observer.
    pub obstacle: Option<LegObstacle>,
}

/// Stretches of one state that follow each other along a way; at least one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WayRun<'a>(pub &'a [WayStretch]);

impl WayRun<'_> {
    /// Returns its first stretch.
    pub fn first(&self) -> &WayStretch {
        &self.0[0]
    }

    /// Returns its last stretch.
    pub fn last(&self) -> &WayStretch {
        &self.0[self.0.len() - 1]
    }

    /// Returns its ends along the way \[m\].
    pub fn along_m(&self) -> [f64; 2] {
        [self.first().along_m[0], self.last().along_m[1]]
    }

    /// Returns its ends since the start of the way \[s\].
    pub fn time_s(&self) -> Option<[f64; 2]> {
        self.first().time_s.zip(self.last().time_s).map(|([from, _], [_, to])| [from, to])
    }

    /// Returns its length \[m\].
    pub fn length_m(&self) -> f64 {
        let [from, to] = self.along_m();
        to - from
    }

    /// Returns its time \[s\], if the way has times.
    pub fn duration_s(&self) -> Option<f64> {
        self.time_s().map(|[from, to]| to - from)
    }

    /// Returns the obstacle of its longest stretch.
    pub fn obstacle(&self) -> Option<LegObstacle> {
        let length_m = |of: &WayStretch| of.along_m[1] - of.along_m[0];
        self.0.iter().max_by(|a, b| length_m(a).total_cmp(&length_m(b)))?.obstacle
    }
}

/// Stretches of all ways, in their order, leg by leg.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WayStretches(pub Vec<WayStretch>);

/// Sums of stretches.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StretchSums {
    /// Length of each state \[m\], in the order of [`TrackState::ALL`].
    pub length_m: [f64; 4],
    /// Time in each state \[s\], if the ways have times.
    pub time_s: Option<[f64; 4]>,
    /// Longest stretch without line of sight \[m\].
    pub longest_without_m: f64,
    /// Longest time without line of sight \[s\], if the ways have times.
    pub longest_without_s: Option<f64>,
}

impl StretchSums {
    /// Returns the length in a state \[m\].
    pub fn length(&self, state: TrackState) -> f64 {
        TrackState::ALL.iter().zip(self.length_m).find(|(of, _)| **of == state).map_or(0.0, |(_, m)| m)
    }

    /// Returns the share in line of sight of lengths or times in the order of [`TrackState::ALL`],
    /// of what has receivers; `None` without any.
    pub fn share(of: [f64; 4]) -> Option<f64> {
        let [los, nlos, ..] = of;
        (los + nlos > 0.0).then(|| los / (los + nlos))
    }
}

/// Stretches of ways for several observers.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackStretches {
    /// Stretches that each observer sees, in the order of the observers.
    pub each: Vec<WayStretches>,
    /// Stretches that the best observer at each place sees.
    pub all: WayStretches,
}

impl WayStretches {
    /// Returns the runs of one state along a way, which may cross legs.
    pub fn runs(&self) -> impl Iterator<Item = WayRun<'_>> {
        self.0.chunk_by(|a, b| (a.way, a.state) == (b.way, b.state)).map(WayRun)
    }

    /// Returns the runs of a state.
    pub fn runs_of(&self, state: TrackState) -> impl Iterator<Item = WayRun<'_>> {
        self.runs().filter(move |run| run.first().state == state)
    }

    /// Returns lengths and times by state.
    pub fn sums(&self) -> StretchSums {
        let has_times = self.0.iter().any(|stretch| stretch.time_s.is_some());
        // The sum of no numbers at all is −0.
        let sum = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |sum, value| sum + value);
        let length_m = TrackState::ALL.map(|state| sum(&mut self.runs_of(state).map(|run| run.length_m())));
        let times_s = || TrackState::ALL.map(|state| sum(&mut self.runs_of(state).filter_map(|run| run.duration_s())));
        let without = || self.runs_of(TrackState::Nlos);
        StretchSums {
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
        let has_size =
            |run: WayRun<'_>| run.length_m() > 0.0 || run.duration_s().is_some_and(|duration| duration > 0.0);
        stretches.into_iter().map(of).filter(move |stretch| has_size(WayRun(std::slice::from_ref(stretch))))
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

impl TrackStretches {
    /// Finds the stretches of ways for each observer, and for all together, exactly. Over a curved
    /// earth they are decided every `step` \[CRS units\], and what begins and ends within a step is
    /// missed.
    ///
    /// # Errors
    /// E118 for an earth so curved that heights would leave the lattice.
    pub fn find(
        field: &HeightField,
        (ways, observers): (&[Way], &[Uav]),
        curved: Option<(Curvature, f64)>,
    ) -> Result<TrackStretches> {
        let legs = legs_of(ways, field.grid().meters_per_unit());
        match curved {
            None => Ok(find_exactly(field, &legs, observers)),
            Some(curved) => find_by_steps(field, &legs, observers, curved),
        }
    }
}

fn find_exactly(field: &HeightField, legs: &[WayLeg<'_>], observers: &[Uav]) -> TrackStretches {
    // PERF: pairs of legs and observers are shared among threads; a track may be one leg.
    let over: Vec<TrackLeg> = legs.par_iter().map(|leg| TrackLeg::between(field, leg.ends)).collect();
    let n = legs.len();
    let pair = |k: usize| over[k % n].hidden_from(field, &observers[k / n].station);
    let hidden: Vec<_> = (0..n * observers.len()).into_par_iter().map(pair).collect();
    let of = |observer: usize| {
        let of_leg =
            |(k, leg): (usize, &WayLeg<'_>)| leg.told(over[k].stretches(&hidden[observer * n + k])).collect::<Vec<_>>();
        WayStretches(legs.iter().enumerate().flat_map(of_leg).collect())
    };
    let each: Vec<WayStretches> = (0..observers.len()).into_par_iter().map(of).collect();
    if let [only] = &each[..] {
        let all = only.clone();
        return TrackStretches { each, all };
    }
    let all = legs.iter().enumerate().flat_map(|(k, leg)| {
        let of_each = (0..observers.len()).map(|observer| &hidden[observer * n + k][..]);
        leg.told(over[k].stretches(&TrackLeg::hidden_from_all(of_each))).collect::<Vec<_>>()
    });
    let all = WayStretches(all.collect());
    TrackStretches { each, all }
}

fn find_by_steps(
    field: &HeightField,
    legs: &[WayLeg<'_>],
    observers: &[Uav],
    (curvature, step): (Curvature, f64),
) -> Result<TrackStretches> {
    let of = |uav: &Uav| -> Result<Vec<Vec<LegStretch>>> {
        let view = SceneView::of(field, uav, Some(curvature))?;
        let stretches = |leg: &WayLeg<'_>| view.stretches_between(leg.ends, &view.along_leg((leg.leg, leg.ends), step));
        Ok(legs.iter().map(stretches).collect())
    };
    let found: Vec<Vec<Vec<LegStretch>>> = observers.par_iter().map(of).collect::<Result<_>>()?;
    let told = |of_legs: &[Vec<LegStretch>]| {
        WayStretches(
            legs.iter().zip(of_legs).flat_map(|(leg, own)| leg.told(own.clone()).collect::<Vec<_>>()).collect(),
        )
    };
    let each: Vec<WayStretches> = found.iter().map(|of_legs| told(of_legs)).collect();
    if let [only] = &each[..] {
        let all = only.clone();
        return Ok(TrackStretches { each, all });
    }
    let union: Vec<Vec<LegStretch>> =
        (0..legs.len()).map(|k| best_of(found.iter().map(|of_legs| &of_legs[k][..]))).collect();
    let all = told(&union);
    Ok(TrackStretches { each, all })
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

impl TrackPoint {
    /// Decides places of ways for one observer, way by way: all vertices, and between them every
    /// `step` \[CRS units\].
    ///
    /// # Errors
    /// As [`TrackStretches::find`].
    pub fn along(
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
}
