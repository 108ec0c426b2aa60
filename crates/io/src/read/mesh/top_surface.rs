//! Highest face over the center of each cell.
//!
//! Corners are rounded to 1/1024 of a cell first. Integers then decide whether a center is inside a
//! face, by the even-odd rule along its row. A center on an edge belongs to the face north-east of
//! it, so that faces that share an edge leave no gap. Upright faces cover no center. A face of more
//! than three corners is taken as plane (Newell's normal through its first corner), its height kept
//! within that of its corners.

use super::faces::Mesh;
use crate::error::{Error, HeightOf, ReadFault, Result};
use crate::formats::reserve_cells;
use crate::input::Input;
use crate::quantity::{Frame, STEPS_PER_UNIT, VOID, height_steps};
use crate::raster::{GeoRef, Raster};

/// A corner: lattice positions from the grid's south-west corner, and the height \[1/1024 m\].
#[derive(Debug, Clone, Copy)]
struct Corner {
    x: i64,
    y: i64,
    z: i32,
}

/// Returns the surface \[1/1024 m above the datum\], [`VOID`] where no face is.
pub(super) fn top_surface(input: &Input, mesh: &Mesh, grid: &GeoRef) -> Result<Raster<i32>> {
    let mut cells: Vec<i32> = reserve_cells(input, grid)?;
    cells.resize(grid.n_cells(), VOID);
    let mut surface = Surface { cells, n_rows: grid.n_rows(), n_cols: grid.n_cols(), crossings: Vec::new() };
    let frame =
        Frame { x_origin: grid.x_min(), y_origin: grid.y_min(), unit_x: grid.cell_width(), unit_y: grid.cell_height() };
    let mut corners: Vec<Corner> = Vec::new();
    for face in mesh.faces() {
        corners.clear();
        for [x, y, z] in face {
            let beyond = || Error::read(input, ReadFault::HeightRange(HeightOf::Vertex, z));
            let z = height_steps(z).ok_or_else(beyond)?;
            let (x, y) = frame.lattice_from_world(x, y);
            corners.push(Corner { x, y, z });
        }
        surface.cover(&corners);
    }
    Ok(Raster::new(grid.clone(), surface.cells))
}

struct Surface {
    cells: Vec<i32>,
    n_rows: usize,
    n_cols: usize,
    /// First columns east of the edges that cross a row.
    crossings: Vec<usize>,
}

impl Surface {
    fn cover(&mut self, corners: &[Corner]) {
        let Some(plane) = Plane::of(corners) else { return };
        let south = corners.iter().map(|c| c.y).min().unwrap_or(0);
        let north = corners.iter().map(|c| c.y).max().unwrap_or(0);
        for from_south in first_center(south.into(), 1, self.n_rows)..first_center(north.into(), 1, self.n_rows) {
            let y = center(from_south);
            self.crossings.clear();
            for (k, a) in corners.iter().enumerate() {
                let b = &corners[(k + 1) % corners.len()];
                if (a.y <= y) != (b.y <= y) {
                    // x where the edge crosses the row, as a fraction with a positive denominator.
                    let rise = i128::from(b.y - a.y);
                    let x = i128::from(a.x) * rise + i128::from(y - a.y) * i128::from(b.x - a.x);
                    self.crossings.push(first_center(x * rise.signum(), rise.abs(), self.n_cols));
                }
            }
            self.crossings.sort_unstable();
            let row = &mut self.cells[(self.n_rows - 1 - from_south) * self.n_cols..][..self.n_cols];
            for ends in self.crossings.chunks_exact(2) {
                for (col, cell) in row.iter_mut().enumerate().take(ends[1]).skip(ends[0]) {
                    *cell = (*cell).max(plane.height(center(col), y));
                }
            }
        }
    }
}

/// Returns the lattice position of the center of cell `k`.
fn center(k: usize) -> i64 {
    let steps = i64::from(STEPS_PER_UNIT);
    i64::try_from(k).unwrap_or(i64::MAX / steps - 1) * steps + steps / 2
}

/// Returns the first of `n` cells whose center is at or beyond `position / per` \[lattice steps\],
/// `n` if there is none.
fn first_center(position: i128, per: i128, n: usize) -> usize {
    let steps = i128::from(STEPS_PER_UNIT);
    let (from_center, cell) = (position - per * (steps / 2), per * steps);
    // The quotient rounded up.
    let k = -(-from_center).div_euclid(cell);
    usize::try_from(k.max(0)).map_or(n, |k| k.min(n))
}

/// The plane of a face: heights relative to its first corner.
struct Plane {
    first: Corner,
    slope_x: f64,
    slope_y: f64,
    lowest: i32,
    highest: i32,
}

impl Plane {
    /// Returns the plane of a face; `None` if it covers no area from above.
    fn of(corners: &[Corner]) -> Option<Plane> {
        let first = *corners.first()?;
        let pairs = || corners.iter().zip(corners.iter().cycle().skip(1));
        let cross = |(a, b): (&Corner, &Corner)| {
            i128::from(a.x - first.x) * i128::from(b.y - first.y)
                - i128::from(b.x - first.x) * i128::from(a.y - first.y)
        };
        let doubled_area: i128 = pairs().map(cross).sum();
        if doubled_area == 0 {
            return None;
        }
        #[expect(clippy::cast_precision_loss, reason = "heights are told to a lattice step, not to the last bit")]
        let normal = pairs().fold([0.0, 0.0], |[nx, ny], (a, b)| {
            let z = f64::from(a.z - first.z) + f64::from(b.z - first.z);
            [nx + (a.y - b.y) as f64 * z, ny + (b.x - a.x) as f64 * z]
        });
        #[expect(clippy::cast_precision_loss, reason = "heights are told to a lattice step, not to the last bit")]
        let up = doubled_area as f64;
        Some(Plane {
            first,
            slope_x: -normal[0] / up,
            slope_y: -normal[1] / up,
            lowest: corners.iter().map(|c| c.z).min()?,
            highest: corners.iter().map(|c| c.z).max()?,
        })
    }

    fn height(&self, x: i64, y: i64) -> i32 {
        #[expect(clippy::cast_precision_loss, reason = "heights are told to a lattice step, not to the last bit")]
        let (dx, dy) = ((x - self.first.x) as f64, (y - self.first.y) as f64);
        let above_first = self.slope_x * dx + self.slope_y * dy;
        let z = (f64::from(self.first.z) + above_first + 0.5).floor();
        #[expect(clippy::cast_possible_truncation, reason = "between the heights of its corners")]
        let z = z.clamp(f64::from(self.lowest), f64::from(self.highest)) as i32;
        z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(n: usize, faces: &[&[[f64; 3]]]) -> Vec<Option<f64>> {
        let mut mesh = Mesh::default();
        for face in faces {
            let from = u32::try_from(mesh.vertices.len()).expect("few");
            mesh.vertices.extend(*face);
            let corners: Vec<u32> = (from..from + u32::try_from(face.len()).expect("few")).collect();
            mesh.add_face(&corners).expect("its own vertices");
        }
        let grid = GeoRef::new((0.0, n as f64), (1.0, 1.0), (n, n), None).expect("a valid grid");
        let raster = top_surface(&"x.obj".into(), &mesh, &grid).expect("a surface");
        raster.cells().iter().map(|z| (*z != VOID).then(|| f64::from(*z) / 1024.0)).collect()
    }

    #[test]
    fn faces_that_share_an_edge_through_centers_cover_each_center_once() {
        // The edge x = 1.5 passes through centers, which belong to the east face. Likewise the
        // outer edge at 0.5 belongs to the inside, and the one at 2.5 to the outside.
        let west = [[0.5, 0.0, 1.0], [1.5, 0.0, 1.0], [1.5, 3.0, 1.0], [0.5, 3.0, 1.0]];
        let east = [[1.5, 0.0, 2.0], [2.5, 0.0, 2.0], [2.5, 3.0, 2.0], [1.5, 3.0, 2.0]];
        let row = [Some(1.0), Some(2.0), None];
        assert_eq!(surface(3, &[&west, &east]), [row, row, row].concat());
        // Walls cover nothing; a concave face covers only its inside.
        let wall = [[0.0, 0.0, 0.0], [3.0, 3.0, 0.0], [3.0, 3.0, 9.0], [0.0, 0.0, 9.0]];
        assert!(surface(3, &[&wall]).iter().all(Option::is_none));
        let ell =
            [[0.0, 0.0, 7.0], [3.0, 0.0, 7.0], [3.0, 1.0, 7.0], [1.0, 1.0, 7.0], [1.0, 3.0, 7.0], [0.0, 3.0, 7.0]];
        let (inside, outside) = (Some(7.0), None);
        let wanted = [[inside, outside, outside], [inside, outside, outside], [inside; 3]].concat();
        assert_eq!(surface(3, &[&ell]), wanted);
    }
}
