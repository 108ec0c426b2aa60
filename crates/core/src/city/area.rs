//! Areas: polygons that limit where UAVs may hover, or which receivers they should see.

use crate::raster::{BitGrid, GeoRef};

/// A region of the plane: the union of polygons. A polygon is the inside of its first ring without
/// the insides of the other rings, its holes. Insides follow the even-odd rule.
#[derive(Debug, Clone, PartialEq)]
pub struct Area {
    polygons: Vec<Vec<Vec<[f64; 2]>>>,
}

impl Area {
    /// Makes an area from polygons of rings of positions \[CRS units\]. No ring repeats its first
    /// point at its end.
    pub fn new(polygons: Vec<Vec<Vec<[f64; 2]>>>) -> Self {
        Area { polygons }
    }

    /// Returns the polygons as given.
    pub fn polygons(&self) -> &[Vec<Vec<[f64; 2]>>] {
        &self.polygons
    }

    /// Returns `true` if a position \[CRS units\] is inside. A point on an edge belongs to the side
    /// north-east of it.
    pub fn contains(&self, x: f64, y: f64) -> bool {
        let is_inside = |ring: &Vec<[f64; 2]>| crossings(ring, y).iter().filter(|at| **at <= x).count() % 2 == 1;
        self.polygons.iter().any(|rings| match rings.split_first() {
            Some((shell, holes)) => is_inside(shell) && !holes.iter().any(is_inside),
            None => false,
        })
    }

    /// Returns the cells of a grid whose centers are inside.
    pub fn cells(&self, grid: &GeoRef) -> BitGrid {
        let (n_rows, n_cols) = (grid.n_rows(), grid.n_cols());
        let mut cells = BitGrid::new(n_rows, n_cols);
        let mut inside = vec![false; n_cols];
        for row in 0..n_rows {
            let y = grid.world_from_cell(row, 0).1;
            for rings in &self.polygons {
                let between = |ring: &Vec<[f64; 2]>| {
                    let mut at = crossings(ring, y);
                    at.sort_unstable_by(f64::total_cmp);
                    at.chunks_exact(2).map(|ends| [ends[0], ends[1]].map(|x| first_center(grid, x))).collect::<Vec<_>>()
                };
                let Some((shell, holes)) = rings.split_first() else { continue };
                let shell = between(shell);
                let Some([from, to]) = shell.iter().copied().reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]) else {
                    continue;
                };
                inside[from..to].fill(false);
                shell.iter().for_each(|[from, to]| inside[*from..*to].fill(true));
                holes.iter().flat_map(between).for_each(|[from, to]| inside[from..to].fill(false));
                (from..to).filter(|col| inside[*col]).for_each(|col| cells.insert(row, col));
            }
        }
        cells
    }

    /// Returns `true` if the area's bounding box and the grid's share a point.
    pub fn meets(&self, grid: &GeoRef) -> bool {
        let points = || self.polygons.iter().flatten().flatten();
        let range = |k: usize| points().fold((f64::INFINITY, f64::NEG_INFINITY), |r, p| (r.0.min(p[k]), r.1.max(p[k])));
        let ((west, east), (south, north)) = (range(0), range(1));
        west <= grid.x_max() && east >= grid.x_min() && south <= grid.y_max() && north >= grid.y_min()
    }
}

/// Returns the x coordinates at which the edges of a ring cross the horizontal line at `y`.
fn crossings(ring: &[[f64; 2]], y: f64) -> Vec<f64> {
    let edges = ring.iter().zip(ring.iter().cycle().skip(1)).filter(|(a, b)| (a[1] <= y) != (b[1] <= y));
    edges.map(|(a, b)| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])).collect()
}

/// Returns the first column whose center is at or east of `x`, or the number of columns.
fn first_center(grid: &GeoRef, x: f64) -> usize {
    let near = ((x - grid.x_min()) / grid.cell_width() - 0.5).ceil().clamp(0.0, grid.n_cols() as f64);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the grid")]
    let mut col = near as usize;
    // The quotient is rounded; the comparison with the center is the one in `contains`.
    while col > 0 && grid.world_from_cell(0, col - 1).0 >= x {
        col -= 1;
    }
    while col < grid.n_cols() && grid.world_from_cell(0, col).0 < x {
        col += 1;
    }
    col
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_area_with_a_hole_holds_the_cells_whose_centers_it_contains() {
        let grid = GeoRef::new((0.0, 10.0), (1.0, 1.0), (10, 12), None).expect("a valid grid");
        let square = |a: f64, b: f64| vec![[a, a], [b, a], [b, b], [a, b]];
        // A third ring lies outside of its shell: a hole there takes nothing out, and adds nothing.
        let holed = vec![square(1.0, 8.2), square(3.0, 5.0), square(9.2, 9.9)];
        let area = Area::new(vec![holed, vec![square(7.0, 9.0)]]);
        let cells = area.cells(&grid);
        for row in 0..10 {
            for col in 0..12 {
                let (x, y) = grid.world_from_cell(row, col);
                assert_eq!(cells.contains(row, col), area.contains(x, y), "({x}, {y})");
            }
        }
        // 7 × 7 less the hole's 2 × 2, and 2 × 2 of which one is in both.
        assert_eq!(cells.count(), 49 - 4 + 3);
        assert!(!area.contains(4.0, 4.0) && area.contains(1.0, 1.0) && !area.contains(9.0, 8.0));
        assert!(!Area::new(vec![vec![square(20.0, 21.0)]]).meets(&grid) && area.meets(&grid));
    }
}
