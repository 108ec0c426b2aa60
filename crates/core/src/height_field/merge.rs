//! Joins convex pieces that share a whole edge into larger convex pieces.
//!
//! Hertel & Mehlhorn 1985: drop every shared edge whose removal leaves both its ends convex. Let
//! two convex rings with disjoint interiors share an edge. Their union is convex if and only if it
//! turns left (or goes straight) at both ends of that edge, so one exact orientation test at each
//! end decides. Long edges are dropped first, because they stand between large pieces. For a
//! triangulated polygon the outcome has at most four times the pieces of the best.

use super::rings::{turn, without_collinear};
use crate::disjoint_sets::DisjointSets;
use crate::overlay::Ring;

/// Joins convex counterclockwise rings where the union is convex. Vertices on a straight edge are
/// removed.
///
/// Rings that are joined lie on opposite sides of the edge that they share; the union of all rings
/// stays what it was. Cost: one sort of the edges, and the length of both rings for each edge that
/// is shared.
pub(super) fn merged(rings: Vec<Ring>) -> Vec<Ring> {
    if rings.len() < 2 {
        return rings;
    }
    let mut edges: Vec<([i32; 2], [i32; 2], usize)> = Vec::with_capacity(rings.iter().map(Vec::len).sum());
    for (k, ring) in rings.iter().enumerate() {
        let next = ring.iter().cycle().skip(1);
        edges.extend(ring.iter().zip(next).map(|(&a, &b)| (a.min(b), a.max(b), k)));
    }
    edges.sort_unstable();
    let length = |a: [i32; 2], b: [i32; 2]| {
        let d = |k: usize| i128::from(a[k]) - i128::from(b[k]);
        d(0) * d(0) + d(1) * d(1)
    };
    let mut shared: Vec<_> = edges
        .windows(2)
        .filter(|pair| pair[0].0 == pair[1].0 && pair[0].1 == pair[1].1)
        .map(|pair| (length(pair[0].0, pair[0].1), pair[0], pair[1].2))
        .collect();
    if shared.is_empty() {
        return rings;
    }
    shared.sort_unstable_by(|a, b| b.cmp(a));

    // Straight vertices stay until the end: a shorter edge that ends there may be shared too.
    let mut rings: Vec<Option<Ring>> = rings.into_iter().map(Some).collect();
    let mut joined = DisjointSets::new(rings.len());
    for (_, (a, b, first), second) in shared {
        let (p, q) = (joined.root(first), joined.root(second));
        if p == q {
            continue;
        }
        let (Some(one), Some(other)) = (&rings[p], &rings[q]) else { continue };
        if let Some(union) = join(one, other, a, b).or_else(|| join(one, other, b, a)) {
            rings[p] = Some(union);
            rings[q] = None;
            joined.join_into(q, p);
        }
    }
    rings.into_iter().flatten().map(|ring| without_collinear(&ring)).collect()
}

/// Returns the union of `p`, which runs from `a` to `b`, and `q`, which runs from `b` to `a`, if it
/// is convex.
///
/// Straight vertices may make several edges of the wall that both share; it is dropped as a whole.
/// Were only one of its edges dropped, the union would run to the other end of the rest and back,
/// and no turn there would tell whether it is convex.
fn join(p: &Ring, q: &Ring, a: [i32; 2], b: [i32; 2]) -> Option<Ring> {
    let starts = |ring: &Ring, from: [i32; 2], to: [i32; 2]| {
        let at = ring.iter().position(|v| *v == from)?;
        (ring[(at + 1) % ring.len()] == to).then_some(at)
    };
    let (n, m) = (p.len(), q.len());
    let (i, j) = (starts(p, a, b)? + n, starts(q, b, a)? + m);
    let at = |ring: &Ring, k: usize| ring[k % ring.len()];
    // More edges of the shared wall before `a` and behind `b`.
    let most = n.min(m) - 2;
    let before = (0..most).take_while(|k| at(p, i - 1 - k) == at(q, j + 2 + k)).count();
    let behind = (0..most - before).take_while(|k| at(p, i + 2 + k) == at(q, j - 1 - k)).count();
    let (start, end) = (i - before, i + 1 + behind);
    let is_convex_at_start = turn(at(p, start - 1), at(p, start), at(q, j + 2 + before)) >= 0;
    let is_convex_at_end = turn(at(q, j + m - 1 - behind), at(p, end), at(p, end + 1)) >= 0;
    (is_convex_at_start && is_convex_at_end).then(|| {
        let of_p = (end..=start + n).map(|k| at(p, k));
        of_p.chain((j + 2 + before..j + m - behind).map(|k| at(q, k))).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::overlay::doubled_area;

    fn rectangle(x0: i32, y0: i32, x1: i32, y1: i32) -> Ring {
        vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
    }

    #[test]
    fn a_wall_of_several_edges_hides_no_corner() {
        // Four houses in a square, and a fifth beside one of them: an L, whichever way they are
        // joined.
        let rings = vec![
            rectangle(0, 0, 5, 10),
            rectangle(0, 10, 5, 15),
            rectangle(5, 0, 10, 10),
            rectangle(5, 10, 10, 15),
            rectangle(10, 0, 18, 10),
        ];
        for turned in 0..5 {
            let mut rings = rings.clone();
            rings.rotate_left(turned);
            let found = merged(rings);
            for ring in &found {
                let n = ring.len();
                let turns = (0..n).map(|k| turn(ring[k], ring[(k + 1) % n], ring[(k + 2) % n]));
                assert!(turns.into_iter().all(|turn| turn > 0), "{found:?}");
            }
            assert_eq!(found.len(), 2, "{found:?}");
            assert_eq!(found.iter().map(|ring| doubled_area(ring)).sum::<i128>(), 2 * (150 + 80));
        }
    }

    #[test]
    fn what_would_turn_right_is_left_apart() {
        // Two triangles that make a dart.
        let rings = vec![vec![[0, 0], [10, 4], [4, 4]], vec![[0, 0], [4, 4], [4, 10]]];
        assert_eq!(merged(rings.clone()), rings);
    }
}
