//! The referee: line of sight in exact integer and rational arithmetic, slow and obvious.
//!
//! It shares no code with the engines that it judges, and it knows no rounding: every input is an integer on the
//! lattice (1024 units to the meter, horizontally to the cell in a raster), every decision is the sign of an integer.
//!
//! # What is decided
//!
//! B is the closed union of all prisms, T the closed union of all columns. A link is LoS iff the *open* segment
//! between its ends does not meet the *interior* of the union. (B and T are two solids. A scene that has both is LoS
//! iff both say so.) Each solid reaches from far below up to a flat top, so the union is what lies under a stepped
//! surface, and a point (p, z) is in its interior iff
//!
//! ```text
//! z < h_low(p),    h_low(p) = lim inf of h(q) as q -> p,    h(q) = the highest top of the closed solids over q,
//!                                                           or minus infinity where there is none.
//! ```
//!
//! Taking the lower limit is what joins and separates solids. On a wall that two solids share, both sides are solid
//! and h_low is the lower roof. On a wall with nothing behind it, and at the point where two cells touch corner to
//! corner, some way of approaching p is open, and h_low is what lies there. As h is never lower on a border than
//! beside it, h_low(p) is the least of the heights of the regions that meet at p: one region away from all borders,
//! two on a wall, several at a vertex.
//!
//! # How
//!
//! 1. Walk along the link's shadow on the plane, with t = 0 at the UAV and t = 1 at the receiver. Collect every t
//!    at which it crosses or touches an edge or a vertex of a footprint, or a grid line (the *breakpoints*), add 0 and
//!    1, and sort. The interior is open, so if the link meets it at all it meets it on a whole interval of t:
//!    breakpoints themselves need no look, only the open *stretches* between neighboring ones.
//! 2. Within a stretch the regions on the left and on the right of the link never change. A stretch may run along a
//!    wall, where left and right differ, or through open space or a solid, where they agree. Both sides are always
//!    looked up, at one point inside the stretch, and the lower of the two is h_low there. The point is
//!    the mediant (a + c) / (b + d) of the ends a/b and c/d: it lies strictly between them and has small terms.
//! 3. The ray's height is linear in t, so on the open stretch it comes as close as one likes to the lower of its
//!    values at the two ends, and never below. The stretch blocks iff that lower value is less than h_low.
//!    Equality is a touch, and a touch is LoS.
//!
//! A vertical link has a single point for a shadow, and one stretch from 0 to 1. There h_low is the least over all
//! the sectors into which the edges that meet at this point cut its surroundings. A link whose ends coincide has no
//! open segment, and is LoS.
//!
//! # Which side is solid
//!
//! A prism is closed over the even-odd interior of its rings, so only parity next to a point matters. To ask whether
//! the region next to p in direction d belongs to a prism, take the ray from p + εd in direction d, for an ε too
//! small to matter, and count the edges it crosses. Edges through p do not count: none runs along d (the callers see
//! to that), so they stay behind the ray's origin. An edge whose end is exactly on the ray counts as if that
//! end were a little to the left, the same for both edges at the vertex. Hence rings of either winding, holes,
//! rings that touch or cross themselves, walls walked twice, and overlapping prisms need no special treatment.
//!
//! # Least heights
//!
//! For fixed horizontal positions, each end of each stretch asks for one thing: that the ray be no lower than H at t.
//! With the UAV at z_u that is `z_u + t (z - z_u) >= H`, so z must reach `z_u + (H - z_u) / t`; and at t = 0 no z
//! helps if z_u < H. The ceiling is the highest of these demands.
//!
//! # Numbers
//!
//! Positions on the link are fractions with integer terms and a positive denominator, points are homogeneous
//! `(x, y) / w`, and comparisons are made by cross-multiplying. The integers start as `i128` and turn into big integers
//! when an operation would overflow, so the result is exact for every `i64` input.

mod curved;
mod int;
mod sloped;

use num_bigint::BigInt;
use num_rational::Ratio;
use std::cmp::Ordering;

use int::Int;

pub(crate) use curved::{Earth, prisms_los_on_earth};
pub(crate) use sloped::{Sloped, sloped_los};

/// A point in lattice units: x east, y north, z up [1/1024 m, horizontally 1/1024 cell in a raster].
pub(crate) type P3 = [i64; 3];

/// Lattice units to the cell.
const CELL: i128 = 1024;

/// A raster of columns, each solid from far below up to its height.
#[derive(Clone, Debug)]
pub(crate) struct Columns {
    /// Cells in a row, west to east.
    pub(crate) n_cols: usize,
    /// Rows, north to south.
    pub(crate) n_rows: usize,
    /// Tops [1/1024 m], row-major, the northern row first. `None` is nodata and blocks nothing.
    ///
    /// Cell (row, col) is the closed square
    /// `[col, col + 1] × [n_rows - 1 - row, n_rows - row]`, times 1024.
    pub(crate) heights: Vec<Option<i64>>,
}

/// A prism over one polygon, solid from far below up to a flat top.
#[derive(Clone, Debug)]
pub(crate) struct Prism {
    /// Shell and holes in any order and winding, first vertex not repeated at the end [1/1024 m].
    ///
    /// The footprint is the closure of the even-odd interior of all rings together.
    pub(crate) rings: Vec<Vec<[i64; 2]>>,
    /// Top [1/1024 m].
    pub(crate) top: i64,
}

/// The least height of one end that makes a link LoS, while everything else stays as it is. Lower ones come first.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Ceiling {
    /// LoS at every height: minus infinity.
    Clear,
    /// LoS at this height and above, NLoS below [1/1024 m].
    At(Ratio<BigInt>),
    /// NLoS at every height: plus infinity.
    Never,
}

/// Decides whether the link is LoS in the raster.
///
/// Every cell whose closed square contains the receiver's (x, y) is removed for this link, before the union is taken.
/// The UAV's own cell blocks like any other. Nothing lies outside the raster.
pub(crate) fn columns_los(columns: &Columns, uav: P3, receiver: P3) -> bool {
    is_los(&column_stretches(columns, plan(uav), plan(receiver)), uav[2], receiver[2])
}

/// Decides whether the link is LoS among the prisms, none of which is exempt.
pub(crate) fn prisms_los(prisms: &[Prism], uav: P3, receiver: P3) -> bool {
    uav == receiver || is_los(&prism_stretches(prisms, plan(uav), plan(receiver)), uav[2], receiver[2])
}

/// Returns the least receiver height at `receiver` (x, y) that makes the link LoS in the raster.
pub(crate) fn columns_ceiling(columns: &Columns, uav: P3, receiver: [i64; 2]) -> Ceiling {
    least_height(&column_stretches(columns, plan(uav), receiver), uav[2])
}

/// Returns the least receiver height at `receiver` (x, y) that makes the link LoS among the prisms.
///
/// The ends are taken as distinct: straight above or below the UAV, the one height at which the link has no length, and
/// so is LoS whatever surrounds it, is not treated apart.
pub(crate) fn prisms_ceiling(prisms: &[Prism], uav: P3, receiver: [i64; 2]) -> Ceiling {
    least_height(&prism_stretches(prisms, plan(uav), receiver), uav[2])
}

/// Returns the least UAV height at `uav` (x, y) that makes the link LoS in the raster, own cells of the receiver
/// exempt. Whether the UAV could be there (above its own cell) is not asked.
pub(crate) fn columns_least_uav_height(columns: &Columns, uav: [i64; 2], receiver: P3) -> Ceiling {
    least_height(&reversed(column_stretches(columns, uav, plan(receiver))), receiver[2])
}

/// Returns the least UAV height at `uav` (x, y) that makes the link LoS among the prisms.
pub(crate) fn prisms_least_uav_height(prisms: &[Prism], uav: [i64; 2], receiver: P3) -> Ceiling {
    least_height(&reversed(prism_stretches(prisms, uav, plan(receiver))), receiver[2])
}

/// Says whether the point (p, z) is in the interior of the closed union of the prisms.
pub(crate) fn prisms_cover(prisms: &[Prism], p: [i64; 2], z: i64) -> bool {
    height_around(prisms, p).is_some_and(|height| z < height)
}

// ---------------------------------------------------------------------------------------------------------------------
// The two decisions, given the stretches.

/// A part of a link in which nothing changes: the open interval of t between two neighboring breakpoints.
struct Stretch {
    from: Fraction,
    to: Fraction,
    /// h_low [1/1024 m], `None` where one side is open down to any depth.
    height: Option<i64>,
}

/// No stretch has the ray's lower end below h_low.
fn is_los(stretches: &[Stretch], z_uav: i64, z_receiver: i64) -> bool {
    let (z_uav, rise) = (Int::from(z_uav), &Int::from(z_receiver) - &Int::from(z_uav));
    stretches.iter().all(|stretch| {
        let Some(height) = stretch.height else { return true };
        // z_uav + t rise >= height, multiplied by the denominator of t.
        let room = &Int::from(height) - &z_uav;
        [&stretch.from, &stretch.to].into_iter().all(|t| (&t.num * &rise).cmp(&(&room * &t.den)).is_ge())
    })
}

/// The highest demand on the far end's height, t counted from the end that stays at `z`.
fn least_height(stretches: &[Stretch], z: i64) -> Ceiling {
    let mut least = Ceiling::Clear;
    for stretch in stretches {
        let Some(height) = stretch.height else { continue };
        let rise = &Int::from(height) - &Int::from(z);
        for t in [&stretch.from, &stretch.to] {
            least = least.max(match t.num.sign() {
                Ordering::Equal if z < height => Ceiling::Never,
                Ordering::Equal => Ceiling::Clear,
                _ => Ceiling::At(Ratio::from(BigInt::from(z)) + Ratio::new((&rise * &t.den).to_big(), t.num.to_big())),
            });
        }
    }
    least
}

/// Stretches of a link with t counted from the other end.
fn reversed(stretches: Vec<Stretch>) -> Vec<Stretch> {
    let turn = |t: Fraction| Fraction { num: &t.den - &t.num, den: t.den };
    stretches.into_iter().map(|s| Stretch { from: turn(s.to), to: turn(s.from), height: s.height }).collect()
}

// ---------------------------------------------------------------------------------------------------------------------
// Columns.

fn column_stretches(columns: &Columns, uav: [i64; 2], receiver: [i64; 2]) -> Vec<Stretch> {
    assert_eq!(columns.heights.len(), columns.n_cols * columns.n_rows, "one height per cell");
    let (start, along) = (wide(uav), difference(uav, receiver));
    // A cell of the raster as ranges of x and y, both ends included.
    let spans = |row: usize, col: usize| {
        let (west, south) = (col as i128 * CELL, (columns.n_rows - 1 - row) as i128 * CELL);
        [[west, west + CELL], [south, south + CELL]]
    };
    let contains_receiver = |row: usize, col: usize| {
        let spans = spans(row, col);
        (0..2).all(|axis| spans[axis][0] <= i128::from(receiver[axis]) && i128::from(receiver[axis]) <= spans[axis][1])
    };
    // The height beside `spot` on the side of `toward`. Where a coordinate is on the cell's border, the side decides.
    let beside = |spot: &Spot, toward: Direction| -> Option<i64> {
        let is_within = |axis: usize, [low, high]: [i128; 2]| {
            let above_low = spot.at[axis].cmp(&(&Int::Small(low) * &spot.w));
            let below_high = (&Int::Small(high) * &spot.w).cmp(&spot.at[axis]);
            above_low.is_ge()
                && below_high.is_ge()
                && (above_low.is_gt() || toward[axis] > 0)
                && (below_high.is_gt() || toward[axis] < 0)
        };
        let col = (0..columns.n_cols).find(|&col| is_within(0, spans(0, col)[0]))?;
        let row = (0..columns.n_rows).find(|&row| is_within(1, spans(row, 0)[1]))?;
        if contains_receiver(row, col) { None } else { columns.heights[row * columns.n_cols + col] }
    };

    if along == [0, 0] {
        // All cells around a vertical link contain the receiver's (x, y): all are exempt.
        return vec![Stretch { from: Fraction::whole(0), to: Fraction::whole(1), height: None }];
    }
    let mut breakpoints = Vec::new();
    for (axis, n_cells) in [(0, columns.n_cols), (1, columns.n_rows)] {
        if along[axis] != 0 {
            for line in 0..=n_cells {
                let num = line as i128 * CELL - start[axis];
                breakpoints.push(Fraction::new(Int::Small(num), Int::Small(along[axis])));
            }
        }
    }
    stretches_between(breakpoints, |t| {
        let spot = Spot::on_link(start, along, t);
        sides(along).into_iter().map(|side| beside(&spot, side)).min().flatten()
    })
}

// ---------------------------------------------------------------------------------------------------------------------
// Prisms.

fn prism_stretches(prisms: &[Prism], uav: [i64; 2], receiver: [i64; 2]) -> Vec<Stretch> {
    let (start, along) = (wide(uav), difference(uav, receiver));
    if along == [0, 0] {
        return vec![Stretch { from: Fraction::whole(0), to: Fraction::whole(1), height: height_around(prisms, uav) }];
    }
    let along_int = along.map(Int::Small);
    let mut breakpoints = Vec::new();
    for [a, b] in prisms.iter().flat_map(edges) {
        let (edge, to_a, to_b) = (difference(a, b).map(Int::Small), difference(uav, a), difference(uav, b));
        let (to_a, to_b) = (to_a.map(Int::Small), to_b.map(Int::Small));
        let (side_a, side_b) = (cross(&along_int, &to_a).sign(), cross(&along_int, &to_b).sign());
        if side_a == Ordering::Equal && side_b == Ordering::Equal {
            // The edge lies on the link's line: its ends are touched.
            for to_end in [to_a, to_b] {
                breakpoints.push(Fraction::new(dot(&along_int, &to_end), dot(&along_int, &along_int)));
            }
        } else if side_a != side_b {
            // Its ends are on different sides of the link's line, or one of them is on it.
            // start + t along = a + s edge, so t (along × edge) = (a - start) × edge.
            breakpoints.push(Fraction::new(cross(&to_a, &edge), cross(&along_int, &edge)));
        }
    }
    stretches_between(breakpoints, |t| {
        // Edges through this point run along the link: any other would have made it a breakpoint.
        let spot = Spot::on_link(start, along, t);
        sides(along).into_iter().map(|side| height_beside(prisms, &spot, side)).min().flatten()
    })
}

/// The least height of the regions that meet at `p`.
///
/// It suffices to look in any set of directions that hits each sector between neighboring edges at p and runs along
/// no edge. For two neighboring edge directions e and f, the sector between them contains e + f if it is narrower than
/// half a turn, and otherwise the direction a quarter turn from e, also when e = f is the only one. So try all of
/// these, for all pairs.
fn height_around(prisms: &[Prism], p: [i64; 2]) -> Option<i64> {
    let spot = Spot { at: wide(p).map(Int::Small), w: Int::Small(1) };
    let mut outgoing: Vec<Direction> = Vec::new();
    for [a, b] in prisms.iter().flat_map(edges) {
        if spot.is_on_edge(a, b) {
            outgoing.extend([difference(p, a), difference(p, b)].into_iter().filter(|&d| d != [0, 0]));
        }
    }
    if outgoing.is_empty() {
        return height_beside(prisms, &spot, [1, 0]);
    }
    let mut candidates: Vec<Direction> = Vec::new();
    for e in &outgoing {
        candidates.extend(sides(*e));
        candidates.extend(outgoing.iter().map(|f| [e[0] + f[0], e[1] + f[1]]));
    }
    let runs_along = |d: Direction, e: Direction| {
        let (d, e) = (d.map(Int::Small), e.map(Int::Small));
        cross(&d, &e).sign().is_eq() && dot(&d, &e).sign().is_gt()
    };
    candidates.retain(|&d| d != [0, 0] && !outgoing.iter().any(|&e| runs_along(d, e)));
    candidates.into_iter().map(|d| height_beside(prisms, &spot, d)).min().flatten()
}

/// The highest top of the prisms that cover the region next to `spot` in direction `toward`.
///
/// No edge through the spot may run along `toward`.
fn height_beside(prisms: &[Prism], spot: &Spot, toward: Direction) -> Option<i64> {
    prisms.iter().filter(|prism| is_solid_beside(prism, spot, toward)).map(|prism| prism.top).max()
}

/// Parity of the edges that a ray meets which starts just beside `spot` and goes on in direction `toward`.
fn is_solid_beside(prism: &Prism, spot: &Spot, toward: Direction) -> bool {
    let toward = toward.map(Int::Small);
    let mut is_inside = false;
    for [a, b] in edges(prism) {
        let a_is_left = cross(&toward, &spot.toward(a)).sign().is_ge();
        let b_is_left = cross(&toward, &spot.toward(b)).sign().is_ge();
        // An edge that passes ahead of the spot from right to left turns counterclockwise around it, one that passes
        // from left to right clockwise. One that goes through the spot does not turn.
        let ahead = if b_is_left { Ordering::Greater } else { Ordering::Less };
        if a_is_left != b_is_left && spot.turn(a, b) == ahead {
            is_inside = !is_inside;
        }
    }
    is_inside
}

/// All edges of all rings, each ring closed.
fn edges(prism: &Prism) -> impl Iterator<Item = [[i64; 2]; 2]> {
    prism.rings.iter().flat_map(|ring| (0..ring.len()).map(move |i| [ring[i], ring[(i + 1) % ring.len()]]))
}

// ---------------------------------------------------------------------------------------------------------------------
// The plane.

/// A direction in the plane; its length does not matter.
type Direction = [i128; 2];

/// A point in the plane, `at / w` with w > 0.
struct Spot {
    at: [Int; 2],
    w: Int,
}

impl Spot {
    /// The point `start + t along`.
    fn on_link(start: [i128; 2], along: Direction, t: &Fraction) -> Spot {
        let coordinate = |axis: usize| {
            let (start, along): (Int, Int) = (Int::Small(start[axis]), Int::Small(along[axis]));
            &(&start * &t.den) + &(&along * &t.num)
        };
        Spot { at: [coordinate(0), coordinate(1)], w: t.den.clone() }
    }

    /// The vector from here to `p`, times w.
    fn toward(&self, p: [i64; 2]) -> [Int; 2] {
        [0, 1].map(|axis| &(&Int::from(p[axis]) * &self.w) - &self.at[axis])
    }

    /// The sense in which the way from `a` to `b` turns around this point: greater is counterclockwise.
    fn turn(&self, a: [i64; 2], b: [i64; 2]) -> Ordering {
        cross(&self.toward(a), &difference(a, b).map(Int::Small)).sign()
    }

    /// This point is on the closed edge from `a` to `b`.
    fn is_on_edge(&self, a: [i64; 2], b: [i64; 2]) -> bool {
        self.turn(a, b).is_eq() && dot(&self.toward(a), &self.toward(b)).sign().is_le()
    }
}

fn plan(p: P3) -> [i64; 2] {
    [p[0], p[1]]
}

fn wide(p: [i64; 2]) -> [i128; 2] {
    p.map(i128::from)
}

fn difference(from: [i64; 2], to: [i64; 2]) -> Direction {
    [0, 1].map(|axis| i128::from(to[axis]) - i128::from(from[axis]))
}

/// The directions a quarter turn to the left and to the right.
fn sides([x, y]: Direction) -> [Direction; 2] {
    [[-y, x], [y, -x]]
}

/// Positive if `b` is to the left of `a`.
fn cross(a: &[Int; 2], b: &[Int; 2]) -> Int {
    &(&a[0] * &b[1]) - &(&a[1] * &b[0])
}

fn dot(a: &[Int; 2], b: &[Int; 2]) -> Int {
    &(&a[0] * &b[0]) + &(&a[1] * &b[1])
}

// ---------------------------------------------------------------------------------------------------------------------
// Positions along a link.

/// A position along a link; the denominator is positive, common factors stay.
#[derive(Clone)]
struct Fraction {
    num: Int,
    den: Int,
}

impl Fraction {
    fn new(num: Int, den: Int) -> Fraction {
        match den.sign() {
            Ordering::Greater => Fraction { num, den },
            Ordering::Less => Fraction { num: &Int::Small(0) - &num, den: &Int::Small(0) - &den },
            Ordering::Equal => panic!("a fraction with denominator 0"),
        }
    }

    fn whole(value: i128) -> Fraction {
        Fraction { num: Int::Small(value), den: Int::Small(1) }
    }

    fn cmp(&self, other: &Fraction) -> Ordering {
        (&self.num * &other.den).cmp(&(&other.num * &self.den))
    }
}

/// Cuts 0..1 at the breakpoints that lie inside, and asks for the height at a point within each stretch.
fn stretches_between(mut breakpoints: Vec<Fraction>, height_at: impl Fn(&Fraction) -> Option<i64>) -> Vec<Stretch> {
    let (zero, one) = (Fraction::whole(0), Fraction::whole(1));
    breakpoints.retain(|t| t.cmp(&zero).is_gt() && t.cmp(&one).is_lt());
    breakpoints.extend([zero, one]);
    breakpoints.sort_by(Fraction::cmp);
    breakpoints.dedup_by(|a, b| Fraction::cmp(a, b).is_eq());
    breakpoints
        .windows(2)
        .map(|ends| {
            let within = Fraction { num: &ends[0].num + &ends[1].num, den: &ends[0].den + &ends[1].den };
            Stretch { from: ends[0].clone(), to: ends[1].clone(), height: height_at(&within) }
        })
        .collect()
}
