//! Roofs on the lattice: surfaces become triangles whose corners have whole positions and heights.
//!
//! A surface of more than three corners is never quite a plane once it is rounded; three corners
//! always are. So surfaces are triangulated as seen from above, and neighbors that share corners
//! share them to the last bit. Each triangle is then exact.

use std::collections::HashMap;

use super::lattice_polygon::{enclosing, lattice_point, region_of};
use super::solid::Face;
use crate::city::RoofTriangle;
use crate::height_field::{ConvexPieces, MAX_ROOF_STEPS, convex_pieces, triangles};
use crate::overlay::{Polygon, Ring, Tangle, check_crossings, doubled_area, union};
use crate::quantity::{Frame, height_steps};

/// A roof on the lattice.
#[derive(Debug, Default)]
pub(super) struct LatticeRoof {
    pub(super) triangles: Vec<RoofTriangle>,
    /// Number of surfaces that cross themselves as seen from above, or are longer than a roof can
    /// be. They are taken flat, as high as their highest corner.
    pub(super) n_flattened: usize,
    /// Number of surfaces that are not plane within [`EVEN`]. They stay as they are triangulated.
    pub(super) n_uneven: usize,
}

/// Largest distance of corners from the plane of their surface, in height \[1/1024 m\]: 5 cm.
const EVEN: f64 = 51.2;

/// Reason why a roof cannot be used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum RoofFault {
    /// A corner is beyond the lattice.
    TooFar,
    /// A surface crosses itself too often to be repaired.
    Tangle(Tangle),
    /// A corner has a height beyond the lattice \[m\].
    Height(f64),
}

/// Returns the triangles of the surfaces of a roof.
pub(super) fn lattice_roof(faces: &[Face], frame: Frame) -> Result<LatticeRoof, RoofFault> {
    let mut roof = LatticeRoof::default();
    for face in faces {
        let mut heights: HashMap<[i32; 2], i32> = HashMap::new();
        let mut rings: Vec<Ring> = Vec::with_capacity(face.len());
        for ring in face {
            let mut points: Ring = Vec::with_capacity(ring.len());
            for &[x, y, z] in ring {
                let point = lattice_point(frame, [x, y]).ok_or(RoofFault::TooFar)?;
                let z = height_steps(z).ok_or(RoofFault::Height(z))?;
                // Of corners above one another, the highest counts.
                let known = heights.entry(point).or_insert(z);
                *known = z.max(*known);
                points.push(point);
            }
            rings.push(points);
        }
        let rings = enclosing(rings);
        check_crossings(&rings).map_err(RoofFault::Tangle)?;
        roof.add(&rings, &heights).map_err(RoofFault::Tangle)?;
    }
    Ok(roof)
}

impl LatticeRoof {
    fn add(&mut self, rings: &[Ring], heights: &HashMap<[i32; 2], i32>) -> Result<(), Tangle> {
        let spans = |axis: usize| {
            let values = || rings.iter().flatten().map(move |p| p[axis]);
            values().max().unwrap_or(0) - values().min().unwrap_or(0)
        };
        let is_flat = heights.values().max() == heights.values().min();
        let is_short = is_flat || spans(0).max(spans(1)) <= MAX_ROOF_STEPS;
        match triangles(rings).filter(|_| is_short) {
            Some(triangles) => {
                self.n_uneven += usize::from(rings.first().is_some_and(|shell| deviation(shell, heights) > EVEN));
                self.triangles.extend(triangles.iter().filter_map(|ring| {
                    let [a, b, c] = ring.as_slice() else { return None };
                    let corners = if doubled_area(ring) > 0 { [a, b, c] } else { [a, c, b] };
                    (doubled_area(ring) != 0).then(|| corners.map(|p| [p[0], p[1], heights[p]]))
                }));
            }
            None => {
                self.n_flattened += 1;
                let highest = heights.values().copied().max().unwrap_or(0);
                for polygon in region_of(rings)?.polygons {
                    let pieces = match convex_pieces(&polygon) {
                        ConvexPieces::Exact(pieces) => pieces,
                        ConvexPieces::Hull(hull) => vec![hull],
                    };
                    for ring in pieces {
                        let fan = (2..ring.len()).map(|k| [ring[0], ring[k - 1], ring[k]]);
                        self.triangles.extend(fan.map(|corners| corners.map(|[x, y]| [x, y, highest])));
                    }
                }
            }
        }
        Ok(())
    }

    /// Returns the polygons that it covers.
    ///
    /// # Errors
    /// Edges that cross too often.
    pub(super) fn polygons(&self) -> Result<Vec<Polygon>, Tangle> {
        union(self.triangles.iter().map(|corners| vec![corners.map(|[x, y, _]| [x, y]).to_vec()]).collect())
    }

    /// Returns its highest corner \[1/1024 m above the datum\].
    pub(super) fn top(&self) -> Option<i32> {
        self.triangles.iter().flatten().map(|[.., z]| *z).max()
    }
}

/// Returns the largest distance of corners from the plane of a ring (Newell's normal through the
/// mean of its corners), in height \[1/1024 m\].
#[expect(clippy::cast_precision_loss, reason = "told to a step")]
fn deviation(ring: &Ring, heights: &HashMap<[i32; 2], i32>) -> f64 {
    let first = ring[0];
    let at = |p: &[i32; 2]| [p[0] - first[0], p[1] - first[1], heights[p] - heights[&first]].map(f64::from);
    let (mut normal, mut mean) = ([0.0; 3], [0.0; 3]);
    for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
        let (a, b) = (at(a), at(b));
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            normal[k] += (a[i] - b[i]) * (a[j] + b[j]);
            mean[k] += a[k] / ring.len() as f64;
        }
    }
    let off = |p: &[i32; 2]| (0..3).map(|k| normal[k] * (at(p)[k] - mean[k])).sum::<f64>() / normal[2];
    ring.iter().map(|p| off(p).abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Frame = Frame { x_origin: 100.0, y_origin: 200.0, unit_x: 1.0, unit_y: 1.0 };

    fn area(roof: &LatticeRoof) -> i128 {
        let plan = |corners: &RoofTriangle| corners.map(|[x, y, _]| [x, y]).to_vec();
        roof.triangles.iter().map(|corners| doubled_area(&plan(corners))).sum::<i128>() / 2
    }

    #[test]
    fn a_surface_with_a_hole_is_triangles_over_just_that() {
        let shell = vec![[100.0, 200.0, 5.0], [108.0, 200.0, 5.0], [108.0, 206.0, 8.0], [100.0, 206.0, 8.0]];
        let hole = vec![[102.0, 202.0, 6.0], [102.0, 204.0, 7.0], [104.0, 204.0, 7.0], [104.0, 202.0, 6.0]];
        let roof = lattice_roof(&[vec![shell, hole]], FRAME).expect("a roof");
        assert_eq!((area(&roof), roof.n_flattened, roof.top()), (44 * 1024 * 1024, 0, Some(8 * 1024)));
        assert_eq!(roof.n_uneven, 0);
        // Each corner lies in its plane: 5 m high, and half a meter higher for each meter to the
        // north.
        for [_, y, z] in roof.triangles.iter().flatten() {
            assert_eq!(z - 5 * 1024, y / 2);
        }
        assert_eq!(roof.polygons().expect("few crossings").iter().flatten().count(), 2);
    }

    #[test]
    fn a_surface_that_is_no_plane_is_counted() {
        let square =
            |z: f64| vec![vec![[100.0, 200.0, 3.0], [104.0, 200.0, 3.0], [104.0, 204.0, 3.0], [100.0, 204.0, z]]];
        // A corner that is off by z is off the plane by a quarter of that.
        let uneven = |z: f64| lattice_roof(&[square(z)], FRAME).expect("a roof").n_uneven;
        assert_eq!([3.0, 3.19, 3.21, 2.7].map(uneven), [0, 0, 1, 1]);
    }

    #[test]
    fn a_surface_that_crosses_itself_is_taken_flat_and_counted() {
        let bow = vec![[100.0, 200.0, 3.0], [104.0, 204.0, 4.0], [104.0, 200.0, 3.0], [100.0, 204.0, 5.0]];
        let roof = lattice_roof(&[vec![bow]], FRAME).expect("a roof");
        assert_eq!((area(&roof), roof.n_flattened), (8 * 1024 * 1024, 1));
        assert!(roof.triangles.iter().flatten().all(|[.., z]| *z == 5 * 1024));
        // Half way around at each corner, so that every edge crosses nearly every other.
        let corner = |k: u32| {
            let (y, x) = (f64::from(k * 500 % 1001) * std::f64::consts::TAU / 1001.0).sin_cos();
            [150.0 + 40.0 * x, 250.0 + 40.0 * y, 3.0 + x]
        };
        let star = lattice_roof(&[vec![(0..1001).map(corner).collect()]], FRAME).err();
        assert!(matches!(star, Some(RoofFault::Tangle(_))), "{star:?}");
        let far = vec![[100.0, 200.0, 3.0], [1e6, 204.0, 4.0], [104.0, 200.0, 3.0]];
        assert_eq!(lattice_roof(&[vec![far]], FRAME).err(), Some(RoofFault::TooFar));
        let high = vec![[100.0, 200.0, 3.0], [104.0, 204.0, 4e4], [104.0, 200.0, 3.0]];
        assert_eq!(lattice_roof(&[vec![high]], FRAME).err(), Some(RoofFault::Height(4e4)));
    }
}
