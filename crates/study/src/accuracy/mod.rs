//! Cost and error of methods: approximations, coarser cells and changed inputs against the exact
//! answer.
//!
//! Nothing here reads a clock: the caller times the contestants.

mod budget;
pub mod chart;
pub mod comparison;
mod economy;
pub mod front;
mod paired;
pub mod plos_cost;
mod simpler;
pub mod stress;
mod tolerance;

pub use budget::{BudgetLine, Part, Uncertain, error_budget};
pub use economy::{
    CellEffect, NO_CHANGE, RoofEffect, Setup, TerrainEffect, cell_effects, coarsest_unchanged, roof_effect,
    terrain_effect,
};
pub use paired::{Paired, paired_difference};
pub(crate) use simpler::moved_to;
pub use simpler::{CoarseAnswer, FACTORS, Simpler, coarse_answer};
pub use tolerance::{CONFIDENCE, Choice, Measured, Question, Tried, coarsest_within};
