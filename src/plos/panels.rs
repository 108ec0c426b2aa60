//! Common parts of curves and heat maps.

use super::report::PlosRow;
use crate::error::{Error, RequestError};
use crate::los_probability::models::UserCurve;
use crate::render::Sheet;

/// Inputs of pictures beside the report.
#[derive(Debug, Default)]
pub(super) struct Facts {
    /// Attributions that pictures must show.
    pub(super) attributions: Vec<String>,
    /// Values of models between those of the table, so that curves show their steps and bends in
    /// the right place.
    pub(super) fine_rows: Vec<PlosRow>,
    /// Rows of the product between the requested ones, where its curve bends.
    pub(super) between: Vec<PlosRow>,
    /// Curves of the user, drawn at the points of their tables.
    pub(super) curves: Vec<UserCurve>,
}

pub(super) const MOST_PANELS: usize = 12;

pub(super) type Drawn = std::result::Result<Sheet, String>;

pub(super) fn too_many(n: usize, what: &'static str, most: usize) -> Error {
    RequestError::TooManyDrawn { n, what, most }.into()
}
