//! Random roofs: gables, hips and sheds, and houses whose heights change.

use super::draw::Draw;
use super::prisms_drawn::shared_walls;
use super::scene::{CELL, StressScene, StressSolid, narrow};
use crate::city::RoofTriangle;
use crate::quantity::LatticePoint;

/// Half a cell; positions are multiples of it.
const HALF: i64 = CELL / 2;

/// Draws houses wall to wall or apart under gables, hips and sheds along either axis. The UAV is at
/// the height of a ridge or some meters above. Positions are multiples of half a cell, so it may be
/// in the plane of a slope.
pub(super) fn gables(draw: &mut Draw) -> StressScene {
    let mut roofs = Vec::new();
    let mut slopes = Vec::new();
    for row in 0..3 {
        for col in 0..3 {
            let [west, south] = [col, row].map(|k| 6 * k * CELL + draw.choose(&[HALF, CELL, 2 * CELL]));
            let [wide, deep] = [4, 4].map(|most| draw.within(2, most) * CELL);
            let (eaves, ridge) = (draw.within(2, 6) * CELL, draw.choose(&[0, 1, 1, 2, 3]) * CELL);
            let hip = draw.choose(&[0, 0, HALF]);
            let house = House { at: [west, south], size: [wide, deep], eaves, ridge: eaves + ridge, hip };
            let turns = draw.chance(50);
            slopes.push((house, turns));
            roofs.push(house.roof(turns, draw.chance(20)));
        }
    }
    let mut along = || draw.within(0, 36) * HALF;
    let (x, y) = (along(), along());
    let (house, _) = draw.choose(&slopes);
    let above = draw.choose(&[0, 0, 1, 2, 6, 12]) * CELL;
    // Over all roofs, or beside the town where it is lower.
    let z = house.ridge + above;
    let y = if z < 10 * CELL { -y / 4 / HALF * HALF } else { y };
    StressScene::of_roofs(roofs, 18, LatticePoint { x, y, z })
}

/// Draws houses that share walls, each moved independently after the city was made.
pub(super) fn redrawn(draw: &mut Draw) -> StressScene {
    let scene = shared_walls(draw);
    let n = match &scene.solid {
        StressSolid::Prisms(prisms) => prisms.len(),
        _ => 0,
    };
    let moved = (0..n).map(|_| narrow(draw.choose(&[-2 * CELL, -1, 0, 0, 1, CELL, 3 * CELL]))).collect();
    let uav = LatticePoint { z: scene.uav.z + 3 * CELL, ..scene.uav };
    StressScene { moved, uav, ..scene }
}

/// House over a rectangle \[lattice steps\].
#[derive(Debug, Clone, Copy)]
struct House {
    at: [i64; 2],
    size: [i64; 2],
    eaves: i64,
    ridge: i64,
    hip: i64,
}

impl House {
    /// Returns its roof, with the ridge along y if it turns: two slopes, or one for a shed, and
    /// hips at the ends if they have a width.
    fn roof(self, turns: bool, is_shed: bool) -> Vec<RoofTriangle> {
        let [long, wide] = if turns { [self.size[1], self.size[0]] } else { self.size };
        let middle = if is_shed { wide } else { wide / 2 / HALF * HALF };
        let hip = if is_shed { 0 } else { self.hip };
        let at = |along: i64, across: i64, z: i64| -> [i32; 3] {
            let [x, y] = if turns { [across, along] } else { [along, across] };
            [self.at[0] + x, self.at[1] + y, z].map(narrow)
        };
        let (e, r) = (self.eaves, self.ridge);
        let [a, b, c, d] = [at(0, 0, e), at(long, 0, e), at(long, wide, e), at(0, wide, e)];
        let (f, g) = (at(hip, middle, r), at(long - hip, middle, r));
        let mut roof = vec![[a, b, g], [a, g, f]];
        if !is_shed {
            roof.extend([[f, g, c], [f, c, d]]);
        }
        if hip > 0 {
            roof.extend([[b, c, g], [d, a, f]]);
        }
        // Along y they run the other way around.
        if turns {
            roof.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        roof
    }
}
