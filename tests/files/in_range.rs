//! Maps of rasters with a radius: they are of the box around what is in range, and what they say of it is what the map of all
//! says.

use skyshed::prelude::*;
use skyshed_core::raster::GeoRef;
use skyshed_io::formats::{Bands, GeoTiff, GeoTiffImage, encode_geotiff};
use skyshed_request::TiffLayout;

use crate::program::Folder;
use crate::support::class_of;

const N_ROWS: usize = 260;
const N_COLS: usize = 340;

/// Writes a surface with houses, slopes and holes, and the terrain below it.
fn write_rasters(folder: &Folder) {
    let ground = |row: usize, col: usize| (row as f32 / 20.0).sin() * 4.0 + col as f32 / 40.0;
    let surface = |row: usize, col: usize| match (row / 12 * 5 + col / 15 * 3) % 7 {
        _ if row % 40 < 3 && col % 50 < 9 => -9999.0,
        0 | 1 => ground(row, col) + 12.0,
        _ => ground(row, col),
    };
    let georef = &GeoRef::new((1000.0, 5000.0), (2.0, 2.0), (N_ROWS, N_COLS), None).expect("a grid");
    let write = |name: &str, value: &dyn Fn(usize, usize) -> f32| {
        let cells: Vec<f32> = (0..N_ROWS * N_COLS).map(|k| value(k / N_COLS, k % N_COLS)).collect();
        let bands = Bands::Float(vec![("height".into(), &cells)]);
        let (nodata, layout) = (Some(-9999.0), TiffLayout::Cog);
        let image = GeoTiffImage { georef, bands, nodata, palette: None, metadata: &[], layout };
        std::fs::write(folder.join(name), encode_geotiff(&image).expect("a file")).expect("a folder for tests");
        let text: String =
            cells.chunks(N_COLS).flat_map(|row| row.iter().map(|h| format!("{h} ")).chain(["\n".into()])).collect();
        let head = format!("ncols {N_COLS}\nnrows {N_ROWS}\nxllcorner 1000\nyllcorner 4480\ncellsize 2\n");
        folder.write(&name.replace(".tif", ".asc"), &format!("{head}NODATA_value -9999\n{text}"));
    };
    write("dsm.tif", &surface);
    write("dtm.tif", &ground);
}

/// The classes of a mask, and where its cells lie.
fn mask_of(folder: &Folder, name: &str) -> (Vec<u8>, GeoRef) {
    let file = GeoTiff::open(folder.join(name), &mut Vec::new()).expect("a GeoTIFF");
    let raster = file.read(file.georef().window(), &mut Vec::new(), class_of).expect("its cells");
    (raster.cells().to_vec(), raster.georef().clone())
}

#[test]
fn a_map_with_a_radius_is_of_what_is_in_range() {
    let folder = Folder::new();
    write_rasters(&folder);
    // The last one is at a corner, so that its range is cut.
    for (uavs, radius) in [
        (&[(1301.0, 4701.0)][..], 75.0),
        (&[(1201.5, 4640.0), (1360.0, 4820.0)], 60.0),
        (&[(1010.0, 4990.0)], 130.0),
        (&[(1301.0, 4701.0)], 2000.0),
    ] {
        for rest in ["", "--terrain dtm.tif", "--ground 0 --receivers all"] {
            let at: String = uavs.iter().map(|(x, y)| format!("--uav {x},{y},40 ")).collect();
            let layers = if uavs.len() == 1 { "los" } else { "count" };
            let line = format!("map dsm.tif {rest} {at} --overwrite -q");
            let whole = folder.type_in(&format!("{line} -o whole.tif --layers {layers} --json")).done().json();
            let part =
                folder.type_in(&format!("{line} --radius {radius} -o part.tif --layers {layers} --json")).done().json();
            let ((all, all_on), (found, on)) = (mask_of(&folder, "whole.tif"), mask_of(&folder, "part.tif"));
            let mut n_in_range = 0;
            for (cell, class) in found.iter().enumerate() {
                let (x, y) = on.world_from_cell(cell / on.n_cols(), cell % on.n_cols());
                let (row, col) = all_on.cell_at(x, y).expect("a cell of the raster");
                let of_all = all[row * all_on.n_cols() + col];
                let is_in_range = |(ux, uy): &(f64, f64)| (x - ux).hypot(y - uy) <= radius;
                if uavs.len() == 1 {
                    let wanted = if is_in_range(&uavs[0]) || of_all == 255 { of_all } else { 3 };
                    assert_eq!(*class, wanted, "{line}: at ({x}, {y})");
                }
                n_in_range += usize::from(uavs.iter().any(is_in_range));
            }
            // All that is in range is in it, and little more than the box around it.
            let of_raster = (0..all.len()).map(|cell| all_on.world_from_cell(cell / N_COLS, cell % N_COLS));
            let near = |(x, y): (f64, f64)| uavs.iter().any(|(ux, uy)| (x - ux).hypot(y - uy) <= radius);
            assert_eq!(n_in_range, of_raster.filter(|place| near(*place)).count(), "{line}");
            let side = if uavs.len() == 1 { 2.0 * radius / 2.0 + 4.0 } else { 400.0 };
            assert!(on.n_cols() as f64 <= side.min(N_COLS as f64) && on.n_rows() as f64 <= side.min(N_ROWS as f64));
            let receivers = |document: &serde_json::Value| document["union"]["receivers"].as_u64();
            assert!(receivers(&part) <= receivers(&whole) && part["scene"]["cols"] == on.n_cols());

            // The same from a file that cannot be read in parts, from a copy on disk, and from a scene in memory.
            let of_text = folder.type_in(&format!("{line} --radius {radius} --json").replace(".tif", ".asc")).done();
            assert_eq!(of_text.json()["digest"], part["digest"], "{line}");
            if uavs.len() == 1 {
                let strips = folder.type_in(&format!("{line} --radius {radius} --strips --json")).done().json();
                assert_eq!(strips["digest"], part["digest"], "{line}");
            }
            let options = match rest {
                "--terrain dtm.tif" => Scene::options().terrain(folder.join("dtm.tif")),
                "" => Scene::options(),
                _ => continue,
            };
            let scene = options.open(folder.join("dsm.tif")).expect("a scene");
            let places = uavs.iter().map(|(x, y)| Uav::new(*x, *y, Height::agl(40.0)));
            let seen = scene.coverages(places).radius(radius).run().expect("a map");
            assert_eq!(part["digest"], seen.digest(), "{line}");
            assert_eq!(seen.grid(), &on);
        }
    }
}

#[test]
fn zones_are_those_of_the_whole_raster_whatever_the_radius() {
    let folder = Folder::new();
    write_rasters(&folder);
    let line = "map dsm.tif --terrain dtm.tif --uav 1301,4701,40";
    let all = folder.type_in(&format!("{line} --zones --json -q")).done().json();
    let near = folder.type_in(&format!("{line} --radius 75 --zones --json -q")).done().json();
    assert_eq!((&near["scene"], &near["sites"][0]["placement"]), (&all["scene"], &all["sites"][0]["placement"]));
    let street = |document: &serde_json::Value| document["sites"][0]["zones"]["street"]["receivers"].as_u64();
    assert!(street(&near).is_some_and(|n| n > 0) && street(&near) < street(&all));
}

#[test]
fn footprints_beyond_reach_of_an_extent_are_not_built_and_hide_nothing() {
    let folder = Folder::new();
    folder.type_in("city itu:highrise --size 900 --seed 4 -o city.geojson -q").done();
    folder.write("uavs.csv", "id,x,y,h\n1,455,432,70\n");
    let line = "map city.geojson --extent 380,350,520,470 --cell 1 --json -q";
    for radius in [40.0, 90.0, 3000.0] {
        // Of a table it is not known beforehand where its UAVs are.
        let all = folder.type_in(&format!("{line} --uavs uavs.csv --radius {radius}")).done().json();
        let near = folder.type_in(&format!("{line} --uav 455,432,70 --radius {radius}")).done().json();
        assert_eq!((&near["digest"], &near["union"]), (&all["digest"], &all["union"]), "{radius} m");
        let n_built = |document: &serde_json::Value| document["footprints"]["total"].as_u64();
        assert!(n_built(&near) < n_built(&all), "{radius} m");
    }
}
