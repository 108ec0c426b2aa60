//! The cells that a segment crosses, in order, in exact integers.
//!
//! After Amanatides & Woo 1987, with the crossing parameters kept as products instead of quotients.
//! The next vertical grid line is met at `t = nx/|dx|`, the next horizontal one at `t = ny/|dy|`.
//! The nearer of the two is found by comparing `nx·|dy|` with `ny·|dx|`. If both are met at once,
//! at a lattice corner, both indices step at once. So cells that are only touched at a corner are
//! never visited.

/// A crossing of a grid line at parameter `n/d` of the segment, with `d > 0`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Crossing {
    pub(super) n: i64,
    pub(super) d: i64,
}

/// A walk over rectangular cells along a segment with at least one nonzero component.
///
/// On a grid line parallel to the segment the walk visits the cells north or east of the line
/// (half-open).
#[derive(Debug, Clone)]
pub(super) struct CellWalk {
    /// Current cell, counted from the origin to the east and to the north.
    pub(super) cell: (i64, i64),
    step: (i64, i64),
    size: [i64; 2],
    next: (i64, i64),
    length: (i64, i64),
}

/// Farther than any grid line of the proven range, so that an axis without motion never comes next.
const NEVER: i64 = 1 << 32;

impl CellWalk {
    /// Starts a walk from `from` towards `to`. Positions are relative to the corner of cell (0, 0);
    /// cells have width and height `size`.
    pub(super) fn new(from: (i64, i64), to: (i64, i64), size: [i64; 2]) -> Self {
        let axis = |from: i64, to: i64, size: i64| {
            let first = if to < from { (from - 1).div_euclid(size) } else { from.div_euclid(size) };
            let (step, next) = match to.cmp(&from) {
                std::cmp::Ordering::Greater => (1, (first + 1) * size - from),
                std::cmp::Ordering::Less => (-1, from - first * size),
                std::cmp::Ordering::Equal => (0, NEVER),
            };
            (first, step, next, (to - from).abs())
        };
        let (col, step_x, next_x, length_x) = axis(from.0, to.0, size[0]);
        let (row, step_y, next_y, length_y) = axis(from.1, to.1, size[1]);
        CellWalk {
            cell: (col, row),
            step: (step_x, step_y),
            size,
            next: (next_x, next_y),
            length: (length_x, length_y),
        }
    }

    /// Returns the crossing at which the segment leaves the current cell; `None` if it ends before
    /// or at the border.
    #[inline]
    pub(super) fn exit(&self) -> Option<Crossing> {
        let by_x = Crossing { n: self.next.0, d: self.length.0 };
        let by_y = Crossing { n: self.next.1, d: self.length.1 };
        let first = if self.x_is_next() { by_x } else { by_y };
        (first.n < first.d).then_some(first)
    }

    #[inline]
    fn x_is_next(&self) -> bool {
        self.next.0 * self.length.1 <= self.next.1 * self.length.0 && self.length.0 > 0
    }

    /// Steps into the next cell.
    #[inline]
    pub(super) fn advance(&mut self) {
        let (ex, ey) = (self.next.0 * self.length.1, self.next.1 * self.length.0);
        if self.length.0 > 0 && (ex <= ey || self.length.1 == 0) {
            self.cell.0 += self.step.0;
            self.next.0 += self.size[0];
        }
        if self.length.1 > 0 && (ey <= ex || self.length.0 == 0) {
            self.cell.1 += self.step.1;
            self.next.1 += self.size[1];
        }
    }
}
