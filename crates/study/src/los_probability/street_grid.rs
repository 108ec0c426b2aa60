//! Manhattan grid without heights: the buildings that a link crosses, and the crossings.
//!
//! Streets are {x mod T ≤ s} and {y mod T ≤ s}; building (i, j) is \[iT + s, (i + 1)T\] × \[jT + s,
//! (j + 1)T\] with T = s + w. A building is convex, so a link crosses it in one interval of its
//! ground distance t from the receiver. The intervals are found building by building, column after
//! column along the longer of the link's two axes. A column is no wider than w, so the link meets
//! at most two rows in it.
//!
//! Saboor et al. 2023 (section III-B, step 3) test the points at which the link hits walls instead.
//! A link along the diagonal of the grid enters every building through its corner and hits no wall
//! inside. By that test it would meet no building at all.

use crate::city::BuiltUp;

/// Widths of a Manhattan grid \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreetGrid {
    street: f64,
    period: f64,
}

/// Zone of a place in a Manhattan grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridZone {
    /// Street along y: x mod T in \[0, s\], y mod T in (s, T).
    StreetAlongY,
    /// Street along x.
    StreetAlongX,
    /// Crossing of two streets.
    Crossroad,
    /// Footprint of a building.
    Building,
}

impl GridZone {
    /// Returns the zone of a place; `x` and `y` are `true` if that coordinate is in a street.
    pub(super) fn where_street(x: bool, y: bool) -> Self {
        match (x, y) {
            (true, true) => GridZone::Crossroad,
            (true, false) => GridZone::StreetAlongY,
            (false, true) => GridZone::StreetAlongX,
            (false, false) => GridZone::Building,
        }
    }
}

/// Straight link over the grid, from the receiver to the UAV. Heights are above ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridLink {
    /// Receiver: x, y, height \[m\].
    pub receiver: [f64; 3],
    /// UAV: x, y, height \[m\].
    pub uav: [f64; 3],
}

/// Building that a link crosses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Index of the building along x and y.
    pub building: (i32, i32),
    /// Ground distance from the receiver at which the link enters it \[m\].
    pub t_in: f64,
    /// Ground distance at which the link leaves it, or ends \[m\].
    pub t_out: f64,
}

impl GridLink {
    /// Returns the ground distance r between the ends \[m\].
    pub fn ground_distance(&self) -> f64 {
        (self.uav[0] - self.receiver[0]).hypot(self.uav[1] - self.receiver[1])
    }

    /// Returns the height of the ray \[m\] at ground distance `t` from the receiver, of `r` in all.
    #[inline]
    pub fn height_at(&self, t: f64, r: f64) -> f64 {
        self.receiver[2] + (self.uav[2] - self.receiver[2]) * (t / r)
    }
}

impl StreetGrid {
    /// Returns the grid of a city.
    pub fn new(built_up: &BuiltUp) -> Self {
        StreetGrid { street: built_up.street_width(), period: built_up.period() }
    }

    /// Returns the width s of a street \[m\].
    pub fn street(&self) -> f64 {
        self.street
    }

    /// Returns the period T = s + w \[m\].
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Returns the zone of a place.
    pub fn zone(&self, x: f64, y: f64) -> GridZone {
        let is_street = |v: f64| v.rem_euclid(self.period) <= self.street;
        GridZone::where_street(is_street(x), is_street(y))
    }

    /// Calls `visit` for every building whose interior the link enters, from the receiver on, until
    /// it returns `false`. Of two buildings in one column the nearer comes first.
    pub fn for_each_crossed(&self, link: &GridLink, mut visit: impl FnMut(Crossing) -> bool) {
        let (dx, dy) = (link.uav[0] - link.receiver[0], link.uav[1] - link.receiver[1]);
        let r = dx.hypot(dy);
        if r == 0.0 {
            return;
        }
        // `a` is along the longer axis. A link towards the west or south is mirrored, x → s − x,
        // which maps streets to streets and building k to −k − 1.
        let swapped = dy.abs() > dx.abs();
        let (from, step) = if swapped { ([1, 0], [dy, dx]) } else { ([0, 1], [dx, dy]) };
        let mirrored = step.map(|d| d < 0.0);
        let start = |k: usize| {
            let v = link.receiver[from[k]];
            if mirrored[k] { self.street - v } else { v }
        };
        let (a0, b0) = (start(0), start(1));
        let (cos, sin) = (step[0].abs() / r, step[1].abs() / r);
        let building = |col: f64, row: f64| {
            #[expect(clippy::cast_possible_truncation, reason = "a city has far fewer than 2^31 columns")]
            let index = |k: f64, mirrored: bool| if mirrored { -(k as i32) - 1 } else { k as i32 };
            let (col, row) = (index(col, mirrored[0]), index(row, mirrored[1]));
            if swapped { (row, col) } else { (col, row) }
        };
        let mut col = floor(a0 / self.period);
        loop {
            let t_west = (col * self.period + self.street - a0) / cos;
            if t_west >= r {
                return;
            }
            let (t0, t1) = (t_west.max(0.0), (((col + 1.0) * self.period - a0) / cos).min(r));
            if t0 < t1 {
                let mut row = floor((b0 + t0 * sin) / self.period);
                // Last row with its south wall below the point where the link leaves the column.
                let last = -floor((self.street - b0 - t1 * sin) / self.period) - 1.0;
                while row <= last {
                    let (south, north) = (row * self.period + self.street - b0, (row + 1.0) * self.period - b0);
                    let (t_in, t_out) = if sin > 0.0 {
                        (t0.max(south / sin), t1.min(north / sin))
                    } else if south < 0.0 && north > 0.0 {
                        (t0, t1)
                    } else {
                        // Along a wall the link touches the building without entering it.
                        (0.0, 0.0)
                    };
                    if t_in < t_out && !visit(Crossing { building: building(col, row), t_in, t_out }) {
                        return;
                    }
                    row += 1.0;
                }
            }
            col += 1.0;
        }
    }
}

/// Returns the largest integer not above `v`, for |v| below 2^31. `f64::floor` would be a call on
/// targets without SSE4.1.
#[inline]
fn floor(v: f64) -> f64 {
    #[expect(clippy::cast_possible_truncation, reason = "within i32 as documented")]
    let truncated = f64::from(v as i32);
    if truncated > v { truncated - 1.0 } else { truncated }
}
