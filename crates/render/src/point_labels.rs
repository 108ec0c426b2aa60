//! Numbers beside the points of a plot: near them, apart from each other and from other marks.

use super::furniture::{NAME, stroke};
use super::lettering::Type;
use super::line_look::MARKER;
use super::marks::{Bounds, overlap, spots_around, within};
use super::sheet::Drawing;

/// Text style of a number.
const NUMBER: Type = Type { size: 21.0, ..NAME };
/// Largest distance of a label from its point without a line to it \[px\].
const NEAR: f64 = 20.0;
/// Gaps between marks and labels to try, nearest first \[px\].
const GAPS: [f64; 9] = [5.0, 14.0, 30.0, 50.0, 75.0, 105.0, 140.0, 180.0, 230.0];

/// A point that has a number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LabeledPoint {
    /// Place \[px\].
    pub(crate) at: [f64; 2],
    /// Its number.
    pub(crate) number: usize,
    /// Color of its number.
    pub(crate) color: &'static str,
}

/// Label with its place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Label {
    point: LabeledPoint,
    bounds: Bounds,
}

/// Finds a place for each label within a plot of this size \[px\], apart from the boxes in `taken`.
/// A label that finds none is left out; its point has a row beside the plot.
pub(crate) fn place(points: &[LabeledPoint], size: [f64; 2], mut taken: Vec<Bounds>) -> Vec<Label> {
    let plot = [4.0, 4.0, size[0] - 4.0, size[1] - 4.0];
    const REACH: f64 = 1.4 * MARKER;
    taken.extend(points.iter().map(|LabeledPoint { at: [x, y], .. }| [x - REACH, y - REACH, x + REACH, y + REACH]));
    // The most crowded points choose first.
    let crowd = |point: &LabeledPoint| {
        let distance = |other: &LabeledPoint| (other.at[0] - point.at[0]).hypot(other.at[1] - point.at[1]);
        points.iter().map(|other| 1.0 / (30.0 + distance(other))).sum::<f64>()
    };
    let mut order: Vec<&LabeledPoint> = points.iter().collect();
    order.sort_by(|a, b| crowd(b).total_cmp(&crowd(a)));
    let mut labels: Vec<Label> = Vec::new();
    for point in order {
        let box_size = [NUMBER.width(&point.number.to_string()) + 4.0, 1.1 * NUMBER.size];
        let spots = || {
            let corners = GAPS.iter().flat_map(|gap| spots_around(point.at, 1.1 * MARKER + gap, box_size));
            corners.map(|[x, y]| [x, y, x + box_size[0], y + box_size[1]])
        };
        let is_free = |bounds: &Bounds| within(bounds, &plot) && !taken.iter().any(|other| overlap(bounds, other));
        // A line to a label may begin among marks. It crosses other lines or numbers only if there
        // is no better place.
        let crosses = |bounds: &Bounds| {
            let over = |part: &Bounds| labels.iter().any(|other: &Label| overlap(part, &other.bounds));
            leader(point.at, bounds).iter().any(over)
        };
        let spot = spots().find(|bounds| is_free(bounds) && !crosses(bounds)).or_else(|| {
            let is_apart = |bounds: &Bounds| !labels.iter().any(|other| overlap(bounds, &other.bounds));
            spots().find(|bounds| within(bounds, &plot) && is_apart(bounds))
        });
        if let Some(bounds) = spot {
            taken.push(bounds);
            taken.extend(leader(point.at, &bounds));
            labels.push(Label { point: *point, bounds });
        }
    }
    labels
}

/// Returns the end of the line from a point to its label; `None` if the label is near.
fn leader_end([x, y]: [f64; 2], [left, top, right, bottom]: &Bounds) -> Option<[f64; 2]> {
    let nearest = [x.clamp(*left, *right), y.clamp(*top, *bottom)];
    ((nearest[0] - x).hypot(nearest[1] - y) > NEAR).then_some(nearest)
}

/// Returns the boxes that the line from a point to its label covers.
fn leader(at: [f64; 2], bounds: &Bounds) -> Vec<Bounds> {
    leader_end(at, bounds).map_or(Vec::new(), |end| along(at, end).collect())
}

/// Returns small boxes along a line, so that no label lies across it.
pub(crate) fn along(from: [f64; 2], to: [f64; 2]) -> impl Iterator<Item = Bounds> {
    const STEPS: u32 = 60;
    (0..=STEPS).map(move |k| {
        let t = f64::from(k) / f64::from(STEPS);
        let [x, y] = [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])];
        [x - 2.0, y - 2.0, x + 2.0, y + 2.0]
    })
}

/// Draws thin lines from points to labels that are not near them.
pub(crate) fn leaders(drawing: &mut Drawing, labels: &[Label]) {
    for Label { point, bounds } in labels {
        if let Some(end) = leader_end(point.at, bounds) {
            drawing.line(point.at, end, &stroke(point.color, 1.2, ""));
        }
    }
}

/// Draws the numbers.
pub(crate) fn numbers(drawing: &mut Drawing, labels: &[Label]) {
    for Label { point, bounds: [left, top, ..] } in labels {
        let baseline = top + 0.86 * NUMBER.size;
        drawing.text(left + 2.0, baseline, Type { color: point.color, ..NUMBER }, &point.number.to_string());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_of_crowded_points_keep_apart() {
        let point = |k: u32| LabeledPoint {
            at: [400.0 + 9.0 * f64::from(k), 300.0 + f64::from(k % 3)],
            number: k as usize + 1,
            color: "#000000",
        };
        let points: Vec<LabeledPoint> = (0..12).map(point).collect();
        let wall = [0.0, 0.0, 800.0, 200.0];
        let labels = place(&points, [800.0, 600.0], vec![wall]);
        assert_eq!(labels.len(), 12);
        for (k, label) in labels.iter().enumerate() {
            assert!(within(&label.bounds, &[0.0, 0.0, 800.0, 600.0]) && !overlap(&label.bounds, &wall));
            assert!(labels[k + 1..].iter().all(|other| !overlap(&label.bounds, &other.bounds)));
        }
    }
}
