//! How far heights of buildings may be off, and what that makes of the probability that a link is clear.
//!
//! **Model.** The top of building i is h_i + e_i + t: an error of its own, normal with standard deviation σ_i, and one that all buildings
//! share, normal with standard deviation τ. All are independent. Ground, and where buildings are, is as it is known.
//!
//! **One link.** Building i has room for an error of l_i at most ([`HeightLimits`]). With a known t that is the product of Φ((l_i − t)/σ_i) over
//! the buildings crossed, Φ the distribution of the normal one, and over t it is integrated: in equal steps of 3/4 of the least σ_i or τ; or, since a
//! building without an error of its own hides the receiver all of a sudden, by Gauss–Legendre of five nodes in parts that end there. That is good to
//! about 10⁻⁵. Errors beyond six standard deviations are left out.
//!
//! Rooms are the largest errors, in whole steps of the lattice, that leave a link clear. The largest of all is somewhere in the step above, so half a
//! step is added.

use std::sync::Arc;

use crate::los::HeightLimits;
use crate::quadrature::mean_over_unit;
use crate::quantity::STEPS_PER_UNIT;

/// Errors beyond so many standard deviations are left out: one in 5·10⁸.
pub(super) const CERTAIN: f64 = 6.0;

/// Length of a part that five nodes are good for, against the shortest standard deviation.
const PART: f64 = 1.5;

/// Equal steps over all errors, against it.
const STEP: f64 = 0.75;

/// Buildings on one link for which steps as long are good.
const MOST_AT_STEP: usize = 3;

/// Errors of buildings alone that are this small against those that they share are taken as none: that changes probabilities by
/// some 10⁻⁵, and bounds the number of steps.
const TINY: f64 = 0.01;

/// Roofs above and below the known one for which links are walked.
const ROOFS: i32 = 2;

/// Standard deviations of the errors that buildings have of their own \[m\].
#[derive(Debug, Clone, PartialEq)]
pub enum OwnErrors {
    /// One for all.
    Same(f64),
    /// Of each building, by its number.
    ByBuilding(Arc<[f64]>),
}

/// How far heights of buildings may be from those of the scene: normal errors of mean 0.
#[derive(Debug, Clone, PartialEq)]
pub struct HeightErrors {
    /// Those of each building alone.
    pub own: OwnErrors,
    /// Standard deviation of the error that all buildings share \[m\].
    pub shared_m: f64,
}

impl Default for HeightErrors {
    /// None.
    fn default() -> Self {
        HeightErrors::same(0.0, 0.0)
    }
}

impl HeightErrors {
    /// Errors of one size for all buildings: standard deviations of their own errors, and of the shared one \[m\].
    pub fn same(own_m: f64, shared_m: f64) -> Self {
        HeightErrors { own: OwnErrors::Same(own_m), shared_m }
    }

    /// Whether all are numbers that are not negative, one for each of so many buildings.
    pub fn are_valid(&self, n_buildings: usize) -> bool {
        let is_valid = |m: &f64| *m >= 0.0 && m.is_finite();
        let own = match &self.own {
            OwnErrors::Same(m) => is_valid(m),
            OwnErrors::ByBuilding(of) => of.len() == n_buildings && of.iter().all(is_valid),
        };
        own && is_valid(&self.shared_m)
    }

    /// Standard deviation of the error that a building has of its own \[m\].
    #[inline]
    pub fn own_m(&self, building: u32) -> f64 {
        match &self.own {
            OwnErrors::Same(m) => *m,
            OwnErrors::ByBuilding(of) => of[building as usize],
        }
    }

    /// Standard deviation of the error of a building's height \[m\].
    pub fn of_building_m(&self, building: u32) -> f64 {
        self.own_m(building).hypot(self.shared_m)
    }
}

/// By how much a building is lower than hides a link, if no error is shared \[1/1024 m\].
type Slack = (u32, f64);

impl HeightErrors {
    /// The probability that a link is clear, given how high buildings may be for it.
    pub(super) fn probability(&self, limits: &HeightLimits) -> f64 {
        self.given(limits, 0.0, steps(self.shared_m))
    }

    /// That of the link of a receiver on the roof of a building, which is as much higher or lower as that: `limits` are those with the roof so many
    /// steps higher.
    ///
    /// A higher receiver raises its link everywhere, the more the nearer to it, and with the link the limits of buildings. That is a straight line for each
    /// place, so limits are found for five roofs and taken as straight between them.
    pub(super) fn probability_on_roof(&self, building: u32, limits: impl Fn(i64) -> Option<HeightLimits>) -> f64 {
        let (shared, own) = (steps(self.shared_m), self.own(building));
        let of_roof = shared.hypot(own);
        let with_roof = |by: i64| limits(by)?.with_error_of(building, by);
        // A roof that moves by less than a step does not move.
        if of_roof <= 1.0 {
            return with_roof(0).map_or(0.0, |limits| self.given(&limits, 0.0, shared));
        }
        // What is known of the shared error once that of the roof is.
        let (part, left) = ((shared / of_roof).powi(2), shared * own / of_roof);
        let tiny = TINY * of_roof;
        let walked =
            |error: f64| with_roof(rounded(error)).map_or(0.0, |limits| self.given(&limits, error * part, left));
        let known: Vec<(f64, Option<HeightLimits>)> = (-ROOFS..=ROOFS)
            .map(|k| {
                let by = rounded(CERTAIN * of_roof * f64::from(k) / f64::from(ROOFS));
                (as_f64(by), limits(by))
            })
            .collect();
        let sum: f64 = known
            .windows(2)
            .map(|pair| {
                let [(from, low), (to, high)] = pair else { return 0.0 };
                let ramps = low.as_ref().zip(high.as_ref()).and_then(|(low, high)| self.ramps(low, high));
                let Some(ramps) = ramps else { return mean(of_roof, (*from, *to), of_roof, Vec::new(), walked) };
                let slack_at = |ramp: &Ramp, error: f64| {
                    let limit = ramp.limits.0 + (ramp.limits.1 - ramp.limits.0) * (error - from) / (to - from);
                    limit - if ramp.building == building { error } else { error * part }
                };
                let of = |error: f64| {
                    let mut slacks = Vec::with_capacity(ramps.len());
                    for ramp in &ramps {
                        match slack_at(ramp, error) {
                            slack if ramp.building != building => slacks.push((ramp.building, slack)),
                            slack if slack < 0.0 => return 0.0,
                            _ => {}
                        }
                    }
                    self.of_slacks(slacks, left)
                };
                // Over what is left of the shared error, another building hides the receiver little by little.
                let smooth = |ramp: &Ramp| self.own(ramp.building).hypot(left);
                let is_sudden = |ramp: &&Ramp| ramp.building == building || smooth(ramp) <= tiny;
                let turn = |ramp: &Ramp| {
                    let (a, b) = (slack_at(ramp, *from), slack_at(ramp, *to));
                    (a * b < 0.0).then(|| from + (to - from) * a / (a - b))
                };
                let breaks = ramps.iter().filter(is_sudden).filter_map(turn).collect();
                let shortest = ramps.iter().map(smooth).filter(|smooth| *smooth > tiny).fold(of_roof, f64::min);
                mean(of_roof, (*from, *to), shortest, breaks, of)
            })
            .sum();
        sum.clamp(0.0, 1.0)
    }

    /// The limits of buildings between those of two roofs; `None` where walls are passed.
    fn ramps(&self, low: &HeightLimits, high: &HeightLimits) -> Option<Vec<Ramp>> {
        if !low.walls.is_empty() || !high.walls.is_empty() {
            return None;
        }
        let of = |limits: &HeightLimits, building: u32| {
            let limit = limits.crossed.iter().find(|(of, _)| *of == building);
            // One that is far below a link may be left out.
            limit.map_or_else(
                || CERTAIN * (self.own(building) + steps(self.shared_m)),
                |(_, limit)| as_f64(*limit) + 0.5,
            )
        };
        let mut buildings: Vec<u32> = low.crossed.iter().chain(&high.crossed).map(|(of, _)| *of).collect();
        buildings.sort_unstable();
        buildings.dedup();
        let ramp = |building: u32| Ramp { building, limits: (of(low, building), of(high, building)) };
        Some(buildings.into_iter().map(ramp).collect())
    }

    /// The probability given the mean and the standard deviation of the shared error \[1/1024 m\].
    fn given(&self, limits: &HeightLimits, mean_error: f64, shared: f64) -> f64 {
        let slack = |room: i64| as_f64(room) + 0.5 - mean_error;
        if limits.walls.is_empty() {
            return self.of_slacks(limits.crossed.iter().map(|(of, room)| (*of, slack(*room))).collect(), shared);
        }
        let at = |t: f64| limits.probability(&|of, room| below(slack(room) - t, self.own(of)));
        if shared <= 0.0 {
            return at(0.0);
        }
        let sides = limits.walls.iter().flat_map(|wall| [0, 1].map(|k| (wall.buildings[k], wall.rooms[k])));
        let all = limits.crossed.iter().copied().chain(sides).map(|(of, room)| (of, slack(room)));
        self.over_shared(&all.collect::<Vec<Slack>>(), shared, at)
    }

    /// The probability that no building is higher than it may be.
    fn of_slacks(&self, mut slacks: Vec<Slack>, shared: f64) -> f64 {
        let reach = |of: u32| CERTAIN * (self.own(of) + shared);
        if slacks.iter().any(|(of, slack)| *slack < -reach(*of)) {
            return 0.0;
        }
        slacks.retain(|(of, slack)| *slack < reach(*of));
        let Some(least) = slacks.iter().map(|(_, slack)| *slack).min_by(f64::total_cmp) else { return 1.0 };
        let at = |t: f64| slacks.iter().map(|(of, slack)| below(slack - t, self.own(*of))).product();
        if shared <= 0.0 {
            at(0.0)
        } else if slacks.iter().all(|(of, _)| self.own(*of) <= 0.0) {
            below(least, shared)
        } else {
            self.over_shared(&slacks, shared, at)
        }
    }

    /// The mean over the shared error.
    fn over_shared(&self, slacks: &[Slack], shared: f64, at: impl Fn(f64) -> f64) -> f64 {
        let is_sudden = |of: u32| self.own(of) <= TINY * shared;
        let own = slacks.iter().filter(|(of, _)| !is_sudden(*of)).map(|(of, _)| self.own(*of));
        let shortest = own.fold(shared, f64::min);
        let breaks = slacks.iter().filter(|(of, _)| is_sudden(*of)).map(|(_, slack)| *slack).collect();
        // The more buildings, the steeper their product.
        let shortest = if slacks.len() > MOST_AT_STEP { shortest * 0.5 } else { shortest };
        mean(shared, (-CERTAIN * shared, CERTAIN * shared), shortest, breaks, at).clamp(0.0, 1.0)
    }

    /// Standard deviation of a building's own error \[1/1024 m\].
    fn own(&self, building: u32) -> f64 {
        steps(self.own_m(building))
    }
}

/// The limits of a building with the lower and the higher of two roofs.
struct Ramp {
    building: u32,
    limits: (f64, f64),
}

/// The mean of a function of a normal error between two, as a part of that between all: of one that is smooth over `shortest` but for some
/// breaks.
fn mean(deviation: f64, (from, to): (f64, f64), shortest: f64, mut breaks: Vec<f64>, at: impl Fn(f64) -> f64) -> f64 {
    let density = |t: f64| libm::exp(-0.5 * (t / deviation) * (t / deviation));
    breaks.retain(|v| *v > from && *v < to);
    let is_whole = to - from >= 2.0 * CERTAIN * deviation;
    let sum = if breaks.is_empty() && is_whole {
        // At both ends there is nothing, so equal steps are best: they are off by e to the −2π²/STEP².
        let n = ((to - from) / (STEP * shortest)).ceil();
        let step = (to - from) / n;
        let mut sum = 0.0;
        let mut t = from + 0.5 * step;
        while t < to {
            sum += step * density(t) * at(t);
            t += step;
        }
        sum
    } else {
        breaks.sort_unstable_by(f64::total_cmp);
        breaks.push(to);
        let mut sum = 0.0;
        let mut from = from;
        for to in breaks {
            let n = ((to - from) / (PART * shortest)).ceil();
            let width = (to - from) / n;
            let mut start = from;
            while start + 0.5 * width < to {
                sum += width * mean_over_unit(|x| density(start + x * width) * at(start + x * width));
                start += width;
            }
            from = to;
        }
        sum
    };
    sum / (deviation * std::f64::consts::TAU.sqrt())
}

/// The probability that a normal error of some standard deviation is at most `slack`.
#[inline]
fn below(slack: f64, deviation: f64) -> f64 {
    if deviation > 0.0 {
        0.5 * libm::erfc(-slack / deviation * std::f64::consts::FRAC_1_SQRT_2)
    } else {
        f64::from(u8::from(slack >= 0.0))
    }
}

fn rounded(steps: f64) -> i64 {
    #[expect(clippy::cast_possible_truncation, reason = "heights of buildings")]
    let whole = steps.round() as i64;
    whole
}

fn steps(m: f64) -> f64 {
    m * f64::from(STEPS_PER_UNIT)
}

#[expect(clippy::cast_precision_loss, reason = "differences of heights, at most 2^28")]
fn as_f64(v: i64) -> f64 {
    v as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the midpoint rule, finely: the means over the shared error, and over each building's own one for the link to be clear.
    fn by_many_parts(limits: &HeightLimits, errors: &HeightErrors) -> f64 {
        let n = 200_000;
        let mut sum = 0.0;
        for k in 0..n {
            let t = (f64::from(k) + 0.5) / f64::from(n) * 14.0 - 7.0;
            let density = (-0.5 * t * t).exp() / (2.0 * std::f64::consts::PI).sqrt() * 14.0 / f64::from(n);
            let product: f64 = limits
                .crossed
                .iter()
                .map(|(of, limit)| {
                    let slack = as_f64(*limit) + 0.5 - t * steps(errors.shared_m);
                    below(slack, steps(errors.own_m(*of)))
                })
                .product();
            sum += density * product;
        }
        sum
    }

    #[test]
    fn few_nodes_are_as_good_as_many() {
        let of = |own: [f64; 4], shared_m| HeightErrors { own: OwnErrors::ByBuilding(own.into()), shared_m };
        for errors in
            [of([1.0; 4], 1.0), of([0.3, 2.0, 1.0, 0.2], 3.0), of([0.0, 2.0, 0.0, 1.0], 1.5), of([0.0; 4], 0.7)]
        {
            for limits in [vec![(0, 1000)], vec![(0, -1000), (1, 500), (2, 1)], vec![(2, 1000), (3, -1000)]] {
                let limits = HeightLimits { crossed: limits, ..HeightLimits::default() };
                let wanted = by_many_parts(&limits, &errors);
                let found = errors.probability(&limits);
                // A jump of the midpoint rule is off by a part.
                assert!((found - wanted).abs() < 3e-5, "{found} {wanted} {limits:?} {errors:?}");
                assert!(wanted > 0.01 && wanted < 0.99, "{wanted}");
            }
        }
    }

    #[test]
    fn tiny_errors_beside_a_shared_one_are_none_and_take_no_time() {
        let limits = HeightLimits { crossed: vec![(0, -1000), (1, 500)], ..HeightLimits::default() };
        let of = |own_m: f64| {
            let errors = HeightErrors::same(own_m, 3.0);
            let on_roof = errors.probability_on_roof(0, |by| {
                let crossed = vec![(0, 500), (1, 300 + by / 2)];
                Some(HeightLimits { crossed, ..HeightLimits::default() })
            });
            [errors.probability(&limits), on_roof]
        };
        let wanted = of(0.0);
        for own_m in [1e-12, 1e-6, 0.001, 0.02] {
            let found = of(own_m);
            assert!((0..2).all(|k| (found[k] - wanted[k]).abs() < 1e-3), "{own_m}: {found:?} {wanted:?}");
            assert!(wanted.iter().all(|p| *p > 0.1 && *p < 0.9), "{wanted:?}");
        }
        // A roof that moves by less than a step.
        let errors = HeightErrors::same(1e-7, 0.0);
        let clear = HeightLimits { crossed: vec![(1, 1)], ..HeightLimits::default() };
        assert!(errors.probability_on_roof(0, |_| Some(clear.clone())) > 0.999);
    }

    #[test]
    fn without_errors_a_link_is_clear_or_not() {
        let errors = HeightErrors::same(0.0, 0.0);
        let of = |limit: i64| {
            let limits = HeightLimits { crossed: vec![(0, limit)], ..HeightLimits::default() };
            errors.probability(&limits)
        };
        assert_eq!([-1, 0, 1].map(|limit| of(limit).to_bits()), [0.0_f64, 1.0, 1.0].map(f64::to_bits));
    }

    #[test]
    fn a_building_that_is_as_high_as_its_limit_is_clear_half_the_time() {
        for errors in [HeightErrors::same(2.0, 0.0), HeightErrors::same(0.0, 2.0), HeightErrors::same(1.2, 1.6)] {
            let of = |limit: i64| {
                let limits = HeightLimits { crossed: vec![(0, limit)], ..HeightLimits::default() };
                errors.probability(&limits)
            };
            // Tables of the normal distribution: one standard deviation of 2 m, half a step on.
            assert!((of(0) - 0.5).abs() < 2e-4, "{}", of(0));
            assert!((of(2048) - 0.841_344_7).abs() < 2e-4, "{}", of(2048));
            assert!((of(-4096) - 0.022_750_1).abs() < 2e-4, "{}", of(-4096));
        }
    }
}
