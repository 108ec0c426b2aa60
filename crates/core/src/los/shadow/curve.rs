//! Ends of shadows on a curved earth.
//!
//! **Method.** Heights are measured from the plane that touches the earth below the UAV. There
//! every point at distance d is lower by c d², c = 1/2KR, and rays are straight. Heights measured
//! from any other plane are a shear of these, which leaves rays straight as well.
//!
//! Take the plane that touches the earth in the middle m of a caster. The UAV is at h' = h_U −
//! c|m|², and receivers at p are at z − c|p − m|². The roof is flat up to c r², with r the half
//! diagonal of the caster (some µm at 10 m, 0.6 mm at 100 m). So the caster has a flat roof at H,
//! known to within c r², and its shadow falls on a paraboloid. Seen through the roof's middle the
//! shadow ends at s̄ m, where s̄ is the nearer root of
//!
//! ```text
//!   (h_U − z) − s (h_U − H + c|m|²) + s² c|m|² = 0
//! ```
//!
//! There receivers are about as high as on the plane L that touches the paraboloid: L(p) = α + γ·p,
//! γ = −2c (s̄ − 1) m. They are lower than L, by at most c r'² within r' of s̄ m, where all of the
//! shadow's end lies. On the plane L the shadow ends where L(p) = h' + (H − h')(E × p)/K, with E
//! and K of [`super`]. With f = (h' − α)/(h' − H) that is behind the line
//!
//! ```text
//!   E' × p > f K,   E' = E + K/(h' − H)·(γ_y, −γ_x)
//! ```
//!
//! A difference ε of heights shifts f K by ε |K|/(h' − H). For the surely hidden receivers take L
//! with the roof lowered by c r², since all receivers are below L. For the possibly hidden
//! receivers take L lowered by c r'².
//!
//! **Horizon.** All this holds for receivers before the horizon of their own height, c|p|² < h_U −
//! z: their rays fall all the way. There a ray through a roof meets the height of the receivers for
//! the first time at the nearer root. A roof that is not above the receivers hides none of them,
//! and neither does the ground, which is not above them either.
//!
//! Rays that rise all the way, to z ≥ h_U + c|p|², are hidden only by roofs above the UAV, as over
//! a flat earth ([`super::ceiling`]). Receivers in between, whose rays fall and then rise, are
//! decided by `ray`. The horizon of prisms ([`super::horizon`]) concerns straight rays, and holds
//! with drops that are larger by c d.

use super::geometry::as_f64;
use super::plane::Plane;
use super::reach::{Bend, Reach};

/// Roundings of heights are far below this \[1/1024 m\].
pub(super) const HEIGHT_SLACK: f64 = 1.0 / 1024.0;

impl Plane {
    /// Returns how far the shadow of a roof within `bounds` reaches on receivers at `z`; `None` if it hides none of them.
    #[inline(always)]
    pub(super) fn reach(&self, bounds: [i32; 4], top: i32, z: i64) -> Option<Reach> {
        if self.curve == 0.0 { Reach::new(self.uav.z, top, z) } else { reach(self, bounds, top, z) }
    }
}

/// Returns the reach for a roof at `top` within bounds (west, south, east, north) over receivers at `z` or higher whose rays fall, or rise, all
/// the way. All are in the wanted part of the plane.
fn reach(plane: &Plane, [w, s, e, n]: [i32; 4], top: i32, z: i64) -> Option<Reach> {
    let (c, uav, farthest, top) = (plane.curve, plane.uav, plane.farthest(), i64::from(top));
    if top <= z.min(uav.z) {
        return None;
    }
    // A shadow has no end if the roof is above the UAV, as seen from the plane below it, or the end is farther than all receivers.
    if z >= uav.z {
        return Some(Reach::ENDLESS);
    }
    let middle = |low: i32, high: i32, at: i64| 0.5 * as_f64(i64::from(low) + i64::from(high) - 2 * at);
    let m = [middle(w, e, uav.x), middle(s, n, uav.y)];
    let r = 0.5 * as_f64(i64::from(e) - i64::from(w)).hypot(as_f64(i64::from(n) - i64::from(s)));
    let (above_receivers, above_roof) = (as_f64(uav.z - z), as_f64(uav.z - top));
    let distance_squared = m[0] * m[0] + m[1] * m[1];
    let distance = distance_squared.sqrt();
    let fall = c * distance_squared;
    let below = above_roof - fall;
    let cap = c * r * r + HEIGHT_SLACK;
    let unknown = || {
        let bend = Bend { gamma: [0.0; 2], far: 1.0, below: 1.0, higher: f64::INFINITY, lower: f64::INFINITY };
        Some(Reach::bent(f64::INFINITY, bend))
    };
    if below < -cap {
        // The UAV and all receivers are below the roof wherever that is lowest.
        return if as_f64(top - z) > cap { Some(Reach::ENDLESS) } else { unknown() };
    }
    // The nearer root for a point of the roof at a distance before the horizon; it grows with the
    // distance.
    let root_below = |above_roof: f64, distance: f64| {
        let fall = c * distance * distance;
        let sum = above_roof + fall;
        let square = sum * sum - 4.0 * fall * above_receivers;
        if square > 0.0 && sum > 0.0 { 2.0 * above_receivers / (sum + square.sqrt()) } else { f64::INFINITY }
    };
    let root = |distance: f64| root_below(above_roof, distance);
    let nearest = distance - r;
    // Beyond the horizon of the receivers the nearer root is before the roof.
    if c * (distance + r) * (distance + r) >= above_receivers * (1.0 - 1e-9) {
        return unknown();
    }
    if nearest > 0.0 && below > cap && root_below(above_roof + cap, nearest) * nearest > farthest {
        return Some(Reach::ENDLESS);
    }
    let horizon = |distance: f64| if distance > 0.0 { (above_receivers / c).sqrt() / distance } else { f64::INFINITY };
    let (least, most) = (root(nearest.max(0.0)), root(distance + r));
    let end = root(distance).min(horizon(distance));
    let last = if most.is_finite() { most } else { horizon(nearest) };
    let is_known = below > cap && last.is_finite() && least.is_finite();
    if !is_known {
        return unknown();
    }
    let off = last * r + (last - end).max(end - least) * distance;
    // Below the UAV the receivers' plane is below it, since f is not negative before the horizon.
    // So all receivers between the plane and the end are hidden on the plane.
    let bend = Bend {
        gamma: m.map(|m| -2.0 * c * (end - 1.0) * m),
        far: (above_receivers - fall * end * end) / below,
        below,
        higher: cap * last + HEIGHT_SLACK,
        lower: if most.is_finite() { c * off * off + HEIGHT_SLACK * (1.0 + last) } else { f64::INFINITY },
    };
    Some(Reach::bent(most, bend))
}
