//! Triangles of roofs, and the upper edges of walls: buildings from above and from the side.

use std::borrow::Cow;
use std::collections::HashSet;

use super::{ConvexPieces, convex_pieces};
use crate::city::{Footprint, RoofTriangle};
use crate::overlay::{Ring, wound};

/// Returns the roof of a building as triangles, those of a flat one over the pieces of its
/// polygons.
pub fn roof_triangles(footprint: &Footprint) -> Cow<'_, [RoofTriangle]> {
    if !footprint.roof.is_empty() {
        return Cow::Borrowed(&footprint.roof);
    }
    let at_top = |[x, y]: [i32; 2]| [x, y, footprint.top];
    let pieces = footprint.polygons.iter().flat_map(|rings| match convex_pieces(rings) {
        ConvexPieces::Exact(pieces) => pieces,
        ConvexPieces::Hull(hull) => vec![hull],
    });
    let fan = |ring: Ring| (2..ring.len()).map(|k| [ring[0], ring[k - 1], ring[k]].map(at_top)).collect::<Vec<_>>();
    pieces.flat_map(fan).collect()
}

/// Returns the upper edges of the walls of a building, the building on their left: around its
/// polygons, or of triangles of its roof that no other one joins there.
pub fn wall_edges(footprint: &Footprint) -> Vec<[[i32; 3]; 2]> {
    if footprint.roof.is_empty() {
        let at_top = |[x, y]: [i32; 2]| [x, y, footprint.top];
        let rings = footprint.polygons.iter().flat_map(wound);
        let edges = |ring: Ring| (0..ring.len()).map(|k| [ring[k], ring[(k + 1) % ring.len()]]).collect::<Vec<_>>();
        return rings.flat_map(edges).map(|ends| ends.map(at_top)).collect();
    }
    let edges = || footprint.roof.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
    let joined: HashSet<[[i32; 3]; 2]> = edges().collect();
    edges().filter(|[a, b]| !joined.contains(&[*b, *a])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_stand_around_a_roof_and_where_it_steps() {
        // A shed of two triangles beside a lower one that shares its corners in the plane.
        let square = |x: i32, z: i32| {
            let at = |dx: i32, dy: i32| [x + dx, dy, z];
            [[at(0, 0), at(9, 0), at(9, 9)], [at(0, 0), at(9, 9), at(0, 9)]]
        };
        let one = |roof: Vec<RoofTriangle>| Footprint { roof, ..Footprint::on_zero(String::new(), Vec::new(), 9) };
        assert_eq!(wall_edges(&one(square(0, 5).to_vec())).len(), 4);
        assert_eq!(wall_edges(&one([square(0, 5), square(9, 5)].concat())).len(), 6);
        assert_eq!(wall_edges(&one([square(0, 5), square(9, 4)].concat())).len(), 8);
        let flat = Footprint::on_zero(String::new(), vec![vec![vec![[0, 0], [0, 9], [9, 9], [9, 0]]]], 5);
        let mut walls = wall_edges(&flat);
        walls.sort_unstable();
        let mut wanted = wall_edges(&one(square(0, 5).to_vec()));
        wanted.sort_unstable();
        assert_eq!(walls, wanted);
        assert_eq!(roof_triangles(&flat).len(), 2);
    }
}
