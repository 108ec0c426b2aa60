//! Point clouds: the city of its own rasters, the heights of cells by hand, units, extents.

#![expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "places in a small city")]

use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;

use las::point::{Classification, Format};
use las::{Builder, Point, Transform, Vector, Vlr, Writer};
use serde_json::Value;
use skyshed_core::city::{City, Ground, Solids};
use skyshed_core::quantity::height_steps;
use skyshed_io::Warning;
use skyshed_io::read::{PointCloudOptions, read_point_cloud};

use crate::needs::truth;
use crate::program::Folder;
use crate::support::Random;

/// Steps of stored coordinates: exact in binary, as heights of the lattice are.
const SCALE: f64 = 1.0 / 1024.0;

/// A point of some class, the only return of its pulse.
fn point([x, y, z]: [f64; 3], class: u8) -> Point {
    let classification = Classification::new(class).unwrap();
    Point { x, y, z, classification, return_number: 1, number_of_returns: 1, ..Point::default() }
}

/// The bytes of a file with some points; `crs` is the text of its system.
pub(crate) fn cloud(points: &[Point], format: u8, is_compressed: bool, crs: Option<&str>) -> Vec<u8> {
    let mut builder = Builder::from(if format >= 6 { (1, 4) } else { (1, 2) });
    builder.point_format = Format::new(format).unwrap();
    builder.point_format.is_compressed = is_compressed;
    let of = |at: f64| Transform { scale: SCALE, offset: at };
    builder.transforms = Vector { x: of(690_000.0), y: of(5_334_000.0), z: of(0.0) };
    if let Some(text) = crs {
        let data = text.as_bytes().to_vec();
        let record = Vlr { user_id: "LASF_Projection".into(), record_id: 2112, description: String::new(), data };
        builder.vlrs.push(record);
        builder.has_wkt_crs = format >= 6;
    }
    let mut writer = Writer::new(Cursor::new(Vec::new()), builder.into_header().unwrap()).unwrap();
    for point in points {
        let of = *writer.header().point_format();
        let gps_time = of.has_gps_time.then_some(1.0);
        let (color, nir) = (of.has_color.then(las::Color::default), of.has_nir.then_some(1));
        writer.write_point(Point { gps_time, color, nir, ..point.clone() }).unwrap();
    }
    writer.into_inner().unwrap().into_inner()
}

pub(crate) const EAST: f64 = 691_000.0;
const NORTH: f64 = 5_334_700.0;
pub(crate) const EDGE: usize = 48;

/// The height of the ground in a slope, exact on the lattice at centers of cells.
fn ground_at(x: f64, y: f64) -> f64 {
    16.0 + (x - EAST) / 64.0 - (y - NORTH) / 128.0
}

/// The height of the roof over a cell, if one is there.
fn roof_at(col: usize, row: usize) -> Option<f64> {
    match (col, row) {
        (6..16, 8..20) => Some(31.5),
        (24..40, 26..34) => Some(27.25),
        _ => None,
    }
}

/// A city of two blocks on a slope: ground every half meter but under roofs, roofs, a tree, a bird, a point that is withheld.
pub(crate) fn city_points() -> Vec<Point> {
    let mut points = Vec::new();
    for row in 0..EDGE {
        for col in 0..EDGE {
            for (dx, dy) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)] {
                let (x, y) = (EAST + col as f64 + dx, NORTH + row as f64 + dy);
                points.push(match roof_at(col, row) {
                    // The highest of a cell counts.
                    Some(z) => point([x, y, if dx < 0.5 { z } else { z - 0.5 }], 6),
                    None => point([x, y, ground_at(x, y)], 2),
                });
            }
        }
    }
    let odd = |z: f64, class: u8| point([EAST + 20.5, NORTH + 4.5, z], class);
    points.extend([odd(25.0, 5), odd(400.0, 18), odd(-300.0, 7), odd(30.0, 17), odd(22.0, 13)]);
    points.push(Point { is_withheld: true, ..odd(60.0, 6) });
    points
}

/// Writes the city of the points as two grids of text.
fn write_rasters(folder: &Folder) {
    let grid = |height: &dyn Fn(usize, usize) -> f64| {
        let row = |row: usize| (0..EDGE).map(|col| height(col, row).to_string()).collect::<Vec<_>>().join(" ");
        let rows: Vec<String> = (0..EDGE).rev().map(row).collect();
        format!("ncols {EDGE}\nnrows {EDGE}\nxllcorner {EAST}\nyllcorner {NORTH}\ncellsize 1\n{}\n", rows.join("\n"))
    };
    let ground = |col: usize, row: usize| ground_at(EAST + col as f64 + 0.5, NORTH + row as f64 + 0.5);
    folder.write("ground.asc", &grid(&ground));
    folder.write("surface.asc", &grid(&|col, row| roof_at(col, row).unwrap_or_else(|| ground(col, row))));
}

/// Digests of three maps of a scene.
fn digests(folder: &Folder, scene: &str) -> Vec<String> {
    let digest = |uav: &str| {
        let document = folder.type_in(&format!("map {scene} --uav {uav} --json")).done().json();
        document["digest"].as_str().unwrap_or_else(|| panic!("{document}")).to_string()
    };
    ["691020.5,5334704.5,40", "691003.2,5334730.1,12", "691044.0,5334741.0,90"].map(digest).to_vec()
}

#[test]
fn a_cloud_of_a_city_is_the_city_of_its_rasters() {
    let folder = Folder::new();
    write_rasters(&folder);
    let wanted = digests(&folder, "surface.asc --terrain ground.asc --crs EPSG:25832");
    assert!(wanted[0] != wanted[1] && wanted[1] != wanted[2]);
    let points = city_points();
    for (format, is_compressed) in [(0, false), (1, true), (3, true), (6, false), (6, true), (7, true)] {
        let name = format!("f{format}.{}", if is_compressed { "laz" } else { "las" });
        fs::write(folder.join(&name), cloud(&points, format, is_compressed, None)).unwrap();
        assert_eq!(digests(&folder, &format!("{name} --cell 1 --crs EPSG:25832")), wanted, "{name}");
        // All open cells hold ground, so that cells of 1 m are chosen, too.
        let chosen = folder.type_in(&format!("info {name} --crs EPSG:25832 --json")).done();
        assert_eq!(chosen.warnings(), Vec::<&str>::new(), "{name}");
        assert_eq!(chosen.json()["cell_m"], serde_json::json!([1.0, 1.0]));
    }
    // The first bytes decide, not the name; the order of points changes nothing.
    let mut reversed = points.clone();
    reversed.reverse();
    fs::write(folder.join("cloud.bin"), cloud(&reversed, 6, true, None)).unwrap();
    assert_eq!(digests(&folder, "cloud.bin --crs EPSG:25832"), wanted);
}

#[test]
fn tiles_are_one_cloud() {
    let folder = Folder::new();
    let points = city_points();
    fs::write(folder.join("whole.laz"), cloud(&points, 6, true, None)).unwrap();
    let wanted = digests(&folder, "whole.laz --cell 1");
    fs::create_dir(folder.join("tiles")).unwrap();
    let mut zip = zip::ZipWriter::new(fs::File::create(folder.join("tiles.zip")).unwrap());
    let mut names = Vec::new();
    for k in 0..3_u8 {
        // Tiles that share cells, and a block.
        let of = |p: &&Point| (((p.x - EAST) / 10.3).floor() as i64).rem_euclid(3) == i64::from(k);
        let bytes = cloud(&points.iter().filter(of).cloned().collect::<Vec<_>>(), 6, k != 1, None);
        names.push(format!("tiles/t{k}.{}", if k == 1 { "las" } else { "laz" }));
        fs::write(folder.join(&names[usize::from(k)]), &bytes).unwrap();
        zip.start_file(format!("deep/t{k}.laz"), zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(&bytes).unwrap();
    }
    zip.finish().unwrap();
    folder.write("tiles/readme.txt", "three tiles");
    for scene in ["tiles", "tiles.zip", &names.join("+")] {
        assert_eq!(digests(&folder, &format!("{scene} --cell 1")), wanted, "{scene}");
    }
    // A tile outside of the extent is not read.
    let bytes = folder.read("tiles/t0.laz");
    fs::write(folder.join("far.laz"), &bytes[..bytes.len() - 100]).unwrap();
    let inside = "--extent 691010,5334700,691018,5334748 --cell 1 --uav 691012,5334720,50";
    folder.type_in(&format!("map tiles/t1.las+tiles/t2.laz {inside}")).done();
}

/// What a read of a scene gives: surface and ground \[1/1024 m\], and the codes of warnings.
fn read(path: &Path, options: &PointCloudOptions) -> (City, Vec<String>) {
    let mut warnings: Vec<Warning> = Vec::new();
    let city = read_point_cloud(path, options, &mut warnings).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    (city, warnings.iter().map(Warning::code).collect())
}

fn heights(city: &City) -> (Vec<i32>, Vec<i32>) {
    let Solids::Raster { surface, ground: Ground::Terrain(ground), .. } = &city.solids else { panic!("{city:?}") };
    (surface.cells().to_vec(), ground.cells().to_vec())
}

/// Points at random, cell by cell: means of the ground and tops of roofs, as sums and maxima of `f64` tell them.
#[test]
fn cells_hold_the_mean_of_the_ground_and_the_highest_roof() {
    let folder = Folder::new();
    let path = folder.join("a.laz");
    for (seed, has_roofs) in [(1, true), (2, true), (3, false)] {
        let (mut random, n) = (Random(seed), 12_usize);
        let mut points = Vec::new();
        for _ in 0..6000 {
            let mut along = |from: f64| from + random.below(n * 1024) as f64 / 1024.0;
            let at = [along(EAST), along(NORTH), 100.0 + random.below(40_000) as f64 / 1024.0];
            let class = random.choose(&[0, 1, 2, 2, 3, 5, 6, 7, 8, 9, 10, 11, 14, 17, 18, 40, 70]);
            let class = if class == 6 && !has_roofs { 1 } else { class };
            let returns = random.choose(&[(1, 1), (1, 2), (2, 2), (2, 3), (0, 0)]);
            let is_withheld = random.chance(10);
            points.push(Point {
                return_number: returns.0,
                number_of_returns: returns.1,
                is_withheld,
                is_synthetic: random.chance(10),
                ..point(at, class)
            });
        }
        let cell = |p: &Point| {
            let index = |from: f64, v: f64| (v - from).floor() as usize;
            (n - 1 - index(NORTH, p.y)) * n + index(EAST, p.x)
        };
        let (mut ground, mut top) = (vec![Vec::new(); n * n], vec![f64::NEG_INFINITY; n * n]);
        for p in points.iter().filter(|p| !p.is_withheld) {
            let is_last = p.return_number >= p.number_of_returns;
            match u8::from(p.classification) {
                2 | 8 | 9 | 10 | 11 => ground[cell(p)].push(p.z),
                6 => top[cell(p)] = top[cell(p)].max(p.z),
                0 | 1 | 40 | 70 if !has_roofs && is_last => top[cell(p)] = top[cell(p)].max(p.z),
                _ => {}
            }
        }
        assert!(ground.iter().all(|of_cell| !of_cell.is_empty()), "each cell has ground: {seed}");
        let mean = |of_cell: &Vec<f64>| of_cell.iter().sum::<f64>() / of_cell.len() as f64;
        let wanted_ground: Vec<i32> = ground.iter().map(|of_cell| height_steps(mean(of_cell)).unwrap()).collect();
        let roof = |k: usize| height_steps(top[k]).unwrap_or(i32::MIN).max(wanted_ground[k]);
        let wanted_surface: Vec<i32> = (0..n * n).map(roof).collect();
        for (format, is_compressed) in [(1, true), (6, true), (8, true), (6, false)] {
            let points: Vec<Point> = match format {
                // Classes from 32 on have no place in old formats.
                1 => points
                    .iter()
                    .map(|p| match u8::from(p.classification) {
                        40 | 70 => Point { classification: Classification::new(1).unwrap(), ..p.clone() },
                        _ => p.clone(),
                    })
                    .collect(),
                _ => points.clone(),
            };
            fs::write(&path, cloud(&points, format, is_compressed, None)).unwrap();
            let options = PointCloudOptions { cell_m: Some(1.0), ..PointCloudOptions::default() };
            let (city, codes) = read(&path, &options);
            assert_eq!(heights(&city), (wanted_surface.clone(), wanted_ground.clone()), "{seed} {format}");
            assert_eq!(codes.contains(&"W390".to_string()), !has_roofs, "{codes:?}");
        }
    }
}

#[test]
fn without_roofs_last_returns_are_the_surface_and_without_ground_one_is_needed() {
    let folder = Folder::new();
    let plain: Vec<Point> = city_points()
        .into_iter()
        .map(|p| match u8::from(p.classification) {
            6 => Point { classification: Classification::new(1).unwrap(), ..p },
            _ => p,
        })
        .collect();
    fs::write(folder.join("plain.laz"), cloud(&plain, 6, true, None)).unwrap();
    fs::write(folder.join("city.laz"), cloud(&city_points(), 6, true, None)).unwrap();
    let map = |name: &str| folder.type_in(&format!("map {name} --cell 1 --uav 691020.5,5334704.5,40 --json")).done();
    let told = map("plain.laz");
    assert!(told.warnings().contains(&"W390") && told.err.contains("trees count as walls"), "{}", told.err);
    assert_eq!(told.json()["digest"], map("city.laz").json()["digest"]);

    let none: Vec<Point> = plain
        .into_iter()
        .filter(|p| ![7, 18].contains(&u8::from(p.classification)))
        .map(|p| Point { classification: Classification::new(1).unwrap(), ..p })
        .collect();
    fs::write(folder.join("none.laz"), cloud(&none, 6, true, None)).unwrap();
    folder.refuses("info none.laz", "E308", &["none.laz", "class 2", "--ground", "--terrain"]);
    let info = folder.type_in("info none.laz --ground 12 --json").done();
    assert_eq!(info.json()["ground_m"], serde_json::json!([12.0, 12.0]));
    write_rasters(&folder);
    let info = folder.type_in("info none.laz --terrain ground.asc --json").done();
    assert!(info.warnings().contains(&"W390"), "{}", info.err);
    // A ground that is set counts in place of the cloud's own.
    let over = folder.type_in("info city.laz --ground 5 --json").done().json();
    assert_eq!(over["ground_m"], serde_json::json!([5.0, 5.0]));
}

#[test]
fn cells_grow_until_they_hold_ground_unless_their_size_is_set() {
    let folder = Folder::new();
    // Cars every meter, ground every two.
    let mut points = Vec::new();
    for (row, col) in (0..40).flat_map(|row| (0..40).map(move |col| (row, col))) {
        let at = |z: f64| [EAST + f64::from(col) + 0.5, NORTH + f64::from(row) + 0.5, z];
        points.push(point(at(2.0), if col > 30 && row > 30 { 6 } else { 1 }));
        if col % 2 == 1 && row % 2 == 0 {
            points.push(point(at(1.0), 2));
        }
    }
    fs::write(folder.join("a.laz"), cloud(&points, 1, true, None)).unwrap();
    let grown = folder.type_in("info a.laz --json").done();
    assert!(grown.warnings().contains(&"W391") && grown.err.contains("cells of 2 m"), "{}", grown.err);
    assert_eq!(grown.json()["cell_m"], serde_json::json!([2.0, 2.0]));
    assert_eq!(grown.json()["extent"], serde_json::json!([EAST, NORTH, EAST + 40.0, NORTH + 40.0]));
    let kept = folder.type_in("info a.laz --cell 1 --json").done();
    assert!(!kept.warnings().contains(&"W391"), "{}", kept.err);
    assert_eq!(kept.json()["cell_m"], serde_json::json!([1.0, 1.0]));
}

const FOOT: f64 = 1200.0 / 3937.0;

#[test]
fn feet_are_meters_in_the_scene() {
    let folder = Folder::new();
    let meters = city_points();
    // A system in feet of the US whose place is the same city, three cells of a meter to ten feet and less.
    let feet: Vec<Point> = meters
        .iter()
        .map(|p| Point { x: p.x / FOOT - 1e6, y: p.y / FOOT - 1.2e7, z: p.z / FOOT, ..p.clone() })
        .collect();
    let projected = r#"PROJCS["local feet",GEOGCS["NAD83",DATUM["North_American_Datum_1983",SPHEROID["GRS 1980",6378137,298.257222101]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",40],PARAMETER["central_meridian",-80],PARAMETER["scale_factor",1],PARAMETER["false_easting",0],PARAMETER["false_northing",0],UNIT["US survey foot",0.304800609601219]]"#;
    let vertical = r#"VERT_CS["NAVD88 height (ftUS)",VERT_DATUM["North American Vertical Datum 1988",2005],UNIT["US survey foot",0.304800609601219],AXIS["Up",UP]]"#;
    let compound = format!(r#"COMPD_CS["both",{projected},{vertical}]"#);
    let info = |points: &[Point], crs: Option<&str>| {
        fs::write(folder.join("a.laz"), cloud(points, 6, true, crs)).unwrap();
        let answer = folder.type_in("info a.laz --cell 1 --json").done();
        (answer.json(), answer.warnings().iter().map(ToString::to_string).collect::<Vec<_>>())
    };
    let near = |a: &Value, b: &Value, tolerance: f64| {
        let (a, b): (Vec<f64>, Vec<f64>) =
            (serde_json::from_value(a.clone()).unwrap(), serde_json::from_value(b.clone()).unwrap());
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= tolerance), "{a:?} {b:?}");
    };
    let (wanted, _) = info(&meters, None);
    for (crs, code) in [(compound.as_str(), "W332"), (projected, "W332")] {
        let (found, warnings) = info(&feet, Some(crs));
        assert!(warnings.iter().any(|w| w == code) && warnings.iter().any(|w| w == "W343"), "{warnings:?}");
        near(&found["ground_m"], &wanted["ground_m"], 0.03);
        near(&found["surface_m"], &wanted["surface_m"], 0.03);
        near(&found["cell_m"], &wanted["cell_m"], 1e-9);
        near(&found["size_m"], &wanted["size_m"], 2.0);
    }
    // Heights in feet over coordinates in meters, as the files of Oregon are.
    let mixed: Vec<Point> = meters.iter().map(|p| Point { z: p.z / FOOT, ..p.clone() }).collect();
    let utm = r#"PROJCS["ETRS89 / UTM zone 32N",GEOGCS["ETRS89",DATUM["European_Terrestrial_Reference_System_1989",SPHEROID["GRS 1980",6378137,298.257222101]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",9],PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1],AUTHORITY["EPSG","25832"]]"#;
    let (found, warnings) = info(&mixed, Some(&format!(r#"COMPD_CS["both",{utm},{vertical}]"#)));
    assert!(found["crs"] == "EPSG:25832" && warnings.iter().any(|w| w == "W332"), "{found} {warnings:?}");
    near(&found["surface_m"], &wanted["surface_m"], 0.002);
}

#[test]
fn degrees_are_refused_with_the_command_that_helps() {
    let folder = Folder::new();
    let at = |k: u32| point([690_000.0 + f64::from(k) / 1024.0, 5_334_000.0, 1.0], 2);
    let mut bytes = cloud(&[at(0), at(1)], 6, true, Some("EPSG:4326"));
    // Longitudes around 11.5 degrees: the offsets of x and y, and the bounds.
    for (at, value) in [(155, 11.5_f64), (163, 48.1), (179, 11.6), (187, 11.5), (195, 48.2), (203, 48.1)] {
        bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
    }
    fs::write(folder.join("a.laz"), bytes).unwrap();
    folder.refuses("info a.laz", "E310", &["a.laz", "degrees", "pdal translate", "EPSG:32632"]);
    folder.refuses("info a.laz --project auto", "E116", &["project", "point cloud"]);
}

/// The sample of COPC, against its own points in plain LAS, whole and cut by extents.
#[test]
fn copc_gives_the_points_that_it_holds() {
    let Some(data) = truth() else { return };
    let folder = Folder::new();
    fs::copy(data.join("formats/lidar/pdal.copc.laz"), folder.join("a.copc.laz")).unwrap();
    let mut reader = las::Reader::from_path(folder.join("a.copc.laz")).unwrap();
    let points = reader.read_all().unwrap();
    let mut builder = Builder::from((1, 4));
    builder.point_format = *reader.header().point_format();
    builder.point_format.is_compressed = false;
    builder.transforms = *reader.header().transforms();
    builder.has_wkt_crs = true;
    builder.vlrs = reader.header().vlrs().iter().filter(|record| record.is_crs()).cloned().collect();
    let mut writer = Writer::from_path(folder.join("a.las"), builder.into_header().unwrap()).unwrap();
    points.points().for_each(|point| writer.write_point(point.unwrap()).unwrap());
    writer.close().unwrap();
    for options in [
        "--cell 16",
        "--cell 8 --extent 636000,849400,637200,850600",
        "--cell 4 --extent 638000,852000,638400,852600",
        "--cell 10 --extent 635000,848000,639000,854000",
    ] {
        let info = |name: &str| {
            let mut document = folder.type_in(&format!("info {name} {options} --json")).done().json();
            for key in ["sources", "command", "request", "name", "vertical", "warnings"] {
                document.as_object_mut().unwrap().remove(key);
            }
            document
        };
        let (copc, plain) = (info("a.copc.laz"), info("a.las"));
        assert_eq!(copc, plain, "{options}");
        assert!(copc["cells"]["open"].as_u64() > Some(100), "{copc}");
    }
    // Heights are in feet: 407 to 586 of them.
    let surface = folder.type_in("info a.copc.laz --cell 16 --json").done().json()["surface_m"].clone();
    let surface: [f64; 2] = serde_json::from_value(surface).unwrap();
    assert!(surface[0] > 120.0 && surface[1] < 179.0, "{surface:?}");
}

#[test]
fn an_extent_gives_the_part_of_the_whole() {
    let folder = Folder::new();
    fs::write(folder.join("a.laz"), cloud(&city_points(), 6, true, None)).unwrap();
    let whole = read(&folder.join("a.laz"), &PointCloudOptions { cell_m: Some(1.0), ..Default::default() }).0;
    let extent = Some([EAST + 2.0, NORTH + 3.0, EAST + 44.0, NORTH + 40.0]);
    let options = PointCloudOptions { cell_m: Some(1.0), extent, ..Default::default() };
    let (part, codes) = read(&folder.join("a.laz"), &options);
    let (whole, part) = (heights(&whole), heights(&part));
    for (whole, part) in [(whole.0, part.0), (whole.1, part.1)] {
        let cut: Vec<i32> = (8..45).flat_map(|row| whole[row * EDGE + 2..row * EDGE + 44].to_vec()).collect();
        assert_eq!(cut, part);
    }
    assert!(!codes.contains(&"W392".to_string()), "{codes:?}");
    folder.refuses("info a.laz --extent 0,0,50,50", "E308", &["extent"]);
}
