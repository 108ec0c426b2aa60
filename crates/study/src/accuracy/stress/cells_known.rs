//! Boards of cells with known answers: grazing roofs, diagonals, slits, cliffs.

use super::draw::Draw;
use super::scene::{Board, CELL, StressScene};
use super::symmetry::Symmetry;
use crate::quantity::LatticePoint;

/// Half a cell, the position of centers.
const HALF: i64 = CELL / 2;

/// Height of the receivers of these scenes \[1/1024 m\].
const RX: i64 = 3 * CELL / 2;

/// Height difference that all even numbers up to 24 divide: 2·lcm(1…12) steps, 54 m.
pub(super) const DIVISIBLE: i64 = 55_440;

/// Directions of the axes and of the diagonals.
const COMPASS: [(i64, i64); 8] = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)];

/// Draws a tower in each of the eight directions. The ray to one receiver touches its roof, misses
/// it by a step, or is a step below. Other rays pass further towers within a step.
pub(super) fn grazing(draw: &mut Draw) -> StressScene {
    const N: i64 = 25;
    let center = N / 2;
    let uav = LatticePoint { x: center * CELL + HALF, y: center * CELL + HALF, z: RX + DIVISIBLE };
    let mut board = Board::flat(25);
    for _ in 0..8 {
        let (east, north) = (draw.within(0, N - 1), draw.within(0, N - 1));
        let (dx, dy) = (east - center, north - center);
        let k = draw.within(25, 75);
        let cell = (center + dx * k / 100, center + dy * k / 100);
        let is_compass = |(e, n): (i64, i64)| e == center || n == center || (e - center).abs() == (n - center).abs();
        if is_compass((east, north)) || is_compass(cell) {
            continue;
        }
        // The ray leaves the cell through the border that it meets first towards the receiver.
        let leave = |d: i64, cell: i64, from: i64| match d.signum() {
            0 => None,
            sign => Some((((cell + i64::from(sign > 0)) * CELL - from) * sign, (d * CELL).abs())),
        };
        let ends = [leave(dx, cell.0, uav.x), leave(dy, cell.1, uav.y)];
        let exit = ends.into_iter().flatten().min_by(|a, b| (a.0 * b.1).cmp(&(b.0 * a.1)));
        if let Some((n, d)) = exit {
            board.set(cell, uav.z - DIVISIBLE * n / d + draw.within(-1, 1));
        }
    }
    let mut known = Vec::new();
    for (east, north) in COMPASS {
        let far = draw.within(2, 12);
        let near = draw.within(1, far - 1);
        // The end of the tower's cell nearer to the receiver is (2·near + 1)/(2·far) of the way
        // from the UAV.
        let ray = uav.z - DIVISIBLE * (2 * near + 1) / (2 * far);
        let above = draw.within(-1, 1);
        board.set((center + near * east, center + near * north), ray + above);
        known.push(((center + far * east, center + far * north), above <= 0));
    }
    let mut scene = StressScene::of_board(board, uav);
    known.into_iter().for_each(|(cell, is_los)| scene.know(cell, is_los));
    scene
}

/// Draws a checkerboard of towers. From the middle of an open cell, exact diagonals pass between
/// towers that touch corner to corner.
pub(super) fn diagonals(draw: &mut Draw) -> StressScene {
    const N: i64 = 20;
    let mut board = Board::flat(20);
    for east in 0..N {
        for north in (0..N).filter(|north| (east + north) % 2 == 0) {
            board.set((east, north), draw.within(4, 40) * CELL);
        }
    }
    let east = draw.within(2, N - 3);
    let north = draw.within(1, (N - 3) / 2) * 2 + i64::from(east % 2 == 0);
    let uav = LatticePoint { x: east * CELL + HALF, y: north * CELL + HALF, z: draw.within(2, 6) * CELL };
    let mut scene = StressScene::of_board(board, uav);
    for (dx, dy) in COMPASS.into_iter().filter(|(dx, dy)| dx * dy != 0) {
        (1..N).for_each(|k| scene.know((east + k * dx, north + k * dy), true));
    }
    scene
}

/// Chain of towers that touch corner to corner, from north-west to south-east, with a UAV to the
/// south-west and its view through the chain.
pub(super) struct SlitChain {
    pub(super) towers: Vec<(i64, i64)>,
    /// Cell with the UAV in its middle.
    pub(super) uav: (i64, i64),
    /// Cells behind the chain; `true` if the ray to the middle passes between touching towers.
    pub(super) behind: Vec<((i64, i64), bool)>,
}

/// Number of cells along a side of a scene with a chain.
pub(super) const SLIT_CELLS: i64 = 21;

impl SlitChain {
    pub(super) fn draw(draw: &mut Draw) -> Self {
        const N: i64 = SLIT_CELLS;
        // Towers at east + north = sum; their corners, in half cells, at (2·east + 2, 2·north).
        let sum = draw.within(N - 3, N + 3);
        let towers: Vec<(i64, i64)> =
            (0..N).map(|east| (east, sum - east)).filter(|(_, n)| (0..N).contains(n)).collect();
        // An odd sum of the UAV's cell and the chain's lets the exact diagonal through a corner.
        let east = draw.within(1, 6);
        let north = draw.within(1, 6) / 2 * 2 + i64::from((sum + east) % 2 == 0);
        let uav = (2 * east + 1, 2 * north + 1);
        let is_slit = |(e, n): (i64, i64)| {
            towers.iter().filter(|tower| towers.contains(&(tower.0 + 1, tower.1 - 1))).any(|tower| {
                let (dx, dy) = (2 * e + 1 - uav.0, 2 * n + 1 - uav.1);
                // Rays that fall to the south or to the west pass through the towers themselves.
                dx > 0 && dy > 0 && dx * (2 * tower.1 - uav.1) == dy * (2 * tower.0 + 2 - uav.0)
            })
        };
        // Rays that pass beside the ends of the chain are left out.
        let (first, last) = (towers[0], towers[towers.len() - 1]);
        let passes_within = |(e, n): (i64, i64)| {
            let (dx, dy) = (2 * e + 1 - uav.0, 2 * n + 1 - uav.1);
            let turn = |(x, y): (i64, i64)| dx * (y - uav.1) - dy * (x - uav.0);
            turn((2 * first.0 + 2, 2 * first.1)) >= 0 && turn((2 * last.0, 2 * last.1 + 2)) <= 0
        };
        let cells = (0..N).flat_map(|e| (0..N).map(move |n| (e, n))).filter(|(e, n)| e + n > sum);
        let behind = cells.filter(|cell| passes_within(*cell)).map(|cell| (cell, is_slit(cell))).collect();
        SlitChain { towers, uav: (east, north), behind }
    }

    /// Returns the UAV in the middle of its cell.
    pub(super) fn station(&self, z: i64) -> LatticePoint {
        LatticePoint { x: self.uav.0 * CELL + HALF, y: self.uav.1 * CELL + HALF, z }
    }
}

/// Draws a chain of towers that touch corner to corner. Cells behind are seen only through the
/// points between them.
pub(super) fn slits(draw: &mut Draw) -> StressScene {
    let chain = SlitChain::draw(draw);
    let mut board = Board::flat(21);
    chain.towers.iter().for_each(|cell| board.set(*cell, draw.within(60, 90) * CELL));
    let mut scene = StressScene::of_board(board, chain.station(draw.within(2, 30) * CELL));
    chain.behind.iter().for_each(|(cell, is_los)| scene.know(*cell, *is_los));
    Symmetry::any(draw).of(&scene)
}

/// Draws a plateau, and a UAV exactly at its height: over the edge, or a step before or behind it.
pub(super) fn cliffs(draw: &mut Draw) -> StressScene {
    const N: i64 = 20;
    let edge = draw.within(6, 14);
    let height = draw.within(5 * CELL, 60 * CELL);
    let mut board = Board::flat(20);
    for east in edge..N {
        for north in 0..N {
            // Some cells of the plateau are lower or higher by a step; those at the edge are not.
            let step = if east > edge + 1 && draw.chance(20) { draw.within(-1, 1) } else { 0 };
            board.set((east, north), height + step);
        }
    }
    let behind = draw.within(-1, 1);
    let north = draw.within(1, N - 2);
    let uav = LatticePoint { x: edge * CELL + behind, y: north * CELL + draw.within(0, CELL - 1), z: height };
    let mut scene = StressScene::of_board(board, uav);
    for east in 0..edge {
        // Over the plateau the ray is below its roof at once.
        (0..N).for_each(|north| scene.know((east, north), behind <= 0));
    }
    Symmetry::any(draw).of(&scene)
}
