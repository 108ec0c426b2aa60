//! What heights are above and in which unit: files as GDAL writes them, and two of them together.

use serde_json::Value;

use crate::mosaic::gdal;
use crate::needs::has_program;
use crate::program::Folder;

/// A surface of 10 and a terrain of 1, 4 × 4 cells, each brought by GDAL into a system.
fn scene(folder: &Folder, surface: &str, terrain: &str) {
    for (name, height, system) in [("dsm", "10", surface), ("dtm", "1", terrain)] {
        let rows = format!("{0} {0} {0} {0}\n", height).repeat(4);
        let head = "ncols 4\nnrows 4\nxllcorner 691000\nyllcorner 5334000\ncellsize 1\n";
        folder.write(&format!("{name}.asc"), &format!("{head}{rows}"));
        gdal(folder, &format!("gdal_translate -q -ot Float32 -a_srs {system} {name}.asc {name}.tif"));
    }
}

const US_FOOT: f64 = 1200.0 / 3937.0;

#[test]
fn feet_of_a_vertical_system_become_meters() {
    if !has_program("gdal_translate") {
        return;
    }
    // EPSG:6360 is NAVD88 in US survey feet, EPSG:5703 the same datum in meters. GDAL stores the code alone.
    let folder = Folder::new();
    scene(&folder, "EPSG:25832+6360", "EPSG:25832+5703");
    let answer = folder.type_in("info dsm.tif --terrain dtm.tif --json").done();
    let (info, warnings) = (answer.json(), answer.warnings());
    let near = |pointer: &str, expected: f64| {
        let found = info.pointer(pointer).and_then(Value::as_f64).unwrap();
        assert!((found - expected).abs() < 1.0 / 1024.0, "{pointer}: {found}, expected {expected}");
    };
    near("/surface_m/1", 10.0 * US_FOOT);
    near("/ground_m/0", 1.0);
    assert!(warnings.contains(&"W332") && !warnings.contains(&"W370") && !warnings.contains(&"W371"), "{warnings:?}");
    assert_eq!(info["vertical"][0]["crs"], "EPSG:6360");
    assert_eq!(info["vertical"][1]["name"], "NAVD88 height");
    let said = folder.type_in("info dsm.tif --terrain dtm.tif").done().out;
    assert!(said.contains("of dsm.tif above NAVD88 height (ftUS) (EPSG:6360)"), "{said}");
}

#[test]
fn a_unit_of_the_band_is_believed_over_that_of_the_system() {
    if !has_program("gdal_translate") {
        return;
    }
    let folder = Folder::new();
    scene(&folder, "EPSG:25832+6360", "EPSG:25832+5703");
    gdal(&folder, "gdal_translate -q -of VRT dsm.tif dsm.vrt");
    let unit = folder.text("dsm.vrt");
    let unit = match (unit.find("<UnitType>"), unit.find("</UnitType>")) {
        (Some(a), Some(b)) => format!("{}m{}", &unit[..a + 10], &unit[b..]),
        _ => unit.replace("<ColorInterp>", "<UnitType>m</UnitType><ColorInterp>"),
    };
    folder.write("dsm.vrt", &unit);
    gdal(&folder, "gdal_translate -q dsm.vrt meters.tif");
    let answer = folder.type_in("info meters.tif --ground 0 --json").done();
    let top = answer.json()["surface_m"][1].as_f64().unwrap();
    assert!((top - 10.0).abs() < 1e-3, "{top}");
    assert!(answer.warnings().contains(&"W372"), "{}", answer.err);
}

#[test]
fn different_datums_are_named_and_an_ellipsoid_is_refused() {
    if !has_program("gdal_translate") {
        return;
    }
    let folder = Folder::new();
    let line = "map dsm.tif --terrain dtm.tif --uav 691001.5,5334001.5,50amsl --json";
    // DHHN92 and NAVD88: two datums.
    scene(&folder, "EPSG:25832+5783", "EPSG:25832+5703");
    let answer = folder.type_in(line).done();
    assert!(answer.warnings().contains(&"W371"), "{}", answer.err);
    assert!(answer.err.contains("DHHN92 height") && answer.err.contains("NAVD88 height"), "{}", answer.err);
    // One of them names none.
    scene(&folder, "EPSG:25832+5783", "EPSG:25832");
    let answer = folder.type_in(line).done();
    assert!(answer.warnings().contains(&"W370") && answer.err.contains("dtm.tif"), "{}", answer.err);
    // Neither does: nothing to be said.
    scene(&folder, "EPSG:25832", "EPSG:25832");
    let answer = folder.type_in(line).done();
    assert!(!answer.warnings().iter().any(|code| ["W370", "W371"].contains(code)), "{}", answer.err);
    let info = folder.type_in("info dsm.tif --terrain dtm.tif --json").done().json();
    assert_eq!(info["vertical"][0]["name"], Value::Null);
    assert!(info["vertical"][0]["reason"].is_string());
    // The number of the system in its key of a GeoTIFF: heights above the ellipsoid of WGS 84, and above NAVD88.
    scene(&folder, "EPSG:25832+5703", "EPSG:25832+5703");
    let mut bytes = folder.read("dsm.tif");
    let key = [4096_u16, 0, 1, 5703].map(u16::to_le_bytes).concat();
    let at = bytes.windows(8).position(|window| window == key).unwrap();
    bytes[at + 6..at + 8].copy_from_slice(&4979_u16.to_le_bytes());
    std::fs::write(folder.join("dsm.tif"), bytes).unwrap();
    folder.refuses(line, "E311", &["EPSG:4979", "EPSG:5703"]);
    // Whoever says which system both are in is believed.
    let answer = folder.type_in(&format!("{line} --crs EPSG:25832")).done();
    assert!(answer.warnings().contains(&"W371"), "{}", answer.err);
}
