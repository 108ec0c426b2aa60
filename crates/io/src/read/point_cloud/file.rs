//! Header of a point cloud, checked before anything in it is believed, and its variable-length
//! records.
//!
//! # References
//! LAS specification 1.4-R15 (ASPRS, 2019); COPC 1.0; `laz`, for the record of LASzip.

use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};

use las::point::Format;
use las::raw;
use laz::{LazItemRecordBuilder, LazVlr};

use super::systems::{Systems, systems_of};
use crate::error::{Cause, Error, ReadFault, Result, Wanted};
use crate::input::{Input, Reader};

/// Length of the head of a record: of a plain one, and of an extended one \[bytes\].
const RECORD_HEADS: [u64; 2] = [54, 60];
/// Longest extended record that is read \[bytes\]: a text of a reference system.
const LONGEST_TEXT: u64 = 1 << 20;
/// Most extended records that are looked at.
const MOST_EXTENDED: u32 = 1000;
/// Most points for each byte of a compressed file.
const MOST_POINTS_PER_BYTE: u64 = 1000;
/// Most bytes of a record of one point; format 10 has 67.
const LONGEST_POINT: u16 = 4096;

/// A point cloud, by its header.
#[derive(Debug, Clone)]
pub(super) struct CloudFile<'a> {
    pub(super) input: &'a Input,
    /// Length of the file \[bytes\].
    pub(super) length: u64,
    /// Number of points.
    pub(super) n_points: u64,
    /// Offset of the points \[bytes\].
    pub(super) points_at: u64,
    /// Compression of the points; `None` if they are stored as they are.
    pub(super) packing: Option<Packing>,
    /// Octree of COPC.
    pub(super) octree: Option<OctreeInfo>,
    pub(super) records: RecordForm,
    /// Bounds in the header: west, south, east, north \[CRS units\].
    pub(super) bounds: [f64; 4],
    pub(super) systems: Systems,
}

/// Compression of points by LASzip.
#[derive(Debug, Clone)]
pub(super) struct Packing {
    pub(super) laz: LazVlr,
    /// `true` if points come in chunks, after the offset of a table of these.
    pub(super) is_chunked: bool,
}

/// Form of the record of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RecordForm {
    /// Length \[bytes\].
    pub(super) length: usize,
    /// Point format, 0 to 10.
    pub(super) format: u8,
    /// Bytes beyond the fields of the format.
    pub(super) n_extra: u16,
    /// Factor and summand of x, y and z.
    pub(super) scaling: [(f64, f64); 3],
}

/// Place of the octree of COPC.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OctreeInfo {
    /// Center of the root cube, along x and y \[CRS units\].
    pub(super) center: [f64; 2],
    /// Half the edge of the root cube \[CRS units\].
    pub(super) half: f64,
    /// Offset and length of the root page \[bytes\].
    pub(super) root_page: (u64, u64),
}

/// Variable-length record of a header.
pub(super) struct Record {
    pub(super) user: String,
    pub(super) id: u16,
    pub(super) data: Vec<u8>,
}

impl<'a> CloudFile<'a> {
    /// Opens a point cloud and checks its header.
    ///
    /// # Errors
    /// E301 if it cannot be read; E302 to E304 for a header that is damaged, cut short or of an
    /// unknown version; E308 for a cloud without points.
    pub(super) fn open(input: &'a Input) -> Result<CloudFile<'a>> {
        let (reader, length) = input.open()?;
        let mut reader = BufReader::with_capacity(1 << 16, reader);
        let header = raw::Header::read_from(&mut reader).map_err(|error| damaged(input, &error))?;
        let records = record_form(input, &header)?;
        let n_points = match (header.number_of_point_records, header.large_file) {
            (0, Some(large)) => large.number_of_point_records,
            (n, Some(large)) if large.number_of_point_records != u64::from(n) => {
                let found = format!("its header announces {n} points, and {} points", large.number_of_point_records);
                return Err(bad_header(input, found));
            }
            (n, _) => u64::from(n),
        };
        if n_points == 0 {
            return Err(Error::read(input, ReadFault::Nothing(Wanted::Points)));
        }
        let bounds = [header.min_x, header.min_y, header.max_x, header.max_y];
        let [west, south, east, north] = bounds;
        if !(bounds.iter().all(|v| v.is_finite()) && west <= east && south <= north) {
            let what = format!("its bounds are x {west}…{east}, y {south}…{north}, wanted finite ones in this order");
            return Err(bad_header(input, what));
        }
        let points_at = u64::from(header.offset_to_point_data);
        if points_at < u64::from(header.header_size) || points_at > length {
            let what = format!("its points begin at byte {points_at} of {length}, wanted a place after the header");
            return Err(bad_header(input, what));
        }
        let found = records_of(input, (&mut reader, length), &header)?;
        let of = |user: &str, id: u16| found.iter().find(|record| record.user == user && record.id == id);
        let is_compressed = header.point_data_record_format & 0x80 != 0;
        let packing = match (is_compressed, of(LazVlr::USER_ID, LazVlr::RECORD_ID)) {
            (false, _) => None,
            (true, Some(record)) => Some(compression(input, &record.data, records)?),
            (true, None) => return Err(Error::malformed(input, "it has no record of its compression, wanted one")),
        };
        check_count((input, length), (n_points, points_at), (records, is_compressed))?;
        let octree = of("copc", 1).filter(|_| is_compressed).and_then(|record| OctreeInfo::of(&record.data));
        let systems = systems_of(input, &found);
        Ok(CloudFile { input, length, n_points, points_at, packing, octree, records, bounds, systems })
    }

    /// Opens the file again, for its points.
    ///
    /// # Errors
    /// E301 if it cannot be read.
    pub(super) fn reader(&self) -> Result<BufReader<Reader>> {
        Ok(BufReader::with_capacity(1 << 16, self.input.open()?.0))
    }

    /// Returns `true` if its bounds meet a box: west, south, east, north \[CRS units\].
    pub(super) fn meets(&self, [west, south, east, north]: [f64; 4]) -> bool {
        let [w, s, e, n] = self.bounds;
        w < east && e >= west && s < north && n >= south
    }
}

impl OctreeInfo {
    /// Reads the record of COPC; `None` if it makes no sense.
    fn of(data: &[u8]) -> Option<OctreeInfo> {
        let float = |at: usize| Some(f64::from_le_bytes(data.get(at..at + 8)?.try_into().ok()?));
        let whole = |at: usize| Some(u64::from_le_bytes(data.get(at..at + 8)?.try_into().ok()?));
        let (center, half) = ([float(0)?, float(8)?], float(24)?);
        let is_cube = center.iter().all(|v| v.is_finite()) && half.is_finite() && half > 0.0;
        is_cube.then_some(OctreeInfo { center, half, root_page: (whole(40)?, whole(48)?) })
    }
}

/// Returns the form of the records of points.
fn record_form(input: &Input, header: &raw::Header) -> Result<RecordForm> {
    let version = header.version;
    if version.major != 1 || version.minor > 4 {
        return Err(Error::unsupported(input, format!("LAS {version}, wanted a version from 1.0 to 1.4")));
    }
    let format = header.point_data_record_format & 0x3f;
    let fields = Format::new(format).ok().filter(|_| format <= 10 && header.point_data_record_format & 0x40 == 0);
    let Some(fields) = fields else {
        let what = format!("points of format {}, wanted 0 to 10", header.point_data_record_format);
        return Err(Error::unsupported(input, what));
    };
    let length = header.point_data_record_length;
    let n_extra = length.checked_sub(fields.len()).filter(|_| length <= LONGEST_POINT);
    let Some(n_extra) = n_extra else {
        let wanted = fields.len();
        return Err(bad_header(
            input,
            format!("its points have {length} bytes each, wanted {wanted} to {LONGEST_POINT}"),
        ));
    };
    let scaling = [
        (header.x_scale_factor, header.x_offset),
        (header.y_scale_factor, header.y_offset),
        (header.z_scale_factor, header.z_offset),
    ];
    if let Some((scale, offset)) = scaling.iter().find(|(s, o)| !(s.is_normal() && o.is_finite())) {
        let what = format!("its coordinates are scaled by {scale} and moved by {offset}, wanted finite numbers, no 0");
        return Err(bad_header(input, what));
    }
    Ok(RecordForm { length: usize::from(length), format, n_extra, scaling })
}

/// Reads the records of a header that may be of use: all plain ones, and short extended ones.
fn records_of(
    input: &Input,
    (reader, length): (&mut BufReader<Reader>, u64),
    header: &raw::Header,
) -> Result<Vec<Record>> {
    let failed = |error: std::io::Error| cut_short(input, &error);
    let end = u64::from(header.offset_to_point_data);
    let mut at = u64::from(header.header_size);
    reader.seek(SeekFrom::Start(at)).map_err(failed)?;
    let mut found = Vec::new();
    for k in 0..header.number_of_variable_length_records {
        let (mut record, n) = record_head(reader, false).map_err(failed)?;
        at += RECORD_HEADS[0] + n;
        if at > end {
            let what = format!("record {} ends at byte {at}, wanted one before the points at byte {end}", k + 1);
            return Err(bad_header(input, what));
        }
        record.data = read_bytes(reader, n).map_err(failed)?;
        found.push(record);
    }
    let extended = header.evlr.filter(|extended| extended.number_of_evlrs > 0);
    let Some(extended) = extended else { return Ok(found) };
    let mut at = extended.start_of_first_evlr;
    for k in 0..extended.number_of_evlrs.min(MOST_EXTENDED) {
        // Files are often cut off after their points, which are whole.
        if at.checked_add(RECORD_HEADS[1]).is_none_or(|end| end > length) {
            break;
        }
        reader.seek(SeekFrom::Start(at)).map_err(failed)?;
        let (mut record, n) = record_head(reader, true).map_err(failed)?;
        let Some(end) = at.checked_add(RECORD_HEADS[1]).and_then(|at| at.checked_add(n)).filter(|end| *end <= length)
        else {
            let what = format!("extended record {} has {n} bytes at byte {at} of {length}", k + 1);
            return Err(bad_header(input, what));
        };
        if n <= LONGEST_TEXT && record.user.eq_ignore_ascii_case("LASF_Projection") {
            record.data = read_bytes(reader, n).map_err(failed)?;
            found.push(record);
        }
        at = end;
    }
    Ok(found)
}

/// Reads the head of a record, and the length of its data.
fn record_head(reader: &mut impl Read, is_extended: bool) -> std::io::Result<(Record, u64)> {
    let mut head = [0_u8; 60];
    let head = &mut head[..if is_extended { 60 } else { 54 }];
    reader.read_exact(head)?;
    let user = head[2..18].split(|byte| *byte == 0).next().unwrap_or_default();
    let user = String::from_utf8_lossy(user).into_owned();
    let id = u16::from_le_bytes([head[18], head[19]]);
    let length = match is_extended {
        false => u64::from(u16::from_le_bytes([head[20], head[21]])),
        true => u64::from_le_bytes(std::array::from_fn(|k| head[20 + k])),
    };
    Ok((Record { user, id, data: Vec::new() }, length))
}

/// Reads some bytes; memory grows with those that are there.
fn read_bytes(reader: &mut impl Read, n: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    reader.take(n).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == n { Ok(bytes) } else { Err(ErrorKind::UnexpectedEof.into()) }
}

/// Reads the record of LASzip, whose items must be those of the point format.
fn compression(input: &Input, data: &[u8], records: RecordForm) -> Result<Packing> {
    let laz = LazVlr::read_from(data)
        .map_err(|error| Error::malformed(input, format!("its record of the compression is damaged ({error})")))?;
    let wanted = LazItemRecordBuilder::default_for_point_format_id(records.format, records.n_extra);
    let wanted = wanted.map_err(|error| Error::unsupported(input, error.to_string()))?;
    let is_same = laz.items().len() == wanted.len()
        && laz.items().iter().zip(&wanted).all(|(a, b)| a.item_type() == b.item_type() && a.size() == b.size());
    let version = laz.items().first().map_or(0, laz::LazItem::version);
    // One chunk of all points, chunks, chunks in layers.
    let kind = data.first().copied().unwrap_or_default();
    let is_known = match (kind, records.format) {
        (1 | 2, ..6) => (1..=2).contains(&version),
        (3, 6..) => (3..=4).contains(&version),
        _ => false,
    };
    if is_same && is_known && laz.items().iter().all(|item| item.version() == version) {
        return Ok(Packing { laz, is_chunked: kind != 1 });
    }
    let what = format!("its compression is not that of points of format {}, wanted LASzip 2 or 3", records.format);
    Err(Error::unsupported(input, what))
}

/// Refuses a number of points that the file has no room for.
fn check_count(
    (input, length): (&Input, u64),
    (n_points, points_at): (u64, u64),
    (records, is_compressed): (RecordForm, bool),
) -> Result<()> {
    let room = length - points_at;
    if is_compressed {
        if n_points / MOST_POINTS_PER_BYTE > room {
            return Err(bad_header(input, format!("{n_points} points in {room} bytes, wanted fewer")));
        }
    } else if n_points.checked_mul(records.length as u64).is_none_or(|bytes| bytes > room) {
        let what = format!("{n_points} points of {} bytes each in {room} bytes, wanted fewer", records.length);
        return Err(Error::truncated(input, what).because(Cause::CutShort));
    }
    Ok(())
}

/// Returns the error for a header that promises the impossible.
fn bad_header(input: &Input, what: String) -> Error {
    Error::malformed(input, what).because(Cause::DamagedHeader)
}

/// Returns the error for bytes that are missing, or that cannot be read.
pub(super) fn cut_short(input: &Input, error: &std::io::Error) -> Error {
    match error.kind() {
        ErrorKind::UnexpectedEof => {
            Error::truncated(input, "it ends before its points do, wanted a whole point cloud").because(Cause::CutShort)
        }
        _ => Error::malformed(input, format!("its points cannot be read ({error})")).because(Cause::CutShort),
    }
}

fn damaged(input: &Input, error: &las::Error) -> Error {
    match error {
        las::Error::Io(error) => cut_short(input, error),
        error => bad_header(input, format!("its header is no LAS header ({error})")),
    }
}
