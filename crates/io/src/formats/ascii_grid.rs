//! Esri ASCII grid (`.asc`): a header of keys and numbers, then the heights row by row from the
//! north.
//!
//! Keys come in any case and order. The corner is that of the grid (`xllcorner`) or the center of
//! its south-west cell (`xllcenter`). The cells are square (`cellsize`) or not (`dx`, `dy`, as GDAL
//! writes them). A missing `NODATA_value` is -9999, as Esri defines it. The coordinate reference
//! system is in a file of the same name with the ending `.prj`. Numbers have a decimal point;
//! decimal commas are refused, since they cannot be distinguished from separators.
//!
//! The file is read as a stream of words, so that it takes the memory of the requested cells only.

use std::fmt::Write as _;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};

use super::oddity::{warned, with_true_lengths};
use super::reserve::reserve_cells;
use super::voids::Voids;
use crate::crs;
use crate::error::{Cause, Error, OddRaster, Oddity, Place, ReadFault, Result, Warning};
use crate::input::{Input, Reader, cannot_read};
use crate::raster::{CellWindow, Crs, GeoRef, Raster};

const KEYS: [&str; 11] = [
    "ncols",
    "nrows",
    "xllcorner",
    "yllcorner",
    "xllcenter",
    "yllcenter",
    "cellsize",
    "dx",
    "dy",
    "nodata_value",
    "nodata",
];
/// Nodata value of a grid that declares none.
pub(super) const DEFAULT_NODATA: f64 = -9999.0;
/// Longest word of a grid \[bytes\].
const MAX_WORD_BYTES: usize = 512;

/// An Esri ASCII grid, its header read and checked.
#[derive(Debug, Clone)]
pub struct AsciiGrid {
    input: Input,
    georef: GeoRef,
    nodata: f64,
    /// Byte and line at which the heights begin.
    cells_at: u64,
    cells_line: u64,
}

impl AsciiGrid {
    /// Opens a file and reads its header, no cell.
    ///
    /// # Errors
    /// If the file cannot be opened, or its header is incomplete, contradicts itself or promises
    /// more cells than the file can hold.
    pub fn open(input: impl Into<Input>, warnings: &mut Vec<Warning>) -> Result<AsciiGrid> {
        warned(warnings, |odd| AsciiGrid::open_told(&input.into(), odd))
    }

    pub(super) fn open_told(input: &Input, odd: &mut Vec<Oddity>) -> Result<AsciiGrid> {
        let (file, len) = input.open()?;
        let mut words = Words::new(input, file, 0, 1);
        let header = Header::read(&mut words)?;
        let (cells_at, cells_line) = (words.word_at, words.word_line);
        let georef = header.georef(input)?;
        // Each height takes a digit and, but for the last, a separator.
        let (n_cells, left) = (georef.n_cells() as u64, len.saturating_sub(cells_at));
        if n_cells.saturating_mul(2) - 1 > left {
            let (cols, rows) = (georef.n_cols(), georef.n_rows());
            let what = format!("{left} bytes follow its header, too few for {cols} columns x {rows} rows");
            return Err(Error::truncated(input, what).because(Cause::TooFewCells));
        }
        let crs = sidecar_crs(input, odd);
        if crs.is_none() {
            odd.push(Oddity::new(input, OddRaster::NoPrj));
        }
        let nodata = header.number("nodata_value").or(header.number("nodata")).unwrap_or(DEFAULT_NODATA);
        let georef = with_true_lengths(georef.with_crs(crs), &mut |of_grid| odd.push(Oddity::new(input, of_grid)));
        Ok(AsciiGrid { input: input.clone(), georef, nodata, cells_at, cells_line })
    }

    /// Returns the grid of the cells.
    pub fn georef(&self) -> &GeoRef {
        &self.georef
    }

    /// Returns the encoding in a few words.
    pub fn description(&self) -> String {
        format!("Esri ASCII grid, nodata {}", self.nodata)
    }

    /// Reads a part as [`super::RasterFile::read`] does, row by row from the north.
    pub fn read<T: bytemuck::Pod>(
        &self,
        window: CellWindow,
        warnings: &mut Vec<Warning>,
        mut convert: impl FnMut(f64) -> T,
    ) -> Result<Raster<T>> {
        let part = self.georef.part(window);
        let mut cells = reserve_cells(&self.input, &part)?;
        let mut voids = Voids::new(Some(self.nodata));
        self.for_each_stored(window, |row, col, stored| cells.push(convert(voids.height(row, col, stored))))?;
        voids.report(&self.input, warnings)?;
        Ok(Raster::new(part, cells))
    }

    /// Returns the value of cells without a height.
    pub(super) fn nodata(&self) -> f64 {
        self.nodata
    }

    /// Calls `visit` with row, column and number of each cell of a part, row by row from the north.
    pub(super) fn for_each_stored(&self, window: CellWindow, mut visit: impl FnMut(usize, usize, f64)) -> Result<()> {
        let (mut file, _) = self.input.open()?;
        file.seek(SeekFrom::Start(self.cells_at)).map_err(|e| cannot_read(&self.input, &e))?;
        let mut words = Words::new(&self.input, file, self.cells_at, self.cells_line);
        for row in 0..window.row + window.n_rows {
            for col in 0..self.georef.n_cols() {
                if !words.next()? {
                    let (found, wanted) = (row * self.georef.n_cols() + col, self.georef.n_cells());
                    let error = words.truncated(format!("the file ends after {found} values, wanted {wanted}"));
                    return Err(error.because(Cause::TooFewCells));
                }
                if row >= window.row && (window.col..window.col + window.n_cols).contains(&col) {
                    visit(row, col, self.stored(words.number()?));
                }
            }
        }
        if window.row + window.n_rows == self.georef.n_rows() && words.next()? {
            let what = format!("`{}` follows the last of {} values", words.text(), self.georef.n_cells());
            return Err(words.malformed(what).because(Cause::TooManyCells));
        }
        Ok(())
    }

    /// Returns the value as read, or the declared nodata value where the two are the same 32-bit
    /// number.
    #[expect(
        clippy::float_cmp,
        clippy::cast_possible_truncation,
        reason = "writers round nodata to 32 bits in one place only"
    )]
    fn stored(&self, value: f64) -> f64 {
        if value as f32 == self.nodata as f32 { self.nodata } else { value }
    }
}

/// Returns `true` when a word is a key of the header, in any case.
pub(crate) fn is_header_key(word: &str) -> bool {
    KEYS.iter().any(|key| word.eq_ignore_ascii_case(key))
}

/// The keys of the header with their values and lines.
#[derive(Debug, Default)]
struct Header {
    /// Key, value as written, line.
    entries: Vec<(&'static str, String, u64)>,
}

impl Header {
    /// Reads keys and values up to the first height, which is the current word afterwards.
    fn read(words: &mut Words) -> Result<Header> {
        let mut header = Header::default();
        loop {
            if !words.next()? {
                return Err(words.truncated("the file ends in its header, wanted heights"));
            }
            let word = words.text();
            let Some(key) = KEYS.iter().find(|key| word.eq_ignore_ascii_case(key)) else {
                // The first height; a word that is no number is a misspelled key.
                let is_key = word.starts_with(|c: char| c.is_ascii_alphabetic()) && word.parse::<f64>().is_err();
                if is_key {
                    let wanted = "ncols, nrows, xllcorner, yllcorner, cellsize, dx, dy or NODATA_value";
                    return Err(words.malformed(format!("`{word}` is no key of the header, wanted {wanted}")));
                }
                header.check(words)?;
                return Ok(header);
            };
            if header.entries.iter().any(|(k, ..)| k == key) {
                return Err(words.malformed(format!("`{word}` is given twice")));
            }
            if !words.next()? {
                return Err(words.truncated(format!("the file ends after `{word}`, wanted its value")));
            }
            let value = words.text();
            // The value is checked while its line is known.
            let number = words.number().map_err(|_| {
                words.not_a_number(format!("`{word}` is `{value}`, wanted a number with a decimal point"))
            })?;
            let is_size = matches!(*key, "cellsize" | "dx" | "dy");
            let is_count = matches!(*key, "ncols" | "nrows");
            if is_size && !(number > 0.0 && number.is_finite()) {
                return Err(words.malformed(format!("`{word}` is `{value}`, must be above 0")));
            }
            if is_count && !value.parse::<usize>().is_ok_and(|n| n > 0) {
                return Err(words.malformed(format!("`{word}` is `{value}`, wanted a whole number above 0")));
            }
            if !number.is_finite() && !key.starts_with("nodata") {
                return Err(words.malformed(format!("`{word}` is `{value}`, wanted a finite number")));
            }
            header.entries.push((key, value, words.word_line));
        }
    }

    /// Checks that each number that the grid needs is present once.
    fn check(&self, words: &Words) -> Result<()> {
        let has = |key| self.entries.iter().any(|(k, ..)| *k == key);
        for (one, other) in
            [("ncols", "ncols"), ("nrows", "nrows"), ("xllcorner", "xllcenter"), ("yllcorner", "yllcenter")]
        {
            if !has(one) && !has(other) {
                return Err(words.malformed(format!("the header ends without `{one}`")));
            }
            if one != other && has(one) && has(other) {
                return Err(words.malformed(format!("the header has both `{one}` and `{other}`")));
            }
        }
        let has_size = has("cellsize") || (has("dx") && has("dy"));
        if !has_size {
            return Err(words.malformed("the header ends without `cellsize`, or `dx` and `dy`"));
        }
        Ok(())
    }

    fn number(&self, key: &str) -> Option<f64> {
        self.entries.iter().find(|(k, ..)| *k == key).and_then(|(_, value, _)| value.parse().ok())
    }

    fn count(&self, key: &str) -> usize {
        self.entries.iter().find(|(k, ..)| *k == key).and_then(|(_, value, _)| value.parse().ok()).unwrap_or(0)
    }

    fn georef(&self, input: &Input) -> Result<GeoRef> {
        let (n_rows, n_cols) = (self.count("nrows"), self.count("ncols"));
        let square = self.number("cellsize").unwrap_or(f64::NAN);
        let (width, height) = (self.number("dx").unwrap_or(square), self.number("dy").unwrap_or(square));
        let corner = |corner, center, size: f64| {
            self.number(corner).or(self.number(center).map(|center| center - 0.5 * size)).unwrap_or(f64::NAN)
        };
        let x_min = corner("xllcorner", "xllcenter", width);
        let y_max = corner("yllcorner", "yllcenter", height) + height * n_rows as f64;
        GeoRef::new((x_min, y_max), (width, height), (n_rows, n_cols), None).ok_or_else(|| {
            let what =
                format!("{n_cols} columns x {n_rows} rows of {width} x {height} at {x_min}, {y_max} are no grid");
            Error::read(input, ReadFault::Irregular(what))
        })
    }
}

/// Words of a file, one after the other.
struct Words<'a> {
    input: &'a Input,
    reader: BufReader<Reader>,
    /// Byte and line of the reader.
    at: u64,
    line: u64,
    word: Vec<u8>,
    /// Byte and line of the current word.
    word_at: u64,
    word_line: u64,
}

impl<'a> Words<'a> {
    fn new(input: &'a Input, file: Reader, at: u64, line: u64) -> Self {
        let reader = BufReader::with_capacity(1 << 18, file);
        Words { input, reader, at, line, word: Vec::new(), word_at: at, word_line: line }
    }

    /// Returns E302 on the line of the current word.
    fn malformed(&self, what: impl Into<String>) -> Error {
        Error::malformed(self.input, what).at(Place::Line(self.word_line))
    }

    /// Returns E303 on the line of the current word.
    fn truncated(&self, what: impl Into<String>) -> Error {
        Error::truncated(self.input, what).at(Place::Line(self.word_line))
    }

    /// Moves to the next word; returns `false` at the end of the file.
    fn next(&mut self) -> Result<bool> {
        self.word.clear();
        loop {
            let buffer = self.reader.fill_buf().map_err(|e| cannot_read(self.input, &e))?;
            if buffer.is_empty() {
                return Ok(!self.word.is_empty());
            }
            let mut n_used = 0;
            let mut done = false;
            for byte in buffer {
                // A byte-order mark does not belong to the first word.
                let is_mark = self.at + (n_used as u64) < 3 && matches!(byte, 0xef | 0xbb | 0xbf);
                if byte.is_ascii_whitespace() || *byte == 0x0b || is_mark {
                    if !self.word.is_empty() {
                        done = true;
                        break;
                    }
                    self.line += u64::from(*byte == b'\n');
                } else {
                    if self.word.is_empty() {
                        (self.word_at, self.word_line) = (self.at + n_used as u64, self.line);
                    }
                    self.word.push(*byte);
                    if self.word.len() > MAX_WORD_BYTES {
                        break;
                    }
                }
                n_used += 1;
            }
            self.reader.consume(n_used);
            self.at += n_used as u64;
            if self.word.len() > MAX_WORD_BYTES {
                return Err(self.malformed(format!("a word of more than {MAX_WORD_BYTES} bytes, wanted a number")));
            }
            if done {
                return Ok(true);
            }
        }
    }

    /// Returns the current word, for a message.
    fn text(&self) -> String {
        String::from_utf8_lossy(&self.word).into_owned()
    }

    /// Returns the current word as a number.
    fn number(&self) -> Result<f64> {
        std::str::from_utf8(&self.word)
            .ok()
            .and_then(|word| word.parse().ok())
            .ok_or_else(|| self.not_a_number(format!("`{}` is no number", self.text())))
    }

    /// Returns the error of a word that should be a number.
    fn not_a_number(&self, what: String) -> Error {
        let error = self.malformed(what);
        if self.word.contains(&b',') { error.because(Cause::DecimalCommas) } else { error }
    }
}

/// Reads the coordinate reference system from the `.prj` file beside a grid, if it can be
/// understood.
pub(super) fn sidecar_crs(input: &Input, odd: &mut Vec<Oddity>) -> Option<Crs> {
    let sidecar = input.beside("prj")?;
    let (file, _) = sidecar.open().ok()?;
    let mut text = String::new();
    let parsed = match file.take(1 << 20).read_to_string(&mut text) {
        Ok(_) => crs::parse(&text).map_err(|e| e.to_string()),
        Err(error) => Err(error.to_string()),
    };
    match parsed {
        Ok(crs) => Some(crs),
        Err(error) => {
            odd.push(Oddity::new(sidecar, OddRaster::CrsIgnored(error)));
            None
        }
    }
}

/// Writes a grid: the header, then `values` row by row from the north-west cell.
///
/// NaN and infinities are written as `nodata`. `decimals` is the number of digits behind the point;
/// `None` writes the fewest that read back as the same number. Cells that are not square get `dx`
/// and `dy`, as GDAL writes them. `out` is written once per row.
///
/// # Errors
/// If `out` cannot be written, or there is not exactly one value per cell.
pub fn write_ascii_grid(
    out: &mut impl Write,
    georef: &GeoRef,
    nodata: f64,
    mut values: impl Iterator<Item = f64>,
    decimals: Option<usize>,
) -> io::Result<()> {
    let (width, height) = (georef.cell_width(), georef.cell_height());
    writeln!(out, "ncols        {}", georef.n_cols())?;
    writeln!(out, "nrows        {}", georef.n_rows())?;
    writeln!(out, "xllcorner    {}", georef.x_min())?;
    writeln!(out, "yllcorner    {}", georef.y_min())?;
    if width.to_bits() == height.to_bits() {
        writeln!(out, "cellsize     {width}")?;
    } else {
        writeln!(out, "dx           {width}")?;
        writeln!(out, "dy           {height}")?;
    }
    writeln!(out, "NODATA_value {nodata}")?;
    let miscounted =
        |what| io::Error::new(io::ErrorKind::InvalidInput, format!("too {what} values for the cells of the grid"));
    let mut line = String::new();
    for _ in 0..georef.n_rows() {
        line.clear();
        for col in 0..georef.n_cols() {
            if col > 0 {
                line.push(' ');
            }
            let value = values.next().ok_or_else(|| miscounted("few"))?;
            // PERF: most values are classes, and floats take ten times as long.
            if let Some(digit) = digit_of(value).filter(|_| decimals.is_none()) {
                line.push(digit);
                continue;
            }
            // Writing to a string cannot fail.
            let _ = match decimals {
                _ if !value.is_finite() => write!(line, "{nodata}"),
                Some(decimals) => write!(line, "{value:.decimals$}"),
                None => write!(line, "{value}"),
            };
        }
        line.push('\n');
        out.write_all(line.as_bytes())?;
    }
    if values.next().is_some() { Err(miscounted("many")) } else { Ok(()) }
}

/// Returns the digit of a whole number below 10; −0 has none.
fn digit_of(value: f64) -> Option<char> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates, and is compared")]
    let digit = value as u8;
    (f64::from(digit).to_bits() == value.to_bits())
        .then_some(digit)
        .and_then(|digit| char::from_digit(digit.into(), 10))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_those_of_all_numbers_as_text() {
        for value in [0.0, -0.0, 1.0, 4.0, 9.0, 10.0, 255.0, 256.0, -1.0, 0.5, 1e300, f64::NAN] {
            let text = value.to_string();
            let digit = digit_of(value).map(String::from);
            assert_eq!(digit, Some(text.clone()).filter(|text| text.len() == 1), "{text}");
        }
    }

    #[test]
    fn a_grid_is_not_written_with_a_wrong_number_of_values() {
        let georef = GeoRef::new((0.0, 1.0), (1.0, 1.0), (1, 2), None).expect("a valid grid");
        for values in [vec![1.0], vec![1.0; 3]] {
            assert!(write_ascii_grid(&mut Vec::new(), &georef, -1.0, values.into_iter(), None).is_err());
        }
    }
}
