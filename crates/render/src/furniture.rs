//! Furniture of a map: legend entries, color bars, the scale bar, the north arrow, and their
//! arrangement.
//!
//! Each piece is a [`Block`], a drawing with a size. [`flow`] and [`stack`] put blocks into rows or
//! a column, so that nothing overlaps, however long the words are.

use super::colors::{self, HAIRLINE, INK, MUTED, Rgb, fill};
use super::lettering::{self, Anchor, Type, Weight};
use super::sheet::Drawing;

/// Height of a legend entry \[px\].
pub(crate) const ENTRY_HEIGHT: f64 = 58.0;

/// Text style of titles.
pub(crate) const TITLE: Type = Type { size: 42.0, weight: Weight::SemiBold, color: INK, anchor: Anchor::Start };
/// Text style of names in a legend.
pub(crate) const NAME: Type = Type { size: 25.0, weight: Weight::SemiBold, color: INK, anchor: Anchor::Start };
/// Text style of details in a legend, numbers at ticks, and captions.
pub(crate) const DETAIL: Type = Type { size: 23.0, weight: Weight::Regular, color: MUTED, anchor: Anchor::Start };

/// A drawing of known size \[px\], its origin at the top left.
#[derive(Clone, Debug, Default)]
pub(crate) struct Block {
    pub(crate) width: f64,
    pub(crate) height: f64,
    pub(crate) drawing: Drawing,
}

/// Sample of color in a legend entry.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Swatch {
    /// One color.
    Flat(Rgb),
    /// Gradient from one color to another.
    Range(Rgb, Rgb),
    /// Stripes, for cells without data.
    Hatched,
    /// The symbol of a UAV.
    Uav,
    /// The symbol of an observer.
    Observer,
}

/// Widest name \[px\]; longer ones are shortened.
const WIDEST_NAME: f64 = 460.0;

/// Makes a legend entry: a swatch, a name, and a line of detail.
pub(crate) fn legend_entry(swatch: Swatch, name: &str, detail: &str) -> Block {
    const SIDE: f64 = 50.0;
    let mut drawing = Drawing::default();
    let place = [1.0, 4.0, SIDE, SIDE];
    let outline = format!("rx=\"3\" fill=\"none\" stroke=\"{INK}\" stroke-opacity=\"0.45\" stroke-width=\"1\"");
    match swatch {
        Swatch::Flat(color) => drawing.rect(place, &format!("rx=\"3\" {}", fill(color))),
        Swatch::Range(a, b) => {
            let steps: Vec<Rgb> = (0..25).map(|k| colors::mix(a, b, f64::from(k) / 24.0)).collect();
            drawing.gradient(place, &steps);
        }
        Swatch::Hatched => {
            drawing.rect(place, "rx=\"3\" fill=\"#FFFFFF\"");
            let mut stripes = Drawing::default();
            hatch(&mut stripes, [0.0, 0.0, SIDE, SIDE]);
            drawing.place(&stripes, 1.0, 4.0);
        }
        Swatch::Uav => uav_symbol(&mut drawing, [1.0 + SIDE / 2.0, 4.0 + SIDE / 2.0], 23.0),
        Swatch::Observer => observer_symbol(&mut drawing, [1.0 + SIDE / 2.0, 4.0 + SIDE / 2.0], 23.0),
    }
    if !matches!(swatch, Swatch::Uav | Swatch::Observer) {
        drawing.rect(place, &outline);
    }
    let left = SIDE + 15.0;
    let name = &NAME.shortened(name, WIDEST_NAME);
    drawing.text(left, if detail.is_empty() { 38.0 } else { 25.0 }, NAME, name);
    drawing.text(left, 52.0, DETAIL, detail);
    Block { width: left + NAME.width(name).max(DETAIL.width(detail)), height: ENTRY_HEIGHT, drawing }
}

/// Draws a quadcopter from above with a white halo, `radius` \[px\] around `center`.
pub(crate) fn uav_symbol(drawing: &mut Drawing, [x, y]: [f64; 2], radius: f64) {
    let (arm, rotor, body) = (0.60 * radius, 0.36 * radius, 0.27 * radius);
    let corners = [[-arm, -arm], [arm, -arm], [arm, arm], [-arm, arm]].map(|[dx, dy]| [x + dx, y + dy]);
    for (color, grow) in [("#FFFFFF", 0.17 * radius), ("#101418", 0.0)] {
        let width = 0.17 * radius + 2.0 * grow;
        let stroke = format!("stroke=\"{color}\" stroke-width=\"{width:.2}\" stroke-linecap=\"round\"");
        drawing.line(corners[0], corners[2], &stroke);
        drawing.line(corners[1], corners[3], &stroke);
        for corner in corners {
            drawing.circle(corner, rotor + grow, &format!("fill=\"{color}\""));
        }
        drawing.circle([x, y], body + grow, &format!("fill=\"{color}\""));
    }
    for corner in corners {
        drawing.circle(corner, 0.52 * rotor, "fill=\"#FFFFFF\"");
    }
}

/// Draws an observer with a white halo, `radius` \[px\] around `center`.
pub(crate) fn observer_symbol(drawing: &mut Drawing, [x, y]: [f64; 2], radius: f64) {
    let (head, shoulders) = (0.32 * radius, 0.55 * radius);
    let (neck, feet) = (y - 0.05 * radius, y + 0.85 * radius);
    for (color, grow) in [("#FFFFFF", 0.17 * radius), ("#101418", 0.0)] {
        let fill = format!("fill=\"{color}\" stroke=\"{color}\" stroke-width=\"{:.2}\"", 2.0 * grow);
        drawing.circle([x, y - 0.45 * radius], head + grow, &format!("fill=\"{color}\""));
        let body = [[-0.55, 0.0], [0.55, 0.0], [1.0, 1.0], [-1.0, 1.0]];
        drawing.polygon(&body.map(|[dx, t]| [x + dx * shoulders, neck + t * (feet - neck)]), &fill);
    }
}

/// Makes a north arrow; north is up.
fn north_arrow() -> Block {
    let mut drawing = Drawing::default();
    drawing.text(19.0, 19.0, Type { anchor: Anchor::Middle, size: 23.0, ..NAME }, "N");
    north_halves(&mut drawing, [19.0, 26.0], [33.0, 74.0], [5.0, 74.0], [19.0, 63.0]);
    Block { width: 38.0, height: 76.0, drawing }
}

/// Draws the dark right half and the light left half of a north arrow; `notch` is between their
/// feet.
pub(crate) fn north_halves(drawing: &mut Drawing, tip: [f64; 2], right: [f64; 2], left: [f64; 2], notch: [f64; 2]) {
    drawing.polygon(&[tip, right, notch], &format!("fill=\"{INK}\""));
    drawing.polygon(&[tip, left, notch], &format!("fill=\"#FFFFFF\" {}", stroke(INK, 1.6, "")));
}

/// Returns the length nearest to `wanted` among 1, 2 and 5 times powers of ten, or 1 if `wanted` is
/// not within 1e-300 to 1e300.
fn round_length(wanted: f64) -> f64 {
    if !(1e-300..=1e300).contains(&wanted) {
        return 1.0;
    }
    let mut power = 1.0;
    while power * 10.0 <= wanted {
        power *= 10.0;
    }
    while power > wanted {
        power /= 10.0;
    }
    let nearness = |length: &f64| (length / wanted).max(wanted / length);
    let choices = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    choices.into_iter().min_by(|a, b| nearness(a).total_cmp(&nearness(b))).unwrap_or(wanted)
}

/// Makes a scale bar of a round length of about `wanted_px`, with the half marked.
fn scale_bar(px_per_m: f64, wanted_px: f64) -> Block {
    const BAR: f64 = 12.0;
    let meters = round_length(wanted_px / px_per_m);
    let width = meters * px_per_m;
    let (unit, per_unit) = if meters >= 1000.0 { ("km", 1000.0) } else { ("m", 1.0) };
    let label = |m: f64| lettering::number(m / per_unit, 9);
    let last = format!("{} {unit}", label(meters));
    let style = Type { anchor: Anchor::Middle, color: INK, ..DETAIL };
    let pad = (style.width(&last) / 2.0).ceil();
    let mut drawing = Drawing::default();
    let top = 32.0;
    let frame = ink(1.6);
    drawing.rect([pad, top, width / 2.0, BAR], &format!("fill=\"{INK}\" {frame}"));
    drawing.rect([pad + width / 2.0, top, width / 2.0, BAR], &format!("fill=\"#FFFFFF\" {frame}"));
    drawing.text(pad, 22.0, style, "0");
    let half = label(meters / 2.0);
    let room = width / 2.0 - style.width(&half) / 2.0;
    if room > pad + 14.0 {
        drawing.text(pad + width / 2.0, 22.0, style, &half);
    }
    drawing.text(pad + width, 22.0, style, &last);
    Block { width: width + 2.0 * pad, height: top + BAR + 2.0, drawing }
}

/// Makes a scale bar of about `wanted_px` with a north arrow beside it.
pub(crate) fn orientation(px_per_m: f64, wanted_px: f64) -> Block {
    beside(&[scale_bar(px_per_m, wanted_px), north_arrow()], 26.0)
}

/// Places blocks beside each other, centered on a line, with `gap` between them.
pub(crate) fn beside(blocks: &[Block], gap: f64) -> Block {
    let height = blocks.iter().map(|b| b.height).fold(0.0, f64::max);
    let mut drawing = Drawing::default();
    let mut x = 0.0;
    for (i, block) in blocks.iter().enumerate() {
        x += if i > 0 { gap } else { 0.0 };
        drawing.place(&block.drawing, x, (height - block.height) / 2.0);
        x += block.width;
    }
    Block { width: x, height, drawing }
}

/// Places blocks in as few rows as possible, no wider than `max_width` and aligned in columns.
pub(crate) fn flow(blocks: &[Block], max_width: f64, gap: [f64; 2]) -> Block {
    let widths = |per_row: usize| -> Vec<f64> {
        let column = |col: usize| blocks.iter().skip(col).step_by(per_row).map(|b| b.width).fold(0.0, f64::max);
        (0..per_row).map(column).collect()
    };
    let total = |widths: &[f64]| widths.iter().map(|w| w + gap[0]).sum::<f64>() - gap[0];
    // Rows of even length look calmer than full rows and a rest.
    let even = (1..=blocks.len()).map(|n_rows| blocks.len().div_ceil(n_rows));
    let per_row = even.into_iter().find(|&per_row| total(&widths(per_row)) <= max_width).unwrap_or(1);
    let widths = widths(per_row);
    let rows: Vec<Block> = blocks
        .chunks(per_row)
        .map(|row| {
            let mut drawing = Drawing::default();
            let mut x = 0.0;
            for (block, width) in row.iter().zip(&widths) {
                drawing.place(&block.drawing, x, 0.0);
                x += width + gap[0];
            }
            Block { width: x - gap[0], height: row.iter().map(|b| b.height).fold(0.0, f64::max), drawing }
        })
        .collect();
    stack(&rows, gap[1])
}

/// Places blocks below each other, aligned at the left.
pub(crate) fn stack(blocks: &[Block], gap: f64) -> Block {
    let mut drawing = Drawing::default();
    let (mut y, mut width) = (0.0, 0.0_f64);
    for (i, block) in blocks.iter().enumerate() {
        y += if i > 0 { gap } else { 0.0 };
        drawing.place(&block.drawing, 0.0, y);
        y += block.height;
        width = width.max(block.width);
    }
    Block { width, height: y, drawing }
}

/// Most lines of a paragraph, roughly; longer text is shortened.
const MOST_LINES: f64 = 60.0;

/// Sets wrapped lines of text as a block.
pub(crate) fn paragraph(text: &str, style: Type, max_width: f64) -> Block {
    let lines = style.wrap(&style.shortened(text, MOST_LINES * max_width), max_width);
    let leading = (style.size * 1.3).round();
    let mut drawing = Drawing::default();
    let mut width = 0.0_f64;
    for (i, line) in lines.iter().enumerate() {
        drawing.text(0.0, (style.size * 0.95).round() + leading * i as f64, style, line);
        width = width.max(style.width(line));
    }
    Block { width, height: leading * lines.len() as f64, drawing }
}

/// Sets caption lines below each other, the first in ink, further ones muted. The backticks of
/// messages are left out.
pub(crate) fn caption(lines: &[String], max_width: f64) -> Block {
    let style = |i: usize| Type { color: if i == 0 { INK } else { MUTED }, ..DETAIL };
    let lines = lines.iter().map(|line| line.replace('`', "")).enumerate();
    let lines: Vec<Block> = lines.map(|(i, line)| paragraph(&line, style(i), max_width)).collect();
    stack(&lines, 5.0)
}

/// Continuous scale, open at an end if values lie beyond it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scale {
    /// Value at the left end.
    pub(crate) low: f64,
    /// Value at the right end.
    pub(crate) high: f64,
    /// True if some values lie below: the bar ends in a point there.
    pub(crate) open_low: bool,
    /// True if some values lie above.
    pub(crate) open_high: bool,
}

/// Length of the point of an open color bar \[px\].
const POINT: f64 = 20.0;

/// Returns the distance from the left of a color bar's block to the bar \[px\]: room for a point
/// and for half the text of a tick.
pub(crate) fn color_bar_inset(scale: Scale) -> f64 {
    let ticks = ticks(scale.low, scale.high, 5.0);
    let pad = ticks.iter().map(|(_, text)| DETAIL.width(text) / 2.0);
    pad.fold(POINT + 2.0, f64::max).ceil().min(60.0)
}

/// Makes a color bar of `width` \[px\] under its name, with round ticks; the name includes the
/// unit.
pub(crate) fn color_bar(name: &str, scale: Scale, colors_along: &[Rgb], width: f64) -> Block {
    const BAR: f64 = 26.0;
    let tick_style = Type { anchor: Anchor::Middle, ..DETAIL };
    let left = color_bar_inset(scale);
    let ticks = ticks(scale.low, scale.high, 5.0);
    let (top, right) = (38.0, left + width);
    let mut drawing = Drawing::default();
    drawing.text(left - if scale.open_low { POINT } else { 0.0 }, 24.0, NAME, name);
    drawing.gradient([left, top, width, BAR], colors_along);
    let (first, last) = (colors_along[0], colors_along[colors_along.len() - 1]);
    // The right end from the top down, then the left end from the bottom up.
    let mut outline = Vec::new();
    let ends =
        [(right, 1.0, [top, top + BAR], scale.open_high, last), (left, -1.0, [top + BAR, top], scale.open_low, first)];
    for (x, outward, [from, to], is_open, color) in ends {
        let tip = [x + outward * POINT, top + BAR / 2.0];
        if is_open {
            drawing.polygon(&[[x - 0.5 * outward, from], tip, [x - 0.5 * outward, to]], &fill(color));
        }
        outline.push([x, from]);
        outline.extend(is_open.then_some(tip));
        outline.push([x, to]);
    }
    // From the top left on.
    outline.rotate_right(1);
    drawing.polygon(&outline, &format!("fill=\"none\" {}", stroke(INK, 1.4, "")));
    for (value, text) in ticks {
        let x = left + width * (value - scale.low) / (scale.high - scale.low);
        drawing.line([x, top + BAR], [x, top + BAR + 7.0], &ink(1.6));
        drawing.text(x, top + BAR + 30.0, tick_style, &text);
    }
    let name_width = left + NAME.width(name);
    Block { width: (right + left).max(name_width), height: top + BAR + 36.0, drawing }
}

/// Returns about `wanted` (at least 2) round values between `low` and `high` (`low` < `high`) with
/// their texts.
pub(crate) fn ticks(low: f64, high: f64, wanted: f64) -> Vec<(f64, String)> {
    let step = round_length((high - low) / wanted.max(2.0));
    let mut decimals = 0;
    let mut digit = step;
    while decimals < 12 && (digit - digit.round()).abs() > 1e-6 * digit {
        digit *= 10.0;
        decimals += 1;
    }
    let slack = 1e-9 * (high - low);
    let first = ((low - slack) / step).ceil();
    (0..100)
        .map(|k| (first + f64::from(k)) * step)
        .take_while(|&value| value <= high + slack)
        .map(|value| (value, lettering::number(value, decimals)))
        .collect()
}

/// Draws the thin frame around a map or a plot of this size \[px\].
pub(crate) fn frame(drawing: &mut Drawing, [left, top]: [f64; 2], [width, height]: [f64; 2]) {
    let around = [left - 0.8, top - 0.8, width + 1.6, height + 1.6];
    drawing.rect(around, &format!("fill=\"none\" {}", ink(1.6)));
}

/// Returns the SVG attributes of a line of a width \[px\], with dashes and gaps unless `dash` is
/// empty.
pub(crate) fn stroke(color: &str, width: f64, dash: &str) -> String {
    let dash = if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") };
    format!("stroke=\"{color}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"{dash}")
}

/// Returns the SVG attributes of a line in ink with corners that are not rounded.
pub(crate) fn ink(width: f64) -> String {
    format!("stroke=\"{INK}\" stroke-width=\"{width}\"")
}

/// Returns the SVG attributes of a hairline.
pub(crate) fn hairline() -> String {
    format!("stroke=\"{HAIRLINE}\" stroke-width=\"1.2\"")
}

/// Draws stripes over a box without data, on the same lines in all boxes.
pub(crate) fn hatch(drawing: &mut Drawing, [left, top, width, height]: [f64; 4]) {
    const STEP: f64 = 14.0;
    let ink = format!("stroke=\"{}\" stroke-width=\"2.2\"", colors::hex(colors::HATCH));
    let (right, bottom) = (left + width, top + height);
    // Stripes are where x + y is a multiple of the step.
    let first = ((left + top) / STEP).ceil();
    let sums = (0..).map(|k| (first + f64::from(k)) * STEP).take_while(|sum| *sum < right + bottom);
    for sum in sums {
        let (lower, upper) = ((sum - bottom).max(left), (sum - top).min(right));
        drawing.line([lower, sum - lower], [upper, sum - upper], &ink);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_bars_have_round_lengths_and_the_right_unit() {
        for (wanted, length) in
            [(290.0, 200.0), (400.0, 500.0), (0.7, 0.5), (3.0, 2.0), (7200.0, 10_000.0), (10.0, 10.0)]
        {
            assert!((round_length(wanted) - length).abs() < 1e-9, "{wanted}: {}", round_length(wanted));
        }
        assert!(scale_bar(1.0, 295.0).drawing.svg.contains(">200 m<"));
        assert!(scale_bar(0.1, 205.0).drawing.svg.contains(">2 km<"));
        assert!(scale_bar(320.0, 160.0).drawing.svg.contains(">0.5 m<"));
        assert!((scale_bar(1.0, 295.0).width - 200.0) < 100.0);
    }

    #[test]
    fn ticks_are_round_and_inside() {
        let texts = |low, high| ticks(low, high, 5.0).into_iter().map(|(_, text)| text).collect::<Vec<_>>();
        assert_eq!(texts(0.0, 100.0), ["0", "20", "40", "60", "80", "100"]);
        assert_eq!(texts(-30.0, 30.0), ["−30", "−20", "−10", "0", "10", "20", "30"]);
        assert_eq!(texts(0.0, 1.0), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
    }

    #[test]
    fn blocks_in_a_flow_do_not_overlap_and_fit() {
        let entries: Vec<Block> =
            (0..5).map(|k| legend_entry(Swatch::Flat(colors::LOS), &format!("class {k}"), "12.3 %")).collect();
        let flowed = flow(&entries, 420.0, [40.0, 14.0]);
        assert!(flowed.width <= 420.0);
        assert!(flowed.height >= 2.0 * ENTRY_HEIGHT + 14.0);
        let column = stack(&entries, 10.0);
        assert!((column.height - (5.0 * ENTRY_HEIGHT + 40.0)).abs() < 1e-9);
    }
}
