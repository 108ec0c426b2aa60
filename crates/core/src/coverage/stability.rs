//! How stable the answers of a map are: which of them turn when the UAV, or every roof, moves by one lattice step.
//!
//! Answers are exact for the numbers that were given, but those are known no better than they were measured. A receiver
//! that grazes a roof turns with the last digit of a height; one in the middle of a shadow does not. Eight maps with one
//! thing moved by one step each tell the two apart: the UAV east, west, north, south, up and down, and all roofs up and
//! down. The receivers and the ground they stand on stay. Roofs are the tops of prisms or of building cells; of a
//! surface model alone, where buildings are not known, all columns move.

use super::range::{Heights, Range};
use super::{Control, MapOptions, Uav};
use crate::error::Result;
use crate::height_field::HeightField;
use crate::los::{GridLos, GridReceivers};
use crate::raster::BitGrid;

/// One thing moved by one step of the lattice: 1/1024 m, of a raster horizontally 1/1024 of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Move {
    /// The UAV to the east.
    East,
    /// The UAV to the west.
    West,
    /// The UAV to the north.
    North,
    /// The UAV to the south.
    South,
    /// The UAV up.
    Up,
    /// The UAV down.
    Down,
    /// All roofs up.
    RoofsUp,
    /// All roofs down.
    RoofsDown,
}

impl Move {
    /// All moves.
    pub const ALL: [Move; 8] =
        [Move::East, Move::West, Move::North, Move::South, Move::Up, Move::Down, Move::RoofsUp, Move::RoofsDown];

    /// The word for it in documents, and the steps of the UAV east, north and up.
    fn told(self) -> (&'static str, [i64; 3]) {
        match self {
            Move::East => ("uav_east", [1, 0, 0]),
            Move::West => ("uav_west", [-1, 0, 0]),
            Move::North => ("uav_north", [0, 1, 0]),
            Move::South => ("uav_south", [0, -1, 0]),
            Move::Up => ("uav_up", [0, 0, 1]),
            Move::Down => ("uav_down", [0, 0, -1]),
            Move::RoofsUp => ("roofs_up", [0; 3]),
            Move::RoofsDown => ("roofs_down", [0; 3]),
        }
    }

    /// The word for it in documents.
    pub fn name(self) -> &'static str {
        self.told().0
    }
}

/// Receivers whose answer a move turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Turned {
    /// From NLoS to LoS.
    pub gained: u64,
    /// From LoS to NLoS.
    pub lost: u64,
}

/// How stable the answers of one UAV are.
#[derive(Debug, Clone, PartialEq)]
pub struct Stability {
    /// What each move turns, in the order of [`Move::ALL`]; or why it cannot be made, as where the UAV would be inside a
    /// building.
    pub moves: Vec<(Move, std::result::Result<Turned, String>)>,
    /// Receivers that at least one move turns.
    pub unstable: u64,
    /// How many moves turn each receiver, 0 to 8; NaN where there is none. Shape `[n_rows, n_cols]`, row 0 north.
    pub turns: Vec<f32>,
}

/// A scene with its roofs a step higher and a step lower; `None` where they would leave the proven range.
#[derive(Debug, Clone)]
pub(super) struct ShiftedRoofs {
    up: Option<HeightField>,
    down: Option<HeightField>,
}

impl ShiftedRoofs {
    pub(super) fn of(field: &HeightField) -> Self {
        ShiftedRoofs { up: field.with_roofs_raised(1), down: field.with_roofs_raised(-1) }
    }

    /// The scene after a move of its roofs.
    fn after(&self, which: Move) -> std::result::Result<&HeightField, String> {
        let field = if which == Move::RoofsUp { &self.up } else { &self.down };
        field.as_ref().ok_or_else(|| "a roof would be beyond ±32768 m of the datum".to_string())
    }
}

/// The receivers of one kind that are in range, where not all are, and those in line of sight.
pub(super) type Decided = (Option<BitGrid>, BitGrid);

/// What a UAV sees of a scene, and how that was decided.
pub(super) struct Answers<'a> {
    pub(super) field: &'a HeightField,
    pub(super) engine: &'a GridLos<'a>,
    /// Receivers on the ground, on roofs, or both; `decided` for each.
    pub(super) receivers: &'a [GridReceivers<'a>],
    pub(super) decided: &'a [Decided],
    pub(super) options: &'a MapOptions,
    /// How high receivers are.
    pub(super) heights: Heights,
    pub(super) uav: &'a Uav,
    pub(super) range: &'a Range<'a>,
}

impl Answers<'_> {
    /// How stable the answers are.
    ///
    /// Cost: eight times the line of sight of the map, by the same engine.
    pub(super) fn stability(&self, roofs: &ShiftedRoofs, control: &Control) -> Result<Stability> {
        let n_cols = self.field.grid().n_cols();
        let mut turns = vec![f32::NAN; self.field.grid().n_cells()];
        for (receivers, (wanted, _)) in self.receivers.iter().zip(self.decided) {
            let cells = wanted.as_ref().unwrap_or(&receivers.cells).cells();
            cells.for_each(|(row, col)| turns[row * n_cols + col] = 0.0);
        }
        let mut moves = Vec::with_capacity(Move::ALL.len());
        for which in Move::ALL {
            control.check()?;
            let turned = self.after(which, roofs).map(|after| {
                let mut turned = Turned::default();
                for ((_, before), after) in self.decided.iter().zip(&after) {
                    let both = before.count_in(after);
                    turned.gained += after.count() - both;
                    turned.lost += before.count() - both;
                    before.clone().xor(after).cells().for_each(|(row, col)| turns[row * n_cols + col] += 1.0);
                }
                turned
            });
            moves.push((which, turned));
        }
        let unstable = turns.iter().filter(|n| **n > 0.0).count() as u64;
        Ok(Stability { moves, unstable, turns })
    }

    /// The receivers in line of sight after a move, kind by kind; or why it cannot be made.
    fn after(&self, which: Move, roofs: &ShiftedRoofs) -> std::result::Result<Vec<BitGrid>, String> {
        let (field, engine) = match which {
            Move::RoofsUp | Move::RoofsDown => {
                let field = roofs.after(which)?;
                (field, &GridLos::new(field, self.engine.method()).map_err(|wrong| wrong.why.to_string())?)
            }
            _ => (self.field, self.engine),
        };
        // Who is in range does not change: what turns is an answer.
        let moved = self.uav.moved(field, which.told().1, self.options.radius).map_err(|e| e.to_string())?;
        let range = Range::of(engine.positions(), &moved, self.options, self.heights);
        let window = self.range.window_with(&range);
        let los = |(receivers, (wanted, _)): (&GridReceivers<'_>, &Decided)| {
            engine.los(&moved.station, receivers, wanted.as_ref().unwrap_or(&receivers.cells), window)
        };
        Ok(self.receivers.iter().zip(self.decided).map(los).collect())
    }
}
