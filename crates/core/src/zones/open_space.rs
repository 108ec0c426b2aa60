//! The zones of any scene, from the shape of the ground between its buildings.

use super::crossings::zones_of;
use super::mesh::Mesh;
use super::outline::Outlines;
use super::zone::{NONE, Zone};
use crate::height_field::HeightField;

/// The zone codes of the cells, row by row from the north-west.
pub(super) fn codes(field: &HeightField) -> Vec<u8> {
    let ground = Outlines::of(field).open_ground();
    let mesh = Mesh::of(&ground);
    let zones = zones_of(&mesh);
    let grid = field.grid();
    let (n_rows, n_cols) = (grid.n_rows(), grid.n_cols());
    // Cell centers in meters from the origin of the mesh.
    let xs: Vec<f64> = (0..n_cols).map(|col| grid.world_from_cell(0, col).0 - ground.origin[0]).collect();
    let ys: Vec<f64> = (0..n_rows).rev().map(|row| grid.world_from_cell(row, 0).1 - ground.origin[1]).collect();
    let mut codes = vec![NONE; grid.n_cells()];
    for (triangle, zone) in mesh.triangles.iter().zip(&zones) {
        let corners = triangle.corners.map(|c| mesh.points[c]);
        fill(corners, &xs, &ys, |x, y| codes[(n_rows - 1 - y) * n_cols + x] = zone.code());
    }
    let cells = field.cells();
    let mut left_over = Vec::new();
    for row in 0..n_rows {
        for col in 0..n_cols {
            let code = &mut codes[row * n_cols + col];
            if cells.building.contains(row, col) {
                *code = Zone::Rooftop.code();
            } else if !cells.open.contains(row, col) {
                *code = NONE;
            } else if *code == NONE {
                left_over.push((row, col));
            }
        }
    }
    spread(&mut codes, left_over, (n_rows, n_cols));
    codes
}

/// Calls `visit` with the indices of the positions inside a counterclockwise triangle. Positions on a side that two
/// triangles share belong to exactly one.
fn fill(corners: [[f64; 2]; 3], xs: &[f64], ys: &[f64], mut visit: impl FnMut(usize, usize)) {
    let south = corners.iter().map(|c| c[1]).fold(f64::INFINITY, f64::min);
    let north = corners.iter().map(|c| c[1]).fold(f64::NEG_INFINITY, f64::max);
    let first = ys.partition_point(|y| *y < south);
    let last = ys.partition_point(|y| *y < north);
    for (k, &y) in ys.iter().enumerate().take(last).skip(first) {
        let (mut west, mut east) = (f64::INFINITY, f64::NEG_INFINITY);
        for side in 0..3 {
            let (a, b) = (corners[side], corners[(side + 1) % 3]);
            // The same order of ends from both sides gives the same crossing.
            let (low, high) = if (a[1], a[0]) <= (b[1], b[0]) { (a, b) } else { (b, a) };
            if low[1] <= y && y < high[1] {
                let x = low[0] + (y - low[1]) / (high[1] - low[1]) * (high[0] - low[0]);
                (west, east) = (west.min(x), east.max(x));
            }
        }
        for x in xs.partition_point(|x| *x < west)..xs.partition_point(|x| *x < east) {
            visit(x, k);
        }
    }
}

/// Gives open cells that lie in no triangle (on a wall, or by a block too small to count) the zone of a neighbor, ring
/// by ring; those that reach none are street.
fn spread(codes: &mut [u8], mut left_over: Vec<(usize, usize)>, (n_rows, n_cols): (usize, usize)) {
    while !left_over.is_empty() {
        let zone_beside = |codes: &[u8], row: usize, col: usize| {
            let beside = [
                (row.checked_sub(1), Some(col)),
                (Some(row), col.checked_sub(1)),
                (Some(row), Some(col + 1).filter(|c| *c < n_cols)),
                (Some(row + 1).filter(|r| *r < n_rows), Some(col)),
            ];
            let codes = beside.into_iter().filter_map(|(r, c)| Some(codes[r? * n_cols + c?]));
            codes.filter(|code| *code != NONE && *code != Zone::Rooftop.code()).max()
        };
        let found: Vec<Option<u8>> = left_over.iter().map(|(row, col)| zone_beside(codes, *row, *col)).collect();
        let is_stuck = found.iter().all(Option::is_none);
        let mut rest = Vec::new();
        for ((row, col), code) in left_over.into_iter().zip(found) {
            match code.or(is_stuck.then(|| Zone::Street.code())) {
                Some(code) => codes[row * n_cols + col] = code,
                None => rest.push((row, col)),
            }
        }
        left_over = rest;
    }
}
