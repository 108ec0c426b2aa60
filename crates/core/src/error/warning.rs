//! Warnings: odd input that does not stop the work.

use super::words::one_line;
use crate::quantity::counted;

/// Something odd that did not stop the work: what was found and what was done instead, on one line.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum Warning {
    /// W340: cells of a scene of footprints have no ground: the terrain is void there, or ends
    /// before. They block everything, or nothing.
    #[error(
        "{} no ground: the terrain is void there, or ends before; it blocks {} and holds no receiver",
        counted(*cells, "cell has", "cells have"),
        if *block { "everything" } else { "nothing" }
    )]
    UnknownGround { cells: u64, block: bool },
    /// W345: a footprint, named by its id, could not be triangulated; its convex hull is used
    /// instead.
    #[error("{}", one_line(&format!("footprint `{footprint}` could not be triangulated; its convex hull is used instead")))]
    Hull { footprint: String },
    /// W379: hardly any open ground lies between the footprints, so all ground counts as known.
    #[error("hardly any open ground lies between the footprints, so all ground counts as known")]
    LittleOpenGround,
}

impl Warning {
    /// Returns the stable code, for example `W340`.
    pub fn code(&self) -> String {
        let number = match self {
            Warning::UnknownGround { .. } => 340,
            Warning::Hull { .. } => 345,
            Warning::LittleOpenGround => 379,
        };
        format!("W{number}")
    }
}
