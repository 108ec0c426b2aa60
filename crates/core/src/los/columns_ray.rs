//! `ray` over columns: visits every cell that the link crosses, from the receiver up.
//!
//! This is the plain engine; all exact engines give its cells. Cost: one comparison of two products
//! per crossed cell. It stops at the first blocked cell, and at the point where the ray rises above
//! the highest column.

use std::cell::Cell;
use std::ops::ControlFlow;

use super::cell_walk::{CellWalk, Crossing};
use super::inner_walk::{InnerWalk, into_cell};
use super::obstruction::{LeastHeight, Obstruction, surely_binds_less};
use crate::height_field::Columns;
use crate::quantity::{LatticePoint, VOID};

/// Decides whether the link between `uav` and `receiver` is clear of the interior of T.
///
/// Cells whose closed square contains the receiver's position are exempt. A vertical link is LoS.
/// Positions may differ by at most 2^26 lattice steps along each axis, and so may heights (not
/// checked).
pub fn columns_los(columns: &Columns, uav: LatticePoint, receiver: LatticePoint) -> bool {
    let (dx, dy) = (uav.x - receiver.x, uav.y - receiver.y);
    if (dx == 0 && dy == 0) || i64::from(columns.max_top()) <= uav.z.min(receiver.z) {
        return true;
    }
    if uav.z >= receiver.z
        && !runs_along_a_grid_line(columns, uav, receiver)
        && let Some(own) = columns.cell_towards(receiver, dx, dy)
    {
        return rising_los(columns, own, uav, receiver);
    }
    let rising = uav.z >= receiver.z;
    let climb = uav.z - receiver.z;
    let blocked = visit_intervals(columns, uav, receiver, |interval| {
        // EXACT: positions differ by at most 2^26 and heights by less than 2^28, so both products
        // are below 2^54.
        let end = if rising { interval.near } else { interval.far };
        let is_blocked = (i64::from(interval.top) - receiver.z) * end.d > end.n * climb;
        if is_blocked { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    blocked.is_continue()
}

/// Returns the least height of a receiver at `receiver`'s position from which the link to `uav` is
/// LoS, with its obstruction. The receiver's own height plays no part.
pub fn columns_least_receiver_height(columns: &Columns, uav: LatticePoint, receiver: LatticePoint) -> LeastHeight {
    // The bound is a height above the UAV, so crossings are converted to distances from the UAV.
    let from_uav = |c: Crossing| Crossing { n: c.d - c.n, d: c.d };
    least_above(columns, (uav, receiver), uav, f64::NEG_INFINITY, |near, far| (from_uav(near), from_uav(far)))
}

/// Returns the least height of a UAV at `uav`'s position from which the link to `receiver` is LoS:
/// the steepest slope seen from the receiver. The UAV's own height plays no part.
pub fn columns_least_height(columns: &Columns, uav: LatticePoint, receiver: LatticePoint) -> LeastHeight {
    least_above(columns, (uav, receiver), receiver, f64::NEG_INFINITY, |near, far| (far, near))
}

/// Returns the least lattice height of a UAV at `uav`'s position, not below `floor`, from which the
/// link to `receiver` is LoS. Returns `None` if no height is enough. Exact.
pub fn columns_least_step(columns: &Columns, uav: LatticePoint, receiver: LatticePoint, floor: i64) -> Option<i64> {
    // A column below the receiver binds nothing above its own top.
    if i64::from(columns.max_top()) <= floor.min(receiver.z) {
        return Some(floor);
    }
    columns_least_height_above(columns, uav, receiver, floor).lowest_step().map(|z| z.max(floor))
}

/// Returns [`columns_least_height`] if it is above `floor` \[1/1024 m above the datum\]; otherwise
/// some height not above `floor`.
pub(super) fn columns_least_height_above(
    columns: &Columns,
    uav: LatticePoint,
    receiver: LatticePoint,
    floor: i64,
) -> LeastHeight {
    #[expect(clippy::cast_precision_loss, reason = "a difference of heights, at most 2^28")]
    let above_receiver = (floor - receiver.z) as f64;
    least_above(columns, (uav, receiver), receiver, above_receiver, |near, far| (far, near))
}

/// Returns the least height of one end of a link, seen from its other end, `pivot`. Intervals that
/// bind no more than `floor` above the pivot may be left out.
///
/// `from_pivot` gets the ends of an interval measured from the receiver, the nearer one first. It
/// returns them measured from the pivot, the farther one first.
#[inline(always)]
fn least_above(
    columns: &Columns,
    (uav, receiver): (LatticePoint, LatticePoint),
    pivot: LatticePoint,
    floor: f64,
    from_pivot: impl Fn(Crossing, Crossing) -> (Crossing, Crossing),
) -> LeastHeight {
    let mut least = LeastHeight::Clear;
    if uav.x == receiver.x && uav.y == receiver.y {
        return least;
    }
    let above_pivot = Cell::new(least.above_uav().max(floor));
    let matters = |top: i32, near: Crossing, far: Crossing| {
        let (far, near) = from_pivot(near, far);
        !surely_binds_less(top, pivot.z, far, near, above_pivot.get())
    };
    let _ = visit_intervals_where(columns, (uav, receiver), matters, |interval| {
        if matters(interval.top, interval.near, interval.far) {
            let (far, near) = from_pivot(interval.near, interval.far);
            least.raise(Obstruction::new(interval.cell, interval.top, pivot, far, near));
            above_pivot.set(least.above_uav().max(floor));
        }
        ControlFlow::Continue(())
    });
    least
}

/// Returns the cells that the link crosses, without the receiver's own, for drawing. The ends of
/// each crossing are fractions of the way from the receiver.
pub fn columns_crossed(columns: &Columns, uav: LatticePoint, receiver: LatticePoint) -> Vec<(usize, f64, f64)> {
    let mut crossed = Vec::new();
    if uav.x == receiver.x && uav.y == receiver.y {
        return crossed;
    }
    #[expect(clippy::cast_precision_loss, reason = "for drawing")]
    let fraction = |c: Crossing| c.n as f64 / c.d as f64;
    let _ = visit_intervals(columns, uav, receiver, |interval| {
        crossed.push((interval.cell, fraction(interval.near), fraction(interval.far)));
        ControlFlow::Continue(())
    });
    crossed
}

/// The part of a ray over one cell (or along the line between two), measured from the receiver.
struct Interval {
    cell: usize,
    top: i32,
    near: Crossing,
    far: Crossing,
}

fn runs_along_a_grid_line(columns: &Columns, uav: LatticePoint, receiver: LatticePoint) -> bool {
    let [width, height] = columns.steps();
    (uav.x == receiver.x && into_cell(receiver.x, width) == 0)
        || (uav.y == receiver.y && into_cell(receiver.y, height) == 0)
}

/// Decides the hot case: the receiver in the raster, the UAV not below it, the ray not along a grid
/// line.
fn rising_los(columns: &Columns, own: usize, uav: LatticePoint, receiver: LatticePoint) -> bool {
    let mut walk = InnerWalk::new(columns, own, uav, receiver);
    let climb = uav.z - receiver.z;
    let above = i64::from(columns.max_top()) - receiver.z;
    // Crossings no longer matter once the ray is above the highest column.
    let below_the_highest = |length: i64| if climb > 0 { (above * length + climb - 1) / climb } else { i64::MAX };
    walk.reach.0 = walk.reach.0.min(below_the_highest(walk.length.0));
    walk.reach.1 = walk.reach.1.min(below_the_highest(walk.length.1));
    // PERF: one top at a time where tops are lowered and few rays are decided.
    match columns.tops_at_hand() {
        Some(tops) => is_clear(&mut walk, |cell| tops[cell], receiver.z, climb),
        None => is_clear(&mut walk, |cell| columns.top_at(cell), receiver.z, climb),
    }
}

/// Returns `true` if a ray from a receiver at height `z` with this `climb` is above the tops of all
/// cells of a walk.
#[inline(always)]
fn is_clear(walk: &mut InnerWalk, top: impl Fn(usize) -> i32, z: i64, climb: i64) -> bool {
    // EXACT: all factors are at most 2^26, so every product is at most 2^52.
    while let Some(crossing) = walk.step() {
        if (i64::from(top(walk.index)) - z) * crossing.d > crossing.n * climb {
            return false;
        }
    }
    true
}

/// Calls `visit` for every interval of the link over a column, from the receiver on, except over
/// the receiver's own cells.
#[inline(always)]
fn visit_intervals(
    columns: &Columns,
    uav: LatticePoint,
    receiver: LatticePoint,
    visit: impl FnMut(Interval) -> ControlFlow<()>,
) -> ControlFlow<()> {
    visit_intervals_where(columns, (uav, receiver), |_, _, _| true, visit)
}

/// Calls `visit` like [`visit_intervals`], but may leave out cells for which `matters` is `false`.
/// `matters` gets a top not lower than theirs, and the ends of an interval around theirs.
#[inline(always)]
fn visit_intervals_where(
    columns: &Columns,
    (uav, receiver): (LatticePoint, LatticePoint),
    matters: impl Fn(i32, Crossing, Crossing) -> bool,
    mut visit: impl FnMut(Interval) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let inner = if runs_along_a_grid_line(columns, uav, receiver) {
        None
    } else {
        columns.cell_towards(receiver, uav.x - receiver.x, uav.y - receiver.y)
    };
    if let Some(own) = inner {
        let tops = columns.tops_at_hand();
        return InnerWalk::new(columns, own, uav, receiver).visit(columns, matters, |cell, near, far| {
            let top = tops.map_or_else(|| columns.top_at(cell), |tops| tops[cell]);
            if top > VOID { visit(Interval { cell, top, near, far }) } else { ControlFlow::Continue(()) }
        });
    }
    let [width, height] = columns.steps();
    let along_column_line = uav.x == receiver.x && into_cell(receiver.x, width) == 0;
    let along_row_line = uav.y == receiver.y && into_cell(receiver.y, height) == 0;
    let is_own = |(east, north): (i64, i64)| {
        let holds = |cell: i64, size: i64, v: i64| cell * size <= v && v <= (cell + 1) * size;
        holds(east, width, receiver.x) && holds(north, height, receiver.y)
    };
    let top = |cell: (i64, i64)| if is_own(cell) { VOID } else { columns.top(cell.0, cell.1) };

    let mut walk = CellWalk::new((receiver.x, receiver.y), (uav.x, uav.y), [width, height]);
    let mut near = Crossing { n: 0, d: 1 };
    loop {
        let exit = walk.exit();
        let far = exit.unwrap_or(Crossing { n: 1, d: 1 });
        let (east, north) = walk.cell;
        let mut obstacle = ((east, north), top((east, north)));
        // Along the line between two cells the ray is inside the solid only if both are.
        for (on_line, other) in [(along_column_line, (east - 1, north)), (along_row_line, (east, north - 1))] {
            if on_line && top(other) < obstacle.1 {
                obstacle = (other, top(other));
            }
        }
        if obstacle.1 > VOID
            && let Some(cell) = columns.index(obstacle.0.0, obstacle.0.1)
        {
            visit(Interval { cell, top: obstacle.1, near, far })?;
        }
        let Some(crossing) = exit else { return ControlFlow::Continue(()) };
        near = crossing;
        walk.advance();
    }
}
