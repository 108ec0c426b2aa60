//! The document `skyshed/plos/1` and the row of its table, as types of serde.

use schemars::JsonSchema;
use serde::Serialize;

use crate::answer::{SourceFacts, WarningFacts};
use crate::map::FormDocument;

/// P_LoS by every method.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PlosDocument<'a> {
    /// Kind of document and its version.
    pub(super) schema: &'static str,
    /// Version of the program.
    pub(super) version: &'static str,
    /// Words of the command line after the program's name; empty for a call of the library.
    pub(super) command: &'a [String],
    /// Seed of everything random.
    pub(super) seed: u64,
    /// Confidence of the intervals.
    pub(super) confidence: f64,
    /// The methods.
    pub(super) methods: &'a [MethodFacts],
    /// What a tolerance led to, where one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) tolerance: Option<ProductToleranceDocument>,
    /// Cities in files.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) real_cities: Vec<RealCityDocument>,
    /// Files that were read.
    pub(super) sources: Vec<SourceFacts>,
    /// The values; not in what is stored in pictures and beside tables.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) rows: Option<Vec<PlosRowDocument>>,
    /// Seconds spent; not there either.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) timing_s: Option<TotalTiming>,
    /// What was odd.
    pub(super) warnings: Vec<WarningFacts>,
    /// SHA-256 of the table.
    pub(super) digest: String,
}

/// Seconds spent.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct TotalTiming {
    /// All of it.
    pub(super) total: f64,
}

/// How far the product may be off.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ProductToleranceDocument {
    /// How far P_LoS may be off.
    pub(super) tolerance: f64,
    /// How sure the bound is.
    pub(super) confidence: f64,
    /// How far it is off at most; null without the product.
    pub(super) bound: Option<f64>,
}

/// A city in a file.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct RealCityDocument {
    /// As it was named.
    pub(super) city: String,
    /// UAV positions that were mapped.
    pub(super) positions: usize,
    /// Those inside of a building.
    pub(super) positions_in_buildings: usize,
    /// Positions left out because their disc is cut by the border of the data.
    pub(super) positions_with_cut_discs: usize,
    /// P_LoS at an angle is of users within so many degrees of it.
    pub(super) theta_band_deg: Option<f64>,
    /// Engine of the maps.
    pub(super) engine: String,
    /// Blocks of ground that are resampled.
    pub(super) blocks: usize,
    /// Their edge [m].
    pub(super) block_m: f64,
    /// What a tolerance led to.
    pub(super) tolerance: Option<ToleranceDocument>,
    /// The statistical city that is most like it; null where buildings are not known one by one.
    pub(super) fit: Option<FitDocument>,
}

/// The statistical city that is most like a real one.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct FitDocument {
    /// Share of the ground that is built on.
    pub(super) alpha: f64,
    /// Buildings per km².
    pub(super) beta_per_km2: f64,
    /// Scale of the Rayleigh distribution of heights [m].
    pub(super) gamma_m: f64,
    /// Standard error of that scale [m].
    pub(super) gamma_std_error_m: f64,
    /// Buildings with a height.
    pub(super) buildings: usize,
    /// Largest distance of the two distributions of heights.
    pub(super) kolmogorov_smirnov_distance: f64,
    /// The height at which they are so far apart [m].
    pub(super) farthest_at_m: f64,
}

/// What a tolerance led to over a real city.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ToleranceDocument {
    /// How far P_LoS may be off.
    pub(super) tolerance: f64,
    /// How sure the bound is.
    pub(super) confidence: f64,
    /// The form of the city that was taken.
    pub(super) taken: FormDocument,
    /// Positions from which maps of both were compared.
    pub(super) positions: usize,
    /// The forms that were tried, the coarsest first.
    pub(super) tried: Vec<TriedDocument>,
}

/// A form that was tried.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct TriedDocument {
    #[serde(flatten)]
    pub(super) form: FormDocument,
    /// How far any P_LoS is off at most.
    pub(super) bound: Option<f64>,
    /// Why there is no bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reason: Option<String>,
}

/// What P_LoS is of. Heights are above ground.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct SettingDocument {
    /// The city as it was named.
    pub(super) city: String,
    /// Share of the ground that is built on; estimated for a real city.
    pub(super) alpha: Option<f64>,
    /// Buildings per km²; estimated for a real city.
    pub(super) beta_per_km2: Option<f64>,
    /// Scale of the Rayleigh distribution of heights [m]; estimated for a real city.
    pub(super) gamma_m: Option<f64>,
    /// Method: product, city, geometry, maps, a model by its id, or a curve by its name.
    pub(super) method: String,
    /// Height of the UAV [m].
    pub(super) height_m: f64,
    /// Height of the receivers [m].
    pub(super) rx_height_m: f64,
    /// Elevation angle of the UAV [deg]; none for users at many.
    pub(super) theta_deg: Option<f64>,
    /// Azimuth, 0 across the street [deg]; none for the mean over all.
    pub(super) phi_deg: Option<f64>,
    /// Ground distance of the users [m]; none for users at many.
    pub(super) distance_m: Option<f64>,
    /// Where the UAV hovers; none for models.
    pub(super) placement: Option<&'static str>,
    /// Which users are counted; none for models.
    pub(super) users: Option<&'static str>,
    /// What becomes of UAVs inside of buildings: nlos or excluded; none for models.
    pub(super) uav_in_building: Option<&'static str>,
}

/// P_LoS and how sure it is.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ValuesDocument {
    /// P_LoS.
    pub(super) p_los: Option<f64>,
    /// Lower end of its interval.
    pub(super) ci_low: Option<f64>,
    /// Upper end of its interval.
    pub(super) ci_high: Option<f64>,
    /// Its standard error.
    pub(super) std_error: Option<f64>,
    /// Links behind it.
    pub(super) samples: Option<u64>,
    /// Independent groups of links.
    pub(super) clusters: Option<u64>,
}

/// A value.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct PlosRowDocument {
    #[serde(flatten)]
    pub(super) setting: SettingDocument,
    /// Radius around the UAV that users are within [m].
    pub(super) radius_m: Option<f64>,
    #[serde(flatten)]
    pub(super) values: ValuesDocument,
    /// Why a value or its interval is missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reason: Option<String>,
}

/// A row of the table of P_LoS.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PlosTableRow {
    #[serde(flatten)]
    pub(super) setting: SettingDocument,
    /// P_LoS; empty where there is none.
    pub(super) p_los: Option<f64>,
    /// Lower end of its interval; n/a where an estimate has none, empty for models.
    pub(super) ci_low: Option<NumberOr>,
    /// Upper end of its interval; n/a where an estimate has none, empty for models.
    pub(super) ci_high: Option<NumberOr>,
    /// Standard error of P_LoS; n/a where an estimate has none, empty for models.
    pub(super) std_error: Option<NumberOr>,
    /// Links behind it.
    pub(super) samples: Option<u64>,
    /// Independent groups of links.
    pub(super) clusters: Option<u64>,
    /// Radius around the UAV that users are within [m].
    pub(super) radius_m: Option<f64>,
    /// P_LoS at an angle is of users within so many degrees of it.
    pub(super) theta_band_deg: Option<f64>,
}

/// A number, or the word for its absence.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum NumberOr {
    Number(f64),
    Word(&'static str),
}

/// A method of a study.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub(crate) struct MethodFacts {
    /// Its word.
    pub(crate) id: String,
    /// Its name.
    pub(crate) name: String,
    /// Where it comes from.
    pub(crate) source: String,
    /// Where it is valid, and what it is a function of.
    pub(crate) domain: String,
}
