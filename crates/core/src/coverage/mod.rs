//! Coverage maps: for every cell of a grid, what one UAV sees of the receiver there.
//!
//! The result of a map is a mask of [`class`]es, a tally of them and, on request, layers of
//! heights. Results do not depend on the number of threads: every cell is decided alone and all
//! sums are integer counts.

mod bearings;
mod cell_classes;
mod cell_heights;
pub mod class;
mod elevation;
mod explained_link;
mod height_curve;
mod height_limits;
mod idle;
mod many;
mod map;
mod margin_stats;
mod options;
mod pairs;
mod polygons;
mod place_sums;
mod range;
mod output_rows;
mod overlay;
mod sight_numbers;
mod stability;
mod streamed;
mod tally;
mod times;
mod track;
mod uav;
mod uav_grid;
mod uncertain_heights;
mod view;

pub use crate::los::{HeightErrors, OwnErrors};
pub use cell_heights::surface_under;
pub use explained_link::{ExplainedLink, LinkObstacle, ObstacleKind, ProfileStep, StepKind, place_receiver};
pub use height_curve::{HeightCurve, LeastHeights};
pub use idle::IdleFootprints;
pub use many::{KeepMasks, ManyMaps, maps_at_once};
pub use map::{Seen, SiteCoverage, map_site};
pub use margin_stats::{GRAZING_M, MarginSample, MarginStats, WorstReceiver};
pub use options::{Control, HeightLayers, MapOptions, Receivers};
pub use overlay::{Overlay, Together};
pub use pairs::{CellGroups, MOST_SETS, PairCounts, count_pairs, count_sets, difference_layer};
pub use polygons::{CoveragePolygon, PolygonOptions, coverage_polygons};
pub use range::any_in_range;
pub use sight_numbers::{CheckedNumbers, NumberFault, SightNumbers, check_height_error, check_radius, receiver_height};
pub use stability::{Move, Stability, Turned};
pub use streamed::StreamedMapper;
pub use tally::{BAND_DEGREES, ElevationBand, Tally};
pub use times::{TimeCount, TimeSpan, Times};
pub use track::{
    LegSpan, LegStretch, StretchSums, TrackHeight, TrackLeg, TrackPoint, TrackState, TrackStretches, TrackVertex, Way,
    WayHeights, WayRun, WayStretch, WayStretches, WayVertex,
};
pub use uav::{HoversOver, Uav, height_over, is_nodata_below};
pub use uav_grid::UavGrid;
pub use uncertain_heights::{CORRELATION_M, Deciding, RedrawnCounts, RedrawnHeights, Sure};
pub use view::{HeightBounds, Mapper, MovedRoofs, SceneView, UncertainHeights, View, check_drop};
