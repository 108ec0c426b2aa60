//! Bands of rasters: which one holds the heights, and what the sidecars of GDAL and ArcGIS say of them.

use serde_json::Value;
use skyshed_core::raster::GeoRef;
use skyshed_io::formats::{Bands, GeoTiffImage, write_geotiff};
use skyshed_request::TiffLayout;

use crate::needs::{has_program, truth};
use crate::program::Folder;

/// A GeoTIFF of 8 × 8 cells of 1 m with some bands, each of one height but for a block of 9 m in cells 2 to 4.
fn write_bands(folder: &Folder, name: &str, bands: &[(&str, f32)]) {
    let crs = skyshed_io::crs::from_epsg(25832).unwrap();
    let georef = GeoRef::new((500_000.0, 5_000_008.0), (1.0, 1.0), (8, 8), Some(crs)).unwrap();
    let cells = |height: f32| -> Vec<f32> {
        (0..64)
            .map(|cell| if (2..5).contains(&(cell / 8)) && (2..5).contains(&(cell % 8)) { 9.0 } else { height })
            .collect()
    };
    let held: Vec<(String, Vec<f32>)> = bands.iter().map(|(name, height)| (name.to_string(), cells(*height))).collect();
    let lent = held.iter().map(|(name, cells)| (name.clone(), &cells[..])).collect();
    let image = GeoTiffImage {
        georef: &georef,
        bands: Bands::Float(lent),
        nodata: None,
        palette: None,
        metadata: &[],
        layout: TiffLayout::Plain,
    };
    write_geotiff(&mut std::fs::File::create(folder.join(name)).unwrap(), &image).unwrap();
}

fn surface(folder: &Folder, line: &str) -> [f64; 2] {
    let info = folder.type_in(&format!("info {line} --json")).done().json();
    heights(&info)
}

/// Whether the lowest and the highest height are these, to a millimeter.
fn are(found: [f64; 2], wanted: [f64; 2]) -> bool {
    found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-3)
}

fn heights(info: &Value) -> [f64; 2] {
    [0, 1].map(|k| info["surface_m"][k].as_f64().unwrap_or_else(|| panic!("{info}")))
}

#[test]
fn a_band_is_read_by_number_and_by_name() {
    let folder = Folder::new();
    write_bands(&folder, "three.tif", &[("share", 1.0), ("building_height", 2.0), ("presence", 3.0)]);
    let told = folder.type_in("info three.tif --ground 0").done();
    for word in ["W323", "1 `share`, 2 `building_height`, 3 `presence`", "`--band N|NAME`"] {
        assert!(told.err.contains(word), "no `{word}` in {}", told.err);
    }
    for (band, least) in [("1", 1.0), ("2", 2.0), ("building_height", 2.0), ("3", 3.0), ("presence", 3.0)] {
        assert!(are(surface(&folder, &format!("three.tif --ground 0 --band {band}")), [least, 9.0]), "--band {band}");
        let answer = folder.type_in(&format!("info three.tif --ground 0 --band {band}"));
        assert!(!answer.warnings().contains(&"W323"), "{}", answer.err);
    }
    for (band, code) in [("4", "E108"), ("height", "E108"), ("0", "E101")] {
        let words: &[&str] =
            if code == "E108" { &["1 `share`, 2 `building_height`, 3 `presence`"] } else { &["counted from 1"] };
        folder.refuses(&format!("info three.tif --ground 0 --band {band}"), code, words);
    }
    // Every command with a scene reads that band.
    for line in [
        "map three.tif --band 2 --ground 2 --uav 500001,5000001,20",
        "link three.tif --band 2 --ground 2 --uav 500001,5000001,20 --rx 500007,5000007",
        "place three.tif --band 2 --ground 2 --height 20 --step 3",
        "compare three.tif --band 2 --ground 2 --uav 500001,5000001,20 --uav 500007,5000007,20",
    ] {
        let answer = folder.type_in(line).done();
        assert!(!answer.warnings().contains(&"W323"), "{line}: {}", answer.err);
    }
    // What has no bands takes none.
    folder.write("one.asc", "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n0 0\n0 0\n");
    folder.refuses("info one.asc --band 2", "E108", &["wanted one of 1"]);
    assert_eq!(folder.type_in("info one.asc --band 1").code(), 0);
    folder.refuses("info itu:urban --band 1", "E116", &["`--band`"]);
}

#[test]
fn bands_of_virtual_rasters_and_folders_are_named_too() {
    let folder = Folder::new();
    write_bands(&folder, "three.tif", &[("share", 1.0), ("building_height", 2.0)]);
    let source = |band: usize| {
        format!(
            "<SimpleSource><SourceFilename relativeToVRT=\"1\">three.tif</SourceFilename><SourceBand>{band}</SourceBand></SimpleSource>"
        )
    };
    // The other way round.
    folder.write(
        "turned.vrt",
        &format!(
            "<VRTDataset rasterXSize=\"8\" rasterYSize=\"8\"><SRS>EPSG:25832</SRS><GeoTransform>500000, 1, 0, 5000008, 0, -1</GeoTransform>\
             <VRTRasterBand dataType=\"Float32\" band=\"1\"><Description>top</Description>{}</VRTRasterBand>\
             <VRTRasterBand dataType=\"Float32\" band=\"2\"><Description>share</Description>{}</VRTRasterBand></VRTDataset>",
            source(2),
            source(1)
        ),
    );
    let told = folder.type_in("info turned.vrt --ground 0").done();
    assert!(told.err.contains("1 `top`, 2 `share`") && told.err.contains("`--band N|NAME`"), "{}", told.err);
    for (band, least) in [("top", 2.0), ("1", 2.0), ("share", 1.0), ("2", 1.0)] {
        assert!(are(surface(&folder, &format!("turned.vrt --ground 0 --band {band}")), [least, 9.0]), "{band}");
    }
    folder.refuses("info turned.vrt --band 3", "E108", &["1 `top`, 2 `share`"]);
    std::fs::create_dir(folder.join("tiles")).unwrap();
    std::fs::copy(folder.join("three.tif"), folder.join("tiles/a.tif")).unwrap();
    assert!(folder.type_in("info tiles --ground 0").done().err.contains("`--band N|NAME`"));
    assert!(are(surface(&folder, "tiles --ground 0"), [1.0, 9.0]));
    assert!(are(surface(&folder, "tiles --ground 0 --band building_height"), [2.0, 9.0]));
    folder.refuses("info tiles --band 7", "E108", &["a.tif", "2 `building_height`"]);
    // The terrain keeps its first band, and no flag is offered for it.
    let over = folder.type_in("info turned.vrt --terrain three.tif --band top").done();
    assert!(over.warnings().contains(&"W323") && !over.err.contains("`--band"), "{}", over.err);
}

/// GDAL 3.6.2, `gdalinfo`: nodata, place and system of the sidecar count before those of the tags; factor, summand and name
/// where the tags have none.
#[test]
fn a_sidecar_counts_as_in_gdal() {
    let folder = Folder::new();
    write_bands(&folder, "a.tif", &[("", 2.0)]);
    let with = |band: &str, others: &str| {
        folder.write(
            "a.tif.aux.xml",
            &format!("<PAMDataset>{others}<PAMRasterBand band=\"1\">{band}</PAMRasterBand></PAMDataset>"),
        );
        folder.type_in("info a.tif --ground 0 --json").done()
    };
    let n_nodata = |document: &Value| document["cells"]["nodata"].as_u64().unwrap();
    let plain = with("", "").json();
    assert!(are(heights(&plain), [2.0, 9.0]) && n_nodata(&plain) == 0, "{plain}");
    assert_eq!(n_nodata(&with("<NoDataValue>9</NoDataValue>", "").json()), 9);
    // The bytes count where digits are rounded.
    assert_eq!(n_nodata(&with("<NoDataValue le_hex_equiv=\"0000000000002240\">7</NoDataValue>", "").json()), 9);
    let scaled = with("<Offset>100</Offset><Scale>0.5</Scale>", "");
    assert!(are(heights(&scaled.json()), [101.0, 104.5]));
    assert!(scaled.warnings().contains(&"W333"), "{}", scaled.err);
    assert!(are(heights(&with("<UnitType>ft</UnitType>", "").json()).map(|h| (h / 0.3048).round()), [2.0, 9.0]));
    let moved = with("", "<SRS>EPSG:32633</SRS><GeoTransform>400000,2,0,6000000,0,-2</GeoTransform>").json();
    assert_eq!(moved["crs"], "EPSG:32633");
    assert_eq!(moved["extent"], serde_json::json!([400_000.0, 5_999_984.0, 400_016.0, 6_000_000.0]));
    // What cannot be read is ignored, and said.
    folder.write("a.tif.aux.xml", "<PAMDataset>");
    let damaged = folder.type_in("info a.tif --ground 0 --json").done();
    assert!(damaged.warnings().contains(&"W324") && damaged.err.contains("a.tif.aux.xml"), "{}", damaged.err);
    assert!(are(heights(&damaged.json()), [2.0, 9.0]));
    // A name in the sidecar names the band.
    folder.write(
        "a.tif.aux.xml",
        "<PAMDataset><PAMRasterBand band=\"1\"><Description>top</Description></PAMRasterBand></PAMDataset>",
    );
    assert!(are(surface(&folder, "a.tif --ground 0 --band top"), [2.0, 9.0]));
}

#[test]
fn sidecars_that_gdal_writes_are_read_as_gdal_reads_them() {
    if !has_program("gdal_translate") {
        return;
    }
    let folder = Folder::new();
    folder.write("a.asc", "ncols 3\nnrows 2\nxllcorner 500000\nyllcorner 5000000\ncellsize 1\n1 2 3\n4 5 7\n");
    let gdal = |words: &str| {
        let done = std::process::Command::new("gdal_translate")
            .args(words.split_whitespace())
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(done.status.success(), "{words}: {done:?}");
    };
    // The profile `BASELINE` holds no tag of GDAL's: all goes to the sidecar.
    gdal("-q -ot Float32 -a_srs EPSG:25832 -a_nodata 7 -a_scale 0.5 -a_offset 10 -co PROFILE=BASELINE a.asc a.tif");
    assert!(folder.join("a.tif.aux.xml").is_file());
    let info = folder.type_in("info a.tif --ground 0 --json").done().json();
    assert_eq!((&info["crs"], &info["cells"]["nodata"]), (&"EPSG:25832".into(), &1.into()), "{info}");
    assert!(are(surface(&folder, "a.tif --ground 0"), [10.5, 12.5]));
    assert_eq!(info["extent"], serde_json::json!([500_000.0, 5_000_000.0, 500_003.0, 5_000_002.0]));
}

#[test]
fn cases_about_bands_and_sidecars_have_their_right_answers() {
    let Some(shared) = truth() else { return };
    let folder = Folder::new();
    for name in ["pam.tif", "pam.tif.aux.xml", "pamcrs.tif", "pamcrs.tif.aux.xml"] {
        std::fs::copy(shared.join("cases/10-pam-sidecar").join(name), folder.join(name)).unwrap();
    }
    let pam = folder.type_in("info pam.tif --ground 0 --json").done().json();
    assert_eq!(pam["cells"]["nodata"], 32, "{pam}");
    let [low, high] = surface(&folder, "pam.tif --ground 0");
    assert!((low - 100.1).abs() < 1e-3 && (high - 106.0).abs() < 1e-3, "{low} {high}");
    let placed = folder.type_in("info pamcrs.tif --ground 0 --json").done();
    assert_eq!(placed.json()["crs"], "EPSG:32632");
    assert_eq!(placed.json()["extent"], serde_json::json!([500_000.0, 5_000_000.0, 500_008.0, 5_000_008.0]));
    assert!(!placed.warnings().iter().any(|code| ["W325", "W327"].contains(code)), "{}", placed.err);
    std::fs::copy(shared.join("formats/meaning/google25d_like.tif"), folder.join("google.tif")).unwrap();
    for band in ["2", "building_height"] {
        let line = format!("map google.tif --ground 0 --band {band} --uav 500400,9799600,60 --json");
        let p_los = folder.type_in(&line).done().json()["sites"][0]["p_los"].as_f64().unwrap();
        assert!((p_los - 0.157).abs() < 1e-3, "{p_los}");
    }
}
