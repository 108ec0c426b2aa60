//! File in, picture out: what a UAV sees of Munich, from building footprints.
//!
//! `cargo run --release --example coverage_map` writes `out/munich_coverage.png`.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use std::path::Path;

use skyshed::SaveOptions;
use skyshed::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let city = Scene::open(root.join("maps/munich.geojson"))?;
    let seen = city.coverage(Uav::new(691_416.0, 5_334_517.0, Height::agl(90.0))).run()?;
    println!("P_LoS = {:.4} of {} open-ground cells", seen.p_los().ok_or("no receiver")?, seen.receivers());
    seen.warnings().iter().for_each(|warning| println!("{warning}"));

    std::fs::create_dir_all(root.join("out"))?;
    let form = SaveOptions::default().overwrite(true).title("A UAV over the old town of Munich");
    seen.save_with(root.join("out/munich_coverage.png"), &form)?;
    Ok(())
}
