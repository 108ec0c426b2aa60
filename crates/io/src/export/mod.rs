//! Outputs: results written into files by extension, all or nothing.
//!
//! Every file is written under a temporary name beside its final one. All are renamed when every
//! file of the run is complete, so that an error, a full disk or Ctrl-C leaves nothing half
//! written.

mod batch;
mod city_mesh;
mod compare;
mod files;
mod flatgeobuf;
mod format;
mod kmz;
mod map;
mod map_arrays;
mod map_result;
mod mask_strips;
mod mitsuba;
mod ns3_boxes;
#[cfg(not(feature = "parquet"))]
#[path = "no_parquet.rs"]
mod parquet;
#[cfg(feature = "parquet")]
mod parquet;
mod columns;
mod seal;
mod single_band;
mod table;
mod temporary;
mod vrt;
mod whole;
mod zones;

pub use self::flatgeobuf::{PolygonFile, add_flatgeobuf};
pub use batch::Batch;
pub use city_mesh::{CityMesh, Mesh, city_mesh};
pub use columns::Column;
pub use compare::{Comparison, add_comparison};
pub use files::{OutputRules, check_folder, check_outputs, place_of, sidecars, with_suffix};
pub use format::Format;
pub use kmz::encode_kmz;
pub use map::{add_map, add_mask_geotiff, bare_name, check_layers, site_in_names};
pub use map_result::{MapResult, MaskValues, n_bands};
pub use mask_strips::MaskStrips;
pub use mitsuba::{MitsubaScene, add_mitsuba};
pub use ns3_boxes::ns3_boxes;
pub use parquet::encode_parquet;
pub use seal::is_unchanged;
pub use table::{as_text, encode_table};
pub use temporary::abandon_files;
pub use vrt::{MosaicTile, Near, vrt};
pub use whole::{Left, left_of};
pub use zones::add_zones;
