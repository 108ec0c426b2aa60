//! What a command refuses, and that each of its flags is shown at work.

#![allow(dead_code, reason = "each binary uses a part")]

use crate::program::Folder;

/// Asserts that each line is refused with a code, the exit code of its class and some words in the first line, and that it
/// writes nothing.
pub(crate) fn check_refusals(folder: &Folder, command: &str, cases: &[(&str, &str, &str)]) {
    let before = folder.files();
    for (line, code, named) in cases {
        let answer = folder.type_in(&format!("{command} {line}"));
        let exit_code = match &code[..2] {
            "E1" => 2,
            "E2" => 4,
            "E5" => 5,
            _ => 3,
        };
        let lines = answer.refused(exit_code);
        assert_eq!(answer.error(), *code, "{line}: {lines:?}");
        assert!(lines[0].contains(named), "{line}: {lines:?}");
        assert_eq!(folder.files(), before, "{line}");
    }
}

/// Asserts that every flag in the help of a command is a word of the flags that are shown at work.
pub(crate) fn check_flags_are_known(folder: &Folder, command: &str, known: &[&str]) {
    let words: Vec<&str> = known.iter().flat_map(|words| words.split(' ')).collect();
    for flag in folder.flags(command) {
        assert!(words.contains(&flag.as_str()), "{command} {flag}: add it to the flags above, with a test");
    }
}
