//! `ray` over prisms: finds the footprint pieces that the link crosses, bucket by bucket from the
//! receiver up.
//!
//! Crossings of the interior ([`super::prism_crossing`]) are tested at once. A ray along an edge is
//! inside the solid up to the lower top if pieces cover both sides: a shared wall, or the diagonal
//! of a triangulated roof. These rare edges are collected and paired at the end.
//!
//! Over a sloped roof the ray comes nearest to the plane at an end of the interval ([`Slope`]).
//!
//! Over a curved earth the link sags ([`Sag`]), and flat ground blocks like a roof without an end.

use std::cell::Cell;
use std::ops::ControlFlow;

use super::cell_walk::{CellWalk, Crossing};
use super::height_limits::HeightLimits;
use super::obstruction::{LeastHeight, Obstruction, surely_binds_less};
use super::prism_crossing::{Edge, Interval, Meeting, Ray, rest, walls_along};
use super::sag::Sag;
use super::slope::Slope;
use crate::height_field::{Piece, Prisms, RoofPlane};
use crate::quantity::LatticePoint;

/// Decides whether the link between `uav` and `receiver` is clear of the interior of B.
///
/// Cost: the pieces listed by the buckets along the link in which the ray is below the highest top.
/// Positions may differ by at most 2^27 lattice steps along each axis (not checked). Orientations
/// then fit in i64, heights against slanted edges in i128.
pub fn prisms_los(prisms: &Prisms, uav: LatticePoint, receiver: LatticePoint) -> bool {
    let sag = Sag::new(prisms.earth(), receiver.x - uav.x, receiver.y - uav.y);
    let lower = uav.z.min(receiver.z) - sag.map_or(0, |sag| sag.most());
    let ray = Ray { sag, ..Ray::new(uav, receiver) };
    if ray.is_below_horizon(prisms) {
        return false;
    }
    if i64::from(prisms.max_top()) <= lower {
        return true;
    }
    if uav.x == receiver.x && uav.y == receiver.y {
        // If the ends coincide, the open segment is empty.
        return uav.z == receiver.z || i64::from(prisms.solid_below(uav.x, uav.y)) <= lower;
    }
    let mut edges: Vec<Edge> = Vec::new();
    let crossed = visit_buckets(
        prisms,
        (receiver, uav),
        ray.rises_above(prisms.max_top()),
        |max_top, near, far| ray.dips_below(max_top, near, far),
        |index, piece| {
            if i64::from(piece.top) <= lower {
                return ControlFlow::Continue(());
            }
            match ray.meet(prisms.ring(piece)) {
                Meeting::Interior(interval) if ray.is_blocked_by(prisms, piece, &interval) => ControlFlow::Break(()),
                Meeting::Edge(side, interval) => {
                    edges.push(Edge { piece: index, top: piece.top, side, interval });
                    ControlFlow::Continue(())
                }
                _ => ControlFlow::Continue(()),
            }
        },
    );
    let is_wall_blocked = |(a, b, interval): (&Edge, &Edge, Interval)| match ray.slopes(prisms, (a, b)) {
        None => ray.is_blocked(a.top.min(b.top), &interval),
        Some((a, b)) => a.is_blocked_with(&b, interval.far, interval.near),
    };
    crossed.is_continue() && !walls_along(&edges).any(is_wall_blocked)
}

/// Returns the least height of a receiver at `receiver`'s position from which the link to `uav` is
/// LoS, with the piece that sets it. The receiver's own height plays no part.
pub fn prisms_least_receiver_height(prisms: &Prisms, uav: LatticePoint, receiver: LatticePoint) -> LeastHeight {
    // An obstacle below the UAV binds more the farther it is from the UAV, so the walk begins at
    // the receiver.
    bound_from(prisms, uav, receiver, Walk::TowardsPivot, None)
}

/// Returns the least height of a UAV at `uav`'s position from which the link to `receiver` is LoS:
/// the steepest slope seen from the receiver. The UAV's own height plays no part.
pub fn prisms_least_height(prisms: &Prisms, uav: LatticePoint, receiver: LatticePoint) -> LeastHeight {
    // No prism is exempt, so a link and its reverse are obstructed alike. An obstacle above the
    // receiver binds more the nearer it is to the receiver.
    bound_from(prisms, receiver, uav, Walk::AwayFromPivot, None)
}

/// Returns the least lattice height of a UAV at `uav`'s position, not below `floor`, from which the
/// link to `receiver` is LoS. Returns `None` if no height is enough. Exact.
pub fn prisms_least_step(prisms: &Prisms, uav: LatticePoint, receiver: LatticePoint, floor: i64) -> Option<i64> {
    if prisms.earth().is_some() || prisms.are_sloped() {
        // Heights are rounded there, so `ray` decides which step is the first.
        let sees = |z: i64| prisms_los(prisms, LatticePoint { z, ..uav }, receiver);
        #[expect(clippy::cast_possible_truncation, reason = "saturates far beyond all heights")]
        let about = prisms_least_height_above(prisms, uav, receiver, floor).height_steps().clamp(-1e12, 1e12) as i64;
        return (floor.max(about - 2)..=floor.max(about + 2)).find(|z| sees(*z));
    }
    // A prism below the receiver binds nothing above its own top.
    if i64::from(prisms.max_top()) <= floor.min(receiver.z) {
        return Some(floor);
    }
    prisms_least_height_above(prisms, uav, receiver, floor).lowest_step().map(|z| z.max(floor))
}

/// Returns [`prisms_least_height`] if it is above `floor` \[1/1024 m above the datum\]; otherwise
/// some height not above `floor`.
pub(super) fn prisms_least_height_above(
    prisms: &Prisms,
    uav: LatticePoint,
    receiver: LatticePoint,
    floor: i64,
) -> LeastHeight {
    bound_from(prisms, receiver, uav, Walk::AwayFromPivot, Some(floor))
}

/// A piece that a link meets between two fractions of its way.
#[derive(Debug, Clone, Copy)]
pub(super) struct MetPiece {
    pub(super) building: u32,
    /// Its highest point \[1/1024 m above the datum\].
    pub(super) top: i32,
    /// The plane of a sloped roof.
    pub(super) plane: Option<RoofPlane>,
    pub(super) interval: Interval,
}

/// Returns the pieces that a link meets in the plane, each alone and in pairs along walls. Pieces
/// are left out if they stay below the ray even with tops `reach` higher than known \[1/1024 m\].
///
/// Cost: the pieces listed by the buckets along the link in which the ray is below the highest top
/// plus `reach`.
pub(super) fn prisms_met(
    prisms: &Prisms,
    uav: LatticePoint,
    receiver: LatticePoint,
    reach: i32,
) -> (Vec<MetPiece>, Vec<[MetPiece; 2]>) {
    let met = |index: usize, interval: Interval| {
        let piece = &prisms.pieces()[index];
        MetPiece { building: piece.building, top: piece.top, plane: prisms.plane(piece), interval }
    };
    if uav.x == receiver.x && uav.y == receiver.y {
        let all = Interval { far: Crossing { n: 0, d: 1 }, near: Crossing { n: 1, d: 1 } };
        let (inside, sides) = prisms.pieces_around(uav.x, uav.y);
        let mut pieces: Vec<MetPiece> = inside.into_iter().map(|index| met(index, all)).collect();
        // Walls that meet there block together; of more than two sides the two lowest are taken.
        let walls = match sides[..] {
            [] => Vec::new(),
            [side] => {
                pieces.push(met(side, all));
                Vec::new()
            }
            [lowest, next, ..] => vec![[met(lowest, all), met(next, all)]],
        };
        return (pieces, walls);
    }
    let ray = Ray { sag: Sag::new(prisms.earth(), receiver.x - uav.x, receiver.y - uav.y), ..Ray::new(uav, receiver) };
    let (mut pieces, mut edges): (Vec<MetPiece>, Vec<Edge>) = (Vec::new(), Vec::new());
    // Lowest height of the ray over the current bucket.
    let lowest = Cell::new(0.0);
    let may_reach = |top: i32| f64::from(top) + f64::from(reach) > lowest.get();
    let _ = visit_buckets(
        prisms,
        (receiver, uav),
        ray.rises_above(prisms.max_top().saturating_add(reach)),
        |max_top, near, far| {
            lowest.set(ray.lowest(near, far));
            may_reach(max_top)
        },
        |index, piece| {
            if may_reach(piece.top) {
                match ray.meet(prisms.ring(piece)) {
                    Meeting::Interior(interval) => pieces.push(met(index, interval)),
                    Meeting::Edge(side, interval) => edges.push(Edge { piece: index, top: piece.top, side, interval }),
                    Meeting::Nothing => {}
                }
            }
            ControlFlow::Continue(())
        },
    );
    let walls = walls_along(&edges).map(|(a, b, interval)| [a, b].map(|edge| met(edge.piece, interval))).collect();
    (pieces, walls)
}

/// Adds to `limits` the rooms of the flat pieces that block a link, each alone and in pairs along
/// walls: how far each may rise, below 0. The ends must differ in the plane.
///
/// Cost: the pieces listed by the buckets along the link in which the ray is below the highest top.
pub(crate) fn limit_by_blocking_prisms(
    prisms: &Prisms,
    uav: LatticePoint,
    receiver: LatticePoint,
    limits: &mut HeightLimits,
) {
    let ray = Ray { sag: Sag::new(prisms.earth(), receiver.x - uav.x, receiver.y - uav.y), ..Ray::new(uav, receiver) };
    let room = |top: i32, interval: &Interval| ray.highest_clear(interval) - i64::from(top);
    let lowest = Cell::new(0.0);
    let may_block = |top: i32| f64::from(top) > lowest.get();
    let mut edges: Vec<Edge> = Vec::new();
    let _ = visit_buckets(
        prisms,
        (receiver, uav),
        ray.rises_above(prisms.max_top()),
        |max_top, near, far| {
            lowest.set(ray.lowest(near, far));
            may_block(max_top)
        },
        |index, piece| {
            if may_block(piece.top) {
                match ray.meet(prisms.ring(piece)) {
                    Meeting::Interior(interval) if ray.is_blocked(piece.top, &interval) => {
                        limits.limit(piece.building, room(piece.top, &interval));
                    }
                    Meeting::Edge(side, interval) => edges.push(Edge { piece: index, top: piece.top, side, interval }),
                    _ => {}
                }
            }
            ControlFlow::Continue(())
        },
    );
    for (a, b, interval) in walls_along(&edges) {
        if ray.is_blocked(a.top.min(b.top), &interval) {
            let [of_a, of_b] = [a, b].map(|edge| prisms.pieces()[edge.piece].building);
            limits.wall([of_a, of_b], [a, b].map(|edge| room(edge.top, &interval)));
        }
    }
}

/// The direction in which buckets are visited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Walk {
    TowardsPivot,
    AwayFromPivot,
}

/// Returns the least height at `end`'s position that is in line of sight of `pivot`. It does not
/// depend on the order of the visits. With a floor, pieces that bind no more than it may be left
/// out.
fn bound_from(prisms: &Prisms, pivot: LatticePoint, end: LatticePoint, walk: Walk, floor: Option<i64>) -> LeastHeight {
    let mut least = LeastHeight::Clear;
    if pivot.x == end.x && pivot.y == end.y {
        // Straight below the UAV a receiver sees it unless a roof is between them, so from the roof
        // up.
        if let Some((top, piece)) = prisms.solid_at(pivot.x, pivot.y) {
            let here = Crossing { n: 1, d: 1 };
            let far = if i64::from(top) > pivot.z { Crossing { n: 0, d: 1 } } else { here };
            least.raise(Obstruction::new(piece, top, pivot, here, far));
        }
        return least;
    }
    let sag = Sag::new(prisms.earth(), end.x - pivot.x, end.y - pivot.y);
    let ray = Ray { sag, ..Ray::new(pivot, end) };
    if let Some((sag, ground)) = sag.zip(prisms.earth().and_then(|earth| earth.ground))
        && let Some(horizon) = Obstruction::of_horizon(ground, pivot, sag)
    {
        least.raise(horizon);
    }
    let mut edges: Vec<Edge> = Vec::new();
    #[expect(clippy::cast_precision_loss, reason = "a difference of heights, at most 2^28")]
    let floor_above_pivot = floor.map_or(f64::NEG_INFINITY, |floor| (floor - pivot.z) as f64);
    let least_cell = std::cell::Cell::new(floor_above_pivot);
    // A bucket from `first` to `last` along the walk, converted to fractions from the pivot.
    let may_bind = |max_top: i32, first: Crossing, last: Crossing| {
        let (from, to) = match walk {
            Walk::TowardsPivot => (rest(last), rest(first)),
            Walk::AwayFromPivot => (first, last),
        };
        ray.may_bind(max_top, to, from, least_cell.get())
    };
    let start = match walk {
        Walk::TowardsPivot => (end, pivot),
        Walk::AwayFromPivot => (pivot, end),
    };
    let _ = visit_buckets(prisms, start, f64::INFINITY, may_bind, |index, piece| {
        match ray.meet(prisms.ring(piece)) {
            Meeting::Interior(interval) => {
                if ray.may_bind(piece.top, interval.near, interval.far, least_cell.get()) {
                    least.raise(match prisms.plane(piece) {
                        None => ray.obstruction(index, piece.top, &interval),
                        Some(plane) => Slope::over(&plane, pivot, end).obstruction(index, interval.far, interval.near),
                    });
                    least_cell.set(least.above_uav().max(floor_above_pivot));
                }
            }
            Meeting::Edge(side, interval) => {
                edges.push(Edge { piece: index, top: piece.top, side, interval });
            }
            Meeting::Nothing => {}
        }
        ControlFlow::Continue(())
    });
    for (a, b, interval) in walls_along(&edges) {
        let lower = if a.top <= b.top { a } else { b };
        least.raise(match ray.slopes(prisms, (a, b)) {
            None => ray.obstruction(lower.piece, lower.top, &interval),
            Some((a, b)) => a.obstruction_with(&b, lower.piece, interval.far, interval.near),
        });
    }
    least
}

/// Returns the pieces whose interior the link crosses, sorted by index, for drawing. The ends of
/// each crossing are fractions of the way from the receiver.
pub fn prisms_crossed(prisms: &Prisms, uav: LatticePoint, receiver: LatticePoint) -> Vec<(usize, f64, f64)> {
    if uav.x == receiver.x && uav.y == receiver.y {
        return Vec::new();
    }
    let ray = Ray::new(uav, receiver);
    let mut crossed = Vec::new();
    let _ = visit_buckets(
        prisms,
        (receiver, uav),
        f64::INFINITY,
        |_, _, _| true,
        |index, piece| {
            if let Meeting::Interior(interval) = ray.meet(prisms.ring(piece)) {
                let obstruction = Obstruction::new(index, piece.top, uav, interval.near, interval.far);
                crossed.push((index, obstruction.near, obstruction.far));
            }
            ControlFlow::Continue(())
        },
    );
    crossed.sort_unstable_by_key(|a| a.0);
    crossed.dedup_by_key(|c| c.0);
    crossed
}

impl Ray {
    /// Returns `true` if the flat ground of a curved earth is in the way: the ray is below it at
    /// its lowest point, between the ends.
    pub(super) fn is_below_horizon(&self, prisms: &Prisms) -> bool {
        let Some((sag, ground)) = self.sag.zip(prisms.earth().and_then(|earth| earth.ground)) else { return false };
        let above = self.uav.z - i64::from(ground);
        let (start, end) = (Crossing { n: 0, d: 1 }, Crossing { n: 1, d: 1 });
        above.min(above + self.dz) < sag.most() && sag.dips_between(above, self.dz, start, end)
    }

    /// Returns the slopes of two pieces along a wall under this ray, if one of them is sloped.
    fn slopes(&self, prisms: &Prisms, (a, b): (&Edge, &Edge)) -> Option<(Slope, Slope)> {
        let plane = |edge: &Edge| prisms.plane(&prisms.pieces()[edge.piece]);
        let slope = |edge: &Edge, plane: Option<RoofPlane>| match plane {
            Some(plane) => Slope::over(&plane, self.uav, self.receiver),
            None => Slope::level(edge.top, self.uav, self.receiver),
        };
        let (of_a, of_b) = (plane(a), plane(b));
        (of_a.is_some() || of_b.is_some()).then(|| (slope(a, of_a), slope(b, of_b)))
    }

    /// Returns the bound of a flat roof over an interval on the end of the link that is not the
    /// pivot.
    fn obstruction(&self, piece: usize, top: i32, interval: &Interval) -> Obstruction {
        let straight = Obstruction::new(piece, top, self.uav, interval.near, interval.far);
        self.sag.map_or(straight, |sag| straight.over_curve(self.uav, sag))
    }

    /// Returns `true` if that bound may exceed a height of `above_uav` over the pivot.
    fn may_bind(&self, top: i32, near: Crossing, far: Crossing, above_uav: f64) -> bool {
        #[expect(clippy::cast_precision_loss, reason = "rounded up by a step")]
        let rise = self.sag.map_or(0.0, |sag| sag.rise_at_end(far.n as f64 / far.d as f64) + 1.0);
        !surely_binds_less(top, self.uav.z, near, far, above_uav - rise)
    }

    /// Returns `true` if a piece blocks the ray over an interval.
    #[inline]
    fn is_blocked_by(&self, prisms: &Prisms, piece: &Piece, interval: &Interval) -> bool {
        match prisms.plane(piece) {
            None => self.is_blocked(piece.top, interval),
            Some(plane) => Slope::over(&plane, self.uav, self.receiver).is_blocked(interval.far, interval.near),
        }
    }

    /// Returns `true` if a solid of the given top blocks the ray over an interval. Over a flat
    /// earth the end nearest the lower terminal decides.
    #[inline]
    fn is_blocked(&self, top: i32, interval: &Interval) -> bool {
        if let Some(sag) = self.sag {
            return sag.dips(self.uav.z - i64::from(top), self.dz, interval.far, interval.near);
        }
        let at = if self.dz <= 0 { interval.near } else { interval.far };
        let excess = i64::from(top) - self.uav.z;
        // z = z_U + (n/d)·dz, so blocked ⇔ excess·d > n·dz. The f64 products are off by less than
        // 3·2^-53 relative.
        #[expect(clippy::cast_precision_loss, reason = "filtered: decided in i128 where rounding could matter")]
        let (left, right) = (excess as f64 * at.d as f64, at.n as f64 * self.dz as f64);
        if (left - right).abs() > 1e-15 * (left.abs() + right.abs()) {
            return left > right;
        }
        i128::from(excess) * i128::from(at.d) > i128::from(at.n) * i128::from(self.dz)
    }

    /// Returns the highest top that does not block the ray over an interval.
    pub(super) fn highest_clear(&self, interval: &Interval) -> i64 {
        let at = if self.dz <= 0 { interval.near } else { interval.far };
        // EXACT: heights are below 2^28, so the quotient is, too.
        let rise = (i128::from(at.n) * i128::from(self.dz)).div_euclid(i128::from(at.d));
        let straight = self.uav.z + i64::try_from(rise).unwrap_or(0);
        let Some(sag) = self.sag else { return straight };
        let is_blocked = |top: i64| sag.dips(self.uav.z - top, self.dz, interval.far, interval.near);
        // Sag lowers a link by no more than its maximum.
        let (mut clear, mut blocked) = (straight - sag.most() - 2, straight + 1);
        while blocked - clear > 1 {
            let middle = clear + (blocked - clear) / 2;
            if is_blocked(middle) { blocked = middle } else { clear = middle }
        }
        clear
    }

    /// Returns the fraction of the way from the receiver beyond which the ray stays above `top`; ∞ if
    /// it does not rise that far.
    #[expect(clippy::cast_precision_loss, reason = "used with a margin of two lattice steps")]
    fn rises_above(&self, top: i32) -> f64 {
        let rise = i64::from(top) + self.sag.map_or(0, |sag| sag.most()) + 2 - self.receiver.z;
        if self.dz < 0 && rise < -self.dz { rise as f64 / -self.dz as f64 } else { f64::INFINITY }
    }

    /// Returns the height of the ray at fraction `t` from the receiver, to within one lattice step.
    #[expect(clippy::cast_precision_loss, reason = "used with a margin of one lattice step")]
    fn height_from_receiver(&self, t: f64) -> f64 {
        self.receiver.z as f64 - t * self.dz as f64
    }

    /// Returns `true` if the ray may be below `top` somewhere between `near` and `far`, measured
    /// from the receiver.
    #[inline]
    fn dips_below(&self, top: i32, near: Crossing, far: Crossing) -> bool {
        f64::from(top) > self.lowest(near, far)
    }

    /// Returns a lower bound on the ray's height between `near` and `far`, measured from the
    /// receiver.
    #[inline]
    fn lowest(&self, near: Crossing, far: Crossing) -> f64 {
        let lowest = if self.dz <= 0 { near } else { far };
        #[expect(clippy::cast_precision_loss, reason = "used with a margin of one lattice step")]
        let fraction = |c: Crossing| c.n as f64 / c.d as f64;
        let sag = self.sag.map_or(0.0, |sag| sag.most_between(fraction(near), fraction(far)));
        self.height_from_receiver(fraction(lowest)) - sag - 1.0
    }
}

/// Visits the pieces listed by the buckets along the link, from its first end up to the fraction
/// `until` of the way.
///
/// Skips the buckets that `matters` rules out. It gets the bucket's highest top and the ray's entry
/// and exit, measured from the first end.
#[inline]
fn visit_buckets(
    prisms: &Prisms,
    (from, to): (LatticePoint, LatticePoint),
    until: f64,
    matters: impl Fn(i32, Crossing, Crossing) -> bool,
    mut visit: impl FnMut(usize, &Piece) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let buckets = prisms.buckets();
    let relative = |p: &LatticePoint| (p.x - buckets.origin.0, p.y - buckets.origin.1);
    let mut walk = CellWalk::new(relative(&from), relative(&to), [buckets.size; 2]);
    let mut near = Crossing { n: 0, d: 1 };
    loop {
        let exit = walk.exit();
        let far = exit.unwrap_or(Crossing { n: 1, d: 1 });
        if let Some((max_top, items)) = buckets.at(walk.cell.0, walk.cell.1)
            && matters(max_top, near, far)
        {
            for &item in items {
                visit(item as usize, &prisms.pieces()[item as usize])?;
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "an end of the walk may be a bucket late")]
        let is_beyond = far.n as f64 > until * far.d as f64;
        if exit.is_none() || is_beyond {
            return ControlFlow::Continue(());
        }
        near = far;
        walk.advance();
    }
}
