//! What the raster writers write is what the reading crates read: values, places, names, and the same bytes each time.
//!
//! `cog` and `planning_tools` hold such files against GDAL and rasterio, where these are at hand.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::io::{Cursor, Read};

use exr::meta::attribute::AttributeValue;
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers};
use geotiff_reader::GeoTiffFile;
use skyshed_core::raster::{Crs, GeoRef};
use skyshed_io::crs;
use skyshed_io::formats::{
    Bands, ClassColor, ExrChannel, GeoTiff, GeoTiffImage, NpyArray, TiffLayout, encode_geotiff, pam_sidecar,
    world_file, write_exr, write_geotiff, write_npz,
};

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
    vec![class(0, "NLoS", [230, 159, 0, 255]), class(1, "LoS", [0, 114, 178, 255]), class(3, "a < b & ä", [9; 4])]
}

fn metadata() -> Vec<(String, String)> {
    vec![("skyshed".to_string(), r#"{"version": "1 <&> 2", "file": "straße.tif"}"#.to_string())]
}

fn ascii_tag(file: &GeoTiffFile, code: u16) -> Option<String> {
    let tag = file.tiff().ifd(file.base_ifd_index()).unwrap().tag(code)?;
    Some(tag.value.as_str().unwrap().to_string())
}

#[test]
fn a_mask_comes_back_from_geotiff_with_place_colors_and_names() {
    let (georef, mask, palette, metadata) = (grid(Some(25832)), classes(), palette(), metadata());
    let bands = Bands::Byte(vec![("los".to_string(), &mask)]);
    let image = GeoTiffImage {
        georef: &georef,
        bands,
        nodata: Some(255.0),
        palette: Some(&palette),
        metadata: &metadata,
        layout: TiffLayout::Cog,
    };
    let file = GeoTiffFile::from_bytes(encode_geotiff(&image).unwrap()).unwrap();

    assert_eq!((file.height() as usize, file.width() as usize, file.band_count()), (SHAPE.0, SHAPE.1, 1));
    assert_eq!(file.read_raster::<u8>().unwrap().into_iter().collect::<Vec<_>>(), mask);
    assert_eq!((file.epsg(), file.nodata()), (Some(25832), Some("255")));
    assert_eq!(file.geo_bounds(), Some([georef.x_min(), georef.y_min(), georef.x_max(), georef.y_max()]));

    let ifd = file.tiff().ifd(0).unwrap();
    assert_eq!((ifd.is_tiled(), ifd.compression(), ifd.photometric_interpretation()), (true, 8, Some(3)));
    let colors = ifd.tag(320).unwrap().value.as_u16_slice().unwrap();
    assert_eq!([colors[1], colors[257], colors[513]], [0, 114 * 257, 178 * 257]);
    let items = ascii_tag(&file, 42112).unwrap();
    assert!(items.contains(r#"<Item name="DESCRIPTION" sample="0" role="description">los</Item>"#), "{items}");
    // GDAL takes the escapes off twice.
    assert!(items.contains("1 &amp;lt;&amp;amp;&amp;gt; 2"), "{items}");
    assert!(items.contains("straße.tif"), "{items}");
}

#[test]
fn overviews_of_a_mask_show_the_most_frequent_class() {
    let mut mask = classes();
    for cell in [0, 1, SHAPE.1] {
        mask[cell] = 2;
    }
    mask[SHAPE.1 + 1] = 3;
    let georef = grid(None);
    let bands = Bands::Byte(vec![("los".to_string(), &mask)]);
    let image =
        GeoTiffImage { georef: &georef, bands, nodata: None, palette: None, metadata: &[], layout: TiffLayout::Cog };
    let file = GeoTiffFile::from_bytes(encode_geotiff(&image).unwrap()).unwrap();
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
    let bands = Bands::Float(vec![("1.margin".to_string(), &margins), ("2.margin".to_string(), &margins)]);
    let image = GeoTiffImage {
        georef: &georef,
        bands,
        nodata: Some(-9999.0),
        palette: None,
        metadata: &[],
        layout: TiffLayout::Cog,
    };
    let file = GeoTiffFile::from_bytes(encode_geotiff(&image).unwrap()).unwrap();
    assert_eq!((file.band_count(), file.nodata()), (2, Some("-9999")));
    for band in 0..2 {
        let found: Vec<u32> = file.read_band::<f32>(band).unwrap().iter().map(|value| value.to_bits()).collect();
        assert_eq!(found, margins.iter().map(|value| value.to_bits()).collect::<Vec<_>>());
    }
    let overview = file.read_overview_band::<f32>(0, 1).unwrap();
    assert_eq!(overview[[3, 5]].to_bits(), margins[6 * SHAPE.1 + 10].to_bits());

    let image =
        GeoTiffImage { bands: Bands::UInt32(vec![("which.0".to_string(), &bits)]), nodata: None, ..image.clone() };
    let file = GeoTiffFile::from_bytes(encode_geotiff(&image).unwrap()).unwrap();
    assert_eq!(file.nodata(), None);
    assert_eq!(file.read_raster::<u32>().unwrap().into_iter().collect::<Vec<_>>(), bits);
}

#[test]
fn a_plain_geotiff_is_strips_of_bare_numbers_that_hold_the_same() {
    let (georef, mask, palette, metadata) = (grid(Some(25832)), classes(), palette(), metadata());
    let image = GeoTiffImage {
        georef: &georef,
        bands: Bands::Byte(vec![("los".to_string(), &mask)]),
        nodata: Some(255.0),
        palette: Some(&palette),
        metadata: &metadata,
        layout: TiffLayout::Plain,
    };
    let bytes = encode_geotiff(&image).unwrap();
    // A band is one stretch of bytes behind the header, north row first: no codec is needed to read it.
    assert_eq!(&bytes[8..8 + n_cells()], &mask);
    let plain = GeoTiffFile::from_bytes(bytes).unwrap();
    let cog = GeoTiffFile::from_bytes(encode_geotiff(&GeoTiffImage { layout: TiffLayout::Cog, ..image }).unwrap());
    let cog = cog.unwrap();
    let ifd = plain.tiff().ifd(0).unwrap();
    assert_eq!((ifd.is_tiled(), ifd.compression(), ifd.photometric_interpretation()), (false, 1, Some(3)));
    assert_eq!((plain.overview_count(), plain.tiff().ifd_count()), (0, 1));
    // 700 cells a row: strips of 12 rows reach 8192 bytes.
    assert_eq!(ifd.tag(278).unwrap().value.as_u32(), Some(12));
    assert_eq!(plain.read_raster::<u8>().unwrap().into_iter().collect::<Vec<_>>(), mask);
    // Everything that is said about the cells is said in both layouts.
    assert_eq!((plain.epsg(), plain.nodata(), plain.geo_bounds()), (cog.epsg(), cog.nodata(), cog.geo_bounds()));
    for code in [320, 33550, 33922, 34735, 34737, 42112, 42113] {
        let of = |file: &GeoTiffFile| file.tiff().ifd(0).unwrap().tag(code).unwrap().value.clone();
        assert_eq!(of(&plain), of(&cog), "tag {code}");
    }

    let (margins, bits) = (margins(), bit_sets());
    let bands = Bands::Float(vec![("1.margin".to_string(), &margins), ("2.margin".to_string(), &margins)]);
    let floats = GeoTiffImage {
        georef: &georef,
        bands,
        nodata: Some(-9999.0),
        palette: None,
        metadata: &[],
        layout: TiffLayout::Plain,
    };
    let bytes = encode_geotiff(&floats).unwrap();
    let numbers: Vec<u8> = margins.iter().flat_map(|value| value.to_le_bytes()).collect();
    assert_eq!(&bytes[8..8 + numbers.len()], &numbers);
    let file = GeoTiffFile::from_bytes(bytes).unwrap();
    for band in 0..2 {
        let found: Vec<u32> = file.read_band::<f32>(band).unwrap().iter().map(|value| value.to_bits()).collect();
        assert_eq!(found, margins.iter().map(|value| value.to_bits()).collect::<Vec<_>>());
    }
    let image = GeoTiffImage { bands: Bands::UInt32(vec![("which.0".to_string(), &bits)]), nodata: None, ..floats };
    let file = GeoTiffFile::from_bytes(encode_geotiff(&image).unwrap()).unwrap();
    assert_eq!(file.read_raster::<u32>().unwrap().into_iter().collect::<Vec<_>>(), bits);
}

#[test]
fn geokeys_say_what_is_known_of_the_reference_system() {
    let cells = vec![0_u8; n_cells()];
    let written = |crs: Option<Crs>| {
        let georef = grid(None).with_crs(crs);
        let bands = Bands::Byte(vec![("los".to_string(), &cells)]);
        let image = GeoTiffImage {
            georef: &georef,
            bands,
            nodata: None,
            palette: None,
            metadata: &[],
            layout: TiffLayout::Cog,
        };
        GeoTiffFile::from_bytes(encode_geotiff(&image).unwrap()).unwrap()
    };
    for code in [4326, 3857, 2056, 4647, 2263] {
        assert_eq!(written(Some(crs::from_epsg(code).unwrap())).epsg(), Some(code));
    }
    // GDAL makes up a local system as soon as there is any key.
    assert!(written(None).tiff().ifd(0).unwrap().tag(34735).is_none());

    let cited = written(Some(crs::from_geokeys_citation("City grid", Some(0.3048), false)));
    assert_eq!(cited.geokeys().get_ascii(3073), Some("City grid"));
    assert_eq!((cited.geokeys().get_short(3072), cited.geokeys().get_short(3076)), (Some(32767), Some(9002)));
    let defined = written(Some(crs::parse("+proj=tmerc +lat_0=1 +lon_0=8.5 +datum=WGS84").unwrap()));
    let definition = defined.geokeys().get_ascii(3073).unwrap();
    assert!(definition.starts_with("ESRI PE String = PROJCS["), "{definition}");
    assert_eq!(crs::parse(definition.trim_start_matches("ESRI PE String = ")).unwrap().epsg(), None);
}

#[test]
fn files_do_not_depend_on_the_number_of_threads() {
    let (georef, margins, bits, metadata) = (grid(Some(2056)), margins(), bit_sets(), metadata());
    let bands = Bands::Float(vec![("a".to_string(), &margins), ("b".to_string(), &margins)]);
    let image = GeoTiffImage {
        georef: &georef,
        bands,
        nodata: None,
        palette: None,
        metadata: &metadata,
        layout: TiffLayout::Cog,
    };
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
    assert!(found.iter().map(|value| value.to_bits()).eq(margins.iter().map(|value| value.to_bits())));

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
fn a_sidecar_names_the_classes_in_order() {
    let text = pam_sidecar(&palette());
    let names: Vec<&str> = text.lines().filter_map(|line| line.trim().strip_prefix("<Category>")).collect();
    assert_eq!(names, ["NLoS</Category>", "LoS</Category>", "</Category>", "a &lt; b &amp; ä</Category>"]);
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
    let bands = Bands::Byte(vec![("los".to_string(), &mask)]);
    let image =
        GeoTiffImage { georef: &georef, bands, nodata: None, palette: None, metadata: &[], layout: TiffLayout::Cog };
    let error = write_geotiff(&mut Full, &image).unwrap_err();
    assert_eq!((error.code().as_str(), error.class().exit_code()), ("E401", 3), "{error}");
    let channels = [("a".to_string(), ExrChannel::UInt(&bits))];
    assert_eq!(write_exr(&mut Full, &georef, &channels, &[]).unwrap_err().code(), "E401");
}

#[test]
fn reference_systems_are_read_named_and_joined() {
    let utm = crs::parse("urn:ogc:def:crs:EPSG::25832").unwrap();
    assert_eq!((utm.label(), utm.name()), ("EPSG:25832".to_string(), "ETRS89 / UTM zone 32N".to_string()));
    assert!(crs::is_web_mercator(&crs::parse("EPSG:900913").unwrap()));
    assert!(!crs::is_web_mercator(&utm));
    assert_eq!(crs::parse(&crs::wkt_of(&utm).unwrap()).unwrap(), utm);
    // PROJ 9.5.1: 513223.5394 5403015.5180.
    let wgs84 = crs::from_epsg(4326).unwrap();
    let (x, y) = skyshed_io::crs::transform(&wgs84, &utm, (9.18, 48.78)).unwrap();
    assert!((x - 513_223.539_4).abs() < 1e-3 && (y - 5_403_015.518).abs() < 1e-3, "{x} {y}");
    assert_eq!(skyshed_io::crs::utm_for(9.18, 48.78), 32632);
}

#[test]
fn a_band_that_says_how_opaque_cells_are_hides_those_that_are_not() {
    let folder = crate::program::Folder::new();
    let georef = GeoRef::new((0.0, 2.0), (1.0, 1.0), (2, 3), None).unwrap();
    // 0 m where nothing was measured, as tools leave it that write transparency beside heights.
    let heights = [5.0, 0.0, 7.0, 0.0, 0.0, 9.0];
    let opaque = [255.0, 0.0, 1.0, 255.0, 0.0, 255.0];
    let bands = Bands::Float(vec![("height".to_string(), &heights), ("alpha".to_string(), &opaque)]);
    let image =
        GeoTiffImage { georef: &georef, bands, nodata: None, palette: None, metadata: &[], layout: TiffLayout::Cog };
    let mut bytes = encode_geotiff(&image).unwrap();
    let read = |name: &str, bytes: &[u8]| {
        std::fs::write(folder.join(name), bytes).unwrap();
        let mut warnings = Vec::new();
        let file = GeoTiff::open(folder.join(name), &mut warnings).unwrap();
        let cells = file.read(file.georef().window(), &mut warnings, |height| height).unwrap().cells().to_vec();
        (cells, warnings.iter().map(skyshed_io::Warning::code).collect::<Vec<_>>())
    };
    let (cells, warnings) = read("bands.tif", &bytes);
    assert!(cells == heights.map(f64::from) && warnings.contains(&"W323".to_string()), "{cells:?} {warnings:?}");
    // The tag ExtraSamples, one short: 0 is data, 2 is unassociated alpha.
    let tag = [0x52, 0x01, 3, 0, 1, 0, 0, 0, 0, 0];
    let at = bytes.windows(tag.len()).position(|window| window == tag).unwrap();
    for alpha in [1, 2] {
        bytes[at + 8] = alpha;
        let (cells, warnings) = read("alpha.tif", &bytes);
        let is_void: Vec<bool> = cells.iter().map(|height| height.is_nan()).collect();
        assert_eq!(is_void, opaque.map(|alpha| alpha == 0.0));
        assert_eq!((cells[0], cells[2], cells[3]), (5.0, 7.0, 0.0));
        assert!(!warnings.contains(&"W323".to_string()), "{warnings:?}");
    }
}
