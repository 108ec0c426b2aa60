//! Truth over columns, from the definition: every crossing of the link with every grid line,
//! sorted.
//!
//! The link runs from the UAV at t = 0 to the receiver at t = 1. With dx and dy its lengths along
//! the axes, it crosses the line x = k cells at t = (1024 k − x_U)/dx. It crosses the line y = k
//! cells at t = (1024 k − y_U)/dy. All t are integers over the common denominator D = |dx|·|dy|,
//! without a factor that is 0.
//!
//! Between two neighbors of the sorted list the cells around the link do not change, so its middle
//! identifies them. They are the one cell that holds the middle, or the two beside a line that the
//! link runs along. Of two, the lower column counts. The ray is straight, so its lowest point on
//! that interval is the lower end. It is inside the solid if and only if it is below the column
//! there.
//!
//! Numbers: all positions are within 2^21 steps of each other, so D and t·D are at most 2^42. The
//! middle is over 2·D, and its position times that is below 2^66. Heights are below 2^27, so their
//! products are below 2^70. All of it is far inside i128.

use super::scene::{Board, CELL};
use crate::quantity::{LatticePoint, VOID};

/// Largest distance of positions along an axis \[1/1024 cell\].
pub(super) const MOST_STEPS: i64 = 1 << 21;

/// Returns `true` if a link is LoS.
pub(super) fn columns_truth(board: &Board, uav: LatticePoint, receiver: LatticePoint) -> bool {
    let d = [receiver.x - uav.x, receiver.y - uav.y].map(i128::from);
    let from = [uav.x, uav.y].map(i128::from);
    let denominator = d.iter().filter(|d| **d != 0).map(|d| d.abs()).product::<i128>();
    let mut at = vec![0, denominator];
    for axis in [0, 1] {
        if d[axis] != 0 {
            let n_lines = if axis == 0 { board.n_cols } else { board.n_rows };
            let lines = (0..=n_lines).map(|k| i128::try_from(k).unwrap_or(i128::MAX) * i128::from(CELL));
            // t = (line − from)/d, over the denominator; the sign of d goes into the numerator.
            let scale = denominator / d[axis].abs() * d[axis].signum();
            at.extend(lines.map(|line| (line - from[axis]) * scale).filter(|t| (0..denominator).contains(t)));
        }
    }
    at.sort_unstable();
    at.dedup();
    let (low, climb) = (i128::from(uav.z), i128::from(receiver.z - uav.z));
    at.windows(2).all(|ends| {
        let middle = [0, 1].map(|axis| from[axis] * 2 * denominator + d[axis] * (ends[0] + ends[1]));
        let Some(top) = lowest_around(board, middle, 2 * denominator, receiver) else { return true };
        let lower_end = if climb < 0 { ends[1] } else { ends[0] };
        i128::from(top) * denominator <= low * denominator + climb * lower_end
    })
}

/// Returns the lowest of the columns whose closed squares hold `position / scale`. `None` if one of
/// them is outside of the raster, void, or touches the receiver.
fn lowest_around(board: &Board, position: [i128; 2], scale: i128, receiver: LatticePoint) -> Option<i32> {
    let size = i128::from(CELL) * scale;
    let cells = position.map(|v| {
        let cell = v.div_euclid(size);
        if v.rem_euclid(size) == 0 { vec![cell - 1, cell] } else { vec![cell] }
    });
    let touches = |cell: i128, v: i64| {
        let low = cell * i128::from(CELL);
        (low..=low + i128::from(CELL)).contains(&i128::from(v))
    };
    let mut lowest = i32::MAX;
    for &east in &cells[0] {
        for &north in &cells[1] {
            if touches(east, receiver.x) && touches(north, receiver.y) {
                return None;
            }
            let top = board.top(i64::try_from(east).ok()?, i64::try_from(north).ok()?);
            lowest = lowest.min(top);
        }
    }
    (lowest != VOID).then_some(lowest)
}
