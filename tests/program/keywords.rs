//! Keywords of the Python package, with their types, as the requests have them.

use std::fmt::Write as _;
use std::path::Path;

use schemars::{JsonSchema, schema_for};
use serde_json::{Map, Value};
use skyshed_request as request;

/// Options that are parameters of their own, or the scene itself.
const PARAMETERS: [&str; 3] = ["scene", "output", "csv"];

/// Returns the options that no question of Python has.
fn no_keywords() -> Vec<&'static str> {
    [&PARAMETERS[..], &request::PROGRAM_OPTIONS].concat()
}

/// A class of keywords: its name, the class that it extends, its doc, and its members.
struct Keywords {
    name: &'static str,
    base: &'static str,
    doc: &'static str,
    members: Vec<(String, String, String)>,
}

impl Keywords {
    /// Returns the fields of a request; `left_out` are parameters of their own, or those of the class that is extended.
    fn of<T: JsonSchema>((name, base): (&'static str, &'static str), doc: &'static str, left_out: &[&str]) -> Keywords {
        let schema = serde_json::to_value(schema_for!(T)).expect("a schema");
        let defs = schema["$defs"].as_object().cloned().unwrap_or_default();
        let fields = schema["properties"].as_object().expect("fields");
        let members = fields.iter().filter(|(field, _)| !left_out.contains(&field.as_str())).map(|(field, schema)| {
            let meaning = schema["description"].as_str().expect("a description");
            let meaning = meaning.split("\n\n").next().unwrap_or_default().replace('\n', " ");
            let hint = hint(schema, &defs, field);
            // A field that is set has a value.
            let hint = if hint.contains("None") { hint } else { format!("{hint} | None") };
            (field.clone(), hint, meaning)
        });
        Keywords { name, base, doc, members: members.collect() }
    }

    fn text(&self) -> String {
        let mut text = format!("\n\nclass {}({}, total=False):\n    \"\"\"{}\n", self.name, self.base, self.doc);
        for (field, _, meaning) in &self.members {
            write!(text, "\n    * ``{field}``: {}", python_words(meaning)).expect("a text");
        }
        if self.base != "TypedDict" {
            write!(text, "\n\n    And those of :class:`{}`.", self.base).expect("a text");
        }
        text += "\n    \"\"\"\n\n";
        for (field, hint, _) in &self.members {
            writeln!(text, "    {field}: {hint}").expect("a text");
        }
        text
    }
}

/// Returns a help text with flags as keywords.
fn python_words(text: &str) -> String {
    let mut words = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("`--") {
        let end = rest[at + 3..].find('`').map_or(rest.len(), |end| at + 3 + end);
        words += &rest[..at];
        words += &format!("`{}", rest[at + 3..end].replace('-', "_"));
        rest = &rest[end..];
    }
    words + rest
}

/// Returns the type of a value, as Python has it.
fn hint(schema: &Value, defs: &Map<String, Value>, field: &str) -> String {
    if ["crs", "project"].contains(&field) {
        return "object".into();
    }
    if let Some(name) = schema["$ref"].as_str().and_then(|path| path.rsplit('/').next()) {
        return match name {
            "FilePath" | "Source" => "PathLike".into(),
            name => hint(&defs[name], defs, field),
        };
    }
    if let Some(any) = schema["anyOf"].as_array() {
        return joined(any.iter().map(|one| hint(one, defs, field)));
    }
    if let Some(words) = schema["enum"].as_array() {
        let words: Vec<String> = words.iter().filter(|word| !word.is_null()).map(Value::to_string).collect();
        return format!("Literal[{}]", words.join(", "));
    }
    match &schema["type"] {
        Value::Array(types) if types.iter().any(|kind| kind == "array") && schema.get("items").is_none() => {
            "float | str | Sequence[float | str]".into()
        }
        Value::Array(types) => joined(types.iter().map(|kind| {
            let one: Map<String, Value> =
                schema.as_object().into_iter().flatten().map(|(k, v)| (k.clone(), v.clone())).collect();
            hint(&Value::Object(one.into_iter().chain([("type".to_string(), kind.clone())]).collect()), defs, field)
        })),
        Value::String(kind) => match kind.as_str() {
            "integer" => "int".into(),
            "number" => "float".into(),
            "boolean" => "bool".into(),
            "null" => "None".into(),
            "array" if schema["minItems"].is_number() => "Sequence[float]".into(),
            "array" => {
                let one = hint(&schema["items"], defs, field);
                let is_list_in_words = one.starts_with("Literal") || one == "str";
                joined(
                    [one.clone(), format!("Sequence[{one}]")].into_iter().chain(is_list_in_words.then(|| "str".into())),
                )
            }
            _ => "str".into(),
        },
        other => panic!("{field}: no type of {other}"),
    }
}

fn joined(hints: impl Iterator<Item = String>) -> String {
    let mut parts: Vec<String> = Vec::new();
    for part in hints.flat_map(|hint| hint.split(" | ").map(String::from).collect::<Vec<_>>()) {
        if !parts.contains(&part) {
            parts.push(part);
        }
    }
    let is_none = parts.iter().any(|part| part == "None");
    parts.retain(|part| part != "None");
    parts.join(" | ") + if is_none { " | None" } else { "" }
}

/// Returns the names of the fields of a request.
fn names<T: JsonSchema>() -> Vec<String> {
    let schema = serde_json::to_value(schema_for!(T)).expect("a schema");
    schema["properties"].as_object().expect("fields").keys().cloned().collect()
}

/// Returns the keywords of a request over a scene in memory, without some.
fn of_request<T: JsonSchema>(name: &'static str, doc: &'static str, own: &[&str]) -> Keywords {
    let (of_scene, sight, all) = (names::<request::SceneOptions>(), names::<request::Sight>(), names::<T>());
    let has_sight = sight.iter().all(|field| all.contains(field));
    let of_base: &[String] = if has_sight { &sight } else { &[] };
    let left_out = of_scene.iter().chain(of_base).map(String::as_str).chain(no_keywords()).chain(own.iter().copied());
    let base = if has_sight { "SightKeywords" } else { "TypedDict" };
    Keywords::of::<T>((name, base), doc, &left_out.collect::<Vec<_>>())
}

/// Returns the module of keywords.
fn module() -> String {
    const OF_FILES: [&str; 3] = ["crs", "band", "terrain"];
    let of_scene = names::<request::SceneOptions>();
    let all_but = |kept: &[&str]| -> Vec<String> {
        of_scene.iter().filter(|name| !kept.contains(&name.as_str())).cloned().collect()
    };
    let scene = |name: &'static str, base: &'static str, doc: &'static str, left_out: Vec<String>| {
        Keywords::of::<request::SceneOptions>(
            (name, base),
            doc,
            &left_out.iter().map(String::as_str).collect::<Vec<_>>(),
        )
    };
    let any: Vec<String> = OF_FILES.iter().chain(&["size", "seed"]).map(ToString::to_string).collect();
    let sight = names::<request::Sight>();
    let sight: Vec<&str> = sight.iter().map(String::as_str).collect();
    let classes = [
        scene("AnySceneKeywords", "TypedDict", "Reading of any scene.", any),
        scene("FootprintKeywords", "AnySceneKeywords", "Reading of footprints in memory.", all_but(&["terrain"])),
        scene(
            "SceneKeywords",
            "FootprintKeywords",
            "Reading of a file: the options under *Scene* of ``skyshed map --help``.",
            all_but(&["crs", "band"]),
        ),
        Keywords::of::<request::Sight>(("SightKeywords", "TypedDict"), "Receivers, range, antennas and earth.", &[]),
        Keywords::of::<request::CoverageQuestion>(("MapKeywords", "SightKeywords"), "Question of maps.", &sight),
        Keywords::of::<request::SaveOptions>(("SaveKeywords", "TypedDict"), "Files of a map.", &[]),
        of_request::<request::LinkRequest>(
            "LinkKeywords",
            "Question of one link.",
            &["uav", "rx", "uavs", "rxs", "pairs", "los_only", "skip_bad", "bad_uavs"],
        ),
        of_request::<request::TrackRequest>(
            "TrackKeywords",
            "Question of a walk or a flight.",
            &["uav", "uavs", "track", "skip_bad"],
        ),
        of_request::<request::LimitsRequest>("LimitsKeywords", "Question of limits.", &["uav", "uavs", "skip_bad"]),
        of_request::<request::CompareRequest>(
            "CompareKeywords",
            "Question of placements side by side.",
            &["uav", "uavs", "skip_bad", "mask"],
        ),
        of_request::<request::ZonesRequest>("ZonesKeywords", "Picture of zones.", &[]),
        of_request::<request::CityRequest>("CityKeywords", "Files of a city.", &[]),
        of_request::<request::PlaceRequest>(
            "PlaceKeywords",
            "Question of where to hover.",
            &["height", "candidates", "within", "keep_out", "area"],
        ),
        of_request::<request::SampleRequest>("SampleKeywords", "Samples of placements.", &["zones", "height"]),
        Keywords::of::<request::InfoRequest>(("InfoKeywords", "TypedDict"), "Facts of a file.", &no_keywords()),
        Keywords::of::<request::PlosRequest>(
            ("PlosKeywords", "TypedDict"),
            "Question of P_LoS over whole cities.",
            &[no_keywords(), vec!["scenes", "height"]].concat(),
        ),
    ];
    let head = "\"\"\"Keywords of the questions, with their types: made from the requests of the program.\"\"\"\n\n\
        from __future__ import annotations\n\n\
        from collections.abc import Sequence\nfrom typing import Literal, TypedDict\n\n\
        from skyshed._options import PathLike\n";
    classes.iter().fold(head.to_string(), |text, class| text + &class.text())
}

#[test]
fn keywords_of_python_are_those_of_the_requests() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("python/skyshed/keywords.py");
    let wanted = module();
    if std::env::var_os("SKYSHED_WRITE_DOCS").is_some() {
        std::fs::write(&path, &wanted).expect("the module");
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == wanted, "{} is not that of the requests: SKYSHED_WRITE_DOCS=1 makes it anew", path.display());
}
