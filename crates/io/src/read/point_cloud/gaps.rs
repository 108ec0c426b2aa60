//! Heights for cells of a terrain without a point of the ground.
//!
//! Gaps are filled linearly within the triangles of known cells (Delaunay), beyond their hull with
//! the height of the nearest known cell. Triangles are drawn cell by cell, and the nearest cells
//! are found for all cells at once, so that no shape of the known cells makes a cell expensive.
//!
//! Only known cells at the rim of gaps are corners. A circle around a triangle over a gap reaches no
//! deeper into known cells than to their rim. So these are the triangles of all known cells, but for
//! the choice among several corners of one circle.
//!
//! # References
//! Felzenszwalb & Huttenlocher 2012, Distance transforms of sampled functions: the lower envelope
//! of parabolas.

use rayon::prelude::*;
use spade::Point2;

use crate::quantity::{VOID, height_steps, meters};
use crate::read::triangulated_heights::{KnownHeight, TriangulatedHeights};

/// Fills the cells without a height. Without any known cell, all stay [`VOID`].
pub(super) fn fill_gaps(cells: &mut [i32], n_cols: usize) {
    if !cells.contains(&VOID) {
        return;
    }
    let mut filled = vec![VOID; cells.len()];
    if let Some(corners) = corners(cells, n_cols) {
        let ground = TriangulatedHeights::through(corners.into_iter());
        ground.triangles().for_each(|triangle| draw(&triangle, &mut filled, n_cols));
    }
    let is_whole = cells.iter().zip(&filled).all(|(known, filled)| *known != VOID || *filled != VOID);
    if !is_whole {
        fill_with_nearest(cells, &mut filled, n_cols);
    }
    let gaps = cells.iter_mut().zip(filled).filter(|(cell, _)| **cell == VOID);
    gaps.for_each(|(cell, filled)| *cell = filled);
}

/// Returns the known cells at the rim of gaps. Neighbors follow one another, and the first three are
/// not in line. `None` if all are in line.
fn corners(cells: &[i32], n_cols: usize) -> Option<Vec<KnownHeight>> {
    let n_rows = cells.len() / n_cols;
    let is_at_rim = |row: usize, col: usize| {
        let cols = col.saturating_sub(1)..=(col + 1).min(n_cols - 1);
        let mut rows = row.saturating_sub(1)..=(row + 1).min(n_rows - 1);
        rows.any(|row| cells[row * n_cols..][cols.clone()].contains(&VOID))
    };
    let mut rim: Vec<usize> =
        (0..cells.len()).filter(|k| cells[*k] != VOID && is_at_rim(k / n_cols, k % n_cols)).collect();
    rim.sort_by_cached_key(|index| place_on_curve(index / n_cols, index % n_cols));
    #[expect(clippy::cast_precision_loss, reason = "rows and columns are below 65536")]
    let corner = |index: usize| KnownHeight {
        at: Point2::new((index % n_cols) as f64, (index / n_cols) as f64),
        height_m: meters(cells[index]),
    };
    let mut corners: Vec<KnownHeight> = rim.into_iter().map(corner).collect();
    let [a, b, ..] = corners[..] else { return None };
    let is_beside = |c: &KnownHeight| {
        // Whole numbers, so that this is exact.
        let across = (b.at.x - a.at.x) * (c.at.y - a.at.y) - (b.at.y - a.at.y) * (c.at.x - a.at.x);
        across.abs() >= 0.5
    };
    let third = corners.iter().position(is_beside)?;
    corners.swap(2, third);
    Some(corners)
}

/// Returns the place of a cell along a curve of Hilbert through 65536 × 65536 cells.
fn place_on_curve(row: usize, col: usize) -> u64 {
    const EDGE: usize = 1 << 16;
    let (mut x, mut y, mut place) = (col, row, 0);
    let mut half = EDGE / 2;
    while half > 0 {
        let (right, upper) = (x & half != 0, y & half != 0);
        let quarter = match (right, upper) {
            (false, false) => 0,
            (false, true) => 1,
            (true, true) => 2,
            (true, false) => 3,
        };
        place = place << 2 | quarter;
        if !upper {
            if right {
                (x, y) = (EDGE - 1 - x, EDGE - 1 - y);
            }
            (x, y) = (y, x);
        }
        half /= 2;
    }
    place
}

/// Draws a triangle into cells. Cells on its edges are drawn, too: the next triangle has the same
/// heights there.
fn draw(corners: &[KnownHeight; 3], cells: &mut [i32], n_cols: usize) {
    let span = |of: fn(&KnownHeight) -> f64| {
        let values = corners.iter().map(of);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        (low, values.fold(f64::NEG_INFINITY, f64::max))
    };
    let ((west, east), (first, last)) = (span(|c| c.at.x), span(|c| c.at.y));
    // Its cells are its corners.
    if east - west <= 1.0 && last - first <= 1.0 {
        return;
    }
    let [a, b, c] = corners;
    let across = |p: Point2<f64>, q: Point2<f64>, r: Point2<f64>| (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
    let area = across(a.at, b.at, c.at);
    let slope_x =
        ((b.height_m - a.height_m) * (c.at.y - a.at.y) - (c.height_m - a.height_m) * (b.at.y - a.at.y)) / area;
    let slope_y =
        ((c.height_m - a.height_m) * (b.at.x - a.at.x) - (b.height_m - a.height_m) * (c.at.x - a.at.x)) / area;
    let mut y = first;
    while y <= last {
        let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let (low, high) = if p.at.y <= q.at.y { (p.at, q.at) } else { (q.at, p.at) };
            if low.y <= y && y <= high.y {
                let ends = if high.y > low.y {
                    [low.x + (high.x - low.x) * (y - low.y) / (high.y - low.y); 2]
                } else {
                    [low.x, high.x]
                };
                from = from.min(ends[0]).min(ends[1]);
                to = to.max(ends[0]).max(ends[1]);
            }
        }
        // Rounding moves a crossing by less than this.
        let (mut x, to) = ((from - 1e-6).ceil(), (to + 1e-6).floor());
        while x <= to {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the corners' cells")]
            let index = y as usize * n_cols + x as usize;
            let height_m = a.height_m + slope_x * (x - a.at.x) + slope_y * (y - a.at.y);
            cells[index] = height_steps(height_m).unwrap_or(VOID);
            x += 1.0;
        }
        y += 1.0;
    }
}

/// Fills what is [`VOID`] both in `known` and in `filled` with the height of the nearest cell of
/// `known`.
fn fill_with_nearest(known: &[i32], filled: &mut [i32], n_cols: usize) {
    let nearest = nearest_in_column(known, n_cols);
    filled.par_chunks_mut(n_cols).zip(known.par_chunks(n_cols)).enumerate().for_each(|(row, (filled, cells))| {
        if !filled.iter().zip(cells).any(|(filled, known)| *filled == VOID && *known == VOID) {
            return;
        }
        let nearest = &nearest[row * n_cols..][..n_cols];
        let rise = |col: usize| (i64::from(nearest[col]) - signed(row)).pow(2);
        // Columns whose nearest cells are the nearest of some cells of the row, and where they begin.
        let mut envelope: Vec<(usize, i64)> = Vec::new();
        for col in (0..n_cols).filter(|col| nearest[*col] != NONE) {
            let mut begin = i64::MIN;
            while let Some((other, from)) = envelope.last().copied() {
                // The first column that is nearer to this one than to the other.
                let (this, that) = (signed(col), signed(other));
                let twice = this * this + rise(col) - that * that - rise(other);
                begin = twice.div_euclid(2 * (this - that)) + 1;
                if begin > from {
                    break;
                }
                envelope.pop();
                begin = i64::MIN;
            }
            envelope.push((col, begin));
        }
        let mut at = 0;
        for (col, cell) in filled.iter_mut().enumerate() {
            while envelope.get(at + 1).is_some_and(|(_, begin)| *begin <= signed(col)) {
                at += 1;
            }
            if let (Some((from, _)), true) = (envelope.get(at), *cell == VOID) {
                *cell = known[nearest[*from] as usize * n_cols + from];
            }
        }
    });
}

/// Row of a cell that has no known cell in its column.
const NONE: u32 = u32::MAX;

/// Returns for each cell the row of the nearest known cell in its column, [`NONE`] where none is.
fn nearest_in_column(known: &[i32], n_cols: usize) -> Vec<u32> {
    let n_rows = known.len() / n_cols;
    let mut nearest = vec![NONE; known.len()];
    for row in 0..n_rows {
        for col in 0..n_cols {
            let index = row * n_cols + col;
            nearest[index] = match known[index] {
                VOID if row > 0 => nearest[index - n_cols],
                VOID => NONE,
                _ => u32::try_from(row).unwrap_or(NONE),
            };
        }
    }
    for row in (0..n_rows.saturating_sub(1)).rev() {
        for col in 0..n_cols {
            let index = row * n_cols + col;
            let (above, below) = (nearest[index], nearest[index + n_cols]);
            let distance = |other: u32| if other == NONE { i64::MAX } else { (i64::from(other) - signed(row)).abs() };
            if distance(below) < distance(above) {
                nearest[index] = below;
            }
        }
    }
    nearest
}

/// Returns a number of rows or columns as a signed one.
fn signed(n: usize) -> i64 {
    i64::try_from(n).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(state: &mut u64) -> usize {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(*state >> 40).expect("24 bits")
    }

    #[test]
    fn a_plane_is_filled_as_a_plane() {
        let (n, mut state) = (40_usize, 7);
        // A plane has the same heights whatever the triangles are.
        let plane = |row: usize, col: usize| i32::try_from(3000 + 64 * row + 16 * col).expect("a small height");
        let mut cells: Vec<i32> = (0..n * n).map(|k| plane(k / n, k % n)).collect();
        for row in 5..20 {
            cells[row * n + 7..row * n + 30].fill(VOID);
        }
        for _ in 0..700 {
            // The rim of the grid stays, so that all gaps lie within the hull.
            let (row, col) = (1 + random(&mut state) % (n - 2), 1 + random(&mut state) % (n - 2));
            cells[row * n + col] = VOID;
        }
        fill_gaps(&mut cells, n);
        let wrong = (0..n * n).filter(|k| cells[*k] != plane(k / n, k % n)).count();
        assert_eq!(wrong, 0);
    }

    type Place = (i64, i64);

    /// Returns twice the area of a triangle, above 0 if its corners turn from x to y.
    fn turn(a: Place, b: Place, c: Place) -> i64 {
        (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
    }

    /// Returns `true` if `d` lies inside of the circle through three corners with a positive area.
    fn is_in_circle([a, b, c]: [Place; 3], d: Place) -> bool {
        let row = |p: Place| {
            let (x, y) = (p.0 - d.0, p.1 - d.1);
            [x, y, x * x + y * y]
        };
        let [[ax, ay, aw], [bx, by, bw], [cx, cy, cw]] = [row(a), row(b), row(c)];
        ax * (by * cw - bw * cy) - ay * (bx * cw - bw * cx) + aw * (bx * cy - by * cx) > 0
    }

    /// Each gap has the height of a triangle of known cells whose circle is empty; beyond all of these
    /// that of a nearest cell.
    #[test]
    fn gaps_have_heights_of_triangles_with_empty_circles() {
        let (n_rows, n_cols, mut state) = (9, 10, 3);
        for share in [2, 3, 5, 10, 30] {
            let n_cells = n_rows * n_cols;
            let mut cells = vec![VOID; n_cells];
            for cell in &mut cells {
                if random(&mut state).is_multiple_of(share) {
                    *cell = i32::try_from(1024 * (random(&mut state) % 60)).expect("a small height");
                }
            }
            let place = |k: usize| (signed(k % n_cols), signed(k / n_cols));
            let known: &Vec<usize> = &(0..n_cells).filter(|k| cells[*k] != VOID).collect();
            let triples =
                known.iter().flat_map(move |a| known.iter().flat_map(move |b| known.iter().map(move |c| [*a, *b, *c])));
            let is_delaunay = |triple: &[usize; 3]| {
                let corners = triple.map(place);
                let is_first = triple[0] < triple[1] && triple[0] < triple[2];
                is_first
                    && turn(corners[0], corners[1], corners[2]) > 0
                    && !known.iter().any(|k| is_in_circle(corners, place(*k)))
            };
            let triangles: Vec<[usize; 3]> = triples.filter(is_delaunay).collect();
            let mut filled = cells.clone();
            fill_gaps(&mut filled, n_cols);
            for gap in (0..n_cells).filter(|k| cells[*k] == VOID) {
                let at = place(gap);
                let mut heights = Vec::new();
                for triangle in &triangles {
                    let [a, b, c] = triangle.map(place);
                    let weights = [turn(at, b, c), turn(a, at, c), turn(a, b, at)];
                    if weights.iter().all(|weight| *weight >= 0) {
                        let sum: i64 = triangle.iter().zip(weights).map(|(k, w)| i64::from(cells[*k]) * w).sum();
                        heights.push(sum as f64 / turn(a, b, c) as f64);
                    }
                }
                if heights.is_empty() {
                    let distance = |k: &usize| (place(*k).0 - at.0).pow(2) + (place(*k).1 - at.1).pow(2);
                    let least = known.iter().map(distance).min();
                    let nearest = known.iter().filter(|k| Some(distance(k)) == least);
                    heights.extend(nearest.map(|k| f64::from(cells[*k])));
                }
                let found = f64::from(filled[gap]);
                assert!(
                    heights.is_empty() || heights.iter().any(|height| (height - found).abs() <= 0.5 + 1e-6),
                    "{at:?}, one of {share} known: {found}, not one of {heights:?}"
                );
            }
        }
    }

    #[test]
    fn beyond_the_hull_and_beside_a_line_the_nearest_cell_counts() {
        let mut cells = vec![VOID; 5 * 4];
        cells[5 + 1] = 1024;
        fill_gaps(&mut cells, 5);
        assert!(cells.iter().all(|z| *z == 1024), "{cells:?}");
        let mut none = vec![VOID; 6];
        fill_gaps(&mut none, 3);
        assert!(none.iter().all(|z| *z == VOID));
        // A line across: each cell takes the foot of its perpendicular, or one beside it.
        let n = 30;
        let mut line: Vec<i32> =
            (0..n * n).map(|k| if k / n == k % n { i32::try_from(k % n).expect("small") } else { VOID }).collect();
        fill_gaps(&mut line, n);
        for (k, height) in line.iter().enumerate() {
            let off = 2 * height - i32::try_from(k / n + k % n).expect("small");
            assert!(off.abs() <= 1, "{k}: {height}");
        }
    }
}
