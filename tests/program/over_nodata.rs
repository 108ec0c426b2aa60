//! A UAV over no data: the map is made, and there is no P_LoS.

use serde_json::Value;

use crate::program::Folder;
use crate::texts::table_rows;

/// A block of houses with streets between, 300 m wide, and another house 400 m to the east, so that all ground between is far from both.
fn write_town(folder: &Folder) {
    let house = |(x, y): (i32, i32)| {
        format!(
            r#"{{"type":"Feature","properties":{{"height":12}},"geometry":{{"type":"Polygon","coordinates":[[[{x},{y}],[{e},{y}],[{e},{n}],[{x},{n}],[{x},{y}]]]}}}}"#,
            e = x + 20,
            n = y + 20
        )
    };
    let block = (0..36).map(|k| (k % 6 * 55, k / 6 * 55));
    let houses: Vec<String> = block.chain([(700, 100), (700, 150)]).map(house).collect();
    let text = format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, houses.join(","));
    std::fs::write(folder.join("town.geojson"), text).unwrap();
}

const REASON: &str = "the UAV is over no data";

/// Receivers, and that there is no share of them.
fn check_undefined(of: &Value) {
    assert!(of["receivers"].as_u64() > Some(0) && of["los"].is_u64(), "{of}");
    assert_eq!((&of["p_los"], of["reason"].as_str()), (&Value::Null, Some(REASON)), "{of}");
}

#[test]
fn a_uav_beyond_the_data_area_has_a_map_and_no_p_los() {
    let folder = Folder::new();
    write_town(&folder);
    let map = "map town.geojson --uav 500,150,60";
    let run = folder.type_in(&format!("{map} -o los.tif -o los.csv --json")).done();
    assert!(run.err.contains("over no data"), "{}", run.err);
    let document = run.json();
    assert!(document["warnings"].as_array().unwrap().iter().any(|w| w["code"] == "W205"), "{document}");
    let site = &document["sites"][0];
    check_undefined(site);
    assert_eq!((&site["placement"], &document["union"]["p_los"]), (&"nodata".into(), &Value::Null));
    assert!(folder.text("los.csv").lines().nth(1).unwrap().contains(",nodata,"));
    // In the block, and with all ground known, it has a number: that of its counts.
    for known in ["map town.geojson --uav 100,150,60", &format!("{map} --data-area all")] {
        let site = &folder.type_in(&format!("{known} --json -q")).done().json()["sites"][0];
        let share = site["los"].as_f64().unwrap() / site["receivers"].as_f64().unwrap();
        assert!((site["p_los"].as_f64().unwrap() - share).abs() < 1e-12, "{site}");
    }
    // The mask is that of all ground, less what is no data.
    let mask = |line: &str, name: &str| {
        folder.type_in(&format!("{line} -o {name} -q")).done();
        let text = folder.text(name);
        let cells: Vec<String> = text.lines().skip(6).flat_map(str::split_whitespace).map(str::to_string).collect();
        cells
    };
    let (limited, all) = (mask(map, "limited.asc"), mask(&format!("{map} --data-area all"), "all.asc"));
    let differs = limited.iter().zip(&all).filter(|(a, b)| a != b && *a != "255");
    assert!(limited.contains(&"255".to_string()) && differs.count() == 0);
}

#[test]
fn other_answers_over_no_data_have_no_p_los_either() {
    let folder = Folder::new();
    write_town(&folder);
    std::fs::write(folder.join("two.csv"), "id,x,y,h\nin,100,150,60\nout,500,150,60\n").unwrap();
    let many = folder.type_in("map town.geojson --uavs two.csv --zones --json -q").done().json();
    assert!(many["sites"][0]["p_los"].is_f64() && many["sites"][0]["zones"]["street"]["p_los"].is_f64());
    check_undefined(&many["sites"][1]);
    check_undefined(&many["sites"][1]["zones"]["street"]);
    check_undefined(&many["union"]);
    let tiles = "map town.geojson --uavs two.csv --layers count,union --tile-size 208 -o {row}-{col}.tif -o {row}-{col}.json -q";
    folder.type_in(tiles).done();
    folder.type_in(&format!("jobs merge -o all.csv -o all.json {tiles}")).done();
    let rows = table_rows(&folder.text("all.csv"));
    let row = |id: &str| rows.iter().find(|row| row["site"] == id).unwrap();
    assert!(
        !row("in")["p_los"].is_empty() && row("out")["p_los"].is_empty() && row("out")["receivers"] != "0",
        "{rows:?}"
    );
    let merged: Value = serde_json::from_str(&folder.text("all.json")).unwrap();
    check_undefined(&merged["union"]);

    let compared = folder.type_in("compare town.geojson --uavs two.csv --json -q").done().json();
    check_undefined(&compared["placements"][1]);
    assert!(compared["placements"][0]["p_los"].is_f64() && compared["pairs"][0]["p_los_difference"].is_null());
    let curve = "map town.geojson --uav 500,150,60 --height-curve c.json -q";
    folder.type_in(curve).done();
    let curve: Value = serde_json::from_str(&folder.text("c.json")).unwrap();
    let site = &curve["sites"][0];
    assert!(site["curve"].as_array().unwrap().iter().all(|p| p["p_los"].is_null()), "{site}");
    let errors = folder.type_in("map town.geojson --uav 500,150,60 --height-error 1 --layers p-los -o p.tif --json -q");
    let errors = errors.done().json();
    assert!(errors["sites"][0]["uncertain"].get("p_los_low").is_none_or(Value::is_null));
    assert!(errors["sites"][0]["uncertain"].get("p_los_mean").is_none_or(Value::is_null));
}

#[test]
fn a_uav_over_a_hole_of_a_raster_has_no_p_los() {
    let folder = Folder::new();
    // 20 × 20 cells of 5 m on 100 m, with a hole of 6 × 6.
    let row = |r: usize| {
        let cell = |c: usize| if (7..13).contains(&r) && (7..13).contains(&c) { "-9999" } else { "100" };
        (0..20).map(cell).collect::<Vec<_>>().join(" ")
    };
    let rows: Vec<String> = (0..20).map(row).collect();
    let head = "ncols 20\nnrows 20\nxllcorner 0\nyllcorner 0\ncellsize 5\nNODATA_value -9999\n";
    std::fs::write(folder.join("dsm.asc"), format!("{head}{}\n", rows.join("\n"))).unwrap();
    for line in
        ["map dsm.asc --uav 50,50,150amsl --json -q", "map dsm.asc --uav 50,50,150amsl --strips -o s.tif --json -q"]
    {
        check_undefined(&folder.type_in(line).done().json()["sites"][0]);
    }
    // Beside the hole, and outside of the grid, where nothing stands in the way, it has one.
    for place in ["10,10,150amsl", "-20,50,150amsl"] {
        let site = &folder.type_in(&format!("map dsm.asc --uav {place} --json -q")).done().json()["sites"][0];
        assert_eq!((&site["p_los"], &site["placement"]), (&1.0.into(), &"ground".into()), "{site}");
    }
}

#[test]
fn times_in_which_a_uav_over_no_data_is_up_have_no_p_los() {
    let folder = Folder::new();
    write_town(&folder);
    folder.write("uavs.csv", "id,x,y,h,from,to\nin,100,150,60,0,10\nbeyond,500,150,60,5,15\n");
    folder.type_in("map town.geojson --uavs uavs.csv --over-time t.json -q").done();
    let document = folder.json("t.json");
    let rows = document["rows"].as_array().unwrap();
    let alone = folder.type_in("map town.geojson --uav 100,150,60 --json -q").done().json();
    assert_eq!((rows.len(), &rows[0]["p_los"]), (3, &alone["union"]["p_los"]));
    for row in &rows[1..] {
        assert!(row["receivers"].as_u64() > Some(0) && row["p_los"].is_null(), "{row}");
    }
    // Nor is there a share of the receivers of both, one of whom is over no data.
    assert!(rows.iter().all(|row| row["share"].is_null()) && document["mean_share"].is_null(), "{document}");
}
