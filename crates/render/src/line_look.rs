//! Looks of lines in plots, which differ with any color vision and on a gray printer.

use super::furniture::stroke;
use super::sheet::Drawing;

/// Colors of lines, distinct with any color vision and dark enough on paper. None is orange, which
/// would mean NLoS.
pub(crate) const COLORS: [&str; 8] =
    ["#0072B2", "#D55E00", "#117733", "#AA4499", "#1B1F24", "#8A7A00", "#2A9D97", "#332288"];

/// Widths of a solid line and of a dashed one \[px\].
const STROKES: [f64; 2] = [4.0, 3.4];
/// Radius of a circle as large as a marker \[px\].
pub(crate) const MARKER: f64 = 8.0;
/// Half the length of the cap of an error bar \[px\].
const CAP: f64 = 9.0;

/// Look of a line in a [`CurveSheet`](super::CurveSheet). Intervals are drawn as a band by looks
/// with a line, as error bars by looks without.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LineLook {
    /// A solid line with filled markers at those of its points that keep apart.
    Solid,
    /// Dashes without markers, such as for a model; each index has its own pattern.
    Dashed,
    /// Hollow markers with error bars at all points and no line, such as for estimates by
    /// simulation.
    Markers,
    /// Filled markers and no line, such as for measurements; some are left out if they would cover
    /// each other.
    Points,
}

/// Patterns of dashed lines: dashes and gaps \[px\]. Patterns eight apart, which lines of one color
/// have, are of different kinds.
const DASHES: [&str; 19] = [
    "14 14",
    "9 14",
    "48 14",
    "20 6 5 6 5 6 5 6",
    "18 8",
    "20 6 5 6",
    "4.5 5.5",
    "20 6 5 6 5 6",
    "32 9",
    "14 5 14 16",
    "26 16",
    "48 8 9 8",
    "34 6 5 6 5 6",
    "4.5 4.5 4.5 13",
    "34 6 14 6",
    "9 6",
    "9 5 9 5 9 15",
    "4.5 11",
    "34 6 5 6",
];

/// Style of a line: everything needed to draw it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LineStyle {
    look: LineLook,
    /// SVG color.
    pub(crate) color: &'static str,
    dash: &'static str,
    /// Corners of the marker in radii; empty for a circle.
    marker: &'static [[f64; 2]],
}

impl LineStyle {
    /// Makes the style with an index: 8 colors, 6 markers and 19 patterns are used in turn.
    pub(crate) fn new(look: LineLook, index: usize) -> Self {
        let dash = if look == LineLook::Dashed { DASHES[index % DASHES.len()] } else { "" };
        Self { look, color: COLORS[index % COLORS.len()], dash, marker: MARKERS[index % MARKERS.len()] }
    }

    /// Returns `true` when points are joined.
    pub(crate) fn has_line(&self) -> bool {
        matches!(self.look, LineLook::Solid | LineLook::Dashed)
    }

    /// Returns `true` when points have markers: some on a solid line, all in looks without a line.
    pub(crate) fn has_markers(&self) -> bool {
        self.look != LineLook::Dashed
    }

    /// Returns the SVG attributes of the line.
    pub(crate) fn stroke(&self) -> String {
        stroke(self.color, STROKES[usize::from(self.look == LineLook::Dashed)], self.dash)
    }

    /// Returns the SVG attributes of the band.
    pub(crate) fn band(&self) -> String {
        format!("fill=\"{}\" fill-opacity=\"0.2\"", self.color)
    }

    /// Draws a marker.
    pub(crate) fn draw_marker(&self, drawing: &mut Drawing, at: [f64; 2]) {
        let attributes = match self.look {
            LineLook::Markers => format!("fill=\"none\" {}", stroke(self.color, 3.0, "")),
            _ => format!("fill=\"{}\" stroke=\"#FFFFFF\" stroke-width=\"1.6\"", self.color),
        };
        if self.marker.is_empty() {
            return drawing.circle(at, MARKER, &attributes);
        }
        let corners: Vec<_> = self.marker.iter().map(|[dx, dy]| [at[0] + MARKER * dx, at[1] + MARKER * dy]).collect();
        drawing.polygon(&corners, &attributes);
    }

    /// Draws an error bar at `x` between `ends`, with caps where `capped` \[px\].
    pub(crate) fn draw_error_bar(&self, drawing: &mut Drawing, x: f64, ends: [f64; 2], capped: [bool; 2]) {
        let attributes = stroke(self.color, 2.4, "");
        drawing.line([x, ends[0]], [x, ends[1]], &attributes);
        for (y, _) in ends.iter().zip(capped).filter(|(_, capped)| *capped) {
            drawing.line([x - CAP, *y], [x + CAP, *y], &attributes);
        }
    }
}

/// Corners of markers about as large as a circle of radius 1, which has none. Six shapes with eight
/// colors, used in turn, make 24 different markers.
const MARKERS: [&[[f64; 2]]; 6] = [
    &[],
    &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
    &[[0.0, -1.35], [1.17, 0.67], [-1.17, 0.67]],
    &[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]],
    &[[0.0, 1.35], [1.17, -0.67], [-1.17, -0.67]],
    &[
        [-0.42, -1.2],
        [0.42, -1.2],
        [0.42, -0.42],
        [1.2, -0.42],
        [1.2, 0.42],
        [0.42, 0.42],
        [0.42, 1.2],
        [-0.42, 1.2],
        [-0.42, 0.42],
        [-1.2, 0.42],
        [-1.2, -0.42],
        [-0.42, -0.42],
    ],
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn lines_differ_in_more_than_color() {
        let patterns: HashSet<&str> =
            (0..DASHES.len()).map(|index| LineStyle::new(LineLook::Dashed, index).dash).collect();
        assert_eq!(patterns.len(), DASHES.len());
        let shape = |index| {
            let mut drawing = Drawing::default();
            LineStyle::new(LineLook::Markers, index).draw_marker(&mut drawing, [0.0, 0.0]);
            drawing.svg
        };
        assert_eq!((0..24).map(shape).collect::<HashSet<_>>().len(), 24);
    }
}
