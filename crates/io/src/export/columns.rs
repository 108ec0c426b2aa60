//! Tables in columns, whatever format holds them.

use crate::error::{Error, Result};

/// The cells of a column; `None` where there is no value.
#[derive(Debug, Clone, PartialEq)]
pub enum Column {
    /// Texts.
    Text(Vec<Option<String>>),
    /// Whole numbers.
    Whole(Vec<Option<i64>>),
    /// Numbers.
    Number(Vec<Option<f64>>),
}

/// Encodes a table of named columns of one length as Parquet, with its provenance under the key
/// `skyshed`.
///
/// # Errors
/// E402 if the columns are not equally long, or in a build without the feature `parquet`.
pub fn encode_parquet(columns: &[(String, Column)], provenance: &str) -> Result<Vec<u8>> {
    #[cfg(feature = "parquet")]
    let encoded = super::parquet::encoded(columns, provenance);
    #[cfg(not(feature = "parquet"))]
    let encoded: Result<Vec<u8>, &str> = {
        let _ = (columns, provenance);
        Err("this build has no `parquet`")
    };
    encoded.map_err(|e| Error::encode("a table in columns", e.to_string()))
}
