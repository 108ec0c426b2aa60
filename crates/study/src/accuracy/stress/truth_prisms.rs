//! Truth among footprints, from the definition and their rings alone: every crossing of the link
//! with every edge, and the even-odd rule on both sides of the link in between.
//!
//! The link runs from the UAV at t = 0 to the receiver at t = 1. Between two neighboring values of
//! t at which it meets an edge or a corner, nothing around it changes. In the middle of such an
//! interval each footprint is tested on the left and on the right of the link. Both tests differ
//! only where the link runs along a wall.
//!
//! The height of a side is that of its highest roof. The interval is inside the solid up to the
//! lower of both heights. So a wall with nothing behind it blocks nothing, and one that two
//! buildings share blocks up to the lower roof. The lowest point of the ray is the lower end of the
//! interval, so one comparison decides it.
//!
//! A side is inside a footprint if a ray from the middle m, at a right angle to the link, crosses
//! an odd number of edges. Edges through m run along the link, and are behind the start of a ray
//! that begins just beside it. A corner exactly on the ray counts as behind it, alike for both of
//! its edges.
//!
//! Numbers: all positions are within 2^20 steps of each other (1024 m), and t is a fraction of
//! terms up to 2^41. The middle has a denominator up to 2^83 and coordinates up to 2^103 over it.
//! The cross product of these with an edge is below 2^125, inside i128. On a curved earth links are
//! at most 2^16 steps long, and p is below 2^24: products are below 2^116.

use super::scene::StressPrism;
use crate::quantity::LatticePoint;

/// Largest distance of positions along an axis \[1/1024 m\].
pub(super) const MOST_STEPS: i64 = 1 << 20;

/// Vector or position in the plane.
type Plane = [i128; 2];

/// Fraction with a positive denominator.
type Fraction = (i128, i128);

/// Returns `true` if a link is LoS. The earth falls away by d²/p at d steps if `earth` is p.
pub(super) fn prisms_truth(
    prisms: &[StressPrism],
    earth: Option<i64>,
    uav: LatticePoint,
    receiver: LatticePoint,
) -> bool {
    let [u, r] = [uav, receiver].map(|p| [i128::from(p.x), i128::from(p.y)]);
    let (low, climb) = (i128::from(uav.z), i128::from(receiver.z - uav.z));
    if u == r {
        return climb == 0 || height_at(prisms, u).is_none_or(|top| low.min(low + climb) >= i128::from(top));
    }
    if let Some(p) = earth {
        let squared = [0, 1].map(|k| (r[k] - u[k]) * (r[k] - u[k])).into_iter().sum::<i128>();
        let sag = Sag { squared, p: i128::from(p), climb };
        // The ground blocks, too.
        return intervals(prisms, u, r).all(|of| sag.is_clear(low - i128::from(of.height.unwrap_or(0).max(0)), &of));
    }
    intervals(prisms, u, r).all(|interval| {
        let Some(top) = interval.height else { return true };
        let (n, d) = if climb < 0 { interval.to } else { interval.from };
        i128::from(top) * d <= low * d + climb * n
    })
}

/// Link that sags by b t(1 − t) with b = squared/p, and climbs.
struct Sag {
    squared: i128,
    p: i128,
    climb: i128,
}

impl Sag {
    /// Returns `true` if a link that begins `above` a roof is nowhere below it on an interval. It
    /// checks both ends, and the lowest place t* = (b − climb)/2b if that is in between.
    fn is_clear(&self, above: i128, interval: &Interval) -> bool {
        let Sag { squared, p, climb } = *self;
        let is_above = |(n, d): Fraction| (above * d + climb * n) * d * p >= squared * n * (d - n);
        let fall = squared - climb * p;
        let (from, to) = (interval.from, interval.to);
        let turns = fall * from.1 > 2 * squared * from.0 && fall * to.1 < 2 * squared * to.0;
        is_above(from) && is_above(to) && (!turns || 4 * squared * p * above >= fall * fall)
    }
}

/// Returns the height up to which the vertical line at a position is inside the solid; `None` if it
/// is not. Sectors around the position lie between the edges that meet there. Two sectors begin
/// just beside each edge.
fn height_at(prisms: &[StressPrism], p: Plane) -> Option<i32> {
    let through = edges(prisms).filter(|(a, b)| is_on(p, *a, *b));
    let mut towards: Vec<Plane> = through.flat_map(|(a, b)| [a, b]).filter(|q| *q != p).collect();
    if towards.is_empty() {
        towards.push([p[0] + 1, p[1]]);
    }
    // Nothing is lower than `None`.
    towards.into_iter().map(|q| intervals(prisms, p, q).next().and_then(|first| first.height)).min().flatten()
}

/// Part of a link along which nothing around it changes.
struct Interval {
    from: Fraction,
    to: Fraction,
    /// Height up to which it is inside the solid, if any.
    height: Option<i32>,
}

fn intervals(prisms: &[StressPrism], u: Plane, r: Plane) -> impl Iterator<Item = Interval> {
    let d = [r[0] - u[0], r[1] - u[1]];
    let mut at: Vec<Fraction> = vec![(0, 1), (1, 1)];
    at.extend(edges(prisms).flat_map(|(a, b)| meetings(u, d, a, b)).filter(|(n, d)| *n > 0 && n < d));
    at.sort_unstable_by(|a, b| (a.0 * b.1).cmp(&(b.0 * a.1)));
    at.dedup_by(|a, b| a.0 * b.1 == b.0 * a.1);
    let between =
        |k: usize| Interval { from: at[k], to: at[k + 1], height: height_of(prisms, u, d, [at[k], at[k + 1]]) };
    let all: Vec<Interval> = (0..at.len() - 1).map(between).collect();
    all.into_iter()
}

/// Returns each t at which a link meets an edge; those of both ends if the edge is on its line.
fn meetings(u: Plane, d: Plane, a: Plane, b: Plane) -> Vec<Fraction> {
    let (edge, to_a) = ([b[0] - a[0], b[1] - a[1]], [a[0] - u[0], a[1] - u[1]]);
    let (turn, along) = (cross(d, edge), cross(to_a, d));
    if turn != 0 {
        let sign = turn.signum();
        let (n, s, whole) = (cross(to_a, edge) * sign, along * sign, turn * sign);
        return if (0..=whole).contains(&s) { vec![(n, whole)] } else { Vec::new() };
    }
    let to_b = [b[0] - u[0], b[1] - u[1]];
    if along == 0 { vec![(dot(to_a, d), dot(d, d)), (dot(to_b, d), dot(d, d))] } else { Vec::new() }
}

/// Returns the lower of the heights just left and just right of a link between two neighboring
/// meetings; `None` if one side is open.
fn height_of(prisms: &[StressPrism], u: Plane, d: Plane, [from, to]: [Fraction; 2]) -> Option<i32> {
    let (n, scale) = (from.0 * to.1 + to.0 * from.1, 2 * from.1 * to.1);
    let middle = [u[0] * scale + d[0] * n, u[1] * scale + d[1] * n];
    let beside = |normal: Plane| {
        let holding =
            prisms.iter().filter(|p| p.rings.iter().map(|r| crossed(r, middle, scale, normal)).sum::<usize>() % 2 == 1);
        holding.map(|p| p.top).max()
    };
    let (left, right) = (beside([-d[1], d[0]])?, beside([d[1], -d[0]])?);
    Some(left.min(right))
}

/// Counts the edges of a ring that a ray from beside `middle / scale` along `normal` crosses.
fn crossed(ring: &[[i32; 2]], middle: Plane, scale: i128, normal: Plane) -> usize {
    let from_middle = |v: Plane| [v[0] * scale - middle[0], v[1] * scale - middle[1]];
    let is_left = |v: Plane| cross(normal, from_middle(v)) >= 0;
    ring_edges(ring)
        .filter(|(a, b)| {
            let (a_left, b_left) = (is_left(*a), is_left(*b));
            // From right to left ahead of the middle, an edge has it on its left.
            let side = cross([b[0] - a[0], b[1] - a[1]], from_middle(*a).map(|v| -v));
            a_left != b_left && if b_left { side > 0 } else { side < 0 }
        })
        .count()
}

fn edges(prisms: &[StressPrism]) -> impl Iterator<Item = (Plane, Plane)> {
    prisms.iter().flat_map(|p| &p.rings).flat_map(|ring| ring_edges(ring))
}

fn ring_edges(ring: &[[i32; 2]]) -> impl Iterator<Item = (Plane, Plane)> {
    let corner = |k: usize| ring[k % ring.len()].map(i128::from);
    (0..ring.len()).map(move |k| (corner(k), corner(k + 1)))
}

fn is_on(p: Plane, a: Plane, b: Plane) -> bool {
    let (to_a, to_b) = ([a[0] - p[0], a[1] - p[1]], [b[0] - p[0], b[1] - p[1]]);
    cross(to_a, to_b) == 0 && dot(to_a, to_b) <= 0
}

fn cross(a: Plane, b: Plane) -> i128 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: Plane, b: Plane) -> i128 {
    a[0] * b[0] + a[1] * b[1]
}
