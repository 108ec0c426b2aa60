//! No more than a scene needs: footprints that can hide nobody are dropped, and `limits` tells what a map needs and what
//! limits it; each number against maps made on their own.

use serde_json::Value;
use skyshed_core::city::Site;
use skyshed_core::coverage::{Control, IdleFootprints, MapOptions, Mapper, Uav};
use skyshed_core::height_field::HeightField;
use skyshed_core::quantity::Height;

use crate::cities::{built, generated};
use crate::program::Folder;
use crate::refusals::check_refusals;
use crate::support::{Random, is_long};
use crate::texts::{self, grid};
use crate::zones::{footprints, rectangle};

/// Square buildings of 4 m, each given by its south-west corner and its height, over 64 × 64 cells.
fn squares(buildings: &[([i32; 2], i32)]) -> HeightField {
    let square = |([x, y], top): &([i32; 2], i32)| (rectangle([*x, *y, x + 4, y + 4].map(|v| v * 1024)), top * 1024);
    footprints(buildings.iter().map(square).collect(), 64, 64)
}

fn uav(field: &HeightField, (x, y, height): (f64, f64, f64), radius: Option<f64>) -> Uav {
    Uav::place(&Site::new("1", (x, y), Height::AboveGround(height)), field, radius).unwrap()
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
    let all = mapper.seen_from(&uav).unwrap().seen();
    let found = mapper.drop_idle(std::slice::from_ref(&uav));
    assert_eq!(found, IdleFootprints { footprints: 6, too_low: 2, out_of_reach: 2 });
    assert_eq!(mapper.seen_from(&uav).unwrap().seen(), all);
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
    for seed in 0..if is_long() { 60 } else { 8 } {
        let name = random.choose(&["suburban", "urban", "dense-urban", "high-rise"]);
        let field = built(&generated(name, seed, 400.0));
        let (x, y, z) = (random.within(0, 399) as f64, random.within(0, 399) as f64, random.within(100, 300) as f64);
        let radius = random.choose(&[30.0, 100.0, 1000.0]);
        let Ok(uav) = Uav::place(&Site::new("1", (x, y), Height::AboveGround(z)), &field, None) else {
            continue;
        };
        let options = MapOptions { radius: Some(radius), ..MapOptions::default() };
        let mut mapper = Mapper::new(&field, &options).unwrap();
        let all = mapper.seen_from(&uav).unwrap().map(&Control::default()).unwrap();
        let idle = mapper.drop_idle(std::slice::from_ref(&uav));
        assert_eq!(
            mapper.seen_from(&uav).unwrap().map(&Control::default()).unwrap().mask,
            all.mask,
            "{name}, seed {seed}, {radius} m"
        );
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
    let needs = folder.type_in(&format!("limits {scene} --uav 150,150,60 --json -o budget.csv")).done().json();
    let own = p_los(&folder, &format!("{scene} --uav 150,150,60"));
    assert_close(needs["p_los"].as_f64().unwrap(), own, "P_LoS");
    assert_eq!(change(&needs, "method", "a ray for each").to_bits(), 0.0_f64.to_bits());
    let at = |height: &str| p_los(&folder, &format!("{scene} --uav 150,150,{height}")) - own;
    assert_close(change(&needs, "UAV height", "1 m up"), farther(at("61"), at("59")), "UAV height");
    let fine = p_los(&folder, &format!("{scene} --cell 0.5 --uav 150,150,60")) - own;
    assert_close(change(&needs, "cell size", "receivers every 0.5 m"), fine, "finer cells");
    for effect in &needs["cells"].as_array().unwrap()[..2] {
        let cell = effect["cell_m"].as_f64().unwrap();
        let coarse = p_los(&folder, &format!("{scene} --cell {cell} --uav 150,150,60"));
        assert_close(effect["p_los"].as_f64().unwrap(), coarse, "coarser cells");
    }
    folder.type_in(&format!("city {scene} -o city.tif")).done();
    let raster = p_los(&folder, "city.tif --ground 0 --uav 150,150,60") - own;
    assert_close(change(&needs, "cell size", "the raster"), raster, "raster instead of footprints");
    let moved = |x: &str, y: &str| p_los(&folder, &format!("{scene} --uav {x},{y},60")) - own;
    let aside = [("151", "150"), ("149", "150"), ("150", "151"), ("150", "149")].map(|(x, y)| moved(x, y));
    let aside = aside.into_iter().fold(0.0, farther);
    assert!(change(&needs, "UAV position", "1 m").abs() >= aside.abs() - 1e-12);
    let curved = p_los(&folder, &format!("{scene} --uav 150,150,60 --earth-k 4/3")) - own;
    assert_close(change(&needs, "shape of the earth", "curved"), curved, "a curved earth");
    let flat = folder.type_in(&format!("limits {scene} --uav 150,150,60 --earth-k 0.001 --json")).done().json();
    let bent = p_los(&folder, &format!("{scene} --uav 150,150,60 --earth-k 0.001"));
    assert_close(change(&flat, "shape of the earth", "a flat earth"), own - bent, "a flat earth");
    // The same cities by their seeds.
    let others: Vec<f64> = (2..12).map(|k| p_los(&folder, &format!("{scene} --uav 150,150,60 --seed {k}"))).collect();
    let mean = others.iter().sum::<f64>() / 10.0;
    let deviation = (others.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / 9.0).sqrt();
    assert_close(change(&needs, "one city of many", "10 other cities"), deviation, "cities");
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
    for (name, more) in [("own.geojson", 0.0), ("high.geojson", 2.0), ("low.geojson", -2.0)] {
        let houses = [(20.0, 8.0), (45.0, 14.0), (70.0, 5.0)].map(|(x, height)| [x, 20.0, 10.0, height + more]);
        folder.write(name, &texts::squares(&houses));
    }
    let words = "--extent 0,0,100,60 --uav 10,25,30";
    let document = folder.type_in(&format!("limits own.geojson {words} --height-error 2 --json")).done().json();
    let of = |name: &str| p_los(&folder, &format!("{name} {words}"));
    let own = of("own.geojson");
    let expected = farther(of("high.geojson") - own, of("low.geojson") - own);
    assert_close(change(&document, "building heights", "all roofs 2 m"), expected, "roofs");
    let reason = document["budget"].as_array().unwrap().iter().find(|l| l["part"] == "one city of many").unwrap();
    assert_eq!((&reason["p_los_change"], &reason["reason"]), (&Value::Null, &"the scene is one real city".into()));
}

#[test]
fn terrain_hides_what_it_hides_without_buildings() {
    let folder = Folder::new();
    // A ridge of 20 m between the UAV at 10 m and the receivers behind it; the surface has one tower more.
    for (name, tower) in [("dsm.asc", 9), ("dtm.asc", 0)] {
        let height =
            |k: usize| [(15, 20), (5, tower)].into_iter().find(|(col, _)| *col == k % 30).map_or(0, |(_, z)| z);
        folder.write(name, &grid(&(0..8 * 30).map(height).collect::<Vec<_>>(), 30, -9999));
    }
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
    let cases = [
        ("-o budget.csv", "E108", ""),
        ("--uav 150,150,60 --uav-error -1", "E113", "`-1`"),
        ("--uav 150,150,60 --height-error nan", "E101", "'nan'"),
        ("--uav 150,150", "E102", "`--uav 150,150`"),
        ("--uav 150,150,60 --cities 1", "E101", "'--cities <N>'"),
    ];
    check_refusals(&folder, "limits itu:urban --size 300", &cases);
}
