//! Estimates for many settings, each to the requested precision.

use std::collections::HashMap;

use rayon::prelude::*;

use skyshed_request::{Placement, Users};

use super::city::CitySimulator;
use super::estimate::{Estimate, clustered, wilson};
use super::geometry::GeometrySimulator;
use super::points::MOST_POINTS;
use super::product::{Product, across_street};
use super::setting::Setting;
use crate::error::Result;

/// Method that estimates P_LoS.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Estimator {
    /// The product over crossed buildings, averaged by a lattice.
    Product,
    /// Whole cities.
    City,
    /// One link at a time.
    Geometry,
}

impl Estimator {
    /// Returns the word of the command line.
    pub fn name(self) -> &'static str {
        match self {
            Estimator::Product => "product",
            Estimator::City => "city",
            Estimator::Geometry => "geometry",
        }
    }
}

/// Amount of sampling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Seed of all random numbers.
    pub seed: u64,
    /// Confidence of the intervals, 0 < c < 1.
    pub confidence: f64,
    /// Half-width that every interval must reach; `None` for the numbers below and
    /// [`PRODUCT_HALF_WIDTH`].
    pub until: Option<f64>,
    /// Number of cities.
    pub n_cities: u64,
    /// Number of users per city and setting.
    pub n_users: u32,
    /// Number of links of the geometry simulator per setting.
    pub n_links: u64,
}

/// Half-width of the intervals of the product unless `until` is given.
pub const PRODUCT_HALF_WIDTH: f64 = 0.001;

/// First number of points per shift of the product.
const FIRST_POINTS: u64 = 512;
/// First numbers of cities and links with `until`: enough to know the spread.
const FIRST_CITIES: u64 = 50;
const FIRST_LINKS: u64 = 2_000;
/// Numbers of cities and links at which `until` ends, reached or not.
const MOST_CITIES: u64 = 200_000;
const MOST_LINKS: u64 = 1 << 28;

/// Estimates P_LoS in the order of the settings.
///
/// Whole cities serve all settings that share α, β, γ. With `until` the number of cities or links
/// grows by half until all intervals are narrow enough; it depends on the seed alone.
pub fn estimate_all(estimator: Estimator, settings: &[Setting], effort: &Effort) -> Result<Vec<Estimate>> {
    match estimator {
        Estimator::Product => Ok(settings.par_iter().map(|s| by_product(s, effort)).collect()),
        Estimator::Geometry => Ok(settings.iter().map(|s| by_geometry(s, effort)).collect()),
        Estimator::City => {
            let mut groups: Vec<Vec<usize>> = Vec::new();
            let mut of_city: HashMap<[u64; 3], usize> = HashMap::new();
            for (k, setting) in settings.iter().enumerate() {
                let city = setting.built_up;
                let key = [city.built_up_ratio, city.buildings_per_km2, city.height_scale].map(f64::to_bits);
                let group = *of_city.entry(key).or_insert_with(|| {
                    groups.push(Vec::new());
                    groups.len() - 1
                });
                groups[group].push(k);
            }
            let mut found: Vec<Option<Estimate>> = vec![None; settings.len()];
            for group in groups {
                let alike: Vec<Setting> = group.iter().map(|k| settings[*k]).collect();
                for (k, estimate) in group.iter().zip(by_city(&alike, effort)?) {
                    found[*k] = Some(estimate);
                }
            }
            Ok(found.into_iter().flatten().collect())
        }
    }
}

/// Returns `true` if an estimate needs no more samples: it is narrow enough, or no user counts.
fn is_enough(estimate: &Estimate, half_width: f64) -> bool {
    estimate.p_los.is_none() || estimate.half_width().is_some_and(|reach| reach <= half_width)
}

fn by_product(setting: &Setting, effort: &Effort) -> Estimate {
    let is_across = setting.phi_deg == Some(0.0)
        && setting.users == Users::Street
        && setting.placement == Placement::Anywhere
        && !setting.uav_clear_of_roof;
    if is_across && let Some(p_los) = across_street(setting) {
        return Estimate::exact(p_los);
    }
    let half_width = effort.until.unwrap_or(PRODUCT_HALF_WIDTH);
    let mut product = Product::new(*setting, effort.seed);
    let mut n = FIRST_POINTS;
    product.add_points(n);
    loop {
        let estimate = product.estimate(effort.confidence);
        if is_enough(&estimate, half_width) || n >= MOST_POINTS {
            return estimate;
        }
        // Doubling the points gives a lattice again.
        product.add_points(n);
        n *= 2;
    }
}

fn by_geometry(setting: &Setting, effort: &Effort) -> Estimate {
    let simulator = GeometrySimulator::new(setting);
    let mut n = if effort.until.is_some() { FIRST_LINKS } else { effort.n_links };
    if simulator.draw(effort.seed, 0).is_none() {
        return Estimate::none();
    }
    let mut count = simulator.count(effort.seed, 0, n);
    loop {
        let estimate = wilson(count.los, count.receivers, effort.confidence);
        let Some(half_width) = effort.until else { return estimate };
        if is_enough(&estimate, half_width) || n >= MOST_LINKS {
            return estimate;
        }
        let more = n / 2;
        count = count + simulator.count(effort.seed, n, more);
        n += more;
    }
}

fn by_city(settings: &[Setting], effort: &Effort) -> Result<Vec<Estimate>> {
    let simulator = CitySimulator::new(settings, effort.n_users)?;
    let mut counts =
        simulator.count_many(effort.seed, 0, if effort.until.is_some() { FIRST_CITIES } else { effort.n_cities });
    loop {
        let estimates: Vec<Estimate> = (0..settings.len())
            .map(|k| clustered(&counts.iter().map(|draw| draw[k]).collect::<Vec<_>>(), effort.confidence))
            .collect();
        let n = counts.len() as u64;
        let Some(half_width) = effort.until else { return Ok(estimates) };
        if estimates.iter().all(|e| is_enough(e, half_width)) || n >= MOST_CITIES {
            return Ok(estimates);
        }
        counts.extend(simulator.count_many(effort.seed, n, n / 2));
    }
}
