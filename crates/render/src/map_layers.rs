//! What a map shows, as a palette and a legend: classes, counts, or a continuous field.

use super::colors::{self, Ramp, Rgb};
use super::furniture::{self, Block, Scale, Swatch};
use super::lettering::{grouped, number, percent};
use super::map_picture::{Layer, MapPicture};
use super::marks;
use super::paint::{self, Axis, Cells, Paint, Painted};

/// More UAVs than this share a color bar instead of legend entries.
const MOST_COUNT_ENTRIES: u32 = 6;

/// The special classes at the end of every palette.
const SPECIAL: [Paint; 3] = [Paint::Building, Paint::OutOfRange, Paint::Void];

/// Returns the offset of a special class behind `n` colors, or nothing for a receiver.
pub(crate) fn special(class: u8, n: usize) -> Option<usize> {
    match class {
        0 | 1 => None,
        2 => Some(n),
        3 => Some(n + 1),
        _ => Some(n + 2),
    }
}

/// Paints the layer of a picture and makes the entries of its legend.
pub(crate) fn paint_layer(picture: &MapPicture<'_>, axes: [Axis; 2]) -> (Painted, Vec<Block>) {
    let backing = Backing { axes, cell_m: picture.cell_m, surface_m: picture.surface_m };
    let range = Range::of(&[picture.layer]);
    let mut painted = painted(picture.layer, &backing, &range);
    if let (Layer::Los(_), Some(tally)) = (picture.layer, picture.counts) {
        let nlos = tally.receivers - tally.los;
        painted.histogram = vec![nlos, tally.los, tally.not_receivers, tally.out_of_range, tally.nodata];
    }
    let words = LegendWords {
        receivers_name: picture.receivers_name,
        others_name: picture.others_name,
        has_counts: true,
        has_rings: !ringed(picture.layer).is_empty(),
    };
    let mut legend = entries(picture.layer, &painted.histogram, (&backing, &range), words);
    match picture.uavs {
        [] => {}
        [uav] => {
            let detail = marks::detail(uav, [picture.n_cols as f64, picture.n_rows as f64], picture.cell_m);
            legend.push(furniture::legend_entry(Swatch::Uav, &uav_name(uav.label), &detail));
        }
        uavs => legend.push(furniture::legend_entry(Swatch::Uav, &format!("{} UAVs", uavs.len()), "id and height")),
    }
    (painted, legend)
}

/// The values that the colors of a layer span, or of several on one scale.
#[derive(Debug)]
pub(crate) enum Range {
    /// Of classes.
    None,
    /// Of a continuous quantity of receivers.
    Field(Field),
    /// Of a quantity of places in the air.
    Heat(Scale),
}

impl Range {
    /// The common range of layers of one kind.
    pub(crate) fn of(layers: &[Layer<'_>]) -> Self {
        let fields: Vec<(&[f32], &[u8])> = layers
            .iter()
            .filter_map(|layer| match *layer {
                Layer::Field { values, mask, .. } => Some((values, mask)),
                _ => None,
            })
            .collect();
        match layers {
            _ if !fields.is_empty() => Range::Field(Field::new(&fields)),
            [Layer::Heat { values, .. }] => Range::Heat(heat_scale(values)),
            _ => Range::None,
        }
    }
}

/// The colors of a layer, in the order of their indices.
fn palette(layer: Layer<'_>, range: &Range) -> Vec<Rgb> {
    match (layer, range) {
        (Layer::Los(_), _) => vec![colors::NLOS, colors::LOS],
        (Layer::Count { n_sites, .. }, _) => (0..=n_sites).map(|k| colors::count_color(k, n_sites)).collect(),
        (Layer::Classes { palette, .. }, _) => palette.iter().map(|class| class.color).collect(),
        (Layer::Stability { .. }, _) => colors::TURNS.to_vec(),
        (Layer::Field { .. }, Range::Field(field)) => (0..=255).map(|k| field.color(k)).collect(),
        (Layer::Field { .. } | Layer::Heat { .. }, _) => {
            let along = heat_colors();
            let pale = along.iter().map(|color| colors::mix(*color, colors::WHITE, PALE));
            along.iter().copied().chain(pale).collect()
        }
    }
}

fn heat_colors() -> Vec<Rgb> {
    (0..128).map(|k| Ramp::Sequential.at(f64::from(k) / 127.0)).collect()
}

/// Paints a layer.
pub(crate) fn painted(layer: Layer<'_>, backing: &Backing<'_>, range: &Range) -> Painted {
    let colors = palette(layer, range);
    let n = colors.len();
    match (layer, range) {
        (Layer::Los(mask), _) => {
            paint_flat(backing, &colors, |cell| special(mask[cell], n).unwrap_or(usize::from(mask[cell])))
        }
        (Layer::Count { count, mask, n_sites }, _) => {
            paint_flat(backing, &colors, |cell| special(mask[cell], n).unwrap_or(count[cell].min(n_sites) as usize))
        }
        (Layer::Classes { index, mask, .. }, _) => {
            paint_flat(backing, &colors, |cell| special(mask[cell], n).unwrap_or(usize::from(index[cell])))
        }
        (Layer::Stability { turns, mask }, _) => paint_flat(backing, &colors, |cell| {
            special(mask[cell], n).unwrap_or_else(|| colors::index(f64::from(turns[cell]), 8))
        }),
        (Layer::Field { values, mask, .. }, Range::Field(field)) => paint_flat(backing, &colors, |cell| {
            special(mask[cell], n).unwrap_or_else(|| field.index(values[cell]).unwrap_or(n + 2))
        }),
        (Layer::Heat { values, outlines, .. }, Range::Heat(scale)) => paint_flat(backing, &colors, |cell| {
            if values[cell].is_nan() {
                return n + 2;
            }
            let t = (f64::from(values[cell]) - scale.low) / (scale.high - scale.low);
            colors::index(t * 127.0 + 0.5, 127) + if outlines[cell] { 128 } else { 0 }
        }),
        // Without a range there is no value.
        (Layer::Field { .. } | Layer::Heat { .. }, _) => paint_flat(backing, &colors, |_| n + 2),
    }
}

/// What a legend says beside colors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LegendWords<'a> {
    /// What receivers are, in the plural.
    pub(crate) receivers_name: &'a str,
    /// What class 2 is, in the plural and capitalized.
    pub(crate) others_name: &'a str,
    /// Whether cells are counted.
    pub(crate) has_counts: bool,
    /// Whether the few cells that a move turns have rings.
    pub(crate) has_rings: bool,
}

/// The entries of the legend of a layer of which so many cells have each color.
pub(crate) fn entries(
    layer: Layer<'_>,
    histogram: &[u64],
    (backing, range): (&Backing<'_>, &Range),
    words: LegendWords<'_>,
) -> Vec<Block> {
    let colors = palette(layer, range);
    let (of_colors, of_special) = histogram.split_at(histogram.len() - SPECIAL.len());
    let receivers: u64 = of_colors.iter().sum();
    let flat = |color: Rgb, name: &str, detail: String| {
        furniture::legend_entry(Swatch::Flat(color), name, if words.has_counts { &detail } else { "" })
    };
    let share = |n: u64| format!("{} · {}", percent(n, receivers), grouped(n));
    let mut legend = Vec::new();
    match (layer, range) {
        (Layer::Los(_), _) => {
            for (n, color, name) in
                [(of_colors[1], colors::LOS, "Line of sight"), (of_colors[0], colors::NLOS, "No line of sight")]
            {
                if n > 0 {
                    let receivers_name = match words.receivers_name.strip_suffix('s') {
                        Some(singular) if n == 1 => singular,
                        _ => words.receivers_name,
                    };
                    legend.push(flat(color, name, format!("{} {receivers_name}", share(n))));
                }
            }
        }
        (Layer::Count { n_sites, .. }, _) => legend.extend(count_legend(n_sites, &colors, histogram)),
        (Layer::Classes { palette, .. }, _) => {
            for (class, n) in palette.iter().zip(of_colors).filter(|(_, n)| **n > 0) {
                let counted = format!("{} {}", grouped(*n), if *n == 1 { "cell" } else { "cells" });
                let detail = if class.detail.is_empty() { counted } else { class.detail.to_string() };
                legend.push(flat(class.color, class.name, detail));
            }
        }
        (Layer::Stability { .. }, _) => {
            for (k, (color, n)) in colors.iter().zip(of_colors).enumerate().filter(|(_, (_, n))| **n > 0) {
                let name = match k {
                    0 => "Stable".to_string(),
                    1 => "1 of 8 moves turns it".to_string(),
                    k => format!("{k} of 8 moves turn it"),
                };
                let ringed = if k > 0 && words.has_rings { " · ringed" } else { "" };
                legend.push(flat(*color, &name, format!("{}{ringed}", share(*n))));
            }
        }
        (Layer::Field { name, unit, .. }, Range::Field(field)) if receivers > 0 => {
            if field.flat_above_zero {
                let detail = format!("{} · 0 {unit} or more", percent(of_colors[255], receivers));
                legend.push(flat(colors::LOS, "Line of sight", detail));
            }
            let shown = if field.flat_above_zero { 255 } else { 256 };
            let along: Vec<Rgb> = colors[..shown].iter().step_by(2).copied().collect();
            legend.push(furniture::color_bar(&with_unit(name, unit), field.scale, &along, 460.0));
        }
        (Layer::Heat { name, unit, .. }, Range::Heat(scale)) if receivers > 0 => {
            legend.push(furniture::color_bar(&with_unit(name, unit), *scale, &heat_colors(), 460.0));
        }
        _ => {}
    }
    for (swatch, name, n) in special_legend(of_special, words.others_name, backing) {
        let (name, detail) = match (layer, swatch) {
            (Layer::Heat { none, .. }, Swatch::Hatched) => (none, String::new()),
            // Cells of the city are no measure of places in the air.
            (Layer::Heat { .. }, _) => (name.as_str(), String::new()),
            _ if !words.has_counts => (name.as_str(), String::new()),
            _ => (name.as_str(), format!("{} {}", grouped(n), if n == 1 { "cell" } else { "cells" })),
        };
        legend.push(furniture::legend_entry(swatch, name, &detail));
    }
    legend
}

fn with_unit(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_string() } else { format!("{name} [{unit}]") }
}

/// More cells than this are not overlooked, and their rings would cover the map.
const MOST_RINGS: usize = 60;

/// The cells that a move turns, where they are so few that they would be overlooked.
pub(crate) fn ringed(layer: Layer<'_>) -> Vec<usize> {
    let Layer::Stability { turns, mask } = layer else { return Vec::new() };
    let turned = (0..turns.len()).filter(|&cell| special(mask[cell], 0).is_none() && turns[cell] > 0.0);
    let first: Vec<usize> = turned.take(MOST_RINGS + 1).collect();
    if first.len() > MOST_RINGS { Vec::new() } else { first }
}

/// How much white the outlines of buildings have under a field of heat.
const PALE: f64 = 0.5;

/// The whole range of the values.
fn heat_scale(values: &[f32]) -> Scale {
    let (low, high) = paint::quantiles(values.to_vec(), 0.0, 1.0).unwrap_or((0.0, 1.0));
    let (low, high) = if high - low < 1e-6 * (1.0 + high.abs()) { (low - 0.5, high + 0.5) } else { (low, high) };
    Scale { low, high, open_low: false, open_high: false }
}

fn uav_name(label: &str) -> String {
    if label.to_lowercase().contains("uav") { label.to_string() } else { format!("UAV {label}").trim_end().to_string() }
}

/// What is the same in all maps of one scene: where cells go, and the surface below them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Backing<'a> {
    /// Columns and rows.
    pub(crate) axes: [Axis; 2],
    /// Cell size \[m\] along columns and rows.
    pub(crate) cell_m: (f64, f64),
    /// Surface heights \[m\].
    pub(crate) surface_m: Option<&'a [f32]>,
}

/// Paints cells in flat colors; indices from [`special`] follow behind the colors.
pub(crate) fn paint_flat(backing: &Backing<'_>, colors: &[Rgb], index_of: impl Fn(usize) -> usize + Sync) -> Painted {
    let palette: Vec<Paint> = colors.iter().map(|&color| Paint::Flat(color)).chain(SPECIAL).collect();
    let Backing { axes, cell_m, surface_m } = *backing;
    paint::paint(&Cells { axes, cell_m, index_of, palette: &palette, surface_m })
}

/// The special classes that occur, from their numbers of cells: swatch, name, number.
pub(crate) fn special_legend(numbers: &[u64], others_name: &str, backing: &Backing<'_>) -> Vec<(Swatch, String, u64)> {
    let tones = [Ramp::BuildingTone.at(0.0), Ramp::BuildingTone.at(1.0)];
    let building =
        if backing.surface_m.is_some() { Swatch::Range(tones[0], tones[1]) } else { Swatch::Flat(colors::BUILDING) };
    let special =
        [(building, others_name), (Swatch::Flat(colors::OUT_OF_RANGE), "Out of range"), (Swatch::Hatched, "No data")];
    let named = special.into_iter().zip(numbers).map(|((swatch, name), &n)| (swatch, name.to_string(), n));
    named.filter(|(_, _, n)| *n > 0).collect()
}

/// Entries for the numbers of UAVs that occur; a color bar for many UAVs.
pub(crate) fn count_legend(n_sites: u32, palette: &[Rgb], histogram: &[u64]) -> Vec<Block> {
    let receivers: u64 = histogram[..palette.len()].iter().sum();
    let entry = |k: u32, name: &str| {
        let n = histogram[k as usize];
        let detail = format!("{} · {}", percent(n, receivers), grouped(n));
        (n > 0).then(|| furniture::legend_entry(Swatch::Flat(palette[k as usize]), name, &detail))
    };
    let none = entry(0, "Seen by none");
    if n_sites <= MOST_COUNT_ENTRIES {
        let name = |k: u32| match k {
            1 if n_sites == 1 => "Seen by the UAV".to_string(),
            1 => "By 1 UAV".to_string(),
            2 if n_sites == 2 => "By both UAVs".to_string(),
            k if k == n_sites => format!("By all {k} UAVs"),
            k => format!("By {k} UAVs"),
        };
        return none.into_iter().chain((1..=n_sites).filter_map(|k| entry(k, &name(k)))).collect();
    }
    let scale = Scale { low: 1.0, high: f64::from(n_sites), open_low: false, open_high: false };
    let along: Vec<Rgb> = (0..64).map(|k| Ramp::Seen.at(f64::from(k) / 63.0)).collect();
    let title = format!("UAVs that see a cell (of {})", number(f64::from(n_sites), 0));
    std::iter::once(furniture::color_bar(&title, scale, &along, 420.0)).chain(none).collect()
}

/// How values become colors.
#[derive(Debug)]
pub(crate) struct Field {
    ramp: Ramp,
    scale: Scale,
    /// Positive values are few and small beside the negative ones, as margins are: they share one color.
    flat_above_zero: bool,
}

/// A positive side smaller than this share of the negative one is not worth half of a ramp.
const SMALL_SIDE: f64 = 0.1;

impl Field {
    /// Spans the middle 98 % of the receivers' values in all maps, from a sample of at most about a million.
    fn new(maps: &[(&[f32], &[u8])]) -> Self {
        let n: usize = maps.iter().map(|(values, _)| values.len()).sum();
        let step = (n / 1_000_000).max(1) | 1;
        let sample = values_of(maps, step);
        let infinite = [f32::NEG_INFINITY, f32::INFINITY].map(|end| sample.iter().any(|v| v.total_cmp(&end).is_eq()));
        let (least, most) = paint::quantiles(sample.clone(), 0.0, 1.0).unwrap_or((0.0, 1.0));
        let (mut low, mut high) = paint::quantiles(sample, 0.01, 0.99).unwrap_or((0.0, 1.0));
        let signed = least < 0.0 && most > 0.0;
        let flat_above_zero = signed && high <= -low * SMALL_SIDE;
        if flat_above_zero {
            high = 0.0;
        } else if signed {
            high = low.abs().max(high.abs());
            low = -high;
        } else if let Some((_, most_are_below)) = paint::quantiles(values_of(maps, step), 0.0, 0.9) {
            // A few cells beside walls ask for heights that would leave the others one color.
            high = if high > 3.0 * most_are_below.abs() { most_are_below } else { high };
        }
        if high - low < 1e-6 * (1.0 + high.abs()) {
            (low, high) = (low - 0.5, high + 0.5);
        }
        let slack = 1e-9 * (high - low);
        let scale = Scale {
            low,
            high,
            open_low: infinite[0] || least < low - slack,
            open_high: !flat_above_zero && (infinite[1] || most > high + slack),
        };
        Self { ramp: if signed { Ramp::Diverging } else { Ramp::Sequential }, scale, flat_above_zero }
    }

    /// One of the 256 colors.
    fn color(&self, k: u8) -> Rgb {
        let t = f64::from(k) / 255.0;
        match (self.flat_above_zero, k) {
            (false, _) => self.ramp.at(t),
            (true, 255) => colors::LOS,
            // The orange half, short of the white in the middle.
            (true, _) => self.ramp.at(0.46 * t),
        }
    }

    fn index(&self, value: f32) -> Option<usize> {
        if self.flat_above_zero && value >= 0.0 {
            return Some(255);
        }
        let last = if self.flat_above_zero { 254 } else { 255 };
        let t = (f64::from(value) - self.scale.low) / (self.scale.high - self.scale.low);
        (!value.is_nan()).then(|| colors::index(t * last as f64 + 0.5, last))
    }
}

/// The receivers' values, every `step`th cell of each map.
fn values_of(maps: &[(&[f32], &[u8])], step: usize) -> Vec<f32> {
    let of_map = |(values, mask): &(&[f32], &[u8])| -> Vec<f32> {
        (0..values.len()).step_by(step).filter(|&cell| mask[cell] <= 1).map(|cell| values[cell]).collect()
    };
    maps.iter().flat_map(of_map).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn margins_keep_one_color_for_line_of_sight_and_the_ramp_for_what_is_missing() {
        let mask = [1_u8; 6];
        let field = Field::new(&[(&[-80.0, -60.0, -40.0, -20.0, 0.0, 1.5], &mask)]);
        assert!(field.flat_above_zero);
        assert_eq!((field.index(0.0), field.index(1.5)), (Some(255), Some(255)));
        assert!(field.index(-0.1).is_some_and(|k| k < 255));
        assert_eq!(field.color(255), colors::LOS);
    }

    #[test]
    fn signed_fields_are_centered_on_zero_and_unsigned_are_not() {
        let mask = [1_u8; 4];
        let field = Field::new(&[(&[-2.0, 0.0, 1.0, f32::NAN], &mask)]);
        assert_eq!((field.ramp, field.index(0.0)), (Ramp::Diverging, Some(128)));
        assert!((field.scale.low + field.scale.high).abs() < 1e-12);
        assert_eq!(field.index(f32::NAN), None);
        assert_eq!(Field::new(&[(&[1.0, 2.0, 3.0, 4.0], &mask)]).ramp, Ramp::Sequential);
    }
}
