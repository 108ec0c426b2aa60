//! The links from one observer to a leg: a triangle of points that half-spaces cut to half-planes.

use super::half_space::HalfSpace;
use super::place::{LegPart, LegPlace};
use super::region::HalfPlane;
use crate::quantity::LatticePoint;

/// The part of a leg that is looked at, with ends at fractions `from` and `to` of its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LegWindow {
    from: (i64, i64),
    to: (i64, i64),
}

impl LegWindow {
    /// The whole leg.
    pub const WHOLE: LegWindow = LegWindow { from: (0, 1), to: (1, 1) };

    /// Returns the window between two fractions, each as numerator and denominator.
    ///
    /// # Panics
    /// Unless `0 ≤ from < to ≤ 1`, with terms from 0 to 2^40.
    pub fn new(from: (i64, i64), to: (i64, i64)) -> LegWindow {
        let is_fraction = |(n, d): (i64, i64)| 0 <= n && n <= d && 0 < d && d <= 1 << 40;
        let is_before = i128::from(from.0) * i128::from(to.1) < i128::from(to.0) * i128::from(from.1);
        assert!(is_fraction(from) && is_fraction(to) && is_before, "a window is a part of a leg with length");
        LegWindow { from, to }
    }

    /// Returns the window as a part of the leg.
    pub fn part(&self) -> LegPart {
        let place = |(n, d): (i64, i64)| LegPlace::new(i128::from(n), i128::from(d));
        LegPart { from: place(self.from), to: place(self.to) }
    }
}

/// A leg on the lattice of one solid, seen from an observer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Links {
    pub(super) observer: LatticePoint,
    pub(super) start: LatticePoint,
    pub(super) end: LatticePoint,
    /// From the observer to the start of the leg.
    pub(super) to_start: [i64; 3],
    /// From the start of the leg to its end.
    pub(super) along: [i64; 3],
    pub(super) window: LegWindow,
}

/// The shape of the links in the plane.
pub(super) enum Shape {
    /// A triangle.
    Spread,
    /// Part of one line: the links are in one vertical plane.
    Upright,
    /// A point: all links are vertical.
    Plumb,
}

impl Links {
    pub(super) fn new(observer: LatticePoint, [start, end]: [LatticePoint; 2], window: LegWindow) -> Links {
        let difference = |a: LatticePoint, b: LatticePoint| [b.x - a.x, b.y - a.y, b.z - a.z];
        let (to_start, along) = (difference(observer, start), difference(start, end));
        Links { observer, start, end, to_start, along, window }
    }

    /// Returns the shape of the links in the plane.
    pub(super) fn shape(&self) -> Shape {
        let (a, b) = (self.to_start, self.along);
        if [a[0], a[1], b[0], b[1]] == [0; 4] {
            Shape::Plumb
        } else if a[0] * b[1] == a[1] * b[0] {
            Shape::Upright
        } else {
            Shape::Spread
        }
    }

    /// Returns the lowest height of the links.
    pub(super) fn lowest(&self) -> i64 {
        self.observer.z.min(self.start.z).min(self.end.z)
    }

    /// Returns the half-plane of (u, v) in which the links are inside a half-space.
    pub(super) fn half_plane(&self, space: &HalfSpace) -> HalfPlane {
        HalfPlane::new([space.change(self.to_start), space.change(self.along), space.value(self.observer)])
    }

    /// Returns the sides of all links to the window, counterclockwise in (u, v).
    pub(super) fn triangle(&self) -> [HalfPlane; 3] {
        let LegWindow { from, to } = self.window;
        let line = |exact: [i64; 3]| HalfPlane::new(exact.map(i128::from));
        [line([-from.0, from.1, 0]), line([-1, 0, 1]), line([to.0, -to.1, 0])]
    }

    /// Returns the part of the leg inside all of some half-spaces. Those whose border contains the
    /// leg count as closed.
    pub(super) fn part_inside(&self, spaces: impl IntoIterator<Item = HalfSpace>) -> Option<LegPart> {
        spaces.into_iter().try_fold(self.window.part(), |part, space| {
            match (space.value(self.start), space.change(self.along)) {
                (0, 0) => Some(part),
                (at_start, rate) => part.where_above_zero(at_start, rate),
            }
        })
    }

    /// Returns the part of the leg strictly below a top.
    pub(super) fn part_below(&self, part: LegPart, top: &HalfSpace) -> Option<LegPart> {
        part.where_above_zero(top.value(self.start), top.change(self.along))
    }

    /// Returns the ends in the plane of the line that holds all links, for upright ones.
    pub(super) fn ends_in_plane(&self) -> [LatticePoint; 2] {
        let direction = if self.to_start[..2] == [0, 0] { self.along } else { self.to_start };
        let advance =
            |p: &LatticePoint| i128::from(p.x) * i128::from(direction[0]) + i128::from(p.y) * i128::from(direction[1]);
        let mut points = [self.observer, self.start, self.end];
        points.sort_by_key(advance);
        [points[0], points[2]]
    }
}
