//! Where methods fail: families of small scenes that are hard to decide, the truth about them, and who gets them wrong.
//!
//! Random cities hardly ever hold a tie, so a method that gets ties wrong looks right on them. The scenes here hold
//! little else: rays that touch roofs exactly, pass through the one point where two towers touch, run along shared
//! walls; UAVs on borders, at roof height, kilometers up. A [`Family`] makes any number of them, each a function of the
//! seed and its number. [`truth()`] decides every receiver from the definition, by integers and without any code of the
//! engines; where an answer is known by construction, it must agree. [`stress`] counts what each method gets wrong.
//!
//! `cells_known` and `prisms_known` make scenes with answers that are known, `cells_drawn`, `prisms_drawn` and `roofs_drawn` those without;
//! `symmetry` mirrors and turns them.

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
