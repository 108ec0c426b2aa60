//! Letters: the embedded font, the width of a text in it, and wrapping.
//!
//! Pictures never use the fonts of the machine. The two weights of Skyshed Sans are part of the
//! program: a subset of Inter under the SIL Open Font License, see `fonts/OFL.txt`. Layout measures
//! text with the advance widths that the rasterizer uses. Kerning is ignored, which overestimates a
//! width by a percent or two.

use std::sync::{Arc, OnceLock};

use resvg::usvg::fontdb;
use skyshed_core::error::is_text;
use ttf_parser::Face;

static REGULAR: &[u8] = include_bytes!("fonts/SkyshedSans-Regular.otf");
static SEMI_BOLD: &[u8] = include_bytes!("fonts/SkyshedSans-SemiBold.otf");

/// Font family in SVG text; the names after the first serve viewers that lack the font.
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

/// Position of the reference point of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    /// At its left end.
    Start,
    /// In its middle.
    Middle,
    /// At its right end.
    End,
}

/// Style of a text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Type {
    /// Font size \[px\].
    pub(crate) size: f64,
    /// Weight.
    pub(crate) weight: Weight,
    /// SVG color.
    pub(crate) color: &'static str,
    /// Reference point.
    pub(crate) anchor: Anchor,
}

impl Type {
    /// Returns the width of a text \[px\].
    pub(crate) fn width(self, text: &str) -> f64 {
        static FACES: OnceLock<[Face<'static>; 2]> = OnceLock::new();
        let faces = FACES.get_or_init(|| [REGULAR, SEMI_BOLD].map(|font| Face::parse(font, 0).expect("it is a font")));
        let face = &faces[usize::from(self.weight == Weight::SemiBold)];
        let advance = |c: char| face.glyph_hor_advance(face.glyph_index(c).unwrap_or_default()).unwrap_or_default();
        text.chars().map(|c| f64::from(advance(c))).sum::<f64>() * self.size / f64::from(face.units_per_em())
    }

    /// Breaks a text into lines no wider than `max_width` \[px\]: at spaces, and inside words that
    /// are too wide themselves.
    pub(crate) fn wrap(self, text: &str, max_width: f64) -> Vec<String> {
        let mut lines = Vec::new();
        let mut line = String::new();
        for word in text.split(' ').filter(|word| !word.is_empty()) {
            let joined = if line.is_empty() { word.to_string() } else { format!("{line} {word}") };
            if self.width(&joined) <= max_width {
                line = joined;
                continue;
            }
            if !line.is_empty() {
                lines.push(std::mem::take(&mut line));
            }
            for c in word.chars() {
                if !line.is_empty() && self.width(&line) + self.width(c.encode_utf8(&mut [0; 4])) > max_width {
                    lines.push(std::mem::take(&mut line));
                }
                line.push(c);
            }
        }
        lines.extend((!line.is_empty()).then_some(line));
        lines
    }

    /// Cuts off the end of a text that is wider than `max_width` \[px\]: names may be of any
    /// length, pictures are not.
    pub(crate) fn shortened(self, text: &str, max_width: f64) -> String {
        if self.width(text) <= max_width {
            return text.to_string();
        }
        let mut left = max_width - self.width("…");
        let fits = |c: &char| {
            left -= self.width(c.encode_utf8(&mut [0; 4]));
            left >= 0.0
        };
        text.chars().take_while(fits).chain(['…']).collect()
    }
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

/// Returns a name with its first letter capitalized.
pub fn capitalized(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Writes a count with narrow spaces between groups of three digits, as legends do; for use in
/// captions.
pub fn grouped(n: u64) -> String {
    let mut out = n.to_string();
    if out.len() > 4 {
        (1..out.len()).rev().skip(2).step_by(3).for_each(|at| out.insert(at, '\u{202F}'));
    }
    out
}

/// Writes the share `part / whole` in percent with one decimal, never rounding a remainder away.
///
/// Halves are rounded up, by integers, as `web_page/shares.js` does in pages, so that one count has
/// one share everywhere.
pub fn percent(part: u64, whole: u64) -> String {
    if whole == 0 {
        return "–".to_string();
    }
    // Tenths of a percent, halves up: the same digits here and on pages.
    let tenths = (u128::from(part) * 2000 + u128::from(whole)) / (u128::from(whole) * 2);
    match tenths {
        _ if part == 0 => "0 %".to_string(),
        _ if part == whole => "100 %".to_string(),
        0 => "< 0.1 %".to_string(),
        1000.. => "> 99.9 %".to_string(),
        _ => format!("{}.{} %", tenths / 10, tenths % 10),
    }
    .replace(' ', "\u{202F}")
}

/// Writes a number with at most `decimals` decimals, without trailing zeros, and with a true minus
/// sign.
pub(crate) fn number(value: f64, decimals: usize) -> String {
    let mut out = format!("{value:.decimals$}");
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

#[cfg(test)]
mod tests {
    use super::*;
    use resvg::usvg;

    const fn style(size: f64, weight: Weight) -> Type {
        Type { size, weight, color: "#000000", anchor: Anchor::Start }
    }

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
            let measured = style(40.0, weight).width(text);
            assert!(drawn > 300.0 && (measured - drawn).abs() < 0.02 * drawn, "{weight:?}: {measured} and {drawn}");
        }
    }

    #[test]
    fn wrapped_lines_fit_and_keep_every_word() {
        let text = "A caption that is long enough to need several lines, with Donaudampfschifffahrtsgesellschaft.";
        let style = style(22.0, Weight::Regular);
        let lines = style.wrap(text, 180.0);
        assert!(lines.len() > 3 && lines.iter().all(|line| style.width(line) <= 180.0));
        assert_eq!(lines.concat().replace(' ', ""), text.replace(' ', ""));
        assert!(style.wrap("", 180.0).is_empty());
    }

    #[test]
    fn numbers_are_written_for_people_and_markup_is_text() {
        for (text, expected) in [
            (grouped(1_181_203), "1\u{202F}181\u{202F}203"),
            (grouped(9_999), "9999"),
            (number(-2.50, 2), "−2.5"),
            (number(-0.001, 1), "0"),
            (length(0.5), "0.5 m"),
            (length(340.4), "340 m"),
            (length(1234.0), "1.2 km"),
            (percent(1, 100_000), "<\u{202F}0.1\u{202F}%"),
            (percent(0, 0), "–"),
            (percent(637, 1000), "63.7\u{202F}%"),
            // Ties; 3 / 2000 as a double is below its half.
            (percent(1, 400), "0.3\u{202F}%"),
            (percent(3, 2000), "0.2\u{202F}%"),
            (percent(1, 2000), "0.1\u{202F}%"),
            (percent(1999, 2000), ">\u{202F}99.9\u{202F}%"),
            (escape("a<b & \"c\"\u{7}"), "a&lt;b &amp; &quot;c&quot; "),
        ] {
            assert_eq!(text, expected);
        }
    }
}
