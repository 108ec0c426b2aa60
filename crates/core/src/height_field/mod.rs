//! Solids that a ray can hit: columns over cells, and prisms over footprints, on the integer
//! lattice.
//!
//! [`Columns`] is the closed union T of all columns of a raster, [`Prisms`] the closed union B of
//! all prisms of a vector scene. A [`HeightField`] is either or both, each on its own lattice,
//! together with what receivers stand on. Nothing here decides who sees whom; that is
//! [`crate::los`].

mod build;
mod casters;
mod cell_counts;
mod cell_sets;
mod columns;
mod changed;
mod closing;
mod coarser;
mod curvature;
mod data_area;
mod field;
mod known_ground;
mod merge;
mod part;
mod plateaus;
mod positions;
mod prisms;
mod rings;
mod roof_plane;
mod roof_shape;
mod roofs;
mod seen_heights;
mod solid;
mod tile_maxima;
mod triangulate;

pub use build::Built;
pub use casters::{Caster, CasterBlock, Casters};
pub use cell_counts::CellCounts;
pub use cell_sets::StandsOn;
pub use coarser::Pooling;
pub use columns::Columns;
pub use curvature::{Bulge, Curvature, EARTH_RADIUS_M};
pub use field::{BelowUav, CellKind, CellSets, HeightField};
pub use plateaus::{Plateau, Plateaus};
pub(crate) use positions::cell_frame;
pub use positions::{GridPositions, Place, Station};
pub use prisms::{Buckets, CurvedGround, Piece, Prisms, Top};
pub(crate) use roof_plane::RoofHeight;
pub use roof_plane::{MAX_ROOF_STEPS, RoofPlane};
pub use roof_shape::{roof_triangles, wall_edges};
pub use seen_heights::{Drops, HeightsOf, SeenHeights};
pub use tile_maxima::{TILE, TILE_BITS, TileMaxima};
pub use triangulate::{ConvexPieces, convex_pieces, triangles};

pub use crate::overlay::Ring;
