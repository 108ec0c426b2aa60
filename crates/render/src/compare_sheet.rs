//! Placements side by side on one sheet: a small map of each, maps of the change in pairs, and a
//! map of counts.
//!
//! All maps have one scale and one legend. The map of counts fills the last row of placements if
//! there is room, else it follows the pairs.

use super::check;
use super::colors::{self, Rgb};
use super::furniture::{self, Block, NAME, Swatch};
use super::lettering::{self, Type};
use super::map_legend;
use super::marks::{self, Mark};
use super::page::MARGIN;
use super::paint::{add, special};
use super::sheet::Sheet;
use super::small_maps::{Maps, Panel};

/// Headings of rows and of parts of the legend.
const HEADING: Type = Type { size: 30.0, ..NAME };

/// Placements to draw. Arrays are `[n_rows, n_cols]`, columns running fastest, north row first.
#[derive(Clone, Copy, Debug)]
pub struct CompareSheet<'a> {
    /// Title.
    pub title: &'a str,
    /// Result in words, below the title.
    pub verdict: &'a str,
    /// Lines below; long ones are wrapped.
    pub caption: &'a [String],
    /// Columns.
    pub n_cols: usize,
    /// Rows.
    pub n_rows: usize,
    /// Cell size along columns and along rows \[m\].
    pub cell_m: (f64, f64),
    /// Placements, at least two.
    pub maps: &'a [CompareMap<'a>],
    /// Pairs of placements.
    pub pairs: &'a [ComparePair<'a>],
    /// Surface heights for gray tones and hillshade of buildings \[m\]; not finite where unknown.
    pub surface_m: Option<&'a [f32]>,
    /// Name of class 2, plural and capitalized, such as `Buildings`.
    pub others_name: &'a str,
}

/// A placement.
#[derive(Clone, Copy, Debug)]
pub struct CompareMap<'a> {
    /// Heading, such as `UAV 1 · 60 m above ground`.
    pub title: &'a str,
    /// Line below the heading, such as its P_LoS with interval.
    pub detail: &'a str,
    /// Classes as in [`MapPicture`](super::MapPicture).
    pub mask: &'a [u8],
    /// Mark of the UAV, if its place is known.
    pub mark: Option<Mark<'a>>,
}

/// Change from one placement to another.
#[derive(Clone, Copy, Debug)]
pub struct ComparePair<'a> {
    /// Heading, such as `1 → 2`.
    pub title: &'a str,
    /// Line below the heading, such as the difference of P_LoS with its interval.
    pub detail: &'a str,
    /// Index of the first map.
    pub first: usize,
    /// Index of the second map.
    pub second: usize,
}

/// Returns the number of maps in a row, and the target length \[px\] of a map's longer side.
fn arrangement(n_maps: usize) -> (usize, f64) {
    if n_maps == 2 { (2, 760.0) } else { (4, 520.0) }
}

/// Draws placements side by side.
///
/// # Errors
/// Fewer than two maps, a pair with an index beyond the maps, an empty raster, an array of another
/// length, or a cell size that is not positive.
pub fn draw_compare_sheet(sheet: &CompareSheet<'_>) -> Result<Sheet, String> {
    if sheet.maps.len() < 2 {
        return Err(format!("cannot draw {} placements side by side: there must be at least 2", sheet.maps.len()));
    }
    let n_cells = [sheet.n_cols, sheet.n_rows];
    let arrangement = arrangement(sheet.maps.len());
    let maps = Maps::new(n_cells, sheet.cell_m, sheet.surface_m, arrangement)?;
    sheet.maps.iter().try_for_each(|map| check::shape("mask", map.mask.len(), n_cells))?;
    if let Some(pair) = sheet.pairs.iter().find(|pair| pair.first.max(pair.second) >= sheet.maps.len()) {
        return Err(format!("cannot draw `{}`: one of its maps is not there", pair.title));
    }
    let mut painter = Painter {
        sheet,
        maps,
        counts_palette: colors::count_colors(u32::try_from(sheet.maps.len()).unwrap_or(u32::MAX)),
        classes: vec![0; 6],
        pairs: vec![0; 4],
        counts: vec![0; sheet.maps.len() + 1],
    };
    let mut placements: Vec<Panel> = sheet.maps.iter().map(|map| painter.map(map)).collect();
    let mut pairs: Vec<Panel> = sheet.pairs.iter().map(|pair| painter.pair(pair)).collect();
    let count = painter.count();
    if placements.len().is_multiple_of(arrangement.0) { &mut pairs } else { &mut placements }.push(count);

    let mut page = maps.page(sheet.title);
    let verdict = furniture::paragraph(sheet.verdict, NAME, page.width);
    page.bottom -= 12.0;
    page.furniture.place(&verdict.drawing, MARGIN, page.bottom);
    page.bottom += verdict.height + 18.0;
    let change = "From the first to the second, with the change of P_LoS";
    for (heading, panels) in [("Placements", placements), (change, pairs)] {
        if !panels.is_empty() {
            page.furniture.text(MARGIN, page.bottom + 28.0, HEADING, heading);
            page.bottom += 46.0;
            maps.place(&mut page, panels);
        }
    }
    Ok(maps.finish(page, |room| painter.legend(room), sheet.caption))
}

/// Painter of the maps of a sheet. It counts the classes over all maps, for the legend.
struct Painter<'a> {
    sheet: &'a CompareSheet<'a>,
    maps: Maps<'a>,
    counts_palette: Vec<Rgb>,
    /// Cells by class: NLoS, LoS, not a receiver, out of range, nodata, open ground.
    classes: Vec<u64>,
    /// Cells of the pairs: seen by neither, only the first, only the second, both.
    pairs: Vec<u64>,
    /// Cells by count: seen by none, one, two …
    counts: Vec<u64>,
}

impl Painter<'_> {
    fn map(&mut self, map: &CompareMap<'_>) -> Panel {
        let colors = [colors::NLOS, colors::LOS];
        let painted = self.maps.canvas.paint_receivers(&colors, map.mask, |cell| usize::from(map.mask[cell]));
        add(&mut self.classes, &painted.histogram);
        self.maps.panel((map.title, map.detail), painted.image, map.mark.as_slice())
    }

    fn pair(&mut self, pair: &ComparePair<'_>) -> Panel {
        let [first, second] = [pair.first, pair.second].map(|k| &self.sheet.maps[k]);
        let painted = self.maps.canvas.paint(&colors::PAIR, |cell| {
            let [a, b] = [first.mask[cell], second.mask[cell]];
            // A cell that is a receiver in only one mask takes its class from the other mask.
            special(a.max(b), 4).unwrap_or_else(|| usize::from(a) + 2 * usize::from(b))
        });
        add(&mut self.pairs, &painted.histogram);
        let marks: Vec<Mark<'_>> = [first.mark, second.mark].into_iter().flatten().collect();
        self.maps.panel((pair.title, pair.detail), painted.image, &marks)
    }

    fn count(&mut self) -> Panel {
        let maps = self.sheet.maps;
        let n_colors = self.counts_palette.len();
        let painted = self.maps.canvas.paint(&self.counts_palette, |cell| {
            let classes = || maps.iter().map(|map| map.mask[cell]);
            match classes().min().and_then(|least| special(least, n_colors)) {
                Some(index) => index,
                None => classes().filter(|class| *class == 1).count(),
            }
        });
        add(&mut self.counts, &painted.histogram);
        let marks: Vec<Mark<'_>> = maps.iter().filter_map(|map| map.mark).collect();
        let receivers: u64 = self.counts.iter().sum();
        let [union, by_all] =
            [receivers - self.counts[0], self.counts[maps.len()]].map(|n| lettering::percent(n, receivers));
        let detail = format!("at least one sees {union}, all see {by_all}");
        self.maps.panel(("How many see a cell", &detail), painted.image, &marks)
    }

    /// Makes the legend of all maps.
    fn legend(&self, room: f64) -> Block {
        let entry = |swatch, name: &str| furniture::legend_entry(swatch, name, "");
        let flat = |of: &[(u64, Rgb, &str)]| -> Vec<Block> {
            of.iter().filter(|(n, ..)| *n > 0).map(|(_, color, name)| entry(Swatch::Flat(*color), name)).collect()
        };
        let mut classes = flat(&[
            (self.classes[1], colors::LOS, "Line of sight"),
            (self.classes[0], colors::NLOS, "No line of sight"),
        ]);
        let sheet = self.sheet;
        let special = map_legend::special_legend(&self.classes[2..], sheet.others_name, sheet.surface_m.is_some());
        classes.extend(special.into_iter().map(|(swatch, name, _)| entry(swatch, name)));
        let marks = sheet.maps.iter().filter_map(|map| map.mark);
        classes.extend(marks::symbols(marks).into_iter().map(|(swatch, name)| entry(swatch, name)));
        let [neither, lost, gained, both] = colors::PAIR;
        let pairs = flat(&[
            (self.pairs[2], gained, "Gained: only the second sees it"),
            (self.pairs[1], lost, "Lost: only the first sees it"),
            (self.pairs[3], both, "Both see it"),
            (self.pairs[0], neither, "Neither sees it"),
        ]);
        let n_maps = u32::try_from(sheet.maps.len()).unwrap_or(u32::MAX);
        let counts = map_legend::count_legend("UAV", n_maps, &self.counts_palette, &self.counts);

        let parts =
            [("Line of sight", classes), ("From the first to the second", pairs), ("How many see a cell", counts)];
        let blocks = parts.into_iter().filter(|(_, entries)| !entries.is_empty()).map(|(heading, entries)| {
            let heading = furniture::paragraph(heading, HEADING, room);
            furniture::stack(&[heading, furniture::flow(&entries, room, [38.0, 10.0])], 8.0)
        });
        furniture::stack(&blocks.collect::<Vec<_>>(), 22.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_number_of_maps_has_its_place() {
        for n in 2..=16 {
            let map = CompareMap { title: "UAV", detail: "P_LoS = 0.5", mask: &[0, 1, 1, 2], mark: None };
            let sheet = draw_compare_sheet(&CompareSheet {
                title: "A test",
                verdict: "One is best.",
                caption: &[],
                n_cols: 4,
                n_rows: 1,
                cell_m: (1.0, 1.0),
                maps: &vec![map; n],
                pairs: &[],
                surface_m: None,
                others_name: "Buildings",
            });
            let sheet = sheet.expect("it is valid");
            let inside = |(x, y, image): &(u32, u32, image::RgbaImage)| {
                f64::from(x + image.width()) <= sheet.width && f64::from(y + image.height()) <= sheet.height
            };
            assert!(sheet.images.iter().all(inside) && sheet.images.len() == n + 1, "{n}");
        }
    }
}
