//! The legend that lies over a globe beside coverage overlays.

use super::colors::{LOS, NLOS};
use super::furniture::{DETAIL, Swatch, legend_entry, paragraph, stack};
use super::sheet::{Drawing, Sheet};

/// Space around the entries and between them \[px\].
const PADDING: f64 = 18.0;
/// Words are wrapped to this width \[px\].
const WIDTH: f64 = 640.0;

/// Draws what blue and orange mean: `uavs` are those that see, `receivers` those that are seen.
pub fn draw_overlay_legend(uavs: &str, receivers: &str) -> Sheet {
    let entries = [
        legend_entry(Swatch::Flat(LOS), "Line of sight", uavs),
        legend_entry(Swatch::Flat(NLOS), "No line of sight", receivers),
        paragraph("No color: no receiver there, out of range, or no data", DETAIL, WIDTH),
    ];
    let block = stack(&entries, PADDING);
    let mut furniture = Drawing::default();
    furniture.place(&block.drawing, PADDING, PADDING);
    Sheet { width: block.width + 2.0 * PADDING, height: block.height + 2.0 * PADDING, images: Vec::new(), furniture }
}
