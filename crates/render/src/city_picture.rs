//! The picture of a city: a plan with axes beside a view from the side, in the same colors.

use glam::DVec3;

use super::check;
use super::city_solids::{CityHeights, CityModel, CityPrism, Solids};
use super::city_view;
use super::colors::Ramp;
use super::furniture::{self, DETAIL, NAME, Scale};
use super::lettering::{Anchor, Type};
use super::page::{MARGIN, Page};
use super::plot::{self, Axis, Direction, Span};
use super::sheet::{self, Drawing, Sheet};
use super::z_buffer::View;

/// Longer side of the plan \[px\]; `VIEW` is the box of the view.
const PLAN: f64 = 1000.0;
const VIEW: [usize; 2] = [1240, 1000];
/// Room for the numbers and the name of the plan's vertical axis.
const AXIS: f64 = 104.0;
const GUTTER: f64 = 56.0;

/// A city to draw.
#[derive(Clone, Copy, Debug)]
pub struct CityPicture<'a> {
    /// Title.
    pub title: &'a str,
    /// Lines below the panels; long ones are wrapped.
    pub caption: &'a [String],
    /// West, south, east and north border \[m\].
    pub extent_m: [f64; 4],
    /// The buildings.
    pub model: CityModel<'a>,
}

/// Draws a city: plan on the left, view from the south-south-west on the right, heights true to
/// scale.
///
/// # Errors
/// An empty extent, a raster of another shape, numbers that are not finite, or 16 million buildings
/// or more.
pub fn draw_city(picture: &CityPicture<'_>) -> Result<Sheet, String> {
    check(picture)?;
    let [west, south, east, north] = picture.extent_m;
    let solids = Solids::new(&picture.model, picture.extent_m);
    let (tallest_m, open_high) = solids.height_scale();
    let px_per_m = PLAN / (east - west).max(north - south);
    let plan_size = [(east - west) * px_per_m, (north - south) * px_per_m].map(|side| sheet::pixels(side.round()));
    let plan = city_view::draw_plan(&solids, plan_size.map(|side| side as usize), tallest_m);
    let view = city_view::draw_view(&solids, VIEW, tallest_m);

    let [plan_w, plan_h] = plan_size.map(f64::from);
    let [view_w, view_h] = [view.0.width(), view.0.height()].map(f64::from);
    let view_left = (MARGIN + AXIS + plan_w + GUTTER).round();
    let body_w = view_left + VIEW[0] as f64 - MARGIN;
    let mut page = Page::new(picture.title, body_w, 14.0);
    let heading = page.bottom;
    let top = (heading + 40.0).round();
    let (plan_left, view_right) = (MARGIN + AXIS, view_left + VIEW[0] as f64);

    let scale = Scale { low: 0.0, high: tallest_m, open_low: false, open_high };
    let color_bar = furniture::color_bar("Building height above ground [m]", scale, &Ramp::Height.steps(64), 470.0);
    let orientation = furniture::orientation(px_per_m, (0.25 * plan_w).clamp(160.0, 260.0));

    let drawing = &mut page.furniture;
    drawing.text(plan_left, heading + 22.0, NAME, "Plan");
    drawing.text(view_left, heading + 22.0, NAME, "View from the south-south-west, heights to scale");
    drawing.place(&plan_axes(picture.extent_m, [plan_w, plan_h]), plan_left, top);

    let room_below = color_bar.height.max(orientation.height) + 26.0;
    let plan_bottom = top + plan_h + 74.0;
    // The view is centered in the room above the legend, which ends level with the plan's axes.
    let body_h = (plan_bottom - top).max(view_h + room_below);
    let view_top = (top + ((body_h - room_below - view_h) / 2.0).max(0.0)).round();
    let view_x = (view_left + (VIEW[0] as f64 - view_w) / 2.0).round();
    drawing.place(&view_north(&view.1), view_right - 62.0, top + 46.0);
    let bottom = top + body_h;
    drawing.place(&color_bar.drawing, view_left - 20.0, bottom - color_bar.height);
    drawing.place(&orientation.drawing, view_right - orientation.width, bottom - orientation.height - 6.0);
    let of_plan = Type { anchor: Anchor::End, ..DETAIL };
    let middle = bottom - orientation.height / 2.0 + 2.0;
    drawing.text(view_right - orientation.width - 22.0, middle, of_plan, "scale of the plan");
    page.image([plan_left, top], plan);
    page.image([view_x, view_top], view.0);
    page.bottom = bottom;
    Ok(page.finish(22.0, picture.caption))
}

fn check(picture: &CityPicture<'_>) -> Result<(), String> {
    let [west, south, east, north] = picture.extent_m;
    let sides = [east - west, north - south];
    if !picture.extent_m.iter().all(|c| c.is_finite()) || sides.iter().any(|&side| side <= 0.0) {
        return Err(format!("cannot draw a city of {} × {} m: both sides must be above 0 m", sides[0], sides[1]));
    }
    if sides[0] > 50.0 * sides[1] || sides[1] > 50.0 * sides[0] {
        let [width, height] = sides;
        return Err(format!("cannot draw a city of {width} × {height} m: one side is over 50 times the other"));
    }
    match picture.model {
        CityModel::Prisms(prisms) if prisms.len() >= (1 << 24) - 2 => {
            Err(format!("cannot draw {} buildings: at most 16777213", prisms.len()))
        }
        CityModel::Prisms(prisms) => {
            let is_good = |p: &CityPrism| {
                let mut corners = p.wall_edges.iter().flatten().chain(p.roof_triangles.iter().flatten());
                p.base_m.is_finite() && p.top_m.is_finite() && corners.all(|c| c.iter().all(|m| m.is_finite()))
            };
            check::each(prisms, is_good, |_| "a building", "finite coordinates and heights")
        }
        CityModel::Heights(CityHeights { n_cols, n_rows, surface_m, ground_m }) => {
            check::shape("surface", surface_m.len(), [n_cols, n_rows])?;
            check::shape("ground", ground_m.len(), [n_cols, n_rows])
        }
    }
}

/// Draws frame, ticks and names of the plan's axes, with the origin at the plan's top left corner.
fn plan_axes([west, south, east, north]: [f64; 4], size: [f64; 2]) -> Drawing {
    let axis = |name: &str, low: f64, high: f64, direction: Direction, length: f64| {
        let ticks = furniture::ticks(low, high, (length / 170.0).clamp(2.0, 6.0));
        Axis { has_grid: false, ..Span::linear(low, high).axis_at(name, direction, length, ticks) }
    };
    let x = Axis { name_at: 66.0, ..axis("x, east [m]", west, east, Direction::Across, size[0]) };
    let y = Axis { name_at: 82.0, ..axis("y, north [m]", south, north, Direction::Up, size[1]) };
    let mut drawing = Drawing::default();
    furniture::frame(&mut drawing, [0.0; 2], size);
    drawing.add(&plot::axes(size, &x, &Axis::default()));
    drawing.add(&plot::axes(size, &Axis::default(), &y));
    drawing
}

/// Draws a north arrow lying on the ground of the view.
fn view_north(view: &View) -> Drawing {
    let [east, north] = [DVec3::X, DVec3::Y].map(|direction| view.direction(direction));
    let at = |x: f64, y: f64| (east * x * 46.0 + north * y * 46.0).to_array();
    let mut drawing = Drawing::default();
    furniture::north_halves(&mut drawing, at(0.0, 1.0), at(0.34, -0.7), at(-0.34, -0.7), at(0.0, -0.4));
    let tip = at(0.0, 1.0);
    drawing.text(tip[0], tip[1] - 9.0, Type { anchor: Anchor::Middle, size: 22.0, ..NAME }, "N");
    drawing
}
