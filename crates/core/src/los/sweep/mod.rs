//! `sweep` over columns: bounds on what hides a receiver, carried outward from the UAV line by line.
//!
//! # Method
//!
//! The plane around the UAV is cut into four quadrants: in the one to the north all cells with |dx| ≤ dy, and so on. Within
//! a quadrant the sweep goes outward over *lines* of cells (rows to the north and south, columns to the east and west).
//! Positions are (lateral, distance): distance y > 0 across the lines, t = lateral/y the azimuth, |t| ≤ 1. Slopes are
//! (z − h_U)/y, so that one slope holds along a whole ray.
//!
//! ```text
//!   distance e ──┬─────┬──x──┬─────┬──   a line spans distances a to e; a bin is what lies
//!                │     │ / \ │     │     between two azimuths, closed, and narrower than a
//!   distance a ──┴─────┴x───x┴─────┴──   cell at e
//!                      /     \           UAV at distance 0, below
//! ```
//!
//! Azimuth is cut into closed *bins* at t = b/2^k, and each bin holds two bounds over the lines passed so far that may hide
//! a receiver:
//! * `upper`: none of these lines obstructs a ray of the bin above this slope. A line raises it to the largest height among
//!   the cells under both edges of the bin at a and at e. Sorted by position these four points are at most a cell apart
//!   (|t| ≤ 1 moves a ray by at most a cell per line, and a bin is narrower than a cell), so no cell that a ray of the bin
//!   touches is missed.
//!   A height d = z − h_U obstructs with slope d/e at most if d ≤ 0, with d/a at most if d > 0: the larger of both.
//! * `lower`: every ray of the bin is obstructed at least up to this slope. Each ray leaves the line at e through one of
//!   the two cells under the edges there (or on the border between), so the lower of these two, at e, obstructs it. It enters
//!   the line through one of the two cells under the edges at a, so the lower of those, at a, obstructs it as well: on rough
//!   surfaces this proves a fifth of what would be in doubt, since half of all cells that rays touch are left sideways.
//!
//! A receiver is compared with the lines *before* its own: from a cell center, |t| ≤ 1 crosses no other cell of the own
//! line. If its slope is above `upper` it is LoS, below `lower` NLoS, both proven; the few between are settled by the lines
//! that may hide them, the last of them by a walk along their ray ([`line_walk`]), in exact integers. So the
//! outcome is that of `ray`, cell for cell.
//!
//! **On the edge of a bin.** A ray exactly on edge t_b is in two closed bins. `upper` holds for it in both. `lower` is the
//! problem: where the ray meets a or e exactly on a border between cells, a look-up takes one of them, and the ray is in the
//! other one before or after. For t > 0 the ray comes out of the left cell and goes on into the right one, and look-ups take
//! the right one: the bin to the left of the edge has both, since its other edge is less than a cell away. For t < 0 all is
//! mirrored: look-ups take the left cell, and the bin to the right of the edge has both. So receivers on an edge belong to
//! the bin towards the axis, and on the axis to the left one: a ray with t = 0 leads to the center of a cell, so that it is
//! never on a border. All other rays of either bin are to one side of the edge, where the bin has the cell.
//!
//! # Rounding
//!
//! Which cell is under an edge is decided in integers: an edge is at (u·2^k + b·y)/2^(k+10) cells. Which bin a receiver is in
//! is decided in fixed point: where it is among the bins, dx·2^k/y, is a multiple of 1/y, so half of that is room enough for
//! rounding once none of them is on an edge any more ([`receivers`]). In a vector of lanes only a remainder below 2^31 is left to
//! add to: of edges it is exact, of receivers it is rounded down by less than 2^-31 of a bin, for which there is room as well.
//! Slopes are 32-bit floats. A height difference is rounded once (2^-24 of itself), the inverse distance twice, its product
//! with what puts a bound off once, the product once: a slope is off by less than 2^-21 of itself, and maxima and minima round nothing. So
//! two slopes compare as they would exactly wherever they differ by more than 2^-20 of either. Both bounds are put off by
//! 2^-19 of themselves, `upper` up and `lower` down, and what lies between is left undecided ([`kernels`]). No distance is
//! below half a lattice cell but a = 0 in the UAV's own line, where 1/a is 10^25: every height above the UAV is then too
//! steep for any receiver, as it must be.
//!
//! # What makes it fast
//!
//! * Cells under edges are looked up with a permutation of one vector, since neighbors are less than a cell apart, and the
//!   bounds of receivers with one of two. All instruction sets do the same operations in the same order: the bits are the
//!   same.
//! * Rays exit a line where they enter the next one, so a line raises the bounds when the next one is entered, and cells are
//!   looked up in both by one reckoning of places.
//! * A line that is below every receiver still to come, wherever it may be, can hide none and raises nothing: so do the streets
//!   between blocks on flat ground (two of five lines of an urban city).
//! * Near lines need few bins: a bin splits in two, which inherit its bounds, when the next line asks for narrower ones.
//!   Bins twice as fine leave fewer receivers undecided, by a sixth to a quarter, but cost as much as these walks do.
//! * Bins in which no later receiver can be LoS retire, 32 at a time; in dense cities nearly all do.
//! * Bins sleep through what lies in the dark. The highest top and receiver of each tile of 8 × 8 cells are known
//!   ([`crate::height_field::TileMaxima`]). Where those of all tiles that 32 bins pass in the next eight lines are less steep than the least
//!   `lower` of these bins, nothing there can raise a bound, be suspected or be seen: not `lower`; not `upper`, which is never
//!   below it; nor is a receiver LoS. So neither cells nor receivers are looked at. This comparison leaves more slack than
//!   any bound is put off by. About half of all bins sleep in an urban city of 4096² cells, fewer in suburbs, more among
//!   high-rises. Gaps of less than 96 bins between others stay awake, which is harmless and costs less than to leave them out.
//! * An undecided receiver need only be asked about the lines that can matter ([`suspects`]). Each bin knows its steepest line
//!   and how steep the second is. Looked at where the ray, in fixed point, enters and leaves it, the steepest line hides four
//!   of ten, and three of ten are seen because no other is as steep as they are. For the rest each bin knows the steepest of
//!   the present group of up to eight lines, the two steepest groups before it, and the first and the last of all other groups
//!   that are as steep as any receiver in doubt can be, that is neither below the lowest possible receiver nor below `lower`.
//!   Over laser scans a half to three quarters of the rest need one group, and one in forty needs other groups; over
//!   these a walk skips eight lines at a time where the tiles are below it.
//! * To the east and west, strips of 64 columns are turned into lines first; memory is read in rows throughout. Rows of rasters
//!   in memory are asked for while those before them are turned or passed: what a wedge reads of a row is too short for a core to
//!   read ahead by itself.
//!
//! Cost: two to three look-ups per cell that is not in the dark, and a look at one line or a walk for each undecided receiver
//! (0.02 to 3 % of all).

mod bins;
mod columns_reader;
mod in_memory;
mod kernels;
mod line_order;
mod line_walk;
mod quadrant_pass;
mod quadrants;
mod receivers;
mod shared_bits;
mod streamed;
mod suspects;
mod verdicts;
mod wedge;

pub use columns_reader::{ColumnsReader, StreamLimits, StreamedHeights, StreamedScene};
pub use in_memory::{ReceiverHeights, sweep_los};
pub use quadrants::Swept;
pub use streamed::streamed_sweep_los;
