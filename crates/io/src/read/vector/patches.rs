//! Shapes of shapefiles that have heights, as surfaces.
//!
//! A multipatch consists of strips and fans of triangles, and of rings: a first or outer one with
//! its holes behind it. A polygon with heights tells shells from holes by their sense of rotation
//! alone, which the floor of a building has in reverse. So a ring is a hole only where it lies in
//! the surface of the shell around it.

use shapefile::record::polygon::GenericPolygon;
use shapefile::{Multipatch, Patch, PointZ, PolygonRing};

use super::super::solid::{Face, is_wall, plan};
use super::rings::surrounds;
use super::surfaces::Areas;

/// Largest distance of the corners of a hole from the plane of its shell, in height \[m\].
const MOST_OFF_M: f64 = 0.2;

/// Returns the surfaces of a multipatch as areas.
pub(super) fn areas_of_patches(shape: Multipatch) -> Areas {
    let mut faces: Vec<Face> = Vec::new();
    // A ring continues the surface that the last first or outer ring began.
    let mut is_begun = false;
    for patch in shape.into_inner() {
        let corners: Vec<[f64; 3]> = patch.points().iter().map(corner).collect();
        let triangle = |[a, b, c]: [usize; 3]| vec![vec![corners[a], corners[b], corners[c]]];
        is_begun = match patch {
            Patch::TriangleStrip(_) => {
                faces.extend((2..corners.len()).map(|k| triangle([k - 2, k - 1, k])));
                false
            }
            Patch::TriangleFan(_) => {
                faces.extend((2..corners.len()).map(|k| triangle([0, k - 1, k])));
                false
            }
            Patch::OuterRing(_) | Patch::FirstRing(_) => {
                faces.push(vec![corners]);
                true
            }
            Patch::InnerRing(_) | Patch::Ring(_) => {
                match faces.last_mut().filter(|_| is_begun) {
                    Some(face) => face.push(corners),
                    None => faces.push(vec![corners]),
                }
                is_begun
            }
        };
    }
    // Walls are no areas.
    let is_area = |face: &&Face| face.first().is_some_and(|shell| !is_wall(shell));
    Areas::of_surfaces(faces.iter().filter(is_area).map(plan).collect(), faces)
}

/// Returns the surfaces of a polygon with heights.
pub(super) fn surfaces_of(polygon: &GenericPolygon<PointZ>) -> Vec<Face> {
    let corners = |points: &[PointZ]| points.iter().map(corner).collect::<Vec<_>>();
    let (mut faces, mut holes): (Vec<Face>, Vec<Vec<[f64; 3]>>) = (Vec::new(), Vec::new());
    for ring in polygon.rings() {
        match ring {
            PolygonRing::Inner(points) if !is_wall(&corners(points)) => holes.push(corners(points)),
            PolygonRing::Inner(points) | PolygonRing::Outer(points) => faces.push(vec![corners(points)]),
        }
    }
    let n_shells = faces.len();
    for hole in holes {
        let outline = &plan(&vec![hole.clone()])[0];
        let is_around = |face: &&mut Face| {
            !is_wall(&face[0]) && surrounds(&plan(&vec![face[0].clone()])[0], outline) && lies_in(&hole, &face[0])
        };
        match faces[..n_shells].iter_mut().find(is_around) {
            Some(face) => face.push(hole),
            None => faces.push(vec![hole]),
        }
    }
    faces
}

fn corner(point: &PointZ) -> [f64; 3] {
    [point.x, point.y, point.z]
}

/// Returns `true` when the corners of a ring lie in the plane of a shell.
fn lies_in(ring: &[[f64; 3]], shell: &[[f64; 3]]) -> bool {
    let origin = shell[0];
    let from = |p: &[f64; 3]| [p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]];
    // Newell's normal.
    let mut normal = [0.0; 3];
    for (a, b) in shell.iter().zip(shell.iter().cycle().skip(1)) {
        let (a, b) = (from(a), from(b));
        for (k, n) in normal.iter_mut().enumerate() {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            *n += (a[i] - b[i]) * (a[j] + b[j]);
        }
    }
    let height = |p: [f64; 3]| p[2] + (normal[0] * p[0] + normal[1] * p[1]) / normal[2];
    ring.iter().all(|p| height(from(p)).abs() <= MOST_OFF_M)
}

#[cfg(test)]
mod tests {
    use shapefile::NO_DATA;

    use super::*;
    use crate::read::vector::CornerHeights;

    fn points(corners: &[[f64; 3]]) -> Vec<PointZ> {
        corners.iter().map(|[x, y, z]| PointZ::new(*x, *y, *z, NO_DATA)).collect()
    }

    fn square(from: f64, to: f64, z: f64) -> Vec<PointZ> {
        points(&[[from, from, z], [from, to, z], [to, to, z], [to, from, z], [from, from, z]])
    }

    #[test]
    fn strips_fans_and_rings_are_surfaces() {
        let strip = points(&[[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 2.0], [1.0, 1.0, 2.0]]);
        let patches = vec![
            Patch::TriangleStrip(strip.clone()),
            Patch::TriangleFan(strip),
            Patch::OuterRing(square(0.0, 9.0, 5.0)),
            Patch::InnerRing(square(2.0, 3.0, 5.0)),
            Patch::InnerRing(square(4.0, 5.0, 5.0)),
            Patch::FirstRing(square(0.0, 9.0, 6.0)),
            Patch::Ring(square(2.0, 3.0, 6.0)),
            Patch::TriangleFan(square(0.0, 2.0, 7.0)[..3].to_vec()),
            Patch::Ring(square(2.0, 3.0, 6.0)),
        ];
        let CornerHeights::Surfaces(faces) = areas_of_patches(Multipatch::with_parts(patches)).into_feature().z else {
            panic!("no surfaces")
        };
        assert_eq!(faces.iter().map(Vec::len).collect::<Vec<_>>(), [1, 1, 1, 1, 3, 2, 1, 1]);
    }

    #[test]
    fn only_rings_in_the_plane_of_a_shell_are_holes() {
        let reversed = |mut ring: Vec<PointZ>| {
            ring.reverse();
            ring
        };
        let rings = vec![
            PolygonRing::Outer(square(0.0, 9.0, 8.0)),
            PolygonRing::Inner(reversed(square(2.0, 3.0, 8.0))),
            // The floor, as seen from below.
            PolygonRing::Inner(reversed(square(0.0, 9.0, 2.0))),
        ];
        let faces = surfaces_of(&GenericPolygon::with_rings(rings));
        assert_eq!(faces.iter().map(Vec::len).collect::<Vec<_>>(), [2, 1]);
    }
}
