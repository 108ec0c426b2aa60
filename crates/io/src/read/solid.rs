//! Surfaces of a building, divided into its roof and its ground.
//!
//! Line of sight depends on what lies over a place. So walls do not count, and a roof is everything
//! that is seen from above. Surfaces with a meaning in the file are believed: a roof is its
//! `RoofSurface`s and `OuterFloorSurface`s. Unmarked surfaces count unless they are walls, or lie
//! flat at the lowest height below another one. Where several lie on one another the highest
//! counts, so that floors and the undersides of roofs do no harm.

use super::polygon::{Polygon, doubled_area};

/// A surface: rings of positions \[CRS units\] with heights \[m above the datum\], the shell first.
pub(super) type Face = Vec<Vec<[f64; 3]>>;

/// Meaning of a surface in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FaceKind {
    Ground,
    Roof,
    /// Something else.
    Other,
    /// Not marked.
    Unknown,
}

/// Outline, heights, roof and ground from the surfaces of one building.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Solid {
    /// Polygons that it covers, which may overlap.
    pub(super) polygons: Vec<Polygon>,
    /// Lowest and highest point \[m above the datum\]; `None` without a point.
    pub(super) heights: Option<[f64; 2]>,
    /// Surfaces of its roof.
    pub(super) roof: Vec<Face>,
    /// Polygons that it covers of the ground, where known.
    pub(super) ground: Vec<Polygon>,
    /// `true` if it has walls.
    pub(super) has_walls: bool,
}

/// Least share of a roof that faces up or down; a surface with less is a wall. Roofs are far
/// flatter.
const LEAST_FLATNESS: f64 = 1e-3;

impl Solid {
    /// Creates a solid from surfaces.
    pub(super) fn of(faces: Vec<(Face, FaceKind)>) -> Solid {
        let heights = |face: &Face| {
            face.iter().flatten().fold(None, |range: Option<[f64; 2]>, [.., z]| {
                let [low, high] = range.unwrap_or([*z, *z]);
                Some([low.min(*z), high.max(*z)])
            })
        };
        let all = faces.iter().filter_map(|(face, _)| heights(face));
        let range = all.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
        let is_lowest = |face: &Face| heights(face).zip(range).is_some_and(|(of, all)| of[1] <= all[0]);
        let has_roof = faces.iter().any(|(_, kind)| *kind == FaceKind::Roof);
        let upright = |face: &Face| face.first().is_none_or(|shell| is_wall(shell));
        let has_walls = faces.iter().any(|(face, _)| face.first().is_some_and(|shell| is_wall(shell)));
        let flat: Vec<(Face, FaceKind)> = faces.into_iter().filter(|(face, _)| !upright(face)).collect();
        let has_ground = flat.iter().any(|(_, kind)| *kind == FaceKind::Ground);
        let upper: Vec<Polygon> =
            flat.iter().filter(|(face, _)| !is_lowest(face)).map(|(face, _)| plan(face)).collect();
        // The lowest surface is ground only if it lies below others.
        let is_ground = |(face, kind): &(Face, FaceKind)| match kind {
            FaceKind::Ground => true,
            _ => !has_ground && is_lowest(face) && upper.iter().any(|other| lies_over(other, &plan(face))),
        };
        let ground: Vec<Polygon> = flat.iter().filter(|face| is_ground(face)).map(|(face, _)| plan(face)).collect();
        // The footprint is everything marked as ground, or everything seen from above.
        let marked = |(_, kind): &&(Face, FaceKind)| !has_ground || *kind == FaceKind::Ground;
        let polygons = flat.iter().filter(marked).map(|(face, _)| plan(face)).collect();
        let is_roof = |face: &(Face, FaceKind)| match face.1 {
            FaceKind::Roof => true,
            FaceKind::Unknown => !is_ground(face),
            FaceKind::Ground | FaceKind::Other => !has_roof && !is_ground(face),
        };
        let roof = flat.into_iter().filter(is_roof).map(|(face, _)| face).collect();
        Solid { polygons, heights: range, roof, ground, has_walls }
    }
}

/// Returns a surface as seen from above.
pub(super) fn plan(face: &Face) -> Polygon {
    face.iter().map(|ring| ring.iter().map(|p| [p[0], p[1]]).collect()).collect()
}

/// Returns `true` when a polygon lies over a place inside of another one.
fn lies_over(polygon: &Polygon, other: &Polygon) -> bool {
    inner_place(other).is_some_and(|[x, y]| crossings(polygon, y).filter(|at| *at > x).count() % 2 == 1)
}

/// Returns a place inside of a polygon: on a line through its middle, in the longest stretch
/// inside.
fn inner_place(polygon: &Polygon) -> Option<[f64; 2]> {
    let ys = || polygon.iter().flatten().map(|p| p[1]);
    let (low, high) = (ys().fold(f64::INFINITY, f64::min), ys().fold(f64::NEG_INFINITY, f64::max));
    // This height is hardly ever that of a corner.
    let y = low + 0.4837 * (high - low);
    let mut at: Vec<f64> = crossings(polygon, y).collect();
    at.sort_by(f64::total_cmp);
    let pairs = at.chunks_exact(2).map(|pair| (pair[1] - pair[0], 0.5 * (pair[0] + pair[1])));
    pairs.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, x)| [x, y])
}

/// Returns the places where edges of a polygon cross a line to the east.
fn crossings(polygon: &Polygon, y: f64) -> impl Iterator<Item = f64> + '_ {
    let edges = polygon.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
    edges
        .filter(move |(a, b)| (a[1] > y) != (b[1] > y))
        .map(move |(a, b)| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
}

/// Returns `true` when hardly any of a surface faces up or down.
pub(super) fn is_wall(ring: &[[f64; 3]]) -> bool {
    let seen_along = |i: usize, j: usize| {
        let plane: Vec<[f64; 2]> = ring.iter().map(|p| [p[i], p[j]]).collect();
        doubled_area(&plane).abs()
    };
    seen_along(0, 1) <= LEAST_FLATNESS * seen_along(1, 2).hypot(seen_along(0, 2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face(corners: &[[f64; 3]]) -> Face {
        vec![corners.to_vec()]
    }

    /// Returns a shed of 4 × 2 m, 2 m high at its west wall and 3 m at its east, from 1 m up:
    /// ground, roof, one wall.
    fn shed() -> [Face; 3] {
        [
            face(&[[0.0, 0.0, 1.0], [0.0, 2.0, 1.0], [4.0, 2.0, 1.0], [4.0, 0.0, 1.0]]),
            face(&[[0.0, 0.0, 2.0], [4.0, 0.0, 3.0], [4.0, 2.0, 3.0], [0.0, 2.0, 2.0]]),
            face(&[[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [4.0, 0.0, 3.0], [0.0, 0.0, 2.0]]),
        ]
    }

    /// Returns a flat roof at 1 m beside the shed.
    fn annex() -> Face {
        face(&[[4.0, 0.0, 1.0], [6.0, 0.0, 1.0], [6.0, 2.0, 1.0], [4.0, 2.0, 1.0]])
    }

    #[test]
    fn marked_or_not_the_roof_is_what_lies_above_the_ground() {
        let [ground, roof, wall] = shed();
        let marked = Solid::of(vec![
            (ground.clone(), FaceKind::Ground),
            (roof.clone(), FaceKind::Roof),
            (wall.clone(), FaceKind::Other),
        ]);
        let unmarked = Solid::of([&ground, &roof, &wall].map(|face| (face.clone(), FaceKind::Unknown)).to_vec());
        for solid in [&marked, &unmarked] {
            assert_eq!(solid.roof, std::slice::from_ref(&roof));
            assert_eq!(solid.ground, [plan(&ground)]);
            assert_eq!(solid.heights, Some([1.0, 3.0]));
        }
        assert_eq!(marked.polygons, [plan(&ground)]);
        // Unmarked surfaces beside a marked roof are roof as well, unless they are ground.
        let partly = Solid::of(vec![
            (ground.clone(), FaceKind::Ground),
            (roof.clone(), FaceKind::Roof),
            (annex(), FaceKind::Unknown),
            (wall.clone(), FaceKind::Other),
        ]);
        assert_eq!(partly.roof, [roof.clone(), annex()]);
        // An annex under open sky is lowest, and roof.
        let open = Solid::of(vec![(roof.clone(), FaceKind::Unknown), (annex(), FaceKind::Unknown)]);
        assert_eq!((open.roof, open.ground.len()), (vec![roof.clone(), annex()], 0));
        // A flat roof alone is no ground.
        let alone = Solid::of(vec![(ground.clone(), FaceKind::Unknown)]);
        assert_eq!((alone.roof, alone.ground.len()), (vec![ground], 0));
    }
}
