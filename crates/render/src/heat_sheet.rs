//! P_LoS against two quantities as a field of colored cells, in one plot or in small multiples with
//! one color bar.

use super::check;
use super::colors::{self, Ramp};
use super::contours::{Field, cut_middle};
use super::furniture::{self, DETAIL, Scale, Swatch, stroke};
use super::lettering::{Anchor, Type, Weight, number};
use super::page::page;
use super::panel_grid::{self, Panel};
use super::plot::{Axis, Direction, Span};
use super::sheet::{Drawing, Sheet};

/// Most values along an axis; more would have less than a pixel each on small plots.
const MOST_VALUES: usize = 400;
/// Length of the color bar \[px\].
const BAR: f64 = 400.0;
/// Levels of the iso-lines of P_LoS.
const LEVELS: [f64; 3] = [0.1, 0.5, 0.9];
/// Text style of the level in an iso-line.
const LEVEL: Type = Type { size: 20.0, weight: Weight::SemiBold, anchor: Anchor::Middle, ..DETAIL };

/// Plots of P_LoS against two quantities with one color bar.
#[derive(Clone, Copy, Debug)]
pub struct HeatSheet<'a> {
    /// Title; may be empty.
    pub title: &'a str,
    /// Lines below; long ones are wrapped.
    pub caption: &'a [String],
    /// Plots, one to twelve, row by row.
    pub panels: &'a [HeatPanel<'a>],
    /// Number of plots in a row.
    pub columns: usize,
}

/// One plot.
#[derive(Clone, Copy, Debug)]
pub struct HeatPanel<'a> {
    /// Heading, such as `(a) Street`; may be empty.
    pub title: &'a str,
    /// Horizontal axis.
    pub x: HeatAxis<'a>,
    /// Vertical axis.
    pub y: HeatAxis<'a>,
    /// P_LoS, 0 to 1, `[n_y, n_x]`, the horizontal quantity running fastest. `None` is drawn as no
    /// value.
    pub values: &'a [Option<f64>],
}

/// An axis of a heat map.
#[derive(Clone, Copy, Debug)]
pub struct HeatAxis<'a> {
    /// Name with unit, such as `Azimuth φ [°]`.
    pub name: &'a str,
    /// Ascending values, 1 to 400, to the right or upward. A cell has its value in the middle, and
    /// neighbors meet midway.
    pub values: &'a [f64],
}

/// Returns width and height of the frames \[px\].
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
/// * No panel or more than twelve, or no column.
/// * An axis without values, with more than 400, or with values that are not finite or do not
///   ascend.
/// * An array of another length, or a P_LoS outside 0 to 1.
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
    let scale = Scale { low: 0.0, high: 1.0, open_low: false, open_high: false };
    let mut keys = vec![furniture::color_bar("P_LoS", scale, &Ramp::Sequential.steps(128), BAR)];
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
    let is_good = |HeatAxis { values, .. }: &HeatAxis<'_>| {
        let ascend = values.iter().all(|v| v.is_finite()) && values.is_sorted_by(|a, b| a < b);
        ascend && (1..=MOST_VALUES).contains(&values.len())
    };
    check::each(&[panel.x, panel.y], is_good, |axis| axis.name, "1 to 400 finite values that ascend")?;
    check::shape("P_LoS", panel.values.len(), [panel.x.values.len(), panel.y.values.len()])?;
    match panel.values.iter().flatten().find(|p| !(0.0..=1.0).contains(*p)) {
        Some(p) => Err(format!("cannot draw a P_LoS of {p}: it must be 0 to 1")),
        None => Ok(()),
    }
}

/// Cells along one axis.
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
        // The outer cells are as wide beyond their middle as before it; a single cell has width 1.
        let (first, last) = match n {
            1 => (0.5, 0.5),
            _ => ((values[1] - values[0]) / 2.0, (values[n - 1] - values[n - 2]) / 2.0),
        };
        let (low, high) = (values[0] - first, values[n - 1] + last);
        let span = Span::linear(low, high);
        let borders = std::iter::once(low).chain(midway).chain([high]);
        let borders = borders.map(|value| span.along(value, direction, length)).collect();
        Self { name, values, direction, span, length, borders }
    }

    /// Returns the distances of the values from the left or from the top \[px\].
    fn middles(&self) -> Vec<f64> {
        self.values.iter().map(|value| self.span.along(*value, self.direction, self.length)).collect()
    }

    /// Returns start and length of a cell from the left or from the top \[px\].
    fn cell(&self, k: usize) -> [f64; 2] {
        let (a, b) = (self.borders[k], self.borders[k + 1]);
        [a.min(b), (b - a).abs()]
    }

    /// Makes the axis, with a tick at each cell if all texts have room there, else with round ones.
    fn axis(&self) -> Axis {
        let ticks = self.own_ticks().filter(|ticks| self.span.keeps_apart(ticks, self.direction, self.length));
        let axis = match ticks {
            Some(ticks) => self.span.axis_at(self.name, self.direction, self.length, ticks),
            None => self.span.axis(self.name, self.direction, self.length),
        };
        Axis { has_grid: false, ..axis }
    }

    /// Returns a tick at each value; `None` if four decimals cannot write them all.
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

    /// Returns left, top, width and height of each cell, with its value.
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
        for ([left, top, width, height], value) in self.boxes() {
            // Under the next cells by a pixel: no seams at any magnification.
            let (reach_x, reach_y) = ((right - left).min(width + 1.0), (bottom - top).min(height + 1.0));
            let color = value.map_or(colors::WHITE, |p| Ramp::Sequential.at(p));
            drawing.rect([left, top, reach_x, reach_y], &colors::fill(color));
        }
        let empty = self.boxes().filter(|(_, value)| value.is_none());
        empty.for_each(|(bounds, _)| furniture::hatch(&mut drawing, bounds));
        drawing
    }

    /// Draws the lines of a level, with the level in the longer ones.
    fn iso_line(&self, drawing: &mut Drawing, level: f64) {
        let [x, y] = [&self.x, &self.y].map(Cells::middles);
        let color = colors::ink_on(Ramp::Sequential.at(level));
        let look = stroke(color, 2.4, "");
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

#[cfg(test)]
mod tests {
    use super::*;

    const X: HeatAxis<'static> = HeatAxis { name: "Azimuth φ [°]", values: &[0.0, 45.0, 90.0] };
    const Y: HeatAxis<'static> = HeatAxis { name: "Elevation angle θ [°]", values: &[10.0, 20.0] };
    const VALUES: [Option<f64>; 6] = [Some(0.0), Some(0.25), None, Some(0.5), Some(0.75), Some(1.0)];
    const PANEL: HeatPanel<'static> = HeatPanel { title: "(a) Street", x: X, y: Y, values: &VALUES };

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
    fn what_cannot_be_drawn_is_refused() {
        for panel in [
            HeatPanel { values: &VALUES[..5], ..PANEL },
            HeatPanel { values: &[Some(1.5); 6], ..PANEL },
            HeatPanel { values: &[Some(f64::NAN); 6], ..PANEL },
            HeatPanel { x: HeatAxis { values: &[0.0, 0.0, 1.0], ..X }, ..PANEL },
            HeatPanel { x: HeatAxis { values: &[], ..X }, values: &[], ..PANEL },
        ] {
            assert!(check(&panel).is_err(), "{panel:?}");
        }
        assert_eq!(check(&PANEL), Ok(()));
    }
}
