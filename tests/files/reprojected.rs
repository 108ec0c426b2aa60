//! Rasters brought into another reference system: each cell is that of the file under its center, by hand and as gdalwarp
//! finds it.

use skyshed_core::Result;
use skyshed_core::city::{City, Ground, Solids};
use skyshed_core::quantity::{VOID, height_steps, meters};
use skyshed_core::raster::{Crs, GeoRef, Raster};
use skyshed_io::Warning;
use skyshed_io::crs;
use skyshed_io::crs::Transformation;
use skyshed_io::formats::{Bands, GeoTiffImage, RasterFile, encode_geotiff};
use skyshed_io::read::{Projection, SurfaceOptions, read_surface};
use skyshed_request::TiffLayout;

use crate::formats_write::image_of;
use crate::mosaic::gdal;
use crate::needs::has_program;
use crate::program::Folder;

fn epsg(code: u32) -> Crs {
    crs::from_epsg(code).unwrap()
}

/// The way from a grid's system to degrees.
fn to_degrees(grid: &GeoRef) -> Transformation {
    Transformation::new(grid.crs().unwrap(), &epsg(4326), grid.world_from_cell(0, 0)).unwrap()
}

/// A raster in degrees over Munich: 80 × 60 cells of about 2.2 m × 3.3 m, each with a height of its own.
fn degrees() -> (GeoRef, Vec<f32>) {
    let georef = GeoRef::new((11.57, 48.14), (0.000_03, 0.000_03), (60, 80), Some(epsg(4326))).unwrap();
    let heights = (0_u16..4800).map(|cell| if cell == 4321 { -9999.0 } else { f32::from(cell) / 4.0 }).collect();
    (georef, heights)
}

fn write(folder: &Folder, name: &str, georef: &GeoRef, heights: &[f32]) {
    let bands = Bands::Float(vec![("height".into(), heights)]);
    let image = GeoTiffImage { nodata: Some(-9999.0), layout: TiffLayout::Plain, ..image_of(georef, bands) };
    std::fs::write(folder.join(name), encode_geotiff(&image).unwrap()).unwrap();
}

fn projected(folder: &Folder, name: &str, options: SurfaceOptions) -> Result<(City, Vec<Warning>)> {
    let mut warnings = Vec::new();
    let options = SurfaceOptions { project: Some(Projection::Auto), ..options };
    Ok(read_surface(folder.join(name), &options, &mut warnings).map(|scene| (scene, warnings))?)
}

fn surface(scene: &City) -> (&Raster<i32>, &Ground) {
    let Solids::Raster { surface, ground, .. } = &scene.solids else { panic!("footprints") };
    (surface, ground)
}

/// Column and row of a position in a grid in cells, from the north-west.
fn cells(grid: &GeoRef, (x, y): (f64, f64)) -> (f64, f64) {
    ((x - grid.x_min()) / grid.cell_width(), (grid.y_max() - y) / grid.cell_height())
}

#[test]
fn each_cell_takes_the_height_under_its_center() {
    let folder = Folder::new();
    let (georef, heights) = degrees();
    write(&folder, "degrees.tif", &georef, &heights);
    for cell_m in [None, Some(1.0), Some(7.5)] {
        let (scene, warnings) =
            projected(&folder, "degrees.tif", SurfaceOptions { cell_m, ..SurfaceOptions::default() }).unwrap();
        let (surface, _) = surface(&scene);
        let grid = surface.georef();
        assert_eq!(grid.crs().and_then(Crs::epsg), Some(32632));
        match cell_m {
            // 80 × 2.233 m by 60 × 3.335 m: a diagonal of 268.4 m over 100 cells, and somewhat more as it is turned by 1.9°.
            None => assert!((2.68..2.8).contains(&grid.cell_width()), "{}", grid.description()),
            Some(cell) => {
                assert_eq!(grid.cell_width().to_bits(), cell.to_bits());
                assert_eq!((grid.x_min() / cell).fract().to_bits(), 0.0_f64.to_bits());
            }
        }
        assert_eq!(grid.cell_width().to_bits(), grid.cell_height().to_bits());
        let way = to_degrees(grid);
        let (mut n_outside, mut n_void) = (0_u64, 0_u64);
        for row in 0..grid.n_rows() {
            for col in 0..grid.n_cols() {
                let (east, south) = cells(&georef, way.apply(grid.world_from_cell(row, col)).unwrap());
                let is_inside = (0.0..80.0).contains(&east) && (0.0..60.0).contains(&south);
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside")]
                let wanted = if is_inside { heights[south as usize * 80 + east as usize] } else { -9999.0 };
                n_outside += u64::from(!is_inside);
                let found = surface.row(row)[col];
                if wanted < 0.0 {
                    assert_eq!(found, VOID, "row {row}, column {col}");
                    n_void += 1;
                } else {
                    assert_eq!(meters(found).to_bits(), f64::from(wanted).to_bits(), "row {row}, column {col}");
                }
            }
        }
        let told = |code: &str| warnings.iter().find(|w| w.code() == code).map(Warning::to_string).unwrap_or_default();
        let text = told("W339");
        // Half the diagonal of 2.233 m × 3.335 m.
        for part in ["from EPSG:4326 to EPSG:32632", "2.01 m away", &format!("{n_outside} cells lie outside")] {
            assert!(text.contains(part), "{text}, wanted {part}");
        }
        assert!(told("W340").contains(&format!("{n_void} cells without a height")), "{warnings:?}");
    }
}

#[test]
fn gdalwarp_finds_the_same_cells() {
    if !has_program("gdalwarp") {
        return;
    }
    let folder = Folder::new();
    let (georef, heights) = degrees();
    write(&folder, "degrees.tif", &georef, &heights);
    let (scene, _) = projected(&folder, "degrees.tif", SurfaceOptions::default()).unwrap();
    let (surface, _) = surface(&scene);
    let grid = surface.georef();
    let extent = [grid.x_min(), grid.y_min(), grid.x_max(), grid.y_max()].map(|v| format!("{v:.9}"));
    let shape = [grid.n_cols(), grid.n_rows()].map(|n| n.to_string());
    let (extent, shape) = (extent.join(" "), shape.join(" "));
    let line = format!("gdalwarp -q -t_srs EPSG:32632 -r near -et 0 -te {extent} -ts {shape} degrees.tif warped.tif");
    gdal(&folder, &line);
    let file = RasterFile::open(folder.join("warped.tif"), &mut Vec::new()).unwrap();
    assert_eq!((file.georef().n_rows(), file.georef().n_cols()), (grid.n_rows(), grid.n_cols()));
    let warped = file.read(file.georef().window(), &mut Vec::new(), |v| v).unwrap();
    let way = to_degrees(grid);
    let (mut n_differing, mut n_near_edges) = (0, 0);
    for (cell, (found, of_gdal)) in surface.cells().iter().zip(warped.cells()).enumerate() {
        let center = way.apply(grid.world_from_cell(cell / grid.n_cols(), cell % grid.n_cols())).unwrap();
        let (east, south) = cells(&georef, center);
        let is_near_an_edge = [east, south].iter().any(|at| (at - at.round()).abs() < 1e-3);
        n_near_edges += usize::from(is_near_an_edge);
        let is_equal = if *found == VOID { of_gdal.is_nan() } else { meters(*found).to_bits() == of_gdal.to_bits() };
        n_differing += usize::from(!is_equal);
        assert!(is_equal || is_near_an_edge, "cell {cell}: {found} and {of_gdal} at {east}, {south}");
    }
    // 4 of 1000 centers lie that near to an edge.
    assert!(n_near_edges < surface.cells().len() / 100, "{n_near_edges}");
    assert!(n_differing <= 2, "{n_differing} of {} cells, {n_near_edges} near edges", surface.cells().len());
    // A map of the one is a map of the other.
    if n_differing == 0 {
        let map = |line: &str| {
            let line = format!("map {line} --uav 691280.3,5334950.7,1400amsl --json");
            folder.type_in(&line).done().json()["digest"].clone()
        };
        assert_eq!(map("degrees.tif --project auto"), map("warped.tif"));
    }
}

#[test]
fn a_terrain_in_degrees_is_looked_up_below_each_cell() {
    let folder = Folder::new();
    let (georef, heights) = degrees();
    write(&folder, "ground.tif", &georef, &heights);
    // A surface in UTM inside of it, and one in degrees on another grid.
    let grid = GeoRef::new((691_230.0, 5_335_000.0), (2.0, 2.0), (40, 50), Some(epsg(32632))).unwrap();
    write(&folder, "utm.tif", &grid, &[1500.0; 2000]);
    let options = SurfaceOptions { terrain: Some(folder.join("ground.tif").into()), ..SurfaceOptions::default() };
    let (scene, warnings) = projected(&folder, "utm.tif", options.clone()).unwrap();
    let Ground::Terrain(terrain) = surface(&scene).1 else { panic!("no terrain") };
    assert_eq!(terrain.georef(), &grid);
    let way = to_degrees(&grid);
    for (cell, found) in terrain.cells().iter().enumerate() {
        let (east, south) = cells(&georef, way.apply(grid.world_from_cell(cell / 50, cell % 50)).unwrap());
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside by the choice of the grid")]
        let wanted = heights[south as usize * 80 + east as usize];
        assert_eq!(*found, if wanted < 0.0 { VOID } else { height_steps(f64::from(wanted)).unwrap() });
    }
    let is_told = warnings.iter().any(|w| w.code() == "W346" && w.to_string().contains("in EPSG:4326"));
    assert!(is_told, "{warnings:?}");
    // Without leave it is refused, and what would help is said first.
    folder.refuses("info utm.tif --terrain ground.tif", "E310", &["hint: `--project auto`, or `gdalwarp"]);
    // Footprints on it: the terrain is brought to their system, whose grid then is its own.
    let square =
        "[[[11.5710, 48.1390], [11.5712, 48.1390], [11.5712, 48.1392], [11.5710, 48.1392], [11.5710, 48.1390]]]";
    let geometry = format!(r#"{{"type": "Polygon", "coordinates": {square}}}"#);
    folder.write(
        "city.geojson",
        &format!(r#"{{"type": "Feature", "properties": {{"height": 9}}, "geometry": {geometry}}}"#),
    );
    let document = folder.type_in("info city.geojson --terrain ground.tif --project auto --json").done().json();
    assert_eq!(document["crs"], "EPSG:32632");
    folder.refuses("info city.geojson --terrain ground.tif", "E310", &[]);
}

#[test]
fn the_program_projects_rasters_when_it_is_told_to() {
    let folder = Folder::new();
    let (georef, heights) = degrees();
    write(&folder, "degrees.tif", &georef, &heights);
    folder.refuses(
        "info degrees.tif",
        "E310",
        &["hint: `--project auto`, or `gdalwarp", "-t_srs EPSG:32632 degrees.tif degrees_32632.tif`"],
    );
    folder.write("sites.csv", "lon,lat,h\n11.5712,48.1391,2000amsl\n");
    let line = "map degrees.tif --project auto --cell 2 --uavs sites.csv --json";
    let answer = folder.type_in(line).done();
    let document = answer.json();
    assert_eq!((&document["scene"]["crs"], &document["scene"]["cell_m"][0]), (&"EPSG:32632".into(), &2.0.into()));
    assert!(answer.warnings().contains(&"W339"), "{}", answer.err);
    // PROJ: longitude 11.5712, latitude 48.1391 in zone 32.
    let site = &document["sites"][0];
    let (x, y) = (site["x"].as_f64().unwrap(), site["y"].as_f64().unwrap());
    let (wanted_x, wanted_y) = crs::transform(&epsg(4326), &epsg(32632), (11.5712, 48.1391)).unwrap();
    assert!((x - wanted_x).abs() < 1e-6 && (y - wanted_y).abs() < 1e-6, "{site}");
    for (line, code, part) in [
        ("info degrees.tif --cell 2", "E116", "`--cell`"),
        ("info degrees.tif --project auto --cell 0", "E112", "`0`"),
        ("info degrees.tif --project auto --cell 0.0001", "E502", ""),
        ("info degrees.tif --project auto --cell 1000000", "E305", ""),
        ("info degrees.tif --project EPSG:4258", "E310", ""),
        ("info degrees.tif --project auto --extent 0,0,1,1", "E116", "`--extent`"),
        ("info itu:urban --project auto", "E116", "`--project`"),
    ] {
        folder.refuses(line, code, &[part]);
    }
    // What is in meters stays, and then a cell size would be lost.
    let grid = GeoRef::new((691_240.0, 5_334_830.0), (2.0, 2.0), (60, 80), Some(epsg(25832))).unwrap();
    write(&folder, "utm.tif", &grid, &heights);
    let stays = folder.type_in("info utm.tif --project auto --json").done().json();
    assert_eq!(stays["crs"], "EPSG:25832");
    folder.refuses("info utm.tif --project auto --cell 1", "E116", &["`--cell`"]);
    // From one projection to another.
    let moved = folder.type_in("info utm.tif --project EPSG:32633 --json").done().json();
    assert_eq!(moved["crs"], "EPSG:32633");
}
