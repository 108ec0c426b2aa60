//! Requests from options by their names, as another program has them.

use clap::error::{ContextKind, ContextValue, ErrorKind as ParserFault};
use clap::{Args, Command, FromArgMatches};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use skyshed_request::json;

use super::failure::{Failure, Result, refusal};
use super::refusal;
use crate::error::Error;

/// Options by their names, as JSON.
pub type Members = serde_json::Map<String, Value>;

/// Reads a request, or a part of one, from options by their names. Flags check what their types do not: ranges, and options that need
/// or exclude each other.
pub(super) fn read<T>(members: Members) -> Result<T>
where
    T: Args + FromArgMatches + Serialize + DeserializeOwned + Default,
{
    let flags = || T::augment_args(Command::new("skyshed")).disable_help_flag(true);
    let words = |members| json::command_line("skyshed", members);
    let checked = |members| flags().try_get_matches_from(words(members)).map(|_| ());
    match json::from_keywords::<T>(members.clone()) {
        Ok(request) => {
            let set = json::set_members(&request);
            let Err(error) = checked(set.clone()) else { return Ok(request) };
            let without = |name: &String| -> Members {
                let others = set.iter().filter(|(other, _)| *other != name);
                others.map(|(name, value)| (name.clone(), value.clone())).collect()
            };
            let culprit = set.keys().find(|name| checked(without(name)).is_ok());
            match (error.kind(), culprit) {
                (ParserFault::MissingRequiredArgument, Some(name)) => {
                    let needed = missing_in(&error);
                    Err(Error::idle(name.clone(), format!("without `{needed}`")).into())
                }
                _ => Err(refused(&error)),
            }
        }
        Err(fault) => {
            let name = fault.member;
            let Some(reason) = fault.reason else {
                let known = serde_json::to_value(T::default()).unwrap_or_default();
                let names = known.as_object().into_iter().flat_map(|members| members.keys().map(String::as_str));
                let mut names: Vec<&str> = names.collect();
                names.sort_unstable();
                return Err(refusal(101, format!("found the option `{name}`, wanted one of {}", names.join(", "))));
            };
            if !reason.contains("wanted") && members[&name].is_number() {
                // The parser of words knows numbers that are out of range.
                checked([(name.clone(), members[&name].clone())].into_iter().collect()).map_err(|e| refused(&e))?;
            }
            Err(refusal(101, format!("`{name}`: {}", in_plain_words(&reason))))
        }
    }
}

/// Returns the reason of a value that has another type, without the names of types.
fn in_plain_words(reason: &str) -> String {
    const WORDS: [(&str, &str); 8] = [
        ("invalid type: ", "found "),
        ("invalid value: ", "found "),
        ("expected f64", "wanted a number"),
        ("expected u64", "wanted a whole number"),
        ("expected u32", "wanted a whole number"),
        ("expected u16", "wanted a whole number"),
        ("expected a boolean", "wanted True or False"),
        ("expected an array of length", "wanted numbers, as many as"),
    ];
    WORDS.iter().fold(reason.to_string(), |text, (from, to)| text.replace(from, to))
}

/// Returns the name of the first option that an error of the parser misses.
fn missing_in(error: &clap::Error) -> String {
    match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::Strings(flags)) => {
            let flag = flags.first().map_or("", |flag| flag.split(' ').next().unwrap_or_default());
            flag.trim_start_matches('-').replace('-', "_")
        }
        _ => String::new(),
    }
}

/// Returns what the parser of words refuses.
fn refused(error: &clap::Error) -> Failure {
    refusal::answer(error).err().unwrap_or_else(|| refusal::in_words(&error.to_string()))
}
