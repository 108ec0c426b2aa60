//! File in, picture out: what a UAV sees of Munich, from building footprints.
//!
//! `cargo run --release --example coverage_map` writes `out/munich_coverage.png`.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use std::path::Path;

use skyshed_core::city::Site;
use skyshed_core::coverage::{Control, MapOptions, Uav, map_site};
use skyshed_core::height_field::{Built, HeightField};
use skyshed_core::quantity::Height;
use skyshed_io::read::{FootprintOptions, read_footprints};
use skyshed_render::{Layer, MapPicture, Mark, PictureForm, draw_map};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/munich.geojson");
    let mut warnings = Vec::new();
    let scene = read_footprints(&file, &FootprintOptions::default(), &mut warnings)?;
    let (grid, attribution) = (scene.grid.clone(), scene.attribution.clone());
    let Built { field, warnings: odd } = HeightField::build(&grid, scene.solids);
    warnings.extend(odd);

    let site = Site { id: "1".into(), x: 691_416.0, y: 5_334_517.0, height: Height::AboveGround(90.0) };
    let uav = Uav::place(&site, &field, None)?;
    let map = map_site(&field, &uav, &MapOptions::default(), &Control::default())?;
    let p_los = map.tally.p_los().ok_or("no receiver")?;
    println!("P_LoS = {p_los:.4} of {} open-ground cells", map.tally.receivers);

    let mut caption = vec![format!("UAV 90 m above ground, receivers 1.5 m; P_LoS = {p_los:.4}")];
    caption.extend(attribution);
    let picture = MapPicture {
        title: "A UAV over the old town of Munich",
        caption: &caption,
        n_cols: grid.n_cols(),
        n_rows: grid.n_rows(),
        cell_m: (grid.cell_width(), grid.cell_height()),
        layer: Layer::Los(&map.mask),
        surface_m: Some(&field.above_ground_m()),
        uavs: &[Mark {
            label: "UAV",
            height: "90 m",
            col: (site.x - grid.x_min()) / grid.cell_width(),
            row: (grid.y_max() - site.y) / grid.cell_height(),
        }],
        receivers_name: "open-ground cells",
        others_name: "Buildings",
        counts: None,
    };
    std::fs::create_dir_all("out")?;
    std::fs::write("out/munich_coverage.png", draw_map(&picture, &PictureForm::PNG, &[])?)?;
    println!("wrote out/munich_coverage.png");
    Ok(())
}
