//! Areas of a geometry, with the heights of their corners where it has any.
//!
//! A geometry with heights is a building made of surfaces, or a footprint drawn at some height.
//! Properties and options decide between the two, so both are kept. Areas that all lie at one
//! height are footprints: their height is that of a roof or of the ground, which nothing tells.

use super::super::polygon::Polygon;
use super::super::solid::{Face, plan};
use super::feature::Feature;

/// Areas of a geometry that is being read.
#[derive(Debug, Default)]
pub(in crate::read) struct Areas {
    polygons: Vec<Polygon>,
    /// Surfaces of the polygons that have heights.
    surfaces: Vec<Face>,
    /// `true` if the geometry has points or lines, too.
    pub(super) has_other_parts: bool,
}

/// Heights in a geometry that is not known to be a building.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::read) enum CornerHeights {
    /// None, or 0 throughout.
    #[default]
    None,
    /// One for all corners.
    Level,
    /// Surfaces, of which each has its own.
    Surfaces(Vec<Face>),
}

impl Areas {
    /// Adds a polygon without heights.
    pub(super) fn push(&mut self, polygon: Polygon) {
        self.polygons.push(polygon);
    }

    /// Adds a polygon with heights.
    pub(super) fn push_face(&mut self, face: Face) {
        self.polygons.push(plan(&face));
        self.surfaces.push(opened(face));
    }

    /// Adds the surfaces of a geometry whose `polygons` are areas already.
    #[cfg(feature = "shapefiles")]
    pub(super) fn of_surfaces(polygons: Vec<Polygon>, surfaces: Vec<Face>) -> Areas {
        let surfaces = surfaces.into_iter().map(opened).collect();
        Areas { polygons, surfaces, has_other_parts: false }
    }

    /// Returns a feature of the areas, without properties.
    pub(in crate::read) fn into_feature(self) -> Feature {
        let Areas { polygons, surfaces, has_other_parts } = self;
        Feature { z: heights_of(surfaces, polygons.len()), polygons, has_other_parts, ..Feature::default() }
    }
}

/// Returns the heights of the surfaces of some polygons.
fn heights_of(surfaces: Vec<Face>, n_polygons: usize) -> CornerHeights {
    let mut all = surfaces.iter().flatten().flatten().map(|[.., z]| *z);
    let Some(first) = all.next() else { return CornerHeights::None };
    // Both zeros are one height.
    let is_level = all.clone().all(|z| (z + 0.0).to_bits() == (first + 0.0).to_bits());
    // A place without a height cannot be part of a building's surface.
    let is_known = first.is_finite() && all.all(f64::is_finite) && surfaces.len() >= n_polygons;
    match (is_known, is_level) {
        (false, _) => CornerHeights::None,
        (true, true) if first == 0.0 => CornerHeights::None,
        (true, true) => CornerHeights::Level,
        (true, false) => CornerHeights::Surfaces(surfaces),
    }
}

/// Drops the last corner of rings that repeats the first.
fn opened(mut face: Face) -> Face {
    for ring in &mut face {
        if ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
    }
    face
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(z: [f64; 2]) -> Face {
        vec![vec![[0.0, 0.0, z[0]], [4.0, 0.0, z[0]], [4.0, 4.0, z[1]], [0.0, 4.0, z[1]], [0.0, 0.0, z[0]]]]
    }

    #[test]
    fn only_differing_heights_are_surfaces() {
        let of = |faces: &[Face]| {
            let mut areas = Areas::default();
            faces.iter().for_each(|face| areas.push_face(face.clone()));
            areas.into_feature().z
        };
        assert_eq!(of(&[]), CornerHeights::None);
        assert_eq!(of(&[square([0.0, 0.0]), square([0.0, -0.0])]), CornerHeights::None);
        assert_eq!(of(&[square([7.0, 7.0]), square([7.0, 7.0])]), CornerHeights::Level);
        assert_eq!(of(&[square([7.0, f64::NAN])]), CornerHeights::None);
        assert_eq!(of(&[square([7.0, 9.0])]), CornerHeights::Surfaces(vec![opened(square([7.0, 9.0]))]));
    }
}
