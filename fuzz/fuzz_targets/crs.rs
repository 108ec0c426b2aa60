//! Coordinate reference systems in any notation, and a point brought into those that are understood.

#![no_main]

use libfuzzer_sys::fuzz_target;
use skyshed_io::crs;
use skyshed_io::crs::transform;
use skyshed_fuzz::{answered, grid};

fuzz_target!(|text: &str| {
    let Some(crs) = answered(crs::parse(text)) else { return };
    if let Some(wkt) = skyshed_io::crs::wkt_of(&crs) {
        assert!(!wkt.is_empty());
    }
    let grid = grid();
    let utm = grid.crs().expect("a grid in UTM");
    if let Some((x, y)) = answered(transform(utm, &crs, (691_000.0, 5_335_000.0))) {
        assert!(x.is_finite() && y.is_finite(), "{x}, {y}");
    }
});
