//! What the program tells of heights that may be off: intervals, layers, comparisons, searches and limits.

use crate::program::Folder;

/// Two streets between three rows of houses, as GeoJSON.
fn write_houses(folder: &Folder) {
    let house = |(x, y, w, d, h): (i32, i32, i32, i32, i32)| {
        format!(
            r#"{{"type":"Feature","properties":{{"height":{h},"sd":{},"id":"h{x}-{y}"}},"geometry":{{"type":"Polygon","coordinates":[[[{x},{y}],[{},{y}],[{},{}],[{x},{}],[{x},{y}]]]}}}}"#,
            f64::from(h - 12) / 4.0,
            x + w,
            x + w,
            y + d,
            y + d
        )
    };
    let rows = (0..12).map(|k| house((10 + k % 4 * 25, 10 + k / 4 * 35, 20, 20, 12 + k)));
    let text = format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, rows.collect::<Vec<_>>().join(","));
    std::fs::write(folder.join("houses.geojson"), text).unwrap();
}

#[test]
fn maps_tell_what_hangs_on_heights() {
    let folder = Folder::new();
    write_houses(&folder);
    let map = "map houses.geojson --uav 60,60,40";
    let asked = format!("{map} --height-error 1.5 --height-bias 0.5 --layers los,sure,p-los -o all.tif --json");
    let found = folder.type_in(&asked).done().json();
    assert_eq!(found["height_errors"]["own_m"], 1.5);
    assert_eq!(found["height_errors"]["draws"], 200);
    let (site, p) = (&found["sites"][0], found["sites"][0]["p_los"].as_f64().unwrap());
    let of = |name: &str| site["uncertain"][name].as_f64().unwrap();
    assert!(of("p_los_low") < p && p < of("p_los_high"), "{site}");
    assert!(of("p_los_low") < of("p_los_mean") && of("p_los_mean") < of("p_los_high"), "{site}");
    let sure = &site["uncertain"]["sure"];
    let count = |name: &str| sure[name].as_u64().unwrap();
    assert_eq!(count("never") + count("surely") + count("possibly"), site["receivers"].as_u64().unwrap());
    assert!(count("possibly") > 100 && count("surely") < site["los"].as_u64().unwrap());
    // Without errors the layers are the mask, and nothing is said of them.
    let exact = folder.type_in(&format!("{map} --layers sure,p-los -o exact.npz --json")).done().json();
    let none = &exact["sites"][0]["uncertain"];
    assert_eq!((&none["sure"]["possibly"], &exact["height_errors"]), (&0.into(), &serde_json::Value::Null));
    assert!((none["p_los_mean"].as_f64().unwrap() - p).abs() < 1e-12);
    assert_eq!(exact["digest"], found["digest"]);
    // The table has the interval, and only where heights may be off.
    let header = |words: &str| folder.type_in(words).done().out.lines().next().unwrap().to_string();
    assert!(header(&format!("{map} --height-error 1")).contains("p_los,p_los_low,p_los_high,"));
    assert!(!header(map).contains("p_los_low"));

    folder.refuses(&format!("{map} --height-error -1"), "E113", &["error of heights", "-1"]);
    folder.refuses(&format!("{map} --height-bias nan"), "E101", &["nan"]);
    folder.refuses(&format!("{map} --height-error 1 --sigma 3"), "E116", &["--sigma", "sure"]);
    folder.refuses(
        &format!("{map} --height-error 1 --layers count -o {{row}}-{{col}}.tif"),
        "E116",
        &["--height-error"],
    );
}

#[test]
fn rasters_have_intervals_and_no_probabilities() {
    let folder = Folder::new();
    write_houses(&folder);
    folder.type_in("city houses.geojson -o dsm.tif").done();
    let map = "map dsm.tif --ground 0 --uav 60,60,40 --height-error 1";
    let found = folder.type_in(&format!("{map} --layers sure -o sure.tif --json")).done().json();
    let site = &found["sites"][0];
    let (low, high) = (&site["uncertain"]["p_los_low"], &site["uncertain"]["p_los_high"]);
    assert!(
        low.as_f64().unwrap() < high.as_f64().unwrap() && site["uncertain"]["sure"]["possibly"].as_u64() > Some(100)
    );
    folder.refuses(&format!("{map} --layers p-los -o p.tif"), "E118", &["raster", "not told apart"]);
    folder.refuses(&format!("{map} --strips -o s.tif"), "E501", &["errors of heights"]);
}

#[test]
fn comparisons_and_searches_say_what_heights_explain() {
    let folder = Folder::new();
    write_houses(&folder);
    // A street apart, and far apart in height.
    let compare = "compare houses.geojson --uav 60,60,40 --uav 80,60,40 --uav 60,60,200 --height-error 2";
    let ran = folder.type_in(&format!("{compare} -o c.json -o c.csv")).done();
    assert!(ran.err.contains("smaller than errors of heights allow") && ran.err.contains("larger than errors"));
    let found = folder.json("c.json");
    let exceeds = |k: usize| found["pairs"][k]["exceeds_heights"].as_bool().unwrap();
    assert_eq!([exceeds(0), exceeds(1), exceeds(2)], [false, true, true]);
    for pair in found["pairs"].as_array().unwrap() {
        let number = |name: &str| pair[name].as_f64().unwrap();
        assert!(number("heights_low") <= number("heights_high"), "{pair}");
    }
    let ran = folder.type_in("place houses.geojson --height 40 --step 8 --height-error 2 -o p.json").done();
    assert!(ran.err.contains("may be as good"), "{}", ran.err);
    let ranked = folder.json("p.json")["ranked"].as_array().unwrap().clone();
    assert!(ranked[0].get("exceeds_heights").is_none() && ranked[1]["exceeds_heights"].is_boolean());
    folder.refuses("place houses.geojson --height 40 -k 2 --height-error 2", "E116", &["--height-error"]);
    folder.refuses("place houses.geojson --height 40 --goal margin --height-bias 2", "E116", &["--height-bias"]);
}

#[test]
fn limits_name_the_roofs_to_measure() {
    let folder = Folder::new();
    write_houses(&folder);
    let found = folder.type_in("limits houses.geojson --uav 60,60,40 --height-error 2 --json").done().json();
    let heights = &found["heights"];
    let buildings = heights["buildings"].as_array().unwrap();
    assert!(!buildings.is_empty() && buildings.len() <= 12);
    let n: Vec<u64> = buildings.iter().map(|building| building["receivers"].as_u64().unwrap()).collect();
    assert!(n.is_sorted_by(|a, b| a >= b) && n[0] <= heights["possibly"].as_u64().unwrap(), "{heights}");
    let text = folder.type_in("limits houses.geojson --uav 60,60,40").done().out;
    assert!(text.contains("roofs to measure first: ") && text.contains("typically off by"), "{text}");
}

#[test]
fn buildings_tell_their_own_errors() {
    let folder = Folder::new();
    write_houses(&folder);
    let map = "map houses.geojson --uav 60,60,40 --layers p-los -o p.tif --overwrite --json";
    let of = |more: &str| folder.type_in(&format!("{map} {more}")).done().json();
    let own = of("--height-error-field sd");
    assert_eq!((&own["height_errors"]["by_building"], &own["height_errors"]["own_m"]), (&true.into(), &0.0.into()));
    let interval = |found: &serde_json::Value| {
        let of = |name: &str| found["sites"][0]["uncertain"][name].as_f64().unwrap();
        of("p_los_high") - of("p_los_low")
    };
    // Errors of 0 to 2.75 m, as the file tells them.
    assert!(interval(&own) > 0.0 && interval(&own) < interval(&of("--height-error 2.75")));
    // What a footprint does not tell is that of all.
    let text = std::fs::read_to_string(folder.join("houses.geojson")).unwrap();
    std::fs::write(folder.join("houses.geojson"), text.replace("\"sd\":1.25", "\"sd\":null")).unwrap();
    assert_ne!(of("--height-error-field sd")["sites"], own["sites"]);
    assert_eq!(of("--height-error-field sd --height-error 1.25")["sites"], own["sites"]);
    folder.refuses(&format!("{map} --height-error-field error"), "E365", &["`error`", "errors of heights"]);
    std::fs::write(folder.join("houses.geojson"), text.replace("\"sd\":2.5,", "\"sd\":-2.5,")).unwrap();
    folder.refuses(&format!("{map} --height-error-field sd"), "E365", &["-2.5", "0 m to 1000 m"]);
    folder.refuses("info houses.geojson --height-error-field sd", "E116", &["--height-error-field", "compare"]);
}
