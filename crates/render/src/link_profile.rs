//! One link from the side: ground and roofs below the ray, and the point that blocks it.

use skyshed_core::coverage::{ProfileStep, StepKind};

use super::check;
use super::colors::{self, INK, Rgb};
use super::furniture::{self, Block, DETAIL, stroke};
use super::lettering::{Anchor, Type, length, number};
use super::marks::{Bounds, Label, overlap};
use super::page::page;
use super::plot::{self, Axis, Direction, Span, Window};
use super::sheet::{Drawing, Sheet};

const WIDTH: f64 = 1500.0;
const HEIGHT: f64 = 620.0;
const AXIS: f64 = 104.0;

/// A link to draw from the side. Distances run from the UAV along the ground \[m\], heights are
/// above one datum \[m\].
#[derive(Clone, Copy, Debug)]
pub struct LinkProfile<'a> {
    /// Title.
    pub title: &'a str,
    /// Lines below; long ones are wrapped.
    pub caption: &'a [String],
    /// Name of the height axis.
    pub heights: &'a str,
    /// Horizontal length of the link \[m\].
    pub distance_m: f64,
    /// Height of the UAV \[m\].
    pub uav_m: f64,
    /// Height of the receiver \[m\].
    pub receiver_m: f64,
    /// Ground and roofs below the link.
    pub steps: &'a [ProfileStep],
    /// Point that blocks the link; `None` for line of sight.
    pub obstruction: Option<Obstruction>,
}

/// The obstructing point of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstruction {
    /// Distance \[m from the UAV\].
    pub distance_m: f64,
    /// Height of the ray there \[m\].
    pub ray_height_m: f64,
    /// Height of the roof or ground there \[m\].
    pub roof_height_m: f64,
}

/// Returns the mapping of meters to the drawing.
fn window(profile: &LinkProfile<'_>) -> Window {
    let heights = profile.steps.iter().flat_map(|step| step.heights_m).chain([profile.uav_m, profile.receiver_m]);
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
    let span = (high - low).max(1.0);
    let side = 0.07 * profile.distance_m;
    // The band at the bottom has room for the receiver's label.
    Window {
        size: [WIDTH, HEIGHT],
        x: Span::linear(-side, profile.distance_m + side),
        y: Span::linear(low - 0.16 * span, high + 0.22 * span),
    }
}

/// Draws a link from the side.
///
/// # Errors
/// A length that is not above 0 m, a height that is not finite, or a step that ends before it
/// starts.
pub fn draw_link_profile(profile: &LinkProfile<'_>) -> Result<Sheet, String> {
    check(profile)?;
    let window = window(profile);
    let mut content = steps(profile, &window);
    content.add(&ray(profile, &window));
    let [x, y] = axes(profile, &window);
    let mut framed = plot::framed(window.size, &x, &y, &content);
    let (legend, below) = (legend(profile), HEIGHT + 92.0);
    framed.place(&legend.drawing, 0.0, below);
    let px_per_m = |span: Span, length: f64| length / (span.ends[1] - span.ends[0]);
    let stretch = stretch(px_per_m(window.y, HEIGHT) / px_per_m(window.x, WIDTH));
    framed.text(WIDTH, below + 24.0, Type { anchor: Anchor::End, ..DETAIL }, &stretch);
    let mut drawing = Drawing::default();
    drawing.place(&framed, AXIS, 0.0);
    let body = Block { width: AXIS + WIDTH, height: below + legend.height + 24.0, drawing };
    Ok(page(profile.title, &body, profile.caption, [16.0, 0.0]))
}

/// Says in words how many times larger one axis is drawn than the other.
fn stretch(exaggeration: f64) -> String {
    let factor = exaggeration.max(1.0 / exaggeration);
    let times = number(factor, if factor < 9.95 { 1 } else { 0 });
    match times.as_str() {
        "1" => "heights to scale".to_string(),
        _ if exaggeration > 1.0 => format!("heights drawn {times} times larger than distances"),
        _ => format!("distances drawn {times} times larger than heights"),
    }
}

fn check(profile: &LinkProfile<'_>) -> Result<(), String> {
    check::ends("a link", [0.0, profile.distance_m])?;
    let obstruction = profile.obstruction.map_or([0.0; 3], |o| [o.distance_m, o.ray_height_m, o.roof_height_m]);
    let is_good =
        |s: &ProfileStep| s.from_m <= s.to_m && [s.from_m, s.to_m].iter().chain(&s.heights_m).all(|m| m.is_finite());
    let are_finite = [profile.uav_m, profile.receiver_m].iter().chain(&obstruction).all(|m| m.is_finite());
    match are_finite && profile.steps.iter().all(is_good) {
        true => Ok(()),
        false => Err("cannot draw a link: wanted finite heights, and steps that end where they start or behind".into()),
    }
}

fn axes(profile: &LinkProfile<'_>, Window { x, y, .. }: &Window) -> [Axis; 2] {
    let distances = furniture::ticks(0.0, profile.distance_m, 8.0);
    let x = x.axis_at("Distance from the UAV [m]", Direction::Across, WIDTH, distances);
    let heights = furniture::ticks(y.ends[0], y.ends[1], 6.0);
    let y = y.axis_at(profile.heights, Direction::Up, HEIGHT, heights);
    [Axis { has_grid: false, ..x }, Axis { name_at: 82.0, ..y }]
}

/// Look of the receiver and of the point on the roof.
const POINT: &str = "fill=\"#101418\" stroke=\"#FFFFFF\" stroke-width=\"3\"";
const TERRAIN_FILL: &str = "#DAD5CA";
const BUILDING_FILL: &str = "#B4B8BD";

/// Draws the ground, then buildings, each an area down to the bottom of the window.
fn steps(profile: &LinkProfile<'_>, window: &Window) -> Drawing {
    let mut drawing = Drawing::default();
    let of_kind = |kind| profile.steps.iter().filter(move |step| step.kind == kind);
    for step in of_kind(StepKind::Terrain).chain(of_kind(StepKind::Building)) {
        let [x0, y0] = window.at(step.from_m, step.heights_m[0]);
        let [x1, y1] = window.at(step.to_m, step.heights_m[1]);
        if x1 <= x0 {
            continue;
        }
        let fill = |drawing: &mut Drawing, color: &str| {
            let fill = format!("fill=\"{color}\"");
            // A rectangle is sharper than any other shape.
            match step.heights_m[0].total_cmp(&step.heights_m[1]).is_eq() {
                true => drawing.rect([x0, y0, x1 - x0, HEIGHT - y0], &fill),
                false => drawing.polygon(&[[x0, HEIGHT], [x0, y0], [x1, y1], [x1, HEIGHT]], &fill),
            }
        };
        if step.kind == StepKind::Building {
            fill(&mut drawing, BUILDING_FILL);
            // A roof that goes on in another slope has no wall there.
            let goes_on = |[at_m, height_m]: [f64; 2], end: usize| {
                of_kind(StepKind::Building).any(|other| {
                    let place_m = [other.from_m, other.to_m][end];
                    (place_m - at_m).abs() < 1e-6 && (other.heights_m[end] - height_m).abs() < 1e-3
                })
            };
            let start = (!goes_on([step.from_m, step.heights_m[0]], 1)).then_some([x0, HEIGHT]);
            let end = (!goes_on([step.to_m, step.heights_m[1]], 0)).then_some([x1, HEIGHT]);
            let outline: Vec<[f64; 2]> = start.into_iter().chain([[x0, y0], [x1, y1]]).chain(end).collect();
            drawing.polyline(&outline, &stroke("#6B7178", 1.6, ""));
        } else {
            fill(&mut drawing, TERRAIN_FILL);
            drawing.line([x0, y0], [x1, y1], &stroke("#8F897B", 2.0, ""));
        }
    }
    drawing
}

/// Draws the ray, its ends and the obstructing point, with their labels.
fn ray(profile: &LinkProfile<'_>, window: &Window) -> Drawing {
    let mut drawing = Drawing::default();
    let uav = window.at(0.0, profile.uav_m);
    let receiver = window.at(profile.distance_m, profile.receiver_m);
    drawing.line(uav, receiver, "stroke=\"#FFFFFF\" stroke-width=\"9\" stroke-opacity=\"0.9\"");
    drawing.line(uav, receiver, &stroke(&colors::hex(answer(profile).0), 4.5, ""));
    drawing.circle(receiver, 10.0, POINT);
    let meters = |height: f64| format!("{} m", number(height, 1));
    let mut labels = vec![
        (uav, ["UAV".to_string(), meters(profile.uav_m)]),
        (receiver, ["Receiver".to_string(), meters(profile.receiver_m)]),
    ];
    let mut taken = vec![around(receiver, receiver, 16.0), around(uav, uav, 30.0)];
    if let Some(obstruction) = profile.obstruction {
        let on_ray = window.at(obstruction.distance_m, obstruction.ray_height_m);
        let on_roof = window.at(obstruction.distance_m, obstruction.roof_height_m);
        draw_obstruction(&mut drawing, on_ray, on_roof);
        taken.push(around(on_ray, on_roof, 14.0));
        let [roof, ray] = [obstruction.roof_height_m, obstruction.ray_height_m].map(meters);
        let detail = format!("at {}: roof {roof}, ray {ray}", length(obstruction.distance_m));
        labels.push((on_roof, ["Obstructing point".to_string(), detail]));
    }
    furniture::uav_symbol(&mut drawing, uav, 23.0);
    for (anchor, words) in labels {
        place_label(&mut drawing, &mut taken, anchor, &words, [uav, receiver]);
    }
    drawing
}

/// Returns the color of the ray, and its meaning in words.
fn answer(profile: &LinkProfile<'_>) -> (Rgb, &'static str) {
    match profile.obstruction {
        None => (colors::LOS, "Line of sight"),
        Some(_) => (colors::NLOS, "No line of sight"),
    }
}

/// Returns the box around two points at one distance.
fn around([x, a]: [f64; 2], [_, b]: [f64; 2], reach: f64) -> Bounds {
    [x - reach, a.min(b) - reach, x + reach, a.max(b) + reach]
}

/// Draws a hollow mark on the ray, another on the roof, and dashes between them.
fn draw_obstruction(drawing: &mut Drawing, on_ray: [f64; 2], on_roof: [f64; 2]) {
    drawing.line(on_ray, on_roof, "stroke=\"#FFFFFF\" stroke-width=\"7\"");
    drawing.line(on_ray, on_roof, &stroke("#101418", 3.0, "7 5"));
    drawing.circle(on_ray, 8.0, "fill=\"#FFFFFF\" stroke=\"#101418\" stroke-width=\"3.4\"");
    let corners = [[0.0, -11.0], [11.0, 0.0], [0.0, 11.0], [-11.0, 0.0]];
    drawing.polygon(&corners.map(|[dx, dy]| [on_roof[0] + dx, on_roof[1] + dy]), POINT);
}

/// Places a label, if possible clear of the ray and of other labels: under an anchor near the
/// bottom, else above it.
fn place_label(
    drawing: &mut Drawing,
    taken: &mut Vec<Bounds>,
    [x, y]: [f64; 2],
    words: &[String; 2],
    [from, to]: [[f64; 2]; 2],
) {
    let label = Label::new(words, 24.0);
    let (w, h) = (label.width, label.height);
    let ray_at = |x: f64| from[1] + (to[1] - from[1]) * ((x - from[0]) / (to[0] - from[0])).clamp(0.0, 1.0);
    let low_on_the_page = y > 0.6 * HEIGHT;
    let under = low_on_the_page.then_some([x - w / 2.0, y + 22.0]);
    let spots = under.into_iter().chain([32.0, 60.0, 100.0, 150.0, 210.0, 280.0].into_iter().flat_map(|gap| {
        let (above, below) = (y - gap - h, y + gap);
        [[x - w / 2.0, above], [x + 6.0, above], [x - w - 6.0, above], [x - w / 2.0, below], [x + gap, y - h / 2.0]]
    }));
    let bounds = |[x, y]: [f64; 2]| {
        let (x, y) = (x.clamp(8.0, (WIDTH - w - 8.0).max(8.0)), y.clamp(8.0, HEIGHT - h - 8.0));
        [x, y, x + w, y + h]
    };
    let spots: Vec<Bounds> = spots.map(bounds).collect();
    let covers = |spot: &Bounds| taken.iter().any(|other| overlap(spot, other));
    let crosses = |spot: &Bounds| {
        let (a, b) = (ray_at(spot[0]), ray_at(spot[2]));
        a.max(b) > spot[1] - 6.0 && a.min(b) < spot[3] + 6.0
    };
    let free = spots.iter().find(|spot| !covers(spot) && !crosses(spot));
    let best = free.or_else(|| spots.iter().find(|spot| !covers(spot))).or(spots.last());
    if let Some(spot) = best {
        label.draw(drawing, spot[0], spot[1]);
        taken.push(*spot);
    }
}

fn legend(profile: &LinkProfile<'_>) -> Block {
    let has = |kind: StepKind| profile.steps.iter().any(|step| step.kind == kind);
    let (color, name) = answer(profile);
    let mut entries = vec![(colors::hex(color), name, 5.0)];
    if has(StepKind::Building) {
        entries.push((BUILDING_FILL.to_string(), "Buildings", 26.0));
    }
    if has(StepKind::Terrain) {
        entries.push((TERRAIN_FILL.to_string(), "Ground", 26.0));
    }
    let blocks: Vec<Block> = entries
        .into_iter()
        .map(|(color, name, thickness)| {
            let mut drawing = Drawing::default();
            drawing.rect([0.0, 16.0 - thickness / 2.0, 44.0, thickness], &format!("fill=\"{color}\""));
            drawing.text(58.0, 25.0, Type { color: INK, ..DETAIL }, name);
            Block { width: 58.0 + DETAIL.width(name), height: 34.0, drawing }
        })
        .collect();
    furniture::beside(&blocks, 44.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scales_of_the_axes_are_compared_in_words() {
        assert_eq!(stretch(1.02), "heights to scale");
        assert_eq!(stretch(12.3), "heights drawn 12 times larger than distances");
        assert_eq!(stretch(0.4), "distances drawn 2.5 times larger than heights");
    }
}
