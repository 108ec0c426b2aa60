//! Line of sight to a receiver that moves along a straight leg, in exact stretches.
//!
//! From a fixed end the part of a straight leg that one convex solid hides is one open interval of
//! the way, and its ends are rational ([`region`]). The hidden parts of a leg are the union of these
//! intervals. No place is rounded before it is decided, and none is sampled.
//!
//! 1. The links from the observer to the leg fill a triangle. An upright triangle is part of a line in
//!    the plane; where all links are vertical it is a point.
//! 2. Doubles rule out the pieces and cells that lie beside the triangle or below it, or that can
//!    only hide what is hidden already ([`plan`]).
//! 3. Each other solid is cut to its region of the triangle in exact signs. Over columns the part of
//!    the leg above a cell's own square is taken out.
//! 4. In an upright triangle a wall or a grid line counts up to the lower of both sides
//!    ([`upright`]).
//!
//! The result is that of [`link_los`](super::link_los) at every place, except at single places
//! between two parts, which have no length and so no state. Intervals that abut are one.

mod ground;
mod half_space;
mod hidden;
mod inside;
mod links;
mod over_columns;
mod over_prisms;
mod place;
mod plan;
mod region;
mod seen;
mod upright;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod tests_fields;
#[cfg(test)]
mod tests_oracle;
#[cfg(test)]
mod tests_pruning;
#[cfg(test)]
mod tests_scenes;

use hidden::HiddenParts;
use links::Links;

pub use ground::{GroundPart, ground_parts};
pub use hidden::{HiddenPart, LegObstacle};
pub use inside::inside_parts;
pub use links::LegWindow;
pub use place::{LegPart, LegPlace, common_parts, merged_parts, total_length};

use crate::height_field::{HeightField, Station};

/// A straight leg of a receiver, and the part of it that is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leg {
    /// Start.
    pub from: Station,
    /// End.
    pub to: Station,
    /// Part of the leg that is looked at.
    pub window: LegWindow,
}

/// Returns the parts of a leg that are not in line of sight of an observer, sorted and disjoint.
///
/// The receiver is on the leg; its own cells are exempt. Over a flat earth only (not checked).
/// Positions may differ by at most 2^27 lattice steps along each axis, heights by less than 2^28
/// (not checked).
pub fn hidden_parts(field: &HeightField, observer: &Station, leg: &Leg) -> Vec<HiddenPart> {
    let mut hidden = HiddenParts::within(leg.window.part());
    if let Some(prisms) = field.prisms() {
        let ends = [leg.from.on_prisms(), leg.to.on_prisms()];
        over_prisms::hide_by_prisms(prisms, &Links::new(observer.on_prisms(), ends, leg.window), &mut hidden);
    }
    if let Some(columns) = field.columns() {
        let ends = [leg.from.on_columns(), leg.to.on_columns()];
        over_columns::hide_by_columns(columns, &Links::new(observer.on_columns(), ends, leg.window), &mut hidden);
    }
    hidden.into_parts()
}
