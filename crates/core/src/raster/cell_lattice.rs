//! Position of the cells of a raster on an integer lattice.

use super::GeoRef;
use crate::quantity::{Frame, STEPS_PER_UNIT};

/// The lattice on which the columns over a raster are decided. A cell is a whole number of its
/// steps wide and high.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellLattice {
    /// Frame of the lattice; its origin is the raster's south-west corner.
    pub frame: Frame,
    /// Width and height of a cell \[lattice steps\].
    pub steps: [i64; 2],
}

/// Steps of a cell in a raster scene, along both axes.
const CELL: i64 = STEPS_PER_UNIT as i64;

/// Numbers this close to an integer count as integers: coordinates of a few million meters are
/// rounded at 10^-9 m.
const WHOLE: f64 = 1e-6;

impl CellLattice {
    /// Returns the lattice of a raster scene: 1024 steps a cell along both axes, for every cell
    /// size.
    pub fn of_cells(grid: &GeoRef) -> Self {
        let frame = Frame {
            x_origin: grid.x_min(),
            y_origin: grid.y_min(),
            unit_x: grid.cell_width(),
            unit_y: grid.cell_height(),
        };
        CellLattice { frame, steps: [CELL; 2] }
    }

    /// Returns the lattice of a terrain in a vector scene, whose positions are on the lattice of
    /// `scene`.
    ///
    /// Every position of the scene is on this lattice too if two conditions hold. The corner fits,
    /// and a cell is a whole number of the scene's steps or such a step is a whole number of 1/1024
    /// cell. Otherwise positions are rounded to it, by half a step of the scene at most.
    pub fn under(scene: &Frame, grid: &GeoRef) -> Self {
        let axis = |cell: f64, unit: f64| {
            let is_whole = |v: f64| (v - v.round()).abs() <= WHOLE;
            let steps = cell / unit * f64::from(STEPS_PER_UNIT);
            let is_finer = steps < f64::from(STEPS_PER_UNIT);
            // The engine for whole terrains needs 1024 steps a cell, so that is preferred if it
            // holds all positions.
            let holds_all = is_whole(f64::from(STEPS_PER_UNIT) / steps);
            #[expect(clippy::cast_possible_truncation, reason = "saturating: larger cells than any grid has")]
            let steps = if is_finer && (holds_all || !is_whole(steps)) { CELL } else { (steps.round() as i64).max(1) };
            #[expect(clippy::cast_precision_loss, reason = "far below 2^53")]
            (steps, cell * f64::from(STEPS_PER_UNIT) / steps as f64)
        };
        let (steps_x, unit_x) = axis(grid.cell_width(), scene.unit_x);
        let (steps_y, unit_y) = axis(grid.cell_height(), scene.unit_y);
        let frame = Frame { x_origin: grid.x_min(), y_origin: grid.y_min(), unit_x, unit_y };
        CellLattice { frame, steps: [steps_x, steps_y] }
    }

    /// Converts a position from the lattice of a scene to this one.
    pub fn position(&self, scene: &Frame, position: [i32; 2]) -> [i64; 2] {
        let (x, y) = scene.world_from_lattice(f64::from(position[0]), f64::from(position[1]));
        let (x, y) = self.frame.lattice_from_world(x, y);
        [x, y]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn under(cell: f64) -> CellLattice {
        let scene = Frame { x_origin: 691_000.0, y_origin: 5_334_000.0, unit_x: 1.0, unit_y: 1.0 };
        let grid = GeoRef::new((691_010.0, 5_334_500.0), (cell, cell), (50, 60), None).expect("a valid grid");
        CellLattice::under(&scene, &grid)
    }

    #[test]
    fn cells_are_whole_numbers_of_steps_and_the_scene_fits_into_them() {
        for (cell, steps) in
            [(1.0, 1024), (2.0, 2048), (2.5, 2560), (0.5, 1024), (0.2, 1024), (0.75, 768), (10.0, 10240)]
        {
            let lattice = under(cell);
            assert_eq!(lattice.steps, [steps; 2], "{cell} m");
            // A position of the scene is a whole number of steps east of the corner.
            let of_scene = 1.0 / 1024.0 / lattice.frame.unit_x * 1024.0;
            assert!((of_scene - of_scene.round()).abs() < 1e-9, "{cell} m: {of_scene}");
        }
    }

    #[test]
    fn other_cells_are_cut_as_finely_as_the_scene() {
        for cell in [2.502_058, 0.3, 1.1, 33.7] {
            let lattice = under(cell);
            let step_m = lattice.frame.unit_x / 1024.0;
            assert!(step_m <= 1.001 / 1024.0, "{cell} m: {step_m}");
        }
    }
}
