//! Damaged vector files: whatever is cut off or turned over, a scene or an error, soon and without a panic.

use std::path::{Path, PathBuf};

use parquet::basic::Compression;
use skyshed_core::ErrorKind;
use skyshed_core::city::City;
use skyshed_core::height_field::HeightField;
use skyshed_io::Warning;
use skyshed_io::read::{FootprintOptions, MeshOptions, read_footprints, read_mesh};

use crate::city_formats::{citygml, write_geoparquet};
use crate::program::Folder;
use crate::solid_writers;
use crate::support::{Random, is_long};
use crate::vector_files::{
    EAST, NORTH, city, write_cityjson, write_flatgeobuf, write_geojson, write_geopackage, write_obj, write_ply,
    write_shapefile,
};

/// A valid file of each format.
fn files(folder: &Folder) -> Vec<PathBuf> {
    let city = city();
    write_geojson(&folder.join("a.geojson"), &city);
    write_shapefile(&folder.join("b.shp"), &city);
    write_flatgeobuf(&folder.join("c.fgb"), &city, true);
    write_flatgeobuf(&folder.join("d.fgb"), &city, false);
    write_geopackage(&folder.join("e.gpkg"), &[("buildings", &city)]);
    write_cityjson(&folder.join("f.city.json"), &city, "2.0");
    folder.write("j.gml", &citygml(&city, 2));
    write_geoparquet(&folder.join("k.parquet"), &city, Compression::SNAPPY, 2);
    write_obj(&folder.join("g.obj"));
    write_ply(&folder.join("h.ply"), "ascii");
    write_ply(&folder.join("i.ply"), "binary_little_endian");
    let solids = solid_writers::solids();
    solid_writers::write_multipatches(&folder.join("n.shp"), &solids);
    solid_writers::write_polygons(&folder.join("o.shp"), &solids);
    solid_writers::write_flatgeobuf(&folder.join("l.fgb"), &solids);
    solid_writers::write_geopackage(&folder.join("m.gpkg"), &solids, 1015);
    let damaged = "a.geojson b.shp b.shx b.dbf b.prj c.fgb d.fgb e.gpkg f.city.json g.obj h.ply i.ply n.shp n.shx o.shp \
                   l.fgb m.gpkg j.gml k.parquet";
    damaged.split(' ').map(|name| folder.join(name)).collect()
}

/// The file that is opened to read `damaged`: of a shapefile always the `.shp`.
fn opened(damaged: &Path) -> PathBuf {
    let is_beside = damaged.extension().is_some_and(|e| ["shx", "dbf", "prj"].iter().any(|s| e == *s));
    if is_beside { damaged.with_extension("shp") } else { damaged.to_path_buf() }
}

fn read(path: &Path, warnings: &mut Vec<Warning>) -> skyshed_core::Result<City> {
    let is_mesh = path.extension().is_some_and(|e| e == "obj" || e == "ply");
    if is_mesh {
        Ok(read_mesh(path, &MeshOptions { extent: Some([0.0, 0.0, 20.0, 10.0]), ..MeshOptions::default() }, warnings)?)
    } else {
        let extent = Some([EAST, NORTH, EAST + 80.0, NORTH + 80.0]);
        Ok(read_footprints(path, &FootprintOptions { extent, ..FootprintOptions::default() }, warnings)?)
    }
}

/// Processor time of this thread so far \[s\], on which other work of the machine does not count; 0 where the system does not say.
fn cpu_of_thread() -> f64 {
    #[cfg(target_os = "linux")]
    {
        use nix::sys::resource::{UsageWho, getrusage};
        use nix::sys::time::TimeValLike;
        let usage = getrusage(UsageWho::RUSAGE_THREAD).expect("what this thread took");
        (usage.user_time() + usage.system_time()).num_microseconds() as f64 * 1e-6
    }
    #[cfg(not(target_os = "linux"))]
    0.0
}

/// Reads and builds whatever is left of a file; `true` if it is still a scene.
fn survives(damaged: &Path, how: &str) -> bool {
    let before = cpu_of_thread();
    let is_scene = match read(&opened(damaged), &mut Vec::new()) {
        Ok(scene) => {
            HeightField::build(&scene.grid, scene.solids);
            true
        }
        // A height or a number of cells may become too large; nothing else is the user's fault.
        Err(e) => {
            let class = e.kind();
            assert!([ErrorKind::File, ErrorKind::Site, ErrorKind::Limit].contains(&class), "{how}: {e}");
            assert!(!e.to_string().is_empty());
            false
        }
    };
    let spent = cpu_of_thread() - before;
    assert!(spent < 5.0, "{how}: {spent} s");
    is_scene
}

#[test]
fn files_that_are_cut_off_are_scenes_or_errors() {
    let folder = Folder::new();
    for path in files(&folder) {
        let whole = std::fs::read(&path).unwrap();
        assert!(survives(&path, "whole"), "{}: {:?}", path.display(), read(&opened(&path), &mut Vec::new()).err());
        let mut n_refused = 0;
        let step = if is_long() { 1 } else { 100 };
        for n in (0..whole.len()).step_by(step) {
            std::fs::write(&path, &whole[..n]).unwrap();
            n_refused += usize::from(!survives(&path, &format!("{} cut at {n}", path.display())));
        }
        // Text of a mesh may end anywhere between lines, and a missing projection is none.
        let may_end = path.extension().is_some_and(|e| e == "obj" || e == "prj");
        assert!(may_end || 10 * n_refused * step >= 9 * whole.len(), "{}", path.display());
        std::fs::write(&path, whole).unwrap();
    }
}

#[test]
fn files_with_bytes_turned_over_are_scenes_or_errors() {
    let folder = Folder::new();
    let mut random = Random(11);
    for path in files(&folder) {
        let whole = std::fs::read(&path).unwrap();
        let mut n_scenes = 0;
        for n in 0..if is_long() { 20_000 } else { 60 } {
            let mut bytes = whole.clone();
            for _ in 0..random.within(1, 4) {
                let at = random.below(bytes.len());
                bytes[at] = random.choose(&[0, 1, 0x7f, 0x80, 0xff, bytes[at] ^ 1, bytes[at] ^ 0x10, bytes[at] ^ 0x80]);
            }
            std::fs::write(&path, &bytes).unwrap();
            n_scenes += usize::from(survives(&path, &format!("{} turned over, {n}", path.display())));
        }
        assert!(n_scenes > 0, "{}: nothing survived, so nothing was read far", path.display());
        std::fs::write(&path, whole).unwrap();
    }
}

#[test]
fn counts_that_lie_take_no_memory() {
    // The program may use 1 GB; each of these announces more.
    let folder = Folder::new();
    let city = city();
    let patch = |name: &str, at: usize, bytes: &[u8]| {
        let mut file = folder.read(name);
        file[at..at + bytes.len()].copy_from_slice(bytes);
        std::fs::write(folder.join(name), file).unwrap();
    };
    // Number of points of the first shape, rows of the table, bytes of the header.
    write_shapefile(&folder.join("points.shp"), &city);
    patch("points.shp", 108 + 40, &i32::MAX.to_le_bytes());
    write_shapefile(&folder.join("rows.shp"), &city);
    patch("rows.dbf", 4, &u32::MAX.to_le_bytes());
    write_flatgeobuf(&folder.join("header.fgb"), &city, true);
    patch("header.fgb", 8, &u32::MAX.to_le_bytes());
    folder
        .write("vertices.ply", "ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nend_header\n1\n");
    folder.write("nothing.ply", "ply\nformat ascii 1.0\nelement junk 99999999999\nend_header\n");
    folder.write("deep.geojson", &"[".repeat(200_000));
    folder.write("deep.city.json", &format!(r#"{{"type": "CityJSON", "vertices": {}"#, "[".repeat(200_000)));
    let files = "points.shp rows.shp header.fgb vertices.ply nothing.ply deep.geojson deep.city.json";
    for file in files.split(' ') {
        assert!(folder.type_in(&format!("info {file}")).error().starts_with("E3"), "{file}");
    }
}

/// Found by fuzzing: the names of columns were asked of a statement, which panics where one is no UTF-8.
#[test]
fn a_column_whose_name_is_no_text_is_no_panic() {
    let folder = Folder::new();
    let path = folder.join("e.gpkg");
    write_geopackage(&path, &[("buildings", &city())]);
    let mut bytes = std::fs::read(&path).unwrap();
    let name = b"height";
    let places: Vec<usize> = (0..bytes.len() - name.len()).filter(|at| bytes[*at..].starts_with(name)).collect();
    assert!(!places.is_empty());
    for at in places {
        bytes[at + 3..at + 5].copy_from_slice(b"\xff\xe1");
    }
    std::fs::write(&path, bytes).unwrap();
    let mut warnings = Vec::new();
    // The heights are lost with the name of their column; nothing else is.
    let scene = read(&path, &mut warnings);
    assert!(scene.is_err() || warnings.iter().any(|w| w.code() == "W354"), "{warnings:?}");
}

/// A file without its last byte was read where the extent left the last feature out.
#[test]
fn a_flatgeobuf_without_its_last_byte_is_refused() {
    let folder = Folder::new();
    for has_index in [true, false] {
        write_flatgeobuf(&folder.join("whole.fgb"), &city(), has_index);
        let bytes = folder.read("whole.fgb");
        std::fs::write(folder.join("cut.fgb"), &bytes[..bytes.len() - 1]).unwrap();
        let box_of = |west: f64| format!("{west},{NORTH},{},{}", west + 10.0, NORTH + 10.0);
        for words in [String::new(), format!("--extent {}", box_of(EAST)), format!("--extent {}", box_of(EAST + 1e4))] {
            let seen = folder.type_in(&format!("info whole.fgb {words}"));
            assert_eq!(seen.code(), 0, "{words}: {seen:?}");
            folder.refuses(&format!("info cut.fgb {words}"), "E303", &["cut short"]);
        }
    }
}

/// Some writers end the properties of a feature with a byte more; GDAL passes over it (gdal#1742).
#[test]
fn a_flatgeobuf_whose_properties_end_with_a_byte_alone_is_read() {
    let Some(shared) = crate::needs::truth() else { return };
    let path = shared.join("cases/16-flatgeobuf/alldatatypes.fgb");
    let options = FootprintOptions { extent: Some([0.0, 0.0, 10.0, 10.0]), ..FootprintOptions::default() };
    let city = read_footprints(&path, &options, &mut Vec::new());
    // It holds a point, and no property of heights.
    assert!(city.is_ok() || city.is_err_and(|error| error.code() == "E365"));
}
