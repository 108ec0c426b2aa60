//! The convex region of links to a leg that a solid hides, clipped in exact signs.
//!
//! A point of the links is `p(u, v) = o + u(a − o) + v(b − a)` with `0 < u < 1` and `0 < v < u`; the
//! link to the place s of the leg is the line `v = s·u`. Each half-space that bounds a solid is a
//! half-plane of (u, v). So a convex solid hides one open interval of s, and its ends are v/u at
//! corners of the clipped region.
//!
//! The region is the cyclic list of its sides as they were given, counterclockwise. A corner is the
//! intersection of two neighbors, never rounded: a half-plane is tested against it by a determinant
//! of three sides. The region stays open and of positive area if and only if a corner is strictly
//! inside the half-plane.
//!
//! Sizes: walls have coefficients up to 2^56, sloped roofs up to 2^77, windows up to 2^40. At most
//! two sides are roofs, so a determinant is below 2^213.

use ethnum::I256;

use super::place::{LegPart, LegPlace};

/// An open half-plane: the points with `a·u + b·v + c > 0`.
#[derive(Debug, Clone, Copy)]
pub(super) struct HalfPlane {
    exact: [i128; 3],
    near: [f64; 3],
}

impl HalfPlane {
    pub(super) fn new(exact: [i128; 3]) -> HalfPlane {
        HalfPlane { exact, near: exact.map(near) }
    }

    /// Returns `true` if the form is 0 everywhere: the plane of the links contains the wall.
    pub(super) fn is_zero(&self) -> bool {
        self.exact == [0; 3]
    }
}

/// Converts a coefficient, rounded by at most 2^-53 of it.
#[expect(clippy::cast_precision_loss, reason = "an approximation; its error is bounded where it is used")]
fn near(v: i128) -> f64 {
    // PERF: most coefficients have 64 bits, which are converted in one instruction.
    i64::try_from(v).map_or(v as f64, |v| v as f64)
}

/// A side of the region, and the corner at which it ends, as (U, V, W) with u = U/W and v = V/W.
/// W is above 0.
#[derive(Debug, Clone, Copy)]
struct Side {
    line: HalfPlane,
    end: [f64; 3],
    /// Bounds on the errors of `end`.
    error: [f64; 3],
}

/// Relative error of a sum of products of rounded factors: fewer than eight roundings.
const ROUNDING: f64 = 1e-15;

impl Side {
    /// Makes a side that ends where the next one begins.
    fn new(line: HalfPlane, next: &HalfPlane) -> Side {
        let (a, b) = (&line.near, &next.near);
        let (mut end, mut error) = ([0.0; 3], [0.0; 3]);
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let (p, q) = (a[i] * b[j], a[j] * b[i]);
            (end[k], error[k]) = (p - q, ROUNDING * (p.abs() + q.abs()));
        }
        Side { line, end, error }
    }
}

/// Returns the corner between two sides exactly.
fn corner(a: &HalfPlane, b: &HalfPlane) -> [I256; 3] {
    let (a, b) = (a.exact.map(I256::from), b.exact.map(I256::from));
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// An open convex region of (u, v), not empty.
#[derive(Debug, Default)]
pub(super) struct Region {
    sides: Vec<Side>,
    clipped: Vec<Side>,
    is_inside: Vec<bool>,
}

impl Region {
    /// Starts anew with a triangle, given by its sides counterclockwise.
    pub(super) fn restart(&mut self, triangle: &[HalfPlane; 3]) {
        self.sides.clear();
        self.sides.extend((0..3).map(|k| Side::new(triangle[k], &triangle[(k + 1) % 3])));
    }

    /// Keeps what is inside a half-plane; returns `false` if nothing is.
    pub(super) fn keep(&mut self, line: &HalfPlane) -> bool {
        let n = self.sides.len();
        self.is_inside.clear();
        self.is_inside.extend((0..n).map(|k| is_strictly_inside(line, &self.sides[k], &self.sides[(k + 1) % n].line)));
        let inside = self.is_inside.iter().filter(|&&is| is).count();
        if inside == 0 || inside == n {
            return inside == n;
        }
        // The corners inside follow one another, since the region is convex.
        let Some(first) = (0..n).find(|&k| self.is_inside[k] && !self.is_inside[(k + n - 1) % n]) else { return false };
        self.clipped.clear();
        self.clipped.extend((first..first + inside).map(|k| self.sides[k % n]));
        self.clipped.push(Side::new(self.sides[(first + inside) % n].line, line));
        self.clipped.push(Side::new(*line, &self.sides[first].line));
        std::mem::swap(&mut self.sides, &mut self.clipped);
        true
    }

    /// Returns the part of the leg to which the links in the region lead.
    pub(super) fn part(&self) -> Option<LegPart> {
        let mut ends: Option<(Direction, Direction)> = None;
        for k in 0..self.sides.len() {
            let Some(seen) = Direction::of(&self.sides[k], &self.sides[(k + 1) % self.sides.len()].line) else {
                continue;
            };
            ends = Some(match ends {
                None => (seen, seen),
                Some((low, high)) => {
                    (if seen.is_before(&low) { seen } else { low }, if high.is_before(&seen) { seen } else { high })
                }
            });
        }
        let (low, high) = ends?;
        Some(LegPart { from: low.place(), to: high.place() })
    }
}

/// Returns `true` if the end of a side is strictly inside a half-plane. Exact.
fn is_strictly_inside(line: &HalfPlane, side: &Side, next: &HalfPlane) -> bool {
    let (mut value, mut doubt) = (0.0, 0.0);
    for k in 0..3 {
        let product = line.near[k] * side.end[k];
        value += product;
        doubt += ROUNDING * product.abs() + line.near[k].abs() * side.error[k];
    }
    // The bound itself is rounded, by far less than a hundredth.
    if value.abs() > 1.01 * doubt {
        return value > 0.0;
    }
    let at = corner(&side.line, next);
    let product = |k: usize| I256::from(line.exact[k]) * at[k];
    product(0) + product(1) + product(2) > I256::ZERO
}

/// The place of the leg to which the link through a corner leads.
#[derive(Clone, Copy)]
struct Direction<'a> {
    sides: (&'a HalfPlane, &'a HalfPlane),
    near: f64,
    error: f64,
}

impl<'a> Direction<'a> {
    /// Returns the direction of the end of a side; `None` at the observer.
    fn of(side: &'a Side, next: &'a HalfPlane) -> Option<Direction<'a>> {
        let sides = (&side.line, next);
        let [u, v, _] = side.end;
        if u > 1.01 * side.error[0] {
            let near = v / u;
            let error = (side.error[1] + near.abs() * side.error[0]) / (u - side.error[0]) + ROUNDING * near.abs();
            return Some(Direction { sides, near, error: 1.01 * error });
        }
        let [u, ..] = corner(sides.0, sides.1);
        (u > I256::ZERO).then_some(Direction { sides, near: 0.0, error: f64::INFINITY })
    }

    fn place(&self) -> LegPlace {
        let [u, v, _] = corner(self.sides.0, self.sides.1);
        LegPlace::of_terms(v, u)
    }

    fn is_before(&self, other: &Direction) -> bool {
        if (self.near - other.near).abs() > self.error + other.error {
            return self.near < other.near;
        }
        self.place() < other.place()
    }
}
