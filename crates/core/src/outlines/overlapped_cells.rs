//! The cells of a grid that polygons overlap with positive area, in exact integers.
//!
//! A cell overlaps a polygon if the polygon's boundary passes through its open square, or if its
//! center is inside. The first kind is found edge by edge, as an interval of columns in each row.
//! The second is found along the middles of the rows.

use std::ops::Range;

use crate::overlay::doubled_area;

/// Calls `visit` with a row, counted from the north, and columns in it that the polygons overlap
/// with positive area. Columns may be visited twice.
///
/// Rings hold positions from the south-west corner of the grid, in steps; a cell has `steps` of
/// them along each axis. A polygon is the region that its rings enclose by the even-odd rule; its
/// edges do not cross. Positions and steps are below 2^29 and cells have at most 2^26 steps, so no
/// product overflows.
pub fn overlapped_cells(
    polygons: &[Vec<Vec<[i64; 2]>>],
    [step_x, step_y]: [i64; 2],
    (n_rows, n_cols): (usize, usize),
    mut visit: impl FnMut(usize, Range<usize>),
) {
    let clip = |v: i64, n: usize| usize::try_from(v.max(0)).unwrap_or(usize::MAX).min(n);
    let mut visit_from_south = |from_south: usize, from: i64, to: i64| {
        let cols = clip(from, n_cols)..clip(to, n_cols);
        if !cols.is_empty() {
            visit(n_rows - 1 - from_south, cols);
        }
    };
    for polygon in polygons {
        let ys = || polygon.iter().flatten().map(|p| p[1]);
        let (Some(south), Some(north)) = (ys().min(), ys().max()) else { continue };
        let first_row = clip(south.div_euclid(step_y), n_rows);
        let end_row = clip(-(-north).div_euclid(step_y), n_rows);
        // Positions at which the boundary crosses the middle of each row [cells].
        let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); end_row.saturating_sub(first_row)];
        for (a, b) in polygon.iter().flat_map(|ring| edges(ring)) {
            let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            if dy == 0 {
                let is_inside_a_row = a[1].rem_euclid(step_y) != 0;
                let row = a[1].div_euclid(step_y);
                if is_inside_a_row && row >= 0 && clip(row, n_rows) < n_rows {
                    let (west, east) = (a[0].min(b[0]), a[0].max(b[0]));
                    visit_from_south(clip(row, n_rows), west.div_euclid(step_x), -(-east).div_euclid(step_x));
                }
                continue;
            }
            let from_row = clip(a[1].div_euclid(step_y), n_rows);
            let to_row = clip(-(-b[1]).div_euclid(step_y), n_rows);
            for row in from_row..to_row {
                #[expect(clippy::cast_possible_wrap, reason = "rows of a grid in memory")]
                let (low, high) = (row as i64 * step_y, (row as i64 + 1) * step_y);
                // EXACT: x·dy at the ends of the edge within the open row, below 2^60.
                let at = |y: i64| a[0] * dy + (y - a[1]) * dx;
                let (p, q) = (at(low.max(a[1])), at(high.min(b[1])));
                let of_cell = dy * step_x;
                visit_from_south(row, p.min(q).div_euclid(of_cell), -(-p.max(q)).div_euclid(of_cell));
                // Half-open, so that a corner on the middle counts once.
                let middle = low + high;
                if 2 * a[1] <= middle && middle < 2 * b[1] {
                    // If rounding moves a crossing across a center, the edge passes through that
                    // cell anyway.
                    #[expect(clippy::cast_precision_loss, reason = "see above")]
                    let x = (a[0] as f64 + (middle - 2 * a[1]) as f64 / 2.0 * (dx as f64 / dy as f64)) / step_x as f64;
                    crossings[row - first_row].push(x);
                }
            }
        }
        for (row, crossings) in (first_row..).zip(&mut crossings) {
            crossings.sort_unstable_by(f64::total_cmp);
            for ends in crossings.chunks_exact(2) {
                #[expect(clippy::cast_possible_truncation, reason = "within the range of positions")]
                let first_center = |x: f64| (x - 0.5).ceil() as i64;
                visit_from_south(row, first_center(ends[0]), first_center(ends[1]));
            }
        }
    }
}

/// Calls `visit(row, col, share)` for each cell of a grid that polygons cover, with the covered
/// share of the cell.
///
/// Arguments are those of [`overlapped_cells`]; shares are rounded at about 10^-12.
pub fn covered_shares(
    polygons: &[Vec<Vec<[i64; 2]>>],
    [step_x, step_y]: [i64; 2],
    (n_rows, n_cols): (usize, usize),
    mut visit: impl FnMut(usize, usize, f64),
) {
    let bounds = polygons.iter().flatten().flatten().fold(None, |bounds: Option<[i64; 4]>, &[x, y]| {
        let [w, s, e, n] = bounds.unwrap_or([x, y, x, y]);
        Some([w.min(x), s.min(y), e.max(x), n.max(y)])
    });
    let Some([west, south, east, north]) = bounds else { return };
    let (first_col, end_col) = (west.div_euclid(step_x), -(-east).div_euclid(step_x));
    let (first_row, end_row) = (south.div_euclid(step_y), -(-north).div_euclid(step_y));
    #[expect(clippy::cast_precision_loss, reason = "positions are below 2^29")]
    let cells = |v: i64, step: i64| v as f64 / step as f64;
    let n = usize::try_from(end_col - first_col).unwrap_or(0);
    // Edges with the sign of their ring, sorted by the row in which they begin.
    let mut to_come: Vec<(f64, [i64; 2], [i64; 2])> = Vec::new();
    for (k, ring) in polygons.iter().flat_map(|rings| rings.iter().enumerate()) {
        let sign = if (doubled_area(ring) > 0) == (k == 0) { 1.0 } else { -1.0 };
        to_come.extend(edges(ring).filter(|(a, b)| a[1] != b[1]).map(|(a, b)| (sign, a, b)));
    }
    to_come.sort_by_key(|(_, a, b)| std::cmp::Reverse(a[1].min(b[1])));
    let mut met: Vec<(f64, [i64; 2], [i64; 2])> = Vec::new();
    for row in first_row..end_row {
        while let Some(edge) = to_come.pop_if(|(_, a, b)| a[1].min(b[1]).div_euclid(step_y) <= row) {
            met.push(edge);
        }
        met.retain(|(_, a, b)| a[1].max(b[1]).div_euclid(step_y) >= row);
        // For each column: the height of the row that edges cover in it, and the area to their east
        // within it. Both are signed, so that the sum over all edges of shells and holes is the
        // region's.
        let (mut height, mut area) = (vec![0.0; n + 1], vec![0.0; n + 1]);
        let mut overlaps = false;
        for (sign, a, b) in &met {
            let ((ax, ay), (bx, by)) =
                ((cells(a[0], step_x), cells(a[1], step_y)), (cells(b[0], step_x), cells(b[1], step_y)));
            let (low, high) = (ay.min(by).max(cells(row, 1)), ay.max(by).min(cells(row + 1, 1)));
            if low >= high {
                continue;
            }
            overlaps = true;
            let x_at = |y: f64| ax + (y - ay) * ((bx - ax) / (by - ay)) - cells(first_col, 1);
            let up = if by > ay { -sign } else { *sign };
            add_edge((x_at(low), x_at(high)), up * (high - low), &mut height, &mut area);
        }
        let Ok(from_south) = usize::try_from(row) else { continue };
        if !overlaps || from_south >= n_rows {
            continue;
        }
        let mut to_the_west = 0.0;
        for k in 0..n {
            let share = to_the_west + area[k];
            to_the_west += height[k];
            let col = first_col + i64::try_from(k).unwrap_or(i64::MAX);
            if let Some(col) = usize::try_from(col).ok().filter(|col| *col < n_cols && share > 0.0) {
                visit(n_rows - 1 - from_south, col, share.min(1.0));
            }
        }
    }
}

/// Adds an edge that runs from `x.0` to `x.1` \[cells\] over a signed height of a row.
fn add_edge(x: (f64, f64), height: f64, heights: &mut [f64], areas: &mut [f64]) {
    let (west, east) = (x.0.min(x.1), x.0.max(x.1));
    let last = heights.len() - 1;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the columns")]
    let col_of = |x: f64| (x.floor().max(0.0) as usize).min(last);
    for col in col_of(west)..=col_of(east) {
        #[expect(clippy::cast_precision_loss, reason = "columns of a grid in memory")]
        let (left, right) = (col as f64, col as f64 + 1.0);
        let (from, to) = (west.max(left), east.min(right));
        let part = if east > west { height * (to - from).max(0.0) / (east - west) } else { height };
        heights[col] += part;
        areas[col] += part * (right - 0.5 * (from + to));
    }
}

/// Returns the edges of a ring, which is not closed.
fn edges(ring: &[[i64; 2]]) -> impl Iterator<Item = ([i64; 2], [i64; 2])> {
    ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(polygon: &[Vec<[i64; 2]>], steps: [i64; 2]) -> Vec<(usize, usize)> {
        let mut found = Vec::new();
        overlapped_cells(&[polygon.to_vec()], steps, (4, 5), |row, cols| found.extend(cols.map(|col| (row, col))));
        found.sort_unstable();
        found.dedup();
        found
    }

    #[test]
    fn walls_on_borders_touch_no_neighbor() {
        let square = |w, s, e, n| vec![vec![[w, s], [e, s], [e, n], [w, n]]];
        assert_eq!(cells(&square(10, 10, 20, 30), [10, 10]), [(1, 1), (2, 1)]);
        assert_eq!(cells(&square(9, 10, 20, 30), [10, 10]), [(1, 0), (1, 1), (2, 0), (2, 1)]);
        assert_eq!(cells(&square(-30, -30, 0, 50), [10, 10]), []);
        assert_eq!(cells(&square(41, 33, 49, 38), [10, 10]), [(0, 4)]);
        // A triangle whose long side passes through corners, and one that reaches a step beyond
        // them.
        assert_eq!(
            cells(&[vec![[0, 0], [30, 30], [0, 30]]], [10, 10]),
            [(1, 0), (1, 1), (1, 2), (2, 0), (2, 1), (3, 0)]
        );
        assert_eq!(cells(&[vec![[1, 0], [31, 30], [1, 30]]], [10, 10]).len(), 9);
    }

    #[test]
    fn a_hole_takes_whole_cells_out_and_shares_add_up_to_the_area() {
        let court = vec![vec![[0, 0], [50, 0], [50, 40], [0, 40]], vec![[10, 10], [10, 30], [40, 30], [40, 10]]];
        assert_eq!(cells(&court, [10, 10]).len(), 14);
        let ring = vec![[3, 5], [47, 2], [38, 36], [21, 11], [7, 39]];
        let (mut sum, mut shared) = (0.0, Vec::new());
        covered_shares(&[vec![ring.clone()]], [10, 10], (4, 5), |row, col, share| {
            sum += share;
            shared.push((row, col));
        });
        shared.sort_unstable();
        // Twice the area by the shoelace formula.
        let doubled: i64 = edges(&ring).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
        assert!((sum - doubled as f64 / 200.0).abs() < 1e-9, "{sum}");
        assert_eq!(shared, cells(&[ring], [10, 10]));
    }
}
