//! `skyshed plos` from outside: tables, documents, plots, its flags, and what it refuses.

use std::collections::HashMap;

use serde_json::Value;

use crate::program::Folder;

/// Two small blocks and a tower, so that every kind of real-city output exists.
const CITY: &str = r#"{"type": "FeatureCollection", "attribution": "drawn by hand", "features": [
  {"type": "Feature", "properties": {"height": 20, "tall": 25, "z_top": 18, "z_ground": 0},
   "geometry": {"type": "Polygon", "coordinates": [[[20,20],[60,20],[60,60],[20,60],[20,20]]]}},
  {"type": "Feature", "properties": {"height": 12, "tall": 5, "z_top": 30, "z_ground": 0},
   "geometry": {"type": "Polygon", "coordinates": [[[90,20],[130,20],[130,60],[90,60],[90,20]]]}},
  {"type": "Feature", "properties": {"height": 50, "tall": 60, "z_top": 50, "z_ground": 0},
   "geometry": {"type": "Polygon", "coordinates": [[[20,90],[60,90],[60,130],[20,130],[20,90]]]}},
  {"type": "Feature", "properties": {"building:levels": 5},
   "geometry": {"type": "Polygon", "coordinates": [[[121,121],[130,121],[130,130],[121,130],[121,121]]]}}]}"#;

const HEADER: &str = "city,alpha,beta_per_km2,gamma_m,method,height_m,rx_height_m,theta_deg,phi_deg,distance_m,placement,\
                      users,uav_in_building,p_los,ci_low,ci_high,std_error,samples,clusters";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("city.geojson", CITY);
    folder.write("curve.csv", "theta_deg,p_los\n0,0\n90,1\n");
    let surface = |cell: usize| match (cell / 40, cell % 40) {
        (8..16, 8..16) => "30",
        (20..24, 4..36) => "0.5",
        (30, 30) => "-9999",
        _ => "0",
    };
    let head = "ncols 40\nnrows 40\nxllcorner 0\nyllcorner 0\ncellsize 5\nNODATA_value -9999\n";
    let cells: Vec<&str> = (0..40 * 40).map(surface).collect();
    folder.write("dsm.asc", &format!("{head}{}\n", cells.join(" ")));
    folder.write("flat.asc", &format!("{head}{}\n", ["1"; 40 * 40].join(" ")));
    folder
}

/// A table as maps from column to text.
fn table(text: &str) -> Vec<HashMap<String, String>> {
    csv::Reader::from_reader(text.as_bytes()).deserialize().map(|row| row.unwrap()).collect()
}

fn document(folder: &Folder, line: &str) -> Value {
    folder.type_in(&format!("plos {line} --json")).done().json()
}

fn methods(document: &Value) -> Vec<&str> {
    document["methods"].as_array().unwrap().iter().map(|m| m["id"].as_str().unwrap()).collect()
}

#[test]
fn without_outputs_the_table_is_the_answer() {
    let folder = folder();
    let answer = folder.type_in("plos itu:urban --theta 20:60:20 --method product,itu").done();
    assert!(answer.out.starts_with(HEADER), "{}", answer.out);
    let rows = table(&answer.out);
    assert_eq!(rows.len(), 6);
    let thetas: Vec<&str> = rows.iter().map(|r| r["theta_deg"].as_str()).collect();
    assert_eq!(thetas, ["20", "40", "60", "20", "40", "60"]);
    for row in &rows[..3] {
        let number = |column: &str| row[column].parse::<f64>().unwrap();
        assert_eq!(row["method"], "product");
        assert!(number("ci_low") < number("p_los") && number("p_los") < number("ci_high"), "{row:?}");
        assert!(number("ci_high") - number("ci_low") <= 0.002 && number("clusters") >= 10.0);
        assert_eq!((row["placement"].as_str(), row["users"].as_str()), ("anywhere", "outdoor"));
        assert_eq!((row["uav_in_building"].as_str(), row["rx_height_m"].as_str()), ("nlos", "1.5"));
    }
    for row in &rows[3..] {
        assert_eq!(row["method"], "itu");
        assert!(["placement", "ci_low", "std_error", "samples"].iter().all(|c| row[*c].is_empty()), "{row:?}");
    }
    assert!(folder.files().iter().all(|f| !f.ends_with(".part")));
}

#[test]
fn every_format_holds_the_same_values() {
    let folder = folder();
    let line = "itu:urban itu:ghent --theta 10:80:10 --method product,city,geometry,kang2019 --cities 40 \
                -o a.csv -o a.json -o a.npz -o a.png -o a.svg --csv b.csv";
    folder.type_in(&format!("plos {line}")).done();
    assert_eq!(folder.text("a.csv"), folder.text("b.csv"));
    let rows = table(&folder.text("a.csv"));
    assert_eq!(rows.len(), 2 * 4 * 8);
    let document = folder.json("a.json");
    assert_eq!(document["schema"], "skyshed/plos/1");
    assert_eq!(document["digest"], folder.json("a.csv.json")["digest"]);
    let of_document = document["rows"].as_array().unwrap();
    assert_eq!(of_document.len(), rows.len());
    for (row, object) in rows.iter().zip(of_document) {
        assert_eq!(row["p_los"].parse::<f64>().ok(), object["p_los"].as_f64());
        assert_eq!(row["ci_low"].parse::<f64>().ok(), object["ci_low"].as_f64());
        assert_eq!(row["city"], object["city"].as_str().unwrap());
    }
    // Pictures know where they come from, and name what they show.
    let svg = folder.text("a.svg");
    for words in ["Product over buildings", "3-D city simulator", "Kang 2019", "Ghent", "Urban", "receivers 1.5"] {
        assert!(svg.to_lowercase().contains(&words.to_lowercase()), "{words}");
    }
    let png = folder.read("a.png");
    assert!(png.windows(14).any(|w| w == b"skyshed/plos/1"), "provenance in the picture");
    // The archive has an array per column.
    let npz = folder.read("a.npz");
    for name in ["p_los.npy", "theta_deg.npy", "method.npy", "city.npy", "ci_high.npy", "provenance.npy"] {
        assert!(npz.windows(name.len()).any(|w| w == name.as_bytes()), "{name}");
    }
}

#[test]
fn equal_runs_give_equal_files_on_any_number_of_threads() {
    let folder = folder();
    let maps = "city.geojson --cell 5 --block 20 --positions 15 --theta 15:75:15 --method maps";
    let cities = "itu:dense-urban --theta 15:75:15 --method all --cities 30";
    for threads in [1, 2, 5] {
        folder.type_in(&format!("plos {maps} -j {threads} -o t{threads}.csv")).done();
        folder.type_in(&format!("plos {cities} -j {threads} -o gt{threads}.csv")).done();
    }
    for name in ["t2.csv", "t5.csv"] {
        assert_eq!(folder.text("t1.csv"), folder.text(name));
        assert_eq!(folder.text("gt1.csv"), folder.text(&format!("g{name}")));
    }
}

#[test]
fn until_stops_when_intervals_are_narrow_enough() {
    let folder = folder();
    for method in ["product", "city", "geometry"] {
        let wide = document(&folder, &format!("itu:urban --theta 30,60 --method {method} --until ±0.03"));
        let narrow = document(&folder, &format!("itu:urban --theta 30,60 --method {method} --until 0.01"));
        let samples = |d: &Value| d["rows"][0]["samples"].as_u64().unwrap();
        assert!(samples(&narrow) >= samples(&wide), "{method}");
        for row in narrow["rows"].as_array().unwrap() {
            let reach = (row["ci_high"].as_f64().unwrap() - row["ci_low"].as_f64().unwrap()) / 2.0;
            assert!(reach <= 0.01, "{method}: ±{reach}");
        }
        if method != "product" {
            assert!(samples(&narrow) > 2 * samples(&wide), "{method}: nothing more was drawn");
        }
    }
}

#[test]
fn too_few_clusters_leave_no_interval() {
    let folder = folder();
    let answer = folder.type_in("plos itu:urban --theta 45 --method city --cities 9").done();
    assert_eq!(answer.warnings(), ["W213"]);
    let row = &table(&answer.out)[0];
    assert_eq!((row["ci_low"].as_str(), row["std_error"].as_str(), row["clusters"].as_str()), ("n/a", "n/a", "9"));
    assert!(row["p_los"].parse::<f64>().is_ok());
    let row = document(&folder, "itu:urban --theta 45 --method city --cities 9 -q")["rows"][0].clone();
    assert!(row["ci_low"].is_null() && row["reason"].as_str().unwrap().contains("at least 10"), "{row}");
}

#[test]
fn a_place_without_users_has_no_p_los() {
    let folder = folder();
    let line = "plos itu:urban --theta 90 --placement rooftop --method product,city,geometry --json";
    let answer = folder.type_in(line).done();
    assert_eq!(answer.warnings(), ["W202"]);
    for row in answer.json()["rows"].as_array().unwrap() {
        assert!(row["p_los"].is_null() && row["reason"] == "no user is there", "{row}");
    }
}

#[test]
fn a_real_city_is_mapped_and_the_city_that_fits_it_laid_over() {
    let folder = folder();
    let line = "city.geojson --cell 2 --theta 10:80:10 --positions 40 --block 20 --height 80 --missing levels";
    folder.type_in(&format!("plos {line} -o p.json -o p.svg -o p.png")).done();
    let document = folder.json("p.json");
    let fit = &document["real_cities"][0]["fit"];
    // γ² = ΣH²/(2n) of 20, 12, 50 and 15 m.
    let gamma = ((400.0 + 144.0 + 2500.0 + 225.0) / 8.0_f64).sqrt();
    assert!((fit["gamma_m"].as_f64().unwrap() - gamma).abs() < 1e-9, "{fit}");
    assert_eq!(fit["buildings"], 4);
    assert_eq!(methods(&document), ["maps", "product"]);
    let svg = folder.text("p.svg");
    for words in ["Rayleigh, most likely", "Building heights", "drawn by hand", "(estimated)"] {
        assert!(svg.contains(words), "{words}");
    }
    // Where a UAV cannot be inside a building, more is seen.
    let low = |flag: &str| {
        let line = format!("city.geojson --cell 2 --theta 20 --positions 60 --height 10 --method maps {flag}");
        self::document(&folder, &line)["rows"][0]["p_los"].as_f64().unwrap()
    };
    assert!(low("--uav-clear-of-roof") > low(""), "UAVs inside buildings see nothing");
}

#[test]
fn users_and_uavs_of_a_real_city_are_told_apart_by_zone() {
    let folder = folder();
    folder.type_in("city itu:urban --size 300 -o grid.geojson").done();
    let line = "grid.geojson --cell 2 --method maps --radius 50,100 --height 40 --positions 40 --block 50";
    let document = document(&folder, &format!("{line} --users outdoor,street,crossroad --placement street,crossroad"));
    let rows = document["rows"].as_array().unwrap();
    for placement in ["street", "crossroad"] {
        for radius in [50.0, 100.0] {
            let of = |users: &str| {
                let is_it = |r: &&Value| {
                    (r["users"].as_str(), r["placement"].as_str(), r["radius_m"].as_f64())
                        == (Some(users), Some(placement), Some(radius))
                };
                let row = rows.iter().find(is_it).unwrap();
                let samples = row["samples"].as_f64().unwrap();
                (samples, (samples * row["p_los"].as_f64().unwrap()).round())
            };
            let (outdoor, street, crossroad) = (of("outdoor"), of("street"), of("crossroad"));
            assert!(street.0 > 1000.0 && crossroad.0 > 1000.0 && street.1 > 0.0);
            assert_eq!(outdoor, (street.0 + crossroad.0, street.1 + crossroad.1), "{placement} within {radius} m");
        }
    }
    // Around a single building no streets meet.
    let house = r#"{"type": "Feature", "properties": {"height": 9},
        "geometry": {"type": "Polygon", "coordinates": [[[5,5],[15,5],[15,15],[5,15],[5,5]]]}}"#;
    folder.write("house.geojson", house);
    let line = "plos house.geojson --extent 0,0,20,20 --users crossroad --theta 40 --method maps";
    folder.refuses(line, "E204", &["crossroad"]);
}

#[test]
fn a_raster_has_maps_but_no_city_that_fits() {
    let folder = folder();
    let line = "plos dsm.asc --ground 0 --theta 20:80:20 --positions 12 --block 40 --height 60";
    let answer = folder.type_in(&format!("{line} --json")).done();
    assert!(answer.warnings().contains(&"W210"), "{answer:?}");
    let document = answer.json();
    assert!(document["rows"].as_array().unwrap().iter().all(|r| r["method"] == "maps"));
    folder.refuses(&format!("{line} --method product"), "E122", &["`product`"]);
}

/// Studies, and what each changes their digests.
const FLAGS: [(&str, &str); 17] = [
    ("itu:urban --phi 45", "--theta 40"),
    ("itu:urban", "--distance 50:200:50; --radius 50,100"),
    (
        "itu:urban --theta 30",
        "--phi 30; --height 40; --alpha 0.2; --beta 300; --gamma 30; --rx-height 0; --seed 2; itu:ghent",
    ),
    (
        "itu:urban --theta 30",
        "--users crossroad; --users street; --placement rooftop; --curve mine=curve.csv; --ci 0.99",
    ),
    ("itu:urban --theta 30", "--method geometry"),
    ("itu:high-rise --theta 30", "--uav-clear-of-roof"),
    ("itu:urban --theta 30 --method geometry", "--until 0.02; --links 3000"),
    ("itu:urban --theta 30 --method city", "--cities 20; --users-per-city 90"),
    ("CITY --cell 5 --block 30", "--positions 20; --extent 0,0,150,150; --theta-band 9; --data-area all"),
    ("CITY --cell 5 --block 30", "--missing levels; --height-unit ft; --height-field tall; --top-field z_top"),
    ("CITY --cell 5", "--block 20"),
    ("CITY --block 30", "--cell 5"),
    ("CITY --cell 5 --block 30 --top-field z_top", "--ground 3"),
    ("CITY --block 30 --top-field z_top", "--terrain flat.asc"),
    ("dsm.asc --ground 0 --theta 10 --height 20 --block 30", "--building-threshold 0.7; --rx-height 9"),
    ("dsm.asc --ground 0 --theta 5 --height 20 --block 30", "--nodata-as block"),
    ("dsm.asc --theta 10 --height 20 --block 30", "--ground 0"),
];

#[test]
fn every_flag_changes_the_values() {
    let folder = folder();
    let digest = |line: &str| document(&folder, &format!("{line} -q"))["digest"].clone();
    for (line, flags) in FLAGS {
        let line = line.replace("CITY", "city.geojson --theta 30 --height 25");
        let without = digest(&line);
        for flag in flags.split("; ") {
            assert_ne!(without, digest(&format!("{line} {flag}")), "{line} {flag}");
        }
    }
}

/// Where UAVs may be depends on the radius, and each radius has its own.
#[test]
fn p_los_within_a_radius_does_not_depend_on_the_other_radii() {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 500 --seed 5 -o c.geojson -q").done();
    let rows = |radii: &str| {
        let line = format!("plos c.geojson --method maps --height 80 --positions 10 --cell 4 --radius {radii}");
        folder.type_in(&format!("{line} --csv t.csv --overwrite -q")).done();
        folder.text("t.csv").lines().skip(1).map(str::to_string).collect::<Vec<_>>()
    };
    let (one, other) = (rows("60"), rows("120"));
    assert_eq!(rows("60,120"), [one, other].concat());
}

#[test]
fn plots_are_chosen_by_what_is_swept() {
    let folder = folder();
    let svg = |line: &str| {
        folder.type_in(&format!("plos {line} -o p.svg --overwrite")).done();
        folder.text("p.svg").replace('\u{a0}', " ")
    };
    let heat = svg("itu:urban --theta 20:80:20 --phi 0:90:30");
    assert!(heat.contains("Azimuth φ") && heat.contains("Elevation angle θ"), "{}", &heat[..500]);
    let curves = svg("itu:urban --theta 20:80:20 --phi 0:90:30 --plot curves");
    assert!(curves.contains("φ = 30°") && !curves.contains("Azimuth φ"));
    assert!(svg("itu:urban --theta 30:60:30 --title Mine").contains("Mine"));
    folder.refuses("plos itu:urban --theta 30 --plot heat -o q.png", "E124", &["0 quantities"]);
    assert!(!folder.files().iter().any(|f| f.contains("q.png")), "{:?}", folder.files());
    // A point is enough for a plot.
    assert!(svg("itu:urban --theta 45").contains("Elevation angle"));
}

#[test]
fn bad_parameters_are_refused_with_their_range() {
    let folder = folder();
    folder.write("bad.csv", "theta_deg,p_los\n0,0\n10,1.5\n");
    for (line, code, told) in [
        ("itu:urban --theta 0", "E120", "0 < θ ≤ 90"),
        ("itu:urban --theta 90.001", "E120", "0 < θ ≤ 90"),
        ("itu:urban --theta nan", "E101", "--theta"),
        ("itu:1,500,15", "E110", "0 < α < 1"),
        ("itu:nan,500,15", "E110", "0 < α < 1"),
        ("itu:0.3,0,15", "E110", "β > 0"),
        ("itu:0.3,500,-1", "E110", "0 < γ ≤ 2048"),
        ("itu:urban --alpha 1", "E110", "0 < α < 1"),
        ("itu:urban --beta 0", "E110", "β > 0"),
        ("itu:urban --gamma 0:20:10", "E110", "0 < γ ≤ 2048"),
        ("itu:urban --height 1", "E120", "1.5 m"),
        ("itu:urban --height 40000", "E120", "32768 m"),
        ("itu:urban --rx-height -1", "E120", "at least 0 m"),
        ("itu:urban --phi 91", "E120", "0 ≤ φ ≤ 90"),
        ("itu:urban --distance -1", "E120", "at least 0 m"),
        ("itu:urban --radius 0", "E120", "above 0 m"),
        ("itu:urban --ci 1", "E120", "above 0 and below 1"),
        ("itu:urban --until 0", "E101", "above 0 and below 0.5"),
        ("itu:urban --theta 5:90", "E101", "A:B:S"),
        ("itu:urban --theta 10 --distance 5", "E101", "--distance"),
        ("itu:urban --theta 0.01", "E502", "32768 m"),
        ("itu:urban --method nothing", "E121", "`nothing`"),
        ("itu:urban --method maps", "E121", "`maps`"),
        ("itu:ghent --method alhourani2014", "E122", "`alhourani2014`"),
        ("itu:urban --size 500", "E116", "`--size`"),
        ("itu:urban --cell 2", "E116", "`--cell`"),
        ("itu:urban --theta 30 --theta-band 3", "E116", "`--theta-band`"),
        ("itu:urban --theta 30 --data-area all", "E116", "`--data-area`"),
        ("itu:urban --theta 30 --base mean", "E116", "`--base`"),
        ("itu:urban --cities 10", "E116", "`--method city`"),
        ("itu:urban --curve mine", "E123", "NAME=FILE"),
        ("itu:urban --curve itu=curve.csv", "E123", "`itu`"),
        ("itu:urban --curve mine=none.csv", "E301", "none.csv"),
        ("itu:urban --curve mine=bad.csv", "E313", "line 3"),
        ("city.geojson --gamma 5,6", "E116", "γ"),
        ("city.geojson --placement street-center", "E116", "a placement"),
        ("city.geojson --phi 30", "E116", "azimuth"),
        ("city.geojson --height 80 --radius 60 --theta-band 3", "E116", "`--theta-band`"),
        ("itu:urban --title Mine", "E116", "`--title`"),
        ("itu:urban --csv table.txt", "E105", "table.txt"),
    ] {
        folder.refuses(&format!("plos {line}"), code, &[told]);
    }
    assert!(!folder.join("table.txt").exists());
}

#[test]
fn models_without_a_value_are_left_out_or_told() {
    let folder = folder();
    let answer = folder.type_in("plos itu:ghent --theta 10:90:10 --method models --json").done();
    let document = answer.json();
    let methods = methods(&document);
    for id in ["itu", "kang2019", "mohammed2023", "tr36777_uma_av"] {
        assert!(methods.contains(&id), "{methods:?}");
    }
    for id in ["alhourani2014", "holis2008", "tr38811", "saboor2024"] {
        assert!(!methods.contains(&id), "{methods:?}");
    }
    assert!(answer.warnings().contains(&"W210"));
    assert!(document["methods"].as_array().unwrap().iter().all(|m| m["source"].as_str().is_some_and(|s| s.len() > 20)));
}
