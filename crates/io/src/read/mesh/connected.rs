//! Faces that are connected by their corners.

use std::collections::HashMap;

use skyshed_core::disjoint_sets::DisjointSets;

use super::super::solid::Face;
use super::faces::Mesh;

/// Returns the faces of each connected part of a mesh, in the order of their first faces. Corners
/// at one position are one, whatever their numbers are.
pub(super) fn buildings(mesh: &Mesh) -> Vec<Vec<Face>> {
    let mut numbers: HashMap<[u64; 3], usize> = HashMap::new();
    let mut joined = DisjointSets::default();
    let mut faces: Vec<(Face, usize)> = Vec::new();
    for face in mesh.faces() {
        let corners: Vec<[f64; 3]> = face.collect();
        let mut first = None;
        for corner in &corners {
            // Adding 0 turns −0 into 0.
            let number = *numbers.entry(corner.map(|v| (v + 0.0).to_bits())).or_insert_with(|| joined.add());
            joined.join(*first.get_or_insert(number), number);
        }
        faces.extend(first.map(|number| (vec![corners], number)));
    }
    let mut at: HashMap<usize, usize> = HashMap::new();
    let mut buildings: Vec<Vec<Face>> = Vec::new();
    for (face, number) in faces {
        let building = *at.entry(joined.root(number)).or_insert_with(|| {
            buildings.push(Vec::new());
            buildings.len() - 1
        });
        buildings[building].push(face);
    }
    buildings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_with_a_corner_in_common_are_one_building() {
        let mut mesh = Mesh::default();
        let square = |x: f64| [[x, 0.0, 3.0], [x + 1.0, 0.0, 3.0], [x + 1.0, 1.0, 3.0], [x, 1.0, 3.0]];
        for x in [0.0, 5.0, 2.0, 1.0] {
            let from = u32::try_from(mesh.vertices.len()).expect("few");
            mesh.vertices.extend(square(x));
            mesh.add_face(&[from, from + 1, from + 2, from + 3]).expect("its own");
        }
        let found: Vec<Vec<f64>> =
            buildings(&mesh).iter().map(|faces| faces.iter().map(|face| face[0][0][0]).collect()).collect();
        assert_eq!(found, [vec![0.0, 2.0, 1.0], vec![5.0]]);
    }
}
