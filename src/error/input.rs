//! Input files that can be read but do not fit their purpose.

/// Fault of an input (E3xx).
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub(crate) enum InputError {
    /// E302: a file that cannot be a mask of an earlier run; the reason.
    #[error("cannot use {name} as a mask: {why}")]
    Mask { name: String, why: String },
    /// E302: a scene, or a file beside it, that changed after the run began.
    #[error("{0}, or a file beside it, has changed since the run began: its units would be of two scenes")]
    Changed(String),
    /// E302: a raster that cannot hold weights; the reason.
    #[error("cannot use {name} as weights: {why}")]
    Weights { name: String, why: String },
    /// E312: a mask on another grid than the scene's; both texts name the grids.
    #[error("cannot compare {mask} with maps of {scene}: wanted the same grid")]
    OtherGrid { mask: String, scene: String },
    /// E313: a table that is no curve of P_LoS; the reason, and `true` if some of its rows can be
    /// used.
    #[error("cannot read the curve {name}: {found}")]
    Curve { name: String, found: String, some_are_good: bool },
}

impl InputError {
    pub(super) fn code(&self) -> u16 {
        match self {
            InputError::Mask { .. } | InputError::Changed(_) | InputError::Weights { .. } => 302,
            InputError::OtherGrid { .. } => 312,
            InputError::Curve { .. } => 313,
        }
    }
}
