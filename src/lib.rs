//! Exact line-of-sight coverage maps: what a hovering UAV can see of a city, cell by cell.
//!
//! A [`Scene`] is a city that was opened or generated. Asked what a [`Uav`] sees, it answers with a [`Coverage`]; of
//! several,
//! with [`Coverages`]. Each answer has its numbers, says what was odd, and saves itself by the extension of a file.
//!
//! ```
//! use skyshed::prelude::*;
//!
//! let city = Scene::options().size(300.0).open("itu:urban")?;
//! let seen = city.coverage(Uav::new(150.0, 150.0, Height::agl(120.0))).radius(100.0).run()?;
//! println!("{:.4} of {} receivers", seen.p_los().unwrap_or(f64::NAN), seen.receivers());
//!
//! // Inside a building nothing can hover: the error says what is there and what to ask instead.
//! assert!(city.coverage(Uav::new(30.0, 30.0, Height::agl(1.0))).run().is_err());
//! # Ok::<(), skyshed::Error>(())
//! ```
//!
//! Names that end in `_m` are in meters, positions in units of the scene's reference system, heights as [`Height`]
//! says. What line of sight means is
//! written in `skyshed_core::los`.
//!
//! The crates below hold what only experts need: `skyshed_core` the engines, `skyshed_study` P_LoS, placement and accuracy,
//! `skyshed_io` formats and readers, `skyshed_render` pictures. Types of options that are not found here stand there.

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

/// The README's code is tested like any other.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
