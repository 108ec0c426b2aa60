//! Lines of three numbers.

use std::io::{BufRead, BufReader, Read};

use crate::error::{Cause, Error, MOST_FOUND, Place, Result, shortened};
use crate::input::{Input, cannot_read};

/// Longest line \[bytes\].
const MOST_LINE_BYTES: u64 = 1024;
/// Most lines before the first point.
const MOST_HEADING_LINES: u64 = 16;

/// Points of a file, one after the other.
pub(super) struct Points<'a> {
    input: &'a Input,
    reader: BufReader<Box<dyn Read>>,
    bytes: Vec<u8>,
    /// Number of lines that were read.
    line: u64,
    has_begun: bool,
}

impl<'a> Points<'a> {
    pub(super) fn open(input: &'a Input) -> Result<Points<'a>> {
        let reader = BufReader::with_capacity(1 << 18, input.stream()?);
        Ok(Points { input, reader, bytes: Vec::new(), line: 0, has_begun: false })
    }

    /// Returns the number of the line of the last point.
    pub(super) fn line(&self) -> u64 {
        self.line
    }

    /// Reads the next point; `None` at the end.
    ///
    /// # Errors
    /// E302 for a line that is no point.
    pub(super) fn next(&mut self) -> Result<Option<[f64; 3]>> {
        loop {
            self.bytes.clear();
            let mut line = self.reader.by_ref().take(MOST_LINE_BYTES + 1);
            if line.read_until(b'\n', &mut self.bytes).map_err(|e| cannot_read(self.input, &e))? == 0 {
                return Ok(None);
            }
            self.line += 1;
            if let Some([x, y, z]) = point(&self.bytes)
                && x.is_finite()
                && y.is_finite()
            {
                self.has_begun = true;
                return Ok(Some([x, y, z]));
            }
            if !self.is_passed_over() {
                return Err(self.fault());
            }
        }
    }

    /// Returns `true` for a line without a word, and for one of the heading.
    fn is_passed_over(&self) -> bool {
        let is_heading = || !self.has_begun && self.line <= MOST_HEADING_LINES && is_heading(&self.bytes);
        self.bytes.len() as u64 <= MOST_LINE_BYTES && (words(&self.bytes).next().is_none() || is_heading())
    }

    /// Returns the error of a line that is no point.
    fn fault(&self) -> Error {
        let text = String::from_utf8_lossy(&self.bytes);
        let text = text.trim();
        let fault = |what: String| Error::malformed(self.input, what).at(Place::Line(self.line));
        if self.bytes.len() as u64 > MOST_LINE_BYTES {
            return fault(format!("it has more than {MOST_LINE_BYTES} bytes, wanted x, y and z"));
        }
        let shown = shortened(text, MOST_FOUND);
        // Commas between other separators are those of decimals.
        let n_outer = text.split(|c: char| c.is_whitespace() || c == ';').filter(|word| !word.is_empty()).count();
        let error = fault(format!("`{shown}` is no point of a grid, wanted the three numbers x, y and z"));
        match text.contains(',') && n_outer == 3 {
            true => error.because(Cause::DecimalCommas),
            false => error,
        }
    }
}

/// Returns `true` for bytes between numbers.
fn is_separator(byte: u8) -> bool {
    byte.is_ascii_whitespace() || matches!(byte, b',' | b';')
}

/// Returns the words of a line, without a byte-order mark.
fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
    line.split(|byte| is_separator(*byte)).filter(|word| !word.is_empty())
}

fn number(word: &[u8]) -> Option<f64> {
    short_decimal(word).or_else(|| std::str::from_utf8(word).ok()?.parse().ok())
}

/// Returns a number of at most 15 digits without an exponent, as all positions are written. Its
/// digits and the power of ten below them are exact, so their quotient is rounded once, as parsing
/// rounds (Clinger 1990).
fn short_decimal(word: &[u8]) -> Option<f64> {
    const MOST_DIGITS: usize = 15;
    const POWERS: [f64; MOST_DIGITS + 1] =
        [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];
    let digits = word.strip_prefix(b"-").unwrap_or(word);
    if digits.len() > MOST_DIGITS + 1 {
        return None;
    }
    let (mut whole, mut n_digits, mut point) = (0, 0, None);
    for byte in digits {
        match byte {
            b'0'..=b'9' => {
                whole = 10 * whole + u64::from(byte - b'0');
                n_digits += 1;
            }
            b'.' if point.is_none() => point = Some(n_digits),
            _ => return None,
        }
    }
    if !(1..=MOST_DIGITS).contains(&n_digits) {
        return None;
    }
    #[expect(clippy::cast_precision_loss, reason = "below 2^53")]
    let value = whole as f64 / POWERS[n_digits - point.unwrap_or(n_digits)];
    Some(if digits.len() < word.len() { -value } else { value })
}

/// Returns the numbers of a line; `None` unless there are just three.
fn point(line: &[u8]) -> Option<[f64; 3]> {
    let mut words = words(line);
    let numbers = [number(words.next()?)?, number(words.next()?)?, number(words.next()?)?];
    words.next().is_none().then_some(numbers)
}

/// Returns `true` for a line that no number begins: the names of the columns, or a comment.
fn is_heading(line: &[u8]) -> bool {
    words(line).next().is_some_and(|word| number(word).is_none() && !word[0].is_ascii_digit())
}

/// Returns `true` for text that begins with points, below a heading that names x, y and z or is a
/// comment. The last line may be cut off.
pub(crate) fn begins_with_points(text: &str) -> bool {
    /// Lines that are looked at.
    const N: usize = 3;
    let is_named = |line: &str| {
        let named = line.trim_start_matches(['#', '/', ' ']).to_ascii_lowercase();
        let names = |word: &[u8]| word.iter().filter(|byte| **byte != b'"').copied().collect::<Vec<u8>>();
        words(named.as_bytes()).map(names).eq([b"x", b"y", b"z"])
    };
    let is_comment = |line: &str| line.starts_with(['#', '/']);
    let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
    if lines.len() > 1 && !text.ends_with('\n') {
        lines.pop();
    }
    let lines = lines.into_iter().map(str::trim).filter(|line| !line.is_empty());
    let mut points = lines.skip_while(|line| is_named(line) || is_comment(line)).take(N).peekable();
    points.peek().is_some() && points.all(|line| point(line.as_bytes()).is_some())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_all_separators_are_points() {
        for line in ["1 2 3", " 1\t2  3\r\n", "1,2,3", "1;2;3", "1, 2, 3", "1 ; 2 ; 3;"] {
            assert_eq!(point(line.as_bytes()), Some([1.0, 2.0, 3.0]), "{line}");
        }
        for line in ["", "1 2", "1 2 3 4", "x y z", "1,5;2;3", "1 2 3m"] {
            assert_eq!(point(line.as_bytes()), None, "{line}");
        }
    }

    #[test]
    fn short_decimals_are_the_numbers_that_parsing_gives() {
        let mut state = 7_u64;
        let mut below = |n: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) % n
        };
        for _ in 0..200_000 {
            let digits: Vec<u8> =
                (0..below(18)).map(|_| b"0123456789....-+e"[usize::try_from(below(17)).expect("a place")]).collect();
            let word = std::str::from_utf8(&digits).expect("ASCII");
            let parsed: Option<f64> = word.parse().ok();
            let is_same = |short: f64| parsed.is_some_and(|parsed| parsed.to_bits() == short.to_bits());
            assert!(short_decimal(&digits).is_none_or(is_same), "{word}");
            assert_eq!(number(&digits).map(f64::to_bits), parsed.map(f64::to_bits), "{word}");
        }
        for word in ["691234.56", "-0", "0.1", ".5", "5.", "123456789012.345", "-9999"] {
            assert!(short_decimal(word.as_bytes()).is_some(), "{word}");
        }
        for word in ["", "-", ".", "1e5", "1.2.3", "+5", "1234567890123456"] {
            assert!(short_decimal(word.as_bytes()).is_none(), "{word}");
        }
    }

    #[test]
    fn text_of_points_is_told_from_tables() {
        for text in ["1 2 3\n2 2 3\n3 2", "X;Y;Z\n1;2;3\n", "//X Y Z\n1 2 3\n", "# of a survey\n\n1 2 3\n", "1 2 3"] {
            assert!(begins_with_points(text), "{text}");
        }
        for text in ["x,y,h\n1,2,3\n", "1 2\n", "1 2 3\n1 2 3 4\n", "", "X Y Z\n", "a b c\n1 2 3\n"] {
            assert!(!begins_with_points(text), "{text}");
        }
    }
}
