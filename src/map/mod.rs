//! Coverage maps: what is asked, the map, and the files it is written to.

mod classes;
mod coverages;
mod curve;
mod drawing;
mod expected;
mod files;
mod job;
mod plan;
mod receivers;
mod request;
mod save;
mod sites;
mod strips;
mod tolerance;

pub use coverages::{Coverage, Coverages};
pub(crate) use curve::CurvePlan;
pub(crate) use drawing::{MapDrawing, height_words};
pub(crate) use expected::Expected;
pub(crate) use files::table as file_table;
pub(crate) use job::{Done, Given, MapJob};
pub(crate) use plan::{Held, MapPlan, checked_radius, receiver_height};
pub use receivers::Receivers;
pub(crate) use receivers::{Asked, cell_names, check_receivers, setting_line};
pub use request::CoverageRequest;
pub use save::{PolygonClasses, SaveOptions};
pub(crate) use sites::{Outcome, SITE, SiteRuns};
pub(crate) use tolerance::check_tolerance;

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
