//! How a picture is written: its format and its size.

/// A format of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// Pixels.
    Png,
    /// Words and marks as vectors, maps as embedded pixels.
    Svg,
    /// As SVG, on one page; letters are outlines, so that no viewer needs the font.
    Pdf,
}

/// How a picture is written. It is laid out once, and scaled as one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureForm {
    /// The format.
    pub format: PictureFormat,
    /// Width \[px\], above 0; the height follows. `None`: as the picture is laid out.
    pub width_px: Option<u32>,
    /// Pixels per inch, above 0; with the width the size on paper. `None`: 200.
    pub dpi: Option<u32>,
}

/// At 200 dpi a large map is printed about 20 cm wide.
const DPI: u32 = 200;
const MM_PER_INCH: f64 = 25.4;

impl PictureForm {
    /// PNG as wide as it is laid out.
    pub const PNG: PictureForm = PictureForm { format: PictureFormat::Png, width_px: None, dpi: None };

    /// Factor from a picture laid out `width` \[px\] wide to the width that is wanted.
    pub(crate) fn scale(&self, width: u32) -> f64 {
        f64::from(self.width_px.unwrap_or(width)) / f64::from(width)
    }

    /// Pixels per inch.
    pub(crate) fn dpi(&self) -> u32 {
        self.dpi.unwrap_or(DPI)
    }

    /// Inches of so many pixels of the layout.
    pub(crate) fn inches(&self, width: u32, length: u32) -> f64 {
        f64::from(length) * self.scale(width) / f64::from(self.dpi())
    }

    /// Width and height in an SVG document: those of the layout, or the size on paper where one was asked for.
    pub(crate) fn svg_size(&self, width: u32, height: u32) -> [String; 2] {
        let on_paper = self.width_px.is_some() || self.dpi.is_some();
        [width, height].map(|length| match on_paper {
            true => format!("{:.3}mm", MM_PER_INCH * self.inches(width, length)),
            false => length.to_string(),
        })
    }
}
