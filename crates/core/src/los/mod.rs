//! Line of sight: its meaning, and the engines that decide it.
//!
//! **A link is LoS if and only if the open segment between the UAV and the receiver meets neither
//! the interior of B nor the interior of T.**
//!
//! B is the closed union of all prisms, T the closed union of all columns. Touching a roof edge, a
//! wall or a corner is LoS. Solids that share a wall are one solid, blocked up to the lower roof. A
//! ray through the one point where two cells touch corner to corner passes. In a raster every cell
//! whose closed square contains the receiver is exempt for that receiver. The UAV's own cell or
//! building blocks like any other, and no prism is ever exempt.
//!
//! Along one ray: let h(p) be the height below which the vertical line at p is in the interior of
//! the solid. It is the top of the piece or cell around p, and on an edge the lower top of both
//! sides. Along the ray h is piecewise constant and drops only at single points. So the link is
//! blocked if and only if some *interval* of the ray has z < h inside. Since z is linear, that is
//! one comparison per interval:
//!
//! ```text
//!   blocked  ⇔  h > z at the obstructing point, the end of the interval nearest the lower terminal
//! ```
//!
//! This is eq. 3 of Saboor et al. 2023 (h_LoS = h_U − r_OP (h_U − h_rx) / r_rx, distances from the
//! UAV). Both sides are compared as products of integers, so line of sight has no epsilon and no
//! rounding.
//!
//! Conversely, an interval of height h bounds the receiver from below. A receiver at the same place
//! is LoS only from `z_U + (h − z_U) / s` up, where s is the fraction of the way from the UAV to
//! the obstructing point. The largest of these bounds is the **least visible height** at that
//! place. The interval that sets it is the **obstruction** to be named to the user.
//!
//! Three exact engines give the same cells:
//!
//! * `ray` visits the solids that one link crosses ([`columns_los`], [`prisms_los`]). It is the
//!   plain twin with which the fast engines are compared.
//! * `shadow` casts the shadows of prisms over a grid ([`shadow_los`]). It also takes a raster made
//!   of few rectangles of one height each ([`plateaus_los`]).
//! * `sweep` carries bounds over the cells of a raster ([`sweep_los`]).
//!
//! A receiver that moves along a straight leg is decided in one piece: [`hidden_parts`] gives the
//! parts of the leg without line of sight, with exact ends.
//!
//! [`GridLos`] runs the engine that [`Method::choose`] picks for a scene. The approximations
//! `step`, `xdraw` and `r2` ([`step_los`], [`xdraw_los`], [`r2_los`]) exist for comparison and run
//! only on request.

mod approximate;
mod cell_walk;
mod columns_ray;
mod curved_plateaus;
mod grid_heights;
mod grid_los;
mod grid_receivers;
mod height_errors;
mod height_limits;
mod inner_walk;
mod leg;
mod link;
mod lowest_between;
mod method;
mod obstruction;
mod plan_crossings;
mod prism_crossing;
mod prisms_ray;
mod sag;
mod shadow;
mod slope;
mod sweep;

pub use approximate::{StepLength, r2_los, step_los, xdraw_los};
pub use columns_ray::{
    columns_crossed, columns_least_height, columns_least_receiver_height, columns_least_step, columns_los,
};
pub use grid_heights::GridHeights;
pub use grid_los::GridLos;
pub(crate) use grid_los::height_by_cell;
pub use grid_receivers::GridReceivers;
pub(crate) use height_errors::{CERTAIN, MOST_AT_STEP, PART, STEP, TINY};
pub use height_errors::{HeightErrors, OwnErrors};
pub use height_limits::{HeightLimits, Wall};
pub use leg::{
    GroundPart, HiddenPart, Leg, LegObstacle, LegPart, LegPlace, LegWindow, common_parts, ground_parts, hidden_parts,
    inside_parts, merged_parts, total_length,
};
pub use link::{LeastHeights, link_least_receiver_heights, link_los};
pub(crate) use link::{link_least_height, link_least_step};
pub use method::{Method, MethodChoice, WrongMethod};
pub use obstruction::{HORIZON, LeastHeight, Obstruction};
pub use plan_crossings::PlanCrossings;
pub(crate) use prisms_ray::limit_by_blocking_prisms;
pub use prisms_ray::{
    prisms_crossed, prisms_least_height, prisms_least_receiver_height, prisms_least_step, prisms_los,
};
pub use shadow::{
    ClearProbabilities, InView, OnPlateaus, PlateauScene, ReceiverTile, ShadowGrid, ShadowLos, ShadowScene,
    UavPositions, plateaus_los, shadow_clear_probabilities, shadow_least_heights, shadow_least_receiver_heights,
    shadow_los, shadow_los_relief,
};
pub use sweep::{
    ColumnsReader, ReceiverHeights, StreamLimits, StreamedHeights, StreamedScene, Swept, streamed_sweep_los, sweep_los,
};
