//! Layers that a map can show, and their cells in color.

use super::check;
use super::colors::{self, INK, Ramp, Rgb};
use super::paint::{Canvas, Painted};
use super::sheet::Drawing;
use super::value_range::ValueRange;

/// Layer of a map.
#[derive(Clone, Copy, Debug)]
pub enum Layer<'a> {
    /// Line of sight of one UAV: the mask.
    Los(&'a [u8]),
    /// Number of UAVs that see a cell.
    Count {
        /// The number, where the mask is 0 or 1.
        count: &'a [u32],
        /// Classes 2, 3, 4 and 255 apply.
        mask: &'a [u8],
        /// Number of UAVs.
        n_sites: u32,
    },
    /// Classes of cells: a palette with names, and for each cell its index in the palette.
    Classes {
        /// Index into `palette`, where the mask is 0 or 1.
        index: &'a [u8],
        /// Colors, names and the unit of their counts, such as `cells`.
        palette: &'a [MapClass<'a>],
        /// Classes 2, 3, 4 and 255 apply.
        mask: &'a [u8],
    },
    /// Number of eight moves by one lattice step that change the answer.
    Stability {
        /// The number, 0 to 8, where the mask is 0 or 1.
        turns: &'a [f32],
        /// Classes 2, 3, 4 and 255 apply.
        mask: &'a [u8],
    },
    /// A continuous quantity. Where some values are negative and some positive, colors are centered
    /// on 0.
    Field {
        /// The values, where the mask is 0 or 1; NaN is drawn as nodata.
        values: &'a [f32],
        /// Its name, such as `Clearance margin`.
        name: &'a str,
        /// Its unit, such as `m`; may be empty.
        unit: &'a str,
        /// Classes 2, 3, 4 and 255 apply.
        mask: &'a [u8],
    },
    /// A quantity of places in the air, over the outlines of the city below.
    Heat {
        /// The values, of any sign; NaN where there is none.
        values: &'a [f32],
        /// True for outlines of buildings, which are drawn paler.
        outlines: &'a [bool],
        /// Its name, such as `P_LoS`.
        name: &'a str,
        /// Its unit, such as `m`; may be empty.
        unit: &'a str,
        /// Name of cells without a value, capitalized.
        none: &'a str,
    },
}

/// A class of a map.
#[derive(Clone, Copy, Debug)]
pub struct MapClass<'a> {
    /// Its name in the legend.
    pub name: &'a str,
    /// Detail below the name; if empty, the number of cells.
    pub detail: &'a str,
    /// Red, green, blue.
    pub color: [u8; 3],
}

impl Layer<'_> {
    /// Refuses arrays that do not fit a raster of `n_cells` columns and rows, and indices beyond
    /// the palette.
    pub(crate) fn check(&self, n_cells: [usize; 2]) -> Result<(), String> {
        let shape = |name: &str, length: usize| check::shape(name, length, n_cells);
        match *self {
            Layer::Los(mask) => shape("mask", mask.len()),
            Layer::Count { count, mask, .. } => shape("count", count.len()).and(shape("mask", mask.len())),
            Layer::Classes { index, palette, mask } => {
                shape("index", index.len()).and(shape("mask", mask.len()))?;
                let is_beyond = |(k, class): (&u8, &u8)| *class <= 1 && usize::from(*k) >= palette.len();
                match index.iter().zip(mask).any(is_beyond) {
                    true => Err("cannot draw a map of classes: an index is beyond the palette".into()),
                    false => Ok(()),
                }
            }
            Layer::Field { values, mask, .. } | Layer::Stability { turns: values, mask } => {
                shape("values", values.len()).and(shape("mask", mask.len()))
            }
            Layer::Heat { values, outlines, .. } => {
                shape("values", values.len()).and(shape("outlines", outlines.len()))
            }
        }
    }

    /// Returns the cells whose answer a move changes, if they are so few that they would be
    /// overlooked.
    fn ringed(&self) -> Vec<usize> {
        let Layer::Stability { turns, mask } = self else { return Vec::new() };
        let turned = (0..turns.len()).filter(|&cell| mask[cell] <= 1 && turns[cell] > 0.0);
        let first: Vec<usize> = turned.take(MOST_RINGS + 1).collect();
        if first.len() > MOST_RINGS { Vec::new() } else { first }
    }

    /// Returns `true` when some cells have a ring.
    pub(crate) fn has_rings(&self) -> bool {
        !self.ringed().is_empty()
    }

    /// Draws rings around the few receivers whose answer a move changes.
    pub(crate) fn rings(&self, n_cols: usize, px_per_cell: [f64; 2]) -> Drawing {
        let mut drawing = Drawing::default();
        let radius = 0.71 * px_per_cell[0].max(px_per_cell[1]) + 8.0;
        for cell in self.ringed() {
            let place = [cell % n_cols, cell / n_cols];
            let center = [0, 1].map(|k| (place[k] as f64 + 0.5) * px_per_cell[k]);
            drawing.circle(center, radius, &format!("fill=\"none\" stroke=\"{INK}\" stroke-width=\"2\""));
        }
        drawing
    }
}

/// Most cells with rings; more are not overlooked, and their rings would cover the map.
const MOST_RINGS: usize = 60;
/// Share of white in the outlines of buildings under a field of heat.
const PALE: f64 = 0.5;
/// Number of colors of a field of heat; as many paler ones follow.
pub(crate) const HEAT: u8 = 128;

/// Returns the range of values that the colors of these layers span; `None` for kinds without
/// values.
pub(crate) fn range_of(layers: &[Layer<'_>]) -> Option<ValueRange> {
    let fields: Vec<(&[f32], &[u8])> = layers
        .iter()
        .filter_map(|layer| match *layer {
            Layer::Field { values, mask, .. } => Some((values, mask)),
            _ => None,
        })
        .collect();
    match layers {
        [Layer::Heat { values, .. }] => Some(ValueRange::whole(values)),
        _ => (!fields.is_empty()).then(|| ValueRange::of_receivers(&fields)),
    }
}

/// Returns the colors of a layer, in the order of their indices.
pub(crate) fn palette(layer: Layer<'_>, range: Option<&ValueRange>) -> Vec<Rgb> {
    match layer {
        Layer::Los(_) => vec![colors::NLOS, colors::LOS],
        Layer::Count { n_sites, .. } => colors::count_colors(n_sites),
        Layer::Classes { palette, .. } => palette.iter().map(|class| class.color).collect(),
        Layer::Stability { .. } => colors::TURNS.to_vec(),
        Layer::Field { .. } => range.map_or(Vec::new(), |range| (0..=255).map(|k| range.color(k)).collect()),
        Layer::Heat { .. } => {
            let along = Ramp::Sequential.steps(HEAT);
            let pale = along.iter().map(|color| colors::mix(*color, colors::WHITE, PALE));
            along.iter().copied().chain(pale).collect()
        }
    }
}

/// Paints a layer; without a range, values are painted as nodata.
pub(crate) fn painted(layer: Layer<'_>, canvas: &Canvas<'_>, range: Option<&ValueRange>) -> Painted {
    let colors = palette(layer, range);
    let nodata = colors.len() + 2;
    let index = |value: f32, n: u8| range.and_then(|range| range.index(value, n));
    match layer {
        Layer::Los(mask) => canvas.paint_receivers(&colors, mask, |cell| usize::from(mask[cell])),
        Layer::Count { count, mask, n_sites } => {
            canvas.paint_receivers(&colors, mask, |cell| count[cell].min(n_sites) as usize)
        }
        Layer::Classes { index, mask, .. } => canvas.paint_receivers(&colors, mask, |cell| usize::from(index[cell])),
        Layer::Stability { turns, mask } => {
            canvas.paint_receivers(&colors, mask, |cell| colors::index(f64::from(turns[cell]), 8))
        }
        Layer::Field { values, mask, .. } => {
            canvas.paint_receivers(&colors, mask, |cell| index(values[cell], 255).unwrap_or(nodata))
        }
        Layer::Heat { values, outlines, .. } => canvas.paint(&colors, |cell| match index(values[cell], HEAT - 1) {
            Some(k) if outlines[cell] => k + usize::from(HEAT),
            Some(k) => k,
            None => nodata,
        }),
    }
}
