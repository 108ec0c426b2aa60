//! P_LoS by zone of the placement, from maps of generated cities, against the product over the same disc.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use skyshed::coverage::{MapOptions, Mapper, Uav};
use skyshed::height_field::HeightField;
use skyshed::los_probability::estimate::Estimate;
use skyshed::los_probability::product::Product;
use skyshed::los_probability::setting::{Placement, Setting, Users};
use skyshed::placement::{ReceiverParts, SampledCounts, middles_of, over_cities};
use skyshed::quantity::Height;
use skyshed::raster::CellBlocks;
use skyshed::scene::{BuiltUp, BuiltUpCity, Site};
use skyshed::zones::{Zone, ZoneMap};

use crate::support::slow;

const HEIGHT_M: f64 = 100.0;
const RX_HEIGHT_M: f64 = 1.5;
const RADII_M: [f64; 4] = [50.0, 100.0, 200.0, 300.0];
const PLACEMENTS: [(Zone, Placement); 3] = [
    (Zone::Crossroad, Placement::CrossroadCenter),
    (Zone::Street, Placement::StreetCenter),
    (Zone::Rooftop, Placement::RooftopCenter),
];

/// UAVs over middles whose discs lie in the city, and which are not inside a building.
fn uavs(field: &HeightField, middles: &[[f64; 2]], size_m: f64) -> Vec<Uav> {
    let reach = RADII_M[3];
    let is_inside = |v: f64| v >= reach && v <= size_m - reach;
    let site = |[x, y]: [f64; 2]| Site { id: "1".into(), x, y, height: Height::AboveGround(HEIGHT_M) };
    let places = middles.iter().filter(|[x, y]| is_inside(*x) && is_inside(*y));
    places.filter_map(|place| Uav::place(&site(*place), field, None).ok()).collect()
}

/// P_LoS of outdoor users within each radius, `[placement][radius]`, over cities of 1 m cells.
fn from_maps(built_up: BuiltUp, n_cities: u64) -> Vec<Vec<Estimate>> {
    // Room for two periods of places.
    let size_m = (2.0 * RADII_M[3] + 2.0 * built_up.period()).ceil();
    let mut totals = vec![vec![Vec::new(); RADII_M.len()]; PLACEMENTS.len()];
    for seed in 1..=n_cities {
        let city = BuiltUpCity { built_up, size_m, cell_m: 1.0, seed, ground_m: 0.0 };
        let scene = city.scene().unwrap();
        let field = HeightField::build(&scene.grid, scene.solids, &mut Vec::new());
        let zones = ZoneMap::of(&field, Some(&built_up));
        let parts = ReceiverParts::new(&field.cells().open, &zones);
        let blocks = CellBlocks::new(field.grid(), 1.0, size_m);
        for (of_radius, radius) in RADII_M.into_iter().enumerate() {
            let options = MapOptions { radius: Some(radius), ..MapOptions::default() };
            let mapper = Mapper::new(&field, &options).unwrap();
            for (of_placement, (zone, _)) in PLACEMENTS.iter().enumerate() {
                let uavs = uavs(&field, &middles_of(&built_up, size_m, *zone), size_m);
                let counts = SampledCounts::of(&mapper, &uavs, &parts, &blocks);
                totals[of_placement][of_radius].push(counts.totals());
            }
        }
    }
    let estimate = |totals: &Vec<Vec<_>>| over_cities(totals, 1, 0.95)[0];
    totals.iter().map(|of_placement| of_placement.iter().map(estimate).collect()).collect()
}

#[test]
fn maps_around_uavs_over_middles_agree_with_the_product_over_the_disc() {
    let n_cities = if slow() { 400 } else { 30 };
    for name in ["suburban", "urban", "dense-urban", "high-rise"] {
        let built_up = BuiltUp::named(name).unwrap();
        let found = from_maps(built_up, n_cities);
        for ((zone, placement), of_placement) in PLACEMENTS.iter().zip(&found) {
            for (radius_m, estimate) in RADII_M.into_iter().zip(of_placement) {
                let mut reference = Product::new(
                    Setting {
                        built_up,
                        uav_height_m: HEIGHT_M,
                        rx_height_m: RX_HEIGHT_M,
                        reach: Setting::reach_within(radius_m, HEIGHT_M, RX_HEIGHT_M).unwrap(),
                        phi_deg: None,
                        users: Users::Outdoor,
                        placement: *placement,
                        uav_clear_of_roof: true,
                    },
                    7,
                );
                reference.add_points(1 << 10);
                let reference = reference.estimate(0.95);
                let (p, wanted) = (estimate.p_los.unwrap(), reference.p_los.unwrap());
                let error = estimate.std_error.unwrap().hypot(reference.std_error.unwrap());
                assert!((p - wanted).abs() <= 4.0 * error, "{name}, {zone:?}, {radius_m} m: {p} ± {error}, {wanted}");
            }
        }
        // Which zone is best: crossroads in dense and high-rise cities, not in the urban one within 100 m.
        let p_los = |placement: usize, radius: usize| found[placement][radius].p_los.unwrap();
        let crossroads_win = |radius: usize| (1..3).all(|other| p_los(0, radius) > p_los(other, radius));
        match name {
            "dense-urban" | "high-rise" => assert!((0..4).all(crossroads_win), "{name}"),
            "urban" => assert!((0..2).all(|radius| p_los(0, radius) < p_los(1, radius)), "{name}"),
            _ => {}
        }
    }
}
