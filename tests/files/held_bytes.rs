//! Readers take bytes that the caller holds, as a web page or Python hands them over: the city is that of the file.

use std::path::Path;

use skyshed_core::city::{City, Ground, Solids};
use skyshed_io::Input;
use skyshed_io::Warning;
use skyshed_io::read::{
    BadRows, FootprintOptions, MeshOptions, SurfaceOptions, read_footprints, read_mesh, read_sites, read_surface,
    read_track,
};

use crate::program::Folder;
use crate::vector_files::{
    city, write_cityjson, write_flatgeobuf, write_geojson, write_geopackage, write_obj, write_ply, write_shapefile,
};

/// The bytes of a file with those of all files of its name beside it.
fn held(path: &Path) -> Input {
    let bytes = |path: &Path| std::fs::read(path).expect("a file of the test");
    let name = path.file_name().expect("a name");
    let stem = path.file_stem();
    let others = std::fs::read_dir(path.parent().expect("a folder")).expect("a folder");
    let others = others.map(|entry| entry.expect("an entry").path());
    others
        .filter(|other| other.file_stem() == stem && other != path)
        .fold(Input::bytes(name, bytes(path)), |input, other| {
            input.with_beside(other.file_name().expect("a name"), bytes(&other))
        })
}

/// What a reader gives, in words; a folder before a name is left out.
fn told(read: skyshed_io::Result<City>, warnings: &[Warning], folder: &Path) -> String {
    let mut city = read.unwrap_or_else(|e| panic!("{e}"));
    let prefix = format!("{}/", folder.display().to_string().trim_end_matches('/'));
    let without = |text: &str| text.replace(&prefix, "");
    city.sources.iter_mut().for_each(|source| source.path = without(&source.path));
    // Cells are compared as numbers: there are too many for words.
    let cells = match &city.solids {
        Solids::Raster { surface, ground, .. } => {
            let sum =
                |cells: &[i32]| cells.iter().zip(1_u64..).map(|(z, k)| i128::from(*z) * i128::from(k)).sum::<i128>();
            let below = if let Ground::Terrain(terrain) = ground { sum(terrain.cells()) } else { 0 };
            format!("{} {below}", sum(surface.cells()))
        }
        Solids::Vector { footprints, ground, .. } => format!("{footprints:?} {ground:?}"),
    };
    let warnings: Vec<_> = warnings.iter().map(|w| (w.code(), without(&w.to_string()))).collect();
    format!("{} {:?} {:?} {cells} {warnings:?}", city.name, city.grid, city.sources)
}

#[test]
fn footprints_in_bytes_are_those_of_the_file() {
    let (folder, city) = (Folder::new(), city());
    write_geojson(&folder.join("a.geojson"), &city);
    write_shapefile(&folder.join("b.shp"), &city);
    write_flatgeobuf(&folder.join("c.fgb"), &city, true);
    write_cityjson(&folder.join("f.json"), &city, "2.0");
    let options = FootprintOptions::default();
    let of = |input: Input| {
        let mut warnings = Vec::new();
        told(read_footprints(input, &options, &mut warnings), &warnings, &folder.join(""))
    };
    write_geopackage(&folder.join("e.gpkg"), &[("buildings", &city)]);
    for name in ["a.geojson", "b.shp", "c.fgb", "e.gpkg", "f.json"] {
        let path = folder.join(name);
        assert_eq!(of(held(&path)), of(Input::path(path)), "{name}");
    }
    // Without its index a shapefile is none.
    let alone = Input::bytes("b.shp", std::fs::read(folder.join("b.shp")).unwrap());
    assert_eq!(read_footprints(alone, &options, &mut Vec::new()).unwrap_err().code(), "E301");
}

#[test]
fn rasters_and_meshes_in_bytes_are_those_of_the_file() {
    let folder = Folder::new();
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps");
    folder.write("g.asc", "ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n4 5 -9999\n");
    folder.write("g.prj", "EPSG:25832");
    let surface = |input: Input, terrain: Option<Input>, folder: &Path| {
        let mut warnings = Vec::new();
        let options = SurfaceOptions { terrain, ..SurfaceOptions::default() };
        told(read_surface(input, &options, &mut warnings), &warnings, folder)
    };
    let grid = folder.join("g.asc");
    let of_grid = surface(held(&grid), None, &folder.join(""));
    assert!(of_grid.contains("25832"), "{of_grid}");
    assert_eq!(of_grid, surface(Input::path(grid), None, &folder.join("")));
    let [dsm, terrain] = ["munich_dsm.tif", "munich_terrain.tif"].map(|name| maps.join(name));
    let of_files = surface(Input::path(&dsm), Some(Input::path(&terrain)), &maps);
    assert_eq!(surface(held(&dsm), Some(held(&terrain)), &maps), of_files);
    write_obj(&folder.join("m.obj"));
    write_ply(&folder.join("n.ply"), "binary_little_endian");
    let mesh = |input: Input| {
        let mut warnings = Vec::new();
        told(read_mesh(input, &MeshOptions::default(), &mut warnings), &warnings, &folder.join(""))
    };
    for name in ["m.obj", "n.ply"] {
        let path = folder.join(name);
        assert_eq!(mesh(held(&path)), mesh(Input::path(path)), "{name}");
    }
    // Other files are named by paths.
    let vrt = Input::bytes("v.vrt", *b"<VRTDataset rasterXSize=\"1\" rasterYSize=\"1\"/>");
    assert_eq!(read_surface(vrt, &SurfaceOptions::default(), &mut Vec::new()).unwrap_err().code(), "E304");
}

#[test]
fn places_in_bytes_are_those_of_the_file() {
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps");
    let grid = skyshed_io::read::surface_grid(maps.join("munich_dsm.tif"), &SurfaceOptions::default()).unwrap();
    let sites = |input: Input| read_sites(input, &grid, 1, BadRows::Refuse).unwrap();
    let path = maps.join("sites.csv");
    assert_eq!(format!("{:?}", sites(held(&path))), format!("{:?}", sites(Input::path(path))));
    let track = |input: Input| read_track(input, grid.crs(), (false, &mut Vec::new())).unwrap();
    let path = maps.join("walk.csv");
    assert_eq!(track(held(&path)), track(Input::path(path)));
}
