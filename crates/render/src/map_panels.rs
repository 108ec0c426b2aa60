//! Maps of several UAVs side by side: one layer of each, with one scale and one legend.

use super::furniture;
use super::map_layers::{self, Layer};
use super::map_legend::{self, LegendWords};
use super::marks::{self, Mark};
use super::paint::add;
use super::sheet::Sheet;
use super::small_maps::Maps;

/// Most maps of a sheet.
pub const MOST_MAP_PANELS: usize = 8;

/// Maps to draw. Arrays are `[n_rows, n_cols]`, columns running fastest, north row first.
#[derive(Clone, Copy, Debug)]
pub struct MapPanels<'a> {
    /// Title.
    pub title: &'a str,
    /// Lines below; long ones are wrapped.
    pub caption: &'a [String],
    /// Columns.
    pub n_cols: usize,
    /// Rows.
    pub n_rows: usize,
    /// Cell size along columns and along rows \[m\].
    pub cell_m: (f64, f64),
    /// Maps, one to [`MOST_MAP_PANELS`]; their layers are of one kind, with one name and palette.
    pub maps: &'a [MapPanel<'a>],
    /// Surface heights for gray tones and hillshade of buildings \[m\]; not finite where unknown.
    pub surface_m: Option<&'a [f32]>,
    /// Name of class 2, plural and capitalized, such as `Buildings`.
    pub others_name: &'a str,
}

/// The map of one UAV.
#[derive(Clone, Copy, Debug)]
pub struct MapPanel<'a> {
    /// Heading, such as `UAV 1 · 60 m above ground`.
    pub title: &'a str,
    /// Line below the heading, such as its P_LoS.
    pub detail: &'a str,
    /// Layer to show.
    pub layer: Layer<'a>,
    /// Mark of the UAV.
    pub mark: Mark<'a>,
}

/// Returns the number of maps in a row, and the target length \[px\] of a map's longer side.
fn arrangement(n_maps: usize) -> (usize, f64) {
    match n_maps {
        1 | 2 => (2, 760.0),
        3 | 5 | 6 => (3, 600.0),
        _ => (4, 520.0),
    }
}

/// Draws maps side by side.
///
/// # Errors
/// No map or too many, an empty raster, an array of another length, or a cell size that is not
/// positive.
pub fn draw_map_panels(sheet: &MapPanels<'_>) -> Result<Sheet, String> {
    let n_maps = sheet.maps.len();
    if !(1..=MOST_MAP_PANELS).contains(&n_maps) {
        return Err(format!("cannot draw {n_maps} maps side by side: there must be 1 to {MOST_MAP_PANELS}"));
    }
    let n_cells = [sheet.n_cols, sheet.n_rows];
    let maps = Maps::new(n_cells, sheet.cell_m, sheet.surface_m, arrangement(n_maps))?;
    let layers: Vec<Layer<'_>> = sheet.maps.iter().map(|map| map.layer).collect();
    layers.iter().try_for_each(|layer| layer.check(n_cells))?;
    let range = map_layers::range_of(&layers);

    let mut histogram: Vec<u64> = Vec::new();
    let panels = sheet.maps.iter().map(|map| {
        let painted = map_layers::painted(map.layer, &maps.canvas, range.as_ref());
        histogram.resize(painted.histogram.len(), 0);
        add(&mut histogram, &painted.histogram);
        let mut panel = maps.panel((map.title, map.detail), painted.image, &[map.mark]);
        panel.over.place(&map.layer.rings(sheet.n_cols, maps.canvas.px_per_cell()), 0.0, 0.0);
        panel
    });
    let panels = panels.collect();
    let has_rings = layers.iter().any(Layer::has_rings);
    let words =
        LegendWords { receivers_name: "", others_name: sheet.others_name, who: "UAV", has_counts: false, has_rings };
    let mut legend = map_legend::entries(layers[0], &histogram, range.as_ref(), sheet.surface_m.is_some(), words);
    let symbols = marks::symbols(sheet.maps.iter().map(|map| map.mark));
    legend.extend(symbols.into_iter().map(|(swatch, name)| furniture::legend_entry(swatch, name, "")));

    let mut page = maps.page(sheet.title);
    maps.place(&mut page, panels);
    Ok(maps.finish(page, |room| furniture::flow(&legend, room, [38.0, 14.0]), sheet.caption))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_share_one_scale_and_one_legend() {
        let mark = Mark { label: "1", height: "60 m above ground", col: 1.0, row: 1.0, is_observer: false };
        let mask = [1, 1, 1, 2];
        let map = |values| {
            let layer = Layer::Field { values, name: "Least receiver height", unit: "m", mask: &mask };
            MapPanel { title: "UAV 1", detail: "P_LoS = 0.5", layer, mark }
        };
        let sheet = draw_map_panels(&MapPanels {
            title: "A test",
            caption: &[],
            n_cols: 2,
            n_rows: 2,
            cell_m: (1.0, 1.0),
            maps: &[map(&[0.0, 1.0, 2.0, f32::NAN]), map(&[90.0, 95.0, 100.0, f32::NAN])],
            surface_m: None,
            others_name: "Buildings",
        });
        let svg = sheet.expect("the maps are valid").furniture.svg;
        // The scale reaches from the least of the first to the most of the second; a scale bar begins at 0, too.
        for (words, n) in [(">Least receiver height [m]<", 1), (">0<", 2), (">100<", 1), (">Buildings<", 1)] {
            assert_eq!(svg.matches(words).count(), n, "{words}: {svg}");
        }
    }
}
