//! What does a map cost per cell, by engine, environment and size, beside the least that memory allows?
//!
//! `cargo bench --bench map` prints Markdown. `SKYSHED_BENCH=full` adds the large cities, `SKYSHED_BENCH=4096,8192` does
//! these sizes alone.
//!
//! One thread, one UAV 100 m over a street in the middle, receivers 1.5 m above what they stand on; the scene is made
//! ready before. *bits* is the set of receivers in line of sight and their number, *mask* a byte per cell and the tally by
//! elevation angle; *ceilings* and *least UAV heights* are in doubles. The *floor* is to read the heights of the city once (4 bytes a cell) and to write a mask once (1
//! byte a cell) into memory that is already there. Before anything is timed, every engine's mask is compared with `ray`.
//!
//! The program is not written with divan because a row is a ratio of figures that must be taken in turns, on the same
//! city, in the same minute: other users of the machine shift a figure by more than the engines differ.
//!
//! A figure is the median of wall time less the time for which the thread waited for a core, which Linux counts, over the
//! runs before and after which the core was not shared ([`quiet`]), or over all, marked with °, if there are too few of these;
//! *all* is that of all runs. Rays are timed five times, shared or not, and in large cities on a sample of the receivers, one
//! of as many as the row says.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a bench prints its table, and how far it is")]

mod cities;
mod quiet;

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;

use rayon::prelude::*;
use skyshed_core::city::{Ground, NodataAs, Solids};
use skyshed_core::coverage::{Control, MapOptions, Mapper, Tally, Uav, class};
use skyshed_core::height_field::{HeightField, Station};
use skyshed_core::los::{GridLos, GridReceivers, Method, MethodChoice, link_los};
use skyshed_core::quantity::VOID;
use skyshed_core::raster::{CellWindow, GeoRef, Raster};
use skyshed_core::simd::{SimdLevel, simd_levels};
use skyshed_io::read::{SurfaceOptions, read_surface};

use self::cities::{footprints, raster, surface_of, uav_in_the_middle};
use self::quiet::{Run, calibrate, is_enough, median, median_of_all, n_quiet, timed};

const ENVIRONMENTS: [&str; 4] = ["suburban", "urban", "dense-urban", "high-rise"];
const UAV_HEIGHT_M: f64 = 100.0;

/// Largest cities of which every receiver is compared with `ray` and in which every receiver has its ray timed; in larger
/// ones a sample is.
const COMPARED_WHOLE: usize = 1024;
const TIMED_WHOLE: usize = 512;
/// Quiet runs after which an engine has been timed often enough, and for how long they are looked for \[s\].
const QUIET_RUNS: usize = 15;
const LONGEST_S: f64 = 4.0;
/// Least number of receivers of a sample.
const SAMPLE: usize = 20_000;

fn main() {
    // Only `cargo bench` measures; whatever else runs this program wants to know that it starts.
    if !std::env::args().any(|word| word == "--bench") {
        return;
    }
    let asked = std::env::var("SKYSHED_BENCH").unwrap_or_default();
    let sizes: Vec<usize> = match asked.as_str() {
        "" => vec![512, 1024, 2048],
        "full" => vec![512, 1024, 2048, 4096, 8192, 16384],
        list => list.split(',').map(|n| n.parse().expect("SKYSHED_BENCH: wanted `full` or sizes")).collect(),
    };

    calibrate();
    println!(
        "| city | cells | engine | bits [ns/cell] | × floor | mask [ns/cell] | × floor | floor, read + write | quiet bits, masks | all bits |"
    );
    println!("|---|---|---|---:|---:|---:|---:|---:|---:|---:|");
    for &n in &sizes {
        for environment in ENVIRONMENTS {
            measure_city(environment, n);
        }
    }
    for &n in sizes.iter().filter(|n| **n >= 1024) {
        for lidar in LIDAR {
            match data() {
                Some(data) => measure_lidar(&data, &lidar, n),
                None => eprintln!("SKIPPED: {}, no LiDAR data", lidar.name),
            }
        }
    }
    if sizes.contains(&2048) {
        println!("\n| urban, 2048², bits [ns/cell] | shadow | sweep, ground | sweep, surface |");
        println!("|---|---:|---:|---:|");
        measure_levels("urban", 2048);
    }
}

/// A generated city: as footprints, and as a raster with receivers on the ground and on the surface.
fn measure_city(environment: &str, n: usize) {
    eprintln!("{environment} {n}²");
    let mut rows = Rows { city: environment.into(), n, floor: Vec::new() };
    let vector = footprints(environment, n);
    let uav = uav_in_the_middle(&vector, UAV_HEIGHT_M);
    let surface = surface_of(&vector);
    rows.measure("shadow, footprints", MethodChoice::Auto, &vector, (&uav, surface.cells()));
    rows.rays("ray, footprints", &vector, &uav);
    let grid = vector.grid().clone();
    drop(vector);

    let ground = raster(&grid, surface.clone(), Ground::Flat(0));
    let uav = uav_in_the_middle(&ground, UAV_HEIGHT_M);
    rows.measure("sweep, ground", MethodChoice::Sweep, &ground, (&uav, surface.cells()));
    rows.plateaus("shadow, ground", &ground, (&uav, surface.cells()));
    rows.rays("ray, ground", &ground, &uav);
    drop(ground);

    let heights = surface.cells().to_vec();
    let whole = raster(&grid, surface, Ground::Surface);
    rows.measure("sweep, surface", MethodChoice::Sweep, &whole, (&uav, &heights));
    rows.plateaus("shadow, surface", &whole, (&uav, &heights));
    rows.rays("ray, surface", &whole, &uav);
}

/// A laser-scanned city, mirrored at its edges until it fills `n` cells a side, so that no seam is a cliff.
struct Lidar {
    name: &'static str,
    surface: &'static str,
    terrain: &'static str,
}

const LIDAR: [Lidar; 2] = [
    Lidar { name: "Bilbao (hills, 2.5 m)", surface: "bilbao/dsm_2.5m.tif", terrain: "bilbao/terrain_2.5m.tif" },
    Lidar { name: "Delft (flat, voids)", surface: "delft/dsm_1m.tif", terrain: "delft/terrain_1m.tif" },
];

fn measure_lidar(folder: &Path, lidar: &Lidar, n: usize) {
    eprintln!("{} {n}²", lidar.name);
    let options = SurfaceOptions {
        terrain: Some(folder.join(lidar.terrain).into()),
        nodata_as: NodataAs::Clear,
        ..SurfaceOptions::default()
    };
    let scene = read_surface(folder.join(lidar.surface), &options, &mut Vec::new()).expect("the LiDAR data");
    let Solids::Raster { surface, ground: Ground::Terrain(terrain), .. } = scene.solids else {
        panic!("a surface over a terrain");
    };
    let grid = &scene.grid;
    let corner = (grid.x_min(), grid.y_max());
    let tiled = GeoRef::new(corner, (grid.cell_width(), grid.cell_height()), (n, n), grid.crs().cloned());
    let tiled = tiled.expect("a grid");
    let (surface, terrain) = (mirrored(&surface, &tiled), mirrored(&terrain, &tiled));
    let heights = surface.cells().to_vec();

    let mut rows = Rows { city: lidar.name.into(), n, floor: Vec::new() };
    let ground = raster(&tiled, surface.clone(), Ground::Terrain(terrain));
    let uav = uav_in_the_middle(&ground, UAV_HEIGHT_M);
    rows.measure("sweep, ground", MethodChoice::Sweep, &ground, (&uav, &heights));
    rows.rays("ray, ground", &ground, &uav);
    drop(ground);
    let whole = raster(&tiled, surface, Ground::Surface);
    rows.measure("sweep, surface", MethodChoice::Sweep, &whole, (&uav, &heights));
    rows.rays("ray, surface", &whole, &uav);
}

fn mirrored(tile: &Raster<i32>, grid: &GeoRef) -> Raster<i32> {
    let fold = |k: usize, n: usize| if (k / n).is_multiple_of(2) { k % n } else { n - 1 - k % n };
    let (n_rows, n_cols) = (tile.georef().n_rows(), tile.georef().n_cols());
    let cell = |k: usize| {
        let (row, col) = (k / grid.n_cols(), k % grid.n_cols());
        tile.row(fold(row, n_rows))[fold(col, n_cols)]
    };
    Raster::new(grid.clone(), (0..grid.n_cells()).map(cell).collect::<Vec<_>>())
}

/// The folder of LiDAR data: that of `SKYSHED_TRUTH`, or beside the repository.
fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("SKYSHED_TRUTH")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data"), PathBuf::from)
        .join("lidar");
    folder.is_dir().then_some(folder)
}

/// Every level of vector instructions on one city.
fn measure_levels(environment: &str, n: usize) {
    let vector = footprints(environment, n);
    let surface = surface_of(&vector);
    let ground = raster(vector.grid(), surface.clone(), Ground::Flat(0));
    let whole = raster(vector.grid(), surface, Ground::Surface);
    let engines = [(&vector, Method::Shadow), (&ground, Method::Sweep), (&whole, Method::Sweep)];
    // A place is on the lattice of the scene that it was made for alone. The middle of the surface is any cell, a roof as well.
    let uavs = [&vector, &ground, &ground].map(|field| uav_in_the_middle(field, UAV_HEIGHT_M));
    let levels = simd_levels();
    let mut samples = vec![vec![Vec::new(); engines.len()]; levels.len()];
    for _ in 0..31 {
        for (level, samples) in levels.iter().zip(&mut samples) {
            for (((field, method), uav), samples) in engines.iter().zip(&uavs).zip(samples) {
                let receivers = receivers(field);
                let mut los = GridLos::new(field, *method).expect("a method for the scene");
                los.level = *level;
                samples.push(on_one_thread(|| bits(&los, uav, &receivers)));
            }
        }
    }
    for (level, samples) in levels.iter().zip(samples) {
        let figures: Vec<String> = samples.iter().map(|s| format!("{:.2}", per_cell(median(s), n))).collect();
        println!("| {} | {} |", name_of(*level), figures.join(" | "));
    }
}

/// `Avx2`, of `Avx2(Avx2 { … })`.
fn name_of(level: SimdLevel) -> String {
    format!("{level:?}").split(['(', ' ']).next().unwrap_or_default().to_lowercase()
}

/// The rows of one city.
struct Rows {
    city: String,
    n: usize,
    floor: Vec<Floor>,
}

#[derive(Clone, Copy)]
struct Floor {
    read: Run,
    write: Run,
}

impl Rows {
    /// The shadows of a raster's plateaus, where `auto` takes them: not in small rasters.
    fn plateaus(&mut self, engine: &str, field: &HeightField, on: (&Uav, &[i32])) {
        if field.plateaus().is_some() {
            self.measure(engine, MethodChoice::Shadow, field, on);
        }
    }

    /// Compares an engine with `ray`, then times it in turns with the floor.
    fn measure(&mut self, engine: &str, method: MethodChoice, field: &HeightField, (uav, heights): (&Uav, &[i32])) {
        let options = MapOptions { method, ..MapOptions::default() };
        let mapper = Mapper::new(field, &options).expect("an engine for the scene");
        let compared = self.compare(&mapper, field, uav);
        let los = GridLos::new(field, mapper.method().0).expect("a method for the scene");
        let receivers = receivers(field);

        let mut mask = vec![0; heights.len()];
        let (mut floor, mut of_bits, mut of_mask) = (Vec::new(), Vec::new(), Vec::new());
        let begin = Instant::now();
        // Quiet moments are as short as a run, so more than a few of these may be needed.
        let wanted = |runs: &[Run]| n_quiet(runs) < QUIET_RUNS && begin.elapsed().as_secs_f64() < LONGEST_S;
        while of_bits.len() < 3 || wanted(&of_bits) || wanted(&of_mask) {
            on_one_thread(|| {
                // The floor is that of warm caches, whatever the engine before it has left there.
                black_box(sum(heights));
                floor.push(Floor { read: timed(|| sum(heights)), write: timed(|| fill(&mut mask)) });
                of_bits.push(bits(&los, uav, &receivers));
                of_mask.push(timed(|| {
                    mapper.seen_from(uav).expect("a view").map(&Control::default()).map(|map| map.tally)
                }));
            });
        }
        self.floor = floor;
        self.print(engine, &of_bits, &of_mask);
        self.heights(engine, &los, &receivers, uav);
        eprintln!("  {engine}: {compared} receivers as `ray` has them");
    }

    /// Times the least heights of receivers and of the UAV, where the engine finds them at once.
    fn heights(&self, engine: &str, los: &GridLos<'_>, receivers: &GridReceivers<'_>, uav: &Uav) {
        let (station, cells, n_cols) = (&uav.station, &receivers.cells, receivers.cells.n_cols());
        let window = CellWindow { row: 0, col: 0, n_rows: cells.n_rows(), n_cols };
        let of_receivers = || los.los_and_least_heights(station, receivers, cells, window);
        let height = |row: usize, col: usize| receivers.base(row * n_cols + col) + MapOptions::default().rx_height;
        let of_uav = || los.least_uav_heights(station, cells, 0, &height);
        let times = |run: &(dyn Fn() -> bool + Sync)| -> Vec<Run> {
            if on_one_thread(run) { (0..5).map(|_| on_one_thread(|| timed(run))).collect() } else { Vec::new() }
        };
        let named = [
            ("ceilings", times(&|| black_box(of_receivers()).is_some())),
            ("least UAV heights", times(&|| black_box(of_uav()).is_some())),
        ];
        for (what, runs) in named.iter().filter(|(_, runs)| !runs.is_empty()) {
            self.print(&format!("{engine}, {what}"), runs, &[]);
        }
    }

    /// Times a ray for each receiver, or for a sample.
    fn rays(&self, engine: &str, field: &HeightField, uav: &Uav) {
        let whole = self.n <= TIMED_WHOLE;
        let step = if whole { 1 } else { sample_step(field) };
        let stations: Vec<Station> = sample(field, step).map(|(_, station)| station).collect();
        let count = || stations.iter().filter(|s| link_los(field, &uav.station, s)).count();
        let share = field.cells().open.count() as f64 / stations.len() as f64;
        let runs: Vec<Run> = (0..5).map(|_| on_one_thread(|| timed(count)).times(share)).collect();
        let name = if whole { engine.to_string() } else { format!("{engine} (1 of {step})") };
        self.print(&name, &runs, &[]);
    }

    fn print(&self, engine: &str, bits: &[Run], mask: &[Run]) {
        let of = |part: fn(&Floor) -> Run| per_cell(median(&self.floor.iter().map(part).collect::<Vec<_>>()), self.n);
        let (read, write) = (of(|f| f.read), of(|f| f.write));
        let figures = |runs: &[Run]| match runs {
            [] => "– | –".into(),
            _ => {
                let ns = per_cell(median(runs), self.n);
                format!("{ns:.2}{} | {:.1}", if is_enough(runs) { "" } else { "°" }, ns / (read + write))
            }
        };
        let Rows { city, n, .. } = self;
        let all = per_cell(median_of_all(bits), self.n);
        println!(
            "| {city} | {n}² | {engine} | {} | {} | {read:.2} + {write:.2} | {}, {} of {} | {all:.2} |",
            figures(bits),
            figures(mask),
            n_quiet(bits),
            n_quiet(mask),
            bits.len()
        );
    }

    /// Compares a map with `ray`: every receiver, or a sample. Returns their number.
    fn compare(&self, mapper: &Mapper<'_>, field: &HeightField, uav: &Uav) -> usize {
        let map = mapper.seen_from(uav).expect("a view").map(&Control::default()).expect("nobody interrupts");
        let n_cells = self.n * self.n;
        let step = if self.n <= COMPARED_WHOLE { 1 } else { sample_step(field) };
        let compared: Vec<(usize, Station)> = sample(field, step).collect();
        assert!(step == 1 || compared.len() >= SAMPLE, "{} receivers are too few", compared.len());
        let wrong = compared.par_iter().find_any(|(cell, station)| {
            map.mask[*cell] != if link_los(field, &uav.station, station) { class::LOS } else { class::NLOS }
        });
        assert!(wrong.is_none(), "{}: the engine and `ray` differ in cell {wrong:?}", self.city);

        assert_eq!(map.mask.len(), n_cells);
        assert_eq!(Tally::of_mask(&map.mask).los, map.tally.los, "the tally does not count the mask");
        let los = GridLos::new(field, mapper.method().0).expect("a method for the scene");
        let receivers = receivers(field);
        let bits = los.los(&uav.station, &receivers, &receivers.cells, field.grid().window());
        assert_eq!(
            (bits.count(), mapper.seen_from(uav).expect("a view").count().1),
            (map.tally.los, map.tally.los),
            "bits and mask differ"
        );
        compared.len()
    }
}

/// Receivers 1.5 m above open ground.
fn receivers(field: &HeightField) -> GridReceivers<'_> {
    let above = MapOptions::default().rx_height;
    GridReceivers::new(&field.cells().open, field.ground_of_cells(), above)
}

/// How many cells apart those of a sample are; odd, so that a sample meets all columns.
fn sample_step(field: &HeightField) -> usize {
    let n = usize::try_from(field.cells().open.count()).expect("fewer than 2^32 cells");
    // Twice as many as wanted, because open cells are not spread evenly.
    (n / (2 * SAMPLE)).max(1) | 1
}

/// Every `step`th cell that holds a receiver, and the receiver.
fn sample(field: &HeightField, step: usize) -> impl Iterator<Item = (usize, Station)> {
    let positions = field.positions();
    let n_cols = field.grid().n_cols();
    let above = i64::from(MapOptions::default().rx_height);
    (0..field.grid().n_cells())
        .filter(move |cell| field.cells().open.contains(cell / n_cols, cell % n_cols))
        .step_by(step)
        .map(move |cell| {
            let place = positions.center(cell / n_cols, cell % n_cols);
            let ground = field.ground_at(&place);
            assert_ne!(ground, VOID, "an open cell has ground");
            (cell, Station { place, z: i64::from(ground) + above })
        })
}

/// Finds the bits of a map and their count.
fn bits(los: &GridLos<'_>, uav: &Uav, receivers: &GridReceivers<'_>) -> Run {
    let window = CellWindow { row: 0, col: 0, n_rows: receivers.cells.n_rows(), n_cols: receivers.cells.n_cols() };
    timed(|| los.los(&uav.station, receivers, &receivers.cells, window).count())
}

/// Reads all heights.
fn sum(heights: &[i32]) -> i32 {
    black_box(heights).iter().fold(0, |sum, h| sum ^ h)
}

/// Writes all of a mask.
fn fill(mask: &mut [u8]) {
    black_box(&mut *mask).fill(black_box(1));
    black_box(mask);
}

/// Runs some work in a pool of one thread.
fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    static ONE: std::sync::OnceLock<rayon::ThreadPool> = std::sync::OnceLock::new();
    let one = || rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    ONE.get_or_init(one).install(work)
}

/// Nanoseconds per cell of a city of `n` cells a side.
fn per_cell(seconds: f64, n: usize) -> f64 {
    seconds * 1e9 / (n * n) as f64
}
