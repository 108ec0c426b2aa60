//! Where the data end, and what a share is a share of: known ground, missing heights, whole discs, bands of angles, goals
//! within a radius.

use serde_json::{Value, json};
use skyshed_request::Placement;
use skyshed_study::los_probability::setting::Setting;

use crate::figures::{drawn, words};
use crate::masks::{mask_of, tif};
use crate::products::{at_height, product, within};
use crate::program::Folder;
use crate::refusals::check_refusals;
use crate::rings::{area, rings};
use crate::support::is_long;
use crate::texts::{number, table_rows};

const MUNICH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/maps/munich.geojson");

fn building(properties: &Value, [west, south, east, north]: [f64; 4]) -> Value {
    let ring = json!([[west, south], [east, south], [east, north], [west, north], [west, south]]);
    json!({"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}})
}

fn write_city(folder: &Folder, name: &str, features: &[Value]) {
    let crs = json!({"type": "name", "properties": {"name": "EPSG:25832"}});
    folder.write(name, &json!({"type": "FeatureCollection", "crs": crs, "features": features}).to_string());
}

/// Four blocks around a crossing, and a farm 400 m to the east.
pub(crate) fn town(folder: &Folder) {
    let blocks = [[0.0, 0.0], [60.0, 0.0], [0.0, 60.0], [60.0, 60.0]];
    let mut features: Vec<Value> =
        blocks.iter().map(|[x, y]| building(&json!({"height": 12}), [*x, *y, x + 40.0, y + 40.0])).collect();
    features.push(building(&json!({"height": 6}), [480.0, 40.0, 500.0, 60.0]));
    write_city(folder, "town.geojson", &features);
}

fn u64_of(value: &Value) -> u64 {
    value.as_u64().unwrap_or_else(|| panic!("no count: {value}"))
}

#[test]
fn ground_beyond_the_last_house_holds_no_data() {
    let folder = Folder::new();
    town(&folder);
    let info = |rest: &str| {
        let mut document = folder.type_in(&format!("info town.geojson {rest} --json")).done().json();
        document["zones"] = folder.type_in(&format!("zones town.geojson {rest} --json")).done().json();
        let cells = document["cells"].clone();
        (u64_of(&cells["open"]), u64_of(&cells["building"]), u64_of(&cells["nodata"]), document)
    };
    let (open, built, nodata, document) = info("");
    // 500 × 100 cells, of which the town is 100 × 100; the farm stands alone. Streets of 20 m are known all through.
    assert_eq!((built, open + built + nodata), (4 * 1600 + 400, 50_000));
    let streets = 10_000 - 4 * 1600;
    // At the four ends of the streets a disc of 100 m reaches in by 100 − √(100² − 10²) = 0.5 m: half a cell of 20, or one.
    assert!((streets - 80..=streets).contains(&open), "{open} of {streets}");
    assert!(!document["warnings"].to_string().contains("W379"), "{document}");
    let zones: u64 =
        ["street", "crossroad", "courtyard", "rooftop"].iter().map(|z| u64_of(&document["zones"][*z]["cells"])).sum();
    assert_eq!(zones, open + built, "{document}");
    assert_eq!(info("--data-area all").0, 50_000 - built);
    // A typed extent is taken whole, and that is said.
    let (all, _, _, document) = info("--extent 0,0,500,100");
    assert_eq!(all, 50_000 - built);
    assert!(document["warnings"].to_string().contains("W378"));
    assert!(!info("--extent 0,0,500,100 --data-area all").3["warnings"].to_string().contains("W378"));
    // A polygon of one's own.
    write_city(&folder, "area.geojson", &[building(&json!({}), [40.0, 0.0, 260.0, 100.0])]);
    assert_eq!(info("--data-area area.geojson").0, 220 * 100 - 2 * 40 * 40);
    check_refusals(&folder, "map itu:urban --uav 5,5,50", &[("--data-area all", "E116", "`--data-area`")]);
}

#[test]
fn cells_without_data_are_no_receivers_and_no_candidates() {
    let folder = Folder::new();
    town(&folder);
    let map = "map town.geojson --uav 50,50,30 -q";
    folder.type_in(&format!("{map} -o m.npz -o m.json -o m.png --polygons los -o m.fgb")).done();
    let site = folder.json("m.json")["sites"][0].clone();
    let info = folder.type_in("info town.geojson --json").done().json();
    assert_eq!(site["receivers"], info["cells"]["open"]);
    // The best place is over the town, though the empty field has sight of all that is near it.
    let line = "place town.geojson --height 20 --step 10 --radius 60 --json";
    let document = folder.type_in(line).done().json();
    let winner = &document["winner"];
    assert!(winner["x"].as_f64().unwrap() <= 100.0, "{winner}");
    let skipped = &document["candidates"]["skipped"]["no_data"];
    assert!(u64_of(skipped) > 0, "{document}");
    // A share within a radius is of all receivers, not of the few in range.
    assert_eq!(winner["receivers"], info["cells"]["open"], "{winner}");
    let (los, p) = (winner["los"].as_f64().unwrap(), winner["p_los"].as_f64().unwrap());
    assert!((p - los / winner["receivers"].as_f64().unwrap()).abs() < 1e-12);
}

#[test]
fn munich_is_known_between_its_houses_only() {
    let folder = Folder::new();
    let document = folder.type_in(&format!("info {MUNICH} --json")).done().json();
    let cells = &document["cells"];
    let all: u64 = ["open", "building", "nodata"].iter().map(|k| u64_of(&cells[*k])).sum();
    // By another program (shapely): the union of the footprints, grown and shrunk by 100 m, its holes filled, has 1 043 840 m².
    let known = (all - u64_of(&cells["nodata"])) as f64;
    assert!((known / 1_043_840.0 - 1.0).abs() < 0.01, "{known} of {all}");
}

#[test]
fn every_file_of_a_map_knows_where_the_data_end() {
    let folder = Folder::new();
    town(&folder);
    // From the west end of a street: receivers in the streets across are hidden. Cells of 4 m².
    let map = "map town.geojson --cell 2 --uav 10,50,20";
    folder.type_in(&format!("{map} --polygons all -o m.tif -o m.json -o m.geojson -q")).done();
    folder.type_in("zones town.geojson --cell 2 -o z.tif -q").done();
    let info = folder.type_in("info town.geojson --cell 2 --json -q").done().json();
    let cells = &info["cells"];
    let mask = mask_of(&folder, "m.tif");
    let n_of = |class: u8| mask.iter().filter(|cell| **cell == class).count() as u64;
    assert!([0, 1, 255].iter().all(|class| n_of(*class) > 0));
    assert_eq!(
        [n_of(0) + n_of(1), n_of(2), n_of(255)],
        ["open", "building", "nodata"].map(|kind| u64_of(&cells[kind]))
    );
    assert_eq!(u64_of(&folder.json("m.json")["sites"][0]["receivers"]), n_of(0) + n_of(1));
    // Polygons are in whole meters: their areas are sums without error.
    let features = folder.json("m.geojson")["features"].as_array().unwrap().clone();
    for (class, name) in [(0, "NLoS"), (1, "LoS")] {
        let of_class = features.iter().filter(|f| f["properties"]["class"] == name);
        let sum: f64 = of_class.flat_map(rings).map(|ring| area(&ring)).sum();
        assert_eq!(Some(sum), Some(4.0 * n_of(class) as f64), "{name}");
    }
    let said = words(&drawn(&folder, map));
    assert!(said.contains(&format!("No data {} cells", n_of(255))), "{said}");
    // A cell has no zone exactly where there are no data.
    let zones = mask_of(&folder, "z.tif");
    assert_eq!(zones.len(), mask.len());
    assert!(zones.iter().zip(&mask).all(|(zone, class)| (*zone == 0) == (*class == 255)));
}

#[test]
fn no_place_is_ranked_and_no_cell_compared_where_munich_has_no_data() {
    let folder = Folder::new();
    let scene = format!("{MUNICH} --cell 4");
    let uavs = ["--uav 691600,5334800,100", "--uav 691700,5334800,100"];
    folder.type_in(&format!("map {scene} {} -o m.tif -q", uavs[0])).done();
    let file = tif(&folder, "m.tif");
    let (n_cols, [west, south, _, _]) = (file.width() as usize, file.geo_bounds().unwrap());
    let mask = mask_of(&folder, "m.tif");
    let without_data: Vec<usize> = (0..mask.len()).filter(|cell| mask[*cell] == 255).collect();
    assert!(without_data.len() > mask.len() / 10, "{} of {}", without_data.len(), mask.len());
    let place = format!("place {scene} --step 60 --height 60");
    let document = folder.type_in(&format!("{place} --csv p.csv --json -q")).done().json();
    let ranked = document["ranked"].as_array().unwrap().iter();
    let mut places: Vec<[f64; 2]> = ranked.map(|p| [p["x"].as_f64().unwrap(), p["y"].as_f64().unwrap()]).collect();
    let n_ranked = places.len();
    let table = table_rows(&folder.text("p.csv"));
    places.extend(table.iter().map(|row| [number(row, "x"), number(row, "y")]));
    assert!(n_ranked > 0 && places.len() > n_ranked + 100, "{n_ranked} and {}", places.len());
    for [x, y] in places {
        // A place on an edge belongs to the cell north-east of it.
        let index = |cells: f64| (0..).find(|k: &usize| cells < *k as f64 + 1.0).unwrap();
        let n_rows = mask.len() / n_cols;
        let cell = (n_rows - 1 - index((y - south) / 4.0)) * n_cols + index((x - west) / 4.0);
        assert_ne!(mask[cell], 255, "({x}, {y})");
    }
    folder.type_in(&format!("compare {scene} {} {} -o k.tif -q", uavs[0], uavs[1])).done();
    let compared = tif(&folder, "k.tif");
    assert_eq!(compared.band_count(), 4, "two masks, their difference, the count");
    for k in 0..4 {
        let band: Vec<u8> = compared.read_band::<u8>(k).unwrap().into_iter().collect();
        assert_eq!(without_data.iter().find(|cell| band[**cell] != 255), None, "band {k}");
        assert!(band.contains(&0) && band.contains(&1), "band {k}");
    }
}

/// The masks of scenes that say as much of their ground as they did in version 0.1.
#[test]
fn masks_of_scenes_without_an_end_of_data_are_those_of_version_0_1() {
    let folder = Folder::new();
    let [dsm, terrain] = ["dsm", "terrain"].map(|part| MUNICH.replace("munich.geojson", &format!("munich_{part}.tif")));
    let surface = format!("{dsm} --terrain {terrain} --uav 691549.7,5334762.2,60");
    let footprints = format!("{MUNICH} --data-area all --uav 691549.7,5334762.2,120");
    let by_their_tops = format!("{footprints} --top-field z_top");
    for (line, digest) in [
        // As version 0.1 gave them; its only data area was all.
        ("itu:urban --size 300 --uav 150,150,60", "288d0a2adcd7825004dd92d51caa456bc0ea8499191fe3461569e5e8989ddf19"),
        (&surface, "22bcc6914bf37dbb9f8f6ea65c66beeaa86ac9a7360b0f09da7108dbd4008756"),
        (&footprints, "dd70488fec8257775802d7cbd1677ef7a90562d2bea986429fe152534b5d3192"),
        (&by_their_tops, "dd70488fec8257775802d7cbd1677ef7a90562d2bea986429fe152534b5d3192"),
    ] {
        let document = folder.type_in(&format!("map {line} --json -q")).done().json();
        assert_eq!(document["digest"], format!("sha256:{digest}"), "{line}");
    }
}

/// Where less than a tenth of what lies between the footprints is open, they say nothing of a city.
#[test]
fn all_ground_around_lone_houses_is_known_and_that_is_said() {
    let folder = Folder::new();
    let house = |west: f64| building(&json!({"height": 9}), [west, 0.0, west + 30.0, 30.0]);
    // One house, and two so far apart that a disc of 100 m passes between them.
    for (houses, open) in [(vec![house(0.0)], 0), (vec![house(0.0), house(500.0)], (530 - 60) * 30)] {
        write_city(&folder, "lone.geojson", &houses);
        let answer = folder.type_in("info lone.geojson --json").done();
        let cells = answer.json()["cells"].clone();
        assert_eq!((&cells["open"], &cells["nodata"]), (&json!(open), &json!(0)), "{answer:?}");
        assert!(answer.warnings().contains(&"W379"), "{} houses: {answer:?}", houses.len());
        // Who asks for all ground need not be told.
        let answer = folder.type_in("info lone.geojson --data-area all --json").done();
        assert!(!answer.warnings().contains(&"W379"), "{answer:?}");
    }
}

#[test]
fn missing_heights_are_refused_above_two_percent_of_the_area() {
    let folder = Folder::new();
    let with = |n_missing: u8| {
        let features: Vec<Value> = (0..100_u8)
            .map(|k| {
                let x = 20.0 * f64::from(k);
                let properties = if k < n_missing {
                    json!({"name": "x", "building:levels": (k % 2 == 0).then_some(4)})
                } else {
                    json!({"height": 10.0 + f64::from(k % 3)})
                };
                building(&properties, [x, 0.0, x + 10.0, 10.0])
            })
            .collect();
        write_city(&folder, "c.geojson", &features);
    };
    with(2);
    let answer = folder.type_in("map c.geojson --uav 995,50,30 -o c.svg --json").done();
    assert!(answer.warnings().contains(&"W354"), "{answer:?}");
    assert!(folder.text("c.svg").contains("2.0 % of the footprint area has no height"), "the caption says so");
    with(3);
    let answer = folder.type_in("map c.geojson --uav 995,50,30 --json");
    assert_eq!(answer.error(), "E309");
    // What is missing, and what each policy would do here.
    for told in [
        "3 of 100 ",
        " 3.0 % ",
        "`--missing drop` leaves them out",
        "`--missing levels,median` gives 2 of the 3 ",
        "`--missing median` gives them 11 m",
    ] {
        assert!(answer.err.contains(told), "{told}: {answer:?}");
    }
    // One of a hundred is left by the storeys.
    for policy in ["drop", "levels", "median", "levels,median", "levels,drop", "9"] {
        folder.type_in(&format!("map c.geojson --uav 995,50,30 --json --missing {policy}")).done();
    }
    // `info` tells what is wrong.
    assert_eq!(folder.type_in("info c.geojson --json").done().json()["faults"]["missing_height"], 3);
    let misspelled = folder.type_in("map c.geojson --uav 995,50,30 --json --height-field heihgt");
    assert!(misspelled.error() == "E365" && misspelled.err.contains("`height`"), "{misspelled:?}");
}

#[test]
fn p_los_at_an_angle_does_not_depend_on_the_other_angles() {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 500 --seed 5 -o c.geojson -q").done();
    let line = "plos c.geojson --method maps --height 80 --positions 20";
    let row_at_30 = |theta: &str| {
        folder.type_in(&format!("{line} --theta {theta} -o t.csv --overwrite -q")).done();
        let table = folder.text("t.csv");
        let row = table.lines().find(|line| line.split(',').nth(7) == Some("30")).unwrap().to_string();
        assert!(table.lines().next().unwrap().ends_with("theta_band_deg") && row.ends_with(",2.5"), "{row}");
        row
    };
    let alone = row_at_30("30");
    assert_eq!(alone, row_at_30("5:90:5"));
    assert_eq!(alone, row_at_30("29,30,31,33.5"));
    let document = folder.type_in(&format!("{line} --theta 30 --theta-band 10 --json -q")).done().json();
    assert_eq!(document["real_cities"][0]["theta_band_deg"], 10.0);
    assert_ne!(document["rows"][0]["p_los"].to_string(), alone.split(',').nth(13).unwrap());
    check_refusals(&folder, line, &[("--theta 30 --theta-band 0", "E113", "`0`")]);
}

/// P_LoS by the product at elevation angles within a band, each weighted by the users there: on flat ground their number per
/// angle grows as the area of the ring.
fn product_over_band(city: &str, height_m: f64, (low, high): (f64, f64)) -> f64 {
    let rise = height_m - 1.5;
    let distance = |theta: f64| rise / theta.to_radians().tan();
    let (near, far) = (distance(high), distance(low));
    let n = 40;
    let mut sum = 0.0;
    for k in 0..n {
        // Rings of equal area.
        let share = (f64::from(k) + 0.5) / f64::from(n);
        let r = (near * near + share * (far * far - near * near)).sqrt();
        let reach = Setting::reach_at_distance(r, height_m, 1.5).unwrap();
        let asked = Setting { rx_height_m: 1.5, reach, ..at_height(city, 90.0, height_m) };
        sum += product(&asked, 1 << 8).p_los.unwrap();
    }
    sum / f64::from(n)
}

#[test]
fn over_a_generated_city_in_a_file_angles_agree_with_the_product_over_their_bands() {
    let folder = Folder::new();
    let n_cities = if is_long() { 8 } else { 2 };
    for seed in 1..=n_cities {
        let line = format!("city itu:urban --size 1500 --cell 3 --seed {seed} -o c.geojson -q --overwrite");
        folder.type_in(&line).done();
        let line = "plos c.geojson --method maps --cell 3 --height 100 --positions 60 --theta 20,40,60 --json -q";
        let document = folder.type_in(line).done().json();
        for row in document["rows"].as_array().unwrap() {
            let theta = row["theta_deg"].as_f64().unwrap();
            let (p, error) = (row["p_los"].as_f64().unwrap(), row["std_error"].as_f64().unwrap());
            let wanted = product_over_band("urban", 100.0, (theta - 2.5, theta + 2.5));
            assert!((p - wanted).abs() <= 4.0 * error + 0.005, "seed {seed}, {theta}°: {p} ± {error}, wanted {wanted}");
        }
    }
}

#[test]
fn a_sample_within_a_radius_is_over_whole_discs() {
    let folder = Folder::new();
    let n_cities = if is_long() { 100 } else { 12 };
    let cities = ["suburban", "urban", "dense-urban", "high-rise", "ghent"];
    let radii = [50.0, 100.0, 200.0, 300.0];
    let all = cities.iter().flat_map(|city| radii.map(|radius_m| (*city, radius_m)));
    let cases: Vec<(&str, f64)> = if is_long() { all.collect() } else { vec![("suburban", 300.0), ("urban", 100.0)] };
    // How far each row is off, in standard errors.
    let mut deviations = Vec::new();
    let placements = [
        ("crossroad", Placement::CrossroadCenter),
        ("street", Placement::StreetCenter),
        ("rooftop", Placement::RooftopCenter),
    ];
    for (name, radius_m) in cases {
        let ground = match is_long() {
            true if radius_m < 200.0 => "--size 1000 --zones crossroad:100,street:100,rooftop:100",
            true => "--size 600 --zones crossroad:100,street:100,rooftop:100",
            false => "--size 150 --zones crossroad:6,street:6,rooftop:6",
        };
        let line = format!(
            "sample itu:{name} {ground} --centers --height 100 --radius {radius_m} --cities {n_cities} --seed 1001 --json -q"
        );
        let document = folder.type_in(&line).done().json();
        for (zone, placement) in placements {
            let rows = document["rows"].as_array().unwrap();
            let row = rows.iter().find(|r| r["placement"] == zone && r["receivers_zone"] == "all").unwrap();
            let wanted = product(&within(name, radius_m, 100.0, placement), 1 << 10);
            let (p, error) = (row["p_los"].as_f64().unwrap(), row["std_error"].as_f64().unwrap());
            let error = error.hypot(wanted.std_error.unwrap());
            let wanted = wanted.p_los.unwrap();
            assert!((p - wanted).abs() <= 4.5 * error, "{name}, {zone}, {radius_m} m: {p} ± {error}, {wanted}");
            deviations.push((p - wanted).abs() / error);
        }
    }
    // Of 60 rows 0.2 are more than three standard errors off by chance.
    let beyond = deviations.iter().filter(|d| **d > 3.0).count();
    assert!(beyond <= 2, "{beyond} of {} rows are more than 3 standard errors off", deviations.len());
}

#[test]
fn a_sample_in_a_file_leaves_out_discs_that_are_cut() {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 400 --seed 3 -o c.geojson -q").done();
    let line = "sample c.geojson --zones street:30 --height 80 --radius 60";
    let document = folder.type_in(&format!("{line} --json")).done().json();
    let row = &document["rows"][0];
    assert_eq!((&row["placements"], row["disc_cut"].as_u64().unwrap() > 0), (&json!(30), true), "{row}");
    assert!(document["discs"].as_str().unwrap().starts_with("whole"), "{document}");
    // `plos` over discs takes whole ones too.
    town(&folder);
    let too_wide = [
        ("sample c.geojson --zones street:5 --height 80 --radius 500", "E216", ""),
        ("plos town.geojson --method maps --height 80 --positions 10 --radius 500", "E216", ""),
    ];
    check_refusals(&folder, "", &too_wide);
    let line = "plos c.geojson --method maps --height 80 --positions 10 --radius 20,60 --json -q";
    let document = folder.type_in(line).done().json();
    assert!(document["real_cities"][0]["positions_with_cut_discs"].as_u64().unwrap() > 0, "{document}");
}
