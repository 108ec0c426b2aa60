//! Limits of a link on the buildings that it passes: the height up to which each leaves it clear.
//!
//! A link is LoS if and only if no building on its way exceeds its known height by more than its
//! room. Where the link runs along the wall between two buildings, one of both must be low enough.
//! So the probability of line of sight follows from those of heights. For independent buildings it
//! is the product over all that have a limit, and walls are split into cases.

/// Two buildings side by side along a link, and how much higher each may be if the other one is in
/// its way \[1/1024 m\].
///
/// For sloped roofs it is the room where the lower of both comes nearest to the link. That is all
/// that matters if both have the same error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wall<R = i64> {
    /// Numbers of the two buildings.
    pub buildings: [u32; 2],
    /// Room of each: how much higher it may be; below 0 if it is too high already.
    pub rooms: [R; 2],
}

/// Per building, how far its roof may rise before it blocks the link: in whole steps, rounded down,
/// or in reals.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HeightLimits<R = i64> {
    /// The buildings that the link crosses, each with its room: how much higher it may be without
    /// blocking the link \[1/1024 m\].
    pub crossed: Vec<(u32, R)>,
    /// Walls between two buildings that the link runs along. It is clear if one of both has the
    /// room.
    pub walls: Vec<Wall<R>>,
}

impl<R> Default for HeightLimits<R> {
    /// Makes the limits of a link that meets no building.
    fn default() -> Self {
        HeightLimits { crossed: Vec::new(), walls: Vec::new() }
    }
}

impl<R: PartialOrd + Copy> HeightLimits<R> {
    /// Adds the room of a building; the least room counts.
    pub(super) fn limit(&mut self, building: u32, room: R) {
        match self.crossed.iter_mut().find(|(b, _)| *b == building) {
            Some((_, known)) => *known = least(*known, room),
            None => self.crossed.push((building, room)),
        }
    }

    /// Adds a wall between pieces of two buildings, or of one.
    pub(super) fn wall(&mut self, buildings: [u32; 2], rooms: [R; 2]) {
        let [a, b] = buildings;
        if a == b {
            self.limit(a, if rooms[0] > rooms[1] { rooms[0] } else { rooms[1] })
        } else {
            self.walls.push(Wall { buildings, rooms })
        }
    }

    /// Returns the limits of the other buildings for a known error `by` of one building; `None` if
    /// that error blocks the link.
    pub(crate) fn with_error_of(mut self, building: u32, by: R) -> Option<HeightLimits<R>> {
        if self.crossed.iter().any(|(of, room)| *of == building && by > *room) {
            return None;
        }
        self.crossed.retain(|(of, _)| *of != building);
        let mut left = HeightLimits { crossed: self.crossed, walls: Vec::new() };
        for wall in self.walls {
            match wall.buildings.iter().position(|of| *of == building) {
                None => left.walls.push(wall),
                Some(k) if by > wall.rooms[k] => left.limit(wall.buildings[1 - k], wall.rooms[1 - k]),
                Some(_) => {}
            }
        }
        Some(left)
    }

    /// Returns the probability that the link is clear, if heights of buildings are independent.
    /// `probability(building, room)` is the probability that a building's error is at most `room`
    /// \[1/1024 m\].
    ///
    /// Cost: linear in the buildings crossed; quadratic in walls that have buildings in common.
    pub fn probability(&self, probability: &impl Fn(u32, R) -> f64) -> f64 {
        let mut spans: Vec<Span<R>> =
            self.crossed.iter().map(|(of, room)| Span { up_to: Some(*room), ..Span::all(*of) }).collect();
        if self.walls.is_empty() {
            return product(&spans, probability);
        }
        for building in self.walls.iter().flat_map(|wall| wall.buildings) {
            if spans.iter().all(|span| span.building != building) {
                spans.push(Span::all(building));
            }
        }
        probability_of(spans, self.walls.clone(), probability)
    }
}

/// Errors of a building: above `over`, up to `up_to`.
#[derive(Debug, Clone, Copy)]
struct Span<R> {
    building: u32,
    over: Option<R>,
    up_to: Option<R>,
}

fn least<R: PartialOrd>(a: R, b: R) -> R {
    if b < a { b } else { a }
}

impl<R: PartialOrd + Copy> Span<R> {
    fn all(building: u32) -> Self {
        Span { building, over: None, up_to: None }
    }

    fn probability(&self, probability: &impl Fn(u32, R) -> f64) -> f64 {
        let up_to = |limit: Option<R>, without: f64| limit.map_or(without, |limit| probability(self.building, limit));
        (up_to(self.up_to, 1.0) - up_to(self.over, 0.0)).max(0.0)
    }

    fn is_below(&self, room: R) -> bool {
        self.up_to.is_some_and(|up_to| up_to <= room)
    }

    fn is_above(&self, room: R) -> bool {
        self.over.is_some_and(|over| over >= room)
    }

    fn lower(&mut self, room: R) {
        self.up_to = Some(self.up_to.map_or(room, |up_to| least(up_to, room)));
    }
}

fn product<R: PartialOrd + Copy>(spans: &[Span<R>], probability: &impl Fn(u32, R) -> f64) -> f64 {
    spans.iter().map(|span| span.probability(probability)).product()
}

fn span_of<R>(spans: &mut [Span<R>], building: u32) -> &mut Span<R> {
    let at = spans.iter().position(|span| span.building == building);
    &mut spans[at.expect("all buildings of walls have a span")]
}

/// Returns the probability that errors are within their spans, and that of each wall one side is
/// low enough.
fn probability_of<R: PartialOrd + Copy>(
    mut spans: Vec<Span<R>>,
    mut walls: Vec<Wall<R>>,
    probability: &impl Fn(u32, R) -> f64,
) -> f64 {
    // Spans settle walls, and settled walls narrow spans, until nothing changes.
    loop {
        let n = walls.len();
        walls.retain(|Wall { buildings: [a, b], rooms: [room_a, room_b] }| {
            let (of_a, of_b) = (*span_of(&mut spans, *a), *span_of(&mut spans, *b));
            if of_a.is_below(*room_a) || of_b.is_below(*room_b) {
                return false;
            }
            if of_a.is_above(*room_a) {
                span_of(&mut spans, *b).lower(*room_b);
                return false;
            }
            if of_b.is_above(*room_b) {
                span_of(&mut spans, *a).lower(*room_a);
                return false;
            }
            true
        });
        if walls.len() == n {
            break;
        }
    }
    let Some(first) = walls.first() else { return product(&spans, probability) };
    // The walls connected to the first one through common buildings.
    let mut together = first.buildings.to_vec();
    loop {
        let n = together.len();
        for Wall { buildings: [a, b], .. } in &walls {
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
    let (of_them, others): (Vec<Span<R>>, Vec<Span<R>>) =
        spans.into_iter().partition(|span| is_together(span.building));
    let (their_walls, other_walls): (Vec<Wall<R>>, Vec<Wall<R>>) =
        walls.into_iter().partition(|wall| is_together(wall.buildings[0]));
    // A wall in the middle is split into cases, which divides a row of houses in two.
    let mut left = their_walls;
    let Wall { buildings: [a, b], rooms: [room_a, room_b] } = left.remove(left.len() / 2);
    let case = |change: &dyn Fn(&mut [Span<R>])| {
        let mut spans = of_them.clone();
        change(&mut spans);
        probability_of(spans, left.clone(), probability)
    };
    let low = case(&|spans| span_of(spans, a).lower(room_a));
    let high = case(&|spans| {
        span_of(spans, a).over =
            Some(span_of(spans, a).over.map_or(room_a, |over| if room_a > over { room_a } else { over }));
        span_of(spans, b).lower(room_b);
    });
    (low + high) * probability_of(others, other_walls, probability)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the probability that the limits are kept, by enumeration of equally likely heights
    /// of each building.
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
            let has_room = |wall: &Wall| (0..2).any(|k| top(wall.buildings[k]) <= wall.rooms[k]);
            limits.crossed.iter().all(|(b, limit)| top(*b) <= *limit) && limits.walls.iter().all(has_room)
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
                let buildings = [below(n_buildings), below(n_buildings)];
                limits.wall(buildings, [below(7), below(7)].map(|room| i64::from(room) - 1));
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
        (0..200).for_each(|k| limits.wall([k, k + 1], [5, 5]));
        // Each building is low or high alike: of rows of 201 those without two high ones side by
        // side, a Fibonacci number.
        let found = limits.probability(&|_, limit| if limit >= 5 { 0.5 } else { 0.0 });
        let (mut before, mut now) = (1.0_f64, 1.0_f64);
        for _ in 2..=201 {
            (before, now) = (now, now / 2.0 + before / 4.0);
        }
        assert!((found / now - 1.0).abs() < 1e-9, "{found} {now}");
    }
}
