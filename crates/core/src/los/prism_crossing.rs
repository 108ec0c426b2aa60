//! Crossings of a link with convex pieces in the plane: an interval of the way, an edge, or
//! nothing.
//!
//! If a piece has vertices on both sides of the link's line, the line crosses its interior in one
//! interval. If the line runs along an edge, the piece covers one side of the ray only.

use super::cell_walk::Crossing;
use super::sag::Sag;
use crate::quantity::LatticePoint;

/// A link as a line from the UAV (parameter 0) to the receiver (parameter 1).
pub(super) struct Ray {
    pub(super) uav: LatticePoint,
    pub(super) receiver: LatticePoint,
    pub(super) dx: i64,
    pub(super) dy: i64,
    /// Rise from the UAV to the receiver.
    pub(super) dz: i64,
    /// The sag over a curved earth; `None` over a flat one.
    pub(super) sag: Option<Sag>,
}

/// An open interval of the ray, clipped to the link; parameters from the UAV.
#[derive(Debug, Clone, Copy)]
pub(super) struct Interval {
    /// The end towards the UAV, at least 0.
    pub(super) far: Crossing,
    /// The end towards the receiver, at most 1.
    pub(super) near: Crossing,
}

/// A piece with an edge along the ray.
pub(super) struct Edge {
    pub(super) piece: usize,
    pub(super) top: i32,
    pub(super) side: Side,
    pub(super) interval: Interval,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
}

pub(super) enum Meeting {
    Nothing,
    Interior(Interval),
    Edge(Side, Interval),
}

impl Ray {
    pub(super) fn new(uav: LatticePoint, receiver: LatticePoint) -> Self {
        Ray { uav, receiver, dx: receiver.x - uav.x, dy: receiver.y - uav.y, dz: receiver.z - uav.z, sag: None }
    }

    /// Returns twice the signed area of the UAV, the receiver and `v`: positive left of the ray.
    #[inline]
    fn side(&self, v: [i32; 2]) -> i64 {
        self.dx * (i64::from(v[1]) - self.uav.y) - self.dy * (i64::from(v[0]) - self.uav.x)
    }

    /// Returns the crossing of a convex counterclockwise ring with the open link.
    #[inline]
    pub(super) fn meet(&self, ring: &[[i32; 2]]) -> Meeting {
        let (mut any_left, mut any_right, mut zeros) = (false, false, 0);
        for &vertex in ring {
            let side = self.side(vertex);
            any_left |= side > 0;
            any_right |= side < 0;
            zeros += i32::from(side == 0);
        }
        if any_left && any_right {
            return self.cross(ring).map_or(Meeting::Nothing, Meeting::Interior);
        }
        if zeros < 2 {
            return Meeting::Nothing;
        }
        let mut ends = ring.iter().filter(|v| self.side(**v) == 0).map(|&v| self.along(v));
        let (Some(a), Some(b)) = (ends.next(), ends.next()) else { return Meeting::Nothing };
        let (first, last) = if a.n <= b.n { (a, b) } else { (b, a) };
        let side = if any_left { Side::Left } else { Side::Right };
        self.clip(first, last).map_or(Meeting::Nothing, |interval| Meeting::Edge(side, interval))
    }

    /// Returns the part of the open link inside a convex counterclockwise ring with vertices on both
    /// sides of the line.
    fn cross(&self, ring: &[[i32; 2]]) -> Option<Interval> {
        let n = ring.len();
        let mut previous = self.side(ring[n - 1]);
        let (mut enters, mut leaves) = (None, None);
        for (k, &vertex) in ring.iter().enumerate() {
            let side = self.side(vertex);
            // Counterclockwise, the boundary passes from right to left where the ray leaves the
            // piece.
            if previous <= 0 && side > 0 {
                leaves = Some((k, previous, side));
            } else if previous >= 0 && side < 0 {
                enters = Some((k, previous, side));
            }
            previous = side;
        }
        let cross = |(k, a, b): (usize, i64, i64)| self.crossing(ring[(k + n - 1) % n], ring[k], a, b);
        self.clip(cross(enters?), cross(leaves?))
    }

    /// Returns the crossing of the line with the edge from `a` to `b`, whose ends are `side_a` and
    /// `side_b` from it.
    #[inline]
    fn crossing(&self, a: [i32; 2], b: [i32; 2], side_a: i64, side_b: i64) -> Crossing {
        let (ex, ey) = (i64::from(b[0]) - i64::from(a[0]), i64::from(b[1]) - i64::from(a[1]));
        let n = (i64::from(a[0]) - self.uav.x) * ey - (i64::from(a[1]) - self.uav.y) * ex;
        let d = side_b - side_a;
        if d > 0 { Crossing { n, d } } else { Crossing { n: -n, d: -d } }
    }

    /// Returns the parameter of a vertex on the line, over the longer component of the link.
    fn along(&self, v: [i32; 2]) -> Crossing {
        let (n, d) = if self.dx.abs() >= self.dy.abs() {
            (i64::from(v[0]) - self.uav.x, self.dx)
        } else {
            (i64::from(v[1]) - self.uav.y, self.dy)
        };
        if d > 0 { Crossing { n, d } } else { Crossing { n: -n, d: -d } }
    }

    /// Returns the part of an interval of the line that lies on the open link, if it has length.
    #[inline]
    fn clip(&self, far: Crossing, near: Crossing) -> Option<Interval> {
        if near.n <= 0 || far.n >= far.d {
            return None;
        }
        let far = if far.n < 0 { Crossing { n: 0, d: 1 } } else { far };
        let near = if near.n > near.d { Crossing { n: 1, d: 1 } } else { near };
        Some(Interval { far, near })
    }
}

/// Returns the pairs of opposite edges along the ray that overlap in an interval with length:
/// shared walls.
pub(super) fn walls_along(edges: &[Edge]) -> impl Iterator<Item = (&Edge, &Edge, Interval)> {
    let less = |a: Crossing, b: Crossing| i128::from(a.n) * i128::from(b.d) < i128::from(b.n) * i128::from(a.d);
    let pairs = edges.iter().enumerate().flat_map(|(i, a)| edges[i + 1..].iter().map(move |b| (a, b)));
    pairs.filter(|(a, b)| a.side != b.side).filter_map(move |(a, b)| {
        let far = if less(a.interval.far, b.interval.far) { b.interval.far } else { a.interval.far };
        let near = if less(a.interval.near, b.interval.near) { a.interval.near } else { b.interval.near };
        less(far, near).then_some((a, b, Interval { far, near }))
    })
}

/// Returns the remaining fraction of the way.
pub(super) fn rest(c: Crossing) -> Crossing {
    Crossing { n: c.d - c.n, d: c.d }
}
