//! Legend entries of a map: classes that occur, color bars, and cells that are no receivers.

use super::colors::{self, Ramp, Rgb};
use super::furniture::{self, Block, DETAIL, Scale, Swatch};
use super::lettering::{capitalized, grouped, percent};
use super::map_layers::{self, HEAT, Layer, MapClass};
use super::sheet::{Drawing, Sheet};
use super::value_range::ValueRange;

/// Space around and between the entries of the legend of an overlay \[px\].
const PADDING: f64 = 18.0;
/// Most UAVs whose counts have entries of their own; counts of more share a color bar.
const MOST_COUNT_ENTRIES: u32 = 6;

/// Words and options of a legend.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LegendWords<'a> {
    /// Name of the receivers, plural.
    pub(crate) receivers_name: &'a str,
    /// Name of class 2, plural and capitalized.
    pub(crate) others_name: &'a str,
    /// Name of a viewer, singular: `UAV` or `observer`.
    pub(crate) who: &'a str,
    /// True if cells are counted.
    pub(crate) has_counts: bool,
    /// True if the few cells whose answer a move changes have rings.
    pub(crate) has_rings: bool,
}

/// Draws the legend that lies over a globe beside coverage overlays. `uavs` is the detail of line
/// of sight, `receivers` that of none.
pub fn draw_overlay_legend(uavs: &str, receivers: &str) -> Sheet {
    let entries = [
        furniture::legend_entry(Swatch::Flat(colors::LOS), "Line of sight", uavs),
        furniture::legend_entry(Swatch::Flat(colors::NLOS), "No line of sight", receivers),
        furniture::paragraph("No color: no receiver there, out of range, or no data", DETAIL, 640.0),
    ];
    let block = furniture::stack(&entries, PADDING);
    let mut furniture = Drawing::default();
    furniture.place(&block.drawing, PADDING, PADDING);
    Sheet { width: block.width + 2.0 * PADDING, height: block.height + 2.0 * PADDING, images: Vec::new(), furniture }
}

/// Makes the legend entries of a layer from the number of cells of each color.
pub(crate) fn entries(
    layer: Layer<'_>,
    histogram: &[u64],
    range: Option<&ValueRange>,
    has_surface: bool,
    words: LegendWords<'_>,
) -> Vec<Block> {
    let colors = map_layers::palette(layer, range);
    let (of_colors, of_special) = histogram.split_at(colors.len());
    let receivers: u64 = of_colors.iter().sum();
    let share = |n: u64| share(n, receivers);
    let flat = |color: Rgb, name: &str, detail: String| {
        furniture::legend_entry(Swatch::Flat(color), name, if words.has_counts { &detail } else { "" })
    };
    let bar_range = range.filter(|_| receivers > 0);
    let mut legend: Vec<Block> = match layer {
        Layer::Los(_) => {
            let entry = |(k, name): (usize, &str)| {
                let receivers_name = match words.receivers_name.strip_suffix('s') {
                    Some(singular) if of_colors[k] == 1 => singular,
                    _ => words.receivers_name,
                };
                let detail = format!("{} {receivers_name}", share(of_colors[k]));
                (of_colors[k] > 0).then(|| flat(colors[k], name, detail))
            };
            [(1, "Line of sight"), (0, "No line of sight")].into_iter().filter_map(entry).collect()
        }
        Layer::Count { n_sites, .. } => count_legend(words.who, n_sites, &colors, histogram),
        Layer::Classes { palette, .. } => {
            let entry = |(class, n): (&MapClass<'_>, &u64)| {
                let detail = if class.detail.is_empty() { cells(*n) } else { class.detail.to_string() };
                flat(class.color, class.name, detail)
            };
            palette.iter().zip(of_colors).filter(|(_, n)| **n > 0).map(entry).collect()
        }
        Layer::Stability { .. } => {
            let entry = |k: usize| {
                let name = match k {
                    0 => "Stable".to_string(),
                    1 => "1 of 8 moves turns it".to_string(),
                    k => format!("{k} of 8 moves turn it"),
                };
                let ringed = if k > 0 && words.has_rings { " · ringed" } else { "" };
                flat(colors[k], &name, format!("{}{ringed}", share(of_colors[k])))
            };
            (0..colors.len()).filter(|k| of_colors[*k] > 0).map(entry).collect()
        }
        Layer::Field { name, unit, .. } => bar_range.map_or(Vec::new(), |range| {
            let n_along = if range.flat_above_zero { 255 } else { 256 };
            let along: Vec<Rgb> = colors[..n_along].iter().step_by(2).copied().collect();
            let bar = color_bar(name, unit, range, &along);
            let detail = format!("{} · 0 {unit} or more", percent(of_colors[255], receivers));
            let los = range.flat_above_zero.then(|| flat(colors::LOS, "Line of sight", detail));
            los.into_iter().chain([bar]).collect()
        }),
        Layer::Heat { name, unit, .. } => {
            bar_range.map(|range| color_bar(name, unit, range, &colors[..HEAT.into()])).into_iter().collect()
        }
    };
    for (swatch, name, n) in special_legend(of_special, words.others_name, has_surface) {
        let (name, detail) = match (layer, swatch) {
            (Layer::Heat { none, .. }, Swatch::Hatched) => (none, String::new()),
            // Cells of the city are no measure of places in the air.
            (Layer::Heat { .. }, _) => (name, String::new()),
            _ => (name, if words.has_counts { cells(n) } else { String::new() }),
        };
        legend.push(furniture::legend_entry(swatch, name, &detail));
    }
    legend
}

fn share(n: u64, of: u64) -> String {
    format!("{} · {}", percent(n, of), grouped(n))
}

fn cells(n: u64) -> String {
    format!("{} {}", grouped(n), if n == 1 { "cell" } else { "cells" })
}

fn color_bar(name: &str, unit: &str, range: &ValueRange, along: &[Rgb]) -> Block {
    let name = if unit.is_empty() { name.to_string() } else { format!("{name} [{unit}]") };
    furniture::color_bar(&name, range.scale, along, 460.0)
}

/// Lists the special classes that occur, from their numbers of cells: swatch, name, number.
pub(crate) fn special_legend<'a>(
    numbers: &[u64],
    others_name: &'a str,
    has_surface: bool,
) -> Vec<(Swatch, &'a str, u64)> {
    let [low, high] = [0.0, 1.0].map(|t| Ramp::BuildingTone.at(t));
    let building = if has_surface { Swatch::Range(low, high) } else { Swatch::Flat(colors::BUILDING) };
    let out_of_range = Swatch::Flat(colors::OUT_OF_RANGE);
    let open = (Swatch::Flat(colors::WHITE), "Open ground without receivers");
    let special = [(building, others_name), (out_of_range, "Out of range"), (Swatch::Hatched, "No data"), open];
    special.into_iter().zip(numbers).filter(|(_, n)| **n > 0).map(|((swatch, name), n)| (swatch, name, *n)).collect()
}

/// Makes entries for the numbers of viewers that see a cell; a color bar for many. `who` names a
/// viewer, singular.
pub(crate) fn count_legend(who: &str, n_sites: u32, palette: &[Rgb], histogram: &[u64]) -> Vec<Block> {
    let receivers: u64 = histogram[..palette.len()].iter().sum();
    let entry = |k: u32, name: &str| {
        let n = histogram[k as usize];
        let swatch = Swatch::Flat(palette[k as usize]);
        (n > 0).then(|| furniture::legend_entry(swatch, name, &share(n, receivers)))
    };
    let none = entry(0, "Seen by none");
    if n_sites <= MOST_COUNT_ENTRIES {
        let name = |k: u32| match k {
            1 if n_sites == 1 => format!("Seen by the {who}"),
            1 => format!("By 1 {who}"),
            2 if n_sites == 2 => format!("By both {who}s"),
            k if k == n_sites => format!("By all {k} {who}s"),
            k => format!("By {k} {who}s"),
        };
        return none.into_iter().chain((1..=n_sites).filter_map(|k| entry(k, &name(k)))).collect();
    }
    let scale = Scale { low: 1.0, high: f64::from(n_sites), open_low: false, open_high: false };
    let title = capitalized(&format!("{who}s that see a cell (of {n_sites})"));
    std::iter::once(furniture::color_bar(&title, scale, &Ramp::Seen.steps(64), 420.0)).chain(none).collect()
}
