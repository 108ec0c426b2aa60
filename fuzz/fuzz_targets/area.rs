//! Areas of a goal, in the grid of a scene.

#![no_main]

use libfuzzer_sys::fuzz_target;
use skyshed_fuzz::{answered, grid, written};
use skyshed_io::read::read_area;

fuzz_target!(|bytes: &[u8]| {
    answered(read_area(&written("input.geojson", bytes), &grid()));
});
