//! Footprints in archives, also in archives of archives.

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| skyshed_fuzz::town("input.zip", bytes));
