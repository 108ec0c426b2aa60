//! Files in and out: formats of rasters, reference systems, readers of scenes, and writers of
//! results.

pub mod crs;
pub mod digest;
pub mod error;
pub mod export;
mod format;
pub mod formats;
mod guard;
mod input;
mod packed;
pub mod read;
mod remote;

pub use error::{Error, Result, Warning};
pub use format::{Conversion, FileFormat, FileKind, ForeignFormat};
pub use input::{Input, cannot_read};
pub use remote::{identity, is_remote, told};

use skyshed_core::{city, coverage, height_field, outlines, overlay, quantity, raster, zones};
