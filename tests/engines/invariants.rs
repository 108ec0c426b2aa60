//! What must not change, and what can only change one way: the oracle, engines and whole maps on random scenes.

#![expect(
    clippy::cast_possible_truncation,
    clippy::unwrap_used,
    reason = "small numbers, and a panic is a failed test"
)]

use rayon::ThreadPoolBuilder;
use skyshed_core::city::{Antenna, DataArea, Footprint, FootprintFaults, Ground, Solids};
use skyshed_core::coverage::{
    Control, HeightLayers, HoversOver, MapOptions, Receivers, SiteCoverage, Uav, class, map_site,
};
use skyshed_core::height_field::{CellKind, HeightField, Station};
use skyshed_core::los::{
    LeastHeight, columns_least_height, columns_least_receiver_height, columns_los, link_los,
    prisms_least_receiver_height, prisms_los,
};
use skyshed_core::quantity::{Frame, LatticePoint, VOID};
use skyshed_core::raster::{GeoRef, Raster};

use crate::oracle::{self, Columns, P3, Prism};
use crate::referee::{both_answers, in_steps};
use crate::shapes::{
    M, at_height, crossing_prism_end, crossing_prisms, moved, plan, prism, raised, random_columns, random_end,
    random_prism_end, random_prisms, star, turn, without_own_cells,
};
use crate::support::{Random, raster_field};
use crate::translation::{columns_of, point, prisms_of};

/// Who decides links, and the random footprints that it can be given.
struct Judge {
    name: &'static str,
    columns_los: fn(&Columns, P3, P3) -> bool,
    prisms_los: fn(&[Prism], P3, P3) -> bool,
    /// Ceiling at the receiver's place \[steps\].
    prisms_ceiling: fn(&[Prism], P3, P3) -> f64,
    random_prisms: fn(&mut Random) -> Vec<Prism>,
    random_prism_end: fn(&mut Random) -> P3,
}

const JUDGES: [Judge; 2] = [
    Judge {
        name: "the oracle",
        columns_los: oracle::columns_los,
        prisms_los: oracle::prisms_los,
        prisms_ceiling: |prisms, uav, receiver| in_steps(&oracle::prisms_ceiling(prisms, uav, plan(receiver))),
        random_prisms: crossing_prisms,
        random_prism_end: crossing_prism_end,
    },
    Judge {
        name: "ray",
        columns_los: |columns, uav, receiver| columns_los(&columns_of(columns), point(uav), point(receiver)),
        prisms_los: |prisms, uav, receiver| prisms_los(&prisms_of(prisms), point(uav), point(receiver)),
        prisms_ceiling: |prisms, uav, receiver| {
            prisms_least_receiver_height(&prisms_of(prisms), point(uav), point(receiver)).height_steps()
        },
        random_prisms,
        random_prism_end,
    },
];

/// Runs a property of a link in a random raster; it returns whether the link is LoS.
fn in_rasters(n: u64, seed: u64, property: impl Fn(&Judge, &mut Random, Columns, P3, P3) -> bool) {
    for judge in &JUDGES {
        both_answers(n, seed, |random| {
            let columns = random_columns(random);
            let (uav, receiver) = (random_end(random, &columns), random_end(random, &columns));
            property(judge, random, columns, uav, receiver)
        });
    }
}

/// Runs a property of a link among random footprints; it returns whether the link is LoS.
fn among_prisms(n: u64, seed: u64, property: impl Fn(&Judge, &mut Random, Vec<Prism>, P3, P3) -> bool) {
    for judge in &JUDGES {
        both_answers(n, seed, |random| {
            let prisms = (judge.random_prisms)(random);
            let (uav, receiver) = ((judge.random_prism_end)(random), (judge.random_prism_end)(random));
            property(judge, random, prisms, uav, receiver)
        });
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// What must not change.

#[test]
fn swapped_ends_mirrors_turns_and_shifts_change_nothing_among_prisms() {
    let maps: [fn([i64; 2]) -> [i64; 2]; 5] = [
        |[x, y]| [-x, y],
        |[x, y]| [-y, x],
        |[x, y]| [y + 7, x - 3],
        |[x, y]| [2 * x + y, y - x],
        |[x, y]| [x * 8192 - 8192, y * 8192 + 16_384],
    ];
    among_prisms(10_000, 1, |judge, _, prisms, uav, receiver| {
        let los = (judge.prisms_los)(&prisms, uav, receiver);
        let what = || format!("{}: {prisms:?} {uav:?} {receiver:?}", judge.name);
        assert_eq!(los, (judge.prisms_los)(&prisms, receiver, uav), "{}", what());
        for map in maps {
            let end = |p: P3| at_height(map(plan(p)), p[2]);
            let there = (judge.prisms_los)(&moved(&prisms, map, |top| top), end(uav), end(receiver));
            assert_eq!(los, there, "{}", what());
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
    in_rasters(10_000, 3, |judge, random, columns, uav, receiver| {
        let los = (judge.columns_los)(&columns, uav, receiver);
        let Columns { n_cols, n_rows, ref heights } = columns;
        let [width, depth] = [n_cols, n_rows].map(|n| i64::try_from(n).unwrap() * M);
        let what = |kind: &str| format!("{kind}, {}: {columns:?} {uav:?} {receiver:?}", judge.name);

        let mirrored = heights.chunks(n_cols).flat_map(|row| row.iter().rev().copied()).collect();
        let mirrored = Columns { n_cols, n_rows, heights: mirrored };
        let end = |[x, y, z]: P3| [width - x, y, z];
        assert_eq!(los, (judge.columns_los)(&mirrored, end(uav), end(receiver)), "{}", what("mirror"));

        // Counterclockwise: the eastern column becomes the northern row, its northern end first.
        let turned = (0..n_cols).rev().flat_map(|c| (0..n_rows).map(move |r| heights[r * n_cols + c])).collect();
        let turned = Columns { n_cols: n_rows, n_rows: n_cols, heights: turned };
        let end = |[x, y, z]: P3| [depth - y, x, z];
        assert_eq!(los, (judge.columns_los)(&turned, end(uav), end(receiver)), "{}", what("turn"));

        let margin = random.within(1, 3);
        let wider = shifted(&columns, usize::try_from(margin).unwrap());
        let end = |[x, y, z]: P3| [x + margin * M, y + margin * M, z];
        assert_eq!(los, (judge.columns_los)(&wider, end(uav), end(receiver)), "{}", what("shift"));
        los
    });
}

#[test]
fn splitting_each_cell_in_four_changes_nothing() {
    in_rasters(10_000, 4, |judge, _, columns, uav, receiver| {
        // The own cell would shrink with the cells, so it is opened beforehand.
        let coarse = without_own_cells(&columns, receiver);
        let (n_cols, n_rows) = (2 * coarse.n_cols, 2 * coarse.n_rows);
        let fine = |index: usize| coarse.heights[index / n_cols / 2 * coarse.n_cols + index % n_cols / 2];
        let fine = Columns { n_cols, n_rows, heights: (0..n_cols * n_rows).map(fine).collect() };
        let end = |[x, y, z]: P3| [2 * x, 2 * y, z];
        let los = (judge.columns_los)(&columns, uav, receiver);
        let what = || format!("{}: {columns:?} {uav:?} {receiver:?}", judge.name);
        assert_eq!(los, (judge.columns_los)(&coarse, uav, receiver), "{}", what());
        assert_eq!(los, (judge.columns_los)(&fine, end(uav), end(receiver)), "{}", what());
        los
    });
}

/// Cuts a convex polygon of four corners or more along the diagonal from its first vertex to that at `at`.
fn cut_in_two(ring: &[[i64; 2]], at: usize) -> Option<[Vec<[i64; 2]>; 2]> {
    let n = ring.len();
    let convex = (0..n).all(|i| turn(ring[i], ring[(i + 1) % n], ring[(i + 2) % n]) > 0);
    (convex && at + 1 < n).then(|| [ring[..=at].to_vec(), [&ring[at..], &ring[..1]].concat()])
}

#[test]
fn cutting_a_footprint_in_two_along_a_line_through_lattice_points_changes_nothing() {
    among_prisms(5_000, 5, |judge, random, mut whole, mut uav, mut receiver| {
        whole.truncate(2);
        let mut cut = whole.clone();
        let (ring, [a, b]) = loop {
            let ring = star(random, 6);
            if let Some(halves) = cut_in_two(&ring, random.index(2, 5)) {
                break (ring, halves);
            }
        };
        let top = random.within(1, 5);
        whole.push(prism(&ring, top));
        cut.extend([prism(&a, top), prism(&b, top)]);
        if random.chance(50) {
            // Along the cut as often as anywhere.
            let (p, q) = (a[0], a[a.len() - 1]);
            let along = |k: i64, z: i64| [p[0] + k * (q[0] - p[0]), p[1] + k * (q[1] - p[1]), z];
            uav = along(-1, random.within(0, 6));
            receiver = along(random.within(1, 2), random.within(0, 6));
        }
        let what = || format!("{}: {whole:?} {uav:?} {receiver:?}", judge.name);
        let los = (judge.prisms_los)(&whole, uav, receiver);
        assert_eq!(los, (judge.prisms_los)(&cut, uav, receiver), "{}", what());
        let ceilings = [&whole, &cut].map(|prisms| (judge.prisms_ceiling)(prisms, uav, receiver));
        assert!(ceilings[0].total_cmp(&ceilings[1]).is_eq(), "{ceilings:?} {}", what());
        los
    });
}

// ---------------------------------------------------------------------------------------------------------------------
// What can change only one way.

#[test]
fn raising_a_building_never_clears_a_link_and_raising_an_end_never_blocks_it() {
    // True for any two ends, wherever they are: every solid reaches down without end, so a segment that rises at one
    // end leaves the interior only. The one exception is an empty segment, of coinciding ends, that gets a length.
    in_rasters(10_000, 6, |judge, random, mut columns, uav, receiver| {
        let los = (judge.columns_los)(&columns, uav, receiver);
        if los {
            assert!((judge.columns_los)(&columns, raised(uav, random.within(1, 5000)), receiver));
            assert!((judge.columns_los)(&columns, uav, raised(receiver, random.within(1, 5000))));
        } else {
            let index = random.below(columns.heights.len());
            columns.heights[index] = Some(columns.heights[index].unwrap_or(0) + random.within(1, 5000));
            let raised = (judge.columns_los)(&columns, uav, receiver);
            assert!(!raised, "{}: {columns:?} {uav:?} {receiver:?}", judge.name);
        }
        los
    });
    among_prisms(10_000, 7, |judge, random, mut prisms, uav, receiver| {
        let los = (judge.prisms_los)(&prisms, uav, receiver);
        if los && uav != receiver {
            assert!((judge.prisms_los)(&prisms, raised(uav, random.within(1, 3)), receiver));
            assert!((judge.prisms_los)(&prisms, uav, raised(receiver, random.within(1, 3))));
        } else if !los {
            let index = random.below(prisms.len());
            prisms[index].top += random.within(1, 3);
            let raised = (judge.prisms_los)(&prisms, uav, receiver);
            assert!(!raised, "{}: {prisms:?} {uav:?} {receiver:?}", judge.name);
        }
        los
    });
}

/// Asserts that a least height tells how the link is decided at the height `z`, and within two steps of itself.
pub(crate) fn check_least(least: &LeastHeight, z: i64, is_los: impl Fn(i64) -> bool) {
    let near = least.height_steps().round();
    let around = if near.is_finite() { near as i64 - 2..=near as i64 + 2 } else { z..=z };
    for z in around.chain([z]) {
        assert_eq!(least.is_met_by(z), is_los(z), "{least:?} at {z}");
    }
}

#[test]
fn a_receiver_at_its_ceiling_is_los_and_a_step_below_is_not() {
    both_answers(10_000, 8, |random| {
        let raster = random_columns(random);
        let (uav, receiver) = (point(random_end(random, &raster)), point(random_end(random, &raster)));
        let columns = columns_of(&raster);
        let ceiling = columns_least_receiver_height(&columns, uav, receiver);
        check_least(&ceiling, receiver.z, |z| columns_los(&columns, uav, LatticePoint { z, ..receiver }));
        let least = columns_least_height(&columns, uav, receiver);
        check_least(&least, uav.z, |z| columns_los(&columns, LatticePoint { z, ..uav }, receiver));
        columns_los(&columns, uav, receiver)
    });
    both_answers(10_000, 9, |random| {
        let prisms = prisms_of(&moved(&random_prisms(random), |p| p, |top| top * M));
        let end = |[x, y, z]: P3| LatticePoint { x, y, z: z * M };
        let (uav, receiver) = (end(random_prism_end(random)), end(random_prism_end(random)));
        let ceiling = prisms_least_receiver_height(&prisms, uav, receiver);
        check_least(&ceiling, receiver.z, |z| {
            let receiver = LatticePoint { z, ..receiver };
            // A link of no length is LoS, whatever the ceiling.
            if receiver == uav { ceiling.is_met_by(z) } else { prisms_los(&prisms, uav, receiver) }
        });
        prisms_los(&prisms, uav, receiver)
    });
}

// ---------------------------------------------------------------------------------------------------------------------
// Whole maps.

const ALL_LAYERS: HeightLayers = HeightLayers {
    margin: true,
    least_receiver_height: true,
    least_height: true,
    stability: false,
    sure: false,
    p_los: false,
};

pub(crate) fn options(receivers: Receivers, layers: HeightLayers) -> MapOptions {
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
    raster_field(Raster::new(grid, cells), Ground::Flat(0))
}

/// Footprints on a ground, on `n` by `n` cells of 1 m.
pub(crate) fn vector_field(footprints: Vec<Footprint>, ground: Ground, n: usize) -> HeightField {
    let grid = GeoRef::new((0.0, n as f64), (1.0, 1.0), (n, n), None).unwrap();
    let solids = Solids::Vector {
        footprints,
        frame: Frame { x_origin: 0.0, y_origin: 0.0, unit_x: 1.0, unit_y: 1.0 },
        ground,
        faults: FootprintFaults::default(),
        data_area: DataArea::All,
    };
    HeightField::build(&grid, solids).field
}

/// A town of random polygons, 7 m apart, on flat ground; edges run through cell centers.
pub(crate) fn vector_town(random: &mut Random, n: usize) -> HeightField {
    vector_town_on(random, Ground::Flat(0), n)
}

/// Such a town on another ground.
pub(crate) fn vector_town_on(random: &mut Random, ground: Ground, n: usize) -> HeightField {
    let blocks = i32::try_from(n / 7).unwrap();
    let footprint = |k: i32| {
        let (east, north) = (k % blocks * 14, k / blocks * 14);
        let half_meters = |v: i64| 2 * i32::try_from(v).unwrap();
        let at = |v: &[i64; 2]| [(east + half_meters(v[0])) * 512, (north + half_meters(v[1]) + 1) * 512];
        let ring = star(random, 6).iter().map(at).collect();
        let top = i32::try_from(random.within(1, 12)).unwrap() * 1024;
        Footprint::on_zero(k.to_string(), vec![vec![ring]], top)
    };
    vector_field((0..blocks * blocks).map(footprint).collect(), ground, n)
}

pub(crate) fn uav_at(field: &HeightField, x: f64, y: f64, z: i64) -> Uav {
    let station = Station { place: field.place(x, y), z };
    Uav {
        id: "1".into(),
        station,
        height_agl_m: None,
        placement: HoversOver::Ground,
        antenna: Antenna::default(),
        up: None,
    }
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

pub(crate) fn map(field: &HeightField, uav: &Uav, options: &MapOptions) -> SiteCoverage {
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
        assert_eq!((&with_layers.mask, with_layers.tally), (&plain.mask, plain.tally));
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
        let bits = |map: &SiteCoverage| {
            let layers = [&map.margin, &map.least_receiver_height, &map.least_height];
            layers.map(|layer| layer.as_ref().unwrap().iter().map(|v| v.to_bits()).collect::<Vec<_>>())
        };
        for other in &all[1..] {
            assert_eq!((&all[0].mask, all[0].tally), (&other.mask, other.tally));
            assert_eq!(bits(&all[0]), bits(other));
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
fn a_receiver_on_a_roof_sees_what_its_own_roof_does_not_hide() {
    // One building of 10 m over 4…8 m; a UAV 20 m high straight over it sees all its roof, one at the side below the
    // roof sees none of it, and one level with the receivers sees them all.
    let ring = vec![[4096, 4096], [8192, 4096], [8192, 8192], [4096, 8192]];
    let house = Footprint::on_zero("a".into(), vec![vec![ring]], 10_240);
    let field = vector_field(vec![house], Ground::Flat(0), 12);
    for (x, z, rx_height, n_los) in
        [(6.0, 20_480, 1536, 16), (0.5, 5_000, 0, 0), (0.5, 11_776, 1536, 16), (0.5, 10_240, 0, 16)]
    {
        let options = MapOptions { rx_height, ..options(Receivers::Roof, ALL_LAYERS) };
        let found = map(&field, &uav_at(&field, x, 6.0, z), &options);
        assert_eq!((found.tally.receivers, found.tally.los), (16, n_los), "{x} {z} {rx_height}");
    }
}
