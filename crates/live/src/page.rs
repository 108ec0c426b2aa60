//! The page as one file: markup, style and script, the engine, and a packed city.
//!
//! A policy in its head forbids the browser to fetch anything, and to run any script but the one whose digest it names: so
//! words of the data cannot become one.

use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::{Compression, GzBuilder};
use serde_json::Value;
use sha2::{Digest, Sha256};

const TEMPLATE: &str = include_str!("../page/page.html");
const STYLE: &str = include_str!("../page/page.css");
/// The script is in parts, of which each uses those before it.
const SCRIPTS: [&str; 27] = [
    include_str!("../page/types.js"),
    include_str!("../page/texts.js"),
    include_str!("../page/elements.js"),
    include_str!("../page/colors.js"),
    include_str!("../page/state.js"),
    include_str!("../page/words.js"),
    include_str!("../page/address.js"),
    include_str!("../page/asking.js"),
    include_str!("../page/coverage.js"),
    include_str!("../page/gl_painter.js"),
    include_str!("../page/canvas_painter.js"),
    include_str!("../page/view.js"),
    include_str!("../page/overlay.js"),
    include_str!("../page/gestures.js"),
    include_str!("../page/readout.js"),
    include_str!("../page/chart.js"),
    include_str!("../page/side_view.js"),
    include_str!("../page/curve.js"),
    include_str!("../page/best.js"),
    include_str!("../page/results.js"),
    include_str!("../page/panel.js"),
    include_str!("../page/sheet.js"),
    include_str!("../page/kept.js"),
    include_str!("../page/files.js"),
    include_str!("../page/picture.js"),
    include_str!("../page/save.js"),
    include_str!("../page/main.js"),
];
/// What unpacks the engine, and what asks it.
const WORKER: [&str; 2] = [include_str!("../page/lzma.js"), include_str!("../page/worker.js")];
/// The engine as WebAssembly, with and without vectors of 128 bits, packed together: made by `scripts/engine`, which also says
/// how to see that it is what the sources give.
const ENGINE: &[u8] = include_bytes!("../page/engine.lzma");
/// Lengths of both before they were packed.
const ENGINE_LENGTHS: &str = include_str!("../page/engine.lengths");

/// What a page is made of.
#[derive(Debug, Clone, Copy)]
pub struct Page<'a> {
    /// The title of its window.
    pub title: &'a str,
    /// The program and its version.
    pub generator: &'a str,
    /// What the script is told.
    pub facts: &'a Value,
    /// The city, by [`crate::pack::pack`].
    pub scene: &'a [u8],
}

impl Page<'_> {
    /// The page.
    pub fn html(&self) -> String {
        let script: String = SCRIPTS.iter().map(|script| without_comments(script)).collect();
        let digest = STANDARD.encode(Sha256::digest(&script));
        let policy = format!(
            "default-src 'none'; script-src 'sha256-{digest}' 'wasm-unsafe-eval'; worker-src blob:; style-src \
             'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'"
        );
        filled(&[
            ("policy", &policy),
            ("generator", self.generator),
            ("title", &escaped(self.title)),
            ("css", &without_comments(STYLE)),
            ("js", &script),
            ("worker", &WORKER.map(without_comments).concat()),
            // In a script element nothing ends but by `</`.
            ("facts", &self.facts.to_string().replace('<', "\\u003c")),
            ("scene", &STANDARD.encode(gzip(self.scene))),
            ("engine", &format!("{ENGINE_LENGTHS} {}", STANDARD.encode(ENGINE))),
        ])
    }
}

/// A script or a style without comments at the beginnings of lines and without indents, which are a third of it. Texts that
/// span lines are shaders, which lose theirs, too.
fn without_comments(source: &str) -> String {
    let mut out = String::with_capacity(source.len());
    let mut is_comment = false;
    for mut line in source.lines().map(str::trim) {
        while is_comment || line.starts_with("/*") {
            let rest = line.split_once("*/").map(|(_, rest)| rest.trim());
            is_comment = rest.is_none();
            line = rest.unwrap_or_default();
            if is_comment {
                break;
            }
        }
        if !line.is_empty() && !line.starts_with("//") {
            out += line;
            out.push('\n');
        }
    }
    out
}

/// Bytes as gzip packs them best.
pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut gzip = GzBuilder::new().write(Vec::new(), Compression::best());
    // A vector takes all.
    gzip.write_all(bytes).and_then(|()| gzip.finish()).unwrap_or_default()
}

/// Words as text in markup.
fn escaped(words: &str) -> String {
    words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The template with its marks replaced, in one pass, so that what is filled in is never taken for a mark.
fn filled(parts: &[(&str, &str)]) -> String {
    let mut out = String::new();
    let mut rest = TEMPLATE;
    while let Some((before, after)) = rest.split_once("{{") {
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        out += before;
        out += parts.iter().find(|(mark, _)| *mark == name).map_or("", |(_, text)| text);
        rest = after;
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_go_and_code_stays() {
        let source =
            "// A word.\n/** @type {x} */ let a = 1; // kept\n/**\n * More.\n */\n/* 1 */ /* 2 */\n  b(); /* c */\n";
        assert_eq!(without_comments(source), "let a = 1; // kept\nb(); /* c */\n");
    }
}
