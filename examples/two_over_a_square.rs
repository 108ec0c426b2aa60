//! Two UAVs over a square of 500 m in Munich: the pair of places that together see most of it, and how much more any
//! other pair of the candidates could see.
//!
//! `cargo run --release --example two_over_a_square`

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use std::path::Path;

use skyshed_core::coverage::{Control, MapOptions, Mapper};
use skyshed_core::height_field::HeightField;
use skyshed_core::quantity::Height;
use skyshed_core::raster::{BitGrid, GeoRef};
use skyshed_io::read::{FootprintOptions, read_footprints};
use skyshed_study::placement::{CandidateRules, Candidates, PlaceGrid, SeenSets, cover};

/// The middle of the square, and its sides \[m\].
const MIDDLE: (f64, f64) = (691_549.7, 5_334_762.2);
const SIDE: f64 = 500.0;
const HEIGHT_M: f64 = 100.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/munich.geojson");
    let scene = read_footprints(&file, &FootprintOptions::default(), &mut Vec::new())?;
    let field = HeightField::build(&scene.grid, scene.solids).field;
    // Every 20 m over the whole map, 100 m above the ground.
    let places = PlaceGrid::over(field.grid(), 20.0).ok_or("a step that fits")?;
    let rules = CandidateRules { over: None, within: None, keep_out: None, clearance: 0, radius: None };
    let candidates = Candidates::of(&places.spots(&[Height::AboveGround(HEIGHT_M)]), &field, &rules)?;

    let options = MapOptions { within: Some(within(field.grid(), MIDDLE, SIDE)), ..MapOptions::default() };
    let mapper = Mapper::new(&field, &options)?;
    let mut sets = SeenSets::over(&mapper.receiver_cells(), None);
    let seen = candidates.kept.iter().map(|candidate| Ok(mapper.seen_from(&candidate.uav)?.seen().los));
    let seen: Vec<BitGrid> = seen.collect::<skyshed_core::Result<_>>()?;
    sets.extend(&seen);
    let found = cover(&sets, 2, &Control::default())?;

    println!("{} receivers in the square, {} candidates at {HEIGHT_M} m", found.wanted, candidates.kept.len());
    for chosen in &found.chosen {
        let spot = candidates.kept[chosen.set].spot;
        println!("UAV at ({}, {}): sees {} more, {} together", spot.x, spot.y, chosen.gain, chosen.covered);
    }
    println!("no two of the candidates see more than {} together", found.bound);
    Ok(())
}

/// The cells with their centers in a square \[CRS units\].
fn within(grid: &GeoRef, (x, y): (f64, f64), side: f64) -> BitGrid {
    let mut cells = BitGrid::new(grid.n_rows(), grid.n_cols());
    for (row, col) in (0..grid.n_rows()).flat_map(|row| (0..grid.n_cols()).map(move |col| (row, col))) {
        let (east, north) = grid.world_from_cell(row, col);
        if (east - x).abs().max((north - y).abs()) <= side / 2.0 {
            cells.insert(row, col);
        }
    }
    cells
}
