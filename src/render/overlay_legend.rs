//! The legend that lies over a globe beside a coverage overlay.

use super::colors::{LOS, NLOS};
use super::furniture::{Swatch, legend_entry, stack};
use super::picture_form::PictureForm;
use super::sheet::{Drawing, Sheet};

/// Space around the entries and between them \[px\].
const PADDING: f64 = 18.0;

/// Draws what blue and orange mean, as a PNG file on white.
///
/// # Errors
/// A keyword of `provenance` that PNG does not allow.
pub fn draw_overlay_legend(title: &str, provenance: &[(String, String)]) -> Result<Vec<u8>, String> {
    let entries = [
        legend_entry(Swatch::Flat(LOS), "Line of sight", title),
        legend_entry(Swatch::Flat(NLOS), "No line of sight", "Elsewhere: no receiver"),
    ];
    let block = stack(&entries, PADDING);
    let mut furniture = Drawing::default();
    furniture.place(&block.drawing, PADDING, PADDING);
    let sheet = Sheet {
        width: block.width + 2.0 * PADDING,
        height: block.height + 2.0 * PADDING,
        images: Vec::new(),
        furniture,
    };
    sheet.write(&PictureForm::PNG, provenance)
}
