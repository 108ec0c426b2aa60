//! Coverage maps: what is asked, the map, and the files it is written to.

mod classes;
mod coverages;
mod curve;
mod curve_report;
mod drawing;
mod files;
mod job;
mod kml;
mod plan;
mod report;
mod request;
mod run;
mod save_options;
mod saving;
mod sites;
mod stability;
mod strips;
mod tolerance;

pub use coverages::{Coverage, Coverages};
pub(crate) use curve::CurvePlan;
pub(crate) use curve_report::{CurveRow, HeightCurveDocument};
pub(crate) use drawing::MapDrawing;
pub(crate) use job::{Done, Given, GivenScene, MapJob};
pub(crate) use plan::{Held, MapPlan, Prepared};
pub use report::SiteFacts;
pub(crate) use report::{AnyMapDocument, IdleDocument, MapDocument, MapReport, MapRow, MaskDigest};
pub use request::CoverageRequest;
pub use save_options::{PolygonClasses, SaveOptions};
pub(crate) use sites::{Outcome, SITE, SiteRuns};
pub(crate) use tolerance::{FormDocument, check_tolerance};

use crate::export::Format;

/// Formats that a map can be written in.
pub(crate) const FORMATS: [Format; 14] = [
    Format::Png,
    Format::Svg,
    Format::Pdf,
    Format::GeoTiff,
    Format::Exr,
    Format::AsciiGrid,
    Format::Bil,
    Format::Npz,
    Format::Kmz,
    Format::Csv,
    Format::Json,
    Format::GeoJson,
    Format::FlatGeobuf,
    Format::Stdout,
];
