//! Random footprints: party walls, slivers, needles, magnitudes, world coordinates, mirrored towns.

use super::draw::Draw;
use super::prisms_known::rectangle;
use super::scene::{CELL, StressPrism, StressScene, narrow};
use crate::quantity::{Frame, LatticePoint};

/// Cells along each side of a scene.
const N: i64 = 18;

fn scene(prisms: Vec<StressPrism>, uav: LatticePoint) -> StressScene {
    StressScene::of_prisms(prisms, 18, uav)
}

fn prism(ring: &[[i64; 2]], top: i64) -> StressPrism {
    StressPrism { rings: vec![ring.iter().map(|corner| corner.map(narrow)).collect()], top: narrow(top) }
}

/// Draws a UAV above all roofs, `over_all`, or a lower one over open ground in the south. In half
/// of the scenes it is over the middle of a cell, so that links run along an axis.
fn uav(draw: &mut Draw, over_all: i64) -> LatticePoint {
    let is_centered = draw.chance(50);
    let mut along = |from: i64, to: i64| {
        if is_centered { draw.within(from, to - 1) * CELL + CELL / 2 } else { draw.within(from * CELL, to * CELL) }
    };
    let (x, north, south) = (along(0, N), along(0, N), along(-1, 0));
    if draw.chance(40) {
        return LatticePoint { x, y: north, z: over_all + draw.within(0, 20 * CELL) };
    }
    LatticePoint { x, y: south, z: draw.within(CELL, 12 * CELL) }
}

/// Draws houses with shared walls on an earth so curved that roofs bulge by a step or by meters.
pub(super) fn curved(draw: &mut Draw) -> StressScene {
    let earth = Some(2 * draw.choose(&[9_000, 40_000, 300_000, 5_000_000]) + 1);
    StressScene { earth, ..shared_walls(draw) }
}

/// Draws houses with shared walls, and a UAV over the middle of a cell that serves a sector. It is
/// whole cells above the receivers on the ground, so that some are at 45°.
pub(super) fn sectors(draw: &mut Draw) -> StressScene {
    let scene = shared_walls(draw);
    let mut along = || draw.within(0, N - 1) * CELL + CELL / 2;
    let (x, y) = (along(), along());
    let z = draw.choose(&[16, 20]) * CELL + i64::from(scene.rx_height);
    StressScene { uav: LatticePoint { x, y, z }, served: Some(draw.served()), ..scene }
}

/// Draws blocks cut into houses of equal and unequal heights. Some walls divide cells in two.
pub(super) fn shared_walls(draw: &mut Draw) -> StressScene {
    let mut prisms = Vec::new();
    let cut = |draw: &mut Draw, from: i64| {
        let mut at = vec![from];
        for _ in 0..draw.within(1, 3) {
            let last = at[at.len() - 1];
            at.push(last + draw.choose(&[CELL / 2, CELL, 3 * CELL / 2, 777]));
        }
        at
    };
    for block in [[2, 2], [9, 2], [2, 9], [9, 9]] {
        let [x, y] = block.map(|v| v * CELL + draw.choose(&[0, CELL / 2, 100]));
        let (xs, ys) = (cut(draw, x), cut(draw, y));
        for x in xs.windows(2) {
            for y in ys.windows(2) {
                prisms.push(rectangle([x[0], y[0]], [x[1], y[1]], draw.choose(&[4, 4, 8, 15]) * CELL));
            }
        }
    }
    let uav = uav(draw, 15 * CELL);
    scene(prisms, uav)
}

/// Draws shapes that are hard to cut into triangles. Slivers and spikes are a step wide, corners a
/// step apart, many points on one edge. A hole touches its shell, and a ring touches itself.
pub(super) fn slivers(draw: &mut Draw) -> StressScene {
    let mut prisms = Vec::new();
    for row in 0..3 {
        for col in 0..3 {
            let [x, y] = [col * 5 + 2, row * 5 + 2].map(|v| v * CELL + draw.within(0, CELL));
            prisms.push(hard_shape(draw, [x, y]));
        }
    }
    let uav = uav(draw, 30 * CELL);
    scene(prisms, uav)
}

/// Draws a shape within 3 m north-east of a corner.
fn hard_shape(draw: &mut Draw, [x, y]: [i64; 2]) -> StressPrism {
    let top = draw.within(3, 30) * CELL;
    let s = draw.within(2 * CELL, 3 * CELL);
    let (east, north, middle) = (x + s, y + s, draw.within(100, s - 100));
    match draw.within(0, 5) {
        0 => prism(&[[x, y], [east, y + 1], [x + middle, y + 1], [x + middle - 50, y + 1]], top),
        // Each corner twice, a step apart.
        1 => prism(
            &[
                [x, y],
                [east - 1, y],
                [east, y + 1],
                [east, north - 1],
                [east - 1, north],
                [x + 1, north],
                [x, north - 1],
                [x, y + 1],
            ],
            top,
        ),
        2 => {
            let along = (0..8).map(|k| s * k / 8);
            let mut ring: Vec<[i64; 2]> = along.clone().map(|d| [x + d, y]).collect();
            ring.extend(along.clone().map(|d| [east, y + d]));
            ring.extend(along.clone().map(|d| [east - d, north]));
            ring.extend(along.map(|d| [x, north - d]));
            prism(&ring, top)
        }
        3 => {
            let (half, spike) = (x + s / 2, y + middle);
            prism(&[[x, y], [half, y], [half, spike], [east, spike], [half, spike + 1], [half, north], [x, north]], top)
        }
        4 => {
            // The hole touches the western edge in one corner.
            let reach = s / 3;
            let hole = [
                [x, y + s / 2],
                [x + reach, y + s / 2 - reach],
                [x + 2 * reach, y + s / 2],
                [x + reach, y + s / 2 + reach],
            ];
            let mut shape = rectangle([x, y], [east, north], top);
            shape.rings.push(hole.map(|corner| corner.map(narrow)).to_vec());
            shape
        }
        // Two triangles that meet in a point, as one ring.
        _ => {
            let (h, v) = (s / 2, s / 3);
            prism(
                &[[x, y], [x + h, y + v], [x + 2 * h, y], [x + 2 * h, y + 2 * v], [x + h, y + v], [x, y + 2 * v]],
                top,
            )
        }
    }
}

/// Draws towers from a step to a hand wide, some of them exactly in a row of receivers.
pub(super) fn needles(draw: &mut Draw) -> StressScene {
    let mut prisms = Vec::new();
    for _ in 0..draw.within(8, 16) {
        let half = draw.choose(&[1, 1, 2, 32, 100]);
        let mut along = || match draw.within(0, 2) {
            0 => draw.within(2, N - 2) * CELL + CELL / 2,
            1 => draw.within(2, N - 2) * CELL + CELL / 2 + half,
            _ => draw.within(2 * CELL, (N - 2) * CELL),
        };
        let (x, y) = (along(), along());
        prisms.push(rectangle([x - half, y - half], [x + half, y + half], draw.within(50, 300) * CELL));
    }
    let x = draw.within(1, N - 2) * CELL + CELL / 2;
    let y = draw.choose(&[CELL / 2, CELL, -CELL / 2]);
    scene(prisms, LatticePoint { x, y, z: draw.within(2, 40) * CELL })
}

/// Draws roofs at powers of two, from 1/1024 m to 16 km.
pub(super) fn magnitudes(draw: &mut Draw) -> StressScene {
    let mut prisms = Vec::new();
    for _ in 0..14 {
        let [x, y] = [draw.within(0, (N - 2) * CELL), draw.within(CELL, (N - 2) * CELL)];
        let [w, h] = [draw.within(1, 3 * CELL), draw.within(1, 3 * CELL)];
        prisms.push(rectangle([x, y], [x + w, y + h], 1 << draw.within(0, 24)));
    }
    let over_all = draw.chance(50);
    let x = draw.within(0, N * CELL);
    let uav = if over_all {
        LatticePoint { x, y: draw.within(0, N * CELL), z: (1 << 24) + (1 << draw.within(0, 23)) }
    } else {
        LatticePoint { x, y: -draw.within(0, 2 * CELL), z: 1 << draw.within(0, 23) }
    };
    let mut scene = scene(prisms, uav);
    scene.rx_height = narrow(draw.choose(&[0, 1, 1536]));
    scene
}

/// Draws a town of rectangles and triangles.
fn town(draw: &mut Draw) -> Vec<StressPrism> {
    let mut prisms = Vec::new();
    for _ in 0..12 {
        let [x, y] = [draw.within(4, 4 * N - 12), draw.within(4, 4 * N - 12)].map(|v| v * CELL / 4);
        let [w, h] = [draw.within(2, 12), draw.within(2, 12)].map(|v| v * CELL / 4);
        let top = draw.choose(&[3, 7, 7, 18]) * CELL;
        let shape = match draw.within(0, 2) {
            0 => prism(&[[x, y], [x + w, y], [x, y + h]], top),
            1 => prism(&[[x, y], [x + w, y + h / 2], [x + w / 2, y + h]], top),
            _ => rectangle([x, y], [x + w, y + h], top),
        };
        prisms.push(shape);
    }
    prisms
}

/// Draws a town far from the origin of its coordinates, under odd, oblong cells.
pub(super) fn utm(draw: &mut Draw) -> StressScene {
    let prisms = town(draw);
    let uav = uav(draw, 18 * CELL);
    let mut scene = scene(prisms, uav);
    scene.cell = draw.choose(&[(0.97, 0.97), (0.7, 1.3), (1.1, 0.9)]);
    let (x_origin, y_origin) = draw.choose(&[(691_549.0, 5_334_762.0), (32_398_551.0, 9_999_017.0), (-5.0, -7e6)]);
    scene.world = Frame { x_origin, y_origin, unit_x: 1.0, unit_y: 1.0 };
    scene
}

/// Draws a town for the eight symmetries.
pub(super) fn mirrored(draw: &mut Draw) -> StressScene {
    let prisms = town(draw);
    let uav = uav(draw, 18 * CELL);
    scene(prisms, uav)
}
