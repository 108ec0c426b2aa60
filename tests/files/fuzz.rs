//! Damaged files of every kind that is read: each must be refused or mapped within seconds and 1 GB, without a panic, and
//! leave nothing half written. And footprints at random: triangulated and mapped, each engine as the oracle says.
//!
//! Inputs are made by mutation from good files: bits turned, numbers replaced by extremes, pieces cut, repeated, moved and
//! nested. Some hundreds in CI, a million with `SKYSHED_LONG=1`. What was found stands in `regressions`.

use std::io::Write;
use std::sync::atomic::{AtomicUsize, Ordering};

use parquet::basic::Compression;
use rayon::prelude::*;
use skyshed_core::raster::GeoRef;

use crate::city_formats;
use crate::formats_write;
use crate::osm_files;
use crate::osm_files_written::Form;
use crate::point_clouds;
use crate::program::{Folder, run_in};
use crate::support::{Random, is_long};
use crate::vector_files;
use crate::xyz_files;

/// A kind of file: its name in the folder of good files, the files beside it that it needs, and the commands that read it.
struct Target {
    name: &'static str,
    beside: &'static [&'static str],
    lines: Vec<String>,
}

const FOOTPRINTS: &str = r#"{"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": "EPSG:25832"}},
"features": [
 {"type": "Feature", "id": 1, "properties": {"height": 12.5}, "geometry": {"type": "Polygon", "coordinates":
  [[[10, 10], [30, 10], [30, 25], [10, 25], [10, 10]], [[15, 14], [15, 20], [22, 20], [22, 14], [15, 14]]]}},
 {"type": "Feature", "properties": {"height": "8,5", "building:levels": 3}, "geometry": {"type": "MultiPolygon",
  "coordinates": [[[[40, 10], [50, 12.25], [44, 30], [40, 10]]], [[[5, 40], [20, 41], [12, 50], [5, 40]]]]}}
]}"#;

const SITES: &str = "# places\nid,x,y,h,h_above\na,5,5,60,ground\nb,35.5,30,90,amsl\n\"c d\",12,12,20,roof\n";

const POINTS: &str = r#"{"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": "EPSG:25832"}}, "features": [
 {"type": "Feature", "properties": {"h": 60, "id": "a"}, "geometry": {"type": "Point", "coordinates": [5, 5]}}]}"#;

const GPX: &str = r#"<gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1"><wpt lat="1e-4" lon="4.5114"/><trk><name>a</name><trkseg>
<trkpt lat="1e-4" lon="4.5114"><ele>20</ele><time>2026-05-01T10:00:00Z</time></trkpt><trkpt lat="2e-4" lon="4.5116"><ele>25.5</ele>
<time>2026-05-01T10:00:09.5Z</time></trkpt></trkseg></trk></gpx>"#;

const KML: &str = r#"<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2"><Document><Placemark>
<LineString><altitudeMode>relativeToGround</altitudeMode><coordinates>4.5114,0.0001,20 4.5116,0.0002,30</coordinates></LineString></Placemark>
<Placemark><gx:Track><altitudeMode>absolute</altitudeMode><when>2026-05-01T10:00:00Z</when><when>2026-05-01T10:00:09Z</when>
<gx:coord>4.5114 0.0001 20</gx:coord><gx:coord>4.5113 0.0002 9</gx:coord></gx:Track></Placemark></Document></kml>"#;

const PLAN: &str = r#"{"fileType": "Plan", "mission": {"plannedHomePosition": [0.0001, 4.5114, 3], "items": [
 {"type": "SimpleItem", "command": 22, "frame": 3, "AltitudeMode": 1, "Altitude": 20, "params": [0, 0, 0, null, 0, 0, 20]},
 {"type": "ComplexItem", "complexItemType": "survey", "TransectStyleComplexItem": {"Items": [
  {"type": "SimpleItem", "command": 16, "frame": 10, "params": [0, 0, 0, null, 0.0002, 4.5116, 30]}]}},
 {"type": "SimpleItem", "command": 20, "frame": 2, "params": [0, 0, 0, 0, 0, 0, 0]}]}}"#;

const WAYPOINTS: &str = "QGC WPL 110\n0\t1\t0\t16\t0\t0\t0\t0\t0.0001\t4.5114\t5\t1\n\
1\t0\t3\t22\t0\t0\t0\t0\t0.0001\t4.5114\t20\t1\n2\t0\t10\t16\t0\t0\t0\t0\t0.0002\t4.5116\t30\t1\n3\t0\t3\t21\t0\t0\t0\t0\t0\t0\t0\t1\n";

fn grid() -> String {
    let rows = (0..12).map(|r| {
        (0..16).map(|c| if (4..7).contains(&c) && r > 3 { "14.25" } else { "2" }).collect::<Vec<_>>().join(" ")
    });
    let head = "ncols 16\nnrows 12\nxllcorner 100\nyllcorner -50.5\ncellsize 2.5\nNODATA_value -9999\n";
    head.to_string() + &rows.collect::<Vec<_>>().join("\n") + "\n"
}

/// A virtual raster over a tile that lies beside it: a copy, and one that is scaled and cut.
const VIRTUAL: &str = r#"<VRTDataset rasterXSize="20" rasterYSize="14">
<SRS dataAxisToSRSAxisMapping="1,2">EPSG:25832</SRS><GeoTransform>500000, 2.5, 0, 5400000, 0, -2.5</GeoTransform>
<VRTRasterBand dataType="Float32" band="1"><NoDataValue>-9999</NoDataValue><SimpleSource>
<SourceFilename relativeToVRT="1">tile.asc</SourceFilename><SourceBand>1</SourceBand>
<SourceProperties RasterXSize="16" RasterYSize="12" DataType="Float32" BlockXSize="16" BlockYSize="1"/>
<SrcRect xOff="0" yOff="0" xSize="16" ySize="12"/><DstRect xOff="0" yOff="0" xSize="16" ySize="12"/></SimpleSource>
<ComplexSource><SourceFilename relativeToVRT="1">tile.asc</SourceFilename>
<SrcRect xOff="2" yOff="1" xSize="9" ySize="8"/><DstRect xOff="11" yOff="6" xSize="9" ySize="8"/>
<ScaleOffset>1.5</ScaleOffset><ScaleRatio>0.5</ScaleRatio><NODATA>2</NODATA></ComplexSource>
</VRTRasterBand></VRTDataset>"#;

/// A reference system in words.
const SYSTEM: &str = r#"PROJCS["a",GEOGCS["b",DATUM["c",SPHEROID["GRS 1980",6378137,298.257222101]],PRIMEM["Greenwich",0],
UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["central_meridian",9],
PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],UNIT["Foot_US",0.304800609601219]]"#;

/// Heights and how opaque their cells are.
fn half_opaque() -> Vec<u8> {
    let georef = GeoRef::new((0.0, 12.0), (1.0, 1.0), (12, 16), None).expect("a valid grid");
    #[expect(clippy::cast_precision_loss, reason = "small numbers")]
    let heights: Vec<f32> = (0..192).map(|k| (k % 7) as f32).collect();
    let opaque: Vec<f32> = (0..192).map(|k| if k % 11 == 0 { 0.0 } else { 255.0 }).collect();
    formats_write::with_opacity(&georef, &heights, &opaque, 2)
}

/// A folder with a good file of every kind.
fn good_files() -> Folder {
    let folder = Folder::new();
    let texts = [
        ("grid.asc", &*grid()),
        ("tile.asc", &grid()),
        ("named.asc", &grid()),
        ("mosaic.vrt", VIRTUAL),
        ("named.prj", SYSTEM),
        ("names.csv", SITES),
        ("sites.csv", SITES),
        ("tiles.geojson", FOOTPRINTS),
        ("city.geojson", FOOTPRINTS),
        ("area.geojson", FOOTPRINTS),
        ("sites.geojson", POINTS),
        ("walk.csv", "x,y\n1,1\n20,5\n45.5,30\n"),
        ("flight.csv", "x,y,h,h_above,t\n1,1,20,ground,0\n20,5,30,amsl,9.5\n45.5,30,10,ground,2\n"),
        ("flight.gpx", GPX),
        ("flight.kml", KML),
        ("flight.plan", PLAN),
        ("flight.waypoints", WAYPOINTS),
        ("curve.csv", "theta_deg,p_los\n5,0.1\n45,0.6\n90,1\n"),
    ];
    texts.iter().for_each(|(name, text)| folder.write(name, text));
    std::fs::write(folder.join("opacity.tif"), half_opaque()).unwrap();
    let city = vector_files::city();
    vector_files::write_shapefile(&folder.join("town.shp"), &city);
    vector_files::write_flatgeobuf(&folder.join("town.fgb"), &city, false);
    vector_files::write_flatgeobuf(&folder.join("index.fgb"), &city, true);
    vector_files::write_geopackage(&folder.join("town.gpkg"), &[("buildings", &city)]);
    vector_files::write_cityjson(&folder.join("town.city.json"), &city, "2.0");
    folder.write("town.gml", &city_formats::citygml(&city, 2));
    folder.write("parts.gml", &city_formats::cadastre(&city, &[4, 2, 3]));
    city_formats::write_geoparquet(&folder.join("town.parquet"), &city, Compression::SNAPPY, 2);
    let osm = osm_files::town().osm;
    folder.write("town.osm", &osm.xml());
    folder.write("nodes.json", &osm.overpass(Form::Nodes));
    folder.write("places.json", &osm.overpass(Form::Places));
    std::fs::write(folder.join("town.osm.pbf"), osm.pbf(true).0).unwrap();
    folder.write("grid.xyz", &xyz_files::grid(","));
    let points: Vec<_> = point_clouds::city_points().into_iter().step_by(7).collect();
    std::fs::write(folder.join("town.las"), point_clouds::cloud(&points, 1, false, None)).unwrap();
    std::fs::write(folder.join("town.laz"), point_clouds::cloud(&points, 6, true, None)).unwrap();
    let document: serde_json::Value = serde_json::from_str(FOOTPRINTS).unwrap();
    let lines: Vec<String> = document["features"].as_array().unwrap().iter().map(ToString::to_string).collect();
    folder.write("lines.geojsonl", &lines.join("\n"));
    let mut gz = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    gz.write_all(FOOTPRINTS.as_bytes()).unwrap();
    std::fs::write(folder.join("city.geojson.gz"), gz.finish().unwrap()).unwrap();
    let mut zip = zip::ZipWriter::new(std::fs::File::create(folder.join("town.zip")).unwrap());
    for name in ["town.shp", "town.dbf", "town.shx", "town.prj"] {
        zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(&folder.read(name)).unwrap();
    }
    zip.finish().unwrap();
    vector_files::write_obj(&folder.join("town.obj"));
    vector_files::write_ply(&folder.join("text.ply"), "ascii");
    vector_files::write_ply(&folder.join("bytes.ply"), "binary_little_endian");
    for line in [
        "city itu:urban --size 60 -o surface.tif",
        "map itu:urban --size 60 --uav 5,5,80 --layers margin --tif-layout plain -o plain.tif",
        "map itu:urban --size 60 --uav 5,5,80 -o mask.tif",
    ] {
        folder.type_in(line).done();
    }
    folder
}

fn targets() -> Vec<Target> {
    let of_line = |name, line: &str| Target { name, beside: &["city.geojson"], lines: vec![line.into()] };
    let scene = |name, beside, options: &str, uav: &str| {
        let lines = [
            format!("info {name}"),
            format!("map {name} {options} --uav {uav} -o out.json"),
            format!("zones {name} {options} -o out.csv"),
            format!("place {name} {options} --height 60 --step 20 -o out.csv"),
        ];
        Target { name, beside, lines: lines.to_vec() }
    };
    let town = |name, beside, options: &str| {
        scene(name, beside, &format!("{options} --extent 690998,5333998,691080,5334070"), "691005,5334005,60")
    };
    let osm = |name| {
        let options = "--project auto --missing levels --extent 686100,5330420,686260,5330560";
        scene(name, &[], options, "686130,5330450,60")
    };
    let cloud = |name| scene(name, &[], "--ground 10 --cell 4", "691005,5334705,60");
    let mesh = |name| scene(name, &[], "", "1,1,60");
    let flight = |name| {
        let line = format!("track city.geojson --uav 5,5,60 --track {name} --every 50 -o out.json");
        of_line(name, &line)
    };
    let small = "--extent -2,-2,60,60";
    vec![
        scene("grid.asc", &[], "--ground 2", "101,-45,40"),
        scene("mosaic.vrt", &["tile.asc"], "--ground 2", "500003,5399990,40amsl"),
        scene("surface.tif", &[], "--ground 0", "5,5,80"),
        scene("plain.tif", &[], "", "5,5,80amsl"),
        scene("opacity.tif", &[], "--ground 0", "5,5,60"),
        scene("city.geojson", &[], small, "5,5,60"),
        town("town.shp", &["town.dbf", "town.shx", "town.prj"], ""),
        town("town.dbf", &["town.shp", "town.shx", "town.prj"], ""),
        town("town.fgb", &[], ""),
        town("index.fgb", &[], ""),
        town("town.gpkg", &[], ""),
        town("town.city.json", &[], ""),
        town("town.gml", &[], ""),
        town("parts.gml", &[], "--missing levels"),
        town("town.parquet", &[], ""),
        scene("lines.geojsonl", &[], "--crs EPSG:25832 --extent -2,-2,60,60", "5,5,60"),
        scene("city.geojson.gz", &[], small, "5,5,60"),
        town("town.zip", &[], ""),
        osm("town.osm"),
        osm("nodes.json"),
        osm("places.json"),
        osm("town.osm.pbf"),
        scene("grid.xyz", &[], "--ground 480", "691005,5333995,60"),
        cloud("town.las"),
        cloud("town.laz"),
        mesh("town.obj"),
        mesh("text.ply"),
        mesh("bytes.ply"),
        Target {
            beside: &["named.asc"],
            ..of_line("named.prj", "map named.asc --ground 2 --uav 101,-45,40 -o out.json")
        },
        // Names in pictures, and footprints cut to tiles.
        of_line("names.csv", "map city.geojson --uavs names.csv --height-curve out.svg"),
        of_line("tiles.geojson", "info tiles.geojson --tile 7 -o out.csv"),
        of_line("sites.csv", "map city.geojson --uavs sites.csv -o out.json"),
        of_line("sites.geojson", "map city.geojson --uavs sites.geojson -o out.json"),
        of_line("walk.csv", "track city.geojson --uav 5,5,60 --track walk.csv -o out.json"),
        flight("flight.csv"),
        flight("flight.gpx"),
        flight("flight.kml"),
        flight("flight.plan"),
        flight("flight.waypoints"),
        of_line(
            "area.geojson",
            "place city.geojson --height 60 --step 20 --goal p_los(area) --area area.geojson -o out.json",
        ),
        of_line("curve.csv", "plos itu:urban --theta 30,60 --method itu --curve mine=curve.csv -o out.json"),
        of_line("mask.tif", "compare itu:urban --size 60 --uav 5,5,70 --mask mask.tif -o out.json"),
    ]
}

/// Numbers that parsers and arithmetic stumble over; one of them is none at all.
const NUMBERS: &str =
    "1e-307|1e150|0|-0|1e308|-1e308|1e-320|nan|inf|-inf|99999999999999999999|1,5|0x10||--1|1e|4294967296|-32769";

/// A damaged copy.
fn damaged(good: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for _ in 0..random.index(1, 4) {
        if bytes.is_empty() {
            break;
        }
        let at = random.below(bytes.len());
        let n = random.index(1, 40).min(bytes.len() - at);
        match random.below(11) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes.truncate(at),
            2 => drop(bytes.drain(at..at + n)),
            3 => {
                let piece = bytes[at..at + n].to_vec();
                let to = random.below(bytes.len());
                let times = random.choose(&[1, 1, 2, 500]);
                (0..times).for_each(|_| drop(bytes.splice(to..to, piece.iter().copied())));
            }
            4 => {
                let value = random.choose(&[0_u64, 1, 0x7FFF, 0xFFFF, 0x7FFF_FFFF, 0xFFFF_FFFF, u64::MAX, 1 << 40]);
                let width = random.choose(&[1, 2, 4, 8]).min(bytes.len() - at);
                bytes[at..at + width].copy_from_slice(&value.to_le_bytes()[..width]);
            }
            5 => drop(bytes.splice(
                at..at,
                random.choose(&[&b"{"[..], b"[", b"]", b"}", b"\"", b",", b"\0", b"\xff\xfe", b"\n"]).iter().copied(),
            )),
            6 => drop(bytes.splice(at..at, vec![b'['; random.choose(&[3, 200, 20_000])])),
            // A long name, or much of what is small.
            7 => drop(bytes.splice(at..at, vec![random.choose(b"nW \n0,<"); random.choose(&[100, 5000, 50_000])])),
            _ => replace_a_number(&mut bytes, at, random),
        }
    }
    bytes
}

/// Replaces the number nearest behind a place, if there is one.
fn replace_a_number(bytes: &mut Vec<u8>, from: usize, random: &mut Random) {
    let is_digit = |b: &u8| b.is_ascii_digit() || b".-".contains(b);
    let Some(start) = bytes[from..].iter().position(is_digit).map(|k| from + k) else { return };
    let end = bytes[start..].iter().position(|b| !is_digit(b)).map_or(bytes.len(), |k| start + k);
    let numbers: Vec<&str> = NUMBERS.split('|').collect();
    bytes.splice(start..end, random.choose(&numbers).bytes());
}

/// Keeps the good files as the first inputs of `fuzz/run.sh`, in the folder that `SKYSHED_SEEDS` names.
#[test]
fn good_files_are_seeds() {
    let Some(into) = std::env::var_os("SKYSHED_SEEDS").map(std::path::PathBuf::from) else { return };
    let good = good_files();
    std::fs::create_dir_all(&into).unwrap();
    for name in good.files() {
        std::fs::write(into.join(&name), good.read(&name)).unwrap();
    }
}

#[test]
fn damaged_files_are_refused_or_mapped_and_leave_nothing_half_written() {
    let (good, targets) = (good_files(), targets());
    let n = if is_long() { 1_000_000 } else { 600 } / targets.len() as u64;
    let (n_done, n_refused) = (AtomicUsize::new(0), AtomicUsize::new(0));
    for (kind, target) in targets.iter().enumerate() {
        let sample = good.read(target.name);
        let beside: Vec<(&str, Vec<u8>)> = target.beside.iter().map(|name| (*name, good.read(name))).collect();
        (0..n).into_par_iter().for_each(|k| {
            let mut random = Random(1_000_000 * kind as u64 + k);
            let bytes = damaged(&sample, &mut random);
            let folder = Folder::new();
            let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).unwrap();
            beside.iter().for_each(|(name, bytes)| write(name, bytes));
            write(target.name, &bytes);
            let mut expected = folder.files();
            let line = &target.lines[usize::try_from(k).unwrap() % target.lines.len()];
            let answer = run_in(folder.path(), &line.split_whitespace().collect::<Vec<_>>());
            let keep = || {
                let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("found-{k}-{}", target.name));
                let _ = std::fs::write(&path, &bytes);
                format!("`{line}` on {}: {answer:?}", path.display())
            };
            let code = answer.status.code();
            assert!(code.is_some_and(|c| [0, 2, 3, 4, 5].contains(&c)), "{}", keep());
            if code == Some(0) {
                let outputs = ["out.json", "out.svg", "out.csv", "out.csv.json"].into_iter();
                expected.extend(outputs.filter(|name| line.contains(&name[..7])).map(str::to_string));
                n_done.fetch_add(1, Ordering::Relaxed);
            } else {
                assert!(answer.err.starts_with("error[E"), "{}", keep());
                n_refused.fetch_add(1, Ordering::Relaxed);
            }
            expected.sort();
            assert_eq!(folder.files(), expected, "{}", keep());
        });
    }
    let (n_done, n_refused) = (n_done.into_inner(), n_refused.into_inner());
    assert!(n_done > n_refused / 20 && n_refused > n_done / 20, "{n_done} mapped, {n_refused} refused");
}

/// A ring of random corners on a coarse lattice or a step off it: it may cross itself, touch itself and turn back.
fn ring(random: &mut Random) -> Vec<[f64; 2]> {
    let coordinate = |random: &mut Random| {
        #[expect(clippy::cast_precision_loss, reason = "small numbers")]
        let on_the_lattice = random.within(0, 24) as f64 * 2.0;
        on_the_lattice + random.choose(&[0.0, 0.0, 0.0, 1.0 / 1024.0, -1.0 / 1024.0, 0.3])
    };
    let mut corners: Vec<[f64; 2]> =
        (0..random.index(3, 9)).map(|_| [coordinate(random), coordinate(random)]).collect();
    if random.chance(20) {
        let k = random.below(corners.len());
        corners.insert(k, corners[k]);
    }
    corners.push(corners[0]);
    corners
}

#[test]
fn footprints_at_random_are_mapped_as_rays_say() {
    let n: u64 = if is_long() { 3000 } else { 20 };
    let n_seen = AtomicUsize::new(0);
    (0..n).into_par_iter().for_each(|k| {
        let mut random = Random(77_000 + k);
        let heights = [0.0, 3.0, 3.0, 9.5, 9.5, 20.0];
        let feature = |random: &mut Random| {
            let rings: Vec<Vec<[f64; 2]>> = (0..random.choose(&[1, 1, 2, 3])).map(|_| ring(random)).collect();
            serde_json::json!({
                "type": "Feature", "properties": {"height": random.choose(&heights)},
                "geometry": {"type": "Polygon", "coordinates": rings},
            })
        };
        let features: Vec<_> = (0..random.index(1, 12)).map(|_| feature(&mut random)).collect();
        let folder = Folder::new();
        let document = serde_json::json!({"type": "FeatureCollection", "features": features});
        folder.write("city.geojson", &document.to_string());
        let place = format!("{},{}", random.within(0, 50), random.within(0, 50));
        let height = random.choose(&["25", "20", "9.5", "60amsl", "3"]);
        let line = |method: &str| {
            format!(
                "map city.geojson --extent -2,-2,52,52 --uav {place},{height} --receivers all --method {method} --json"
            )
        };
        let fast = folder.type_in(&line("auto"));
        if fast.status.code() == Some(4) {
            return;
        }
        let (fast, slow) = (fast.done().json(), folder.type_in(&line("ray")).done().json());
        assert_eq!(fast["digest"], slow["digest"], "{document} seen from {place},{height}");
        n_seen.fetch_add(1, Ordering::Relaxed);
    });
    assert!(n_seen.into_inner() as u64 > n / 4);
}
