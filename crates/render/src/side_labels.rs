//! Labels beside the right ends of curves, spread so that they keep apart.

use super::furniture::{DETAIL, NAME};
use super::lettering::Type;
use super::sheet::Drawing;

/// Distance from the right end of a curve to its label \[px\].
pub(crate) const LEADER: f64 = 78.0;

/// Label beside the right end of a curve.
#[derive(Clone, Debug)]
pub(crate) struct SideLabel {
    /// Vertical place of the end of the curve \[px\].
    pub(crate) y: f64,
    /// Name, and optionally a detail below it; no wider than [`WIDEST`].
    words: Vec<String>,
    /// SVG attributes of the line from the curve to the label.
    pub(crate) stroke: String,
}

/// Text styles of the name and of the detail.
const STYLES: [Type; 2] = [NAME, DETAIL];
/// Widest label \[px\]; wider ones are shortened.
const WIDEST: f64 = 380.0;

impl SideLabel {
    /// Makes a label of a name and optionally a detail below it.
    pub(crate) fn new(y: f64, words: Vec<String>, stroke: String) -> Self {
        let words = words.iter().zip(STYLES).map(|(words, style)| style.shortened(words, WIDEST)).collect();
        SideLabel { y, words, stroke }
    }

    fn height(&self) -> f64 {
        if self.words.len() > 1 { 59.0 } else { 31.0 }
    }

    fn lines(&self) -> impl Iterator<Item = (Type, &String)> {
        STYLES.into_iter().zip(&self.words)
    }

    /// Returns the width of the words \[px\].
    pub(crate) fn width(&self) -> f64 {
        self.lines().map(|(style, words)| style.width(words)).fold(0.0, f64::max)
    }
}

/// Returns the middles of labels from the top down within `height` \[px\]. Each is as near to the
/// end of its curve as it can be without covering another label. Labels come in the order of the
/// ends of their curves.
fn spread(labels: &[SideLabel], height: f64) -> Vec<f64> {
    // Labels that touch form a stack, centered on the mean of their curves' ends, within the plot.
    struct Stack {
        n: usize,
        height: f64,
        wanted: f64,
    }
    let top_of = |s: &Stack| (s.wanted / s.n as f64 - s.height / 2.0).clamp(0.0, (height - s.height).max(0.0));
    let mut stacks: Vec<Stack> = Vec::new();
    for label in labels {
        let mut stack = Stack { n: 1, height: label.height(), wanted: label.y };
        while let Some(above) = stacks.pop_if(|above| top_of(above) + above.height > top_of(&stack)) {
            stack.n += above.n;
            stack.height += above.height;
            stack.wanted += above.wanted;
        }
        stacks.push(stack);
    }
    let mut rest = labels.iter();
    let mut middles = Vec::with_capacity(labels.len());
    for stack in &stacks {
        let mut top = top_of(stack);
        for label in rest.by_ref().take(stack.n) {
            middles.push(top + label.height() / 2.0);
            top += label.height();
        }
    }
    middles
}

/// Draws the labels of a plot of this size \[px\], each with a line from the end of its curve to
/// its name. Labels come in the order of the ends of their curves.
pub(crate) fn beside(labels: &[SideLabel], [right, height]: [f64; 2]) -> Drawing {
    let mut drawing = Drawing::default();
    for (label, middle) in labels.iter().zip(spread(labels, height)) {
        let leader = [[right + 3.0, label.y], [right + 22.0, middle], [right + LEADER - 12.0, middle]];
        drawing.polyline(&leader, &label.stroke);
        let first = middle + if label.words.len() > 1 { -4.0 } else { 8.5 };
        for (k, (style, words)) in label.lines().enumerate() {
            drawing.text(right + LEADER, first + 27.0 * k as f64, style, words);
        }
    }
    drawing
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_keep_apart_and_stay_beside_the_plot() {
        for (n, n_words) in [(2, 2), (8, 2), (12, 2), (24, 1)] {
            let label = |k: usize| {
                let y = if k.is_multiple_of(3) { 0.0 } else { 700.0 };
                SideLabel::new(y, vec!["UAV".to_string(); n_words], String::new())
            };
            let mut labels: Vec<SideLabel> = (0..n).map(label).collect();
            labels.sort_by(|a, b| a.y.total_cmp(&b.y));
            let middles = spread(&labels, 760.0);
            for (k, (middle, label)) in middles.iter().zip(&labels).enumerate() {
                let half = label.height() / 2.0;
                assert!(middle - half >= -1e-9 && middle + half <= 760.0 + 1e-9);
                assert!(k == 0 || middle - half >= middles[k - 1] + half - 1e-9);
            }
        }
    }
}
