//! Exact line-of-sight coverage maps: the part of a city that a hovering UAV sees, cell by cell.
//!
//! A [`Scene`] is a city: a surface model, footprints with heights, a mesh, or a generated city. A
//! [`Uav`] hovers over it. A map has an answer for every cell: line of sight, no line of sight, no
//! receiver, out of range, or no data. The answers are those of exact arithmetic on the heights of
//! the scene, whatever the engine, the machine and the number of threads.
//!
//! ```
//! use skyshed::prelude::*;
//!
//! let city = Scene::options().size(300.0).open("itu:urban")?;
//! let seen = city.coverage(Uav::new(150.0, 150.0, Height::agl(120.0))).radius(100.0).run()?;
//! println!("{:.4} of {} receivers", seen.p_los().unwrap_or(f64::NAN), seen.receivers());
//! # Ok::<(), skyshed::Error>(())
//! ```
//!
//! It is no radio model: it has no path loss, diffraction or reflection. It is geometry that such
//! models need: who is in line of sight, by how many meters, and with what probability.
//!
//! # A tour
//!
//! | question | call | answer |
//! |---|---|---|
//! | coverage of one UAV, of many | [`Scene::coverage`], [`Scene::coverages`] | [`Coverage`], [`Coverages`] |
//! | one link, and its obstacle | [`Scene::link`] | [`Link`] |
//! | a user's way below a UAV | [`Scene::track`] | [`Report`] |
//! | the best places to hover | [`Scene::placements`] | [`Placements`] |
//! | P_LoS of whole cities | [`PLos::of`] | [`PLos`] |
//! | P_LoS by zone of the placement | [`Scene::sample`] | [`Report`] |
//! | placements side by side | [`Scene::compare`] | [`Report`] |
//! | limits of a map | [`Scene::limits`] | [`Report`] |
//! | streets, crossroads, rooftops | [`Scene::zone_report`] | [`Report`] |
//! | facts of a file | [`SceneReader::info`] | [`Report`] |
//! | the city as files | [`Scene::city_report`] | [`Report`] |
//! | a live page | [`Scene::live_page`] | HTML |
//! | maps in units of work | [`Job`] | files |
//!
//! Options are the flags of the program: `--rx-height 2` is `.rx_height(2)`. The traits of the
//! [`prelude`] set them on every request that has them; [`request`] has all types of options, and
//! [`request::defaults`] their defaults. Every answer has a document (JSON, with schemas in `docs/schema`
//! of the repository), its warnings, and `save`, which writes the format of a file's extension.
//!
//! Names that end in `_m` are in meters. Positions are in units of the scene's reference system.
//! Heights of UAVs are above the ground, a roof or the datum: [`Height`]. Rasters have the shape
//! `[n_rows, n_cols]`, row 0 in the north, columns running fastest.
//!
//! # Recipes
//!
//! Open a city with options:
//!
//! ```no_run
//! use skyshed::prelude::*;
//! use skyshed::GroundChoice;
//!
//! let buildings = Scene::options().height_field("hgt").ground(GroundChoice::Flat(0.0)).open("buildings.geojson")?;
//! let raster = Scene::options().terrain("dtm.tif").extent([0.0, 0.0, 500.0, 500.0]).open("dsm.tif")?;
//! # Ok::<(), skyshed::Error>(())
//! ```
//!
//! Count what three UAVs see together:
//!
//! ```
//! # use skyshed::prelude::*;
//! # let city = Scene::options().size(200.0).open("itu:urban")?;
//! let uavs = [40.0, 100.0, 160.0].map(|x| Uav::new(x, 100.0, Height::agl(80.0)));
//! let seen = city.coverages(uavs).run()?;
//! let by_two = seen.count().iter().filter(|n| **n >= 2).count();
//! # assert!(by_two > 0);
//! # Ok::<(), skyshed::Error>(())
//! ```
//!
//! Save a map as a picture and as a GeoTIFF:
//!
//! ```no_run
//! # use skyshed::prelude::*;
//! # let seen = Scene::open("itu:urban")?.coverage(Uav::new(9.0, 9.0, Height::agl(80.0))).run()?;
//! seen.save("coverage.tif")?;
//! seen.save_with("coverage.png", &SaveOptions::default().title("North tower").overwrite(true))?;
//! # Ok::<(), skyshed::Error>(())
//! ```
//!
//! Margins in meters, and the least height of a receiver:
//!
//! ```
//! # use skyshed::prelude::*;
//! # let city = Scene::options().size(100.0).open("itu:urban")?;
//! let map = city.coverage(Uav::new(50.0, 50.0, Height::agl(80.0))).layers([Layer::Margin]).run()?;
//! let margins = map.layer(Layer::Margin).expect("the layer that was requested");
//! # assert_eq!(margins.len(), map.mask().len());
//! # Ok::<(), skyshed::Error>(())
//! ```
//!
//! Explain one link:
//!
//! ```
//! # use skyshed::prelude::*;
//! # let city = Scene::options().size(200.0).open("itu:urban")?;
//! let link = city.link(Uav::new(150.0, 100.0, Height::agl(60.0)), (30.0, 9.0), Height::agl(1.5))?;
//! match link.obstruction() {
//!     Some(obstacle) => println!("blocked at ({:.1}, {:.1})", obstacle.x, obstacle.y),
//!     None => println!("a receiver {:.1} m lower would do", link.margin_m().unwrap_or(f64::INFINITY)),
//! }
//! # Ok::<(), skyshed::Error>(())
//! ```
//!
//! Find the best place for streets; `.goal("p_los(area)".parse()?)` with `.area("area.geojson")` counts a polygon's:
//!
//! ```
//! # use skyshed::prelude::*;
//! # let city = Scene::options().size(150.0).open("itu:urban")?;
//! let streets: Goal = "p_los(street)".parse().expect("a goal");
//! let found = city.placements([Height::agl(80.0)]).step(50.0).goal(streets).run()?;
//! println!("{:?}, refined {:?}", found.best(), found.refined());
//! # Ok::<(), skyshed::Error>(())
//! ```
//!
//! Compare two placements: a negative difference is a second one that sees less.
//!
//! ```
//! # use skyshed::prelude::*;
//! # let city = Scene::options().size(200.0).open("itu:urban")?;
//! let uavs = [40.0, 160.0].map(|x| Uav::new(x, 100.0, Height::agl(80.0)));
//! let compared = city.compare(uavs).block(40.0).run()?.document();
//! println!("{}", compared["verdict"]);
//! println!("{} to {}", compared["pairs"][0]["ci_low"], compared["pairs"][0]["ci_high"]);
//! # assert!(compared["pairs"][0]["difference"].is_f64());
//! # Ok::<(), skyshed::Error>(())
//! ```
//!
//! P_LoS against the elevation angle:
//!
//! ```
//! # use skyshed::prelude::*;
//! use skyshed::PLos;
//!
//! let curve = PLos::of("itu:urban").height([100.0]).theta([20.0, 45.0, 70.0]).run()?;
//! let values: Vec<Option<f64>> = curve.values().map(|value| value.p_los).collect();
//! # assert_eq!(values.len(), 3);
//! # Ok::<(), skyshed::Error>(())
//! ```
//!
//! Uncertain heights: an interval of P_LoS.
//!
//! ```
//! # use skyshed::prelude::*;
//! # let city = Scene::options().size(100.0).open("itu:urban")?;
//! let map = city.coverage(Uav::new(50.0, 50.0, Height::agl(80.0))).height_error(2.0).run()?;
//! println!("{}", map.document()["sites"][0]["p_los_interval"]);
//! # Ok::<(), skyshed::Error>(())
//! ```
//!
//! Show progress, and stop from another thread: see [`Progress`].
//!
//! Read a question from JSON, where members have the names of options:
//!
//! ```
//! # use skyshed::prelude::*;
//! # let city = Scene::options().size(100.0).open("itu:urban")?;
//! use skyshed::CoverageQuestion;
//!
//! let question: CoverageQuestion = serde_json::from_str(r#"{"radius": 40, "layers": ["los", "margin"]}"#).expect("JSON");
//! let map = city.coverage(Uav::new(50.0, 50.0, Height::agl(80.0))).question(question).run()?;
//! # assert!(map.layer(Layer::Margin).is_some());
//! # Ok::<(), skyshed::Error>(())
//! ```
//!
//! # Errors
//!
//! Every fallible function returns [`Error`]: a [kind](Error::kind), a stable [code](Error::code), and
//! one line of text. Findings that do not stop the work are [`Warning`]s of the answer.
//!
//! ```
//! # use skyshed::prelude::*;
//! # let city = Scene::options().size(300.0).open("itu:urban")?;
//! use skyshed::ErrorKind;
//!
//! // Nothing can hover inside a building.
//! let error = city.coverage(Uav::new(30.0, 30.0, Height::agl(1.0))).run().expect_err("inside");
//! assert_eq!(error.kind(), ErrorKind::Site);
//! # Ok::<(), skyshed::Error>(())
//! ```
//!
//! # Features
//!
//! | feature | default | adds |
//! |---|---|---|
//! | `cli` | yes | the program, and the doors of the Python package |
//! | `geopackage` | yes | GeoPackages, read by SQLite, which is C |
//! | `parquet` | yes | tables in columns (.parquet) |
//! | `exr` | yes | rasters in OpenEXR (.exr) |
//! | `meshes` | yes | meshes in PLY |
//! | `shapefiles` | yes | footprints in Shapefiles |
//! | `remote` | no | scenes at addresses: `http://`, `https://`, `s3://` |
//!
//! The crates below hold types for experts: `skyshed_core` the engines, `skyshed_study` P_LoS,
//! placement and accuracy, `skyshed_io` formats and readers, `skyshed_render` pictures.

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
mod earth;
mod error;
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
mod report;
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

pub use error::{Error, ErrorKind, Result, Warning};
pub use jobs::{Job, JobCounts, PlannedUnit};
pub use link::{Link, LinkArray, LinkObstruction};
pub use map::{Coverage, CoverageRequest, Coverages, SiteFacts};
pub use placements::{Placements, PlacementsRequest};
pub use plos::{PLos, PLosRequest, PLosValue};
pub use progress::Progress;
pub use report::{Report, ReportRequest, Track};
pub use scene::{Scene, SceneReader};
pub use skyshed_core::city::{Antenna, AntennaFault, Clock, UpTime};
pub use skyshed_core::coverage::Tally;
pub use skyshed_core::coverage::class;
pub use skyshed_core::los::{MethodChoice, StepLength};
pub use skyshed_core::quantity::Height;
pub use skyshed_core::raster::{Crs, GeoRef};
pub use skyshed_core::zones::{Zone, ZoneMap};
pub use skyshed_io::read::{HeldBuilding, HeldHeights};
pub use skyshed_request as request;
pub use skyshed_request::{
    BaseRule, CompareOptions, CoverageQuestion, DataAreaChoice, Goal, GroundChoice, HeightErrors, HeightUnit, Layer,
    LimitsOptions, MapRequest, MissingHeights, Parts, PictureOptions, Placement, PolygonClasses, Receivers, Roofs,
    SampleOptions, SaveOptions, SceneOptions, Sight, Source, TiffLayout, TrackOptions, Users, Writing, ZoneCount,
};
pub use uav::Uav;

use skyshed_core::{city, coverage, height_field, los, quantity, raster, zones};
use skyshed_io::{crs, digest, export, formats, read};
use skyshed_render as render;
use skyshed_study::{accuracy, city_statistics, los_probability, placement};

/// Names that most programs need: types of questions, and the setters of their options.
pub mod prelude {
    pub use crate::{Antenna, Goal, Height, Layer, Progress, Receivers, SaveOptions, Scene, Uav};
    pub use skyshed_request::{
        SetAntenna, SetCandidateOptions, SetCompareOptions, SetEarth, SetFiles, SetGoalOptions, SetHeightCurve,
        SetHeightErrors, SetLimitsOptions, SetMapForms, SetMapMemory, SetMapOptions, SetMapUnits, SetOverTime,
        SetPictureOptions, SetPlosEffort, SetPlosOptions, SetRange, SetReceiver, SetSampleOptions, SetSceneOptions,
        SetSceneWord, SetSweepOptions, SetTrackOptions, SetUavs, SetWriting,
    };
}

/// Tests of the code in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
