//! Command line of a run, and the question that it asks.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};
use skyshed_request::json;

/// Command line and question of a run.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub(crate) struct CommandFacts {
    /// Words of the command line after the program's name; empty for a call of the library.
    command: Vec<String>,
    /// The question: every option that was set, by the name of its flag.
    #[serde(skip_serializing_if = "Option::is_none")]
    request: Option<Map<String, Value>>,
}

impl CommandFacts {
    /// Returns the facts of a run: its words, and the set members of its request, if it has one. Options
    /// of the run are left out, and secrets in addresses.
    pub(crate) fn of(command: Vec<String>, members: Option<Map<String, Value>>) -> CommandFacts {
        let told = |(name, value)| (name, without_secrets(value));
        let request = members.map(|members| json::question(members).into_iter().map(told).collect());
        CommandFacts { command, request }
    }
}

/// Returns a value whose addresses hold no user, no query and no fragment.
fn without_secrets(value: Value) -> Value {
    match value {
        Value::String(text) => skyshed_io::told(text.as_ref()).to_string_lossy().into(),
        Value::Array(values) => values.into_iter().map(without_secrets).collect(),
        value => value,
    }
}
