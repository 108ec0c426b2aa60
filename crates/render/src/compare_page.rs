//! Placements side by side as one self-contained web page: a map to swipe over, differences in
//! words, tables.
//!
//! The page loads nothing: style, script and pictures are in the file, and a policy in its head
//! forbids the browser to fetch more. A mask is a palette PNG of one pixel per cell, so the script
//! reads classes, shares and differences from the very pixels that are shown. Template, style and
//! script are files of their own kinds in `compare_page/`.
//!
//! A grid of more cells than a picture may have is thinned, not averaged: each pixel is the middle
//! cell of a square of cells. So a pixel is true of one cell, the same cell in every mask. The page
//! says so.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use skyshed_core::coverage::class;

use super::check;
use super::colors::{self, Rgb, hex};
use super::furniture;
use super::lettering::escape;
use super::live_page;
use super::marks::Mark;
use super::paint::{self, Canvas};
use super::png;
use super::sheet::Drawing;
use super::web_page::{SHARES, filled, in_script, policy};

const TEMPLATE: &str = include_str!("compare_page/page.html");
const STYLE: &str = include_str!("compare_page/page.css");
const SCRIPT: &str = include_str!("compare_page/page.js");

/// Button that opens the live page.
const LIVE_BUTTON: &str = "<button type=\"button\" id=\"live\">Open live: drag A and B</button>\n";

/// Most pixels of one picture.
const MOST_PIXELS: usize = 4_000_000;
/// Most pixels of all masks together. At two bits each they stay below 8 MB in base 64 even if
/// nothing compresses.
const MOST_PIXELS_OF_ALL: usize = 24_000_000;

/// Placements to show. Arrays are `[n_rows, n_cols]`, columns running fastest, north row first.
#[derive(Clone, Copy, Debug)]
pub struct ComparePage<'a> {
    /// Title.
    pub title: &'a str,
    /// Result in words, below the title.
    pub verdict: &'a str,
    /// Differences between any two placements, below the verdict.
    pub matrix: &'a PageTable,
    /// Caption lines at the end.
    pub caption: &'a [String],
    /// Columns.
    pub n_cols: usize,
    /// Rows.
    pub n_rows: usize,
    /// North-west corner \[CRS units\].
    pub corner: (f64, f64),
    /// Cell size along columns and along rows \[CRS units\].
    pub cell: (f64, f64),
    /// Length of a CRS unit \[m\].
    pub meters_per_unit: f64,
    /// Placements, at least two.
    pub placements: &'a [PagePlacement<'a>],
    /// Heights above ground \[m\], for the buildings behind the masks; not finite where unknown.
    pub above_ground_m: &'a [f32],
    /// Sentences that sum up the differences.
    pub sentences: &'a [String],
    /// Tables.
    pub tables: &'a [PageTable],
    /// The document of the run, kept in the page.
    pub document: &'a Value,
    /// The live page of the same place, if there is one.
    pub live: Option<LiveDoor<'a>>,
}

/// Live page that opens from this page.
#[derive(Clone, Copy, Debug)]
pub struct LiveDoor<'a> {
    /// The page, packed by gzip.
    pub page: &'a [u8],
    /// Part of its address for receivers: height, place, range.
    pub sight: &'a str,
    /// Part of its address for each placement's UAV: x, y and height; `None` for a mask without a
    /// UAV.
    pub uavs: &'a [Option<String>],
}

/// A placement.
#[derive(Clone, Copy, Debug)]
pub struct PagePlacement<'a> {
    /// Its id, as in the page's address.
    pub id: &'a str,
    /// Name in words.
    pub label: &'a str,
    /// Classes: 0 NLoS, 1 LoS, 2 not a receiver, 3 out of range, 255 nodata.
    pub mask: &'a [u8],
    /// Mark of the UAV, if its place is known.
    pub mark: Option<Mark<'a>>,
}

/// A table of words.
#[derive(Clone, Debug)]
pub struct PageTable {
    /// Caption.
    pub caption: String,
    /// Names of the columns.
    pub head: Vec<String>,
    /// Rows, each as long as the head; its first cell names it. Line breaks in a cell are kept.
    pub rows: Vec<Vec<String>>,
}

/// Returns the step of thinning: one of `step` cells along each side is shown.
fn step(n_cells: usize, n_masks: usize) -> usize {
    let most = MOST_PIXELS.min(MOST_PIXELS_OF_ALL / n_masks.max(1));
    (1..).find(|step| n_cells.div_ceil(step * step) <= most).unwrap_or(1)
}

/// Writes the page.
///
/// # Errors
/// Fewer than two placements, an empty raster, or an array of another length.
pub fn compare_page(page: &ComparePage<'_>) -> Result<String, String> {
    if page.placements.len() < 2 {
        return Err(format!("cannot show {} placements side by side: there must be at least 2", page.placements.len()));
    }
    let shape = |name: &str, length: usize| check::shape(name, length, [page.n_cols, page.n_rows]);
    page.placements.iter().try_for_each(|p| shape("mask", p.mask.len()))?;
    shape("heights", page.above_ground_m.len())?;
    let thinned = Thinned::of(page);
    let mut caption: Vec<String> = page.caption.to_vec();
    if thinned.step > 1 {
        caption.push(thinned.words());
    }
    let aspect = page.n_cols as f64 * page.cell.0 / (page.n_rows as f64 * page.cell.1);
    let [neither, lost, gained, both] = colors::PAIR.map(hex);
    let lines =
        |texts: &[String], tag: &str| texts.iter().map(|text| format!("<{tag}>{}</{tag}>\n", words(text))).collect();
    let symbols = [furniture::uav_symbol, furniture::observer_symbol].map(symbol);
    let script = [SHARES, SCRIPT].concat();
    // A live page that is opened from this one obeys its policy.
    let live_script = page.live.map(|_| live_page::script());
    let scripts: Vec<&str> = std::iter::once(script.as_str()).chain(live_script.as_deref()).collect();
    let parts: [(&str, String); 28] = [
        ("policy", policy(&scripts)),
        ("generator", format!("skyshed {}", env!("CARGO_PKG_VERSION"))),
        ("css", STYLE.to_string()),
        ("js", script.clone()),
        ("title", escape(page.title)),
        ("verdict", words(page.verdict)),
        ("matrix", table(page.matrix)),
        ("options", options(page)),
        ("aspect", format!("{aspect:.6}")),
        ("backdrop", picture("id=\"backdrop\" alt=\"buildings\"", &thinned.backdrop()?)),
        ("marks", marks(page, &symbols)),
        ("symbols", legend_of_marks(page, &symbols)),
        ("los", hex(colors::LOS)),
        ("nlos", hex(colors::NLOS)),
        ("neither", neither),
        ("lost", lost),
        ("gained", gained),
        ("both", both),
        ("counts", counts(&count_colors(page))),
        ("ground", hex(colors::OPEN_GROUND)),
        ("sentences", lines(page.sentences, "li")),
        ("tables", page.tables.iter().map(table).collect()),
        ("caption", lines(&caption, "p")),
        ("masks", thinned.masks()?),
        ("view", in_script(&view(page, &thinned))),
        ("document", in_script(page.document)),
        ("live", page.live.map_or(String::new(), |_| LIVE_BUTTON.to_string())),
        ("live_page", page.live.map_or(String::new(), |live| STANDARD.encode(live.page))),
    ];
    Ok(filled(TEMPLATE, &parts))
}

/// Escapes words of the page, sets the index of each `P_LoS` below the line, and forbids a break
/// before a percent sign.
fn words(text: &str) -> String {
    escape(text).replace("P_LoS", "P<sub>LoS</sub>").replace(" %", "\u{a0}%")
}

fn options(page: &ComparePage<'_>) -> String {
    let option = |p: &PagePlacement<'_>| format!("<option value=\"{}\">{}</option>", escape(p.id), escape(p.label));
    page.placements.iter().map(option).collect()
}

/// Returns a symbol as markup.
fn symbol(draw: fn(&mut Drawing, [f64; 2], f64)) -> String {
    let mut drawing = Drawing::default();
    draw(&mut drawing, [20.0, 20.0], 18.0);
    format!("<svg viewBox=\"0 0 40 40\" aria-hidden=\"true\">{}</svg>", drawing.svg.replace('\n', ""))
}

/// Returns the legend entries of the symbols on the map: UAVs and observers.
fn legend_of_marks(page: &ComparePage<'_>, symbols: &[String; 2]) -> String {
    let has = |is_observer: bool| page.placements.iter().any(|p| p.mark.is_some_and(|m| m.is_observer == is_observer));
    let entry = |(symbol, (is_observer, name)): (&String, (bool, &str))| {
        if has(is_observer) { format!("<li>{symbol}{name}</li>\n") } else { String::new() }
    };
    symbols.iter().zip([(false, "UAV"), (true, "observer")]).map(entry).collect()
}

/// Returns symbols and names of the UAVs on the map. Those at one place are stacked, upward near
/// the southern border.
fn marks(page: &ComparePage<'_>, symbols: &[String; 2]) -> String {
    let mut out = String::new();
    let places: Vec<Option<[f64; 2]>> =
        page.placements.iter().map(|p| p.mark.map(|mark| [mark.col, mark.row])).collect();
    for (k, placement) in page.placements.iter().enumerate() {
        let Some(mark) = placement.mark else { continue };
        let (x, y) = (mark.col / page.n_cols as f64, mark.row / page.n_rows as f64);
        if (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y) {
            let n_before = places[..k].iter().filter(|place| **place == places[k]).count();
            let side = if x > 0.5 { " left-of" } else { "" };
            let way = if y > 0.75 { " up" } else { "" };
            let symbol = &symbols[usize::from(mark.is_observer)];
            let height = if mark.height.is_empty() { String::new() } else { format!(" · {}", escape(mark.height)) };
            let _ = writeln!(
                out,
                "<div class=\"mark{side}{way}\" data-placement=\"{k}\" style=\"left:{:.4}%;top:{:.4}%;--nth:{n_before}\">\
                 {symbol}<span>{}{height}</span></div>",
                100.0 * x,
                100.0 * y,
                escape(mark.label)
            );
        }
    }
    out
}

/// Returns the colors of cells by the number of placements that see them.
fn count_colors(page: &ComparePage<'_>) -> Vec<String> {
    let n = u32::try_from(page.placements.len()).unwrap_or(u32::MAX);
    colors::count_colors(n).into_iter().map(hex).collect()
}

/// Returns the legend entries of [`count_colors`].
fn counts(colors: &[String]) -> String {
    let entry = |(k, color): (usize, &String)| {
        let words = match k {
            0 => "none".to_string(),
            k if k + 1 == colors.len() => format!("all {k}"),
            k => k.to_string(),
        };
        format!("<li><i style=\"background:{color}\"></i>{words}</li>\n")
    };
    colors.iter().enumerate().map(entry).collect()
}

fn table(table: &PageTable) -> String {
    let lines = |text: &String| text.split('\n').map(words).collect::<Vec<_>>().join("<br>");
    let cell = |name: &str, text: &String| format!("<{name}>{}</{}>", lines(text), &name[..2]);
    let head: String = table.head.iter().map(|text| cell("th scope=\"col\"", text)).collect();
    let mut out = format!(
        "<div class=\"table\"><table>\n<caption>{}</caption>\n<thead><tr>{head}</tr></thead>\n<tbody>\n",
        words(&table.caption)
    );
    for row in &table.rows {
        let cells = row.iter().enumerate().map(|(k, text)| cell(if k == 0 { "th scope=\"row\"" } else { "td" }, text));
        let _ = writeln!(out, "<tr>{}</tr>", cells.collect::<String>());
    }
    out + "</tbody>\n</table></div>\n"
}

/// Returns a picture as an element that holds its bytes.
fn picture(attributes: &str, file: &[u8]) -> String {
    format!("<img {attributes} src=\"data:image/png;base64,{}\">\n", STANDARD.encode(file))
}

/// Returns the facts of the map that the script needs.
fn view(page: &ComparePage<'_>, thinned: &Thinned<'_>) -> Value {
    let list = |of: fn(&PagePlacement<'_>) -> String| page.placements.iter().map(of).collect::<Vec<_>>();
    json!({
        "ids": list(|p| p.id.to_string()),
        "labels": list(|p| p.label.to_string()),
        "cols": thinned.cols.len(),
        "rows": thinned.rows.len(),
        "grid_cols": page.n_cols,
        "grid_rows": page.n_rows,
        "step": thinned.step,
        "x_min": page.corner.0,
        "y_max": page.corner.1,
        "cell_width": page.cell.0,
        "cell_height": page.cell.1,
        "width_m": page.n_cols as f64 * page.cell.0 * page.meters_per_unit,
        "live": page.live.map(|live| json!({ "sight": live.sight, "uavs": live.uavs })),
        "colors": {
            "los": [hex(colors::NLOS), hex(colors::LOS)],
            "pair": colors::PAIR.map(hex),
            "count": count_colors(page),
        },
    })
}

/// Cells that the pictures of a page show.
struct Thinned<'a> {
    page: &'a ComparePage<'a>,
    step: usize,
    cols: Vec<usize>,
    rows: Vec<usize>,
}

impl<'a> Thinned<'a> {
    fn of(page: &'a ComparePage<'a>) -> Self {
        let step = step(page.n_cols * page.n_rows, page.placements.len());
        let middles = |n: usize| (0..n.div_ceil(step)).map(|k| (k * step + step / 2).min(n - 1)).collect();
        Thinned { page, step, cols: middles(page.n_cols), rows: middles(page.n_rows) }
    }

    fn words(&self) -> String {
        let step = self.step;
        format!(
            "The map shows one cell of each {step} × {step}, the one in the middle; tables and sentences count all cells, \
             the shares below the map those that are shown."
        )
    }

    /// Picks the values of the shown cells, row by row.
    fn pick<T: Copy>(&self, values: &[T]) -> Vec<T> {
        let n_cols = self.page.n_cols;
        self.rows.iter().flat_map(|row| self.cols.iter().map(move |col| values[row * n_cols + col])).collect()
    }

    fn masks(&self) -> Result<String, String> {
        let mut out = String::new();
        for (k, placement) in self.page.placements.iter().enumerate() {
            let file = png::draw_bare(self.cols.len(), self.rows.len(), &self.pick(placement.mask), &[])?;
            let attributes =
                format!("class=\"mask\" data-placement=\"{k}\" alt=\"mask of {}\"", escape(placement.label));
            out.push_str(&picture(&attributes, &file));
        }
        Ok(out)
    }

    /// Draws buildings in gray by height, with light from the north-west, over pale ground.
    fn backdrop(&self) -> Result<Vec<u8>, String> {
        let heights = self.pick(self.page.above_ground_m);
        let n_cells = [self.cols.len(), self.rows.len()];
        let side_m = |cell: f64| cell * self.page.meters_per_unit * self.step as f64;
        let cell_m = (side_m(self.page.cell.0), side_m(self.page.cell.1));
        let colors = [colors::OPEN_GROUND, colors::WHITE];
        let building = paint::special(class::NOT_A_RECEIVER, colors.len()).unwrap_or_default();
        let painted = Canvas::bare(n_cells, cell_m, &heights).paint(&colors, |cell| match heights[cell] {
            height if height > 0.0 => building,
            height if height.is_finite() => 0,
            _ => 1,
        });
        let colors: Vec<Rgb> = painted.image.pixels().map(|pixel| [pixel.0[0], pixel.0[1], pixel.0[2]]).collect();
        png::encode_grays(n_cells, &colors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_thinned_only_where_they_must_be() {
        for (n_cells, n_masks, n) in [(4_000_000, 6, 1), (4_000_001, 6, 2), (2_000_000, 16, 2), (16_384 * 16_384, 2, 9)]
        {
            assert_eq!(step(n_cells, n_masks), n, "{n_cells}");
        }
    }
}
