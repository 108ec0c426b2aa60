//! Schemas of documents and columns of tables, derived from their types.

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, schema_for};
use serde_json::{Map, Value};

use crate::conversion::CityDocument;
use crate::limits::{LimitRow, LimitsDocument};
use crate::link::{LinkDocument, LinkRow, LinksDocument};
use crate::live::LiveDocument;
use crate::repairs::{RepairRow, RepairsDocument};
use crate::track::{PointRow, StretchRow, TrackDocument};
use crate::zone_files::ZonesDocument;
use crate::{chart, comparison, jobs, map, placements, plos, sample, stress, survey};

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Name in the header.
    pub name: String,
    /// Meaning of its values, with their unit.
    pub meaning: String,
}

/// Returns the JSON Schema of each kind of document, by the word for the kind in its `schema`
/// member (`map` for `skyshed/map/1`).
///
/// A schema names every member: a document has no other.
pub fn documents() -> Vec<(&'static str, Value)> {
    vec![
        document::<map::AnyMapDocument>("map"),
        document::<map::HeightCurveDocument>("height-curve"),
        document::<map::OverTimeDocument>("over-time"),
        document::<jobs::PlannedUnit>("jobs-plan"),
        document::<jobs::StatusDocument>("jobs-status"),
        document::<jobs::MergeDocument>("jobs-merge"),
        document::<LinkDocument<'_>>("link"),
        document::<TrackDocument>("track"),
        document::<LinksDocument>("links"),
        document::<plos::PlosDocument<'_>>("plos"),
        document::<placements::SearchDocument<'_>>("place"),
        document::<sample::SampleDocument>("sample"),
        document::<comparison::CompareDocument>("compare"),
        document::<chart::AnyChartDocument>("chart"),
        document::<stress::StressDocument>("stress"),
        document::<stress::StressSceneDocument>("stress-scene"),
        document::<survey::InfoDocument<'_>>("info"),
        document::<survey::TilesProvenance>("tiles"),
        document::<ZonesDocument>("zones"),
        document::<LimitsDocument>("limits"),
        document::<CityDocument>("city"),
        document::<LiveDocument>("live"),
        document::<RepairsDocument>("repairs"),
    ]
}

/// Returns the columns of each kind of table, by the same words. A table leaves out columns that
/// none of its rows has.
pub fn tables() -> Vec<(&'static str, Vec<Column>)> {
    vec![
        ("map", columns::<map::MapRow>()),
        ("height-curve", columns::<map::CurveRow>()),
        ("over-time", columns::<map::TimeRow>()),
        ("jobs-merge", columns::<jobs::MergedRow>()),
        ("track", columns::<PointRow>()),
        ("stretches", columns::<StretchRow>()),
        ("links", columns::<LinkRow>()),
        ("plos", columns::<plos::PlosTableRow>()),
        ("place", columns::<placements::PlaceRow>()),
        ("sample", columns::<sample::SampleRow>()),
        ("compare", columns::<comparison::CompareRow>()),
        ("chart", columns::<chart::ChartTableRow>()),
        ("chart-plos", columns::<chart::PlosChartTableRow>()),
        ("stress", columns::<stress::StressRow>()),
        ("stress-scene", columns::<stress::StressSceneRow>()),
        ("tiles", columns::<survey::TileRow>()),
        ("limits", columns::<LimitRow>()),
        ("repairs", columns::<RepairRow>()),
    ]
}

fn document<T: JsonSchema>(kind: &'static str) -> (&'static str, Value) {
    // The schema describes written documents: a member that may be left out is not required.
    let generator = SchemaSettings::default().for_serialize().into_generator();
    let mut schema = generator.into_root_schema_for::<T>().to_value();
    close(&mut schema);
    schema["title"] = format!("skyshed/{kind}/1").into();
    (kind, schema)
}

/// Forbids members that the schema does not name.
fn close(schema: &mut Value) {
    match schema {
        Value::Object(object) => {
            object.values_mut().for_each(close);
            // A member that two flattened parts have is required once.
            if let Some(Value::Array(required)) = object.get_mut("required") {
                let mut seen = std::collections::HashSet::new();
                required.retain(|name| seen.insert(name.to_string()));
            }
            if object.get("properties").is_some_and(Value::is_object) && !object.contains_key("additionalProperties") {
                object.insert("additionalProperties".into(), false.into());
            }
        }
        Value::Array(values) => values.iter_mut().for_each(close),
        _ => {}
    }
}

fn columns<R: JsonSchema>() -> Vec<Column> {
    let schema = schema_for!(R);
    let fields = schema.get("properties").and_then(Value::as_object);
    let column = |(name, field): (&String, &Value)| {
        let meaning = field.get("description").and_then(Value::as_str).unwrap_or_default().to_string();
        Column { name: name.clone(), meaning }
    };
    fields.into_iter().flat_map(Map::iter).map(column).collect()
}
