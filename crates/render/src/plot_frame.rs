//! What every plot has: axes with ticks around a frame.

use super::colors::INK;
use super::furniture::{self, DETAIL};
use super::lettering::{Anchor, Type};
use super::plot_axis::Axis;
use super::sheet::Drawing;

/// Draws ticks, grid and names around a plot of this size \[px\], its origin at the top left of the frame.
pub(crate) fn axes([width, height]: [f64; 2], x: &Axis, y: &Axis) -> Drawing {
    let mut drawing = Drawing::default();
    let tick = format!("stroke=\"{INK}\" stroke-width=\"1.6\"");
    let grid = "stroke=\"#E3E7EB\" stroke-width=\"1.4\"";
    let middle = Type { anchor: Anchor::Middle, ..DETAIL };
    for (at, text) in &y.ticks {
        if y.has_grid && !text.is_empty() {
            drawing.line([0.0, *at], [width, *at], grid);
        }
        drawing.line([if text.is_empty() { -5.0 } else { -8.0 }, *at], [0.0, *at], &tick);
        if !text.is_empty() {
            drawing.text(-14.0, at + 8.0, Type { anchor: Anchor::End, ..DETAIL }, text);
        }
    }
    for (at, text) in &x.ticks {
        if x.has_grid && !text.is_empty() {
            drawing.line([*at, 0.0], [*at, height], grid);
        }
        drawing.line([*at, height], [*at, height + if text.is_empty() { 5.0 } else { 8.0 }], &tick);
        if !text.is_empty() {
            drawing.text(*at, height + 32.0, middle, text);
        }
    }
    let name = Type { color: INK, ..middle };
    if !x.name.is_empty() {
        drawing.text(width / 2.0, height + x.name_at, name, &x.name);
    }
    if !y.name.is_empty() {
        drawing.text_upward(-y.name_at, height / 2.0, name, &y.name);
    }
    drawing
}

/// Draws the frame of a plot of this size \[px\].
pub(crate) fn frame(drawing: &mut Drawing, [width, height]: [f64; 2]) {
    drawing.rect([-0.8, -0.8, width + 1.6, height + 1.6], &furniture::frame());
}
