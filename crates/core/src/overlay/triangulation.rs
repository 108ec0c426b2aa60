//! Constrained Delaunay triangulations of rings (spade).

use std::collections::HashMap;
use std::hash::Hash;

use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

/// A triangulation in which the edges of rings are constraint edges.
pub(crate) type Cdt = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// Returns the corners of some rings, each once and in order, and the edges between them.
pub(crate) fn corners_and_edges<T: Copy + Eq + Hash>(rings: &[Vec<[T; 2]>]) -> (Vec<[T; 2]>, Vec<[usize; 2]>) {
    let mut index: HashMap<[T; 2], usize> = HashMap::new();
    let mut corners = Vec::new();
    let mut edges = Vec::new();
    for ring in rings {
        let number = |p: &[T; 2]| {
            *index.entry(*p).or_insert_with(|| {
                corners.push(*p);
                corners.len() - 1
            })
        };
        let numbers: Vec<usize> = ring.iter().map(number).collect();
        let next = numbers.iter().cycle().skip(1);
        edges.extend(numbers.iter().zip(next).filter(|(a, b)| a != b).map(|(&a, &b)| [a, b]));
    }
    (corners, edges)
}

/// Returns a triangulation with the vertex numbers of `points`, and `true` if no edges cross. Of
/// two edges that cross, one is left out.
///
/// Returns `None` if there are fewer than three points, or equal ones.
pub(crate) fn triangulated(points: &[[f64; 2]], edges: Vec<[usize; 2]>) -> Option<(Cdt, bool)> {
    if points.len() < 3 {
        return None;
    }
    let vertices = points.iter().map(|p| Point2::new(p[0], p[1])).collect();
    let mut are_apart = true;
    let cdt = Cdt::try_bulk_load_cdt(vertices, edges, |_| are_apart = false).ok()?;
    (cdt.num_vertices() == points.len()).then_some((cdt, are_apart))
}

/// Returns for each face, by index, whether it is inside. From the outside, each constraint edge
/// crossed changes the side. The flag is `true` if all ways to every face agree.
pub(crate) fn inside_faces(cdt: &Cdt) -> (Vec<bool>, bool) {
    let mut is_inside = vec![false; cdt.num_all_faces()];
    let mut is_met = vec![false; cdt.num_all_faces()];
    is_met[cdt.outer_face().fix().index()] = true;
    let mut is_consistent = true;
    // A hull edge has the outer face on its left. If all points are on one line, it has it on its
    // right as well.
    let hull = cdt.convex_hull().filter(|edge| !edge.rev().face().is_outer());
    let mut queue: Vec<_> = hull.map(|edge| (edge.rev().face().fix(), edge.is_constraint_edge())).collect();
    while let Some((face, here)) = queue.pop() {
        if std::mem::replace(&mut is_met[face.index()], true) {
            is_consistent &= is_inside[face.index()] == here;
            continue;
        }
        is_inside[face.index()] = here;
        let Some(triangle) = cdt.face(face).as_inner() else { continue };
        let beyond = triangle.adjacent_edges();
        queue.extend(beyond.map(|edge| (edge.rev().face().fix(), here != edge.is_constraint_edge())));
    }
    (is_inside, is_consistent)
}
