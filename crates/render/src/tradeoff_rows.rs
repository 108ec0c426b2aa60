//! Signed bias of each contestant in a row of its own. The rows are also the legend of marks and
//! numbers.

use super::colors::{INK, MUTED};
use super::furniture::{self, Block, DETAIL, stroke};
use super::lettering::{Anchor, Type, Weight, number};
use super::line_look::{LineLook, LineStyle};
use super::plot::{self, Axis, Direction, Span};
use super::sheet::Drawing;

/// Width of the plot of biases \[px\].
const WIDTH: f64 = 430.0;
/// Greatest height of a row \[px\].
const ROW: f64 = 40.0;
/// Room for the numbers at the right \[px\].
const NUMBERS: f64 = 124.0;

/// A contestant.
#[derive(Clone, Copy, Debug)]
pub struct TradeoffPoint<'a> {
    /// Name, in its row.
    pub label: &'a str,
    /// Name of its family.
    pub family: &'a str,
    /// Index of color and shape of its mark, as in [`CurveLine`](super::CurveLine).
    pub look: usize,
    /// Cost, above 0, and error, at least 0; a contestant without them is only in the rows.
    pub place: Option<(f64, f64)>,
    /// Signed bias; `None` if there is none.
    pub bias: Option<f64>,
}

/// Returns the mark of a contestant.
pub(crate) fn mark(look: usize) -> LineStyle {
    LineStyle::new(LineLook::Solid, look)
}

/// A row: the heading of a family, or a contestant.
#[derive(Clone, Copy, Debug)]
enum Row<'a> {
    Family(&'a str),
    /// Contestant, with its number.
    Point(usize, &'a TradeoffPoint<'a>),
}

/// Draws the rows within `height` \[px\].
pub(crate) fn rows(points: &[TradeoffPoint<'_>], bias_name: &str, height: f64) -> Block {
    let mut rows: Vec<Row<'_>> = Vec::new();
    let mut family = "";
    for (k, point) in points.iter().enumerate() {
        if point.family != family {
            family = point.family;
            rows.push(Row::Family(family));
        }
        rows.push(Row::Point(k + 1, point));
    }
    let step = (height / rows.len().max(1) as f64).min(ROW);
    let size = DETAIL.size.min(0.72 * step);
    let words = Type { size, color: INK, ..DETAIL };
    let heading = Type { color: MUTED, ..words };
    let width_of = |row: &Row<'_>| match row {
        Row::Family(name) => heading.width(name),
        Row::Point(_, point) => 84.0 + words.width(point.label),
    };
    let left = (rows.iter().map(width_of).fold(0.0, f64::max) + 22.0).ceil();
    let reach = points.iter().filter_map(|p| p.bias).map(f64::abs).fold(0.0, f64::max).max(1e-3) * 1.12;
    let span = Span::linear(-reach, reach);
    let frame = [WIDTH, step * rows.len() as f64];
    let x = span.axis(bias_name, Direction::Across, WIDTH);
    let mut content = Drawing::default();
    let zero = WIDTH / 2.0;
    content.line([zero, 0.0], [zero, frame[1]], &furniture::ink(1.6));
    for (k, row) in rows.iter().enumerate() {
        let middle = step * (k as f64 + 0.5);
        let baseline = middle + 0.36 * size;
        match row {
            Row::Family(name) => {
                content.text(-left, baseline, heading, name);
                content.line([-left, middle + step / 2.0], [0.0, middle + step / 2.0], &furniture::hairline());
            }
            Row::Point(number, point) => {
                let style = mark(point.look);
                let number_type = Type { anchor: Anchor::End, ..words };
                let of_mark = Type { color: style.color, weight: Weight::SemiBold, ..number_type };
                content.text(-left + 34.0, baseline, of_mark, &number.to_string());
                style.draw_marker(&mut content, [-left + 56.0, middle]);
                content.text(-left + 76.0, baseline, words, point.label);
                let right = WIDTH + NUMBERS - 4.0;
                let Some(bias) = point.bias else {
                    content.text(right, baseline, Type { color: MUTED, ..number_type }, "no answer");
                    continue;
                };
                let at = [WIDTH * span.share(bias), middle];
                content.line([zero, middle], at, &stroke(style.color, 5.0, ""));
                style.draw_marker(&mut content, at);
                content.text(right, baseline, number_type, &signed(bias));
            }
        }
    }
    let framed = plot::framed(frame, &x, &Axis::default(), &content);
    let mut drawing = Drawing::default();
    drawing.place(&framed, left, 0.0);
    Block { width: left + WIDTH + NUMBERS, height: frame[1] + x.name_at + 8.0, drawing }
}

/// Writes a number with its sign and as many decimals as its size needs; 0 has no sign.
fn signed(value: f64) -> String {
    let decimals = match value.abs() {
        v if v >= 10.0 => 1,
        v if v >= 0.1 => 2,
        v if v >= 0.01 => 3,
        _ => 4,
    };
    let text = number(value, decimals);
    match text.as_str() {
        "0" if value > 0.0 => "> 0".to_string(),
        "0" if value < 0.0 => "< 0".to_string(),
        _ if value > 0.0 => format!("+{text}"),
        _ => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_tell_their_sign_and_never_round_a_bias_to_none() {
        let texts = [2.345, -0.0871, 0.0, 1e-7, -1e-7, -12.34].map(signed);
        assert_eq!(texts, ["+2.35", "−0.087", "0", "> 0", "< 0", "−12.3"]);
    }
}
