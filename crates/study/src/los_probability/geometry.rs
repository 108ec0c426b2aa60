//! Geometry simulator of Saboor et al. 2023 (section III-B): one user, one UAV, and the buildings
//! between them.
//!
//! A draw places a user and a UAV. It draws the height of each building when the link meets it,
//! until one blocks the link. No city is built, so the cost does not grow with the city. Draws are
//! independent, so a count of them is binomial. Building (i, j) has the height of that building in
//! the whole city of the seed. So for one seed this simulator and [`super::city`] agree link by
//! link.
//!
//! The paper places only the user. Here the UAV may have a zone, too: draws whose user does not
//! count are repeated.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

use super::city::{CityLink, lattice_point};
use super::estimate::Count;
use super::lattice_city::LatticeCity;
use super::points::unit_interval;
use super::setting::{Setting, position_of};
use super::street_grid::GridZone;
use crate::city::BuildingHeights;
use crate::quantity::LatticePoint;

/// Most placements that one draw tries. If all fail, no user who counts is possible.
const MOST_TRIES: u32 = 10_000;

/// Simulator for one setting.
#[derive(Debug, Clone)]
pub struct GeometrySimulator {
    setting: Setting,
    city: LatticeCity,
}

impl GeometrySimulator {
    /// Makes the simulator for a setting.
    pub fn new(setting: &Setting) -> Self {
        GeometrySimulator { setting: *setting, city: LatticeCity::new(setting.built_up, None) }
    }

    /// Returns `true` if draw number `k` of a seed is in line of sight; `None` if no user counts.
    pub fn draw(&self, seed: u64, k: u64) -> Option<bool> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(k);
        let setting = &self.setting;
        for _ in 0..MOST_TRIES {
            let city_seed = random.next_u64();
            let mut number = || unit_interval(random.next_u64());
            let [x, y] = position_of(setting.placement, self.city.grid(), [number(), number()]);
            let (offset, street) = setting.offset(number(), number());
            let user = [x + offset[0], y + offset[1]];
            if !setting.counts(self.city.grid().zone(user[0], user[1]), street) {
                continue;
            }
            let link = CityLink {
                receiver: lattice_point(user, setting.rx_height_m),
                uav: lattice_point([x, y], setting.uav_height_m),
            };
            let mut heights = setting.built_up.heights(city_seed);
            if setting.uav_clear_of_roof && self.is_inside(&link.uav, &mut heights) {
                continue;
            }
            return Some(self.los(&link, &mut heights));
        }
        None
    }

    /// Returns `true` if a link is in line of sight in the city with these heights.
    pub fn los(&self, link: &CityLink, heights: &mut BuildingHeights) -> bool {
        self.city.los(&link.receiver, &link.uav, |i, j| heights.steps(i, j))
    }

    /// Counts draws `first` to `first + n` of a seed in parallel: those with a user, and those of
    /// them in line of sight.
    pub fn count(&self, seed: u64, first: u64, n: u64) -> Count {
        let draws = (first..first + n).into_par_iter().filter_map(|k| self.draw(seed, k));
        draws.map(|los| Count { receivers: 1, los: u64::from(los) }).sum()
    }

    fn is_inside(&self, uav: &LatticePoint, heights: &mut BuildingHeights) -> bool {
        self.city.zone(uav.x, uav.y) == GridZone::Building && i64::from(heights.steps(0, 0)) > uav.z
    }
}
