//! The picture of a city: a plan with axes beside a view from the side, in the same colors.

use glam::DVec2;

use super::city_solids::Solids;
use super::city_view::{self, CityImage};
use super::colors::{INK, Ramp, Rgb};
use super::furniture::{self, DETAIL, NAME, Scale, TITLE};
use super::marks::Label;
use super::picture_form::PictureForm;
use super::sheet::{self, Anchor, Drawing, Sheet, Type};

const MARGIN: f64 = 40.0;
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
    /// UAVs to mark; may be empty.
    pub uavs: &'a [CityUav<'a>],
}

/// How a city is given.
#[derive(Clone, Copy, Debug)]
pub enum CityModel<'a> {
    /// Footprints with flat tops.
    Prisms(&'a [CityPrism]),
    /// A raster over the whole extent, each cell a column.
    Heights(CityHeights<'a>),
}

/// A building: footprint, ground and roof.
#[derive(Clone, Debug)]
pub struct CityPrism {
    /// Outer ring and holes, without the first point repeated at the end \[m\].
    pub rings: Vec<Vec<[f64; 2]>>,
    /// The footprint cut into triangles \[m\].
    pub roof_triangles: Vec<[[f64; 2]; 3]>,
    /// Height of the ground \[m\].
    pub base_m: f64,
    /// Height of the roof \[m\].
    pub top_m: f64,
}

/// A city as a raster, `[n_rows, n_cols]`, columns running fastest, north row first. A cell is a building if its
/// surface is more than 0.25 m above its ground. Rasters of more than 800 cells a side are thinned for the picture.
#[derive(Clone, Copy, Debug)]
pub struct CityHeights<'a> {
    /// Columns.
    pub n_cols: usize,
    /// Rows.
    pub n_rows: usize,
    /// Surface heights \[m\]; not finite where unknown.
    pub surface_m: &'a [f32],
    /// Ground heights \[m\]; without them the ground is at 0 m.
    pub ground_m: Option<&'a [f32]>,
}

/// A UAV in a city picture.
#[derive(Clone, Copy, Debug)]
pub struct CityUav<'a> {
    /// Its id.
    pub label: &'a str,
    /// Its height in words, such as `100 m`; may be empty.
    pub height: &'a str,
    /// East, north and height in the coordinates of the buildings \[m\].
    pub at_m: [f64; 3],
}

/// Draws a city: plan on the left, view from the south-south-west on the right, heights true to scale.
///
/// # Errors
/// An empty extent, a raster of another shape, numbers that are not finite, 16 million buildings or more, or a keyword
/// of `provenance` that PNG does not allow.
pub fn draw_city(
    picture: &CityPicture<'_>,
    form: &PictureForm,
    provenance: &[(String, String)],
) -> Result<Vec<u8>, String> {
    compose(picture)?.write(form, provenance)
}

fn compose(picture: &CityPicture<'_>) -> Result<Sheet, String> {
    check(picture)?;
    let [west, south, east, north] = picture.extent_m;
    let solids = Solids::new(&picture.model, picture.extent_m);
    let (tallest_m, open_high) = solids.height_scale();
    let px_per_m = PLAN / (east - west).max(north - south);
    let plan_size = [(east - west) * px_per_m, (north - south) * px_per_m].map(|side| sheet::pixels(side.round()));
    let plan = city_view::draw_plan(&solids, plan_size.map(|side| side as usize), tallest_m);
    let view = city_view::draw_view(&solids, VIEW, tallest_m);

    let [plan_w, plan_h] = plan_size.map(f64::from);
    let (view_w, view_h) = (f64::from(view.image.width()), f64::from(view.image.height()));
    let view_left = (MARGIN + AXIS + plan_w + GUTTER).round();
    let body_w = view_left + VIEW[0] as f64 - MARGIN;
    let title = furniture::paragraph(picture.title, TITLE, body_w);
    let caption = furniture::caption(picture.caption, body_w);
    let title_h = if title.height > 0.0 { title.height + 14.0 } else { 0.0 };
    let heading = MARGIN + title_h;
    let top = (heading + 40.0).round();
    let plan_left = MARGIN + AXIS;

    let along: Vec<Rgb> = (0..64).map(|k| Ramp::Height.at(f64::from(k) / 63.0)).collect();
    let scale = Scale { low: 0.0, high: tallest_m, open_low: false, open_high };
    let color_bar = furniture::color_bar("Building height above ground [m]", scale, &along, 470.0);
    let scale_bar = furniture::scale_bar(px_per_m, (0.25 * plan_w).clamp(160.0, 260.0));
    let orientation = furniture::beside(&[scale_bar, furniture::north_arrow()], 26.0);

    let mut drawing = Drawing::default();
    drawing.place(&title.drawing, MARGIN, MARGIN - 6.0);
    drawing.text(plan_left, heading + 22.0, NAME, "Plan");
    drawing.text(view_left, heading + 22.0, NAME, "View from the south-south-west, heights to scale");
    drawing.place(&plan_axes(picture.extent_m, [plan_w, plan_h]), plan_left, top);
    drawing.place(&plan_marks(picture, &plan, [plan_w, plan_h]), plan_left, top);

    let room_below = color_bar.height.max(orientation.height) + 26.0;
    let plan_bottom = top + plan_h + 74.0;
    // The view is centered on what its neighbors leave, and the legend ends where the plan does.
    let body_h = (plan_bottom - top).max(view_h + room_below);
    let view_top = (top + ((body_h - room_below - view_h) / 2.0).max(0.0)).round();
    let view_x = (view_left + (VIEW[0] as f64 - view_w) / 2.0).round();
    drawing.place(&view_marks(picture, &plan, &view), view_x, view_top);
    drawing.place(&view_north(&view), view_left + VIEW[0] as f64 - 62.0, top + 46.0);
    let legend_y = top + body_h - color_bar.height;
    drawing.place(&color_bar.drawing, view_left - 20.0, legend_y);
    drawing.place(
        &orientation.drawing,
        view_left + VIEW[0] as f64 - orientation.width,
        top + body_h - orientation.height - 6.0,
    );
    let of_plan = Type { anchor: Anchor::End, ..DETAIL };
    drawing.text(
        view_left + VIEW[0] as f64 - orientation.width - 22.0,
        top + body_h - orientation.height / 2.0 + 2.0,
        of_plan,
        "scale of the plan",
    );
    let mut bottom = top + body_h;
    if caption.height > 0.0 {
        bottom += 22.0;
        drawing.line([MARGIN, bottom], [MARGIN + body_w, bottom], &furniture::hairline());
        drawing.place(&caption.drawing, MARGIN, bottom + 14.0);
        bottom += 14.0 + caption.height;
    }
    let whole = sheet::pixels;
    Ok(Sheet {
        width: body_w + 2.0 * MARGIN,
        height: bottom + MARGIN - 8.0,
        images: vec![(whole(plan_left), whole(top), plan.image), (whole(view_x), whole(view_top), view.image)],
        furniture: drawing,
    })
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
            super::check_shape("surface", heights.surface_m.len(), heights.n_cols, heights.n_rows)?;
            if let Some(ground) = heights.ground_m {
                super::check_shape("ground", ground.len(), heights.n_cols, heights.n_rows)?;
            }
        }
    }
    match picture.uavs.iter().find(|uav| uav.at_m.iter().any(|c| !c.is_finite())) {
        Some(uav) => Err(format!("cannot draw UAV `{}`: its position is not finite", uav.label)),
        None => Ok(()),
    }
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

fn label_of(uav: &CityUav<'_>, size: f64) -> Label {
    Label::new(&[uav.label.to_string(), uav.height.to_string()], size)
}

fn plan_marks(picture: &CityPicture<'_>, plan: &CityImage, size: [f64; 2]) -> Drawing {
    let marks: Vec<super::marks::Mark<'_>> = picture
        .uavs
        .iter()
        .map(|uav| {
            let [col, row] = plan.place(uav.at_m);
            super::marks::Mark { label: uav.label, height: uav.height, col, row }
        })
        .collect();
    let m_per_px = (picture.extent_m[2] - picture.extent_m[0]) / size[0];
    super::marks::draw_marks(&marks, size, [1.0, 1.0], (m_per_px, m_per_px))
}

/// UAVs in the view, each with a line down to what is below it; hidden parts of the line are faint.
fn view_marks(picture: &CityPicture<'_>, plan: &CityImage, view: &CityImage) -> Drawing {
    const STEPS: u32 = 96;
    let mut drawing = Drawing::default();
    let mut taken: Vec<[f64; 4]> = Vec::new();
    for uav in picture.uavs {
        let [x, y, z] = uav.at_m;
        let Some(foot) = plan.surface_below([x, y]) else {
            continue;
        };
        let point = |k: u32| [x, y, foot + (z - foot) * f64::from(k) / f64::from(STEPS)];
        for k in 0..STEPS {
            let (from, to) = (view.place(point(k)), view.place(point(k + 1)));
            if view.is_visible(point(k + 1)) {
                drawing.line(from, to, "stroke=\"#FFFFFF\" stroke-opacity=\"0.85\" stroke-width=\"6\"");
            }
        }
        for k in 0..STEPS {
            let (from, to) = (view.place(point(k)), view.place(point(k + 1)));
            let opacity = if view.is_visible(point(k + 1)) { "1" } else { "0.3" };
            drawing.line(from, to, &format!("stroke=\"#101418\" stroke-opacity=\"{opacity}\" stroke-width=\"2.6\""));
        }
        if view.is_visible([x, y, foot + 0.5]) {
            let [fx, fy] = view.place([x, y, foot]);
            let ring = "fill=\"none\" stroke=\"#101418\" stroke-width=\"2.4\"";
            let _ = std::fmt::Write::write_fmt(
                &mut drawing.svg,
                format_args!("<ellipse cx=\"{}\" cy=\"{}\" rx=\"9\" ry=\"5\" {ring}/>\n", sheet::px(fx), sheet::px(fy)),
            );
        }
        let [ux, uy] = view.place(uav.at_m);
        furniture::uav_symbol(&mut drawing, [ux, uy], 22.0);
        let label = label_of(uav, 24.0);
        let spots = [[ux + 30.0, uy - label.height / 2.0], [ux - 30.0 - label.width, uy - label.height / 2.0]];
        let free = |[x, y]: [f64; 2]| {
            let bounds = [x, y, x + label.width, y + label.height];
            x >= 0.0
                && bounds[2] <= f64::from(view.image.width())
                && !taken.iter().any(|t| bounds[0] < t[2] && t[0] < bounds[2] && bounds[1] < t[3] && t[1] < bounds[3])
        };
        let spot = spots.into_iter().find(|&spot| free(spot));
        taken.push([ux - 24.0, uy - 24.0, ux + 24.0, uy + 24.0]);
        if let Some([x, y]) = spot {
            taken.push([x, y, x + label.width, y + label.height]);
            label.draw(&mut drawing, x, y);
        }
    }
    drawing
}

/// A north arrow lying on the ground of the view.
fn view_north(view: &CityImage) -> Drawing {
    let north = DVec2::from(view.direction([0.0, 1.0]));
    let east = DVec2::from(view.direction([1.0, 0.0]));
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

    fn grid_city(n: u32) -> Vec<CityPrism> {
        (0..n * n)
            .map(|k| {
                let (x, y) = (10.0 + 40.0 * f64::from(k % n), 10.0 + 40.0 * f64::from(k / n));
                let ring = vec![[x, y], [x + 25.0, y], [x + 25.0, y + 25.0], [x, y + 25.0]];
                let roof_triangles = vec![[ring[0], ring[1], ring[2]], [ring[0], ring[2], ring[3]]];
                CityPrism { rings: vec![ring], roof_triangles, base_m: 0.0, top_m: 10.0 + f64::from(k % 7) }
            })
            .collect()
    }

    #[test]
    fn a_city_picture_has_two_panels_and_says_what_they_are() {
        let prisms = grid_city(4);
        let uavs = [CityUav { label: "UAV 1", height: "60 m", at_m: [80.0, 80.0, 60.0] }];
        let picture = CityPicture {
            title: "A small city",
            caption: &["Sixteen blocks".to_string()],
            extent_m: [0.0, 0.0, 160.0, 160.0],
            model: CityModel::Prisms(&prisms),
            uavs: &uavs,
        };
        let sheet = compose(&picture).expect("the city is valid");
        assert_eq!(sheet.images.len(), 2);
        assert_eq!(sheet.images[0].2.dimensions(), (1000, 1000));
        for words in
            ["Building height above ground [m]", "x, east [m]", "y, north [m]", "UAV 1", "heights to scale", "50 m"]
        {
            assert!(sheet.furniture.svg.contains(words), "{words}");
        }
        let file = draw_city(&picture, &PictureForm::PNG, &[]).expect("the city is valid");
        assert_eq!(file, draw_city(&picture, &PictureForm::PNG, &[]).expect("the city is valid"));
    }

    #[test]
    fn impossible_cities_are_refused() {
        let prisms = grid_city(1);
        let picture = CityPicture {
            title: "",
            caption: &[],
            extent_m: [0.0, 0.0, 0.0, 10.0],
            model: CityModel::Prisms(&prisms),
            uavs: &[],
        };
        assert!(draw_city(&picture, &PictureForm::PNG, &[]).is_err());
        let raster = CityHeights { n_cols: 2, n_rows: 2, surface_m: &[0.0; 3], ground_m: None };
        let picture = CityPicture { extent_m: [0.0, 0.0, 2.0, 2.0], model: CityModel::Heights(raster), ..picture };
        assert!(draw_city(&picture, &PictureForm::PNG, &[]).is_err());
        let mut bent = grid_city(1);
        bent[0].top_m = f64::NAN;
        let picture = CityPicture { model: CityModel::Prisms(&bent), ..picture };
        assert!(draw_city(&picture, &PictureForm::PNG, &[]).is_err_and(|e| e.contains("building 0")));
    }
}
