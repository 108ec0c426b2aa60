//! Symmetries of a square, eight in all, for scenes and their answers: no direction may be favored.

use super::draw::Draw;
use super::scene::{Board, CELL, Known, StressPrism, StressScene, StressSolid, narrow};
use crate::city::RoofTriangle;
use crate::quantity::LatticePoint;

/// Symmetry of a square: optional mirroring along x and y, then an optional exchange of x and y.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Symmetry {
    flips_x: bool,
    flips_y: bool,
    swaps: bool,
}

impl Symmetry {
    /// Returns symmetry `k`, 0 to 7; 0 changes nothing. Larger numbers count again from 0.
    pub fn number(k: u32) -> Self {
        Symmetry { flips_x: k & 1 != 0, flips_y: k & 2 != 0, swaps: k & 4 != 0 }
    }

    /// Draws a symmetry.
    pub(super) fn any(draw: &mut Draw) -> Self {
        Symmetry { flips_x: draw.chance(50), flips_y: draw.chance(50), swaps: draw.chance(50) }
    }

    /// Maps a position in a box of this width and height \[any unit\].
    fn position(self, [x, y]: [i64; 2], [width, height]: [i64; 2]) -> [i64; 2] {
        let x = if self.flips_x { width - x } else { x };
        let y = if self.flips_y { height - y } else { y };
        if self.swaps { [y, x] } else { [x, y] }
    }

    /// Maps row and column of a cell of a grid of `n_rows` and `n_cols`.
    pub fn cell(self, (row, col): (usize, usize), (n_rows, n_cols): (usize, usize)) -> (usize, usize) {
        // Computed from positions from the south-west, because rows count from the north.
        let east = if self.flips_x { n_cols - 1 - col } else { col };
        let north = if self.flips_y { row } else { n_rows - 1 - row };
        let (east, north, rows) = if self.swaps { (north, east, n_cols) } else { (east, north, n_rows) };
        (rows - 1 - north, east)
    }

    /// Maps a scene: its solid, the UAV and the known answers.
    pub fn of(self, scene: &StressScene) -> StressScene {
        let shape = (scene.n_rows, scene.n_cols);
        let steps = |n: usize| i64::try_from(n).unwrap_or(i64::MAX).saturating_mul(CELL);
        let extent = [steps(scene.n_cols), steps(scene.n_rows)];
        let (n_rows, n_cols) = if self.swaps { (shape.1, shape.0) } else { shape };
        let solid = match &scene.solid {
            StressSolid::Columns { board, ground } => {
                let mut tops = board.tops.clone();
                for (cell, top) in board.tops.iter().enumerate() {
                    let (row, col) = self.cell((cell / board.n_cols, cell % board.n_cols), shape);
                    tops[row * n_cols + col] = *top;
                }
                StressSolid::Columns { board: Board::new(n_rows, n_cols, tops), ground: *ground }
            }
            StressSolid::Prisms(prisms) => {
                let corner = |v: &[i32; 2]| self.position(v.map(i64::from), extent).map(narrow);
                let ring = |ring: &Vec<[i32; 2]>| ring.iter().map(corner).collect();
                let prism = |p: &StressPrism| StressPrism { rings: p.rings.iter().map(ring).collect(), top: p.top };
                StressSolid::Prisms(prisms.iter().map(prism).collect())
            }
            StressSolid::Roofs(roofs) => {
                let corner = |[x, y, z]: [i32; 3]| {
                    let [x, y] = self.position([x, y].map(i64::from), extent).map(narrow);
                    [x, y, z]
                };
                let turns = usize::from(self.flips_x) + usize::from(self.flips_y) + usize::from(self.swaps);
                let triangle = |corners: &RoofTriangle| {
                    let [a, b, c] = corners.map(corner);
                    // A mirror image runs the other way around.
                    if turns % 2 == 0 { [a, b, c] } else { [a, c, b] }
                };
                StressSolid::Roofs(roofs.iter().map(|roof| roof.iter().map(triangle).collect()).collect())
            }
        };
        let [x, y] = self.position([scene.uav.x, scene.uav.y], extent);
        let known = scene.known.iter().map(|k| {
            let (row, col) = self.cell((k.row, k.col), shape);
            Known { row, col, is_los: k.is_los }
        });
        StressScene {
            solid,
            n_rows,
            n_cols,
            uav: LatticePoint { x, y, z: scene.uav.z },
            known: known.collect(),
            ..scene.clone()
        }
    }
}
