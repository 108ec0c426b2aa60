//! Exact line-of-sight coverage maps: the part of a city that a hovering UAV sees, cell by cell.
//!
//! A [`Scene`] is a city that was opened or generated. The question what a [`Uav`] sees gives a
//! [`Coverage`], for several UAVs [`Coverages`]. Each answer holds its numbers and its warnings,
//! and saves itself in the format of a file's extension.
//!
//! ```
//! use skyshed::prelude::*;
//!
//! let city = Scene::options().size(300.0).open("itu:urban")?;
//! let seen = city.coverage(Uav::new(150.0, 150.0, Height::agl(120.0))).radius(100.0).run()?;
//! println!("{:.4} of {} receivers", seen.p_los().unwrap_or(f64::NAN), seen.receivers());
//!
//! Nothing can hover inside a building: the error holds the heights of the UAV and the roof.
//! assert!(city.coverage(Uav::new(30.0, 30.0, Height::agl(1.0))).run().is_err());
//! # Ok::<(), skyshed::Error>(())
//! ```
//!
//! Names that end in `_m` are in meters. Positions are in units of the scene's reference system. A
//! [`Height`] names its reference. `skyshed_core::los` defines line of sight.
//!
//! The crates below hold types for experts: `skyshed_core` the engines, `skyshed_study` P_LoS,
//! placement and accuracy, `skyshed_io` formats and readers, `skyshed_render` pictures. They also
//! hold types of options that this crate does not export.

#![cfg_attr(
    not(feature = "cli"),
    allow(dead_code, unused_imports, reason = "some questions are asked by the program alone")
)]

mod answer;
mod chart;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
mod comparison;
mod conversion;
pub mod error;
mod expected;
mod height_errors;
mod jobs;
mod limits;
mod link;
mod live;
mod map;
mod memory;
mod method_looks;
mod os_words;
mod picture;
mod placements;
mod plos;
mod progress;
mod repairs;
mod sample;
mod scene;
pub mod schemas;
mod sight;
mod stress;
mod survey;
mod threads;
mod track;
mod uav;
mod words;
mod zone_files;

pub use error::{Error, ErrorClass, Result, Warning};
pub use link::{Link, LinkObstruction};
pub use map::{Coverage, CoverageRequest, Coverages, SiteFacts};
pub use placements::{Placements, PlacementsRequest};
pub use plos::{PLos, PLosRequest, PLosValue};
pub use progress::Progress;
pub use scene::{Scene, SceneReader};
pub use skyshed_core::city::{Antenna, AntennaFault};
pub use skyshed_core::coverage::class;
pub use skyshed_core::los::MethodChoice;
pub use skyshed_core::quantity::Height;
pub use skyshed_request::{
    BaseRule, DataAreaChoice, GroundChoice, HeightErrors, HeightUnit, Layer, MissingHeights, Parts, Placement,
    PolygonClasses, Receivers, Roofs, SaveOptions, SceneOptions, Sight, Source, TiffLayout, Users,
};
pub use uav::Uav;

use skyshed_core::{city, coverage, height_field, los, quantity, raster, zones};
use skyshed_io::{crs, digest, export, formats, read};
use skyshed_render as render;
use skyshed_study::{accuracy, city_statistics, los_probability, placement};

/// Names that most programs need: types of questions, and the setters of their options.
pub mod prelude {
    pub use crate::{Antenna, Height, Layer, Progress, Receivers, Scene, Uav};
    pub use skyshed_request::{
        SetAntenna, SetCandidateOptions, SetEarth, SetGoalOptions, SetHeightErrors, SetMapForms, SetMapOptions,
        SetPictureOptions, SetRange, SetReceiver, SetSceneOptions, SetWriting,
    };
}

/// Tests of the code in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
