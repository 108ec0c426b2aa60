//! Small maps on one page: rows of panels, one legend for all maps.

use image::RgbaImage;

use super::furniture::{self, Block, DETAIL, NAME};
use super::marks::{Mark, draw_marks};
use super::page::{MARGIN, Page};
use super::paint::Canvas;
use super::sheet::{Drawing, Sheet};

/// Gaps between neighboring maps \[px\].
const GAPS: [f64; 2] = [34.0, 30.0];
/// Least width of a panel \[px\]; in a narrower one the title would need many lines.
const NARROWEST: f64 = 380.0;

/// One small map with its words.
#[derive(Debug)]
pub(crate) struct Panel {
    words: Block,
    image: RgbaImage,
    /// Marks and rings over the map.
    pub(crate) over: Drawing,
}

/// Canvas and arrangement that the maps of a page share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Maps<'a> {
    pub(crate) canvas: Canvas<'a>,
    /// Number of maps in a row.
    columns: usize,
}

impl<'a> Maps<'a> {
    /// Makes maps of the same cells, `columns` in a row, whose longer sides aim at `target` \[px\].
    ///
    /// # Errors
    /// Cells without a size, or a surface of another shape.
    pub(crate) fn new(
        n_cells: [usize; 2],
        cell_m: (f64, f64),
        surface_m: Option<&'a [f32]>,
        (columns, target): (usize, f64),
    ) -> Result<Self, String> {
        Ok(Maps { canvas: Canvas::new(n_cells, cell_m, surface_m, (target, 1.4 * target))?, columns })
    }

    /// Returns the width of a map and its words \[px\].
    fn width(&self) -> f64 {
        self.canvas.size()[0].max(NARROWEST)
    }

    /// Begins a page with a title.
    pub(crate) fn page(&self, title: &str) -> Page {
        let mut page = Page::new(title, (self.width() + GAPS[0]) * self.columns as f64 - GAPS[0], 0.0);
        page.bottom += 12.0;
        page
    }

    /// Makes a map with a title, a line below that, and marks.
    pub(crate) fn panel(&self, (title, detail): (&str, &str), image: RgbaImage, marks: &[Mark<'_>]) -> Panel {
        let title = NAME.shortened(title, 2.0 * self.width());
        let words =
            [(&*title, NAME), (detail, DETAIL)].map(|(text, kind)| furniture::paragraph(text, kind, self.width()));
        let (over, _) = draw_marks(marks, self.canvas.size(), self.canvas.px_per_cell(), self.canvas.cell_m);
        Panel { words: furniture::stack(&words, 2.0), image, over }
    }

    /// Places maps row by row; the maps of a row are level.
    pub(crate) fn place(&self, page: &mut Page, panels: Vec<Panel>) {
        let [width, height] = self.canvas.size();
        let mut panels = panels.into_iter().peekable();
        while panels.peek().is_some() {
            let row: Vec<Panel> = panels.by_ref().take(self.columns).collect();
            let words = row.iter().map(|panel| panel.words.height).fold(0.0, f64::max);
            let top = (page.bottom + words + 8.0).round();
            for (col, panel) in row.into_iter().enumerate() {
                let left = (MARGIN + (self.width() + GAPS[0]) * col as f64).round();
                page.furniture.place(&panel.words.drawing, left, page.bottom);
                furniture::frame(&mut page.furniture, [left, top], [width, height]);
                page.furniture.place(&panel.over, left, top);
                page.image([left, top], panel.image);
            }
            page.bottom = top + height + GAPS[1];
        }
    }

    /// Ends a page with a legend, made for the room beside the scale bar and the north arrow, and a
    /// caption.
    pub(crate) fn finish(&self, mut page: Page, legend: impl FnOnce(f64) -> Block, caption: &[String]) -> Sheet {
        let px_per_m = self.canvas.px_per_cell()[0] / self.canvas.cell_m.0;
        let orientation = furniture::orientation(px_per_m, (0.3 * self.canvas.size()[0]).clamp(140.0, 260.0));
        let legend = legend(page.width - orientation.width - 44.0);
        page.furniture.place(&legend.drawing, MARGIN, page.bottom);
        page.furniture.place(&orientation.drawing, MARGIN + page.width - orientation.width, page.bottom + 10.0);
        page.bottom += legend.height.max(orientation.height + 10.0) + 26.0;
        page.finish(0.0, caption)
    }
}
