//! Reads the text cases in `tests/cases/*.txt`: a scene, two ends, and the answer found by hand.
//!
//! ```text
//! # A line that starts with a hash is a comment.
//! title: a wall hides the street behind it
//! source: how the answer was found; may go on
//!   in indented lines
//! grid:
//!   0 0 10 0 0
//! uav: 0.5 0.5 20
//! receiver: 4.5 0.5 0
//! expect: NLoS
//! ```
//!
//! A case starts at its `title`; the other keys come once each, in any order. Indented lines go on with the key above.
//!
//! * `grid`: heights of columns in meters, the northern row first, `.` for nodata. The ends are then given as
//!   x and y in cells from the south-west corner and z in meters.
//! * `prism: top Z`, once or more instead of `grid`: a prism up to Z meters, then one line per ring, shell or hole:
//!   its vertices `x y` in meters, separated by commas, the first not repeated. The ends are in meters.
//! * A number is a decimal such as `-2.5`, optionally followed by units of the lattice, as in `4-1/1024`. It must
//!   be a whole number of these units.

use std::path::Path;

use super::oracle::{Columns, P3, Prism};

/// How many cases `tests/cases` holds. An engine's test asserts that it ran this many.
pub(crate) const N_CASES: usize = 82;

/// One link in one scene, with the answer that every engine must give.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    /// What the case shows; no two are equal.
    pub(crate) title: String,
    /// How the expected answer was found, or who published it.
    pub(crate) source: String,
    /// Name of the file that holds the case.
    pub(crate) file: String,
    /// Line of its title, counted from 1.
    pub(crate) line: usize,
    /// The scene.
    pub(crate) kind: CaseKind,
    /// Aerial end, in lattice units.
    pub(crate) uav: P3,
    /// Ground end, in lattice units.
    pub(crate) receiver: P3,
    /// LoS is expected, as opposed to NLoS.
    pub(crate) expect_los: bool,
}

/// The two kinds of scene.
#[derive(Clone, Debug)]
pub(crate) enum CaseKind {
    /// Horizontal coordinates of the ends are in 1/1024 cell.
    Columns(Columns),
    /// All coordinates are in 1/1024 m.
    Prisms(Vec<Prism>),
}

/// Reads every case, files in the order of their names.
///
/// # Panics
/// If a file cannot be read, or is malformed: the message names the file and the line.
pub(crate) fn all_cases() -> Vec<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("cannot list {}: {e}", folder.display()));
    let mut paths: Vec<_> = entries.map(|entry| entry.expect("the folder lists its entries").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "txt"));
    paths.sort();
    let mut cases = Vec::new();
    for path in paths {
        let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("cannot read {}: {e}", path.display()));
        let file = path.file_name().expect("a file has a name").to_string_lossy();
        cases.extend(parse(&file, &text).unwrap_or_else(|message| panic!("{message}")));
    }
    cases
}

/// Parses the text of one file; the error is `file:line: what is wrong`.
fn parse(file: &str, text: &str) -> Result<Vec<Case>, String> {
    let cases = entries(text).and_then(|entries| {
        let goes_on = |_: &Entry, next: &Entry| next.key != "title";
        entries.chunk_by(goes_on).map(|entries| case(file, entries)).collect()
    });
    cases.map_err(|Fault { line, message }| format!("{file}:{line}: {message}"))
}

/// What is wrong, and in which line.
struct Fault {
    line: usize,
    message: String,
}

fn fault<T>(line: usize, message: impl Into<String>) -> Result<T, Fault> {
    Err(Fault { line, message: message.into() })
}

/// A key, its value, and the indented lines below it.
struct Entry {
    line: usize,
    key: String,
    value: String,
    below: Vec<(usize, String)>,
}

fn entries(text: &str) -> Result<Vec<Entry>, Fault> {
    let mut entries: Vec<Entry> = Vec::new();
    let lines = (1..).zip(text.lines());
    for (line, content) in lines.filter(|(_, content)| !content.trim().is_empty() && !content.starts_with('#')) {
        if content.starts_with(' ') {
            match entries.last_mut() {
                Some(entry) => entry.below.push((line, content.trim().to_owned())),
                None => return fault(line, "an indented line needs a key above it"),
            }
            continue;
        }
        let (key, value) = content.split_once(':').unwrap_or((content, ""));
        if !["title", "source", "grid", "prism", "uav", "receiver", "expect"].contains(&key) {
            return fault(line, format!("`{key}` is not a key"));
        }
        entries.push(Entry { line, key: key.to_owned(), value: value.trim().to_owned(), below: Vec::new() });
    }
    Ok(entries)
}

fn case(file: &str, entries: &[Entry]) -> Result<Case, Fault> {
    let first = &entries[0];
    if first.key != "title" {
        return fault(first.line, format!("`{}` comes before any title", first.key));
    }
    let line = first.line;
    let the_one = |key: &str| {
        let mut found = entries.iter().filter(|entry| entry.key == key);
        match (found.next(), found.next()) {
            (Some(entry), None) => Ok(entry),
            (Some(_), Some(again)) => fault(again.line, format!("`{key}` is given twice")),
            (None, _) => fault(line, format!("`{key}` is missing")),
        }
    };
    let words = |key: &str| -> Result<String, Fault> {
        let entry = the_one(key)?;
        let lines: Vec<&str> =
            std::iter::once(entry.value.as_str()).chain(entry.below.iter().map(|(_, text)| text.as_str())).collect();
        let text = lines.join(" ").trim().to_owned();
        if text.is_empty() { fault(entry.line, format!("`{key}` is empty")) } else { Ok(text) }
    };
    let end = |key: &str| -> Result<P3, Fault> {
        let entry = the_one(key)?;
        let point = numbers(entry.line, &entry.value)?;
        <P3>::try_from(point).or_else(|_| fault(entry.line, format!("`{}` is not `x y z`", entry.value)))
    };
    let prisms: Vec<&Entry> = entries.iter().filter(|entry| entry.key == "prism").collect();
    let kind = if prisms.is_empty() {
        CaseKind::Columns(columns(the_one("grid")?)?)
    } else if let Some(grid) = entries.iter().find(|entry| entry.key == "grid") {
        return fault(grid.line, "a case has a grid or prisms, not both");
    } else {
        CaseKind::Prisms(prisms.into_iter().map(prism).collect::<Result<_, _>>()?)
    };
    let expect = the_one("expect")?;
    let expect_los = match expect.value.as_str() {
        "LoS" => true,
        "NLoS" => false,
        other => return fault(expect.line, format!("`{other}` is neither `LoS` nor `NLoS`")),
    };
    Ok(Case {
        title: words("title")?,
        source: words("source")?,
        file: file.to_owned(),
        line,
        kind,
        uav: end("uav")?,
        receiver: end("receiver")?,
        expect_los,
    })
}

fn columns(entry: &Entry) -> Result<Columns, Fault> {
    let mut heights = Vec::new();
    let mut n_cols = 0;
    for (line, row) in &entry.below {
        let cells: Vec<Option<i64>> = row
            .split_whitespace()
            .map(|cell| if cell == "." { Ok(None) } else { number(*line, cell).map(Some) })
            .collect::<Result<_, _>>()?;
        if n_cols != 0 && cells.len() != n_cols {
            return fault(*line, format!("the row has {} cells, the first has {n_cols}", cells.len()));
        }
        n_cols = cells.len();
        heights.extend(cells);
    }
    if heights.is_empty() {
        return fault(entry.line, "the grid has no rows");
    }
    Ok(Columns { n_cols, n_rows: entry.below.len(), heights })
}

fn prism(entry: &Entry) -> Result<Prism, Fault> {
    let Some(top) = entry.value.strip_prefix("top ") else {
        return fault(entry.line, format!("`{}` is not `top Z`", entry.value));
    };
    let mut rings = Vec::new();
    for (line, ring) in &entry.below {
        let vertex = |text: &str| {
            <[i64; 2]>::try_from(numbers(*line, text)?).or_else(|_| fault(*line, format!("`{text}` is not `x y`")))
        };
        rings.push(ring.split(',').map(str::trim).map(vertex).collect::<Result<Vec<_>, _>>()?);
    }
    if rings.is_empty() {
        return fault(entry.line, "the prism has no rings");
    }
    Ok(Prism { rings, top: number(entry.line, top.trim())? })
}

fn numbers(line: usize, text: &str) -> Result<Vec<i64>, Fault> {
    text.split_whitespace().map(|word| number(line, word)).collect()
}

/// A decimal, with `+k/1024` or `-k/1024` behind it or not, in lattice units.
fn number(line: usize, text: &str) -> Result<i64, Fault> {
    exact(text).map_or_else(|| fault(line, format!("`{text}` is not a number in steps of 1/1024")), Ok)
}

fn exact(text: &str) -> Option<i64> {
    let digits = |text: &str| -> Option<i64> {
        let all_digits = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        if all_digits { text.parse().ok() } else { None }
    };
    let (sign, text) = text.strip_prefix('-').map_or((1, text), |rest| (-1, rest));
    let (decimal, extra) = match text.strip_suffix("/1024") {
        Some(text) => {
            let at = text.rfind(['+', '-'])?;
            let extra = digits(&text[at + 1..])?;
            (&text[..at], if text[at..].starts_with('-') { -extra } else { extra })
        }
        None => (text, 0),
    };
    let (whole, fraction) = decimal.split_once('.').unwrap_or((decimal, "0"));
    // Ten digits are enough for 1/1024 = 0.0009765625.
    let scale = 10_i64.checked_pow(u32::try_from(fraction.len()).ok().filter(|&n| n <= 10)?)?;
    let units = digits(fraction)? * 1024;
    if units % scale != 0 {
        return None;
    }
    Some(sign * (digits(whole)?.checked_mul(1024)? + units / scale) + extra)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn the_cases_hold_both_kinds_of_scene_and_both_answers_under_different_titles() {
        let cases = all_cases();
        for is_raster in [true, false] {
            for expect_los in [true, false] {
                let is_such =
                    |c: &&Case| matches!(c.kind, CaseKind::Columns(_)) == is_raster && c.expect_los == expect_los;
                let n = cases.iter().filter(is_such).count();
                assert!(n >= 10, "only {n} cases, of rasters: {is_raster}, LoS: {expect_los}");
            }
        }
        let mut titles = HashSet::new();
        for case in &cases {
            assert!(titles.insert(&case.title), "{}:{}: `{}` again", case.file, case.line, case.title);
        }
    }

    #[test]
    fn numbers_are_read_exactly() {
        for (text, units) in [
            ("0", 0),
            ("2.5", 2560),
            ("-2.5", -2560),
            ("0.0009765625", 1),
            ("4-1/1024", 4095),
            ("-4-1/1024", -4097),
            ("-4+3/1024", -4093),
            ("20000", 20_480_000),
        ] {
            assert_eq!(exact(text), Some(units), "{text}");
        }
        for text in ["", ".", "2.", ".5", "0.1", "1e3", "--1", "1/1024", "4+/1024", "4+1/512", "0.00000000001", "x"] {
            assert_eq!(exact(text), None, "{text}");
        }
    }

    #[test]
    fn a_malformed_case_is_refused_with_file_and_line() {
        let good = "title: t\nsource: s\ngrid:\n  0 1\n  . 2\nuav: 0 0 1\nreceiver: 1 1 0.5\nexpect: LoS\n";
        assert_eq!(parse("f", good).map(|cases| cases.len()), Ok(1));
        for (from, to, error) in [
            ("title: t\n", "", "f:1: `source` comes before any title"),
            ("title: t\n", "  0\n", "f:1: an indented line needs a key above it"),
            ("title: t", "title:", "f:1: `title` is empty"),
            ("source: s\n", "", "f:1: `source` is missing"),
            ("source: s", "sauce: s", "f:2: `sauce` is not a key"),
            ("source: s", "source", "f:2: `source` is empty"),
            ("grid:\n  0 1\n  . 2\n", "", "f:1: `grid` is missing"),
            ("  0 1\n  . 2\n", "", "f:3: the grid has no rows"),
            ("  . 2", "  2", "f:5: the row has 1 cells, the first has 2"),
            ("  . 2", "  * 2", "f:5: `*` is not a number in steps of 1/1024"),
            ("grid:\n  0 1\n  . 2\n", "prism: 5\n", "f:3: `5` is not `top Z`"),
            ("grid:\n  0 1\n  . 2\n", "prism: top 5\n", "f:3: the prism has no rings"),
            ("grid:\n  0 1\n  . 2\n", "prism: top 5\n  0 0, 1\n", "f:4: `1` is not `x y`"),
            ("uav: 0 0 1", "prism: top 1\n  0 0, 1 0, 0 1", "f:3: a case has a grid or prisms, not both"),
            ("uav: 0 0 1", "uav: 0 1", "f:6: `0 1` is not `x y z`"),
            ("uav: 0 0 1", "uav: 0 0 0.1", "f:6: `0.1` is not a number in steps of 1/1024"),
            ("expect: LoS", "expect: yes", "f:8: `yes` is neither `LoS` nor `NLoS`"),
            ("expect: LoS", "expect: LoS\nexpect: LoS", "f:9: `expect` is given twice"),
        ] {
            let text = good.replacen(from, to, 1);
            assert_ne!(text, good, "{error}");
            assert_eq!(parse("f", &text).err().as_deref(), Some(error));
        }
    }
}
