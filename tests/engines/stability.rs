//! Which answers turn when the UAV, or all roofs, move by one lattice step: by hand, by maps made anew at the moved places,
//! and in files.

use serde_json::Value;
use skyshed_core::city::{Ground, Site};
use skyshed_core::coverage::{
    Control, HeightLayers, MapOptions, Mapper, Move, MovedRoofs, Receivers, SiteCoverage, Stability, Turned, Uav, class,
};
use skyshed_core::height_field::{CellKind, HeightField, Station};
use skyshed_core::los::{MethodChoice, link_los};
use skyshed_core::quantity::{Height, meters};
use skyshed_core::raster::GeoRef;

use crate::invariants::{raster_town, vector_town};
use crate::program::Folder;
use crate::support::{Random, surface_field};

const STABILITY: HeightLayers = HeightLayers {
    margin: false,
    least_receiver_height: false,
    least_height: false,
    stability: true,
    sure: false,
    p_los: false,
};

fn map(field: &HeightField, uav: &Uav, options: &MapOptions) -> SiteCoverage {
    Mapper::new(field, options).unwrap().seen_from(uav).unwrap().map(&Control::default()).unwrap()
}

fn stability(field: &HeightField, uav: &Uav, options: &MapOptions) -> Stability {
    map(field, uav, &MapOptions { layers: STABILITY, ..options.clone() }).stability.unwrap()
}

/// Columns of these tops \[1/1024 m\] in one row, a cell to the meter, over flat ground at 0 m or alone.
fn row(tops: &[i32], ground: Ground) -> HeightField {
    let grid = GeoRef::new((0.0, 1.0), (1.0, 1.0), (1, tops.len()), None).unwrap();
    surface_field(&grid, tops.to_vec(), ground)
}

fn uav_at(field: &HeightField, x: f64, y: f64, z: i32) -> Uav {
    let site = Site::new("1", (x, y), Height::AboveDatum(meters(z)));
    Uav::place(&site, field, None).unwrap()
}

fn turned(stability: &Stability) -> Vec<Option<(u64, u64)>> {
    assert_eq!(stability.moves.iter().map(|(which, _)| *which).collect::<Vec<_>>(), Move::ALL);
    stability.moves.iter().map(|(_, t)| t.as_ref().ok().map(|t| (t.gained, t.lost))).collect()
}

#[test]
fn a_receiver_that_grazes_turns_with_the_moves_that_a_hand_works_out() {
    // UAV in the middle of cell 0, a tower on cell 1, receivers on the ground at 1536. The ray to cell 2 leaves the tower
    // at x = 2 m, three quarters of the way, at 1536 + (9728 − 1536)/4 = 3584: exactly its roof.
    let field = row(&[0, 3584, 0], Ground::Flat(0));
    let uav = uav_at(&field, 0.5, 0.5, 9728);
    let found = stability(&field, &uav, &MapOptions::default());
    // The wall at 2 m is 512/2048 of the way from the receiver. A step nearer (east) that is 512/2047, and the ray is
    // higher there; a step farther it is lower than the roof. North and south the ray leaves through the same wall at the
    // same share. Up lifts it by a quarter of a step, down lowers it; roofs up block, roofs down do not.
    let [stays, lost] = [Some((0, 0)), Some((0, 1))];
    assert_eq!(turned(&found), [stays, lost, stays, stays, stays, lost, lost, stays]);
    assert_eq!((found.turns[2], found.unstable), (3.0, 1));
    assert!(found.turns[1].is_nan(), "a roof is no receiver");
    assert!(found.turns[0].abs() < 0.5, "{:?}", found.turns);

    // A step lower it is hidden: what saved it above now gains it.
    let field = row(&[0, 3585, 0], Ground::Flat(0));
    let found = stability(&field, &uav_at(&field, 0.5, 0.5, 9728), &MapOptions::default());
    // 1 step is missing: 512/2047 · 8192 is 2049.0, one more than 2048; up brings a quarter; roofs down bring one.
    let gained = Some((1, 0));
    assert_eq!(turned(&found), [gained, stays, stays, stays, stays, stays, stays, gained]);
    assert_eq!((found.turns[2], found.unstable), (2.0, 1));
}

#[test]
fn a_surface_model_alone_moves_under_receivers_that_stay() {
    // Receivers stand on every column. The one on the last column grazes the middle one: from 4096 at x = 0.5 to 0 at
    // x = 2.5, at x = 2 the ray is 1024 high.
    let field = row(&[0, 1024, 0], Ground::Surface);
    let uav = uav_at(&field, 0.5, 0.5, 4096);
    let options = MapOptions { rx_height: 0, ..MapOptions::default() };
    let found = stability(&field, &uav, &options);
    let (roofs_up, roofs_down) = (&found.moves[6], &found.moves[7]);
    assert_eq!(roofs_up.1, Ok(Turned { gained: 0, lost: 1 }));
    assert_eq!(roofs_down.1, Ok(Turned { gained: 0, lost: 0 }));
}

#[test]
fn a_move_into_a_building_or_out_of_the_lattice_is_no_number() {
    let field = row(&[0, 2048, 0], Ground::Flat(0));
    // On the roof: down, and roofs up, put it inside.
    let found = stability(&field, &uav_at(&field, 1.5, 0.5, 2048), &MapOptions::default());
    let none = |found: &Stability| -> Vec<Move> {
        found.moves.iter().filter(|(_, t)| t.is_err()).map(|(which, _)| *which).collect()
    };
    assert_eq!(none(&found), [Move::Down, Move::RoofsUp]);
    assert!(found.moves[5].1.as_ref().unwrap_err().contains("inside a building"), "{found:?}");
    // At the top of the lattice there is no way up; nor is there for a roof.
    let field = row(&[0, 1 << 25, 0], Ground::Flat(0));
    let found = stability(&field, &uav_at(&field, 0.5, 0.5, 1 << 25), &MapOptions::default());
    assert_eq!(none(&found), [Move::Up, Move::RoofsUp]);
}

#[test]
fn the_layer_counts_the_maps_that_differ() {
    let mut random = Random(71);
    let (mut n_turned, mut n_made) = (0, 0);
    for field in [raster_town(&mut random, 30), vector_town(&mut random, 30)] {
        for (k, radius) in [None, Some(0.4), None].into_iter().enumerate() {
            let (width, height) =
                (field.grid().x_max() - field.grid().x_min(), field.grid().y_max() - field.grid().y_min());
            let (x, y) = (field.grid().x_min() + width * (0.2 + 0.3 * k as f64), field.grid().y_min() + height * 0.45);
            let radius: Option<f64> = radius.map(|share: f64| share * width);
            let place = field.place(x, y);
            let z = skyshed_core::coverage::surface_under(&field, &place).max(0) + 3 * 1024;
            let uav = uav_at(&field, x, y, z);
            let options = MapOptions { radius, receivers: Receivers::All, ..MapOptions::default() };
            let before = map(&field, &uav, &options);
            let found = stability(&field, &uav, &options);
            let mut counts = vec![0_u8; before.mask.len()];
            // The receivers that were in range and turn when they are seen as `is_los_now` says.
            let mut turned_by = |is_los_now: &dyn Fn(usize) -> bool| {
                let mut sum = Turned::default();
                for (cell, class) in before.mask.iter().enumerate().filter(|(_, class)| **class <= class::LOS) {
                    let is_los = is_los_now(cell);
                    if is_los != (*class == class::LOS) {
                        counts[cell] += 1;
                        sum.gained += u64::from(is_los);
                        sum.lost += u64::from(!is_los);
                    }
                }
                sum
            };
            let steps = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]];
            for ((which, turned), steps) in found.moves.iter().zip(steps) {
                let Ok(moved) = uav.moved(&field, steps, None) else {
                    assert!(turned.as_ref().is_err_and(|why| why.contains("inside a building")), "{turned:?}");
                    continue;
                };
                n_made += 1;
                // Everywhere, so that the radius does not matter.
                let after = map(&field, &moved, &MapOptions { radius: None, ..options.clone() });
                assert_eq!(turned, &Ok(turned_by(&|cell| after.mask[cell] == class::LOS)), "{which:?}");
            }
            for (step, turned) in [1, -1].into_iter().zip(&found.moves[6..]) {
                let shifted = MovedRoofs::by_building(&field, |_| step).unwrap();
                let (positions, n_cols) = (field.positions(), field.grid().n_cols());
                let is_los = |cell: usize| {
                    let place = positions.center(cell / n_cols, cell % n_cols);
                    let base = match field.cell_kind(cell, &place) {
                        CellKind::Open(z) | CellKind::Building(z) => z,
                        CellKind::Void => panic!("no receiver is there"),
                    };
                    let receiver = Station { place, z: i64::from(base) + i64::from(options.rx_height) };
                    link_los(&shifted.field, &uav.station, &receiver)
                };
                assert_eq!(turned.1, Ok(turned_by(&is_los)), "roofs by {step}");
            }
            for (cell, turns) in found.turns.iter().enumerate() {
                let expected = (before.mask[cell] <= class::LOS).then(|| f32::from(counts[cell]));
                assert_eq!((!turns.is_nan()).then_some(*turns), expected, "cell {cell}");
            }
            assert_eq!(found.unstable, counts.iter().filter(|n| **n > 0).count() as u64);
            n_turned += found.unstable;
            let by_ray = stability(&field, &uav, &MapOptions { method: MethodChoice::Ray, ..options });
            assert_eq!((by_ray.moves, by_ray.unstable), (found.moves, found.unstable));
        }
    }
    assert!(n_turned > 0 && n_made > 24, "{n_turned} turned by {n_made} moves: the test proves nothing");
}

/// A tower whose roof the ray to one cell grazes, as in the first test, with a file of its own.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("dsm.asc", "ncols 3\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9999\n0 3.5 0\n");
    folder
}

const GRAZING: &str = "dsm.asc --ground 0 --uav 0.5,0.5,9.5";

#[test]
fn the_layer_goes_into_every_file() {
    let folder = folder();
    let files = "-o s.asc -o s.tif -o s.npz -o s.exr -o s.png -o s.svg -o s.json";
    let printed = folder.type_in(&format!("map {GRAZING} --layers stability {files} --json")).done().json();
    let stability = &printed["sites"][0]["stability"];
    assert_eq!(stability["cells"], 1);
    assert_eq!(stability["moves"]["uav_down"], serde_json::json!({"gained": 0, "lost": 1}));
    assert_eq!(stability["moves"].as_object().unwrap().len(), 8);
    assert_eq!(folder.json("s.json")["sites"][0]["stability"], *stability);
    assert_eq!(folder.text("s.asc").lines().last().unwrap().trim(), "0 -9999 3");
    let tif = geotiff_reader::GeoTiffFile::from_bytes(folder.read("s.tif")).unwrap();
    let values: Vec<f32> = tif.read_raster::<f32>().unwrap().into_iter().collect();
    assert_eq!(values, [0.0, -9999.0, 3.0]);
    let svg = folder.text("s.svg");
    for words in
        ["Stability of line of sight", "Stable", "3 of 8 moves turn it", "UAV down +0 −1", "1 receiver turns", "ringed"]
    {
        assert!(svg.contains(words), "{words}: {svg}");
    }
    // Without the layer the document does not speak of it.
    let without = folder.type_in(&format!("map {GRAZING} --json")).done().json();
    assert_eq!(without["sites"][0].get("stability"), None);
}

#[test]
fn the_perturbation_test_of_a_scene_tells_moves_and_margins() {
    let folder = folder();
    let line = format!("stress {GRAZING} -o s.csv -o s.json -o s.png -o s.svg --json");
    let answer = folder.type_in(&line).done();
    let document = answer.json();
    assert_eq!(document["schema"], "skyshed/stress-scene/1");
    assert_eq!(document["sites"][0]["stability"]["cells"], 1);
    let margins = &document["margins"];
    assert_eq!((&margins["every"], &margins["sampled"]), (&Value::from(1), &Value::from(2)));
    // Cell 2 grazes with margin 0; cell 0, below the UAV, has nothing above it but its own ground, 1.5 m down.
    let near: Vec<&Value> = margins["near_grazing"].as_array().unwrap().iter().map(|bin| &bin["receivers"]).collect();
    assert_eq!(near, [1, 1, 1, 1, 2]);
    let table = folder.text("s.csv");
    assert!(table.contains("\nmove,uav_west,2,0,1,1,0.5,\n"), "{table}");
    assert!(table.contains("\nmargin,within 0.0009765625 m,2,,,1,0.5,\n"), "{table}");
    assert_eq!(folder.json("s.csv.json")["schema"], "skyshed/stress-scene/1");
    for note in ["uav west by a lattice step: 0 gained, 1 lost", "within 0.01 m of grazing: 1 of 2"] {
        assert!(answer.err.contains(note), "{note}: {}", answer.err);
    }
    // Without a file the table goes to standard output.
    assert_eq!(folder.type_in(&format!("stress {GRAZING} -q")).done().out, table);
    let roof = folder.type_in("stress dsm.asc --ground 0 --uav 1.5,0.5,0roof --json -q").done().json();
    let down = &roof["sites"][0]["stability"]["moves"]["uav_down"];
    assert!(down["gained"].is_null() && down["reason"].as_str().unwrap().contains("inside a building"), "{down}");
}
