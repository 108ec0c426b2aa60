//! Small scenes as texts of files, and tables read back.

use std::collections::HashMap;

/// An ASCII grid of some columns from (0, 0), cells of 1 m.
pub(crate) fn grid<T: ToString>(values: &[T], n_cols: usize, nodata: i32) -> String {
    let n_rows = values.len() / n_cols;
    let rows: Vec<String> =
        values.chunks(n_cols).map(|row| row.iter().map(T::to_string).collect::<Vec<_>>().join(" ")).collect();
    let head = format!("ncols {n_cols}\nnrows {n_rows}\nxllcorner 0\nyllcorner 0\ncellsize 1\nNODATA_value {nodata}\n");
    format!("{head}{}\n", rows.join("\n"))
}

/// Squares as x, y, edge and height, in a file of footprints.
pub(crate) fn squares(squares: &[[f64; 4]]) -> String {
    let feature = |[x, y, s, h]: &[f64; 4]| {
        let (e, n) = (x + s, y + s);
        format!(
            r#"{{"type": "Feature", "properties": {{"height": {h}}}, "geometry": {{"type": "Polygon", "coordinates":
            [[[{x}, {y}], [{e}, {y}], [{e}, {n}], [{x}, {n}], [{x}, {y}]]]}}}}"#
        )
    };
    let features: Vec<String> = squares.iter().map(feature).collect();
    format!(
        r#"{{"type": "FeatureCollection", "crs": {{"type": "name", "properties": {{"name": "EPSG:25832"}}}}, "features": [{}]}}"#,
        features.join(",")
    )
}

/// The rows of a table, their cells by column.
pub(crate) fn table_rows(table: &str) -> Vec<HashMap<String, String>> {
    csv::Reader::from_reader(table.as_bytes()).deserialize().map(|row| row.unwrap()).collect()
}

/// A number of a row.
pub(crate) fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} of {row:?}"))
}
