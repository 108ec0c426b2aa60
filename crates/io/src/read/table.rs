//! Tables as text: separators of fields, decimal marks, and rows that cannot be read.
//!
//! The line of the column names sets the separator: commas, semicolons or tabs. Numbers have a
//! point before their decimals. Behind semicolons and tabs a comma may mark decimals too, the same
//! in all rows.

use std::borrow::Cow;
use std::cell::Cell;
use std::collections::HashSet;
use std::fmt::Display;

use crate::error::{MOST_FOUND, OddFile, Warning, shortened};
use crate::quantity::{Height, parse_meters, parse_number};

/// Treatment of rows that cannot be read.
#[derive(Debug)]
pub enum BadRows<'a> {
    /// One error for all of them.
    Refuse,
    /// Omission with one warning (W380); it is still an error if no row can be read.
    LeaveOut(&'a mut Vec<Warning>),
}

/// Wanted content of a coordinate, for messages.
pub(super) const NUMBER: &str = "a number";

/// A table of named columns.
#[derive(Debug)]
pub struct Table {
    headers: csv::StringRecord,
    rows: Vec<Row>,
    separator: u8,
    /// Decimal mark, and the line that sets it.
    mark: Cell<Option<(char, u64)>>,
}

/// A row of a table.
#[derive(Debug)]
pub struct Row {
    line: u64,
    fields: csv::StringRecord,
}

/// Columns of a position.
#[derive(Debug)]
pub struct Position {
    /// Columns of x and y, or of longitude and latitude.
    pub columns: (usize, usize),
    /// `true` if the position is longitude and latitude.
    pub is_degrees: bool,
    /// Columns of longitude and latitude beside those of x and y.
    pub degrees_too: Option<(usize, usize)>,
}

impl Table {
    /// Parses a text. Lines that begin with `#` are comments.
    ///
    /// # Errors
    /// The fault of the table as a whole, in words.
    pub fn parse(text: &str) -> std::result::Result<Table, String> {
        let text = text.trim_start_matches('\u{feff}');
        let separator = separator_of(text)?;
        let mut reader = csv::ReaderBuilder::new()
            .delimiter(separator)
            .trim(csv::Trim::All)
            .comment(Some(b'#'))
            .flexible(true)
            .from_reader(text.as_bytes());
        let headers = reader.headers().map_err(|e| e.to_string())?.clone();
        let mut names = HashSet::new();
        if let Some(twice) = headers.iter().find(|name| !name.is_empty() && !names.insert(name.to_lowercase())) {
            return Err(format!(
                "line 1: found the column `{}` twice, wanted each name once",
                shortened(twice, MOST_FOUND)
            ));
        }
        let mut rows = Vec::new();
        for record in reader.records() {
            let fields = record.map_err(|e| e.to_string())?;
            let line = fields.position().map_or(0, |start| line_of(text, start));
            rows.push(Row { line, fields });
        }
        Ok(Table { headers, rows, separator, mark: Cell::new(None) })
    }

    /// Returns the column with one of these names.
    pub fn column(&self, names: &[&str]) -> Option<usize> {
        self.headers.iter().position(|header| names.contains(&header.to_lowercase().as_str()))
    }

    /// Returns the name of a column, as the table has it.
    pub fn name(&self, column: usize) -> &str {
        &self.headers[column]
    }

    /// Returns the names of all columns, for messages.
    pub fn found(&self) -> String {
        shortened(&self.headers.iter().collect::<Vec<_>>().join(","), 4 * MOST_FOUND).into_owned()
    }

    /// Returns the columns of a position: in the scene's system if there are any, else in degrees.
    pub fn position(&self) -> std::result::Result<Position, String> {
        let projected = self.column(&["x", "x_m", "easting"]).zip(self.column(&["y", "y_m", "northing"]));
        let degrees = self.column(&["lon", "longitude", "lng"]).zip(self.column(&["lat", "latitude"]));
        match projected.or(degrees) {
            Some(columns) => {
                let degrees_too = degrees.filter(|_| projected.is_some());
                Ok(Position { columns, is_degrees: projected.is_none(), degrees_too })
            }
            None => Err(format!("line 1: found columns `{}`, wanted a position", self.found())),
        }
    }

    /// Calls `read` with each row, and returns the results with the place of each row in words.
    pub fn rows<T>(
        &self,
        mut read: impl FnMut(usize, &Row) -> std::result::Result<T, RowFault>,
    ) -> Vec<(String, std::result::Result<T, RowFault>)> {
        let each = |(k, row): (usize, &Row)| {
            (format!("line {}", row.line), self.check_fields(row).and_then(|()| read(k, row)))
        };
        self.rows.iter().enumerate().map(each).collect()
    }

    /// Refuses fields beyond the last column: they are decimals behind a comma, or shift all other
    /// fields.
    fn check_fields(&self, row: &Row) -> std::result::Result<(), RowFault> {
        let wanted = self.headers.len();
        if row.fields.iter().skip(wanted).all(str::is_empty) {
            return Ok(());
        }
        let remedy = if self.separator == b',' { "; decimal commas need semicolons between the fields" } else { "" };
        Err(RowFault::Text(format!("found {} fields, wanted {wanted}, one for each column{remedy}", row.fields.len())))
    }

    /// Refuses a row with fewer fields than columns: it may lack any of them.
    pub fn check_complete(&self, row: &Row) -> std::result::Result<(), RowFault> {
        match (row.fields.len(), self.headers.len()) {
            (found, wanted) if found < wanted => {
                Err(RowFault::Text(format!("found {found} fields, wanted {wanted}, one for each column")))
            }
            _ => Ok(()),
        }
    }

    /// Returns a finite number; `wanted` names it in messages.
    pub fn number(&self, row: &Row, column: usize, wanted: &str) -> std::result::Result<f64, RowFault> {
        let number = self
            .decimals(row, column)
            .and_then(|text| parse_number(&text).map_err(|found| format!("{found}, wanted {wanted}")));
        number.map_err(|found| RowFault::Text(format!("`{}`: {found}", &self.headers[column])))
    }

    /// Returns a height, whose reference may be in a column of its own.
    pub fn height(&self, row: &Row, column: usize, above: Option<usize>) -> std::result::Result<Height, RowFault> {
        let above = above.map(|column| row.field(column));
        self.decimals(row, column).and_then(|text| height(&text, above)).map_err(RowFault::Text)
    }

    /// Returns a field with a point before its decimals.
    fn decimals<'a>(&self, row: &'a Row, column: usize) -> std::result::Result<Cow<'a, str>, String> {
        let text = row.field(column);
        if self.separator == b',' {
            return Ok(text.into());
        }
        let mark = match (text.matches(',').count(), text.matches('.').count()) {
            (0, 0) => return Ok(text.into()),
            (1, 0) => ',',
            (0, 1) => '.',
            _ => return Err(format!("found `{text}`, wanted one decimal mark and none between thousands")),
        };
        match self.mark.get() {
            Some((other, line)) if other != mark => {
                let text = format!(
                    "found `{text}`, which is ambiguous: on line {line} the decimal mark is `{other}`, wanted one in all rows"
                );
                return Err(text);
            }
            Some(_) => {}
            None => self.mark.set(Some((mark, row.line))),
        }
        Ok(text.replace(',', ".").into())
    }
}

impl Row {
    /// Returns the line of the file.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// Returns a field; empty where the row has none.
    pub fn field(&self, column: usize) -> &str {
        self.fields.get(column).unwrap_or_default()
    }
}

/// Parses a height from its number and its reference, if that is separate.
pub(super) fn height(text: &str, above: Option<&str>) -> std::result::Result<Height, String> {
    let Some(above) = above.filter(|a| !a.is_empty()) else { return text.parse() };
    let value = parse_meters(text).map_err(|found| format!("height: {found}"))?;
    match above {
        "ground" | "agl" => Ok(Height::AboveGround(value)),
        "roof" => Ok(Height::AboveRoof(value)),
        "amsl" | "datum" => Ok(Height::AboveDatum(value)),
        other => Err(format!("`h_above` is `{other}`, wanted `ground`, `roof` or `amsl`")),
    }
}

/// Returns the separator of the column names. No name holds another separator, unless it is quoted.
fn separator_of(text: &str) -> std::result::Result<u8, String> {
    const SEPARATORS: [(char, u8, &str); 3] = [(',', b',', "commas"), (';', b';', "semicolons"), ('\t', b'\t', "tabs")];
    let (number, line) = text
        .lines()
        .enumerate()
        .find(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'))
        .unwrap_or_default();
    let unquoted: String = line.split('"').step_by(2).collect();
    match SEPARATORS.into_iter().filter(|(c, _, _)| unquoted.contains(*c)).collect::<Vec<_>>()[..] {
        [] => Ok(b','),
        [(_, separator, _)] => Ok(separator),
        [(_, _, one), (_, _, other), ..] => {
            let line_number = number + 1;
            Err(format!(
                "line {line_number}: found {one} and {other} between the column names, which is ambiguous, wanted one of them"
            ))
        }
    }
}

/// Returns the line of a record. The reader returns the end of the record before it, ahead of
/// comments and empty lines.
fn line_of(text: &str, start: &csv::Position) -> u64 {
    let rest = usize::try_from(start.byte()).ok().and_then(|byte| text.get(byte..)).unwrap_or_default();
    let skipped = rest.lines().take_while(|line| line.is_empty() || line.starts_with('#'));
    start.line() + skipped.count() as u64
}

/// Fault of a row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RowFault {
    /// Fault of its text.
    Text(String),
    /// Fault of the place of its position.
    Place(String),
    /// Fault of the system of its position: no transformation from or to it is known.
    NoWay(String),
}

impl std::fmt::Display for RowFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            RowFault::Text(words) | RowFault::Place(words) | RowFault::NoWay(words) => f.write_str(words),
        }
    }
}

/// Rows that cannot be read, in words.
#[derive(Debug)]
pub struct BadRowsTold {
    /// Fault of the first bad row.
    pub first: RowFault,
    /// Text about all bad rows.
    pub text: String,
    /// `true` if other rows are good.
    pub some_are_good: bool,
}

/// Returns the rows of a file that can be read. All others are reported together, by an error of
/// `refuse` or a warning.
///
/// # Errors
/// If `bad` refuses bad rows and there are any, or if all rows are bad.
pub fn readable<T, E>(
    name: impl Display,
    rows: Vec<(String, std::result::Result<T, RowFault>)>,
    bad: BadRows<'_>,
    refuse: impl FnOnce(BadRowsTold) -> E,
) -> std::result::Result<Vec<T>, E> {
    /// Largest number of rows that are reported one by one.
    const MOST_TOLD: usize = 20;
    /// Largest number of characters about each.
    const MOST_CHARACTERS: usize = 160;
    let n_rows = rows.len();
    let (mut good, mut faults) = (Vec::with_capacity(n_rows), Vec::new());
    for (place, row) in rows {
        match row {
            Ok(row) => good.push(row),
            Err(fault) => faults.push((place, fault)),
        }
    }
    let Some((place, first)) = faults.first() else { return Ok(good) };
    let told: Vec<String> = faults
        .iter()
        .take(MOST_TOLD)
        .map(|(place, fault)| shortened(&format!("{place}: {}", fault), MOST_CHARACTERS).into_owned())
        .collect();
    let n_bad = faults.len();
    let more = if n_bad > MOST_TOLD { format!("; and {} more", n_bad - MOST_TOLD) } else { String::new() };
    let told = told.join("; ") + &more;
    match bad {
        BadRows::LeaveOut(warnings) if !good.is_empty() => {
            warnings.push(Warning::of(name, OddFile::BadRows { n: n_bad, of: n_rows, told }));
            return Ok(good);
        }
        _ => {}
    }
    let text =
        if n_bad == 1 { format!("{place}: {}", first) } else { format!("{n_bad} of {n_rows} rows are bad: {told}") };
    Err(refuse(BadRowsTold { first: first.clone(), text, some_are_good: !good.is_empty() }))
}
