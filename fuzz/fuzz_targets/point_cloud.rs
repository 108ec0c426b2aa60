//! Surveys in LAS, LAZ and COPC.

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| skyshed_fuzz::cloud("input.laz", bytes));
