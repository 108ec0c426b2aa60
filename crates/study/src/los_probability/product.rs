//! P_LoS with the heights integrated out: the product over the crossed buildings.
//!
//! A link clears a building of height H if and only if H ≤ z. Here z is the lower of the ray's
//! heights at both ends of the crossing. The obstructing point is the one towards the lower
//! terminal (Saboor et al. 2023, eq. 3). Heights are independent Rayleigh variates, so for one link
//!
//! ```text
//!   P_LoS = Π over crossed buildings of F(z),   F(z) = 1 − exp(−z² / 2γ²) for z > 0, else 0
//! ```
//!
//! A UAV over a building needs no extra rule: the crossing ends at the UAV. If it must hover clear
//! of the roof, the condition H < h_U divides by F(h_U), and positions over buildings have the
//! weight F(h_U).
//!
//! The mean over positions and azimuths is taken by [`Points`]. Each of [`SHIFTS`] independent
//! shifts gives a ratio Σ w·P / Σ w, with w = 1 if the user counts. The estimate is the ratio of
//! the sums over all shifts. Its standard error is that of a ratio over independent shifts.

use rayon::prelude::*;

use skyshed_request::{Placement, Users};

use super::estimate::{Estimate, ratio_of_clusters};
use super::points::Points;
use super::setting::{Setting, position_of};
use super::street_grid::{GridLink, GridZone, StreetGrid};
use crate::quadrature::mean_over_unit;

/// Number of independent shifts of the lattice, which are the clusters of an estimate.
pub const SHIFTS: usize = 32;

/// Number of γ above which no roof is met: F(9γ) = 1 − 2.6·10^−18, which is 1 in floating point.
const CERTAIN_SCALES: f64 = 9.0;

/// Returns F(z) = 1 − exp(−z²/2γ²) of building heights (Saboor et al. 2023, eq. 1, integrated).
#[inline]
pub fn rayleigh_cdf(z: f64, height_scale: f64) -> f64 {
    if z <= 0.0 {
        return 0.0;
    }
    let q = z / height_scale;
    -libm::expm1(-0.5 * q * q)
}

/// Returns P_LoS of one link, to a few units of the last place.
pub fn link_p_los(grid: &StreetGrid, height_scale: f64, link: &GridLink) -> f64 {
    let r = link.ground_distance();
    let rises = link.uav[2] >= link.receiver[2];
    let certain = CERTAIN_SCALES * height_scale;
    let mut p_los = 1.0;
    grid.for_each_crossed(link, |crossing| {
        let z = link.height_at(if rises { crossing.t_in } else { crossing.t_out }, r);
        if z >= certain {
            // A rising ray meets nothing beyond, a falling one may.
            return !rises;
        }
        let q = z.max(0.0) / height_scale;
        p_los *= 1.0 - exp_of_negative(-0.5 * q * q);
        p_los > 0.0
    });
    p_los
}

/// Sums over the points of one shift.
#[derive(Debug, Clone)]
struct Shift {
    points: Points,
    p_los: f64,
    weight: f64,
    n_users: u64,
}

/// Mean of P_LoS over positions and azimuths that can be refined.
#[derive(Debug, Clone)]
pub struct Product {
    setting: Setting,
    grid: StreetGrid,
    shifts: Vec<Shift>,
}

impl Product {
    /// Makes a mean without points.
    pub fn new(setting: Setting, seed: u64) -> Self {
        let shift = |k: usize| Shift { points: Points::new(seed, k as u64), p_los: 0.0, weight: 0.0, n_users: 0 };
        Product { setting, grid: StreetGrid::new(&setting.built_up), shifts: (0..SHIFTS).map(shift).collect() }
    }

    /// Adds `n` points to each shift. Shifts run in parallel; each adds its points in order, so
    /// that the sums do not depend on the threads.
    pub fn add_points(&mut self, n: u64) {
        let (setting, grid) = (self.setting, self.grid);
        self.shifts.par_iter_mut().for_each(|shift| {
            for point in shift.points.by_ref().take(usize::try_from(n).unwrap_or(usize::MAX)) {
                if let Some((p_los, weight)) = sample(&setting, &grid, point) {
                    shift.p_los += p_los;
                    shift.weight += weight;
                    shift.n_users += 1;
                }
            }
        });
    }

    /// Returns the mean over all points so far, with an interval of the given confidence.
    pub fn estimate(&self, confidence: f64) -> Estimate {
        let n_users = self.shifts.iter().map(|s| s.n_users).sum();
        ratio_of_clusters(self.shifts.iter().map(|s| (s.p_los, s.weight)), n_users, confidence)
    }
}

/// Returns P_LoS and the weight of the user at a point; `None` if no user who counts is there.
fn sample(setting: &Setting, grid: &StreetGrid, [u, v, azimuth, radius]: [f64; 4]) -> Option<(f64, f64)> {
    // A quarter of the circle represents it all: zones are their own mirror images.
    let azimuth = if setting.phi_deg.is_none() { 0.25 * azimuth } else { azimuth };
    let (offset, street) = setting.offset(azimuth, radius);
    let (user, uav) = if setting.placement == Placement::Anywhere {
        // The UAV is as uniform as the user: start from a user who counts.
        let user = user_position(setting.users, grid, [u, v], street);
        (user, [user[0] - offset[0], user[1] - offset[1]])
    } else {
        let uav = position_of(setting.placement, grid, [u, v]);
        let user = [uav[0] + offset[0], uav[1] + offset[1]];
        if !setting.counts(grid.zone(user[0], user[1]), street) {
            return None;
        }
        (user, uav)
    };
    let link =
        GridLink { receiver: [user[0], user[1], setting.rx_height_m], uav: [uav[0], uav[1], setting.uav_height_m] };
    let height_scale = setting.built_up.height_scale;
    let p_los = link_p_los(grid, height_scale, &link);
    let weight = if setting.uav_clear_of_roof && grid.zone(uav[0], uav[1]) == GridZone::Building {
        rayleigh_cdf(setting.uav_height_m, height_scale)
    } else {
        1.0
    };
    Some((p_los, weight))
}

/// Returns a user's place for two numbers in \[0, 1), uniform over the users who count.
fn user_position(users: Users, grid: &StreetGrid, [u, v]: [f64; 2], street: Option<GridZone>) -> [f64; 2] {
    let (s, t) = (grid.street(), grid.period());
    let along_y = |u: f64| [s * u, s + (t - s) * v];
    match users {
        Users::Crossroad => [s * u, s * v],
        Users::Street => match street {
            Some(GridZone::StreetAlongX) => {
                let [x, y] = along_y(u);
                [y, x]
            }
            Some(_) => along_y(u),
            // Both streets look the same in all directions together.
            None => along_y(u),
        },
        Users::Outdoor => {
            // The street along y with its crossroad, then the rest of the street along x.
            let first = t / (2.0 * t - s);
            if u < first { [s * (u / first), t * v] } else { [s + (t - s) * ((u - first) / (1.0 - first)), s * v] }
        }
    }
}

/// Returns P_LoS of street users at azimuth φ = 0, across the street, by quadrature in one
/// dimension. It is exact to about 10 digits.
///
/// Let u be the distance to the wall ahead, uniform in (0, s). The link meets walls at u + kT, so
/// P_LoS = 1/s ∫ Π over k ≥ 0, u + kT < r of F(h_rx + (u + kT) tan θ) du. The number of factors
/// changes at u + kT = r, where the integral is cut. Below one period, for h_rx = 0, this is the
/// closed form 1 − γ√(π/2)/(s tan θ) · erf(min(r, s) tan θ/(√2 γ)).
pub fn across_street(setting: &Setting) -> Option<f64> {
    let theta = setting.theta_deg()?;
    let (grid, height_scale) = (StreetGrid::new(&setting.built_up), setting.built_up.height_scale);
    let (s, t, r) = (grid.street(), grid.period(), setting.reach.farthest());
    if theta >= 90.0 {
        return Some(1.0);
    }
    let slope = setting.rise() / r;
    let p_los = |u: f64| {
        let mut p = 1.0;
        let mut wall = u;
        while wall < r {
            let z = setting.rx_height_m + wall * slope;
            p *= rayleigh_cdf(z, height_scale);
            if p == 0.0 || z > CERTAIN_SCALES * height_scale {
                break;
            }
            wall += t;
        }
        p
    };
    // Pieces end where a factor is lost, and are short against the scale on which factors vary.
    let jump = r.rem_euclid(t);
    let ends: Vec<f64> = if jump > 0.0 && jump < s { vec![0.0, jump, s] } else { vec![0.0, s] };
    let mut sum = 0.0;
    for piece in ends.windows(2) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small, positive, and capped")]
        let n = ((piece[1] - piece[0]) * slope / height_scale * 4.0).ceil().clamp(8.0, 1e4) as usize;
        let width = (piece[1] - piece[0]) / n as f64;
        for k in 0..n {
            let start = piece[0] + k as f64 * width;
            sum += mean_over_unit(|x| p_los(start + x * width)) * width;
        }
    }
    Some(sum / s)
}

/// Returns e^x for −40.5 ≤ x ≤ 0, to 3·10^−15, alike on every machine. It is cheaper than a call.
#[inline]
fn exp_of_negative(x: f64) -> f64 {
    const ROUNDER: f64 = 6_755_399_441_055_744.0; // 1.5 · 2^52
    let k = (x * std::f64::consts::LOG2_E + ROUNDER) - ROUNDER;
    let r = (x - k * 0.693_147_180_369_123_8) - k * 1.908_214_929_270_587_7e-10;
    let mut sum = 1.0 / 39_916_800.0;
    for divisor in [3_628_800.0, 362_880.0, 40_320.0, 5040.0, 720.0, 120.0, 24.0, 6.0, 2.0, 1.0, 1.0] {
        sum = sum * r + 1.0 / divisor;
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "−59 ≤ k ≤ 0")]
    let power = f64::from_bits(((k as i64 + 1023) as u64) << 52);
    sum * power
}
