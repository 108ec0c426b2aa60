//! `shadow` against `ray`, cell for cell: tiny scenes full of ties, generated cities, a real one; every SIMD level, any
//! number of bands, any subset of cells.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "small numbers, and a panic is a failed test"
)]

use std::path::Path;

use rayon::ThreadPoolBuilder;
use skyshed_core::city::BuiltUp;
use skyshed_core::height_field::{CellKind, HeightField, Prisms, Station};
use skyshed_core::los::{
    GridHeights, LeastHeight, ShadowGrid, ShadowLos, ShadowScene, prisms_least_height, prisms_least_receiver_height,
    prisms_los, shadow_least_heights, shadow_least_receiver_heights, shadow_los, shadow_los_relief,
};
use skyshed_core::quantity::{LatticePoint, VOID};
use skyshed_core::raster::BitGrid;
use skyshed_core::simd::{SimdLevel, simd_levels};
use skyshed_io::read::{FootprintOptions, read_footprints};
use skyshed_request::{GroundChoice, MissingHeights, WithoutHeight};

use crate::oracle::Prism;
use crate::referee::{Count, check_cells, over_seeds};
use crate::shapes::{M, block, catalogue, moved, prism, random_prisms, star, turn};
use crate::support::{ENVIRONMENTS, Random, cells_where, city, is_long};
use crate::translation::prisms_of;

/// Receivers of a scene: positions of columns and rows, and the height of each cell.
pub(crate) struct Field {
    pub(crate) xs: Vec<i64>,
    pub(crate) ys: Vec<i64>,
    pub(crate) heights: Vec<i32>,
    pub(crate) wanted: BitGrid,
}

/// Both answers are common; `ray` is asked about fewer than one in `rarely` cells, if about any.
fn assert_decided(count: Count, rarely: u64) {
    assert!(count.los > count.links / 20 && count.los < count.links - count.links / 20, "{count:?}");
    assert!(count.asked * rarely < count.links, "{count:?}");
}

impl Field {
    fn height(&self, row: usize, col: usize) -> i32 {
        self.heights[row * self.xs.len() + col]
    }

    /// The height of all receivers, if it is the same.
    fn level(&self) -> Option<i64> {
        let first = *self.heights.first()?;
        self.heights.iter().all(|z| *z == first).then_some(i64::from(first))
    }

    fn cast(&self, prisms: &Prisms, uav: LatticePoint, level: SimdLevel, n_bands: usize) -> ShadowLos {
        let grid = ShadowGrid::new(self.xs.clone(), self.ys.clone());
        let scene =
            ShadowScene { prisms, casters: prisms.casters(), grid: &grid, wanted: &self.wanted, level, n_bands };
        match self.level() {
            Some(z) => shadow_los(&scene, uav, z),
            None => shadow_los_relief(&scene, uav, &|row, col| self.height(row, col)),
        }
    }

    /// Asserts that the least heights that are found above `from`, as the numbers that files hold and as steps of the lattice, are
    /// those of walks; returns how many links were compared and how many of them were left to walks.
    pub(crate) fn compare_heights(
        &self,
        prisms: &Prisms,
        uav: LatticePoint,
        from: i64,
        context: &(impl Fn() -> String + Sync),
    ) -> (u64, u64) {
        let grid = ShadowGrid::new(self.xs.clone(), self.ys.clone());
        let casters = prisms.casters();
        let level = SimdLevel::new();
        let scene = ShadowScene { prisms, casters, grid: &grid, wanted: &self.wanted, level, n_bands: 1 };
        let height = |row, col| self.height(row, col);
        let of_receivers = shadow_least_receiver_heights(&scene, uav, from).unwrap();
        let of_uav = shadow_least_heights(&scene, uav, from, &height).unwrap();
        let (mut n, mut n_left) = (0, 0);
        for cell in self.wanted.cells() {
            let receiver =
                LatticePoint { x: self.xs[cell.1], y: self.ys[cell.0], z: i64::from(height(cell.0, cell.1)) };
            let mut check = |found: &GridHeights, walk: LeastHeight, what: &str| {
                let from = from as f64;
                let single = |z: f64| z.max(from) as f32;
                // Far above all heights a walk no longer counts steps.
                let up = |z: f64| z.max(from).ceil().min(1e9) + 0.0;
                let steps = walk.lowest_step().map_or(f64::INFINITY, |step| step as f64);
                // Where two slopes cross along a wall the walk itself rounds.
                let is_rounded =
                    walk.height_steps().is_finite() && !(0.0..=1.001).contains(&(steps - walk.height_steps()));
                let steps = if is_rounded { walk.height_steps().ceil() } else { steps }.max(from).min(1e9);
                let (found, found_up) = (found.settled(cell, single), found.settled(cell, up));
                let is_it = found.is_none_or(|found| found.to_bits() == single(walk.height_steps()).to_bits());
                let is_up = found_up.is_none_or(|found| found.to_bits() == steps.to_bits());
                let what = || format!("{what} at {receiver:?} from {uav:?}, above {from}: {}", context());
                assert!(is_it && is_up, "{}: {found:?} {found_up:?}, wanted {walk:?}", what());
                n += 1;
                n_left += u64::from(found.is_none());
            };
            check(&of_receivers, prisms_least_receiver_height(prisms, uav, receiver), "receiver");
            check(&of_uav, prisms_least_height(prisms, uav, receiver), "UAV");
        }
        (n, n_left)
    }

    /// Asserts that `shadow` says of each wanted cell what `ray` says, and nothing of others.
    fn compare(&self, prisms: &Prisms, uav: LatticePoint, context: &(impl Fn() -> String + Sync)) -> Count {
        let found = self.cast(prisms, uav, SimdLevel::new(), 1);
        let receiver = |row: usize, col: usize| LatticePoint {
            x: self.xs[col],
            y: self.ys[row],
            z: i64::from(self.height(row, col)),
        };
        let ray = |row: usize, col: usize| prisms_los(prisms, uav, receiver(row, col));
        let count = check_cells(&found.los, &self.wanted, ray, || format!("from {uav:?}: {}", context()));
        assert_eq!(found.count, count.los);
        Count { asked: found.asked, ..count }
    }
}

// ---------------------------------------------------------------------------------------------------------------------
// Tiny scenes.

/// Up to six footprints on the integers 0..=6: rectangles, triangles, stars, shapes with holes, rows of houses.
fn tiny_scene(random: &mut Random) -> Vec<Prism> {
    match random.within(0, 9) {
        0..=3 => random_prisms(random),
        4 => {
            let scenes = catalogue();
            scenes[random.below(scenes.len())].1.clone()
        }
        5 => {
            // Houses wall to wall, some of equal height.
            let mut west = 0;
            let mut row = Vec::new();
            while west < 6 {
                let east = west + random.within(1, 2);
                let south = random.choose(&[1, 1, 2]);
                row.push(block(west, south, east, random.choose(&[4, 4, 5]), random.choose(&[2, 2, 3])));
                west = east;
            }
            row
        }
        6 => (0..random.within(1, 5))
            .map(|_| {
                loop {
                    let mut corner = || [random.within(0, 6), random.within(0, 6)];
                    let [a, b, c] = [corner(), corner(), corner()];
                    if turn(a, b, c) != 0 {
                        break prism(&[a, b, c], random.within(1, 5));
                    }
                }
            })
            .collect(),
        7 => {
            // A square cut along its diagonals, roofs alike or not.
            let (w, e) = (random.within(0, 2), random.within(4, 6));
            let (m, t) = ((w + e) / 2, random.within(1, 4));
            let corners = [[w, w], [e, w], [e, e], [w, e]];
            (0..4)
                .map(|k| prism(&[corners[k], corners[(k + 1) % 4], [m, m]], t + i64::from(random.chance(20))))
                .collect()
        }
        _ => (0..random.within(1, 3)).map(|_| prism(&star(random, 6), random.within(1, 5))).collect(),
    }
}

/// A grid over such a scene, its cell centers on walls, half-way, or anywhere; sometimes with cells of odd size.
pub(crate) fn tiny_field(random: &mut Random, prisms: &[Prism]) -> Field {
    let cell = random.choose(&[1024.0, 1024.0, 512.0, 256.0, 307.2, 716.8, 333.0]);
    let n = ((9.0 * 1024.0 / cell) as usize + random.index(1, 3)).min(30);
    let offset = random.choose(&[-1024, -512, -1536, 0, 17]) as f64;
    let positions: Vec<i64> = (0..n).map(|k| (offset + k as f64 * cell + 0.5).floor() as i64).collect();
    let (n_rows, n_cols) = (n - random.below(2), n);
    let height = |random: &mut Random| {
        let top = prisms[random.below(prisms.len())].top;
        random.choose(&[0, 0, -1, 512, 1024, 1536, 2048, top, top - 1, top + 1, 7000]) as i32
    };
    let heights = match random.within(0, 3) {
        0 => {
            let choice: Vec<i32> = (0..3).map(|_| height(random)).collect();
            (0..n_rows * n_cols).map(|_| random.choose(&choice)).collect()
        }
        1 => {
            // A slope.
            let (base, east, north) = (height(random), random.within(-40, 40) as i32, random.within(-40, 40) as i32);
            (0..n_rows * n_cols).map(|i| base + east * (i % n_cols) as i32 + north * (i / n_cols) as i32).collect()
        }
        _ => vec![height(random); n_rows * n_cols],
    };
    let share = random.choose(&[100, 100, 60, 5]);
    let wanted = cells_where((n_rows, n_cols), |_, _| random.chance(share));
    Field { ys: positions[..n_rows].iter().rev().copied().collect(), xs: positions, heights, wanted }
}

/// A UAV where something coincides: on a vertex, along an edge, over a roof, at a roof's height, at a cell.
pub(crate) fn tiny_uav(random: &mut Random, prisms: &[Prism], field: &Field) -> LatticePoint {
    let of = &prisms[random.below(prisms.len())];
    let ring = &of.rings[random.below(of.rings.len())];
    let k = random.below(ring.len());
    let (a, b) = (ring[k], ring[(k + 1) % ring.len()]);
    let along = |n: i64, d: i64| [a[0] + (b[0] - a[0]) * n / d, a[1] + (b[1] - a[1]) * n / d];
    let [x, y] = match random.within(0, 6) {
        0 => a,
        1 => along(random.within(1, 3), 4),
        2 => along(random.choose(&[-3, -2, -1, 2, 3]), 1),
        3 => [random.choose(&field.xs), random.choose(&field.ys)],
        4 => [random.within(-2, 8) * M, random.within(-2, 8) * M],
        5 => [random.within(-2, 16) * M / 2, random.within(-2, 16) * M / 2],
        _ => [random.within(-3000, 9000), random.within(-3000, 9000)],
    };
    let z = match random.within(0, 5) {
        0 => of.top,
        1 => of.top + random.choose(&[-1, 1]),
        2 => i64::from(random.choose(&field.heights)) + random.choose(&[-1, 0, 0, 1]),
        3 => random.within(-1, 7) * M,
        _ => random.within(0, 40) * M / 2,
    };
    LatticePoint { x, y, z }
}

/// A scene of [`tiny_scene`] in lattice units, in which a meter of the plane is not always a cell.
pub(crate) fn scaled_scene(random: &mut Random) -> Vec<Prism> {
    let scale = random.choose(&[1024, 1024, 1024, 1000, 512]);
    moved(&tiny_scene(random), |[x, y]| [x * scale, y * scale], |top| top * 1024)
}

#[test]
fn shadow_equals_ray_on_tiny_scenes_where_everything_coincides() {
    let count = over_seeds(if is_long() { 400_000 } else { 24_000 }, 0, |seed, random, count| {
        let scene = scaled_scene(random);
        let prisms = prisms_of(&scene);
        if prisms.pieces().is_empty() {
            return;
        }
        let field = tiny_field(random, &scene);
        for _ in 0..4 {
            let uav = tiny_uav(random, &scene, &field);
            *count += field.compare(&prisms, uav, &|| format!("seed {seed}, {scene:?}"));
        }
    });
    assert_decided(count, 2);
    assert!(count.links > 20_000_000, "{count:?}");
    assert!(count.asked > count.links / 1000, "scenes without ties: {count:?}");
}

#[test]
fn a_wall_shared_by_equal_roofs_hides_what_looks_along_it_and_a_gap_of_one_step_does_not() {
    // Two houses of equal height that share part of a wall at x = 2 m, so that they are no convex union; the UAV and a
    // column of receivers look along the wall.
    for (gap, sees) in [(0, false), (1, true)] {
        let houses = [block(0, 0, 2 * M, 4 * M, 3 * M), block(2 * M + gap, M, 4 * M, 5 * M, 3 * M)];
        let prisms = prisms_of(&houses);
        let ys: Vec<i64> = (0..8).map(|k| -k * M / 2 - 1).collect();
        let wanted = BitGrid::full(ys.len(), 1);
        let field = Field { xs: vec![2 * M], heights: vec![0; ys.len()], ys, wanted };
        let uav = LatticePoint { x: 2 * M, y: 9 * M, z: 4 * M };
        let count = field.compare(&prisms, uav, &|| format!("gap {gap}"));
        assert_eq!(count.los == count.links, sees, "gap {gap}: {count:?}");
        assert!(count.asked > 0);
    }
}

#[test]
fn least_heights_are_those_of_walks_on_tiny_scenes_where_everything_coincides() {
    let totals = over_seeds(if is_long() { 200_000 } else { 6_000 }, 1 << 40, |seed, random, count| {
        let scene = scaled_scene(random);
        let prisms = prisms_of(&scene);
        if prisms.pieces().is_empty() {
            return;
        }
        let field = tiny_field(random, &scene);
        let uav = tiny_uav(random, &scene, &field);
        let lowest = i64::from(*field.heights.iter().min().unwrap());
        let from = random.choose(&[lowest, lowest - 1536, uav.z, -20_000, 2048]);
        let (n, n_left) = field.compare_heights(&prisms, uav, from, &|| format!("seed {seed}, {scene:?}"));
        *count += Count { links: n, asked: n_left, ..Count::default() };
    });
    assert!(totals.links > 3_000_000 && totals.asked > 10_000, "{totals:?}");
    assert!(totals.asked * 5 < totals.links, "{totals:?}");
}

// ---------------------------------------------------------------------------------------------------------------------
// Cities.

/// The receivers of a scene, on the ground or on all cells, `rx` \[steps\] above what they stand on, on hills if asked;
/// `share` percent of them wanted.
fn receivers(field: &HeightField, rx: i32, with_roofs: bool, share: u64, hills: f64) -> Field {
    let positions = field.positions();
    let (n_rows, n_cols) = (field.grid().n_rows(), field.grid().n_cols());
    let mut random = Random(share);
    let (xs, ys) = positions.on_prisms();
    let mut found = Field { xs, ys, heights: vec![rx; n_rows * n_cols], wanted: BitGrid::new(n_rows, n_cols) };
    for row in 0..n_rows {
        for col in 0..n_cols {
            let index = row * n_cols + col;
            let stands_on = match field.cell_kind(index, &positions.center(row, col)) {
                CellKind::Open(z) => z,
                CellKind::Building(z) if with_roofs => z,
                _ => continue,
            };
            let hill = hills * ((row as f64 / 40.0).sin() + (col as f64 / 60.0).cos());
            found.heights[index] = stands_on + rx + (hill * 1024.0) as i32;
            if random.chance(share) {
                found.wanted.insert(row, col);
            }
        }
    }
    // Cells that nobody stands on do not make a level field uneven.
    let level = (0..n_rows * n_cols).find(|i| found.wanted.contains(i / n_cols, i % n_cols)).map(|i| found.heights[i]);
    if let Some(level) = level.filter(|_| !with_roofs && hills == 0.0) {
        found.heights.fill(level);
    }
    found
}

/// The lattice point of a UAV, lifted onto the roof below it where it is not above that.
fn over_roofs(field: &HeightField, x: f64, y: f64, height_m: i64) -> LatticePoint {
    let place = field.place(x, y);
    let z = i64::from(field.roof_at(&place).unwrap_or(VOID)).max(height_m * 1024);
    Station { place, z }.on_prisms()
}

/// UAVs over a street, a crossroad, a roof and beside the city, at heights from 2 to 500 m; not inside a building.
fn uavs_over(field: &HeightField, city: &BuiltUp) -> Vec<LatticePoint> {
    let (street, width) = (city.street_width(), city.building_width());
    let middle = 2.0 * city.period();
    let places = [
        (middle + street / 2.0, middle + street + width / 2.0),
        (middle + street / 2.0, middle + street / 2.0),
        (middle + street + width / 2.0, middle + street + width / 3.0),
        (-20.0, 31.5),
    ];
    places.iter().flat_map(|(x, y)| [2, 10, 30, 100, 500].map(|height| over_roofs(field, *x, *y, height))).collect()
}

#[test]
fn shadow_equals_ray_on_generated_cities() {
    let (size, seeds) = if is_long() { (400.0, 1..6) } else { (200.0, 1..3) };
    let mut all = Count::default();
    for seed in seeds {
        for name in ENVIRONMENTS {
            let built_up = BuiltUp::named(name).unwrap();
            let field = city(name, size, 1.0, seed);
            let ground = receivers(&field, 1536, false, 100, 0.0);
            let all_cells = receivers(&field, 1536, true, 100, 0.0);
            let hilly = receivers(&field, 1536, true, 30, 4.0);
            for uav in uavs_over(&field, &built_up) {
                for (receivers, what) in [(&ground, "ground"), (&all_cells, "all"), (&hilly, "hills")] {
                    let context = || format!("{name}, seed {seed}, {what}");
                    all += receivers.compare(field.prisms().unwrap(), uav, &context);
                }
            }
        }
    }
    assert_decided(all, 200);
    assert!(all.links > 8_000_000, "{all:?}");
}

#[test]
fn shadow_equals_ray_on_cells_of_odd_size() {
    let mut all = Count::default();
    for (name, cell, size) in [("urban", 0.3, 60.0), ("high-rise", 0.7, 150.0), ("suburban", 2.3, 500.0)] {
        let built_up = BuiltUp::named(name).unwrap();
        let field = city(name, size, cell, 3);
        let receivers = receivers(&field, 1536, false, 100, 0.0);
        for uav in uavs_over(&field, &built_up) {
            all += receivers.compare(field.prisms().unwrap(), uav, &|| format!("{name} at {cell} m"));
        }
    }
    assert_decided(all, 20);
    assert!(all.asked > 0);
}

#[test]
fn least_heights_are_those_of_walks_on_cities() {
    let (mut n, mut n_left) = (0, 0);
    let mut check = |field: &HeightField, receivers: &Field, uav: LatticePoint, what: &str| {
        let prisms = field.prisms().unwrap();
        for from in [0, uav.z] {
            let (links, left) = receivers.compare_heights(prisms, uav, from, &|| what.into());
            n += links;
            n_left += left;
        }
    };
    let step = if is_long() { 1 } else { 3 };
    for (name, cell, size) in [("urban", 1.0, 200.0), ("high-rise", 0.7, 150.0), ("suburban", 2.3, 500.0)] {
        let field = city(name, size, cell, 3);
        let built_up = BuiltUp::named(name).unwrap();
        let all = receivers(&field, 1536, true, 30, 4.0);
        let ground = receivers(&field, 1536, false, 60, 0.0);
        for (k, uav) in uavs_over(&field, &built_up).into_iter().enumerate().step_by(step) {
            check(&field, if k % 2 == 0 { &ground } else { &all }, uav, name);
        }
    }
    for terrain in [false, true] {
        let field = munich(terrain);
        let receivers =
            receivers(&field, 1536, terrain, if is_long() { 60 } else { 3 }, if terrain { 6.0 } else { 0.0 });
        let grid = field.grid();
        for (x, y, height) in [(600.0, 500.0, 100), (430.5, 690.5, 20), (1300.0, 200.0, 400)] {
            check(&field, &receivers, over_roofs(&field, grid.x_min() + x, grid.y_min() + y, height), "Munich");
        }
    }
    assert!(n > 1_000_000 && n_left > 0 && n_left * 1000 < n, "{n} {n_left}");
}

fn munich(terrain: bool) -> HeightField {
    let maps = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps");
    let options = FootprintOptions {
        top_field: Some("z_top".into()),
        missing: MissingHeights::only(WithoutHeight::Fail),
        terrain: terrain.then(|| maps.join("munich_terrain.tif").into()),
        ground: (!terrain).then_some(GroundChoice::Flat(0.0)),
        ..FootprintOptions::default()
    };
    let scene = read_footprints(maps.join("munich.geojson"), &options, &mut Vec::new()).unwrap();
    HeightField::build(&scene.grid, scene.solids).field
}

#[test]
fn shadow_equals_ray_on_munich() {
    let share = if is_long() { 100 } else { 4 };
    let mut all = Count::default();
    for terrain in [false, true] {
        let field = munich(terrain);
        let grid = field.grid();
        let prisms = field.prisms().unwrap();
        let fields = if terrain {
            vec![receivers(&field, 1536, false, share, 6.0), receivers(&field, 1536, true, share, 0.0)]
        } else {
            vec![receivers(&field, 1536, false, share, 0.0)]
        };
        for (east, north, height) in [(0.5, 0.5, 30), (0.3, 0.6, 60), (0.7, 0.25, 120), (0.1, 0.9, 3), (0.5, 0.4, 400)]
        {
            let x = grid.x_min() + east * (grid.x_max() - grid.x_min());
            let y = grid.y_min() + north * (grid.y_max() - grid.y_min());
            let uav = over_roofs(&field, x, y, height);
            for receivers in &fields {
                all += receivers.compare(prisms, uav, &|| format!("Munich, {height} m"));
            }
        }
    }
    assert_decided(all, 1000);
    assert!(all.links > 300_000, "{all:?}");
}

// ---------------------------------------------------------------------------------------------------------------------
// What must not matter.

#[test]
fn every_simd_level_and_any_number_of_bands_and_threads_give_the_same_bits() {
    let levels = simd_levels();
    assert!(levels.len() > 1);
    let mut n_asked = 0;
    for (name, cell) in [("urban", 0.7), ("high-rise", 1.0)] {
        let built_up = BuiltUp::named(name).unwrap();
        let field = city(name, 300.0, cell, 5);
        let prisms = field.prisms().unwrap();
        for receivers in [receivers(&field, 1536, false, 100, 0.0), receivers(&field, 1536, true, 100, 2.0)] {
            for uav in uavs_over(&field, &built_up).into_iter().step_by(3) {
                let expected = receivers.cast(prisms, uav, SimdLevel::new(), 1);
                n_asked += expected.asked;
                for level in &levels {
                    assert_eq!(receivers.cast(prisms, uav, *level, 1), expected, "{level:?}");
                }
                for n_threads in [1, 2, 7] {
                    let pool = ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
                    let found = pool.install(|| receivers.cast(prisms, uav, SimdLevel::new(), n_threads));
                    assert_eq!((found.los, found.count), (expected.los.clone(), expected.count), "{n_threads} threads");
                }
            }
        }
    }
    assert!(n_asked > 0, "no cell was in doubt, so its handling was not compared");
}

#[test]
fn nothing_wanted_nothing_found_and_without_prisms_all_is_seen() {
    let field = city("urban", 100.0, 1.0, 1);
    let uav = LatticePoint { x: 1024, y: 1024, z: 50 * 1024 };
    let mut receivers = receivers(&field, 1536, false, 100, 0.0);
    let clear = receivers.cast(&Prisms::new([] as [(Vec<[i32; 2]>, i32, u32); 0]), uav, SimdLevel::new(), 3);
    assert_eq!((clear.count, &clear.los), (receivers.wanted.count(), &receivers.wanted));
    receivers.wanted = BitGrid::new(100, 100);
    assert_eq!(receivers.cast(field.prisms().unwrap(), uav, SimdLevel::new(), 3).count, 0);
    let empty = Field { xs: Vec::new(), ys: Vec::new(), heights: Vec::new(), wanted: BitGrid::new(0, 0) };
    assert_eq!(empty.cast(field.prisms().unwrap(), uav, SimdLevel::new(), 1).count, 0);
}
