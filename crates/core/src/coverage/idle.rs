//! Footprints that cannot hide any receiver of a run from any of its UAVs: dropped before work
//! starts, and counted.
//!
//! Every link lies in the box around the UAVs and the receivers in range. It is nowhere below the
//! lowest of them, but for what it sags by over a curved earth. So a prism that is no higher blocks
//! none, nor does one whose bounding box lies outside. Those that remain may still hide nobody,
//! which only their shadows show.

use super::Uav;
use super::view::Mapper;
use crate::height_field::{Caster, Prisms, Station};
use crate::overlay::bounds_of;

/// Footprints of a scene, by what they can do to a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct IdleFootprints {
    /// All of them.
    pub footprints: u64,
    /// Not higher than any link is anywhere.
    pub too_low: u64,
    /// Outside the box of all links, or partly that and else too low.
    pub out_of_reach: u64,
}

impl IdleFootprints {
    /// Returns the number of those that are dropped.
    pub fn dropped(&self) -> u64 {
        self.too_low + self.out_of_reach
    }
}

/// The box that holds every link of a run, on the lattice of the prisms.
#[derive(Debug, Clone, Copy)]
struct LinkBox {
    /// West, south, east, north.
    bounds: [i64; 4],
    /// Nowhere below this is a link \[1/1024 m above the datum\].
    lowest: i64,
}

impl LinkBox {
    fn add(&mut self, x: i64, y: i64) {
        let [west, south, east, north] = self.bounds;
        self.bounds = [west.min(x), south.min(y), east.max(x), north.max(y)];
    }

    fn is_too_low(&self, top: i32) -> bool {
        i64::from(top) <= self.lowest
    }

    /// Returns whether a bounding box, west, south, east and north, lies outside; one that touches
    /// does not.
    fn is_beyond(&self, bounds: [i32; 4]) -> bool {
        let [west, south, east, north] = bounds.map(i64::from);
        east < self.bounds[0] || west > self.bounds[2] || north < self.bounds[1] || south > self.bounds[3]
    }
}

impl Mapper<'_> {
    /// Drops footprints that cannot hide a receiver from these UAVs; from then on the mapper is for
    /// them alone. Counts footprints, of which a raster scene has none.
    ///
    /// Cost: a look at each piece of a footprint.
    pub fn drop_idle(&mut self, uavs: &[Uav]) -> IdleFootprints {
        let Some(prisms) = self.field().prisms() else { return IdleFootprints::default() };
        let links = self.links_of(uavs);
        let kept = prisms.casters().kept(|c: &Caster| !links.is_too_low(c.top) && !links.is_beyond(c.bounds));
        self.cast_only(kept);
        count(prisms, self.field().n_buildings(), &links)
    }

    fn links_of(&self, uavs: &[Uav]) -> LinkBox {
        let mut links = LinkBox { bounds: [i64::MAX, i64::MAX, i64::MIN, i64::MIN], lowest: i64::MAX };
        let mut sag = 0;
        for uav in uavs {
            let place = uav.station.on_prisms();
            links.add(place.x, place.y);
            links.lowest = links.lowest.min(uav.station.z);
            // A UAV without a view has no map either.
            let Ok(view) = self.seen_from(uav) else { continue };
            let window = view.window;
            if window.n_rows == 0 || window.n_cols == 0 {
                continue;
            }
            if view.scene().curvature().is_some() {
                // A link sags by a quarter of what its end drops by.
                sag = sag.max(view.most_drop() / 4 + 1);
            }
            let last = (window.row + window.n_rows - 1, window.col + window.n_cols - 1);
            for (row, col) in [(window.row, window.col), last] {
                let corner = Station { place: self.positions().center(row, col), z: 0 }.on_prisms();
                links.add(corner.x, corner.y);
            }
        }
        let lowest = self.receivers.iter().filter_map(|receivers| receivers.lowest()).min();
        // A lattice step to spare: how stable answers are is found by moving the UAV by one.
        let [west, south, east, north] = links.bounds;
        LinkBox {
            bounds: [west - 1, south - 1, east + 1, north + 1],
            lowest: links.lowest.min(lowest.unwrap_or(i64::MAX)) - 1 - sag,
        }
    }
}

/// Footprints all of whose pieces are idle, by the first reason that any of them leaves.
fn count(prisms: &Prisms, n_footprints: usize, links: &LinkBox) -> IdleFootprints {
    #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    enum Role {
        None,
        TooLow,
        Beyond,
        Busy,
    }
    let mut roles = vec![Role::None; n_footprints];
    for piece in prisms.pieces() {
        let bounds = bounds_of(prisms.ring(piece));
        let role = match (links.is_too_low(piece.top), links.is_beyond(bounds)) {
            (true, _) => Role::TooLow,
            (false, true) => Role::Beyond,
            (false, false) => Role::Busy,
        };
        if let Some(of_footprint) = roles.get_mut(piece.building as usize) {
            *of_footprint = role.max(*of_footprint);
        }
    }
    let n = |role: Role| roles.iter().filter(|r| **r == role).count() as u64;
    // One without a piece, whose outline has no area on the lattice, hides nothing either.
    IdleFootprints {
        footprints: n_footprints as u64,
        too_low: n(Role::TooLow) + n(Role::None),
        out_of_reach: n(Role::Beyond),
    }
}
