//! What pictures say beside what they show, and how large they are.

use std::path::PathBuf;

use clap::Args;

use crate::error::{Error, Result};
use crate::export::Format;
use crate::raster::{CellWindow, GeoRef};
use crate::render::{Mark, PictureForm, PictureFormat};

/// What a picture says beside what it shows.
#[derive(Debug, Clone, Default, Args)]
pub struct PictureWords {
    /// Title of the picture, or of the page
    #[arg(long, value_name = "TEXT")]
    pub(crate) title: Option<String>,
    /// Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    #[arg(long, value_name = "TEXT")]
    pub(crate) attribution: Option<String>,
    #[command(flatten)]
    pub(crate) size: PictureSize,
}

/// How large a picture is.
#[derive(Debug, Clone, Copy, Default, Args)]
pub struct PictureSize {
    /// Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(100..=10_000))]
    pub(crate) width: Option<u32>,
    /// Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=2400))]
    pub(crate) dpi: Option<u32>,
}

impl PictureSize {
    /// How a picture of a format is written.
    pub(crate) fn form(self, format: Format) -> PictureForm {
        let format = match format {
            Format::Svg => PictureFormat::Svg,
            Format::Pdf => PictureFormat::Pdf,
            _ => PictureFormat::Png,
        };
        PictureForm { format, width_px: self.width, dpi: self.dpi }
    }

    /// Where no picture is made, its size would be lost in silence.
    pub(crate) fn refuse_without_picture(self, outputs: &[(PathBuf, Format)]) -> Result<()> {
        if outputs.iter().any(|(_, format)| format.is_picture()) {
            return Ok(());
        }
        match [("--width", self.width), ("--dpi", self.dpi)].iter().find(|(_, size)| size.is_some()) {
            Some((flag, _)) => Err(no_picture(flag)),
            None => Ok(()),
        }
    }
}

/// A flag of pictures without a picture.
fn no_picture(flag: &str) -> Error {
    Error::usage(116, format!("`{flag}` has no meaning without a .png, .svg or .pdf output"))
}

impl PictureWords {
    /// The title that was typed, or another.
    pub(crate) fn title_or(&self, other: impl FnOnce() -> String) -> String {
        self.title.clone().unwrap_or_else(other)
    }

    /// Whom to credit: as typed, or as the scene asks for.
    pub(crate) fn credit(&self, of_scene: Option<&String>) -> Option<String> {
        self.attribution.as_ref().or(of_scene).cloned()
    }

    /// A title, an attribution or a size is that of a picture; where none is made, it would be lost in silence.
    pub(crate) fn refuse_without_picture(&self, outputs: &[(PathBuf, Format)]) -> Result<()> {
        let has_picture = outputs.iter().any(|(_, format)| format.is_picture() || *format == Format::Html);
        let typed = [("--title", &self.title), ("--attribution", &self.attribution)];
        match typed.iter().find(|(_, words)| words.is_some()) {
            Some((flag, _)) if !has_picture => Err(no_picture(flag)),
            _ => self.size.refuse_without_picture(outputs),
        }
    }
}

/// The cells of a window, row by row.
pub(crate) fn crop<T: Copy>(cells: &[T], n_cols: usize, window: CellWindow) -> Vec<T> {
    let rows = cells.chunks_exact(n_cols).skip(window.row).take(window.n_rows);
    rows.flat_map(|row| row[window.col..window.col + window.n_cols].iter().copied()).collect()
}

/// The mark of a UAV at a place, on a map of a grid.
pub(crate) fn mark<'a>(shown: &GeoRef, (x, y): (f64, f64), label: &'a str, height: &'a str) -> Mark<'a> {
    let (col, row) = ((x - shown.x_min()) / shown.cell_width(), (shown.y_max() - y) / shown.cell_height());
    Mark { label, height, col, row }
}

pub(crate) fn undrawable(cause: String) -> Error {
    Error::internal(403, format!("cannot draw the picture: {cause}"))
}
