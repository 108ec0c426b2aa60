//! The Manhattan grid of the built-up parameters α, β, γ of ITU-R P.1410.
//!
//! Square buildings of width w stand on a square lattice, separated by streets of width s (Saboor
//! et al. 2023, eqs. 2–3). Their heights are independent Rayleigh variates of scale γ (eq. 1).
//!
//! The height of building (i, j) is a function of (seed, i, j) alone. Each building owns one stream
//! of a counter-based generator (ChaCha8) and draws one exponential variate E from it. The height
//! is γ·√(2E), rounded to the lattice. So a city is the same on every machine, for any number of
//! threads, and whether it is built at once or building by building.

use std::fmt;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Exp1};

use crate::error::{CityError, Result};
use crate::quantity::{MAX_HEIGHT_M, STEPS_PER_UNIT, height_steps};

/// The built-up parameters of a city.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BuiltUp {
    /// α: share of the land covered by buildings, 0 < α < 1.
    pub built_up_ratio: f64,
    /// β: buildings per square kilometer, > 0.
    pub buildings_per_km2: f64,
    /// γ: scale (mode) of the Rayleigh distribution of building heights \[m\], > 0.
    pub height_scale: f64,
}

impl BuiltUp {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Usage error if a parameter is not finite or out of range, or if streets or buildings would
    /// be narrower than 4 lattice steps (4 mm).
    pub fn new(built_up_ratio: f64, buildings_per_km2: f64, height_scale: f64) -> Result<Self> {
        let city = BuiltUp { built_up_ratio, buildings_per_km2, height_scale };
        let refuse = |name: &'static str, found: f64, wanted: &'static str| {
            Err(CityError::Parameter { name, found, wanted }.into())
        };
        if !(built_up_ratio > 0.0 && built_up_ratio < 1.0) {
            return refuse("α (built-up ratio)", built_up_ratio, "0 < α < 1");
        }
        if !(buildings_per_km2 > 0.0 && buildings_per_km2.is_finite()) {
            return refuse("β (buildings per km²)", buildings_per_km2, "β > 0");
        }
        if !(height_scale > 0.0 && height_scale <= MAX_HEIGHT_M / 16.0) {
            return refuse("γ (height scale)", height_scale, "0 < γ ≤ 2048 m");
        }
        let finest = 4.0 / f64::from(STEPS_PER_UNIT);
        if city.street_width() < finest || city.building_width() < finest {
            return refuse("α, β", built_up_ratio, "streets and buildings at least 4 mm wide");
        }
        Ok(city)
    }

    /// Estimates the built-up parameters of an existing city. They are the share of its cells that
    /// are buildings, its buildings per area, and the maximum-likelihood scale of a Rayleigh
    /// distribution, γ² = ΣH²/(2n).
    ///
    /// `heights` are those of all buildings \[m above their ground\]; `area_km2` is the area of the
    /// city. Returns `None` without a building or open ground.
    pub fn estimated(built_up_ratio: f64, heights: &[f64], area_km2: f64) -> Option<Self> {
        let n = heights.len() as f64;
        let squares: f64 = heights.iter().map(|h| h * h).sum();
        BuiltUp::new(built_up_ratio, n / area_km2, (squares / (2.0 * n)).sqrt()).ok()
    }

    /// Returns the environment of a name: `suburban`, `urban`, `dense-urban` (or `dense`),
    /// `high-rise` (or `highrise`). `ghent` is the center of that city, estimated by the paper
    /// below.
    ///
    /// # References
    /// The four tuples: Saboor et al. 2023, Table I; Holis & Pechac 2008, Table I. Ghent: Saboor et
    /// al. 2023, section IV.
    pub fn named(name: &str) -> Option<Self> {
        let (built_up_ratio, buildings_per_km2, height_scale) = match name {
            "suburban" => (0.1, 750.0, 8.0),
            "urban" => (0.3, 500.0, 15.0),
            "dense-urban" | "dense" => (0.5, 300.0, 20.0),
            "high-rise" | "highrise" => (0.5, 300.0, 50.0),
            "ghent" => (0.435, 4679.0, 8.8),
            _ => return None,
        };
        Some(BuiltUp { built_up_ratio, buildings_per_km2, height_scale })
    }

    /// Returns the width w of a building \[m\]: 1000·√(α/β) (Saboor et al. 2023, eq. 2).
    pub fn building_width(&self) -> f64 {
        1000.0 * (self.built_up_ratio / self.buildings_per_km2).sqrt()
    }

    /// Returns the width s of a street \[m\]: 1000/√β − w (Saboor et al. 2023, eq. 3).
    pub fn street_width(&self) -> f64 {
        1000.0 / self.buildings_per_km2.sqrt() - self.building_width()
    }

    /// Returns the period T = s + w of the grid \[m\].
    pub fn period(&self) -> f64 {
        1000.0 / self.buildings_per_km2.sqrt()
    }

    /// Returns the ends of building k along x or y: \[kT + s, (k + 1)T\] \[1/1024 m\]. Building 0
    /// follows the crossroad that begins at 0. Valid for |k|·T up to 2^20 m.
    pub fn building_span(&self, k: i32) -> [i64; 2] {
        let start = f64::from(k) * self.period();
        #[expect(clippy::cast_possible_truncation, reason = "at most 2^30 by the documented range")]
        let steps = |v: f64| (v * f64::from(STEPS_PER_UNIT)).round() as i64;
        [steps(start + self.street_width()), steps(start + self.period())]
    }

    /// Returns the building whose open span along x or y holds a coordinate \[1/1024 m\]; `None` on
    /// streets and walls.
    pub fn building_at(&self, v: i64) -> Option<i32> {
        #[expect(clippy::cast_possible_truncation, reason = "a city has far fewer than 2^31 columns")]
        let k = (v as f64 / f64::from(STEPS_PER_UNIT) / self.period()).floor() as i32;
        (k - 1..=k + 1).find(|k| {
            let [start, end] = self.building_span(*k);
            start < v && v < end
        })
    }

    /// Returns the heights of the buildings of the city with this seed.
    pub fn heights(&self, seed: u64) -> BuildingHeights {
        BuildingHeights {
            streams: ChaCha8Rng::seed_from_u64(seed),
            height_scale: self.height_scale,
            tallest: self.tallest(),
        }
    }

    /// Returns an upper bound of the buildings' heights \[m\]: γ·√90, at most 16 384 m.
    ///
    /// Variates E are cut at 45; larger ones have probability e^−45 = 3·10^−20.
    pub fn tallest(&self) -> f64 {
        (self.height_scale * 90.0_f64.sqrt()).min(TALLEST_M)
    }
}

/// Largest height of a generated building \[m\]; it keeps heights within the lattice for every γ.
const TALLEST_M: f64 = MAX_HEIGHT_M / 2.0;

/// The heights of one city's buildings, drawn on demand.
#[derive(Debug, Clone)]
pub struct BuildingHeights {
    streams: ChaCha8Rng,
    height_scale: f64,
    tallest: f64,
}

impl BuildingHeights {
    /// Returns the height of building (i, j) \[m above its ground\], not yet rounded to the
    /// lattice. It is always the same for (seed, i, j).
    pub fn meters(&mut self, i: i32, j: i32) -> f64 {
        self.streams.set_stream((u64::from(i.cast_unsigned()) << 32) | u64::from(j.cast_unsigned()));
        self.streams.set_word_pos(0);
        let exponential: f64 = Exp1.sample(&mut self.streams);
        (self.height_scale * (2.0 * exponential).sqrt()).min(self.tallest)
    }

    /// Returns the height of building (i, j) on the lattice \[1/1024 m\], as in the built city.
    pub fn steps(&mut self, i: i32, j: i32) -> i32 {
        height_steps(self.meters(i, j)).unwrap_or(0)
    }
}

impl fmt::Display for BuiltUp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "α = {}, β = {}/km², γ = {} m", self.built_up_ratio, self.buildings_per_km2, self.height_scale)
    }
}
