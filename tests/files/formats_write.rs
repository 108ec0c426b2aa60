//! What the raster writers write is what the reading crates read: values, places, names, and the same bytes each time.
//!
//! `cog` and `planning_tools` hold such files against GDAL and rasterio, where these are at hand.

use std::io::{Cursor, Read};

use exr::meta::attribute::AttributeValue;
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers};
use geotiff_reader::GeoTiffFile;
use skyshed_core::raster::{Crs, GeoRef};
use skyshed_io::crs;
use skyshed_io::formats::{
    Bands, ClassColor, ExrChannel, GeoTiffImage, NpyArray, encode_geotiff, pam_sidecar, world_file, write_exr,
    write_geotiff, write_npz,
};
use skyshed_request::TiffLayout;

use crate::mosaic::{codes, read, same};
use crate::program::Folder;

const SHAPE: (usize, usize) = (300, 700);

fn grid(epsg: Option<u32>) -> GeoRef {
    let crs = epsg.map(|code| crs::from_epsg(code).unwrap());
    GeoRef::new((500_000.25, 5_400_000.5), (0.5, 0.25), SHAPE, crs).unwrap()
}

fn n_cells() -> usize {
    SHAPE.0 * SHAPE.1
}

fn classes() -> Vec<u8> {
    (0..n_cells()).map(|i| [0, 1, 2, 3, 255][(i % SHAPE.1 / 50 + i / SHAPE.1 / 40) % 5]).collect()
}

fn margins() -> Vec<f32> {
    (0..=u16::MAX)
        .cycle()
        .take(n_cells())
        .map(|i| if i % 97 == 0 { -9999.0 } else { f32::from(i) / 8.0 - 3000.0 })
        .collect()
}

fn bit_sets() -> Vec<u32> {
    (0_u32..).take(n_cells()).map(|i| i.wrapping_mul(2_654_435_761)).collect()
}

fn palette() -> Vec<ClassColor> {
    let class = |value, name: &str, rgba| ClassColor { value, name: name.to_string(), rgba };
    vec![
        class(0, "NLoS", [230, 159, 0, 255]),
        class(1, "LoS", [0, 114, 178, 255]),
        class(3, "a<b> & \"c\"\u{1}ä", [9; 4]),
    ]
}

fn metadata() -> Vec<(String, String)> {
    vec![("skyshed".to_string(), r#"{"version": "1 <&> 2", "file": "straße.tif"}"#.to_string())]
}

/// A cloud optimized picture of some bands, and of nothing beside them.
pub(crate) fn image_of<'a>(georef: &'a GeoRef, bands: Bands<'a>) -> GeoTiffImage<'a> {
    GeoTiffImage { georef, bands, nodata: None, palette: None, metadata: &[], layout: TiffLayout::Cog }
}

fn written(image: &GeoTiffImage<'_>) -> GeoTiffFile {
    GeoTiffFile::from_bytes(encode_geotiff(image).unwrap()).unwrap()
}

fn classes_of(file: &GeoTiffFile) -> Vec<u8> {
    file.read_raster::<u8>().unwrap().into_iter().collect()
}

fn bits_of<'a>(values: impl IntoIterator<Item = &'a f32>) -> Vec<u32> {
    values.into_iter().map(|value| value.to_bits()).collect()
}

#[test]
fn a_mask_comes_back_from_geotiff_in_both_layouts_with_place_colors_and_names() {
    let (georef, mask, palette, metadata) = (grid(Some(25832)), classes(), palette(), metadata());
    let bands = Bands::Byte(vec![("los".to_string(), &mask)]);
    let (palette, metadata) = (Some(&palette[..]), &metadata[..]);
    let image = GeoTiffImage { nodata: Some(255.0), palette, metadata, ..image_of(&georef, bands) };
    let file = written(&image);

    assert_eq!((file.height() as usize, file.width() as usize, file.band_count()), (SHAPE.0, SHAPE.1, 1));
    assert_eq!(classes_of(&file), mask);
    assert_eq!((file.epsg(), file.nodata()), (Some(25832), Some("255")));
    assert_eq!(file.geo_bounds(), Some([georef.x_min(), georef.y_min(), georef.x_max(), georef.y_max()]));

    let ifd = file.tiff().ifd(0).unwrap();
    assert_eq!((ifd.is_tiled(), ifd.compression(), ifd.photometric_interpretation()), (true, 8, Some(3)));
    let colors = ifd.tag(320).unwrap().value.as_u16_slice().unwrap();
    assert_eq!([colors[1], colors[257], colors[513]], [0, 114 * 257, 178 * 257]);
    let items = ifd.tag(42112).unwrap().value.as_str().unwrap();
    assert!(items.contains(r#"<Item name="DESCRIPTION" sample="0" role="description">los</Item>"#), "{items}");
    // GDAL takes the escapes off twice.
    assert!(items.contains("1 &amp;lt;&amp;amp;&amp;gt; 2"), "{items}");
    assert!(items.contains("straße.tif"), "{items}");

    // Everything that is said about the cells is said in both layouts.
    let bytes = encode_geotiff(&GeoTiffImage { layout: TiffLayout::Plain, ..image }).unwrap();
    // A band is one stretch of bytes behind the header, north row first: no codec is needed to read it.
    assert_eq!(&bytes[8..8 + n_cells()], &mask);
    let plain = GeoTiffFile::from_bytes(bytes).unwrap();
    let plain_ifd = plain.tiff().ifd(0).unwrap();
    assert_eq!((plain_ifd.is_tiled(), plain_ifd.compression()), (false, 1));
    assert_eq!((plain.overview_count(), plain.tiff().ifd_count()), (0, 1));
    // 700 cells a row: strips of 12 rows reach 8192 bytes.
    assert_eq!(plain_ifd.tag(278).unwrap().value.as_u32(), Some(12));
    assert_eq!(classes_of(&plain), mask);
    assert_eq!((plain.epsg(), plain.nodata(), plain.geo_bounds()), (file.epsg(), file.nodata(), file.geo_bounds()));
    for code in [262, 320, 33550, 33922, 34735, 34737, 42112, 42113] {
        assert_eq!(plain_ifd.tag(code).unwrap().value, ifd.tag(code).unwrap().value, "tag {code}");
    }
}

#[test]
fn overviews_of_a_mask_show_the_most_frequent_class() {
    let mut mask = classes();
    for cell in [0, 1, SHAPE.1] {
        mask[cell] = 2;
    }
    mask[SHAPE.1 + 1] = 3;
    let georef = grid(None);
    let file = written(&image_of(&georef, Bands::Byte(vec![("los".to_string(), &mask)])));
    assert_eq!(file.overview_count(), 2);
    let half = file.read_overview::<u8>(0).unwrap();
    assert_eq!(half.shape(), [150, 350]);
    assert_eq!(half[[0, 0]], 2);
    assert_eq!(half[[149, 349]], mask[n_cells() - 1]);
    assert_eq!(file.read_overview::<u8>(1).unwrap().shape(), [75, 175]);
}

#[test]
fn bands_of_numbers_come_back_from_geotiff() {
    let (georef, margins, bits) = (grid(Some(32632)), margins(), bit_sets());
    let floats = Bands::Float(vec![("1.margin".to_string(), &margins), ("2.margin".to_string(), &margins)]);
    let whole = Bands::UInt32(vec![("which.0".to_string(), &bits)]);
    for layout in [TiffLayout::Cog, TiffLayout::Plain] {
        let image = GeoTiffImage { nodata: Some(-9999.0), layout, ..image_of(&georef, floats.clone()) };
        let file = written(&image);
        assert_eq!((file.band_count(), file.nodata()), (2, Some("-9999")));
        for band in 0..2 {
            assert_eq!(bits_of(&file.read_band::<f32>(band).unwrap()), bits_of(&margins));
        }
        if layout == TiffLayout::Cog {
            let overview = file.read_overview_band::<f32>(0, 1).unwrap();
            assert_eq!(overview[[3, 5]].to_bits(), margins[6 * SHAPE.1 + 10].to_bits());
        } else {
            let numbers: Vec<u8> = margins.iter().flat_map(|value| value.to_le_bytes()).collect();
            assert_eq!(encode_geotiff(&image).unwrap()[8..8 + numbers.len()], numbers);
        }
        let file = written(&GeoTiffImage { layout, ..image_of(&georef, whole.clone()) });
        assert_eq!(file.nodata(), None);
        assert_eq!(file.read_raster::<u32>().unwrap().into_iter().collect::<Vec<_>>(), bits);
    }
}

#[test]
fn geokeys_say_what_is_known_of_the_reference_system() {
    let cells = vec![0_u8; n_cells()];
    let of = |crs: Option<Crs>| {
        let georef = grid(None).with_crs(crs);
        written(&image_of(&georef, Bands::Byte(vec![("los".to_string(), &cells)])))
    };
    for code in [4326, 3857, 2056, 4647, 2263] {
        assert_eq!(of(Some(crs::from_epsg(code).unwrap())).epsg(), Some(code));
    }
    // GDAL makes up a local system as soon as there is any key.
    assert!(of(None).tiff().ifd(0).unwrap().tag(34735).is_none());

    let cited = of(Some(crs::from_geokeys_citation("City grid", Some(0.3048), false)));
    assert_eq!(cited.geokeys().get_ascii(3073), Some("City grid"));
    assert_eq!((cited.geokeys().get_short(3072), cited.geokeys().get_short(3076)), (Some(32767), Some(9002)));
    let defined = of(Some(crs::parse("+proj=tmerc +lat_0=1 +lon_0=8.5 +datum=WGS84").unwrap()));
    let definition = defined.geokeys().get_ascii(3073).unwrap();
    assert!(definition.starts_with("ESRI PE String = PROJCS["), "{definition}");
    assert_eq!(crs::parse(definition.trim_start_matches("ESRI PE String = ")).unwrap().epsg(), None);
}

#[test]
fn files_do_not_depend_on_the_number_of_threads() {
    let (georef, margins, bits, metadata) = (grid(Some(2056)), margins(), bit_sets(), metadata());
    let bands = Bands::Float(vec![("a".to_string(), &margins), ("b".to_string(), &margins)]);
    let image = GeoTiffImage { metadata: &metadata, ..image_of(&georef, bands) };
    let files = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (mut tif, mut exr, mut npz) = (Vec::new(), Vec::new(), Cursor::new(Vec::new()));
            write_geotiff(&mut tif, &image).unwrap();
            let channels = [("a".to_string(), ExrChannel::Float(&margins)), ("b".to_string(), ExrChannel::UInt(&bits))];
            write_exr(&mut exr, &georef, &channels, &metadata).unwrap();
            let arrays = [("a".to_string(), NpyArray::F32(&margins, vec![SHAPE.0, SHAPE.1]))];
            write_npz(&mut npz, &arrays).unwrap();
            (tif, exr, npz.into_inner())
        })
    };
    assert!(files(1) == files(4));
}

#[test]
fn channels_come_back_from_exr_with_their_place() {
    let (georef, mut margins, bits, metadata) = (grid(Some(25832)), margins(), bit_sets(), metadata());
    margins[7] = f32::NAN;
    let channels = [
        ("s1.margin".to_string(), ExrChannel::Float(&margins)),
        ("a_site_with_a_name_of_more_than_31_bytes.los".to_string(), ExrChannel::UInt(&bits)),
    ];
    let mut bytes = Vec::new();
    write_exr(&mut bytes, &georef, &channels, &metadata).unwrap();
    let read = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
    let image = read.all_attributes().from_buffered(Cursor::new(&bytes)).unwrap();

    let list = &image.layer_data.channel_data.list;
    let names: Vec<String> = list.iter().map(|channel| channel.name.to_string()).collect();
    assert_eq!(names, ["a_site_with_a_name_of_more_than_31_bytes.los", "s1.margin"]);
    assert_eq!(list[0].sample_data, FlatSamples::U32(bits));
    let FlatSamples::F32(found) = &list[1].sample_data else { panic!("margins are floats") };
    assert_eq!(bits_of(found), bits_of(&margins));

    let attribute = |name: &str| {
        let own = image.layer_data.attributes.other.iter().chain(&image.attributes.other);
        own.into_iter().find(|(key, _)| key.as_slice() == name.as_bytes()).map(|(_, value)| value.clone())
    };
    let Some(AttributeValue::Custom { kind, bytes }) = attribute("gdal:geoTransform") else { panic!("no place") };
    let matrix: Vec<f64> = bytes.chunks_exact(8).map(|number| f64::from_le_bytes(number.try_into().unwrap())).collect();
    assert_eq!(kind.to_string(), "m33d");
    assert_eq!(matrix, [0.5, 0.0, 500_000.25, 0.0, -0.25, 5_400_000.5, 0.0, 0.0, 1.0]);
    let text = |name: &str| match attribute(name) {
        Some(AttributeValue::Text(text)) => String::from_utf8(text.as_slice().to_vec()).unwrap(),
        other => panic!("{name}: {other:?}"),
    };
    assert_eq!(crs::parse(&text("gdal:crsWkt")).unwrap().epsg(), Some(25832));
    assert_eq!(text("gdal:skyshed"), metadata[0].1);
}

#[test]
fn arrays_come_back_from_npz() {
    let (bits, doubles) = ([1_u32, 2, 3, 4, 5, u32::MAX], [0.5, f64::NAN]);
    let arrays = [
        ("which".to_string(), NpyArray::U32(&bits, vec![2, 3])),
        ("x".to_string(), NpyArray::F64(&doubles, vec![2])),
        ("los".to_string(), NpyArray::U8(&[7], vec![1, 1])),
        ("ids".to_string(), NpyArray::I64(&[-1], vec![1])),
        ("meta".to_string(), NpyArray::Text("aß")),
    ];
    let mut out = Cursor::new(Vec::new());
    write_npz(&mut out, &arrays).unwrap();
    let mut archive = zip::ZipArchive::new(out).unwrap();
    let mut array = |name: &str| {
        let mut bytes = Vec::new();
        archive.by_name(&format!("{name}.npy")).unwrap().read_to_end(&mut bytes).unwrap();
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        (String::from_utf8(bytes[10..start].to_vec()).unwrap().trim_end().to_string(), bytes[start..].to_vec())
    };
    let header = |kind: &str, shape: &str| format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    let little_endian: Vec<u8> = bits.iter().flat_map(|value| value.to_le_bytes()).collect();
    assert_eq!(array("which"), (header("<u4", "(2, 3)"), little_endian));
    assert_eq!(array("x"), (header("<f8", "(2,)"), doubles.iter().flat_map(|value| value.to_le_bytes()).collect()));
    assert_eq!(array("los"), (header("|u1", "(1, 1)"), vec![7]));
    assert_eq!(array("ids"), (header("<i8", "(1,)"), vec![255; 8]));
    assert_eq!(array("meta"), (header("<U2", "()"), vec![b'a', 0, 0, 0, 0xdf, 0, 0, 0]));
}

#[test]
fn a_sidecar_names_the_classes_in_order_with_their_colors_and_no_others() {
    let two = pam_sidecar(&palette(), 2);
    assert_eq!(two.matches("<PAMRasterBand").count(), 2);
    let text = pam_sidecar(&palette(), 1);
    let colors: Vec<&str> = text.lines().filter_map(|line| line.trim().strip_prefix("<Entry ")).collect();
    assert_eq!(colors.len(), 4, "{text}");
    assert_eq!(colors[1], "c1=\"0\" c2=\"114\" c3=\"178\" c4=\"255\"/>");
    assert_eq!(colors[2], "c1=\"0\" c2=\"0\" c3=\"0\" c4=\"0\"/>", "a value without a class");
    let names: Vec<&str> = text.lines().filter_map(|line| line.trim().strip_prefix("<Category>")).collect();
    let last = "a&lt;b&gt; &amp; &quot;c&quot; ä</Category>";
    assert_eq!(names, ["NLoS</Category>", "LoS</Category>", "</Category>", last]);
}

#[test]
fn a_world_file_holds_the_center_of_the_north_west_cell() {
    assert_eq!(world_file(&grid(None)), "0.5\n0\n0\n-0.25\n500000.5\n5400000.375\n");
}

#[test]
fn a_full_disk_is_an_error_of_the_output() {
    struct Full;
    impl std::io::Write for Full {
        fn write(&mut self, _: &[u8]) -> std::io::Result<usize> {
            Err(std::io::Error::from(std::io::ErrorKind::StorageFull))
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let (georef, mask, bits) = (grid(None), classes(), bit_sets());
    let image = image_of(&georef, Bands::Byte(vec![("los".to_string(), &mask)]));
    let error = write_geotiff(&mut Full, &image).unwrap_err();
    assert_eq!((error.code().as_str(), error.kind().exit_code()), ("E401", 3), "{error}");
    let channels = [("a".to_string(), ExrChannel::UInt(&bits))];
    assert_eq!(write_exr(&mut Full, &georef, &channels, &[]).unwrap_err().code(), "E401");
}

/// Heights with a band that says how opaque their cells are, which counts from an `ExtraSamples` of 1 on.
pub(crate) fn with_opacity(georef: &GeoRef, heights: &[f32], opacity: &[f32], extra_samples: u8) -> Vec<u8> {
    let bands = Bands::Float(vec![("height".to_string(), heights), ("alpha".to_string(), opacity)]);
    let mut bytes = encode_geotiff(&image_of(georef, bands)).unwrap();
    // The tag, one short: 0 is data, 1 and 2 are associated and unassociated alpha.
    let tag = [0x52, 0x01, 3, 0, 1, 0, 0, 0, 0, 0];
    let at = bytes.windows(tag.len()).position(|window| window == tag).unwrap();
    bytes[at + 8] = extra_samples;
    bytes
}

#[test]
fn a_band_that_says_how_opaque_cells_are_hides_those_that_are_not() {
    let folder = Folder::new();
    let georef = GeoRef::new((0.0, 2.0), (1.0, 1.0), (2, 3), None).unwrap();
    // 0 m where nothing was measured, as tools leave it that write transparency beside heights.
    let heights = [5.0, 0.0, 7.0, 0.0, 0.0, 9.0];
    let opacity = [255.0, 0.0, 1.0, 255.0, 0.0, 255.0];
    for extra_samples in 0..=2 {
        std::fs::write(folder.join("a.tif"), with_opacity(&georef, &heights, &opacity, extra_samples)).unwrap();
        let (cells, warnings) = read(&folder.join("a.tif")).unwrap();
        let seen = |k: usize| if extra_samples > 0 && opacity[k] == 0.0 { f64::NAN } else { f64::from(heights[k]) };
        let wanted = [0, 1, 2, 3, 4, 5].map(seen);
        assert!(same(&cells, &wanted), "{extra_samples}: {cells:?}");
        assert_eq!(codes(&warnings).contains(&"W323".to_string()), extra_samples == 0, "{warnings:?}");
    }
}
