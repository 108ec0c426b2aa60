//! Legend of lines: one for all panels, placed in a corner, at the right or below.

use super::curve_lines::CurveLine;
use super::furniture::{self, Block, NAME};
use super::lettering::{Type, Weight};
use super::line_look::MARKER;
use super::panel_grid::Grid;
use super::sheet::Drawing;

/// Length of the sample of a line \[px\].
const SAMPLE: f64 = 84.0;
/// Distance from the start of the sample to the words \[px\].
const WORDS: f64 = SAMPLE + 16.0;
/// Widest words \[px\]; wider ones are wrapped.
const WIDEST: f64 = 400.0;
/// Gaps between entries: in a row, in a column \[px\].
const GAPS: [f64; 2] = [48.0, 14.0];

const LABEL: Type = Type { weight: Weight::Regular, ..NAME };

/// Entry of the legend.
#[derive(Clone, Debug)]
pub(crate) struct Entry<'a> {
    line: CurveLine<'a>,
    has_band: bool,
}

/// Collects lines, each label once, in order of appearance.
///
/// # Errors
/// A label with two looks or colors.
pub(crate) fn entries<'a>(lines: impl Iterator<Item = &'a CurveLine<'a>>) -> Result<Vec<Entry<'a>>, String> {
    let mut entries: Vec<Entry<'a>> = Vec::new();
    for line in lines.filter(|line| !line.label.is_empty()) {
        let has_band = line.points.iter().any(|p| p.y.and(p.low_high).is_some());
        if let Some(known) = entries.iter_mut().find(|e| e.line.label == line.label) {
            known.has_band |= has_band;
            if (known.line.look, known.line.color_index) != (line.look, line.color_index) {
                return Err(format!("cannot draw `{}`: wanted one look and color everywhere", line.label));
            }
        } else {
            entries.push(Entry { line: *line, has_band });
        }
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

/// Most lines of a label, roughly; longer ones are shortened.
const MOST_LINES: f64 = 3.0;

/// Draws an entry: a sample of the line, and its label.
fn block(entry: &Entry<'_>) -> Block {
    let mut drawing = Drawing::default();
    let (style, y) = (entry.line.style(), 16.0);
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
    for line in LABEL.wrap(&LABEL.shortened(entry.line.label, MOST_LINES * WIDEST), WIDEST) {
        drawing.text(WORDS, height + 25.0, LABEL, &line);
        width = width.max(LABEL.width(&line));
        height += 32.0;
    }
    Block { width: WORDS + width, height, drawing }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve_lines::CurvePoint;
    use crate::line_look::LineLook;

    const POINTS: [CurvePoint; 1] = [CurvePoint { x: 0.0, y: Some(0.5), low_high: None }];

    fn line(label: &str, look: LineLook) -> CurveLine<'_> {
        CurveLine { label, color_index: 0, look, points: &POINTS, through: &[] }
    }

    #[test]
    fn a_label_has_one_entry_and_one_meaning() {
        let [b, a, other] =
            [("b", LineLook::Dashed), ("a", LineLook::Solid), ("b", LineLook::Solid)].map(|(l, k)| line(l, k));
        let agreed = entries([&b, &a, &b].into_iter()).expect("the labels agree");
        assert_eq!(agreed.iter().map(|entry| entry.line.label).collect::<Vec<_>>(), ["b", "a"]);
        let error = entries([&b, &other].into_iter()).expect_err("`b` means two looks");
        assert!(error.contains("`b`") && error.contains("one look"), "{error}");
    }

    #[test]
    fn entries_do_not_overlap_wherever_the_legend_stands() {
        let labels: Vec<String> = (0..24).map(|k| format!("line {k} {}", "with a long name ".repeat(k % 4))).collect();
        for (n, free, height, [is_beside, is_below]) in [
            (8, None, 600.0, [true, false]),
            (8, Some([500.0, 0.0, 800.0, 700.0]), 600.0, [false, false]),
            (24, None, 600.0, [true, true]),
            (24, None, 300.0, [false, true]),
        ] {
            let lines: Vec<CurveLine<'_>> = labels[..n].iter().map(|label| line(label, LineLook::Solid)).collect();
            let entries = entries(lines.iter()).expect("the labels differ");
            for block in entries.iter().map(block) {
                let baselines = block.drawing.svg.matches("<text").count() as f64;
                assert!(block.width <= WORDS + WIDEST && block.height >= 32.0 * baselines);
            }
            let block = Block { width: 800.0, height, drawing: Drawing::default() };
            let all = with_legend(Grid { block, first_frame: [90.0, 0.0], free }, &entries);
            assert_eq!([all.width > 800.0, all.height > height], [is_beside, is_below], "{n} {free:?} {height}");
        }
    }
}
