//! Exact line-of-sight coverage maps: what a hovering UAV can see of a city, cell by cell.
//!
//! Data flows one way through the modules, in this order: a **raster** or other file becomes a **scene**; a scene
//! becomes a **height field**, what a ray can hit, on an integer lattice; **los** decides who sees whom, exactly; **zones**
//! tells streets, crossroads, courtyards and rooftops apart; **coverage** makes maps; **los_probability** says how likely
//! line of sight is; **placement** finds where to hover; **accuracy** tells what a method costs and errs; **render**,
//! **export** and **report** turn all that into pictures, files and documents; **cli** is the program.
//!
//! What line of sight means is written once, in [`los`].
//!
//! # Examples
//!
//! ```
//! use skyshed::coverage::{Control, MapOptions, Uav, map_site};
//! use skyshed::height_field::HeightField;
//! use skyshed::quantity::Height;
//! use skyshed::scene::{BuiltUp, BuiltUpCity, Site};
//!
//! // 300 m of the ITU urban environment, on a grid of 1 m cells.
//! let built_up = BuiltUp::new(0.3, 500.0, 15.0)?;
//! let scene = BuiltUpCity { built_up, size_m: 300.0, margin_m: 0.0, cell_m: 1.0, seed: 1, ground_m: 0.0 }.scene()?;
//! let field = HeightField::build(&scene.grid, scene.solids, &mut Vec::new());
//!
//! // A UAV 100 m above the crossroad in the south-west.
//! let site = Site { id: "1".into(), x: 10.0, y: 10.0, height: Height::AboveGround(100.0) };
//! let uav = Uav::place(&site, &field, None)?;
//! let map = map_site(&field, &uav, &MapOptions::default(), &Control::default())?;
//! let p_los = map.tally.p_los().expect("there are streets in range");
//! assert!(p_los > 0.3 && p_los < 0.9);
//!
//! // Inside a building nothing can hover: the error says what is there and what to ask instead.
//! let inside = Site { id: "2".into(), x: 30.0, y: 30.0, height: Height::AboveGround(1.0) };
//! assert!(Uav::place(&inside, &field, None).is_err());
//! # Ok::<(), skyshed::Error>(())
//! ```

pub mod report;

pub mod cli;

pub use skyshed_core::{Error, ErrorClass, Result, Warning};
pub use skyshed_core::{coverage, error, height_field, los, outlines, overlay, quantity, raster, scene, zones};
pub use skyshed_io::{crs, export, formats, read};
pub use skyshed_render as render;
pub use skyshed_study::{accuracy, los_probability, placement};

use skyshed_io::digest;

/// The README's code is tested like any other.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
