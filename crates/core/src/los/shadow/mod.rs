//! `shadow` over prisms: casts the shadow of every convex piece on the receivers, row by row, into
//! a set of bits.
//!
//! **Method.** Let u be the UAV, F a convex footprint with its roof at H, and let receivers stand
//! at height z. A point u + t(p − u), 0 < t < 1, of the ray to a receiver at p is in the prism if
//! two conditions hold. It lies in the interior of F, and the ray is below the roof there: h_U +
//! t(z − h_U) < H. The receiver is hidden by this prism alone if and only if there is such a point.
//! With s = 1/t > 1 the hidden set is the union of all u + s(F° − u) over the s that the heights
//! admit:
//!
//! ```text
//!   H ≤ z and H ≤ h_U    nothing
//!   z < H < h_U          1 < s < f, f = (h_U − z)/(h_U − H)     the roof's shadow on the plane z
//!   H ≥ h_U and H ≥ z    1 < s                                  no end
//!   h_U < H < z          g < s, g = (z − h_U)/(H − h_U)         no end, and it begins behind the building
//!   ⇒ always near < s < far, with near = 1 or g, and far = f or ∞; near may be larger where another hides what is nearer
//! ```
//!
//! **Half-planes.** Let edge A→B of the counterclockwise F have direction E, and let
//! K = E × (A − u). Inside F, E × (p − u) > K. The edge *faces* u if K > 0: u itself is then outside
//! of the edge's line. It is inside if K < 0. Scaled by s about u the edge bounds E × (p − u) > s·K.
//!
//! A point of the cone over F from u leaves through edges that do not face u and enters through
//! facing edges. So it is hidden if and only if it is
//!
//! * inside the facing edges at s = near,
//! * inside the other edges at s = far, if there is an end,
//! * inside the cone, whose sides are the lines from u through the two vertices where facing edges
//!   meet others.
//!
//! An edge whose line passes through u (K = 0) is such a side itself. Over F there is no facing
//! edge and the cone is the whole plane. So the hidden set is an open convex set: an intersection
//! of half-planes E × q > K', q = p − u. Along a row of cells each half-plane is one bound on the
//! column, `at + per_q·q_y`. The hidden cells of the row lie between the largest of the western and
//! the smallest of the eastern bounds.
//!
//! **Exactness.** Coordinates, E, K and the rows' q_y are integers (K and products of differences
//! below 2^55 in i64). The bounds are computed in doubles, in one order of operations at every SIMD
//! level. Their error is proven to be below a margin (`outline::ROUNDING`) of about 1e-11 cells.
//! Cells farther from all bounds than the margin are decided.
//!
//! The few other cells are recorded as *doubts*. At the end `ray` decides the wanted doubts that no
//! other shadow has hidden: it alone knows whether the wall or diagonal along the ray is shared. No
//! other receiver can be hidden. If the ray is blocked only by several pieces together, it runs
//! along an edge of two of them. Then the receiver lies on a bounding line (K = 0) of both, in the
//! closure of both shadows, and is a doubt. If centers of cells do not lie evenly on the lattice
//! (cells of 0.3 m), the margin grows by the largest deviation.
//!
//! **Differing heights** ([`shadow_los_relief`]). Solved for z, the half-plane of an edge at s = f
//! (or g) reads z < h_U + (E × q)·(H − h_U)/K. That is below the plane through the UAV and the far
//! (near) upper edge. So within the cone and behind the near edges a prism hides the receivers
//! below its ceiling. The ceiling is the lowest of these planes, and the roof if that is below the
//! UAV.
//!
//! The least of several planes is concave, so its values at the corners of a tile bound it there.
//! Tiles whose receivers are all below are filled as before, and tiles whose receivers are all
//! above are left out. In other tiles eight receivers at a time are compared with the planes, again
//! with a proven margin and doubts. Higher receivers are hidden by less, so the outline on the
//! lowest bounds all. A mask keeps no ceiling per cell: every shadow would write 64 times the
//! memory, and no ground would ever be dark.
//!
//! **Least heights** ([`least_heights`]) are the largest of these ceilings, cell by cell. Those of
//! the UAV are found in the same way.
//!
//! **Cost.** Proportional to the rows of the shadows, not their cells: a set of bits is cleared 64
//! cells at a time. Seen from above all receivers, where shadows are long, casters behind the
//! horizon are left out. The other casters' shadows begin where the shadows before them end
//! ([`horizon`]), so that most of the ground is cleared about once.
//!
//! Blocks of neighboring casters go nearest first, one sector of azimuths after the other, so that
//! the far ones find their ground dark. Then 64 rows of a shadow are skipped if no wanted cell is
//! left in the tiles of 64 × 64 cells that they meet. Whole blocks are skipped in the same way.
//!
//! **Heights with errors** ([`clear_probability`]). The same half-planes give the room of a
//! building, receiver by receiver.
//!
//! **Curved earth** ([`curve`]). Shadows end along a curve there, which is between two lines that
//! are some µm of height apart. Cells between them are in doubt.
//!
//! **Sloped roofs** ([`sloped`]). Where a roof is a plane, the shadow ends at the projection of its
//! upper edges, each corner at a height of its own. From a UAV below that plane, it ends at the
//! projection of the near edges. Everything else is as above.

mod band;
mod between;
mod cast;
mod caster_heights;
mod ceiling;
mod clear_probability;
mod curve;
mod geometry;
mod grid;
mod horizon;
mod least_heights;
mod map;
mod outline;
mod plane;
mod plateaus;
mod positions;
mod reach;
mod scene;
mod sloped;
mod spans;
mod words;

pub use clear_probability::{ClearProbabilities, shadow_clear_probabilities};
pub use grid::ShadowGrid;
pub use least_heights::{shadow_least_heights, shadow_least_receiver_heights};
pub use map::{shadow_los, shadow_los_relief};
pub use plateaus::{OnPlateaus, PlateauScene, plateaus_los};
pub use positions::{InView, ReceiverTile, UavPositions};
pub use scene::{ShadowLos, ShadowScene};
