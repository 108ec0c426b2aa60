//! Placements side by side on one sheet: a small map each, what changes between pairs of them, and how many see a cell.
//!
//! All maps have one scale and one legend. Where the maps leave a place in their last row, the number of UAVs that see a
//! cell stands there, else behind the pairs.

use super::colors::{self, Rgb};
use super::furniture::{self, Block, Swatch};
use super::lettering;
use super::map_layers::{self, Backing};
use super::marks::Mark;
use super::paint;
use super::sheet::Sheet;
use super::small_maps::{HEADING, Maps, Page, Panel};

/// Placements to draw. Arrays are `[n_rows, n_cols]`, columns running fastest, north row first.
#[derive(Clone, Copy, Debug)]
pub struct CompareSheet<'a> {
    /// Title.
    pub title: &'a str,
    /// What comes out, below the title.
    pub verdict: &'a str,
    /// Lines below; long ones are wrapped.
    pub caption: &'a [String],
    /// Columns.
    pub n_cols: usize,
    /// Rows.
    pub n_rows: usize,
    /// Cell size along columns and along rows \[m\].
    pub cell_m: (f64, f64),
    /// Two placements or more.
    pub maps: &'a [CompareMap<'a>],
    /// Pairs of them.
    pub pairs: &'a [ComparePair<'a>],
    /// Surface heights for gray tones and hillshade of buildings \[m\]; not finite where unknown.
    pub surface_m: Option<&'a [f32]>,
    /// What class 2 is, in the plural and capitalized, such as `Buildings`.
    pub others_name: &'a str,
}

/// A placement.
#[derive(Clone, Copy, Debug)]
pub struct CompareMap<'a> {
    /// What stands over it, such as `UAV 1 · 60 m above ground`.
    pub title: &'a str,
    /// A line below that, such as its P_LoS with interval.
    pub detail: &'a str,
    /// Classes: 0 NLoS, 1 LoS, 2 not a receiver, 3 out of range, 255 nodata.
    pub mask: &'a [u8],
    /// Where the UAV is, if that is known.
    pub mark: Option<Mark<'a>>,
}

/// What changes from one placement to another.
#[derive(Clone, Copy, Debug)]
pub struct ComparePair<'a> {
    /// What stands over it, such as `1 → 2`.
    pub title: &'a str,
    /// A line below that, such as the difference of P_LoS with its interval.
    pub detail: &'a str,
    /// The first, as an index of the maps.
    pub first: usize,
    /// The second.
    pub second: usize,
}

/// Columns of maps, and the length \[px\] that the longer side of a map aims at.
fn arrangement(n_maps: usize) -> (usize, f64) {
    if n_maps == 2 { (2, 760.0) } else { (4, 520.0) }
}

/// Draws placements.
///
/// # Errors
/// Fewer than two maps, a pair of maps that are not there, an empty raster, an array of another length, or a cell size
/// that is not positive.
pub fn draw_compare_sheet(sheet: &CompareSheet<'_>) -> Result<Sheet, String> {
    check(sheet)?;
    let (columns, target) = arrangement(sheet.maps.len());
    let axes = paint::scale_to(sheet.n_cols, sheet.n_rows, sheet.cell_m, (target, 1.4 * target));
    let painter = Painter {
        sheet,
        backing: Backing { axes, cell_m: sheet.cell_m, surface_m: sheet.surface_m },
        maps: Maps {
            size: axes.map(|axis| axis.n_px as f64),
            n_cells: [sheet.n_cols, sheet.n_rows],
            cell_m: sheet.cell_m,
            columns,
        },
    };
    let mut found = Found { classes: [0; 5], pairs: [0; 4], counts: vec![0; sheet.maps.len() + 1] };
    let mut maps: Vec<Panel> = sheet.maps.iter().map(|map| painter.map(map, &mut found)).collect();
    let mut pairs: Vec<Panel> = sheet.pairs.iter().map(|pair| painter.pair(pair, &mut found)).collect();
    let count = painter.count(&mut found);
    if maps.len().is_multiple_of(columns) { &mut pairs } else { &mut maps }.push(count);

    let mut page = Page::new(sheet.title, painter.maps);
    page.lead(sheet.verdict);
    for (heading, panels) in [("Placements", maps), ("From the first to the second, with the change of P_LoS", pairs)] {
        if !panels.is_empty() {
            page.heading(heading);
            page.panels(panels);
        }
    }
    page.legend(|room| legend(&painter, &found, room));
    Ok(page.finish(sheet.caption))
}

fn check(sheet: &CompareSheet<'_>) -> Result<(), String> {
    if sheet.maps.len() < 2 {
        return Err(format!("cannot draw {} placements side by side: there must be at least 2", sheet.maps.len()));
    }
    let (cell_x, cell_y) = sheet.cell_m;
    if ![cell_x, cell_y].iter().all(|c| c.is_finite() && *c > 0.0) {
        return Err(format!("cannot draw a map of cells of {cell_x} × {cell_y} m: both must be above 0 m"));
    }
    let shape = |name: &str, length: usize| super::check_shape(name, length, sheet.n_cols, sheet.n_rows);
    sheet.maps.iter().try_for_each(|map| shape("mask", map.mask.len()))?;
    sheet.surface_m.map_or(Ok(()), |surface| shape("surface", surface.len()))?;
    match sheet.pairs.iter().find(|pair| pair.first.max(pair.second) >= sheet.maps.len()) {
        Some(pair) => Err(format!("cannot draw `{}`: one of its maps is not there", pair.title)),
        None => Ok(()),
    }
}

/// How many cells were painted as what, over all maps: what the legend names.
struct Found {
    /// NLoS, LoS, not a receiver, out of range, nodata.
    classes: [u64; 5],
    /// Neither, only the first, only the second, both.
    pairs: [u64; 4],
    /// Seen by none, one, two …
    counts: Vec<u64>,
}

fn add(sums: &mut [u64], numbers: &[u64]) {
    sums.iter_mut().zip(numbers).for_each(|(sum, n)| *sum += n);
}

/// Paints the maps of a sheet.
struct Painter<'a> {
    sheet: &'a CompareSheet<'a>,
    backing: Backing<'a>,
    maps: Maps,
}

impl Painter<'_> {
    fn map(&self, map: &CompareMap<'_>, found: &mut Found) -> Panel {
        let mask = map.mask;
        let index_of = |cell: usize| map_layers::special(mask[cell], 2).unwrap_or(usize::from(mask[cell]));
        let painted = map_layers::paint_flat(&self.backing, &[colors::NLOS, colors::LOS], index_of);
        add(&mut found.classes, &painted.histogram);
        let marks: Vec<Mark<'_>> = map.mark.into_iter().collect();
        self.maps.panel((map.title, map.detail), painted.image, &marks)
    }

    fn pair(&self, pair: &ComparePair<'_>, found: &mut Found) -> Panel {
        let [first, second] = [pair.first, pair.second].map(|k| &self.sheet.maps[k]);
        // A cell that is a receiver of one alone is drawn as what it is to the other.
        let class = |cell: usize| first.mask[cell].max(second.mask[cell]);
        let index_of = |cell: usize| {
            let seen = || usize::from(first.mask[cell]) + 2 * usize::from(second.mask[cell]);
            map_layers::special(class(cell), 4).unwrap_or_else(seen)
        };
        let painted = map_layers::paint_flat(&self.backing, &colors::PAIR, index_of);
        add(&mut found.pairs, &painted.histogram);
        let marks: Vec<Mark<'_>> = [first.mark, second.mark].into_iter().flatten().collect();
        self.maps.panel((pair.title, pair.detail), painted.image, &marks)
    }

    fn count(&self, found: &mut Found) -> Panel {
        let maps = self.sheet.maps;
        let palette = self.count_palette();
        let index_of = |cell: usize| {
            let least = maps.iter().map(|map| map.mask[cell]).filter(|class| *class > 1).min();
            let is_receiver = maps.iter().any(|map| map.mask[cell] <= 1);
            match least.filter(|_| !is_receiver) {
                Some(class) => map_layers::special(class, palette.len()).unwrap_or(palette.len()),
                None => maps.iter().filter(|map| map.mask[cell] == 1).count(),
            }
        };
        let painted = map_layers::paint_flat(&self.backing, &palette, index_of);
        add(&mut found.counts, &painted.histogram);
        let marks: Vec<Mark<'_>> = maps.iter().filter_map(|map| map.mark).collect();
        let receivers: u64 = found.counts.iter().sum();
        let union = lettering::percent(receivers - found.counts[0], receivers);
        let by_all = lettering::percent(found.counts[maps.len()], receivers);
        let detail = format!("at least one sees {union}, all see {by_all}");
        self.maps.panel(("How many see a cell", &detail), painted.image, &marks)
    }

    fn n_maps(&self) -> u32 {
        u32::try_from(self.sheet.maps.len()).unwrap_or(u32::MAX)
    }

    fn count_palette(&self) -> Vec<Rgb> {
        (0..=self.n_maps()).map(|k| colors::count_color(k, self.n_maps())).collect()
    }
}

/// The legend of all maps.
fn legend(painter: &Painter<'_>, found: &Found, room: f64) -> Block {
    let entry = |swatch, name: &str| furniture::legend_entry(swatch, name, "");
    let flat = |colors: &[Rgb], names: &[&str], numbers: &[u64]| -> Vec<Block> {
        let all = colors.iter().zip(names).zip(numbers).filter(|(_, n)| **n > 0);
        all.map(|((color, name), _)| entry(Swatch::Flat(*color), name)).collect()
    };
    let seen = [colors::LOS, colors::NLOS];
    let numbers = [found.classes[1], found.classes[0]];
    let mut classes = flat(&seen, &["Line of sight", "No line of sight"], &numbers);
    let special = map_layers::special_legend(&found.classes[2..], painter.sheet.others_name, &painter.backing);
    classes.extend(special.into_iter().map(|(swatch, name, _)| entry(swatch, &name)));
    if painter.sheet.maps.iter().any(|map| map.mark.is_some()) {
        classes.push(entry(Swatch::Uav, "UAV"));
    }
    let [neither, lost, gained, both] = colors::PAIR;
    let names = ["Gained: only the second sees it", "Lost: only the first sees it", "Both see it", "Neither sees it"];
    let [n_neither, n_lost, n_gained, n_both] = found.pairs;
    let pairs = flat(&[gained, lost, both, neither], &names, &[n_gained, n_lost, n_both, n_neither]);
    let counts = map_layers::count_legend(painter.n_maps(), &painter.count_palette(), &found.counts);

    let parts = [("Line of sight", classes), ("From the first to the second", pairs), ("How many see a cell", counts)];
    let blocks = parts.into_iter().filter(|(_, entries)| !entries.is_empty()).map(|(heading, entries)| {
        let heading = furniture::paragraph(heading, HEADING, room);
        furniture::stack(&[heading, furniture::flow(&entries, room, [38.0, 10.0])], 8.0)
    });
    furniture::stack(&blocks.collect::<Vec<_>>(), 22.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAIR: ComparePair<'static> = ComparePair { title: "0 → 1", detail: "falls", first: 0, second: 1 };
    const SHEET: CompareSheet<'static> = CompareSheet {
        title: "A test",
        verdict: "One is best.",
        caption: &[],
        n_cols: 4,
        n_rows: 1,
        cell_m: (1.0, 1.0),
        maps: &[],
        pairs: &[],
        surface_m: None,
        others_name: "Buildings",
    };

    fn map<'a>(title: &'a str, mask: &'a [u8]) -> CompareMap<'a> {
        CompareMap { title, detail: "P_LoS = 0.5", mask, mark: None }
    }

    #[test]
    fn a_sheet_names_every_map_once_and_what_occurs_on_them() {
        let maps = [map("UAV 0", &[0, 1, 1, 2]), map("UAV 1", &[0, 0, 1, 2])];
        let sheet = draw_compare_sheet(&CompareSheet { maps: &maps, pairs: &[PAIR], ..SHEET }).expect("it is valid");
        let svg = sheet.furniture.svg;
        let names = ["One is best.<", "UAV 0<", "UAV 1<", "0 → 1<"];
        for text in names.into_iter().chain(["Lost: only", "Both see it", "Neither sees it", "By both UAVs"]) {
            assert_eq!(svg.matches(text).count(), 1, "{text}");
        }
        assert!(!svg.contains("Gained") && !svg.contains("Out of range"));
        assert!(svg.contains("at least one sees 66.7\u{202F}%, all see 33.3\u{202F}%"), "{svg}");
    }

    #[test]
    fn any_number_of_maps_has_its_place() {
        for n in 2..=16 {
            let maps = vec![map("UAV", &[0, 1, 1, 2]); n];
            let sheet = draw_compare_sheet(&CompareSheet { maps: &maps, ..SHEET }).expect("it is valid");
            let inside = |(x, y, image): &(u32, u32, image::RgbaImage)| {
                f64::from(x + image.width()) <= sheet.width && f64::from(y + image.height()) <= sheet.height
            };
            assert!(sheet.images.iter().all(inside) && sheet.images.len() == n + 1, "{n}");
        }
    }

    #[test]
    fn pixels_have_the_colors_of_the_pair() {
        let maps = [map("", &[0, 1, 0, 1]), map("", &[0, 0, 1, 1])];
        let sheet = draw_compare_sheet(&CompareSheet { maps: &maps, pairs: &[PAIR], ..SHEET }).expect("it is valid");
        let image = &sheet.images[2].2;
        let step = image.width() / 4;
        for (k, color) in (0..4).zip(colors::PAIR) {
            assert_eq!(image.get_pixel(step * k + step / 2, 5).0[..3], color);
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let (good, short) = (map("", &[1; 4]), map("", &[1; 3]));
        for (maps, pairs, words) in [
            (&[good][..], &[][..], "at least 2"),
            (&[good, short], &[], "mask has 3"),
            (&[good, good], &[ComparePair { second: 2, ..PAIR }], "not there"),
        ] {
            let drawn = draw_compare_sheet(&CompareSheet { maps, pairs, ..SHEET });
            assert!(drawn.is_err_and(|e| e.contains(words)), "{words}");
        }
    }
}
