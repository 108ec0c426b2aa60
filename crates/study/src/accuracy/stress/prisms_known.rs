//! Footprints with known answers: grazing roofs, walls, slits, a UAV at roof height.

use super::cells_known::{DIVISIBLE, SLIT_CELLS, SlitChain};
use super::draw::Draw;
use super::scene::{CELL, StressPrism, StressScene, narrow};
use super::symmetry::Symmetry;
use crate::quantity::LatticePoint;

/// Half a cell, the position of receivers.
const HALF: i64 = CELL / 2;

/// Height of the receivers of these scenes \[1/1024 m\].
const RX: i64 = 3 * CELL / 2;

/// Makes a rectangle along the axes from one corner to the opposite one \[1/1024 m\].
pub(super) fn rectangle([x0, y0]: [i64; 2], [x1, y1]: [i64; 2], top: i64) -> StressPrism {
    let ring = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|corner| corner.map(narrow));
    StressPrism { rings: vec![ring.to_vec()], top: narrow(top) }
}

/// Draws a roof along each axis: the ray to one receiver touches it, misses it by a step, or is a
/// step below. On each diagonal a corner touches the rays, or reaches into them by a step.
pub(super) fn grazing(draw: &mut Draw) -> StressScene {
    const CENTER: i64 = 12 * CELL + HALF;
    let uav = LatticePoint { x: CENTER, y: CENTER, z: RX + DIVISIBLE };
    let mut prisms = Vec::new();
    let mut known = Vec::new();
    for (ex, ey) in [(1, 0), (0, 1), (-1, 0), (0, -1)] {
        let far = draw.within(2, 12);
        // The wall nearer to the receiver is `wall` half cells from the UAV.
        let wall = draw.within(2, 2 * far - 1);
        let above = draw.within(-1, 1);
        let at = |along: i64, across: i64| [CENTER + along * ex - across * ey, CENTER + along * ey + across * ex];
        let thick = draw.within(1, HALF);
        let half_wide = draw.within(1, HALF - 1);
        let top = uav.z - DIVISIBLE * wall / (2 * far) + above;
        prisms.push(rectangle(at(wall * HALF - thick, -half_wide), at(wall * HALF, half_wide), top));
        known.push(((12 + far * ex, 12 + far * ey), above <= 0));
    }
    for (ex, ey) in [(1, 1), (-1, 1), (-1, -1), (1, -1)] {
        let from = draw.within(CELL, 4 * CELL);
        let size = draw.within(200, CELL);
        // A square to the right of the diagonal, its near left corner on it, or a step beyond it.
        let beyond = draw.within(0, 1);
        let corner = [CENTER + ex * (from - beyond), CENTER + ey * (from + beyond)];
        prisms.push(rectangle(corner, [corner[0] + ex * size, corner[1] - ey * size], 200 * CELL));
        (6..=12).for_each(|k| known.push(((12 + k * ex, 12 + k * ey), beyond == 0)));
    }
    let mut scene = StressScene::of_prisms(prisms, 25, uav);
    known.into_iter().for_each(|(cell, is_los)| scene.know(cell, is_los));
    scene
}

/// Draws buildings whose walls lie exactly in the rays along the axes: on one side, on both, or
/// first on one side and then on the other.
pub(super) fn walls(draw: &mut Draw) -> StressScene {
    const CENTER: i64 = 10 * CELL + HALF;
    let uav = LatticePoint { x: CENTER, y: CENTER, z: draw.within(4, 20) * CELL };
    let mut prisms = Vec::new();
    let mut known = Vec::new();
    for (ex, ey) in [(1, 0), (0, 1), (-1, 0), (0, -1)] {
        let at = |along: i64, across: i64| [CENTER + along * ex - across * ey, CENTER + along * ey + across * ex];
        let (from, to) = (draw.within(CELL, 3 * CELL), draw.within(5 * CELL, 7 * CELL));
        let (left, right) = (draw.within(300, 2 * CELL), draw.within(300, 2 * CELL));
        let tall = |draw: &mut Draw| draw.within(100, 200) * CELL;
        let kind = draw.within(0, 3);
        let mut add = |a: [i64; 2], b: [i64; 2], top: i64| prisms.push(rectangle(a, b, top));
        match kind {
            0 => add(at(from, 0), at(to, left), tall(draw)),
            1 => {
                let middle = draw.within(from + 1, to - 1);
                add(at(from, 0), at(middle, left), tall(draw));
                add(at(middle, -right), at(to, 0), tall(draw));
            }
            2 => {
                add(at(from, 0), at(to, left), tall(draw));
                add(at(to - draw.within(1, CELL), -right), at(to + CELL, 0), tall(draw));
            }
            // A wall shared with a roof that is no higher than the receivers.
            _ => {
                add(at(from, 0), at(to, left), tall(draw));
                add(at(from, -right), at(to, 0), RX - draw.within(0, 1));
            }
        }
        (9..=10).for_each(|k| known.push(((10 + k * ex, 10 + k * ey), kind != 2)));
    }
    let mut scene = StressScene::of_prisms(prisms, 21, uav);
    known.into_iter().for_each(|(cell, is_los)| scene.know(cell, is_los));
    scene
}

/// Draws a chain of square towers that touch corner to corner. Cells behind are seen only through
/// the points between them.
pub(super) fn slits(draw: &mut Draw) -> StressScene {
    let chain = SlitChain::draw(draw);
    let tower = |(east, north): &(i64, i64), top: i64| {
        rectangle([east * CELL, north * CELL], [(east + 1) * CELL, (north + 1) * CELL], top)
    };
    let prisms = chain.towers.iter().map(|cell| tower(cell, draw.within(60, 90) * CELL)).collect();
    let n = usize::try_from(SLIT_CELLS).unwrap_or(0);
    let mut scene = StressScene::of_prisms(prisms, n, chain.station(draw.within(2, 30) * CELL));
    chain.behind.iter().for_each(|(cell, is_los)| scene.know(*cell, *is_los));
    Symmetry::any(draw).of(&scene)
}

/// Draws a UAV exactly at the height of the roof below it: inside its edge by a step or more, on
/// the edge, or a step outside. Roofs around it have that height, or are a step lower or higher.
pub(super) fn roof_height(draw: &mut Draw) -> StressScene {
    let height = draw.within(6 * CELL, 40 * CELL);
    let (west, east) = (6 * CELL + draw.within(0, CELL), 12 * CELL + draw.within(0, CELL));
    let mut prisms = vec![rectangle([west, 5 * CELL], [east, 15 * CELL], height)];
    for _ in 0..draw.within(1, 4) {
        let [x, y] = [draw.within(14, 17) * CELL, draw.within(0, 17) * CELL];
        let [w, h] = [draw.within(300, 2 * CELL), draw.within(300, 2 * CELL)];
        prisms.push(rectangle([x, y], [x + w, y + h], height + draw.within(-1, 1)));
    }
    let inside = draw.choose(&[-1, 0, 1, 2 * CELL]);
    let uav = LatticePoint { x: west + inside, y: draw.within(6 * CELL, 14 * CELL), z: height };
    let mut scene = StressScene::of_prisms(prisms, 20, uav);
    // West of the building nothing stands in the way but its own roof.
    (0..5).for_each(|col| (0..20).for_each(|row| scene.know((col, row), inside <= 0)));
    Symmetry::any(draw).of(&scene)
}
