//! Plots of one size in a grid; neighbors with the same axis name show it once.

use super::furniture::{self, Block, NAME};
use super::plot::{self, Axis};
use super::sheet::Drawing;

/// Most plots on a sheet.
pub(crate) const MOST_PANELS: usize = 12;
/// Gaps between neighboring plots, besides the room for axes \[px\].
const GAPS: [f64; 2] = [30.0, 26.0];

/// Gaps between the plots and their key, at the right and below \[px\].
const KEY_GAPS: [f64; 2] = [40.0, 20.0];

/// A plot without its frame and axes.
#[derive(Clone, Debug)]
pub(crate) struct Panel<'a> {
    /// Heading; may be empty.
    pub(crate) title: &'a str,
    /// Horizontal axis.
    pub(crate) x: Axis,
    /// Vertical axis.
    pub(crate) y: Axis,
    /// Drawing inside the frame.
    pub(crate) content: Drawing,
}

/// Plots in a grid.
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    /// Drawing of all plots.
    pub(crate) block: Block,
    /// Top left corner of the first frame \[px\].
    pub(crate) first_frame: [f64; 2],
    /// Free room at the right of an incomplete last row: left, top, width, height \[px\].
    pub(crate) free: Option<[f64; 4]>,
}

impl Grid {
    /// Puts a block into the middle of the free corner; returns `false` if there is no room for it.
    pub(crate) fn place_in_corner(&mut self, key: &Block) -> bool {
        let Some([left, top, width, height]) = self.free.filter(|[_, _, w, h]| key.width <= *w && key.height <= *h)
        else {
            return false;
        };
        let (right, down) = ((width - key.width) / 2.0, (height - key.height) / 2.0);
        self.block.drawing.place(&key.drawing, (left + right).round(), (top + down).round());
        true
    }

    /// Puts a block to the right of everything, its top at that of the first frame.
    pub(crate) fn place_beside(&mut self, key: &Block) {
        let (left, top) = (self.block.width + KEY_GAPS[0], self.first_frame[1]);
        self.block.drawing.place(&key.drawing, left, top);
        self.block.width = left + key.width;
        self.block.height = self.block.height.max(top + key.height);
    }

    /// Puts a block below everything, `left` \[px\] from the left.
    pub(crate) fn place_below(&mut self, key: &Block, left: f64) {
        let top = self.block.height + KEY_GAPS[1];
        self.block.drawing.place(&key.drawing, left, top);
        self.block.width = self.block.width.max(left + key.width);
        self.block.height = top + key.height;
    }
}

/// Refuses a number of panels or columns that cannot be arranged.
pub(crate) fn check(n_panels: usize, columns: usize) -> Result<(), String> {
    match (1..=MOST_PANELS).contains(&n_panels) && columns > 0 {
        true => Ok(()),
        false => Err(format!("cannot draw {n_panels} panels in {columns} columns: wanted 1 to {MOST_PANELS} panels")),
    }
}

/// Places panels with frames of `size` \[px\] row by row; there is at least one panel and one
/// column.
pub(crate) fn grid(mut panels: Vec<Panel<'_>>, columns: usize, size: [f64; 2]) -> Grid {
    let (n, columns) = (panels.len(), columns.min(panels.len()));
    // Backwards for vertical axes and forwards for horizontal ones, so that each name is compared
    // before it is cleared.
    for k in (1..n).rev().filter(|k| k % columns > 0) {
        if panels[k - 1].y.name == panels[k].y.name {
            panels[k].y.name.clear();
        }
    }
    for k in 0..n.saturating_sub(columns) {
        if panels[k + columns].x.name == panels[k].x.name {
            panels[k].x.name.clear();
        }
    }
    // Room left of the frames of a column, and below those of a row.
    let left_of = |axis: &Axis| {
        if axis.name.is_empty() { 14.0 + axis.widest_text().ceil() } else { axis.name_at + 24.0 }
    };
    let below = |axis: &Axis| if axis.name.is_empty() { 38.0 } else { axis.name_at + 8.0 };
    let titles: Vec<Block> = panels.iter().map(|panel| furniture::paragraph(panel.title, NAME, size[0])).collect();
    let title_height = |block: &Block| if block.height > 0.0 { block.height + 10.0 } else { 0.0 };
    let n_rows = n.div_ceil(columns);
    let highest = |lengths: &mut dyn Iterator<Item = f64>| lengths.fold(0.0, f64::max);
    let widest = |of: &dyn Fn(&Panel<'_>) -> f64| -> Vec<f64> {
        (0..columns).map(|col| highest(&mut panels.iter().skip(col).step_by(columns).map(of))).collect()
    };
    let lefts = widest(&|panel| left_of(&panel.y));
    // The text of the last tick may reach beyond a frame.
    let rights = widest(&|panel| panel.x.text_beyond(size[0]));
    let frame_x = |col: usize| {
        let before = lefts.iter().take(col + 1).chain(rights.iter().take(col)).sum::<f64>();
        before + (size[0] + GAPS[0]) * col as f64
    };
    let mut drawing = Drawing::default();
    let mut y = 0.0;
    let mut first_frame = [frame_x(0), 0.0];
    let mut last_row = [0.0; 2];
    for row in 0..n_rows {
        let here = row * columns..n.min((row + 1) * columns);
        let head = highest(&mut titles[here.clone()].iter().map(title_height));
        let foot = highest(&mut panels[here.clone()].iter().map(|panel| below(&panel.x)));
        let top = y + head;
        for k in here {
            let left = frame_x(k % columns);
            drawing.place(&titles[k].drawing, left, top - title_height(&titles[k]));
            draw_panel(&mut drawing, &panels[k], size, [left, top]);
        }
        if row == 0 {
            first_frame[1] = top;
        }
        last_row = [y, head + size[1] + foot];
        y = top + size[1] + foot + GAPS[1];
    }
    let width = frame_x(columns - 1) + size[0] + rights[columns - 1];
    let height = y - GAPS[1];
    let n_last = n - (n_rows - 1) * columns;
    let free = (n_last < columns).then(|| {
        let left = frame_x(n_last - 1) + size[0] + rights[n_last - 1] + GAPS[0];
        [left, last_row[0], width - left, last_row[1]]
    });
    Grid { block: Block { width, height, drawing }, first_frame, free }
}

fn draw_panel(drawing: &mut Drawing, panel: &Panel<'_>, size: [f64; 2], [left, top]: [f64; 2]) {
    let mut framed = plot::axes(size, &panel.x, &panel.y);
    furniture::frame(&mut framed, [0.0; 2], size);
    framed.add(&panel.content);
    drawing.place(&framed, left, top);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Direction, Span};

    fn panel(title: &'static str, x: &str) -> Panel<'static> {
        let span = Span::linear(0.0, 1.0);
        Panel {
            title,
            x: span.axis(x, Direction::Across, 300.0),
            y: span.axis("P_LoS", Direction::Up, 200.0),
            content: Drawing::default(),
        }
    }

    #[test]
    fn neighbors_share_the_names_of_their_axes() {
        let grid = grid((0..5).map(|_| panel("a", "θ")).collect(), 3, [300.0, 200.0]);
        // In the second row two panels; over the free place the third has its own name.
        assert_eq!(grid.block.drawing.svg.matches(">θ<").count(), 3);
        assert_eq!(grid.block.drawing.svg.matches("matrix(0 -1 1 0").count(), 2);
        let [left, top, width, height] = grid.free.expect("five panels leave a place of six");
        assert!(left > 2.0 * 300.0 && width >= 300.0 && (left + width - grid.block.width).abs() < 1e-9);
        assert!(top > 200.0 && height > 200.0);
        let different = super::grid(vec![panel("a", "θ"), panel("a", "φ")], 1, [300.0, 200.0]);
        assert!(different.block.drawing.svg.contains(">θ<") && different.block.drawing.svg.contains(">φ<"));
        assert!(different.free.is_none());
    }
}
