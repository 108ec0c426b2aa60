//! Files that a scene was read from, and their hashes, for the provenance of results.

use std::io::Read;

use crate::city::Source;
use crate::digest::Sha256;
use crate::error::{OddFile, Result, Warning};
use crate::formats::RasterFile;
use crate::input::{Input, cannot_read};

/// Largest size of a file that is hashed without request \[bytes\]; of a mosaic, of all tiles
/// together.
const HASH_LIMIT_BYTES: u64 = 64 << 20;
/// Largest number of tiles of a mosaic that are named one by one.
const MAX_NAMED_TILES: usize = 1000;

/// Returns the name of a file's content in titles, such as `the surface in dsm.tif`.
pub(super) fn name_of(what: &str, input: &Input) -> String {
    let file = input.as_path().file_name().unwrap_or(input.as_path().as_os_str());
    format!("the {what} in {}", file.to_string_lossy())
}

/// Reads the text of a table.
///
/// # Errors
/// E301 if it cannot be read, E302 if it is not UTF-8.
pub fn read_text(input: impl Into<Input>) -> Result<String> {
    input.into().text("a table as UTF-8 text")
}

/// Returns `true` when a file of places is GeoJSON, by its extension. Standard input is GeoJSON if
/// it begins with a brace.
pub(super) fn is_geojson(input: &Input) -> Result<bool> {
    if input.is_standard_input() {
        let bytes = input.read()?;
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
        return Ok(text.trim_ascii_start().starts_with(b"{"));
    }
    Ok(["geojson", "json"].contains(&input.extension().as_str()))
}

/// Returns a source with its hash. The hash is left out above 64 MiB and for files on servers,
/// unless `always_hash`, and for a pipe, which is read already.
///
/// # Errors
/// If the file cannot be read.
pub fn source_of(input: impl Into<Input>, always_hash: bool) -> Result<Source> {
    let input = &input.into();
    let named = |sha256| Source { path: input.to_string(), sha256 };
    let mut hasher = Sha256::default();
    if input.is_held() || input.is_standard_input() {
        hasher.update(input.read()?);
        return Ok(named(Some(hasher.hex_digits())));
    }
    // A hash would read all of a file on a server.
    if input.is_stream() || (input.is_remote() && !always_hash) {
        return Ok(named(None));
    }
    let unreadable = |e: std::io::Error| cannot_read(input, &e);
    let (mut file, length) = input.open()?;
    if !always_hash && length > HASH_LIMIT_BYTES {
        return Ok(named(None));
    }
    let mut block = vec![0; 1 << 16];
    loop {
        match file.read(&mut block).map_err(unreadable)? {
            0 => return Ok(named(Some(hasher.hex_digits()))),
            n => hasher.update(&block[..n]),
        }
    }
}

/// Returns the sources of a raster: its file, or its folder without a hash, and the tiles that it
/// is made of.
pub(super) fn sources_of_raster(
    input: &Input,
    raster: &RasterFile,
    always_hash: bool,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<Source>> {
    let unhashed = |input: &Input| Source { path: input.to_string(), sha256: None };
    let own = if input.is_folder() { unhashed(input) } else { source_of(input, always_hash)? };
    let tiles: Vec<Input> = raster.tile_paths().into_iter().map(Input::path).collect();
    if tiles.len() > MAX_NAMED_TILES {
        warnings.push(Warning::of(input, OddFile::ManyTiles { n: tiles.len(), most: MAX_NAMED_TILES }));
        return Ok(vec![own]);
    }
    let hashes = always_hash || tiles.iter().map(Input::len).sum::<u64>() <= HASH_LIMIT_BYTES;
    let of_tile = |tile: &Input| if hashes { source_of(tile, always_hash) } else { Ok(unhashed(tile)) };
    std::iter::once(Ok(own)).chain(tiles.iter().map(of_tile)).collect()
}
