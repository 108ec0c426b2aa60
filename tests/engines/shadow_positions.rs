//! `shadow` seen from the ground: which UAV positions of a lattice a receiver sees, through nested tiles of receivers, is
//! what `ray` says of every link; and the counts of many UAVs taken together are those of each alone.

#![expect(clippy::unwrap_used, clippy::cast_possible_wrap, reason = "a test stops at the first surprise")]

use std::sync::atomic::{AtomicU64, Ordering};

use skyshed_core::city::Ground;
use skyshed_core::coverage::{Control, MapOptions, Mapper, Receivers, Uav, UavGrid};
use skyshed_core::height_field::HeightField;
use skyshed_core::los::{InView, MethodChoice, ReceiverTile, ShadowGrid, UavPositions, prisms_los};
use skyshed_core::quantity::{Height, LatticePoint, VOID};
use skyshed_core::raster::{BitGrid, GeoRef, Raster};
use skyshed_core::simd::simd_levels;
use skyshed_study::placement::{CandidateRules, Candidates, PlaceGrid, Scorer, Weights, scores, scores_over_grid};

use crate::invariants::{raster_town, vector_town};
use crate::referee::{Count, check_cells, over_seeds};
use crate::shadow::{scaled_scene, tiny_field, tiny_uav};
use crate::shapes::moved;
use crate::support::{ENVIRONMENTS, Random, cells_where, city, is_long, raster_field};
use crate::translation::prisms_of;

/// The box around some receivers, sometimes a little larger.
fn tile_of(random: &mut Random, receivers: &[LatticePoint]) -> ReceiverTile {
    let spare = random.choose(&[0, 0, 1, 700]);
    let range = |of: fn(&LatticePoint) -> i64| {
        let all = || receivers.iter().map(of);
        (all().min().unwrap() - spare, all().max().unwrap() + spare)
    };
    let ((west, east), (south, north)) = (range(|r| r.x), range(|r| r.y));
    ReceiverTile { bounds: [west, south, east, north], heights: range(|r| r.z) }
}

/// Asserts that every receiver sees the positions that `ray` says it sees. Of the links that are counted `asked` are those
/// whose position was not even in view.
fn compare(
    positions: &UavPositions<'_>,
    (xs, ys): (&[i64], &[i64]),
    asked: &BitGrid,
    (in_view, receivers): (&InView, &[LatticePoint]),
    context: &(impl Fn() -> String + Sync),
) -> Count {
    let compare_one = |receiver: &LatticePoint| {
        let mut found = in_view.positions.clone();
        positions.los(in_view, *receiver, &mut found);
        let ray = |row: usize, col: usize| {
            let uav = LatticePoint { x: xs[col], y: ys[row], z: positions.z };
            // A link of no length is never blocked; of one inside of a building nobody asks.
            let above = LatticePoint { z: uav.z + 1, ..uav };
            let is_inside = uav == *receiver && !prisms_los(positions.prisms, uav, above);
            if is_inside { found.contains(row, col) } else { prisms_los(positions.prisms, uav, *receiver) }
        };
        let count = check_cells(&found, asked, ray, || format!("from {receiver:?}: {}", context()));
        Count { asked: asked.count() - in_view.positions.count(), ..count }
    };
    receivers.iter().map(compare_one).sum()
}

#[test]
fn what_a_receiver_sees_is_what_ray_says_where_everything_coincides() {
    let levels = simd_levels();
    let count = over_seeds(if is_long() { 300_000 } else { 5_000 }, 0xA11, |seed, random, count| {
        let scene = scaled_scene(random);
        if prisms_of(&scene).pieces().is_empty() {
            return;
        }
        let mut field = tiny_field(random, &scene);
        if seed % 40 == 0 {
            // More than a word of columns and than a tile of rows.
            let (n_rows, n_cols) = (random.choose(&[3, 65, 70_usize]), random.choose(&[65, 127, 128, 140_usize]));
            let cell = random.choose(&[64, 100, 128]);
            field.xs = (0..n_cols).map(|k| k as i64 * cell - 512).collect();
            field.ys = (0..n_rows).rev().map(|k| k as i64 * cell - 512).collect();
            field.wanted = BitGrid::full(n_rows, n_cols);
        }
        let level = random.choose(&levels);
        // Mostly above the roofs and the receivers, but anything goes.
        let top = scene.iter().map(|prism| prism.top).max().unwrap();
        let anywhere = random.within(0, 40) * 512;
        let z = random.choose(&[top + 3000, top + 1, top, 6 * 1024, 20 * 1024, anywhere]);
        let mut receivers: Vec<LatticePoint> = (0..6).map(|_| tiny_uav(random, &scene, &field)).collect();
        if random.chance(60) {
            // Neighbors, as the cells of a tile are.
            let LatticePoint { x, y, z } = receivers[0];
            let steps = random.choose(&[1, 256, 512, 1024]);
            for (k, receiver) in receivers.iter_mut().enumerate() {
                let k = k as i64;
                *receiver = LatticePoint { x: x + k % 3 * steps, y: y + k / 3 * steps, z };
            }
        }
        // As wide as a scene can be.
        let stretch = if seed % 7 == 0 { random.choose(&[7919, 8192]) } else { 1 };
        let scene = moved(&scene, |[x, y]| [x * stretch, y * stretch], |top| top);
        receivers.iter_mut().for_each(|r| (r.x, r.y) = (r.x * stretch, r.y * stretch));
        field.xs.iter_mut().chain(&mut field.ys).for_each(|v| *v *= stretch);
        let prisms = prisms_of(&scene);
        let grid = ShadowGrid::new(field.xs.clone(), field.ys.clone());
        let positions = UavPositions { prisms: &prisms, casters: prisms.casters(), grid: &grid, z, level };
        let context = || format!("seed {seed}, {scene:?}");
        let whole = positions.anywhere(&field.wanted);
        let large = positions.from_tile(&tile_of(random, &receivers), &whole);
        let small = positions.from_tile(&tile_of(random, &receivers[..2]), &large);
        let at = (field.xs.as_slice(), field.ys.as_slice());
        for (in_view, n) in [(&whole, 1), (&large, 6), (&small, 2)] {
            *count += compare(&positions, at, &field.wanted, (in_view, &receivers[..n]), &context);
        }
    });
    count.assert_both(4_000_000);
    assert!(count.asked > (count.links - count.los) / 20, "tiles leave nothing out: {count:?}");
}

/// The UAVs of a grid of places, with the numbers of their places.
fn uavs_of(field: &HeightField, places: &PlaceGrid, height: Height) -> Vec<(usize, Uav)> {
    let kept = Candidates::of(&places.spots(&[height]), field, &CandidateRules::default()).unwrap().kept;
    kept.into_iter().map(|candidate| (candidate.spot.place, candidate.uav)).collect()
}

/// The UAVs as a grid, where they are one.
fn grid_of(mapper: &Mapper<'_>, places: &PlaceGrid, uavs: &[(usize, Uav)]) -> Option<UavGrid> {
    mapper.uav_grid(&places.grid, uavs.iter().map(|(place, uav)| (*place, uav)))
}

/// Asserts that UAVs counted together see what each sees by rays.
pub(crate) fn compare_counts(field: &HeightField, places: &PlaceGrid, height: Height, options: &MapOptions) -> u128 {
    let uavs = uavs_of(field, places, height);
    let mapper = Mapper::new(field, options).unwrap();
    let by_rays = MapOptions { method: MethodChoice::Ray, ..options.clone() };
    let by_rays = Mapper::new(field, &by_rays).unwrap();
    let grid = grid_of(&mapper, places, &uavs).unwrap();
    let n_cols = field.grid().n_cols();
    let weight = |cell: usize| (cell / n_cols * 3 + cell % 2) as u128;
    let alone = mapper.count_grid(&grid, &|_| 1, &Control::default()).unwrap().unwrap();
    let weighed = mapper.count_grid(&grid, &weight, &Control::default()).unwrap().unwrap();
    let sum = |cells: &BitGrid| -> u128 { cells.cells().map(|(row, col)| weight(row * n_cols + col)).sum() };
    // All are compared with the count of each, some of them with rays.
    let every = uavs.len().div_ceil(150);
    let mut all = vec![0; places.grid.n_cells()];
    for (k, (place, uav)) in uavs.iter().enumerate() {
        all[*place] = u128::from(mapper.seen_from(uav).unwrap().count().1);
        if k % every == 0 {
            let seen = by_rays.seen_from(uav).unwrap().seen().los;
            let expected = (seen.count().into(), sum(&seen));
            assert_eq!((alone[*place], weighed[*place]), expected, "place {place}, {height:?}, {options:?}");
        }
    }
    assert_eq!(alone, all, "{height:?}, {options:?}");
    alone.iter().sum()
}

#[test]
fn uavs_counted_together_see_what_each_sees_alone() {
    let mut random = Random(71);
    let mut fields: Vec<HeightField> = [21, 28, 70].map(|n| vector_town(&mut random, n)).into_iter().collect();
    fields.extend(ENVIRONMENTS.map(|name| city(name, 150.0, 2.0, 5)));
    let mut seen = 0;
    for field in &fields {
        let side = field.grid().x_max() - field.grid().x_min();
        let within = cells_where((field.grid().n_rows(), field.grid().n_cols()), |_, _| random.chance(40));
        for (receivers, within, radius) in [
            (Receivers::Ground, None, None),
            (Receivers::All, None, Some(side / 4.0)),
            (Receivers::Roof, Some(within), None),
        ] {
            let options = MapOptions { receivers, within, radius, ..MapOptions::default() };
            for height in [Height::AboveGround(3.0), Height::AboveGround(9.5), Height::AboveDatum(60.0)] {
                let places = PlaceGrid::over(field.grid(), side / random.within(7, 12) as f64).unwrap();
                seen += compare_counts(field, &places, height, &options);
            }
        }
    }
    assert!(seen > 1_000_000, "{seen}");
}

#[test]
fn more_places_than_a_word_and_a_tile_hold_are_told_apart() {
    let field = city("urban", 200.0, 4.0, 6);
    let places = PlaceGrid::over(field.grid(), 1.5).unwrap();
    assert!(places.grid.n_rows() > 130 && !places.grid.n_cols().is_multiple_of(64));
    for radius in [None, Some(45.0)] {
        let options = MapOptions { radius, ..MapOptions::default() };
        let mapper = Mapper::new(&field, &options).unwrap();
        let uavs = uavs_of(&field, &places, Height::AboveGround(40.0));
        let grid = grid_of(&mapper, &places, &uavs).unwrap();
        assert!(mapper.is_counted_sooner(&grid));
        assert!(compare_counts(&field, &places, Height::AboveGround(40.0), &options) > 1_000_000);
    }
}

#[test]
fn scores_over_a_grid_are_those_of_each_candidate() {
    let field = city("urban", 200.0, 4.0, 7);
    let places = PlaceGrid::over(field.grid(), if is_long() { 2.5 } else { 4.0 }).unwrap();
    // The second height is above the datum by ground, the third differs from roof to roof.
    let heights = [Height::AboveGround(45.0), Height::AboveDatum(60.0), Height::AboveRoof(3.0)];
    let kept = Candidates::of(&places.spots(&heights), &field, &CandidateRules::default()).unwrap().kept;
    // With holes.
    let kept: Vec<_> = kept.into_iter().filter(|candidate| candidate.spot.place % 7 != 3).collect();
    let n_cells = field.grid().n_cells();
    let weights: Vec<f64> = (0..n_cells).map(|k| f64::from(u32::try_from(k % 5).unwrap())).collect();
    let weights = Weights::new(&weights, field.grid().n_cols()).unwrap();
    for radius in [None, Some(60.0)] {
        let options = MapOptions { radius, ..MapOptions::default() };
        let mapper = Mapper::new(&field, &options).unwrap();
        let of_height = |z: i64| kept.iter().filter(move |candidate| candidate.uav.station.z == z);
        let is_together = |z: i64| {
            let uavs = of_height(z).map(|candidate| (candidate.spot.place, &candidate.uav));
            mapper.is_counted_sooner(&mapper.uav_grid(&places.grid, uavs).unwrap())
        };
        assert!(is_together(45 * 1024) && is_together(60 * 1024));
        assert!(kept.iter().any(|candidate| !is_together(candidate.uav.station.z)), "both ways are taken");
        for weights in [None, Some(&weights)] {
            let scorer = Scorer::new(&mapper, weights);
            let control = Control::default();
            let found = scores_over_grid(&scorer, &places, &kept, &control).unwrap();
            let uavs: Vec<&Uav> = kept.iter().map(|candidate| &candidate.uav).collect();
            assert_eq!(found, scores(&scorer, &uavs, &Control::default()).unwrap());
            assert_eq!(control.done.into_inner(), kept.len() as u64, "progress ends at the number of candidates");
        }
    }
}

#[test]
fn a_grid_of_uavs_has_one_height_and_prisms_alone_below() {
    let mut random = Random(72);
    let (vector, raster) = (vector_town(&mut random, 21), raster_town(&mut random, 21));
    let options = MapOptions::default();
    let places = PlaceGrid::over(vector.grid(), 3.0).unwrap();
    let mapper = Mapper::new(&vector, &options).unwrap();
    let mut uavs = uavs_of(&vector, &places, Height::AboveGround(20.0));
    let is_grid = |uavs: &[(usize, Uav)]| grid_of(&mapper, &places, uavs).is_some();
    assert!(is_grid(&uavs) && !is_grid(&[]));
    uavs[1].1.station.z += 1;
    assert!(!is_grid(&uavs), "two heights");
    uavs[1].1.station.z -= 1;
    uavs[1].0 += 1;
    assert!(!is_grid(&uavs), "a UAV over another place");

    let on_raster = Mapper::new(&raster, &options).unwrap();
    let uavs = uavs_of(&raster, &places, Height::AboveDatum(40.0));
    let grid = grid_of(&on_raster, &places, &uavs).unwrap();
    assert!(!on_raster.is_counted_sooner(&grid));
    assert_eq!(on_raster.count_grid(&grid, &|_| 1, &Control::default()).unwrap(), None);
}

/// A block model with holes, and blocks from `least` \[1/1024 m\] on above flat ground at 0.
fn block_model(random: &mut Random, least: usize) -> HeightField {
    let (n_rows, n_cols) = (540, 560);
    let mut cells = vec![0; n_rows * n_cols];
    for _ in 0..60 {
        let (row, col) = (random.below(n_rows), random.below(n_cols));
        let (height, width) = (random.index(4, 44), random.index(4, 44));
        let top = if random.chance(10) { VOID } else { i32::try_from(random.index(least, 60_000)).unwrap() };
        for row in row..(row + height).min(n_rows) {
            cells[row * n_cols + col..][..width.min(n_cols - col)].fill(top);
        }
    }
    let grid = GeoRef::new((20.0, 900.0), (1.0, 1.0), (n_rows, n_cols), None).unwrap();
    raster_field(Raster::new(grid, cells), Ground::Flat(0))
}

#[test]
fn uavs_over_a_block_model_are_counted_as_one_by_one() {
    let mut random = Random(74);
    for (height, receivers, rx_height) in [
        (Height::AboveDatum(30.0), Receivers::Ground, 1536),
        (Height::AboveDatum(90.0), Receivers::Ground, 0),
        (Height::AboveDatum(1.0), Receivers::Ground, 1024),
    ] {
        let field = block_model(&mut random, 300);
        assert!(field.plateaus().is_some());
        let options = MapOptions { receivers, rx_height, radius: Some(90.0), ..MapOptions::default() };
        let places = PlaceGrid::over(field.grid(), 31.0).unwrap();
        assert!(compare_counts(&field, &places, height, &options) > 0);
    }
    // On roofs receivers are at many heights; below a step of the ground, and above the UAVs, their own cells matter.
    let field = block_model(&mut random, 100);
    let places = PlaceGrid::over(field.grid(), 31.0).unwrap();
    for (height, receivers, rx_height) in
        [(70.0, Receivers::All, 1536), (10.0, Receivers::Ground, 20_480), (70.0, Receivers::Ground, 0)]
    {
        let options = MapOptions { receivers, rx_height, ..MapOptions::default() };
        let mapper = Mapper::new(&field, &options).unwrap();
        let grid = grid_of(&mapper, &places, &uavs_of(&field, &places, Height::AboveDatum(height))).unwrap();
        assert_eq!(mapper.count_grid(&grid, &|_| 1, &Control::default()).unwrap(), None);
    }
}

#[test]
fn whoever_wants_to_stop_is_heard() {
    let field = city("urban", 400.0, 2.0, 8);
    let places = PlaceGrid::over(field.grid(), 20.0).unwrap();
    let options = MapOptions::default();
    let mapper = Mapper::new(&field, &options).unwrap();
    let uavs = uavs_of(&field, &places, Height::AboveGround(40.0));
    let grid = grid_of(&mapper, &places, &uavs).unwrap();
    let control = Control::default();
    let n_asked = AtomicU64::new(0);
    // The first receiver that is looked at stops the count; tiles that are begun look at no more than their own.
    let weight = |_: usize| {
        n_asked.fetch_add(1, Ordering::Relaxed);
        control.stop.store(true, Ordering::Relaxed);
        1
    };
    let error = mapper.count_grid(&grid, &weight, &control).unwrap_err();
    assert_eq!(error.kind(), skyshed_core::error::ErrorKind::Interrupted);
    let n_threads = rayon::current_num_threads() as u64;
    let n_asked = n_asked.into_inner();
    assert!(n_asked <= n_threads * 64 * 64, "{n_asked} receivers of {}", mapper.receiver_cells().count());
    assert!(mapper.receiver_cells().count() > 20_000);
}
