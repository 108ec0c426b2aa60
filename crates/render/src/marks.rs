//! UAV marks on a map, and labels that keep out of each other's way.

use super::furniture::{self, NAME, Swatch};
use super::lettering::{self, Type, Weight};
use super::sheet::Drawing;

/// A UAV on a map.
#[derive(Clone, Copy, Debug)]
pub struct Mark<'a> {
    /// Its id, such as `1` or `UAV 1`.
    pub label: &'a str,
    /// Its height in words, such as `60 m` or `60 m above ground`; may be empty.
    pub height: &'a str,
    /// Distance from the western border \[cells\]; may lie outside the grid.
    pub col: f64,
    /// Distance from the northern border \[cells\]; may lie outside the grid.
    pub row: f64,
    /// True if it is an observer on the ground, not a UAV.
    pub is_observer: bool,
}

/// Returns the legend entries of some marks: a UAV, an observer, or both.
pub(crate) fn symbols<'a>(marks: impl Iterator<Item = Mark<'a>>) -> Vec<(Swatch, &'static str)> {
    let (mut has_uav, mut has_observer) = (false, false);
    for mark in marks {
        has_uav |= !mark.is_observer;
        has_observer |= mark.is_observer;
    }
    let kinds = [(has_uav, (Swatch::Uav, "UAV")), (has_observer, (Swatch::Observer, "observer"))];
    kinds.into_iter().filter(|(has, _)| *has).map(|(_, kind)| kind).collect()
}

/// A rectangle: left, top, right, bottom \[px\].
pub(crate) type Bounds = [f64; 4];

/// Returns `true` when two rectangles have more than a border in common.
pub(crate) fn overlap(a: &Bounds, b: &Bounds) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// Returns `true` when one rectangle lies in another.
pub(crate) fn within(inner: &Bounds, outer: &Bounds) -> bool {
    inner[0] >= outer[0] && inner[1] >= outer[1] && inner[2] <= outer[2] && inner[3] <= outer[3]
}

/// Mark with its place on the map.
#[derive(Clone, Debug)]
struct Placed {
    at: [f64; 2],
    /// Unit vector towards a UAV outside the map.
    outward: Option<[f64; 2]>,
    /// Place of the UAV, if the mark was moved away from another one there.
    moved_from: Option<[f64; 2]>,
    words: [String; 2],
    is_observer: bool,
}

/// Most UAVs with heights in their labels. Labels of more have only ids, and are beside their marks
/// or left out.
pub const MOST_WITH_HEIGHTS: usize = 60;
/// Most UAVs with labels; more have none.
const MOST_WITH_LABELS: usize = 400;

/// Draws marks and labels on a map of `size` \[px\] with `px_per_cell` and `cell_m` per axis, and
/// returns the number of labels that found a place.
///
/// A UAV outside the grid becomes an arrow at the border and its distance from there. UAVs at one
/// place are drawn one below the other, each with a line to the place. Labels that find no free
/// place are shortened, then left out, later marks first.
pub(crate) fn draw_marks(
    uavs: &[Mark<'_>],
    size: [f64; 2],
    px_per_cell: [f64; 2],
    cell_m: (f64, f64),
) -> (Drawing, usize) {
    let radius = match uavs.len() {
        0..=12 => 23.0,
        13..=MOST_WITH_HEIGHTS => 16.0,
        61..=MOST_WITH_LABELS => 10.0,
        _ => 6.0,
    };
    let mut placed: Vec<Placed> = uavs.iter().map(|uav| place(uav, size, px_per_cell, cell_m)).collect();
    if uavs.len() <= MOST_WITH_HEIGHTS {
        set_apart(&mut placed, radius, size);
    }
    let mut drawing = Drawing::default();
    for mark in &placed {
        if let Some(place) = mark.moved_from {
            drawing.line(place, mark.at, "stroke=\"#FFFFFF\" stroke-width=\"6\"");
            drawing.line(place, mark.at, "stroke=\"#101418\" stroke-width=\"3\"");
        }
    }
    // The first UAV is drawn last, on top.
    for mark in placed.iter().rev() {
        match mark.outward {
            Some(outward) => arrow(&mut drawing, mark.at, outward, radius),
            None if mark.is_observer => furniture::observer_symbol(&mut drawing, mark.at, radius),
            None => furniture::uav_symbol(&mut drawing, mark.at, radius),
        }
    }
    let n_labels = if uavs.len() <= MOST_WITH_LABELS { draw_labels(&mut drawing, &placed, radius, size) } else { 0 };
    (drawing, n_labels)
}

/// Draws the labels that find a place on a map of a size, and returns their number.
fn draw_labels(drawing: &mut Drawing, placed: &[Placed], radius: f64, size: [f64; 2]) -> usize {
    let map = [6.0, 6.0, size[0] - 6.0, size[1] - 6.0];
    let mut taken: Vec<Bounds> = placed.iter().map(|mark| symbol_bounds(mark, radius)).collect();
    let is_crowd = placed.len() > MOST_WITH_HEIGHTS;
    for mark in placed {
        let font_size = if radius > 20.0 { 25.0 } else { (radius + 7.0).min(20.0) };
        // In a crowd, a label away from its mark would be taken for another mark's label.
        let (choices, n_spots) =
            if is_crowd { (vec![id_of(mark, usize::MAX)], 8) } else { (choices(mark), usize::MAX) };
        let spot = choices.iter().find_map(|words| {
            let label = Label::new(words, font_size);
            let bounds = |[x, y]: [f64; 2]| {
                let x = x.min(map[2] - label.width).max(map[0]);
                let y = y.min(map[3] - label.height).max(map[1]);
                [x, y, x + label.width, y + label.height]
            };
            let is_free = |b: &Bounds| within(b, &map) && !taken.iter().any(|other| overlap(b, other));
            let mut spots = candidates(mark, radius, [label.width, label.height]).take(n_spots).map(bounds);
            spots.find(is_free).map(|bounds| (label, bounds))
        });
        if let Some((label, bounds)) = spot {
            label.draw(drawing, bounds[0], bounds[1]);
            taken.push(bounds);
        }
    }
    taken.len() - placed.len()
}

/// Returns the words of a label, best first: all of them, the id alone, or its beginning.
fn choices(mark: &Placed) -> Vec<[String; 2]> {
    let ids = [usize::MAX, 20, 12, 6].map(|most| id_of(mark, most));
    std::iter::once(mark.words.clone()).chain(ids).collect()
}

/// Returns the id of a mark, or its beginning if it has more than `most` characters.
fn id_of(mark: &Placed, most: usize) -> [String; 2] {
    let id = &mark.words[0];
    let is_whole = id.chars().count() <= most;
    [if is_whole { id.clone() } else { id.chars().take(most - 1).chain(['…']).collect() }, String::new()]
}

fn place(uav: &Mark<'_>, size: [f64; 2], px_per_cell: [f64; 2], cell_m: (f64, f64)) -> Placed {
    let wanted = [uav.col * px_per_cell[0], uav.row * px_per_cell[1]];
    let at = [wanted[0].clamp(0.0, size[0]), wanted[1].clamp(0.0, size[1])];
    let cell_m = <[f64; 2]>::from(cell_m);
    let beyond_m = [0, 1].map(|k| (wanted[k] - at[k]) / px_per_cell[k] * cell_m[k]);
    let distance_m = (beyond_m[0] * beyond_m[0] + beyond_m[1] * beyond_m[1]).sqrt();
    let outward = (distance_m > 0.0).then(|| beyond_m.map(|d| d / distance_m));
    let beyond = outward.map(|_| format!("{} outside", lettering::length(distance_m)));
    let height = Some(uav.height.to_string()).filter(|words| !words.is_empty());
    let details: Vec<String> = height.into_iter().chain(beyond).collect();
    let words = [uav.label.to_string(), details.join(" · ")];
    Placed { at, outward, moved_from: None, words, is_observer: uav.is_observer }
}

/// Moves marks at one place apart: one below the other, or above if the map ends there.
fn set_apart(placed: &mut [Placed], radius: f64, size: [f64; 2]) {
    let places: Vec<[f64; 2]> = placed.iter().map(|mark| mark.at).collect();
    let is_same = |a: &[f64; 2], b: &[f64; 2]| (a[0] - b[0]).abs() < 1.0 && (a[1] - b[1]).abs() < 1.0;
    for (k, mark) in placed.iter_mut().enumerate() {
        let n_there = places.iter().filter(|place| is_same(place, &places[k])).count();
        let n_before = places[..k].iter().filter(|place| is_same(place, &places[k])).count();
        if n_before > 0 {
            let step = 2.4 * radius;
            let way = if places[k][1] + step * n_there as f64 > size[1] { -1.0 } else { 1.0 };
            mark.moved_from = Some(mark.at);
            mark.at[1] = (mark.at[1] + way * step * n_before as f64).clamp(0.0, size[1]);
        }
    }
}

/// Returns the detail of a mark's label: its height, and its distance from a map of this size in
/// cells.
pub(crate) fn detail(uav: &Mark<'_>, size_cells: [f64; 2], cell_m: (f64, f64)) -> String {
    place(uav, size_cells, [1.0, 1.0], cell_m).words[1].clone()
}

fn symbol_bounds(mark: &Placed, radius: f64) -> Bounds {
    let [x, y] = match mark.outward {
        Some([dx, dy]) => [mark.at[0] - dx * radius, mark.at[1] - dy * radius],
        None => mark.at,
    };
    let reach = radius * 1.1;
    [x - reach, y - reach, x + reach, y + reach]
}

/// Draws an arrow whose tip touches the border, with a white halo.
fn arrow(drawing: &mut Drawing, [x, y]: [f64; 2], [dx, dy]: [f64; 2], radius: f64) {
    let at =
        |along: f64, across: f64| [x - (dx * along + dy * across) * radius, y - (dy * along - dx * across) * radius];
    let shape = [at(0.1, 0.0), at(1.1, 0.85), at(1.1, 0.3), at(2.1, 0.3), at(2.1, -0.3), at(1.1, -0.3), at(1.1, -0.85)];
    drawing.polygon(&shape, "fill=\"#101418\" stroke=\"#FFFFFF\" stroke-width=\"7\" stroke-linejoin=\"round\"");
    drawing.polygon(&shape, "fill=\"#101418\"");
}

/// Returns top left corners for a label around a mark, best first.
fn candidates(mark: &Placed, radius: f64, size: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    let inset = if mark.outward.is_some() { 1.4 * radius } else { 0.0 };
    [6.0, 20.0, 45.0, 80.0, 130.0]
        .into_iter()
        .flat_map(move |gap| spots_around(mark.at, radius * 1.15 + inset + gap, size))
}

/// Returns top left corners for a label of a size around a place, `reach` from it, best first
/// \[px\].
pub(crate) fn spots_around([x, y]: [f64; 2], reach: f64, [w, h]: [f64; 2]) -> [[f64; 2]; 8] {
    let (east, west) = (x + reach, x - reach - w);
    let (above, below) = (y - reach - h, y + reach);
    let (middle_x, middle_y) = (x - w / 2.0, y - h / 2.0);
    let near = 0.7 * reach;
    [
        [east, middle_y],
        [west, middle_y],
        [middle_x, above],
        [middle_x, below],
        [x + near, y - near - h],
        [x - near - w, y - near - h],
        [x + near, y + near],
        [x - near - w, y + near],
    ]
}

/// A label: a name and a detail on a white plate.
#[derive(Debug)]
pub(crate) struct Label {
    /// Width \[px\].
    pub(crate) width: f64,
    /// Height \[px\].
    pub(crate) height: f64,
    size: f64,
    name_width: f64,
    words: [String; 2],
}

/// Widest name or detail \[letter sizes\]; wider ones are shortened.
const WIDEST: f64 = 18.0;

impl Label {
    /// Measures a label of a name and a detail, either of which may be empty.
    pub(crate) fn new(words: &[String; 2], size: f64) -> Self {
        let styles = [NAME, Type { weight: Weight::Regular, ..NAME }].map(|style| Type { size, ..style });
        let words = [0, 1].map(|k| styles[k].shortened(&words[k], WIDEST * size));
        let [name, detail] = [0, 1].map(|k| styles[k].width(&words[k]));
        let gap = if words.iter().any(String::is_empty) { 0.0 } else { 0.36 * size };
        let name_width = name + gap;
        Self { width: name_width + detail + 0.8 * size, height: 1.44 * size, size, name_width, words }
    }

    /// Draws the label with its top left corner at (`x`, `y`).
    pub(crate) fn draw(&self, drawing: &mut Drawing, x: f64, y: f64) {
        drawing.rect(
            [x, y, self.width, self.height],
            "rx=\"5\" fill=\"#FFFFFF\" fill-opacity=\"0.93\" stroke=\"#1B1F24\" stroke-opacity=\"0.55\" stroke-width=\"1.1\"",
        );
        let baseline = y + self.height / 2.0 + 0.36 * self.size;
        let style = Type { size: self.size, ..NAME };
        let left = x + 0.4 * self.size;
        drawing.text(left, baseline, style, &self.words[0]);
        drawing.text(left + self.name_width, baseline, Type { weight: Weight::Regular, ..style }, &self.words[1]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mark(label: &str, col: f64, row: f64) -> Mark<'_> {
        Mark { label, height: "60 m", col, row, is_observer: false }
    }

    fn plates(svg: &str) -> Vec<Bounds> {
        let value = |line: &str, key: &str| -> f64 {
            let rest = line.split(&format!(" {key}=\"")).nth(1).expect("the attribute is there");
            rest.split('"').next().and_then(|v| v.parse().ok()).expect("it is a number")
        };
        let plates = svg.lines().filter(|line| line.starts_with("<rect"));
        plates
            .map(|line| {
                let [x, y, w, h] = ["x", "y", "width", "height"].map(|key| value(line, key));
                [x, y, x + w, y + h]
            })
            .collect()
    }

    #[test]
    fn labels_of_crowded_marks_do_not_overlap_and_stay_on_the_map() {
        let uavs: Vec<Mark<'_>> = (0..10).map(|k| mark("UAV", 500.0 + 12.0 * f64::from(k), 500.0)).collect();
        let drawing = draw_marks(&uavs, [1000.0, 1000.0], [1.0, 1.0], (1.0, 1.0)).0;
        let plates = plates(&drawing.svg);
        assert!(plates.len() >= 6, "{} labels", plates.len());
        for (i, a) in plates.iter().enumerate() {
            assert!(within(a, &[0.0, 0.0, 1000.0, 1000.0]));
            assert!(plates[i + 1..].iter().all(|b| !overlap(a, b)));
        }
    }

    #[test]
    fn a_uav_outside_becomes_an_arrow_with_its_distance() {
        let drawing = draw_marks(&[mark("1", 1340.0, 300.0)], [1000.0, 1000.0], [1.0, 1.0], (1.0, 1.0)).0;
        assert!(drawing.svg.contains("60 m · 340 m outside"));
        assert!(drawing.svg.contains("<polygon") && !drawing.svg.contains("<circle"));
        let inside = draw_marks(&[mark("1", 1000.0, 0.0)], [1000.0, 1000.0], [1.0, 1.0], (1.0, 1.0)).0;
        assert!(inside.svg.contains("<circle") && !inside.svg.contains("outside"));
    }

    #[test]
    fn uavs_at_one_place_are_all_seen_and_named() {
        for row in [300.0, 990.0] {
            let uavs = ["low", "middle", "high"].map(|label| mark(label, 500.0, row));
            let svg = draw_marks(&uavs, [1000.0, 1000.0], [1.0, 1.0], (1.0, 1.0)).0.svg;
            assert!(["low", "middle", "high"].iter().all(|label| svg.contains(&format!(">{label}<"))), "{svg}");
            // The body of each symbol, the largest circle but for rotors, has a center of its own.
            let centers: std::collections::BTreeSet<&str> =
                svg.lines().filter(|l| l.starts_with("<circle") && l.contains(" cx=\"500")).collect();
            assert_eq!(centers.len(), 2 * 3, "a halo and a body each: {centers:?}");
            let plates = plates(&svg);
            assert!(plates.len() == 3 && !overlap(&plates[0], &plates[1]) && !overlap(&plates[1], &plates[2]));
        }
    }

    #[test]
    fn a_name_that_finds_no_place_is_shortened() {
        let name = "The tower beyond the old market hall";
        let svg = draw_marks(&[mark(name, 150.0, 100.0)], [300.0, 200.0], [1.0, 1.0], (1.0, 1.0)).0.svg;
        assert!(!svg.contains(name) && svg.contains("The tower b…"), "{svg}");
    }

    #[test]
    fn of_many_marks_those_with_room_have_labels() {
        let uavs = |n: u32| (0..n).map(|k| mark("17", f64::from(k), 5.0)).collect::<Vec<_>>();
        let (drawing, n_labels) = draw_marks(&uavs(100), [1000.0, 100.0], [10.0, 10.0], (1.0, 1.0));
        assert_eq!(drawing.svg.matches(">17<").count(), n_labels);
        assert!((10..100).contains(&n_labels) && !drawing.svg.contains("60 m"), "{n_labels}");
        assert_eq!(draw_marks(&uavs(401), [1000.0, 100.0], [2.0, 10.0], (1.0, 1.0)).1, 0);
    }
}
