//! `step:K`: samples of the ray, at most K cells apart.

use crate::height_field::Columns;
use crate::quantity::{LatticePoint, STEPS_PER_UNIT, VOID};

const CELL: i64 = STEPS_PER_UNIT as i64;

/// The longest distance between two samples of a ray, in thousandths of a cell: 20 to 1 000 000
/// (1/50 to 1000 cells).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct StepLength {
    milli_cells: u32,
}

impl StepLength {
    /// Makes a length \[cells\], rounded to a thousandth; `None` outside \[1/50, 1000\].
    pub fn new(cells: f64) -> Option<Self> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 20 and 10^6")]
        (0.02..=1000.0).contains(&cells).then(|| StepLength { milli_cells: (cells * 1000.0).round() as u32 })
    }

    /// Returns the length \[cells\].
    pub fn cells(self) -> f64 {
        f64::from(self.milli_cells) / 1000.0
    }

    /// Returns the number of equal parts, none longer than this, of a link `(dx, dy)` \[1/1024
    /// cell\].
    fn parts(self, dx: i64, dy: i64) -> i64 {
        #[expect(clippy::cast_precision_loss, reason = "differences are at most 2^26, their squares' sum at most 2^53")]
        let length = ((dx * dx + dy * dy) as f64).sqrt() / f64::from(STEPS_PER_UNIT);
        #[expect(clippy::cast_possible_truncation, reason = "at most 2^17 cells by 50 samples each")]
        let parts = (length / self.cells()).ceil() as i64;
        parts.max(1)
    }
}

/// Returns `true` if no sample of a link is inside the columns: *approximate*.
///
/// The link is cut into the fewest equal parts not longer than `step`. At each inner end the height
/// of the ray is compared with that of the column. On a border between cells the lower cell counts,
/// and a cell that touches the receiver never does. A sample inside the columns is an obstruction,
/// so a link that is LoS is never called NLoS.
///
/// Cost: a multiplication and a look-up per sample; it ends where the ray is above the highest
/// column.
pub fn step_los(columns: &Columns, uav: LatticePoint, receiver: LatticePoint, step: StepLength) -> bool {
    let (dx, dy, climb) = (uav.x - receiver.x, uav.y - receiver.y, uav.z - receiver.z);
    if (dx == 0 && dy == 0) || i64::from(columns.max_top()) <= uav.z.min(receiver.z) {
        return true;
    }
    let parts = step.parts(dx, dy);
    // EXACT: differences are at most 2^28 and parts at most 2^23, so every product of both is at
    // most 2^51.
    let last = match climb {
        1.. => ((i64::from(columns.max_top()) - receiver.z) * parts / climb).min(parts - 1),
        _ => parts - 1,
    };
    let samples =
        Samples { columns, receiver, dx, dy, parts, per_part: (cells(dx) / cells(parts), cells(dy) / cells(parts)) };
    (1..=last).all(|k| {
        let top = samples.top(k);
        top == VOID || (i64::from(top) - receiver.z) * parts <= climb * k
    })
}

#[expect(clippy::cast_precision_loss, reason = "positions are at most 2^27, parts at most 2^23")]
fn cells(v: i64) -> f64 {
    v as f64
}

/// The inner ends of the equal parts of a link.
struct Samples<'a> {
    columns: &'a Columns,
    receiver: LatticePoint,
    dx: i64,
    dy: i64,
    parts: i64,
    /// Length of a part along each axis \[1/1024 cell\].
    per_part: (f64, f64),
}

impl Samples<'_> {
    /// Returns the lowest of the columns whose closed squares hold sample `k`; [`VOID`] if one of
    /// them touches the receiver.
    ///
    /// PERF: finding the cell takes two divisions in integers. The f64 position is off by less than
    /// 2^-18 of a lattice step, so they are needed only within 2^-10 steps of a border.
    #[inline]
    fn top(&self, k: i64) -> i32 {
        let side = f64::from(STEPS_PER_UNIT);
        let x = cells(self.receiver.x) + cells(k) * self.per_part.0;
        let y = cells(self.receiver.y) + cells(k) * self.per_part.1;
        let (east, north) = ((x / side).floor(), (y / side).floor());
        let (right, up) = (x - east * side, y - north * side);
        const NEAR: f64 = 1.0 / 1024.0;
        let is_inner = |v: f64| v > NEAR && v < side - NEAR;
        if !is_inner(right) || !is_inner(up) {
            return self.lowest_touching(k);
        }
        #[expect(clippy::cast_possible_truncation, reason = "a cell number, below 2^18")]
        self.top_of(east as i64, north as i64)
    }

    fn lowest_touching(&self, k: i64) -> i32 {
        let size = CELL * self.parts;
        let touching = |from: i64, d: i64| {
            let position = from * self.parts + d * k;
            let cell = position.div_euclid(size);
            (if cell * size == position { cell - 1 } else { cell }, cell)
        };
        let ((west, east), (south, north)) = (touching(self.receiver.x, self.dx), touching(self.receiver.y, self.dy));
        let tops = [(west, south), (west, north), (east, south), (east, north)].map(|(e, n)| self.top_of(e, n));
        tops.into_iter().min().unwrap_or(VOID)
    }

    /// Returns the top of a cell; [`VOID`] if it touches the receiver.
    #[inline]
    fn top_of(&self, east: i64, north: i64) -> i32 {
        let holds = |cell: i64, v: i64| cell * CELL <= v && v <= (cell + 1) * CELL;
        let is_own = holds(east, self.receiver.x) && holds(north, self.receiver.y);
        if is_own { VOID } else { self.columns.top(east, north) }
    }
}
