//! A GeoTIFF is cloud optimized: directories first, overviews after the full resolution, tiles in order.
//!
//! The layout is read here byte by byte, and judged by `rio cogeo` where Python has it.

use std::process::Command;

use skyshed_core::raster::GeoRef;
use skyshed_io::crs;
use skyshed_io::formats::{Bands, GeoTiffImage, encode_geotiff};

use crate::formats_write::image_of;
use crate::needs::python_with;
use crate::program::Folder;

/// What a directory says of its picture.
#[derive(Debug)]
struct Directory {
    at: u64,
    size: [u64; 2],
    is_overview: bool,
    tile: [u64; 2],
    /// Offsets and lengths of the tiles.
    tiles: Vec<(u64, u64)>,
}

/// The directories of a little-endian classic TIFF file in the order of their chain (TIFF 6.0, section 2).
fn directories(file: &[u8]) -> Vec<Directory> {
    let number = |at: u64, n: u64| -> u64 {
        let at = usize::try_from(at).unwrap();
        file[at..at + usize::try_from(n).unwrap()].iter().rev().fold(0, |sum, byte| sum << 8 | u64::from(*byte))
    };
    assert_eq!(&file[..4], b"II*\0");
    let mut next = number(4, 4);
    let mut found = Vec::new();
    while next != 0 {
        let at = next;
        let n_tags = number(at, 2);
        let values = |code: u64| -> Vec<u64> {
            let entries = (0..n_tags).map(|k| at + 2 + 12 * k);
            let Some(entry) = entries.into_iter().find(|entry| number(*entry, 2) == code) else { return Vec::new() };
            let size = [0, 1, 1, 2, 4][usize::try_from(number(entry + 2, 2)).unwrap()];
            let n = number(entry + 4, 4);
            let start = if n * size <= 4 { entry + 8 } else { number(entry + 8, 4) };
            (0..n).map(|k| number(start + k * size, size)).collect()
        };
        let one = |code: u64| values(code).first().copied().unwrap_or(0);
        found.push(Directory {
            at,
            size: [one(256), one(257)],
            is_overview: one(254) == 1,
            tile: [one(322), one(323)],
            tiles: values(324).into_iter().zip(values(325)).collect(),
        });
        next = number(at + 2 + 12 * n_tags, 4);
    }
    found
}

/// Two bands of numbers.
fn margins() -> Vec<u8> {
    let georef = GeoRef::new((500_000.0, 5_400_000.0), (1.0, 1.0), (900, 1100), crs::from_epsg(25832).ok()).unwrap();
    let values: Vec<f32> = (0..900 * 1100).map(|cell| (cell % 1009) as f32 / 8.0).collect();
    let bands = Bands::Float(["0.margin", "1.margin"].map(|name| (name.to_string(), &values[..])).to_vec());
    let metadata = [("SKYSHED".into(), "{}".into())];
    let image = GeoTiffImage { nodata: Some(-9999.0), metadata: &metadata, ..image_of(&georef, bands) };
    encode_geotiff(&image).unwrap()
}

#[test]
fn directories_come_first_and_the_full_resolution_last() {
    let file = margins();
    let found = directories(&file);
    // 1100 × 900 is halved until it fits one tile, rounding up.
    let sizes: Vec<[u64; 2]> = found.iter().map(|d| d.size).collect();
    assert_eq!(sizes, [[1100, 900], [550, 450], [275, 225], [138, 113]]);
    assert_eq!(found.iter().map(|d| d.is_overview).collect::<Vec<_>>(), [false, true, true, true]);
    assert!(found.windows(2).all(|pair| pair[0].at < pair[1].at), "the chain runs forward");
    let first_tile = found.iter().flat_map(|d| &d.tiles).map(|tile| tile.0).min().unwrap();
    assert!(found.iter().all(|d| d.at < first_tile), "no directory lies behind a tile");
    // A reader that fetches the head knows everything; each smaller picture lies before the larger one.
    for directory in &found {
        let [across, down] = [0, 1].map(|k| directory.size[k].div_ceil(directory.tile[k]));
        assert_eq!((directory.tile, directory.tiles.len() as u64), ([256, 256], 2 * across * down));
        assert!(directory.tiles.windows(2).all(|pair| pair[0].0 + pair[0].1 == pair[1].0), "tiles follow each other");
    }
    for pair in found.windows(2) {
        assert_eq!(pair[1].tiles.last().map(|t| t.0 + t.1), pair[0].tiles.first().map(|t| t.0));
    }
    assert_eq!(found[0].tiles.last().map(|t| t.0 + t.1), Some(file.len() as u64));
}

#[test]
fn rio_cogeo_finds_nothing_to_warn_of() {
    if !python_with("rio_cogeo") {
        return;
    }
    let folder = Folder::new();
    std::fs::write(folder.join("margins.tif"), margins()).unwrap();
    folder.type_in("map itu:urban --size 700 --uav 300,300,80 -o mask.tif -q").done();
    folder.type_in("map itu:urban --size 700 --uav 300,300,80 --tif-layout plain -o plain.tif -q").done();
    let judged = |name: &str| {
        let code =
            "import sys; from rio_cogeo.cogeo import cog_validate; print(cog_validate(sys.argv[1], strict=True))";
        let output = Command::new("python3").args(["-c", code, &folder.word(name)]).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    for name in ["margins.tif", "mask.tif"] {
        assert_eq!(judged(name).trim(), "(True, [], [])", "{name}");
    }
    assert!(judged("plain.tif").starts_with("(False"), "{}", judged("plain.tif"));
}
