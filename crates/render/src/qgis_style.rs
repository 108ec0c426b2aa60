//! The style of a raster for QGIS: a `.qml` file, which QGIS applies to the raster of the same name
//! beside it.
//!
//! Without a style QGIS takes the first three bands of any raster for red, green and blue. A style
//! shows the first band alone, in the colors of the program's own pictures.

use std::fmt::Write as _;

use super::colors::{self, LOS, NLOS, Ramp, Rgb};
use super::value_range::ValueRange;

/// Number of UAVs from which counts are drawn as a ramp, not as classes.
const MOST_CLASSES: u32 = 12;

/// Content of the first band of a raster.
#[derive(Clone, Copy, Debug)]
pub enum FirstBand<'a> {
    /// Classes of a mask.
    Mask,
    /// Number of UAVs that see a cell, of this many.
    Count(u32),
    /// Nearest UAV that sees a cell, by its number from 1 to this many; 0 for none.
    BestServer(u32),
    /// Number of eight moves that change the answer.
    Stability,
    /// Line of sight: 0 never, 1 surely, 2 possibly.
    Sure,
    /// Classes of a difference of two masks: 0 neither, 1 only the first, 2 only the second, 3
    /// both.
    Difference,
    /// Heights or other values; NaN and values of -9999 are none.
    Values(&'a [f32]),
}

/// Returns the text of the style for a raster with this first band.
pub fn qgis_style(band: FirstBand<'_>) -> String {
    let classes = |named: &[(&str, Rgb)]| {
        let class = |(value, (name, color)): (usize, &(&str, Rgb))| (value as f64, (*name).to_string(), *color);
        paletted(&named.iter().enumerate().map(class).collect::<Vec<_>>())
    };
    let none_then = |first: &str, colors: Vec<Rgb>| {
        let entry = |(value, color): (usize, Rgb)| {
            let label = if value == 0 { first.to_string() } else { value.to_string() };
            (value as f64, label, color)
        };
        colors.into_iter().enumerate().map(entry).collect::<Vec<_>>()
    };
    match band {
        FirstBand::Mask => classes(&[
            ("NLoS", NLOS),
            ("LoS", LOS),
            ("not a receiver", colors::BUILDING),
            ("out of range", colors::OUT_OF_RANGE),
        ]),
        FirstBand::Sure => {
            let [never, surely, possibly] = colors::SURE_COLORS;
            classes(&[("never", never), ("surely", surely), ("possibly", possibly)])
        }
        FirstBand::Difference => {
            let [neither, first, second, both] = colors::PAIR;
            classes(&[("neither", neither), ("only the first", first), ("only the second", second), ("both", both)])
        }
        FirstBand::Stability => paletted(&none_then("0", colors::TURNS.to_vec())),
        FirstBand::Count(n) if n < MOST_CLASSES => paletted(&none_then("none", colors::count_colors(n))),
        FirstBand::Count(n) => ramp(&none_then("none", colors::count_colors(n))),
        FirstBand::BestServer(n) => {
            let numbers = (0..n).map(|k| Ramp::Sequential.at(f64::from(k) / f64::from(n.max(2) - 1)));
            let entries = none_then("none", std::iter::once(NLOS).chain(numbers).collect());
            if n < MOST_CLASSES { paletted(&entries) } else { ramp(&entries) }
        }
        FirstBand::Values(values) => {
            // Some thousands are enough to find the middle 98 %.
            let step = (values.len() / 16_384).max(1) | 1;
            let known: Vec<f32> = values.iter().step_by(step).copied().filter(|v| *v > -9999.0).collect();
            let everywhere = vec![0_u8; known.len()];
            let range = ValueRange::of_receivers(&[(&known, &everywhere)]);
            let entry = |k: u8| {
                let value = range.scale.low + (range.scale.high - range.scale.low) * f64::from(k) / 16.0;
                (value, format!("{value:.4}"), range.color(k.saturating_mul(16)))
            };
            ramp(&(0..=16).map(entry).collect::<Vec<_>>())
        }
    }
}

/// Writes a style of single values, each with its label.
fn paletted(entries: &[(f64, String, Rgb)]) -> String {
    let mut list = String::from("      <colorPalette>\n");
    for (value, label, color) in entries {
        let color = colors::hex(*color);
        let _ = writeln!(
            list,
            "        <paletteEntry value=\"{value}\" color=\"{color}\" label=\"{label}\" alpha=\"255\"/>"
        );
    }
    list += "      </colorPalette>\n";
    style("type=\"paletted\"", &list)
}

/// Writes a style of colors that change steadily between values.
fn ramp(entries: &[(f64, String, Rgb)]) -> String {
    let (low, high) = (entries.first().map_or(0.0, |e| e.0), entries.last().map_or(1.0, |e| e.0));
    let mut list = format!(
        "      <rastershader>\n        <colorrampshader colorRampType=\"INTERPOLATED\" classificationMode=\"1\" clip=\"0\" \
         minimumValue=\"{low}\" maximumValue=\"{high}\">\n"
    );
    for (value, label, color) in entries {
        let color = colors::hex(*color);
        let _ = writeln!(list, "          <item value=\"{value}\" color=\"{color}\" label=\"{label}\" alpha=\"255\"/>");
    }
    list += "        </colorrampshader>\n      </rastershader>\n";
    style(&format!("type=\"singlebandpseudocolor\" classificationMin=\"{low}\" classificationMax=\"{high}\""), &list)
}

fn style(attributes: &str, inner: &str) -> String {
    format!(
        "<!DOCTYPE qgis PUBLIC 'http://mrcc.com/qgis.dtd' 'SYSTEM'>\n<qgis version=\"3.22\" styleCategories=\"Symbology\">\n  <pipe>\n    \
         <rasterrenderer {attributes} band=\"1\" opacity=\"1\" alphaBand=\"-1\">\n{inner}    </rasterrenderer>\n  </pipe>\n</qgis>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_style_lists_the_classes_of_its_band() {
        for (band, n) in [
            (FirstBand::Mask, 4),
            (FirstBand::Sure, 3),
            (FirstBand::Difference, 4),
            (FirstBand::Stability, 9),
            (FirstBand::Count(3), 4),
            (FirstBand::BestServer(2), 3),
        ] {
            assert_eq!(qgis_style(band).matches("<paletteEntry").count(), n, "{band:?}");
        }
        let heights = qgis_style(FirstBand::Values(&[f32::NAN, -9999.0, 2.0, 8.0]));
        assert!(heights.contains("minimumValue=\"2\" maximumValue=\"8\""), "{heights}");
        assert!(qgis_style(FirstBand::Count(40)).contains("<item value=\"40\""));
    }
}
