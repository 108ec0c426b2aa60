//! What a machine can see of how documents and doc comments read: long pages, long sentences, private openings.

use std::path::{Path, PathBuf};

/// Longest sentence \[words\].
const LONGEST: usize = 40;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn text_of(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// All files below a folder whose names end so.
fn files(folder: &str, end: &str) -> Vec<PathBuf> {
    let (mut found, mut folders) = (Vec::new(), vec![root().join(folder)]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
            let path = entry.path();
            match entry.file_type().expect("a type").is_dir() {
                true if entry.file_name() != "target" => folders.push(path),
                true => {}
                false if path.to_string_lossy().ends_with(end) => found.push(path),
                false => {}
            }
        }
    }
    found.sort();
    found
}

/// Every page of the repository.
fn pages() -> Vec<PathBuf> {
    let at_root = ["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md"].map(|name| root().join(name));
    let folders = ["docs", "tests", "benches", "maps", "fuzz"].into_iter().flat_map(|folder| files(folder, ".md"));
    at_root.into_iter().chain(folders).collect()
}

/// The paragraphs, items and cells of a page, without code and addresses.
fn passages(page: &str) -> Vec<String> {
    let (mut passages, mut passage, mut in_code) = (Vec::new(), String::new(), false);
    let mut flush =
        |passage: &mut String| passages.extend(Some(std::mem::take(passage)).filter(|p| !p.trim().is_empty()));
    for line in page.lines() {
        let line = line.trim();
        if line.starts_with("```") {
            in_code = !in_code;
            flush(&mut passage);
            continue;
        }
        let is_item = line.starts_with("* ")
            || line.starts_with("- ")
            || line.split_once(". ").is_some_and(|(n, _)| n.parse::<u32>().is_ok());
        if in_code || line.is_empty() || is_item || line.starts_with(['#', '|']) {
            flush(&mut passage);
        }
        if in_code || line.starts_with("<!--") {
            continue;
        }
        if line.starts_with('|') {
            passages_of_row(line, &mut flush);
        } else if line.starts_with('#') {
            flush(&mut plain(line.trim_start_matches('#')));
        } else {
            passage.push_str(line.trim_start_matches("* ").trim_start_matches("- "));
            passage.push(' ');
        }
    }
    flush(&mut passage);
    passages.iter().map(|passage| plain(passage)).collect()
}

fn passages_of_row(row: &str, flush: &mut impl FnMut(&mut String)) {
    row.split(" | ").for_each(|cell| flush(&mut cell.trim_matches(['|', ' ']).to_string()));
}

/// A passage without code, addresses, tags and marks of emphasis; a word stands for a piece of code.
fn plain(passage: &str) -> String {
    let mut out = String::new();
    for (k, part) in passage.split('`').enumerate() {
        out.push_str(if k % 2 == 0 { part } else { "code" });
    }
    let without = |text: &str, open: &str, close: char| {
        let mut parts = text.split(open);
        let first = parts.next().unwrap_or_default().to_string();
        parts.fold(first, |out, part| out + part.split_once(close).map_or("", |(_, rest)| rest))
    };
    let out = without(&without(&out, "](", ')'), "<", '>');
    let out = out.split_whitespace().filter(|word| !word.contains("://")).collect::<Vec<_>>().join(" ");
    out.replace(['*', '[', ']', '!'], "")
}

/// The sentences of a passage.
fn sentences(passage: &str) -> Vec<String> {
    let (mut sentences, mut sentence) = (Vec::new(), Vec::new());
    let words: Vec<&str> = passage.split_whitespace().filter(|word| word.contains(char::is_alphanumeric)).collect();
    for (k, word) in words.iter().enumerate() {
        sentence.push(*word);
        let ends = word.trim_end_matches([')', '”', '"']).ends_with(['.', '?', ':', ';']);
        let begins = words.get(k + 1).is_none_or(|next| next.starts_with(|c: char| !c.is_lowercase()));
        if ends && begins {
            sentences.push(std::mem::take(&mut sentence).join(" "));
        }
    }
    sentences.extend((!sentence.is_empty()).then(|| sentence.join(" ")));
    sentences
}

fn n_words(text: &str) -> usize {
    text.split_whitespace().count()
}

/// Longest sentence of a doc comment, in words; a formula or a piece of code is one word.
const LONGEST_OF_COMMENTS: usize = 30;

/// Sources whose doc comments are checked.
fn checked_sources() -> Vec<PathBuf> {
    let crates =
        ["core", "io", "live", "python", "render", "request", "study"].map(|name| format!("crates/{name}/src"));
    crates.iter().map(String::as_str).chain(["src"]).flat_map(|folder| files(folder, ".rs")).collect()
}

/// The paragraphs and list items of a doc comment, without code and tables.
fn paragraphs(comment: &str) -> Vec<String> {
    let mut paragraphs = vec![String::new()];
    let mut is_code = false;
    for line in comment.lines().map(str::trim) {
        let is_fence = line.starts_with("```");
        is_code ^= is_fence;
        let is_left_out = is_fence || is_code || line.starts_with(['#', '|']);
        let item = ["* ", "- "].iter().find_map(|mark| line.strip_prefix(mark));
        let numbered = line.split_once(". ").filter(|(mark, _)| mark.parse::<u8>().is_ok()).map(|(_, rest)| rest);
        match item.or(numbered) {
            _ if is_left_out || line.is_empty() => paragraphs.push(String::new()),
            Some(rest) => paragraphs.push(rest.to_string()),
            None => {
                if let Some(last) = paragraphs.last_mut() {
                    *last += &format!(" {line}");
                }
            }
        }
    }
    paragraphs.retain(|paragraph| !paragraph.trim().is_empty());
    paragraphs
}

/// The doc comments of a source: each with the line where it begins.
fn doc_comments(source: &str) -> Vec<(usize, String)> {
    let mut comments: Vec<(usize, String)> = Vec::new();
    let mut is_going_on = false;
    for (k, line) in source.lines().enumerate() {
        let text = line.trim_start();
        let text = text.strip_prefix("///").or_else(|| text.strip_prefix("//!"));
        match (text, is_going_on, comments.last_mut()) {
            (Some(text), true, Some((_, comment))) => *comment += &format!("\n{}", text.trim()),
            (Some(text), ..) => comments.push((k + 1, text.trim().to_string())),
            (None, ..) => {}
        }
        is_going_on = text.is_some();
    }
    comments
}

#[test]
fn the_two_pages_that_everybody_reads_are_short() {
    for (page, most) in [("README.md", 1200), ("ARCHITECTURE.md", 1000)] {
        let text = text_of(page);
        assert!(n_words(&text) <= most, "{page}: {} words", n_words(&text));
    }
}

#[test]
fn no_sentence_of_a_page_is_long() {
    let mut long = Vec::new();
    for page in pages() {
        for sentence in passages(&text_of(&page)).iter().flat_map(|passage| sentences(passage)) {
            if n_words(&sentence) > LONGEST {
                long.push(format!("{} ({} words): {sentence}", page.display(), n_words(&sentence)));
            }
        }
    }
    assert!(long.is_empty(), "{}", long.join("\n"));
}

#[test]
fn no_doc_comment_needs_the_item_above_it() {
    let mut found = Vec::new();
    for path in ["src", "crates", "tests", "benches", "examples"].into_iter().flat_map(|folder| files(folder, ".rs")) {
        for (line, comment) in doc_comments(&text_of(&path)) {
            if ["The same", "Likewise", "As above", "Ditto", "See above"]
                .iter()
                .any(|banned| comment.starts_with(banned))
            {
                found.push(format!("{}:{line}: {}", path.display(), comment.lines().next().unwrap_or_default()));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn no_doc_comment_opens_with_a_riddle() {
    const RIDDLES: [&str; 9] = ["What", "How", "Whether", "Where", "Which", "Those", "Whom", "Whose", "They"];
    let mut found = Vec::new();
    for path in checked_sources() {
        for (line, comment) in doc_comments(&text_of(&path)) {
            let first = comment.split(|c: char| !c.is_alphanumeric()).find(|word| !word.is_empty());
            if first.is_some_and(|word| RIDDLES.contains(&word)) {
                found.push(format!("{}:{line}: {}", path.display(), comment.lines().next().unwrap_or_default()));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn no_sentence_of_a_doc_comment_is_long() {
    let mut found = Vec::new();
    for path in checked_sources() {
        for (line, comment) in doc_comments(&text_of(&path)) {
            let paragraphs = paragraphs(&comment);
            for sentence in paragraphs.iter().flat_map(|paragraph| sentences(&plain(paragraph))) {
                if n_words(&sentence) > LONGEST_OF_COMMENTS {
                    found.push(format!("{}:{line}: {} words: {sentence}", path.display(), n_words(&sentence)));
                }
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn crates_of_one_maintainer_are_named_in_two_folders() {
    let names = [
        "tiff_reader",
        "tiff_writer",
        "tiff_core",
        "geotiff_core",
        "lerc_reader",
        "lerc_core",
        "proj_core",
        "proj_wkt",
    ];
    let is_named = |path: &PathBuf| names.iter().any(|name| text_of(path).contains(&format!("{name}::")));
    let folders = ["crates/io/src/formats/geotiff", "crates/io/src/crs"].map(|folder| root().join(folder));
    let outside = checked_sources().into_iter().filter(is_named);
    let outside: Vec<_> = outside.filter(|path| folders.iter().all(|folder| !path.starts_with(folder))).collect();
    assert_eq!(outside, Vec::<PathBuf>::new());
}

#[test]
fn no_source_file_is_long() {
    const MOST_LINES: usize = 500;
    let long = ["crates", "src", "tests", "examples"]
        .into_iter()
        .flat_map(|folder| files(folder, ".rs"))
        .filter(|path| text_of(path).lines().count() > MOST_LINES);
    assert_eq!(long.collect::<Vec<_>>(), Vec::<PathBuf>::new());
}
