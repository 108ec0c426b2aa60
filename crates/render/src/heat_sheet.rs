//! P_LoS against two quantities as a field of colored cells, in one plot or in small multiples with one color bar.

use super::check;
use super::colors::{self, Ramp};
use super::contours::{Field, cut_middle};
use super::furniture::{self, DETAIL, Scale, Swatch};
use super::lettering::{Anchor, Type, Weight, number};
use super::page::page;
use super::panel_grid::{self, Panel};
use super::plot_axis::{Axis, Direction, Span};
use super::sheet::{Drawing, Sheet};

/// Most values along an axis: more have no pixel each.
const MOST_VALUES: usize = 400;
/// Length of the color bar \[px\].
const BAR: f64 = 400.0;
/// Iso-lines of P_LoS.
const LEVELS: [f64; 3] = [0.1, 0.5, 0.9];
/// The level in an iso-line.
const LEVEL: Type = Type { size: 20.0, weight: Weight::SemiBold, anchor: Anchor::Middle, ..DETAIL };

/// Plots of P_LoS against two quantities with one color bar.
#[derive(Clone, Copy, Debug)]
pub struct HeatSheet<'a> {
    /// Title; may be empty.
    pub title: &'a str,
    /// Lines below; long ones are wrapped.
    pub caption: &'a [String],
    /// One to twelve plots, row by row.
    pub panels: &'a [HeatPanel<'a>],
    /// Plots beside each other.
    pub columns: usize,
}

/// One plot.
#[derive(Clone, Copy, Debug)]
pub struct HeatPanel<'a> {
    /// What stands over it, such as `(a) Street`; may be empty.
    pub title: &'a str,
    /// Horizontal axis.
    pub x: HeatAxis<'a>,
    /// Vertical axis.
    pub y: HeatAxis<'a>,
    /// P_LoS, 0 to 1, `[n_y, n_x]`, the horizontal quantity running fastest; nothing is drawn as no value.
    pub values: &'a [Option<f64>],
}

/// An axis of a heat map.
#[derive(Clone, Copy, Debug)]
pub struct HeatAxis<'a> {
    /// Name with unit, such as `Azimuth φ [°]`.
    pub name: &'a str,
    /// One to 400 ascending values, to the right or upward. Cells have them in their middle and meet midway.
    pub values: &'a [f64],
}

/// Width and height of the frames \[px\].
fn frame_size(columns: usize) -> [f64; 2] {
    match columns {
        1 => [680.0, 520.0],
        2 => [540.0, 440.0],
        _ => [460.0, 380.0],
    }
}

/// Draws heat maps.
///
/// # Errors
/// No panel or more than twelve, no column, an axis without values, with too many, or with values that are not finite
/// or do not ascend, an array of another length, or a P_LoS outside 0 to 1.
pub fn draw_heat_sheet(sheet: &HeatSheet<'_>) -> Result<Sheet, String> {
    panel_grid::check(sheet.panels.len(), sheet.columns)?;
    sheet.panels.iter().try_for_each(check)?;
    let size = frame_size(sheet.columns.min(sheet.panels.len()));
    let plots: Vec<Plot<'_>> = sheet.panels.iter().map(|panel| Plot::new(panel, size)).collect();
    let panels = plots.iter().map(|plot| {
        let mut content = plot.cells();
        LEVELS.iter().for_each(|level| plot.iso_line(&mut content, *level));
        Panel { title: plot.panel.title, x: plot.x.axis(), y: plot.y.axis(), content }
    });
    let mut grid = panel_grid::grid(panels.collect(), sheet.columns, size);
    let steps: Vec<_> = (0..128).map(|k| Ramp::Sequential.at(f64::from(k) / 127.0)).collect();
    let scale = Scale { low: 0.0, high: 1.0, open_low: false, open_high: false };
    let mut keys = vec![furniture::color_bar("P_LoS", scale, &steps, BAR)];
    if sheet.panels.iter().any(|panel| panel.values.iter().any(Option::is_none)) {
        keys.push(furniture::legend_entry(Swatch::Hatched, "No value", ""));
    }
    if !grid.place_in_corner(&furniture::stack(&keys, 30.0)) {
        let left = grid.first_frame[0] - furniture::color_bar_inset(scale);
        grid.place_below(&furniture::beside(&keys, 36.0), left);
    }
    Ok(page(sheet.title, &grid.block, sheet.caption, [22.0, 22.0]))
}

fn check(panel: &HeatPanel<'_>) -> Result<(), String> {
    for HeatAxis { name, values } in [panel.x, panel.y] {
        let n = values.len();
        if !(1..=MOST_VALUES).contains(&n) {
            return Err(format!("cannot draw `{name}` with {n} values: there must be 1 to {MOST_VALUES}"));
        }
        if !values.iter().all(|v| v.is_finite()) || !values.windows(2).all(|pair| pair[0] < pair[1]) {
            return Err(format!("cannot draw `{name}`: its values must be finite and ascend"));
        }
    }
    check::shape("P_LoS", panel.values.len(), [panel.x.values.len(), panel.y.values.len()])?;
    match panel.values.iter().flatten().find(|p| !(0.0..=1.0).contains(*p)) {
        Some(p) => Err(format!("cannot draw a P_LoS of {p}: it must be 0 to 1")),
        None => Ok(()),
    }
}

/// Where the cells along one axis lie.
#[derive(Clone, Debug)]
struct Cells<'a> {
    name: &'a str,
    values: &'a [f64],
    direction: Direction,
    span: Span,
    length: f64,
    /// Distances of the borders from the left or from the top \[px\], one more than values.
    borders: Vec<f64>,
}

impl<'a> Cells<'a> {
    fn new(axis: &HeatAxis<'a>, direction: Direction, length: f64) -> Self {
        let HeatAxis { name, values } = *axis;
        let n = values.len();
        let midway = values.windows(2).map(|pair| pair[0] + (pair[1] - pair[0]) / 2.0);
        // The outer cells are as wide beyond their middle as before it; a single one has any width.
        let (first, last) = match n {
            1 => (0.5, 0.5),
            _ => ((values[1] - values[0]) / 2.0, (values[n - 1] - values[n - 2]) / 2.0),
        };
        let (low, high) = (values[0] - first, values[n - 1] + last);
        let span = Span { ends: [low, high], is_log: false };
        let borders = std::iter::once(low).chain(midway).chain([high]);
        let mut cells = Self { name, values, direction, span, length, borders: Vec::new() };
        cells.borders = borders.map(|value| cells.at(value)).collect();
        cells
    }

    /// Distance of a value from the left or from the top \[px\].
    fn at(&self, value: f64) -> f64 {
        let share = self.span.share(value);
        self.length * if self.direction == Direction::Across { share } else { 1.0 - share }
    }

    /// Start and length of a cell from the left or from the top \[px\].
    fn cell(&self, k: usize) -> [f64; 2] {
        let (a, b) = (self.borders[k], self.borders[k + 1]);
        [a.min(b), (b - a).abs()]
    }

    /// The axis, with a tick at each cell if all texts have room there, else with round ones.
    fn axis(&self) -> Axis {
        let ticks = self.own_ticks().filter(|ticks| self.span.keeps_apart(ticks, self.direction, self.length));
        let axis = match ticks {
            Some(ticks) => self.span.axis_at(self.name, self.direction, self.length, ticks),
            None => self.span.axis(self.name, self.direction, self.length),
        };
        Axis { has_grid: false, ..axis }
    }

    /// A tick at each value, if few decimals are enough to write them all.
    fn own_ticks(&self) -> Option<Vec<(f64, String)>> {
        const MOST_DECIMALS: i32 = 4;
        let [low, high] = self.span.ends;
        let is_enough = |decimals: &i32| {
            let power = 10_f64.powi(*decimals);
            self.values.iter().all(|v| ((v * power).round() / power - v).abs() < 1e-9 * (high - low))
        };
        let decimals = usize::try_from((0..=MOST_DECIMALS).find(is_enough)?).ok()?;
        Some(self.values.iter().map(|value| (*value, number(*value, decimals))).collect())
    }
}

/// A panel with its cells in place.
#[derive(Debug)]
struct Plot<'a> {
    panel: &'a HeatPanel<'a>,
    x: Cells<'a>,
    y: Cells<'a>,
}

impl<'a> Plot<'a> {
    fn new(panel: &'a HeatPanel<'a>, [width, height]: [f64; 2]) -> Self {
        let x = Cells::new(&panel.x, Direction::Across, width);
        Self { panel, x, y: Cells::new(&panel.y, Direction::Up, height) }
    }

    /// The cells with their values: left, top, width, height.
    fn boxes(&self) -> impl Iterator<Item = ([f64; 4], Option<f64>)> {
        let (n_x, n_y) = (self.panel.x.values.len(), self.panel.y.values.len());
        // From the top, so that each cell can reach under the next ones.
        (0..n_y).rev().flat_map(move |row| (0..n_x).map(move |col| (row, col))).map(move |(row, col)| {
            let ([left, width], [top, height]) = (self.x.cell(col), self.y.cell(row));
            ([left, top, width, height], self.panel.values[row * n_x + col])
        })
    }

    fn cells(&self) -> Drawing {
        let mut drawing = Drawing::default();
        let [right, bottom] = [self.x.length, self.y.length];
        let ink = format!("stroke=\"{}\" stroke-width=\"2.2\"", colors::hex(colors::HATCH));
        for ([left, top, width, height], value) in self.boxes() {
            // Under the next cells by a pixel: no seams at any magnification.
            let (reach_x, reach_y) = ((right - left).min(width + 1.0), (bottom - top).min(height + 1.0));
            let fill = colors::hex(value.map_or(colors::WHITE, |p| Ramp::Sequential.at(p)));
            drawing.rect([left, top, reach_x, reach_y], &format!("fill=\"{fill}\""));
        }
        for ([left, top, width, height], _) in self.boxes().filter(|(_, value)| value.is_none()) {
            hatch(&mut drawing, [left, top, width, height], &ink);
        }
        drawing
    }

    /// Draws the lines of a level, with the level in the longer ones.
    fn iso_line(&self, drawing: &mut Drawing, level: f64) {
        let [x, y] = [&self.x, &self.y].map(|c| c.values.iter().map(|v| c.at(*v)).collect::<Vec<f64>>());
        let color = colors::ink_on(Ramp::Sequential.at(level));
        let look = format!("stroke=\"{color}\" stroke-width=\"2.4\" stroke-linejoin=\"round\"");
        let kind = Type { color, ..LEVEL };
        let text = number(level, 3);
        let gap = kind.width(&text) + 12.0;
        let has_room = |[x, y]: &[f64; 2]| {
            let within = |at: f64, half: f64, length: f64| at > half && at < length - half;
            within(*x, gap / 2.0, self.x.length) && within(*y, kind.size, self.y.length)
        };
        for line in (Field { x: &x, y: &y, values: self.panel.values }).lines(level) {
            match cut_middle(&line, gap).filter(|(_, middle)| has_room(middle)) {
                Some((pieces, [x, y])) => {
                    for piece in pieces.iter().filter(|piece| piece.len() > 1) {
                        drawing.polyline(piece, &look);
                    }
                    drawing.text(x, y + 0.36 * kind.size, kind, &text);
                }
                None => drawing.polyline(&line, &look),
            }
        }
    }
}

/// Draws stripes in a box, on the same lines in all boxes.
fn hatch(drawing: &mut Drawing, [left, top, width, height]: [f64; 4], ink: &str) {
    const STEP: f64 = 14.0;
    let (right, bottom) = (left + width, top + height);
    // Stripes are where x + y is a multiple of the step.
    let first = ((left + top) / STEP).ceil();
    let sums = (0..).map(|k| (first + f64::from(k)) * STEP).take_while(|sum| *sum < right + bottom);
    for sum in sums {
        let (lower, upper) = ((sum - bottom).max(left), (sum - top).min(right));
        drawing.line([lower, sum - lower], [upper, sum - upper], ink);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: HeatAxis<'static> = HeatAxis { name: "Azimuth φ [°]", values: &[0.0, 45.0, 90.0] };
    const Y: HeatAxis<'static> = HeatAxis { name: "Elevation angle θ [°]", values: &[10.0, 20.0] };
    const VALUES: [Option<f64>; 6] = [Some(0.0), Some(0.25), None, Some(0.5), Some(0.75), Some(1.0)];
    const PANEL: HeatPanel<'static> = HeatPanel { title: "(a) Street", x: X, y: Y, values: &VALUES };

    fn svg(panels: &[HeatPanel<'_>]) -> Result<String, String> {
        let sheet = HeatSheet { title: "P_LoS < 1 & more", caption: &[], panels, columns: 3 };
        draw_heat_sheet(&sheet).map(|sheet| sheet.furniture.svg)
    }

    #[test]
    fn cells_of_uneven_values_meet_midway_and_the_lowest_is_at_the_bottom() {
        let axis = HeatAxis { name: "Height [m]", values: &[0.0, 10.0, 40.0] };
        // From −5 to 55 over 600 px.
        let cells = Cells::new(&axis, Direction::Across, 600.0);
        for (border, expected) in cells.borders.iter().zip([0.0, 100.0, 300.0, 600.0]) {
            assert!((border - expected).abs() < 1e-9, "{:?}", cells.borders);
        }
        let up = Cells::new(&axis, Direction::Up, 600.0);
        assert!((up.cell(2)[0] - 0.0).abs() < 1e-9 && (up.cell(2)[1] - 300.0).abs() < 1e-9);
        let one = Cells::new(&HeatAxis { values: &[7.0], ..axis }, Direction::Up, 600.0);
        assert_eq!(one.axis().ticks, [(300.0, "7".to_string())]);
        // What four decimals cannot write has round ticks.
        let thirds = Cells::new(&HeatAxis { values: &[0.0, 1.0 / 3.0, 2.0 / 3.0], ..axis }, Direction::Across, 600.0);
        assert!(thirds.axis().ticks.iter().any(|(_, text)| text == "0.2"));
    }

    #[test]
    fn cells_have_the_color_of_their_value_and_iso_lines_their_level() {
        let svg = svg(&[PANEL]).expect("the sheet is valid");
        for words in [">0.5<", ">No value<", "φ [°]", "θ [°]", ">(a) Street<", ">45<", "&lt; 1 &amp; more"] {
            assert!(svg.contains(words), "{words}: {svg}");
        }
        for p in VALUES.iter().flatten() {
            assert!(svg.contains(&colors::hex(Ramp::Sequential.at(*p))), "{p}");
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        for (panel, words) in [
            (HeatPanel { values: &VALUES[..5], ..PANEL }, "5 values"),
            (HeatPanel { values: &[Some(1.5); 6], ..PANEL }, "1.5"),
            (HeatPanel { values: &[Some(f64::NAN); 6], ..PANEL }, "NaN"),
            (HeatPanel { x: HeatAxis { values: &[0.0, 0.0, 1.0], ..X }, ..PANEL }, "ascend"),
            (HeatPanel { x: HeatAxis { values: &[], ..X }, values: &[], ..PANEL }, "0 values"),
        ] {
            assert!(svg(&[panel]).is_err_and(|e| e.contains(words)), "{words}");
        }
    }
}
