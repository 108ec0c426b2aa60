//! The legend of lines: one for all panels, where there is room for it.

use super::colors::MUTED;
use super::curve_sheet::{CurveLine, CurvePanel};
use super::furniture::{self, Block, DETAIL, NAME};
use super::lettering::{self, Weight};
use super::line_look::{LineStyle, MARKER};
use super::panel_grid::Grid;
use super::sheet::{Drawing, Type};

/// Length of the sample of a line \[px\].
const SAMPLE: f64 = 84.0;
/// From its start to the words \[px\].
const WORDS: f64 = SAMPLE + 16.0;
/// Words wider than this are wrapped \[px\].
const WIDEST: f64 = 400.0;
/// Between entries: in a row, in a column \[px\].
const GAPS: [f64; 2] = [48.0, 14.0];

const LABEL: Type = Type { weight: Weight::Regular, ..NAME };
const SMALL: Type = Type { size: 21.0, color: MUTED, ..DETAIL };

/// A line of the legend.
#[derive(Clone, Debug)]
pub(crate) struct Entry<'a> {
    line: CurveLine<'a>,
    has_band: bool,
    pub(crate) style: LineStyle,
}

impl Entry<'_> {
    /// What the line is called.
    pub(crate) fn label(&self) -> &str {
        self.line.label
    }
}

/// Collects what panels draw, each label once, in the order in which they come.
///
/// # Errors
/// A label that means two looks, colors or details.
pub(crate) fn entries<'a>(panels: &[CurvePanel<'a>]) -> Result<Vec<Entry<'a>>, String> {
    let mut entries: Vec<Entry<'a>> = Vec::new();
    for line in panels.iter().flat_map(|panel| panel.lines).filter(|line| !line.label.is_empty()) {
        let has_band = line.points.iter().any(|p| p.y.and(p.low_high).is_some());
        if let Some(known) = entries.iter_mut().find(|e| e.line.label == line.label) {
            known.has_band |= has_band;
            let meaning = |line: &CurveLine<'a>| (line.look, line.color_index, line.detail);
            if meaning(&known.line) != meaning(line) {
                let label = line.label;
                return Err(format!(
                    "cannot draw the line `{label}`: it must have one look, color and detail everywhere"
                ));
            }
            continue;
        }
        entries.push(Entry { line: *line, has_band, style: LineStyle::new(line.look, line.color_index) });
    }
    Ok(entries)
}

/// Puts the legend into the free corner of a grid of plots, else to its right, else below.
pub(crate) fn with_legend(mut grid: Grid, entries: &[Entry<'_>]) -> Block {
    let blocks: Vec<Block> = entries.iter().map(block).collect();
    if blocks.is_empty() {
        return grid.block;
    }
    // One column in the free corner or at the right, else two that may reach further down, else rows below.
    let column = furniture::stack(&blocks, GAPS[1]);
    if grid.place_in_corner(&column) {
        return grid.block;
    }
    let halves: Vec<Block> =
        blocks.chunks(blocks.len().div_ceil(2)).map(|half| furniture::stack(half, GAPS[1])).collect();
    for (columns, reach) in [(&[column][..], 1.0), (&halves, 1.5)] {
        let highest = columns.iter().map(|c| c.height).fold(0.0, f64::max);
        if grid.first_frame[1] + highest <= reach * grid.block.height {
            grid.place_beside(&furniture::flow(columns, f64::INFINITY, GAPS));
            return grid.block;
        }
    }
    let rows = furniture::flow(&blocks, grid.block.width, GAPS);
    let left = (grid.block.width - rows.width).max(0.0) / 2.0;
    grid.place_below(&rows, left.min(grid.first_frame[0]));
    grid.block
}

/// Labels and details of more lines than about this are shortened.
const MOST_LINES: f64 = 3.0;

/// Draws an entry: a sample of the line, its label, and its detail below in smaller type.
fn block(entry: &Entry<'_>) -> Block {
    let mut drawing = Drawing::default();
    let (style, y) = (&entry.style, 16.0);
    let middle = [SAMPLE / 2.0, y];
    if style.has_line() {
        if entry.has_band {
            drawing.rect([0.0, y - 12.0, SAMPLE, 24.0], &style.band());
        }
        drawing.line([0.0, y], [SAMPLE, y], &style.stroke());
    } else if entry.has_band {
        style.draw_error_bar(&mut drawing, middle[0], [y - 2.0 * MARKER, y + 2.0 * MARKER], [true; 2]);
    }
    if style.has_markers() {
        style.draw_marker(&mut drawing, middle);
    }
    let (mut height, mut width) = (0.0, 0.0_f64);
    for (text, kind, leading) in [(entry.line.label, LABEL, 32.0), (entry.line.detail.unwrap_or_default(), SMALL, 27.0)]
    {
        let text = lettering::shortened(text, kind, MOST_LINES * WIDEST);
        for line in lettering::wrap(&text, kind.size, kind.weight, WIDEST) {
            drawing.text(WORDS, height + 25.0 - if kind.size < LABEL.size { 4.0 } else { 0.0 }, kind, &line);
            width = width.max(lettering::width(&line, kind.size, kind.weight));
            height += leading;
        }
    }
    Block { width: WORDS + width, height, drawing }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CurveAxis, CurvePoint, LineLook};

    const POINTS: [CurvePoint; 2] =
        [CurvePoint { x: 0.0, y: Some(0.5), low_high: None }, CurvePoint { x: 1.0, y: Some(0.6), low_high: None }];

    fn line(label: &str, look: LineLook) -> CurveLine<'_> {
        CurveLine { label, detail: Some("a detail"), color_index: 0, look, points: &POINTS, through: &[] }
    }

    fn panel<'a>(lines: &'a [CurveLine<'a>]) -> CurvePanel<'a> {
        let x = CurveAxis { name: "x", ends: [0.0, 1.0], is_log: false };
        CurvePanel { title: "", x, y_name: "y", y_ends: [0.0, 1.0], lines }
    }

    fn grid(free: Option<[f64; 4]>) -> Grid {
        let block = Block { width: 800.0, height: 600.0, drawing: Drawing::default() };
        Grid { block, first_frame: [90.0, 0.0], free }
    }

    #[test]
    fn a_label_has_one_entry_in_the_order_given() {
        let second = CurveLine { color_index: 1, ..line("a", LineLook::Dashed) };
        let (a, b) = ([line("b", LineLook::Dashed), second], [line("b", LineLook::Dashed)]);
        let panels = [panel(&a), panel(&b)];
        let entries = entries(&panels).expect("the labels agree");
        let labels: Vec<&str> = entries.iter().map(|e| e.line.label).collect();
        assert_eq!(labels, ["b", "a"]);
        assert_ne!(entries[0].style.stroke(), entries[1].style.stroke(), "the patterns differ");
        let other = [line("b", LineLook::Solid)];
        let error = super::entries(&[panel(&a), panel(&other)]).expect_err("`b` means two looks");
        assert!(error.contains("`b`") && error.contains("one look"), "{error}");
    }

    #[test]
    fn entries_do_not_overlap_and_fit_wherever_the_legend_stands() {
        let labels: Vec<String> = (0..24).map(|k| format!("line {k} {}", "with a long name ".repeat(k % 4))).collect();
        for n in [1, 8, 24] {
            let lines: Vec<CurveLine<'_>> = labels[..n].iter().map(|label| line(label, LineLook::Solid)).collect();
            let panels = [panel(&lines)];
            let entries = entries(&panels).expect("the labels differ");
            for entry in &entries {
                let block = block(entry);
                assert!(block.width <= WORDS + WIDEST && block.height >= 59.0, "{} {}", block.width, block.height);
                let baselines = block.drawing.svg.matches("<text").count() as f64;
                assert!(block.height >= 27.0 * baselines);
            }
            for free in [None, Some([500.0, 0.0, 800.0, 700.0])] {
                let all = with_legend(grid(free), &entries);
                assert_eq!(all.drawing.svg.matches(">a detail<").count(), n);
                let is_beside = all.width > 800.0;
                let is_below = all.height > 600.0;
                assert_eq!((is_beside, is_below), (free.is_none() && n < 24, n == 24), "{n} {free:?}");
            }
        }
    }

    #[test]
    fn samples_show_bands_and_error_bars_only_where_there_are_some() {
        let sample = |look, has_band| {
            let style = LineStyle::new(look, 0);
            block(&Entry { line: line("a", look), has_band, style }).drawing.svg
        };
        assert!(sample(LineLook::Solid, true).contains("fill-opacity"));
        assert!(!sample(LineLook::Solid, false).contains("fill-opacity"));
        assert_eq!(sample(LineLook::Markers, true).matches("<line").count(), 3);
        assert_eq!(sample(LineLook::Markers, false).matches("<line").count(), 0);
        assert!(sample(LineLook::Dashed, false).contains("dasharray"));
    }
}
