//! What curves and heat maps have in common.

use super::report::PlosRow;
use crate::error::{Error, RequestError};
use crate::los_probability::models::UserCurve;
use crate::render::Sheet;

/// What pictures need beside the report.
#[derive(Debug, Default)]
pub(super) struct Facts {
    /// Whom pictures must credit.
    pub(super) attributions: Vec<String>,
    /// Models between the values of the table, so that their steps and bends are drawn where they are.
    pub(super) fine_rows: Vec<PlosRow>,
    /// Rows of the product between those that were asked for, where its curve turns.
    pub(super) between: Vec<PlosRow>,
    /// Curves of the user's own, whose rows are drawn.
    pub(super) curves: Vec<UserCurve>,
}

pub(super) const MOST_PANELS: usize = 12;

pub(super) type Drawn = std::result::Result<Sheet, String>;

pub(super) fn too_many(n: usize, what: &'static str, most: usize) -> Error {
    RequestError::TooManyDrawn { n, what, most }.into()
}
