//! The live page as one file: markup, style and script, the engine, and a packed city.
//!
//! A policy in its head forbids the browser to fetch anything, and to run any script but the one
//! whose digest it holds. So words of the data cannot become a script.

use serde_json::Value;

use super::lettering::escape;
use super::web_page::{SHARES, filled, gzip, in_script, policy};

const TEMPLATE: &str = include_str!("live_page/page.html");
const STYLE: &str = include_str!("live_page/page.css");
/// Parts of the script, each of which uses parts before it.
const SCRIPTS: [&str; 30] = [
    include_str!("live_page/types.js"),
    SHARES,
    include_str!("live_page/texts.js"),
    include_str!("live_page/elements.js"),
    include_str!("live_page/colors.js"),
    include_str!("live_page/state.js"),
    include_str!("live_page/words.js"),
    include_str!("live_page/address.js"),
    include_str!("live_page/asking.js"),
    include_str!("live_page/coverage.js"),
    include_str!("live_page/gl_painter.js"),
    include_str!("live_page/canvas_painter.js"),
    include_str!("live_page/view.js"),
    include_str!("live_page/overlay.js"),
    include_str!("live_page/gestures.js"),
    include_str!("live_page/readout.js"),
    include_str!("live_page/chart.js"),
    include_str!("live_page/side_view.js"),
    include_str!("live_page/track_view.js"),
    include_str!("live_page/fields.js"),
    include_str!("live_page/curve.js"),
    include_str!("live_page/best.js"),
    include_str!("live_page/results.js"),
    include_str!("live_page/panel.js"),
    include_str!("live_page/sheet.js"),
    include_str!("live_page/kept.js"),
    include_str!("live_page/files.js"),
    include_str!("live_page/picture.js"),
    include_str!("live_page/save.js"),
    include_str!("live_page/main.js"),
];
/// Script of the worker, which holds the engine.
const WORKER: &str = include_str!("live_page/worker.js");
/// Engine as WebAssembly with vectors of 128 bits, gzipped by `scripts/engine`, which also checks
/// it against the sources.
const ENGINE: &[u8] = include_bytes!("live_page/engine.wasm.gz");

/// Content of a live page.
#[derive(Debug, Clone, Copy)]
pub struct LivePage<'a> {
    /// Title of its window.
    pub title: &'a str,
    /// Program and its version.
    pub generator: &'a str,
    /// Facts that the script reads.
    pub facts: &'a Value,
    /// The city, packed for the engine.
    pub scene: &'a [u8],
}

/// Writes the page.
pub fn live_page(page: &LivePage<'_>) -> String {
    let script = script();
    let parts = [
        ("policy", policy(&[&script])),
        ("generator", page.generator.to_string()),
        ("title", escape(page.title)),
        ("css", without_spaces(&without_comments(STYLE))),
        ("js", script),
        ("worker", without_comments(WORKER)),
        ("facts", in_script(page.facts)),
        ("scene", base85(&gzip(page.scene))),
        ("engine", base85(ENGINE)),
    ];
    filled(TEMPLATE, &parts)
}

/// Returns the script of every live page.
pub(crate) fn script() -> String {
    // The script has many arrow functions, and no text of it holds an arrow.
    SCRIPTS.iter().map(|script| without_comments(script)).collect::<String>().replace(" => ", "=>")
}

/// Writes bytes as text of a script: five digits for four bytes, a sixteenth shorter than base 64.
/// Digit d is the character d places after `(`, but `}` for `<`, so that no tag can begin.
fn base85(bytes: &[u8]) -> String {
    let mut out = String::with_capacity(bytes.len() / 4 * 5 + 5);
    for group in bytes.chunks(4) {
        let mut word = [0; 4];
        word[..group.len()].copy_from_slice(group);
        let word = u32::from_be_bytes(word);
        // A group of fewer bytes keeps one digit more than it has bytes; a decoder takes 84 for the
        // digits left out.
        out.extend([52_200_625, 614_125, 7_225, 85, 1].into_iter().take(group.len() + 1).map(|power| {
            match b'(' + u8::try_from(word / power % 85).unwrap_or_default() {
                b'<' => '}',
                sign => char::from(sign),
            }
        }));
    }
    out
}

/// Removes spaces without meaning from a style.
fn without_spaces(style: &str) -> String {
    let mut out = style.replace('\n', " ");
    for mark in ["{", "}", ";", ","] {
        out = out.replace(&format!(" {mark}"), mark).replace(&format!("{mark} "), mark);
    }
    out.replace(": ", ":").replace(";}", "}")
}

/// Removes comments at the beginnings of lines, types within lines and indents from a script or a
/// style, a third of it. Texts that span lines are shaders, which lose theirs, too.
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
        if line.is_empty() || line.starts_with("//") {
            continue;
        }
        while let Some((code, (_, rest))) =
            line.split_once("/** @").and_then(|(code, of)| Some((code, of.split_once("*/")?)))
        {
            out += code;
            line = rest.trim_start();
        }
        out += line;
        out.push('\n');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::cast_possible_truncation, reason = "the bytes of a word are cut out of it")]
    fn words_of_85_signs_hold_all_bytes() {
        let decoded = |text: &str| {
            let digits: Vec<u32> = text.chars().map(|c| if c == '}' { 20 } else { u32::from(c) - 40 }).collect();
            let word = |five: &[u32]| (0..5).fold(0_u64, |sum, k| sum * 85 + u64::from(*five.get(k).unwrap_or(&84)));
            let group = |five: &[u32]| (word(five) as u32).to_be_bytes()[..five.len() - 1].to_vec();
            digits.chunks(5).flat_map(group).collect::<Vec<u8>>()
        };
        let bytes: Vec<u8> = (0..5003_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        for cut in [0, 1, 2, 3, 4, 5, 255, 5003] {
            let text = base85(&bytes[..cut]);
            assert_eq!(decoded(&text), bytes[..cut]);
            assert!(!text.contains(['<', '&', ' ']));
        }
        assert_eq!(decoded(&base85(&[255; 7])), [255; 7]);
    }

    #[test]
    fn comments_go_and_code_stays() {
        let source =
            "// A word.\n/** @type {x} */ let a = 1; // kept\n/**\n * More.\n */\n/* 1 */ /* 2 */\n  b(); /* c */\n";
        assert_eq!(without_comments(source), "let a = 1; // kept\nb(); /* c */\n");
    }
}
