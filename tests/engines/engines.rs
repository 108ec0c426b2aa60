//! Whole maps by the engine for the scene are those of a ray per receiver: generated cities, noisy roofs, real terrain,
//! hostile rasters; and the oracle agrees where masks turn.

use std::path::PathBuf;

use rayon::prelude::*;
use skyshed_core::city::{Ground, Site};
use skyshed_core::coverage::{MapOptions, Mapper, Receivers, SiteCoverage, Uav, class};
use skyshed_core::height_field::HeightField;
use skyshed_core::los::{GridLos, GridReceivers, Method, MethodChoice};
use skyshed_core::quantity::{Height, VOID, height_steps};
use skyshed_core::raster::{CellWindow, GeoRef, Raster};
use skyshed_core::simd::simd_levels;
use skyshed_io::read::{SurfaceOptions, read_surface};

use crate::invariants::{map, uav_at};
use crate::needs::truth;
use crate::oracle;
use crate::referee::{Count, over_seeds};
use crate::support::{ENVIRONMENTS, Random, city, is_long, raster_field};
use crate::translation::oracle_of;

/// A raster scene of the surface of another, each roof cell raised by up to `noise` lattice steps.
pub(crate) fn as_raster(field: &HeightField, ground: Ground, noise: i64, random: &mut Random) -> HeightField {
    let heights = field.surface_m();
    let cells = heights.iter().map(|z| {
        let z = height_steps(f64::from(*z)).unwrap();
        if z > 0 && noise > 0 { z + i32::try_from(random.within(-noise, noise)).unwrap() } else { z }
    });
    raster_field(Raster::new(field.grid().clone(), cells.collect::<Vec<_>>()), ground)
}

fn by(field: &HeightField, uav: &Uav, method: MethodChoice, receivers: Receivers, radius: Option<f64>) -> SiteCoverage {
    map(field, uav, &MapOptions { method, receivers, radius, ..MapOptions::default() })
}

/// Compares the engine that the scene calls for with rays.
fn compare(field: &HeightField, uav: &Uav, receivers: Receivers, radius: Option<f64>, what: &str) -> Count {
    let found = by(field, uav, MethodChoice::Auto, receivers, radius);
    let expected = by(field, uav, MethodChoice::Ray, receivers, radius);
    let n_cols = field.grid().n_cols();
    if let Some(cell) = (0..found.mask.len()).find(|cell| found.mask[*cell] != expected.mask[*cell]) {
        let (row, col, classes) = (cell / n_cols, cell % n_cols, (found.mask[cell], expected.mask[cell]));
        panic!("{what}, {receivers:?}, UAV {:?}: row {row}, column {col}: {classes:?}", uav.station);
    }
    assert_eq!(found.tally, expected.tally, "{what}");
    let mapper_options = MapOptions { receivers, radius, ..MapOptions::default() };
    let (links, los) = (found.tally.receivers, found.tally.los);
    assert_eq!(Mapper::new(field, &mapper_options).unwrap().seen_from(uav).unwrap().count(), (links, los));
    Count { links, los, ..Count::default() }
}

/// UAVs over a street, a crossroad and a roof, at cell centers, corners and anywhere, from 2 m to 500 m up.
fn uavs(field: &HeightField, random: &mut Random) -> Vec<Uav> {
    let grid = field.grid();
    let half = (grid.x_min() + grid.x_max()) / 2.0;
    let mut found = Vec::new();
    // The crossroad's corner is the origin of a generated city; streets and roofs are found by looking.
    let mut places = vec![(0.5, 0.5), (half.floor(), half.floor())];
    for wants_roof in [false, true] {
        for _ in 0..200 {
            let (x, y) = (half * random.within(1, 1999) as f64 / 1000.0, half * random.within(1, 1999) as f64 / 1000.0);
            if field.roof_at(&field.place(x, y)).is_some() == wants_roof {
                places.push((x, y));
                break;
            }
        }
    }
    for (x, y) in places {
        for height in [2.0, 15.0, 40.0, 100.0, 500.0] {
            let over_roof = field.roof_at(&field.place(x, y)).is_some();
            let height = if over_roof { Height::AboveRoof(height - 2.0) } else { Height::AboveGround(height) };
            found.push(Uav::place(&Site::new("1", (x, y), height), field, None).unwrap());
        }
    }
    found
}

#[test]
fn generated_cities_as_footprints_and_as_rasters_agree_with_rays() {
    let (seeds, size) = if is_long() { (20, 400.0) } else { (2, 140.0) };
    let count = over_seeds(4 * seeds, 0, |job, _, count| {
        let (name, seed) = (ENVIRONMENTS[usize::try_from(job % 4).unwrap()], job / 4);
        let mut random = Random(seed);
        let footprints = city(name, size, 1.0, seed);
        let flat = as_raster(&footprints, Ground::Flat(0), 0, &mut random);
        let noisy = as_raster(&footprints, Ground::Flat(0), 700, &mut random);
        let surface = as_raster(&footprints, Ground::Surface, 0, &mut random);
        for (k, uav) in uavs(&footprints, &mut random).iter().enumerate() {
            let radius = (k % 4 == 3).then_some(47.3);
            let mut add = |field: &HeightField, receivers: Receivers, kind: &str| {
                let uav = &uav_at(field, uav.station.place.x, uav.station.place.y, uav.station.z);
                *count += compare(field, uav, receivers, radius, &format!("{name}, seed {seed}, {kind}"));
            };
            for receivers in [Receivers::Ground, Receivers::Roof, Receivers::All] {
                add(&footprints, receivers, "footprints");
                add(&flat, receivers, "raster");
            }
            add(&noisy, Receivers::All, "noisy roofs");
            add(&surface, Receivers::Ground, "surface alone");
        }
    });
    count.assert_both(3_000_000);
}

/// Surfaces on which bins, corners and heights coincide as often as can be.
fn hostile(kind: usize, n: i32, uav_z: i32) -> Vec<i32> {
    let at = |f: &dyn Fn(i32, i32) -> i32| (0..n * n).map(|cell| f(cell / n, cell % n)).collect();
    let half = n / 2;
    match kind {
        // Towers one cell wide, and slots one cell wide.
        0 => at(&|r, c| if r % 3 == 0 && c % 5 == 0 { uav_z / 2 } else { 0 }),
        1 => at(&|r, c| if r % 7 == 3 || c % 11 == 5 { 0 } else { uav_z / 3 }),
        // Checkers: rays through corners pass.
        2 => at(&|r, c| if (r + c) % 2 == 0 { uav_z - 512 } else { 0 }),
        // Diagonal walls, and a wall with a hole.
        3 => at(&|r, c| if (r + 2 * c) % 13 == 0 { uav_z / 4 } else { 0 }),
        4 => at(&|r, c| if c == half + 9 && r != half { uav_z + 1024 } else { 0 }),
        // A cone whose flanks graze every ray from its top, and a dome.
        5 => at(&|r, c| uav_z - 1024 - 300 * (r - half).abs().max((c - half).abs())),
        6 => at(&|r, c| uav_z / 2 - 60 * ((r - half).pow(2) + (c - half).pow(2))),
        // Stairs that each touch the ray to the next, towers above the UAV, and a plain exactly at its height.
        7 => at(&|r, _| 512 * (n - r)),
        8 => at(&|r, c| if (r * 7 + c * 3) % 17 == 0 { uav_z + 5000 } else { 0 }),
        9 => at(&|r, c| if (r / 4 + c / 4) % 3 == 0 { uav_z } else { uav_z - 1537 }),
        // Voids in between.
        _ => at(&|r, c| if (r / 5 + c / 3) % 4 == 0 { VOID } else { (r * 131 + c * 71) % 9000 }),
    }
}

#[test]
fn hostile_rasters_agree_with_rays_from_every_kind_of_place() {
    let n = if is_long() { 200 } else { 90 };
    let side = usize::try_from(n).unwrap();
    let grid = GeoRef::new((0.0, f64::from(n)), (1.0, 1.0), (side, side), None).unwrap();
    let uav_z = 30 * 1024;
    let half = f64::from(n / 2);
    let places = [
        (half + 0.5, half + 0.5),
        (half, half),
        (half, half + 0.5),
        (half + 1.0 / 1024.0, half - 1.0 / 1024.0),
        (half + 0.3, half + 0.77),
        (0.0, 0.0),
        (0.5, f64::from(n) - 0.5),
        (-31.5, half + 0.5),
        (-200.0, -200.0),
        (half, f64::from(n) + 77.0),
    ];
    (0..11_usize).into_par_iter().for_each(|kind| {
        let field = raster_field(Raster::new(grid.clone(), hostile(kind, n, uav_z)), Ground::Surface);
        let mut count = Count::default();
        for (x, y) in places {
            for z in [uav_z, uav_z + 1, 2 * uav_z, 20 * uav_z] {
                let uav = uav_at(&field, x, y, i64::from(z));
                count += compare(&field, &uav, Receivers::Ground, None, &format!("{kind}"));
            }
        }
        assert!(count.links > 100_000 && count.los > 0 && count.los < count.links, "{kind}: {count:?}");
    });
}

#[test]
fn real_surfaces_agree_with_rays() {
    let Some(data) = truth() else { return };
    let of = |parts: &str| -> Vec<PathBuf> {
        let folder = data.join(parts);
        let entries = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path());
        entries.filter(|p| p.extension().is_some_and(|e| e == "tif" || e == "asc")).collect()
    };
    let folders =
        ["lidar/bilbao", "lidar/delft", "viewshed_thirdparty/gdal", "viewshed_thirdparty/grass", "cities/munich"];
    let files: Vec<PathBuf> = folders.iter().flat_map(|f| of(f)).collect();
    let mut n_files = 0;
    for path in &files {
        // Masks and outputs are no surfaces, and some cases are no rasters.
        let Ok(scene) = read_surface(path, &SurfaceOptions::default(), &mut Vec::new()) else { continue };
        let field = HeightField::build(&scene.grid, scene.solids).field;
        let grid = field.grid().clone();
        let mut random = Random(grid.n_cells() as u64);
        let n_uavs = if is_long() { 12 } else { 2 };
        for k in 0..n_uavs {
            let at = |random: &mut Random, low: f64, high: f64| {
                low + (high - low) * random.within(-50, 1050) as f64 / 1000.0
            };
            let (x, y) = (at(&mut random, grid.x_min(), grid.x_max()), at(&mut random, grid.y_min(), grid.y_max()));
            let height = [40, 3, 150, 900][k % 4] * 1024;
            let z = i64::from(field.ground_at(&field.place(x, y)).max(0)) + height;
            let uav = uav_at(&field, x, y, z);
            // Whole large surfaces take rays half a minute.
            let radius = (!is_long()).then_some(200.0 * grid.cell_width());
            compare(&field, &uav, Receivers::Ground, radius, &path.display().to_string());
        }
        n_files += 1;
    }
    assert!(n_files >= 6, "{n_files} of {} files", files.len());
}

#[test]
fn neither_threads_nor_vectors_change_a_cell() {
    let mut random = Random(5);
    let footprints = city("urban", 300.0, 1.0, 3);
    let raster = as_raster(&footprints, Ground::Surface, 300, &mut random);
    for field in [&footprints, &raster] {
        let uav = &uavs(field, &mut random)[3];
        let one = by(field, uav, MethodChoice::Auto, Receivers::All, None);
        for threads in [1, 2, 7, 40] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let other = pool.install(|| by(field, uav, MethodChoice::Auto, Receivers::All, None));
            assert!(one.mask == other.mask && one.tally == other.tally, "{threads} threads");
        }
        let (method, _) = Method::choose(field, MethodChoice::Auto).unwrap();
        let cells = field.cells().open.clone();
        let receivers = GridReceivers::new(cells.clone(), field.ground_of_cells(), 1536);
        let grid = field.grid();
        let window = CellWindow { row: 0, col: 0, n_rows: grid.n_rows(), n_cols: grid.n_cols() };
        let los: Vec<_> = simd_levels()
            .into_iter()
            .map(|level| {
                let mut engine = GridLos::new(field, method).unwrap();
                engine.level = level;
                engine.los(&uav.station, &receivers, &cells, window)
            })
            .collect();
        assert!(los.len() >= 2 && los.iter().all(|found| *found == los[0]), "{method:?}");
    }
}

#[test]
fn the_oracle_agrees_where_masks_turn() {
    let n_asked = if is_long() { 4000 } else { 250 };
    let mut random = Random(11);
    for name in ENVIRONMENTS {
        let raster = as_raster(&city(name, 160.0, 1.0, 7), Ground::Flat(0), 50, &mut random);
        let columns = raster.columns().unwrap();
        let exact = oracle_of(columns);
        let mut asked = 0;
        for uav in &uavs(&raster, &mut random) {
            let found = by(&raster, uav, MethodChoice::Sweep, Receivers::All, None);
            let n_cols = raster.grid().n_cols();
            let turns = |i: usize| {
                let right = i % n_cols + 1 < n_cols && found.mask[i] + found.mask[i + 1] == 1;
                right || (i + n_cols < found.mask.len() && found.mask[i] + found.mask[i + n_cols] == 1)
            };
            let edges: Vec<usize> = (0..found.mask.len()).filter(|i| found.mask[*i] <= 1 && turns(*i)).collect();
            for _ in 0..n_asked.min(edges.len()) / 10 {
                let cell = random.choose(&edges);
                let (row, col) = (cell / n_cols, cell % n_cols);
                let (x, y) = columns.center(row, col);
                let on = if raster.cells().open.contains(row, col) { 0 } else { columns.tops()[cell] };
                let u = uav.station.on_columns();
                let los = oracle::columns_los(&exact, [u.x, u.y, u.z], [x, y, i64::from(on) + 1536]);
                assert_eq!(los, found.mask[cell] == class::LOS, "{name}: cell {cell}, UAV {u:?}");
                asked += 1;
            }
        }
        assert!(asked >= 100, "{asked} cells at edges of {name}");
    }
}
