//! What a user sees along a track: a strip of line of sight, and above it the height that would be enough.

use super::colors::{self, INK, Rgb};
use super::furniture::{self, Block, DETAIL, Swatch};
use super::lettering::length as length_words;
use super::lettering::{Anchor, Type};
use super::page::page;
use super::plot_axis::{Axis, Direction, Span};
use super::plot_frame;
use super::sheet::{Drawing, Sheet};

const WIDTH: f64 = 1500.0;
const HEIGHT: f64 = 480.0;
const AXIS: f64 = 104.0;
/// The strip below the plot, and the room between \[px\].
const STRIP: f64 = 40.0;
const GAP: f64 = 14.0;
/// Where a track runs through buildings.
const NO_RECEIVER: Rgb = [0xC3, 0xC6, 0xC9];

/// A picture of a track. Lengths in meters.
#[derive(Debug, Clone, Copy)]
pub struct TrackProfile<'a> {
    /// Title.
    pub title: &'a str,
    /// Lines below; long ones are wrapped.
    pub caption: &'a [String],
    /// Length of the track \[m\].
    pub length_m: f64,
    /// Parts of the track, in order, that are all of it.
    pub stretches: &'a [TrackStretch],
    /// Distances along the track \[m\], ascending, with the least height above ground in line of sight there \[m\]; `None` where
    /// there is no receiver or no height is enough.
    pub enough: &'a [(f64, Option<f64>)],
    /// Height of the user above ground \[m\].
    pub user_m: f64,
}

/// A part of a track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackStretch {
    /// Where it begins and ends along the track \[m\].
    pub along_m: [f64; 2],
    /// Whether the user has line of sight; `None` where there is no receiver.
    pub los: Option<bool>,
}

/// Draws a track.
///
/// # Errors
/// A length that is not above 0 or a value that is not finite.
pub fn draw_track_profile(track: &TrackProfile<'_>) -> Result<Sheet, String> {
    let finite = track.enough.iter().all(|(at, h)| at.is_finite() && h.is_none_or(f64::is_finite));
    let ends = track.stretches.iter().all(|s| s.along_m.iter().all(|m| m.is_finite()));
    if !(track.length_m > 0.0 && track.length_m.is_finite() && track.user_m.is_finite() && finite && ends) {
        return Err("cannot draw a track: its lengths and heights must be finite, and its length above 0".into());
    }
    let highest = track.enough.iter().filter_map(|p| p.1).fold(track.user_m, f64::max);
    let (along, heights) = (
        Span { ends: [0.0, track.length_m], is_log: false },
        Span { ends: [0.0, 1.05 * highest.max(1.0)], is_log: false },
    );
    let x = |m: f64| along.share(m).clamp(0.0, 1.0) * WIDTH;
    let y = |m: f64| (1.0 - heights.share(m)) * HEIGHT;

    let mut framed = Drawing::default();
    // The names of the axis along stand below the strip.
    let x_axis = along.axis("Distance along the track [m]", Direction::Across, WIDTH);
    let below = Axis { has_grid: false, ..x_axis.clone() };
    let empty =
        Axis { name: String::new(), ticks: x_axis.ticks.iter().map(|t| (t.0, String::new())).collect(), ..x_axis };
    let y_axis = heights.axis("Height above ground [m]", Direction::Up, HEIGHT);
    framed.place(&plot_frame::axes([WIDTH, HEIGHT], &empty, &Axis { name_at: 72.0, ..y_axis }), 0.0, 0.0);
    for piece in track.enough.chunk_by(|a, b| a.1.is_some() == b.1.is_some()) {
        let points: Vec<[f64; 2]> = piece.iter().filter_map(|(at, h)| Some([x(*at), y((*h)?)])).collect();
        let (Some(first), Some(last)) = (points.first(), points.last()) else { continue };
        let mut area = points.clone();
        area.extend([[last[0], HEIGHT], [first[0], HEIGHT]]);
        framed.polygon(&area, &format!("fill=\"{}\" fill-opacity=\"0.28\"", colors::hex(colors::NLOS)));
        // A single place is a short line.
        let line = if points.len() > 1 { points } else { vec![[first[0] - 1.5, first[1]], [first[0] + 1.5, first[1]]] };
        framed.polyline(&line, "stroke=\"#9A5B00\" stroke-width=\"3.4\" stroke-linejoin=\"round\"");
    }
    let user = y(track.user_m);
    framed.line(
        [0.0, user],
        [WIDTH, user],
        &format!("stroke=\"{INK}\" stroke-width=\"2.4\" stroke-dasharray=\"10 7\""),
    );
    let words = format!("user at {}", length_words(track.user_m));
    framed.text(WIDTH - 10.0, user - 10.0, Type { anchor: Anchor::End, color: INK, ..DETAIL }, &words);
    plot_frame::frame(&mut framed, [WIDTH, HEIGHT]);

    let mut strip = Drawing::default();
    for stretch in track.stretches {
        let [from, to] = stretch.along_m.map(x);
        let color = match stretch.los {
            Some(true) => colors::LOS,
            Some(false) => colors::NLOS,
            None => NO_RECEIVER,
        };
        strip.rect([from, 0.0, (to - from).max(0.5), STRIP], &format!("fill=\"{}\"", colors::hex(color)));
    }
    strip.place(&plot_frame::axes([WIDTH, STRIP], &below, &no_axis()), 0.0, 0.0);
    plot_frame::frame(&mut strip, [WIDTH, STRIP]);

    let sum = |los: Option<bool>| -> f64 {
        track.stretches.iter().filter(|s| s.los == los).map(|s| s.along_m[1] - s.along_m[0]).sum()
    };
    let entry = |swatch, name, m: f64| furniture::legend_entry(swatch, name, &length_words(m));
    let mut keys = vec![
        entry(Swatch::Flat(colors::LOS), "Line of sight", sum(Some(true))),
        entry(Swatch::Flat(colors::NLOS), "No line of sight", sum(Some(false))),
    ];
    if sum(None) > 0.0 {
        keys.push(entry(Swatch::Flat(NO_RECEIVER), "No receiver", sum(None)));
    }
    keys.push(furniture::legend_entry(
        Swatch::Flat(colors::mix(colors::NLOS, [255; 3], 0.72)),
        "Least height in line of sight",
        "a user up there would see the UAV",
    ));
    let legend = furniture::flow(&keys, WIDTH, [44.0, 14.0]);

    let mut drawing = Drawing::default();
    drawing.place(&legend.drawing, AXIS, 0.0);
    let top = legend.height + 26.0;
    drawing.place(&framed, AXIS, top);
    drawing.place(&strip, AXIS, top + HEIGHT + GAP);
    let body = Block { width: AXIS + WIDTH + 30.0, height: top + HEIGHT + GAP + STRIP + 92.0, drawing };
    Ok(page(track.title, &body, track.caption, [24.0, 0.0]))
}

/// An axis without ticks and name.
fn no_axis() -> Axis {
    Axis { name: String::new(), ticks: Vec::new(), has_grid: false, name_at: 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_strip_shows_every_stretch_at_its_place_and_bad_numbers_are_refused() {
        let stretch = |from, to, los| TrackStretch { along_m: [from, to], los };
        let track = TrackProfile {
            title: "A walk",
            caption: &[],
            length_m: 100.0,
            stretches: &[stretch(0.0, 25.0, Some(true)), stretch(25.0, 50.0, Some(false)), stretch(50.0, 100.0, None)],
            enough: &[(0.0, Some(0.5)), (25.0, Some(2.0)), (49.0, Some(9.0)), (60.0, None)],
            user_m: 1.5,
        };
        let svg = draw_track_profile(&track).expect("the track is valid").furniture.svg;
        // 25 m of 100 are a quarter of the width.
        for words in ["No receiver", "50 m", "25 m", "user at 1.5 m", "width=\"375\" height=\"40\" fill=\"#E69F00\""] {
            assert!(svg.contains(words), "{words}: {svg}");
        }
        assert!(draw_track_profile(&TrackProfile { length_m: 0.0, ..track }).is_err());
        assert!(draw_track_profile(&TrackProfile { enough: &[(f64::NAN, None)], ..track }).is_err());
    }
}
