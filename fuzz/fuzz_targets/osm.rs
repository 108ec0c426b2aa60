//! Data of OpenStreetMap: XML, PBF, answers of the Overpass API.

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| skyshed_fuzz::projected("input", bytes));
