//! No more than a scene needs: footprints that can hide nobody are dropped, and `limits` tells what a map needs and what
//! limits it; each number against maps made on their own.

use serde_json::Value;
use skyshed_core::city::{BuiltUp, BuiltUpCity, DataArea, Footprint, FootprintFaults, Ground, Site, Solids};
use skyshed_core::coverage::{Control, IdleFootprints, MapOptions, Mapper, Uav};
use skyshed_core::height_field::HeightField;
use skyshed_core::quantity::{Frame, Height};
use skyshed_core::raster::GeoRef;

use crate::program::Folder;
use crate::support::{Random, slow};

/// Square buildings of 4 m, each given by its south-west corner and its height, over 64 × 64 cells.
fn squares(buildings: &[([i32; 2], i32)]) -> HeightField {
    let grid = GeoRef::new((0.0, 64.0), (1.0, 1.0), (64, 64), None).unwrap();
    let ring = |[x, y]: [i32; 2]| {
        let (w, s, e, n) = (x * 1024, y * 1024, (x + 4) * 1024, (y + 4) * 1024);
        vec![[w, s], [e, s], [e, n], [w, n]]
    };
    let footprint = |(k, (corner, top)): (usize, &([i32; 2], i32))| Footprint {
        id: k.to_string(),
        polygons: vec![vec![ring(*corner)]],
        top: top * 1024,
        base: Some(0),
    };
    let solids = Solids::Vector {
        footprints: buildings.iter().enumerate().map(footprint).collect(),
        frame: Frame { x_origin: 0.0, y_origin: 0.0, unit_x: 1.0, unit_y: 1.0 },
        ground: Ground::Flat(0),
        faults: FootprintFaults::default(),
        data_area: DataArea::All,
    };
    HeightField::build(&grid, solids).field
}

fn uav(field: &HeightField, (x, y, height): (f64, f64, f64), radius: Option<f64>) -> Uav {
    Uav::place(&Site { id: "1".into(), x, y, height: Height::AboveGround(height) }, field, radius).unwrap()
}

#[test]
fn footprints_that_can_hide_nobody_are_dropped_and_counted() {
    // A UAV in the south-west with a radius of 20 m: links end at x, y ≤ 30.5.
    let field = squares(&[
        ([20, 20], 12), // in reach
        ([20, 10], 1),  // lower than the receivers at 1.5 m
        ([50, 50], 40), // beyond
        ([40, 10], 1),  // both
        ([29, 10], 12), // partly in reach
        ([32, 10], 12), // its wall is 1.5 m beyond the last receiver
    ]);
    let at = (10.5, 10.5, 30.0);
    let options = MapOptions { radius: Some(20.0), ..MapOptions::default() };
    let mut mapper = Mapper::new(&field, &options).unwrap();
    let uav = uav(&field, at, Some(20.0));
    let all = mapper.seen(&uav);
    let found = mapper.drop_idle(std::slice::from_ref(&uav));
    assert_eq!(found, IdleFootprints { footprints: 6, too_low: 2, out_of_reach: 2 });
    assert_eq!(mapper.seen(&uav), all);
    // Receivers on roofs are higher: nothing is too low for the UAV's height alone.
    let options = MapOptions { receivers: skyshed_core::coverage::Receivers::Roof, ..MapOptions::default() };
    let mut mapper = Mapper::new(&field, &options).unwrap();
    let found = mapper.drop_idle(std::slice::from_ref(&uav));
    // The lowest receiver stands on a roof of 1 m, 1.5 m above it.
    assert_eq!((found.too_low, found.out_of_reach), (2, 0));
}

#[test]
fn maps_are_the_same_without_what_was_dropped() {
    let mut random = Random(5);
    let (mut n_dropped, mut n_left) = (0, 0);
    for seed in 0..if slow() { 60 } else { 8 } {
        let name = random.choose(&["suburban", "urban", "dense-urban", "high-rise"]);
        let built_up = BuiltUp::named(name).unwrap();
        let city = BuiltUpCity { built_up, size_m: 400.0, margin_m: 0.0, cell_m: 1.0, seed, ground_m: 0.0 };
        let scene = city.city().unwrap();
        let field = HeightField::build(&scene.grid, scene.solids).field;
        #[expect(clippy::cast_precision_loss, reason = "a few hundred meters")]
        let (x, y, z) = (random.within(0, 399) as f64, random.within(0, 399) as f64, random.within(100, 300) as f64);
        let radius = random.choose(&[30.0, 100.0, 1000.0]);
        let Ok(uav) = Uav::place(&Site { id: "1".into(), x, y, height: Height::AboveGround(z) }, &field, None) else {
            continue;
        };
        let options = MapOptions { radius: Some(radius), ..MapOptions::default() };
        let mut mapper = Mapper::new(&field, &options).unwrap();
        let all = mapper.map(&uav, &Control::default()).unwrap();
        let idle = mapper.drop_idle(std::slice::from_ref(&uav));
        assert_eq!(mapper.map(&uav, &Control::default()).unwrap().mask, all.mask, "{name}, seed {seed}, {radius} m");
        n_dropped += idle.dropped();
        n_left += idle.footprints - idle.dropped();
    }
    assert!(n_dropped > 100 && n_left > 100, "{n_dropped} dropped, {n_left} left");
}

fn p_los(folder: &Folder, words: &str) -> f64 {
    let document = folder.type_in(&format!("map {words} --json")).done().json();
    document["sites"][0]["p_los"].as_f64().unwrap()
}

/// The line of a budget whose change begins with some words.
fn change(needs: &Value, part: &str, changed: &str) -> f64 {
    let lines = needs["budget"].as_array().unwrap();
    let is_it = |l: &&Value| l["part"] == part && l["changed"].as_str().unwrap().starts_with(changed);
    let line = lines.iter().find(is_it).unwrap_or_else(|| panic!("{part}, {changed}: {needs:#}"));
    line["p_los_change"].as_f64().unwrap_or_else(|| panic!("{line}"))
}

/// One of two numbers, whichever is farther from zero.
fn farther(a: f64, b: f64) -> f64 {
    if a.abs() >= b.abs() { a } else { b }
}

fn assert_close(found: f64, expected: f64, what: &str) {
    assert!((found - expected).abs() < 1e-12, "{what}: {found} instead of {expected}");
}

#[test]
fn what_limits_a_map_is_what_maps_of_the_changed_scene_say() {
    let folder = Folder::new();
    let scene = "itu:urban --size 300";
    let document = folder.type_in(&format!("limits {scene} --uav 150,150,60 --json -o budget.csv")).done().json();
    let needs = &document;
    let own = p_los(&folder, &format!("{scene} --uav 150,150,60"));
    assert_close(needs["p_los"].as_f64().unwrap(), own, "P_LoS");
    assert_eq!(change(needs, "method", "a ray for each").to_bits(), 0.0_f64.to_bits());
    let at = |height: &str| p_los(&folder, &format!("{scene} --uav 150,150,{height}")) - own;
    assert_close(change(needs, "UAV height", "1 m up"), farther(at("61"), at("59")), "UAV height");
    let fine = p_los(&folder, &format!("{scene} --cell 0.5 --uav 150,150,60")) - own;
    assert_close(change(needs, "cell size", "receivers every 0.5 m"), fine, "finer cells");
    for effect in needs["cells"].as_array().unwrap() {
        let cell = effect["cell_m"].as_f64().unwrap();
        if [2.0, 4.0].contains(&cell) {
            let coarse = p_los(&folder, &format!("{scene} --cell {cell} --uav 150,150,60"));
            assert_close(effect["p_los"].as_f64().unwrap(), coarse, "coarser cells");
        }
    }
    folder.type_in(&format!("city {scene} -o city.tif")).done();
    let raster = p_los(&folder, "city.tif --ground 0 --uav 150,150,60") - own;
    assert_close(change(needs, "cell size", "the raster"), raster, "raster instead of footprints");
    let moved = |x: &str, y: &str| p_los(&folder, &format!("{scene} --uav {x},{y},60")) - own;
    let aside =
        farther(farther(moved("151", "150"), moved("149", "150")), farther(moved("150", "151"), moved("150", "149")));
    assert!(change(needs, "UAV position", "1 m").abs() >= aside.abs() - 1e-12);
    // The same cities by their seeds.
    let others: Vec<f64> = (2..12).map(|k| p_los(&folder, &format!("{scene} --uav 150,150,60 --seed {k}"))).collect();
    let mean = others.iter().sum::<f64>() / 10.0;
    let deviation = (others.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / 9.0).sqrt();
    assert_close(change(needs, "one city of many", "10 other cities"), deviation, "cities");
    // Sorted by size, and the table says the same.
    let changes: Vec<f64> =
        needs["budget"].as_array().unwrap().iter().map(|l| l["p_los_change"].as_f64().unwrap().abs()).collect();
    assert!(changes.is_sorted_by(|a, b| a >= b), "{changes:?}");
    let table = folder.text("budget.csv");
    assert_eq!(table.lines().count(), changes.len() + 1);
    assert!(table.starts_with("part,changed,p_los,p_los_change,reason\n"), "{table}");
    assert_eq!(needs["rectangles"]["rectangles"], needs["rectangles"]["footprints"]);
    assert_eq!((&needs["terrain"], &needs["method"]), (&Value::Null, &Value::from("shadow")));
}

#[test]
fn higher_roofs_are_those_of_a_file_with_higher_buildings() {
    let folder = Folder::new();
    let city = |name: &str, more: f64| {
        let square = |x: f64, height: f64| {
            format!(
                r#"{{"type": "Feature", "properties": {{"height": {}}}, "geometry": {{"type": "Polygon",
                "coordinates": [[[{x}, 20], [{}, 20], [{}, 30], [{x}, 30], [{x}, 20]]]}}}}"#,
                height + more,
                x + 10.0,
                x + 10.0
            )
        };
        let all = [square(20.0, 8.0), square(45.0, 14.0), square(70.0, 5.0)].join(", ");
        folder.write(name, &format!(r#"{{"type": "FeatureCollection", "features": [{all}]}}"#));
    };
    city("own.geojson", 0.0);
    city("high.geojson", 2.0);
    city("low.geojson", -2.0);
    let words = "--extent 0,0,100,60 --uav 10,25,30";
    let document = folder.type_in(&format!("limits own.geojson {words} --height-error 2 --json")).done().json();
    let of = |name: &str| p_los(&folder, &format!("{name} {words}"));
    let own = of("own.geojson");
    let expected = farther(of("high.geojson") - own, of("low.geojson") - own);
    assert_close(change(&document, "building heights", "all roofs 2 m"), expected, "roofs");
    let reason = document["budget"].as_array().unwrap().iter().find(|l| l["part"] == "one city of many").unwrap();
    assert_eq!(
        (&reason["p_los_change"], &reason["reason"]),
        (&Value::Null, &Value::from("the scene is one real city"))
    );
}

#[test]
fn terrain_hides_what_it_hides_without_buildings() {
    let folder = Folder::new();
    // A ridge of 20 m between the UAV at 10 m and the receivers behind it; the surface has one tower more.
    let row = |tower: bool| {
        let z = |k: usize| {
            if k == 15 {
                20
            } else if tower && k == 5 {
                9
            } else {
                0
            }
        };
        (0..30).map(|k| z(k).to_string()).collect::<Vec<_>>().join(" ")
    };
    let grid = |tower: bool| {
        let rows = (0..8).map(|_| row(tower)).collect::<Vec<_>>().join("\n");
        format!("ncols 30\nnrows 8\nxllcorner 0\nyllcorner 0\ncellsize 1\n{rows}\n")
    };
    folder.write("dsm.asc", &grid(true));
    folder.write("dtm.asc", &grid(false));
    let words = "dsm.asc --terrain dtm.asc --uav 0.5,4.5,10";
    let document = folder.type_in(&format!("limits {words} --json")).done().json();
    // Of 29 open columns, without the tower's, 14 lie behind the ridge; those upon it see the UAV.
    assert_eq!(document["terrain"], serde_json::json!({"hidden": 14 * 8, "receivers": 29 * 8}));
    let said = folder.type_in(&format!("limits {words}")).done().out;
    assert!(said.contains("terrain    hides 112 of 232 receivers by itself"), "{said}");
}

#[test]
fn flags_of_needs_want_a_uav() {
    let folder = Folder::new();
    for (more, code) in [
        ("-o budget.csv", "E108"),
        ("--uav 150,150,60 --uav-error -1", "E113"),
        ("--uav 150,150,60 --height-error nan", "E101"),
        ("--uav 150,150", "E102"),
        ("--uav 150,150,60 --cities 1", "E101"),
    ] {
        let answer = folder.type_in(&format!("limits itu:urban --size 300 {more}"));
        let lines = answer.refused(2);
        assert!(lines[0].starts_with(&format!("error[{code}]")), "{more}: {lines:?}");
    }
    assert_eq!(folder.files(), Vec::<String>::new());
}
