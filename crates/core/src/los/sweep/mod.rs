//! `sweep` over columns: bounds on what hides a receiver, carried outward from the UAV row by row.
//!
//! # Words
//!
//! | word | meaning |
//! |---|---|
//! | row | a line of cells across the way out: of the raster to the north and south, a column of it to the east and west |
//! | azimuth bin | the rays between two azimuths t = b/2^k and (b+1)/2^k, both included |
//! | slope | height above the UAV over the distance across rows, so that one slope holds along a whole ray |
//! | bound | a slope above which no ray of a bin is obstructed (`upper`), or below which every ray is (`lower`) |
//! | undecided | a receiver whose slope is between the bounds of its bin |
//! | candidate row | a row that may obstruct a ray of a bin more than all other rows do |
//! | obstructing point | the point of a ray at which a cell obstructs it the most: the end nearest the lower terminal |
//! | wedge | adjacent bins, which one thread takes outward |
//!
//! # Algorithm
//!
//! 1. Cut the plane around the UAV into four quadrants, and number the rows of each outward
//!    ([`frame`]). Cut each quadrant into wedges.
//! 2. Get one row after another, from memory or from a reader ([`row_source`]).
//! 3. For each bin, look up the cells under both its edges, where rays enter the row and where they
//!    leave it. These four tops give bounds of the row, which raise those of the bin ([`bounds`]).
//! 4. Compare each receiver of the next row with the bounds of its bin, which come from the rows
//!    before its own. Above `upper` it is LoS, below `lower` NLoS, both proven ([`receivers`]).
//! 5. Settle receivers between the bounds exactly, by the few rows that may hide them
//!    ([`undecided`]).
//! 6. If least heights are requested, find the steepest obstruction of each link among the
//!    candidate rows of its bin ([`least_heights`]).
//!
//! The loop over rows is in [`wedge`], the loop over quadrants and wedges in [`run`]; [`output`]
//! takes the answers. Cells near the UAV are left to `ray`, since many bins pass one cell there;
//! their rows raise bounds. No receiver is LoS until an answer says so.
//!
//! ```text
//!   distance e ──┬─────┬──x──┬x────┬──   a row spans distances a to e; the bin between both rays is narrower than a
//!                │     │  │  /     │     cell at e. It is over the middle cell and the right one at e, over the middle
//!   distance a ──┴─────┴──x─x┴─────┴──   one alone at a. With tops of −8 m in the middle and −2 m to the right, a = 40
//!                         │/             and e = 41 m, and the UAV at 0, `upper` is −2/41 and `lower` −8/41
//! ```
//!
//! # Why the bounds hold
//!
//! Positions are (lateral, distance): distance y > 0 across rows, t = lateral/y the azimuth, |t| ≤
//! 1.
//!
//! * `upper` is the bound of the highest of the four tops. Sorted by position the four points are
//!   at most a cell apart. For |t| ≤ 1 moves a ray by at most a cell per row, and a bin is narrower
//!   than a cell. So no cell that a ray of the bin touches is missed. A top d above the UAV
//!   obstructs with slope d/e at most if d ≤ 0, with d/a at most if d > 0. The bound is the larger
//!   of both.
//! * `lower`: each ray leaves the row at e through one of the two cells under the edges there, or
//!   on the border between them. So the lower of these two tops obstructs it at e. At a, the lower
//!   of the two tops under the edges there does. On rough surfaces the second bound settles a fifth
//!   of the receivers that would be undecided, since half of all cells that rays touch are left
//!   sideways.
//! * From a cell center, |t| ≤ 1 crosses no other cell of the own row. So only rows before it can
//!   hide a receiver.
//!
//! **On the edge of a bin.** A ray exactly on edge t_b is in two closed bins. In both, `upper`
//! holds for it. The problem is `lower`: where the ray meets a or e exactly on a border between
//! cells, a look-up takes one of them. The ray is in the other cell before or after.
//!
//! For t > 0 the ray comes out of the left cell and continues into the right one, and look-ups take
//! the right one. The bin to the left of the edge has both, since its other edge is less than a
//! cell away. For t < 0 everything is mirrored: look-ups take the left cell, and the bin to the
//! right of the edge has both. So receivers on an edge belong to the bin towards the axis, and on
//! the axis to the left one. A ray with t = 0 leads to the center of a cell, so it is never on a
//! border. All other rays of either bin are to one side of the edge, where the bin has the cell.
//!
//! # Rounding
//!
//! The cell under an edge is found in integers: an edge is at (u·2^k + b·y)/2^(k+10) cells.
//!
//! The bin of a receiver is found in fixed point. Its place among the bins, dx·2^k/y, is a multiple
//! of 1/y. Moved by half of that it is on no edge, and rounding cannot move it over one. Vectors
//! add to the part of a place below the bin, which has 31 bits. Of edges that part is exact. Of
//! receivers it is rounded down by less than 2^-31 of a bin, far less than half of 1/y.
//!
//! Slopes are 32-bit floats. A height difference is rounded once (2^-24 of itself), the inverse
//! distance twice, its product with 1 ± 2^-19 once, the product once. So a slope is off by less
//! than 2^-21 of itself, and maxima and minima round nothing. Two slopes that differ by more than
//! 2^-20 of either compare as they would exactly. Both bounds are moved by 2^-19 of themselves,
//! `upper` up and `lower` down, and receivers between them are left undecided.
//!
//! No distance is below half a lattice cell except a = 0 in the UAV's own row, where 1/a is 10^25.
//! Every height above the UAV is then too steep for any receiver, as it must be.
//!
//! # What makes it fast
//!
//! * Cells under edges are looked up with a permutation of one vector, since neighbors are less
//!   than a cell apart. Bounds of receivers are looked up with a permutation of two vectors. All
//!   instruction sets do the same operations in the same order, so the bits are the same.
//! * Rays leave a row where they enter the next one. So a row raises the bounds when the next one
//!   is entered, and cells are looked up in both at the same places, found once.
//! * A row below every receiver and requested height beyond it hides nothing and raises nothing.
//!   The streets between blocks on flat ground are such rows (two of five rows of an urban city).
//! * Near rows need few bins. A bin splits in two, which inherit its bounds, when the next row
//!   needs narrower ones.
//! * Bins that no later row can change retire, 32 at a time; in dense cities nearly all do.
//! * Bins sleep through the dark. The highest top and receiver of each tile of 8 × 8 cells are
//!   known ([`crate::height_field::TileMaxima`]). They are compared for all tiles that 32 bins pass
//!   in the next eight rows. If all are less steep than the least `lower` of these bins, nothing
//!   there can raise a bound, be a candidate or be seen. This comparison leaves more slack than any
//!   bound is moved by. Gaps of less than 96 bins between awake bins stay awake, because skipping
//!   them costs more.
//! * To the east and west, strips of 64 columns are turned into rows first; memory is read in rows
//!   throughout.
//!
//! Cost: two to three look-ups per cell that is not in the dark. Each undecided receiver (0.02 to 3
//! % of all) takes a look at a row or a walk. With least heights, each receiver takes two candidate
//! rows.
//!
//! # Where extensions belong
//!
//! Heights that depend on the UAV (the earth's curvature) are lowered in [`row_source`], some rows
//! at a time, and one by one where step 5 needs single cells. A top that is a plane over its cell
//! would have two heights at a and two at e instead of one: those under each edge there. A
//! candidate row would then keep the plane.

mod bounds;
mod candidates;
mod columns_reader;
mod frame;
mod least_heights;
mod output;
mod receivers;
mod row_source;
mod row_walk;
mod run;
mod simd;
mod suspects;
mod undecided;
mod wedge;

pub use columns_reader::{ColumnsReader, StreamLimits, StreamedHeights, StreamedScene};
pub use run::{ReceiverHeights, Swept, streamed_sweep_los, sweep_los};
