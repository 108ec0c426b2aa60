//! Track of a user: on a plan of the city, and as strips of line of sight.
//!
//! Above the strips are the least height in line of sight of a walk, or the heights that a flight passes over.

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
/// Height of a strip of one of several UAVs \[px\], and the most of them.
const THIN_STRIP: f64 = 22.0;
const MOST_STRIPS: usize = 16;
/// Color of a track inside buildings.
const NO_RECEIVER: Rgb = [0x84, 0x5E, 0x8C];
/// Colors of what is below a flight.
const GROUND: Rgb = [0xDA, 0xD5, 0xCA];
const ROOF: Rgb = [0xB4, 0xB8, 0xBD];
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
    /// Parts of the track, in order, which together cover it: as the best UAV at each place sees it.
    pub stretches: &'a [TrackStretch<'a>],
    /// Parts of the track as each UAV sees it, with its id; empty for one UAV.
    pub of_each: &'a [(String, Vec<TrackStretch<'a>>)],
    /// Heights along the track.
    pub heights: TrackHeights<'a>,
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
    /// Marks of the UAVs.
    pub uavs: &'a [Mark<'a>],
}

/// Heights along a track.
#[derive(Debug, Clone, Copy)]
pub enum TrackHeights<'a> {
    /// A walk: heights above the ground.
    Walk {
        /// Distances along the track \[m\], ascending, with the least height in line of sight there
        /// \[m\]. `None`: no receiver, or no height is enough.
        enough: &'a [(f64, Option<f64>)],
        /// Height of the user \[m\].
        user_m: f64,
    },
    /// A flight, at places along it, ascending: heights above the datum.
    Flight(&'a [FlightHeights]),
}

/// Heights at a place of a flight \[m\]; not finite where unknown or not there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlightHeights {
    /// Distance along the track.
    pub along_m: f64,
    /// The user.
    pub user_m: f64,
    /// The ground.
    pub ground_m: f64,
    /// The roof, if the place is over a building.
    pub roof_m: f64,
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
    let finite = match track.heights {
        TrackHeights::Walk { enough, user_m } => {
            user_m.is_finite() && enough.iter().all(|(at, h)| at.is_finite() && h.is_none_or(f64::is_finite))
        }
        TrackHeights::Flight(heights) => heights.iter().all(|h| h.along_m.is_finite() && h.user_m.is_finite()),
    };
    let ends = track.stretches.iter().all(|s| s.along_m.iter().all(|m| m.is_finite()));
    if !(track.length_m > 0.0 && track.length_m.is_finite() && finite && ends) {
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
    let (mark, _) = draw_marks(track.plan.uavs, [width, height], px_per_cell, cell_m);
    page.furniture.place(&mark, left, top);
    let beside = furniture::stack(&[legend(track), furniture::orientation(px_per_cell[0] / cell_m.0, 240.0)], 34.0);
    page.furniture.place(&beside.drawing, left + width + 44.0, top);
    let top = top + height.max(beside.height) + 34.0;

    let along = Span::linear(0.0, track.length_m);
    let x_axis = along.axis("Distance along the track [m]", Direction::Across, WIDTH);
    let drawn = match track.heights {
        TrackHeights::Walk { enough, user_m } => walk_heights((enough, user_m), along, &x_axis),
        TrackHeights::Flight(heights) => flight_heights(heights, track.stretches, along, &x_axis),
    };
    page.furniture.place(&drawn, left, top);
    let mut top = top + HEIGHT + GAP;
    for (name, stretches) in track.of_each.iter().take(MOST_STRIPS) {
        page.furniture.place(&strip(stretches, along, None), left, top);
        let style = Type { anchor: Anchor::End, color: INK, ..DETAIL };
        page.furniture.text(left - 12.0, top + 0.5 * THIN_STRIP + 7.0, style, &shortened(name));
        top += THIN_STRIP + 4.0;
    }
    page.furniture.place(&strip(track.stretches, along, Some(x_axis)), left, top);
    page.bottom = top + STRIP + 92.0;
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

/// Returns the id of a UAV as it fits beside its strip.
fn shortened(name: &str) -> String {
    const MOST: usize = 9;
    match name.chars().count() > MOST {
        true => name.chars().take(MOST - 1).chain(['…']).collect(),
        false => name.to_string(),
    }
}

/// Draws the ground and the roofs below a flight, and the flight in the colors of its stretches.
fn flight_heights(heights: &[FlightHeights], stretches: &[TrackStretch<'_>], along: Span, x_axis: &Axis) -> Drawing {
    let all = || heights.iter().flat_map(|h| [h.user_m, h.ground_m, h.roof_m]).filter(|m| m.is_finite());
    let (low, high) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), m| (low.min(m), high.max(m)));
    let room = 0.06 * (high - low).max(1.0);
    let span = Span::linear(low - room, high + room);
    let window = Window { size: [WIDTH, HEIGHT], x: along, y: span };
    let mut content = Drawing::default();
    let mut area = |of: fn(&FlightHeights) -> f64, color: Rgb| {
        for run in heights.chunk_by(|a, b| of(a).is_finite() == of(b).is_finite()) {
            let mut points: Vec<[f64; 2]> =
                run.iter().filter(|h| of(h).is_finite()).map(|h| window.at(h.along_m, of(h))).collect();
            let (Some(first), Some(last)) = (points.first().copied(), points.last().copied()) else { continue };
            points.extend([[last[0].max(first[0] + 1.0), HEIGHT], [first[0], HEIGHT]]);
            content.polygon(&points, &colors::fill(color));
        }
    };
    area(|h| h.ground_m, GROUND);
    area(|h| h.roof_m, ROOF);
    for stretch in stretches {
        let [from, to] = stretch.along_m;
        let within = heights.iter().filter(|h| from < h.along_m && h.along_m < to).map(|h| (h.along_m, h.user_m));
        let ends = [from, to].map(|m| (m, user_at(heights, m)));
        let line = std::iter::once(ends[0]).chain(within).chain([ends[1]]);
        let line: Vec<[f64; 2]> = line.map(|(m, h)| window.at(m, h)).collect();
        content.polyline(&line, &stroke(&colors::hex(color(stretch.los)), 6.0, ""));
    }
    let ticks = x_axis.ticks.iter().map(|tick| (tick.0, String::new())).collect();
    let empty = Axis { ticks, ..Axis::default() };
    let y_axis = span.axis("Height above the datum [m]", Direction::Up, HEIGHT);
    plot::framed(window.size, &empty, &Axis { name_at: 72.0, ..y_axis }, &content)
}

/// Returns the height of the user at a distance along a flight \[m\].
fn user_at(heights: &[FlightHeights], along_m: f64) -> f64 {
    let next = heights.partition_point(|h| h.along_m < along_m).clamp(1, heights.len().max(2) - 1);
    match heights {
        [] => 0.0,
        [only] => only.user_m,
        _ => {
            let [a, b] = [&heights[next - 1], &heights[next]];
            let t = if b.along_m > a.along_m { (along_m - a.along_m) / (b.along_m - a.along_m) } else { 0.0 };
            a.user_m + t.clamp(0.0, 1.0) * (b.user_m - a.user_m)
        }
    }
}

/// Draws the heights that would be enough for a walk, and the height of the user.
fn walk_heights((enough, user_m): (&[(f64, Option<f64>)], f64), along: Span, x_axis: &Axis) -> Drawing {
    let highest = enough.iter().filter_map(|p| p.1).fold(user_m, f64::max);
    let heights = Span::linear(0.0, 1.05 * highest.max(1.0));
    let window = Window { size: [WIDTH, HEIGHT], x: along, y: heights };
    let mut content = Drawing::default();
    for piece in enough.chunk_by(|a, b| a.1.is_some() == b.1.is_some()) {
        let points: Vec<[f64; 2]> = piece.iter().filter_map(|(at, h)| Some(window.at(*at, (*h)?))).collect();
        let (Some(first), Some(last)) = (points.first(), points.last()) else { continue };
        let mut area = points.clone();
        area.extend([[last[0], HEIGHT], [first[0], HEIGHT]]);
        content.polygon(&area, &format!("{} fill-opacity=\"0.28\"", colors::fill(colors::NLOS)));
        // A single place is a short line.
        let line = if points.len() > 1 { points } else { vec![[first[0] - 1.5, first[1]], [first[0] + 1.5, first[1]]] };
        content.polyline(&line, &stroke("#9A5B00", 3.4, ""));
    }
    let [_, user] = window.at(0.0, user_m);
    content.line([0.0, user], [WIDTH, user], &stroke(INK, 2.4, "10 7"));
    let words = format!("user at {}", length_words(user_m));
    content.text(WIDTH - 10.0, user - 10.0, Type { anchor: Anchor::End, color: INK, ..DETAIL }, &words);
    // The texts of the horizontal axis are below the strip.
    let ticks = x_axis.ticks.iter().map(|tick| (tick.0, String::new())).collect();
    let empty = Axis { ticks, ..Axis::default() };
    let y_axis = heights.axis("Height above ground [m]", Direction::Up, HEIGHT);
    plot::framed(window.size, &empty, &Axis { name_at: 72.0, ..y_axis }, &content)
}

/// Draws stretches side by side; those below all others with the axis.
fn strip(stretches: &[TrackStretch<'_>], along: Span, x_axis: Option<Axis>) -> Drawing {
    let mut strip = Drawing::default();
    let height = if x_axis.is_some() { STRIP } else { THIN_STRIP };
    for stretch in stretches {
        let [from, to] = stretch.along_m.map(|m| along.share(m).clamp(0.0, 1.0) * WIDTH);
        strip.rect([from, 0.0, (to - from).max(0.5), height], &colors::fill(color(stretch.los)));
    }
    if let Some(axis) = x_axis {
        strip.add(&plot::axes([WIDTH, STRIP], &Axis { has_grid: false, ..axis }, &Axis::default()));
    }
    furniture::frame(&mut strip, [0.0; 2], [WIDTH, height]);
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
    match track.heights {
        TrackHeights::Walk { .. } => {
            let pale = Swatch::Flat(colors::mix(colors::NLOS, colors::WHITE, 0.72));
            keys.push(furniture::legend_entry(
                pale,
                "Least height in line of sight",
                "a user up there would see the UAV",
            ));
        }
        TrackHeights::Flight(_) => {
            keys.push(furniture::legend_entry(Swatch::Flat(GROUND), "Ground", "below the flight"));
            keys.push(furniture::legend_entry(Swatch::Flat(ROOF), "Roofs", "below the flight"));
        }
    }
    keys.push(furniture::legend_entry(Swatch::Uav, "UAV", "the track begins at the white dot"));
    furniture::stack(&keys, 14.0)
}
