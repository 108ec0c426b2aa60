//! Meshes as PLY, text or binary.

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| skyshed_fuzz::mesh("input.ply", bytes));
