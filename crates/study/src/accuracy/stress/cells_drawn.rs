//! Random boards of cells: borders, needles, slots, heights, world coordinates, mirrored towns.

use super::draw::Draw;
use super::scene::{Board, CELL, StressScene, StressSolid, narrow};
use super::symmetry::Symmetry;
use crate::quantity::{Frame, LatticePoint, VOID};

/// Cells along each side of a board.
const N: i64 = 20;

fn board() -> Board {
    Board::flat(20)
}

/// Iterates over the cells of a board, east and north.
fn cells() -> impl Iterator<Item = (i64, i64)> {
    (0..N).flat_map(|east| (0..N).map(move |north| (east, north)))
}

/// Returns a UAV at `height` above the highest column that touches its place, or above the ground.
fn above(board: &Board, (x, y): (i64, i64), height: i64) -> LatticePoint {
    let around = [(x - 1, y - 1), (x - 1, y), (x, y - 1), (x, y)];
    let tops = around.map(|(x, y)| board.top(x.div_euclid(CELL), y.div_euclid(CELL)));
    let surface = tops.into_iter().filter(|top| *top != VOID).max().unwrap_or(0).max(0);
    LatticePoint { x, y, z: i64::from(surface) + height }
}

/// Draws buildings of some heights on open ground.
fn town(draw: &mut Draw, percent: i64, tops: &[i64]) -> Board {
    let mut board = board();
    for cell in cells() {
        if draw.chance(percent) {
            board.set(cell, draw.choose(tops));
        }
    }
    board
}

fn anywhere(draw: &mut Draw) -> (i64, i64) {
    (draw.within(CELL, (N - 1) * CELL), draw.within(CELL, (N - 1) * CELL))
}

/// Draws two lines of columns of unequal heights on either side of a border. The UAV is on the
/// border, on a corner, or a step beside.
pub(super) fn borders(draw: &mut Draw) -> StressScene {
    let mut board = town(draw, 15, &[2 * CELL, 5 * CELL, 9 * CELL]);
    let (line, north) = (draw.within(4, N - 4), draw.within(1, 4));
    for along in (0..N).filter(|along| *along > north + 1) {
        let west = if along % 2 == 0 { draw.within(1, 12) } else { 0 };
        let east = if along % 2 == 0 { 0 } else { draw.within(1, 12) };
        board.set((line - 1, along), west * CELL);
        board.set((line, along), east * CELL);
    }
    let x = line * CELL + draw.choose(&[0, 0, 0, -1, 1]);
    let y = if draw.chance(50) { north * CELL } else { north * CELL + draw.within(1, CELL - 1) };
    let uav = above(&board, (x, y), draw.within(CELL, 15 * CELL));
    Symmetry::any(draw).of(&StressScene::of_board(board, uav))
}

/// Draws a few towers of one cell, far higher than the UAV.
pub(super) fn needles(draw: &mut Draw) -> StressScene {
    let mut board = board();
    for _ in 0..draw.within(5, 9) {
        board.set((draw.within(0, N - 1), draw.within(0, N - 1)), draw.within(80, 300) * CELL);
    }
    // Beside the towers: over one it would see everything.
    let open: Vec<(i64, i64)> = cells().filter(|(east, north)| board.top(*east, *north) == 0).collect();
    let (east, north) = draw.choose(&open);
    let (x, y) = (east * CELL + draw.within(1, CELL - 1), north * CELL + draw.within(1, CELL - 1));
    let uav = LatticePoint { x, y, z: draw.within(10, 70) * CELL };
    StressScene::of_board(board, uav)
}

/// Draws two long walls with openings of one cell.
pub(super) fn slots(draw: &mut Draw) -> StressScene {
    let mut board = board();
    for line in [draw.within(5, 8), draw.within(11, 15)] {
        let mut next = draw.within(0, 4);
        for east in 0..N {
            if east == next {
                next += draw.within(2, 6);
            } else {
                board.set((east, line), draw.within(20, 50) * CELL);
            }
        }
    }
    let at = (draw.within(CELL, (N - 1) * CELL), draw.within(CELL, 4 * CELL));
    let uav = above(&board, at, draw.within(2, 15) * CELL);
    Symmetry::any(draw).of(&StressScene::of_board(board, uav))
}

/// Draws a town with a UAV 2 m to 20 km above it, or so far away that its rays are almost level.
pub(super) fn heights(draw: &mut Draw) -> StressScene {
    let board = town(draw, 30, &[CELL, 6 * CELL, 12 * CELL, 30 * CELL, 120 * CELL]);
    let uav = if draw.chance(30) {
        let far = draw.choose(&[-900, -60, 80, 1000]) * CELL + draw.within(0, CELL);
        LatticePoint { x: far, y: draw.within(-40, 60) * CELL + draw.within(0, CELL), z: draw.within(0, 130 * CELL) }
    } else {
        let height = draw.choose(&[2, 2, 5, 400, 5000, 20_000]) * CELL + draw.within(0, CELL - 1);
        let at = anywhere(draw);
        above(&board, at, height)
    };
    let mut scene = StressScene::of_board(board, uav);
    scene.rx_height = narrow(draw.choose(&[0, 1, 3 * CELL / 2]));
    scene
}

/// Draws a town on odd, oblong cells far from the origin of its coordinates.
pub(super) fn utm(draw: &mut Draw) -> StressScene {
    let board = town(draw, 25, &[3 * CELL, 8 * CELL, 20 * CELL]);
    let at = anywhere(draw);
    let uav = above(&board, at, draw.within(2, 40) * CELL);
    let mut scene = StressScene::of_board(board, uav);
    scene.cell = draw.choose(&[(0.37, 0.37), (0.2, 1.7), (3.3, 0.9), (12.5, 7.1)]);
    let (x_origin, y_origin) = draw.choose(&[(691_549.37, 5_334_762.21), (32_398_551.05, 9_999_017.9), (-0.3, -7e6)]);
    scene.world = Frame { x_origin, y_origin, unit_x: scene.cell.0, unit_y: scene.cell.1 };
    scene
}

/// Draws a surface of columns that are powers of two high, from 1/1024 m to 16 km, below or above
/// the datum. Half of the scenes have a hole.
pub(super) fn magnitudes(draw: &mut Draw) -> StressScene {
    let mut board = board();
    for cell in cells() {
        let power = 1_i64 << draw.within(0, 24);
        board.set(cell, draw.choose(&[0, power, power, power, -power]));
    }
    let at = anywhere(draw);
    let uav = above(&board, at, 1 << draw.within(0, 23));
    if draw.chance(50) {
        board.set((draw.within(0, N - 1), draw.within(0, N - 1)), i64::from(VOID));
    }
    let mut scene = StressScene::of_board(board.clone(), uav);
    scene.solid = StressSolid::Columns { board, ground: None };
    scene.rx_height = narrow(draw.choose(&[0, 1, 1536]));
    scene
}

/// Draws a town on an earth so curved that its far side is meters lower. Some receivers are beyond
/// the horizon, or behind roofs that rays over a flat earth would clear.
pub(super) fn curved(draw: &mut Draw) -> StressScene {
    let board = town(draw, 20, &[CELL, 2 * CELL, 4 * CELL, 9 * CELL]);
    let at = anywhere(draw);
    let uav = above(&board, at, draw.within(CELL, 14 * CELL));
    let earth = Some(2 * draw.within(20_000, 600_000) + 1);
    StressScene { earth, ..StressScene::of_board(board, uav) }
}

/// Draws towers around a UAV over the middle of a cell that serves a sector. It is whole cells
/// above the receivers, so that some are at 45°.
pub(super) fn sectors(draw: &mut Draw) -> StressScene {
    let scene = needles(draw);
    let middle = |at: i64| at.div_euclid(CELL) * CELL + CELL / 2;
    let z = draw.choose(&[5, 10, 13]) * CELL + i64::from(scene.rx_height);
    let uav = LatticePoint { x: middle(scene.uav.x), y: middle(scene.uav.y), z };
    StressScene { uav, served: Some(draw.served()), ..scene }
}

/// Draws a town for the eight symmetries.
pub(super) fn mirrored(draw: &mut Draw) -> StressScene {
    let board = town(draw, 25, &[2 * CELL, 4 * CELL, 15 * CELL]);
    let at =
        if draw.chance(50) { anywhere(draw) } else { (draw.within(1, N - 1) * CELL, draw.within(1, N - 1) * CELL) };
    let uav = above(&board, at, draw.within(1, 20) * CELL);
    StressScene::of_board(board, uav)
}
