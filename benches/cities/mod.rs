//! The cities of the benches: as footprints, and the same as a raster.

use skyshed_core::city::{BuiltUp, BuiltUpCity, Ground, Site, Solids};
use skyshed_core::coverage::Uav;
use skyshed_core::height_field::HeightField;
use skyshed_core::quantity::{Height, height_steps};
use skyshed_core::raster::{GeoRef, Raster};

/// The seed of every city.
pub(crate) const SEED: u64 = 1;

/// A city of footprints on flat ground, `n` cells of 1 m a side.
pub(crate) fn footprints(environment: &str, n: usize) -> HeightField {
    let built_up = BuiltUp::named(environment).expect("a named environment");
    let scene = BuiltUpCity { built_up, size_m: n as f64, margin_m: 0.0, cell_m: 1.0, seed: SEED, ground_m: 0.0 }
        .city()
        .expect("a city within the limits");
    HeightField::build(&scene.grid, scene.solids).field
}

/// The heights of a field at its cell centers \[1/1024 m\].
pub(crate) fn surface_of(field: &HeightField) -> Raster<i32> {
    let steps = |m: &f32| height_steps(f64::from(*m)).expect("a generated city has no voids");
    Raster::new(field.grid().clone(), field.surface_m().iter().map(steps).collect::<Vec<_>>())
}

/// A raster scene; a cell more than 0.25 m above the ground is a building.
pub(crate) fn raster(grid: &GeoRef, surface: Raster<i32>, ground: Ground) -> HeightField {
    let building_threshold = height_steps(0.25).expect("in range");
    HeightField::build(grid, Solids::Raster { surface, ground, building_threshold, voids: None }).field
}

/// A UAV over the center of the open cell nearest to the middle.
pub(crate) fn uav_in_the_middle(field: &HeightField, height_m: f64) -> Uav {
    let grid = field.grid();
    let (n_rows, n_cols) = (grid.n_rows(), grid.n_cols());
    let from_middle = |(row, col): &(usize, usize)| row.abs_diff(n_rows / 2) + col.abs_diff(n_cols / 2);
    let near = |n: usize| n / 2 - (n / 2).min(100)..(n / 2 + 100).min(n);
    let (row, col) = near(n_rows)
        .flat_map(|row| near(n_cols).map(move |col| (row, col)))
        .filter(|(row, col)| field.cells().open.contains(*row, *col))
        .min_by_key(from_middle)
        .expect("open ground near the middle");
    let (x, y) = grid.world_from_cell(row, col);
    let site = Site::new("1", (x, y), Height::AboveGround(height_m));
    Uav::place(&site, field, None).expect("in the clear")
}
