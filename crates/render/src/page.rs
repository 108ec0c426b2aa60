//! A page that grows downward: a title, a body, a caption.

use image::RgbaImage;

use super::furniture::{self, Block, TITLE};
use super::sheet::{Drawing, Sheet, pixels};

/// Margin around a page \[px\].
pub(crate) const MARGIN: f64 = 40.0;

/// A page that is not finished.
#[derive(Debug)]
pub(crate) struct Page {
    /// Width between the margins \[px\].
    pub(crate) width: f64,
    pub(crate) furniture: Drawing,
    images: Vec<(u32, u32, RgbaImage)>,
    /// Top of the next piece \[px\].
    pub(crate) bottom: f64,
}

impl Page {
    /// Begins with a title, if there is one, and a gap below it \[px\].
    pub(crate) fn new(title: &str, width: f64, gap: f64) -> Self {
        let title = furniture::paragraph(title, TITLE, width);
        let mut furniture = Drawing::default();
        furniture.place(&title.drawing, MARGIN, MARGIN - 6.0);
        let bottom = MARGIN + if title.height > 0.0 { title.height + gap } else { 0.0 };
        Page { width, furniture, images: Vec::new(), bottom }
    }

    /// Puts an image at a place.
    pub(crate) fn image(&mut self, [left, top]: [f64; 2], image: RgbaImage) {
        self.images.push((pixels(left), pixels(top), image));
    }

    /// Ends with the caption, if there is one, and a gap above its line \[px\].
    pub(crate) fn finish(mut self, gap: f64, caption: &[String]) -> Sheet {
        let caption = furniture::caption(caption, self.width);
        if caption.height > 0.0 {
            let line = self.bottom + gap;
            self.furniture.line([MARGIN, line], [MARGIN + self.width, line], &furniture::hairline());
            self.furniture.place(&caption.drawing, MARGIN, line + 14.0);
            self.bottom = line + 14.0 + caption.height;
        }
        let (width, height) = (self.width + 2.0 * MARGIN, self.bottom + MARGIN - 8.0);
        Sheet { width, height, images: self.images, furniture: self.furniture }
    }
}

/// Makes a page of a title, a body, and a caption, with gaps between them \[px\].
pub(crate) fn page(title: &str, body: &Block, caption: &[String], [above, below]: [f64; 2]) -> Sheet {
    let mut page = Page::new(title, body.width, above);
    page.bottom = page.bottom.round();
    page.furniture.place(&body.drawing, MARGIN, page.bottom);
    page.bottom += body.height;
    page.finish(below, caption)
}
