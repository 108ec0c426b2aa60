//! The planes below which one caster hides receivers at differing heights. The derivation is in the
//! essay of [`super`].

use super::curve::HEIGHT_SLACK;
use super::geometry::{as_f64, cross, sub};
use super::outline::ROUNDING;
use super::plane::Plane;

/// A plane of heights over the grid: `at + per_col · column + per_q · q` \[lattice steps\].
#[derive(Debug, Clone, Copy)]
pub(super) struct Slope {
    pub(super) at: f64,
    pub(super) per_col: f64,
    pub(super) per_q: f64,
}

/// The ceiling of one prism: within its cone, behind its near edges, it hides the receivers below
/// all these planes.
#[derive(Debug, Default)]
pub(super) struct Ceiling {
    /// Planes through the UAV and one upper edge each: the far edges of a roof below the UAV, else
    /// the near edges.
    pub(super) slopes: Vec<Slope>,
    /// Receivers at this height or above are not surely hidden \[lattice steps\].
    pub(super) cap: f64,
    /// Receivers at this height or above are seen in any case \[lattice steps\].
    pub(super) cap_maybe: f64,
    /// Receivers nearer to a plane than this are in doubt \[lattice steps\].
    pub(super) margin: f64,
}

impl Ceiling {
    /// Makes this the ceiling of a convex counterclockwise ring with its roof at `top`.
    #[inline(always)]
    pub(super) fn cast(&mut self, plane: &Plane, ring: &[[i32; 2]], top: i32) {
        let (ux, uy) = (plane.uav.x, plane.uav.y);
        let rise = i64::from(top) - plane.uav.z;
        #[expect(clippy::cast_precision_loss, reason = "differences of heights are below 2^53")]
        let (rise_steps, uav_z) = (rise as f64, plane.uav.z as f64);
        self.cap = if rise > 0 { f64::INFINITY } else { f64::from(top) };
        self.cap_maybe = self.cap;
        self.slopes.clear();
        let from_uav = |v: [i32; 2]| [i64::from(v[0]) - ux, i64::from(v[1]) - uy];
        let mut a = from_uav(ring[ring.len() - 1]);
        let mut magnitude = 0.0_f64;
        let mut steepest = 0.0_f64;
        for &vertex in ring {
            let b = from_uav(vertex);
            let edge = sub(b, a);
            let k = cross(edge, a);
            if (rise < 0 && k < 0) || (rise >= 0 && k > 0) {
                #[expect(clippy::cast_precision_loss, reason = "rounded once, within the margin")]
                let (ex, ey, k) = (edge[0] as f64, edge[1] as f64, k as f64);
                let slope = rise_steps / k;
                let (per_q, per_col) = (ex * slope, -(ey * plane.step) * slope);
                self.slopes.push(Slope { at: uav_z - per_col * plane.origin, per_col, per_q });
                let columns = plane.origin.abs() + plane.last_column;
                magnitude = magnitude.max(per_q.abs() * plane.q_max + per_col.abs() * columns);
                steepest = steepest.max(per_col.abs());
            }
            a = b;
        }
        self.margin = ROUNDING * (magnitude + uav_z.abs() + 1.0) + steepest * plane.unevenness;
    }

    /// Makes this the ceiling on a curved earth of a ring. Its shadow reaches at most `far` times
    /// its distance.
    ///
    /// Measured from the plane that touches the earth in the middle of the roof, the roof is flat
    /// up to c r². The planes go through the edges of the flat roof, and all are sheared alike into
    /// heights as the UAV sees them. Receivers are lower as well; [`Plane::falls`] accounts for
    /// that.
    #[inline(never)]
    pub(super) fn cast_curved(&mut self, plane: &Plane, ring: &[[i32; 2]], (top, bounds): (i32, [i32; 4]), far: f64) {
        let (c, (ux, uy)) = (plane.curve, (plane.uav.x, plane.uav.y));
        let [w, s, e, n] = bounds.map(i64::from);
        let r = 0.5 * as_f64(e - w).hypot(as_f64(n - s));
        let middle = [0.5 * as_f64(w + e - 2 * ux), 0.5 * as_f64(s + n - 2 * uy)];
        let distance = middle[0].hypot(middle[1]);
        // Fall of heights over the flat roof to the east and the north.
        let shear = middle.map(|m| 2.0 * c * m);
        let (above_roof, uav_z) = (as_f64(plane.uav.z - i64::from(top)), as_f64(plane.uav.z));
        let below = above_roof - c * distance * distance;
        let thickness = c * r * r + HEIGHT_SLACK;
        let farthest = plane.farthest();
        let factor = far.min(farthest / (distance - r).max(1.0));
        self.slopes.clear();
        self.cap = if below < 0.0 { f64::INFINITY } else { f64::from(top) };
        // Before the horizon of the roof no ray comes down behind it that was above it.
        let is_before_horizon = c * farthest * (distance + r) < above_roof * (1.0 - 1e-9);
        self.cap_maybe = if is_before_horizon { self.cap } else { f64::INFINITY };
        if below.abs() < thickness {
            self.slopes.push(Slope { at: 0.0, per_col: 0.0, per_q: 0.0 });
            (self.cap_maybe, self.margin) = (f64::INFINITY, f64::INFINITY);
            return;
        }
        let from_uav = |v: [i32; 2]| [i64::from(v[0]) - ux, i64::from(v[1]) - uy];
        let columns = plane.origin.abs() + plane.last_column;
        let (mut magnitude, mut steepest) = (0.0_f64, 0.0_f64);
        let mut a = from_uav(ring[ring.len() - 1]);
        for &vertex in ring {
            let b = from_uav(vertex);
            let edge = sub(b, a);
            let k = cross(edge, a);
            if (below > 0.0 && k < 0) || (below < 0.0 && k > 0) {
                let slope = -below / as_f64(k);
                let [ex, ey] = edge.map(as_f64);
                let per_q = ex * slope - shear[1];
                let per_col = (-ey * slope - shear[0]) * plane.step;
                self.slopes.push(Slope { at: uav_z - per_col * plane.origin, per_col, per_q });
                let terms_q = (ex * slope).abs() + shear[1].abs();
                let terms_col = ((ey * slope).abs() + shear[0].abs()) * plane.step;
                magnitude = magnitude.max(terms_q * plane.q_max + terms_col * columns);
                steepest = steepest.max(per_col.abs());
            }
            a = b;
        }
        let falls = c * farthest * farthest + 2.0 * c * farthest * plane.unevenness * plane.step;
        self.margin = 4.0 * ROUNDING * (magnitude + uav_z.abs() + falls + 1.0)
            + (steepest + 2.0 * c * farthest * plane.step) * plane.unevenness
            + thickness * factor;
    }

    /// Returns bounds on the least of the planes over rows with `q` from `q.0` to `q.1` and columns
    /// from `cols.0` to `cols.1`. They are relative to receivers at their heights over the datum.
    ///
    /// The least of several planes is concave, so over a rectangle it is lowest at a corner.
    #[inline(always)]
    pub(super) fn range(&self, plane: &Plane, q: (f64, f64), cols: (f64, f64)) -> (f64, f64) {
        let (mut low, mut high) = (f64::INFINITY, f64::INFINITY);
        for s in &self.slopes {
            let (a, b) = (s.at + s.per_q * q.0, s.at + s.per_q * q.1);
            let (c, d) = (s.per_col * cols.0, s.per_col * cols.1);
            low = low.min(a.min(b) + c.min(d));
            high = high.min(a.max(b) + c.max(d));
        }
        let (least, most) = plane.falls(q, cols);
        (low + least - self.margin, high + most + self.margin)
    }
}
