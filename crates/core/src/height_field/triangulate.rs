//! Cuts footprint polygons into convex pieces whose shadows and crossings are simple.
//!
//! A convex ring without holes is kept as it is. Anything else goes through a constrained Delaunay
//! triangulation (spade). The triangles inside are found by counting the constraint edges between
//! them and the outside. They are joined into larger convex pieces, each of which costs a ray as
//! much as a triangle. Coordinates are integers far below 2^53, so spade's predicates see them
//! exactly. The outcome is checked in integers: twice the area of the pieces equals twice the area
//! of the polygon.

use spade::Triangulation;

use super::merge::merged;
use super::rings::{turn, without_collinear};
use crate::overlay::{Ring, corners_and_edges, doubled_area, inside_faces, triangulated};

/// The outcome of [`convex_pieces`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ConvexPieces {
    /// Convex counterclockwise rings with disjoint interiors whose union is the polygon.
    Exact(Vec<Ring>),
    /// The triangulation failed its check; this one ring is the convex hull of the polygon.
    Hull(Ring),
}

/// Cuts a polygon into convex pieces.
///
/// `contours` are the rings of one polygon whose edges do not cross: the shell first, then its
/// holes, in any winding. Collinear vertices are removed. An empty polygon has no pieces.
pub fn convex_pieces(contours: &[Ring]) -> ConvexPieces {
    if let [ring] = contours {
        let ring = without_collinear(ring);
        if is_convex(&ring) {
            return ConvexPieces::Exact(vec![counterclockwise(ring)]);
        }
    }
    match triangles(contours) {
        Some(triangles) => ConvexPieces::Exact(merged(triangles)),
        None => ConvexPieces::Hull(convex_hull(contours.iter().flatten().copied().collect())),
    }
}

/// Returns whether a ring without collinear triples turns the same way everywhere, and only once
/// around.
fn is_convex(ring: &[[i32; 2]]) -> bool {
    let n = ring.len();
    if n < 3 {
        return false;
    }
    let left = turn(ring[0], ring[1], ring[2]) > 0;
    let same_way = (0..n).all(|i| (turn(ring[i], ring[(i + 1) % n], ring[(i + 2) % n]) > 0) == left);
    // A star also turns one way only; a convex ring has one westmost run, so its x direction
    // reverses just twice.
    let directions: Vec<i32> =
        (0..n).map(|i| (ring[(i + 1) % n][0].cmp(&ring[i][0])) as i32).filter(|&s| s != 0).collect();
    let reversals = (0..directions.len()).filter(|&i| directions[i] != directions[(i + 1) % directions.len()]).count();
    same_way && reversals == 2
}

fn counterclockwise(mut ring: Ring) -> Ring {
    if doubled_area(&ring) < 0 {
        ring.reverse();
    }
    ring
}

/// Returns the triangles inside a polygon, whose corners are its own, counterclockwise; `None` if
/// the triangulation does not cover it exactly, because edges cross.
///
/// `contours` are the rings of one polygon: the shell first, then its holes, in any winding.
pub fn triangles(contours: &[Ring]) -> Option<Vec<Ring>> {
    let (corners, edges) = corners_and_edges(contours);
    if corners.len() < 3 {
        return Some(Vec::new());
    }
    let points: Vec<[f64; 2]> = corners.iter().map(|p| p.map(f64::from)).collect();
    let (triangulation, _) = triangulated(&points, edges).filter(|(_, are_apart)| *are_apart)?;
    let (inside, is_consistent) = inside_faces(&triangulation);
    if !is_consistent {
        return None;
    }
    let pieces: Vec<Ring> = triangulation
        .inner_faces()
        .filter(|face| inside[face.fix().index()])
        .map(|face| counterclockwise(face.vertices().map(|v| corners[v.fix().index()]).to_vec()))
        .collect();
    let covered: i128 = pieces.iter().map(|p| doubled_area(p)).sum();
    let area = |ring: &Ring| doubled_area(ring).abs();
    let of_polygon = contours.first().map_or(0, area) - contours.iter().skip(1).map(area).sum::<i128>();
    (covered == of_polygon).then_some(pieces)
}

/// Returns the convex hull, counterclockwise (Andrew 1979, monotone chain).
fn convex_hull(mut points: Vec<[i32; 2]>) -> Ring {
    points.sort_unstable();
    points.dedup();
    let half = |points: &mut dyn Iterator<Item = [i32; 2]>| {
        let mut chain: Ring = Vec::new();
        for p in points {
            while chain.len() >= 2 && turn(chain[chain.len() - 2], chain[chain.len() - 1], p) <= 0 {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exact(contours: &[Ring]) -> Vec<Ring> {
        match convex_pieces(contours) {
            ConvexPieces::Exact(pieces) => pieces,
            ConvexPieces::Hull(_) => panic!("fell back to the hull"),
        }
    }

    #[test]
    fn a_pentagram_is_not_taken_for_convex() {
        let star = vec![[0, 100], [59, -81], [-95, 31], [95, 31], [-59, -81]];
        assert!(!is_convex(&star));
    }

    #[test]
    fn crossing_contours_fall_back_to_the_hull_instead_of_panicking() {
        let a = vec![[0, 0], [100, 0], [100, 10], [0, 10]];
        let b = vec![[50, -50], [60, -50], [60, 50], [50, 50]];
        assert!(matches!(convex_pieces(&[a, b]), ConvexPieces::Hull(hull) if hull.len() == 8));
    }

    #[test]
    fn degenerate_rings_have_no_pieces() {
        assert_eq!(exact(&[vec![[0, 0], [5, 5], [9, 9]]]), Vec::<Ring>::new());
        assert_eq!(exact(&[]), Vec::<Ring>::new());
    }
}
