//! Track of a user: on a plan of the city, as a strip of line of sight, and above that the least
//! height in line of sight.

use super::check;
use super::colors::{self, INK, Rgb};
use super::furniture::{self, Block, DETAIL, Swatch, stroke};
use super::lettering::length as length_words;
use super::lettering::{Anchor, Type};
use super::marks::{Mark, draw_marks};
use super::page::{MARGIN, Page};
use super::paint::Canvas;
use super::plot::{self, Axis, Direction, Span, Window};
use super::sheet::{Drawing, Sheet};

const WIDTH: f64 = 1500.0;
const HEIGHT: f64 = 480.0;
const AXIS: f64 = 104.0;
/// Height of the strip below the plot \[px\]; `GAP` is the room between them.
const STRIP: f64 = 40.0;
const GAP: f64 = 14.0;
/// Color of a track inside buildings.
const NO_RECEIVER: Rgb = [0x84, 0x5E, 0x8C];
/// Size of a plan: its longer side \[px\], and the most cells along it that are drawn one by one.
const PLAN: (f64, f64) = (700.0, 950.0);

/// A picture of a track. Lengths in meters.
#[derive(Debug, Clone, Copy)]
pub struct TrackProfile<'a> {
    /// Title.
    pub title: &'a str,
    /// Lines below; long ones are wrapped.
    pub caption: &'a [String],
    /// Length of the track \[m\].
    pub length_m: f64,
    /// Parts of the track, in order, which together cover it.
    pub stretches: &'a [TrackStretch<'a>],
    /// Distances along the track \[m\], ascending, with the least height above ground in line of
    /// sight there \[m\]. `None`: no receiver, or no height is enough.
    pub enough: &'a [(f64, Option<f64>)],
    /// Height of the user above ground \[m\].
    pub user_m: f64,
    /// The city around it.
    pub plan: TrackPlan<'a>,
}

/// The city around a track from above. Arrays are `[n_rows, n_cols]`, columns running fastest,
/// north row first.
#[derive(Debug, Clone, Copy)]
pub struct TrackPlan<'a> {
    /// Columns.
    pub n_cols: usize,
    /// Rows.
    pub n_rows: usize,
    /// Cell size along columns and along rows \[m\].
    pub cell_m: (f64, f64),
    /// Classes: 2 buildings, 4 open ground, 255 nodata.
    pub mask: &'a [u8],
    /// Heights above ground, for gray tones of buildings \[m\]; not finite where unknown.
    pub surface_m: &'a [f32],
    /// Mark of the UAV.
    pub uav: Mark<'a>,
}

/// A part of a track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackStretch<'a> {
    /// Start and end along the track \[m\].
    pub along_m: [f64; 2],
    /// Line of sight of the user; `None` where there is no receiver.
    pub los: Option<bool>,
    /// Start, turns and end on the plan: columns and rows.
    pub path: &'a [[f64; 2]],
}

/// Draws a track.
///
/// # Errors
/// A length that is not above 0, a value that is not finite, or a plan of another shape.
pub fn draw_track_profile(track: &TrackProfile<'_>) -> Result<Sheet, String> {
    let finite = track.enough.iter().all(|(at, h)| at.is_finite() && h.is_none_or(f64::is_finite));
    let ends = track.stretches.iter().all(|s| s.along_m.iter().all(|m| m.is_finite()));
    if !(track.length_m > 0.0 && track.length_m.is_finite() && track.user_m.is_finite() && finite && ends) {
        return Err("cannot draw a track: its lengths and heights must be finite, and its length above 0".into());
    }
    let TrackPlan { n_cols, n_rows, cell_m, mask, surface_m, .. } = track.plan;
    check::shape("mask", mask.len(), [n_cols, n_rows])?;
    let canvas = Canvas::new([n_cols, n_rows], cell_m, Some(surface_m), PLAN)?;
    let [width, height] = canvas.size();
    let px_per_cell = canvas.px_per_cell();

    let mut page = Page::new(track.title, AXIS + WIDTH + 30.0, 24.0);
    let [left, top] = [MARGIN + AXIS, page.bottom.round()];
    page.image([left, top], canvas.paint_receivers(&[], mask, |_| 0).image);
    page.furniture.rect([left, top, width, height], &format!("fill=\"none\" {}", furniture::ink(1.6)));
    page.furniture.place(&walked(track, px_per_cell), left, top);
    let (mark, _) = draw_marks(&[track.plan.uav], [width, height], px_per_cell, cell_m);
    page.furniture.place(&mark, left, top);
    let beside = furniture::stack(&[legend(track), furniture::orientation(px_per_cell[0] / cell_m.0, 240.0)], 34.0);
    page.furniture.place(&beside.drawing, left + width + 44.0, top);
    let top = top + height.max(beside.height) + 34.0;

    let along = Span::linear(0.0, track.length_m);
    let x_axis = along.axis("Distance along the track [m]", Direction::Across, WIDTH);
    page.furniture.place(&heights(track, along, &x_axis), left, top);
    page.furniture.place(&strip(track, along, x_axis), left, top + HEIGHT + GAP);
    page.bottom = top + HEIGHT + GAP + STRIP + 92.0;
    Ok(page.finish(0.0, track.caption))
}

/// Returns the color of a stretch.
fn color(los: Option<bool>) -> Rgb {
    match los {
        Some(true) => colors::LOS,
        Some(false) => colors::NLOS,
        None => NO_RECEIVER,
    }
}

/// Draws the track on the plan, in the colors of its stretches, with a dot at its start.
fn walked(track: &TrackProfile<'_>, px_per_cell: [f64; 2]) -> Drawing {
    let mut drawing = Drawing::default();
    let px = |place: &[f64; 2]| [0, 1].map(|k| place[k] * px_per_cell[k]);
    for is_core in [false, true] {
        for stretch in track.stretches {
            let look = if is_core { stroke(&colors::hex(color(stretch.los)), 7.0, "") } else { stroke(INK, 11.0, "") };
            drawing.polyline(&stretch.path.iter().map(px).collect::<Vec<_>>(), &look);
        }
    }
    if let Some(start) = track.stretches.first().and_then(|stretch| stretch.path.first()) {
        drawing.circle(px(start), 9.0, &format!("fill=\"#FFFFFF\" {}", furniture::ink(3.0)));
    }
    drawing
}

/// Draws the heights that would be enough, and the height of the user.
fn heights(track: &TrackProfile<'_>, along: Span, x_axis: &Axis) -> Drawing {
    let highest = track.enough.iter().filter_map(|p| p.1).fold(track.user_m, f64::max);
    let heights = Span::linear(0.0, 1.05 * highest.max(1.0));
    let window = Window { size: [WIDTH, HEIGHT], x: along, y: heights };
    let mut content = Drawing::default();
    for piece in track.enough.chunk_by(|a, b| a.1.is_some() == b.1.is_some()) {
        let points: Vec<[f64; 2]> = piece.iter().filter_map(|(at, h)| Some(window.at(*at, (*h)?))).collect();
        let (Some(first), Some(last)) = (points.first(), points.last()) else { continue };
        let mut area = points.clone();
        area.extend([[last[0], HEIGHT], [first[0], HEIGHT]]);
        content.polygon(&area, &format!("{} fill-opacity=\"0.28\"", colors::fill(colors::NLOS)));
        // A single place is a short line.
        let line = if points.len() > 1 { points } else { vec![[first[0] - 1.5, first[1]], [first[0] + 1.5, first[1]]] };
        content.polyline(&line, &stroke("#9A5B00", 3.4, ""));
    }
    let [_, user] = window.at(0.0, track.user_m);
    content.line([0.0, user], [WIDTH, user], &stroke(INK, 2.4, "10 7"));
    let words = format!("user at {}", length_words(track.user_m));
    content.text(WIDTH - 10.0, user - 10.0, Type { anchor: Anchor::End, color: INK, ..DETAIL }, &words);
    // The texts of the horizontal axis are below the strip.
    let ticks = x_axis.ticks.iter().map(|tick| (tick.0, String::new())).collect();
    let empty = Axis { ticks, ..Axis::default() };
    let y_axis = heights.axis("Height above ground [m]", Direction::Up, HEIGHT);
    plot::framed(window.size, &empty, &Axis { name_at: 72.0, ..y_axis }, &content)
}

/// Draws the stretches side by side.
fn strip(track: &TrackProfile<'_>, along: Span, x_axis: Axis) -> Drawing {
    let mut strip = Drawing::default();
    for stretch in track.stretches {
        let [from, to] = stretch.along_m.map(|m| along.share(m).clamp(0.0, 1.0) * WIDTH);
        strip.rect([from, 0.0, (to - from).max(0.5), STRIP], &colors::fill(color(stretch.los)));
    }
    let axis = Axis { has_grid: false, ..x_axis };
    strip.add(&plot::axes([WIDTH, STRIP], &axis, &Axis::default()));
    furniture::frame(&mut strip, [0.0; 2], [WIDTH, STRIP]);
    strip
}

/// Makes the legend, its entries below each other.
fn legend(track: &TrackProfile<'_>) -> Block {
    let sum = |los: Option<bool>| -> f64 {
        track.stretches.iter().filter(|s| s.los == los).map(|s| s.along_m[1] - s.along_m[0]).sum()
    };
    let entry = |(los, name)| furniture::legend_entry(Swatch::Flat(color(los)), name, &length_words(sum(los)));
    let states = [(Some(true), "Line of sight"), (Some(false), "No line of sight"), (None, "No receiver")];
    let is_there = |(los, _): &(Option<bool>, &str)| los.is_some() || sum(*los) > 0.0;
    let mut keys: Vec<Block> = states.into_iter().filter(is_there).map(entry).collect();
    let pale = Swatch::Flat(colors::mix(colors::NLOS, colors::WHITE, 0.72));
    keys.push(furniture::legend_entry(pale, "Least height in line of sight", "a user up there would see the UAV"));
    keys.push(furniture::legend_entry(Swatch::Uav, "UAV", "the track begins at the white dot"));
    furniture::stack(&keys, 14.0)
}
