//! Errors of the library as those of Python, in whose words options have no dashes.

use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;
use skyshed::ErrorKind;
use skyshed::cli::Refusal;

/// Why something has no answer.
#[derive(Debug)]
pub(crate) enum Failure {
    Refused(Refusal),
    /// An exception of Python.
    Python(PyErr),
    /// A fault of this library.
    Fault(String),
}

impl From<Refusal> for Failure {
    fn from(refusal: Refusal) -> Failure {
        Failure::Refused(refusal)
    }
}

impl From<skyshed::Error> for Failure {
    fn from(error: skyshed::Error) -> Failure {
        Failure::Refused(error.into())
    }
}

impl From<skyshed_io::Error> for Failure {
    fn from(error: skyshed_io::Error) -> Failure {
        Failure::Refused(error.into())
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Failure {
        Failure::Python(error)
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> PyErr {
        match failure {
            Failure::Refused(refusal) => Python::attach(|py| raised(py, &refusal)),
            Failure::Python(error) => error,
            Failure::Fault(what) => PyRuntimeError::new_err(format!("skyshed has a fault: {what}")),
        }
    }
}

fn raised(py: Python<'_>, refusal: &Refusal) -> PyErr {
    static ERROR: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    static FILE_ERROR: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    if refusal.kind == ErrorKind::Interrupted {
        return PyKeyboardInterrupt::new_err(());
    }
    let class = match refusal.kind {
        ErrorKind::File => FILE_ERROR.import(py, "skyshed._errors", "FileError"),
        _ => ERROR.import(py, "skyshed._errors", "Error"),
    };
    let hint = refusal.hint.as_deref().map(in_python);
    match class.and_then(|class| class.call1((in_python(&refusal.text), refusal.code.as_str(), hint))) {
        Ok(error) => PyErr::from_value(error),
        Err(error) => error,
    }
}

/// A text in which the options of the command line are named as arguments: `--rx-height` becomes `rx_height`, and in backticks
/// `--project auto` becomes `project="auto"`. Commands of the shell stay.
pub(crate) fn in_python(text: &str) -> String {
    let is_balanced = text.matches('`').count().is_multiple_of(2);
    let piece = |(k, piece): (usize, &str)| match k % 2 == 1 && is_balanced {
        true if piece.starts_with('-') => arguments(piece),
        true => piece.to_string(),
        false => named(piece),
    };
    text.split('`').enumerate().map(piece).collect::<Vec<_>>().join("`")
}

/// Options with their values as arguments.
fn arguments(options: &str) -> String {
    /// Options that are on or off.
    const SWITCHES: [&str; 5] = ["overwrite", "skip_bad", "resume", "strips", "hash"];
    let mut words = options.split(' ').peekable();
    let mut arguments = Vec::new();
    while let Some(option) = words.next() {
        let name = if option == "-o" { "output".into() } else { option.trim_start_matches('-').replace('-', "_") };
        arguments.push(match words.next_if(|word| !word.starts_with('-')) {
            Some(value) => format!("{name}={}", literal(value)),
            None if SWITCHES.contains(&name.as_str()) => format!("{name}=True"),
            None => name,
        });
    }
    arguments.join(", ")
}

/// A value as Python writes it; one capital letter stands for a number, longer words for a text.
fn literal(value: &str) -> String {
    let is_number =
        |part: &str| part.parse::<f64>().is_ok() || part.len() == 1 && part.chars().all(|c| c.is_ascii_uppercase());
    let parts: Vec<&str> = value.split(',').collect();
    match parts.iter().all(|part| is_number(part)) {
        true if parts.len() == 1 => value.to_string(),
        true => format!("({})", parts.join(", ")),
        false => value.split('|').map(|way| format!("\"{way}\"")).collect::<Vec<_>>().join("|"),
    }
}

/// A text outside of backticks, its options without dashes.
fn named(text: &str) -> String {
    let mut told = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("--") {
        let is_word_before = rest[..at].ends_with(|c: char| c.is_alphanumeric() || c == '-');
        let name: String = rest[at + 2..].chars().take_while(|c| c.is_ascii_lowercase() || *c == '-').collect();
        told.push_str(&rest[..at]);
        if is_word_before || name.is_empty() {
            told.push_str("--");
        }
        told.push_str(&name.replace('-', "_"));
        rest = &rest[at + 2 + name.len()..];
    }
    told + rest
}
