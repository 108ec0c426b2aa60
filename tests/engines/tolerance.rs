//! `--tolerance`: P_LoS of the form that is taken is within it, on generated and on real cities; bounds that hold; words.

use std::path::{Path, PathBuf};

use serde_json::Value;
use skyshed_core::city::{City, Ground, Site};
use skyshed_core::coverage::{MapOptions, Mapper, Uav};
use skyshed_core::height_field::{HeightField, Pooling};
use skyshed_core::quantity::Height;
use skyshed_core::raster::{BitGrid, GeoRef};
use skyshed_io::read::{FootprintOptions, SurfaceOptions, read_footprints, read_surface};
use skyshed_study::accuracy::{Choice, Question, Simpler, coarse_answer, coarsest_within};

use crate::cities::{built, generated};
use crate::needs::truth;
use crate::program::Folder;
use crate::refusals::check_refusals;
use crate::support::{Random, is_long, surface_field};

fn field_of(scene: City) -> HeightField {
    HeightField::build(&scene.grid, scene.solids).field
}

fn raster(dsm: &Path, terrain: &Path) -> HeightField {
    let options =
        SurfaceOptions { terrain: Some(terrain.into()), building_threshold_m: 0.5, ..SurfaceOptions::default() };
    field_of(read_surface(dsm, &options, &mut Vec::new()).unwrap())
}

fn footprints(buildings: &Path, terrain: &Path) -> HeightField {
    let options = FootprintOptions { terrain: Some(terrain.into()), ..FootprintOptions::default() };
    field_of(read_footprints(buildings, &options, &mut Vec::new()).unwrap())
}

/// Scenes of every kind: generated ones as footprints and as rasters, Munich, and the real cities that are there.
fn scenes() -> Vec<(String, HeightField)> {
    let mut scenes = Vec::new();
    for name in ["suburban", "urban", "dense-urban", "high-rise"] {
        let city = built(&generated(name, 5, 500.0));
        scenes.push((format!("{name} as a raster"), city.rasterized().unwrap()));
        scenes.push((name.to_string(), city));
    }
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps");
    scenes.push(("munich".into(), raster(&maps.join("munich_dsm.tif"), &maps.join("munich_terrain.tif"))));
    let Some(data) = truth().filter(|_| is_long()) else { return scenes };
    let cities = data.join("cities");
    for city in ["munich", "etoile", "simple_street_canyon"] {
        let at = |file: &str| cities.join(city).join(file);
        scenes.push((format!("{city}, footprints"), footprints(&at("buildings.geojson"), &at("terrain_1m.tif"))));
        scenes.push((format!("{city}, raster"), raster(&at("dsm_1m.tif"), &at("terrain_1m.tif"))));
    }
    for (city, folder) in [("bilbao", data.join("lidar/bilbao")), ("delft", data.join("lidar/delft"))] {
        let find = |word: &str| -> PathBuf {
            let mut files: Vec<PathBuf> = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
            files.sort();
            let is_it = |p: &&PathBuf| {
                let name = p.file_name().unwrap().to_string_lossy().to_lowercase();
                name.starts_with(word) && name.ends_with("m.tif") && !name.contains("vegetation")
            };
            files.iter().find(is_it).unwrap().clone()
        };
        scenes.push((city.into(), raster(&find("dsm_"), &find("terrain_"))));
    }
    scenes
}

/// A UAV somewhere over a scene, not inside of anything.
fn random_uav(field: &HeightField, random: &mut Random) -> Uav {
    let grid = field.grid();
    loop {
        let (row, col) = (random.below(grid.n_rows()), random.below(grid.n_cols()));
        let (x, y) = grid.world_from_cell(row, col);
        let height = random.within(10, 300) as f64;
        let site = Site::new("1", (x, y), Height::AboveGround(height));
        if let Ok(uav) = Uav::place(&site, field, None) {
            return uav;
        }
    }
}

fn p_los(field: &HeightField, uav: &Uav) -> Option<f64> {
    let options = MapOptions::default();
    let (receivers, los) = Mapper::new(field, &options).unwrap().seen_from(uav).unwrap().count();
    (receivers > 0).then(|| los as f64 / receivers as f64)
}

fn choose(field: &HeightField, uav: &Uav, tolerance: f64, seed: u64) -> Choice {
    let question = Question { field, uavs: std::slice::from_ref(uav), tolerance, seed };
    coarsest_within(&question, &|_| Ok(MapOptions::default())).unwrap()
}

#[test]
fn p_los_of_the_form_taken_is_within_the_tolerance() {
    let scenes = scenes();
    let mut random = Random(21);
    let n_runs: usize = if is_long() { 200 } else { 45 };
    let (mut n_within, mut n_simpler) = (0, 0);
    let mut outside = Vec::new();
    for k in 0..n_runs {
        let (name, field) = &scenes[k % scenes.len()];
        let uav = random_uav(field, &mut random);
        let tolerance = random.choose(&[0.005, 0.01, 0.02, 0.05]);
        let Some(exact) = p_los(field, &uav) else { continue };
        let choice = choose(field, &uav, tolerance, random.next());
        let Some((form, coarse, moved)) = &choice.taken else {
            n_within += 1;
            continue;
        };
        n_simpler += 1;
        let found = p_los(coarse, &moved[0]).unwrap();
        let measured = choice.tried.last().unwrap().measured.as_ref().unwrap();
        assert_eq!(found.to_bits(), measured[0].p_los.to_bits(), "{name}: the map measured is the map taken");
        assert!(measured[0].bound <= tolerance);
        // Sums of shares are rounded in another order than shares of sums.
        if (found - exact).abs() <= measured[0].bound + 1e-12 {
            n_within += 1;
        } else {
            outside.push(format!("{name}, {form:?}: {found} instead of {exact}, {measured:?}"));
        }
        // What was estimated is near what is: within its own bound's width.
        assert!((measured[0].difference - (found - exact)).abs() <= 2.0 * tolerance, "{name}: {measured:?}");
    }
    assert!(n_within * 100 >= n_runs * 95, "{n_within} of {n_runs}: {outside:#?}");
    assert!(n_simpler * 2 >= n_runs, "{n_simpler} of {n_runs} on simpler forms");
}

#[test]
fn a_difference_is_counted_by_hand() {
    // Two blocks of 2 × 2 cells beside a wall: the coarse cell over the wall has no receiver, as its maximum is a roof.
    // 32 × 16 cells, open but for a wall 1 cell wide in column 16, 20 m high; the UAV 10 m high at the west end.
    let grid = GeoRef::new((0.0, 16.0), (1.0, 1.0), (16, 32), None).unwrap();
    let tops = (0..16 * 32).map(|i| if i % 32 == 16 { 20 * 1024 } else { 0 }).collect::<Vec<_>>();
    let field = surface_field(&grid, tops, Ground::Flat(0));
    let uav = Uav::place(&Site::new("1", (1.5, 8.5), Height::AboveGround(10.0)), &field, None).unwrap();
    // Exact: 16 columns in front are LoS, 15 behind are not: P = 256/496. Pooled by 2: the wall takes columns 16 and 17, so
    // 8 coarse columns are LoS and 7 are not: A = 64/120. By the mean the wall is 10 m, as high as the UAV, and hides the
    // same.
    let choice = choose(&field, &uav, 0.05, 1);
    let (form, ..) = choice.taken.as_ref().unwrap();
    assert_eq!(*form, Simpler { factor: 2, pooling: Some(Pooling::Mean) });
    let m = &choice.tried.last().unwrap().measured.as_ref().unwrap()[0];
    assert_eq!((m.sample, m.receivers), (496, 496), "fewer receivers than a sample: all are asked");
    assert!((m.p_los - 64.0 / 120.0).abs() < 1e-15);
    assert!((m.difference - (64.0 / 120.0 - 256.0 / 496.0)).abs() < 1e-15 && (m.bound - m.difference).abs() < 1e-15);
    // Off by 0.0172: 0.015 asks for the scene itself.
    assert!(choose(&field, &uav, 0.015, 1).taken.is_none());
}

#[test]
fn a_receiver_takes_the_answer_of_the_cell_that_it_is_in() {
    use skyshed_study::accuracy::CoarseAnswer;
    let (mut receivers, mut los) = (BitGrid::new(2, 2), BitGrid::new(2, 2));
    receivers.insert(0, 1);
    receivers.insert(1, 0);
    los.insert(1, 0);
    let of = |cell| coarse_answer(&receivers, &los, 3, cell);
    assert_eq!((of((2, 3)), of((3, 2)), of((5, 5))), (CoarseAnswer::Nlos, CoarseAnswer::Los, CoarseAnswer::None));
}

#[test]
fn the_program_says_what_was_taken_and_writes_coarser_cells() {
    let folder = Folder::new();
    let said = folder.type_in("map itu:urban --uav 500,500,100 --tolerance 0.02 -o map.json").done().err;
    assert!(said.contains("Tolerance 0.02: receivers every"), "{said}");
    assert!(said.contains("with 99 % confidence"), "{said}");
    let document = folder.json("map.json");
    let tolerance = &document["tolerance"];
    let factor = tolerance["taken"]["factor"].as_u64().unwrap();
    assert!(factor > 1);
    assert_eq!(document["exact"], false);
    assert_eq!(document["scene"]["cols"].as_u64().unwrap(), 1000_u64.div_ceil(factor));
    let last = tolerance["tried"].as_array().unwrap().last().unwrap();
    assert!(last["bound"].as_f64().unwrap() <= 0.02);
    assert_eq!(last["sites"][0]["p_los"], document["sites"][0]["p_los"]);
    // The same with one thread.
    folder.type_in("map itu:urban --uav 500,500,100 --tolerance 0.02 -j 1 -o again.json").done();
    let again = folder.json("again.json");
    assert_eq!((&again["tolerance"], &again["digest"]), (tolerance, &document["digest"]));
}

#[test]
fn a_tolerance_that_nothing_meets_leaves_the_scene_as_it_is() {
    let folder = Folder::new();
    let words = "map itu:urban --size 200 --uav 100,100,40 --json";
    let exact = folder.type_in(words).done().json();
    let strict = folder.type_in(&format!("{words} --tolerance 0.000001")).done();
    let found = strict.json();
    assert_eq!((&found["digest"], &found["exact"]), (&exact["digest"], &Value::Bool(true)));
    assert_eq!(found["tolerance"]["taken"]["factor"], 1);
    assert!(strict.err.contains("no simpler form will do"), "{}", strict.err);
}

#[test]
fn senseless_tolerances_are_refused() {
    let folder = Folder::new();
    let of_map = [
        ("--tolerance 0", "E113", "`0`"),
        ("--tolerance -0.1", "E113", "`-0.1`"),
        ("--tolerance 1", "E113", "`1`"),
        ("--tolerance nan", "E101", "'nan'"),
        ("--tolerance 0.1 --method xdraw", "E116", "tolerance"),
    ];
    check_refusals(&folder, "map itu:urban --uav 500,500,100 --json", &of_map);
    let of_plos = [
        ("--tolerance 0", "E113", "`0`"),
        ("--tolerance 0.01 --until 0.01", "E101", "'--until"),
        ("--tolerance 0.01 --method itu", "E116", "tolerance"),
    ];
    check_refusals(&folder, "plos itu:urban --json", &of_plos);
}

/// The values of P_LoS of a study, row by row.
fn values(document: &Value) -> Vec<Option<f64>> {
    document["rows"].as_array().unwrap().iter().map(|row| row["p_los"].as_f64()).collect()
}

#[test]
fn the_product_stops_where_a_tolerance_allows() {
    let folder = Folder::new();
    let study = "plos itu:urban --theta 10:80:10 --json";
    let exact = values(&folder.type_in(&format!("{study} --until 0.0001")).done().json());
    let mut last = 0;
    for tolerance in [0.05, 0.005, 0.0005] {
        for seed in 1..=if is_long() { 70 } else { 8 } {
            let line = format!("{study} --tolerance {tolerance} --seed {seed}");
            let document = folder.type_in(&line).done().json();
            for (found, exact) in values(&document).iter().zip(&exact) {
                let off = (found.unwrap() - exact.unwrap()).abs();
                assert!(off <= tolerance + 0.0002, "{line}: {found:?} instead of {exact:?}");
            }
            let bound = document["tolerance"]["bound"].as_f64().unwrap();
            assert!(bound <= tolerance && bound > 0.0, "{line}: {bound}");
            if seed == 1 {
                let samples: u64 =
                    document["rows"].as_array().unwrap().iter().map(|r| r["samples"].as_u64().unwrap()).sum();
                assert!(samples >= last, "{line}: {samples} samples after {last}");
                last = samples;
            }
        }
    }
}

#[test]
fn maps_over_a_real_city_are_as_coarse_as_a_tolerance_allows() {
    let folder = Folder::new();
    let munich = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/munich.geojson");
    let munich = munich.to_str().unwrap();
    let study = format!(
        "plos {munich} --extent 691300,5334500,691700,5334900 --method maps --height 60,120 --radius 50,100 --positions 60 --json"
    );
    let exact = values(&folder.type_in(&study).done().json());
    let mut n_simpler = 0;
    for tolerance in [0.05, 0.02, 0.01] {
        let document = folder.type_in(&format!("{study} --tolerance {tolerance}")).done().json();
        for (found, exact) in values(&document).iter().zip(&exact) {
            let off = (found.unwrap() - exact.unwrap()).abs();
            assert!(off <= tolerance, "{tolerance}: {found:?} instead of {exact:?}");
        }
        let told = &document["real_cities"][0]["tolerance"];
        let last = told["tried"].as_array().unwrap().last().unwrap();
        let factor = told["taken"]["factor"].as_u64().unwrap();
        if factor > 1 {
            n_simpler += 1;
            assert!(last["bound"].as_f64().unwrap() <= tolerance);
            assert_eq!(last["factor"].as_u64(), Some(factor));
        }
    }
    assert!(n_simpler > 0);
}
