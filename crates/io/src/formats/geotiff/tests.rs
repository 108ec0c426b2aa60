//! Headers made by hand, good and bad.

use super::GeoTiff;
use super::geo_tiff::nodata_in;
use super::metadata::Metadata;
use super::stored::turn_over;
use crate::error::{Result, Warning};
use crate::formats::sample::Sample;
use crate::input::Input;

/// A tag: code, field type, values as 32-bit numbers.
type Tag = (u16, u16, &'static [u32]);

/// Returns a little-endian classic TIFF of one image with these tags, then `pixels`.
///
/// An offset of strips or tiles other than 0 counts from 1 at the first byte of `pixels`.
fn tiff(tags: &[Tag], pixels: &[u8]) -> Vec<u8> {
    let directory_len = u32::try_from(2 + 12 * tags.len() + 4).expect("few tags");
    let mut values: Vec<u8> = Vec::new();
    let values_len: usize = tags.iter().filter(|t| t.2.len() > 1).map(|t| 4 * t.2.len()).sum();
    let pixels_at = 8 + directory_len + u32::try_from(values_len).expect("few values");
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    bytes.extend(u16::try_from(tags.len()).expect("few tags").to_le_bytes());
    for (code, kind, numbers) in tags {
        let shift = |n: u32| if matches!(code, 273 | 324) && n != 0 { n - 1 + pixels_at } else { n };
        bytes.extend(code.to_le_bytes());
        bytes.extend(kind.to_le_bytes());
        bytes.extend(u32::try_from(numbers.len()).expect("few values").to_le_bytes());
        if let [number] = numbers {
            bytes.extend(shift(*number).to_le_bytes());
        } else {
            let at = 8 + directory_len + u32::try_from(values.len()).expect("few values");
            bytes.extend(at.to_le_bytes());
            values.extend(numbers.iter().flat_map(|n| shift(*n).to_le_bytes()));
        }
    }
    bytes.extend([0; 4]);
    bytes.extend(values);
    bytes.extend(pixels);
    bytes
}

/// Returns the tags of 3 x 2 cells of one byte in one strip, one of them replaced.
fn tags_with(replaced: Tag) -> Vec<Tag> {
    let mut tags: Vec<Tag> = vec![
        (256, 4, &[3]),
        (257, 4, &[2]),
        (258, 3, &[8]),
        (259, 3, &[1]),
        (262, 3, &[1]),
        (273, 4, &[1]),
        (277, 3, &[1]),
        (278, 4, &[2]),
        (279, 4, &[6]),
        (317, 3, &[1]),
        (339, 3, &[1]),
    ];
    tags.retain(|tag| tag.0 != replaced.0);
    tags.push(replaced);
    tags.sort_by_key(|tag| tag.0);
    tags
}

fn open(bytes: Vec<u8>) -> (Result<GeoTiff>, Vec<Warning>) {
    let mut warnings = Vec::new();
    let tiff = GeoTiff::open(Input::bytes("a.tif", bytes), &mut warnings).and_then(|tiff| {
        tiff.read(tiff.georef().window(), &mut warnings, |height| height)?;
        Ok(tiff)
    });
    (tiff, warnings)
}

#[test]
fn each_bad_tag_is_named() {
    let cases: [(Tag, &str, &str); 19] = [
        ((256, 4, &[0]), "E302", "width `0`"),
        ((257, 4, &[2, 2]), "E302", "tag 257 holds 2 values"),
        ((257, 4, &[4_000_000_000]), "E303", "need 2000000000 strips"),
        ((258, 3, &[17]), "E304", "17-bit unsigned integer"),
        ((258, 3, &[1]), "E304", "1-bit samples"),
        ((258, 99, &[8]), "E302", "tag 258 holds 1 values of field type `99`"),
        ((259, 3, &[999]), "E304", "compression `999`"),
        ((259, 3, &[34925]), "E304", "LZMA"),
        ((273, 4, &[1_000_000]), "E303", "ends beyond the file"),
        ((273, 4, &[0]), "E305", "none of the 6 cells"),
        ((277, 3, &[0]), "E302", "0 samples per cell"),
        ((277, 3, &[9]), "E303", "cannot hold 54"),
        ((278, 4, &[0]), "E302", "0 rows per strip"),
        ((279, 4, &[5]), "E303", "cannot hold 6"),
        ((279, 4, &[]), "E302", "tag 279 holds 0 values"),
        ((284, 3, &[3]), "E302", "planar configuration `3`"),
        ((338, 3, &[0, 0]), "E302", "2 extra samples"),
        ((339, 3, &[5]), "E304", "complex"),
        ((266, 3, &[3]), "E302", "fill order `3`"),
    ];
    for (tag, code, text) in cases {
        let (tiff, _) = open(tiff(&tags_with(tag), &[1, 2, 3, 4, 5, 6]));
        let error = tiff.expect_err(text);
        assert_eq!(error.code(), code, "{error}");
        assert!(error.to_string().contains(text), "{text}: {error}");
        assert!(error.to_string().contains("a.tif"), "the file is named: {error}");
    }
}

#[test]
fn a_plain_header_is_described() {
    let (tiff, warnings) = open(tiff(&tags_with((278, 4, &[u32::MAX])), &[1, 2, 3, 4, 5, 6]));
    let tiff = tiff.expect("a good file");
    assert_eq!(tiff.description(), "uint8, uncompressed, strips of 2 rows");
    let codes: Vec<String> = warnings.iter().map(Warning::code).collect();
    assert_eq!(codes, ["W327", "W325"], "no place, no CRS");
}

#[test]
fn nodata_compares_in_the_type_of_the_samples() {
    assert_eq!(nodata_in(Sample::F32, "-3.4028234663852886e+38"), Some(f64::from(f32::MIN)));
    assert_eq!(nodata_in(Sample::F32, "-3.40282346638529e+38 "), Some(f64::from(f32::MIN)));
    assert_eq!(nodata_in(Sample::F32, "0.1"), Some(f64::from(0.1f32)));
    assert_eq!(nodata_in(Sample::F64, "0.1"), Some(0.1));
    assert_eq!(nodata_in(Sample::I16, "-32768"), Some(-32768.0));
    assert_eq!(nodata_in(Sample::F32, "-inf"), Some(f64::NEG_INFINITY));
    assert!(nodata_in(Sample::F32, "nan").is_some_and(f64::is_nan));
    assert_eq!(nodata_in(Sample::F32, "abcde"), None);
}

#[test]
fn rows_are_turned_over_in_place() {
    let mut cells = [1, 2, 3, 4, 5, 6];
    turn_over(&mut cells, 2);
    assert_eq!(cells, [5, 6, 3, 4, 1, 2]);
    turn_over(&mut cells, 3);
    assert_eq!(cells, [4, 1, 2, 5, 6, 3]);
}

#[test]
fn metadata_gives_scale_offset_and_unit() {
    let metadata = Metadata::parse(
        r#"<GDALMetadata>
          <Item name="OFFSET" sample="0" role="offset">-50</Item>
          <Item name="SCALE" sample="0" role="scale">0.1</Item>
          <Item name="UNITTYPE" sample="0" role="unittype">ft</Item>
          <Item name="SCALE" sample="1" role="scale">oops</Item>
        </GDALMetadata>"#,
    );
    assert_eq!(metadata.scaling(0), (0.1, -50.0));
    assert_eq!(metadata.scaling(1), (1.0, 0.0));
    assert_eq!(metadata.unit(0), Some("ft"));
}
