//! Failure rates as a table of colored squares: a row for each family of tests, a column for each
//! method.
//!
//! Each square has its rate in percent as a number, and a color by the size of the rate: the darker
//! the worse. Exactly 0 is white, so that it cannot be taken for a small rate. A rate that cannot
//! be decided is left blank.

use super::check;
use super::colors::{self, INK, Rgb, TURNS, WHITE};
use super::furniture::{self, Block, DETAIL, NAME, Swatch};
use super::lettering::{Anchor, Type, number};
use super::page::page;
use super::sheet::{Drawing, Sheet};

/// Failure rates of some methods on some families.
#[derive(Clone, Copy, Debug)]
pub struct RateSheet<'a> {
    /// Title; may be empty.
    pub title: &'a str,
    /// Lines below; long ones are wrapped.
    pub caption: &'a [String],
    /// Rows, from the top: a description in plain words, and a name.
    pub rows: &'a [[&'a str; 2]],
    /// Columns, from the left; neighbors of one group share its name.
    pub columns: &'a [RateColumn<'a>],
    /// Failures and trials, `[n_rows, n_columns]`, columns running fastest; `None` if no trial can
    /// be made.
    pub rates: &'a [Option<[u64; 2]>],
    /// Meaning of a blank square.
    pub blank: &'a str,
}

/// A column of rates.
#[derive(Clone, Copy, Debug)]
pub struct RateColumn<'a> {
    /// Its name.
    pub name: &'a str,
    /// Name of the group, over this column and its neighbors of the same group.
    pub group: &'a str,
}

/// Width and height of a square \[px\].
const CELL: [f64; 2] = [124.0, 46.0];
/// Gap between groups of columns \[px\].
const GROUP_GAP: f64 = 18.0;
/// Height of the names of groups and of columns, above the squares \[px\].
const HEAD: f64 = 84.0;
/// Gap between the names of rows and the squares \[px\].
const NAME_GAP: f64 = 16.0;

/// Upper end \[%\] of each color of rates, about a power of ten each, with its words.
const DECADES: [(f64, Rgb, &str); 5] = [
    (0.1, TURNS[1], "below 0.1 %"),
    (1.0, TURNS[2], "0.1 to 1 %"),
    (10.0, TURNS[4], "1 to 10 %"),
    (30.0, TURNS[6], "10 to 30 %"),
    (f64::INFINITY, TURNS[8], "30 % or more"),
];

/// Returns the color of a rate \[%\].
fn color(percent: f64) -> Rgb {
    if percent <= 0.0 {
        return WHITE;
    }
    DECADES.iter().find(|(end, _, _)| percent < *end).map_or(WHITE, |(_, color, _)| *color)
}

/// Writes a rate in percent with more decimals the smaller it is: 0.0012, 0.35, 4.2, 87.
fn digits(percent: f64) -> String {
    let decimals = match percent {
        p if p <= 0.0 || p >= 10.0 => 0,
        p if p >= 1.0 => 1,
        p if p >= 0.1 => 2,
        p if p >= 0.01 => 3,
        _ => 4,
    };
    number(percent, decimals)
}

/// Draws failure rates.
///
/// # Errors
/// No row, no column, an array of another length, more failures than trials, or no trial.
pub fn draw_rate_sheet(sheet: &RateSheet<'_>) -> Result<Sheet, String> {
    check::shape("rates", sheet.rates.len(), [sheet.columns.len(), sheet.rows.len()])?;
    if let Some([wrong, of]) = sheet.rates.iter().flatten().find(|[wrong, of]| *of == 0 || wrong > of) {
        return Err(format!("cannot draw a rate of {wrong} in {of}"));
    }
    let table = table(sheet);
    let entry = |color: Rgb, words: &str| furniture::legend_entry(Swatch::Flat(color), words, "");
    let decades = DECADES.iter().map(|(_, color, words)| entry(*color, words));
    let keys: Vec<Block> = std::iter::once(entry(WHITE, "none")).chain(decades).collect();
    let legend = furniture::flow(&keys, table.width, [34.0, 10.0]);
    let has_blanks = sheet.rates.iter().any(Option::is_none);
    let blank = has_blanks.then(|| furniture::paragraph(&format!("Blank: {}", sheet.blank), DETAIL, table.width));
    let body = furniture::stack(&[table, legend].into_iter().chain(blank).collect::<Vec<_>>(), 24.0);
    Ok(page(sheet.title, &body, sheet.caption, [22.0, 20.0]))
}

/// Draws the names, and the squares with their rates.
fn table(sheet: &RateSheet<'_>) -> Block {
    let mut drawing = Drawing::default();
    let widest = |k: usize| sheet.rows.iter().map(|row| DETAIL.width(row[k])).fold(0.0, f64::max).ceil();
    let names = widest(0) + 2.0 * NAME_GAP;
    let left = names + widest(1) + NAME_GAP;
    let lefts = lefts(sheet.columns, left);
    let placed: Vec<_> = sheet.columns.iter().zip(&lefts).collect();
    let middle = Type { anchor: Anchor::Middle, color: INK, ..DETAIL };
    for (column, x) in &placed {
        drawing.text(*x + CELL[0] / 2.0, HEAD - 14.0, middle, column.name);
    }
    for group in placed.chunk_by(|(a, _), (b, _)| a.group == b.group) {
        let (from, to) = (*group[0].1, group[group.len() - 1].1 + CELL[0]);
        drawing.text((from + to) / 2.0, 24.0, Type { anchor: Anchor::Middle, ..NAME }, group[0].0.group);
        drawing.line([from, 36.0], [to, 36.0], &furniture::hairline());
    }
    for (row, [words, name]) in sheet.rows.iter().enumerate() {
        let top = HEAD + CELL[1] * row as f64;
        let base = top + CELL[1] / 2.0 + 8.0;
        drawing.text(0.0, base, Type { color: INK, ..DETAIL }, words);
        drawing.text(names, base, DETAIL, name);
        for (col, x) in lefts.iter().enumerate() {
            let square = [*x, top, CELL[0], CELL[1]];
            let Some([wrong, of]) = sheet.rates[row * lefts.len() + col] else { continue };
            let percent = 100.0 * wrong as f64 / of as f64;
            let fill = color(percent);
            drawing.rect(square, &colors::fill(fill));
            drawing.rect(square, &format!("fill=\"none\" {}", furniture::hairline()));
            let text = Type { color: colors::ink_on(fill), ..middle };
            drawing.text(x + CELL[0] / 2.0, base, text, &digits(percent));
        }
    }
    let width = lefts.last().map_or(left, |x| x + CELL[0]);
    Block { width, height: HEAD + CELL[1] * sheet.rows.len() as f64, drawing }
}

/// Returns the left ends of the columns \[px\].
fn lefts(columns: &[RateColumn<'_>], left: f64) -> Vec<f64> {
    let mut x = left;
    let mut lefts = Vec::with_capacity(columns.len());
    for (k, column) in columns.iter().enumerate() {
        if k > 0 && columns[k - 1].group != column.group {
            x += GROUP_GAP;
        }
        lefts.push(x);
        x += CELL[0];
    }
    lefts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn none_is_white_and_few_are_not() {
        assert_eq!([0.0, 0.001, 3.0].map(color), [WHITE, TURNS[1], TURNS[4]]);
        assert_eq!([0.0012, 0.35, 4.21, 87.4].map(digits), ["0.0012", "0.35", "4.2", "87"]);
    }
}
