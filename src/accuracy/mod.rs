//! What a method costs and how far it errs: approximations, coarser cells and moved inputs against the exact answer.

mod paired;
mod simpler;
pub mod stress;
mod tolerance;
pub use paired::{FEWEST_POSITIONS, Paired, paired_difference};
pub use simpler::{CoarseAnswer, Simpler, coarse_answer, moved_to};
pub use tolerance::{CONFIDENCE, Choice, Measured, Question, Tried, coarsest_within};
