//! Iso-lines of a field on a rectilinear grid: marching squares with linear interpolation along
//! grid lines.
//!
//! If a square has opposite corners on one side of the level, the mean of its corners decides which
//! edges are joined. Squares with an unknown corner have no line.

use std::collections::{BTreeMap, VecDeque};

/// A field on a grid: places of the columns and of the rows \[px\] and values `[n_rows, n_cols]`,
/// columns fastest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Field<'a> {
    /// Places of the columns, monotonic.
    pub(crate) x: &'a [f64],
    /// Places of the rows, monotonic.
    pub(crate) y: &'a [f64],
    /// The values, one for each column and row.
    pub(crate) values: &'a [Option<f64>],
}

/// Points joined in order \[px\].
pub(crate) type Path = Vec<[f64; 2]>;

/// Grid line between neighboring grid points: row and column of the first, and `true` if the second
/// is in the next row.
type Edge = (usize, usize, bool);

impl Field<'_> {
    /// Returns the lines along which the field has this level: open paths, or closed paths with
    /// equal ends.
    pub(crate) fn lines(&self, level: f64) -> Vec<Path> {
        let mut joined: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
        for row in 1..self.y.len() {
            for col in 1..self.x.len() {
                for (a, b) in self.in_square(row - 1, col - 1, level) {
                    joined.entry(a).or_default().push(b);
                    joined.entry(b).or_default().push(a);
                }
            }
        }
        let mut lines = Vec::new();
        while let Some(start) = joined.keys().next().copied() {
            let mut line = VecDeque::from([start]);
            // From the start in one direction, then in the other.
            for push in [VecDeque::push_back, VecDeque::push_front] {
                let mut at = start;
                while let Some(next) = take(&mut joined, at) {
                    push(&mut line, next);
                    at = next;
                }
            }
            lines.push(line.into_iter().map(|edge| self.crossing(edge, level)).collect());
        }
        lines
    }

    fn value(&self, row: usize, col: usize) -> Option<f64> {
        self.values[row * self.x.len() + col]
    }

    /// Returns the pairs of edges that the level joins in the square from this grid point to the
    /// next row and column.
    fn in_square(&self, row: usize, col: usize, level: f64) -> Vec<(Edge, Edge)> {
        // Around the square; edge k is between corners k and k + 1.
        let corners = [(row, col), (row, col + 1), (row + 1, col + 1), (row + 1, col)];
        let edges: [Edge; 4] = [(row, col, false), (row, col + 1, true), (row + 1, col, false), (row, col, true)];
        let [Some(a), Some(b), Some(c), Some(d)] = corners.map(|(row, col)| self.value(row, col)) else {
            return Vec::new();
        };
        let values = [a, b, c, d];
        let above = values.map(|v| v >= level);
        let crossed: Vec<usize> = (0..4).filter(|k| above[*k] != above[(k + 1) % 4]).collect();
        match crossed[..] {
            [a, b] => vec![(edges[a], edges[b])],
            [_, _, _, _] => {
                let middle_is_above = values.iter().sum::<f64>() / 4.0 >= level;
                // The corners that differ from the middle are cut off: either 0 and 2 or 1 and 3.
                if middle_is_above == above[0] {
                    vec![(edges[0], edges[1]), (edges[2], edges[3])]
                } else {
                    vec![(edges[3], edges[0]), (edges[1], edges[2])]
                }
            }
            _ => Vec::new(),
        }
    }

    /// Returns the point of the level on an edge whose ends are on both sides of it.
    fn crossing(&self, (row, col, is_down): Edge, level: f64) -> [f64; 2] {
        let (next_row, next_col) = if is_down { (row + 1, col) } else { (row, col + 1) };
        let ends = [self.value(row, col), self.value(next_row, next_col)].map(Option::unwrap_or_default);
        let t = (level - ends[0]) / (ends[1] - ends[0]);
        let between = |a: f64, b: f64| a + (b - a) * t;
        [between(self.x[col], self.x[next_col]), between(self.y[row], self.y[next_row])]
    }
}

/// Takes one segment at an edge, and returns the edge at its far end.
fn take(joined: &mut BTreeMap<Edge, Vec<Edge>>, at: Edge) -> Option<Edge> {
    let next = joined.get_mut(&at)?.pop()?;
    if let Some(others) = joined.get_mut(&next)
        && let Some(back) = others.iter().position(|edge| *edge == at)
    {
        others.remove(back);
    }
    for edge in [at, next] {
        if joined.get(&edge).is_some_and(Vec::is_empty) {
            joined.remove(&edge);
        }
    }
    Some(next)
}

/// Cuts `gap` \[px\] out of the middle of a path. Returns both pieces and the middle; `None` for a
/// path shorter than three gaps.
pub(crate) fn cut_middle(line: &[[f64; 2]], gap: f64) -> Option<([Path; 2], [f64; 2])> {
    let length = |pair: &[[f64; 2]]| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
    let total: f64 = line.windows(2).map(length).sum();
    if total < 3.0 * gap {
        return None;
    }
    let first = head(line, total / 2.0);
    let middle = *first.last()?;
    // Points near the middle are cut off, however the path winds there.
    let is_far = |p: &[f64; 2]| (p[0] - middle[0]).hypot(p[1] - middle[1]) >= gap / 2.0;
    let half = |points: Path| -> Path {
        let Some(last) = points.iter().rposition(is_far) else { return Vec::new() };
        let mut kept = points[..=last].to_vec();
        if let Some(near) = points.get(last + 1) {
            // The point of the segment at that distance, by halving.
            let (mut far, mut near) = (points[last], *near);
            for _ in 0..40 {
                let between = [(far[0] + near[0]) / 2.0, (far[1] + near[1]) / 2.0];
                if is_far(&between) { far = between } else { near = between }
            }
            kept.push(far);
        }
        kept
    };
    let reversed: Path = line.iter().rev().copied().collect();
    Some(([half(first), half(head(&reversed, total / 2.0))], middle))
}

/// Returns the first `wanted` \[px\] of a path.
fn head(line: &[[f64; 2]], wanted: f64) -> Path {
    let mut rest = wanted;
    let mut points: Path = line.first().copied().into_iter().collect();
    for pair in line.windows(2) {
        let step = (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
        if step >= rest {
            let t = if step > 0.0 { rest / step } else { 0.0 };
            points.push([0, 1].map(|k| pair[0][k] + (pair[1][k] - pair[0][k]) * t));
            return points;
        }
        points.push(pair[1]);
        rest -= step;
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_at(a: [f64; 2], b: [f64; 2]) -> bool {
        (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-6
    }

    #[test]
    fn a_plane_has_one_straight_line() {
        let x: Vec<f64> = (0..5).map(|k| 10.0 * f64::from(k)).collect();
        let values: Vec<Option<f64>> = (0..20).map(|k| Some(f64::from(k % 5) / 4.0)).collect();
        let lines = Field { x: &x, y: &[30.0, 20.0, 10.0, 0.0], values: &values }.lines(0.4);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].len(), 4);
        assert!(lines[0].iter().all(|[x, _]| (x - 16.0).abs() < 1e-9), "{lines:?}");
        assert!(lines[0].windows(2).all(|pair| (pair[0][1] - pair[1][1]).abs() > 9.0));
    }

    #[test]
    fn a_summit_has_a_closed_line_and_a_saddle_has_two() {
        let x = [0.0, 1.0, 2.0];
        let summit: Vec<Option<f64>> = [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0].map(Some).to_vec();
        let lines = Field { x: &x, y: &x, values: &summit }.lines(0.5);
        assert_eq!((lines.len(), lines[0].len()), (1, 5));
        assert!(is_at(lines[0][0], lines[0][4]));
        let field = |values| Field { x: &x[..2], y: &x[..2], values };
        let saddle = [1.0, 0.0, 0.0, 1.0].map(Some);
        assert_eq!(field(&saddle).lines(0.4).len(), 2);
        // The middle is above 0.4 and below 0.6: the level goes around the other two corners.
        let goes_around = |level, corner: [f64; 2]| {
            let near = |p: &[f64; 2]| (p[0] - corner[0]).abs() + (p[1] - corner[1]).abs() < 0.7;
            field(&saddle).lines(level).iter().any(|line| line.iter().all(near))
        };
        assert!(goes_around(0.4, [1.0, 0.0]) && goes_around(0.4, [0.0, 1.0]));
        assert!(goes_around(0.6, [0.0, 0.0]) && goes_around(0.6, [1.0, 1.0]));
    }

    #[test]
    fn an_unknown_value_has_no_lines_around_it() {
        let x = [0.0, 1.0, 2.0, 3.0];
        let values: Vec<Option<f64>> = (0..16).map(|k| (k != 5).then_some(f64::from(k / 4) / 3.0)).collect();
        let lines = Field { x: &x, y: &x, values: &values }.lines(0.5);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].iter().all(|[x, _]| *x >= 2.0), "{lines:?}");
    }

    #[test]
    fn a_gap_is_cut_into_the_middle_of_a_long_line_only() {
        let line = [[0.0, 0.0], [60.0, 0.0], [60.0, 40.0]];
        let ([a, b], middle) = cut_middle(&line, 20.0).expect("it is long enough");
        assert!(is_at(middle, [50.0, 0.0]), "{middle:?}");
        assert!(a.len() == 2 && is_at(a[0], [0.0, 0.0]) && is_at(a[1], [40.0, 0.0]), "{a:?}");
        assert!(is_at(b[0], [60.0, 40.0]) && b.iter().all(|p| (p[0] - middle[0]).hypot(p[1]) > 10.0 - 1e-6), "{b:?}");
        assert!(cut_middle(&line, 40.0).is_none() && cut_middle(&[], 1.0).is_none());
    }
}
