//! Tracks of users; the first byte tells a table from a line.

#![no_main]

use libfuzzer_sys::fuzz_target;
use skyshed_io::read::{BadRows, read_track};
use skyshed_fuzz::{answered, grid, written};

fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else { return };
    let name = if *first == b'{' { "input.geojson" } else { "input.csv" };
    for place in answered(read_track(&written(name, bytes), grid().crs(), BadRows::Refuse)).into_iter().flatten() {
        assert!(place.iter().all(|v| v.is_finite()), "{place:?}");
    }
});
