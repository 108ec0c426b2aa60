//! Points and edges by square cells, to find those near a place.

use std::ops::Range;

use super::vectors::{Edge, Place, minus};

/// Square cells over some points and edges: about one point in each, and no edge passes many.
struct Squares {
    corner: Place,
    side: f64,
    n_cols: usize,
    n_rows: usize,
}

/// Things in order of their cells, row by row.
struct ByCell<T> {
    all: Vec<T>,
    /// Begin of the items of each cell, and the end of all.
    starts: Vec<u32>,
}

/// Points, and edges in each cell that they pass.
pub(super) struct Grid {
    squares: Squares,
    points: ByCell<Place>,
    edges: ByCell<Edge>,
}

impl Squares {
    fn over(points: &[Place], edges: &[Edge]) -> Squares {
        let (mut low, mut high) = ([f64::INFINITY; 2], [0.0_f64; 2]);
        for place in points.iter().copied().chain(edges.iter().flat_map(Edge::ends)) {
            low = [0, 1].map(|k| low[k].min(place[k]));
            high = [0, 1].map(|k| high[k].max(place[k]));
        }
        let corner = low.map(|v| if v.is_finite() { v } else { 0.0 });
        let [width, height] = minus(high, corner);
        #[expect(clippy::cast_precision_loss, reason = "fewer points than 2^32")]
        let [n_points, n_edges] = [points.len(), edges.len()].map(|n| n.max(1) as f64);
        let mean_length = edges.iter().map(|edge| edge.length).sum::<f64>() / n_edges;
        let side = (width * height / n_points).sqrt().max(width.max(height) / n_points).max(mean_length).max(1.0);
        let [n_cols, n_rows] = [width, height].map(|length| whole(length / side) + 1);
        Squares { corner, side, n_cols, n_rows }
    }

    /// Returns the column and row of the cell that is nearest to a place.
    fn at(&self, place: Place) -> [usize; 2] {
        let [col, row] = minus(place, self.corner).map(|v| whole(v / self.side));
        [col.min(self.n_cols - 1), row.min(self.n_rows - 1)]
    }

    /// Returns the cells of one ring around a cell, in pieces of rows.
    fn ring(&self, [col, row]: [usize; 2], ring: usize) -> impl Iterator<Item = Range<usize>> {
        let rows = row.saturating_sub(ring)..(row + ring + 1).min(self.n_rows);
        let (first, last) = (col.saturating_sub(ring), (col + ring).min(self.n_cols - 1));
        rows.flat_map(move |at| {
            let start = at * self.n_cols;
            let is_whole = at.abs_diff(row) == ring;
            let west =
                (is_whole || col >= ring).then_some(start + first..start + if is_whole { last + 1 } else { first + 1 });
            let east = (!is_whole && col + ring == last).then_some(start + last..start + last + 1);
            west.into_iter().chain(east)
        })
    }

    /// Returns the cells of each row that a shape meets, which tells what part of a row it spans
    /// between two heights.
    fn met(&self, [south, north]: [f64; 2], span: impl Fn([f64; 2]) -> [f64; 2]) -> impl Iterator<Item = Range<usize>> {
        let rows = [south, north].map(|y| whole((y - self.corner[1]) / self.side));
        (rows[0]..=rows[1].min(self.n_rows - 1)).filter_map(move |row| {
            #[expect(clippy::cast_precision_loss, reason = "fewer rows than 2^32")]
            let low = self.corner[1] + row as f64 * self.side;
            let [west, east] =
                span([low.max(south), (low + self.side).min(north)]).map(|x| (x - self.corner[0]) / self.side);
            let start = row * self.n_cols;
            (east >= 0.0 && whole(west) < self.n_cols)
                .then(|| start + whole(west)..start + whole(east).min(self.n_cols - 1) + 1)
        })
    }

    /// Returns the cells that an edge passes.
    fn passed(&self, edge: &Edge) -> impl Iterator<Item = usize> {
        let [[x0, y0], [x1, y1]] = edge.ends();
        let dy = y1 - y0;
        let at = move |y: f64| if dy == 0.0 { x0 } else { x0 + (y - y0) / dy * (x1 - x0) };
        let span = move |[low, high]: [f64; 2]| {
            if dy == 0.0 { [x0.min(x1), x0.max(x1)] } else { [at(low).min(at(high)), at(low).max(at(high))] }
        };
        self.met([y0.min(y1), y0.max(y1)], span).flatten()
    }

    /// Returns the cells that a disc meets, in pieces of rows.
    fn of_disc(&self, [x, y]: Place, radius: f64) -> impl Iterator<Item = Range<usize>> {
        self.met([y - radius, y + radius], move |[low, high]| {
            let dy = (low - y).max(y - high).max(0.0);
            let half = (radius * radius - dy * dy).max(0.0).sqrt();
            [x - half, x + half]
        })
    }
}

impl<T: Copy> ByCell<T> {
    fn of(squares: &Squares, mut found: Vec<(usize, T)>) -> ByCell<T> {
        let n_cells = squares.n_cols * squares.n_rows;
        found.sort_by_key(|(cell, _)| *cell);
        let mut starts = vec![0; n_cells + 1];
        found.iter().for_each(|(cell, _)| starts[cell + 1] += 1);
        (0..n_cells).for_each(|cell| starts[cell + 1] += starts[cell]);
        ByCell { all: found.into_iter().map(|(_, thing)| thing).collect(), starts }
    }

    fn of_cells(&self, cells: Range<usize>) -> &[T] {
        &self.all[self.starts[cells.start] as usize..self.starts[cells.end] as usize]
    }
}

impl Grid {
    pub(super) fn of(points: &[Place], edges: &[Edge]) -> Grid {
        let squares = Squares::over(points, edges);
        let at = |point: Place| squares.at(point)[1] * squares.n_cols + squares.at(point)[0];
        let of_points = points.iter().map(|point| (at(*point), *point)).collect();
        let of_edges = edges.iter().flat_map(|edge| squares.passed(edge).map(|cell| (cell, *edge))).collect();
        Grid { points: ByCell::of(&squares, of_points), edges: ByCell::of(&squares, of_edges), squares }
    }

    /// Points near a place of the area of all, from rings of cells around its own, outwards.
    pub(super) fn points_around(&self, place: Place, n_rings: usize) -> impl Iterator<Item = Place> {
        let cell = self.squares.at(place);
        (0..n_rings)
            .flat_map(move |ring| self.squares.ring(cell, ring))
            .flat_map(|cells| self.points.of_cells(cells))
            .copied()
    }

    /// Returns the points that a disc holds, and some others.
    pub(super) fn points_in(&self, center: Place, radius: f64) -> impl Iterator<Item = Place> {
        self.squares.of_disc(center, radius).flat_map(|cells| self.points.of_cells(cells)).copied()
    }

    /// Returns the edges that a disc meets, and some others; an edge that passes many cells comes
    /// as often.
    pub(super) fn edges_in(&self, center: Place, radius: f64) -> impl Iterator<Item = &Edge> {
        self.squares.of_disc(center, radius).flat_map(|cells| self.edges.of_cells(cells))
    }
}

/// Returns the whole part of a number from 0 to 2^32; 0 of less.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
pub(super) fn whole(value: f64) -> usize {
    value as u32 as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::height_field::closing::vectors::{length, plus};

    #[test]
    fn what_a_disc_meets_is_found() {
        let mut state = 1_u64;
        let mut random = move |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            f64::from(u32::try_from((state >> 33) % n).unwrap())
        };
        for (width, height) in [(100, 100), (1000, 1), (1, 500), (1, 1), (37, 900)] {
            let mut place = || [500.0 + random(width), 80.0 + random(height)];
            let points: Vec<Place> = (0..200).map(|_| place()).collect();
            let mut edges = Vec::new();
            for (from, to) in points.iter().map(|point| (*point, place())) {
                edges.extend((length(minus(to, from)) > 0.0).then(|| Edge::between(from, to)));
            }
            let grid = Grid::of(&points, &edges);
            for center in (0..40).map(|_| place()) {
                for radius in [0.0, 3.0, 40.0, 1e4] {
                    let is_near = |p: &Place| length(minus(*p, center)) <= radius;
                    let found = grid.points_in(center, radius).filter(is_near).count();
                    assert_eq!(found, points.iter().filter(|p| is_near(p)).count(), "{width} {height} {radius}");
                    let meets = |edge: &&Edge| {
                        let t = edge.seen(center).0.clamp(0.0, edge.length);
                        is_near(&plus(edge.from, t, edge.along))
                    };
                    let ends = |edge: &Edge| edge.ends().map(|end| end.map(f64::to_bits));
                    let mut found: Vec<_> = grid.edges_in(center, radius).filter(meets).map(ends).collect();
                    let mut wanted: Vec<_> = edges.iter().filter(meets).map(ends).collect();
                    [&mut found, &mut wanted].into_iter().for_each(|list| {
                        list.sort_unstable();
                        list.dedup();
                    });
                    assert_eq!(found, wanted, "{width} {height} {radius}");
                }
                let all = grid.squares.n_rows.max(grid.squares.n_cols);
                assert_eq!(grid.points_around(center, all).count(), points.len());
                let is_in_ring =
                    grid.points_around(center, 2).all(|p| length(minus(p, center)) < 3.0 * grid.squares.side);
                assert!(is_in_ring);
            }
        }
    }
}
