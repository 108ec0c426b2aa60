//! Scenes whose heights are drawn from their errors: they are the scenes built anew, and their intervals cover what they say.

use skyshed_core::city::{Footprint, Ground};
use skyshed_core::coverage::{Control, HeightErrors, MapOptions, Mapper, Receivers, RedrawnHeights};
use skyshed_core::raster::{GeoRef, Raster};

use crate::curvature::block_model;
use crate::height_errors::{N, houses, options, p_los, raster_of, seen};
use crate::invariants::{uav_at, vector_field};
use crate::referee::over_seeds;
use crate::support::{Random, is_long, raster_field};

/// What a redrawn scene counts is what the scene built anew counts, receivers on roofs as well.
#[test]
fn redrawn_maps_are_those_of_towns_built_anew() {
    let count = over_seeds(if is_long() { 1000 } else { 200 }, 355, |seed, random, count| {
        let houses = houses(random);
        // Between the houses ground hides receivers as well.
        let is_built = |cell: usize| {
            let [x, y] = [cell % N, N - 1 - cell / N].map(|k| i32::try_from(k).unwrap() * 1024 + 512);
            houses.iter().any(|of| {
                let (low, high) = (of.polygons[0][0][0], of.polygons[0][0][2]);
                low[0] < x && x < high[0] && low[1] < y && y < high[1]
            })
        };
        let hill = |cell: usize| if is_built(cell) { 0 } else { random.choose(&[0, 0, 2048, 6144]) };
        let hills: Vec<i32> = (0..N * N).map(hill).collect();
        let is_flat = random.chance(60);
        let ground = || match is_flat {
            true => Ground::Flat(0),
            false => Ground::Terrain(Raster::new(
                GeoRef::new((0.0, N as f64), (1.0, 1.0), (N, N), None).unwrap(),
                hills.clone(),
            )),
        };
        let field = vector_field(houses.clone(), ground(), N);
        let [x, y] = [(); 2].map(|()| random.below(N) as f64 + 0.5);
        let uavs = [(); 2].map(|()| uav_at(&field, x, y, random.choose(&[20, 30, 48]) * 1024));
        let asked = options(random, &uavs[0]);
        let errors = HeightErrors::same(random.choose(&[0.0, 0.3]), random.choose(&[0.0, 0.4]));
        let heights = RedrawnHeights::of(&field, &errors, None, seed).unwrap();
        let mapper = Mapper::new(&field, &asked).unwrap();
        let found = mapper.redrawn(&uavs, &heights, 4, &Control::default()).unwrap();
        for draw in 0..4_u32 {
            let errors = heights.errors(draw);
            let redrawn = |(of, error): (&Footprint, &i32)| Footprint { top: of.top + error, ..of.clone() };
            let drawn = vector_field(houses.iter().zip(&errors).map(redrawn).collect(), ground(), N);
            for (k, uav) in uavs.iter().enumerate() {
                let wanted = seen(&drawn, uav, &asked);
                let counted = (found.receivers[k], found.los[draw as usize][k]);
                assert_eq!(
                    counted,
                    (wanted.receivers.count(), wanted.los.count()),
                    "seed {seed} {asked:?}, {errors:?}"
                );
                count.los += wanted.los.count();
                count.links += wanted.receivers.count();
            }
        }
    });
    count.assert_both(10_000);
}

/// Of towns drawn from the errors, P_LoS of as many as the interval says is within it; and their mean is that of the probabilities.
#[test]
fn intervals_cover_what_they_say() {
    let n_trials = if is_long() { 1000 } else { 200 };
    let (mut covered, mut n) = (0_u32, 0_u32);
    for (of, errors) in [HeightErrors::same(1.0, 0.0), HeightErrors::same(0.5, 0.8)].iter().enumerate() {
        let mut random = Random(356 + of as u64);
        let higher = |of: Footprint| Footprint { top: of.top + 8 * 1024, ..of };
        let field = vector_field(houses(&mut random).into_iter().map(higher).collect(), Ground::Flat(0), N);
        let uav = uav_at(&field, 17.5, 19.5, 60 * 1024);
        let mapper = Mapper::new(&field, &MapOptions::default()).unwrap();
        let redrawn = |seed: u64, n: u32| {
            let heights = RedrawnHeights::of(&field, errors, None, seed).unwrap();
            mapper.redrawn(std::slice::from_ref(&uav), &heights, n, &Control::default()).unwrap()
        };
        let mut sum = 0.0;
        for trial in 0..n_trials {
            let interval = redrawn(1000 + trial, 200).interval(0, 0.95);
            let truth = redrawn(9_000_000 + trial, 1);
            let p = truth.los[0][0] as f64 / truth.receivers[0] as f64;
            sum += p;
            covered += u32::from(interval.0 <= p && p <= interval.1);
            n += 1;
        }
        let p_los: Vec<f32> = p_los(&field, &uav, &MapOptions::default(), errors);
        let known = p_los.iter().filter(|p| !p.is_nan());
        let (total, n_receivers) = known.fold((0.0, 0_u32), |(sum, n), p| (sum + f64::from(*p), n + 1));
        let all = redrawn(5, 4000);
        let shares = all.los.iter().map(|of| of[0] as f64 / all.receivers[0] as f64);
        let (mean, squares) = shares.fold((0.0, 0.0), |(m, s), p| (m + p / 4000.0, s + p * p / 4000.0));
        let standard_error = ((squares - mean * mean) / 4000.0).sqrt();
        let expected = total / f64::from(n_receivers);
        assert!((mean - expected).abs() < 4.0 * standard_error, "{mean} {expected} {standard_error}");
        assert!(standard_error > 1e-5 && sum > 0.0);
    }
    let share = f64::from(covered) / f64::from(n);
    assert!(
        if is_long() { (0.93..=0.97).contains(&share) } else { (0.91..=0.98).contains(&share) },
        "{covered} of {n}"
    );
}

#[test]
fn redrawn_rasters_are_those_built_anew_with_errors_of_one_size_everywhere() {
    let mut random = Random(357);
    let tops: Vec<i32> = (0..N * N)
        .map(|_| if random.chance(30) { i32::try_from(random.within(20_000, 30_000)).unwrap() } else { 0 })
        .collect();
    let field = raster_of(tops.clone());
    let uav = uav_at(&field, 12.5, 20.5, 60 * 1024);
    let n_draws = 2000_u32;
    for receivers in [Receivers::Ground, Receivers::All] {
        let asked = MapOptions { receivers, ..MapOptions::default() };
        let mapper = Mapper::new(&field, &asked).unwrap();
        let heights = RedrawnHeights::of(&field, &HeightErrors::same(1.5, 0.5), Some(5.0), 7).unwrap();
        let found = mapper.redrawn(std::slice::from_ref(&uav), &heights, 5, &Control::default()).unwrap();
        for draw in 0..5_u32 {
            let errors = heights.errors(draw);
            let drawn = raster_of(tops.iter().zip(&errors).map(|(top, error)| top + error).collect());
            let wanted = seen(&drawn, &uav, &asked);
            let counted = (found.receivers[0], found.los[draw as usize][0]);
            assert_eq!(counted, (wanted.receivers.count(), wanted.los.count()), "{receivers:?}, draw {draw}");
        }
    }
    // Of each cell, and of pairs of them some cells apart.
    let heights = RedrawnHeights::of(&field, &HeightErrors::same(2.0, 0.0), Some(5.0), 8).unwrap();
    let buildings: Vec<usize> = (0..N * N).filter(|cell| tops[*cell] > 0).collect();
    let mut squares = vec![0.0; N * N];
    let mut products = [(0.0, 0_u32); 2];
    for draw in 0..n_draws {
        let errors = heights.errors(draw);
        assert!((0..N * N).all(|cell| tops[cell] > 0 || errors[cell] == 0));
        let m = |cell: usize| f64::from(errors[cell]) / 1024.0;
        buildings.iter().for_each(|cell| squares[*cell] += m(*cell).powi(2) / f64::from(n_draws));
        for pair in buildings.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|cell| (cell / N, cell % N));
            if a.0 == b.0 && b.1 - a.1 == 1 {
                products[0] = (products[0].0 + m(pair[0]) * m(pair[1]), products[0].1 + 1);
            }
        }
        let (first, last) = (buildings[0], buildings[buildings.len() - 1]);
        products[1] = (products[1].0 + m(first) * m(last), products[1].1 + 1);
    }
    for cell in &buildings {
        // The standard error of a variance of 4 over so many draws is 0.13.
        assert!((squares[*cell] - 4.0).abs() < 0.65, "{cell}: {}", squares[*cell]);
    }
    let correlation = |k: usize| products[k].0 / f64::from(products[k].1) / 4.0;
    assert!(correlation(0) > 0.85 && correlation(1).abs() < 0.12, "{} {}", correlation(0), correlation(1));
}

#[test]
fn blocks_of_one_height_share_an_error() {
    let field = block_model(&mut Random(358));
    let heights = RedrawnHeights::of(&field, &HeightErrors::same(3.0, 0.0), None, 9).unwrap();
    let errors = heights.errors(3);
    let (tops, n_cols) = (field.columns().unwrap().tops().to_vec(), field.grid().n_cols());
    let is_building = |cell: usize| field.cells().building.contains(cell / n_cols, cell % n_cols);
    let mut shared = 0;
    let mut seen = std::collections::HashSet::new();
    for cell in 0..tops.len() {
        if !is_building(cell) {
            assert_eq!(errors[cell], 0);
            continue;
        }
        seen.insert(errors[cell]);
        for near in [cell.wrapping_sub(1), cell.wrapping_sub(n_cols)] {
            if near < tops.len() && is_building(near) && tops[near] == tops[cell] && cell % n_cols > 0 {
                assert_eq!(errors[near], errors[cell]);
                shared += 1;
            }
        }
    }
    assert!(shared > 10_000 && seen.len() > 50, "{shared} {}", seen.len());
}

#[test]
fn parts_of_a_raster_have_the_errors_of_the_whole() {
    let mut random = Random(360);
    let (n_rows, n_cols) = (60, 80);
    for is_block_model in [true, false] {
        // Blocks of 6 × 6 cells, of which a part cuts none.
        let tops: Vec<i32> = (0..n_rows * n_cols)
            .map(|cell| {
                let (row, col) = (cell / n_cols, cell % n_cols);
                let is_house = row % 10 < 6 && col % 10 < 6;
                let top = if is_block_model { 9000 + 1024 * (row / 10 + col / 10) } else { random.index(9000, 30_000) };
                if is_house { i32::try_from(top).unwrap() } else { 0 }
            })
            .collect();
        let grid = GeoRef::new((0.0, n_rows as f64), (1.0, 1.0), (n_rows, n_cols), None).unwrap();
        let window = skyshed_core::raster::CellWindow { row: 20, col: 30, n_rows: 26, n_cols: 36 };
        let part: Vec<i32> = (0..window.n_rows)
            .flat_map(|row| &tops[(window.row + row) * n_cols + window.col..][..window.n_cols])
            .copied()
            .collect();
        let whole = raster_field(Raster::new(grid.clone(), tops), Ground::Flat(0));
        let part = raster_field(Raster::new(grid.part(window), part), Ground::Flat(0));
        let errors = HeightErrors::same(2.0, 0.5);
        let [of_whole, of_part] = [&whole, &part].map(|f| RedrawnHeights::of(f, &errors, None, 3).unwrap().errors(7));
        let mut seen = std::collections::HashSet::new();
        for (cell, error) in of_part.iter().enumerate() {
            let (row, col) = (window.row + cell / window.n_cols, window.col + cell % window.n_cols);
            assert_eq!(*error, of_whole[row * n_cols + col], "{row} {col}, block model: {is_block_model}");
            seen.insert(*error);
        }
        assert!(if is_block_model { (8..=17).contains(&seen.len()) } else { seen.len() > 100 }, "{}", seen.len());
    }
}
