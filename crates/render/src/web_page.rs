//! Parts that all web pages share: a template with marks, and data in scripts.

use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::{Compression, GzBuilder};
use serde_json::Value;
use sha2::{Digest, Sha256};

/// Script that writes shares and numbers.
pub(crate) const SHARES: &str = include_str!("web_page/shares.js");

/// Replaces the marks `{{name}}` of a template in one pass, so that words of the user are never
/// taken for a mark.
///
/// # Panics
/// If it has a mark without a part.
pub(crate) fn filled(template: &str, parts: &[(&str, String)]) -> String {
    let mut out = String::new();
    let mut rest = template;
    while let Some((before, (name, after))) = rest.split_once("{{").and_then(|(b, a)| Some((b, a.split_once("}}")?))) {
        let part = parts.iter().find(|(part, _)| *part == name);
        out += before;
        out += part.map(|(_, text)| text.as_str()).expect("the template has no other marks");
        rest = after;
    }
    out + rest
}

/// Returns the policy of a page that loads nothing and runs only these scripts.
pub(crate) fn policy(scripts: &[&str]) -> String {
    let digest = |script: &&str| format!("'sha256-{}' ", STANDARD.encode(Sha256::digest(script)));
    let scripts: String = scripts.iter().map(digest).collect();
    format!(
        "default-src 'none'; script-src {scripts}'wasm-unsafe-eval'; worker-src blob:; style-src 'unsafe-inline'; \
         img-src data: blob:; base-uri 'none'; form-action 'none'"
    )
}

/// Writes JSON that no HTML parser takes for the end of its script.
pub(crate) fn in_script(value: &Value) -> String {
    value.to_string().replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029")
}

/// Packs bytes as gzip, at its best compression; browsers unpack them.
pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut gzip = GzBuilder::new().write(Vec::new(), Compression::best());
    // Writing to a vector does not fail.
    gzip.write_all(bytes).and_then(|()| gzip.finish()).unwrap_or_default()
}
