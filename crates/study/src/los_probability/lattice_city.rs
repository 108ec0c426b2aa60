//! Links of a generated city, decided in integers.
//!
//! A simulator of one link needs no scene. The walls of building (i, j) and its height are
//! functions of (i, j) and the seed, and both are on the lattice. The decision is the one defined
//! in [`crate::los`], for the very city that [`crate::city::BuiltUpCity`] builds. So the engine
//! `ray` gives the same answer link by link.
//!
//! With D and E the lengths of the link along its longer and its shorter axis, positions along it
//! are compared as multiples of 1/(D·E). All products are below 2^53.

use crate::city::BuiltUp;
use crate::quantity::{LatticePoint, STEPS_PER_UNIT, height_steps};

use super::street_grid::{GridZone, StreetGrid};

/// Walls of a generated city on the lattice.
#[derive(Debug, Clone, Copy)]
pub struct LatticeCity {
    built_up: BuiltUp,
    grid: StreetGrid,
    /// Period T \[1/1024 m\], not rounded.
    period: f64,
    /// Height that no building exceeds \[1/1024 m\].
    highest: i64,
}

impl LatticeCity {
    /// Makes the city of these parameters. No building exceeds `highest` \[1/1024 m\]; `None`
    /// stands for the limit of all such cities.
    pub fn new(built_up: BuiltUp, highest: Option<i32>) -> Self {
        let grid = StreetGrid::new(&built_up);
        let any = || height_steps(built_up.tallest()).map_or(i64::from(i32::MAX), |z| i64::from(z) + 1);
        let highest = highest.map_or_else(any, i64::from);
        LatticeCity { built_up, grid, period: grid.period() * f64::from(STEPS_PER_UNIT), highest }
    }

    /// Returns the widths.
    pub fn grid(&self) -> &StreetGrid {
        &self.grid
    }

    /// Returns the number of the period that holds a coordinate \[1/1024 m\], or of a neighbor.
    fn period_of(&self, v: i64) -> i32 {
        #[expect(clippy::cast_possible_truncation, reason = "positions are below 2^31 and the period above 8 steps")]
        let k = (v as f64 / self.period).floor() as i32;
        k
    }

    /// Returns the zone of a place \[1/1024 m\].
    pub fn zone(&self, x: i64, y: i64) -> GridZone {
        GridZone::where_street(self.built_up.building_at(x).is_none(), self.built_up.building_at(y).is_none())
    }

    /// Returns `true` if the UAV, not below the receiver, is in line of sight. Calls `height(i, j)`
    /// for the height of a building \[1/1024 m\], only for buildings that the link enters.
    pub fn los(&self, receiver: &LatticePoint, uav: &LatticePoint, mut height: impl FnMut(i32, i32) -> i32) -> bool {
        debug_assert!(uav.z >= receiver.z, "the obstructing point is the entry");
        let (dx, dy, dz) = (uav.x - receiver.x, uav.y - receiver.y, uav.z - receiver.z);
        let swapped = dy.abs() > dx.abs();
        // Along the longer axis, then along the shorter one, both pointing at the UAV.
        let (from, to) =
            if swapped { ([receiver.y, receiver.x], [dy, dx]) } else { ([receiver.x, receiver.y], [dx, dy]) };
        let [d, e] = to.map(i64::abs);
        let signs = to.map(|v| if v < 0 { -1_i64 } else { 1 });
        if d == 0 {
            // Straight up: only a building around both ends is in the way.
            return match (self.built_up.building_at(receiver.x), self.built_up.building_at(receiver.y)) {
                (Some(i), Some(j)) => i64::from(height(i, j)) <= receiver.z,
                _ => true,
            };
        }
        // The spans of building k ahead of the receiver along an axis.
        let span = |axis: usize, k: i32| {
            let [a, b] = self.built_up.building_span(k);
            if signs[axis] > 0 { [a - from[axis], b - from[axis]] } else { [from[axis] - b, from[axis] - a] }
        };
        let step = signs.map(|s| if s > 0 { 1_i32 } else { -1 });
        let mut col = self.period_of(from[0]) - step[0];
        loop {
            let [near, far] = span(0, col);
            if near >= d {
                return true;
            }
            let (near, far) = (near.max(0), far.min(d));
            if near < far {
                // The ray never falls, so above the highest building nothing blocks it.
                if dz * near >= (self.highest - receiver.z) * d {
                    return true;
                }
                // Rows between the points where the link enters and leaves the column. The guess is
                // safe by one lattice step; the comparison below is exact.
                let across = |along: i64| along as f64 * (e as f64 / d as f64);
                let world = |offset: f64| from[1] as f64 + signs[1] as f64 * offset;
                let (a, b) = (world(across(near) - 1.0), world(across(far) + 1.0));
                #[expect(clippy::cast_possible_truncation, reason = "as in period_of")]
                let row_of = |v: f64| (v / self.period).floor() as i32;
                let (first, last) = (row_of(a.min(b)), row_of(a.max(b)));
                for row in first..=last {
                    let [near_row, far_row] = span(1, row);
                    let enters_by_column = near * e >= near_row * d;
                    let entry = if enters_by_column { near * e } else { near_row * d };
                    let exit = (far * e).min(far_row * d);
                    let crosses = if e == 0 { near_row < 0 && 0 < far_row } else { entry < exit };
                    if !crosses {
                        continue;
                    }
                    let (i, j) = if swapped { (row, col) } else { (col, row) };
                    let above = i64::from(height(i, j)) - receiver.z;
                    let is_blocked =
                        if e == 0 || enters_by_column { above * d > dz * near } else { above * e > dz * near_row };
                    if is_blocked {
                        return false;
                    }
                }
            }
            col += step[0];
        }
    }
}
