//! Approximations over columns, for comparison only: the shortcuts of other programs, implemented
//! as well as possible.
//!
//! None of these is exact, and nothing in the crate relies on them. They let a user see, on the
//! scene at hand, what the usual shortcuts cost and save compared with the exact engines:
//!
//! * `step:K` ([`step_los`]) samples the column under the ray every K cells. Obstacles between two
//!   samples are missed, so it errs towards LoS only.
//! * `xdraw` ([`xdraw_los`]) carries the steepest slope outward from cell to cell, interpolated
//!   between two neighbors of the line before. It is the family of GDAL's and WhiteboxTools'
//!   viewsheds (Franklin, Ray & Mehta 1994).
//! * `r2` ([`r2_los`]) traces one ray to each cell of the perimeter. Every cell gets the answer of
//!   the ray that passes nearest to its center (Franklin & Ray 1994).
//!
//! `xdraw` and `r2` take a cell for a point at its center, with its own height. A wall becomes a
//! ramp, and both methods err both ways. The operations of all three round the same way everywhere.
//! So their wrong cells are the same on every machine and with any number of threads.

mod quadrants;
mod r2;
mod step;
mod xdraw;

pub use r2::r2_los;
pub use step::{StepLength, step_los};
pub use xdraw::xdraw_los;
