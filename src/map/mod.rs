//! Coverage maps: requests, plans, maps in memory, and the files that they are written to.

mod class_pictures;
mod coverages;
mod curve;
mod curve_report;
mod drawing;
mod files;
mod job;
mod kml;
mod needs;
mod over_time;
mod plan;
mod raster_files;
mod report;
mod request;
mod run;
mod save_checks;
mod saving;
mod stability_report;
mod strips;
mod table;
mod tiles;
mod tolerance;
mod unit_runs;
mod units;

pub use coverages::{Coverage, Coverages};
pub(crate) use curve_report::{CurveRow, HeightCurveDocument};
pub(crate) use drawing::MapDrawing;
pub(crate) use job::{Done, Given, GivenScene, MapJob, names_tile};
pub(crate) use over_time::{OverTimeDocument, TimeRow};
pub(crate) use plan::{Held, MapPlan, PartOf, Prepared};
pub(crate) use raster_files::{add_raster, style_of};
pub use report::SiteFacts;
pub(crate) use report::{AnyMapDocument, IdleDocument, MapDocument, MapReport, MaskDigest};
pub use request::CoverageRequest;
pub(crate) use table::MapRow;
pub(crate) use tolerance::{FormDocument, check_tolerance};
pub(crate) use unit_runs::{Outcome, Purpose, UnitRuns, Units};
pub(crate) use units::{Found, Part, SITE, Unit};

use crate::export::Format;

/// Formats of the files of a map.
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
