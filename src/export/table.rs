//! Tables as comma-separated values.

use crate::error::{Error, Result};

/// A table of equally long rows, the header first, as UTF-8 text.
///
/// # Errors
/// E402 if the rows are not equally long.
pub fn encode_table(rows: &[Vec<String>]) -> Result<Vec<u8>> {
    let failed = |cause: String| Error::internal(402, format!("cannot encode a table: {cause}"));
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.write_record(row).map_err(|e| failed(e.to_string()))?;
    }
    writer.into_inner().map_err(|e| failed(e.to_string()))
}
