//! The links to a leg in the plane, in doubles: rules out most obstacles before any exact test.
//!
//! For a place c of the plane, `D·u = (c − o) × (b − a)` and `D·v = (a − o) × (c − o)`, where D is
//! the cross product of `a − o` and `b − a`, made positive. Along the boundary of a convex ring u, v
//! and v/u are extreme at corners, and so is the height of the links, which is linear in the plane.
//! Every bound is moved outward by more than its rounding errors.

use super::links::Links;

/// Relative error of a cross product of exact differences, over the sum of its absolute products.
const ROUNDING: f64 = 1e-15;

/// Links to a leg whose plan is a triangle.
#[derive(Debug)]
pub(super) struct Plan {
    observer: [i64; 2],
    to_start: [f64; 3],
    along: [f64; 3],
    /// D, and the sign that made it positive.
    area: f64,
    sign: f64,
    /// Ends of the window, moved outward.
    window: [f64; 2],
    observer_z: f64,
    lowest: f64,
    /// Corners of the triangle in the plane.
    corners: [[f64; 2]; 3],
}

/// Bounds on the links over a convex ring.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    /// Bounds on the places of the leg to which they lead.
    pub(super) from: f64,
    pub(super) to: f64,
    /// Lower bound on their height.
    pub(super) lowest: f64,
    /// `false` if no receiver is over the ring.
    pub(super) holds_receivers: bool,
    /// Lower bound on D·u.
    nearest: f64,
}

impl Plan {
    #[expect(clippy::cast_precision_loss, reason = "differences below 2^28; places in the plane are bounds")]
    pub(super) fn new(links: &Links) -> Plan {
        let (to_start, along) = (links.to_start.map(|v| v as f64), links.along.map(|v| v as f64));
        let cross = i128::from(links.to_start[0]) * i128::from(links.along[1])
            - i128::from(links.to_start[1]) * i128::from(links.along[0]);
        let window = links.window.part();
        let (from, to) = (window.from.fraction(), window.to.fraction());
        let at = |s: f64| [links.start.x as f64 + s * along[0], links.start.y as f64 + s * along[1]];
        Plan {
            observer: [links.observer.x, links.observer.y],
            to_start,
            along,
            area: cross.unsigned_abs() as f64,
            sign: if cross < 0 { -1.0 } else { 1.0 },
            window: [from - ROUNDING, to + ROUNDING],
            observer_z: links.observer.z as f64,
            lowest: links.lowest() as f64,
            corners: [[links.observer.x as f64, links.observer.y as f64], at(from), at(to)],
        }
    }

    /// Returns the range of x of the triangle between two values of y, with a margin of a step.
    pub(super) fn x_range(&self, south: f64, north: f64) -> Option<[f64; 2]> {
        let (mut west, mut east) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..3 {
            let (mut p, mut q) = (self.corners[k], self.corners[(k + 1) % 3]);
            if p[1] > q[1] {
                (p, q) = (q, p);
            }
            if q[1] < south - 1.0 || p[1] > north + 1.0 {
                continue;
            }
            let x_at = |y: f64| if q[1] > p[1] { p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0]) } else { p[0] };
            for x in [x_at((south - 1.0).max(p[1])), x_at((north + 1.0).min(q[1]))] {
                (west, east) = (west.min(x), east.max(x));
            }
            if q[1] <= p[1] {
                (west, east) = (west.min(q[0]), east.max(q[0]));
            }
        }
        (west <= east).then_some([west - 1.0, east + 1.0])
    }

    /// Returns the range of y of the triangle, with a margin of a step.
    pub(super) fn y_range(&self) -> [f64; 2] {
        let ys = self.corners.map(|corner| corner[1]);
        [ys[0].min(ys[1]).min(ys[2]) - 1.0, ys[0].max(ys[1]).max(ys[2]) + 1.0]
    }

    /// Returns bounds on the links over a convex ring, given its corners; `None` if there is none.
    pub(super) fn span(&self, ring: impl Iterator<Item = [i64; 2]>) -> Option<Span> {
        let ([ax, ay, az], [bx, by, bz]) = (self.to_start, self.along);
        // Over each corner D·u and D·v; how far it is right of the first side and left of the last.
        let (mut nearest, mut farthest) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut after, mut before, mut low) = (f64::NEG_INFINITY, f64::NEG_INFINITY, f64::INFINITY);
        let (mut from, mut to, mut reach) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
        for [x, y] in ring {
            #[expect(clippy::cast_precision_loss, reason = "a difference below 2^29")]
            let (x, y) = ((x - self.observer[0]) as f64, (y - self.observer[1]) as f64);
            let (u, v) = (self.sign * (x * by - y * bx), self.sign * (ax * y - ay * x));
            (nearest, farthest) = (nearest.min(u), farthest.max(u));
            after = after.max(v - self.window[0] * u);
            before = before.max(self.window[1] * u - v);
            low = low.min(u * az + v * bz);
            let place = v / u;
            (from, to) = (from.min(place), to.max(place));
            reach = reach.max(x.abs()).max(y.abs());
        }
        let (error_u, error_v) = (ROUNDING * reach * (bx.abs() + by.abs()), ROUNDING * reach * (ax.abs() + ay.abs()));
        let error = 4.0 * (error_u + error_v);
        if farthest < -error_u || nearest > self.area * (1.0 + ROUNDING) + error_u || after < -error || before < -error
        {
            return None;
        }
        let error_z = (error_u * az.abs() + error_v * bz.abs()) * 4.0 / self.area;
        let lowest = (self.observer_z + low / self.area - error_z - 1.0).max(self.lowest);
        let holds_receivers = farthest >= self.area * (1.0 - ROUNDING) - error_u;
        let nearest = nearest - error_u;
        if nearest <= error_u {
            return Some(Span { from: self.window[0], to: self.window[1], lowest, holds_receivers, nearest: 0.0 });
        }
        let doubt = |place: f64| 2.0 * (error_v + place.abs() * error_u) / nearest + 4.0 * ROUNDING * place.abs();
        let (from, to) = ((from - doubt(from)).max(self.window[0]), (to + doubt(to)).min(self.window[1]));
        Some(Span { from, to, lowest, holds_receivers, nearest })
    }

    /// Returns the longest part of the leg that a cell of this size can hide, within a span.
    pub(super) fn longest_of_cell(&self, span: &Span, [width, height]: [f64; 2]) -> f64 {
        let ([ax, ay, _], [bx, by, _]) = (self.to_start, self.along);
        // v/u changes by (a + s·b − o) × dc / (D·u) along dc.
        let across = |s: f64| width * (ay + s * by).abs() + height * (ax + s * bx).abs();
        if span.nearest > 0.0 { 1.01 * across(span.from).max(across(span.to)) / span.nearest } else { f64::INFINITY }
    }
}
