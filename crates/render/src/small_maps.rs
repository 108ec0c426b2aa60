//! Small maps on one page: rows of panels that grow downward, one legend for all, a caption.

use image::RgbaImage;

use super::furniture::{self, Block, DETAIL, NAME, TITLE};
use super::lettering;
use super::marks::{Mark, draw_marks};
use super::sheet::{Drawing, Sheet, Type, pixels};

const MARGIN: f64 = 40.0;
/// Between neighboring maps \[px\].
const GAPS: [f64; 2] = [34.0, 30.0];
/// No map is narrower, or its title would need many lines \[px\].
const NARROWEST: f64 = 380.0;
/// Headings of rows and of parts of the legend.
pub(crate) const HEADING: Type = Type { size: 30.0, ..NAME };

/// One small map with its words.
#[derive(Debug)]
pub(crate) struct Panel {
    words: Block,
    image: RgbaImage,
    marks: Drawing,
}

/// What the maps of a page have in common.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Maps {
    /// Size of a map \[px\].
    pub(crate) size: [f64; 2],
    /// Columns and rows of its cells.
    pub(crate) n_cells: [usize; 2],
    /// Cell size along columns and rows \[m\].
    pub(crate) cell_m: (f64, f64),
    /// Maps beside each other.
    pub(crate) columns: usize,
}

impl Maps {
    /// Width that a map and its words have \[px\].
    fn width(&self) -> f64 {
        self.size[0].max(NARROWEST)
    }

    /// Width of everything between the margins \[px\].
    pub(crate) fn body_width(&self) -> f64 {
        (self.width() + GAPS[0]) * self.columns as f64 - GAPS[0]
    }

    /// Pixels of a cell along columns and rows.
    pub(crate) fn px_per_cell(&self) -> [f64; 2] {
        [0, 1].map(|k| self.size[k] / self.n_cells[k] as f64)
    }

    /// A map with a title, a line below that, and marks.
    pub(crate) fn panel(&self, (title, detail): (&str, &str), image: RgbaImage, marks: &[Mark<'_>]) -> Panel {
        let title = lettering::shortened(title, NAME, 2.0 * self.width());
        let words =
            [furniture::paragraph(&title, NAME, self.width()), furniture::paragraph(detail, DETAIL, self.width())];
        let marks = draw_marks(marks, self.size, self.px_per_cell(), self.cell_m);
        Panel { words: furniture::stack(&words, 2.0), image, marks }
    }

    /// Scale bar and north arrow.
    fn orientation(&self) -> Block {
        let px_per_m = self.px_per_cell()[0] / self.cell_m.0;
        let scale_bar = furniture::scale_bar(px_per_m, (0.3 * self.size[0]).clamp(140.0, 260.0));
        furniture::beside(&[scale_bar, furniture::north_arrow()], 26.0)
    }
}

impl Panel {
    /// Draws more over the map.
    pub(crate) fn with(mut self, drawing: &Drawing) -> Self {
        self.marks.place(drawing, 0.0, 0.0);
        self
    }
}

/// A page that grows downward.
#[derive(Debug)]
pub(crate) struct Page {
    maps: Maps,
    furniture: Drawing,
    images: Vec<(u32, u32, RgbaImage)>,
    /// Where the next piece goes \[px\].
    bottom: f64,
}

impl Page {
    /// Begins with a title.
    pub(crate) fn new(title: &str, maps: Maps) -> Self {
        let title = furniture::paragraph(title, TITLE, maps.body_width());
        let mut page = Page { maps, furniture: Drawing::default(), images: Vec::new(), bottom: MARGIN - 6.0 };
        page.furniture.place(&title.drawing, MARGIN, page.bottom);
        page.bottom += title.height + 18.0;
        page
    }

    /// Places a sentence below the title.
    pub(crate) fn lead(&mut self, text: &str) {
        let text = furniture::paragraph(text, NAME, self.maps.body_width());
        self.bottom -= 12.0;
        self.furniture.place(&text.drawing, MARGIN, self.bottom);
        self.bottom += text.height + 18.0;
    }

    /// Places a heading.
    pub(crate) fn heading(&mut self, text: &str) {
        self.furniture.text(MARGIN, self.bottom + 28.0, HEADING, text);
        self.bottom += 46.0;
    }

    /// Places maps row by row, those of a row at one height.
    pub(crate) fn panels(&mut self, panels: Vec<Panel>) {
        let [width, height] = self.maps.size;
        let mut panels = panels.into_iter().peekable();
        while panels.peek().is_some() {
            let row: Vec<Panel> = panels.by_ref().take(self.maps.columns).collect();
            let words = row.iter().map(|panel| panel.words.height).fold(0.0, f64::max);
            let top = (self.bottom + words + 8.0).round();
            for (col, panel) in row.into_iter().enumerate() {
                let left = (MARGIN + (self.maps.width() + GAPS[0]) * col as f64).round();
                self.furniture.place(&panel.words.drawing, left, self.bottom);
                self.furniture.rect([left - 0.8, top - 0.8, width + 1.6, height + 1.6], &furniture::frame());
                self.furniture.place(&panel.marks, left, top);
                self.images.push((pixels(left), pixels(top), panel.image));
            }
            self.bottom = top + height + GAPS[1];
        }
    }

    /// Places the legend that is made for the room beside the scale bar and the north arrow.
    pub(crate) fn legend(&mut self, legend: impl FnOnce(f64) -> Block) {
        let orientation = self.maps.orientation();
        let body_w = self.maps.body_width();
        let legend = legend(body_w - orientation.width - 44.0);
        self.furniture.place(&legend.drawing, MARGIN, self.bottom);
        self.furniture.place(&orientation.drawing, MARGIN + body_w - orientation.width, self.bottom + 10.0);
        self.bottom += legend.height.max(orientation.height + 10.0) + 26.0;
    }

    /// Ends with the caption.
    pub(crate) fn finish(mut self, caption: &[String]) -> Sheet {
        let body_w = self.maps.body_width();
        let caption = furniture::caption(caption, body_w);
        self.furniture.line([MARGIN, self.bottom], [MARGIN + body_w, self.bottom], &furniture::hairline());
        self.furniture.place(&caption.drawing, MARGIN, self.bottom + 14.0);
        let height = self.bottom + 14.0 + caption.height + MARGIN - 8.0;
        Sheet { width: body_w + 2.0 * MARGIN, height, images: self.images, furniture: self.furniture }
    }
}
