//! Scenes and what belongs to them, read from files and checked once.

mod area;
mod box_index;
mod building;
mod faults;
mod file_heights;
mod footprint_options;
mod footprints;
mod ground_of_bases;
mod height_value;
mod heights;
mod held;
mod lattice_footprints;
mod lattice_polygon;
mod mesh;
mod not_there;
mod moment;
mod outline;
mod parts;
mod path;
#[cfg(feature = "point-clouds")]
mod point_cloud;
#[cfg(not(feature = "point-clouds"))]
#[path = "no_point_cloud.rs"]
mod point_cloud;
mod polygon;
mod projection;
mod receivers_grid;
mod repairs;
mod reprojected;
mod roof;
mod scene_files;
mod sites;
mod solid;
mod source;
mod streamed;
mod surface;
mod systems;
mod table;
mod terrain;
mod triangulated_heights;
mod vector;
mod vertical;

pub use area::read_area;
pub use file_heights::METERS_PER_LEVEL;
pub use footprint_options::FootprintOptions;
pub use footprints::{read_footprints, read_footprints_and_repairs};
pub use held::{HeldBuilding, HeldHeights, footprints_of, surface_of};
pub use lattice_polygon::{Region, region_of};
pub use mesh::{MeshOptions, read_mesh, read_mesh_buildings};
pub use moment::{moment_words, up_time};
pub use path::{Path, Paths, Vertex, VertexHeight, is_path_file, read_paths, read_track};
pub use point_cloud::{PointCloudOptions, read_point_cloud};
pub use projection::Projection;
pub use repairs::Repair;
pub use scene_files::{SceneFiles, named_files};
pub use sites::read_sites;
pub use source::{read_text, source_of};
pub use streamed::StreamedSurface;
pub use surface::{SurfaceOptions, read_surface, surface_grid};
pub use systems::refuse_two_crs;
pub use table::{BadRows, BadRowsTold, Row, RowFault, Table, readable};
pub use vertical::{SystemSaid, compare_vertical, vertical_of};
