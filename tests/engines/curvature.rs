//! The curve of the earth over rasters: every engine against the oracle over columns that are lowered in exact arithmetic.

use serde_json::Value;
use skyshed_core::city::Ground;
use skyshed_core::coverage::{HeightLayers, MapOptions, Mapper, Receivers, SiteCoverage, Uav, class};
use skyshed_core::height_field::{CellKind, Curvature, HeightField};
use skyshed_core::los::MethodChoice;
use skyshed_core::quantity::{BLOCKS_ALL, VOID};
use skyshed_core::raster::{GeoRef, Raster};

use crate::invariants::{map, uav_at};
use crate::oracle;
use crate::program::Folder;
use crate::referee::{Count, over_seeds};
use crate::support::{Random, is_long, raster_field};

/// K as a fraction: those of radio and light, and such that a few cells bend by meters.
pub(crate) const EARTHS: [(i128, i128); 5] = [(4, 3), (7, 6), (1, 1), (1, 100_000), (1, 700_000)];

/// How much lower a cell is seen so many lattice steps of 1/1024 m away, rounded half up.
pub(crate) fn drop((p, q): (i128, i128), dx: i64, dy: i64) -> i64 {
    // d² / 2KR with R = 6 371 008.8 m, in steps.
    let squared = i128::from(dx) * i128::from(dx) + i128::from(dy) * i128::from(dy);
    let (num, den) = (squared * q * 10, 1024 * 2 * p * 63_710_088);
    i64::try_from((2 * num + den).div_euclid(2 * den)).unwrap()
}

pub(crate) fn curvature((p, q): (i128, i128)) -> Curvature {
    Curvature::of_earth_k(p as f64 / q as f64).unwrap()
}

/// A raster with steps of relief, houses and holes on cells of 1 m.
fn scene(random: &mut Random) -> HeightField {
    let (n_rows, n_cols) = (random.index(5, 45), random.index(5, 45));
    let grid = GeoRef::new((40.0, 90.0), (1.0, 1.0), (n_rows, n_cols), None).unwrap();
    let kind = random.within(0, 2);
    let cells: Vec<i32> = (0..n_rows * n_cols)
        .map(|_| match (random.within(0, 19), kind) {
            (0, _) => VOID,
            (1..=4, _) => i32::try_from(random.within(1, 9000)).unwrap(),
            (_, 0) => 0,
            _ => i32::try_from(random.within(-700, 700)).unwrap(),
        })
        .collect();
    let ground = match random.within(0, 2) {
        0 => Ground::Surface,
        1 => Ground::Flat(0),
        _ => {
            let terrain =
                cells.iter().enumerate().map(|(k, z)| if k % 3 == 0 || *z == VOID { *z } else { (*z).min(99) });
            Ground::Terrain(Raster::new(grid.clone(), terrain.collect::<Vec<_>>()))
        }
    };
    raster_field(Raster::new(grid, cells), ground)
}

/// Compares a map of each engine with the oracle, cell by cell.
fn compare(field: &HeightField, uav: &Uav, earth: (i128, i128), receivers: Receivers, count: &mut Count) {
    let grid = field.grid();
    let (n_rows, n_cols) = (grid.n_rows(), grid.n_cols());
    let curvature = Some(curvature(earth));
    let options = MapOptions { curvature, receivers, ..MapOptions::default() };
    let positions = field.positions();
    let here = uav.station.on_columns();
    let steps = |cell: usize| {
        let place = positions.center(cell / n_cols, cell % n_cols);
        let there = skyshed_core::height_field::Station { place, z: 0 }.on_columns();
        (there.x, there.y)
    };
    let lower = |cell: usize| {
        let (x, y) = steps(cell);
        drop(earth, x - here.x, y - here.y)
    };
    let tops = field.columns().unwrap().tops();
    let heights = (0..tops.len()).map(|k| (tops[k] != VOID).then(|| i64::from(tops[k]) - lower(k))).collect();
    let columns = oracle::Columns { n_cols, n_rows, heights };
    let found = map(field, uav, &options);
    let mapper = Mapper::new(field, &options).unwrap();
    assert_eq!(mapper.seen_from(uav).unwrap().count(), (found.tally.receivers, found.tally.los));
    for method in [MethodChoice::Ray, MethodChoice::Sweep] {
        assert_eq!(map(field, uav, &MapOptions { method, ..options.clone() }).mask, found.mask, "{method:?}");
    }
    for cell in 0..tops.len() {
        let place = positions.center(cell / n_cols, cell % n_cols);
        let base = match field.cell_kind(cell, &place) {
            CellKind::Open(z) if receivers != Receivers::Roof => z,
            CellKind::Building(z) if receivers != Receivers::Ground => z,
            _ => continue,
        };
        let (x, y) = steps(cell);
        let receiver = [x, y, i64::from(base) + 1536 - lower(cell)];
        let wanted = oracle::columns_los(&columns, [here.x, here.y, here.z], receiver);
        let of =
            || format!("K {earth:?}, {receivers:?}, UAV {here:?}, receiver {receiver:?} in cell {cell}\n{columns:?}");
        assert_eq!(found.mask[cell], if wanted { class::LOS } else { class::NLOS }, "{}", of());
        count.add(wanted);
    }
}

#[test]
fn rasters_over_a_curved_earth_are_those_of_the_oracle() {
    let count = over_seeds(if is_long() { 4000 } else { 125 }, 34, |seed, random, count| {
        let field = scene(random);
        let grid = field.grid();
        let (width, depth) = (grid.x_max() - grid.x_min(), grid.y_max() - grid.y_min());
        let along = |random: &mut Random, low: f64, length: f64| match random.within(0, 2) {
            0 => low + (length * 0.5).floor() + 0.5,
            1 => low + random.within(0, 1023) as f64 / 1024.0 * length,
            _ => low + (random.within(-4, 6) as f64 / 2.0 * length).floor(),
        };
        let (x, y) = (along(random, grid.x_min(), width), along(random, grid.y_min(), depth));
        let uav = uav_at(&field, x, y, random.choose(&[1536, 2048, 5000, 9000, 20_000, 60_000]));
        let earth = EARTHS[usize::try_from(seed).unwrap() % EARTHS.len()];
        compare(&field, &uav, earth, random.choose(&[Receivers::Ground, Receivers::Roof, Receivers::All]), count);
    });
    count.assert_both(20_000);
}

/// A raster of some hundred cells a side: rough ground, blocks of houses, cells without data and such that block everything.
fn wide_scene(random: &mut Random) -> HeightField {
    let (n_rows, n_cols) = (random.index(120, 300), random.index(120, 300));
    let grid = GeoRef::new((40.0, 90.0), (1.0, 1.0), (n_rows, n_cols), None).unwrap();
    let (pitch, tallest) = (random.index(9, 25), random.within(3000, 40_000));
    let houses: Vec<i64> = (0..n_rows * n_cols).map(|_| random.within(0, tallest)).collect();
    let cells: Vec<i32> = (0..n_rows * n_cols)
        .map(|k| {
            let (row, col) = (k / n_cols, k % n_cols);
            let is_house = row % pitch < pitch / 2 && col % pitch < pitch / 2;
            let house = if is_house { houses[row / pitch * n_cols + col / pitch] } else { 0 };
            match random.within(0, 1999) {
                0..=3 => VOID,
                4 => BLOCKS_ALL,
                _ => i32::try_from(house + random.within(0, 300)).unwrap(),
            }
        })
        .collect();
    let ground = match random.within(0, 2) {
        0 => Ground::Surface,
        1 => Ground::Flat(0),
        _ => {
            let low = |z: &i32| if *z == VOID || *z == BLOCKS_ALL { VOID } else { (*z).min(280) };
            Ground::Terrain(Raster::new(grid.clone(), cells.iter().map(low).collect::<Vec<_>>()))
        }
    };
    raster_field(Raster::new(grid, cells), ground)
}

#[test]
fn wide_rasters_over_a_curved_earth_are_swept_as_rays_pass_them() {
    let count = over_seeds(if is_long() { 400 } else { 12 }, 37, |seed, random, count| {
        let field = wide_scene(random);
        let grid = field.grid();
        let at = |random: &mut Random, low: f64, high: f64| {
            low + ((high - low) * random.within(-1, 5) as f64 / 4.0).floor() + 0.5
        };
        let (x, y) = (at(random, grid.x_min(), grid.x_max()), at(random, grid.y_min(), grid.y_max()));
        let uav = uav_at(&field, x, y, random.choose(&[42_000, 50_000, 90_000]));
        let earth = random.choose(&[(4, 3), (1, 1000), (1, 20_000), (1, 100_000)]);
        let receivers = random.choose(&[Receivers::Ground, Receivers::Roof, Receivers::All]);
        let options = MapOptions { curvature: Some(curvature(earth)), receivers, ..MapOptions::default() };
        let [swept, walked] = [MethodChoice::Sweep, MethodChoice::Ray]
            .map(|method| map(&field, &uav, &MapOptions { method, ..options.clone() }).mask);
        for (cell, (swept, walked)) in swept.iter().zip(&walked).enumerate() {
            assert_eq!(swept, walked, "seed {seed}, K {earth:?}, {receivers:?}, cell {cell}");
            if *walked == class::LOS || *walked == class::NLOS {
                count.add(*walked == class::LOS);
            }
        }
    });
    count.assert_both(100_000);
}

/// A raster of few flat blocks, on ground that is at some places lower, or without data.
pub(crate) fn block_model(random: &mut Random) -> HeightField {
    let (n_rows, n_cols) = (random.index(512, 560), random.index(512, 560));
    let (pitch, tallest) = (random.index(25, 60), random.within(3000, 50_000));
    let n_along = n_cols / pitch + 1;
    let has_low_ones = random.chance(50);
    let blocks: Vec<i64> = (0..(n_rows / pitch + 1) * n_along)
        .map(|_| match random.within(0, 29) {
            0 => i64::from(VOID),
            1 if has_low_ones => -random.within(0, 4000),
            2..=9 => 0,
            _ => random.within(1, tallest),
        })
        .collect();
    let cells = (0..n_rows * n_cols).map(|k| {
        let (row, col) = (k / n_cols, k % n_cols);
        let is_block = row % pitch < pitch * 2 / 3 && col % pitch < pitch / 2;
        let top = if is_block { blocks[row / pitch * n_along + col / pitch] } else { 0 };
        i32::try_from(top).unwrap()
    });
    let grid = GeoRef::new((40.0, 90.0), (1.0, 1.0), (n_rows, n_cols), None).unwrap();
    raster_field(Raster::new(grid, cells.collect::<Vec<_>>()), Ground::Flat(0))
}

#[test]
fn shadows_of_plateaus_over_a_curved_earth_are_those_of_rays() {
    let count = over_seeds(if is_long() { 4000 } else { 200 }, 38, |seed, random, count| {
        let field = block_model(random);
        let lowest = field.plateaus().expect("few flat blocks").lowest();
        let grid = field.grid();
        let at = |random: &mut Random, low: f64, high: f64| match random.within(0, 2) {
            0 => low + ((high - low) * random.within(-1, 5) as f64 / 4.0).floor() + 0.5,
            1 => low + (high - low) * random.within(0, 1023) as f64 / 1024.0,
            _ => low + ((high - low) * random.within(0, 8) as f64 / 8.0).floor(),
        };
        let (x, y) = (at(random, grid.x_min(), grid.x_max()), at(random, grid.y_min(), grid.y_max()));
        let earth = random.choose(&[(4, 3), (1, 100), (1, 1000), (1, 3000), (1, 10_000), (1, 30_000)]);
        // From where the farthest receivers are beyond the horizon to far above all.
        let fall = drop(earth, 1024 * i64::try_from(grid.n_cols()).unwrap(), 0);
        let z = random.choose(&[fall / 2, fall * 3 / 2, fall * 3, 500, 3000, 30_000, 60_000, 150_000]).max(200);
        let uav = uav_at(&field, x, y, z);
        let rx_height = random.choose(&[1536, 1536, 0, 1]);
        let options = MapOptions { curvature: Some(curvature(earth)), rx_height, ..MapOptions::default() };
        let [cast, walked] = [MethodChoice::Shadow, MethodChoice::Ray]
            .map(|method| map(&field, &uav, &MapOptions { method, ..options.clone() }).mask);
        for (cell, (cast, walked)) in cast.iter().zip(&walked).enumerate() {
            assert_eq!(cast, walked, "seed {seed}, K {earth:?}, lowest {lowest}, UAV {:?}, cell {cell}", uav.station);
            if *walked == class::LOS || *walked == class::NLOS {
                count.add(*walked == class::LOS);
            }
        }
    });
    assert!(count.links > 40_000_000 && count.los > 2_000_000 && count.links - count.los > 2_000_000, "{count:?}");
}

#[test]
fn layers_over_a_curved_earth_are_those_of_walks() {
    let layers = HeightLayers {
        margin: true,
        least_receiver_height: true,
        least_height: true,
        stability: true,
        sure: false,
        p_los: false,
    };
    over_seeds(if is_long() { 2000 } else { 50 }, 35, |_, random, _| {
        let field = scene(random);
        let grid = field.grid();
        let uav = uav_at(&field, grid.x_min() + 2.5, grid.y_min() + 2.5, random.choose(&[3000, 9000, 40_000]));
        let curvature = Some(curvature((1, 300_000)));
        let options = MapOptions { layers, curvature, receivers: Receivers::All, ..MapOptions::default() };
        let (a, b) =
            (map(&field, &uav, &options), map(&field, &uav, &MapOptions { method: MethodChoice::Ray, ..options }));
        let bits = |of: &Option<Vec<f32>>| of.as_ref().unwrap().iter().map(|z| z.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&a.margin), bits(&b.margin));
        assert_eq!(bits(&a.least_receiver_height), bits(&b.least_receiver_height));
        assert_eq!(bits(&a.least_height), bits(&b.least_height));
        let turns = |of: &SiteCoverage| {
            of.stability.as_ref().map(|found| (found.moves.clone(), bits(&Some(found.turns.clone()))))
        };
        assert_eq!(turns(&a), turns(&b));
        // A receiver is in line of sight from its least height up, above the datum.
        let (least, margin) = (a.least_receiver_height.unwrap(), a.margin.unwrap());
        let positions = field.positions();
        for cell in (0..least.len()).filter(|cell| matches!(a.mask[*cell], class::LOS | class::NLOS)) {
            let place = positions.center(cell / grid.n_cols(), cell % grid.n_cols());
            if let CellKind::Open(z) | CellKind::Building(z) = field.cell_kind(cell, &place) {
                let height = f64::from(z + 1536) / 1024.0;
                if !least[cell].is_finite() || !margin[cell].is_finite() {
                    continue;
                }
                let by_margin = height - f64::from(margin[cell]);
                assert!((by_margin - f64::from(least[cell])).abs() < 1e-3 * (1.0 + f64::from(least[cell].abs())));
            }
        }
    });
}

#[test]
fn an_earth_that_is_hardly_curved_is_flat() {
    let mut random = Random(36);
    for _ in 0..20 {
        let field = scene(&mut random);
        let uav = uav_at(&field, field.grid().x_min() + 3.5, field.grid().y_min() + 1.5, 5000);
        let curvature = Curvature::of_earth_k(1e12);
        let flat = map(&field, &uav, &MapOptions::default());
        assert_eq!(map(&field, &uav, &MapOptions { curvature, ..MapOptions::default() }).mask, flat.mask);
    }
    assert_eq!([0.0, -1.0, f64::NAN, f64::INFINITY].map(Curvature::of_earth_k), [None; 4]);
}

/// The earth does not fall away below the UAV itself, whatever it does at the middle of its cell; and beside a raster on flat ground there is
/// that ground.
#[test]
fn a_uav_over_a_curved_earth_needs_no_height_below_its_ground() {
    let folder = Folder::new();
    let tops: Vec<i32> = (0..1600).map(|k| if k / 40 % 7 < 2 && k % 9 < 3 { 84 } else { 70 }).collect();
    folder.write("dsm.asc", &crate::texts::grid(&tops, 40, -9999));
    for (scene, uav) in [
        ("dsm.asc --ground 70", "20.05,17.95,30"),
        ("dsm.asc --ground 70", "-15.3,20,30"),
        ("dsm.asc", "20.05,17.95,30"),
        ("dsm.asc --terrain dsm.asc", "20.05,17.95,30"),
    ] {
        let line =
            format!("map {scene} --uav={uav} --earth-k 0.00002 --layers least-height -o least.tif --overwrite -q");
        folder.type_in(&line).done();
        let file = crate::masks::tif(&folder, "least.tif");
        let heights: Vec<f32> = file.read_band::<f32>(0).unwrap().into_iter().filter(|z| *z > -9000.0).collect();
        let lowest = heights.iter().copied().fold(f32::INFINITY, f32::min);
        assert!(heights.len() > 1000 && lowest >= 70.0, "{line}: {lowest} of {}", heights.len());
        let curve = format!("map {scene} --uav={uav} --earth-k 0.00002 --height-curve c.json --overwrite -q");
        folder.type_in(&curve).done();
        let curve = folder.json("c.json");
        assert!(curve["sites"][0]["lowest_height_amsl_m"].as_f64().unwrap() >= 70.0, "{line}");
    }
}

#[test]
fn flags_bend_rasters() {
    let folder = Folder::new();
    let cells: Vec<String> = (0..400).map(|k| (k * 7919 % 97 / 12).to_string()).collect();
    folder.write(
        "dsm.asc",
        &format!("ncols 20\nnrows 20\nxllcorner 0\nyllcorner 0\ncellsize 900\n{}\n", cells.join(" ")),
    );
    let document = |words: &str| folder.type_in(&format!("map dsm.asc --uav 9000,9000,30 {words} --json")).done();
    let (flat, radio) = (document(""), document("--earth-k 4/3"));
    assert!(flat.warnings().contains(&"W201") && flat.err.contains("`--earth-k 4/3`"), "{}", flat.err);
    assert!(!radio.warnings().contains(&"W201"), "{}", radio.err);
    let (flat, radio) = (flat.json(), radio.json());
    assert_ne!(flat["digest"], radio["digest"]);
    assert_eq!((&flat["earth_k"], &radio["earth_k"]), (&Value::Null, &Value::from(4.0 / 3.0)));
    assert_eq!(document("--curvature-coefficient 0.75").json()["digest"], radio["digest"]);
    for flat_again in ["--earth-k inf", "--curvature-coefficient 0", "--earth-k 1e12"] {
        assert_eq!(document(flat_again).json()["digest"], flat["digest"], "{flat_again}");
    }
    // A link is that of the map, a track and a curve run over the same scene.
    let link =
        folder.type_in("link dsm.asc --uav 9000,9000,30 --rx 450,450 --earth-k 0.05 --json -o link.png").done().json();
    assert_eq!((&link["los"], &link["earth_k"]), (&Value::Bool(false), &Value::from(0.05)));
    let heights = |words: &str| {
        let of = format!("map dsm.asc --uav 9000,9000,30 {words} --height-curve c.json -o m.json --overwrite -q");
        folder.type_in(&of).done();
        (folder.json("c.json")["sites"][0].clone(), folder.json("m.json")["sites"][0]["los"].as_u64())
    };
    let (curve, los) = heights("--earth-k 0.05");
    assert_ne!(curve, heights("").0);
    assert!(los > Some(0));
    folder.write("walk.csv", "x,y\n9000,9000\n450,450\n");
    let track = |words: &str| {
        folder.type_in(&format!("track dsm.asc --uav 9000,9000,30 --track walk.csv --every 30 {words} --json")).done()
    };
    assert_ne!(track("").json()["length_m"], track("--earth-k 0.05").json()["length_m"]);
    folder.refuses(
        "map dsm.asc --uav 9000,9000,30 --earth-k 1e-5 --json",
        "E118",
        &["fall away", "larger `--earth-k`"],
    );
    // Every answer refuses what would leave the lattice, also where nothing of it is told.
    for k in ["1e-5", "1e-12"] {
        let link = format!("link dsm.asc --uav 9000,9000,30 --rx 450,450 --earth-k {k}");
        folder.refuses(&link, "E118", &["fall away"]);
        folder.refuses(&format!("track dsm.asc --uav 9000,9000,30 --track walk.csv --earth-k {k}"), "E118", &["fall"]);
        let place = format!("place dsm.asc --height 30 --step 4000 --earth-k {k} -o place.csv");
        folder.refuses(&place, "E118", &["fall away"]);
    }
    folder.refuses("map dsm.asc --uav 9000,9000,30 --earth-k 0 --json", "E113", &["K of the earth"]);
    folder.refuses("map dsm.asc --uav 9000,9000,30 --earth-k 4/x", "E101", &["4/x"]);
}

#[test]
fn walls_of_nodata_and_low_ground_stand_on_a_curved_earth() {
    let folder = Folder::new();
    let raster = |name: &str, low: &str| {
        let cells: Vec<&str> = (0..400).map(|k| if k % 37 == 6 { "-9999" } else { low }).collect();
        let head = "ncols 20\nnrows 20\nxllcorner 0\nyllcorner 0\ncellsize 900\nNODATA_value -9999";
        folder.write(name, &format!("{head}\n{}\n", cells.join(" ")));
    };
    raster("walls.asc", "0");
    let map = |words: &str| {
        folder.type_in(&format!("map walls.asc --nodata-as block --uav 9000,9000,30 {words} --json")).done().json()
    };
    assert_eq!(map("--earth-k 1e12")["digest"], map("")["digest"]);
    let los = |map: &Value| map["sites"][0]["los"].as_u64();
    assert!(los(&map("--earth-k 0.05")) < los(&map("")));
    // The earth falls by 12.7 km in the corners: from ground at 20 km below the datum that is too much, from the datum it is not.
    raster("low.asc", "-20200");
    let of = |name: &str| format!("map {name} --uav 9000,9000,30 --earth-k 0.001 --json");
    assert_eq!(folder.type_in(&of("walls.asc")).done().json()["earth_k"], 0.001);
    folder.refuses(&of("low.asc"), "E118", &["12"]);
}

/// Counts and sets bent heights out of the lattice in silence, where maps refused.
#[test]
fn an_earth_that_bends_heights_off_the_lattice_has_no_view() {
    let grid = GeoRef::new((0.0, 1.0), (1.0, 1.0), (1, 40), None).unwrap();
    let field = raster_field(Raster::new(grid, vec![0; 40]), Ground::Flat(0));
    let uav = uav_at(&field, 0.5, 0.5, 30 * 1024);
    let seen = |earth_k: f64| {
        let curvature = Curvature::of_earth_k(earth_k);
        let mapper = Mapper::new(&field, &MapOptions { curvature, ..MapOptions::default() }).unwrap();
        mapper.seen_from(&uav).map(|view| view.count()).map_err(|error| error.code())
    };
    // At 39 m the earth falls by 119 m, and by 119 km.
    assert!(seen(1e-6).is_ok_and(|(receivers, los)| receivers == 40 && los < 40));
    assert_eq!(seen(1e-9), Err("E118".into()));
}
