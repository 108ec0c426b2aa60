//! P_LoS by zone of the placement: from maps of generated cities against the product over the same disc, and
//! `skyshed sample --zones` from outside.

use std::collections::HashMap;

use skyshed_core::city::{BuiltUp, Site};
use skyshed_core::coverage::{MapOptions, Mapper, Uav};
use skyshed_core::height_field::HeightField;
use skyshed_core::quantity::Height;
use skyshed_core::raster::CellBlocks;
use skyshed_core::zones::{Zone, ZoneMap};
use skyshed_request::Placement;
use skyshed_study::los_probability::estimate::Estimate;
use skyshed_study::placement::{ReceiverParts, SampledCounts, middles_of, over_cities};

use crate::cities::{built, generated};
use crate::products::{product, within};
use crate::program::Folder;
use crate::refusals::check_refusals;
use crate::support::is_long;
use crate::texts::{number, table_rows};

const HEIGHT_M: f64 = 100.0;
const RADII_M: [f64; 4] = [50.0, 100.0, 200.0, 300.0];
const PLACEMENTS: [(Zone, Placement); 3] = [
    (Zone::Crossroad, Placement::CrossroadCenter),
    (Zone::Street, Placement::StreetCenter),
    (Zone::Rooftop, Placement::RooftopCenter),
];

/// UAVs over middles whose discs lie in the city, and which are not inside a building.
fn uavs(field: &HeightField, middles: &[[f64; 2]], size_m: f64) -> Vec<Uav> {
    let reach = RADII_M[3];
    let is_inside = |v: f64| v >= reach && v <= size_m - reach;
    let site = |[x, y]: [f64; 2]| Site::new("1", (x, y), Height::AboveGround(HEIGHT_M));
    let places = middles.iter().filter(|[x, y]| is_inside(*x) && is_inside(*y));
    places.filter_map(|place| Uav::place(&site(*place), field, None).ok()).collect()
}

/// P_LoS of outdoor users within each radius, `[placement][radius]`, over cities of 1 m cells.
fn from_maps(name: &str, n_cities: u64) -> Vec<Vec<Estimate>> {
    let built_up = BuiltUp::named(name).unwrap();
    // Room for two periods of places.
    let size_m = (2.0 * RADII_M[3] + 2.0 * built_up.period()).ceil();
    let mut totals = vec![vec![Vec::new(); RADII_M.len()]; PLACEMENTS.len()];
    for seed in 1..=n_cities {
        let field = built(&generated(name, seed, size_m));
        let zones = ZoneMap::of(&field, Some(&built_up)).unwrap();
        let parts = ReceiverParts::new(&field.cells().open, &zones);
        let blocks = CellBlocks::new(field.grid(), 1.0, size_m);
        for (of_radius, radius) in RADII_M.into_iter().enumerate() {
            let options = MapOptions { radius: Some(radius), ..MapOptions::default() };
            let mapper = Mapper::new(&field, &options).unwrap();
            for (of_placement, (zone, _)) in PLACEMENTS.iter().enumerate() {
                let uavs = uavs(&field, &middles_of(&built_up, size_m, *zone), size_m);
                let counts = SampledCounts::of(&mapper, &uavs, &parts, &blocks).unwrap();
                totals[of_placement][of_radius].push(counts.totals());
            }
        }
    }
    let estimate = |totals: &Vec<Vec<_>>| over_cities(totals, 1, 0.95)[0];
    totals.iter().map(|of_placement| of_placement.iter().map(estimate).collect()).collect()
}

#[test]
fn maps_around_uavs_over_middles_agree_with_the_product_over_the_disc() {
    let n_cities = if is_long() { 400 } else { 30 };
    for name in ["suburban", "urban", "dense-urban", "high-rise"] {
        let found = from_maps(name, n_cities);
        for ((zone, placement), of_placement) in PLACEMENTS.iter().zip(&found) {
            for (radius_m, estimate) in RADII_M.into_iter().zip(of_placement) {
                let reference = product(&within(name, radius_m, HEIGHT_M, *placement), 1 << 10);
                let (p, wanted) = (estimate.p_los.unwrap(), reference.p_los.unwrap());
                let error = estimate.std_error.unwrap().hypot(reference.std_error.unwrap());
                assert!((p - wanted).abs() <= 4.0 * error, "{name}, {zone:?}, {radius_m} m: {p} ± {error}, {wanted}");
            }
        }
        // Which zone is best: crossroads in dense and high-rise cities, not in the urban one within 100 m.
        let p_los = |placement: usize, radius: usize| found[placement][radius].p_los.unwrap();
        let crossroads_win = |radius: usize| (1..3).all(|other| p_los(0, radius) > p_los(other, radius));
        match name {
            "dense-urban" | "high-rise" => assert!((0..4).all(crossroads_win), "{name}"),
            "urban" => assert!((0..2).all(|radius| p_los(0, radius) < p_los(1, radius)), "{name}"),
            _ => {}
        }
    }
}

#[test]
fn a_sample_of_one_place_says_what_the_map_of_it_says() {
    let folder = Folder::new();
    // The middle of the first crossroad: streets are 1000/√500 − 1000·√(0.3/500) m wide.
    let middle = 0.5 * (1000.0 / 500.0_f64.sqrt() - 1000.0 * (0.3_f64 / 500.0).sqrt());
    let scene = "itu:urban --size 250";
    let map =
        folder.type_in(&format!("map {scene} --uav {middle},{middle},60 --receivers all --zones --json")).done().json();
    let line = format!("sample {scene} --zones crossroad:1 --centers --height 60 --receivers all");
    let sample = folder.type_in(&format!("{line} --json -o s.csv -o s.svg -o s.pdf")).done().json();
    assert_eq!(sample["schema"], "skyshed/sample/1");
    let site = &map["sites"][0];
    let rows = sample["rows"].as_array().unwrap();
    let zones: Vec<&str> = rows.iter().map(|row| row["receivers_zone"].as_str().unwrap()).collect();
    assert_eq!(zones, ["all", "street", "crossroad", "rooftop"]);
    for (row, zone) in rows.iter().zip(zones) {
        let wanted = if zone == "all" { site } else { &site["zones"][zone] };
        // The cells of a sample begin at a drawn place, so that walls do not stand alike in all of them.
        let number = |of: &serde_json::Value| of.as_f64().unwrap();
        let (p, n) =
            (number(&row["p_los"]) - number(&wanted["p_los"]), number(&row["samples"]) / number(&wanted["receivers"]));
        assert!(p.abs() < 0.01 && (n - 1.0).abs() < 0.02, "{zone}: {row}, {wanted}");
        assert_eq!((&row["placements"], &row["clusters"].is_u64()), (&serde_json::json!(1), &true));
        assert!(row["ci_low"].is_null() && row["reason"].as_str().unwrap().starts_with("no interval"), "{row}");
    }
    let table = folder.text("s.csv");
    assert!(table.starts_with("placement,height_m,receivers_zone,") && table.lines().count() == 5, "{table}");
    assert!(folder.text("s.svg").contains("UAV over crossroads"));
    assert!(std::fs::read(folder.join("s.pdf")).unwrap().starts_with(b"%PDF-1"));
}

#[test]
fn samples_have_intervals_and_do_not_depend_on_threads() {
    let folder = Folder::new();
    let line = "sample itu:dense-urban --size 300 --cell 2 --zones street:12,rooftop:12,courtyard:3 --height 30,80 --cities 12";
    let one = folder.type_in(&format!("{line} --csv one.csv -j 1")).done();
    assert!(one.warnings().contains(&"W202"), "a generated city has no courtyard: {one:?}");
    folder.type_in(&format!("{line} --csv three.csv -j 3")).done();
    assert_eq!(folder.text("one.csv"), folder.text("three.csv"));
    let rows = table_rows(&folder.text("one.csv"));
    for row in &rows {
        if row["placement"] == "courtyard" {
            assert_eq!((&row["p_los"][..], &row["reason"][..]), ("", "the scene has no courtyard place"));
            continue;
        }
        let (low, p, high) = (number(row, "ci_low"), number(row, "p_los"), number(row, "ci_high"));
        assert!(0.0 < low && low < p && p < high && high < 1.0, "{row:?}");
        let n_places = number(row, "placements") + number(row, "inside_building");
        assert_eq!((number(row, "clusters"), n_places), (12.0, 144.0));
    }
    // From 30 m a dense city has roofs in the way; from 80 m more is seen.
    let p_los = |wanted: [&str; 3]| {
        let is_it = |row: &&HashMap<String, String>| {
            ["placement", "height_m", "receivers_zone"].map(|key| &row[key][..]) == wanted
        };
        number(rows.iter().find(is_it).unwrap(), "p_los")
    };
    assert!(p_los(["street", "30", "all"]) < p_los(["street", "80", "all"]));
    assert!(p_los(["street", "30", "street"]) > p_los(["rooftop", "30", "street"]), "roofs hide the street below them");
}

#[test]
fn samples_that_make_no_sense_are_refused() {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 100 -o city.geojson").done();
    folder.type_in("city itu:urban --size 100 -o dsm.asc").done();
    let cases = [
        ("itu:urban --zones street --height 50", "E101", "found `street`"),
        ("itu:urban --zones park:5 --height 50", "E101", "found `park`"),
        ("itu:urban --zones street:0 --height 50", "E101", "found `0`"),
        ("itu:urban --zones street:5,street:6 --height 50", "E113", "street"),
        ("itu:urban --zones street:5 --height 30roof", "E113", "`30roof`"),
        ("itu:urban --zones street:5 --height 50 --ci 1", "E113", "`1`"),
        ("itu:urban --zones street:5 --height 50 --block 0", "E113", "`0`"),
        ("itu:urban --zones street:5 --height 50 --goal p_los", "E101", "'--goal'"),
        ("itu:urban --zones street:5 --height 50 -o a.tif", "E105", "a.tif"),
        ("itu:urban --height 50 --cities 5", "E101", "--zones"),
        ("city.geojson --zones street:5 --height 50 --cities 5", "E116", "several cities"),
        ("city.geojson --zones street:5 --height 50 --centers", "E116", "centers of zones"),
        ("dsm.asc --zones street:5 --height 50", "E117", "zones"),
    ];
    check_refusals(&folder, "sample", &cases);
}
