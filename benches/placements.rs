//! How long do 1000 placements of a UAV over 1 km² take, P_LoS of each, on all cores? And the search over a grid of 100 ×
//! 100 candidates, 60 m above ground, on cells of 2 m, as `skyshed place --step 10` makes it?
//!
//! `cargo bench --bench placements`. Cells of 1 m, receivers 1.5 m above all open ground, buildings as footprints; the
//! scene is made ready before. Placements are at random over the open cells, off the cell centers. Before timing, the
//! masks of some of them are compared with `ray`, cell for cell.

#[expect(dead_code, reason = "rasters, and the UAV in the middle, are for the other benches")]
mod cities;

use std::fmt;
use std::path::Path;

use divan::Bencher;
use divan::counter::ItemsCount;
use rayon::prelude::*;
use skyshed_core::city::{BuiltUp, BuiltUpCity, Site};
use skyshed_core::coverage::{Control, MapOptions, Mapper, Uav};
use skyshed_core::height_field::HeightField;
use skyshed_core::los::MethodChoice;
use skyshed_core::quantity::Height;
use skyshed_io::read::{FootprintOptions, read_footprints};
use skyshed_study::placement::{CandidateRules, Candidates, PlaceGrid, Scorer, ranked, scores_over_grid};

fn main() {
    divan::main();
}

const PLACEMENTS: usize = 1000;
const COMPARED: usize = 5;

/// Where, and how high above ground \[m\].
#[derive(Debug, Clone, Copy)]
struct Case(City, f64);

#[derive(Debug, Clone, Copy)]
enum City {
    Urban,
    Munich,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {} m", self.0, self.1)
    }
}

impl fmt::Display for City {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            City::Urban => "itu:urban",
            City::Munich => "Munich",
        })
    }
}

const CASES: [Case; 4] =
    [Case(City::Urban, 60.0), Case(City::Urban, 100.0), Case(City::Munich, 60.0), Case(City::Munich, 100.0)];

#[divan::bench(args = CASES, sample_count = 5, sample_size = 1)]
fn p_los_of_1000_placements(bencher: Bencher<'_, '_>, Case(city, height_m): Case) {
    let field = match city {
        City::Urban => cities::footprints("urban", 1000),
        City::Munich => munich(1.0),
    };
    let uavs = placements(&field, height_m);
    let options = MapOptions::default();
    let mapper = Mapper::new(&field, &options).expect("`auto` decides any scene");
    compare_with_rays(&field, &mapper, &uavs[..COMPARED]);
    let p_los = |uav: &Uav| {
        let (receivers, los) = mapper.seen_from(uav).expect("a view").count();
        los as f64 / receivers as f64
    };
    bencher.counter(ItemsCount::new(PLACEMENTS)).bench(|| uavs.par_iter().map(p_los).collect::<Vec<f64>>());
}

#[divan::bench(args = [City::Urban, City::Munich], sample_count = 5, sample_size = 1)]
fn search_of_10000_candidates(bencher: Bencher<'_, '_>, city: City) {
    let field = match city {
        City::Urban => {
            let built_up = BuiltUp::named("urban").expect("a named environment");
            let city =
                BuiltUpCity { built_up, size_m: 1000.0, margin_m: 0.0, cell_m: 2.0, seed: cities::SEED, ground_m: 0.0 };
            let scene = city.city().expect("a city within the limits");
            HeightField::build(&scene.grid, scene.solids).field
        }
        City::Munich => munich(2.0),
    };
    let places = PlaceGrid::over(field.grid(), 10.0).expect("a step above 0");
    let spots = places.spots(&[Height::AboveGround(60.0)]);
    let options = MapOptions::default();
    let mapper = Mapper::new(&field, &options).expect("`auto` decides any scene");
    bencher.counter(ItemsCount::new(spots.len())).bench(|| {
        let candidates = Candidates::of(&spots, &field, &CandidateRules::default()).expect("on the lattice");
        let scorer = Scorer::new(&mapper, None);
        ranked(&scores_over_grid(&scorer, &places, &candidates.kept, &Control::default()).expect("nobody interrupts"))
    });
}

/// 1 km² of the old town of Munich on cells of `cell_m` \[m\].
fn munich(cell_m: f64) -> HeightField {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/munich.geojson");
    let (west, south) = (691_050.0, 5_334_260.0);
    let extent = Some([west, south, west + 1000.0, south + 1000.0]);
    let options = FootprintOptions { extent, cell_m: Some(cell_m), ..FootprintOptions::default() };
    let scene = read_footprints(&file, &options, &mut Vec::new()).expect("the map of Munich");
    let field = HeightField::build(&scene.grid, scene.solids).field;
    let side = field.grid().n_cols() as f64 * cell_m;
    assert!((side - 1000.0).abs() < 1e-6 && field.grid().n_rows() == field.grid().n_cols(), "{side} m");
    field
}

/// UAVs over open ground, by SplitMix64 (Steele, Lea & Flood 2014) from one seed.
fn placements(field: &HeightField, height_m: f64) -> Vec<Uav> {
    let mut state = cities::SEED;
    let mut random = || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) as f64 / u64::MAX as f64
    };
    let grid = field.grid();
    let mut uavs = Vec::with_capacity(PLACEMENTS);
    while uavs.len() < PLACEMENTS {
        let (x, y) = (grid.x_min() + 1000.0 * random(), grid.y_min() + 1000.0 * random());
        let site = Site::new(uavs.len().to_string(), (x, y), Height::AboveGround(height_m));
        if field.roof_at(&field.place(x, y)).is_none() {
            uavs.extend(Uav::place(&site, field, None));
        }
    }
    uavs
}

fn compare_with_rays(field: &HeightField, mapper: &Mapper<'_>, uavs: &[Uav]) {
    let by_rays = MapOptions { method: MethodChoice::Ray, ..MapOptions::default() };
    let by_rays = Mapper::new(field, &by_rays).expect("`ray` decides any scene");
    let map = |mapper: &Mapper<'_>, uav: &Uav| {
        mapper.seen_from(uav).expect("a view").map(&Control::default()).expect("nobody interrupts")
    };
    for uav in uavs {
        let (found, wanted) = (map(mapper, uav), map(&by_rays, uav));
        assert!(found.mask == wanted.mask, "UAV {}: the engine and `ray` differ", uav.id);
        assert_eq!(
            mapper.seen_from(uav).expect("a view").count(),
            (wanted.tally.receivers, wanted.tally.los),
            "UAV {}: the counts differ",
            uav.id
        );
    }
}
