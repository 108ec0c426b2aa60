//! Three placements over Munich compared: what each sees, and what changes from one to another.
//!
//! `cargo run --release --example compared` writes `out/compared.png`.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use std::path::Path;

use skyshed_core::city::Site;
use skyshed_core::coverage::{CellGroups, Control, KeepMasks, MapOptions, Mapper, Together, Uav, count_pairs};
use skyshed_core::height_field::HeightField;
use skyshed_core::quantity::Height;
use skyshed_core::raster::CellBlocks;
use skyshed_core::zones::{N_CODES, ZoneMap};
use skyshed_io::read::{FootprintOptions, read_footprints};
use skyshed_render::{CompareMap, ComparePair, CompareSheet, Mark, PictureForm, draw_compare_sheet};

/// Name, x, y, height above ground \[m\].
const PLACEMENTS: [(&str, f64, f64, f64); 3] = [
    ("square", 691_549.7, 5_334_762.2, 60.0),
    ("east", 691_900.0, 5_334_800.0, 60.0),
    ("south", 691_500.0, 5_334_400.0, 60.0),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/munich.geojson");
    let scene = read_footprints(&file, &FootprintOptions::default(), &mut Vec::new())?;
    let attribution = scene.attribution.clone();
    let field = HeightField::build(&scene.grid, scene.solids).field;
    let grid = field.grid();

    let place = |(id, x, y, height): (&str, f64, f64, f64)| {
        Uav::place(&Site::new(id, (x, y), Height::AboveGround(height)), &field, None)
    };
    let uavs: Vec<Uav> = PLACEMENTS.into_iter().map(place).collect::<skyshed_core::Result<_>>()?;
    let options = MapOptions::default();
    let maps = Mapper::new(&field, &options)?
        .map_many(&uavs, (KeepMasks::Always, &Together::default()), &Control::default(), |_| {}, |_| {})?
        .sites;

    let details: Vec<String> =
        maps.iter().map(|map| format!("P_LoS = {:.4}", map.tally.p_los().unwrap_or(f64::NAN))).collect();
    let zones = ZoneMap::of(&field, None)?;
    let blocks = CellBlocks::new(grid, 1.0, 2000.0);
    let cells = CellGroups { groups: zones.codes(), blocks: &blocks, n_cols: grid.n_cols() };
    let mut words = Vec::new();
    for (first, second) in [(0, 1), (0, 2), (1, 2)] {
        let counts = count_pairs::<N_CODES>(&maps[first].mask, &maps[second].mask, &cells);
        let all =
            counts.iter().flatten().fold(Default::default(), |sum: skyshed_core::coverage::PairCounts, c| sum.plus(c));
        let title = format!("{} → {}", uavs[first].id, uavs[second].id);
        let detail = format!("both {}, gained {}, lost {}", all.both, all.only_second, all.only_first);
        println!("{title}: {detail}");
        words.push((title, detail, first, second));
    }

    let mark = |k: usize| Mark {
        label: &uavs[k].id,
        height: "60 m",
        col: (uavs[k].station.place.x - grid.x_min()) / grid.cell_width(),
        row: (grid.y_max() - uavs[k].station.place.y) / grid.cell_height(),
        is_observer: false,
    };
    let drawn: Vec<CompareMap<'_>> = (0..maps.len())
        .map(|k| CompareMap { title: &uavs[k].id, detail: &details[k], mask: &maps[k].mask, mark: Some(mark(k)) })
        .collect();
    let pairs: Vec<ComparePair<'_>> = words
        .iter()
        .map(|(title, detail, first, second)| ComparePair { title, detail, first: *first, second: *second })
        .collect();
    let caption: Vec<String> = attribution.into_iter().collect();
    let sheet = CompareSheet {
        title: "Three places to hover over Munich, 60 m above ground",
        verdict: "What each sees, and what changes from one to another.",
        caption: &caption,
        n_cols: grid.n_cols(),
        n_rows: grid.n_rows(),
        cell_m: (grid.cell_width(), grid.cell_height()),
        maps: &drawn,
        pairs: &pairs,
        surface_m: Some(&field.above_ground_m()),
        others_name: "Buildings",
    };
    std::fs::create_dir_all("out")?;
    std::fs::write("out/compared.png", draw_compare_sheet(&sheet)?.write(&PictureForm::PNG, &[])?)?;
    println!("wrote out/compared.png");
    Ok(())
}
