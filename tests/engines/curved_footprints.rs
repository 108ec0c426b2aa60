//! The curve of the earth over footprints: rays against the oracle, whole maps against both.

use num_bigint::BigInt;
use num_rational::Ratio;
use serde_json::Value;
use skyshed_core::city::Ground;
use skyshed_core::coverage::{MapOptions, Mapper, Receivers, class};
use skyshed_core::height_field::{Bulge, CellKind, CurvedGround, HeightField, Prisms, Station};
use skyshed_core::los::{
    MethodChoice, ShadowGrid, ShadowScene, prisms_least_height, prisms_least_receiver_height, prisms_los, shadow_los,
    shadow_los_relief,
};
use skyshed_core::quantity::LatticePoint;
use skyshed_core::raster::{GeoRef, Raster};
use skyshed_core::simd::SimdLevel;

use crate::curvature::{EARTHS, curvature, drop};
use crate::invariants::{map, uav_at, vector_town, vector_town_on};
use crate::oracle::{self, Earth, Prism};
use crate::program::Folder;
use crate::referee::over_seeds;
use crate::shadow::scaled_scene;
use crate::shapes::turn;
use crate::support::{ENVIRONMENTS, Random, cells_where, city, is_long};
use crate::translation::{point, prisms_of};

/// drop d² with d in steps of 1/1024 m, the drop in these as well: d² / 2KR with R = 6 371 008.8 m.
fn earth((p, q): (i128, i128), ground: Option<i64>) -> Earth {
    Earth { drop: Ratio::new(BigInt::from(q * 10), BigInt::from(1024 * 2 * p * 63_710_088)), ground }
}

fn bulge(of: (i128, i128)) -> Bulge {
    Bulge::new(curvature(of), 1.0).unwrap()
}

#[test]
fn rays_over_curved_roofs_are_those_of_the_oracle() {
    let count = over_seeds(if is_long() { 200_000 } else { 6_000 }, 341, |seed, random, count| {
        let scene = scaled_scene(random);
        // So curved that some meters bend by meters, or by a step.
        let of = random.choose(&[(1, 700_000), (1, 3_000_000), (1, 100_000), (1, 1000), (4, 3)]);
        let ground = random.choose(&[None, Some(0), Some(-1024)]);
        let earth = earth(of, ground);
        let prisms = prisms_of(&scene);
        let on_earth =
            prisms.on_earth(Some(CurvedGround { bulge: bulge(of), ground: ground.map(|z| i32::try_from(z).unwrap()) }));
        let end = |random: &mut Random| {
            let at = |random: &mut Random| random.within(-2, 14) * 512 + random.choose(&[0, 0, 0, 1, 13]);
            let top = scene[random.below(scene.len())].top;
            let z = random.choose(&[0, 0, 1, 512, 1536, top, top + 1, 3 * 1024, 7 * 1024, 20 * 1024]);
            [at(random), at(random), z]
        };
        for _ in 0..12 {
            let (uav, receiver) = (end(random), end(random));
            let wanted = oracle::prisms_los_on_earth(&scene, &earth, uav, receiver);
            let what = || format!("seed {seed}: {of:?}, ground {ground:?}, {uav:?} to {receiver:?}, {scene:?}");
            assert_eq!(prisms_los(&on_earth, point(uav), point(receiver)), wanted, "{}", what());
            assert_eq!(prisms_los(&on_earth, point(receiver), point(uav)), wanted, "reverse, {}", what());
            count.add(wanted);
        }
    });
    count.assert_both(20_000);
}

#[test]
#[expect(clippy::cast_possible_truncation, reason = "a height in steps")]
fn least_heights_over_curved_roofs_are_where_the_oracle_turns() {
    over_seeds(if is_long() { 40_000 } else { 1250 }, 342, |seed, random, _| {
        let scene = scaled_scene(random);
        let of = random.choose(&[(1, 700_000), (1, 3_000_000), (1, 100_000)]);
        let ground = random.choose(&[None, Some(0)]);
        let earth = earth(of, ground);
        let curved = CurvedGround { bulge: bulge(of), ground: ground.map(|z| i32::try_from(z).unwrap()) };
        let prisms = prisms_of(&scene).on_earth(Some(curved));
        let at = |random: &mut Random| random.within(-2, 14) * 512;
        for _ in 0..6 {
            let uav = [at(random), at(random), random.choose(&[0, 1536, 4096, 9000])];
            let receiver = [at(random), at(random), 0];
            if uav[..2] == receiver[..2] {
                continue;
            }
            let of_receiver = prisms_least_receiver_height(&prisms, point(uav), point(receiver)).height_steps();
            let of_uav = prisms_least_height(&prisms, point(receiver), point(uav)).height_steps();
            let what = || format!("seed {seed}: {of:?}, ground {ground:?}, {uav:?} to {receiver:?}, {scene:?}");
            let are_equal = of_receiver.to_bits() == of_uav.to_bits() || (of_receiver - of_uav).abs() < 1e-6;
            assert!(are_equal, "{of_receiver} {of_uav}, {}", what());
            let sees = |z: i64| oracle::prisms_los_on_earth(&scene, &earth, uav, [receiver[0], receiver[1], z]);
            // Ground bounds no end that is on it.
            let lowest = ground.unwrap_or(-90_000);
            if of_receiver == f64::INFINITY {
                assert!(!sees(1 << 26), "{}", what());
            } else if of_receiver > lowest as f64 + 1.0 {
                let step = |z: f64| i64::try_from(z.ceil() as i128).unwrap();
                assert!(sees(step(of_receiver + 1e-3)), "{of_receiver}, {}", what());
                assert!(!sees(step(of_receiver - 1e-3) - 1), "{of_receiver}, {}", what());
            } else {
                assert!(sees(lowest + 2), "{of_receiver}, {}", what());
            }
        }
    });
}

/// The prisms of a field as the oracle takes them.
fn of_field(field: &HeightField) -> Vec<Prism> {
    let prisms = field.prisms().unwrap();
    let ring = |piece| prisms.ring(piece).iter().map(|v| v.map(i64::from)).collect();
    prisms.pieces().iter().map(|piece| Prism { rings: vec![ring(piece)], top: i64::from(piece.top) }).collect()
}

/// Receivers of a map: their cells, and where they are on the lattice of the prisms.
fn receivers_of(field: &HeightField, receivers: Receivers) -> Vec<(usize, LatticePoint)> {
    let positions = field.positions();
    let n_cols = field.grid().n_cols();
    let of = |cell: usize| {
        let place = positions.center(cell / n_cols, cell % n_cols);
        let base = match field.cell_kind(cell, &place) {
            CellKind::Open(z) if receivers != Receivers::Roof => z,
            CellKind::Building(z) if receivers != Receivers::Ground => z,
            _ => return None,
        };
        Some((cell, Station { place, z: i64::from(base) + 1536 }.on_prisms()))
    };
    (0..field.grid().n_cells()).filter_map(of).collect()
}

#[test]
fn maps_of_footprints_on_a_curved_earth_are_those_of_the_oracle() {
    let count = over_seeds(if is_long() { 600 } else { 15 }, 343, |seed, random, count| {
        let field = vector_town(random, 35);
        let scene = of_field(&field);
        let of = EARTHS[usize::try_from(seed).unwrap() % EARTHS.len()];
        let receivers = random.choose(&[Receivers::Ground, Receivers::Roof, Receivers::All]);
        let (x, y) =
            (random.within(-20, 55) as f64 + random.choose(&[0.0, 0.5, 0.25]), random.within(-9, 40) as f64 + 0.5);
        let uav = uav_at(&field, x, y, random.choose(&[1500, 1537, 4096, 9000, 13_000, 20_000, 60_000]));
        let options = MapOptions { curvature: Some(curvature(of)), receivers, ..MapOptions::default() };
        let found = map(&field, &uav, &options);
        let mapper = Mapper::new(&field, &options).unwrap();
        assert_eq!(mapper.seen_from(&uav).unwrap().count(), (found.tally.receivers, found.tally.los));
        let by_rays = map(&field, &uav, &MapOptions { method: MethodChoice::Ray, ..options.clone() });
        assert!(by_rays.mask == found.mask, "seed {seed}: {of:?} {receivers:?} {:?}", uav.station);
        let here = uav.station.on_prisms();
        let earth = earth(of, Some(0));
        for (cell, there) in receivers_of(&field, receivers) {
            let wanted =
                oracle::prisms_los_on_earth(&scene, &earth, [here.x, here.y, here.z], [there.x, there.y, there.z]);
            let what = || format!("seed {seed}: {of:?} {receivers:?} {here:?} {there:?} {scene:?}");
            assert_eq!(found.mask[cell], if wanted { class::LOS } else { class::NLOS }, "{}", what());
            count.add(wanted);
        }
    });
    count.assert_both(2000);
}

/// A convex counterclockwise ring of some corners around a middle, most of them oblong or with a corner far out.
fn ring(random: &mut Random, [x, y]: [i64; 2], size: i64) -> Vec<[i64; 2]> {
    loop {
        let stretch = random.choose(&[1, 1, 4, 20]);
        let n = random.index(3, 7);
        let mut corners: Vec<[i64; 2]> =
            (0..n).map(|_| [x + random.within(-size, size), y + random.within(-size, size) / stretch]).collect();
        // The hull, by turning around the middle of the corners.
        corners.sort_by_key(|c| (c[0], c[1]));
        corners.dedup();
        let half = |of: &mut dyn Iterator<Item = [i64; 2]>| {
            let mut hull: Vec<[i64; 2]> = Vec::new();
            for c in of {
                while hull.len() >= 2 && turn(hull[hull.len() - 2], hull[hull.len() - 1], c) <= 0 {
                    hull.pop();
                }
                hull.push(c);
            }
            hull.pop();
            hull
        };
        let lower = half(&mut corners.iter().copied());
        let upper = half(&mut corners.iter().rev().copied());
        let hull = [lower, upper].concat();
        if hull.len() >= 3 {
            return hull;
        }
    }
}

/// Single roofs, of which most are neither rectangles nor small, seen from near the plane that touches the earth below them, by receivers
/// some steps below the roof and anywhere.
#[test]
#[expect(clippy::cast_possible_truncation, reason = "heights in steps")]
fn roofs_near_the_height_of_the_uav_hide_what_rays_say() {
    let count = over_seeds(if is_long() { 400_000 } else { 20_000 }, 345, |seed, random, count| {
        let (of, size, far) = random.choose(&[
            ((4, 3), 40_000, 2_000_000),
            ((1, 250), 40_000, 400_000),
            ((1, 1000), 900_000, 4_000_000),
            ((1, 100_000), 30_000, 60_000),
        ]);
        let middle = [random.within(-far, far), random.within(-far, far)];
        let ring = ring(random, middle, size);
        let drop_at = |at: [i64; 2]| {
            let squared = (at[0] * at[0] + at[1] * at[1]) as f64;
            squared * bulge(of).coefficient()
        };
        let (fall, bulges) = (drop_at(middle), bulge(of).coefficient() * (2 * size * size) as f64);
        let slope = 2.0 * bulge(of).coefficient() * size as f64 * f64::hypot(middle[0] as f64, middle[1] as f64);
        let step = |v: f64| v as i64;
        let below =
            random.choose(&[fall, fall + bulges, fall - bulges, fall + slope, fall + 3.0 * bulges, fall + 9000.0]);
        let top = -step(below) + random.within(-2, 2);
        let uav = LatticePoint { x: 0, y: 0, z: 0 };
        let piece = ring.iter().map(|v| v.map(|v| i32::try_from(v).unwrap())).collect::<Vec<_>>();
        let top_of = |z: i64| i32::try_from(z.clamp(-(1 << 25), 1 << 25)).unwrap();
        let prisms = Prisms::new([(piece, top_of(top), 0)]);
        let prisms = prisms.on_earth(Some(CurvedGround { bulge: bulge(of), ground: None }));
        // Receivers around and behind the roof, before their horizon.
        let spread = 3 * size;
        let mut xs: Vec<i64> = (0..12).map(|_| middle[0] + random.within(-spread, spread)).collect();
        let mut ys: Vec<i64> = (0..12).map(|_| middle[1] + random.within(-spread, spread)).collect();
        xs.sort_unstable();
        xs.dedup();
        ys.sort_unstable_by(|a, b| b.cmp(a));
        ys.dedup();
        let level = top_of(top) - top_of(random.choose(&[1, 2, 3, step(bulges) / 2 + 1, step(bulges) + 9, 2000]));
        let is_level = random.chance(50);
        let height = |row: usize, col: usize| {
            if is_level { level } else { level - i32::try_from((row * 7919 + col * 104_729) % 3000).unwrap() }
        };
        let falls = |row: usize, col: usize| drop_at([xs[col], ys[row]]) < 0.999 * -f64::from(height(row, col));
        let wanted = cells_where((ys.len(), xs.len()), falls);
        let grid = ShadowGrid::new(xs.clone(), ys.clone());
        let (casters, level_of_simd) = (prisms.casters(), SimdLevel::new());
        let scene =
            ShadowScene { prisms: &prisms, casters, grid: &grid, wanted: &wanted, level: level_of_simd, n_bands: 1 };
        let found = match is_level {
            true => shadow_los(&scene, uav, i64::from(level)),
            false => shadow_los_relief(&scene, uav, &height),
        };
        for (row, col) in wanted.cells() {
            let receiver = LatticePoint { x: xs[col], y: ys[row], z: i64::from(height(row, col)) };
            let is_los = prisms_los(&prisms, uav, receiver);
            let what = || format!("seed {seed}: {of:?}, {ring:?} at {top}, {receiver:?}, level {is_level}");
            assert_eq!(found.los.contains(row, col), is_los, "{}", what());
            count.add(is_los);
        }
    });
    // Most receivers are beside the shadow.
    assert!(count.los > 1_000_000 && count.links - count.los > 100_000, "{count:?}");
}

/// Where a shadow ends, receivers a lattice step apart are told as rays tell them: there a roof that bulges hides less than a flat one.
#[test]
#[expect(clippy::cast_possible_truncation, reason = "heights in steps")]
fn shadows_of_bulging_roofs_end_at_the_step_where_those_of_rays_do() {
    let count = over_seeds(if is_long() { 60_000 } else { 1500 }, 346, |seed, random, count| {
        let of = random.choose(&[(1, 1000), (1, 10_000), (1, 100_000), (1, 300_000)]);
        let size = random.choose(&[20_000, 60_000, 200_000]);
        let c = bulge(of).coefficient();
        let middle = [random.choose(&[3, 5, 9]) * size, random.within(-2 * size, 2 * size)];
        let ring = ring(random, middle, size);
        let squared = |x: i64, y: i64| (x as f64).powi(2) + (y as f64).powi(2);
        // So high that receivers twice as far as the roof are before their horizon.
        let fall = c * squared(3 * middle[0], 3 * middle[1].abs() + size);
        if fall > 2e7 {
            return;
        }
        let step = |v: f64| v as i64;
        let high = step(fall) + random.within(2000, 200_000);
        let roof = random.within(500, (high - step(c * squared(middle[0], middle[1]))).max(1000) * 3 / 4);
        let uav = LatticePoint { x: 0, y: 0, z: high };
        let piece = ring.iter().map(|v| v.map(|v| i32::try_from(v).unwrap())).collect::<Vec<_>>();
        let prisms = Prisms::new([(piece, i32::try_from(roof).unwrap(), 0)]);
        let prisms = prisms.on_earth(Some(CurvedGround { bulge: bulge(of), ground: None }));
        // Along a row of receivers from the roof on, the last one that is hidden.
        let y = middle[1] + random.within(-size / 2, size / 2);
        let sees = |x: i64| prisms_los(&prisms, uav, LatticePoint { x, y, z: 0 });
        let (mut hidden, mut seen) = (middle[0], 3 * middle[0]);
        if sees(hidden) || !sees(seen) {
            return;
        }
        while seen - hidden > 1 {
            let x = hidden + (seen - hidden) / 2;
            if sees(x) { seen = x } else { hidden = x }
        }
        let xs: Vec<i64> = (hidden - 31..hidden + 33).collect();
        let ys = vec![y + 1, y, y - 1];
        let grid = ShadowGrid::new(xs.clone(), ys.clone());
        let wanted = cells_where((ys.len(), xs.len()), |_, _| true);
        let scene = ShadowScene {
            prisms: &prisms,
            casters: prisms.casters(),
            grid: &grid,
            wanted: &wanted,
            level: SimdLevel::new(),
            n_bands: 1,
        };
        let found = shadow_los(&scene, uav, 0).los;
        for (row, col) in wanted.cells() {
            let receiver = LatticePoint { x: xs[col], y: ys[row], z: 0 };
            let is_los = prisms_los(&prisms, uav, receiver);
            assert_eq!(
                found.contains(row, col),
                is_los,
                "seed {seed}: {of:?}, {ring:?} at {roof}, UAV at {high}, {receiver:?}"
            );
            count.add(is_los);
        }
    });
    count.assert_both(20_000);
}

#[test]
fn footprints_on_a_terrain_are_hidden_by_either() {
    let count = over_seeds(if is_long() { 400 } else { 12 }, 344, |seed, random, count| {
        let n = 28;
        let grid = GeoRef::new((0.0, n as f64), (1.0, 1.0), (n, n), None).unwrap();
        let heights: Vec<i32> = (0..n * n)
            .map(|_| if random.chance(4) { 6000 } else { i32::try_from(random.within(0, 900)).unwrap() })
            .collect();
        let field = vector_town_on(random, Ground::Terrain(Raster::new(grid, heights.clone())), n);
        let scene = of_field(&field);
        let of = random.choose(&[(4, 3), (1, 100_000), (1, 400_000)]);
        let uav = uav_at(&field, random.within(0, 27) as f64 + 0.5, 13.5, random.choose(&[9000, 13_000, 30_000]));
        let (here, on_columns) = (uav.station.on_prisms(), uav.station.on_columns());
        // The terrain and the receivers against it are lower by what the earth falls away by at the centers of cells, rounded.
        let fall = |cell: usize| {
            let center = |k: usize| 1024 * i64::try_from(k).unwrap() + 512;
            drop(of, center(cell % n) - on_columns.x, center(n - 1 - cell / n) - on_columns.y)
        };
        let lowered = heights.iter().enumerate().map(|(cell, z)| Some(i64::from(*z) - fall(cell))).collect();
        let columns = oracle::Columns { n_cols: n, n_rows: n, heights: lowered };
        let earth = earth(of, None);
        let receivers = random.choose(&[Receivers::Ground, Receivers::Roof, Receivers::All]);
        let options = MapOptions { curvature: Some(curvature(of)), receivers, ..MapOptions::default() };
        let found = map(&field, &uav, &options);
        let by_rays = map(&field, &uav, &MapOptions { method: MethodChoice::Ray, ..options });
        assert!(found.mask == by_rays.mask, "seed {seed}");
        for (cell, there) in receivers_of(&field, receivers) {
            let past_prisms =
                oracle::prisms_los_on_earth(&scene, &earth, [here.x, here.y, here.z], [there.x, there.y, there.z]);
            let on_column = field.positions().center(cell / n, cell % n);
            let on_column = Station { place: on_column, z: there.z - fall(cell) }.on_columns();
            let past_columns = oracle::columns_los(
                &columns,
                [on_columns.x, on_columns.y, on_columns.z],
                [on_column.x, on_column.y, on_column.z],
            );
            let wanted = past_prisms && past_columns;
            let what = || format!("seed {seed}: {of:?} {receivers:?} {here:?} {there:?} in {cell}");
            assert_eq!(found.mask[cell], if wanted { class::LOS } else { class::NLOS }, "{}", what());
            count.add(wanted);
        }
    });
    count.assert_both(2000);
}

#[test]
fn shadows_of_a_wide_city_end_where_those_of_rays_do() {
    // Cells of odd size, kilometers away, from over the roofs, from among them and from so low that some shadows have no end.
    let size = if is_long() { 8000.0 } else { 2500.0 };
    for (k, name) in ["urban", "high-rise"].into_iter().enumerate() {
        let field = city(name, size, 17.3, 9);
        for (j, of) in [(4, 3), (7, 6), (1, 130)].into_iter().enumerate() {
            for z in [25, 99, 130] {
                let mut random = Random((100 * k + 10 * j) as u64 + z);
                let mut along = || random.within(0, 1000) as f64 / 1000.0 * size;
                let uav = uav_at(&field, along(), along(), i64::try_from(z).unwrap() * 1024);
                let options = MapOptions { curvature: Some(curvature(of)), ..MapOptions::default() };
                let by_rays = map(&field, &uav, &MapOptions { method: MethodChoice::Ray, ..options.clone() });
                let found = map(&field, &uav, &options);
                assert!(found.mask == by_rays.mask, "{name} {of:?} {:?}", uav.station);
                let flat = map(&field, &uav, &MapOptions::default());
                // Every ray sags.
                let is_gained = |(curved, flat): (&u8, &u8)| *curved == class::LOS && *flat != class::LOS;
                assert!(!found.mask.iter().zip(&*flat.mask).any(is_gained), "{name} {of:?}");
            }
        }
    }
}

#[test]
fn shadows_over_curved_cities_are_those_of_rays() {
    let n = if is_long() { 1500.0 } else { 400.0 };
    for (k, name) in ENVIRONMENTS.iter().enumerate() {
        let field = city(name, n, 1.0, 5);
        for (j, of) in [(4, 3), (7, 6), (1, 1000), (1, 20_000), (1, 50_000)].into_iter().enumerate() {
            for receivers in [Receivers::Ground, Receivers::All] {
                let mut random = Random(1000 + (10 * k + j) as u64);
                let along = |random: &mut Random| random.within(-50, 450) as f64 * n / 400.0 + 0.25;
                let uav =
                    uav_at(&field, along(&mut random), along(&mut random), random.choose(&[20, 60, 150, 400]) * 1024);
                let options = MapOptions { curvature: Some(curvature(of)), receivers, ..MapOptions::default() };
                let by_rays = map(&field, &uav, &MapOptions { method: MethodChoice::Ray, ..options.clone() });
                let found = map(&field, &uav, &options);
                let differ = found.mask.iter().zip(&*by_rays.mask).filter(|(a, b)| a != b).count();
                assert_eq!(differ, 0, "{name} {of:?} {receivers:?} {:?}", uav.station);
            }
        }
    }
}

#[test]
fn every_command_tells_the_same_of_a_curved_city() {
    let folder = Folder::new();
    // The earth falls away by 20 m over a kilometer.
    let (scene, k) = ("itu:urban --size 1000 --seed 3", "--earth-k 0.004");
    let map = |words: &str| {
        let run = folder.type_in(&format!("map {scene} --uav 13,17,60 {words} -o m.tif -o m.json --overwrite --json"));
        (run.done().json(), folder.json("m.json"))
    };
    let (flat, _) = map("");
    let (curved, _) = map(k);
    let los = |map: &Value| map["sites"][0]["los"].as_u64().unwrap();
    assert!(los(&curved) < los(&flat) && los(&curved) > 1000, "{} of {}", los(&curved), los(&flat));
    assert_eq!((&curved["earth_k"], &curved["method"]), (&Value::from(0.004), &Value::from("shadow")));
    assert_eq!(map("--earth-k inf").0["digest"], flat["digest"]);
    assert_eq!(map(&format!("{k} --method ray")).0["digest"], curved["digest"]);
    // A height curve at the height of the UAV.
    folder.type_in(&format!("map {scene} --uav 13,17,60 {k} --height-curve c.csv --overwrite -o m.json -q")).done();
    let at_60 = |line: &&str| line.split(',').any(|v| v == "60" || v == "60.0");
    let curve = folder.text("c.csv");
    assert!(curve.lines().any(|line| at_60(&line) && line.contains(&los(&curved).to_string())), "{}", los(&curved));
    // A search counts UAV by UAV.
    let place = |words: &str| {
        folder.type_in(&format!("place {scene} --height 60 --step 200 {words} -o p.csv --overwrite -q")).done();
        folder.text("p.csv")
    };
    assert_ne!(place(k), place(""));
    // Links and tracks sag: beyond the horizon the ground is in the way.
    let link = |words: &str| {
        folder
            .type_in(&format!("link {scene} --uav 13,17,60 --rx {words} --json -o link.png --overwrite"))
            .done()
            .json()
    };
    let (far, near) = (link(&format!("990,990 {k}")), link("990,990"));
    assert_eq!(far["los"], Value::Bool(false));
    assert!(far["margin_m"].as_f64() < near["margin_m"].as_f64());
    // Where no house is, the ground alone is in the way.
    let house = "{\"type\":\"Polygon\",\"coordinates\":[[[0,0],[9,0],[9,9],[0,9],[0,0]]]}";
    folder.write(
        "house.geojson",
        &format!("{{\"type\":\"Feature\",\"properties\":{{\"height\":5}},\"geometry\":{house}}}"),
    );
    let words = "link house.geojson --crs EPSG:32632 --extent 0,0,1000,1000 --uav 13,500,15 --rx 987,500,15amsl --earth-k 0.0005 --json -o link.png --overwrite";
    let horizon = folder.type_in(words).done().json();
    let obstruction = &horizon["obstruction"];
    assert_eq!(obstruction["kind"], "horizon", "{horizon}");
    let at = |name: &str| obstruction[name].as_f64().unwrap();
    // The horizon of a UAV at 15 m is √(2KR · 15 m) away; the ray is lower there by b t(1 − t), b = L²/2KR.
    let (sag, t) = (974.0 * 974.0 / 6371.0088, (15.0 * 6371.0088_f64).sqrt() / 974.0);
    assert!((at("x") - 13.0 - t * 974.0).abs() < 0.01, "{horizon}");
    assert!((at("ray_height_m") - (15.0 - sag * t * (1.0 - t))).abs() < 0.01, "{horizon}");
    folder.write("walk.csv", "x,y\n100,100\n900,900\n");
    let track = |words: &str| {
        let of = format!("track {scene} --uav 13,17,60 --track walk.csv --every 5 {words} --json");
        folder.type_in(&of).done().json()
    };
    let los_m = |words: &str| track(words)["length_m"]["los"].as_f64().unwrap();
    assert!(los_m(k) < los_m(""));
}
