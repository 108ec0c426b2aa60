//! The files that a scene was read from, and their hashes, for the provenance of what is made of it.

use std::io::Read;
use std::path::Path;

use crate::digest::Sha256;
use crate::error::{Error, Result, Warning};
use crate::raster::RasterFile;

/// An input file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// As the user gave it.
    pub path: String,
    /// SHA-256 of its bytes in hexadecimal, if it was computed.
    pub sha256: Option<String>,
}

/// Files larger than this are hashed only on request; of a mosaic all tiles together.
const HASH_LIMIT_BYTES: u64 = 64 << 20;
/// Most tiles of a mosaic that are named one by one.
const MAX_NAMED_TILES: usize = 1000;

impl Source {
    /// A source with its hash, which is left out above 64 MiB unless `always_hash`.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn of(path: &Path, always_hash: bool) -> Result<Source> {
        let unreadable = |e: std::io::Error| Error::file(301, format!("cannot read {}: {e}", path.display()));
        let mut file = std::fs::File::open(path).map_err(unreadable)?;
        let length = file.metadata().map_err(unreadable)?.len();
        let sha256 = if always_hash || length <= HASH_LIMIT_BYTES {
            let mut hasher = Sha256::new();
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
    pub(crate) fn of_raster(
        path: &Path,
        raster: &RasterFile,
        always_hash: bool,
        warnings: &mut Vec<Warning>,
    ) -> Result<Vec<Source>> {
        let unhashed = |path: &Path| Source { path: path.display().to_string(), sha256: None };
        let own = if path.is_dir() { unhashed(path) } else { Source::of(path, always_hash)? };
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
        let of_tile = |tile: &Path| if hashes { Source::of(tile, always_hash) } else { Ok(unhashed(tile)) };
        std::iter::once(Ok(own)).chain(tiles.into_iter().map(of_tile)).collect()
    }
}
