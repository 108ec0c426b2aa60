//! Roofs that are planes: `ray` against the oracle, `shadow` against `ray`, in drawn scenes and at random, on coarse lattices where edges, ridges
//! and planes meet links and each other.

#![expect(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    reason = "small numbers, and a panic is a failed test"
)]

use skyshed_core::height_field::{Prisms, Top};
use skyshed_core::los::{
    LeastHeight, ReceiverTile, ShadowGrid, ShadowScene, UavPositions, prisms_least_height,
    prisms_least_receiver_height, prisms_least_step, prisms_los, shadow_los, shadow_los_relief,
};
use skyshed_core::quantity::LatticePoint;
use skyshed_core::raster::BitGrid;
use skyshed_core::simd::simd_levels;

use crate::oracle::{P3, Sloped, sloped_los};
use crate::referee::{Count, check_cells, over_seeds};
use crate::shadow::Field;
use crate::support::{Random, is_long};
use crate::translation::point;

/// Prisms over triangles, one building each.
fn prisms_of(triangles: &[Sloped]) -> Prisms {
    let narrow = |v: i64| i32::try_from(v).unwrap();
    let piece = |(triangle, building): (&Sloped, u32)| {
        let [a, b, c] = *triangle;
        let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let corners = if doubled > 0 { [a, b, c] } else { [a, c, b] };
        let ring = corners.map(|v| [narrow(v[0]), narrow(v[1])]).to_vec();
        (doubled != 0).then(|| (ring, Top::Sloped(corners.map(|v| narrow(v[2])).to_vec()), building))
    };
    Prisms::with_tops(triangles.iter().zip(0..).filter_map(piece))
}

/// The triangles of a roof over a rectangle whose ridge runs along x, half way up: gables at its ends, or hips of a width.
fn house([west, south, east, north]: [i64; 4], eaves: i64, ridge: i64, hip: i64) -> Vec<Sloped> {
    let middle = (south + north) / 2;
    let [a, b, c, d] = [[west, south, eaves], [east, south, eaves], [east, north, eaves], [west, north, eaves]];
    let (e, f) = ([west + hip, middle, ridge], [east - hip, middle, ridge]);
    let mut roof = vec![[a, b, f], [a, f, e], [c, d, e], [c, e, f]];
    if hip > 0 {
        roof.extend([[b, c, f], [d, a, e]]);
    }
    roof
}

/// A turn by so many quarters and a mirror.
fn turned(triangles: Vec<Sloped>, quarters: usize, mirrored: bool) -> Vec<Sloped> {
    let turn = |[x, y, z]: P3| {
        let [x, y] = [[x, y], [-y, x], [-x, -y], [y, -x]][quarters % 4];
        [if mirrored { -x } else { x }, y, z]
    };
    triangles.into_iter().map(|triangle| triangle.map(turn)).collect()
}

/// Houses that share walls, a meshed hill with gaps, or triangles that lie on one another.
fn random_roofs(random: &mut Random) -> Vec<Sloped> {
    match random.below(3) {
        0 => {
            let mut all = Vec::new();
            for k in 0..random.within(1, 3) {
                let [w, s] = [4 * k + random.within(-1, 0), random.within(-2, 1)];
                let (eaves, hip) = (random.within(0, 3), random.within(0, 1));
                let at = [w, s, w + random.within(2, 4), s + 2 * random.within(1, 2)];
                all.extend(house(at, eaves, eaves + random.within(0, 3), hip));
            }
            turned(all, random.below(4), random.chance(50))
        }
        1 => {
            let n = 4;
            let corners: Vec<P3> = (0..n * n)
                .map(|k| {
                    [
                        3 * (k % n) - 4 + random.within(-1, 1),
                        3 * (k / n) - 4 + random.within(-1, 1),
                        random.within(0, 4),
                    ]
                })
                .collect();
            let at = |x: i64, y: i64| corners[usize::try_from(y * n + x).unwrap()];
            let mut all = Vec::new();
            for k in 0..(n - 1) * (n - 1) {
                let (x, y) = (k % (n - 1), k / (n - 1));
                let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
                let halves = if random.chance(50) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                all.extend(halves.into_iter().filter(|_| random.chance(85)));
            }
            all
        }
        _ => {
            let n = random.within(1, 5);
            (0..n).map(|_| [0; 3].map(|_| [random.within(-4, 6), random.within(-4, 6), random.within(-1, 5)])).collect()
        }
    }
}

fn scaled(triangles: &[Sloped], [x, y, z]: [i64; 3]) -> Vec<Sloped> {
    triangles.iter().map(|t| t.map(|v| [v[0] * x, v[1] * y, v[2] * z])).collect()
}

/// The `k`-th lattice point of a box.
fn random_point(random: &mut Random) -> P3 {
    [random.within(-7, 12), random.within(-7, 9), random.within(-1, 7)]
}

/// Asserts that `ray` says what the oracle does, of a link and of least heights at either end.
fn check(triangles: &[Sloped], (uav, receiver): (P3, P3), scale: [i64; 3], prisms: &Prisms, count: &mut Count) {
    let wanted = sloped_los(triangles, uav, receiver);
    let at = |p: P3| point([0, 1, 2].map(|k| p[k] * scale[k]));
    let (from, to) = (at(uav), at(receiver));
    let what = || format!("{uav:?} {receiver:?} {scale:?} {triangles:?}");
    assert_eq!(prisms_los(prisms, from, to), wanted, "{}", what());
    assert_eq!(prisms_los(prisms, to, from), wanted, "backwards {}", what());
    count.add(wanted);
    if (from.x, from.y) == (to.x, to.y) {
        return;
    }
    // A least height is where `ray`, which the oracle has just been asked about, changes its answer.
    let changes = |least: &LeastHeight, sees: &dyn Fn(i64) -> bool| match least.height_steps() {
        f64::NEG_INFINITY => assert!(sees(-40 * scale[2]), "clear: {}", what()),
        f64::INFINITY => assert!(!sees(40 * scale[2]) && !sees(9000 * scale[2]), "never: {}", what()),
        z => {
            let below = z.ceil() as i64 - 1;
            let whole = (z - z.round()).abs() < 1e-6;
            assert!(sees(z.floor() as i64 + 1) && (whole || !sees(below)) && !sees(below - 1), "{z}: {}", what());
        }
    };
    changes(&prisms_least_receiver_height(prisms, from, to), &|z| prisms_los(prisms, from, LatticePoint { z, ..to }));
    let sees_from = |z: i64| prisms_los(prisms, LatticePoint { z, ..from }, to);
    changes(&prisms_least_height(prisms, from, to), &sees_from);
    let floor = -3 * scale[2];
    match prisms_least_step(prisms, from, to, floor) {
        Some(z) => assert!(sees_from(z) && (z == floor || !sees_from(z - 1)), "{z}: {}", what()),
        None => assert!(!sees_from(9000 * scale[2]), "{}", what()),
    }
}

const SCALES: [[i64; 3]; 4] = [[1, 1, 1], [1024, 1024, 512], [7, 13, 3], [40_000, 50_000, 90_000]];

#[test]
fn ray_past_random_roofs_is_the_oracle() {
    let n = if is_long() { 60_000 } else { 3000 };
    let count = over_seeds(n, 0x510, |seed, random, count| {
        let triangles = random_roofs(random);
        let scale = SCALES[(seed % 4) as usize];
        let prisms = prisms_of(&scaled(&triangles, scale));
        for _ in 0..12 {
            let ends = (random_point(random), random_point(random));
            check(&triangles, ends, scale, &prisms, count);
        }
        // Between corners of roofs, so that links run along edges, ridges and planes.
        for _ in 0..8 {
            let mut corner = || {
                let triangle = random.below(triangles.len().max(1));
                let [x, y, z] = triangles.get(triangle).map_or([0; 3], |of| of[random.below(3)]);
                [x, y, z + random.choose(&[0, 0, 1, -1, 2])]
            };
            let ends = (corner(), corner());
            check(&triangles, ends, scale, &prisms, count);
        }
    });
    count.assert_both(n * 20);
}

#[test]
fn drawn_scenes_are_what_their_drawings_say() {
    // A gable of 4 × 2 × 1 with eaves at 2 and the ridge along x at 3.
    let gable = || house([0, 0, 4, 2], 2, 3, 0);
    let twins = || [gable(), house([4, 0, 8, 2], 2, 3, 0)].concat();
    let stepped = || [gable(), house([0, 2, 4, 4], 2, 3, 0)].concat();
    let cases: Vec<(&str, Vec<Sloped>, P3, P3, bool)> = vec![
        ("grazes the ridge across", gable(), [2, -3, 4], [2, 5, 2], true),
        ("dips below the ridge across", scaled(&gable(), [2, 2, 2]), [4, -6, 8], [4, 10, 3], false),
        ("runs along the ridge, on it", gable(), [-2, 1, 3], [6, 1, 3], true),
        ("runs along below the ridge", scaled(&gable(), [2, 2, 2]), [-4, 2, 5], [12, 2, 5], false),
        ("slides down the slope in its plane", gable(), [2, 1, 3], [2, -1, 1], true),
        ("steeper than the slope from above the ridge", gable(), [2, 1, 4], [2, -1, 1], true),
        ("grazes the ridge, flatter than both slopes", gable(), [2, 5, 5], [2, -1, 2], true),
        ("in the plane of two coplanar neighbors", twins(), [4, 2, 2], [4, 1, 3], true),
        ("below that plane along their common wall", scaled(&twins(), [2, 2, 2]), [8, 6, 3], [8, -1, 3], false),
        ("from the ridge into the valley behind the next ridge", stepped(), [2, 1, 3], [2, 2, 2], true),
        ("over the valley, ridge to ridge", stepped(), [2, 1, 3], [2, 3, 3], true),
        ("ridge to ridge, a step lower", scaled(&stepped(), [2, 2, 2]), [4, 2, 5], [4, 6, 6], false),
        ("the receiver is inside, below the slope", scaled(&gable(), [2, 2, 2]), [4, -6, 9], [4, 1, 4], false),
        ("the receiver is on the slope", scaled(&gable(), [2, 2, 2]), [4, -6, 9], [4, 1, 5], true),
        ("straight down onto the slope", scaled(&gable(), [2, 2, 2]), [4, 1, 9], [4, 1, 5], true),
        ("straight down into the slope", scaled(&gable(), [2, 2, 2]), [4, 1, 9], [4, 1, 4], false),
        ("up along a gable wall, outside", gable(), [0, -1, 0], [0, 3, 9], true),
    ];
    for (name, triangles, uav, receiver, wanted) in cases {
        assert_eq!(sloped_los(&triangles, uav, receiver), wanted, "{name}");
        for scale in SCALES {
            let prisms = prisms_of(&scaled(&triangles, scale));
            check(&triangles, (uav, receiver), scale, &prisms, &mut Count::default());
        }
    }
}

/// Positions along one axis, around the middle of a scene, on and between the corners of roofs.
fn places(random: &mut Random, n: i64, scale: i64) -> Vec<i64> {
    let (step, offset) =
        (random.choose(&[scale, scale, scale / 2, 3 * scale]).max(1), random.choose(&[0, 0, scale / 3]));
    let first = -n / 2 * step + offset;
    (0..n).map(|k| first + k * step).collect()
}

#[test]
fn least_heights_past_random_roofs_are_those_of_walks() {
    let n = if is_long() { 20_000 } else { 1500 };
    let count = over_seeds(n, 0x512, |seed, random, count| {
        let scale = SCALES[(seed % 4) as usize];
        let triangles = scaled(&random_roofs(random), scale);
        let prisms = prisms_of(&triangles);
        let (xs, ys) = (places(random, 16, scale[0]), places(random, 14, scale[1]));
        let ys: Vec<i64> = ys.into_iter().rev().collect();
        let wanted = BitGrid::full(ys.len(), xs.len());
        let level = random.chance(50).then(|| random.within(-1, 4));
        let heights = (0..xs.len() * ys.len())
            .map(|_| (level.unwrap_or_else(|| random.within(-1, 5)) * scale[2]) as i32)
            .collect();
        let [x, y, z] = random_point(random);
        let uav = point([x * scale[0], y * scale[1], z * scale[2] + random.choose(&[0, 0, 1])]);
        let field = Field { xs, ys, heights, wanted };
        let from = random.within(-2, 3) * scale[2];
        let (links, left) = field.compare_heights(&prisms, uav, from, &|| format!("seed {seed}: {triangles:?}"));
        count.links += links;
        count.asked += left;
    });
    assert!(count.links > n * 400 && count.asked * 3 < count.links, "{count:?}");
}

#[test]
fn shadows_of_random_roofs_are_those_of_rays() {
    let n = if is_long() { 40_000 } else { 2500 };
    let levels = simd_levels();
    let count = over_seeds(n, 0x511, |seed, random, count| {
        let scale = SCALES[(seed % 4) as usize];
        let triangles = scaled(&random_roofs(random), scale);
        let prisms = prisms_of(&triangles);
        let (xs, ys) = (places(random, 24, scale[0]), places(random, 20, scale[1]));
        let ys: Vec<i64> = ys.into_iter().rev().collect();
        let grid = ShadowGrid::new(xs.clone(), ys.clone());
        let wanted = BitGrid::full(ys.len(), xs.len());
        let uav = {
            let [x, y, z] = random_point(random);
            point([x * scale[0], y * scale[1], z * scale[2] + random.choose(&[0, 0, 1])])
        };
        let level = levels[random.below(levels.len())];
        let n_bands = random.index(1, 3);
        let scene =
            ShadowScene { prisms: &prisms, casters: prisms.casters(), grid: &grid, wanted: &wanted, level, n_bands };
        let z = random.within(-1, 5) * scale[2] + random.choose(&[0, 0, scale[2] / 2]);
        let what = || format!("seed {seed}: {uav:?}, level {z}, {triangles:?}");
        let found = shadow_los(&scene, uav, z);
        let ray = |row: usize, col: usize| prisms_los(&prisms, uav, LatticePoint { x: xs[col], y: ys[row], z });
        *count += check_cells(&found.los, &wanted, ray, what);
        count.asked += found.asked;
        // Receivers at many heights.
        let heights: Vec<i32> =
            (0..wanted.n_rows() * wanted.n_cols()).map(|_| (random.within(-1, 5) * scale[2]) as i32).collect();
        let height = |row: usize, col: usize| heights[row * xs.len() + col];
        let found = shadow_los_relief(&scene, uav, &height);
        let ray = |row: usize, col: usize| {
            prisms_los(&prisms, uav, LatticePoint { x: xs[col], y: ys[row], z: height(row, col).into() })
        };
        *count += check_cells(&found.los, &wanted, ray, what);
        // Seen from the ground.
        let positions = UavPositions { prisms: &prisms, casters: prisms.casters(), grid: &grid, z, level };
        let receiver = LatticePoint { z: uav.z.min(z - 1), ..uav };
        let tile = ReceiverTile {
            bounds: [receiver.x, receiver.y, receiver.x + scale[0], receiver.y + scale[1]],
            heights: (receiver.z, receiver.z),
        };
        let in_view = positions.from_tile(&tile, &positions.anywhere(&wanted));
        let mut found = in_view.positions.clone();
        positions.los(&in_view, receiver, &mut found);
        let ray = |row: usize, col: usize| prisms_los(&prisms, LatticePoint { x: xs[col], y: ys[row], z }, receiver);
        check_cells(&found, &wanted, ray, || format!("from {receiver:?}: {}", what()));
    });
    count.assert_both(n * 900);
}
