//! Regions of the lattice: repaired, joined and cut, in integers (i_overlay).
//!
//! The overlay compares all edges whose boxes meet, and takes time and memory for each crossing. So
//! [`check_crossings`] counts both first, and [`union`] joins overlapping outlines by halves. A
//! crossing off the lattice is rounded to it, so that edges bend by less than a step. Coordinates are
//! within ±2^28.

mod arrangement;
mod crossings;
mod rings;
mod triangulation;

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::integer::OverlayInt;
use i_overlay::core::overlay::Overlay;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::i_float::int::point::IntPoint;

pub(crate) use arrangement::{FINER, arranged, finer};
pub(crate) use crossings::are_many;
pub use crossings::{Tangle, check_crossings};
use crossings::{few_crossings, most_crossings};
pub(crate) use rings::{FinePolygon, FineRing, bounds_of};
pub use rings::{Polygon, Ring, doubled_area};
pub(crate) use triangulation::{Cdt, corners_and_edges, inside_faces, triangulated};

/// Returns the region that rings enclose by the even-odd rule. Their crossings are not counted: see
/// [`check_crossings`].
pub fn even_odd(rings: &[Ring]) -> Vec<Polygon> {
    polygons_of(Overlay::<i32>::from_subj(&contours(rings)), OverlayRule::Subject, FillRule::EvenOdd)
}

/// Returns the region that `rings` enclose and `less` do not. Overlapping rings of one side are
/// wound alike.
///
/// # Errors
/// Edges that cross too often.
pub fn difference(rings: &[Ring], less: &[Ring]) -> Result<Vec<Polygon>, Tangle> {
    check_crossings(rings.iter().chain(less))?;
    let overlay = Overlay::<i32>::from_subj_and_clip(&contours(rings), &contours(less));
    Ok(polygons_of(overlay, OverlayRule::Difference, FillRule::NonZero))
}

/// Returns the region that both sets of rings enclose. Overlapping rings of one side are wound
/// alike.
///
/// # Errors
/// Edges that cross too often.
pub fn intersection(rings: &[Ring], with: &[Ring]) -> Result<Vec<Polygon>, Tangle> {
    check_crossings(rings.iter().chain(with))?;
    let overlay = Overlay::<i32>::from_subj_and_clip(&contours(rings), &contours(with));
    Ok(polygons_of(overlay, OverlayRule::Intersect, FillRule::NonZero))
}

/// Returns the region that any of the polygons covers. Shells are wound alike, and holes the other
/// way.
///
/// Cost: n log n for n edges, plus the crossings of their outlines, plus the pairs of edges whose
/// boxes meet. Joining by halves keeps crossings few where outlines lie on one another. Pairs are
/// many only for long edges side by side that run along no axis.
///
/// # Errors
/// Edges of two halves that cross too often.
pub fn union(polygons: Vec<Polygon>) -> Result<Vec<Polygon>, Tangle> {
    let most = 4 * most_crossings(n_edges(&polygons));
    let mut left = most;
    let too_many = |tangle| if let Tangle::Crossings(_) = tangle { Tangle::Crossings(most) } else { tangle };
    union_within(polygons, &mut left).map_err(too_many)
}

/// Joins polygons whose overlays pay for at most as many crossings as are `left`.
fn union_within(mut polygons: Vec<Polygon>, left: &mut usize) -> Result<Vec<Polygon>, Tangle> {
    // Outlines on one another cross far more often than the outline of their union has edges.
    let few = if polygons.len() > 1 { few_crossings(n_edges(&polygons)).min(*left) } else { *left };
    match joined(&polygons, few, left) {
        Err(Tangle::Crossings(_)) if polygons.len() > 1 && few < *left => {}
        found => return found,
    }
    let bounds = |axis: usize| {
        let values = || polygons.iter().flatten().flatten().map(move |p| p[axis]);
        values().max().unwrap_or(0) - values().min().unwrap_or(0)
    };
    let axis = usize::from(bounds(1) > bounds(0));
    let middle = |polygon: &Polygon| polygon.first().map_or(0, |shell| shell.iter().map(|p| i64::from(p[axis])).sum());
    polygons.sort_by_cached_key(middle);
    let rest = polygons.split_off(polygons.len() / 2);
    let halves = [union_within(polygons, left)?, union_within(rest, left)?].concat();
    joined(&halves, *left, left)
}

fn n_edges(polygons: &[Polygon]) -> usize {
    polygons.iter().flatten().map(Vec::len).sum()
}

/// Joins polygons with at most `most` crossings, which are taken from those that are `left`.
fn joined(polygons: &[Polygon], most: usize, left: &mut usize) -> Result<Vec<Polygon>, Tangle> {
    *left -= crossings::count(polygons.iter().flatten(), most)?;
    let rings = contours(polygons.iter().flatten());
    Ok(polygons_of(Overlay::<i32>::from_subj(&rings), OverlayRule::Subject, FillRule::NonZero))
}

/// Joins rings that were [`arranged`] together. Shells are wound alike, and holes the other way.
pub(crate) fn fine_union(rings: &[FineRing]) -> Vec<FinePolygon> {
    polygons_of(Overlay::from_subj(&contours(rings)), OverlayRule::Subject, FillRule::NonZero)
}

/// Cuts `less` out of `rings`; all were [`arranged`] together. Overlapping rings of one side are
/// wound alike.
pub(crate) fn fine_difference(rings: &[FineRing], less: &[FineRing]) -> Vec<FinePolygon> {
    polygons_of(
        Overlay::from_subj_and_clip(&contours(rings), &contours(less)),
        OverlayRule::Difference,
        FillRule::NonZero,
    )
}

/// Returns the polygon with its shell counterclockwise and its holes clockwise.
pub fn wound(polygon: &Polygon) -> Polygon {
    let ring = |(k, ring): (usize, &Ring)| {
        let mut ring = ring.clone();
        if (doubled_area(&ring) > 0) != (k == 0) {
            ring.reverse();
        }
        ring
    };
    polygon.iter().enumerate().map(ring).collect()
}

fn contours<'a, I: OverlayInt + 'a>(rings: impl IntoIterator<Item = &'a Vec<[I; 2]>>) -> Vec<Vec<IntPoint<I>>> {
    rings.into_iter().map(|ring| ring.iter().map(|p| IntPoint { x: p[0], y: p[1] }).collect()).collect()
}

fn polygons_of<I: OverlayInt>(mut overlay: Overlay<I>, rule: OverlayRule, fill: FillRule) -> Vec<Vec<Vec<[I; 2]>>> {
    let ring = |contour: Vec<IntPoint<I>>| contour.into_iter().map(|p| [p.x, p.y]).collect();
    overlay.overlay(rule, fill).into_iter().map(|shape| shape.into_iter().map(ring).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: i32, y: i32, side: i32) -> Polygon {
        vec![vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side]]]
    }

    fn doubled(polygons: &[Polygon]) -> i128 {
        polygons.iter().flatten().map(|ring| doubled_area(ring)).sum()
    }

    #[test]
    fn what_several_polygons_cover_counts_once() {
        // 8 × 8 with a hole of 4 × 4, which a second half covers by 3 × 3 and one in it by 2 × 2;
        // those two share one square.
        let mut court = square(0, 0, 8);
        court.push(vec![[2, 2], [2, 6], [6, 6], [6, 2]]);
        let united = union(vec![court, square(3, 3, 8), square(2, 2, 2)]).expect("few crossings");
        assert_eq!(doubled(&united), 2 * (48 + 64 - (25 - 9) + 4 - 1));
        assert_eq!(union(Vec::new()), Ok(Vec::new()));
    }
}
