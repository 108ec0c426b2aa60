//! Parts of a leg that prisms hide.

use super::half_space::{HalfSpace, walls_of};
use super::hidden::{HiddenParts, LegObstacle};
use super::links::{Links, Shape};
use super::place::LegPart;
use super::plan::Plan;
use super::region::{HalfPlane, Region};
use super::seen::Seen;
use super::upright::pieces_along;
use crate::height_field::{Piece, Prisms};

/// Adds the parts of a leg that prisms hide.
///
/// Cost: the buckets below the links that hold a piece higher than the lowest link. Each piece that
/// is higher than the links over it takes a few exact tests.
pub(super) fn hide_by_prisms(prisms: &Prisms, links: &Links, hidden: &mut HiddenParts) {
    if i64::from(prisms.max_top()) <= links.lowest() {
        return;
    }
    match links.shape() {
        Shape::Plumb => hide_plumb(prisms, links, hidden),
        Shape::Upright => {
            let mut cut = Cut::of(links);
            pieces_along(prisms, links.ends_in_plane(), links.lowest(), |pieces| {
                let first = pieces.iter().min_by_key(|&&index| (prisms.pieces()[index].top, index));
                if let (Some(part), Some(&piece)) = (cut.hidden_by(prisms, pieces), first) {
                    hidden.add(part, LegObstacle::Piece(piece));
                }
            });
        }
        Shape::Spread => hide_spread(prisms, links, hidden),
    }
}

/// Links that are cut to the region inside pieces.
pub(super) struct Cut<'a> {
    links: &'a Links,
    triangle: [HalfPlane; 3],
    region: Region,
}

impl Cut<'_> {
    pub(super) fn of(links: &Links) -> Cut<'_> {
        Cut { links, triangle: links.triangle(), region: Region::default() }
    }

    /// Returns the part that is hidden inside all of some pieces. Walls in the plane of the links do
    /// not bound it.
    pub(super) fn hidden_by(&mut self, prisms: &Prisms, pieces: &[usize]) -> Option<LegPart> {
        self.region.restart(&self.triangle);
        for piece in pieces.iter().map(|&index| &prisms.pieces()[index]) {
            let top = self.links.half_plane(&HalfSpace::below_piece(prisms, piece));
            if !self.region.keep(&top) {
                return None;
            }
            for wall in walls_of(prisms.ring(piece)) {
                let wall = self.links.half_plane(&wall);
                if !wall.is_zero() && !self.region.keep(&wall) {
                    return None;
                }
            }
        }
        self.region.part()
    }
}

/// Adds what is hidden from links that are a triangle in the plane: no wall can be in their plane.
fn hide_spread(prisms: &Prisms, links: &Links, hidden: &mut HiddenParts) {
    let plan = Plan::new(links);
    let mut cut = Cut::of(links);
    let mut seen = Seen::of(prisms.pieces().len());
    let buckets = prisms.buckets();
    #[expect(clippy::cast_precision_loss, reason = "positions have a margin of a step")]
    let (size, [west, south]) = (buckets.size as f64, [buckets.origin.0 as f64, buckets.origin.1 as f64]);
    #[expect(clippy::cast_possible_truncation, reason = "clamped to the grid of buckets")]
    let bucket = |v: f64, origin: f64, n: i64| (((v - origin) / size).floor() as i64).clamp(-1, n);
    let [bottom, top] = plan.y_range().map(|y| bucket(y, south, buckets.shape.1));
    for north in bottom.max(0)..=top.min(buckets.shape.1 - 1) {
        #[expect(clippy::cast_precision_loss, reason = "a row of buckets")]
        let row = south + north as f64 * size;
        let Some(range) = plan.x_range(row, row + size) else { continue };
        let [first, last] = range.map(|x| bucket(x, west, buckets.shape.0));
        for east in first.max(0)..=last.min(buckets.shape.0 - 1) {
            let Some((max_top, items)) = buckets.at(east, north) else { continue };
            if i64::from(max_top) <= links.lowest() {
                continue;
            }
            for index in items.iter().map(|&item| item as usize) {
                let piece = &prisms.pieces()[index];
                if seen.is_new(index)
                    && may_hide(&plan, prisms, piece, hidden)
                    && let Some(part) = cut.hidden_by(prisms, &[index])
                {
                    hidden.add(part, LegObstacle::Piece(index));
                }
            }
        }
    }
}

/// Returns `false` if a piece surely hides nothing, or nothing new.
fn may_hide(plan: &Plan, prisms: &Prisms, piece: &Piece, hidden: &HiddenParts) -> bool {
    let corners = prisms.ring(piece).iter().map(|corner| corner.map(i64::from));
    plan.span(corners).is_some_and(|span| {
        f64::from(piece.top) > span.lowest && !hidden.are_hidden(span.from, span.to, span.to - span.from)
    })
}

/// Adds what is hidden from vertical links: all below the solid there, unless the observer is above
/// it.
fn hide_plumb(prisms: &Prisms, links: &Links, hidden: &mut HiddenParts) {
    let Some((height, piece)) = prisms.exact_solid_at(links.observer.x, links.observer.y) else { return };
    let window = links.window.part();
    let room = |z: i64| height.num - i128::from(z) * i128::from(height.den);
    let part = if room(links.observer.z) > 0 {
        // A link without a length is in line of sight.
        (links.along[2] != 0 || links.to_start[2] != 0).then_some(window)
    } else {
        window.where_above_zero(room(links.start.z), -i128::from(links.along[2]) * i128::from(height.den))
    };
    if let Some(part) = part {
        hidden.add(part, LegObstacle::Piece(piece));
    }
}
