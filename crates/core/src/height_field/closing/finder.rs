//! Finder of the border of the centers of discs, corner by corner and edge by edge.

use super::TIE;
use super::cells::Cells;
use super::free::{End, Free};
use super::shell::{Shell, holds_near, steps};
use super::vectors::{Edge, Place, cross, direction, dot, minus, plus, turn};
use crate::raster::BitGrid;

/// Rings of cells around a point or an edge that are looked through first: they cover most of those
/// that do not bound E.
const N_RINGS: usize = 4;

/// Finder of pieces of the border of E.
pub(super) struct Finder<'a> {
    pub(super) shell: &'a Shell,
    pub(super) cells: &'a Cells,
    /// Cells that may hold points of E.
    pub(super) may_be_center: &'a BitGrid,
}

/// Centers of discs that touch a corner of a footprint: counter-clockwise between two directions;
/// all where they are none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    pub(super) around: Place,
    pub(super) between: Option<[Place; 2]>,
}

/// Centers of discs that touch an edge on its left.
#[derive(Debug, Clone, Copy)]
pub(super) struct Side {
    pub(super) edge: [Place; 3],
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Arc {
    pub(super) fn has(&self, toward: Place) -> bool {
        let Some([first, last]) = self.between else { return true };
        let is_less_than_half = cross(first, last) > 0.0 || (cross(first, last) == 0.0 && dot(first, last) > 0.0);
        match is_less_than_half {
            true => cross(first, toward) >= 0.0 && cross(toward, last) >= 0.0,
            false => !(cross(last, toward) > 0.0 && cross(toward, first) > 0.0),
        }
    }
}

impl Finder<'_> {
    /// Returns the arcs of E around a point, and their ends.
    pub(super) fn around(&self, point: Place) -> (Vec<Arc>, Vec<Place>) {
        let Shell { radius: r, .. } = *self.shell;
        let mut circle = Circle::around(point, r);
        for other in self.shell.grid.points_around(point, N_RINGS) {
            circle.cover_near_point(other);
            if circle.free.is_empty() {
                return (Vec::new(), Vec::new());
            }
        }
        let at = |turn: f64| plus(point, r, direction(turn));
        // Directions whose turns differ by t are nowhere more than 2 t apart, in radians.
        circle.retain(|interval| self.may_have_centers(interval, 2.0 * r, at));
        for [first, last] in circle.free.intervals.clone() {
            let center = at(0.5 * (first.loose + last.loose));
            let reach = r + (r * (last.loose - first.loose)).min(2.0 * r);
            self.shell.grid.points_in(center, reach).for_each(|other| circle.cover_near_point(other));
            self.shell.grid.edges_in(center, reach).for_each(|edge| circle.cover_near_edge(edge));
        }
        let (mut arcs, mut corners) = (Vec::new(), Vec::new());
        for [first, last] in circle.free.intervals {
            // An arc leaves E only where a footprint near these cells covers it, and ends there:
            // its middle speaks for all of it.
            if !self.cells.holds(self.may_be_center, at(0.5 * (first.loose + last.loose))) {
                continue;
            }
            let ends = [first.exact, last.exact];
            if ends[0] < ends[1] {
                let is_all = ends[1] - ends[0] >= 4.0;
                arcs.push(Arc { around: point, between: (!is_all).then(|| ends.map(direction)) });
            }
            corners.extend(ends.map(at));
        }
        (arcs, corners)
    }

    /// Returns the sides of E along an edge, and their ends.
    pub(super) fn beside(&self, edge: &Edge) -> (Vec<Side>, Vec<Place>) {
        let Shell { radius: r, .. } = *self.shell;
        let (mut sides, mut corners) = (Vec::new(), Vec::new());
        let [from, to] = edge.ends();
        // The left of the edge there and back.
        for edge in [*edge, Edge::between(to, from)] {
            let middle = edge.place(0.5 * edge.length, 0.0);
            let mut free = Free::between(0.0, edge.length);
            for point in self.shell.grid.points_around(middle, N_RINGS) {
                cover_near_point(&mut free, &edge, r, point);
                if free.is_empty() {
                    break;
                }
            }
            free.intervals.retain(|interval| self.may_have_centers(interval, 1.0, |t| edge.place(t, r)));
            for [first, last] in free.intervals.clone() {
                let center = edge.place(0.5 * (first.loose + last.loose), r);
                let reach = r + 0.5 * (last.loose - first.loose);
                let Shell { grid, .. } = self.shell;
                grid.points_in(center, reach).for_each(|point| cover_near_point(&mut free, &edge, r, point));
                grid.edges_in(center, reach).for_each(|other| cover_near_edge(&mut free, &edge, r, other));
            }
            for [first, last] in free.intervals {
                let at = |t: f64| edge.place(t, r);
                if !self.cells.holds(self.may_be_center, at(0.5 * (first.loose + last.loose))) {
                    continue;
                }
                let [from, to] = [first.exact, last.exact];
                if from < to {
                    sides.push(Side { edge: [edge.from, edge.along, edge.normal], from, to });
                }
                corners.extend([from, to].map(at));
            }
        }
        (sides, corners)
    }

    /// Returns whether places of an interval, at most so far apart for each 1 of it, may be in E.
    fn may_have_centers(&self, [first, last]: &[End; 2], most: f64, at: impl Fn(f64) -> Place) -> bool {
        let length = last.loose - first.loose;
        steps(self.cells, length * most)
            .any(|t| holds_near(self.cells, self.may_be_center, at(first.loose + t * length)))
    }
}

/// Takes away centers on the left of an edge whose discs meet a point.
fn cover_near_point(free: &mut Free, edge: &Edge, radius: f64, point: Place) {
    let (t, h) = edge.seen(point);
    free.cover(chord(radius, radius - h).map(|end| End { exact: t + end.exact, loose: t + end.loose }));
}

/// Takes away centers on the left of an edge that are beside another and nearer than the radius.
fn cover_near_edge(free: &mut Free, edge: &Edge, radius: f64, other: &Edge) {
    let (t, h) = other.seen(edge.place(0.0, radius));
    let sides = [-1.0, 1.0].map(|side| End { exact: side * radius, loose: side * (radius - TIE) });
    let across = within(h, dot(edge.along, other.normal), sides);
    let along = within(t, dot(edge.along, other.along), [0.0, other.length].map(End::at));
    let later = |a: End, b: End| if a.loose < b.loose { b } else { a };
    let sooner = |a: End, b: End| if a.loose < b.loose { a } else { b };
    free.cover([later(across[0], along[0]), sooner(across[1], along[1])]);
}

/// Returns where a line at some distance from the middle of a disc enters and leaves it, from the
/// foot of the perpendicular.
fn chord(radius: f64, distance: f64) -> [End; 2] {
    let half = |radius: f64| ((radius - distance) * (radius + distance)).max(0.0).sqrt();
    let (exact, loose) = (half(radius), half(radius - TIE));
    [End { exact: -exact, loose: -loose }, End { exact, loose }]
}

/// Returns where a value that begins at `start` and grows by `slope` is within limits.
fn within(start: f64, slope: f64, limits: [End; 2]) -> [End; 2] {
    let at = |limit: f64| (limit - start) / slope;
    if slope == 0.0 {
        let is_within = limits[0].loose < start && start < limits[1].loose;
        let [from, to] = if is_within { [f64::NEG_INFINITY, f64::INFINITY] } else { [0.0, 0.0] };
        return [End::at(from), End::at(to)];
    }
    let mut ends = limits.map(|limit| End { exact: at(limit.exact), loose: at(limit.loose) });
    if slope < 0.0 {
        ends.reverse();
    }
    ends
}

/// The centers of discs that touch a point, by [turns](turn) of 0 to 4.
struct Circle {
    point: Place,
    radius: f64,
    free: Free,
    /// Directions of the ends of what is free.
    ends: Vec<[Place; 2]>,
}

impl Circle {
    fn around(point: Place, radius: f64) -> Circle {
        Circle { point, radius, free: Free::between(0.0, 4.0), ends: vec![[[1.0, 0.0]; 2]] }
    }

    /// Takes away centers whose discs meet another point.
    fn cover_near_point(&mut self, other: Place) {
        let d = minus(other, self.point);
        let (square, r) = (dot(d, d), self.radius);
        // A center in the direction u is nearer than the radius if u · d is more than this.
        let least = (square + (2.0 * r - TIE) * TIE) / (2.0 * r);
        let far = square.sqrt();
        let is_met = |(interval, [first, last]): (&[End; 2], &[Place; 2])| {
            let is_wide = interval[1].loose - interval[0].loose > 1.5;
            is_wide
                || dot(*first, d) > least
                || dot(*last, d) > least
                || (cross(*first, d) > 0.0 && cross(d, *last) > 0.0)
        };
        if far == 0.0 || least >= far || !self.free.intervals.iter().zip(&self.ends).any(is_met) {
            return;
        }
        let toward = [d[0] / far, d[1] / far];
        let ends_at = |cos: f64| {
            let sin = other_leg(cos);
            [-sin, sin].map(|sin| turn([cos * toward[0] - sin * toward[1], cos * toward[1] + sin * toward[0]]))
        };
        let (exact, loose) = (ends_at(far / (2.0 * r)), ends_at(least / far));
        self.cover([0, 1].map(|k| End { exact: exact[k], loose: loose[k] }));
    }

    /// Takes away centers that are beside an edge and nearer than the radius.
    fn cover_near_edge(&mut self, edge: &Edge) {
        let r = self.radius;
        let (t, h) = edge.seen(self.point);
        if h.abs() >= 2.0 * r || t < -r || t > edge.length + r {
            return;
        }
        // Only directions toward the line of the edge lead to centers nearer to that than the
        // radius.
        let away = if h < 0.0 { [-edge.normal[0], -edge.normal[1]] } else { edge.normal };
        let is_met = |(interval, [first, last]): (&[End; 2], &[Place; 2])| {
            let is_wide = interval[1].loose - interval[0].loose > 1.5;
            let reaches = |u: &Place| h.abs() + r * dot(*u, away) < r - TIE;
            is_wide || reaches(first) || reaches(last) || (cross(*first, away) < 0.0 && cross(away, *last) < 0.0)
        };
        if !self.free.intervals.iter().zip(&self.ends).any(is_met) {
            return;
        }
        // Directions where the circle crosses the sides of the strip around the edge, and where it
        // passes its ends.
        let mut cuts: Vec<End> = Vec::with_capacity(8);
        let mut cut = |exact: Place, loose: Place| {
            let in_plane = |[x, y]: Place| turn(plus([x * edge.along[0], x * edge.along[1]], y, edge.normal));
            cuts.push(End { exact: in_plane(exact), loose: in_plane(loose) });
        };
        for side in [-1.0, 1.0] {
            let sin = |r_side: f64| (side * r_side - h) / r;
            let loose = sin(r - TIE);
            if loose.abs() < 1.0 {
                let exact = sin(r).clamp(-1.0, 1.0);
                [-1.0, 1.0].into_iter().for_each(|k| cut([k * other_leg(exact), exact], [k * other_leg(loose), loose]));
            }
        }
        for end in [0.0, edge.length] {
            let cos = (end - t) / r;
            if cos.abs() < 1.0 {
                let sin = other_leg(cos);
                [-sin, sin].into_iter().for_each(|sin| cut([cos, sin], [cos, sin]));
            }
        }
        cuts.sort_by(|a, b| a.loose.total_cmp(&b.loose));
        for k in 0..cuts.len() {
            let (from, to) = (cuts[k], cuts[(k + 1) % cuts.len()]);
            let lap = if k + 1 < cuts.len() { 0.0 } else { 4.0 };
            let middle = 0.5 * (from.loose + to.loose + lap);
            let middle = direction(if middle < 4.0 { middle } else { middle - 4.0 });
            let along = t + r * dot(middle, edge.along);
            let across = h + r * dot(middle, edge.normal);
            if across.abs() < r - TIE && (0.0..=edge.length).contains(&along) {
                self.cover([from, to]);
            }
        }
    }

    /// Takes away the turns from one to another, counter-clockwise.
    fn cover(&mut self, [from, to]: [End; 2]) {
        // An exact end may be on the other side of the east, where turns begin anew.
        let from = End { exact: if from.exact - from.loose > 2.0 { 0.0 } else { from.exact }, ..from };
        let to = End { exact: if to.loose - to.exact > 2.0 { 4.0 } else { to.exact }, ..to };
        let is_changed = if from.loose > to.loose {
            let last = self.free.cover([from, End::at(f64::INFINITY)]);
            self.free.cover([End::at(f64::NEG_INFINITY), to]) || last
        } else {
            self.free.cover([from, to])
        };
        if is_changed {
            self.renew_ends();
        }
    }

    /// Leaves free only some of the intervals.
    fn retain(&mut self, is_kept: impl Fn(&[End; 2]) -> bool) {
        self.free.intervals.retain(is_kept);
        self.renew_ends();
    }

    fn renew_ends(&mut self) {
        self.ends.clear();
        self.ends.extend(self.free.intervals.iter().map(|interval| interval.map(|end| direction(end.loose))));
    }
}

/// Returns the other leg of a right triangle whose longest side is 1.
fn other_leg(leg: f64) -> f64 {
    ((1.0 - leg) * (1.0 + leg)).max(0.0).sqrt()
}
