//! JSON in which no object names a member twice. RFC 8259 leaves the meaning of such a text open:
//! some readers take the first value, some the last.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fmt;
use std::marker::PhantomData;

use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

/// Parses a JSON text.
///
/// # Errors
/// Faults of the text, and a member that an object names twice.
pub(super) fn parse(text: &str) -> serde_json::Result<Value> {
    serde_json::from_str::<Unique>(text).map(|Unique(value)| value)
}

/// Parses a feature; `None` for a text that is none, or whose members are named twice.
///
/// PERF: in one pass, where the type of `geojson` holds the whole feature twice.
pub(super) fn parse_feature(text: &str) -> Option<geojson::Feature> {
    /// Members of a feature that are looked at.
    #[derive(Deserialize)]
    struct Given {
        #[serde(rename = "type")]
        kind: String,
        #[serde(default, rename = "bbox")]
        _bbox: Option<geojson::Bbox>,
        #[serde(default)]
        id: Option<geojson::feature::Id>,
        #[serde(default)]
        geometry: Option<geojson::Geometry>,
        #[serde(default)]
        properties: Option<Unique>,
    }
    let Given { kind, id, geometry, properties, .. } = serde_json::from_str(text).ok()?;
    let properties = match properties {
        Some(Unique(Value::Object(members))) => Some(members),
        None => None,
        Some(_) => return None,
    };
    (kind == "Feature").then(|| geojson::Feature { id, geometry, properties, ..geojson::Feature::default() })
}

/// Value whose objects name each member once.
struct Unique(Value);

/// Members of an object that names each once.
pub(super) struct Members<V>(pub(super) HashMap<String, V>);

fn twice<E: Error>(name: &str) -> E {
    E::custom(format_args!("`{name}` is given twice"))
}

impl<'de, V: Deserialize<'de>> Deserialize<'de> for Members<V> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Of<V>(PhantomData<V>);
        impl<'de, V: Deserialize<'de>> Visitor<'de> for Of<V> {
            type Value = Members<V>;

            fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                out.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut given: A) -> Result<Members<V>, A::Error> {
                let mut members = HashMap::new();
                while let Some((name, value)) = given.next_entry::<String, V>()? {
                    match members.entry(name) {
                        Entry::Occupied(of) => return Err(twice(of.key())),
                        Entry::Vacant(of) => of.insert(value),
                    };
                }
                Ok(Members(members))
            }
        }
        deserializer.deserialize_map(Of(PhantomData))
    }
}

impl<'de> Deserialize<'de> for Unique {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Of;
        impl<'de> Visitor<'de> for Of {
            type Value = Value;

            fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                out.write_str("any JSON value")
            }

            fn visit_unit<E>(self) -> Result<Value, E> {
                Ok(Value::Null)
            }

            fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
                Ok(value.into())
            }

            fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
                Ok(value.into())
            }

            fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
                Ok(value.into())
            }

            fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
                Ok(value.into())
            }

            fn visit_str<E>(self, value: &str) -> Result<Value, E> {
                Ok(value.into())
            }

            fn visit_string<E>(self, value: String) -> Result<Value, E> {
                Ok(value.into())
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
                let mut values = Vec::new();
                while let Some(Unique(value)) = items.next_element()? {
                    values.push(value);
                }
                Ok(values.into())
            }

            fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<Value, A::Error> {
                let mut map = Map::new();
                while let Some((name, Unique(value))) = members.next_entry::<String, _>()? {
                    if map.contains_key(&name) {
                        return Err(twice(&name));
                    }
                    map.insert(name, value);
                }
                Ok(map.into())
            }
        }
        deserializer.deserialize_any(Of).map(Unique)
    }
}
