//! Approximations over columns, for comparison only: what other programs do, built as well as it can be.
//!
//! None of these is exact, and nothing in the crate relies on them. They exist so that a user can see, on the scene at
//! hand, what the usual shortcuts cost and save beside the exact engines:
//!
//! * `step:K` ([`step_los`]) looks at the column under the ray every K cells. What lies between two samples is missed, so it
//!   errs towards LoS only.
//! * `xdraw` ([`xdraw_los`]) carries the steepest slope outward from cell to cell, interpolated between two neighbors of the
//!   line before (Franklin, Ray & Mehta 1994; the family of GDAL's and WhiteboxTools' viewsheds).
//! * `r2` ([`r2_los`]) traces one ray to each cell of the perimeter, and gives every cell the answer of the ray that passes
//!   nearest to its center (Franklin & Ray 1994).
//!
//! `xdraw` and `r2` take a cell for a point at its center, with its own height: a wall becomes a ramp, and both err both
//! ways. All three are decided by operations that round the same way everywhere, so their wrong cells are the same on
//! every machine and with any number of threads.

mod quadrants;
mod r2;
mod step;
mod xdraw;

pub use r2::r2_los;
pub use step::{StepLength, step_los};
pub use xdraw::xdraw_los;
