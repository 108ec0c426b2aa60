//! State of a file that was written earlier: a full disk or an interrupted copy may have cut its
//! end.
//!
//! Cells and features are not decoded where the file itself declares its end. Where it holds
//! checksums, they are checked.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use flatgeobuf::packed_r_tree::PackedRTree;
use flatgeobuf::size_prefixed_root_as_header;
use serde_json::value::RawValue;

use super::format::Format;
use crate::error::{Error, ReadFault};
use crate::formats::{RasterFile, is_whole_exr};

/// State of a file that was written earlier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Left {
    /// It begins and ends as its format does.
    Whole,
    /// It begins as its format does, and is cut short or damaged further on.
    Damaged,
    /// It does not begin as its format does, or cannot be read.
    Strange,
}

/// Largest header of a FlatGeobuf file that is read \[bytes\].
const MOST_HEADER_BYTES: u32 = 64 << 20;

/// Returns the state of a file of a format that maps are written in.
///
/// Cost: that of reading it; of a GeoTIFF and of a vector picture that of its ends.
pub fn left_of(path: &Path, format: Format) -> Left {
    let mut head = Vec::new();
    match File::open(path).and_then(|file| file.take(8).read_to_end(&mut head)) {
        Ok(_) if begins_as(format, &head) => {}
        _ => return Left::Strange,
    }
    if is_whole(path, format).unwrap_or(false) { Left::Whole } else { Left::Damaged }
}

/// Returns `true` when `head` begins with the first bytes of a format, or is itself the beginning
/// of them.
fn begins_as(format: Format, head: &[u8]) -> bool {
    let beginnings: &[&[u8]] = match format {
        Format::Png => &[b"\x89PNG"],
        Format::Pdf => &[b"%PDF"],
        Format::GeoTiff => &[b"II", b"MM"],
        Format::Exr => &[b"v/1\x01"],
        Format::Npz | Format::Kmz => &[b"PK"],
        Format::FlatGeobuf => &[b"fgb"],
        Format::Parquet => &[b"PAR1"],
        Format::AsciiGrid => &[b"ncols"],
        Format::Json | Format::GeoJson => &[b"{"],
        Format::Svg | Format::Html | Format::Vrt | Format::Mitsuba | Format::Gpx | Format::Kml => &[b"<"],
        // Numbers and tables begin with anything.
        Format::Bil | Format::Csv | Format::Stdout => &[b""],
    };
    beginnings.iter().any(|beginning| head.starts_with(beginning) || beginning.starts_with(head))
}

fn is_whole(path: &Path, format: Format) -> io::Result<bool> {
    let ends_with = |end: &[u8]| tail(path).map(|tail| tail.trim_ascii_end().ends_with(end));
    match format {
        Format::Png => is_whole_png(path),
        Format::Pdf => ends_with(b"%%EOF"),
        Format::Svg => ends_with(b"</svg>"),
        Format::Html => ends_with(b"</html>"),
        Format::Vrt => ends_with(b"</VRTDataset>"),
        Format::Gpx => ends_with(b"</gpx>"),
        Format::Kml => ends_with(b"</kml>"),
        Format::Mitsuba => ends_with(b"</scene>"),
        Format::Parquet => tail(path).map(|tail| tail.ends_with(b"PAR1")),
        Format::Csv => tail(path).map(|tail| tail.ends_with(b"\n")),
        Format::GeoTiff => Ok(RasterFile::open(path, &mut Vec::new()).is_ok()),
        Format::AsciiGrid => Ok(is_whole_grid(path)),
        Format::Bil => is_whole_bil(path),
        Format::Exr => Ok(is_whole_exr(path)),
        Format::Npz | Format::Kmz => is_whole_zip(path),
        Format::FlatGeobuf => is_whole_flatgeobuf(path),
        Format::Json | Format::GeoJson => {
            Ok(serde_json::from_reader::<_, Box<RawValue>>(BufReader::new(File::open(path)?)).is_ok())
        }
        Format::Stdout => Ok(true),
    }
}

/// Returns `true` when chunks with right checksums follow one another up to the last.
fn is_whole_png(path: &Path) -> io::Result<bool> {
    const SIGNATURE_BYTES: usize = 8;
    let bytes = std::fs::read(path)?;
    let mut left = bytes.get(SIGNATURE_BYTES..).unwrap_or_default();
    while let Some((length, rest)) = left.split_first_chunk::<4>() {
        let length = u32::from_be_bytes(*length) as usize;
        let Some((named, rest)) = length.checked_add(4).and_then(|n| rest.split_at_checked(n)) else { break };
        let Some((checksum, rest)) = rest.split_first_chunk::<4>() else { break };
        if zlib_rs::crc32::crc32(0, named) != u32::from_be_bytes(*checksum) {
            break;
        }
        if named.starts_with(b"IEND") {
            return Ok(rest.is_empty());
        }
        left = rest;
    }
    Ok(false)
}

/// Returns `true` when the members of an archive have the checksums that it declares.
fn is_whole_zip(path: &Path) -> io::Result<bool> {
    let Ok(mut archive) = zip::ZipArchive::new(BufReader::new(File::open(path)?)) else { return Ok(false) };
    let n = archive.len();
    let is_whole = |k| archive.by_index(k).is_ok_and(|mut member| io::copy(&mut member, &mut io::sink()).is_ok());
    Ok((0..n).all(is_whole))
}

/// Returns the last bytes of a file.
fn tail(path: &Path) -> io::Result<Vec<u8>> {
    const BYTES: u64 = 64;
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(BYTES)))?;
    let mut tail = Vec::new();
    file.read_to_end(&mut tail)?;
    Ok(tail)
}

fn is_whole_grid(path: &Path) -> bool {
    let file = RasterFile::open(path, &mut Vec::new());
    match file.and_then(|file| file.for_each_row(&mut Vec::new(), |_, _| {})) {
        // All cells may be void.
        Err(Error::Read(error)) => matches!(error.fault, ReadFault::AllVoid(..)),
        read => read.is_ok(),
    }
}

/// Returns `true` when there are as many bytes as the header beside the numbers declares.
fn is_whole_bil(path: &Path) -> io::Result<bool> {
    let header = std::fs::read_to_string(path.with_extension("hdr"))?;
    let number = |key: &str| -> Option<u64> {
        let line = header.lines().find_map(|line| line.strip_prefix(key));
        line.and_then(|value| value.trim().parse().ok())
    };
    let bytes = number("NROWS ").zip(number("TOTALROWBYTES ")).map(|(n_rows, bytes)| n_rows.saturating_mul(bytes));
    Ok(bytes == Some(std::fs::metadata(path)?.len()))
}

/// Returns `true` when features follow one another up to the end of the file, as many as its header
/// declares.
fn is_whole_flatgeobuf(path: &Path) -> io::Result<bool> {
    const MAGIC_BYTES: u64 = 8;
    let mut file = BufReader::new(File::open(path)?);
    let length = file.get_ref().metadata()?.len();
    let mut at = MAGIC_BYTES;
    let size_at = |file: &mut BufReader<File>, at: u64| {
        let mut size = [0; 4];
        file.seek(SeekFrom::Start(at))?;
        file.read_exact(&mut size)?;
        Ok::<u32, io::Error>(u32::from_le_bytes(size))
    };
    let header_bytes = size_at(&mut file, at)?;
    if header_bytes > MOST_HEADER_BYTES {
        return Ok(false);
    }
    let mut header = header_bytes.to_le_bytes().to_vec();
    file.by_ref().take(header_bytes.into()).read_to_end(&mut header)?;
    let Ok(header) = size_prefixed_root_as_header(&header) else { return Ok(false) };
    at += 4 + u64::from(header_bytes);
    let (n_features, node_size) = (header.features_count(), header.index_node_size());
    let Ok(n_boxes) = usize::try_from(n_features) else { return Ok(false) };
    if n_boxes > 0 && node_size >= 2 {
        at = at.saturating_add(PackedRTree::index_size(n_boxes, node_size) as u64);
    }
    let mut n_found = 0;
    while at < length {
        at = at.saturating_add(4 + u64::from(size_at(&mut file, at)?));
        n_found += 1;
    }
    Ok(at == length && n_found == n_features)
}
