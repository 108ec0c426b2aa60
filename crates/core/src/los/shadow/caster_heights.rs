//! The least heights that one caster demands of receivers, or of the UAV, eight at a time.
//!
//! **Of receivers.** Within the cone over its footprint and behind the near edges a prism hides the
//! receivers below its ceiling. The ceiling is the least of all planes through the UAV and the far
//! upper edges (the near ones of a roof above the UAV). It is also at most the roof if that is
//! below the UAV. A plane is `h_U + (H − h_U)·(E × q)/K`, with the symbols of [`super`]. A
//! receiver's least height is the largest demand of the casters.
//!
//! **Of the UAV.** Consider a receiver at height z, and the fraction t of the way from the UAV's
//! place (t = K/(E × q) on an edge). If the ray grazes the roof there, it reaches the UAV's place
//! at `z + (H − z)·(E × q)/(E × q − K)`. A roof above the receiver binds at its far edge, which is
//! next to the receiver. A lower roof binds at its near edge. The ray crosses the edge at which
//! this height is least.
//!
//! **Sloped roofs.** The planes go through the UAV and both ends of an edge, each at its own height
//! ([`super::sloped`]). With α and β below the UAV they are
//! `h_U − (α·(E × q) + (α − β)·(A × q))/K`. The roof's own plane is added if the UAV is above it.
//!
//! Seen from a receiver the ray grazes the roof at either end of its way over it. It crosses the
//! near edge with the least E × q/K of all, and the far edge with the greatest. The higher of both
//! heights counts.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8};

use super::geometry::{as_f64, cross, sub};
use super::plane::Plane;
use crate::height_field::{Caster, Casters, RoofPlane};

/// Largest ratio of a link's length to its part beyond a sloped roof for which heights of the UAV
/// are given.
pub(super) const OFTEN: f64 = 256.0;

/// The edges of a caster, as seen from the UAV.
#[derive(Debug, Default)]
pub(super) struct Edges {
    far: Vec<Edge>,
    near: Vec<Edge>,
    /// Top \[1/1024 m above the datum\].
    top: f64,
    /// The top above the UAV \[1/1024 m\].
    rise: f64,
    /// Its plane, if it is sloped.
    pub(super) sloped: Option<SlopedTop>,
}

/// The plane of a sloped top: height at the UAV's place above the UAV, and rise to the east and the
/// north \[1/1024 m\].
#[derive(Debug, Clone, Copy)]
pub(super) struct SlopedTop {
    above_uav: f64,
    rise: [f64; 2],
}

/// A step E, and K = E × (A − u).
#[derive(Debug, Clone, Copy)]
struct Edge {
    east: f64,
    north: f64,
    k: f64,
    /// Ratio of the top above the UAV to K; for a sloped top, of A above the UAV.
    slope: f64,
    /// A, its start.
    from: [f64; 2],
    /// Height of A \[1/1024 m above the datum\].
    height: f64,
    /// Height of B above A \[1/1024 m\].
    climb: f64,
}

impl Edge {
    /// Returns A × q.
    #[inline(always)]
    fn cross_from<S: Simd>(&self, simd: S, (east, north): (f64x8<S>, f64)) -> f64x8<S> {
        f64x8::splat(simd, self.from[0] * north) - f64x8::splat(simd, self.from[1]) * east
    }

    /// Returns E × q.
    #[inline(always)]
    fn cross<S: Simd>(&self, simd: S, (east, north): (f64x8<S>, f64)) -> f64x8<S> {
        f64x8::splat(simd, self.east * north) - f64x8::splat(simd, self.north) * east
    }
}

impl Edges {
    #[inline(always)]
    pub(super) fn of(&mut self, plane: &Plane, casters: &Casters, caster: &Caster) {
        let (ring, heights) = (casters.ring(caster), casters.heights(caster));
        let (ux, uy) = (plane.uav.x, plane.uav.y);
        self.far.clear();
        self.near.clear();
        self.top = f64::from(caster.top);
        self.rise = as_f64(i64::from(caster.top) - plane.uav.z);
        let from_uav = |v: [i32; 2]| [i64::from(v[0]) - ux, i64::from(v[1]) - uy];
        self.sloped = heights.map(|heights| {
            let roof = RoofPlane::through(ring, heights);
            let area = as_f64(roof.area());
            #[expect(clippy::cast_precision_loss, reason = "rounded, within the terms that are reckoned with")]
            let above_uav = -(roof.above(plane.uav) as f64) / area;
            SlopedTop { above_uav, rise: roof.rise().map(|rise| as_f64(rise) / area) }
        });
        let height = |k: usize| heights.map_or(self.top, |heights| f64::from(heights[k]));
        let last = ring.len() - 1;
        let (mut a, mut height_a) = (from_uav(ring[last]), height(last));
        for (k, &vertex) in ring.iter().enumerate() {
            let (b, height_b) = (from_uav(vertex), height(k));
            let edge = sub(b, a);
            let k = cross(edge, a);
            let of_side = if k < 0 { &mut self.far } else { &mut self.near };
            if k != 0 {
                let k = as_f64(k);
                of_side.push(Edge {
                    east: as_f64(edge[0]),
                    north: as_f64(edge[1]),
                    k,
                    slope: (height_a - as_f64(plane.uav.z)) / k,
                    from: a.map(as_f64),
                    height: height_a,
                    climb: height_b - height_a,
                });
            }
            (a, height_a) = (b, height_b);
        }
    }

    /// Returns the least heights above the UAV of receivers at some places, which are relative to
    /// the UAV.
    #[inline(always)]
    pub(super) fn of_receivers<S: Simd>(&self, simd: S, q: (f64x8<S>, f64)) -> f64x8<S> {
        if let Some(top) = &self.sloped {
            return self.of_receivers_over(simd, q, top);
        }
        let (edges, cap) = if self.rise <= 0.0 { (&self.far, self.rise) } else { (&self.near, f64::INFINITY) };
        let mut least = f64x8::splat(simd, cap);
        for edge in edges {
            least = least.min(edge.cross(simd, q) * f64x8::splat(simd, edge.slope));
        }
        least
    }

    /// Returns the least heights of receivers past a sloped top.
    #[inline(always)]
    fn of_receivers_over<S: Simd>(&self, simd: S, q: (f64x8<S>, f64), top: &SlopedTop) -> f64x8<S> {
        let splat = |v: f64| f64x8::splat(simd, v);
        let (edges, mut least) = if top.above_uav > 0.0 {
            (&self.near, splat(f64::INFINITY))
        } else {
            (&self.far, splat(top.above_uav + top.rise[1] * q.1) + splat(top.rise[0]) * q.0)
        };
        // For a UAV in the plane of the roof, only that plane counts.
        if top.above_uav == 0.0 {
            return least;
        }
        for edge in edges {
            let turn = edge.cross_from(simd, q) * splat(edge.climb / edge.k);
            least = least.min(edge.cross(simd, q) * splat(edge.slope) - turn);
        }
        least
    }

    /// Returns the least heights of the UAV past a sloped top; NaN if rounding may matter.
    #[inline(always)]
    fn of_uav_over<S: Simd>(&self, simd: S, q: (f64x8<S>, f64), z: f64x8<S>, top: &SlopedTop) -> f64x8<S> {
        let splat = |v: f64| f64x8::splat(simd, v);
        let (zero, infinite, unknown) = (splat(0.0), splat(f64::INFINITY), splat(f64::NAN));
        // The inverse of the part of the way at which the ray crosses an edge, and the UAV's height
        // if it grazes the roof there.
        let at = |edge: &Edge| {
            let cross = edge.cross(simd, q);
            let behind = cross - splat(edge.k);
            let over = (splat(edge.height) - z) * cross - edge.cross_from(simd, q) * splat(edge.climb);
            let height = z + over / behind;
            let is_close = cross.abs().simd_gt((behind * splat(OFTEN)).abs());
            (cross / splat(edge.k), is_close.select(unknown, height))
        };
        // Above its own roof the UAV is at least as high as the roof.
        let own = splat(self.top - self.rise + top.above_uav);
        let (mut near, mut of_near) = (infinite, own);
        for edge in &self.near {
            let (part, height) = at(edge);
            let is_first = part.simd_lt(near);
            (near, of_near) = (is_first.select(part, near), is_first.select(height, of_near));
        }
        let (mut far, mut of_far) = (splat(1.0), zero);
        for edge in &self.far {
            let (part, height) = at(edge);
            let is_last = part.simd_gt(far);
            (far, of_far) = (is_last.select(part, far), is_last.select(height, of_far));
        }
        // Over the footprint a receiver is below the roof, where no height is enough, or above it.
        let roof = splat(self.top - self.rise + top.above_uav + top.rise[1] * q.1) + splat(top.rise[0]) * q.0;
        let (below, margin) = (roof - z, splat(1.0 / 64.0));
        let within = below.simd_gt(margin).select(infinite, below.simd_lt(-margin).select(of_near, unknown));
        let is_within = far.simd_le(splat(1.0));
        let past = of_near.max_precise(of_far);
        let past = (of_near.simd_eq(of_near) & of_far.simd_eq(of_far)).select(past, unknown);
        is_within.select(within, past)
    }

    /// Returns the least heights of the UAV for receivers at height `z` at some places, which are
    /// relative to the UAV.
    #[inline(always)]
    pub(super) fn of_uav<S: Simd>(&self, simd: S, q: (f64x8<S>, f64), z: f64x8<S>) -> f64x8<S> {
        if let Some(top) = &self.sloped {
            return self.of_uav_over(simd, q, z, top);
        }
        let zero = f64x8::splat(simd, 0.0);
        let rise = f64x8::splat(simd, self.top) - z;
        // Over the footprint no edge is between the building and a receiver below the roof: no
        // height is enough.
        let infinite = f64x8::splat(simd, f64::INFINITY);
        let (mut far, mut near) = (infinite, rise);
        for edge in &self.far {
            let cross = edge.cross(simd, q);
            let behind = cross - f64x8::splat(simd, edge.k);
            far = far.min(behind.simd_lt(zero).select(rise * cross / behind, infinite));
        }
        if !rise.simd_gt(zero).all_true() {
            for edge in &self.near {
                let cross = edge.cross(simd, q);
                let behind = cross - f64x8::splat(simd, edge.k);
                near = near.min(behind.simd_gt(zero).select(rise * cross / behind, rise));
            }
        }
        z + rise.simd_gt(zero).select(far, near)
    }
}
