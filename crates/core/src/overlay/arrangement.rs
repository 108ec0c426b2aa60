//! Edges split at their common points, before an overlay is made of them.
//!
//! The overlay rounds a crossing down or to the nearest lattice point, depending on which end of an
//! edge is farther west. So the crossings of a mirrored scene are not the mirrored crossings. Here
//! each crossing is rounded to the nearest point of a finer lattice, which is the same from all
//! sides. The overlay has nothing left to round.
//!
//! A point halfway between two points of the finer lattice has a denominator of 2^21 or a multiple.
//! A crossing has the reduced denominator of its edges' cross product, which has that many factors
//! of two only in contrived scenes.

use std::ops::ControlFlow;

use super::crossings::{Edge, Tangle, edges_once, for_each_crossing, most_crossings, turn};
use super::rings::{FineRing, Ring};

/// Steps of the finer lattice per lattice step. Coordinates within ±2^28 are exact in an f64 on
/// both.
pub(crate) const FINER: i64 = 1 << 20;

/// Returns rings on the finer lattice, with a new corner where an edge crosses another or touches
/// its end.
///
/// Cost: n log n for n edges, the pairs of edges side by side, and the crossings.
///
/// # Errors
/// Edges that cross too often.
pub(crate) fn arranged(rings: &[Ring]) -> Result<Vec<FineRing>, Tangle> {
    let edges = edges_once(rings);
    // New corners: the edge, the distance along it, the corner.
    let mut corners: Vec<(usize, i128, [i64; 2])> = Vec::new();
    let (most, mut n_crossings) = (most_crossings(edges.len()), 0);
    let met = for_each_crossing(&edges, |a, b| {
        split(&edges, a, b, &mut corners);
        n_crossings += 1;
        if n_crossings > most { ControlFlow::Break(Tangle::Crossings(most)) } else { ControlFlow::Continue(()) }
    });
    if let ControlFlow::Break(tangle) = met {
        return Err(tangle);
    }
    corners.sort_unstable();
    corners.dedup();
    Ok(rings.iter().map(|ring| with_corners(ring, &edges, &corners)).collect())
}

/// Returns a ring on the finer lattice with the new corners of its edges,
/// `(edge, distance along it, corner)`.
fn with_corners(ring: &Ring, edges: &[Edge], corners: &[(usize, i128, [i64; 2])]) -> FineRing {
    let mut fine = FineRing::with_capacity(ring.len());
    for (&a, &b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
        fine.push(finer(a));
        let Ok(edge) = edges.binary_search(&[a.min(b), a.max(b)]) else { continue };
        let first = corners.partition_point(|corner| corner.0 < edge);
        let last = first + corners[first..].partition_point(|corner| corner.0 == edge);
        let along = corners[first..last].iter().map(|corner| corner.2);
        if a < b { fine.extend(along) } else { fine.extend(along.rev()) }
    }
    fine
}

/// Adds the new corners of two crossing edges.
fn split(edges: &[Edge], first: usize, second: usize, corners: &mut Vec<(usize, i128, [i64; 2])>) {
    let mut add = |edge: usize, at: [i64; 2]| {
        let [a, b] = edges[edge].map(finer);
        let along = |k: usize| i128::from(at[k] - a[k]) * i128::from(b[k] - a[k]);
        if at != a && at != b {
            corners.push((edge, along(0) + along(1), at));
        }
    };
    let mut touch = false;
    for (edge, other) in [(first, second), (second, first)] {
        let [a, b] = edges[edge];
        for end in edges[other] {
            if turn(&a, &b, &end) == 0 {
                touch = true;
                if a < end && end < b {
                    add(edge, finer(end));
                }
            }
        }
    }
    if !touch {
        let at = crossing(edges[first], edges[second]);
        add(first, at);
        add(second, at);
    }
}

/// Returns the point of the finer lattice nearest to the crossing of two edges. EXACT: all products
/// are below 2^112.
fn crossing([a, b]: Edge, [c, d]: Edge) -> [i64; 2] {
    let to = |p: [i32; 2], q: [i32; 2]| [0, 1].map(|k| i128::from(q[k]) - i128::from(p[k]));
    let cross = |u: [i128; 2], v: [i128; 2]| u[0] * v[1] - u[1] * v[0];
    let (ab, cd) = (to(a, b), to(c, d));
    let (n, d) = (cross(to(a, c), cd), cross(ab, cd));
    let (n, d) = if d < 0 { (-n, -d) } else { (n, d) };
    [0, 1].map(|k| {
        let steps = (2 * ab[k] * n * i128::from(FINER) + d).div_euclid(2 * d);
        #[expect(clippy::cast_possible_truncation, reason = "no longer than the edge")]
        let steps = steps as i64;
        i64::from(a[k]) * FINER + steps
    })
}

/// Returns a lattice point on the finer lattice.
pub(crate) fn finer(p: [i32; 2]) -> [i64; 2] {
    p.map(|v| i64::from(v) * FINER)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners(rings: &[Ring]) -> Vec<Vec<[f64; 2]>> {
        #[expect(clippy::cast_precision_loss, reason = "small")]
        let coarse = |p: &[i64; 2]| p.map(|v| v as f64 / FINER as f64);
        arranged(rings).expect("few crossings").iter().map(|ring| ring.iter().map(coarse).collect()).collect()
    }

    #[test]
    fn edges_are_split_where_they_cross_touch_and_share_a_part() {
        let square = vec![[0, 0], [4, 0], [4, 4], [0, 4]];
        let crossed = corners(&[square.clone(), vec![[2, 2], [6, 3], [6, 5]]]);
        assert_eq!(crossed[0], [[0.0, 0.0], [4.0, 0.0], [4.0, 2.5], [4.0, 3.5], [4.0, 4.0], [0.0, 4.0]]);
        assert_eq!(crossed[1], [[2.0, 2.0], [4.0, 2.5], [6.0, 3.0], [6.0, 5.0], [4.0, 3.5]]);
        let touching = corners(&[square.clone(), vec![[4, 2], [6, 1], [6, 3]]]);
        assert_eq!(touching[0], [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [4.0, 4.0], [0.0, 4.0]]);
        let beside = corners(&[square.clone(), vec![[4, 3], [4, 1], [6, 1]]]);
        assert_eq!(beside[0], [[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [4.0, 3.0], [4.0, 4.0], [0.0, 4.0]]);
        assert_eq!(beside[1].len(), 3);
        assert_eq!(corners(&[square.clone(), square])[1].len(), 4);
    }

    #[test]
    fn crossings_of_turned_and_mirrored_edges_are_turned_and_mirrored() {
        let edges: [[[i32; 2]; 2]; 2] = [[[3, -7], [1000, 731]], [[1, 400], [977, -3]]];
        let [x, y] = crossing(edges[0], edges[1]);
        for (image, wanted) in [
            (edges.map(|edge| edge.map(|[x, y]| [-x, y])), [-x, y]),
            (edges.map(|edge| edge.map(|[x, y]| [x, 9 - y])), [x, 9 * FINER - y]),
            (edges.map(|edge| edge.map(|[x, y]| [-y, x])), [-y, x]),
        ] {
            let [e, f] = image.map(|[a, b]| [a.min(b), a.max(b)]);
            assert_eq!((crossing(e, f), crossing(f, e)), (wanted, wanted));
        }
    }
}
