//! What was typed, as opposed to left at its default.

use std::path::PathBuf;

use clap::ArgMatches;
use clap::parser::ValueSource;

use super::failure::{Result, refusal};

/// Arguments whose values are text, whatever they look like.
const TEXTS: [&str; 10] = [
    "title",
    "attribution",
    "layer",
    "band",
    "crs",
    "height_field",
    "top_field",
    "base_field",
    "levels_field",
    "height_error_field",
];

/// What was typed, as opposed to left at its default.
#[derive(Debug, Default)]
pub(super) struct Typed {
    /// The names of the arguments.
    names: Vec<String>,
    /// The files that they name, other than the scene and that of repairs.
    pub(super) files: Vec<PathBuf>,
    /// The words of each, in the order of the names.
    words: Vec<Vec<String>>,
}

impl Typed {
    pub(super) fn of(matches: &ArgMatches) -> Typed {
        let ids = || matches.ids().map(|id| id.as_str());
        let is_typed = |id: &&str| matches.value_source(id) == Some(ValueSource::CommandLine);
        let files_of = |id| matches.try_get_many::<PathBuf>(id).ok().flatten();
        let words_of = |id| {
            let raw = matches.get_raw(id).into_iter().flatten();
            raw.map(|word| word.to_string_lossy().into_owned()).collect()
        };
        Typed {
            names: ids().filter(is_typed).map(str::to_string).collect(),
            words: ids().filter(is_typed).map(words_of).collect(),
            files: ids().filter(|id| *id != "repairs").filter_map(files_of).flatten().cloned().collect(),
        }
    }

    /// Whether an argument was typed.
    pub(super) fn has(&self, name: &str) -> bool {
        self.names.iter().any(|typed| typed == name)
    }

    /// The flags of some names that were typed, with their words, as they may be typed again.
    pub(super) fn flags(&self, names: &[String]) -> Vec<String> {
        let typed = self.names.iter().zip(&self.words).filter(|(name, _)| names.contains(name));
        let flag = |name: &str| format!("--{}", name.replace('_', "-"));
        typed.flat_map(|(name, words)| std::iter::once(flag(name)).chain(words.iter().cloned())).collect()
    }

    /// The flags that were typed but some, each as one word or with its words joined by commas, as they may be typed again; in the
    /// order of their names, whatever that of the words was, with numbers in one spelling.
    pub(super) fn flags_but(&self, names: &[&str]) -> Vec<String> {
        let is_flag = |name: &str| name.starts_with(char::is_lowercase) && !names.contains(&name);
        let mut typed: Vec<(&String, &Vec<String>)> =
            self.names.iter().zip(&self.words).filter(|(name, _)| is_flag(name)).collect();
        typed.sort();
        let flag = |(name, words): (&String, &Vec<String>)| {
            // One number has many spellings, but a text has one.
            let is_text = TEXTS.contains(&name.as_str());
            let number = |word: &String| word.parse::<f64>().ok().filter(|_| !is_text);
            let spelled = |word: &String| number(word).map_or_else(|| word.clone(), |number| number.to_string());
            let words: Vec<String> = words.iter().map(spelled).collect();
            let value = if words == ["true"] && !is_text { Vec::new() } else { vec![words.join(",")] };
            std::iter::once(format!("--{}", name.replace('_', "-"))).chain(value).collect::<Vec<_>>()
        };
        typed.into_iter().flat_map(flag).collect()
    }

    /// Refuses those of some arguments that were typed.
    ///
    /// # Errors
    /// E116, with `why` they have no meaning.
    pub(super) fn refuse(&self, names: &[&str], why: &str) -> Result<()> {
        self.refuse_if(|name| names.contains(&name), why)
    }

    /// Refuses all but some.
    ///
    /// # Errors
    /// E116.
    pub(super) fn refuse_others(&self, names: &[&str], why: &str) -> Result<()> {
        self.refuse_if(|name| !names.contains(&name), why)
    }

    fn refuse_if(&self, is_refused: impl Fn(&str) -> bool, why: &str) -> Result<()> {
        // Groups of arguments have names too, which begin with a capital.
        let is_flag = |name: &&String| name.starts_with(char::is_lowercase);
        match self.names.iter().filter(is_flag).find(|name| is_refused(name)) {
            Some(name) => Err(refusal(116, format!("`--{}` has no meaning {why}", name.replace('_', "-")))),
            None => Ok(()),
        }
    }
}
