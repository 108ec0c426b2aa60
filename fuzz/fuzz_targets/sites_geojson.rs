//! Places of UAVs as points.

#![no_main]

use libfuzzer_sys::fuzz_target;
use skyshed_io::read::{BadRows, read_sites};
use skyshed_fuzz::{answered, grid, written};

fuzz_target!(|bytes: &[u8]| {
    for site in answered(read_sites(&written("input.geojson", bytes), &grid(), 1, BadRows::Refuse)).into_iter().flatten() {
        assert!(site.x.is_finite() && site.y.is_finite() && site.height.value().is_finite(), "{site:?}");
    }
});
