//! The reach of shadows, as factors of the distance from the UAV.

/// Rows whose bounds are computed at once.
pub(super) const LANES: usize = 8;

/// Beyond every position of a grid and its UAV \[lattice steps\].
pub(super) const FAR: f64 = (1_u64 << 40) as f64;

/// The reach of a shadow along the rays through a footprint, as factors of the distance from the
/// UAV in the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reach {
    /// Begin of the shadow, relative to the footprint's near edges. It is 1, or more for receivers
    /// above the roof and if another caster hides nearer receivers.
    pub(super) near: f64,
    /// End of the shadow, relative to the far edges; infinite if it has none.
    pub(super) far: f64,
    /// The curve of its end on a curved earth.
    pub(super) bend: Option<Bend>,
}

impl Reach {
    /// From the near edges on without an end.
    pub(super) const ENDLESS: Reach = Reach { near: 1.0, far: f64::INFINITY, bend: None };

    /// Returns the reach for a roof at `top`, seen by receivers at `z`; `None` if it hides nothing
    /// from them.
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

    /// Makes a reach that ends along a curve, at a factor of at most `far`.
    pub(super) fn bent(far: f64, bend: Bend) -> Reach {
        Reach { far, bend: Some(bend), ..Reach::ENDLESS }
    }

    /// Returns the length of the shadow behind an object at a distance from the UAV, in the unit of
    /// `distance`.
    pub(super) fn behind(self, distance: f64) -> f64 {
        (self.far - 1.0) * distance
    }

    /// Returns the reach from `begin` on, if that is farther than its own begin.
    #[inline(always)]
    pub(super) fn from(self, begin: f64) -> Reach {
        Reach { near: self.near.max(begin), ..self }
    }

    /// Returns the box (west, south, east, north of the UAV at `u`) of all u + s(F − u) for a
    /// footprint F within `bounds` \[lattice steps\]. It is a lattice step wider than rounding can
    /// matter.
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
    /// Rise of the plane of the receivers to the east and the north.
    pub(super) gamma: [f64; 2],
    /// f: end of the shadow behind the far edges, as a factor.
    pub(super) far: f64,
    /// Height of the UAV above the roof \[1/1024 m\].
    pub(super) below: f64,
    /// Bounds on how much higher hidden receivers, and how much lower others, may be than assumed
    /// \[1/1024 m\].
    pub(super) higher: f64,
    pub(super) lower: f64,
}

/// A far edge of a caster as it bounds a shadow. Receivers are surely hidden if
/// `cross(edge, p − u)` is more than `sure`, and possibly hidden if it is more than `maybe`.
pub(super) struct FarEdge {
    pub(super) edge: [f64; 2],
    /// Magnitudes of the terms of the edge.
    pub(super) terms: [f64; 2],
    pub(super) sure: f64,
    pub(super) maybe: f64,
}

impl Bend {
    /// Returns the bound of an edge that does not face the UAV, with its `K`.
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
