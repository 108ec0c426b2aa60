//! Provenance that this program wrote into a picture, raster or archive.

use std::io::{BufReader, Read};

use super::RasterFile;
use super::exr_file::exr_text;
use crate::input::Input;

/// Longest text that is read \[bytes\].
const MOST_BYTES: u64 = 64 << 20;

/// Beginning of every provenance text.
const BEGINNING: &str = "{\"schema\":\"skyshed/";

/// Returns the provenance in a GeoTIFF, PNG, OpenEXR file or numpy archive of this program, as
/// JSON. `None` for files of other programs, damaged ones, and formats that hold none.
pub fn origin_of(input: impl Into<Input>) -> Option<String> {
    let input = &input.into();
    let mut head = [0; 4];
    input.open().ok()?.0.read_exact(&mut head).ok()?;
    let text = match &head {
        b"\x89PNG" => of_png(input),
        b"v/1\x01" => exr_text(input, BEGINNING),
        b"PK\x03\x04" => of_npz(input),
        [b'I', b'I', ..] | [b'M', b'M', ..] => match RasterFile::open(input, &mut Vec::new()).ok()? {
            RasterFile::GeoTiff(tiff) => tiff.provenance().map(str::to_string),
            _ => None,
        },
        _ => None,
    };
    text.filter(|text| text.starts_with(BEGINNING))
}

fn of_png(input: &Input) -> Option<String> {
    let reader = png::Decoder::new(BufReader::new(input.open().ok()?.0)).read_info().ok()?;
    let chunk = reader.info().utf8_text.iter().find(|chunk| chunk.keyword == "skyshed")?;
    chunk.get_text().ok()
}

/// Reads the entry `meta` of an archive: a numpy array of one text in UTF-32.
fn of_npz(input: &Input) -> Option<String> {
    let mut archive = zip::ZipArchive::new(BufReader::new(input.open().ok()?.0)).ok()?;
    let mut bytes = Vec::new();
    archive.by_name("meta.npy").ok()?.take(MOST_BYTES).read_to_end(&mut bytes).ok()?;
    // Six bytes of magic, two of version, two of the length of the header.
    let header = usize::from(u16::from_le_bytes(*bytes.get(8..)?.first_chunk::<2>()?));
    let text = bytes.get(10 + header..)?.chunks_exact(4);
    text.map(|unit| char::from_u32(u32::from_le_bytes([unit[0], unit[1], unit[2], unit[3]])))
        .take_while(|unit| *unit != Some('\0'))
        .collect()
}
