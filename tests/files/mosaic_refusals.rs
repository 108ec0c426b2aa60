//! Virtual rasters and folders that cannot be read, or only oddly: what is said of them; and hostile ones.

use skyshed_io::formats::RasterFile;

use crate::mosaic::{CORNER, codes, nine_tiles, read};
use crate::plain_tiff::{Cells, PlainTiff};
use crate::program::Folder;

/// A virtual raster that is right, to be spoiled.
const GOOD: &str = r#"<VRTDataset rasterXSize="15" rasterYSize="12"><SRS>EPSG:25832</SRS>
<GeoTransform>500000, 2, 0, 5400000, 0, -2</GeoTransform>
<VRTRasterBand dataType="Float32" band="1"><NoDataValue>-9999</NoDataValue>
<ComplexSource><SourceFilename relativeToVRT="1">nine/t0.tif</SourceFilename><SourceBand>1</SourceBand>
<SourceProperties RasterXSize="5" RasterYSize="4" DataType="Float32" BlockXSize="5" BlockYSize="3"/>
<SrcRect xOff="0" yOff="0" xSize="5" ySize="4"/><DstRect xOff="5" yOff="4" xSize="5" ySize="4"/>
<NODATA>-9999</NODATA></ComplexSource></VRTRasterBand></VRTDataset>"#;

/// A tile of 5 × 4 cells at the corner, all of one height.
fn flat_tile() -> PlainTiff {
    PlainTiff { cells: Cells::Int16, ..PlainTiff::floats(CORNER, 2.0, 5, vec![1.0; 20]) }
}

#[test]
fn virtual_rasters_that_cannot_be_read_cell_by_cell_say_why_and_what_to_do() {
    let folder = nine_tiles();
    let mut other = PlainTiff { epsg: 25833, ..flat_tile() };
    std::fs::write(folder.join("nine/utm33.tif"), other.bytes()).unwrap();
    folder.write("good.vrt", GOOD);
    assert!(read(&folder.join("good.vrt")).is_ok());
    // What is replaced, by what, the code, and parts of the answer.
    let gdal = "`gdal_translate bad.vrt bad_whole.tif`";
    let cases: [(&str, &str, &str, &[&str]); 31] = [
        ("<VRTDataset ", "<VRTDataset subClass=\"VRTWarpedDataset\" ", "E304", &["VRTWarpedDataset", gdal]),
        ("band=\"1\">", "subClass=\"VRTDerivedRasterBand\">", "E304", &["VRTDerivedRasterBand", gdal]),
        ("band=\"1\">", "subClass=\"VRTRawRasterBand\">", "E304", &["VRTRawRasterBand", gdal]),
        ("<NODATA>-9999</NODATA>", "<LUT>0:1,2:3</LUT>", "E304", &["line 7", "`LUT`", gdal]),
        ("<NODATA>-9999</NODATA>", "<Exponent>2</Exponent>", "E304", &["`Exponent`", gdal]),
        ("ComplexSource>", "AveragedSource>", "E304", &["`AveragedSource`", gdal]),
        ("ComplexSource>", "KernelFilteredSource>", "E304", &["`KernelFilteredSource`", gdal]),
        ("</VRTRasterBand>", "<MaskBand/></VRTRasterBand>", "E304", &["mask", gdal]),
        ("</VRTDataset>", "<MaskBand/></VRTDataset>", "E304", &["mask", gdal]),
        ("yOff=\"4\" xSize=\"5\"", "yOff=\"4\" xSize=\"10\"", "E304", &["5 x 4", "10 x 4", gdal]),
        ("xOff=\"5\"", "xOff=\"5.5\"", "E304", &["5.5", gdal]),
        ("xOff=\"5\"", "xOff=\"nan\"", "E302", &["`xOff` is `nan`"]),
        ("xOff=\"5\"", "xOff=\"1e300\"", "E304", &["wanted whole cells"]),
        ("SourceBand>1<", "SourceBand>mask,1<", "E304", &["`SourceBand` is `mask,1`", gdal]),
        ("SourceBand>1<", "SourceBand>2<", "E302", &["band 2, found 1"]),
        ("RasterXSize=\"5\"", "RasterXSize=\"6\"", "E302", &["t0.tif", "6 columns", "found 5 x 4", "gdalbuildvrt"]),
        ("nine/t0.tif", "nine/none.tif", "E301", &["none.tif", "`bad.vrt`"]),
        ("nine/t0.tif", "nine/utm33.tif", "E311", &["bad.vrt", "EPSG:25832", "utm33.tif in EPSG:25833"]),
        ("nine/t0.tif", "bad.vrt", "E302", &["bad.vrt: it is a source of itself", "`bad.vrt`"]),
        ("nine/t0.tif", "", "E302", &["`SourceFilename`"]),
        ("nine/t0.tif", "nine", "E301", &["folder"]),
        ("Float32\" band", "CFloat32\" band", "E304", &["`CFloat32`"]),
        ("rasterXSize=\"15\"", "rasterXSize=\"-15\"", "E302", &["`rasterXSize` is `-15`"]),
        ("rasterXSize=\"15\"", "rasterXSize=\"99999999999\"", "E302", &["`rasterXSize` is `99999999999`"]),
        ("\"15\" rasterYSize=\"12\"", "\"2147483647\" rasterYSize=\"2147483647\"", "E501", &["GiB"]),
        (", 2, 0, ", ", 2, 0.5, ", "E306", &[]),
        ("0, -2<", "0, 2<", "E306", &[]),
        ("500000, 2", "inf, 2", "E302", &["`GeoTransform` is `inf`"]),
        ("<GeoTransform>500000, ", "<GeoTransform>", "E302", &["5 numbers"]),
        ("</VRTDataset>", "", "E302", &["bad.vrt", "XML"]),
        ("<VRTRasterBand", "<Other", "E302", &["bad.vrt"]),
    ];
    for (from, to, code, parts) in cases {
        assert!(GOOD.contains(from), "{from}");
        folder.write("bad.vrt", &GOOD.replace(from, to));
        folder.refuses("info bad.vrt --json", code, parts);
    }
    // What is read although it looks odd: the source in part or wholly outside, other bands, a scaled band in feet.
    for (from, to, n_heights, wanted) in [
        ("xOff=\"5\"", "xOff=\"-2\"", 12, &[][..]),
        ("xOff=\"5\"", "xOff=\"13\"", 8, &[]),
        ("</VRTDataset>", "<VRTRasterBand dataType=\"Byte\"/></VRTDataset>", 20, &["W323"]),
        ("<NoDataValue>", "<Scale>0.5</Scale><UnitType>ft</UnitType><NoDataValue>", 20, &["W332", "W333"]),
        ("<SRS>EPSG:25832</SRS>", "", 20, &["W325"]),
        ("dataType", "DATATYPE", 20, &[]),
        ("Float32\" band", "Byte\" band", 180, &[]),
    ] {
        folder.write("odd.vrt", &GOOD.replace(from, to));
        let (heights, warnings) = read(&folder.join("odd.vrt")).unwrap();
        assert_eq!(heights.iter().filter(|h| !h.is_nan()).count(), n_heights, "{to}");
        assert_eq!(codes(&warnings), wanted, "{to}");
    }
    // A tile that changed its size meanwhile.
    let file = RasterFile::open(folder.join("good.vrt"), &mut Vec::new()).unwrap();
    (other.n_cols, other.values) = (4, vec![1.0; 16]);
    std::fs::write(folder.join("nine/t0.tif"), other.bytes()).unwrap();
    let error = file.read(file.georef().window(), &mut Vec::new(), |v| v).unwrap_err();
    assert_eq!((error.code(), error.to_string().contains("t0.tif")), ("E303".into(), true));
}

#[test]
fn hostile_virtual_rasters_are_refused_within_seconds() {
    let folder = nine_tiles();
    // Each source holds the next one; the last holds the first.
    let unsized_source = GOOD.replace("RasterXSize=\"5\" RasterYSize=\"4\"", "");
    for k in 0..6 {
        let text = unsized_source.replace("nine/t0.tif", &format!("deep{}.vrt", (k + 1) % 6));
        folder.write(&format!("deep{k}.vrt"), &text);
    }
    let entities: String =
        (1..20).map(|k| format!("<!ENTITY e{k} \"&e{};&e{};&e{};\">", k - 1, k - 1, k - 1)).collect();
    let bomb = format!("<!DOCTYPE VRTDataset [<!ENTITY e0 \"x\">{entities}]>{}", GOOD.replace("EPSG:25832", "&e19;"));
    folder.write("bomb.vrt", &bomb);
    folder.write("nested.vrt", &format!("<VRTDataset>{}", "<a>".repeat(300_000)));
    let own = |k: usize| {
        format!("<SimpleSource><SourceFilename relativeToVRT=\"1\">none{k}.tif</SourceFilename></SimpleSource>")
    };
    let many: String = (0..5000).map(own).collect();
    folder.write("many.vrt", &GOOD.replace("<ComplexSource>", &format!("{many}<ComplexSource>")));
    for (name, code, part) in [
        ("deep0.vrt", "E304", "more than 4 deep"),
        ("bomb.vrt", "E302", "bomb.vrt"),
        ("nested.vrt", "E302", "nested.vrt"),
        ("many.vrt", "E301", "none0.tif"),
    ] {
        folder.refuses(&format!("info {name}"), code, &[part]);
    }
    // Thousands of sources are fine.
    let source = GOOD.lines().skip(3).collect::<Vec<_>>().join("\n").replace("</VRTRasterBand></VRTDataset>", "");
    let many: String = (0..5000).map(|k| source.replace("t0.tif", &format!("t{}.tif", k % 9))).collect();
    let head = GOOD.lines().take(3).collect::<Vec<_>>().join("\n");
    folder.write("thousands.vrt", &format!("{head}{many}</VRTRasterBand></VRTDataset>"));
    let answer = folder.type_in("map thousands.vrt --uav 500011,5399989,500amsl --json").done().json();
    assert_eq!(answer["scene"]["sources"].as_array().unwrap().len(), 10);
}

#[test]
fn tiles_that_do_not_belong_together_are_named() {
    let base = flat_tile();
    let east = (CORNER.0 + 10.0, CORNER.1);
    // The other tile, the code if both are no raster, and what is said of them.
    let cases: [(PlainTiff, Option<&str>, &[&str]); 6] = [
        (PlainTiff { corner: east, cell: 2.001, ..base.clone() }, Some("E307"), &["a.tif", "b.tif", "2.001×2.001"]),
        (PlainTiff { corner: (east.0 + 0.5, east.1), ..base.clone() }, Some("E307"), &["a.tif", "b.tif", "0.2500"]),
        (PlainTiff { corner: east, epsg: 25833, ..base.clone() }, Some("E311"), &["a.tif", "b.tif", "EPSG:25833"]),
        (PlainTiff { corner: (1e12, CORNER.1), ..base.clone() }, Some("E501"), &["columns"]),
        // A thousandth of a cell is not much.
        (PlainTiff { corner: (east.0 + 0.0015, east.1), ..base.clone() }, None, &[]),
        (PlainTiff { corner: east, ..base.clone() }, None, &[]),
    ];
    for (other, code, parts) in cases {
        let folder = Folder::new();
        std::fs::create_dir(folder.join("city")).unwrap();
        std::fs::write(folder.join("city/a.tif"), base.bytes()).unwrap();
        std::fs::write(folder.join("city/b.tif"), other.bytes()).unwrap();
        match (code, read(&folder.join("city"))) {
            (Some(code), Err(error)) => {
                let text = error.to_string();
                assert_eq!(error.code(), code, "{text}");
                assert!(parts.iter().all(|part| text.contains(part)), "{text}, wanted {parts:?}");
            }
            (None, Ok((heights, _))) => assert_eq!(heights.len(), 40),
            (code, found) => panic!("{other:?}: wanted {code:?}, found {:?}", found.map(|f| f.0.len())),
        }
    }
    let folder = Folder::new();
    std::fs::create_dir(folder.join("empty")).unwrap();
    folder.refuses("info empty", "E308", &["empty"]);
}
