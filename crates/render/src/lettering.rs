//! Letters: the embedded font, the width of a text in it, and wrapping.
//!
//! Pictures never use the fonts of the machine. The two weights of Skyshed Sans (a subset of Inter under the SIL Open
//! Font License, see `fonts/OFL.txt`) are part of the program, and layout measures text with the very advance widths
//! that the rasterizer uses; kerning is ignored, which overestimates a width by a percent or two.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::{Arc, OnceLock};

use resvg::usvg::fontdb;

use super::sheet::Type;
use crate::error::is_text;

static REGULAR: &[u8] = include_bytes!("fonts/SkyshedSans-Regular.otf");
static SEMI_BOLD: &[u8] = include_bytes!("fonts/SkyshedSans-SemiBold.otf");

/// The family name in SVG text; what follows serves viewers that lack the font.
pub(crate) const FAMILY: &str = "Skyshed Sans, Inter, Helvetica, Arial, sans-serif";

/// A weight of the embedded font.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Weight {
    /// For captions and details.
    Regular,
    /// For titles and names.
    SemiBold,
}

/// Returns the font database with the embedded font and nothing else.
pub(crate) fn fonts() -> Arc<fontdb::Database> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    Arc::clone(FONTS.get_or_init(|| {
        let mut fonts = fontdb::Database::new();
        for data in [REGULAR, SEMI_BOLD] {
            fonts.load_font_source(fontdb::Source::Binary(Arc::new(data)));
        }
        Arc::new(fonts)
    }))
}

/// Returns the width of `text` \[px\] at the given font size \[px\].
pub(crate) fn width(text: &str, size: f64, weight: Weight) -> f64 {
    static ADVANCES: OnceLock<[Advances; 2]> = OnceLock::new();
    let advances = ADVANCES.get_or_init(|| [Advances::read(REGULAR), Advances::read(SEMI_BOLD)]);
    let advances = &advances[usize::from(weight == Weight::SemiBold)];
    text.chars().map(|c| advances.of(c)).sum::<f64>() * size / advances.units_per_em
}

/// Breaks `text` into lines no wider than `max_width` \[px\]: at spaces, and inside a word that is itself too wide.
pub(crate) fn wrap(text: &str, size: f64, weight: Weight, max_width: f64) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = String::new();
    for word in text.split(' ').filter(|word| !word.is_empty()) {
        let joined = if line.is_empty() { word.to_string() } else { format!("{line} {word}") };
        if width(&joined, size, weight) <= max_width {
            line = joined;
            continue;
        }
        if !line.is_empty() {
            lines.push(std::mem::take(&mut line));
        }
        for c in word.chars() {
            if !line.is_empty()
                && width(&line, size, weight) + width(c.encode_utf8(&mut [0; 4]), size, weight) > max_width
            {
                lines.push(std::mem::take(&mut line));
            }
            line.push(c);
        }
    }
    if !line.is_empty() {
        lines.push(line);
    }
    lines
}

/// `text` with its end left out where it is wider than `max_width` \[px\]: names may be of any length, pictures are not.
pub(crate) fn shortened(text: &str, style: Type, max_width: f64) -> String {
    let width = |text: &str| width(text, style.size, style.weight);
    if width(text) <= max_width {
        return text.to_string();
    }
    let mut short = String::new();
    let mut left = max_width - width("…");
    for c in text.chars() {
        left -= width(c.encode_utf8(&mut [0; 4]));
        if left < 0.0 {
            break;
        }
        short.push(c);
    }
    short + "…"
}

/// Escapes text for SVG; characters that XML forbids become spaces.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if is_text(c) => out.push(c),
            _ => out.push(' '),
        }
    }
    out
}

/// Writes a count with narrow spaces between groups of three digits, as legends do; for use in captions.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) && digits.len() > 4 {
            out.push('\u{202F}');
        }
        out.push(c);
    }
    out
}

/// Writes the share `part / whole` in percent with one decimal, never rounding a remainder away.
pub fn percent(part: u64, whole: u64) -> String {
    if whole == 0 {
        return "–".to_string();
    }
    let value = 100.0 * part as f64 / whole as f64;
    match (part, value) {
        (0, _) => "0 %".to_string(),
        (p, _) if p == whole => "100 %".to_string(),
        (_, v) if v < 0.05 => "< 0.1 %".to_string(),
        (_, v) if v >= 99.95 => "> 99.9 %".to_string(),
        (_, v) => format!("{v:.1} %"),
    }
    .replace(' ', "\u{202F}")
}

/// Writes a number with at most `decimals` decimals, without trailing zeros, and with a true minus sign.
pub(crate) fn number(value: f64, decimals: usize) -> String {
    let mut out = String::new();
    let _ = write!(out, "{value:.decimals$}");
    if out.contains('.') {
        out.truncate(out.trim_end_matches('0').trim_end_matches('.').len());
    }
    if out == "-0" { "0".to_string() } else { out.replace('-', "−") }
}

/// Writes a length with its unit: meters, or kilometers from 1 km on.
pub(crate) fn length(meters: f64) -> String {
    if meters >= 999.5 {
        format!("{} km", number(meters / 1000.0, if meters < 100_000.0 { 1 } else { 0 }))
    } else {
        format!("{} m", number(meters, if meters < 10.0 { 1 } else { 0 }))
    }
}

/// Advance widths by character, read from a font's `cmap` (format 4) and `hmtx` tables.
#[derive(Debug)]
struct Advances {
    units_per_em: f64,
    missing: u16,
    by_char: BTreeMap<u16, u16>,
}

impl Advances {
    fn read(font: &[u8]) -> Self {
        let u16_at = |at: usize| u16::from_be_bytes([font[at], font[at + 1]]);
        let u32_at = |at: usize| u32::from_be_bytes([font[at], font[at + 1], font[at + 2], font[at + 3]]) as usize;
        let table = |tag: &[u8; 4]| {
            let record = (0..usize::from(u16_at(4))).map(|i| 12 + 16 * i).find(|&at| &font[at..at + 4] == tag);
            u32_at(record.expect("the embedded font has this table") + 8)
        };
        let (cmap, hhea, hmtx) = (table(b"cmap"), table(b"hhea"), table(b"hmtx"));
        let n_long = usize::from(u16_at(hhea + 34));
        let advance = |glyph: u16| u16_at(hmtx + 4 * usize::from(glyph).min(n_long - 1));
        let format_4 = (0..usize::from(u16_at(cmap + 2)))
            .map(|i| cmap + u32_at(cmap + 8 + 8 * i))
            .find(|&at| u16_at(at) == 4)
            .expect("the embedded font maps the basic plane");
        let segments = usize::from(u16_at(format_4 + 6)) / 2;
        let mut by_char = BTreeMap::new();
        for s in 0..segments {
            let end = u16_at(format_4 + 14 + 2 * s);
            let start = u16_at(format_4 + 16 + 2 * (segments + s));
            let delta = u16_at(format_4 + 16 + 2 * (2 * segments + s));
            let offset_at = format_4 + 16 + 2 * (3 * segments + s);
            let offset = usize::from(u16_at(offset_at));
            for c in start..=end.min(0xFFFE) {
                let glyph = match offset {
                    0 => c.wrapping_add(delta),
                    _ => match u16_at(offset_at + offset + 2 * usize::from(c - start)) {
                        0 => 0,
                        glyph => glyph.wrapping_add(delta),
                    },
                };
                by_char.insert(c, advance(glyph));
            }
        }
        Self { units_per_em: f64::from(u16_at(table(b"head") + 18)), missing: advance(0), by_char }
    }

    fn of(&self, c: char) -> f64 {
        let advance = u16::try_from(u32::from(c)).ok().and_then(|c| self.by_char.get(&c));
        f64::from(*advance.unwrap_or(&self.missing))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use resvg::usvg;

    #[test]
    fn widths_agree_with_the_rasterizer() {
        for (weight, number) in [(Weight::Regular, 400), (Weight::SemiBold, 600)] {
            let text = "What a UAV sees: θ = 45°, 1 181 203 cells";
            let svg = format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"2000\" height=\"100\"><text x=\"0\" y=\"50\" \
                 font-family=\"Skyshed Sans\" font-size=\"40\" font-weight=\"{number}\">{text}</text></svg>"
            );
            let options = usvg::Options { fontdb: fonts(), ..usvg::Options::default() };
            let tree = usvg::Tree::from_str(&svg, &options).expect("the test text is valid SVG");
            let drawn = f64::from(tree.root().abs_bounding_box().width());
            let measured = width(text, 40.0, weight);
            assert!(drawn > 300.0 && (measured - drawn).abs() < 0.02 * drawn, "{weight:?}: {measured} and {drawn}");
        }
    }

    #[test]
    fn both_weights_are_found_by_name_and_number() {
        let fonts = fonts();
        for weight in [400, 600] {
            let query = fontdb::Query {
                families: &[fontdb::Family::Name("Skyshed Sans")],
                weight: fontdb::Weight(weight),
                ..fontdb::Query::default()
            };
            let face = fonts.query(&query).and_then(|id| fonts.face(id)).expect("the font is embedded");
            assert_eq!(face.weight.0, weight);
        }
    }

    #[test]
    fn wrapped_lines_fit_and_keep_every_word() {
        let text = "A caption that is long enough to need several lines, with Donaudampfschifffahrtsgesellschaft.";
        let lines = wrap(text, 22.0, Weight::Regular, 180.0);
        assert!(lines.len() > 3);
        assert!(lines.iter().all(|line| width(line, 22.0, Weight::Regular) <= 180.0));
        assert_eq!(lines.concat().replace(' ', ""), text.replace(' ', ""));
        assert!(wrap("", 22.0, Weight::Regular, 180.0).is_empty());
    }

    #[test]
    fn numbers_are_written_for_people() {
        assert_eq!(grouped(1_181_203), "1\u{202F}181\u{202F}203");
        assert_eq!((grouped(9_999).as_str(), grouped(0).as_str()), ("9999", "0"));
        assert_eq!((number(-2.50, 2).as_str(), number(-0.001, 1).as_str()), ("−2.5", "0"));
        assert_eq!(
            (length(0.5).as_str(), length(340.4).as_str(), length(1234.0).as_str()),
            ("0.5 m", "340 m", "1.2 km")
        );
        assert_eq!(percent(1, 100_000), "<\u{202F}0.1\u{202F}%");
        assert_eq!(percent(0, 0), "–");
    }

    #[test]
    fn markup_in_titles_is_text() {
        assert_eq!(escape("a<b & \"c\"\u{7}"), "a&lt;b &amp; &quot;c&quot; ");
    }
}
