//! The planes below which one caster hides receivers at differing heights. The derivation is in the essay of
//! [`super`].

use super::geometry::{cross, sub};
use super::outline::{Plane, ROUNDING};

/// A plane of heights over the grid: `at + per_col · column + per_q · q` \[lattice steps\].
#[derive(Debug, Clone, Copy)]
pub(super) struct Slope {
    pub(super) at: f64,
    pub(super) per_col: f64,
    pub(super) per_q: f64,
}

/// The ceiling of one prism: within its cone, behind its near edges, it hides the receivers below all these planes.
#[derive(Debug, Default)]
pub(super) struct Ceiling {
    /// Planes through the UAV and one upper edge each: the far ones of a roof below the UAV, else the near ones.
    pub(super) slopes: Vec<Slope>,
    /// Receivers at this height or above are seen in any case \[lattice steps\].
    pub(super) cap: f64,
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

    /// Bounds on the least of the planes over rows with `q` from `q.0` to `q.1` and columns from `cols.0` to `cols.1`.
    ///
    /// The least of several planes is concave, so over a rectangle it is lowest at a corner.
    #[inline(always)]
    pub(super) fn range(&self, q: (f64, f64), cols: (f64, f64)) -> (f64, f64) {
        let (mut low, mut high) = (self.cap, self.cap);
        for s in &self.slopes {
            let (a, b) = (s.at + s.per_q * q.0, s.at + s.per_q * q.1);
            let (c, d) = (s.per_col * cols.0, s.per_col * cols.1);
            low = low.min(a.min(b) + c.min(d));
            high = high.min(a.max(b) + c.max(d));
        }
        (low - self.margin, high + self.margin)
    }
}
