//! Surface models as lines of three numbers.

#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| skyshed_fuzz::surface("input.xyz", bytes));
