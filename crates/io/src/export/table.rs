//! Tables as comma-separated values.

use crate::error::{Error, Result};

/// Returns rows whose cells no spreadsheet runs. Cells that begin with `=`, `+`, `-`, `@` or a
/// control character and are no numbers get a `'` before them.
pub fn as_text(rows: &[Vec<String>]) -> Vec<Vec<String>> {
    let cell = |cell: &String| {
        let is_run =
            cell.starts_with(['=', '+', '-', '@', '\t', '\r', '\n']) && !cell.parse::<f64>().is_ok_and(f64::is_finite);
        if is_run { format!("'{cell}") } else { cell.clone() }
    };
    rows.iter().map(|row| row.iter().map(cell).collect()).collect()
}

/// Encodes a table of equally long rows, the header first, as UTF-8 text.
///
/// # Errors
/// E402 if the rows are not equally long.
pub fn encode_table(rows: &[Vec<String>]) -> Result<Vec<u8>> {
    let failed = |cause: String| Error::encode("a table", cause);
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.write_record(row).map_err(|e| failed(e.to_string()))?;
    }
    writer.into_inner().map_err(|e| failed(e.to_string()))
}
