//! Footprints as a shapefile: the first four bytes are the length of the `.shp`, the table `.dbf` follows it.

#![no_main]

use libfuzzer_sys::fuzz_target;
use skyshed_fuzz::{town, written};

fuzz_target!(|bytes: &[u8]| {
    let Some((length, files)) = bytes.split_first_chunk::<4>() else { return };
    let length = usize::try_from(u32::from_le_bytes(*length)).unwrap_or(usize::MAX).min(files.len());
    let (shapes, table) = files.split_at(length);
    written("input.dbf", table);
    town("input.shp", shapes);
});
