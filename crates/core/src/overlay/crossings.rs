//! Number of crossings between edges of rings, counted before an overlay pays for them.

use std::fmt;
use std::ops::ControlFlow;

use super::rings::Ring;

/// Crossings allowed in any region, in addition to [`CROSSINGS_PER_EDGE`].
const MOST_CROSSINGS: usize = 30_000;

/// Crossings allowed in any region for each edge.
const CROSSINGS_PER_EDGE: usize = 4;

/// Pairs of edges that may be compared, in addition to [`PAIRS_PER_EDGE`].
const MOST_PAIRS: usize = 20_000_000;

/// Pairs of edges that may be compared, for each edge.
const PAIRS_PER_EDGE: usize = 256;

/// Edges that cross too often for an overlay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tangle {
    /// More crossings than this.
    Crossings(usize),
    /// More pairs of edges than this lie beside one another.
    Pairs(usize),
    /// More pairs of outlines than this lie on one another.
    Outlines(usize),
}

impl fmt::Display for Tangle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Tangle::Crossings(most) => write!(f, "edges that cross one another more than {most} times"),
            Tangle::Pairs(most) => write!(f, "more than {most} pairs of long edges side by side"),
            Tangle::Outlines(most) => write!(f, "more than {most} pairs of outlines on one another"),
        }
    }
}

/// Refuses rings whose edges cross too often for an overlay: more than 30 000 times plus 4 for each
/// edge.
///
/// Two edges cross if they share more than an end; equal edges do not cross. Cost: n log n, plus
/// comparisons of pairs, at most 20 million and 256 for each edge.
///
/// # Errors
/// The limit that was exceeded.
pub fn check_crossings<'a>(rings: impl IntoIterator<Item = &'a Ring> + Clone) -> Result<(), Tangle> {
    let n_edges: usize = rings.clone().into_iter().map(Vec::len).sum();
    let most = most_crossings(n_edges);
    // The number of all pairs.
    if n_edges * n_edges.saturating_sub(1) / 2 <= most {
        return Ok(());
    }
    count(rings, most).map(drop)
}

/// Returns the number of crossings that an overlay pays for.
pub(super) fn most_crossings(n_edges: usize) -> usize {
    MOST_CROSSINGS + CROSSINGS_PER_EDGE * n_edges
}

/// Returns `true` if rings cross so often that joining them by halves costs less.
///
/// Pairs of edges side by side do not count: halves have as many.
pub(crate) fn are_many<'a>(rings: impl IntoIterator<Item = &'a Ring> + Clone) -> bool {
    let n_edges: usize = rings.clone().into_iter().map(Vec::len).sum();
    matches!(count(rings, few_crossings(n_edges)), Err(Tangle::Crossings(_)))
}

/// Returns the number of crossings above which rings are joined by halves.
pub(super) fn few_crossings(n_edges: usize) -> usize {
    1000 + CROSSINGS_PER_EDGE * n_edges
}

/// An edge from its smaller end.
pub(super) type Edge = [[i32; 2]; 2];

/// Returns the edges of rings, each once, in ascending order.
pub(super) fn edges_once<'a>(rings: impl IntoIterator<Item = &'a Ring>) -> Vec<Edge> {
    let mut edges = edges_of(rings);
    edges.sort_unstable();
    edges.dedup();
    edges
}

fn edges_of<'a>(rings: impl IntoIterator<Item = &'a Ring>) -> Vec<Edge> {
    let of_ring = |ring: &'a Ring| ring.iter().zip(ring.iter().cycle().skip(1)).map(|(&a, &b)| [a.min(b), a.max(b)]);
    rings.into_iter().flat_map(of_ring).collect()
}

/// Counts the crossings of edges.
///
/// # Errors
/// More than `most`, or too many pairs of edges side by side.
pub(super) fn count<'a>(rings: impl IntoIterator<Item = &'a Ring>, most: usize) -> Result<usize, Tangle> {
    let mut n_crossings = 0;
    let met = for_each_crossing(&edges_once(rings), |_, _| {
        n_crossings += 1;
        if n_crossings > most { ControlFlow::Break(Tangle::Crossings(most)) } else { ControlFlow::Continue(()) }
    });
    met.break_value().map_or(Ok(n_crossings), Err)
}

/// Calls `visit` with the numbers of every two edges that cross, until it breaks or more pairs were
/// compared than 20 million and 256 for each edge.
///
/// `edges` are in ascending order. The plane is cut into strips about as high as an edge, or at
/// most as many as the root of the number of edges. In each strip edges are visited from west to
/// east. Each is compared with the earlier edges that reach as far east as it begins.
pub(super) fn for_each_crossing(
    edges: &[Edge],
    mut visit: impl FnMut(usize, usize) -> ControlFlow<Tangle>,
) -> ControlFlow<Tangle> {
    let n = edges.len();
    let ys = |edge: &Edge| [edge[0][1].min(edge[1][1]), edge[0][1].max(edge[1][1])].map(i64::from);
    let south = edges.iter().map(|edge| ys(edge)[0]).min();
    let north = edges.iter().map(|edge| ys(edge)[1]).max();
    let (Some(south), Some(north), Ok(count)) = (south, north, i64::try_from(n)) else {
        return ControlFlow::Continue(());
    };
    let mean = edges.iter().map(|edge| ys(edge)[1] - ys(edge)[0]).sum::<i64>() / count;
    let height = mean.max((north - south) / count.isqrt()) + 1;
    let strip = |y: i64| usize::try_from((y - south) / height).unwrap_or(0);
    let mut in_strips: Vec<Vec<usize>> = vec![Vec::new(); strip(north) + 1];
    for (number, edge) in edges.iter().enumerate() {
        let [low, high] = ys(edge);
        in_strips[strip(low)..=strip(high)].iter_mut().for_each(|numbers| numbers.push(number));
    }
    let most_pairs = MOST_PAIRS + PAIRS_PER_EDGE * n;
    let mut n_pairs = 0;
    let mut before: Vec<usize> = Vec::new();
    for (k, numbers) in in_strips.iter().enumerate() {
        before.clear();
        for &number in numbers {
            n_pairs += before.len();
            if n_pairs > most_pairs {
                return ControlFlow::Break(Tangle::Pairs(most_pairs));
            }
            let edge = &edges[number];
            before.retain(|other| edges[*other][1][0] >= edge[0][0]);
            let [low, high] = ys(edge);
            for &other in &before {
                let [other_low, other_high] = ys(&edges[other]);
                // Two edges that share several strips are compared in the lowest of them.
                let is_here = other_low <= high && other_high >= low && strip(other_low.max(low)) == k;
                if is_here && cross(&edges[other], edge) {
                    visit(other, number)?;
                }
            }
            before.push(number);
        }
    }
    ControlFlow::Continue(())
}

/// Returns `true` if two different edges share more than an end.
fn cross([a, b]: &Edge, [c, d]: &Edge) -> bool {
    let (of_c, of_d) = (turn(a, b, c), turn(a, b, d));
    if of_c == 0 && of_d == 0 {
        return a.max(c) < b.min(d);
    }
    let shares_end = a == c || a == d || b == c || b == d;
    !shares_end && of_c * of_d <= 0 && turn(c, d, a) * turn(c, d, b) <= 0
}

/// Returns 1 if r is to the left of the way from p to q, −1 if to its right, 0 if on its line.
pub(super) fn turn(p: &[i32; 2], q: &[i32; 2], r: &[i32; 2]) -> i64 {
    let d = |p: &[i32; 2], q: &[i32; 2]| [0, 1].map(|k| i64::from(q[k]) - i64::from(p[k]));
    let ([ux, uy], [vx, vy]) = (d(p, q), d(p, r));
    (ux * vy - uy * vx).signum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns all crossings, pair by pair.
    fn counted(edges: &[Edge]) -> usize {
        let mut edges = edges.to_vec();
        edges.sort_unstable();
        edges.dedup();
        (0..edges.len()).map(|k| edges[..k].iter().filter(|other| cross(other, &edges[k])).count()).sum()
    }

    #[test]
    fn edges_cross_where_they_have_more_in_common_than_an_end() {
        let crossing = |a: [i32; 4], b: [i32; 4]| {
            let edge = |[x0, y0, x1, y1]: [i32; 4]| [[x0, y0].min([x1, y1]), [x0, y0].max([x1, y1])];
            cross(&edge(a), &edge(b))
        };
        assert!(crossing([0, 0, 9, 9], [0, 9, 9, 0]));
        assert!(crossing([0, 0, 9, 0], [4, 0, 5, 7]), "one ends on the other");
        assert!(crossing([0, 0, 9, 0], [4, 0, 12, 0]), "they share a part");
        assert!(crossing([0, 0, 9, 9], [0, 0, 4, 4]), "one is a part of the other");
        assert!(!crossing([0, 0, 9, 0], [9, 0, 12, 0]), "one goes on where the other ends");
        assert!(!crossing([0, 0, 9, 0], [9, 0, 9, 7]));
        assert!(!crossing([0, 0, 9, 0], [0, 1, 9, 1]));
        assert!(!crossing([0, 0, 9, 0], [10, 5, 10, -5]));
    }

    #[test]
    fn strips_count_what_all_pairs_do() {
        // Rings of a multiplicative generator, of long and of short edges.
        let mut state = 1_u64;
        let mut random = |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            i32::try_from((state >> 33) % n).expect("a small number")
        };
        for (n, reach) in [(40, 20), (200, 30), (300, 3000)] {
            let mut at = [0, 0];
            let ring: Ring = std::iter::repeat_with(|| {
                at = [0, 1].map(|k| at[k] + random(2 * reach + 1) - i32::try_from(reach).expect("small"));
                at
            })
            .take(n)
            .collect();
            let truth = counted(&edges_of([&ring]));
            assert!(truth > 10);
            assert_eq!(count([&ring], truth), Ok(truth));
            assert_eq!(count([&ring], truth - 1), Err(Tangle::Crossings(truth - 1)));
        }
    }
}
