//! Virtual rasters over a tile, as surface models.

#![no_main]

use std::sync::Once;

use libfuzzer_sys::fuzz_target;
use skyshed_fuzz::{surface, written};

const TILE: &[u8] = b"ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value -9\n1 2 3\n4 -9 6\n";

fuzz_target!(|bytes: &[u8]| {
    static TILES: Once = Once::new();
    TILES.call_once(|| drop(written("tile.asc", TILE)));
    surface("input.vrt", bytes);
});
