//! What is odd but stops nothing.

use std::fmt;

use super::words::one_line;
use crate::quantity::counted;

/// Something odd that did not stop the work: what was found and what was done instead.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the docs of a variant say what its fields are")]
pub enum Warning {
    /// Cells of a scene of footprints have no ground: the terrain is void there, or ends before. They block everything, or
    /// nothing.
    UnknownGround { cells: u64, block: bool },
    /// A footprint, named by its id, could not be triangulated; its convex hull is used instead.
    Hull { footprint: String },
    /// Hardly any open ground lies between the footprints, so all ground counts as known.
    LittleOpenGround,
    /// A warning, and the larger thing that it concerns.
    Within { warning: Box<Warning>, context: String },
    /// A warning that is text alone.
    Told { code: u16, text: String },
}

impl Warning {
    /// A warning that is text alone, with a stable code. What errors do with text holds here, too.
    pub fn new(code: u16, text: impl Into<String>) -> Self {
        Warning::Told { code, text: one_line(&text.into()) }
    }

    /// The warning in a larger thing, which its text names at the end, in parentheses.
    #[must_use]
    pub fn within(self, context: impl fmt::Display) -> Self {
        Warning::Within { warning: Box::new(self), context: context.to_string() }
    }

    /// The stable code, for example `W320`.
    pub fn code(&self) -> String {
        let code = match self {
            Warning::UnknownGround { .. } => 340,
            Warning::Hull { .. } => 345,
            Warning::LittleOpenGround => 379,
            Warning::Within { warning, .. } => return warning.code(),
            Warning::Told { code, .. } => *code,
        };
        format!("W{code:03}")
    }

    /// One line: what was found, what was done instead.
    pub fn text(&self) -> String {
        let text = match self {
            Warning::UnknownGround { cells, block } => format!(
                "{} no ground: the terrain is void there, or ends before; it blocks {} and holds no receiver",
                counted(*cells, "cell has", "cells have"),
                if *block { "everything" } else { "nothing" }
            ),
            Warning::Hull { footprint } => {
                format!("footprint `{footprint}` could not be triangulated; its convex hull is used instead")
            }
            Warning::LittleOpenGround => {
                "hardly any open ground lies between the footprints, so all ground counts as known".to_string()
            }
            Warning::Within { warning, context } => format!("{} ({context})", warning.text()),
            Warning::Told { text, .. } => return text.clone(),
        };
        one_line(&text)
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text())
    }
}
