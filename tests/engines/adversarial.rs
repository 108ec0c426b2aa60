//! Links on which engines break, every one compared with the oracle: never switched off.
//!
//! Whole families are walked through: all ends on a coarse lattice, over all patterns of columns or a catalogue of
//! footprints, so that rays run along walls, through corners and just at roof height by the thousand. Around every tie
//! the neighboring lattice points are tried as well.

#![expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "small numbers")]

use skyshed_core::los;

use crate::oracle::{Columns, P3, Prism};
use crate::referee::{Count, Footprints, Raster, Scene, over_seeds};
use crate::shapes::{
    M, around, at_height, block, catalogue, cross, moved, prism, random_columns, random_end, random_prisms, star,
};
use crate::support::{Random, is_long};
use crate::translation::{columns_of, point};

/// All points of a square lattice, `low..=high` along both axes, times `step`.
fn lattice(low: i64, high: i64, step: i64) -> Vec<[i64; 2]> {
    (low..=high).flat_map(|x| (low..=high).map(move |y| [x * step, y * step])).collect()
}

/// Pattern `k` of `n_cells` heights out of `choices`.
fn pattern(mut k: usize, n_cells: usize, choices: &[Option<i64>]) -> Vec<Option<i64>> {
    let mut digit = || {
        let d = k % choices.len();
        k /= choices.len();
        choices[d]
    };
    (0..n_cells).map(|_| digit()).collect()
}

// ---------------------------------------------------------------------------------------------------------------------
// Rasters.

#[test]
fn all_links_between_half_cells_over_all_patterns_of_four_columns() {
    // 2 × 2 cells, each nodata, 0 or 1 m, and ends on a lattice of half cells that reaches half a cell beyond.
    let heights = [(1, 1), (2, 0), (0, 2), (3, 1), (2, 2), (0, 0)];
    let count = over_seeds(3_u64.pow(4), 0, |k, _, count| {
        let k = k as usize;
        let raster = Raster::new(Columns { n_cols: 2, n_rows: 2, heights: pattern(k, 4, &[Some(M), None, Some(0)]) });
        let points = lattice(-1, 5, M / 2);
        for (i, &uav) in points.iter().enumerate() {
            for (j, &receiver) in points.iter().enumerate() {
                let z = heights[(i + 3 * j + k) % heights.len()];
                raster.check(at_height(uav, z.0 * M / 2), at_height(receiver, z.1 * M / 2), count);
            }
        }
    });
    count.assert_both(190_000);
}

#[test]
fn links_between_half_cells_over_all_patterns_of_nine_columns_and_their_neighbors() {
    let every = if is_long() { 4 } else { 16 };
    let neighbors = if is_long() { 26 } else { 6 };
    let heights = [(1, 1), (2, 0), (0, 2), (4, 0), (3, 1), (2, 2)];
    let count = over_seeds(512, 0, |k, random, count| {
        let k = k as usize;
        let raster = Raster::new(Columns { n_cols: 3, n_rows: 3, heights: pattern(k, 9, &[Some(M), Some(0)]) });
        let points = lattice(0, 6, M / 2);
        for (i, &uav) in points.iter().enumerate() {
            for (j, &receiver) in points.iter().enumerate() {
                if !(i * 49 + j + k).is_multiple_of(every) {
                    continue;
                }
                let z = random.choose(&heights);
                let (uav, receiver) = (at_height(uav, z.0 * M / 2), at_height(receiver, z.1 * M / 2));
                raster.check(uav, receiver, count);
                if (i + j) % 4 == 0 {
                    raster.check_tie(uav, receiver, neighbors, random, count);
                }
            }
        }
    });
    count.assert_both(80_000);
    assert!(count.ties > 1_000, "{count:?}");
}

#[test]
fn random_links_over_random_columns_and_their_neighbors_at_every_tie() {
    let n = if is_long() { 400_000 } else { 12_000 };
    let count = over_seeds(n, 0, |_, random, count| {
        let raster = Raster::new(random_columns(random));
        for _ in 0..3 {
            let (uav, receiver) = (random_end(random, &raster.oracle), random_end(random, &raster.oracle));
            raster.check(uav, receiver, count);
            raster.check_tie(uav, receiver, 12, random, count);
        }
    });
    count.assert_both(3 * n);
    assert!(count.ties > n / 100, "{count:?}");
}

#[test]
fn rows_columns_and_single_cells_are_seen_from_all_eight_sides() {
    let count = over_seeds(1500, 0xE1, |seed, random, count| {
        let (n_cols, n_rows) = [(1, 1), (1, 7), (7, 1)][seed as usize % 3];
        let choices = [None, Some(0), Some(M), Some(3 * M)];
        let columns = (0..n_cols * n_rows).map(|_| random.choose(&choices)).collect();
        let raster = Raster::new(Columns { n_cols, n_rows, heights: columns });
        // Below, on, inside and beyond both borders along each axis.
        let along = |n: usize| {
            let edge = i64::try_from(n).unwrap() * M;
            [-2 * M, -M, -1, 0, 1, M / 2, edge / 2, edge - 1, edge, edge + 1, edge + M]
        };
        let mut end =
            || at_height([random.choose(&along(n_cols)), random.choose(&along(n_rows))], random.within(0, 8) * M / 2);
        let links: Vec<(P3, P3)> = (0..40).map(|_| (end(), end())).collect();
        for (uav, receiver) in links {
            raster.check_all(uav, receiver, count);
        }
    });
    count.assert_both(60_000);
}

#[test]
fn long_links_at_extreme_heights_over_a_raster_are_exact() {
    // 2^16 cells in a row (links up to 2^26 steps), columns near ±2^25, the blocking top of nodata, ends at both borders.
    let n = 1 << 16;
    let top = (1 << 25) - 3;
    let mut columns = vec![Some(-(1 << 25)); n];
    for (k, cell) in columns.iter_mut().enumerate() {
        match k % 4099 {
            0 => *cell = Some(top - i64::try_from(k).unwrap()),
            1 => *cell = None,
            _ => {}
        }
    }
    columns[40_000] = Some(1 << 24);
    // The oracle looks at every cell; so it gets the row of those that matter, as blocks of their own.
    let prisms: Vec<Prism> = columns
        .iter()
        .enumerate()
        .filter(|(_, h)| h.is_some_and(|h| h > -(1 << 25)))
        .map(|(k, h)| {
            let west = i64::try_from(k).unwrap() * M;
            block(west, 0, west + M, M, h.unwrap())
        })
        .collect();
    let engine = columns_of(&Columns { n_cols: n, n_rows: 1, heights: columns });
    let footprints = Footprints::new(prisms);
    let (mut random, mut count) = (Random(5), Count::default());
    let far = i64::try_from(n).unwrap() * M;
    for k in 0..if is_long() { 20_000 } else { 1_500 } {
        let height = |random: &mut Random| random.choose(&[top, top, top, top - 70_000, 1 << 24, -(1 << 24)]);
        // Only cells without a prism of their own, so that no exemption plays a part.
        let own = 2 + random.within(0, 4) + 4099 * random.within(0, 14);
        let receiver = [own * M + random.within(1, M - 1), random.within(0, M), height(&mut random)];
        let x = random.choose(&[0, 1, far - 1, far, 4099 * M, 8198 * M + 1]);
        let uav = [x, random.within(0, M), height(&mut random) + random.within(-2, 2)];
        let los = footprints.check(uav, receiver, &mut count);
        assert_eq!(los::columns_los(&engine, point(uav), point(receiver)), los, "link {k}: {uav:?} {receiver:?}");
    }
    assert!(count.links >= 1_500 && count.los > 100 && count.links - count.los > 100, "{count:?}");
}

// ---------------------------------------------------------------------------------------------------------------------
// Footprints.

/// Compares links between the points of a lattice over a scene on 0..=6, `every`-th of them, neighbors of ties too.
fn sweep_scene(prisms: &[Prism], unit: i64, lift: i64, every: u64, random: &mut Random) -> Count {
    let scene = Footprints::new(moved(prisms, |p| p.map(|c| c * unit), |top| top * lift));
    let heights = [(2, 2), (1, 1), (3, 1), (2, 0), (4, 1), (1, 3), (3, 2), (0, 0)];
    let mut count = Count::default();
    let points = lattice(-1, 7, unit);
    for &uav in &points {
        for &receiver in &points {
            if !random.next().is_multiple_of(every) {
                continue;
            }
            let z = random.choose(&heights);
            let (uav, receiver) = (at_height(uav, z.0 * lift), at_height(receiver, z.1 * lift));
            scene.check(uav, receiver, &mut count);
            if random.chance(15) {
                scene.check_tie(uav, receiver, 8, random, &mut count);
            }
        }
    }
    count
}

#[test]
fn all_links_on_a_coarse_lattice_over_a_catalogue_of_footprints() {
    // With a unit of 4 m every second line of the lattice is a border between buckets.
    let units: &[i64] = if is_long() { &[2, 1024, 4096, 1 << 17] } else { &[4096] };
    let every = if is_long() { 1 } else { 2 };
    let scenes = catalogue();
    let count = over_seeds((units.len() * scenes.len()) as u64, 0, |job, random, count| {
        let (unit, (name, prisms)) = (units[job as usize / scenes.len()], &scenes[job as usize % scenes.len()]);
        *count = sweep_scene(prisms, unit, M, every, random);
        assert!(count.los > 100 && count.links - count.los > 100, "{name}: {count:?}");
    });
    count.assert_both(56_000);
    assert!(count.ties > 800, "{count:?}");
}

#[test]
fn random_footprints_with_collinear_vertices_and_shared_walls() {
    let n = if is_long() { 4_000 } else { 300 };
    let count = over_seeds(n, 0x5EED, |_, random, count| {
        let prisms = random_prisms(random);
        let unit = random.choose(&[1, 512, 4096, 8192]);
        *count = sweep_scene(&prisms, unit, random.choose(&[1, M]), 40, random);
    });
    count.assert_both(100 * n);
}

#[test]
fn large_offsets_and_heights_at_the_ends_of_the_proven_range_are_exact() {
    // Coordinates within ±2^26, differences up to 2^26, tops and ends near ±2^25, neighbors of every end.
    let n = if is_long() { 16_000 } else { 800 };
    let scenes = catalogue();
    let count = over_seeds(n, 0xFA2, |seed, random, count| {
        let prisms =
            if random.chance(70) { scenes[seed as usize % scenes.len()].1.clone() } else { random_prisms(random) };
        let unit = (1 << 23) - random.within(0, 2);
        let shift = [random.choose(&[0, -(1 << 26) + (1 << 23), 1 << 23]), random.choose(&[0, -(1 << 25), 1 << 23])];
        let low = -(1 << 25);
        let lift = random.choose(&[(1 << 24) - 1, 9_999_991, 1]);
        let place = |p: [i64; 2]| [p[0] * unit + shift[0], p[1] * unit + shift[1]];
        // A few vertices move by a step, so that walls are almost shared and almost collinear.
        let mut wobble = Random(seed);
        let mut scene = moved(&prisms, place, |top| low + top.min(4) * lift);
        if let Some(first) = scene.first_mut().filter(|p| p.rings.len() == 1 && p.rings[0].len() <= 4) {
            first.rings[0].iter_mut().for_each(|v| v[0] += wobble.within(-1, 1));
        }
        let scene = Footprints::new(scene);
        for _ in 0..30 {
            let mut end =
                || at_height(place([random.within(0, 7), random.within(0, 7)]), low + random.within(0, 4) * lift);
            let (uav, receiver) = (end(), end());
            for (uav, receiver) in around(uav, receiver, 2, random) {
                scene.check(uav, receiver, count);
            }
            scene.check_heights(uav, receiver, count);
        }
    });
    count.assert_both(60 * n);
}

#[test]
fn needles_slits_and_slivers_one_step_wide() {
    let unit = 300;
    let town = vec![
        block(0, 0, 900, 600, 500),
        block(901, 0, 1800, 600, 700),   // a slit of one step between them
        block(400, 900, 401, 1200, 900), // a needle
        block(401, 900, 402, 1200, 600), // and another at its side
        prism(&[[600, 900], [1500, 901], [600, 902]], 600), // a sliver
        prism(&[[600, 900], [1500, 901], [600, 1500], [599, 1200]], 400), // almost along it
        prism(&[[1200, 1200], [1201, 1200], [1200, 1201]], 800), // the smallest triangle
    ];
    let scene = Footprints::new(town);
    let count = over_seeds(if is_long() { 120 } else { 5 }, 0, |_, random, count| {
        for _ in 0..1000 {
            let xs = [0, 400, 401, 402, 599, 600, 899, 900, 901, 902, 1200, 1201, 1500, 1800, 2 * unit, -unit];
            let ys = [-unit, 0, 1, 600, 900, 901, 902, 1199, 1200, 1201, 1500, 1800];
            let mut end = || [random.choose(&xs), random.choose(&ys), random.within(3, 9) * 100];
            let (uav, receiver) = (end(), end());
            scene.check(uav, receiver, count);
            if random.chance(5) {
                scene.check_heights(uav, receiver, count);
            }
        }
    });
    count.assert_both(5_000);
}

#[test]
fn a_platform_at_twenty_kilometers_sees_through_a_slit_only_along_it() {
    let top = 50 * M;
    let town = vec![block(0, 0, 20 * M, 100 * M, top), block(20 * M + 1, 0, 40 * M, 100 * M, top)];
    let scene = Footprints::new(town);
    let mut count = Count::default();
    let high = 20_000 * M;
    for x in 0..=1 {
        let uav = [20 * M + x, -30_000 * M, high];
        for dx in -2..=3 {
            for y in [0, 1, 50 * M, 100 * M - 1, 100 * M, 100 * M + 1, 140 * M] {
                for z in [0, M, top - 1, top] {
                    scene.check_all(uav, [20 * M + dx, y, z], &mut count);
                }
            }
        }
    }
    count.assert_both(300);
}

#[test]
fn many_prisms_that_meet_at_one_point_are_told_apart() {
    let fan = |random: &mut Random| -> Vec<Prism> {
        let rays: [[i64; 2]; 12] =
            [[6, 0], [6, 3], [4, 4], [3, 6], [0, 6], [-3, 6], [-4, 4], [-6, 1], [-6, 0], [-4, -4], [0, -6], [4, -4]];
        let mut wedges = Vec::new();
        for k in 0..rays.len() {
            let (a, b) = (rays[k], rays[(k + random.choose(&[1, 1, 2])) % rays.len()]);
            if cross(a, b) > 0 && random.chance(80) {
                wedges.push(prism(&[[0, 0], a, b], random.within(1, 3)));
            }
        }
        moved(&wedges, |p| p.map(|c| c * M), |top| top * M)
    };
    let count = over_seeds(if is_long() { 1_500 } else { 60 }, 0, |_, random, count| {
        let scene = Footprints::new(fan(random));
        for _ in 0..60 {
            let mut end = || [random.within(-6, 6) * M, random.within(-6, 6) * M, random.within(0, 3) * M];
            let (a, b) = (end(), end());
            // Also through the point, and up and down over it.
            let opposite = [-a[0], -a[1], b[2]];
            let center = [0, 0, b[2]];
            for (uav, receiver) in [(a, b), (a, opposite), (a, center), ([0, 0, a[2]], center)] {
                scene.check_all(uav, receiver, count);
            }
        }
    });
    count.assert_both(12_000);
}

#[test]
fn vertical_and_zero_length_links_agree_at_every_kind_of_point() {
    let mut count = Count::default();
    for (_, prisms) in catalogue() {
        let scene = Footprints::new(moved(&prisms, |p| p.map(|c| c * M), |top| top * M));
        for p in lattice(-1, 13, M / 2) {
            for (a, b) in [(4, 0), (3, 2), (2, 2), (2, 1), (0, 4), (1, 1), (0, 0)] {
                scene.check_all(at_height(p, a * M), at_height(p, b * M), &mut count);
            }
        }
    }
    count.assert_both(25_000);
    let mut count = Count::default();
    let raster = Raster::new(Columns { n_cols: 2, n_rows: 2, heights: vec![Some(M), None, Some(0), Some(5 * M)] });
    for p in lattice(-1, 5, M / 2) {
        for (a, b) in [(4, 0), (2, 2), (0, 0), (0, 9)] {
            assert!(raster.check_all(at_height(p, a * M), at_height(p, b * M), &mut count));
        }
    }
    assert_eq!(count.links, 4 * 49);
}

#[test]
fn a_link_without_length_inside_a_building_has_nothing_in_its_way() {
    // The open segment between coinciding ends is empty. The engine asked for the roof instead.
    let scene = Footprints::new(vec![block(0, 0, 4, 4, 9)]);
    assert!(scene.check([2, 2, 5], [2, 2, 5], &mut Count::default()));
    assert!(!scene.check([2, 2, 5], [2, 2, 6], &mut Count::default()));
}

#[test]
fn a_city_of_stars_is_crossed_by_long_links_over_many_buckets() {
    let n = if is_long() { 60 } else { 8 };
    let count = over_seeds(n, 0xC17, |seed, random, count| {
        let mut town = Vec::new();
        for corner in lattice(0, 5, 7 * 2048) {
            let ring = star(random, 6);
            let at = |p: [i64; 2]| [corner[0] + p[0] * 2048, corner[1] + p[1] * 2048];
            town.extend(moved(&[prism(&ring, random.within(1, 20))], at, |top| top * M));
        }
        let scene = Footprints::new(town);
        for _ in 0..250 {
            let mut end = |high: i64| [random.within(-1, 42) * 2048, random.within(-1, 42) * 2048, high];
            let (uav, receiver) = (end(seed as i64 % 30 * M), end(0));
            let uav = [uav[0], uav[1], uav[2] + (receiver[0] / 2048 % 8) * 2 * M];
            scene.check_all(uav, receiver, count);
        }
    });
    assert!(count.links >= 250 * n && count.los > 100 && count.links - count.los > 100, "{count:?}");
}

#[test]
fn a_ceiling_far_below_the_lattice_is_still_that_of_the_highest_bound() {
    // One step from the UAV the bound of its own roof lies millions of meters below; the wall of another roof,
    // 17 − 2^-25 steps away and 17 times as far below, asks for a little less. The engine skipped the roof,
    // as it took the way left for one minus a rounded fraction.
    let (high, drop) = (1 << 25, 1 << 20);
    let own_roof = block(0, -10, 5, 10, high - drop);
    let slanted = prism(&[[-16, 0], [-5, 0], [-5, 1 << 25], [-15, 1 << 25]], high - 17 * drop);
    let scene = Footprints::new(vec![own_roof, slanted]);
    let mut random = Random(77);
    for _ in 0..2000 {
        let reach = (1 << 26) - random.within(0, 100_000);
        scene.check_heights([1, 1, high], [1 - reach, 1, 0], &mut Count::default());
    }
}
