//! The picture of a city: a plan with axes beside a view from the side, in the same colors.

use glam::DVec3;

use super::check;
use super::city_solids::{CityModel, CityPrism, Solids};
use super::city_view;
use super::colors::{INK, Ramp};
use super::furniture::{self, DETAIL, NAME, Scale};
use super::lettering::{Anchor, Type};
use super::page::{MARGIN, Page};
use super::sheet::{self, Drawing, Sheet};
use super::z_buffer::View;

/// The longer side of the plan \[px\], and the box for the view.
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

/// Draws a city: plan on the left, view from the south-south-west on the right, heights true to scale.
///
/// # Errors
/// An empty extent, a raster of another shape, numbers that are not finite, or 16 million buildings or more.
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
    // The view is centered on what its neighbors leave, and the legend ends where the plan does.
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
        return Err(format!(
            "cannot draw a city of {} × {} m: one side is over 50 times the other",
            sides[0], sides[1]
        ));
    }
    match picture.model {
        CityModel::Prisms(prisms) => {
            if prisms.len() >= (1 << 24) - 2 {
                return Err(format!("cannot draw {} buildings: at most 16777213", prisms.len()));
            }
            let bad = |p: &CityPrism| {
                let corners = p.rings.iter().flatten().chain(p.roof_triangles.iter().flatten());
                !(p.base_m.is_finite() && p.top_m.is_finite() && corners.flatten().all(|c| c.is_finite()))
            };
            if let Some(i) = prisms.iter().position(bad) {
                return Err(format!("cannot draw building {i}: a coordinate or height is not finite"));
            }
        }
        CityModel::Heights(heights) => {
            let n_cells = [heights.n_cols, heights.n_rows];
            check::shape("surface", heights.surface_m.len(), n_cells)?;
            check::shape("ground", heights.ground_m.len(), n_cells)?;
        }
    }
    Ok(())
}

/// Frame, ticks and names of the plan's axes, the origin at the plan's top left corner.
fn plan_axes([west, south, east, north]: [f64; 4], [w, h]: [f64; 2]) -> Drawing {
    let mut drawing = Drawing::default();
    drawing.rect([-0.8, -0.8, w + 1.6, h + 1.6], &furniture::frame());
    let tick = format!("stroke=\"{INK}\" stroke-width=\"1.6\"");
    let number = Type { anchor: Anchor::Middle, ..DETAIL };
    let wanted = |px: f64| (px / 170.0).clamp(2.0, 6.0);
    for (value, text) in furniture::ticks(west, east, wanted(w)) {
        let x = w * (value - west) / (east - west);
        drawing.line([x, h], [x, h + 8.0], &tick);
        drawing.text(x, h + 32.0, number, &text);
    }
    for (value, text) in furniture::ticks(south, north, wanted(h)) {
        let y = h * (north - value) / (north - south);
        drawing.line([-8.0, y], [0.0, y], &tick);
        drawing.text(-14.0, y + 8.0, Type { anchor: Anchor::End, ..DETAIL }, &text);
    }
    drawing.text(w / 2.0, h + 66.0, Type { color: INK, ..number }, "x, east [m]");
    drawing.text_upward(-82.0, h / 2.0, Type { color: INK, ..number }, "y, north [m]");
    drawing
}

/// A north arrow lying on the ground of the view.
fn view_north(view: &View) -> Drawing {
    let [east, north] = [DVec3::X, DVec3::Y].map(|direction| view.direction(direction));
    let at = |x: f64, y: f64| (east * x * 46.0 + north * y * 46.0).to_array();
    let mut drawing = Drawing::default();
    drawing.polygon(&[at(0.0, 1.0), at(0.34, -0.7), at(0.0, -0.4)], &format!("fill=\"{INK}\""));
    let light = format!("fill=\"#FFFFFF\" stroke=\"{INK}\" stroke-width=\"1.6\" stroke-linejoin=\"round\"");
    drawing.polygon(&[at(0.0, 1.0), at(-0.34, -0.7), at(0.0, -0.4)], &light);
    let tip = at(0.0, 1.0);
    drawing.text(tip[0], tip[1] - 9.0, Type { anchor: Anchor::Middle, size: 22.0, ..NAME }, "N");
    drawing
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::city_solids::{CityHeights, block};

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let whole = [block(0.0, 0.0, 9.0, 9.0)];
        let bent = [block(0.0, 0.0, 9.0, f64::NAN)];
        let raster = CityHeights { n_cols: 2, n_rows: 2, surface_m: &[0.0; 3], ground_m: &[0.0; 4] };
        for (extent_m, model, words) in [
            ([0.0, 0.0, 0.0, 10.0], CityModel::Prisms(&whole), "above 0 m"),
            ([0.0, 0.0, 10.0, 501.0], CityModel::Prisms(&whole), "over 50 times"),
            ([0.0, 0.0, 10.0, 10.0], CityModel::Prisms(&bent), "building 0"),
            ([0.0, 0.0, 10.0, 10.0], CityModel::Heights(raster), "surface has 3"),
        ] {
            let drawn = draw_city(&CityPicture { title: "", caption: &[], extent_m, model });
            assert!(drawn.is_err_and(|e| e.contains(words)), "{words}");
        }
    }
}
