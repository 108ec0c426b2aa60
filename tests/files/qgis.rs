//! Rasters opened in QGIS as they are: their classes in the program's colors, with a legend of the classes alone.

use std::process::Command;

use serde_json::Value;

use crate::needs::has;
use crate::program::Folder;

/// The interpreter that has QGIS: that of the system.
const PYTHON: &str = "/usr/bin/python3";

/// What QGIS makes of some rasters, in order; `None` where it is not installed.
fn looked_at(folder: &Folder, names: &[&str]) -> Option<Vec<Value>> {
    let found = Command::new(PYTHON).args(["-c", "import qgis.core"]).output();
    if !has("qgis", found.is_ok_and(|found| found.status.success())) {
        return None;
    }
    let tool = format!("{}/tests/tools/qgis_look.py", env!("CARGO_MANIFEST_DIR"));
    let mut command = Command::new(PYTHON);
    command.arg(tool).args(names.iter().map(|name| folder.word(name)));
    if let Some(pictures) = std::env::var_os("SKYSHED_PICTURES") {
        command.arg("--pictures").arg(pictures);
    }
    let done = command.output().unwrap();
    let said = String::from_utf8(done.stdout).unwrap();
    let rows: Vec<Value> =
        said.lines().filter(|line| line.starts_with('{')).map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(rows.len(), names.len(), "{said}{}", String::from_utf8_lossy(&done.stderr));
    Some(rows)
}

#[test]
fn rasters_of_every_kind_open_with_their_colors_and_a_legend() {
    let folder = Folder::new();
    folder.type_in("city itu:urban --size 300 -o city.geojson -q").done();
    let scene = "map city.geojson --crs EPSG:25832";
    let (one, three) = ("--uav 140,140,40", "--uav 140,140,40 --uav 60,200,40 --uav 220,60,40");
    for line in [
        format!("{scene} {one} -o one.tif"),
        format!("{scene} {three} -o three.tif"),
        format!("{scene} {one} --layers los,margin,ceiling -o layers.tif"),
        format!("{scene} {one} --layers margin -o margin.tif"),
        format!("{scene} {three} --layers count -o count.tif"),
        format!("{scene} {three} --layers union,count -o both.tif"),
        format!("{scene} {one} --height-error 1.5 --layers sure,p-los -o sure.tif"),
        "compare city.geojson --crs EPSG:25832 --uav 140,140,40 --uav 60,200,40 -o compare.tif".to_string(),
    ] {
        folder.type_in(&format!("{line} -q")).done();
    }
    folder.write("uavs.csv", "x,y,h\n140,140,40\n60,200,40\n");
    for layer in ["union", "count"] {
        let map = format!("{scene} --uavs uavs.csv --layers {layer} --tile-size 160 -o {layer}-{{row}}-{{col}}.tif");
        folder.type_in(&format!("{map} -q")).done();
        folder.type_in(&format!("jobs merge -o tiles-{layer}.vrt {map} -q")).done();
    }
    let names = [
        ("one.tif", 4),
        ("three.tif", 4),
        ("layers.tif", 4),
        ("margin.tif", 0),
        ("count.tif", 4),
        ("both.tif", 4),
        ("sure.tif", 3),
        ("compare.tif", 4),
        ("tiles-union.vrt", 4),
        ("tiles-count.vrt", 3),
    ];
    let Some(found) = looked_at(&folder, &names.map(|(name, _)| name)) else { return };
    for ((name, n_classes), found) in names.into_iter().zip(found) {
        let legend = found["legend"].as_array().unwrap();
        // The first line names the band.
        let kind = if n_classes > 0 { "paletted" } else { "singlebandpseudocolor" };
        assert_eq!(found["renderer"], kind, "{name}: {found}");
        assert!(n_classes == 0 || legend.len() == n_classes + 1, "{name}: {found}");
        let colors: Vec<&str> = found["colors"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        // Blue is line of sight and orange is none; numbers of UAVs have paler and deeper blues.
        let wanted: &[&str] = match name {
            "margin.tif" => &[],
            "count.tif" | "tiles-count.vrt" => &["#e69f00"],
            _ => &["#0072b2", "#e69f00"],
        };
        assert!(wanted.iter().all(|color| colors.contains(color)), "{name}: {found}");
        assert!(colors.len() > if n_classes > 0 { 2 } else { 10 }, "{name}: {found}");
    }
}
