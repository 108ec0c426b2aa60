//! The legend that lies over a globe beside coverage overlays.

use super::colors::{LOS, NLOS};
use super::furniture::{DETAIL, Swatch, legend_entry, paragraph, stack};
use super::picture_form::PictureForm;
use super::sheet::{Drawing, Sheet};

/// Space around the entries and between them \[px\].
const PADDING: f64 = 18.0;
/// Words are wrapped to this width \[px\].
const WIDTH: f64 = 640.0;

/// Draws what blue and orange mean, as a PNG file on white: `uavs` are those that see, `receivers` those that are seen.
///
/// # Errors
/// A keyword of `provenance` that PNG does not allow.
pub fn draw_overlay_legend(uavs: &str, receivers: &str, provenance: &[(String, String)]) -> Result<Vec<u8>, String> {
    compose(uavs, receivers).write(&PictureForm::PNG, provenance)
}

fn compose(uavs: &str, receivers: &str) -> Sheet {
    let block = stack(
        &[
            legend_entry(Swatch::Flat(LOS), "Line of sight", uavs),
            legend_entry(Swatch::Flat(NLOS), "No line of sight", receivers),
            paragraph("No color: no receiver there, out of range, or no data", DETAIL, WIDTH),
        ],
        PADDING,
    );
    let mut furniture = Drawing::default();
    furniture.place(&block.drawing, PADDING, PADDING);
    Sheet { width: block.width + 2.0 * PADDING, height: block.height + 2.0 * PADDING, images: Vec::new(), furniture }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colors::hex;

    #[test]
    fn the_legend_says_what_each_color_of_an_overlay_and_its_absence_mean() {
        let sheet = compose("of UAV 1", "Receivers: street cells, 1.5 m high");
        let svg = sheet.furniture.svg;
        let place = |words: &str| svg.find(words).unwrap_or_else(|| panic!("{words}: {svg}"));
        assert!(place(&hex(LOS)) < place(">Line of sight<") && place(">Line of sight<") < place(&hex(NLOS)));
        assert!(place(&hex(NLOS)) < place(">No line of sight<"));
        for words in ["of UAV 1", "Receivers: street cells, 1.5 m high", "out of range"] {
            assert!(place(words) > 0);
        }
        let text = crate::lettering::width("Receivers: street cells, 1.5 m high", DETAIL.size, DETAIL.weight);
        assert!(sheet.width > text, "nothing is cut off");
    }
}
