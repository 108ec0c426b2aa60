//! What must not change, and what can only change one way: engines and whole maps on random scenes.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::unwrap_used,
    reason = "small numbers, and a panic is a failed test"
)]

use rayon::ThreadPoolBuilder;
use skyshed_core::city::{DataArea, Footprint, FootprintFaults, Ground, Solids};
use skyshed_core::coverage::{
    Control, HeightLayers, HoversOver, MapOptions, Overlay, Receivers, SiteCoverage, Uav, class, map_site, which_layer,
};
use skyshed_core::height_field::{CellKind, HeightField, Station};
use skyshed_core::los::{
    columns_least_height, columns_least_receiver_height, columns_los, link_los, prisms_least_receiver_height,
    prisms_los,
};
use skyshed_core::quantity::{Frame, VOID};
use skyshed_core::raster::{GeoRef, LargeVec, Raster};

use crate::oracle::{Columns, P3, Prism};
use crate::shapes::{M, moved, plan, prism, random_columns, random_end, random_prism_end, random_prisms, star};
use crate::support::{Random, columns_of, point, prisms_of};

/// Runs a property on `n` random scenes; it returns whether a link is LoS, and both answers must be frequent.
fn both_answers(n: u64, seed: u64, property: impl Fn(&mut Random) -> bool) {
    let mut random = Random(seed);
    let los = (0..n).filter(|_| property(&mut random)).count() as u64;
    assert!(los * 10 >= n && (n - los) * 10 >= n, "{los} of {n} are LoS");
}

fn raised([x, y, z]: P3, by: i64) -> P3 {
    [x, y, z + by]
}

fn raster_los(columns: &Columns, uav: P3, receiver: P3) -> bool {
    columns_los(&columns_of(columns), point(uav), point(receiver))
}

fn vector_los(prisms: &[Prism], uav: P3, receiver: P3) -> bool {
    prisms_los(&prisms_of(prisms), point(uav), point(receiver))
}

// ---------------------------------------------------------------------------------------------------------------------
// What must not change.

#[test]
fn swapping_the_ends_changes_nothing_among_prisms() {
    both_answers(10_000, 1, |random| {
        let prisms = prisms_of(&random_prisms(random));
        let (uav, receiver) = (point(random_prism_end(random)), point(random_prism_end(random)));
        let los = prisms_los(&prisms, uav, receiver);
        assert_eq!(los, prisms_los(&prisms, receiver, uav), "{uav:?} {receiver:?}");
        los
    });
}

#[test]
fn mirrors_turns_and_shifts_change_nothing_among_prisms() {
    let maps: [fn([i64; 2]) -> [i64; 2]; 5] = [
        |[x, y]| [-x, y],
        |[x, y]| [-y, x],
        |[x, y]| [y + 7, x - 3],
        |[x, y]| [2 * x + y, y - x],
        |[x, y]| [x * 8192 - 8192, y * 8192 + 16_384],
    ];
    both_answers(5_000, 2, |random| {
        let prisms = random_prisms(random);
        let (uav, receiver) = (random_prism_end(random), random_prism_end(random));
        let los = vector_los(&prisms, uav, receiver);
        for map in maps {
            let end = |p: P3| {
                let [x, y] = map(plan(p));
                [x, y, p[2]]
            };
            let there = vector_los(&moved(&prisms, map, |top| top), end(uav), end(receiver));
            assert_eq!(los, there, "{prisms:?} {uav:?} {receiver:?}");
        }
        los
    });
}

/// The raster with `margin` more cells of nodata in the west and in the south.
fn shifted(columns: &Columns, margin: usize) -> Columns {
    let (n_cols, n_rows) = (columns.n_cols + margin, columns.n_rows + margin);
    let mut heights = vec![None; n_cols * n_rows];
    for (k, height) in columns.heights.iter().enumerate() {
        heights[k / columns.n_cols * n_cols + k % columns.n_cols + margin] = *height;
    }
    Columns { n_cols, n_rows, heights }
}

#[test]
fn mirrors_turns_and_shifts_change_nothing_in_a_raster() {
    both_answers(10_000, 3, |random| {
        let columns = random_columns(random);
        let (uav, receiver) = (random_end(random, &columns), random_end(random, &columns));
        let los = raster_los(&columns, uav, receiver);
        let Columns { n_cols, n_rows, ref heights } = columns;
        let [width, depth] = [n_cols, n_rows].map(|n| i64::try_from(n).unwrap() * M);

        let mirrored = heights.chunks(n_cols).flat_map(|row| row.iter().rev().copied()).collect();
        let end = |[x, y, z]: P3| [width - x, y, z];
        let there = raster_los(&Columns { n_cols, n_rows, heights: mirrored }, end(uav), end(receiver));
        assert_eq!(los, there, "mirror: {columns:?} {uav:?} {receiver:?}");

        // Counterclockwise: the eastern column becomes the northern row, its northern end first.
        let turned = (0..n_cols).rev().flat_map(|c| (0..n_rows).map(move |r| heights[r * n_cols + c])).collect();
        let end = |[x, y, z]: P3| [depth - y, x, z];
        let there = raster_los(&Columns { n_cols: n_rows, n_rows: n_cols, heights: turned }, end(uav), end(receiver));
        assert_eq!(los, there, "turn: {columns:?} {uav:?} {receiver:?}");

        let margin = random.within(1, 3);
        let end = |[x, y, z]: P3| [x + margin * M, y + margin * M, z];
        let wider = shifted(&columns, usize::try_from(margin).unwrap());
        assert_eq!(los, raster_los(&wider, end(uav), end(receiver)), "shift: {columns:?} {uav:?} {receiver:?}");
        los
    });
}

/// The raster with the receiver's own cells as nodata.
fn without_own_cells(columns: &Columns, receiver: P3) -> Columns {
    let mut open = columns.clone();
    for (index, height) in open.heights.iter_mut().enumerate() {
        let corner = [index % columns.n_cols, columns.n_rows - 1 - index / columns.n_cols];
        let [west, south] = corner.map(|n| i64::try_from(n).unwrap() * M);
        if (west..=west + M).contains(&receiver[0]) && (south..=south + M).contains(&receiver[1]) {
            *height = None;
        }
    }
    open
}

#[test]
fn splitting_each_cell_in_four_changes_nothing() {
    both_answers(10_000, 4, |random| {
        let columns = random_columns(random);
        let (uav, receiver) = (random_end(random, &columns), random_end(random, &columns));
        // The own cell would shrink with the cells, so it is opened beforehand.
        let coarse = without_own_cells(&columns, receiver);
        let (n_cols, n_rows) = (2 * coarse.n_cols, 2 * coarse.n_rows);
        let fine = |index: usize| coarse.heights[index / n_cols / 2 * coarse.n_cols + index % n_cols / 2];
        let fine = Columns { n_cols, n_rows, heights: (0..n_cols * n_rows).map(fine).collect() };
        let end = |[x, y, z]: P3| [2 * x, 2 * y, z];
        let los = raster_los(&columns, uav, receiver);
        assert_eq!(los, raster_los(&coarse, uav, receiver), "{columns:?} {uav:?} {receiver:?}");
        assert_eq!(los, raster_los(&fine, end(uav), end(receiver)), "{columns:?} {uav:?} {receiver:?}");
        los
    });
}

/// Cuts a polygon seen whole from its first vertex, or `None` if no diagonal from there stays inside.
fn cut_in_two(ring: &[[i64; 2]], at: usize) -> Option<[Vec<[i64; 2]>; 2]> {
    let turn = |a: [i64; 2], b: [i64; 2], c: [i64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let n = ring.len();
    // In a convex polygon every diagonal is inside.
    let convex = (0..n).all(|i| turn(ring[i], ring[(i + 1) % n], ring[(i + 2) % n]) > 0);
    (convex && n >= 4).then(|| [ring[..=at].to_vec(), [&ring[at..], &ring[..1]].concat()])
}

#[test]
fn cutting_a_footprint_in_two_along_a_line_through_lattice_points_changes_nothing() {
    both_answers(3_000, 5, |random| {
        let mut whole = random_prisms(random);
        whole.truncate(2);
        let mut cut = whole.clone();
        let (ring, [a, b]) = loop {
            let ring = star(random, 6);
            let at = 2 + random.within(0, 3) as usize;
            if at + 1 < ring.len()
                && let Some(halves) = cut_in_two(&ring, at)
            {
                break (ring, halves);
            }
        };
        let top = random.within(1, 5);
        whole.push(prism(&ring, top));
        cut.extend([prism(&a, top), prism(&b, top)]);
        let (whole_engine, cut_engine) = (prisms_of(&whole), prisms_of(&cut));
        // Along the cut as often as anywhere.
        let along = |k: i64, z: i64| {
            let (p, q) = (a[0], a[a.len() - 1]);
            [p[0] + k * (q[0] - p[0]), p[1] + k * (q[1] - p[1]), z]
        };
        let (uav, receiver) = if random.chance(50) {
            (random_prism_end(random), random_prism_end(random))
        } else {
            (along(-1, random.within(0, 6)), along(random.within(1, 2), random.within(0, 6)))
        };
        let los = prisms_los(&whole_engine, point(uav), point(receiver));
        assert_eq!(los, prisms_los(&cut_engine, point(uav), point(receiver)), "{whole:?} {uav:?} {receiver:?}");
        let ceilings = [&whole_engine, &cut_engine]
            .map(|p| prisms_least_receiver_height(p, point(uav), point(receiver)).height_steps());
        assert!(ceilings[0].total_cmp(&ceilings[1]).is_eq(), "{ceilings:?} {whole:?} {uav:?} {receiver:?}");
        los
    });
}

// ---------------------------------------------------------------------------------------------------------------------
// What can change only one way.

#[test]
fn raising_a_building_never_clears_a_link_and_raising_an_end_never_blocks_it() {
    // True for any two ends, wherever they are: every solid reaches down without end, so a segment that rises at one
    // end leaves the interior only. The one exception is an empty segment, of coinciding ends, that gets a length.
    both_answers(10_000, 6, |random| {
        let mut columns = random_columns(random);
        let (uav, receiver) = (random_end(random, &columns), random_end(random, &columns));
        let los = raster_los(&columns, uav, receiver);
        if los {
            assert!(raster_los(&columns, raised(uav, random.within(1, 5000)), receiver));
            assert!(raster_los(&columns, uav, raised(receiver, random.within(1, 5000))));
        } else {
            let index = random.next() as usize % columns.heights.len();
            columns.heights[index] = Some(columns.heights[index].unwrap_or(0) + random.within(1, 5000));
            assert!(!raster_los(&columns, uav, receiver), "{columns:?} {uav:?} {receiver:?}");
        }
        los
    });
    both_answers(10_000, 7, |random| {
        let mut prisms = random_prisms(random);
        let (uav, receiver) = (random_prism_end(random), random_prism_end(random));
        let los = vector_los(&prisms, uav, receiver);
        if los && uav != receiver {
            assert!(vector_los(&prisms, raised(uav, random.within(1, 3)), receiver));
            assert!(vector_los(&prisms, uav, raised(receiver, random.within(1, 3))));
        } else if !los {
            let index = random.next() as usize % prisms.len();
            prisms[index].top += random.within(1, 3);
            assert!(!vector_los(&prisms, uav, receiver), "{prisms:?} {uav:?} {receiver:?}");
        }
        los
    });
}

#[test]
fn a_receiver_at_its_ceiling_is_los_and_a_step_below_is_not() {
    both_answers(10_000, 8, |random| {
        let columns = columns_of(&random_columns(random));
        let shape = Columns { n_cols: columns.n_cols(), n_rows: columns.n_rows(), heights: Vec::new() };
        let (uav, receiver) = (random_end(random, &shape), random_end(random, &shape));
        let (uav, receiver) = (point(uav), point(receiver));
        let los = columns_los(&columns, uav, receiver);
        let with_z = |mut p: skyshed_core::quantity::LatticePoint, z: i64| {
            p.z = z;
            p
        };
        let ceiling = columns_least_receiver_height(&columns, uav, receiver);
        assert_eq!(ceiling.is_met_by(receiver.z), los);
        if ceiling.height_steps().is_finite() {
            let near = ceiling.height_steps().round() as i64;
            for z in near - 2..=near + 2 {
                assert_eq!(ceiling.is_met_by(z), columns_los(&columns, uav, with_z(receiver, z)));
            }
        }
        let least = columns_least_height(&columns, uav, receiver);
        assert_eq!(least.is_met_by(uav.z), los);
        if least.height_steps().is_finite() {
            let near = least.height_steps().round() as i64;
            for z in near - 2..=near + 2 {
                assert_eq!(least.is_met_by(z), columns_los(&columns, with_z(uav, z), receiver));
            }
        }
        los
    });
    both_answers(10_000, 9, |random| {
        let scene = moved(&random_prisms(random), |p| p, |top| top * M);
        let prisms = prisms_of(&scene);
        let ([x, y, z], [rx, ry, rz]) = (random_prism_end(random), random_prism_end(random));
        let (uav, receiver) = (point([x, y, z * M]), point([rx, ry, rz * M]));
        let los = prisms_los(&prisms, uav, receiver);
        let ceiling = prisms_least_receiver_height(&prisms, uav, receiver);
        if uav != receiver {
            assert_eq!(ceiling.is_met_by(receiver.z), los);
        }
        if ceiling.height_steps().is_finite() {
            let near = ceiling.height_steps().round() as i64;
            for z in (near - 2..=near + 2).filter(|z| [rx, ry, *z] != [x, y, uav.z]) {
                assert_eq!(ceiling.is_met_by(z), prisms_los(&prisms, uav, point([rx, ry, z])));
            }
        }
        los
    });
}

// ---------------------------------------------------------------------------------------------------------------------
// Whole maps.

const ALL_LAYERS: HeightLayers =
    HeightLayers { margin: true, least_receiver_height: true, least_height: true, stability: false };

fn options(receivers: Receivers, layers: HeightLayers) -> MapOptions {
    MapOptions { rx_height: 1536, receivers, layers, ..MapOptions::default() }
}

/// A town of random columns on flat ground, some of it nodata.
pub(crate) fn raster_town(random: &mut Random, n: usize) -> HeightField {
    let grid = GeoRef::new((500.25, 1000.0), (1.0, 1.0), (n, n), None).unwrap();
    let height = |random: &mut Random| match random.within(0, 19) {
        0 => VOID,
        1..=4 => i32::try_from(random.within(1, 9000)).unwrap(),
        _ => 0,
    };
    let cells = (0..n * n).map(|_| height(random)).collect::<Vec<_>>();
    let solids = Solids::Raster {
        surface: Raster::new(grid.clone(), cells),
        ground: Ground::Flat(0),
        building_threshold: 256,
        voids: None,
    };
    HeightField::build(&grid, solids).field
}

/// A town of random polygons, 7 m apart, on flat ground; edges run through cell centers.
pub(crate) fn vector_town(random: &mut Random, n: usize) -> HeightField {
    let grid = GeoRef::new((0.0, n as f64), (1.0, 1.0), (n, n), None).unwrap();
    let blocks = i32::try_from(n / 7).unwrap();
    let footprints = (0..blocks * blocks)
        .map(|k| {
            let (i, j) = (k % blocks * 7, k / blocks * 7);
            let at = |v: &[i64; 2]| {
                [(i * 2 + i32::try_from(v[0]).unwrap() * 2) * 512, (j * 2 + i32::try_from(v[1]).unwrap() * 2 + 1) * 512]
            };
            let ring = star(random, 6).iter().map(at).collect();
            let top = i32::try_from(random.within(1, 12)).unwrap() * 1024;
            Footprint { id: k.to_string(), polygons: vec![vec![ring]], top, base: Some(0) }
        })
        .collect();
    let solids = Solids::Vector {
        footprints,
        frame: Frame { x_origin: 0.0, y_origin: 0.0, unit_x: 1.0, unit_y: 1.0 },
        ground: Ground::Flat(0),
        faults: FootprintFaults::default(),
        data_area: DataArea::All,
    };
    HeightField::build(&grid, solids).field
}

pub(crate) fn uav_at(field: &HeightField, x: f64, y: f64, z: i64) -> Uav {
    let station = Station { place: field.place(x, y), z };
    Uav { id: "1".into(), station, height_agl_m: None, placement: HoversOver::Ground }
}

/// A few UAVs over the grid, at its border and outside.
pub(crate) fn uavs(field: &HeightField, random: &mut Random) -> Vec<Uav> {
    let grid = field.grid();
    let (x, y) = (grid.x_min(), grid.y_min());
    let (width, depth) = (grid.x_max() - x, grid.y_max() - y);
    [(0.5, 0.5, 12), (0.25, 0.75, 30), (0.0, 0.5, 9), (1.0, 1.0, 20), (-0.5, 0.3, 15), (0.6, 1.4, 40)]
        .map(|(u, v, z)| uav_at(field, x + u * width, y + v * depth, z * M + random.within(0, 1023)))
        .into()
}

fn map(field: &HeightField, uav: &Uav, options: &MapOptions) -> SiteCoverage {
    map_site(field, uav, options, &Control::default()).unwrap()
}

/// Every town with every one of its UAVs.
fn for_each_site(seed: u64, check: impl Fn(&HeightField, &Uav)) {
    let mut random = Random(seed);
    for field in [raster_town(&mut random, 40), vector_town(&mut random, 42)] {
        for uav in uavs(&field, &mut random) {
            check(&field, &uav);
        }
    }
}

#[test]
fn the_margin_is_never_negative_zero_and_tells_los_by_its_sign() {
    for_each_site(11, |field, uav| {
        let with_layers = map(field, uav, &options(Receivers::All, ALL_LAYERS));
        let plain = map(field, uav, &options(Receivers::All, HeightLayers::default()));
        assert_eq!(with_layers.mask, plain.mask);
        assert_eq!(with_layers.tally, plain.tally);
        assert!(plain.tally.los > 100 && plain.tally.receivers - plain.tally.los > 100, "{:?}", plain.tally);
        let (margin, ceiling) = (with_layers.margin.unwrap(), with_layers.least_receiver_height.unwrap());
        for ((class, margin), ceiling) in plain.mask.iter().zip(&margin).zip(&ceiling) {
            match *class {
                class::LOS => assert!(*margin >= 0.0 && margin.is_sign_positive() && *margin <= 1.5),
                class::NLOS => assert!(*margin < 0.0),
                _ => assert!(margin.is_nan() && ceiling.is_nan()),
            }
        }
    });
}

#[test]
fn a_uav_at_the_least_height_sees_the_receiver_and_just_below_does_not() {
    for_each_site(12, |field, uav| {
        let found = map(field, uav, &options(Receivers::All, ALL_LAYERS));
        let positions = field.positions();
        let n_cols = field.grid().n_cols();
        let least_heights = found.least_height.unwrap();
        let lowest = least_heights.iter().copied().fold(f32::INFINITY, f32::min);
        let mut n_checked = 0;
        for (index, least) in least_heights.iter().enumerate().filter(|(_, h)| h.is_finite()) {
            let place = positions.center(index / n_cols, index % n_cols);
            let stands_on = match field.cell_kind(index, &place) {
                CellKind::Open(z) | CellKind::Building(z) => i64::from(z),
                CellKind::Void => panic!("a least height over nodata"),
            };
            let receiver = Station { place, z: stands_on + 1536 };
            let sees = |z: i64| link_los(field, &Station { z, ..uav.station }, &receiver);
            // The layer is an f32: of a height up to 2^14 m it is off by less than 2^-10 m, one step.
            let steps = f64::from(*least) * 1024.0;
            assert!(sees(steps.floor() as i64 + 1), "{least} m does not see {receiver:?}");
            assert_eq!(found.mask[index] == class::LOS, sees(uav.station.z));
            // The least of all is the surface under the UAV, where lower is seen as well but cannot be flown.
            if *least > lowest {
                assert!(!sees(steps.ceil() as i64 - 1), "below {least} m sees {receiver:?}");
                n_checked += 1;
            }
        }
        assert!(n_checked > 200, "{n_checked}");
    });
}

#[test]
fn masks_and_layers_are_equal_with_one_two_and_seven_threads() {
    for_each_site(13, |field, uav| {
        let all = [1, 2, 7].map(|n_threads| {
            let pool = ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
            pool.install(|| map(field, uav, &options(Receivers::All, ALL_LAYERS)))
        });
        let bits =
            |layer: &Option<Vec<f32>>| -> Vec<u32> { layer.as_ref().unwrap().iter().map(|v| v.to_bits()).collect() };
        for other in &all[1..] {
            assert_eq!(all[0].mask, other.mask);
            assert_eq!(all[0].tally, other.tally);
            assert_eq!(bits(&all[0].margin), bits(&other.margin));
            assert_eq!(bits(&all[0].least_receiver_height), bits(&other.least_receiver_height));
            assert_eq!(bits(&all[0].least_height), bits(&other.least_height));
        }
    });
}

#[test]
fn nodata_wins_over_out_of_range_and_that_over_not_a_receiver() {
    let mut random = Random(14);
    let field = raster_town(&mut random, 40);
    let uav = &uavs(&field, &mut random)[0];
    let [ground, roof, all] = [Receivers::Ground, Receivers::Roof, Receivers::All].map(|receivers| {
        let options = MapOptions { radius: Some(12.5), ..options(receivers, HeightLayers::default()) };
        map(&field, uav, &options).mask
    });
    let positions = field.positions();
    let mut seen = [0; 6];
    for index in 0..1600 {
        let place = positions.center(index / 40, index % 40);
        let (dx, dy) = (place.x - uav.station.place.x, place.y - uav.station.place.y);
        let is_far = dx * dx + dy * dy > 12.5 * 12.5;
        let classes = [ground[index], roof[index], all[index]];
        let case = match (field.cell_kind(index, &place), is_far) {
            (CellKind::Void, far) => {
                assert_eq!(classes, [class::NODATA; 3]);
                usize::from(far)
            }
            (_, true) => {
                assert_eq!(classes, [class::OUT_OF_RANGE; 3]);
                2
            }
            (CellKind::Open(_), false) => {
                assert_eq!(classes, [all[index], class::NOT_A_RECEIVER, all[index]]);
                3 + usize::from(all[index])
            }
            (CellKind::Building(_), false) => {
                assert_eq!(classes, [class::NOT_A_RECEIVER, all[index], all[index]]);
                5
            }
        };
        assert!(case < 3 || all[index] <= 1);
        seen[case] += 1;
    }
    assert!(seen.iter().all(|n| *n > 0), "{seen:?}");
}

#[test]
fn union_count_and_which_agree_with_each_other_and_with_the_masks() {
    let mut random = Random(15);
    let field = vector_town(&mut random, 42);
    // More than 32 UAVs, so that `which` needs two words.
    let masks: Vec<LargeVec<u8>> = (0..35)
        .map(|k| {
            let uav = uav_at(&field, f64::from(k) + 0.5, f64::from((k * 17) % 42) + 0.25, 15 * M);
            let radius = Some(18.0);
            map(&field, &uav, &MapOptions { radius, ..options(Receivers::Ground, HeightLayers::default()) }).mask
        })
        .collect();
    let masks: Vec<&[u8]> = masks.iter().map(LargeVec::as_slice).collect();
    let mut overlay = Overlay::new(masks[0].len());
    masks.iter().for_each(|mask| overlay.add(mask));
    let (union, count, which) = (overlay.union(), overlay.count(), which_layer(&masks));
    assert_eq!(which.len(), 2);
    let mut n_los = 0;
    for i in 0..union.len() {
        assert_eq!(count[i], which.iter().map(|word| word[i].count_ones()).sum::<u32>());
        for (k, mask) in masks.iter().enumerate() {
            assert_eq!(mask[i] == class::LOS, which[k / 32][i] >> (k % 32) & 1 == 1);
        }
        assert_eq!(count[i] > 0, union[i] == class::LOS);
        assert_eq!(union[i] == class::NLOS, count[i] == 0 && masks.iter().any(|m| m[i] == class::NLOS));
        n_los += usize::from(union[i] == class::LOS);
    }
    assert!(n_los > 200);
}

#[test]
fn a_receiver_on_a_roof_sees_what_its_own_roof_does_not_hide() {
    // One building of 10 m over 4…8 m; a UAV 20 m high straight over it sees all its roof, one at the side below the
    // roof sees none of it, and one level with the receivers sees them all.
    let grid = GeoRef::new((0.0, 12.0), (1.0, 1.0), (12, 12), None).unwrap();
    let ring = vec![[4096, 4096], [8192, 4096], [8192, 8192], [4096, 8192]];
    let solids = Solids::Vector {
        footprints: vec![Footprint { id: "a".into(), polygons: vec![vec![ring]], top: 10_240, base: Some(0) }],
        frame: Frame { x_origin: 0.0, y_origin: 0.0, unit_x: 1.0, unit_y: 1.0 },
        ground: Ground::Flat(0),
        faults: FootprintFaults::default(),
        data_area: DataArea::All,
    };
    let field = HeightField::build(&grid, solids).field;
    for (x, z, rx_height, n_los) in
        [(6.0, 20_480, 1536, 16), (0.5, 5_000, 0, 0), (0.5, 11_776, 1536, 16), (0.5, 10_240, 0, 16)]
    {
        let options = MapOptions { rx_height, ..options(Receivers::Roof, ALL_LAYERS) };
        let found = map(&field, &uav_at(&field, x, 6.0, z), &options);
        assert_eq!((found.tally.receivers, found.tally.los), (16, n_los), "{x} {z} {rx_height}");
    }
}
