//! Is a crossroad the best place? P_LoS within 100 m of a UAV 100 m above crossroads, streets and rooftops of the four
//! ITU environments, with 95 % intervals over cities.
//!
//! `cargo run --release --example best_zone`

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use skyshed_core::city::{BuiltUp, BuiltUpCity, Site};
use skyshed_core::coverage::{MapOptions, Mapper, Uav};
use skyshed_core::height_field::HeightField;
use skyshed_core::quantity::Height;
use skyshed_core::raster::CellBlocks;
use skyshed_core::zones::{Zone, ZoneMap};
use skyshed_study::los_probability::estimate::Count;
use skyshed_study::placement::{Drawn, ReceiverParts, SampledCounts, over_cities};

const ZONES: [Zone; 3] = [Zone::Crossroad, Zone::Street, Zone::Rooftop];
const CITIES: u64 = 20;
const PLACES: usize = 25;
const RADIUS_M: f64 = 100.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("{:<12} {:>24} {:>24} {:>24}", "environment", "over crossroads", "over streets", "over rooftops");
    for name in ["suburban", "urban", "dense-urban", "high-rise"] {
        let built_up = BuiltUp::named(name).ok_or("a named environment")?;
        let mut totals: Vec<Vec<Vec<Count>>> = vec![Vec::new(); ZONES.len()];
        for seed in 1..=CITIES {
            let city = BuiltUpCity { built_up, size_m: 600.0, margin_m: RADIUS_M, cell_m: 1.0, seed, ground_m: 0.0 };
            for (of_zone, counts) in totals.iter_mut().zip(of_city(&city)?) {
                of_zone.push(counts);
            }
        }
        print!("{name:<12}");
        for of_zone in &totals {
            let estimate = over_cities(of_zone, 1, 0.95)[0];
            let (p, (low, high)) = estimate.p_los.zip(estimate.interval).ok_or("too few cities")?;
            print!("  {p:.3} [{low:.3}, {high:.3}]  ");
        }
        println!();
    }
    Ok(())
}

/// What all receivers within 100 m of the placements over each zone see, in one city.
fn of_city(city: &BuiltUpCity) -> skyshed::Result<Vec<Vec<Count>>> {
    let scene = city.city()?;
    let field = HeightField::build(&scene.grid, scene.solids).field;
    let zones = ZoneMap::of(&field, scene.built_up.as_ref())?;
    let options = MapOptions { radius: Some(RADIUS_M), ..MapOptions::default() };
    let mapper = Mapper::new(&field, &options)?;
    let parts = ReceiverParts::new(&mapper.receiver_cells(), &zones);
    let blocks = CellBlocks::new(field.grid(), 1.0, city.size_m);
    let of_zone = |zone: &Zone| {
        let site = |[x, y]: [f64; 2]| Site::new("", (x, y), Height::AboveGround(100.0));
        // A UAV that would be inside a tower is left out.
        let within = [0.0, 0.0, city.size_m, city.size_m];
        let drawn = Drawn { zone: *zone, n: PLACES, within, radius: Some(RADIUS_M), seed: city.seed };
        let places = drawn.places(&field, &zones).places;
        let uavs: Vec<Uav> =
            places.into_iter().filter_map(|place| Uav::place(&site(place), &field, None).ok()).collect();
        // The first part is all receivers.
        Ok(SampledCounts::of(&mapper, &uavs, &parts, &blocks)?.totals()[..1].to_vec())
    };
    ZONES.iter().map(of_zone).collect()
}
