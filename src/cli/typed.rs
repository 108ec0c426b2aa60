//! What was typed, as opposed to left at its default.

use std::path::PathBuf;

use clap::ArgMatches;
use clap::parser::ValueSource;
use skyshed_request::FilePath;

use super::failure::{Result, refusal};

/// Returns the paths that an argument names; none of an argument of another type.
pub(super) fn paths_of(matches: &ArgMatches, id: &str) -> Vec<PathBuf> {
    let of_requests = matches.try_get_many::<FilePath>(id).ok().flatten();
    let of_requests = of_requests.into_iter().flatten().map(|path| path.0.clone());
    of_requests.chain(matches.try_get_many::<PathBuf>(id).ok().flatten().into_iter().flatten().cloned()).collect()
}

/// What was typed, as opposed to left at its default.
#[derive(Debug, Default)]
pub(super) struct Typed {
    /// The names of the arguments.
    names: Vec<String>,
    /// The files that they name, other than the scene and that of repairs.
    pub(super) files: Vec<PathBuf>,
}

impl Typed {
    pub(super) fn of(matches: &ArgMatches) -> Typed {
        let ids = || matches.ids().map(|id| id.as_str());
        let is_typed = |id: &&str| matches.value_source(id) == Some(ValueSource::CommandLine);
        Typed {
            names: ids().filter(is_typed).map(str::to_string).collect(),
            files: ids()
                .filter(|id| !["repairs", "scene", "scenes"].contains(id))
                .flat_map(|id| paths_of(matches, id))
                .collect(),
        }
    }

    /// Whether an argument was typed.
    pub(super) fn has(&self, name: &str) -> bool {
        self.names.iter().any(|typed| typed == name)
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
