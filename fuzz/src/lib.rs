//! What the targets share: a file on a memory disk that holds the input, and what a reader may answer.

use std::fmt::Debug;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use skyshed_io::crs;
use skyshed_core::height_field::HeightField;
use skyshed_core::raster::GeoRef;
use skyshed_io::read::{
    FootprintOptions, MeshOptions, PointCloudOptions, Projection, SurfaceOptions, read_footprints, read_mesh, read_point_cloud,
    read_surface,
};
use skyshed_core::city::City;
use skyshed_io::Error;
use skyshed_io::error::ErrorKind;

/// A folder of this process on a memory disk, if the machine has one.
static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let memory = Path::new("/dev/shm");
    let parent = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
    let folder = parent.join(format!("skyshed-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for inputs");
    folder
});

/// Largest extents of the receivers' grid \[units\], where the first inputs are: what is fuzzed is reading, not drawing of
/// large maps.
const TOWN: [f64; 4] = [690_998.0, 5_333_998.0, 691_080.0, 5_334_070.0];
const EXTENT: [f64; 4] = [-8.0, -8.0, 72.0, 72.0];
const PROJECTED: [f64; 4] = [686_100.0, 5_330_420.0, 686_260.0, 5_330_560.0];
const SURVEYED: [f64; 4] = [691_000.0, 5_334_700.0, 691_048.0, 5_334_748.0];

/// Writes the input under a name, whose extension tells the format, and returns its path.
pub fn written(name: &str, bytes: &[u8]) -> PathBuf {
    let path = FOLDER.join(name);
    std::fs::write(&path, bytes).expect("an input on the memory disk");
    path
}

/// The value, if there is one. A refusal must blame what was read, in words, and never the program itself.
pub fn answered<T: Debug>(result: Result<T, impl Into<Error>>) -> Option<T> {
    match result.map_err(Into::<Error>::into) {
        Ok(value) => Some(value),
        Err(error) => {
            assert_ne!(error.kind(), ErrorKind::Internal, "{error}");
            assert!(!error.to_string().is_empty());
            None
        }
    }
}

/// Reads footprints around the origin, and cuts them into prisms.
pub fn footprints(name: &str, bytes: &[u8]) {
    footprints_within(EXTENT, None, name, bytes);
}

/// Reads footprints of the town of the tests.
pub fn town(name: &str, bytes: &[u8]) {
    footprints_within(TOWN, None, name, bytes);
}

/// Reads footprints in degrees, brought into meters.
pub fn projected(name: &str, bytes: &[u8]) {
    footprints_within(PROJECTED, Some(Projection::Auto), name, bytes);
}

fn footprints_within(extent: [f64; 4], project: Option<Projection>, name: &str, bytes: &[u8]) {
    let options = FootprintOptions {
        extent: Some(extent),
        missing: "levels,7".parse().expect("a rule for heights"),
        project,
        ..FootprintOptions::default()
    };
    build(answered(read_footprints(&written(name, bytes), &options, &mut Vec::new())));
}

/// Reads a mesh onto a grid.
pub fn mesh(name: &str, bytes: &[u8]) {
    let options = MeshOptions { extent: Some(EXTENT), ..MeshOptions::default() };
    build(answered(read_mesh(&written(name, bytes), &options, &mut Vec::new())));
}

/// Reads a surface model.
pub fn surface(name: &str, bytes: &[u8]) {
    build(answered(read_surface(&written(name, bytes), &SurfaceOptions::default(), &mut Vec::new())));
}

/// Reads a point cloud.
pub fn cloud(name: &str, bytes: &[u8]) {
    let surface = SurfaceOptions { ground_m: Some(0.0), ..SurfaceOptions::default() };
    let options = PointCloudOptions { surface, extent: Some(SURVEYED), cell_m: Some(4.0) };
    build(answered(read_point_cloud(&written(name, bytes), &options, &mut Vec::new())));
}

fn build(scene: Option<City>) {
    if let Some(scene) = scene {
        HeightField::build(&scene.grid, scene.solids).field;
    }
}

/// A grid for files that name places in a scene, in UTM so that degrees are brought into it.
pub fn grid() -> GeoRef {
    let crs = crs::from_epsg(25832).expect("a registered system");
    GeoRef::new((691_000.0, 5_335_000.0), (1.0, 1.0), (64, 64), Some(crs)).expect("a valid grid")
}
