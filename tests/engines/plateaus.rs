//! Shadows of the plateaus of a raster equal `ray` on its columns, cell for cell; and `auto` takes them where they serve.

use skyshed_core::city::Ground;
use skyshed_core::coverage::{Control, KeepMasks, MapOptions, Mapper, Receivers, Together};
use skyshed_core::height_field::{Columns, Plateaus};
use skyshed_core::los::{Method, MethodChoice, OnPlateaus, PlateauScene, ShadowGrid, columns_los, plateaus_los};
use skyshed_core::quantity::{LatticePoint, VOID};
use skyshed_core::raster::CellWindow;
use skyshed_core::simd::simd_levels;

use crate::engines::as_raster;
use crate::invariants::{map, uav_at};
use crate::plain_tiff::{Cells, PlainTiff};
use crate::program::Folder;
use crate::referee::{Count, check_cells, over_seeds};
use crate::support::{ENVIRONMENTS, Random, cells_where, city, is_long, random_place};

/// Rectangles on flat ground, one over another, some of them void, with tops around the UAV's height.
fn blocks(random: &mut Random, (n_rows, n_cols): (usize, usize), uav_z: i64) -> Vec<i32> {
    let ground = random.choose(&[0, -20 * 1024, 3]);
    let spread = random.choose(&[1, 3, 3000, 100 * 1024]);
    let mut tops = vec![ground; n_rows * n_cols];
    for _ in 0..random.index(0, 14) {
        let side = |random: &mut Random, n: usize| {
            let first = random.index(0, n - 1);
            (first, (first + random.index(1, 12)).min(n))
        };
        let (rows, cols) = (side(random, n_rows), side(random, n_cols));
        let top = match random.within(0, 10) {
            0 => VOID,
            1..=5 => i32::try_from((uav_z + random.within(-spread, spread)).max(ground.into())).unwrap(),
            6 => ground - i32::try_from(random.within(0, 5 * 1024)).unwrap(),
            _ => ground + i32::try_from(random.within(0, 20 * 1024)).unwrap(),
        };
        for row in rows.0..rows.1 {
            tops[row * n_cols + cols.0..row * n_cols + cols.1].fill(top);
        }
    }
    tops
}

/// Compares all receivers of one scene with rays.
fn compare(tops: &[i32], n_cols: usize, uav: LatticePoint, on: OnPlateaus, random: &mut Random) -> Count {
    let n_rows = tops.len() / n_cols;
    let columns = Columns::new(n_rows, n_cols, tops.to_vec());
    let Some(plateaus) = Plateaus::of(tops, n_cols) else { return Count::default() };
    let height = |cell: usize| match on {
        OnPlateaus::Level(z) => z,
        OnPlateaus::Above(above) => i64::from(tops[cell]) + i64::from(above),
    };
    let lowest = i64::from(plateaus.lowest());
    if uav.z < lowest || matches!(on, OnPlateaus::Level(z) if z < lowest) {
        return Count::default();
    }
    let wanted_of_100 = random.choose(&[100, 100, 60]);
    // Sometimes a part of the raster, and all between it and the UAV.
    let some = |random: &mut Random, n: usize| {
        let first = random.index(0, n - 1);
        if random.chance(20) { (first, random.index(first, n - 1) + 1) } else { (0, n) }
    };
    let (rows, cols) = (some(random, n_rows), some(random, n_cols));
    let wanted = cells_where((n_rows, n_cols), |row, col| {
        let is_there = (rows.0..rows.1).contains(&row) && (cols.0..cols.1).contains(&col);
        is_there && tops[row * n_cols + col] != VOID && random.chance(wanted_of_100)
    });
    let place = |steps: i64, n: usize| usize::try_from(steps.div_euclid(1024)).unwrap_or(0).min(n - 1);
    let (uav_row, uav_col) = (n_rows - 1 - place(uav.y, n_rows), place(uav.x, n_cols));
    let (row, col) = (rows.0.min(uav_row), cols.0.min(uav_col));
    let (n_rows_of, n_cols_of) = (rows.1.max(uav_row + 1) - row, cols.1.max(uav_col + 1) - col);
    let window = CellWindow { row, col, n_rows: n_rows_of, n_cols: n_cols_of };
    let xs = (0..n_cols).map(|col| columns.center(0, col).0).collect();
    let ys = (0..n_rows).map(|row| columns.center(row, 0).1).collect();
    let grid = ShadowGrid::new(xs, ys);
    let (level, n_bands) = (random.choose(&simd_levels()), random.index(1, 3));
    let (columns, plateaus) = (&columns, &plateaus);
    let scene = PlateauScene { columns, plateaus, grid: &grid, wanted: &wanted, window, level, n_bands };
    let los = plateaus_los(&scene, uav, on);
    let ray = |row: usize, col: usize| {
        let ((x, y), z) = (columns.center(row, col), height(row * n_cols + col));
        columns_los(columns, uav, LatticePoint { x, y, z })
    };
    check_cells(&los, &wanted, ray, || format!("UAV {uav:?}, {on:?}, {level:?}, {n_bands} bands, tops {tops:?}"))
}

#[test]
fn small_block_models_with_heights_around_the_uav_agree_with_ray() {
    let n = if is_long() { 400_000 } else { 12_000 };
    let count = over_seeds(n, 0x91A7, |_, random, count| {
        let shape = (random.index(1, 40), random.index(1, 80));
        let uav_z = random.choose(&[512, 1024, 9 * 1024, 40 * 1024, 130 * 1024]);
        let tops = blocks(random, shape, uav_z);
        let uav = random_place(random, shape, uav_z, 20);
        let on = match random.within(0, 2) {
            0 => OnPlateaus::Level(random.choose(&[0, 1536, uav_z, uav_z + 3000, 9000])),
            _ => OnPlateaus::Above(random.choose(&[0, 1, 1536, 1536, 30 * 1024])),
        };
        *count = compare(&tops, shape.1, uav, on, random);
    });
    assert!(count.links > n * 300 && count.los > n * 50 && count.los < count.links * 3 / 4, "{count:?}");
}

#[test]
fn towns_of_blocks_agree_with_ray() {
    let n = if is_long() { 2000 } else { 60 };
    let count = over_seeds(n, 0xB10C, |_, random, count| {
        let (n_rows, n_cols) = (random.index(60, 300), random.index(60, 300));
        let (block, street) = (random.index(5, 25), random.index(1, 12));
        let (tall, spread) = (random.within(1, 40), random.choose(&[0, 1024, 40 * 1024]));
        let mut tops = vec![0; n_rows * n_cols];
        for row in (0..n_rows).step_by(block + street) {
            for col in (0..n_cols).step_by(block + street) {
                let top = i32::try_from(tall * 1024 + random.within(0, spread)).unwrap();
                for row in row..(row + block).min(n_rows) {
                    tops[row * n_cols + col..][..block.min(n_cols - col)].fill(top);
                }
            }
        }
        let z = random.choose(&[2000, 20 * 1024, 60 * 1024, 100 * 1024, 300 * 1024]);
        let uav = random_place(random, (n_rows, n_cols), z, 20);
        let on = random.choose(&[OnPlateaus::Level(1536), OnPlateaus::Above(1536), OnPlateaus::Above(0)]);
        *count = compare(&tops, n_cols, uav, on, random);
    });
    assert!(count.links > n * 10_000 && count.los > n * 1000 && count.los < count.links, "{count:?}");
}

#[test]
fn auto_takes_the_shadows_of_generated_cities_as_rasters_and_they_are_those_of_rays_and_of_the_sweep() {
    let seeds = if is_long() { 10 } else { 1 };
    for (name, seed) in ENVIRONMENTS.into_iter().flat_map(|n| (0..seeds).map(move |s| (n, s))) {
        let mut random = Random(seed);
        let footprints = city(name, 520.0, 1.0, seed);
        for ground in [Ground::Surface, Ground::Flat(0)] {
            let field = as_raster(&footprints, ground, 0, &mut random);
            let (x, y) = (random.within(0, 1040) as f64 / 2.0, random.within(0, 1040) as f64 / 2.0);
            let roof = field.roof_at(&field.place(x, y)).unwrap_or(0).max(field.ground_at(&field.place(x, y)));
            for above in [2, 60, 200] {
                let uav = uav_at(&field, x, y, i64::from(roof) + above * 1024);
                for (receivers, radius) in
                    [(Receivers::Ground, None), (Receivers::All, None), (Receivers::All, Some(201.3))]
                {
                    let options = |method| MapOptions { method, receivers, radius, ..MapOptions::default() };
                    let by = |method| map(&field, &uav, &options(method));
                    let (auto, ray, sweep) = (by(MethodChoice::Auto), by(MethodChoice::Ray), by(MethodChoice::Sweep));
                    let what = format!("{name}, seed {seed}, UAV {above} m over {x}, {y}, {receivers:?}, {radius:?}");
                    assert!(auto.mask == ray.mask && sweep.mask == ray.mask, "{what}");
                    assert_eq!((auto.tally, sweep.tally), (ray.tally, ray.tally), "{what}");
                }
            }
            assert_eq!(Method::choose(&field, MethodChoice::Auto).unwrap().0, Method::Shadow);
            // Roofs that are not flat are no plateaus.
            let noisy = as_raster(&footprints, Ground::Surface, 700, &mut random);
            assert_eq!(Method::choose(&noisy, MethodChoice::Auto).unwrap().0, Method::Sweep);
            assert!(Method::choose(&noisy, MethodChoice::Shadow).is_err());
        }
    }
}

#[test]
fn many_threads_that_all_want_what_is_made_once_do_not_wait_for_each_other() {
    let footprints = city("urban", 520.0, 1.0, 3);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(8).build().unwrap();
    for method in [MethodChoice::Auto, MethodChoice::Sweep] {
        for _ in 0..5 {
            let field = as_raster(&footprints, Ground::Surface, 0, &mut Random(1));
            let uavs: Vec<_> = (0..12).map(|k| uav_at(&field, 20.5 + 40.0 * f64::from(k), 300.5, 90 * 1024)).collect();
            let options = MapOptions { method, ..MapOptions::default() };
            let maps = pool.install(|| {
                let mapper = Mapper::new(&field, &options).unwrap();
                mapper
                    .map_many(&uavs, (KeepMasks::Always, &Together::default()), &Control::default(), |_| {}, |_| {})
                    .unwrap()
            });
            assert_eq!(maps.sites.len(), 12);
            assert!(maps.sites[7].mask == map(&field, &uavs[7], &options).mask);
        }
    }
}

/// Blocks of whole meters with a hole in the data; below `noise_from`, cells of any height.
fn block_heights((n_rows, n_cols): (usize, usize), noise_from: usize) -> Vec<f64> {
    let mut random = Random(5);
    let mut heights = vec![2.0; n_rows * n_cols];
    for row in (7..n_rows).step_by(31) {
        for col in (3..n_cols).step_by(27) {
            let height = if random.chance(2) { -99.0 } else { random.within(5, 60) as f64 };
            for row in row..(row + 20).min(n_rows) {
                heights[row * n_cols + col..][..18.min(n_cols - col)].fill(height);
            }
        }
    }
    heights[noise_from * n_cols..].iter_mut().for_each(|height| *height = random.within(0, 30) as f64);
    heights
}

#[test]
fn a_file_of_runs_is_the_map_of_the_same_cells_one_by_one() {
    let shape = (570, 600);
    for (noise_from, method) in [(570, "shadow"), (300, "sweep"), (0, "sweep")] {
        let folder = Folder::new();
        for (name, cells) in [("runs", Cells::Float32), ("cells", Cells::Int16)] {
            let tiff = PlainTiff {
                corner: (300_000.0, 5_000_000.0),
                cell: 1.0,
                n_cols: shape.1,
                n_rows: shape.0,
                cells,
                values: block_heights(shape, noise_from),
                nodata: Some(-99),
                rows_per_strip: 17,
                epsg: 25832,
            };
            std::fs::write(folder.join(&format!("{name}.tif")), tiff.bytes()).unwrap();
        }
        let document = |scene: &str, options: &str| {
            let command = format!("map {scene}.tif --uav 300311.5,4999741,93 {options} -o m.tif -o - --overwrite -q");
            folder.type_in(&command).done().json()
        };
        let ray = document("cells", "--method ray");
        assert_eq!(document("runs", "")["method"], method);
        let mut n = 0;
        for scene in ["runs", "cells"] {
            for options in
                ["-j 1", "-j 2 --tif-layout plain", "-j 7", "--method sweep", "--layers margin", "--nodata-as block"]
            {
                let found = document(scene, options);
                if options.contains("block") {
                    assert_eq!(found["digest"], document("cells", "--method ray --nodata-as block")["digest"]);
                    continue;
                }
                assert_eq!((&found["digest"], &found["sites"]), (&ray["digest"], &ray["sites"]), "{scene} {options}");
                n += 1;
            }
            // A mask that is all there is to write is decided in strips.
            for threads in ["1", "2", "5"] {
                let at = "--uav 300311.5,4999741,93 --tif-layout plain";
                folder.type_in(&format!("map {scene}.tif {at} -o alone.tif -j {threads} --overwrite -q")).done();
                let bytes = folder.read("alone.tif");
                let mask = &bytes[8..8 + shape.0 * shape.1];
                let n_los = mask.iter().filter(|class| **class == 1).count();
                assert_eq!(Some(n_los as u64), ray["sites"][0]["los"].as_u64(), "{scene}, {threads} threads");
                n += 1;
            }
        }
        assert_eq!(n, 16);
    }
}
