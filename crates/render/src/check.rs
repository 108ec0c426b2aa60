//! What no picture can be drawn of.

/// Refuses an empty raster of so many columns and rows, and an array that does not fit it.
pub(crate) fn shape(name: &str, length: usize, [n_cols, n_rows]: [usize; 2]) -> Result<(), String> {
    if n_cols == 0 || n_rows == 0 {
        return Err(format!("cannot draw a raster of {n_cols} × {n_rows} cells: it is empty"));
    }
    if n_cols.checked_mul(n_rows) != Some(length) {
        return Err(format!("cannot draw: {name} has {length} values, the raster has {n_cols} × {n_rows} cells"));
    }
    Ok(())
}
