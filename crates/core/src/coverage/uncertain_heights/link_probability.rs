//! Probability that one link is clear, where heights of buildings are off.
//!
//! **One link.** Building i has room for an error of l_i at most ([`HeightLimits`]). With a known
//! shared error t, the link is clear with the product of Φ((l_i − t)/σ_i) over the buildings
//! crossed, Φ the distribution of the normal one. Over t the product is integrated in equal steps
//! of 3/4 of the least σ_i or τ. A building without an error of its own hides the receiver all of a
//! sudden. Parts end there, with Gauss–Legendre of five nodes in each. [`HeightErrors`] has all
//! tolerances.
//!
//! **A receiver on a roof** moves with its building, by b = e_i + t. Its link is clear of the
//! ground and of its own roof for one interval of b ([`PlanCrossings`]), to which the mean is cut.
//! Rooms of other buildings are the least of straight lines in b, so parts end where one gives way
//! to another. Given b, t is normal with mean b·τ²/(σ_i² + τ²) and deviation τσ_i/√(σ_i² + τ²).

use crate::los::{CERTAIN, HeightErrors, HeightLimits, MOST_AT_STEP, PART, PlanCrossings, STEP, TINY};
use crate::quadrature::mean_over_unit;

/// By how much a building is lower than hides a link, if no error is shared \[1/1024 m\].
type Slack = (u32, f64);

impl HeightErrors {
    /// Returns the probability that the link of a receiver whose height is known is clear, on the
    /// roof of a building or on the ground.
    pub(super) fn probability(&self, on_roof_of: Option<u32>, link: &PlanCrossings<'_>) -> f64 {
        if link.coincides_at() == Some(0) {
            return 1.0;
        }
        let Some(exact) = link.limits(0) else { return 0.0 };
        let mut rooms = link.rooms(0.0, |_| true);
        // A building without an error is in the way or not: whole steps decide that exactly.
        if self.shared_m <= 0.0 {
            for ((of, room), (_, exact)) in rooms.crossed.iter_mut().zip(&exact.crossed) {
                *room = if self.own_steps(*of) > 0.0 { *room } else { as_f64(*exact) };
            }
            for (wall, exact) in rooms.walls.iter_mut().zip(&exact.walls) {
                for k in 0..2 {
                    let is_known = self.own_steps(wall.buildings[k]) <= 0.0;
                    wall.rooms[k] = if is_known { as_f64(exact.rooms[k]) } else { wall.rooms[k] };
                }
            }
        }
        let rooms = match on_roof_of {
            Some(building) => rooms.with_error_of(building, 0.0),
            None => Some(rooms),
        };
        rooms.map_or(0.0, |rooms| self.given(&rooms, 0.0, self.shared_steps()))
    }

    /// Returns the probability that the link of a receiver on the roof of a building is clear, as
    /// far as [`CERTAIN`] deviations of its error reach.
    pub(super) fn probability_on_roof(&self, building: u32, link: &PlanCrossings<'_>) -> f64 {
        let (shared, own) = (self.shared_steps(), self.own_steps(building));
        let of_roof = shared.hypot(own);
        if of_roof <= 0.0 {
            return self.probability(Some(building), link);
        }
        let Some((from, to)) = self.clear_of_ground_and_roof(building, link) else { return 0.0 };
        // What is known of the shared error once that of the roof is.
        let (part, left) = ((shared / of_roof).powi(2), shared * own / of_roof);
        let certain = |of: u32| CERTAIN * self.own_steps(of).hypot(left);
        // Rooms are concave, so they are least at an end.
        let at_ends = [from, to].map(|b| (b * part, link.rooms(b, |of| of != building)));
        let mut near: Vec<u32> = Vec::new();
        for (mean, rooms) in &at_ends {
            let of_walls = rooms.walls.iter().flat_map(|wall| [0, 1].map(|k| (wall.buildings[k], wall.rooms[k])));
            for (of, room) in rooms.crossed.iter().copied().chain(of_walls) {
                if of != building && room - mean < certain(of) && !near.contains(&of) {
                    near.push(of);
                }
            }
        }
        let is_near = |of: u32| near.contains(&of);
        let given = |b: f64| {
            let rooms = link.rooms(b, is_near).with_error_of(building, b);
            rooms.map_or(0.0, |rooms| self.given(&rooms, b * part, left))
        };
        if near.is_empty() {
            return (below(to, of_roof) - below(from, of_roof)).max(0.0);
        }
        // Over what is left of the shared error, another building hides the receiver little by
        // little.
        let tiny = TINY * of_roof;
        let smooth = |of: u32| self.own_steps(of).hypot(left);
        let mut breaks = link.kinks((from, to), is_near);
        breaks.sort_unstable_by(f64::total_cmp);
        let sudden: Vec<u32> = near.iter().copied().filter(|of| smooth(*of) <= tiny).collect();
        let slacks = |b: f64| {
            let rooms = link.rooms(b, |of| sudden.contains(&of));
            let of_walls = rooms.walls.iter().flat_map(|wall| wall.rooms);
            let all = rooms.crossed.iter().map(|(_, room)| *room).chain(of_walls);
            all.map(|room| room - b * part).collect::<Vec<f64>>()
        };
        if !sudden.is_empty() {
            let ends: Vec<f64> = [from].into_iter().chain(breaks.iter().copied()).chain([to]).collect();
            for pair in ends.windows(2) {
                for (a, b) in slacks(pair[0]).into_iter().zip(slacks(pair[1])) {
                    if a * b < 0.0 {
                        breaks.push(pair[0] + (pair[1] - pair[0]) * a / (a - b));
                    }
                }
            }
        }
        let shortest = near.iter().map(|of| smooth(*of)).filter(|smooth| *smooth > tiny).fold(of_roof, f64::min);
        mean(of_roof, (from, to), shortest, breaks, given).clamp(0.0, 1.0)
    }

    /// Returns the errors of the roof below a receiver between which neither ground nor that roof
    /// blocks its link \[1/1024 m\].
    fn clear_of_ground_and_roof(&self, building: u32, link: &PlanCrossings<'_>) -> Option<(f64, f64)> {
        let most = CERTAIN * self.shared_steps().hypot(self.own_steps(building));
        let to = link.most_on_roof(building).min(most);
        let (mut hidden, mut clear) = (rounded(-most), rounded(to.max(-most)));
        let from = if link.is_clear_of_ground(hidden) {
            -most
        } else if !link.is_clear_of_ground(clear) {
            return None;
        } else {
            while clear - hidden > 1 {
                let middle = i64::midpoint(hidden, clear);
                if link.is_clear_of_ground(middle) { clear = middle } else { hidden = middle }
            }
            // Somewhere in the step.
            as_f64(clear) - 0.5
        };
        (from <= to).then_some((from, to))
    }

    /// Returns the probability given the mean and the standard deviation of the shared error
    /// \[1/1024 m\].
    fn given(&self, limits: &HeightLimits<f64>, mean_error: f64, shared: f64) -> f64 {
        let slack = |room: f64| room - mean_error;
        if limits.walls.is_empty() {
            return self.of_slacks(limits.crossed.iter().map(|(of, room)| (*of, slack(*room))).collect(), shared);
        }
        let at = |t: f64| limits.probability(&|of, room| below(slack(room) - t, self.own_steps(of)));
        if shared <= 0.0 {
            return at(0.0);
        }
        let sides = limits.walls.iter().flat_map(|wall| [0, 1].map(|k| (wall.buildings[k], wall.rooms[k])));
        let all = limits.crossed.iter().copied().chain(sides).map(|(of, room)| (of, slack(room)));
        self.over_shared(&all.collect::<Vec<Slack>>(), shared, at)
    }

    /// Returns the probability that no building is higher than it may be.
    fn of_slacks(&self, mut slacks: Vec<Slack>, shared: f64) -> f64 {
        let reach = |of: u32| CERTAIN * (self.own_steps(of) + shared);
        if slacks.iter().any(|(of, slack)| *slack < -reach(*of)) {
            return 0.0;
        }
        slacks.retain(|(of, slack)| *slack < reach(*of));
        let Some(least) = slacks.iter().map(|(_, slack)| *slack).min_by(f64::total_cmp) else { return 1.0 };
        let at = |t: f64| slacks.iter().map(|(of, slack)| below(slack - t, self.own_steps(*of))).product();
        if shared <= 0.0 {
            at(0.0)
        } else if slacks.iter().all(|(of, _)| self.own_steps(*of) <= 0.0) {
            below(least, shared)
        } else {
            self.over_shared(&slacks, shared, at)
        }
    }

    /// Returns the mean over the shared error.
    fn over_shared(&self, slacks: &[Slack], shared: f64, at: impl Fn(f64) -> f64) -> f64 {
        let is_sudden = |of: u32| self.own_steps(of) <= TINY * shared;
        let own = slacks.iter().filter(|(of, _)| !is_sudden(*of)).map(|(of, _)| self.own_steps(*of));
        let shortest = own.fold(shared, f64::min);
        let breaks = slacks.iter().filter(|(of, _)| is_sudden(*of)).map(|(_, slack)| *slack).collect();
        // The more buildings, the steeper their product.
        let shortest = if slacks.len() > MOST_AT_STEP { shortest * 0.5 } else { shortest };
        mean(shared, (-CERTAIN * shared, CERTAIN * shared), shortest, breaks, at).clamp(0.0, 1.0)
    }
}

/// Returns the mean of a function of a normal error between two, as a part of that between all: of
/// one that is smooth over `shortest` but for some breaks.
fn mean(deviation: f64, (from, to): (f64, f64), shortest: f64, mut breaks: Vec<f64>, at: impl Fn(f64) -> f64) -> f64 {
    let density = |t: f64| libm::exp(-0.5 * (t / deviation) * (t / deviation));
    breaks.retain(|v| *v > from && *v < to);
    let is_whole = to - from >= 2.0 * CERTAIN * deviation;
    let sum = if breaks.is_empty() && is_whole {
        // At both ends there is nothing, so equal steps are best: they are off by e to the
        // −2π²/STEP².
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

/// Returns the probability that a normal error of some standard deviation is at most `slack`.
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

#[expect(clippy::cast_precision_loss, reason = "differences of heights, at most 2^28")]
fn as_f64(v: i64) -> f64 {
    v as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::los::OwnErrors;

    /// Integrates by the midpoint rule, finely: the means over the shared error, and over each
    /// building's own one for the link to be clear.
    fn by_many_parts(limits: &HeightLimits<f64>, errors: &HeightErrors) -> f64 {
        let n = 200_000;
        let mut sum = 0.0;
        for k in 0..n {
            let t = (f64::from(k) + 0.5) / f64::from(n) * 14.0 - 7.0;
            let density = (-0.5 * t * t).exp() / (2.0 * std::f64::consts::PI).sqrt() * 14.0 / f64::from(n);
            let product: f64 = limits
                .crossed
                .iter()
                .map(|(of, limit)| {
                    let slack = *limit - t * errors.shared_steps();
                    below(slack, errors.own_steps(*of))
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
            for limits in [vec![(0, 1e3)], vec![(0, -1e3), (1, 500.0), (2, 1.0)], vec![(2, 1e3), (3, -1e3)]] {
                let limits = HeightLimits { crossed: limits, ..HeightLimits::default() };
                let wanted = by_many_parts(&limits, &errors);
                let found = errors.given(&limits, 0.0, errors.shared_steps());
                // A jump of the midpoint rule is off by a part.
                assert!((found - wanted).abs() < 3e-5, "{found} {wanted} {limits:?} {errors:?}");
                assert!(wanted > 0.01 && wanted < 0.99, "{wanted}");
            }
        }
    }

    #[test]
    fn tiny_errors_beside_a_shared_one_are_none_and_take_no_time() {
        let limits = HeightLimits { crossed: vec![(0, -1e3), (1, 500.0)], ..HeightLimits::default() };
        let of = |own_m: f64| {
            let errors = HeightErrors::same(own_m, 3.0);
            errors.given(&limits, 0.0, errors.shared_steps())
        };
        let wanted = of(0.0);
        for own_m in [1e-12, 1e-6, 0.001, 0.02] {
            let found = of(own_m);
            assert!((found - wanted).abs() < 1e-3, "{own_m}: {found} {wanted}");
        }
        assert!(wanted > 0.1 && wanted < 0.9, "{wanted}");
    }

    #[test]
    fn without_errors_a_link_is_clear_or_not() {
        let errors = HeightErrors::same(0.0, 0.0);
        let of = |limit: f64| {
            let limits = HeightLimits { crossed: vec![(0, limit)], ..HeightLimits::default() };
            errors.given(&limits, 0.0, errors.shared_steps())
        };
        assert_eq!([-1.0, 0.0, 1.0].map(|limit| of(limit).to_bits()), [0.0_f64, 1.0, 1.0].map(f64::to_bits));
    }

    #[test]
    fn a_building_that_is_as_high_as_its_limit_is_clear_half_the_time() {
        for errors in [HeightErrors::same(2.0, 0.0), HeightErrors::same(0.0, 2.0), HeightErrors::same(1.2, 1.6)] {
            let of = |limit: f64| {
                let limits = HeightLimits { crossed: vec![(0, limit)], ..HeightLimits::default() };
                errors.given(&limits, 0.0, errors.shared_steps())
            };
            // Tables of the normal distribution: one standard deviation of 2 m.
            assert!((of(0.0) - 0.5).abs() < 2e-7, "{}", of(0.0));
            assert!((of(2048.0) - 0.841_344_7).abs() < 2e-7, "{}", of(2048.0));
            assert!((of(-4096.0) - 0.022_750_1).abs() < 2e-7, "{}", of(-4096.0));
        }
    }
}
