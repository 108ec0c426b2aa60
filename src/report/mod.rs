//! What is reported: versioned JSON documents, tables, captions.

mod chart;
mod chart_plos;
mod city;
mod compare;
mod documents;
mod features;
mod height_curve;
mod kml;
mod place;
mod plos;
mod polygons;
mod position;
mod repairs;
mod sampled;
mod stability;
mod stress;
mod tolerance;
mod track;
mod zones;

pub use chart::{CHART_SCHEMA, ChartReport, ChartRow, Cost};
pub use chart_plos::{PlosChartReport, PlosChartRow};
pub use city::city_geojson;
pub use compare::{
    CompareReport, GroupDifference, GroupShare, IntervalFacts, MarginFacts, N_GROUPS, Origin, PairFacts,
    PlacementFacts, group_names, signed,
};
pub(crate) use documents::digest_words;
pub use documents::{
    LinkReport, MapReport, MaskDigest, ObstructionReport, RunFacts, SiteFacts, Timing, digest, idle_json, zone_tallies,
};
pub use height_curve::{CurveFacts, CurvePoint, HeightCurveReport, QUANTILES, curve_digest};
pub use kml::{KmlOverlay, kml};
pub use place::{NO_RECEIVER, PlaceFacts, PlaceReport, PlaceValue, SeveralFacts, place_digest};
pub use plos::{MethodFacts, PlosReport, PlosRow, PlosToleranceFacts, PlosTried, PlosValue, RealCityFacts};
pub use position::Position;
pub use repairs::{repairs_geojson, repairs_table};
pub use sampled::{SampledReport, SampledRow};
pub use stability::StabilityFacts;
pub use stress::{NEAR_M, StressReport, StressSceneReport};
pub use tolerance::ToleranceFacts;
pub use track::TrackReport;
pub use zones::zones_geojson;
