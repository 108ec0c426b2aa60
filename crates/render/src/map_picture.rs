//! The picture of a coverage map: title, map, legend, scale bar, north arrow, marks, caption.
//!
//! The legend stands below the map, or beside it where the map is narrow. Lengths are constants in pixels because a
//! map has about the same size in every picture, however many cells it has.

use super::colors::INK;
use super::furniture::{self, TITLE};
use super::map_layers;
use super::marks::{Mark, draw_marks};
use super::paint;
use super::sheet::{Drawing, Sheet};
use crate::coverage::Tally;

const MARGIN: f64 = 40.0;
const SMALLEST_BODY: f64 = 900.0;

/// A map to draw. Arrays are `[n_rows, n_cols]`, columns running fastest, north row first.
///
/// Mask classes: 0 NLoS, 1 LoS, 2 not a receiver, 3 out of range, 255 nodata.
#[derive(Clone, Copy, Debug)]
pub struct MapPicture<'a> {
    /// Title, such as `What a UAV sees of Munich`.
    pub title: &'a str,
    /// Lines below the map; long ones are wrapped. The first is set in ink, the others in gray.
    pub caption: &'a [String],
    /// Columns.
    pub n_cols: usize,
    /// Rows.
    pub n_rows: usize,
    /// Cell size along columns and along rows \[m\]; the picture keeps the proportions of the ground.
    pub cell_m: (f64, f64),
    /// What to show.
    pub layer: Layer<'a>,
    /// Surface heights for gray tones and hillshade of buildings \[m\]; not finite where unknown. Heights above ground
    /// give tones that follow building height, heights above the datum give tones that follow altitude.
    pub surface_m: Option<&'a [f32]>,
    /// UAVs.
    pub uavs: &'a [Mark<'a>],
    /// What receivers are, in the plural, such as `street cells`.
    pub receivers_name: &'a str,
    /// What class 2 is, in the plural and capitalized, such as `Buildings`.
    pub others_name: &'a str,
    /// The counts that the legend of a mask tells, where it is drawn smaller than it is; else those of what is drawn.
    pub counts: Option<Tally>,
}

/// What a map shows.
#[derive(Clone, Copy, Debug)]
pub enum Layer<'a> {
    /// Line of sight of one UAV: the mask.
    Los(&'a [u8]),
    /// Number of UAVs that see a cell.
    Count {
        /// The number, where the mask is 0 or 1.
        count: &'a [u32],
        /// Classes 2, 3 and 255 apply.
        mask: &'a [u8],
        /// Number of UAVs.
        n_sites: u32,
    },
    /// What each cell is: a palette of classes with their names, and for each cell its place in the palette.
    Classes {
        /// Index into `palette`, where the mask is 0 or 1.
        index: &'a [u8],
        /// Colors, names and the unit of their counts, such as `cells`.
        palette: &'a [MapClass<'a>],
        /// Classes 2, 3 and 255 apply.
        mask: &'a [u8],
    },
    /// How many of eight moves by one lattice step turn the answer.
    Stability {
        /// The number, 0 to 8, where the mask is 0 or 1.
        turns: &'a [f32],
        /// Classes 2, 3 and 255 apply.
        mask: &'a [u8],
    },
    /// A continuous quantity. Where some values are negative and some positive, colors are centered on 0.
    Field {
        /// The values, where the mask is 0 or 1; NaN is drawn as nodata.
        values: &'a [f32],
        /// Its name, such as `Clearance margin`.
        name: &'a str,
        /// Its unit, such as `m`; may be empty.
        unit: &'a str,
        /// Classes 2, 3 and 255 apply.
        mask: &'a [u8],
    },
    /// A quantity of places in the air, over the outlines of the city below.
    Heat {
        /// The values, of any sign; NaN where there is none.
        values: &'a [f32],
        /// Which cells are outlines of buildings, drawn paler.
        outlines: &'a [bool],
        /// Its name, such as `P_LoS`.
        name: &'a str,
        /// Its unit, such as `m`; may be empty.
        unit: &'a str,
        /// What cells without a value are, capitalized.
        none: &'a str,
    },
}

/// A class of a map.
#[derive(Clone, Copy, Debug)]
pub struct MapClass<'a> {
    /// Its name in the legend.
    pub name: &'a str,
    /// More about it; the number of its cells without.
    pub detail: &'a str,
    /// Red, green, blue.
    pub color: [u8; 3],
}

/// Draws a map.
///
/// Cost: one pass over the cells, in parallel. Memory beyond the input is that of the picture.
///
/// # Errors
/// An empty raster, an array of another length, or a cell size that is not positive.
pub fn draw_map(picture: &MapPicture<'_>) -> Result<Sheet, String> {
    check_layer(picture.layer, [picture.n_cols, picture.n_rows], picture.cell_m, picture.surface_m)?;
    let axes = paint::scale(picture.n_cols, picture.n_rows, picture.cell_m);
    let (painted, legend) = map_layers::paint_layer(picture, axes);
    let size = axes.map(|axis| axis.n_px as f64);
    let [map_w, map_h] = size;
    let px_per_cell = [map_w / picture.n_cols as f64, map_h / picture.n_rows as f64];
    let px_per_m = px_per_cell[0] / picture.cell_m.0;
    let scale_bar = furniture::scale_bar(px_per_m, (0.2 * map_w).clamp(160.0, 320.0));
    let orientation = furniture::beside(&[scale_bar, furniture::north_arrow()], 26.0);

    let narrow = map_w < 620.0 || map_w < 0.55 * map_h;
    let column = furniture::stack(&[furniture::stack(&legend, 16.0), orientation.clone()], 34.0);
    let body_w = if narrow { map_w + 40.0 + column.width } else { map_w }.max(SMALLEST_BODY).round();
    let title = furniture::paragraph(picture.title, TITLE, body_w);
    let title_h = if title.height > 0.0 { title.height + 16.0 } else { 0.0 };
    let caption = furniture::caption(picture.caption, body_w);
    let [left, top] = [MARGIN, (MARGIN + title_h - 6.0).round()];

    let mut furniture = Drawing::default();
    furniture.place(&title.drawing, left, MARGIN - 6.0);
    furniture.rect([left - 0.8, top - 0.8, map_w + 1.6, map_h + 1.6], &furniture::frame());
    furniture.place(&cell_borders(picture, size), left, top);
    furniture.place(&rings(picture.layer, picture.n_cols, px_per_cell), left, top);
    furniture.place(&draw_marks(picture.uavs, size, px_per_cell, picture.cell_m), left, top);
    let mut bottom = top + map_h;
    if narrow {
        furniture.place(&column.drawing, left + map_w + 40.0, top);
        bottom = bottom.max(top + column.height) + 26.0;
    } else {
        let legend = furniture::flow(&legend, body_w - orientation.width - 44.0, [38.0, 14.0]);
        furniture.place(&legend.drawing, left, bottom + 24.0);
        furniture.place(&orientation.drawing, left + body_w - orientation.width, bottom + 16.0);
        bottom += 24.0 + legend.height.max(orientation.height) + 24.0;
    }
    if caption.height > 0.0 {
        furniture.line([left, bottom], [left + body_w, bottom], &furniture::hairline());
        furniture.place(&caption.drawing, left, bottom + 14.0);
        bottom += 14.0 + caption.height;
    }
    let place = |length: f64| super::sheet::pixels(length);
    Ok(Sheet {
        width: body_w + 2.0 * MARGIN,
        height: bottom + MARGIN - 8.0,
        images: vec![(place(left), place(top), painted.image)],
        furniture,
    })
}

/// Refuses a layer, cell sizes or a surface that cannot be drawn.
pub(crate) fn check_layer(
    layer: Layer<'_>,
    [n_cols, n_rows]: [usize; 2],
    (cell_x, cell_y): (f64, f64),
    surface_m: Option<&[f32]>,
) -> Result<(), String> {
    let shape = |name: &str, length: usize| super::check_shape(name, length, n_cols, n_rows);
    if ![cell_x, cell_y].iter().all(|c| c.is_finite() && *c > 0.0) {
        return Err(format!("cannot draw a map of cells of {cell_x} × {cell_y} m: both must be above 0 m"));
    }
    match layer {
        Layer::Los(mask) => shape("mask", mask.len())?,
        Layer::Count { count, mask, .. } => {
            shape("count", count.len())?;
            shape("mask", mask.len())?;
        }
        Layer::Classes { index, palette, mask } => {
            shape("index", index.len())?;
            shape("mask", mask.len())?;
            let is_receiver = |class: u8| matches!(class, 0 | 1);
            if index.iter().zip(mask).any(|(k, class)| is_receiver(*class) && usize::from(*k) >= palette.len()) {
                return Err("cannot draw a map of classes: an index is beyond the palette".into());
            }
        }
        Layer::Field { values, mask, .. } | Layer::Stability { turns: values, mask } => {
            shape("values", values.len())?;
            shape("mask", mask.len())?;
        }
        Layer::Heat { values, outlines, .. } => {
            shape("values", values.len())?;
            shape("outlines", outlines.len())?;
        }
    }
    surface_m.map_or(Ok(()), |surface| shape("surface", surface.len()))
}

/// Rings around the few receivers that a move turns.
pub(crate) fn rings(layer: Layer<'_>, n_cols: usize, px_per_cell: [f64; 2]) -> Drawing {
    let mut drawing = Drawing::default();
    let radius = 0.71 * px_per_cell[0].max(px_per_cell[1]) + 8.0;
    for cell in map_layers::ringed(layer) {
        let place = [cell % n_cols, cell / n_cols];
        let [x, y] = [0, 1].map(|k| (place[k] as f64 + 0.5) * px_per_cell[k]);
        drawing.circle([x, y], radius, &format!("fill=\"none\" stroke=\"{INK}\" stroke-width=\"2\""));
    }
    drawing
}

/// Thin lines between cells where these are large enough to be counted.
fn cell_borders(picture: &MapPicture<'_>, [w, h]: [f64; 2]) -> Drawing {
    let mut drawing = Drawing::default();
    let (n_cols, n_rows) = (picture.n_cols, picture.n_rows);
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
    use crate::colors;

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
            receivers_name: "street cells",
            others_name: "Buildings",
            counts: None,
        }
    }

    #[test]
    fn the_pixel_of_a_cell_has_its_class_color() {
        let sheet = draw_map(&picture(Layer::Los(&[0, 1, 2, 3, 255, 1]), 3, 2)).expect("the picture is valid");
        let map = &sheet.images[0].2;
        assert_eq!(map.dimensions(), (960, 640));
        for (x, y, color) in [(100, 100, colors::NLOS), (480, 100, colors::LOS), (800, 500, colors::LOS)] {
            assert_eq!(map.get_pixel(x, y).0[..3], color);
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

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let good = picture(Layer::Los(&[0]), 1, 1);
        for (bad, words) in [
            (picture(Layer::Los(&[0; 5]), 3, 2), "mask has 5"),
            (picture(Layer::Los(&[]), 0, 2), "it is empty"),
            (picture(Layer::Classes { index: &[0], palette: &[], mask: &[1] }, 1, 1), "beyond the palette"),
            (MapPicture { cell_m: (1.0, 0.0), ..good }, "above 0 m"),
            (MapPicture { surface_m: Some(&[1.0; 3]), ..good }, "surface has 3"),
        ] {
            assert!(draw_map(&bad).is_err_and(|e| e.contains(words)), "{words}");
        }
    }
}
