//! The picture of a coverage map: title, map, legend, scale bar, north arrow, marks, caption.
//!
//! The legend is below the map, or beside it if the map is narrow. Lengths are constants in pixels
//! because a map has about the same size in every picture, however many cells it has.

use skyshed_core::coverage::Tally;

use super::colors;
use super::furniture::{self, Block, Swatch};
use super::lettering::capitalized;
use super::map_layers::{self, Layer};
use super::map_legend::{self, LegendWords};
use super::marks::{self, MOST_WITH_HEIGHTS, Mark, draw_marks};
use super::page::{MARGIN, Page};
use super::paint::{Canvas, LARGE, RAISED};
use super::sheet::{Drawing, Sheet};
use super::value_range::ValueRange;

/// Least width between the margins, so that titles and captions have room \[px\].
const SMALLEST_BODY: f64 = 900.0;

/// A map to draw. Arrays are `[n_rows, n_cols]`, columns running fastest, north row first.
///
/// Mask classes: 0 NLoS, 1 LoS, 2 not a receiver, 3 out of range, 4
/// [`OPEN_GROUND`](super::OPEN_GROUND), 255 nodata.
#[derive(Clone, Copy, Debug)]
pub struct MapPicture<'a> {
    /// Title, such as `What a UAV sees of Munich`.
    pub title: &'a str,
    /// Lines below the map; long ones are wrapped. The first is set in ink, further ones in gray.
    pub caption: &'a [String],
    /// Columns.
    pub n_cols: usize,
    /// Rows.
    pub n_rows: usize,
    /// Cell size along columns and along rows \[m\]; the picture keeps the proportions of the
    /// ground.
    pub cell_m: (f64, f64),
    /// Layer to show.
    pub layer: Layer<'a>,
    /// Surface heights for gray tones and hillshade of buildings \[m\]; not finite where unknown.
    /// Heights above ground give tones that follow building height, heights above the datum give
    /// tones that follow altitude.
    pub surface_m: Option<&'a [f32]>,
    /// UAVs.
    pub uavs: &'a [Mark<'a>],
    /// True if receivers are in the air; cells over buildings are then darker.
    pub is_in_air: bool,
    /// Name of the receivers, plural, such as `street cells`.
    pub receivers_name: &'a str,
    /// Name of class 2, plural and capitalized, such as `Buildings`.
    pub others_name: &'a str,
    /// Counts for the legend of a mask that is drawn at reduced size; `None` counts the drawn
    /// cells.
    pub counts: Option<Tally>,
}

/// Draws a map.
///
/// Cost: one pass over the cells, in parallel. Memory beyond the input is that of the picture.
///
/// # Errors
/// An empty raster, an array of another length, or a cell size that is not positive.
pub fn draw_map(picture: &MapPicture<'_>) -> Result<Sheet, String> {
    let MapPicture { layer, n_cols, n_rows, cell_m, surface_m, .. } = *picture;
    let canvas = Canvas::new([n_cols, n_rows], cell_m, surface_m, LARGE)?;
    layer.check([n_cols, n_rows])?;
    let range = map_layers::range_of(&[layer]);
    let mut painted = map_layers::painted(layer, &canvas, range.as_ref());
    if picture.is_in_air {
        canvas.darken_raised(&mut painted.image);
    }
    let size = canvas.size();
    let ([map_w, map_h], px_per_cell) = (size, canvas.px_per_cell());
    let (marks, n_labels) = draw_marks(picture.uavs, size, px_per_cell, cell_m);
    let legend = legend(picture, painted.histogram, range.as_ref(), n_labels);
    let orientation = furniture::orientation(px_per_cell[0] / cell_m.0, (0.2 * map_w).clamp(160.0, 320.0));

    let narrow = map_w < 620.0 || map_w < 0.55 * map_h;
    let column = furniture::stack(&[furniture::stack(&legend, 16.0), orientation.clone()], 34.0);
    let body_w = if narrow { map_w + 40.0 + column.width } else { map_w }.max(SMALLEST_BODY).round();
    let mut page = Page::new(picture.title, body_w, 16.0);
    let [left, top] = [MARGIN, (page.bottom - 6.0).round()];

    let furniture = &mut page.furniture;
    furniture::frame(furniture, [left, top], size);
    furniture.place(&cell_borders([n_cols, n_rows], size), left, top);
    furniture.place(&layer.rings(n_cols, px_per_cell), left, top);
    furniture.place(&marks, left, top);
    let bottom = top + map_h;
    page.bottom = if narrow {
        furniture.place(&column.drawing, left + map_w + 40.0, top);
        bottom.max(top + column.height) + 26.0
    } else {
        let legend = furniture::flow(&legend, body_w - orientation.width - 44.0, [38.0, 14.0]);
        furniture.place(&legend.drawing, left, bottom + 24.0);
        furniture.place(&orientation.drawing, left + body_w - orientation.width, bottom + 16.0);
        bottom + (24.0 + legend.height.max(orientation.height) + 24.0)
    };
    page.image([left, top], painted.image);
    Ok(page.finish(0.0, picture.caption))
}

/// Makes the entries of the layer from the number of cells of each color, and one entry for the
/// UAVs, `n_labels` of which have labels.
fn legend(picture: &MapPicture<'_>, of_colors: Vec<u64>, range: Option<&ValueRange>, n_labels: usize) -> Vec<Block> {
    let mut histogram = of_colors;
    let MapPicture { layer, n_cols, n_rows, receivers_name, others_name, .. } = *picture;
    if let (Layer::Los(_), Some(tally)) = (layer, picture.counts) {
        let nlos = tally.receivers - tally.los;
        let nodata = if histogram[4] > 0 { tally.nodata } else { 0 };
        histogram = vec![nlos, tally.los, tally.not_receivers, tally.out_of_range, nodata, 0];
    }
    let are_observers = picture.uavs.iter().all(|uav| uav.is_observer) && picture.is_in_air;
    let (swatch, who) = if are_observers { (Swatch::Observer, "observer") } else { (Swatch::Uav, "UAV") };
    let words = LegendWords { receivers_name, others_name, who, has_counts: true, has_rings: layer.has_rings() };
    let mut legend = map_legend::entries(layer, &histogram, range, picture.surface_m.is_some(), words);
    if picture.is_in_air && picture.surface_m.is_some() {
        let swatch = Swatch::Range(colors::shade(colors::LOS, RAISED), colors::shade(colors::NLOS, RAISED));
        legend.push(furniture::legend_entry(swatch, "Over a building", "darker"));
    }
    let uavs = match picture.uavs {
        [] => None,
        [uav] => {
            let is_named = uav.label.to_lowercase().contains(&who.to_lowercase());
            let name = if is_named { uav.label.to_string() } else { capitalized(&format!("{who} {}", uav.label)) };
            Some((name, marks::detail(uav, [n_cols, n_rows].map(|n| n as f64), picture.cell_m)))
        }
        uavs => Some((
            format!("{} {who}s", uavs.len()),
            match uavs.len() {
                n if n_labels < n => format!("labels of {n_labels} of {n}; the table has all"),
                n => if n > MOST_WITH_HEIGHTS { "id" } else { "id and height" }.to_string(),
            },
        )),
    };
    legend.extend(uavs.map(|(name, detail)| furniture::legend_entry(swatch, &name, &detail)));
    legend
}

/// Draws thin lines between cells if these are large enough to be counted.
fn cell_borders([n_cols, n_rows]: [usize; 2], [w, h]: [f64; 2]) -> Drawing {
    let mut drawing = Drawing::default();
    let cell = (w / n_cols as f64).min(h / n_rows as f64);
    if cell >= 12.0 {
        let width = if cell >= 40.0 { 2.0 } else { 1.0 };
        let stroke = format!("stroke=\"#FFFFFF\" stroke-opacity=\"0.55\" stroke-width=\"{width}\"");
        for col in 1..n_cols {
            let x = (w * col as f64 / n_cols as f64).round();
            drawing.line([x, 0.0], [x, h], &stroke);
        }
        for row in 1..n_rows {
            let y = (h * row as f64 / n_rows as f64).round();
            drawing.line([0.0, y], [w, y], &stroke);
        }
    }
    drawing
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture<'a>(layer: Layer<'a>, n_cols: usize, n_rows: usize) -> MapPicture<'a> {
        MapPicture {
            title: "A test",
            caption: &[],
            n_cols,
            n_rows,
            cell_m: (1.0, 1.0),
            layer,
            surface_m: None,
            uavs: &[],
            is_in_air: false,
            receivers_name: "street cells",
            others_name: "Buildings",
            counts: None,
        }
    }

    #[test]
    fn legends_name_what_occurs_and_nothing_else() {
        let mask = [0, 1, 1, 1];
        let count = |count, n_sites| Layer::Count { count, mask: &mask, n_sites };
        let values = [1.0, 2.0, 3.0, f32::INFINITY];
        for (layer, wanted, unwanted) in [
            (Layer::Los(&[0, 1, 1, 2]), &["66.7\u{202F}% · 2 street cells", "No line", "1 cell<"][..], "Out of range"),
            (Layer::Los(&[3, 255, 3, 3]), &["Out of range", "No data"], "ine of sight"),
            (count(&[0, 1, 2, 3], 3), &["Seen by none", "By 1 UAV", "By 2 UAVs", "By all 3 UAVs"], "No data"),
            (count(&[0, 1, 2, 30], 30), &["UAVs that see a cell (of 30)", "Seen by none"], "By 1 UAV"),
            (Layer::Field { values: &values, name: "Ceiling", unit: "m", mask: &mask }, &["Ceiling [m]"], "No data"),
        ] {
            let svg = draw_map(&picture(layer, 4, 1)).expect("the picture is valid").furniture.svg;
            assert!(wanted.iter().all(|text| svg.contains(text)) && !svg.contains(unwanted), "{wanted:?}: {svg}");
        }
    }

    #[test]
    fn odd_shapes_and_long_words_are_drawn() {
        let title = "A title that goes on and on ".repeat(8);
        let caption = ["x".repeat(3000)];
        for (n_cols, n_rows) in [(1, 1), (1, 500), (500, 1), (7, 3000)] {
            let mask = vec![1; n_cols * n_rows];
            let picture = MapPicture { title: &title, caption: &caption, ..picture(Layer::Los(&mask), n_cols, n_rows) };
            let sheet = draw_map(&picture).expect("the picture is valid");
            assert!(sheet.width >= 980.0 && sheet.width < 2200.0 && sheet.height < 3600.0);
        }
    }
}
