//! Failures of methods on families of scenes, and the stability of a scene's answers under moves by
//! a lattice step.

mod families;
mod report;
mod scene;

pub(crate) use families::Stress;
pub(crate) use report::{StressDocument, StressRow, StressSceneDocument, StressSceneRow};
pub(crate) use scene::StressScene;

use crate::export::Format;

/// Output formats of both.
pub(crate) const FORMATS: [Format; 6] =
    [Format::Png, Format::Svg, Format::Pdf, Format::Csv, Format::Json, Format::Stdout];
