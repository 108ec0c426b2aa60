//! XYZ grids. Each gives the maps of the same raster as an ASCII grid; what is no grid is refused with its line.

use std::fs::{self, File};
use std::io::Write;
use std::process::Command;

use crate::needs::{has_program, truth};
use crate::program::Folder;

const N_ROWS: usize = 40;
const N_COLS: usize = 60;

/// Height of a cell from the north-west; `None` in the holes.
fn height(row: usize, col: usize) -> Option<f64> {
    let is_hole = (30..34).contains(&row) && (5..9).contains(&col) || (row < 6 && col >= 50);
    let top = match (row, col) {
        (8..18, 10..22) => 512.25,
        (20..26, 35..50) => 507.5,
        _ => 500.0,
    };
    (!is_hole).then_some(top)
}

/// An ASCII grid of some rows and columns, its cells `cell` m wide.
fn asc(cell: f64) -> String {
    let mut text = format!("ncols {N_COLS}\nnrows {N_ROWS}\nxllcorner 691000\nyllcorner 5334000\ncellsize {cell}\n");
    for row in 0..N_ROWS {
        let words: Vec<String> = (0..N_COLS).map(|col| height(row, col).unwrap_or(-9999.0).to_string()).collect();
        text += &format!("{}\n", words.join(" "));
    }
    text
}

/// A line of the cell, `None` in the holes.
fn line(cell: f64, (row, col): (usize, usize), separator: &str) -> Option<String> {
    let (x, y) = (691_000.0 + (col as f64 + 0.5) * cell, 5_334_000.0 + ((N_ROWS - row) as f64 - 0.5) * cell);
    Some(format!("{x}{separator}{y}{separator}{}\n", height(row, col)?))
}

fn cells() -> impl Iterator<Item = (usize, usize)> {
    (0..N_ROWS).flat_map(|row| (0..N_COLS).map(move |col| (row, col)))
}

fn xyz(cell: f64, cells: impl Iterator<Item = (usize, usize)>, separator: &str) -> String {
    cells.filter_map(|at| line(cell, at, separator)).collect()
}

/// All cells, 1 m wide.
pub(crate) fn grid(separator: &str) -> String {
    xyz(1.0, cells(), separator)
}

fn gzip(folder: &Folder, name: &str, text: &str) {
    let mut packed = flate2::write::GzEncoder::new(File::create(folder.join(name)).unwrap(), Default::default());
    packed.write_all(text.as_bytes()).unwrap();
    packed.finish().unwrap();
}

fn digests(folder: &Folder, scene: &str) -> Vec<String> {
    let digest = |uav: &&str| {
        let document = folder.type_in(&format!("map {scene} --uav {uav} --json")).done().json();
        document["digest"].as_str().unwrap_or_else(|| panic!("{document}")).to_string()
    };
    ["691015.3,5334012.2,9", "691040,5334030,4", "691008,5334037,30"].iter().map(digest).collect()
}

#[test]
fn lines_in_any_order_are_the_map_of_the_grid() {
    let folder = Folder::new();
    folder.write("grid.asc", &asc(1.0));
    let wanted = digests(&folder, "grid.asc --ground 500");
    assert!(wanted[0] != wanted[1] && wanted[1] != wanted[2]);
    let mut columns: Vec<(usize, usize)> = cells().collect();
    columns.sort_by_key(|(row, col)| (*col, *row));
    let from_south = (0..N_ROWS).rev().flat_map(|row| (0..N_COLS).map(move |col| (row, col)));
    folder.write("rows.xyz", &grid(" "));
    folder.write("south.xyz", &xyz(1.0, from_south, "\t"));
    folder.write("columns.txt", &format!("X;Y;Z\r\n{}", xyz(1.0, columns.iter().copied(), ";").replace('\n', "\r\n")));
    folder.write("commas", &format!("# a survey\n\n{}\n", xyz(1.0, columns.iter().rev().copied(), ", ")));
    let twice = xyz(1.0, cells().chain([(0, 0), (9, 11)]), " ");
    folder.write("twice.xyz", &twice);
    gzip(&folder, "packed.xyz.gz", &grid(" "));
    let mut zip = zip::ZipWriter::new(File::create(folder.join("packed.zip")).unwrap());
    zip.start_file("dem/part.xyz", zip::write::SimpleFileOptions::default()).unwrap();
    zip.write_all(twice.as_bytes()).unwrap();
    zip.start_file("dem/readme.txt", zip::write::SimpleFileOptions::default()).unwrap();
    zip.write_all(b"a survey of 2026").unwrap();
    zip.finish().unwrap();
    for name in ["rows.xyz", "south.xyz", "columns.txt", "commas", "twice.xyz", "packed.xyz.gz", "packed.zip"] {
        assert_eq!(digests(&folder, &format!("{name} --ground 500")), wanted, "{name}");
    }
    // A part of a file, and a terrain below the same surface.
    let part = |name: &str| digests(&folder, &format!("{name} --ground 500 --radius 9"));
    assert_eq!(part("rows.xyz"), part("grid.asc"));
    assert_eq!(part("columns.txt"), part("grid.asc"));
    let over = |name: &str, terrain: &str| digests(&folder, &format!("{name} --terrain {terrain}"));
    assert_eq!(over("rows.xyz", "packed.xyz.gz"), over("grid.asc", "grid.asc"));
}

#[test]
fn tiles_are_one_grid() {
    let folder = Folder::new();
    folder.write("grid.asc", &asc(0.5));
    let mut zip = zip::ZipWriter::new(File::create(folder.join("tiles.zip")).unwrap());
    for name in ["tiles", "packed"] {
        fs::create_dir(folder.join(name)).unwrap();
    }
    for tile in 0..4 {
        let is_in = |(row, col): &(usize, usize)| (2 * row / N_ROWS, 2 * col / N_COLS) == (tile / 2, tile % 2);
        let text = xyz(0.5, cells().filter(is_in), " ");
        let name = format!("t{tile}.{}", if tile == 1 { "txt" } else { "xyz" });
        folder.write(&format!("tiles/{name}"), &text);
        gzip(&folder, &format!("packed/{name}.gz"), &text);
        zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap();
    folder.write("tiles/readme.txt", "4 tiles of a survey");
    let digests = |scene: &str| {
        let digest = |uav: &str| {
            let document = folder.type_in(&format!("map {scene} --ground 500 --uav {uav} --json")).done().json();
            document["digest"].as_str().unwrap().to_string()
        };
        ["691007.3,5334006.2,9", "691020,5334015,4"].map(digest)
    };
    let wanted = digests("grid.asc");
    for scene in ["tiles", "packed", "tiles.zip"] {
        assert_eq!(digests(scene), wanted, "{scene}");
    }
}

#[test]
fn gdal_writes_the_same_grid() {
    if !has_program("gdal_translate") {
        return;
    }
    let folder = Folder::new();
    folder.write("grid.asc", &asc(1.0));
    for options in ["", "-co COLUMN_SEPARATOR=, -co ADD_HEADER_LINE=YES"] {
        let words = format!("-q -of XYZ {options} grid.asc gdal.xyz");
        let made = Command::new("gdal_translate").args(words.split_whitespace()).current_dir(folder.path()).output();
        assert!(made.unwrap().status.success());
        assert_eq!(digests(&folder, "gdal.xyz --ground 500"), digests(&folder, "grid.asc --ground 500"), "{options}");
    }
}

#[test]
fn the_reference_system_is_beside_the_file() {
    let folder = Folder::new();
    folder.write("grid.xyz", &grid(" "));
    gzip(&folder, "packed.xyz.gz", &grid(" "));
    for name in ["grid.prj", "packed.prj"] {
        folder.write(name, crate::vector_files::UTM32);
    }
    for scene in ["grid.xyz", "packed.xyz.gz"] {
        let document = folder.type_in(&format!("info {scene} --json")).done().json();
        assert!(document["crs"].to_string().contains("25832"), "{document}");
        let without = folder.type_in(&format!("info {scene} --crs EPSG:25833 --json")).done().json();
        assert!(without["crs"].to_string().contains("25833"), "{without}");
    }
}

#[test]
fn what_is_no_grid_is_refused_with_its_line() {
    let folder = Folder::new();
    let grid = grid(" ");
    let refuses = |text: &str, code: &str, words: &[&str]| {
        folder.write("bad.xyz", text);
        folder.refuses("info bad.xyz", code, words);
    };
    refuses("691000,5;5334000,5;500,1\n691001,5;5334000,5;500,1\n", "E302", &["line 1", "decimal commas"]);
    refuses("1 2 3\n2 2 3\n3 2 3 4\n", "E302", &["line 3", "`3 2 3 4`", "x, y and z"]);
    refuses("1 2 3\n2 2 3\n3 2 high\n", "E302", &["line 3"]);
    refuses("1 2 3\n2 2 3\nnan 2 3\n", "E302", &["line 3"]);
    refuses("1 2 3\n2 2 3\n3 inf 3\n", "E302", &["line 3"]);
    refuses(&format!("1 2 3\n{}", "9".repeat(5000)), "E302", &["line 2", "1024 bytes"]);
    refuses("x y z\n", "E303", &["no point"]);
    refuses("1 2 3\n", "E307", &["line 1", "all its points lie at 1, 2"]);
    // Far points, scattered ones, and one between the others.
    refuses(&format!("{grid}1e300 5334000.5 3\n"), "E307", &["regular grid", "LAS"]);
    refuses("0 0 3\n1 0 3\n1e6 1e6 3\n", "E307", &["line 2", "1000001 columns x 2 rows"]);
    let scattered: String =
        (0..500).map(f64::from).map(|k| format!("{} {} 3\n", k.sin() * 1e3, k.cos() * 1e3)).collect();
    refuses(&scattered, "E307", &["line", "regular grid"]);
    refuses(&format!("{grid}691004.9 5334001.5 3\n"), "E307", &["line 2325", "on no lattice", "LAS"]);
    // Two heights of one cell.
    refuses(&format!("{grid}691004.5 5334001.5 3\n"), "E302", &["line 2325", "height 3", "500"]);
    refuses("1 2 -9999\n2 2 -9999\n1 3 -9999\n", "E305", &["none of the 4 cells"]);
}

#[test]
fn a_sample_of_a_survey_is_a_scene() {
    let Some(data) = truth() else { return };
    let folder = Folder::new();
    fs::copy(data.join("formats/meaning/small.xyz"), folder.join("small.xyz")).unwrap();
    let made = "map small.xyz --ground 0 --uav 690876,5335301,60 -o small.json";
    folder.type_in(made).done();
    let document = folder.type_in("info small.xyz --json").done().json();
    assert_eq!(document["extent"].to_string(), "[690816.0,5335241.0,690936.0,5335361.0]", "{document}");
}
