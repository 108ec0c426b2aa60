//! The shortest use: one generated city, two points, one answer with its reason.
//!
//! `cargo run --release --example one_link`

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use skyshed::Result;
use skyshed_core::city::{BuiltUp, BuiltUpCity, Site};
use skyshed_core::coverage::Uav;
use skyshed_core::height_field::{HeightField, Station};
use skyshed_core::los::{LeastHeight, link_least_receiver_heights, link_los};
use skyshed_core::quantity::{Height, height_steps, meters};

fn main() -> Result<()> {
    let built_up = BuiltUp::named("urban").expect("`urban` is a named environment");
    let scene = BuiltUpCity { built_up, size_m: 500.0, margin_m: 0.0, cell_m: 1.0, seed: 1, ground_m: 0.0 }.city()?;
    let field = HeightField::build(&scene.grid, scene.solids).field;
    println!("{built_up}: {} buildings", field.n_buildings());

    // A UAV over a crossroad, and a receiver 1.5 m above the street, farther and farther to the east.
    let crossroad = 5.0 * built_up.period() + built_up.street_width() / 2.0;
    let site = Site { id: "1".into(), x: crossroad, y: crossroad, height: Height::AboveGround(60.0) };
    let uav = Uav::place(&site, &field, None)?;
    for east in [0.0, 60.0, 120.0, 180.0] {
        let place = field.place(crossroad + east, crossroad + 30.0 + built_up.street_width() / 2.0);
        let receiver = Station { place, z: i64::from(height_steps(1.5).expect("in range")) };
        let verdict = if link_los(&field, &uav.station, &receiver) { "LoS" } else { "NLoS" };
        let (prisms, _) = link_least_receiver_heights(&field, &uav.station, &receiver);
        let reason = match prisms {
            LeastHeight::Clear => "nothing on the way".to_string(),
            LeastHeight::At(o) => {
                let building = field.prisms().map_or(0, |p| p.pieces()[o.obstacle].building);
                format!(
                    "building {} with its roof at {:.1} m lets a receiver see the UAV from {:.1} m up",
                    field.building_id(building),
                    meters(o.top),
                    prisms.height_steps() / 1024.0
                )
            }
        };
        println!("{east:>4} m east: {verdict:<4} ({reason})");
    }
    Ok(())
}
