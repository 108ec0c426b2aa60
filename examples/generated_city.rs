//! The same UAV over the four named environments: how much of the ground it sees, and at which elevation angles.
//!
//! `cargo run --release --example generated_city`

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use skyshed::Result;
use skyshed_core::city::{BuiltUp, BuiltUpCity, Site};
use skyshed_core::coverage::{Control, MapOptions, Uav, map_site};
use skyshed_core::height_field::HeightField;
use skyshed_core::quantity::Height;

fn main() -> Result<()> {
    println!("P_LoS of receivers 1.5 m above ground, by elevation angle, UAV 100 m over a crossroad, one city each");
    println!("{:<12} {:>6}  0–10° 10–20° 20–30° 30–40° 40–50° 50–60° 60–70° 70–80° 80–90°", "", "all");
    for name in ["suburban", "urban", "dense-urban", "high-rise"] {
        let built_up = BuiltUp::named(name).expect("a named environment");
        let scene =
            BuiltUpCity { built_up, size_m: 1000.0, margin_m: 0.0, cell_m: 1.0, seed: 7, ground_m: 0.0 }.city()?;
        let field = HeightField::build(&scene.grid, scene.solids).field;
        let middle = (500.0 / built_up.period()).floor() * built_up.period() + built_up.street_width() / 2.0;
        let site = Site { id: "1".into(), x: middle, y: middle, height: Height::AboveGround(100.0) };
        let uav = Uav::place(&site, &field, None)?;
        let map = map_site(&field, &uav, &MapOptions::default(), &Control::default())?;
        let share = |los: u64, receivers: u64| match receivers {
            0 => "     –".to_string(),
            n => format!("{:>6.3}", los as f64 / n as f64),
        };
        let bands: Vec<String> = map.tally.elevation_bands().iter().map(|b| share(b.los, b.receivers)).collect();
        println!("{name:<12} {}  {}", share(map.tally.los, map.tally.receivers), bands.join(" "));
    }
    Ok(())
}
