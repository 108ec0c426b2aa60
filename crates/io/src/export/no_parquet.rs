//! Tables in columns in a build without the feature `parquet`.

use super::columns::Column;
use crate::error::{Error, Result};

/// Refuses to encode.
///
/// # Errors
/// E402.
pub fn encode_parquet(_: &[(String, Column)], _: &str) -> Result<Vec<u8>> {
    Err(Error::encode("a table in columns", "this build has no `parquet`"))
}
