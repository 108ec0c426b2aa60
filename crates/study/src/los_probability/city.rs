//! 3-D city simulator of Saboor et al. 2023 (section III-A): a new city for every draw, seen from
//! one UAV.
//!
//! A draw consists of a city with all its buildings, large enough that no link leaves it, a UAV
//! over it, and users. Users are on a circle around the point below the UAV, or over the area
//! within a radius. One city serves all settings of a study that share its α, β, γ, as in the
//! paper. So curves over angles or heights are smooth where cities differ. Only obstructing points
//! are compared, in integers ([`LatticeCity`]).
//!
//! Each draw turns the circle by a random angle. Users at whole degrees would include azimuth 0 and
//! 90, along the streets. There P_LoS is 1 for a set of directions of measure 0.
//!
//! Users of one city share its buildings, so the city is the unit of the error: see [`clustered`].
//!
//! [`clustered`]: super::estimate::clustered

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

use super::estimate::Count;
use super::lattice_city::LatticeCity;
use super::points::unit_interval;
use super::setting::{Setting, position_of};
use super::street_grid::GridZone;
use crate::city::BuiltUp;
use crate::error::{LosProbabilityError, Result};
use crate::quantity::{LatticePoint, STEPS_PER_UNIT, height_steps};

/// Most buildings of one city; each takes 4 bytes per thread.
const MOST_BUILDINGS: f64 = 1e8;

/// City of a study: its seed, and the place of the UAV.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CityDraw {
    /// Seed of the building heights: `itu:α,β,γ --seed N` builds the same city.
    pub seed: u64,
    /// Two numbers in \[0, 1) that place the UAV in its zone.
    pub position: [f64; 2],
    /// Two numbers in \[0, 1) that turn the circle of users, or shift their pattern over the area.
    pub turn: [f64; 2],
}

impl CityDraw {
    /// Draws number `k` of a seed.
    pub fn new(seed: u64, k: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(k);
        let seed = random.next_u64();
        let mut number = || unit_interval(random.next_u64());
        CityDraw { seed, position: [number(), number()], turn: [number(), number()] }
    }
}

/// Simulator for settings that share α, β, γ.
#[derive(Debug, Clone)]
pub struct CitySimulator {
    settings: Vec<Setting>,
    city: LatticeCity,
    built_up: BuiltUp,
    n_users: u32,
    /// Number of periods around the UAV's own, on each side.
    n_around: i32,
}

/// Link of a draw.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CityLink {
    /// The user.
    pub receiver: LatticePoint,
    /// The UAV.
    pub uav: LatticePoint,
}

impl CitySimulator {
    /// Makes a simulator of `n_users` users per city and setting; 8 if the azimuth is given.
    ///
    /// # Errors
    /// Limit error (E502) if the cities would have more than 10^8 buildings.
    ///
    /// # Panics
    /// If the settings are of different cities, or there is none.
    pub fn new(settings: &[Setting], n_users: u32) -> Result<Self> {
        let built_up = settings.first().expect("there is a setting").built_up;
        assert!(settings.iter().all(|s| s.built_up == built_up), "one simulator serves one kind of city");
        let farthest_m = settings.iter().map(|s| s.reach.farthest()).fold(0.0, f64::max);
        let n_periods = (farthest_m / built_up.period()).ceil() + 1.0;
        let buildings = (2.0 * n_periods + 1.0).powi(2);
        if buildings > MOST_BUILDINGS {
            return Err(LosProbabilityError::CityTooLarge { farthest_m, buildings, most: MOST_BUILDINGS }.into());
        }
        #[expect(clippy::cast_possible_truncation, reason = "at most 5000 by the check above")]
        let n_around = n_periods as i32;
        Ok(CitySimulator {
            settings: settings.to_vec(),
            city: LatticeCity::new(built_up, None),
            built_up,
            n_users,
            n_around,
        })
    }

    /// Returns the number of buildings of one city.
    pub fn n_buildings(&self) -> u64 {
        let side = u64::from((2 * self.n_around + 1).unsigned_abs());
        side * side
    }

    /// Returns the links of a draw for a setting whose users count, in the order of the circle.
    /// Returns `None` if the UAV must be clear of roofs and would be inside the building below it.
    pub fn links(
        &self,
        setting: &Setting,
        draw: &CityDraw,
        height: &mut impl FnMut(i32, i32) -> i32,
    ) -> Option<Vec<CityLink>> {
        let grid = self.city.grid();
        // The UAV's period is in the middle of the city, whose south-west corner is the origin.
        let corner = f64::from(self.n_around) * grid.period();
        let [x, y] = position_of(setting.placement, grid, draw.position).map(|v| corner + v);
        let uav = lattice_point([x, y], setting.uav_height_m);
        if setting.uav_clear_of_roof
            && self.city.zone(uav.x, uav.y) == GridZone::Building
            && i64::from(height(self.n_around, self.n_around)) > uav.z
        {
            return None;
        }
        // With a given azimuth there is one user in each octant; more would be at equal places.
        let n_users = if setting.phi_deg.is_some() { OCTANTS } else { self.n_users };
        let n = f64::from(n_users);
        let user = |k: u32| {
            let azimuth = (f64::from(k) + draw.turn[0]) / n;
            // The golden section spreads distances evenly, whatever the number of users.
            let radius = (draw.turn[1] + f64::from(k) * GOLDEN_SECTION).fract();
            let (offset, street) = setting.offset(azimuth, radius);
            // Zones are those of the exact position: on the lattice a wall is as wide as a step,
            // and its points would count as street. A user outside a wall stays outside, because
            // both are rounded alike.
            let user = [x + offset[0], y + offset[1]];
            let receiver = lattice_point(user, setting.rx_height_m);
            setting.counts(grid.zone(user[0], user[1]), street).then_some(CityLink { receiver, uav })
        };
        Some((0..n_users).filter_map(user).collect())
    }

    /// Counts the links of a draw and those in line of sight, setting by setting.
    pub fn count(&self, draw: &CityDraw) -> Vec<Count> {
        // The whole city, as in the paper, and its highest building.
        let side = 2 * self.n_around + 1;
        let mut drawn = self.built_up.heights(draw.seed);
        let heights: Vec<i32> =
            (0..side).flat_map(|j| (0..side).map(move |i| (i, j))).map(|(i, j)| drawn.steps(i, j)).collect();
        let highest = heights.iter().copied().max();
        let city = LatticeCity::new(self.built_up, highest);
        #[expect(clippy::cast_sign_loss, reason = "links stay within the city")]
        let mut height = |i: i32, j: i32| heights[(j * side + i) as usize];
        let count = |setting: &Setting| {
            let Some(links) = self.links(setting, draw, &mut height) else { return Count::default() };
            let los = links.iter().filter(|link| city.los(&link.receiver, &link.uav, &mut height)).count();
            Count { receivers: links.len() as u64, los: los as u64 }
        };
        self.settings.iter().map(count).collect()
    }

    /// Counts draws `first` to `first + n` of a seed in parallel, `[draw][setting]`. The counts do
    /// not depend on the number of threads.
    pub fn count_many(&self, seed: u64, first: u64, n: u64) -> Vec<Vec<Count>> {
        (first..first + n).into_par_iter().map(|k| self.count(&CityDraw::new(seed, k))).collect()
    }
}

/// Number of directions equivalent to a given azimuth: its mirror images, along either street.
const OCTANTS: u32 = 8;

/// 2/(1 + √5).
const GOLDEN_SECTION: f64 = 0.618_033_988_749_894_8;

/// Returns a position and a height above ground \[m\] on the lattice.
pub(super) fn lattice_point(position: [f64; 2], height_m: f64) -> LatticePoint {
    #[expect(clippy::cast_possible_truncation, reason = "positions are within the lattice by the checks of Setting")]
    let [x, y] = position.map(|v| (v * f64::from(STEPS_PER_UNIT)).round() as i64);
    LatticePoint { x, y, z: height_steps(height_m).map_or(0, i64::from) }
}
