//! Small files that would take much time or memory: each is refused, or read at the cost that its size stands for. Every run
//! may take 1 GB of memory and some seconds, which the system enforces.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use flatgeobuf::geozero::{ColumnValue, PropertyProcessor};
use flatgeobuf::{ColumnType, FgbCrs, FgbWriter, FgbWriterOptions, GeometryType};
use rusqlite::Connection;

use crate::program::Folder;
use crate::vector_files::{Building, EAST, NORTH, Shape, city, write_geopackage};

/// Asserts that a line is refused with this code and these words, in short.
fn refused(folder: &Folder, line: &str, code: &str, words: &str) {
    let n_bytes = folder.refuses(line, code, &[words]).err.len();
    assert!(n_bytes < 2000, "{line}: {n_bytes} bytes are said");
}

#[test]
fn long_names_of_columns_are_held_once() {
    let folder = Folder::new();
    let crs = FgbCrs { code: 25832, ..FgbCrs::default() };
    let options = FgbWriterOptions { write_index: false, crs, ..FgbWriterOptions::default() };
    let mut writer = FgbWriter::create_with_options("city", GeometryType::MultiPolygon, options).unwrap();
    // 10 names of 30 kB and 4000 values of each: 1.2 GB, were every value given its name.
    let names: Vec<String> = (0..10).map(|k| format!("{k}{}", "n".repeat(30_000))).collect();
    names.iter().for_each(|name| writer.add_column(name, ColumnType::Bool, |_, _| {}));
    writer.add_column("height", ColumnType::Double, |_, _| {});
    for k in 0..4000 {
        let (x, y) = (EAST + 10.0 * f64::from(k % 64), NORTH + 10.0 * f64::from(k / 64));
        let square = vec![[x, y], [x + 5.0, y], [x + 5.0, y + 5.0], [x, y + 5.0], [x, y]];
        let building = Building { height: "9", polygons: vec![vec![square]] };
        writer
            .add_feature_geom(Shape(&building), |feature| {
                for (k, name) in names.iter().enumerate() {
                    feature.property(k, name, &ColumnValue::Bool(true)).unwrap();
                }
                feature.property(names.len(), "height", &ColumnValue::Double(9.0)).unwrap();
            })
            .unwrap();
    }
    writer.write(std::fs::File::create(folder.join("long.fgb")).unwrap()).unwrap();
    let buildings = folder.type_in("info long.fgb --json").done().json()["buildings"].clone();
    assert_eq!(buildings, 4000);
}

/// A GeoPackage of one building, changed by statements.
fn geopackage(folder: &Folder, name: &str, statements: &str) {
    let city = city();
    write_geopackage(&folder.join(name), &[("city", &city[..1])]);
    Connection::open(folder.join(name)).unwrap().execute_batch(statements).unwrap();
}

#[test]
fn what_a_geopackage_computes_is_not_read() {
    let folder = Folder::new();
    let rows = "WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL SELECT k + 1 FROM n WHERE k < 4000)
        INSERT INTO city (geom, height) SELECT city.geom, city.height FROM n, city LIMIT 4000;";
    // A value that stands in no row but is that of each: 4 GB of text, were it read.
    let long = format!("{rows} ALTER TABLE city ADD COLUMN note TEXT DEFAULT '{}';", "n".repeat(1_000_000));
    geopackage(&folder, "default.gpkg", &long);
    refused(&folder, "info default.gpkg", "E302", "");
    let many: String = (0..1900).map(|k| format!("ALTER TABLE city ADD COLUMN c{k} INTEGER DEFAULT 1;")).collect();
    geopackage(&folder, "many.gpkg", &format!("{rows}{many}"));
    refused(&folder, "info many.gpkg", "E302", "");
    // Columns without values cost nothing.
    let empty = many.replace(" DEFAULT 1", "");
    let few = rows.replace("4000", "20");
    geopackage(&folder, "empty.gpkg", &format!("{few}{empty}"));
    folder.type_in("info empty.gpkg --json").done();
    let blob = "ALTER TABLE city ADD COLUMN big BLOB GENERATED ALWAYS AS (zeroblob(900000000)) VIRTUAL;";
    geopackage(&folder, "blob.gpkg", blob);
    refused(&folder, "info blob.gpkg", "E304", "`big` of `city` is generated");
    let stored = "ALTER TABLE city ADD COLUMN floors INTEGER GENERATED ALWAYS AS (height / 3) VIRTUAL;";
    geopackage(&folder, "generated.gpkg", stored);
    refused(
        &folder,
        "info generated.gpkg",
        "E304",
        "the column `floors` of `city` is generated, wanted one that is stored",
    );
    // Of a table that describes others.
    let slow = "ALTER TABLE gpkg_contents DROP COLUMN data_type;
        ALTER TABLE gpkg_contents ADD COLUMN data_type TEXT GENERATED ALWAYS AS (CASE
        WHEN instr(hex(zeroblob(500000)), hex(zeroblob(250000)) || '1') > 0 THEN 'a' ELSE 'features' END) VIRTUAL;";
    geopackage(&folder, "slow.gpkg", slow);
    refused(&folder, "info slow.gpkg", "E304", "`data_type` of `gpkg_contents` is generated");
    let endless = "DROP TABLE gpkg_contents; CREATE VIEW gpkg_contents AS WITH RECURSIVE n(k) AS
        (SELECT 1 UNION ALL SELECT k + 1 FROM n) SELECT 'city' AS table_name, 'features' AS data_type FROM n WHERE k < 0;";
    geopackage(&folder, "endless.gpkg", endless);
    refused(&folder, "info endless.gpkg", "E302", "no plain table");
}

/// A virtual raster of 4 × 4 cells with all sources over each other.
fn virtual_raster(sources: &[String]) -> String {
    let source = |name: &String| {
        format!(
            "<SimpleSource><SourceFilename relativeToVRT=\"1\">{name}</SourceFilename><SourceBand>1</SourceBand>\
             <SrcRect xOff=\"0\" yOff=\"0\" xSize=\"4\" ySize=\"4\"/><DstRect xOff=\"0\" yOff=\"0\" xSize=\"4\" ySize=\"4\"/>\
             </SimpleSource>"
        )
    };
    let sources: String = sources.iter().map(source).collect();
    format!(
        "<VRTDataset rasterXSize=\"4\" rasterYSize=\"4\"><SRS>EPSG:25832</SRS>\
         <GeoTransform>0, 1, 0, 4, 0, -1</GeoTransform><VRTRasterBand dataType=\"Float32\" band=\"1\">{sources}\
         </VRTRasterBand></VRTDataset>"
    )
}

const GRID: &str = "ncols 4\nnrows 4\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 1 1 1\n1 1 1 1\n1 1 1 1\n1 1 1 1\n";

#[test]
fn virtual_rasters_are_read_at_the_cost_of_their_size() {
    let folder = Folder::new();
    let plain = virtual_raster(&["a.asc".to_string()]);
    folder.write("a.asc", GRID);
    folder.write("plain.vrt", &plain);
    folder.type_in("info plain.vrt --json").done();
    // The parser compares each attribute and each namespace with all others.
    let attributes: String = (0..100_000).map(|k| format!(" a{k}=\"<>'\"")).collect();
    folder.write("attributes.vrt", &plain.replacen("<VRTDataset", &format!("<VRTDataset{attributes}"), 1));
    refused(&folder, "info attributes.vrt", "E502", "more than 500 attributes");
    let namespaces: String = (0..20_000).map(|k| format!("<x xmlns:n{k}=\"u{k}\"/>")).collect();
    folder.write("namespaces.vrt", &plain.replacen("<SRS>", &format!("{namespaces}<SRS>"), 1));
    refused(&folder, "info namespaces.vrt", "E502", "namespaces");
    // What looks like attributes in a comment is none.
    let quotes = "\"'".repeat(100_000);
    folder.write("comment.vrt", &plain.replacen("<SRS>", &format!("<!-- {quotes} --><SRS>"), 1));
    folder.type_in("info comment.vrt --json").done();
    // Three levels of 40 files that name the 40 files below are opened 64 000 times.
    for k in 0..40 {
        folder.write(&format!("0_{k}.asc"), GRID);
        for level in 1..4 {
            let extension = if level == 1 { "asc" } else { "vrt" };
            let below: Vec<String> = (0..40).map(|j| format!("{}_{j}.{extension}", level - 1)).collect();
            folder.write(&format!("{level}_{k}.vrt"), &virtual_raster(&below));
        }
    }
    refused(&folder, "info 3_0.vrt", "E502", "more than 10000 sources");
    folder.type_in("info 2_0.vrt --json").done();
}

#[test]
fn tiles_that_sources_name_again_and_again_are_not_decoded_without_end() {
    let folder = Folder::new();
    folder.write("a.asc", GRID);
    let all = |name: &str, n: usize| virtual_raster(&vec![name.to_string(); n]);
    folder.write("inner.vrt", &all("a.asc", 2000));
    folder.write("few.vrt", &all("inner.vrt", 2));
    folder.write("many.vrt", &all("inner.vrt", 200));
    folder.type_in("info few.vrt --json").done();
    refused(&folder, "info many.vrt", "E502", "too many sources name the same tiles");
}

#[test]
fn a_tile_much_larger_than_its_raster_is_not_decoded() {
    let folder = Folder::new();
    // 3 × 2 cells in one tile of 16 384 × 16 384; so many bytes could hold it.
    let tile = vec![0x78; 1_100_000];
    let tags: [(u16, u16, u32); 11] = [
        (256, 4, 3),
        (257, 4, 2),
        (258, 3, 32),
        (259, 3, 8),
        (262, 3, 1),
        (277, 3, 1),
        (322, 4, 16_384),
        (323, 4, 16_384),
        (324, 4, 8 + 2 + 12 * 11 + 4),
        (325, 4, u32::try_from(tile.len()).unwrap()),
        (339, 3, 3),
    ];
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    bytes.extend(11_u16.to_le_bytes());
    for (tag, kind, value) in tags {
        bytes.extend([tag.to_le_bytes(), kind.to_le_bytes()].concat());
        bytes.extend([1_u32.to_le_bytes(), value.to_le_bytes()].concat());
    }
    bytes.extend([0; 4]);
    bytes.extend(tile);
    std::fs::write(folder.join("six.tif"), bytes).unwrap();
    folder.write("six.tfw", "1\n0\n0\n-1\n500000\n5400000\n");
    refused(&folder, "info six.tif", "E304", "decodes to 1073741824 bytes, at most 67108864 can be held");
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_without_an_end_are_no_tables() {
    let folder = Folder::new();
    folder.write("a.asc", GRID);
    for line in [
        "map a.asc --uavs /dev/zero --json",
        "track a.asc --uav 2,2,30 --track /dev/zero --json",
        "plos itu:urban --theta 30 --curve a=/dev/zero --json",
    ] {
        refused(&folder, line, "E502", "more than 128 MiB, wanted a file");
    }
}

#[cfg(unix)]
#[test]
fn a_pipe_of_uavs_is_read_once() {
    let folder = Folder::new();
    folder.write("a.asc", GRID);
    let pipe = folder.join("uavs");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let writer = std::thread::spawn(move || std::fs::write(pipe, "id,x,y,h\nnorth,2,2,9\n").unwrap());
    let found = folder.type_in("map a.asc --uavs uavs --json");
    writer.join().unwrap();
    assert_eq!(found.done().json()["sites"][0]["id"], "north");
}

#[cfg(unix)]
#[test]
fn a_pipe_is_called_one_and_not_waited_for() {
    let folder = Folder::new();
    let made = std::process::Command::new("mkfifo").arg(folder.join("pipe.asc")).status().unwrap();
    assert!(made.success());
    folder.write("of_pipe.vrt", &virtual_raster(&["pipe.asc".to_string()]));
    for scene in ["of_pipe.vrt", "pipe.asc"] {
        refused(&folder, &format!("info {scene}"), "E301", "a pipe");
    }
    // As an output it is refused, not replaced.
    folder.write("a.asc", GRID);
    refused(&folder, "map a.asc --uav 2,2,9 -o pipe.asc --overwrite", "E105", "a pipe");
    use std::os::unix::fs::FileTypeExt;
    assert!(std::fs::metadata(folder.join("pipe.asc")).unwrap().file_type().is_fifo());
}

#[test]
fn grids_whose_cells_vanish_are_refused() {
    let folder = Folder::new();
    for (corner, cell) in [("0", "1e-307"), ("0", "1e300"), ("1e15", "0.001"), ("0", "1e-12")] {
        let text = GRID
            .replace("cellsize 1", &format!("cellsize {cell}"))
            .replace("xllcorner 0", &format!("xllcorner {corner}"));
        folder.write("a.asc", &text);
        refused(&folder, "info a.asc", "E307", "");
        refused(&folder, "map a.asc --uav 2,2,9 --json", "E307", "");
    }
    refused(&folder, "map itu:urban --cell 1e-300 --uav 2,2,9 --json", "E502", "");
}

/// UTM zone 32 with feet, as Esri writes it.
const FEET: &str = concat!(
    r#"PROJCS["feet",GEOGCS["GCS",DATUM["D",SPHEROID["S",6378137.0,298.257222101]],PRIMEM["Greenwich",0.0],"#,
    r#"UNIT["Degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["False_Easting",500000.0],"#,
    r#"PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",9.0],PARAMETER["Scale_Factor",0.9996],"#,
    r#"PARAMETER["Latitude_Of_Origin",0.0],UNIT["Foot_US",0.3048006096012192]]"#,
);

#[test]
fn a_reference_system_that_is_cut_or_absurd_is_refused() {
    let folder = Folder::new();
    folder.write("a.asc", GRID);
    let cell = |prj: &str| {
        folder.write("a.prj", prj);
        folder.type_in("info a.asc --json")
    };
    let found = cell(FEET).done().json()["cell_m"][0].as_f64().unwrap();
    assert!((found - 0.304_800_609_6).abs() < 1e-9, "{found}");
    // Cut at any place it is no system of meters.
    for end in [FEET.len() - 1, FEET.find(",0.3048").unwrap(), FEET.rfind("UNIT").unwrap(), FEET.find("PARAM").unwrap()]
    {
        assert_eq!(cell(&FEET[..end]).error(), "E310", "cut at {end}");
    }
    for unit in ["1e308", "1e-300", "0", "-1"] {
        assert_eq!(cell(&FEET.replace("0.3048006096012192", unit)).error(), "E310", "{unit}");
    }
    for nonsense in ["PROJCS[]", "PROJCS[\"\"]"] {
        assert_eq!(cell(nonsense).error(), "E310", "{nonsense}");
    }
}

#[test]
fn names_of_any_length_leave_a_picture_its_room() {
    let folder = Folder::new();
    let long = "n".repeat(100);
    folder.write("uavs.csv", &format!("id,x,y,h\n{long}1,20,20,50\n{long}2,60,60,50\n"));
    let line = "map itu:urban --size 100 --uavs uavs.csv --layers count,which -o a.svg -o a.png --height-curve c.svg";
    folder.type_in(line).done();
    folder.type_in("compare itu:urban --size 100 --uavs uavs.csv -o k.svg -o k.png").done();
    for name in ["a.svg", "c.svg", "k.svg"] {
        let text = folder.text(name);
        let width: f64 = text.split("width=\"").nth(1).and_then(|w| w.split('"').next()).unwrap().parse().unwrap();
        assert!(width < 4000.0 && text.contains('…'), "{name}: {width}");
    }
}

#[test]
fn what_a_file_says_beside_its_areas_is_told() {
    let folder = Folder::new();
    let ring = "[[[0, 0], [9, 0], [9, 9], [0, 9], [0, 0]]]";
    let area = format!(r#"{{"type": "Polygon", "coordinates": {ring}}}"#);
    let file = |crs: &str, geometry: &str| {
        let feature = format!(r#"{{"type": "Feature", "properties": {{"height": 9}}, "geometry": {geometry}}}"#);
        folder.write("a.geojson", &format!(r#"{{"type": "FeatureCollection", {crs} "features": [{feature}]}}"#));
        folder.type_in("info a.geojson --json")
    };
    let named = r#""crs": {"type": "name", "properties": {"name": "EPSG:25832"}},"#;
    let point = r#"{"type": "Point", "coordinates": [1, 1]}"#;
    let both = format!(r#"{{"type": "GeometryCollection", "geometries": [{area}, {point}]}}"#);
    assert!(!file(named, &area).done().warnings().contains(&"W350"));
    assert!(file(named, &both).done().warnings().contains(&"W350"), "a point in a collection is told");
    let link = r#""crs": {"type": "link", "properties": {"href": "http://example.com/crs/42"}},"#;
    assert_eq!(file(link, &area).error(), "E310");
}

#[test]
fn threads_are_as_many_as_are_of_use() {
    let folder = Folder::new();
    let line = "map itu:urban --size 100 --uav 20,20,50 --json -q";
    let digest = |line: &str| folder.type_in(line).done().json()["digest"].clone();
    assert_eq!(digest(&format!("{line} -j 65535")), digest(line));
}
