//! Words and sizes that all pictures share.

use serde_json::Value;

use skyshed_request::{PictureOptions, Writing};

use crate::coverage::class;
use crate::error::{Error, ErrorRepr, Result};
use crate::export::Format;
use crate::height_field::HeightField;
use crate::raster::{CellWindow, Crs, GeoRef};
use crate::render::{Mark, OPEN_GROUND, PictureForm, PictureFormat, Sheet};
use crate::words::version;

/// A file to write and its format, checked before any work.
pub(crate) type Output = (std::path::PathBuf, Format);

/// Look of output files, where their extension leaves a choice.
#[derive(Debug, Clone, Default)]
pub(crate) struct Look {
    /// Title of pictures and pages.
    pub(crate) title: Option<String>,
    /// Attribution in captions, instead of that of the data.
    pub(crate) attribution: Option<String>,
    /// Width of pictures \[px\].
    pub(crate) width_px: Option<u32>,
    /// Pixels per inch of paper.
    pub(crate) dpi: Option<u32>,
    /// `true` if cells of tables that a spreadsheet would run are written as text.
    pub(crate) csv_text: bool,
}

impl Look {
    /// Returns the look of files.
    pub(crate) fn of(picture: &PictureOptions, writing: &Writing) -> Look {
        Look {
            title: picture.title.clone(),
            attribution: picture.attribution.clone(),
            width_px: picture.width,
            dpi: picture.dpi,
            csv_text: writing.csv_text,
        }
    }

    /// Returns the look of some files. Refuses words and sizes of pictures if no file would use
    /// them.
    ///
    /// # Errors
    /// E116.
    pub(crate) fn checked(picture: &PictureOptions, writing: &Writing, outputs: &[Output]) -> Result<Look> {
        let has = |wanted: fn(Format) -> bool| outputs.iter().any(|(_, format)| wanted(*format));
        let (has_picture, has_page) = (has(Format::is_picture), has(|format| format == Format::Html));
        let words = [("title", picture.title.is_some()), ("attribution", picture.attribution.is_some())];
        let sizes = [("width", picture.width.is_some()), ("dpi", picture.dpi.is_some())];
        let lost_words = words.iter().filter(|_| !has_picture && !has_page);
        match lost_words.chain(sizes.iter().filter(|_| !has_picture)).find(|(_, is_set)| *is_set) {
            Some((option, _)) => Err(Error::idle(*option, "without a .png, .svg or .pdf output")),
            None => Ok(Look::of(picture, writing)),
        }
    }

    /// Returns the requested title, or another.
    pub(crate) fn title_or(&self, other: impl FnOnce() -> String) -> String {
        self.title.clone().unwrap_or_else(other)
    }

    /// Returns the requested attribution, or that of the data.
    pub(crate) fn credit(&self, of_data: Option<&String>) -> Option<String> {
        self.attribution.as_ref().or(of_data).cloned()
    }

    /// Returns the form of a picture in a format.
    pub(crate) fn form(&self, format: Format) -> PictureForm {
        let format = match format {
            Format::Svg => PictureFormat::Svg,
            Format::Pdf => PictureFormat::Pdf,
            _ => PictureFormat::Png,
        };
        PictureForm { format, width_px: self.width_px, dpi: self.dpi }
    }
}

/// Returns the provenance of a picture: the program, and a document as one text.
pub(crate) fn picture_provenance(document: &Value) -> [(String, String); 2] {
    [("Software".into(), program()), ("skyshed".into(), document.to_string())]
}

/// Returns the program and its version, for captions.
pub(crate) fn program() -> String {
    format!("skyshed {}", version())
}

/// Returns the reference system of a grid, for captions.
pub(crate) fn crs_words(grid: &GeoRef) -> String {
    grid.crs().map_or("local coordinates".to_string(), Crs::label)
}

/// Returns the cells of a window, row by row.
pub(crate) fn crop<T: Copy>(cells: &[T], n_cols: usize, window: CellWindow) -> Vec<T> {
    let rows = cells.chunks_exact(n_cols).skip(window.row).take(window.n_rows);
    rows.map(|row| &row[window.col..window.col + window.n_cols]).collect::<Vec<_>>().concat()
}

/// Returns the classes of a mask in a window, for pictures. Open ground without a receiver gets a
/// class of its own, because it is no building.
pub(crate) fn shown_classes(mask: &[u8], field: &HeightField, window: CellWindow) -> Vec<u8> {
    let mut classes = crop(mask, field.grid().n_cols(), window);
    let open = &field.cells().open;
    for (k, class) in classes.iter_mut().enumerate().filter(|(_, class)| **class == class::NOT_A_RECEIVER) {
        if open.contains(window.row + k / window.n_cols, window.col + k % window.n_cols) {
            *class = OPEN_GROUND;
        }
    }
    classes
}

/// Returns the cells that some boxes (west, south, east, north) reach, or all cells of the grid if
/// they reach none.
pub(crate) fn window_of(grid: &GeoRef, boxes: impl Iterator<Item = [f64; 4]>) -> CellWindow {
    // Rows count from the north, positions from the south.
    let span = |low: f64, high: f64, n: usize| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the grid")]
        let (low, high) = (low.floor().clamp(0.0, n as f64) as usize, high.ceil().clamp(0.0, n as f64) as usize);
        (low < high).then_some([low, high])
    };
    let of_box = |[west, south, east, north]: [f64; 4]| {
        let (west, south) = grid.cells_from_world(west, south);
        let (east, north) = grid.cells_from_world(east, north);
        let height = grid.n_rows() as f64;
        span(west, east, grid.n_cols()).zip(span(height - north, height - south, grid.n_rows()))
    };
    let join = |a: [usize; 2], b: [usize; 2]| [a[0].min(b[0]), a[1].max(b[1])];
    let found = boxes.filter_map(of_box).reduce(|a, b| (join(a.0, b.0), join(a.1, b.1)));
    found.map_or(grid.window(), |([west, east], [north, south])| CellWindow {
        row: north,
        col: west,
        n_rows: south - north,
        n_cols: east - west,
    })
}

/// Returns the mark of a UAV at a place, on a map of a grid.
pub(crate) fn mark<'a>(shown: &GeoRef, (x, y): (f64, f64), label: &'a str, height: &'a str) -> Mark<'a> {
    let (col, row) = ((x - shown.x_min()) / shown.cell_width(), (shown.y_max() - y) / shown.cell_height());
    Mark { label, height, col, row, is_observer: false }
}

/// Encodes a drawn picture with its provenance.
///
/// # Errors
/// E403.
pub(crate) fn written(
    picture: std::result::Result<Sheet, String>,
    form: &PictureForm,
    provenance: &[(String, String)],
) -> Result<Vec<u8>> {
    drawn(picture.and_then(|sheet| sheet.write(form, provenance)))
}

/// Returns a drawn picture, or the error of drawing it.
///
/// # Errors
/// E403.
pub(crate) fn drawn(picture: std::result::Result<Vec<u8>, String>) -> Result<Vec<u8>> {
    picture.map_err(|why| ErrorRepr::Drawing(why).into())
}
