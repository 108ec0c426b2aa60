//! docs/codes.md: what each code of an error or a warning means, from the words beside the values that have it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const HEAD: &str = "# Codes

Errors (`E…`) end a run; warnings (`W…`) do not. Codes are stable, texts are not. The first digit of an error is its cause and
fixes the exit code: 1 usage (2), 2 UAVs and other places (4), 3 and 4 files (3), 5 limits (5), 6 checks (6), 9 faults of the
program (1).

| code | for |
|---|---|
";

/// All files of sources below a folder.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            sources(&entry, found);
        } else if entry.extension().is_some_and(|e| e == "rs") {
            found.push(entry);
        }
    }
}

/// The meanings of a code in comments of the form `/// E123: an item.`, which stand above the variants of errors.
fn meanings() -> BTreeMap<String, Vec<String>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    ["src", "crates"].iter().for_each(|folder| sources(&root.join(folder), &mut files));
    files.sort();
    let mut found: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for file in files {
        let text = std::fs::read_to_string(file).unwrap();
        let mut lines = text.lines().map(str::trim).peekable();
        while let Some(line) = lines.next() {
            let Some((codes, words)) = line.strip_prefix("/// ").and_then(|line| line.split_once(": ")) else {
                continue;
            };
            let codes: Vec<&str> = codes.split(", ").collect();
            let is_code = |code: &&str| {
                code.len() == 4 && code.starts_with(['E', 'W']) && code[1..].bytes().all(|c| c.is_ascii_digit())
            };
            if !codes.iter().all(is_code) {
                continue;
            }
            let mut words = words.to_string();
            while let Some(more) = lines.peek().and_then(|line| line.strip_prefix("/// ")) {
                words = format!("{words} {more}");
                lines.next();
            }
            // What follows a semicolon says what the value holds.
            let words = words.split("; ").next().unwrap_or_default().trim_end_matches('.').replace('\\', "");
            for code in codes {
                let of_code = found.entry(code.to_string()).or_default();
                if !of_code.contains(&words) {
                    of_code.push(words.clone());
                }
            }
        }
    }
    found
}

#[test]
fn the_page_of_codes_is_what_the_sources_say() {
    let meanings = meanings();
    assert!(meanings.len() > 60, "{}", meanings.len());
    let sentence = |words: &String| words[..1].to_uppercase() + &words[1..];
    let row = |(code, words): (&String, &Vec<String>)| {
        format!("| {code} | {} |\n", words.iter().map(sentence).collect::<Vec<_>>().join(". "))
    };
    let rows: String = meanings.iter().map(row).collect();
    let wanted = format!("{HEAD}{rows}");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/codes.md");
    if std::env::var_os("SKYSHED_WRITE_DOCS").is_some() {
        std::fs::write(&path, &wanted).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == wanted, "docs/codes.md: run with SKYSHED_WRITE_DOCS=1");
}
