//! Layers of heights that an engine finds for all receivers at once are those of a walk along each link, to the last bit.

use std::path::{Path, PathBuf};

use skyshed_core::city::{NodataAs, Site};
use skyshed_core::coverage::{Control, HeightLayers, MapOptions, Mapper, Receivers, Uav};
use skyshed_core::height_field::{Columns, HeightField};
use skyshed_core::los::{Method, MethodChoice, columns_least_height, columns_least_receiver_height, columns_los};
use skyshed_core::quantity::{Height, LatticePoint, VOID};
use skyshed_io::read::{FootprintOptions, SurfaceOptions, read_footprints, read_surface};

use crate::invariants::check_least;
use crate::needs::truth;
use crate::referee::both_answers;
use crate::shapes::M;
use crate::support::{Random, is_long};

/// A surface, over a terrain or alone.
fn surface(dsm: &Path, terrain: Option<&Path>, nodata_as: NodataAs) -> HeightField {
    let options = SurfaceOptions { terrain: terrain.map(Into::into), nodata_as, ..SurfaceOptions::default() };
    let scene = read_surface(dsm, &options, &mut Vec::new()).unwrap();
    HeightField::build(&scene.grid, scene.solids).field
}

/// Compares the layers of some UAVs around the middle of a city; returns how many receivers were compared.
fn compare(field: &HeightField, receivers: Receivers, radius: Option<f64>) -> usize {
    // Past a raster alone the least heights of the UAV are those of walks.
    let least_height = field.prisms().is_some();
    let layers = HeightLayers { margin: true, least_receiver_height: true, least_height, ..HeightLayers::default() };
    let options = |method| MapOptions { receivers, radius, layers, method, ..MapOptions::default() };
    let engine = if least_height { MethodChoice::Auto } else { MethodChoice::Sweep };
    let [fast, ray] = [engine, MethodChoice::Ray].map(|method| Mapper::new(field, &options(method)).unwrap());
    assert!(ray.method().0 == Method::Ray && fast.method().0 != Method::Ray);
    let grid = field.grid();
    let (width, height) = (grid.x_max() - grid.x_min(), grid.y_max() - grid.y_min());
    let mut n = 0;
    for (x, y, up) in [(0.5, 0.5, 60.0), (0.31, 0.62, 15.0), (0.77, 0.4, 250.0)] {
        let (x, y) = (grid.x_min() + x * width, grid.y_min() + y * height);
        let site = Site::new("1", (x, y), Height::AboveGround(up));
        let Ok(uav) = Uav::place(&site, field, None) else { continue };
        let [found, wanted] =
            [&fast, &ray].map(|mapper| mapper.seen_from(&uav).unwrap().map(&Control::default()).unwrap());
        assert_eq!(found.mask, wanted.mask);
        let layers = |map: &skyshed_core::coverage::SiteCoverage| {
            [map.margin.clone(), map.least_receiver_height.clone(), map.least_height.clone()]
                .map(Option::unwrap_or_default)
        };
        assert_eq!(layers(&found).map(|layer| layer.is_empty()), [false, false, !least_height]);
        for (found, wanted) in layers(&found).iter().zip(&layers(&wanted)) {
            let differ = found.iter().zip(wanted).position(|(a, b)| a.to_bits() != b.to_bits());
            assert!(differ.is_none(), "cell {differ:?} of a UAV {up} m over {x}, {y}");
        }
        n += usize::try_from(found.tally.receivers).unwrap();
    }
    n
}

#[test]
fn margins_and_ceilings_of_munich_by_the_sweep_are_those_of_rays() {
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps");
    let [dsm, terrain] = ["munich_dsm.tif", "munich_terrain.tif"].map(|file| maps.join(file));
    let radius = if is_long() { None } else { Some(250.0) };
    let field = surface(&dsm, Some(&terrain), NodataAs::Clear);
    assert!(compare(&field, Receivers::All, radius) > 300_000);
    let alone = surface(&dsm, None, NodataAs::Clear);
    assert!(compare(&alone, Receivers::Ground, radius) > 300_000);
}

#[test]
fn heights_past_the_footprints_of_munich_are_those_of_rays_on_flat_ground_and_on_terrain() {
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps");
    let radius = if is_long() { None } else { Some(250.0) };
    for terrain in [None, Some(maps.join("munich_terrain.tif").into())] {
        // The one that is no multiple of the terrain's cells is left to rays past that.
        for cell in [1.0, 0.7] {
            let options =
                FootprintOptions { cell_m: Some(cell), terrain: terrain.clone(), ..FootprintOptions::default() };
            let scene = read_footprints(maps.join("munich.geojson"), &options, &mut Vec::new()).unwrap();
            let field = HeightField::build(&scene.grid, scene.solids).field;
            assert!(compare(&field, Receivers::All, radius) > 100_000);
        }
    }
}

#[test]
fn margins_and_ceilings_of_laser_scans_by_the_sweep_are_those_of_rays() {
    let Some(data) = truth() else { return };
    let lidar = |file: &str| -> PathBuf { data.join("lidar").join(file) };
    for nodata_as in [NodataAs::Clear, NodataAs::Block] {
        let delft = surface(&lidar("delft/dsm_1m.tif"), Some(&lidar("delft/terrain_1m.tif")), nodata_as);
        assert!(compare(&delft, Receivers::All, None) > 100_000);
    }
    let bilbao = surface(&lidar("bilbao/dsm_2.5m.tif"), Some(&lidar("bilbao/terrain_2.5m.tif")), NodataAs::Clear);
    assert!(compare(&bilbao, Receivers::Ground, if is_long() { None } else { Some(500.0) }) > 100_000);
}

#[test]
fn walks_past_tiles_find_the_least_heights_of_wide_rasters() {
    both_answers(4_000, 12, |random| {
        // Wider than several tiles of tiles, with towers here and there, and voids; ends on lines and corners of cells, and beside it.
        let (n_rows, n_cols) = (random.index(60, 200), random.index(60, 200));
        let (most, towers) = (random.choose(&[1, 300, 4000]), random.choose(&[0, 1, 3]));
        let top = |random: &mut Random| match random.within(0, 99) {
            share if share < towers => i32::try_from(random.within(5, 60) * M).unwrap(),
            99 => VOID,
            _ => i32::try_from(random.within(0, most)).unwrap(),
        };
        let columns = Columns::new(n_rows, n_cols, (0..n_rows * n_cols).map(|_| top(random)).collect::<Vec<_>>());
        let end = |random: &mut Random| {
            let step = random.choose(&[1, 256, 512, 1024]);
            let mut along = |n: usize| random.within(-3 * M / step, (i64::try_from(n).unwrap() + 3) * M / step) * step;
            let (x, y) = (along(n_cols), along(n_rows));
            LatticePoint { x, y, z: random.within(0, 50) * M / 2 }
        };
        let (uav, mut receiver) = (end(random), end(random));
        if random.chance(10) {
            receiver.x = uav.x;
        }
        let ceiling = columns_least_receiver_height(&columns, uav, receiver);
        check_least(&ceiling, receiver.z, |z| columns_los(&columns, uav, LatticePoint { z, ..receiver }));
        let least = columns_least_height(&columns, uav, receiver);
        check_least(&least, uav.z, |z| columns_los(&columns, LatticePoint { z, ..uav }, receiver));
        columns_los(&columns, uav, receiver)
    });
}
