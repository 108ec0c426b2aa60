//! The files that a scene was read from, and their hashes, for the provenance of what is made of it.

use std::borrow::Cow;
use std::io::Read;
use std::path::Path;
use std::sync::OnceLock;

use crate::city::Source;
use crate::digest::Sha256;
use crate::error::{Error, Result, Warning};
use crate::formats::{RasterFile, cannot_read};

/// Files larger than this are hashed only on request; of a mosaic all tiles together.
const HASH_LIMIT_BYTES: u64 = 64 << 20;
/// Most tiles of a mosaic that are named one by one.
const MAX_NAMED_TILES: usize = 1000;

/// Whether a table comes from standard input: its name is `-`.
fn is_standard_input(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// What messages and documents call a file, or standard input.
pub(crate) fn input_name(path: &Path) -> String {
    if is_standard_input(path) { "standard input".into() } else { path.display().to_string() }
}

/// What a file is called in captions: its stem, spelled as words.
pub(crate) fn name_of(path: &Path) -> String {
    let stem = path.file_stem().map_or_else(|| "scene".into(), |s| s.to_string_lossy().replace('_', " "));
    let mut letters = stem.chars();
    letters.next().map_or(stem.clone(), |first| first.to_uppercase().chain(letters).collect())
}

/// The bytes of a file, or of standard input, which are kept: they can be read once.
pub(crate) fn read_input(path: &Path) -> Result<Cow<'static, [u8]>> {
    static STANDARD_INPUT: OnceLock<Vec<u8>> = OnceLock::new();
    if !is_standard_input(path) {
        return std::fs::read(path).map(Cow::Owned).map_err(|e| cannot_read(path, &e));
    }
    if STANDARD_INPUT.get().is_none() {
        let mut bytes = Vec::new();
        std::io::stdin().lock().read_to_end(&mut bytes).map_err(|e| cannot_read(Path::new(&input_name(path)), &e))?;
        let _ = STANDARD_INPUT.set(bytes);
    }
    Ok(Cow::Borrowed(STANDARD_INPUT.get().map_or(&[], Vec::as_slice)))
}

/// The text of a table.
pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read_input(path)?.into_owned()).map_err(|e| {
        let place = e.utf8_error().valid_up_to();
        Error::file(
            302,
            format!("cannot read {}: byte {place} is not UTF-8, wanted a table as UTF-8 text", input_name(path)),
        )
    })
}

/// Whether a file of places is GeoJSON: by its extension; on standard input it begins with a brace.
pub(super) fn is_geojson(path: &Path) -> Result<bool> {
    if is_standard_input(path) {
        let bytes = read_input(path)?;
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
        return Ok(text.trim_ascii_start().starts_with(b"{"));
    }
    Ok(path.extension().is_some_and(|e| e.eq_ignore_ascii_case("geojson") || e.eq_ignore_ascii_case("json")))
}

/// A source with its hash, which is left out above 64 MiB unless `always_hash`.
///
/// # Errors
/// If the file cannot be read.
pub fn source_of(path: &Path, always_hash: bool) -> Result<Source> {
    if is_standard_input(path) {
        let mut hasher = Sha256::default();
        hasher.update(read_input(path)?);
        return Ok(Source { path: input_name(path), sha256: Some(hasher.hex_digits()) });
    }
    let unreadable = |e: std::io::Error| cannot_read(path, &e);
    let mut file = std::fs::File::open(path).map_err(unreadable)?;
    let length = file.metadata().map_err(unreadable)?.len();
    let sha256 = if always_hash || length <= HASH_LIMIT_BYTES {
        let mut hasher = Sha256::default();
        let mut block = vec![0; 1 << 16];
        loop {
            match file.read(&mut block).map_err(unreadable)? {
                0 => break,
                n => hasher.update(&block[..n]),
            }
        }
        Some(hasher.hex_digits())
    } else {
        None
    };
    Ok(Source { path: path.display().to_string(), sha256 })
}

/// The sources of a raster: its file, or its folder without a hash, and the tiles that it is made of.
///
/// # Errors
/// If a file cannot be read.
pub(crate) fn sources_of_raster(
    path: &Path,
    raster: &RasterFile,
    always_hash: bool,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<Source>> {
    let unhashed = |path: &Path| Source { path: path.display().to_string(), sha256: None };
    let own = if path.is_dir() { unhashed(path) } else { source_of(path, always_hash)? };
    let tiles = raster.tile_paths();
    if tiles.len() > MAX_NAMED_TILES {
        let text = format!(
            "{}: {} tiles, of which documents name none (they name up to {MAX_NAMED_TILES})",
            path.display(),
            tiles.len()
        );
        warnings.push(Warning::new(338, text));
        return Ok(vec![own]);
    }
    let length = |path: &&Path| std::fs::metadata(path).map_or(0, |metadata| metadata.len());
    let hashes = always_hash || tiles.iter().map(length).sum::<u64>() <= HASH_LIMIT_BYTES;
    let of_tile = |tile: &Path| if hashes { source_of(tile, always_hash) } else { Ok(unhashed(tile)) };
    std::iter::once(Ok(own)).chain(tiles.into_iter().map(of_tile)).collect()
}
