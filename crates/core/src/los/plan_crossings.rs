//! A link in the plane: the pieces that it meets and its intervals over them, for any height of its
//! receiver.
//!
//! The receiver may stand on a roof and rise with it. With b the rise, the ray at the fraction t of
//! the way from the UAV is at `h_U + t·(h_R + b − h_U)`, less its sag over a curved earth. A
//! building whose top there is H may be higher by
//!
//! ```text
//!   room(b) = min over t of  h_U − H(t) + t·(h_R + b − h_U) − sag(t)
//! ```
//!
//! This rises with b, by t for each unit. The building below the receiver rises by b, too. Let U
//! and D be the heights of UAV and receiver above its roof, or above the roof's plane. It leaves
//! the link clear as long as
//!
//! ```text
//!   b ≤ min over t of  U + D·t/(1 − t) − sag(t)/(1 − t)
//! ```
//!
//! Ground does not move, and hides a receiver that is too low. So with other buildings unchanged a
//! link is clear for one interval of b. The exception is a wall that a building shares with the one
//! below the receiver.

use super::cell_walk::Crossing;
use super::columns_ray::columns_los;
use super::height_limits::HeightLimits;
use super::prism_crossing::Ray;
use super::prisms_ray::{MetPiece, prisms_met};
use super::sag::Sag;
use super::slope::Slope;
use crate::height_field::{HeightField, Prisms, Station};
use crate::quantity::LatticePoint;

/// A link between a UAV and a receiver that may be higher or lower than known, and the pieces that
/// it meets in the plane.
#[derive(Debug)]
pub struct PlanCrossings<'a> {
    field: &'a HeightField,
    uav: Station,
    /// The known position of the receiver.
    receiver: Station,
    pieces: Vec<MetPiece>,
    /// Pairs of pieces that share a wall along the link.
    walls: Vec<[MetPiece; 2]>,
}

impl<'a> PlanCrossings<'a> {
    /// Finds the pieces that a link meets, if its receiver is lower by at most `fall` and buildings
    /// are higher by at most `reach` \[1/1024 m\].
    ///
    /// Cost: the pieces listed by the buckets along the lowest link in which the ray is below the
    /// highest top plus `reach`.
    pub fn new(field: &'a HeightField, uav: &Station, receiver: &Station, fall: i32, reach: i32) -> Self {
        let lowest = Station { z: receiver.z - i64::from(fall), ..*receiver };
        let met = |prisms| prisms_met(prisms, uav.on_prisms(), lowest.on_prisms(), reach);
        let (pieces, walls) = field.prisms().map(met).unwrap_or_default();
        PlanCrossings { field, uav: *uav, receiver: *receiver, pieces, walls }
    }

    /// Returns how far each building may rise if the receiver is `by` higher, in whole steps,
    /// rounded down; exact. Returns `None` if terrain, or the ground of a curved earth, blocks the
    /// link.
    pub fn limits(&self, by: i64) -> Option<HeightLimits> {
        // Nothing is between ends that coincide.
        if self.coincides_at() == Some(by) { Some(HeightLimits::default()) } else { self.limits_around(by) }
    }

    /// Returns the rise of the receiver that brings it to the very place of the UAV, if any does.
    pub fn coincides_at(&self) -> Option<i64> {
        let (uav, receiver) = (self.uav.on_prisms(), self.receiver.on_prisms());
        ((uav.x, uav.y) == (receiver.x, receiver.y)).then_some(uav.z - receiver.z)
    }

    /// Returns [`PlanCrossings::limits`], but treats a receiver at the place of the UAV as if it
    /// were a little higher or lower.
    pub(crate) fn limits_around(&self, by: i64) -> Option<HeightLimits> {
        let mut limits = HeightLimits::default();
        let Some(prisms) = self.field.prisms() else { return self.is_clear_of_ground(by).then_some(limits) };
        if !self.is_clear_of_ground(by) {
            return None;
        }
        let ray = self.ray(prisms, by);
        self.pieces.iter().for_each(|piece| limits.limit(piece.building, piece.room(&ray)));
        for wall in &self.walls {
            limits.wall([wall[0].building, wall[1].building], rooms_along(wall, &ray));
        }
        Some(limits)
    }

    /// Returns how far each of some buildings may rise if the receiver is `by` higher, in reals;
    /// along walls with a sloped roof in whole steps. The ground is left out.
    pub fn rooms(&self, by: f64, of: impl Fn(u32) -> bool) -> HeightLimits<f64> {
        let mut limits = HeightLimits::default();
        let Some(prisms) = self.field.prisms() else { return limits };
        let sag = self.sag();
        for piece in self.pieces.iter().filter(|piece| of(piece.building)) {
            limits.limit(piece.building, self.form(piece).room(sag, by));
        }
        for wall in self.walls.iter().filter(|wall| wall.iter().any(|piece| of(piece.building))) {
            let is_sloped = wall.iter().any(|piece| piece.plane.is_some());
            let rooms = if is_sloped {
                // The largest rises in whole steps; the largest real ones are somewhere in the step
                // above.
                rooms_along(wall, &self.ray(prisms, rounded(by))).map(|room| as_f64(room) + 0.5)
            } else {
                [0, 1].map(|k| self.form(&wall[k]).room(sag, by))
            };
            limits.wall([wall[0].building, wall[1].building], rooms);
        }
        limits
    }

    /// Returns `true` if terrain, and the ground of a curved earth, leave the link clear with the
    /// receiver `by` higher. A higher receiver is no less clear.
    pub fn is_clear_of_ground(&self, by: i64) -> bool {
        let receiver = Station { z: self.receiver.z + by, ..self.receiver };
        let columns = self.field.columns();
        columns.is_none_or(|c| columns_los(c, self.uav.on_columns(), self.field.seen_on_columns(&receiver)))
            && self.field.prisms().is_none_or(|prisms| !self.ray(prisms, by).is_below_horizon(prisms))
    }

    /// Returns the largest common rise of a building and the receiver on it that leaves the link
    /// clear; −∞ for none. Walls that the building shares with others are left out.
    pub fn most_on_roof(&self, building: u32) -> f64 {
        let own = self.pieces.iter().filter(|piece| piece.building == building);
        let alone = own.map(|piece| self.form(piece).most_with_receiver(self.sag()));
        let of_walls = self.walls.iter().filter(|wall| wall.iter().all(|piece| piece.building == building));
        let along = of_walls.map(|wall| {
            let [a, b] = [0, 1].map(|k| self.form(&wall[k]).most_with_receiver(self.sag()));
            a.max(b)
        });
        alone.chain(along).fold(f64::INFINITY, f64::min)
    }

    /// Returns the rises of the receiver at which the room of a wanted building changes from one
    /// straight line to another.
    ///
    /// There, another piece or its other end becomes nearest to the ray. The rises at which a
    /// building starts or stops hiding another along a wall are included. Sag is left out.
    pub fn kinks(&self, (from, to): (f64, f64), of: impl Fn(u32) -> bool) -> Vec<f64> {
        let mut lines: Vec<(u32, [f64; 2])> = Vec::new();
        for piece in self.pieces.iter().chain(self.walls.iter().flatten()).filter(|piece| of(piece.building)) {
            lines.extend(self.form(piece).lines().map(|line| (piece.building, line)));
        }
        lines.sort_by_key(|(building, _)| *building);
        let mut kinks = Vec::new();
        for of_building in lines.chunk_by(|a, b| a.0 == b.0) {
            let mut at = from;
            while let Some(kink) = next_kink(of_building, at).filter(|kink| *kink < to) {
                kinks.push(kink);
                at = kink;
            }
        }
        // Along walls, whether a building is in the way depends on its own height.
        let own_walls = self.walls.iter().filter(|wall| wall[0].building != wall[1].building).flatten();
        kinks.extend(own_walls.map(|piece| self.form(piece).most_with_receiver(self.sag())));
        kinks.retain(|kink| *kink > from && *kink < to);
        kinks
    }

    fn ray(&self, prisms: &Prisms, by: i64) -> Ray {
        let (uav, receiver) = (self.uav.on_prisms(), self.receiver.on_prisms());
        let receiver = LatticePoint { z: receiver.z + by, ..receiver };
        let sag = Sag::new(prisms.earth(), receiver.x - uav.x, receiver.y - uav.y);
        Ray { sag, ..Ray::new(uav, receiver) }
    }

    /// Returns the b of [`Sag`] \[1/1024 m\].
    fn sag(&self) -> f64 {
        let Some(prisms) = self.field.prisms() else { return 0.0 };
        self.ray(prisms, 0).sag.map_or(0.0, |sag| sag.scale())
    }

    fn form(&self, piece: &MetPiece) -> Form {
        let (uav, receiver) = (self.uav.on_prisms(), self.receiver.on_prisms());
        let above = |p: LatticePoint| match &piece.plane {
            None => as_f64(p.z - i64::from(piece.top)),
            #[expect(clippy::cast_precision_loss, reason = "rounded")]
            Some(plane) => plane.above(p) as f64 / as_f64(plane.area()),
        };
        let at = |c: Crossing| as_f64(c.n) / as_f64(c.d);
        Form { uav: above(uav), receiver: above(receiver), far: at(piece.interval.far), near: at(piece.interval.near) }
    }
}

impl MetPiece {
    /// Returns how far it may rise before it blocks a ray, in whole steps, rounded down.
    fn room(&self, ray: &Ray) -> i64 {
        match &self.plane {
            None => ray.highest_clear(&self.interval) - i64::from(self.top),
            Some(plane) => Slope::over(plane, ray.uav, ray.receiver).room(self.interval.far, self.interval.near),
        }
    }
}

/// Returns how far each of two pieces along a wall may rise so that the wall leaves a ray clear, in
/// whole steps.
fn rooms_along(wall: &[MetPiece; 2], ray: &Ray) -> [i64; 2] {
    if wall.iter().all(|piece| piece.plane.is_none()) {
        return [0, 1].map(|k| wall[k].room(ray));
    }
    let [a, b] = [0, 1].map(|k| match &wall[k].plane {
        Some(plane) => Slope::over(plane, ray.uav, ray.receiver),
        None => Slope::level(wall[k].top, ray.uav, ray.receiver),
    });
    a.rooms_with(&b, wall[0].interval.far, wall[0].interval.near)
}

/// The line from UAV to receiver over the plane of a roof, in doubles \[1/1024 m\].
#[derive(Debug, Clone, Copy)]
struct Form {
    /// Height of the UAV above the plane.
    uav: f64,
    /// Height of the receiver above the plane, at its known position.
    receiver: f64,
    /// Fractions of the way from the UAV between which the roof is below the line.
    far: f64,
    near: f64,
}

impl Form {
    /// Returns how far the roof may rise if the receiver rises by `by`.
    fn room(&self, sag: f64, by: f64) -> f64 {
        let receiver = self.receiver + by;
        let at = |t: f64| self.uav * (1.0 - t) + receiver * t - sag * t * (1.0 - t);
        let ends = at(self.far).min(at(self.near));
        if sag <= 0.0 {
            return ends;
        }
        let lowest = 0.5 - (receiver - self.uav) / (2.0 * sag);
        if lowest > self.far && lowest < self.near { ends.min(at(lowest)) } else { ends }
    }

    /// Returns how far roof and receiver together may rise.
    fn most_with_receiver(&self, sag: f64) -> f64 {
        // At the receiver both rise alike.
        let at = |t: f64| match 1.0 - t {
            rest if rest <= 0.0 && self.receiver > 0.0 => f64::INFINITY,
            rest if rest <= 0.0 && self.receiver == 0.0 => self.uav - sag,
            rest if rest <= 0.0 => f64::NEG_INFINITY,
            rest => self.uav + self.receiver * (t / rest) - sag * t,
        };
        let ends = at(self.far).min(at(self.near));
        if sag <= 0.0 || self.receiver <= 0.0 {
            return ends;
        }
        let lowest = 1.0 - (self.receiver / sag).sqrt();
        if lowest > self.far && lowest < self.near { ends.min(at(lowest)) } else { ends }
    }

    /// Returns the room at each end, as its value without a rise and its growth with the rise.
    fn lines(&self) -> [[f64; 2]; 2] {
        [self.far, self.near].map(|t| [self.uav * (1.0 - t) + self.receiver * t, t])
    }
}

/// Returns the first position beyond `from` at which another of some straight lines becomes the
/// lowest.
fn next_kink(lines: &[(u32, [f64; 2])], from: f64) -> Option<f64> {
    let value = |line: &[f64; 2]| line[0] + line[1] * from;
    // The lowest line just beyond `from`: of the lines that meet there, the one that grows least.
    let lowest = lines.iter().map(|(_, line)| line).min_by(|a, b| {
        let apart = value(a) - value(b);
        if apart.abs() < 1e-6 { a[1].total_cmp(&b[1]) } else { apart.total_cmp(&0.0) }
    })?;
    let meets = |other: &[f64; 2]| from + (value(other) - value(lowest)) / (lowest[1] - other[1]);
    let flatter = lines.iter().map(|(_, line)| line).filter(|line| line[1] < lowest[1]);
    flatter.map(meets).filter(|at| *at > from + 1e-6).min_by(f64::total_cmp)
}

fn rounded(steps: f64) -> i64 {
    #[expect(clippy::cast_possible_truncation, reason = "heights of buildings")]
    let whole = steps.round() as i64;
    whole
}

#[expect(clippy::cast_precision_loss, reason = "rounded")]
fn as_f64(v: i64) -> f64 {
    v as f64
}
