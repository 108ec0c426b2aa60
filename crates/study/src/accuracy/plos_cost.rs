//! Effort against accuracy of P_LoS over a generated city: the product and both simulators with
//! growing effort, and published models.

use crate::error::Result;
use crate::los_probability::city::CitySimulator;
use crate::los_probability::estimate::{Count, Estimate, clustered, wilson};
use crate::los_probability::geometry::GeometrySimulator;
use crate::los_probability::models::{Model, ModelLink};
use crate::los_probability::product::{Product, SHIFTS};
use crate::los_probability::setting::Setting;

/// Way to compute P_LoS with a fixed effort.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlosWay {
    /// Product over crossed buildings with this many points of each shift.
    Product(u64),
    /// This many whole cities.
    City(u64),
    /// This many links, each in its own city.
    Geometry(u64),
    /// A published model.
    Model(Model),
}

/// Result of a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlosAnswer {
    /// An estimate with its standard error.
    Estimate(Estimate),
    /// Value of a model, which has no error estimate.
    Model(f64),
}

impl PlosAnswer {
    /// Returns P_LoS; `None` without a user who counts.
    pub fn p_los(&self) -> Option<f64> {
        match self {
            PlosAnswer::Estimate(estimate) => estimate.p_los,
            PlosAnswer::Model(p_los) => Some(*p_los),
        }
    }
}

/// Points of each shift.
const POINTS: [u64; 5] = [1 << 4, 1 << 7, 1 << 10, 1 << 12, 1 << 14];
/// Numbers of whole cities: as many as a standard error needs, and more.
const CITIES: [u64; 4] = [16, 64, 256, 1024];
/// Numbers of links of the geometry simulator.
const LINKS: [u64; 5] = [1 << 6, 1 << 9, 1 << 12, 1 << 15, 1 << 18];
/// Points of each shift of the converged product.
const REFERENCE_POINTS: u64 = 1 << 17;
/// Users per city, as in `skyshed plos`.
const USERS_PER_CITY: u32 = 360;
/// Confidence of intervals, which are not reported. Standard errors do not depend on it.
const CONFIDENCE: f64 = 0.95;

impl PlosWay {
    /// Returns all ways, by rising effort. Of two versions of a model it has the published formula
    /// only; models of a single azimuth are left out.
    pub fn all() -> Vec<PlosWay> {
        let is_wanted = |m: &Model| !matches!(m, Model::AlHourani2014Table | Model::Tr38811Linear | Model::Saboor2024);
        let ways = POINTS.map(PlosWay::Product).into_iter().chain(CITIES.map(PlosWay::City));
        ways.chain(LINKS.map(PlosWay::Geometry))
            .chain(Model::ALL.into_iter().filter(is_wanted).map(PlosWay::Model))
            .collect()
    }

    /// Returns the word of the command line.
    pub fn method(self) -> &'static str {
        match self {
            PlosWay::Product(_) => "product",
            PlosWay::City(_) => "city",
            PlosWay::Geometry(_) => "geometry",
            PlosWay::Model(model) => model.id(),
        }
    }

    /// Returns the effort in words; empty for a model.
    pub fn parameters(self) -> String {
        match self {
            PlosWay::Product(points) => format!("{SHIFTS} shifts of {points} points"),
            PlosWay::City(cities) => format!("{cities} cities of {USERS_PER_CITY} users"),
            PlosWay::Geometry(links) => format!("{links} links"),
            PlosWay::Model(_) => String::new(),
        }
    }

    /// Returns P_LoS of users at one distance.
    pub fn answer(self, setting: &Setting, seed: u64) -> std::result::Result<PlosAnswer, String> {
        let estimate = match self {
            PlosWay::Product(points) => by_product(setting, seed, points),
            PlosWay::City(cities) => by_cities(setting, seed, cities).map_err(|e| e.to_string())?,
            PlosWay::Geometry(links) => {
                let count = GeometrySimulator::new(setting).count(seed, 0, links);
                wilson(count.los, count.receivers, CONFIDENCE)
            }
            PlosWay::Model(model) => return by_model(model, setting),
        };
        Ok(PlosAnswer::Estimate(estimate))
    }
}

/// Returns the converged product. Its seed is its own, so it shares no points with contestants.
pub fn reference(setting: &Setting, seed: u64) -> Estimate {
    by_product(setting, !seed, REFERENCE_POINTS)
}

fn by_product(setting: &Setting, seed: u64, points: u64) -> Estimate {
    let mut product = Product::new(*setting, seed);
    product.add_points(points);
    product.estimate(CONFIDENCE)
}

fn by_cities(setting: &Setting, seed: u64, cities: u64) -> Result<Estimate> {
    let draws = CitySimulator::new(&[*setting], USERS_PER_CITY)?.count_many(seed, 0, cities);
    let counts: Vec<Count> = draws.into_iter().flatten().collect();
    Ok(clustered(&counts, CONFIDENCE))
}

fn by_model(model: Model, setting: &Setting) -> std::result::Result<PlosAnswer, String> {
    let link = ModelLink::of(setting)?;
    model.p_los(&link).map(|value| PlosAnswer::Model(value.p_los)).map_err(|outside| outside.to_string())
}
