//! Where the data end, and what a share is a share of: known ground, missing heights, whole discs, bands of angles, goals
//! within a radius.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use serde_json::{Value, json};
use skyshed::los_probability::product::Product;
use skyshed::los_probability::setting::{Placement, Setting, Users};
use skyshed::scene::BuiltUp;

use crate::program::Folder;
use crate::support::slow;

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
fn town(folder: &Folder) {
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
        let document = folder.type_in(&format!("info town.geojson {rest} --zones --json")).done().json();
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
    let answer = folder.type_in("map itu:urban --data-area all --uav 5,5,50 --json");
    let lines = answer.refused(2);
    assert!(lines[0].contains("`--data-area` has no meaning for a generated city"), "{lines:?}");
    // A lone building says nothing of a city: all is known, and a warning says so.
    write_city(&folder, "lone.geojson", &[building(&json!({"height": 9}), [0.0, 0.0, 30.0, 30.0])]);
    let document = folder.type_in("info lone.geojson --json").done().json();
    assert_eq!(document["cells"]["nodata"], 0, "{document}");
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
fn missing_heights_are_refused_above_two_percent_of_the_area() {
    let folder = Folder::new();
    let with = |n_missing: u8| {
        let features: Vec<Value> = (0..100_u8)
            .map(|k| {
                let x = 20.0 * f64::from(k);
                let properties = match k < n_missing {
                    true => {
                        json!({"name": "x", "building:levels": if k % 2 == 0 { Value::from(4) } else { Value::Null }})
                    }
                    false => json!({"height": 10.0 + f64::from(k % 3)}),
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
    let lines = folder.type_in("map c.geojson --uav 995,50,30 --json").refused(3).join("\n");
    assert!(
        lines.contains("error[E309]") && lines.contains("3 of 100 footprints, 3.0 % of the footprint area"),
        "{lines}"
    );
    // What each policy would do here.
    assert!(
        lines.contains("`levels` gives 2 of them")
            && lines.contains("leaves 1 out")
            && lines.contains("`median` gives them 11 m"),
        "{lines}"
    );
    for policy in ["drop", "levels", "median"] {
        folder.type_in(&format!("map c.geojson --uav 995,50,30 --json --missing {policy}")).done();
    }
    // `info` tells what is wrong.
    assert_eq!(folder.type_in("info c.geojson --json").done().json()["faults"]["missing_height"], 3);
    let lines = folder.type_in("map c.geojson --uav 995,50,30 --json --height-field heihgt").refused(3).join("\n");
    assert!(lines.contains("error[E365]") && lines.contains("`height`"), "{lines}");
}

#[test]
fn p_los_at_an_angle_does_not_depend_on_the_other_angles() {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 500 --seed 5 -o c.geojson -q").done();
    let rows = |theta: &str| {
        let line = format!("plos c.geojson --method maps --height 80 --positions 20 --theta {theta} --csv -");
        let line = line.replace(" --csv -", " -o t.csv --overwrite -q");
        folder.type_in(&line).done();
        let table = folder.text("t.csv");
        let row = table.lines().find(|line| line.split(',').nth(7) == Some("30")).unwrap().to_string();
        assert!(table.lines().next().unwrap().ends_with("theta_band_deg") && row.ends_with(",2.5"), "{row}");
        row
    };
    let alone = rows("30");
    assert_eq!(alone, rows("5:90:5"));
    assert_eq!(alone, rows("29,30,31,33.5"));
    let wide =
        folder.type_in("plos c.geojson --method maps --height 80 --positions 20 --theta 30 --theta-band 10 --json -q");
    let document = wide.done().json();
    assert_eq!(document["real_cities"][0]["theta_band_deg"], 10.0);
    assert_ne!(document["rows"][0]["p_los"].to_string(), alone.split(',').nth(13).unwrap());
    folder.type_in("plos c.geojson --method maps --theta 30 --theta-band 0").refused(2);
}

/// P_LoS by the product at elevation angles within a band, each weighted by the users there: on flat ground their number per
/// angle grows as the area of the ring.
fn product_over_band(built_up: BuiltUp, height_m: f64, (low, high): (f64, f64)) -> f64 {
    let rise = height_m - 1.5;
    let distance = |theta: f64| rise / theta.to_radians().tan();
    let (near, far) = (distance(high), distance(low));
    let n = 40;
    let mut sum = 0.0;
    for k in 0..n {
        // Rings of equal area.
        let share = (f64::from(k) + 0.5) / f64::from(n);
        let r = (near * near + share * (far * far - near * near)).sqrt();
        let mut product = Product::new(
            Setting {
                built_up,
                uav_height_m: height_m,
                rx_height_m: 1.5,
                reach: Setting::reach_at_distance(r, height_m, 1.5).unwrap(),
                phi_deg: None,
                users: Users::Outdoor,
                placement: Placement::Anywhere,
                uav_clear_of_roof: false,
            },
            11,
        );
        product.add_points(1 << 8);
        sum += product.estimate(0.95).p_los.unwrap();
    }
    sum / f64::from(n)
}

#[test]
fn over_a_generated_city_in_a_file_angles_agree_with_the_product_over_their_bands() {
    let folder = Folder::new();
    let built_up = BuiltUp::named("urban").unwrap();
    let n_cities = if slow() { 8 } else { 2 };
    for seed in 1..=n_cities {
        let line = format!("city itu:urban --size 1500 --cell 3 --seed {seed} -o c.geojson -q --overwrite");
        folder.type_in(&line).done();
        let line = "plos c.geojson --method maps --cell 3 --height 100 --positions 60 --theta 20,40,60 --json -q";
        let document = folder.type_in(line).done().json();
        for row in document["rows"].as_array().unwrap() {
            let theta = row["theta_deg"].as_f64().unwrap();
            let (p, error) = (row["p_los"].as_f64().unwrap(), row["std_error"].as_f64().unwrap());
            let wanted = product_over_band(built_up, 100.0, (theta - 2.5, theta + 2.5));
            assert!((p - wanted).abs() <= 4.0 * error + 0.005, "seed {seed}, {theta}°: {p} ± {error}, wanted {wanted}");
        }
    }
}

#[test]
fn a_sample_within_a_radius_is_over_whole_discs() {
    let folder = Folder::new();
    let n_cities = if slow() { 100 } else { 12 };
    let cities = ["suburban", "urban", "dense-urban", "high-rise", "ghent"];
    let radii = [50.0, 100.0, 200.0, 300.0];
    let all = cities.iter().flat_map(|city| radii.map(|radius_m| (*city, radius_m)));
    let cases: Vec<(&str, f64)> = if slow() { all.collect() } else { vec![("suburban", 300.0), ("urban", 100.0)] };
    // How far each row is off, in standard errors.
    let mut deviations = Vec::new();
    let placements = [
        ("crossroad", Placement::CrossroadCenter),
        ("street", Placement::StreetCenter),
        ("rooftop", Placement::RooftopCenter),
    ];
    for (name, radius_m) in cases {
        // Streets of Ghent are a few cells wide: cells of 1 m would be off by as much as a hundred cities.
        let ground = match (slow(), name) {
            (true, "ghent") if radius_m < 200.0 => "--size 200 --cell 0.25 --sample crossroad:60,street:60,rooftop:60",
            (true, _) if radius_m < 200.0 => "--size 1000 --sample crossroad:100,street:100,rooftop:100",
            (true, _) => "--size 600 --sample crossroad:100,street:100,rooftop:100",
            (false, _) => "--size 150 --sample crossroad:6,street:6,rooftop:6",
        };
        let line = format!(
            "place itu:{name} {ground} --centers --height 100 --radius {radius_m} --cities {n_cities} --seed 1001 --json -q"
        );
        let document = folder.type_in(&line).done().json();
        for (zone, placement) in placements {
            let row = document["rows"]
                .as_array()
                .unwrap()
                .iter()
                .find(|r| r["placement"] == zone && r["receivers_zone"] == "all")
                .unwrap();
            let mut product = Product::new(
                Setting {
                    built_up: BuiltUp::named(name).unwrap(),
                    uav_height_m: 100.0,
                    rx_height_m: 1.5,
                    reach: Setting::reach_within(radius_m, 100.0, 1.5).unwrap(),
                    phi_deg: None,
                    users: Users::Outdoor,
                    placement,
                    uav_clear_of_roof: true,
                },
                7,
            );
            product.add_points(1 << 10);
            let wanted = product.estimate(0.95);
            let (p, error) = (row["p_los"].as_f64().unwrap(), row["std_error"].as_f64().unwrap());
            let error = error.hypot(wanted.std_error.unwrap());
            let wanted = wanted.p_los.unwrap();
            assert!((p - wanted).abs() <= 4.0 * error, "{name}, {zone}, {radius_m} m: {p} ± {error}, {wanted}");
            deviations.push((p - wanted).abs() / error);
        }
    }
    let beyond = deviations.iter().filter(|d| **d > 2.0).count();
    assert!(
        beyond * 20 <= deviations.len(),
        "{beyond} of {} rows are more than 2 standard errors off",
        deviations.len()
    );
}

#[test]
fn a_sample_in_a_file_leaves_out_discs_that_are_cut() {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 400 --seed 3 -o c.geojson -q").done();
    let line = "place c.geojson --sample street:30 --height 80 --radius 60";
    let document = folder.type_in(&format!("{line} --json")).done().json();
    let row = &document["rows"][0];
    assert_eq!((&row["placements"], row["disc_cut"].as_u64().unwrap() > 0), (&json!(30), true), "{row}");
    assert!(document["discs"].as_str().unwrap().starts_with("whole"), "{document}");
    let lines = folder.type_in("place c.geojson --sample street:5 --height 80 --radius 500").refused(4).join("\n");
    assert!(lines.contains("error[E216]") && lines.contains("smaller `--radius`"), "{lines}");
    // `plos` over discs takes whole ones too.
    let line = "plos c.geojson --method maps --height 80 --positions 10 --radius 20,60 --json -q";
    let document = folder.type_in(line).done().json();
    assert!(document["real_cities"][0]["positions_with_cut_discs"].as_u64().unwrap() > 0, "{document}");
}
