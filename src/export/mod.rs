//! What is written where: results into files, by extension, all or nothing.
//!
//! Every file is written under a temporary name beside its final one and renamed when all files of the run are complete,
//! so that an error, a full disk or Ctrl-C leaves nothing half written.

mod compare;
mod files;
mod map;
mod table;
mod zones;

pub use compare::{Comparison, add_comparison};
pub use files::{Batch, Format, OutputRules, check_outputs};
pub(crate) use map::with_suffix;
pub use map::{Layer, MapResult, add_map, bare_name, check_layers};
pub use table::encode_table;
pub use zones::add_zones;
