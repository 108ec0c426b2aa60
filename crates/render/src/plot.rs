//! Parts of every plot: the mapping of values to pixels, ticks, and axes around a frame.

use super::colors::INK;
use super::furniture::{self, DETAIL};
use super::lettering::{Anchor, Type, number};
use super::sheet::Drawing;

/// Least gap between the texts of neighboring ticks \[px\].
const TEXT_GAP: f64 = 22.0;
/// Steps between ticks on an axis of angles \[°\].
const ANGLE_STEPS: [f64; 5] = [10.0, 15.0, 30.0, 45.0, 90.0];

/// An axis with its ticks, ready to be drawn; the default has neither ticks nor a name.
#[derive(Clone, Debug, Default)]
pub(crate) struct Axis {
    /// Name with unit.
    pub(crate) name: String,
    /// Ticks: distance from the left or from the top end \[px\], and text. A tick without text is
    /// short.
    pub(crate) ticks: Vec<(f64, String)>,
    /// True if a line crosses the plot at each tick with a text.
    pub(crate) has_grid: bool,
    /// Distance from the frame to the baseline of the name \[px\].
    pub(crate) name_at: f64,
}

impl Axis {
    /// Returns the width of the widest text at a tick \[px\].
    pub(crate) fn widest_text(&self) -> f64 {
        self.ticks.iter().map(|(_, text)| DETAIL.width(text)).fold(0.0, f64::max)
    }

    /// Returns the length by which texts reach beyond the right end of an axis of this length
    /// \[px\].
    pub(crate) fn text_beyond(&self, length: f64) -> f64 {
        self.ticks.iter().map(|(at, text)| at + DETAIL.width(text) / 2.0 - length).fold(0.0, f64::max).ceil()
    }
}

/// Direction of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Direction {
    /// From left to right.
    Across,
    /// From the bottom up.
    Up,
}

impl Direction {
    /// Returns the length that the text of a tick takes along the axis \[px\].
    fn room(self, text: &str) -> f64 {
        if self == Self::Across { DETAIL.width(text) } else { DETAIL.size }
    }
}

/// The values along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    /// Values at the left or lower end and at the opposite end, ascending.
    pub(crate) ends: [f64; 2],
    /// True if equal factors, not equal differences, have equal lengths. Both ends are then above
    /// 0.
    pub(crate) is_log: bool,
}

impl Span {
    /// Makes a span from `low` to `high`, equal differences of equal length.
    pub(crate) const fn linear(low: f64, high: f64) -> Self {
        Span { ends: [low, high], is_log: false }
    }

    /// Returns the position of a value: 0 at the first end, 1 at the second, beyond that outside.
    pub(crate) fn share(&self, value: f64) -> f64 {
        let [low, high] = self.ends;
        if self.is_log { (value / low).ln() / (high / low).ln() } else { (value - low) / (high - low) }
    }

    /// Returns the distance of a value from the left or from the top end of an axis of `length`
    /// \[px\].
    pub(crate) fn along(&self, value: f64, direction: Direction, length: f64) -> f64 {
        let share = self.share(value);
        length * if direction == Direction::Across { share } else { 1.0 - share }
    }

    /// Makes an axis of `length` \[px\] with round ticks whose texts keep apart.
    pub(crate) fn axis(&self, name: &str, direction: Direction, length: f64) -> Axis {
        let ticks = match (self.is_log, name.contains('°')) {
            (true, _) => self.log_ticks(direction, length),
            (false, true) => self.angle_ticks(direction, length),
            (false, false) => None,
        };
        let ticks = ticks.unwrap_or_else(|| self.round_ticks(direction, length));
        self.axis_at(name, direction, length, ticks)
    }

    /// Makes an axis of `length` \[px\] with ticks at these values.
    pub(crate) fn axis_at(&self, name: &str, direction: Direction, length: f64, ticks: Vec<(f64, String)>) -> Axis {
        let ticks = ticks.into_iter().map(|(value, text)| (self.along(value, direction, length), text)).collect();
        let axis = Axis { name: name.to_string(), ticks, has_grid: true, name_at: 68.0 };
        match direction {
            Direction::Across => axis,
            Direction::Up => Axis { name_at: 14.0 + axis.widest_text().ceil() + 24.0, ..axis },
        }
    }

    fn round_ticks(&self, direction: Direction, length: f64) -> Vec<(f64, String)> {
        let [low, high] = self.ends;
        let most = if direction == Direction::Across { 9 } else { 11 };
        let choices = (2..=most).rev().map(|n| furniture::ticks(low, high, f64::from(n)));
        let mut fitting = choices.filter(|ticks| self.keeps_apart(ticks, direction, length));
        fitting.next().unwrap_or_default()
    }

    /// Returns multiples of 10°, 15° and so on; `None` unless the axis ends at a multiple of 90°
    /// and spans at least 40°.
    fn angle_ticks(&self, direction: Direction, length: f64) -> Option<Vec<(f64, String)>> {
        let [low, high] = self.ends;
        let quarters = high / 90.0;
        if (quarters - quarters.round()).abs() > 1e-9 || high - low < 40.0 {
            return None;
        }
        ANGLE_STEPS.iter().map(|step| multiples(low, high, *step)).find(|t| self.keeps_apart(t, direction, length))
    }

    /// Returns ticks at all digits times powers of ten. Texts are at the digits 1, 2 and 5, at 1
    /// and 3, or at 1 only: the most that have room.
    fn log_ticks(&self, direction: Direction, length: f64) -> Option<Vec<(f64, String)>> {
        let [low, high] = self.ends;
        let exponents = whole(low.log10().floor())..=whole(high.log10().ceil());
        let inside = |value: f64| (-1e-9..=1.0 + 1e-9).contains(&self.share(value));
        for named in [&[1, 2, 5][..], &[1, 3], &[1]] {
            let digits = exponents.clone().flat_map(|e| (1..10).map(move |digit| (e, digit)));
            let ticks: Vec<(f64, String)> = digits
                .map(|(e, digit)| (f64::from(digit) * 10_f64.powi(e), e, digit))
                .filter(|(value, ..)| inside(*value))
                .map(|(value, e, digit)| {
                    (value, if named.contains(&digit) { power_text(e, digit) } else { String::new() })
                })
                .collect();
            let texts: Vec<(f64, String)> = ticks.iter().filter(|(_, text)| !text.is_empty()).cloned().collect();
            if texts.len() >= 2 && self.keeps_apart(&texts, direction, length) {
                return Some(ticks);
            }
        }
        None
    }

    /// Returns `true` when the texts of ticks in ascending order have room.
    pub(crate) fn keeps_apart(&self, ticks: &[(f64, String)], direction: Direction, length: f64) -> bool {
        ticks.windows(2).all(|pair| {
            let distance = (self.share(pair[1].0) - self.share(pair[0].0)) * length;
            distance >= (direction.room(&pair[0].1) + direction.room(&pair[1].1)) / 2.0 + TEXT_GAP
        })
    }
}

/// Returns the multiples of `step` from `low` to `high`.
fn multiples(low: f64, high: f64, step: f64) -> Vec<(f64, String)> {
    let first = (low / step - 1e-9).ceil();
    let values = (0..200).map(|k| (first + f64::from(k)) * step).take_while(|value| *value <= high + 1e-9 * step);
    values.map(|value| (value, number(value, 0))).collect()
}

/// Writes `digit` times ten to the `exponent`: plainly from 0.001 to 90 000, else with a power.
fn power_text(exponent: i32, digit: i32) -> String {
    const SUPERSCRIPTS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    if (-3..=4).contains(&exponent) {
        return number(f64::from(digit) * 10_f64.powi(exponent), 3);
    }
    let mut text = if digit == 1 { "10".to_string() } else { format!("{digit}\u{202F}·\u{202F}10") };
    for c in exponent.to_string().chars() {
        let raised = c.to_digit(10).and_then(|d| SUPERSCRIPTS.get(d as usize));
        text.push(raised.copied().unwrap_or('⁻'));
    }
    text
}

/// Converts a whole number of the size of an exponent.
#[expect(clippy::cast_possible_truncation, reason = "clamped to the exponents of f64 first")]
fn whole(value: f64) -> i32 {
    value.clamp(-400.0, 400.0) as i32
}

/// Tolerance within which a point outside the frame counts as on it \[px\].
pub(crate) const SLACK: f64 = 0.5;

/// Mapping of values to a plot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    /// Width and height \[px\].
    pub(crate) size: [f64; 2],
    /// Values from left to right.
    pub(crate) x: Span,
    /// Values from the bottom up.
    pub(crate) y: Span,
}

impl Window {
    /// Returns the place of a value from the top left of the frame \[px\].
    pub(crate) fn at(&self, x: f64, y: f64) -> [f64; 2] {
        [self.x.along(x, Direction::Across, self.size[0]), self.y.along(y, Direction::Up, self.size[1])]
    }

    /// Returns `true` when a place is in the frame.
    pub(crate) fn shows(&self, place: [f64; 2]) -> bool {
        place.iter().zip(self.size).all(|(at, length)| (-SLACK..=length + SLACK).contains(at))
    }
}

/// Draws a plot of this size \[px\], its origin at the top left of the frame: axes, content, and
/// the frame over both.
pub(crate) fn framed(size: [f64; 2], x: &Axis, y: &Axis, content: &Drawing) -> Drawing {
    let mut drawing = axes(size, x, y);
    drawing.add(content);
    furniture::frame(&mut drawing, [0.0; 2], size);
    drawing
}

/// Draws ticks, grid and names around a plot of this size \[px\].
pub(crate) fn axes([width, height]: [f64; 2], x: &Axis, y: &Axis) -> Drawing {
    let mut drawing = Drawing::default();
    let tick = furniture::ink(1.6);
    let grid = "stroke=\"#E3E7EB\" stroke-width=\"1.4\"";
    let middle = Type { anchor: Anchor::Middle, ..DETAIL };
    // A tick without a text is short, and has no line across the plot.
    let tick_length = |text: &str| if text.is_empty() { 5.0 } else { 8.0 };
    for (at, text) in &y.ticks {
        if y.has_grid && !text.is_empty() {
            drawing.line([0.0, *at], [width, *at], grid);
        }
        drawing.line([-tick_length(text), *at], [0.0, *at], &tick);
        drawing.text(-14.0, at + 8.0, Type { anchor: Anchor::End, ..DETAIL }, text);
    }
    for (at, text) in &x.ticks {
        if x.has_grid && !text.is_empty() {
            drawing.line([*at, 0.0], [*at, height], grid);
        }
        drawing.line([*at, height], [*at, height + tick_length(text)], &tick);
        drawing.text(*at, height + 32.0, middle, text);
    }
    let name = Type { color: INK, ..middle };
    drawing.text(width / 2.0, height + x.name_at, name, &x.name);
    drawing.text_upward(-y.name_at, height / 2.0, name, &y.name);
    drawing
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(span: Span, name: &str, direction: Direction, length: f64) -> Vec<String> {
        span.axis(name, direction, length).ticks.into_iter().map(|(_, text)| text).filter(|t| !t.is_empty()).collect()
    }

    #[test]
    fn angles_that_end_at_90_have_ticks_at_multiples_of_10_or_15() {
        let name = "Elevation angle θ [°]";
        let tens = ["10", "20", "30", "40", "50", "60", "70", "80", "90"];
        assert_eq!(texts(Span::linear(5.0, 90.0), name, Direction::Across, 760.0), tens);
        let wide = ["0", "15", "30", "45", "60", "75", "90"];
        assert_eq!(texts(Span::linear(0.0, 90.0), name, Direction::Across, 400.0), wide);
        assert_eq!(texts(Span::linear(0.0, 90.0), name, Direction::Across, 200.0), ["0", "30", "60", "90"]);
        assert_eq!(
            texts(Span::linear(0.0, 360.0), "φ [°]", Direction::Across, 420.0),
            ["0", "90", "180", "270", "360"]
        );
        // Elsewhere any round value will do.
        assert_eq!(texts(Span::linear(0.0, 1.0), "α", Direction::Up, 240.0), ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
    }

    #[test]
    fn texts_at_ticks_keep_apart_whatever_the_range_and_the_length() {
        let spans = [(0.0_f64, 1.0), (-3.0, 1e6), (0.001, 0.0017), (99_999.0, 100_001.0), (5.0, 90.0), (1.0, 1e12)];
        for (low, high) in spans {
            for (is_log, name) in [(false, "x"), (false, "x [°]"), (true, "x")] {
                for length in [150.0, 480.0, 760.0, 1400.0] {
                    for direction in [Direction::Across, Direction::Up] {
                        let span = Span { ends: [if is_log { low.max(1e-9) } else { low }, high], is_log };
                        let axis = span.axis(name, direction, length);
                        let named: Vec<_> = axis.ticks.iter().filter(|(_, text)| !text.is_empty()).collect();
                        assert!(named.iter().all(|(at, _)| (-0.1..=length + 0.1).contains(at)), "{named:?}");
                        for pair in named.windows(2) {
                            let room = (direction.room(&pair[0].1) + direction.room(&pair[1].1)) / 2.0;
                            assert!((pair[1].0 - pair[0].0).abs() > room, "{span:?} {length} {pair:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn logarithmic_axes_have_a_tick_at_every_digit() {
        let span = Span { ends: [10.0, 1000.0], is_log: true };
        let axis = span.axis("Height [m]", Direction::Across, 600.0);
        assert_eq!(axis.ticks.len(), 19);
        assert!((axis.ticks[9].0 - 300.0).abs() < 1e-6 && axis.ticks[9].1 == "100");
        assert_eq!(texts(span, "", Direction::Across, 600.0), ["10", "20", "50", "100", "200", "500", "1000"]);
        assert_eq!(power_text(6, 1), "10⁶");
        assert_eq!(power_text(-5, 2), "2\u{202F}·\u{202F}10⁻⁵");
        assert_eq!(power_text(-2, 5), "0.05");
    }
}
