//! Text that several commands share: documents, titles.

/// A document as indented text with a final line break.
pub(super) fn pretty(document: &serde_json::Value) -> String {
    format!("{document:#}\n")
}

/// A name as a title: capitalized, and no line break inside `β = 500/km²`.
pub(super) fn title_of(name: &str) -> String {
    let mut letters = name.chars();
    let name: String = letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect());
    unbreakable(&name)
}

/// Text whose equations and units are not broken across lines.
pub(super) fn unbreakable(text: &str) -> String {
    text.replace(" = ", "\u{a0}=\u{a0}").replace(" m;", "\u{a0}m;")
}
