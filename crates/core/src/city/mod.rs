//! Scenes, read and checked once: a surface model, footprints with heights, or a generated city.
//!
//! A [`City`] holds plain data on a georeferenced grid of receivers. Positions of footprints and
//! all heights are already on the lattice ([`crate::quantity`]). [`crate::height_field`] builds
//! from it everything a ray can hit.

mod antenna;
mod area;
mod built_up;
mod faults;
mod footprint;
mod generated;
mod height_sources;
mod scene;
mod site;
mod up_time;
mod windowed;

pub use antenna::{Antenna, AntennaFault};
pub use area::Area;
pub use built_up::{BuildingHeights, BuiltUp};
pub use faults::{FootprintFault, FootprintFaults, LEFT_OUT};
pub use footprint::{BuildingHeight, Footprint, RoofTriangle};
pub use generated::BuiltUpCity;
pub use height_sources::{HeightSource, HeightSources, SourceShare};
pub use scene::{City, DataArea, Ground, NodataAs, Solids, Source};
pub use site::{GivenSite, Site};
pub use up_time::{Clock, UpTime};
pub use windowed::{STRIP_ROWS, WindowedBase, WindowedSolids, strips};
