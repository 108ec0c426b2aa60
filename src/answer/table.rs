//! Tables made of serde types. The columns are the fields of a row type.

use schemars::{JsonSchema, schema_for};
use serde::Serialize;
use serde_json::{Map, Value};

use crate::error::Result;
use crate::export::{Column, as_text, encode_table};

/// Cells of a table, row by row. The first row holds the names of the columns.
pub(crate) type Rows = Vec<Vec<String>>;

/// Returns the table of some rows. Its columns are the fields of `R` in their order, without fields
/// that no row has.
pub(crate) fn rows<R: Serialize + JsonSchema>(rows: impl IntoIterator<Item = R>) -> Rows {
    let objects: Vec<Map<String, Value>> = rows.into_iter().filter_map(|row| object(&row)).collect();
    let schema = schema_for!(R);
    let fields = schema.get("properties").and_then(Value::as_object);
    let is_there = |name: &&String| objects.is_empty() || objects.iter().any(|row| row.contains_key(*name));
    let header: Vec<String> = fields.into_iter().flat_map(Map::keys).filter(is_there).cloned().collect();
    let cells = objects.iter().map(|row| header.iter().map(|name| row.get(name).map_or(String::new(), cell)).collect());
    std::iter::once(header.clone()).chain(cells).collect()
}

/// Returns the same table by columns, typed as the fields.
pub(crate) fn columns_of<R: Serialize + JsonSchema>(of: impl IntoIterator<Item = R>) -> Vec<(String, Column)> {
    let objects: Vec<Map<String, Value>> = of.into_iter().filter_map(|row| object(&row)).collect();
    let schema = schema_for!(R);
    let fields = schema.get("properties").and_then(Value::as_object);
    let is_there = |name: &&String| objects.is_empty() || objects.iter().any(|row| row.contains_key(*name));
    let holds = |field: &Value, kind: &str| match field.get("type") {
        Some(Value::Array(kinds)) => kinds.iter().any(|k| k == kind),
        kind_of_all => kind_of_all.is_some_and(|k| k == kind),
    };
    let column = |name: &String, field: &Value| {
        let values = objects.iter().map(|row| row.get(name).unwrap_or(&Value::Null));
        match field {
            field if holds(field, "integer") => Column::Whole(values.map(Value::as_i64).collect()),
            field if holds(field, "number") => Column::Number(values.map(Value::as_f64).collect()),
            _ => Column::Text(values.map(|value| value.as_str().map(str::to_string)).collect()),
        }
    };
    let fields = fields.into_iter().flatten().filter(|(name, _)| is_there(name));
    fields.map(|(name, field)| (name.clone(), column(name, field))).collect()
}

fn object(row: &impl Serialize) -> Option<Map<String, Value>> {
    match serde_json::to_value(row) {
        Ok(Value::Object(object)) => Some(object),
        _ => None,
    }
}

/// Returns a value as a cell; a missing value is empty.
fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        Value::Number(number) if number.is_f64() => number.as_f64().map_or(String::new(), |v| v.to_string()),
        other => other.to_string(),
    }
}

/// Encodes a table. With `is_text`, cells that a spreadsheet would run become text.
///
/// # Errors
/// If the table cannot be encoded.
pub(crate) fn encoded(rows: &Rows, is_text: bool) -> Result<Vec<u8>> {
    if is_text { Ok(encode_table(&as_text(rows))?) } else { Ok(encode_table(rows)?) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize, JsonSchema)]
    struct Row {
        name: &'static str,
        #[serde(skip_serializing_if = "Option::is_none")]
        only_sometimes: Option<u32>,
        length_m: Option<f64>,
    }

    #[test]
    fn columns_are_those_that_any_row_has() {
        let row = |only_sometimes| Row { name: "a", only_sometimes, length_m: Some(2.0) };
        assert_eq!(rows([row(None)]), [["name", "length_m"], ["a", "2"]]);
        assert_eq!(
            rows([row(None), row(Some(3))]).concat(),
            ["name", "only_sometimes", "length_m", "a", "", "2", "a", "3", "2"]
        );
        assert_eq!(rows::<Row>([])[0].len(), 3);
    }
}
