//! A pilot asks: where may I fly at 100 m and keep sight of the drone, from here?
//!
//! `cargo run --release --example pilot` writes `out/pilot.png`.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use std::path::Path;

use skyshed::SaveOptions;
use skyshed::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let city = Scene::open(root.join("maps/munich.geojson"))?;
    // Line of sight has no direction: the pilot's eyes take the place of a UAV, the places of the drone those of receivers.
    let eyes = Uav::new(691_549.7, 5_334_762.2, Height::agl(1.7));
    let seen = city.coverage(eyes).receivers(Receivers::Air).rx_height(100.0).run()?;
    println!("in sight over {:.1} % of {} m²", 100.0 * seen.p_los().ok_or("no place")?, seen.receivers());

    std::fs::create_dir_all(root.join("out"))?;
    seen.save_with(root.join("out/pilot.png"), &SaveOptions::default().overwrite(true))?;
    Ok(())
}
