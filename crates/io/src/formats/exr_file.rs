//! OpenEXR files: named channels of 32-bit numbers, lossless, in one part, placed on the map as
//! GDAL does it.
//!
//! | attribute | read by GDAL and QGIS as |
//! |---|---|
//! | `gdal:crsWkt` | definition of the coordinate system |
//! | `gdal:geoTransform` | place, of type `m33d`: rows `[dx, 0, x0]`, `[0, −dy, y0]`, `[0, 0, 1]` |
//! | any other `gdal:NAME` | metadata item NAME |
//!
//! Channels appear as bands in the order of their names. No data is NaN.
//!
//! # References
//! OpenEXR file layout (openexr.com, version 3); the EXR driver of GDAL,
//! `frmts/exr/exrdataset.cpp`.

use std::fs::File;
use std::io::{BufReader, Cursor, Write};
use std::path::Path;

use exr::block::BlockIndex;
use exr::image::write::WritableImage;
use exr::image::write::channels::{ChannelsWriter, WritableChannels};
use exr::image::{Encoding, Image, Layer};
use exr::math::RoundingMode;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, ChannelDescription, ChannelList, LevelMode, LineOrder, SampleType, Text};
use exr::meta::header::{Header, LayerAttributes};
use exr::prelude::{Blocks, Compression};

use super::ExrChannel;
use crate::error::{Error, Result};
use crate::input::Input;
use crate::raster::GeoRef;

/// Writes channels and metadata as an OpenEXR file, compressed with ZIP in blocks of 16 rows.
///
/// # Errors
/// E401 if `out` refuses the bytes. E402 if the format cannot hold the image (no channel, two
/// channels of one name, a name of more than 255 bytes, more than 2³¹ rows or columns).
///
/// # Panics
/// If a channel does not hold one value per cell.
pub fn write_exr(
    out: &mut impl Write,
    georef: &GeoRef,
    channels: &[(String, ExrChannel<'_>)],
    metadata: &[(String, String)],
) -> Result<()> {
    let channels = Channels::new(georef, channels)?;
    let mut attributes = LayerAttributes::default();
    let mut add = |name: &str, value| attributes.other.insert(text(&format!("gdal:{name}")), value);
    for (name, value) in metadata {
        add(name, AttributeValue::Text(text(value)));
    }
    if let Some(wkt) = georef.crs().and_then(crate::crs::wkt_of) {
        add("crsWkt", AttributeValue::Text(text(&wkt)));
    }
    add("geoTransform", geo_transform(georef));

    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let layer = Layer::new((georef.n_cols(), georef.n_rows()), attributes, encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).map_err(|cause| cannot_encode(&cause.to_string()))?;
    let mut bytes = bytes.into_inner();
    sort_attributes(&mut bytes).ok_or_else(|| cannot_encode("its header is not as expected"))?;
    out.write_all(&bytes).map_err(|cause| Error::refused("an OpenEXR file", &cause))
}

fn cannot_encode(why: &str) -> Error {
    Error::encode("an OpenEXR file", why)
}

/// Returns the bytes of a string; readers take them as UTF-8.
fn text(string: &str) -> Text {
    Text::from_slice_unchecked(string.as_bytes())
}

/// Returns the place as nine numbers of 64 bits, row by row.
fn geo_transform(georef: &GeoRef) -> AttributeValue {
    let (dx, dy) = (georef.cell_width(), georef.cell_height());
    let matrix = [dx, 0.0, georef.x_min(), 0.0, -dy, georef.y_max(), 0.0, 0.0, 1.0];
    AttributeValue::Custom {
        kind: text("m33d"),
        bytes: matrix.iter().flat_map(|number| number.to_le_bytes()).collect(),
    }
}

/// Borrowed channels in the order of their names.
struct Channels<'a> {
    sorted: Vec<(&'a str, ExrChannel<'a>)>,
    n_cols: usize,
}

impl<'a> Channels<'a> {
    fn new(georef: &GeoRef, channels: &'a [(String, ExrChannel<'a>)]) -> Result<Self> {
        let mut sorted: Vec<(&str, ExrChannel<'_>)> = channels.iter().map(|(name, c)| (name.as_str(), *c)).collect();
        sorted.sort_by_key(|(name, _)| *name);
        if sorted.is_empty() {
            return Err(cannot_encode("it has no channel"));
        }
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            return Err(cannot_encode(&format!("two channels are called `{}`", pair[0].0)));
        }
        for (name, channel) in &sorted {
            let len = match channel {
                ExrChannel::Float(values) => values.len(),
                ExrChannel::UInt(values) => values.len(),
            };
            assert_eq!(len, georef.n_cells(), "channel `{name}` holds one value per cell");
        }
        Ok(Channels { sorted, n_cols: georef.n_cols() })
    }
}

impl<'slf> WritableChannels<'slf> for Channels<'slf> {
    type Writer = BlockWriter<'slf>;

    fn infer_channel_list(&self) -> ChannelList {
        let description = |(name, channel): &(&str, ExrChannel<'_>)| {
            let sample_type = match channel {
                ExrChannel::Float(_) => SampleType::F32,
                ExrChannel::UInt(_) => SampleType::U32,
            };
            ChannelDescription::new(text(name), sample_type, false)
        };
        ChannelList::new(self.sorted.iter().map(description).collect())
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_writer(&'slf self, _: &Header) -> BlockWriter<'slf> {
        BlockWriter(self)
    }
}

/// Writer of blocks of rows: in each row all of the first channel, then all of the second, and so
/// on.
struct BlockWriter<'a>(&'a Channels<'a>);

impl ChannelsWriter for BlockWriter<'_> {
    fn extract_uncompressed_block(&self, _: &Header, block: BlockIndex) -> Vec<u8> {
        let Channels { sorted, n_cols } = self.0;
        let (first_row, n_rows) = (block.pixel_position.1, block.pixel_size.1);
        let mut bytes = Vec::with_capacity(n_rows * n_cols * sorted.len() * 4);
        for row in first_row..first_row + n_rows {
            let cells = row * n_cols..(row + 1) * n_cols;
            for (_, channel) in sorted {
                match channel {
                    ExrChannel::Float(values) => {
                        bytes.extend(values[cells.clone()].iter().flat_map(|value| value.to_ne_bytes()));
                    }
                    ExrChannel::UInt(values) => {
                        bytes.extend(values[cells.clone()].iter().flat_map(|value| value.to_ne_bytes()));
                    }
                }
            }
        }
        bytes
    }
}

/// Sorts the attributes in the header of a one-part file by name; `None` if the file does not begin
/// with a header.
///
/// The crate keeps them in a hash map, so that the same image would give other bytes in each run.
/// The length of the header stays, and with it all offsets.
fn sort_attributes(file: &mut [u8]) -> Option<()> {
    // Magic number and version, then `name 0 type 0 length value` for each attribute, then one more
    // 0.
    let start = 8;
    let (mut at, mut attributes) = (start, Vec::new());
    while *file.get(at)? != 0 {
        let name = file[at..].iter().position(|&byte| byte == 0)?;
        let kind = file[at + name + 1..].iter().position(|&byte| byte == 0)?;
        let value = at + name + kind + 2;
        let len = u32::from_le_bytes(file.get(value..value + 4)?.try_into().ok()?);
        let end = value + 4 + usize::try_from(len).ok()?;
        attributes.push(file.get(at..end)?.to_vec());
        at = end;
    }
    attributes.sort();
    file[start..at].copy_from_slice(&attributes.concat());
    Some(())
}

/// Returns the first text attribute of a file that begins with some words.
pub(super) fn exr_text(input: &Input, beginning: &str) -> Option<String> {
    let headers = MetaData::read_from_buffered(BufReader::new(input.open().ok()?.0), false).ok()?.headers;
    let mut attributes = headers.first()?.own_attributes.other.values();
    attributes.find_map(|value| match value {
        AttributeValue::Text(text) => {
            std::str::from_utf8(text.bytes()).ok().filter(|text| text.starts_with(beginning)).map(str::to_string)
        }
        _ => None,
    })
}

/// Returns `true` if all blocks of a file can be read.
pub(crate) fn is_whole_exr(path: &Path) -> bool {
    let Ok(file) = File::open(path) else { return false };
    let chunks = exr::block::read(BufReader::new(file), false).and_then(|reader| reader.all_chunks(false));
    chunks.is_ok_and(|mut chunks| chunks.all(|chunk| chunk.is_ok()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unusable_channels_are_refused() {
        let georef = GeoRef::new((0.0, 0.0), (1.0, 1.0), (1, 1), None).unwrap();
        let twice = [("a".to_string(), ExrChannel::UInt(&[1])), ("a".to_string(), ExrChannel::UInt(&[2]))];
        for channels in [&twice[..], &[]] {
            assert_eq!(write_exr(&mut Vec::new(), &georef, channels, &[]).unwrap_err().code(), "E402");
        }
    }
}
