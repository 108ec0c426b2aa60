//! Requests as JSON, as canonical JSON, and as words of a command line.

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::Fault;

/// A request that cannot be read from JSON: the member at fault, and the reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MemberFault {
    /// Name of the member.
    pub member: String,
    /// Reason; `None` if there is no such member.
    pub reason: Option<String>,
}

/// Returns the set fields of a request, in the order of their definition.
pub fn set_members(request: &impl Serialize) -> Map<String, Value> {
    let value = serde_json::to_value(request).unwrap_or_default();
    let Value::Object(members) = value else { return Map::new() };
    members.into_iter().filter(|(_, value)| !is_unset(value)).collect()
}

fn is_unset(value: &Value) -> bool {
    match value {
        Value::Null | Value::Bool(false) => true,
        Value::Array(members) => members.is_empty(),
        _ => false,
    }
}

/// Returns the members of a request that its answer depends on: all but names of files to write,
/// `overwrite`, effort, memory, and how units of work are handed out.
pub fn question(members: Map<String, Value>) -> Map<String, Value> {
    let parts = [
        serde_json::to_value(crate::Files::default()),
        serde_json::to_value(crate::Effort::default()),
        serde_json::to_value(crate::Table::default()),
        serde_json::to_value(crate::Repairs::default()),
        serde_json::to_value(crate::MapMemory::default()),
    ];
    let is_of_run = |name: &str| {
        ["height_curve", "over_time", "overwrite", "resume", "shard"].contains(&name)
            || parts.iter().flatten().any(|part| part.get(name).is_some())
    };
    members.into_iter().filter(|(name, _)| !is_of_run(name)).collect()
}

/// Refuses the members of a list that are set.
///
/// # Errors
/// E116, with the reason why they change nothing.
pub fn refuse(members: &Map<String, Value>, names: &[&'static str], why: &str) -> crate::Result<()> {
    match names.iter().find(|name| members.contains_key(**name)) {
        Some(name) => Err(Fault::idle(*name, why)),
        None => Ok(()),
    }
}

/// Refuses all set members but those of a list.
///
/// # Errors
/// E116, with the reason why they change nothing.
pub fn refuse_others(members: &Map<String, Value>, names: &[&str], why: &str) -> crate::Result<()> {
    match members.keys().find(|name| !names.contains(&name.as_str())) {
        Some(name) => Err(Fault::idle(name.clone(), why)),
        None => Ok(()),
    }
}

/// Reads a request.
///
/// # Errors
/// The first member that does not exist, or has a value that cannot be.
pub fn from_members<T: Serialize + DeserializeOwned>(members: Map<String, Value>) -> Result<T, MemberFault> {
    let read = |members: Map<String, Value>| serde_json::from_value::<T>(Value::Object(members));
    let alone = |(name, value): (&String, &Value)| [(name.clone(), value.clone())].into_iter().collect::<Map<_, _>>();
    let request = read(members.clone()).map_err(|error| {
        // A flattened struct does not say which member was wrong.
        let culprit = members.iter().find_map(|member| Some((member.0, read(alone(member)).err()?)));
        let (member, reason) =
            culprit.map_or((String::new(), error.to_string()), |(name, e)| (name.clone(), e.to_string()));
        MemberFault { member, reason: Some(reason) }
    })?;
    let known = set_members(&request);
    match members.iter().find(|(name, value)| !is_unset(value) && !known.contains_key(*name)) {
        Some((name, _)) => Err(MemberFault { member: name.clone(), reason: None }),
        None => Ok(request),
    }
}

/// Reads a request from the keywords of another language. A number may stand for a text with a unit, one
/// value for a list, and a list for a text with commas.
///
/// # Errors
/// The first keyword that does not exist, or has a value that cannot be.
pub fn from_keywords<T>(keywords: Map<String, Value>) -> Result<T, MemberFault>
where
    T: Serialize + DeserializeOwned + Default,
{
    let names = serde_json::to_value(T::default()).unwrap_or_default();
    let mut members = Map::new();
    let is_set = |value: &Value| !matches!(value, Value::Null | Value::Bool(false));
    for (name, value) in keywords.into_iter().filter(|(_, value)| is_set(value)) {
        if value.as_array().is_some_and(Vec::is_empty) {
            return Err(MemberFault { member: name, reason: Some("found none, wanted at least one".into()) });
        }
        if names.get(&name).is_none() {
            return Err(MemberFault { member: name, reason: None });
        }
        let read = |value: &Value| {
            serde_json::from_value::<T>(Value::Object([(name.clone(), value.clone())].into_iter().collect()))
        };
        let mut reasons: Vec<String> = Vec::new();
        let fitting = spellings(&name, value).into_iter().find(|value| match read(value) {
            Ok(_) => true,
            Err(error) => {
                reasons.push(error.to_string());
                false
            }
        });
        let Some(fitting) = fitting else {
            let reason = reasons.iter().position(|reason| reason.contains("wanted")).unwrap_or(0);
            return Err(MemberFault { member: name, reason: reasons.into_iter().nth(reason) });
        };
        members.insert(name, fitting);
    }
    from_members(members)
}

/// Returns the values that a keyword may mean, as it is written first. Commas part the members of a list,
/// unless these may hold commas themselves.
fn spellings(name: &str, value: Value) -> Vec<Value> {
    let parts = |parts: Vec<Value>| Value::Array(parts);
    let as_text = |value: &Value| Value::String(text(value));
    let others = match &value {
        Value::Number(_) => vec![as_text(&value), parts(vec![value.clone()]), parts(vec![as_text(&value)])],
        Value::String(list) => {
            let number = list.trim().parse::<serde_json::Number>().ok().map(Value::Number);
            let of_list = parts(list.split(',').map(|part| Value::String(part.trim().into())).collect());
            let one = parts(vec![value.clone()]);
            let lists = if REPEATED.contains(&name) { [one, of_list] } else { [of_list, one] };
            number.into_iter().chain(lists).collect()
        }
        Value::Array(members) => vec![parts(members.iter().map(as_text).collect()), as_text(&value)],
        _ => Vec::new(),
    };
    std::iter::once(value).chain(others).collect()
}

/// Returns the canonical JSON of a planned question (RFC 8785): keys in order, shortest digits, no
/// blanks. Equal questions have equal texts.
pub fn canonical(question: &impl Serialize) -> String {
    serde_json_canonicalizer::to_string(question).unwrap_or_default()
}

/// Returns the members of a question with the defaults of its fields: a default that was set and one that
/// was not are equal.
pub fn filled_members<T: Serialize + Default>(question: &T) -> Map<String, Value> {
    let names = serde_json::to_value(T::default()).unwrap_or_default();
    let mut members = set_members(question);
    for (name, value) in crate::defaults() {
        if names.get(&name).is_some() {
            members.entry(name).or_insert(value);
        }
    }
    members
}

/// Members that name files, beside the scene and its list of repairs.
const FILES: [&str; 17] = [
    "area",
    "candidates",
    "csv",
    "data_area",
    "height_curve",
    "keep_out",
    "map",
    "mask",
    "output",
    "over_time",
    "rxs",
    "stretches",
    "terrain",
    "track",
    "uavs",
    "weights",
    "within",
];
/// Files that are written.
const WRITTEN: [&str; 6] = ["csv", "height_curve", "map", "output", "over_time", "stretches"];

/// Returns the files that a request names, beside the scene and its list of repairs.
pub fn files(members: &Map<String, Value>) -> Vec<&str> {
    let named = members.iter().filter(|(name, _)| FILES.contains(&name.as_str()));
    let paths = named.flat_map(|(name, value)| texts(value).into_iter().map(move |path| (name, path)));
    paths.filter(|(name, path)| *name != "data_area" || !["auto", "all"].contains(path)).map(|(_, path)| path).collect()
}

/// Returns the files that a request reads, beside the scene.
pub fn files_read(members: &Map<String, Value>) -> Vec<&str> {
    let written: Vec<&str> = WRITTEN.iter().filter_map(|name| members.get(*name)).flat_map(texts).collect();
    files(members).into_iter().filter(|path| !written.contains(path)).collect()
}

fn texts(value: &Value) -> Vec<&str> {
    match value {
        Value::Array(values) => values.iter().filter_map(Value::as_str).collect(),
        value => value.as_str().into_iter().collect(),
    }
}

/// Returns a command line: the command, its scenes, and the flags that set other members.
pub fn command_line(command: &str, mut members: Map<String, Value>) -> Vec<String> {
    let scenes: Vec<String> =
        ["scene", "scenes"].iter().filter_map(|name| members.get(*name)).flat_map(texts).map(String::from).collect();
    // The scenes of `stress` are a number.
    members.retain(|name, value| !["scene", "scenes"].contains(&name.as_str()) || value.is_number());
    std::iter::once(command.to_string()).chain(scenes).chain(words(&members)).collect()
}

/// Lists whose members may hold commas: their flags are repeated.
const REPEATED: [&str; 9] = ["curve", "height_curve", "mask", "output", "over_time", "rx", "stretches", "tile", "uav"];

/// Returns the flags that set members of a request, in their order.
pub fn words(members: &Map<String, Value>) -> Vec<String> {
    let mut words = Vec::new();
    let mut push = |name: &str, value: String| {
        let flag = format!("--{}", name.replace('_', "-"));
        // A value may begin as a flag does.
        match value.starts_with('-') {
            true => words.push(format!("{flag}={value}")),
            false => words.extend([flag, value]),
        }
    };
    for (name, value) in members {
        match value {
            Value::Array(values) if REPEATED.contains(&name.as_str()) => {
                values.iter().for_each(|value| push(name, text(value)));
            }
            value => push(name, text(value)),
        }
    }
    words.into_iter().filter(|word| !word.is_empty()).collect()
}

/// Returns a value as it is typed; nothing for a switch.
pub(crate) fn text(value: &Value) -> String {
    match value {
        Value::Bool(_) | Value::Null => String::new(),
        Value::String(text) => text.clone(),
        Value::Array(values) => values.iter().map(text).collect::<Vec<_>>().join(","),
        Value::Number(number) => number.as_f64().map_or_else(|| number.to_string(), |number| number.to_string()),
        value => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Range, Receivers};

    #[test]
    fn members_are_read_and_a_wrong_one_is_named() {
        let of = |text: &str| from_members::<Range>(serde_json::from_str(text).expect("an object"));
        let range = of(r#"{"receivers": "roof", "radius": 300, "method": null}"#).expect("a range");
        assert_eq!(range, Range { receivers: Some(Receivers::Roof), radius: Some(300.0), method: None });
        let fault = of(r#"{"receivers": "rof"}"#).expect_err("no such word");
        assert_eq!(fault.member, "receivers");
        assert!(fault.reason.is_some_and(|reason| reason.contains("wanted ground, street")));
        assert_eq!(of(r#"{"x": 1}"#), Err(MemberFault { member: "x".into(), reason: None }));
        assert_eq!(words(&set_members(&range)), ["--receivers", "roof", "--radius", "300"]);
    }

    #[test]
    fn keywords_may_be_written_in_several_ways() {
        use crate::{CoverageQuestion, Heights, Layer, PlaceQuestion};
        let of = |text: &str| from_keywords::<CoverageQuestion>(serde_json::from_str(text).expect("an object"));
        let layers = |text: &str| of(text).map(|question| question.map.layers);
        let both = Ok(vec![Layer::Los, Layer::Margin]);
        assert_eq!(layers(r#"{"layers": "los,margin"}"#), both);
        assert_eq!(layers(r#"{"layers": ["los", "margin"]}"#), both);
        assert_eq!(layers(r#"{"layers": "los", "radius": null, "zones": false}"#), Ok(vec![Layer::Los]));
        let sight =
            of(r#"{"radius": "300", "rx_height": "5ft", "earth_k": 1.2, "sector": [10, 20]}"#).expect("a sight").sight;
        assert_eq!((sight.range.radius, sight.receiver.rx_height_m()), (Some(300.0), 1.524));
        assert_eq!(sight.antenna.sector, Some([10.0, 20.0]));
        let heights = |text: &str| {
            let place: PlaceQuestion =
                from_keywords(serde_json::from_str(text).expect("an object")).expect("a question");
            place.candidates.height
        };
        let wanted = |text: &str| text.parse::<Heights>().ok();
        assert_eq!(heights(r#"{"height": 60}"#), wanted("60"));
        assert_eq!(heights(r#"{"height": [60, "30roof"]}"#), wanted("60,30roof"));
        assert_eq!(heights(r#"{"height": "60:120:20"}"#), wanted("60:120:20"));
        let plos: crate::PlosRequest = from_keywords(
            serde_json::from_str(r#"{"method": "product,itu", "curve": "a=b,c.csv"}"#).expect("an object"),
        )
        .expect("a request");
        assert_eq!((plos.plos.method.len(), plos.plos.curve.len()), (2, 1));
        let fault = of(r#"{"receivers": 5}"#).expect_err("no such word");
        assert!(
            fault.member == "receivers"
                && fault.reason.is_some_and(|reason| reason.contains("found `5`, wanted ground"))
        );
        assert_eq!(of(r#"{"radiuss": 5}"#), Err(MemberFault { member: "radiuss".into(), reason: None }));
    }

    #[test]
    fn one_number_has_one_canonical_spelling() {
        let of = |radius| canonical(&Range { radius: Some(radius), ..Range::default() });
        assert_eq!(of(1e21), r#"{"method":null,"radius":1e+21,"receivers":null}"#);
        assert_eq!(of(-0.0), of(0.0));
    }
}
