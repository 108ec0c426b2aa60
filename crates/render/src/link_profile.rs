//! One link from the side: what the ray passes over, and where it stops.

use skyshed_core::coverage::{ProfileStep, StepKind};

use super::colors::{self, INK};
use super::furniture::{self, Block, DETAIL};
use super::lettering::{Anchor, Type, length, number};
use super::marks::Label;
use super::page::page;
use super::plot_axis::{Axis, Direction, Span};
use super::plot_frame;
use super::sheet::{Drawing, Sheet};

const WIDTH: f64 = 1500.0;
const HEIGHT: f64 = 620.0;
const AXIS: f64 = 104.0;

/// A link to draw from the side. Distances run from the UAV along the ground \[m\], heights are above one datum \[m\].
#[derive(Clone, Copy, Debug)]
pub struct LinkProfile<'a> {
    /// Title.
    pub title: &'a str,
    /// Lines below; long ones are wrapped.
    pub caption: &'a [String],
    /// Horizontal length of the link \[m\].
    pub distance_m: f64,
    /// Height of the UAV \[m\].
    pub uav_m: f64,
    /// Height of the receiver \[m\].
    pub receiver_m: f64,
    /// Ground and roofs below the link.
    pub steps: &'a [ProfileStep],
    /// What blocks the link; nothing if it is line of sight.
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

/// The window of the drawing and how meters map to it.
#[derive(Clone, Copy, Debug)]
struct Window {
    distance: [f64; 2],
    height: [f64; 2],
}

impl Window {
    fn new(profile: &LinkProfile<'_>) -> Self {
        let heights = || {
            let steps = profile.steps.iter().map(|step| step.height_m);
            steps.chain([profile.uav_m, profile.receiver_m])
        };
        let low = heights().fold(f64::INFINITY, f64::min);
        let high = heights().fold(f64::NEG_INFINITY, f64::max);
        let span = (high - low).max(1.0);
        let side = 0.07 * profile.distance_m;
        // The band at the bottom has room for the receiver's label.
        Self { distance: [-side, profile.distance_m + side], height: [low - 0.16 * span, high + 0.22 * span] }
    }

    fn at(&self, distance_m: f64, height_m: f64) -> [f64; 2] {
        let x = (distance_m - self.distance[0]) / (self.distance[1] - self.distance[0]) * WIDTH;
        let y = (self.height[1] - height_m) / (self.height[1] - self.height[0]) * HEIGHT;
        [x.clamp(0.0, WIDTH), y.clamp(0.0, HEIGHT)]
    }

    /// How much heights are stretched against distances.
    fn exaggeration(&self) -> f64 {
        (HEIGHT / (self.height[1] - self.height[0])) / (WIDTH / (self.distance[1] - self.distance[0]))
    }
}

/// Draws a link from the side.
///
/// # Errors
/// A length that is not above 0 m, a height that is not finite, or a step that ends before it starts.
pub fn draw_link_profile(profile: &LinkProfile<'_>) -> Result<Sheet, String> {
    check(profile)?;
    let window = Window::new(profile);
    let mut framed = axes(profile, &window);
    framed.svg.push_str(&steps(profile, &window).svg);
    framed.svg.push_str(&ray(profile, &window).svg);
    plot_frame::frame(&mut framed, [WIDTH, HEIGHT]);
    let (legend, below) = (legend(profile), HEIGHT + 92.0);
    framed.place(&legend.drawing, 0.0, below);
    let stretch = stretch(window.exaggeration());
    framed.text(WIDTH, below + 24.0, Type { anchor: Anchor::End, ..DETAIL }, &stretch);
    let mut drawing = Drawing::default();
    drawing.place(&framed, AXIS, 0.0);
    let body = Block { width: AXIS + WIDTH, height: below + legend.height + 24.0, drawing };
    Ok(page(profile.title, &body, profile.caption, [16.0, 0.0]))
}

/// Says how the scales of the two axes differ.
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
    if !(profile.distance_m.is_finite() && profile.distance_m > 0.0) {
        return Err(format!("cannot draw a link of {} m: it must be above 0 m", profile.distance_m));
    }
    let obstruction = profile.obstruction.map_or([0.0; 3], |o| [o.distance_m, o.ray_height_m, o.roof_height_m]);
    if ![profile.uav_m, profile.receiver_m].iter().chain(&obstruction).all(|h| h.is_finite()) {
        return Err("cannot draw a link: a height or distance is not finite".to_string());
    }
    let bad = |s: &ProfileStep| {
        let finite = s.from_m.is_finite() && s.to_m.is_finite() && s.height_m.is_finite();
        !finite || s.to_m < s.from_m
    };
    match profile.steps.iter().position(bad) {
        Some(i) => Err(format!("cannot draw step {i} of a link: not finite, or it ends before it starts")),
        None => Ok(()),
    }
}

fn axes(profile: &LinkProfile<'_>, window: &Window) -> Drawing {
    let span = |ends| Span { ends, is_log: false };
    let distances = furniture::ticks(0.0, profile.distance_m, 8.0);
    let x = span(window.distance).axis_at("Distance from the UAV [m]", Direction::Across, WIDTH, distances);
    let heights = furniture::ticks(window.height[0], window.height[1], 6.0);
    let y = span(window.height).axis_at("Height above the datum [m]", Direction::Up, HEIGHT, heights);
    plot_frame::axes([WIDTH, HEIGHT], &Axis { has_grid: false, ..x }, &Axis { name_at: 82.0, ..y })
}

const TERRAIN_FILL: &str = "#DAD5CA";
const BUILDING_FILL: &str = "#B4B8BD";

/// Ground below, then buildings, each an area down to the bottom of the window.
fn steps(profile: &LinkProfile<'_>, window: &Window) -> Drawing {
    let mut drawing = Drawing::default();
    for kind in [StepKind::Terrain, StepKind::Building] {
        let fill = if kind == StepKind::Terrain { TERRAIN_FILL } else { BUILDING_FILL };
        for step in profile.steps.iter().filter(|step| step.kind == kind) {
            let [x0, y] = window.at(step.from_m, step.height_m);
            let [x1, _] = window.at(step.to_m, step.height_m);
            if x1 > x0 {
                drawing.rect([x0, y, x1 - x0, HEIGHT - y], &format!("fill=\"{fill}\""));
                if kind == StepKind::Building {
                    let roof = [[x0, HEIGHT], [x0, y], [x1, y], [x1, HEIGHT]];
                    drawing.polyline(&roof, "stroke=\"#6B7178\" stroke-width=\"1.6\" stroke-linejoin=\"round\"");
                } else {
                    drawing.line([x0, y], [x1, y], "stroke=\"#8F897B\" stroke-width=\"2\"");
                }
            }
        }
    }
    drawing
}

fn ray(profile: &LinkProfile<'_>, window: &Window) -> Drawing {
    let mut drawing = Drawing::default();
    let uav = window.at(0.0, profile.uav_m);
    let receiver = window.at(profile.distance_m, profile.receiver_m);
    drawing.line(uav, receiver, "stroke=\"#FFFFFF\" stroke-width=\"9\" stroke-opacity=\"0.9\"");
    let color = colors::hex(if profile.obstruction.is_none() { colors::LOS } else { colors::NLOS });
    drawing.line(uav, receiver, &format!("stroke=\"{color}\" stroke-width=\"4.5\""));

    let [x, y] = receiver;
    let ink = "fill=\"#101418\" stroke=\"#FFFFFF\" stroke-width=\"3\"";
    drawing.circle([x, y], 10.0, ink);
    let mut taken =
        vec![[x - 16.0, y - 16.0, x + 16.0, y + 16.0], [uav[0] - 30.0, uav[1] - 30.0, uav[0] + 30.0, uav[1] + 30.0]];
    let meters = |height: f64| format!("{} m", number(height, 1));
    let mut labels = vec![
        (uav, ["UAV".to_string(), meters(profile.uav_m)]),
        (receiver, ["Receiver".to_string(), meters(profile.receiver_m)]),
    ];
    if let Some(obstruction) = profile.obstruction {
        let on_ray = window.at(obstruction.distance_m, obstruction.ray_height_m);
        let on_roof = window.at(obstruction.distance_m, obstruction.roof_height_m);
        drawing.line(on_ray, on_roof, "stroke=\"#FFFFFF\" stroke-width=\"7\"");
        drawing.line(on_ray, on_roof, "stroke=\"#101418\" stroke-width=\"3\" stroke-dasharray=\"7 5\"");
        drawing.circle(on_ray, 8.0, "fill=\"#FFFFFF\" stroke=\"#101418\" stroke-width=\"3.4\"");
        drawing.polygon(
            &[[0.0, -11.0], [11.0, 0.0], [0.0, 11.0], [-11.0, 0.0]].map(|[dx, dy]| [on_roof[0] + dx, on_roof[1] + dy]),
            ink,
        );
        let [x, y] = on_ray;
        taken.push([x - 14.0, on_roof[1].min(y) - 14.0, x + 14.0, on_roof[1].max(y) + 14.0]);
        let detail = format!(
            "at {}: roof {} m, ray {} m",
            length(obstruction.distance_m),
            number(obstruction.roof_height_m, 1),
            number(obstruction.ray_height_m, 1)
        );
        labels.push((on_roof, ["Obstructing point".to_string(), detail]));
    }
    furniture::uav_symbol(&mut drawing, uav, 23.0);
    for (anchor, words) in labels {
        place_label(&mut drawing, &mut taken, anchor, &words, [uav, receiver]);
    }
    drawing
}

/// Puts a label where it covers neither the ray nor another label: under an anchor near the bottom, else above it.
fn place_label(
    drawing: &mut Drawing,
    taken: &mut Vec<[f64; 4]>,
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
    let spots: Vec<[f64; 2]> =
        spots.map(|[x, y]| [x.clamp(8.0, (WIDTH - w - 8.0).max(8.0)), y.clamp(8.0, HEIGHT - h - 8.0)]).collect();
    let covers = |[x, y]: [f64; 2], boxes: &[[f64; 4]]| {
        boxes.iter().any(|t| x < t[2] && t[0] < x + w && y < t[3] && t[1] < y + h)
    };
    let crosses = |[x, y]: [f64; 2]| {
        let (a, b) = (ray_at(x), ray_at(x + w));
        a.max(b) > y - 6.0 && a.min(b) < y + h + 6.0
    };
    let free = spots.iter().find(|&&s| !covers(s, taken) && !crosses(s));
    let best = free.or_else(|| spots.iter().find(|&&s| !covers(s, taken))).or(spots.last());
    if let Some(&[x, y]) = best {
        taken.push([x, y, x + w, y + h]);
        label.draw(drawing, x, y);
    }
}

fn legend(profile: &LinkProfile<'_>) -> Block {
    let has = |kind: StepKind| profile.steps.iter().any(|step| step.kind == kind);
    let line = if profile.obstruction.is_none() {
        (colors::hex(colors::LOS), "Line of sight", 5.0)
    } else {
        (colors::hex(colors::NLOS), "No line of sight", 5.0)
    };
    let mut entries = vec![line];
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

    const STEPS: [ProfileStep; 2] = [
        ProfileStep { from_m: 0.0, to_m: 200.0, height_m: 0.0, kind: StepKind::Terrain },
        ProfileStep { from_m: 120.0, to_m: 150.0, height_m: 25.0, kind: StepKind::Building },
    ];
    const CLEAR: LinkProfile<'static> = LinkProfile {
        title: "One link",
        caption: &[],
        distance_m: 200.0,
        uav_m: 60.0,
        receiver_m: 1.5,
        steps: &STEPS,
        obstruction: None,
    };

    fn svg(profile: &LinkProfile<'_>) -> Result<String, String> {
        draw_link_profile(profile).map(|sheet| sheet.furniture.svg)
    }

    #[test]
    fn a_clear_link_is_blue_and_a_blocked_one_orange_with_its_obstructing_point() {
        let clear = svg(&CLEAR).expect("the link is valid");
        assert!(clear.contains("#0072B2") && !clear.contains("#E69F00") && !clear.contains("Obstructing"));
        let obstruction = Some(Obstruction { distance_m: 150.0, ray_height_m: 16.1, roof_height_m: 25.0 });
        let blocked = svg(&LinkProfile { obstruction, ..CLEAR }).expect("the link is valid");
        for words in ["#E69F00", "Obstructing point", "roof 25 m, ray 16.1 m", ">Receiver<", ">UAV<"] {
            assert!(blocked.contains(words), "{words}");
        }
        assert!(!blocked.contains("#0072B2"));
    }

    #[test]
    fn the_scales_of_the_axes_are_compared_in_words() {
        assert_eq!(stretch(1.02), "heights to scale");
        assert_eq!(stretch(12.3), "heights drawn 12 times larger than distances");
        assert_eq!(stretch(0.4), "distances drawn 2.5 times larger than heights");
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let steps = [ProfileStep { from_m: 5.0, to_m: 4.0, ..STEPS[0] }];
        for bad in [
            LinkProfile { distance_m: 0.0, ..CLEAR },
            LinkProfile { uav_m: f64::NAN, ..CLEAR },
            LinkProfile { steps: &steps, ..CLEAR },
        ] {
            assert!(svg(&bad).is_err(), "{bad:?}");
        }
    }
}
