//! Stress tests of methods: families of small scenes that are hard to decide, the truth about them,
//! and the errors of each method.
//!
//! Random cities hardly ever hold a tie, so a method with wrong ties looks right on them. The
//! scenes here hold little else. Rays touch roofs exactly, pass through the one point where two
//! towers touch, or run along shared walls. UAVs are on borders, at roof height, or kilometers up.
//!
//! * A [`Family`] makes any number of scenes, each a function of the seed and its number.
//! * [`truth()`] decides every receiver from the definition, in integers and without any code of
//!   the engines. It must agree with answers known by construction.
//! * [`stress`] counts the wrong receivers of each method.
//!
//! `cells_known` and `prisms_known` make scenes with known answers; `cells_drawn`, `prisms_drawn`
//! and `roofs_drawn` make scenes without; `symmetry` mirrors and turns scenes.

mod cells_drawn;
mod cells_known;
mod draw;
mod families;
mod prisms_drawn;
mod prisms_known;
mod roofs_drawn;
mod scene;
mod score;
mod served;
mod symmetry;
mod truth;
mod truth_columns;
mod truth_prisms;
mod truth_roofs;

pub use families::{AtRisk, FAMILIES, Family};
pub use scene::{Board, Known, Ready, StressPrism, StressScene, StressSolid};
pub use score::{Contender, Effort, FamilyScore, Outcome, Wrong, check_exact, stress};
pub use served::Served;
pub use symmetry::Symmetry;
pub use truth::truth;
