//! One UAV over each of the four named environments: how much of the ground it sees, and at which elevation angles.
//!
//! `cargo run --release --example generated_city`

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use skyshed::Result;
use skyshed::prelude::*;
use skyshed_core::city::BuiltUp;

fn main() -> Result<()> {
    println!("P_LoS of receivers 1.5 m above ground, by elevation angle, UAV 100 m over a crossroad, one city each");
    println!("{:<12} {:>6}  0–10° 10–20° 20–30° 30–40° 40–50° 50–60° 60–70° 70–80° 80–90°", "", "all");
    for name in ["suburban", "urban", "dense-urban", "high-rise"] {
        let built_up = BuiltUp::named(name).expect("a named environment");
        let crossroad = (500.0 / built_up.period()).floor() * built_up.period() + built_up.street_width() / 2.0;
        let city = Scene::options().size(1000.0).seed(7).open(format!("itu:{name}"))?;
        let seen = city.coverage(Uav::new(crossroad, crossroad, Height::agl(100.0))).run()?;
        let share = |p_los: Option<f64>| p_los.map_or("     –".to_string(), |p| format!("{p:>6.3}"));
        let of_band = |los: u64, receivers: u64| (receivers > 0).then(|| los as f64 / receivers as f64);
        let bands = seen.tally().elevation_bands();
        let bands: Vec<String> = bands.iter().map(|band| share(of_band(band.los, band.receivers))).collect();
        println!("{name:<12} {}  {}", share(seen.p_los()), bands.join(" "));
    }
    Ok(())
}
