//! Speed against accuracy: counts by hand and from saved maps, sums, the exact answer, coarser cells, threads.

use serde_json::Value;
use skyshed_core::city::{Ground, Site};
use skyshed_core::coverage::{MapOptions, Uav};
use skyshed_core::height_field::{HeightField, Pooling, Station};
use skyshed_core::los::{MethodChoice, link_los};
use skyshed_core::quantity::Height;
use skyshed_core::raster::GeoRef;
use skyshed_io::formats::GeoTiff;
use skyshed_study::accuracy::chart::{Contestant, Truth};

use crate::program::Folder;
use crate::support::{Random, class_of, surface_field};

/// Flat ground with a wall of 5 m in the fourth of seven columns; a UAV over the first cell of the middle row.
const WALL: [i32; 21] = [0, 0, 0, 5, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0, 0, 0, 0, 5, 0, 0, 0];
pub(crate) const BY_HAND: &str = "wall.asc --ground 0 --uav 0.5,1.5,11.5";

/// Two buildings, one of them without a height but with storeys.
const CITY: &str = r#"{"type": "FeatureCollection", "features": [
  {"type": "Feature", "properties": {"height": 20, "tall": 35, "z_top": 18, "z_ground": 0},
   "geometry": {"type": "Polygon", "coordinates": [[[20,20],[30,22],[29,30],[20,30],[20,20]]]}},
  {"type": "Feature", "properties": {"height": 12, "tall": 5, "z_top": 30, "z_ground": 0},
   "geometry": {"type": "Polygon", "coordinates": [[[5,5],[15,5],[15,12],[5,12],[5,5]]]}},
  {"type": "Feature", "properties": {"building:levels": 5},
   "geometry": {"type": "Polygon", "coordinates": [[[42.6,13],[44,13],[44,14],[42.6,14],[42.6,13]]]}}]}"#;

pub(crate) fn grid<T: ToString>(values: &[T], n_cols: usize) -> String {
    crate::texts::grid(values, n_cols, -9999)
}

/// Heights of 48 × 40 cells: flat ground with some columns upon it.
pub(crate) fn rough() -> Vec<i64> {
    let mut random = Random(7);
    (0..48 * 40).map(|_| if random.chance(12) { random.within(3, 30) } else { 0 }).collect()
}

pub(crate) fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("wall.asc", &grid(&WALL, 7));
    folder.write("rough.asc", &grid(&rough(), 48));
    folder.write("city.geojson", CITY);
    folder
}

pub(crate) fn document(folder: &Folder, line: &str) -> Value {
    folder.type_in(&format!("chart {line} --time 0 --json -q")).done().json()
}

/// The contestant with this method and these parameters.
pub(crate) fn row<'a>(document: &'a Value, method: &str, parameters: &str) -> &'a Value {
    let rows = document["contestants"].as_array().unwrap();
    let found = rows.iter().find(|row| row["method"] == method && row["parameters"] == parameters);
    found.unwrap_or_else(|| panic!("{method} {parameters}: {document}"))
}

/// Receivers, false LoS, false NLoS, unanswered, own receivers, own LoS.
fn counts(row: &Value) -> [Option<u64>; 6] {
    ["receivers", "false_los", "false_nlos", "unanswered", "own_receivers", "own_los"].map(|name| row[name].as_u64())
}

#[test]
fn the_counts_of_a_wall_are_those_of_a_hand() {
    let folder = folder();
    let document = document(&folder, BY_HAND);
    assert_eq!((&document["schema"], &document["kind"]), (&"skyshed/chart/1".into(), &"scene".into()));
    // A ray from 11.5 m over x = 0.5 to 1.5 m over x leaves the wall, at x = 4, at 11.5 − 35 / (x − 0.5) m: 2.75, 4.5 and
    // 5.67 m for the three columns behind it. The wall hides two of them.
    let exact = &document["exact"];
    assert_eq!(
        (exact["method"].as_str(), exact["receivers"].as_u64(), exact["los"].as_u64()),
        (Some("ray"), Some(18), Some(12))
    );
    let wanted = [
        ("ray", "", [18, 0, 0, 0, 18, 12]),
        ("sweep", "", [18, 0, 0, 0, 18, 12]),
        // Two equal parts, at most: their end is before the wall, or on its border.
        ("step:4", "", [18, 6, 0, 0, 18, 18]),
        // Only the nearest receiver behind the wall, straight ahead, has no sample in it.
        ("step:2", "", [18, 1, 0, 0, 18, 13]),
        // The wall takes the column before it, too. To x = 5 the ray leaves it at 3.72 m, to x = 7 at 6.1 m.
        ("sweep", "cells 2x maximum", [15, 0, 0, 3, 6, 4]),
        // 2.5 m high it hides nothing.
        ("sweep", "cells 2x mean", [15, 6, 0, 3, 6, 6]),
        // One larger cell is left, whose center at x = 6 is seen over the wall: by 5.14 m.
        ("sweep", "cells 4x maximum", [9, 6, 0, 9, 1, 1]),
        ("sweep", "cells 4x mean", [9, 6, 0, 9, 1, 1]),
        // One larger cell, which is a building.
        ("sweep", "cells 8x maximum", [0, 0, 0, 18, 0, 0]),
    ];
    for (method, parameters, by_hand) in wanted {
        let row = row(&document, method, parameters);
        assert_eq!(counts(row), by_hand.map(Some), "{method} {parameters}: {row}");
        assert_eq!(row["wrong_cells"].as_u64(), Some(by_hand[1] + by_hand[2]));
    }
    let step = row(&document, "step:4", "");
    assert_eq!((step["p_los"].as_f64(), step["p_los_error"].as_f64()), (Some(1.0), Some(1.0 - 12.0 / 18.0)));
    let none = row(&document, "sweep", "cells 8x maximum");
    assert_eq!(
        (&none["wrong_share"], &none["p_los"], &none["p_los_error"]),
        (&Value::Null, &Value::Null, &Value::Null)
    );
    assert_eq!(none["reason"], "no receiver that both answer");
    for row in document["contestants"].as_array().unwrap() {
        assert!(row["cpu_s"].as_f64() > Some(0.0) || !cfg!(unix), "{row}");
        assert!(row["wall_s"].as_f64() > Some(0.0) && row["runs"].as_u64() >= Some(3), "{row}");
        assert!(row["peak_mb"].as_f64() > Some(1.0) || row["peak_reason"].is_string(), "{row}");
    }
}

#[test]
fn a_uav_inside_a_building_that_grew_has_no_numbers_but_a_reason() {
    let folder = folder();
    folder.write("high.asc", &grid(&WALL.map(|z| 4 * z), 7));
    folder.type_in("chart high.asc --ground 0 --uav 2.5,1.5,11 --time 0 -o h.csv -o h.json -o h.svg -q").done();
    let document = folder.json("h.json");
    let grown = row(&document, "sweep", "cells 2x maximum");
    assert_eq!((&grown["wrong_cells"], &grown["cpu_s"], &grown["p_los"]), (&Value::Null, &Value::Null, &Value::Null));
    assert!(grown["reason"].as_str().unwrap().contains("inside a building"), "{grown}");
    // The mean of street and wall is 10 m, below it.
    assert!(row(&document, "sweep", "cells 2x mean")["receivers"].as_u64() > Some(0));
    let line = folder.text("h.csv").lines().find(|l| l.starts_with("sweep,cells 2x maximum,")).unwrap().to_string();
    assert!(line.starts_with("sweep,cells 2x maximum,,,,,,,,,,,,,,coarser,"), "{line}");
    assert!(folder.text("h.svg").contains(">no answer<"));
}

/// The classes of a saved map, row by row.
pub(crate) fn classes(folder: &Folder, file: &str) -> Vec<u8> {
    let tiff = GeoTiff::open(folder.join(file), &mut Vec::new()).unwrap();
    tiff.read_band(0, tiff.georef().window(), &mut Vec::new(), class_of).unwrap().cells().to_vec()
}

#[test]
fn wrong_counts_are_those_of_saved_maps() {
    let folder = folder();
    let scene = "rough.asc --ground 0 --uav 20.3,17.8,35";
    let document = document(&folder, scene);
    folder.type_in(&format!("map {scene} --method ray -o ray.tif -q")).done();
    let exact = classes(&folder, "ray.tif");
    let mut n_wrong = 0;
    for method in ["sweep", "step:0.25", "step:0.5", "step:1", "step:2", "step:4", "xdraw", "r2"] {
        folder.type_in(&format!("map {scene} --method {method} -o m.tif --overwrite -q")).done();
        let found = classes(&folder, "m.tif");
        let count =
            |said: u8, truth: u8| found.iter().zip(&exact).filter(|pair| pair == &(&said, &truth)).count() as u64;
        let row = row(&document, method, "");
        assert_eq!((row["false_los"].as_u64(), row["false_nlos"].as_u64()), (Some(count(1, 0)), Some(count(0, 1))));
        assert_eq!(row["own_los"].as_u64(), Some(count(1, 0) + count(1, 1)), "{method}");
        n_wrong += row["wrong_cells"].as_u64().unwrap();
        if method.starts_with("step") {
            assert_eq!(row["false_nlos"], 0, "{method} misses obstacles, and invents none");
        }
    }
    assert!(n_wrong > 100, "a scene where {n_wrong} are wrong proves little");
}

#[test]
fn counts_of_several_uavs_are_sums() {
    let folder = folder();
    let (a, b) = ("--uav 20.3,17.8,35", "--uav 3,30,50");
    for scene in ["rough.asc --ground 0 --radius 25", "city.geojson"] {
        let [both, a, b] =
            [format!("{a} {b}"), a.into(), b.into()].map(|uavs| document(&folder, &format!("{scene} {uavs}")));
        for k in 0..both["contestants"].as_array().unwrap().len() {
            let [both, a, b] = [&both, &a, &b].map(|document| counts(&document["contestants"][k]));
            let sum: Vec<Option<u64>> = a.iter().zip(&b).map(|(a, b)| Some(a.unwrap() + b.unwrap())).collect();
            assert_eq!(both.to_vec(), sum, "{scene}, contestant {k}");
        }
    }
}

#[test]
fn a_row_names_the_engine_that_decided_it() {
    let folder = folder();
    folder.write("slope.asc", &grid(&(0..50 * 50).map(|k| k % 50 / 4).collect::<Vec<_>>(), 50));
    let document = document(&folder, "city.geojson --terrain slope.asc --uav 2,2,60");
    // Receivers on other cells than the terrain's call for rays over it.
    for (method, parameters) in
        [("ray", ""), ("shadow+sweep", ""), ("sweep", "raster"), ("step:1", "raster"), ("shadow+ray", "receivers 2x")]
    {
        assert!(row(&document, method, parameters)["receivers"].as_u64() > Some(0), "{method} {parameters}");
    }
    assert_eq!(row(&document, "shadow+sweep", "")["wrong_cells"], 0);
}

/// The rough raster as a field, and a UAV over it.
fn rough_field() -> (HeightField, Uav) {
    let georef = GeoRef::new((0.0, 40.0), (1.0, 1.0), (40, 48), None).unwrap();
    let tops = rough().iter().map(|z| i32::try_from(*z).unwrap() * 1024).collect::<Vec<_>>();
    let field = surface_field(&georef, tops, Ground::Flat(0));
    let site = Site::new("1", (20.25, 17.75), Height::AboveGround(35.0));
    let uav = Uav::place(&site, &field, None).unwrap();
    (field, uav)
}

#[test]
fn exact_engines_have_no_wrong_receivers_because_they_were_compared() {
    let (field, uav) = rough_field();
    let uavs = [uav];
    let options = MapOptions::default();
    let truth = Truth::of(&field, &uavs, &options, u64::MAX).unwrap();
    // An answer that differs in one receiver, and says of another nothing.
    let mut other = truth.clone();
    let (row, col) = (0..40 * 48).map(|k| (k / 48, k % 48)).find(|(r, c)| truth.seen[0].los.contains(*r, *c)).unwrap();
    other.seen[0].los.words_mut()[row * truth.seen[0].los.words_per_row() + col / 64] &= !(1 << (col % 64));
    let contestants = Contestant::all(&field, MethodChoice::Auto).unwrap();
    let exact: Vec<&Contestant> = contestants.iter().filter(|c| c.family().name() == "exact").collect();
    assert_eq!(exact.iter().map(|c| c.method.to_string()).collect::<Vec<_>>(), ["ray", "sweep"]);
    for contestant in exact {
        let prepared = contestant.prepare(&field, &uavs, &options).unwrap();
        let answer = prepared.answer(&prepared.mapper().unwrap()).unwrap();
        assert_eq!(truth.compare(&answer, 1).wrong(), 0, "{contestant:?}");
        let against_other = other.compare(&answer, 1);
        assert_eq!((against_other.false_los, against_other.false_nlos), (1, 0), "{contestant:?}");
    }
}

#[test]
fn where_rays_are_too_many_a_sample_of_them_confirms_the_other_engine() {
    let (field, uav) = rough_field();
    let uavs = [uav];
    let options = MapOptions::default();
    let by_ray = Truth::of(&field, &uavs, &options, u64::MAX).unwrap();
    let by_sweep = Truth::of(&field, &uavs, &options, 100).unwrap();
    assert_eq!((by_ray.method.to_string(), by_ray.checked), ("ray".to_string(), None));
    assert_eq!((by_sweep.method.to_string(), &by_sweep.seen), ("sweep".to_string(), &by_ray.seen));
    let checked = by_sweep.checked.unwrap();
    assert!((50..=100).contains(&checked), "{checked}");
}

#[test]
fn what_is_seen_over_the_coarse_maximum_is_seen_over_the_fine_grid() {
    let (field, uav) = rough_field();
    let place = &uav.station.place;
    let mut n_seen = 0;
    for factor in [2, 4] {
        let coarse = field.coarser(factor, Pooling::Maximum).unwrap();
        let on_coarse = Station { place: coarse.place(place.x, place.y), z: uav.station.z };
        let open = &coarse.cells().open;
        for row in 0..open.n_rows() {
            for col in (0..open.n_cols()).filter(|col| open.contains(row, *col)) {
                let (x, y) = coarse.grid().world_from_cell(row, col);
                let receiver = |field: &HeightField| Station { place: field.place(x, y), z: 1536 };
                if link_los(&coarse, &on_coarse, &receiver(&coarse)) {
                    n_seen += 1;
                    assert!(link_los(&field, &uav.station, &receiver(&field)), "{factor}: ({x}, {y})");
                }
            }
        }
    }
    assert!(n_seen > 20, "only {n_seen} were asked");
}

/// The document without what a clock or the machine says.
pub(crate) fn without_times(mut document: Value) -> Value {
    let object = document.as_object_mut().unwrap();
    ["command", "memory_floor", "threads"].iter().for_each(|key| drop(object.remove(*key)));
    for row in object["contestants"].as_array_mut().unwrap() {
        let row = row.as_object_mut().unwrap();
        for key in ["cpu_s", "wall_s", "peak_mb", "runs", "cpu_ns_per_receiver", "pareto"] {
            row.remove(key);
        }
    }
    document
}

#[test]
fn counts_do_not_depend_on_threads_or_runs() {
    let folder = folder();
    for scene in ["rough.asc --ground 0 --uav 20.3,17.8,35", "city.geojson --uav 2,2,50", "itu:urban --plos"] {
        let [one, two, again] =
            ["-j 1", "-j 2", ""].map(|flags| without_times(document(&folder, &format!("{scene} {flags}"))));
        assert_eq!(one, two, "{scene}");
        assert_eq!(one, again, "{scene}");
    }
    let threads = |flags: &str| document(&folder, &format!("{BY_HAND} {flags}"))["threads"].as_u64();
    assert_eq!([threads(""), threads("-j 2")], [Some(1), Some(2)]);
}
