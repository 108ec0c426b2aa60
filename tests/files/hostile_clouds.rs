//! Damaged point clouds: headers, chunks and octrees that lie are errors, and whatever else is changed ends soon.

use std::fs;

use las::Point;
use skyshed_core::ErrorKind;
use skyshed_io::read::{PointCloudOptions, SurfaceOptions, read_point_cloud};

use crate::needs::truth;
use crate::point_clouds::{EAST, EDGE, city_points, cloud};
use crate::program::Folder;
use crate::support::{Random, is_long};

/// Puts bytes into a copy of a file.
fn patched(bytes: &[u8], at: usize, patch: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[at..at + patch.len()].copy_from_slice(patch);
    bytes
}

#[test]
fn headers_that_lie_are_errors() {
    let folder = Folder::new();
    let points = city_points();
    let (las, laz) = (cloud(&points, 1, false, None), cloud(&points, 6, true, None));
    let refuse = |bytes: &[u8], code: &str, words: &[&str]| {
        fs::write(folder.join("bad.laz"), bytes).unwrap();
        folder.refuses("info bad.laz", code, words);
    };
    let float = |value: f64| value.to_le_bytes();
    refuse(&patched(&las, 107, &u32::MAX.to_le_bytes()), "E303", &["points"]);
    // The number of older versions counts if it is not 0.
    let number = |n: u64| patched(&patched(&laz, 107, &[0; 4]), 247, &n.to_le_bytes());
    refuse(&number(0), "E308", &["point"]);
    refuse(&number(u64::MAX), "E302", &["points"]);
    refuse(&number(1_000_000), "E303", &[]);
    for (at, value, code, word) in [
        (131, 0.0, "E302", "scaled"),
        (147, f64::NAN, "E302", "scaled"),
        (155, f64::INFINITY, "E302", "moved"),
        (179, 1e300, "E502", "grid"),
        (179, f64::NAN, "E302", "bounds"),
        (187, f64::NEG_INFINITY, "E302", "bounds"),
        (187, 9e9, "E302", "bounds"),
        (139, 1e300, "E308", "point"),
        (147, 1e9, "E205", "point"),
    ] {
        refuse(&patched(&las, at, &float(value)), code, &[word]);
    }
    refuse(&patched(&las, 94, &9999_u16.to_le_bytes()), "E302", &[]);
    refuse(&patched(&las, 96, &u32::MAX.to_le_bytes()), "E302", &["byte"]);
    refuse(&patched(&laz, 100, &u32::MAX.to_le_bytes()), "E302", &["record"]);
    refuse(&patched(&las, 104, &[99]), "E304", &["format"]);
    refuse(&patched(&las, 105, &3_u16.to_le_bytes()), "E302", &["bytes"]);
    refuse(&patched(&las, 24, &[2, 7]), "E304", &["2.7"]);
    // The record of LASzip is the first: the length of its data, its kind, the number of its items, the size of one.
    let record = 375 + 54;
    refuse(&patched(&laz, 375 + 20, &u16::MAX.to_le_bytes()), "E302", &["record"]);
    refuse(&patched(&laz, record, &[1]), "E304", &["compression"]);
    refuse(&patched(&laz, record + 32, &[0, 0]), "E304", &["compression"]);
    refuse(&patched(&laz, record + 36, &[1]), "E304", &["compression"]);
    // An extended record of 16 EB at the end of the file.
    let mut extended = patched(&laz, 235, &(laz.len() as u64).to_le_bytes());
    extended[243..247].copy_from_slice(&1_u32.to_le_bytes());
    extended.extend([0; 18].iter().chain(&[9, 9]).chain(&[0xff; 8]).chain(&[0; 32]));
    refuse(&extended, "E302", &["extended record"]);
    // The first chunk: its number of points, and the lengths of its layers.
    let start = usize::try_from(u32::from_le_bytes(laz[96..100].try_into().unwrap())).unwrap() + 8;
    refuse(&patched(&laz, start + 30, &u32::MAX.to_le_bytes()), "E302", &["chunk"]);
    refuse(&patched(&laz, start + 34, &u32::MAX.to_le_bytes()), "E302", &["chunk"]);
    // Bounds that are too small leave points out, with a word; those that are too large leave none.
    fs::write(folder.join("small.las"), patched(&las, 179, &float(EAST + 30.0))).unwrap();
    let told = folder.type_in("info small.las --json").done();
    assert!(told.warnings().contains(&"W392"), "{}", told.err);
    fs::write(folder.join("large.las"), patched(&las, 179, &float(EAST + 9000.0))).unwrap();
    let told = folder.type_in("info large.las --json").done().json();
    assert_eq!(told["cols"], EDGE);
}

#[test]
fn octrees_that_lie_are_errors() {
    let Some(data) = truth() else { return };
    let folder = Folder::new();
    let copc = fs::read(data.join("formats/lidar/pdal.copc.laz")).unwrap();
    let info = 375 + 54;
    let word = |at: usize| u64::from_le_bytes(copc[at..at + 8].try_into().unwrap());
    let page = usize::try_from(word(info + 40)).unwrap();
    let extent = "--extent 636000,849000,638000,852000 --cell 8";
    let run = |bytes: &[u8]| {
        fs::write(folder.join("bad.copc.laz"), bytes).unwrap();
        folder.type_in(&format!("info bad.copc.laz {extent}"))
    };
    run(&copc).done();
    for (at, patch) in [
        (info + 40, u64::MAX.to_le_bytes()),
        (info + 48, u64::MAX.to_le_bytes()),
        (info + 48, (copc.len() as u64).to_le_bytes()),
        (page + 16, u64::MAX.to_le_bytes()),
    ] {
        assert!(run(&patched(&copc, at, &patch)).error().starts_with("E30"), "{at}");
    }
    // A page that is its own child, one with 2^31 points, and one with fewer than none.
    let child = |at: u64, n_bytes: i32, n_points: i32| {
        let mut bytes = patched(&copc, page + 16, &at.to_le_bytes());
        bytes[page + 24..page + 28].copy_from_slice(&n_bytes.to_le_bytes());
        bytes[page + 28..page + 32].copy_from_slice(&n_points.to_le_bytes());
        run(&bytes)
    };
    let of_page = i32::try_from(word(info + 48)).unwrap();
    let own = child(page as u64, of_page, -1);
    assert!(own.code() == 0 || own.error().starts_with("E30"), "{own:?}");
    assert!(child(5000, 100, i32::MAX).error().starts_with("E302"));
    assert!(child(5000, 100, -7).error().starts_with("E302"));
}

/// Files that are cut off or changed anywhere: a scene or an error, soon and without a panic.
#[test]
fn damaged_clouds_are_scenes_or_errors() {
    let folder = Folder::new();
    let points: Vec<Point> = city_points().into_iter().step_by(3).collect();
    let mut files = vec![
        cloud(&points, 1, false, None),
        cloud(&points, 3, true, None),
        cloud(&points, 6, true, Some("EPSG:25832+5783")),
        cloud(&points, 8, true, None),
    ];
    if let Some(data) = truth() {
        files.push(fs::read(data.join("formats/lidar/pdal.copc.laz")).unwrap());
    }
    let surface = SurfaceOptions { ground_m: Some(0.0), ..SurfaceOptions::default() };
    let path = folder.join("a.laz");
    let survives = |bytes: &[u8], extent: Option<[f64; 4]>| {
        fs::write(&path, bytes).unwrap();
        let cell_m = if extent.is_some() { 8.0 } else { 4.0 };
        let options = PointCloudOptions { surface: surface.clone(), extent, cell_m: Some(cell_m) };
        match read_point_cloud(&path, &options, &mut Vec::new()) {
            Ok(_) => true,
            Err(error) => {
                let class = error.kind();
                assert!([ErrorKind::File, ErrorKind::Site, ErrorKind::Limit].contains(&class), "{error}");
                false
            }
        }
    };
    let mut random = Random(5);
    for (k, whole) in files.iter().enumerate() {
        let extent = (k == 4).then_some([636_000.0, 849_000.0, 638_000.0, 852_000.0]);
        assert!(survives(whole, extent), "{k}");
        let n_cuts = if is_long() { 2000 } else { 40 };
        for _ in 0..n_cuts {
            survives(&whole[..random.below(whole.len())], extent);
        }
        for n in 0..if is_long() { 50_000 } else { 300 } {
            let mut bytes = whole.clone();
            // Half of the changes are in the header and the records behind it.
            let end = if n % 2 == 0 { bytes.len() } else { 700 };
            for _ in 0..random.within(1, 4) {
                let at = random.below(end);
                bytes[at] = random.choose(&[0, 1, 0x7f, 0x80, 0xff, bytes[at] ^ 1, bytes[at] ^ 0x10, bytes[at] ^ 0x80]);
            }
            survives(&bytes, extent);
        }
    }
}
