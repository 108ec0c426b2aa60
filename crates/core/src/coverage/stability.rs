//! Stability of a map's answers: receivers that turn when the UAV, or every roof, moves by one
//! lattice step.
//!
//! Answers are exact for the numbers that were given, but those are known no better than they were
//! measured. A receiver that grazes a roof turns with the last digit of a height; one in the middle
//! of a shadow does not. Eight maps with one thing moved by one step each tell the two apart. The
//! receivers and the ground they stand on stay. Roofs are the tops of prisms or of building cells;
//! of a surface model alone, where buildings are not known, all columns move.

use super::view::{Decided, MovedRoofs, Threads, View};
use super::{Control, Uav};
use crate::error::Result;
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

    /// Returns the word for it in documents, and the steps of the UAV east, north and up.
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

    /// Returns the word for it in documents.
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

/// Stability of the answers about one UAV.
#[derive(Debug, Clone, PartialEq)]
pub struct Stability {
    /// Receivers that each move turns, in the order of [`Move::ALL`]; or why it cannot be made, as
    /// where the UAV would be inside a building.
    pub moves: Vec<(Move, std::result::Result<Turned, String>)>,
    /// Receivers that at least one move turns.
    pub unstable: u64,
    /// Number of moves that turn each receiver, 0 to 8; NaN where there is none. Shape `[n_rows,
    /// n_cols]`, row 0 north.
    pub turns: Vec<f32>,
}

/// Finds how stable the answers of a view are, with roofs a step higher and a step lower.
///
/// Cost: eight times the line of sight of the map, by the same engine.
pub(super) fn stability(
    view: &View<'_>,
    decided: &[Decided<'_>],
    roofs: &[Option<MovedRoofs>; 2],
    control: &Control,
) -> Result<Stability> {
    let n_cols = view.field().grid().n_cols();
    let mut turns = vec![f32::NAN; view.field().grid().n_cells()];
    for Decided { in_range, .. } in decided {
        in_range.cells().for_each(|(row, col)| turns[row * n_cols + col] = 0.0);
    }
    let mut moves = Vec::with_capacity(Move::ALL.len());
    for which in Move::ALL {
        control.check()?;
        let turned = after(view, which, decided, roofs).map(|after| {
            let mut turned = Turned::default();
            for (Decided { los: before, .. }, after) in decided.iter().zip(&after) {
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

/// Returns the receivers in line of sight after a move, kind by kind; or why it cannot be made.
fn after(
    view: &View<'_>,
    which: Move,
    decided: &[Decided<'_>],
    roofs: &[Option<MovedRoofs>; 2],
) -> std::result::Result<Vec<BitGrid>, String> {
    let [up, down] = roofs;
    let roofs = match which {
        Move::RoofsUp => Some(up),
        Move::RoofsDown => Some(down),
        _ => None,
    };
    let beyond = || "a roof would be beyond ±32768 m of the datum".to_string();
    let roofs = roofs.map(|roofs| roofs.as_ref().ok_or_else(beyond)).transpose()?;
    let over = roofs.map(|roofs| view.with_roofs(roofs)).transpose().map_err(|e| e.to_string())?;
    let over = over.as_ref().unwrap_or(view);
    let uav: Uav =
        view.uav().moved(over.field(), which.told().1, view.mapper.options.radius).map_err(|e| e.to_string())?;
    // Nobody comes into range by a move, or leaves it: the turn of an answer is what counts.
    let after = over.with_uav(&uav);
    let los = after.receivers().zip(decided).map(|(of_kind, decided)| of_kind.los(&decided.in_range, Threads::All));
    Ok(los.collect())
}
