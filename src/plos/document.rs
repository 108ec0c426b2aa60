//! Serialized forms of a P_LoS study: the document `skyshed/plos/1` and the row of its table.

use schemars::JsonSchema;
use serde::Serialize;

use crate::answer::{CommandFacts, SourceFacts, WarningFacts};
use crate::map::FormDocument;

/// P_LoS by every method.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PlosDocument<'a> {
    /// Kind of document and its version.
    pub(super) schema: &'static str,
    /// Version of the program.
    pub(super) version: &'static str,
    #[serde(flatten)]
    pub(super) command: &'a CommandFacts,
    /// Seed of everything random.
    pub(super) seed: u64,
    /// Confidence of the intervals.
    pub(super) confidence: f64,
    /// Methods of the study.
    pub(super) methods: &'a [MethodFacts],
    /// Result of a tolerance, where one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) tolerance: Option<ProductToleranceDocument>,
    /// Cities in files.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) real_cities: Vec<RealCityDocument>,
    /// Files that were read.
    pub(super) sources: Vec<SourceFacts>,
    /// The values; absent in the copies that pictures and tables store.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) rows: Option<Vec<PlosRowDocument>>,
    /// Seconds spent; absent in the copies that pictures and tables store.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) timing_s: Option<TotalTiming>,
    /// Warnings.
    pub(super) warnings: Vec<WarningFacts>,
    /// SHA-256 of the table.
    pub(super) digest: String,
}

/// Seconds spent.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct TotalTiming {
    /// Whole run.
    pub(super) total: f64,
}

/// Tolerance of the product, and its bound.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ProductToleranceDocument {
    /// Largest allowed error of P_LoS.
    pub(super) tolerance: f64,
    /// Confidence of the bound.
    pub(super) confidence: f64,
    /// Largest error of any value of the product; null without the product.
    pub(super) bound: Option<f64>,
}

/// A city in a file.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct RealCityDocument {
    /// Path as the user wrote it.
    pub(super) city: String,
    /// UAV positions that were mapped.
    pub(super) positions: usize,
    /// Positions inside a building.
    pub(super) positions_in_buildings: usize,
    /// Positions left out because the border of the data cuts their disc.
    pub(super) positions_with_cut_discs: usize,
    /// Half-width of the band of elevation angles around θ whose users count [deg].
    pub(super) theta_band_deg: Option<f64>,
    /// Engine of the maps.
    pub(super) engine: String,
    /// Blocks of ground that are resampled.
    pub(super) blocks: usize,
    /// Edge of a block [m].
    pub(super) block_m: f64,
    /// Result of a tolerance.
    pub(super) tolerance: Option<ToleranceDocument>,
    /// Statistical city most like this one; null where single buildings are not known.
    pub(super) fit: Option<FitDocument>,
}

/// Statistical city most like a real one.
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
    /// Height at which that distance occurs [m].
    pub(super) farthest_at_m: f64,
}

/// Result of a tolerance over a real city.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ToleranceDocument {
    /// Largest allowed error of P_LoS.
    pub(super) tolerance: f64,
    /// Confidence of the bound.
    pub(super) confidence: f64,
    /// Form of the city that was mapped.
    pub(super) taken: FormDocument,
    /// Positions from which maps of both forms were compared.
    pub(super) positions: usize,
    /// Forms that were tried, the coarsest first.
    pub(super) tried: Vec<TriedDocument>,
}

/// A form that was tried.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct TriedDocument {
    #[serde(flatten)]
    pub(super) form: FormDocument,
    /// Largest error of any P_LoS.
    pub(super) bound: Option<f64>,
    /// Reason for having no bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reason: Option<String>,
}

/// Setting of a value of P_LoS. Heights are above ground.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct SettingDocument {
    /// City as the user wrote it.
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
    /// Elevation angle of the UAV [deg]; none if the users have several.
    pub(super) theta_deg: Option<f64>,
    /// Azimuth, 0 across the street [deg]; none for the mean over all.
    pub(super) phi_deg: Option<f64>,
    /// Ground distance of the users [m]; none if the users have several.
    pub(super) distance_m: Option<f64>,
    /// Place of the UAV; none for models.
    pub(super) placement: Option<&'static str>,
    /// Users that count; none for models.
    pub(super) users: Option<&'static str>,
    /// Treatment of UAVs inside buildings: nlos or excluded; none for models.
    pub(super) uav_in_building: Option<&'static str>,
}

/// P_LoS and its uncertainty.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct ValuesDocument {
    /// P_LoS.
    pub(super) p_los: Option<f64>,
    /// Lower end of the interval of P_LoS.
    pub(super) ci_low: Option<f64>,
    /// Upper end of the interval of P_LoS.
    pub(super) ci_high: Option<f64>,
    /// Standard error of P_LoS.
    pub(super) std_error: Option<f64>,
    /// Links behind P_LoS.
    pub(super) samples: Option<u64>,
    /// Independent groups of links.
    pub(super) clusters: Option<u64>,
}

/// A value of P_LoS.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct PlosRowDocument {
    #[serde(flatten)]
    pub(super) setting: SettingDocument,
    /// Radius around the UAV that users are within [m].
    pub(super) radius_m: Option<f64>,
    #[serde(flatten)]
    pub(super) values: ValuesDocument,
    /// Reason for a missing value or interval.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reason: Option<String>,
}

/// A row of the table of P_LoS.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PlosTableRow {
    #[serde(flatten)]
    pub(super) setting: SettingDocument,
    /// P_LoS; empty for a missing value.
    pub(super) p_los: Option<f64>,
    /// Lower end of the interval of P_LoS; n/a for an estimate without one, empty for models.
    pub(super) ci_low: Option<NumberOr>,
    /// Upper end of the interval of P_LoS; n/a for an estimate without one, empty for models.
    pub(super) ci_high: Option<NumberOr>,
    /// Standard error of P_LoS; n/a for an estimate without one, empty for models.
    pub(super) std_error: Option<NumberOr>,
    /// Links behind P_LoS.
    pub(super) samples: Option<u64>,
    /// Independent groups of links.
    pub(super) clusters: Option<u64>,
    /// Radius around the UAV that users are within [m].
    pub(super) radius_m: Option<f64>,
    /// Half-width of the band of elevation angles around θ whose users count [deg].
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
    /// Word for the method.
    pub(crate) id: String,
    /// Name of the method.
    pub(crate) name: String,
    /// Source of the method.
    pub(crate) source: String,
    /// Range of validity, and the quantities that the method depends on.
    pub(crate) domain: String,
}
