//! Writes a surface model of any size without holding it: hills of some 60 m with a city of blocks on them, as a
//! compressed GeoTIFF in tiles, or in strips of one row.
//!
//! ```text
//! cargo run --release --example large_dsm -- 50000 large.tif
//! cargo run --release --example large_dsm -- 50000 large_strips.tif strips
//! ```
//!
//! Without words it writes `out/large_dsm.tif`, of 2048 cells a side. The heights at a cell depend on its row and column alone, so a smaller file is the north-west corner of a larger one.

use std::fs::File;
use std::io::{BufWriter, Seek, SeekFrom, Write};

use rayon::prelude::*;
use tiff_core::{ByteOrder, Compression, Predictor};
use tiff_writer::compress::{BlockEncodingOptions, compress_block};

/// Rows and columns of a tile \[cells\].
const TILE: usize = 512;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words = if words.is_empty() {
        std::fs::create_dir_all("out")?;
        vec!["2048".to_string(), "out/large_dsm.tif".to_string()]
    } else {
        words
    };
    let [cells, path, layout @ ..] = words.as_slice() else { return Err("wanted CELLS FILE [strips]".into()) };
    let n: usize = cells.parse()?;
    let block = if layout.first().is_some_and(|word| word == "strips") { (1, n) } else { (TILE, TILE) };
    Ok(write(path, n, block)?)
}

/// Height at a cell \[m\]: hills, and on them houses of 12 × 12 cells between streets of 8.
fn height(row: usize, col: usize) -> f32 {
    let wave = |at: usize, length: f64| (at as f64 / length * std::f64::consts::TAU).sin();
    let hills = 40.0 * wave(row, 9000.0) * wave(col, 7000.0) + 20.0 * wave(row + 2 * col, 3100.0);
    // Ground in steps of a quarter, as many terrain models have it.
    let ground = (4.0 * hills).round() / 4.0 + 100.0;
    let is_house = row % 20 < 12 && col % 20 < 12;
    let hash = ((row / 20) as u64)
        .wrapping_mul(0x9E37_79B9_7F4A_7C15)
        .wrapping_add((col / 20) as u64)
        .wrapping_mul(0xD6E8_FEB8_6659_FD93);
    let storeys = (hash >> 40) % 64;
    // Two in three lots are built on; a few houses are high.
    let roof = match storeys {
        0..21 => 0.0,
        63 => 60.0,
        _ => 3.0 * (2 + storeys % 7) as f64,
    };
    #[expect(clippy::cast_possible_truncation, reason = "a multiple of a quarter below 1000 is exact")]
    let height = (ground + if is_house { roof } else { 0.0 }) as f32;
    height
}

fn write(path: &str, n: usize, (block_rows, block_cols): (usize, usize)) -> std::io::Result<()> {
    let (down, across) = (n.div_ceil(block_rows), n.div_ceil(block_cols));
    let mut file = BufWriter::new(File::create(path)?);
    // BigTIFF, little endian; where the directory is gets known last.
    file.write_all(b"II\x2b\0\x08\0\0\0")?;
    file.write_all(&0_u64.to_le_bytes())?;
    let mut at = 16_u64;
    let (mut offsets, mut lengths) = (Vec::new(), Vec::new());
    let options = BlockEncodingOptions {
        byte_order: ByteOrder::LittleEndian,
        compression: Compression::Deflate,
        predictor: Predictor::FloatingPoint,
        samples_per_pixel: 1,
        row_width_pixels: block_cols,
        jpeg_options: None,
        jpeg_sampling: None,
        deflate_level: None,
    };
    let compressed = |block: usize| {
        let (top, left) = (block / across * block_rows, block % across * block_cols);
        let cells: Vec<f32> = (top..top + block_rows)
            .flat_map(|row| (left..left + block_cols).map(move |col| height(row.min(n - 1), col.min(n - 1))))
            .collect();
        compress_block(&cells, options, block).map_err(std::io::Error::other)
    };
    let blocks: Vec<usize> = (0..down * across).collect();
    for some in blocks.chunks(across.max(256)) {
        for bytes in some.par_iter().map(|block| compressed(*block)).collect::<Vec<_>>() {
            let bytes = bytes?;
            offsets.push(at);
            lengths.push(bytes.len() as u64);
            at += bytes.len() as u64;
            file.write_all(&bytes)?;
        }
    }
    let tags = tags(n, block_rows > 1, &offsets, &lengths);
    // Values of more than 8 bytes come before the directory.
    let mut entries = Vec::new();
    for (code, kind, count, mut value) in tags {
        if value.len() > 8 {
            let start = at;
            file.write_all(&value)?;
            at += value.len() as u64;
            value = start.to_le_bytes().to_vec();
        }
        value.resize(8, 0);
        entries.push([&code.to_le_bytes()[..], &kind.to_le_bytes(), &count.to_le_bytes(), &value].concat());
    }
    file.write_all(&(entries.len() as u64).to_le_bytes())?;
    file.write_all(&entries.concat())?;
    file.write_all(&0_u64.to_le_bytes())?;
    file.seek(SeekFrom::Start(8))?;
    file.write_all(&at.to_le_bytes())?;
    file.flush()
}

/// Returns the tags of the directory: code, type, number of values, and their bytes.
fn tags(n: usize, is_tiled: bool, offsets: &[u64], lengths: &[u64]) -> Vec<(u16, u16, u64, Vec<u8>)> {
    let n = n as u64;
    let (short, long8, double) = (3_u16, 16_u16, 12_u16);
    let le = |numbers: &[u64]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let shorts = |numbers: &[u16]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let doubles = |numbers: &[f64]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    // A projected system (1024 = 1), cells are areas (1025 = 1), EPSG:25832.
    let keys = shorts(&[1, 1, 0, 3, 1024, 0, 1, 1, 1025, 0, 1, 1, 3072, 0, 1, 25832]);
    let mut tags: Vec<(u16, u16, u64, Vec<u8>)> = vec![
        (256, long8, 1, le(&[n])),
        (257, long8, 1, le(&[n])),
        (258, short, 1, shorts(&[32])),
        (259, short, 1, shorts(&[8])),
        (262, short, 1, shorts(&[1])),
        (277, short, 1, shorts(&[1])),
        (317, short, 1, shorts(&[3])),
        (339, short, 1, shorts(&[3])),
        (33550, double, 3, doubles(&[1.0, 1.0, 0.0])),
        (33922, double, 6, doubles(&[0.0, 0.0, 0.0, 400_000.0, 5_400_000.0, 0.0])),
        (34735, short, 16, keys),
    ];
    let count = offsets.len() as u64;
    tags.extend(match is_tiled {
        true => vec![
            (322, long8, 1, le(&[TILE as u64])),
            (323, long8, 1, le(&[TILE as u64])),
            (324, long8, count, le(offsets)),
            (325, long8, count, le(lengths)),
        ],
        false => {
            vec![(273, long8, count, le(offsets)), (278, long8, 1, le(&[1])), (279, long8, count, le(lengths))]
        }
    });
    tags.sort_by_key(|tag| tag.0);
    tags
}
