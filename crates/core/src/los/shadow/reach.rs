//! How far shadows reach, as factors of the distance from the UAV.

/// Rows whose bounds are computed at once.
pub(super) const LANES: usize = 8;

/// Beyond every place of a grid and its UAV \[lattice steps\].
pub(super) const FAR: f64 = (1_u64 << 40) as f64;

/// How far along the rays through a footprint its shadow reaches, as factors of the distance from the UAV in the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reach {
    /// Where the shadow begins, relative to the footprint's near edges: 1, or more for receivers above the roof, and where
    /// nearer receivers are hidden by another.
    pub(super) near: f64,
    /// Where it ends, relative to the far edges; infinite if never.
    pub(super) far: f64,
    /// What more its end is on a curved earth.
    pub(super) bend: Option<Bend>,
}

impl Reach {
    /// From the near edges on without an end.
    pub(super) const ENDLESS: Reach = Reach { near: 1.0, far: f64::INFINITY, bend: None };

    /// The reach for a roof at `top`, seen by receivers at `z`; `None` if it hides nothing from them.
    #[inline(always)]
    pub(super) fn new(uav_z: i64, top: i32, z: i64) -> Option<Reach> {
        let top = i64::from(top);
        #[expect(clippy::cast_precision_loss, reason = "differences of heights are below 2^53")]
        let quotient = |num: i64, den: i64| num as f64 / den as f64;
        if top <= z && top <= uav_z {
            None
        } else if top < uav_z {
            Some(Reach { far: quotient(uav_z - z, uav_z - top), ..Reach::ENDLESS })
        } else if top >= z {
            Some(Reach::ENDLESS)
        } else {
            Some(Reach { near: quotient(z - uav_z, top - uav_z), ..Reach::ENDLESS })
        }
    }

    /// One that ends at a factor at most, along a curve.
    pub(super) fn bent(far: f64, bend: Bend) -> Reach {
        Reach { far, bend: Some(bend), ..Reach::ENDLESS }
    }

    /// How far behind what is at a distance from the UAV the shadow reaches, in its unit.
    pub(super) fn behind(self, distance: f64) -> f64 {
        (self.far - 1.0) * distance
    }

    /// The reach from `begin` on, if that is farther than its own begin.
    #[inline(always)]
    pub(super) fn from(self, begin: f64) -> Reach {
        Reach { near: self.near.max(begin), ..self }
    }

    /// The box (west, south, east, north of the UAV at `u`) of all u + s(F − u) for a footprint F within `bounds`, a
    /// lattice step wider than rounding can matter \[lattice steps\].
    #[inline(always)]
    pub(super) fn extent(self, bounds: [i32; 4], u: (i64, i64)) -> [f64; 4] {
        let Reach { near, far, .. } = self;
        #[expect(clippy::cast_precision_loss, reason = "differences of at most 2^33")]
        let relative = |v: i32, u: i64| (i64::from(v) - u) as f64;
        let least = |v: f64| if v < 0.0 { (far * v).max(-FAR) } else { near * v } - 1.0;
        let most = |v: f64| -least(-v);
        let [w, s, e, n] = bounds;
        [least(relative(w, u.0)), least(relative(s, u.1)), most(relative(e, u.0)), most(relative(n, u.1))]
    }
}

/// The end of a shadow on a curved earth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bend {
    /// How the plane of the receivers rises to the east and the north.
    pub(super) gamma: [f64; 2],
    /// f: how far behind the far edges the shadow ends, as a factor.
    pub(super) far: f64,
    /// By how much the roof is below the UAV \[1/1024 m\].
    pub(super) below: f64,
    /// By how much receivers may be higher than is reckoned with where they are hidden, and lower where they are not \[1/1024 m\].
    pub(super) higher: f64,
    pub(super) lower: f64,
}

/// A far edge of a caster as it bounds a shadow: `cross(edge, p − u)` is more than `sure` where receivers are surely hidden, and more
/// than `maybe` where they may be.
pub(super) struct FarEdge {
    pub(super) edge: [f64; 2],
    /// What the edge without a bend adds to the magnitude of its terms.
    pub(super) terms: [f64; 2],
    pub(super) sure: f64,
    pub(super) maybe: f64,
}

impl Bend {
    /// An edge that does not face the UAV, with its `K`.
    #[inline(always)]
    pub(super) fn far_edge(&self, [ex, ey]: [f64; 2], k: f64) -> FarEdge {
        let ratio = k / self.below;
        let [by_x, by_y] = [ratio * self.gamma[1], -ratio * self.gamma[0]];
        let end = k * self.far;
        FarEdge {
            edge: [ex + by_x, ey + by_y],
            terms: [ex.abs() + by_x.abs(), ey.abs() + by_y.abs()],
            sure: end - ratio * self.higher,
            maybe: end + ratio * self.lower,
        }
    }
}
