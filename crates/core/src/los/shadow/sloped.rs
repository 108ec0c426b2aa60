//! Shadows of sloped roofs.
//!
//! **Method.** Let the roof of a convex footprint F be a plane, lower than the UAV at u by α(p)
//! over p. Let q = p − u for a receiver at p, lower than the UAV by Z. A point of the ray is u +
//! q/s, s > 1, and the ray is below the roof there if Z/s > α(u + q/s). Since α is linear that is
//! `s·α₀ + g·q < Z`, where α₀ = α(u) and g is its gradient. So the receiver is hidden if and only
//! if some s meets
//!
//! ```text
//!   s > 1,      E × q > s·K for every edge,      s·α₀ + g·q < Z
//! ```
//!
//! These are bounds on s, each linear in q. Some s meets them all if every lower bound is below
//! every upper one (Fourier–Motzkin), and each such pair is a half-plane. An edge that faces u
//! (K > 0) with s > 1 is the near edge; two edges are a side of the cone. If u is below the plane
//! continued to it (α₀ < 0), the roof bounds s from below, else (α₀ > 0) from above:
//!
//! ```text
//!   α₀ > 0 with the far edges (K < 0):    (αB − βA) × q > Z·K      α and β at the ends A and B of the edge, from u
//!   α₀ < 0 with the near edges (K > 0):   (αB − βA) × q < Z·K
//!   α₀ ≥ 0 with s > 1:                    the receiver is below the plane; follows from the others if no corner is below the receiver
//! ```
//!
//! A flat roof has α = β, and αB − βA = αE. Heights of corners are integers and so are αB − βA
//! (below 2^55), Z and K. Solved for the receiver's height, a pair is the plane through the UAV and
//! the two ends of the edge on the roof ([`super::ceiling`]).

use super::ceiling::{Ceiling, Slope};
use super::geometry::{as_f64, cross, sub};
use super::outline::{Magnitude, Outline, ROUNDING};
use super::plane::Plane;
use super::reach::Reach;
use crate::height_field::{Caster, Casters, RoofPlane};
use crate::quantity::LatticePoint;

/// A sloped roof as the UAV of a plane sees it.
pub(super) struct SlopedRoof<'a> {
    ring: &'a [[i32; 2]],
    heights: &'a [i32],
    roof: RoofPlane,
}

impl<'a> SlopedRoof<'a> {
    /// Returns the roof of a caster; `None` if it is flat.
    #[inline(always)]
    pub(super) fn of(casters: &'a Casters, caster: &Caster) -> Option<Self> {
        let (ring, heights) = (casters.ring(caster), casters.heights(caster)?);
        Some(SlopedRoof { ring, heights, roof: RoofPlane::through(ring, heights) })
    }

    /// Returns the height of the UAV above the plane of the roof, times the plane's area.
    #[inline(always)]
    fn above(&self, plane: &Plane) -> i128 {
        self.roof.above(plane.uav)
    }

    /// Returns the edges of the ring from u: A, E and K, and αB − βA.
    #[inline(always)]
    fn edges(&self, plane: &Plane) -> impl Iterator<Item = RoofEdge> + use<'a> {
        let LatticePoint { x, y, z } = plane.uav;
        let (ring, heights) = (self.ring, self.heights);
        let corner = move |k: usize| {
            let at = [i64::from(ring[k][0]) - x, i64::from(ring[k][1]) - y];
            (at, z - i64::from(heights[k]))
        };
        let mut last = corner(ring.len() - 1);
        (0..ring.len()).map(move |k| {
            let (a, alpha) = last;
            let (b, beta) = corner(k);
            last = (b, beta);
            let edge = sub(b, a);
            let (of_a, of_b) = ([beta * a[0], beta * a[1]], [alpha * b[0], alpha * b[1]]);
            RoofEdge { from: a, edge, k: cross(edge, a), upper: sub(of_b, of_a) }
        })
    }
}

/// An edge of a sloped roof as seen from the UAV.
#[derive(Debug, Clone, Copy)]
struct RoofEdge {
    /// A, its start.
    from: [i64; 2],
    /// E, from A to B.
    edge: [i64; 2],
    /// E × A.
    k: i64,
    /// αB − βA.
    upper: [i64; 2],
}

impl Outline {
    /// Makes this the outline of the shadow of a caster on receivers at height `z`; returns `false`
    /// if it has no wanted cell. The `reach` is that of a flat roof as high as the highest corner.
    #[inline(always)]
    pub(super) fn cast_roof(
        &mut self,
        plane: &Plane,
        (casters, caster): (&Casters, &Caster),
        reach: Reach,
        z: i64,
    ) -> bool {
        match SlopedRoof::of(casters, caster) {
            None => self.cast(plane, casters.ring(caster), caster.bounds, reach),
            Some(roof) => self.cast_sloped(plane, &roof, caster.bounds, reach, z),
        }
    }

    #[inline(never)]
    fn cast_sloped(&mut self, plane: &Plane, roof: &SlopedRoof<'_>, bounds: [i32; 4], reach: Reach, z: i64) -> bool {
        let uav = plane.uav;
        if !self.begin(plane, reach.extent(bounds, (uav.x, uav.y))) {
            return false;
        }
        let (above, below_uav) = (roof.above(plane), uav.z - z);
        let mut magnitude = Magnitude::default();
        let mut was_facing = roof.edges(plane).last().is_some_and(|edge| edge.k > 0);
        for RoofEdge { from, edge, k, upper } in roof.edges(plane) {
            let is_facing = k > 0;
            // EXACT: Z has no rounding, and the factor of a flat roof has one. So the bound on the
            // offset holds here as well.
            let offset = as_f64(below_uav) * as_f64(k);
            if is_facing {
                self.add(plane, edge, reach.near * as_f64(k), &mut magnitude);
                if above < 0 {
                    self.add_upper(plane, [-upper[0], -upper[1]], -offset, &mut magnitude);
                }
            } else if k == 0 {
                self.add(plane, edge, 0.0, &mut magnitude);
            } else if above > 0 {
                self.add_upper(plane, upper, offset, &mut magnitude);
            }
            if was_facing != is_facing {
                let along = if was_facing { from } else { [-from[0], -from[1]] };
                self.add(plane, along, 0.0, &mut magnitude);
            }
            was_facing = is_facing;
        }
        let is_partly_below = || roof.heights.iter().any(|height| i64::from(*height) < z);
        if above == 0 || (above > 0 && is_partly_below()) {
            let [east, north] = roof.roof.rise();
            #[expect(clippy::cast_precision_loss, reason = "rounded once, within the margin")]
            let offset = roof.roof.above(LatticePoint { z, ..uav }) as f64;
            self.add_upper(plane, [north, -east], offset, &mut magnitude);
        }
        self.finish(plane, &magnitude)
    }

    /// Adds the half-plane `cross(upper, p − u) > k`, which may be everything or nothing.
    #[inline(always)]
    fn add_upper(&mut self, plane: &Plane, upper: [i64; 2], k: f64, magnitude: &mut Magnitude) {
        if upper != [0, 0] {
            self.add(plane, upper, k, magnitude);
        } else if k >= 0.0 {
            self.close();
        }
    }
}

impl Ceiling {
    /// Makes this the ceiling of a sloped roof whose highest corner is at `top`.
    #[inline(never)]
    pub(super) fn cast_sloped(&mut self, plane: &Plane, roof: &SlopedRoof<'_>, top: i32) {
        let uav = plane.uav;
        let above = roof.above(plane);
        let (uav_z, columns) = (as_f64(uav.z), plane.origin.abs() + plane.last_column);
        self.slopes.clear();
        self.cap = f64::INFINITY;
        self.cap_maybe = if i64::from(top) <= uav.z { f64::from(top) } else { f64::INFINITY };
        let (mut magnitude, mut steepest) = (0.0_f64, 0.0_f64);
        let mut add = |at: f64, [east, north]: [f64; 2]| {
            let per_col = east * plane.step;
            magnitude = magnitude.max(at.abs() + north.abs() * plane.q_max + per_col.abs() * columns);
            steepest = steepest.max(per_col.abs());
            self.slopes.push(Slope { at: at - per_col * plane.origin, per_col, per_q: north });
        };
        for RoofEdge { k, upper, .. } in roof.edges(plane) {
            if (above > 0 && k < 0) || (above < 0 && k > 0) {
                // z_U − ((αB − βA) × q)/K
                let [ux, uy] = upper.map(as_f64);
                add(uav_z, [uy / as_f64(k), -(ux / as_f64(k))]);
            }
        }
        if above >= 0 {
            let area = as_f64(roof.roof.area());
            #[expect(clippy::cast_precision_loss, reason = "rounded once, within the margin")]
            let at = uav_z - above as f64 / area;
            add(at, roof.roof.rise().map(|rise| as_f64(rise) / area));
        }
        // Terms of the roof's own height may nearly cancel, so its margin counts them as well.
        #[expect(clippy::cast_precision_loss, reason = "a bound")]
        let of_roof = uav_z.abs() + (above as f64 / as_f64(roof.roof.area())).abs();
        self.margin = 2.0 * ROUNDING * (magnitude + of_roof + 1.0) + steepest * plane.unevenness;
    }
}
