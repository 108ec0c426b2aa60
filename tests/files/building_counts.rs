//! How files of buildings are counted and told: one number for each warning, shares, what captions and `info` say, names that formats cut.

use serde_json::{Value, json};

use crate::building_meaning::{cells, collection, n_of, rectangle};
use crate::program::Folder;

fn on(k: u32, properties: Value) -> Value {
    rectangle(&k.to_string(), [f64::from(20 * k), 0.0, f64::from(20 * k + 10), 10.0], &properties)
}

#[test]
fn heights_that_are_null_are_missing_as_those_below_0() {
    let folder = Folder::new();
    for none in [Value::Null, json!(-1), json!("")] {
        folder.write("a.geojson", &collection(&[on(0, json!({"height": none})), on(1, json!({"height": none}))]));
        folder.refuses("map a.geojson --uav 5,50,60", "E309", &["2 of 2", "`--missing 9` gives"]);
        folder.type_in("map a.geojson --uav 15,5,60 --missing drop --json").done();
        assert_eq!(n_of(&cells(&folder, "a.geojson --missing 8 --extent 0,0,40,10"), 8.0), 200);
    }
    // A property that no feature has is an error, unless the list gives each one a height.
    folder.write("b.geojson", &collection(&[on(0, json!({"building:levels": 2})), on(1, json!({"name": "x"}))]));
    for list in ["levels,drop", "levels", "levels,median", "drop"] {
        folder.refuses(&format!("info b.geojson --missing {list}"), "E365", &["`height`"]);
    }
    folder.type_in("info b.geojson --missing levels,9").done();
    folder.write("b.geojson", &collection(&[on(0, json!({"building:levels": 2})), on(1, json!({"num_floors": 3}))]));
    folder.type_in("info b.geojson --missing levels").done();
    // `null` hides no tag.
    let tagged = on(0, json!({"height": null, "tags": {"height": 33}}));
    folder.write("c.geojson", &collection(&[tagged]));
    assert_eq!(n_of(&cells(&folder, "c.geojson"), 33.0), 100);
    // Formats of columns hold such an object as text.
    let text = on(0, json!({"tags": r#"{"building": "yes", "height": "21"}"#}));
    folder.write("d.geojson", &collection(&[text]));
    assert_eq!(n_of(&cells(&folder, "d.geojson"), 21.0), 100);
}

#[test]
fn medians_are_of_buildings_whose_parts_have_heights() {
    let folder = Folder::new();
    let part = |id: &str, [w, e]: [f64; 2], height: f64| {
        rectangle(id, [w, 0.0, e, 10.0], &json!({"building:part": "yes", "height": height}))
    };
    // Of the first building the highest part counts; then 6 and 8: the lower middle is 8.
    let features = [
        rectangle("way/1", [0.0, 0.0, 40.0, 10.0], &json!({"building": "yes"})),
        part("2", [0.0, 20.0], 50.0),
        part("3", [20.0, 40.0], 30.0),
        on(3, json!({"building": "yes", "height": 6})),
        on(4, json!({"building": "yes", "height": 8})),
        on(5, json!({"building": "yes"})),
    ];
    folder.write("a.geojson", &collection(&features));
    let found = cells(&folder, "a.geojson --missing median --extent 0,0,120,10 --data-area all");
    assert_eq!((n_of(&found, 50.0), n_of(&found, 30.0), n_of(&found, 8.0)), (200, 200, 200));
    let info = folder.type_in("info a.geojson --missing median --json -q").done().json();
    assert_eq!(info["buildings"], 4);
    // What is left of an outline without a height of its own is as high as the lowest part, whatever `--missing` makes up.
    folder.write(
        "b.geojson",
        &collection(&[
            rectangle("way/1", [0.0, 0.0, 100.0, 10.0], &json!({"building": "yes", "building:levels": 2})),
            part("2", [0.0, 40.0], 50.0),
            part("3", [40.0, 80.0], 20.0),
        ]),
    );
    for list in ["9", "levels,9", "median", "drop"] {
        let found = cells(&folder, &format!("b.geojson --missing {list}"));
        assert_eq!((n_of(&found, 50.0), n_of(&found, 20.0)), (400, 600), "{list}");
    }
    // A name that nothing has leaves the part to the building around it.
    let stray =
        rectangle("2", [0.0, 0.0, 100.0, 10.0], &json!({"building:part": "yes", "building_id": "zzz", "height": 10}));
    folder.write("c.geojson", &collection(&[rectangle("1", [0.0, 0.0, 100.0, 10.0], &json!({"height": 40})), stray]));
    assert_eq!(n_of(&cells(&folder, "c.geojson"), 10.0), 1000);
}

#[test]
fn warnings_and_captions_are_of_the_typed_extent_and_give_shares() {
    let folder = Folder::new();
    let house = |k: u32| match k % 4 {
        0 => on(k, json!({"building:levels": 2})),
        1 => on(k, json!({"height": -2, "min_height": 1})),
        2 => on(k, json!({"height": "9,5"})),
        _ => on(k, json!({"height": 12})),
    };
    folder.write("a.geojson", &collection(&(0..40).map(house).collect::<Vec<_>>()));
    let counts = |line: &str| {
        let answer = folder.type_in(&format!("info a.geojson --missing levels {line} --json")).done();
        let faults = answer.json()["faults"].clone();
        ["missing_height", "from_levels", "negative_height", "decimal_comma"].map(|name| faults[name].as_u64().unwrap())
    };
    assert_eq!(counts(""), [10, 10, 10, 10]);
    assert_eq!(counts("--extent 0,0,150,10"), [2, 2, 2, 2]);
    let answer = folder.type_in("map a.geojson --missing levels --uav 15,5,60 -o a.svg").done();
    assert!(
        answer.err.contains("10 footprints with a negative height: left out, 33.3 % of the area"),
        "{}",
        answer.err
    );
    let svg = folder.text("a.svg").replace(['\u{a0}', '\u{202f}'], " ");
    assert!(svg.contains("with a negative height left out, 33.3"), "{svg}");
    // Tops below a ground that was typed, and a ground that does not fit.
    folder.write(
        "b.geojson",
        &collection(&[on(0, json!({"top": 110, "z_ground": 100})), on(1, json!({"top": 120, "z_ground": 104}))]),
    );
    let answer = folder.type_in("map b.geojson --top-field top --ground 115 --uav 5,5,200amsl -o b.svg").done();
    assert!(answer.err.contains("W382") && answer.err.contains("50.0 % of the area"), "{}", answer.err);
    let svg = folder.text("b.svg").replace(['\u{a0}', '\u{202f}'], " ");
    assert!(svg.contains("ground at 115 m, where buildings begin at 100 to 104 m"), "{svg}");
    // Nothing but what is not there.
    folder.write("c.geojson", &collection(&[on(0, json!({"building": "no", "height": 9}))]));
    folder.refuses("info c.geojson", "E308", &["none of its areas is a building"]);
}

#[test]
fn the_ground_is_in_one_property_of_a_file() {
    let folder = Folder::new();
    folder.write(
        "a.geojson",
        &collection(&[
            on(0, json!({"top": 12, "b3_h_maaiveld": 0})),
            on(1, json!({"top": 12, "ground_height": 10})),
            on(2, json!({"top": 12, "h_ground": 30})),
        ]),
    );
    let info = folder.type_in("info a.geojson --top-field top --json -q").done().json();
    assert_eq!(info["ground_m"], json!([0.0, 0.0]));
    let text = collection(&[on(0, json!({"top": 12, "ground": "paved"}))]);
    folder.write("b.geojson", &text);
    folder.refuses("info b.geojson --top-field top", "E365", &["nothing tells the ground"]);
}

#[test]
fn names_that_gdal_makes_of_tags_are_known() {
    let folder = Folder::new();
    let whole = [0.0, 0.0, 60.0, 60.0];
    folder.write(
        "a.geojson",
        &collection(&[
            rectangle("1", whole, &json!({"building": "yes", "height": 40})),
            rectangle("2", whole, &json!({"building_part": "yes", "height": 15})),
            on(5, json!({"demolished_building": "yes", "height": 20})),
        ]),
    );
    let found = cells(&folder, "a.geojson --extent 0,0,120,60 --data-area all");
    assert_eq!((n_of(&found, 15.0), n_of(&found, 20.0)), (3600, 0));
}

#[test]
fn a_uav_over_no_data_has_no_share_in_limits_and_charts_either() {
    let folder = Folder::new();
    // Two villages, and a UAV between them.
    let house = |k: u32| {
        let (x, y) = (f64::from(k % 4) * 20.0 + if k < 16 { 0.0 } else { 600.0 }, f64::from(k % 16 / 4) * 20.0);
        rectangle(&k.to_string(), [x, y, x + 8.0, y + 8.0], &json!({"height": 9}))
    };
    folder.write("a.geojson", &collection(&(0..32).map(house).collect::<Vec<_>>()));
    let line = "a.geojson --uav 330,30,60";
    let map = folder.type_in(&format!("map {line} --json")).done();
    assert!(map.warnings().contains(&"W205"), "{}", map.err);
    for command in ["limits", "chart --time 0"] {
        let answer = folder.type_in(&format!("{command} {line} --json")).done();
        assert!(answer.warnings().contains(&"W205"), "{command}: {}", answer.err);
        let document = answer.json();
        let p_los = document.pointer("/exact/p_los").or(document.get("p_los")).cloned();
        assert_eq!(p_los, Some(Value::Null), "{command}");
    }
}
