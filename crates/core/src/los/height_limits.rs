//! What a link asks of the buildings that it passes: how high each may be, so that it is clear.
//!
//! A link is line of sight if and only if no roof on its way is above its limit. Where it runs along the wall between two buildings, one of
//! both must be low enough. So the probability of line of sight follows from those of heights: of independent buildings the product over all
//! that have a limit, with walls told apart by cases.

/// Two buildings side by side, and the highest top of the lower one that leaves a link along their wall clear.
type Wall = (u32, u32, i64);

/// How high buildings may be so that a link past them is clear.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct HeightLimits {
    /// The buildings that the link crosses, each with the highest top that leaves it clear \[1/1024 m above the datum\].
    pub crossed: Vec<(u32, i64)>,
    /// Walls between two buildings that the link runs along: it is clear if one of both is no higher than this.
    pub walls: Vec<Wall>,
}

impl HeightLimits {
    /// Adds a limit of a building, of which the lowest counts.
    pub(super) fn limit(&mut self, building: u32, top: i64) {
        match self.crossed.iter_mut().find(|(b, _)| *b == building) {
            Some((_, known)) => *known = (*known).min(top),
            None => self.crossed.push((building, top)),
        }
    }

    /// Adds a wall between two pieces.
    pub(super) fn wall(&mut self, a: u32, b: u32, top: i64) {
        if a == b { self.limit(a, top) } else { self.walls.push((a, b, top)) }
    }

    /// What is left to ask of the others once the top of one building is known; `None` if that is too high.
    pub(crate) fn with_top_of(mut self, building: u32, top: i64) -> Option<HeightLimits> {
        if self.crossed.iter().any(|(of, limit)| *of == building && top > *limit) {
            return None;
        }
        self.crossed.retain(|(of, _)| *of != building);
        let (known, walls): (Vec<Wall>, Vec<Wall>) =
            self.walls.into_iter().partition(|(a, b, _)| *a == building || *b == building);
        let mut left = HeightLimits { crossed: self.crossed, walls };
        for (a, b, limit) in known.into_iter().filter(|(.., limit)| top > *limit) {
            left.limit(if a == building { b } else { a }, limit);
        }
        Some(left)
    }

    /// The probability that the link is clear, if heights of buildings are independent: `probability(building, limit)` is that of a building to be no
    /// higher than a limit \[1/1024 m above the datum\].
    ///
    /// Cost: linear in the buildings crossed; quadratic in walls that have buildings in common.
    pub fn probability(&self, probability: &impl Fn(u32, i64) -> f64) -> f64 {
        let mut spans: Vec<Span> =
            self.crossed.iter().map(|(of, top)| Span { up_to: Some(*top), ..Span::all(*of) }).collect();
        if self.walls.is_empty() {
            return product(&spans, probability);
        }
        for building in self.walls.iter().flat_map(|(a, b, _)| [*a, *b]) {
            if spans.iter().all(|span| span.building != building) {
                spans.push(Span::all(building));
            }
        }
        probability_of(spans, self.walls.clone(), probability)
    }
}

/// Heights of a building: above one limit, up to another.
#[derive(Debug, Clone, Copy)]
struct Span {
    building: u32,
    over: Option<i64>,
    up_to: Option<i64>,
}

impl Span {
    fn all(building: u32) -> Span {
        Span { building, over: None, up_to: None }
    }

    fn probability(&self, probability: &impl Fn(u32, i64) -> f64) -> f64 {
        let up_to = |limit: Option<i64>, without: f64| limit.map_or(without, |limit| probability(self.building, limit));
        (up_to(self.up_to, 1.0) - up_to(self.over, 0.0)).max(0.0)
    }

    fn is_below(&self, top: i64) -> bool {
        self.up_to.is_some_and(|up_to| up_to <= top)
    }

    fn is_above(&self, top: i64) -> bool {
        self.over.is_some_and(|over| over >= top)
    }

    fn lower(&mut self, top: i64) {
        self.up_to = Some(self.up_to.map_or(top, |up_to| up_to.min(top)));
    }
}

fn product(spans: &[Span], probability: &impl Fn(u32, i64) -> f64) -> f64 {
    spans.iter().map(|span| span.probability(probability)).product()
}

fn span_of(spans: &mut [Span], building: u32) -> &mut Span {
    let at = spans.iter().position(|span| span.building == building);
    &mut spans[at.expect("all buildings of walls have a span")]
}

/// The probability that heights are within their spans, and that of each wall one side is low enough.
fn probability_of(mut spans: Vec<Span>, mut walls: Vec<Wall>, probability: &impl Fn(u32, i64) -> f64) -> f64 {
    // What spans say of walls, and the other way round, until neither has news.
    loop {
        let n = walls.len();
        walls.retain(|(a, b, top)| {
            let (of_a, of_b) = (*span_of(&mut spans, *a), *span_of(&mut spans, *b));
            if of_a.is_below(*top) || of_b.is_below(*top) {
                return false;
            }
            if of_a.is_above(*top) {
                span_of(&mut spans, *b).lower(*top);
                return false;
            }
            if of_b.is_above(*top) {
                span_of(&mut spans, *a).lower(*top);
                return false;
            }
            true
        });
        if walls.len() == n {
            break;
        }
    }
    let Some(first) = walls.first() else { return product(&spans, probability) };
    // The walls that hang together with the first one, by buildings on both.
    let mut together = vec![first.0, first.1];
    loop {
        let n = together.len();
        for (a, b, _) in &walls {
            match (together.contains(a), together.contains(b)) {
                (true, false) => together.push(*b),
                (false, true) => together.push(*a),
                _ => {}
            }
        }
        if together.len() == n {
            break;
        }
    }
    let is_together = |building: u32| together.contains(&building);
    let (of_them, others): (Vec<Span>, Vec<Span>) = spans.into_iter().partition(|span| is_together(span.building));
    let (their_walls, other_walls): (Vec<Wall>, Vec<Wall>) = walls.into_iter().partition(|(a, ..)| is_together(*a));
    // One wall in the middle is told apart by cases, which parts a row of houses in two.
    let mut left = their_walls;
    let (a, b, top) = left.remove(left.len() / 2);
    let case = |change: &dyn Fn(&mut [Span])| {
        let mut spans = of_them.clone();
        change(&mut spans);
        probability_of(spans, left.clone(), probability)
    };
    let low = case(&|spans| span_of(spans, a).lower(top));
    let high = case(&|spans| {
        span_of(spans, a).over = Some(span_of(spans, a).over.map_or(top, |over| over.max(top)));
        span_of(spans, b).lower(top);
    });
    (low + high) * probability_of(others, other_walls, probability)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Some buildings, each of some heights that are equally likely.
    fn by_enumeration(limits: &HeightLimits, heights: &[Vec<i64>]) -> f64 {
        let n: usize = heights.iter().map(Vec::len).product();
        let is_clear = |mut k: usize| {
            let tops: Vec<i64> = heights
                .iter()
                .map(|of| {
                    let top = of[k % of.len()];
                    k /= of.len();
                    top
                })
                .collect();
            let top = |building: u32| tops[building as usize];
            limits.crossed.iter().all(|(b, limit)| top(*b) <= *limit)
                && limits.walls.iter().all(|(a, b, limit)| top(*a) <= *limit || top(*b) <= *limit)
        };
        (0..n).filter(|k| is_clear(*k)).count() as f64 / n as f64
    }

    #[test]
    fn probabilities_are_those_of_all_combinations_of_heights() {
        let mut state = 7_u64;
        let mut below = |n: u32| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            u32::try_from(state >> 33).expect("31 bits") % n
        };
        let mut n_between = 0;
        for _ in 0..4000 {
            let n_buildings = 1 + below(7);
            // Powers of two, so that shares of one height or another are exact.
            let heights: Vec<Vec<i64>> =
                (0..n_buildings).map(|_| (0..1 << below(3)).map(|_| i64::from(below(6))).collect()).collect();
            let mut limits = HeightLimits::default();
            for _ in 0..below(5) {
                limits.limit(below(n_buildings), i64::from(below(7)) - 1);
            }
            for _ in 0..below(8) {
                limits.wall(below(n_buildings), below(n_buildings), i64::from(below(7)) - 1);
            }
            let share = |building: u32, limit: i64| {
                let of = &heights[building as usize];
                of.iter().filter(|top| **top <= limit).count() as f64 / of.len() as f64
            };
            let (found, wanted) = (limits.probability(&share), by_enumeration(&limits, &heights));
            assert_eq!(found.to_bits(), wanted.to_bits(), "{found} {wanted} {limits:?} {heights:?}");
            n_between += u32::from(wanted > 0.0 && wanted < 1.0);
        }
        assert!(n_between > 300, "{n_between}");
    }

    #[test]
    fn a_long_row_of_walls_is_told_apart_in_no_time() {
        let mut limits = HeightLimits::default();
        (0..200).for_each(|k| limits.wall(k, k + 1, 5));
        // Each building is low or high alike: of rows of 201 those without two high ones side by side, a Fibonacci number.
        let found = limits.probability(&|_, limit| if limit >= 5 { 0.5 } else { 0.0 });
        let (mut before, mut now) = (1.0_f64, 1.0_f64);
        for _ in 2..=201 {
            (before, now) = (now, now / 2.0 + before / 4.0);
        }
        assert!((found / now - 1.0).abs() < 1e-9, "{found} {now}");
    }
}
