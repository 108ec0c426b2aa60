//! Contents of the sheet and the page of a comparison, in words and marks.

use serde_json::Value;

use super::facts::{Origin, PairFacts, PlacementFacts, group_names};
use super::live_door::LivePacked;
use super::outcome::Comparison;
use super::report::{CompareReport, signed};
use crate::city_statistics::bootstrap::{RESAMPLINGS, RatioEstimate};
use crate::coverage::class;
use crate::picture::{Look, crop, mark, shown_classes};
use crate::quantity::{self, tidy};
use crate::raster::{CellWindow, GeoRef};
use crate::render::{
    self, CompareMap, ComparePage, ComparePair, CompareSheet, LiveDoor, Mark, PagePlacement, PageTable, grouped,
    percent,
};
use crate::words::unbreakable;

/// Most placements of a sheet with all pairs. A larger sheet shows only pairs with the first
/// placement.
const MOST_WITH_ALL_PAIRS: usize = 6;

/// Text of a sheet or a page.
pub(super) struct Figure<'a> {
    of: &'a Comparison,
    title: String,
    /// Labels by placement: `square · 60 m above ground`.
    labels: Vec<String>,
    /// Heights by placement: `60 m` where another one is at the same place, so that marks there
    /// differ.
    heights: Vec<String>,
    verdict: String,
    caption: Vec<String>,
}

impl<'a> Figure<'a> {
    pub(super) fn new(of: &'a Comparison, look: &Look) -> Self {
        let Comparison { scene, report, .. } = of;
        let title = format!("What {} placements see of {}", report.placements.len(), scene.name);
        let title = look.title_or(|| title);
        let label = |p: &PlacementFacts| match &p.origin {
            Origin::Uav(site) => unbreakable(&format!("{} · {}", p.id, site.height_words())),
            Origin::File { .. } => format!("{} · saved map", p.id),
        };
        let labels = report.placements.iter().map(label).collect();
        let places: Vec<_> = report.placements.iter().map(|p| p.position().map(|at| (at.x, at.y))).collect();
        let height = |p: &PlacementFacts| {
            let here = p.position().map(|at| (at.x, at.y));
            match &p.origin {
                Origin::Uav(site) if places.iter().filter(|place| **place == here).count() > 1 => {
                    format!("{} m", tidy(site.height_agl_m.unwrap_or(site.height_amsl_m)))
                }
                _ => String::new(),
            }
        };
        let heights = report.placements.iter().map(height).collect();
        let verdict = unbreakable(&report.verdict());
        Figure { of, title: unbreakable(&title), labels, heights, verdict, caption: caption(of, look) }
    }

    /// Returns the mark of a UAV, or of an observer, on a grid.
    fn mark_of<'b>(&self, placement: &'b PlacementFacts, height: &'b str, grid: &GeoRef) -> Option<Mark<'b>> {
        let at = placement.position()?;
        let Comparison { scene, report, .. } = self.of;
        // The height of a saved mask is unknown.
        let [height_amsl_m, _] = placement.heights();
        let is_observer = height_amsl_m
            .is_some_and(|height_m| report.sight.receivers().has_observer(&scene.field, (at.x, at.y), height_m));
        Some(Mark { is_observer, ..mark(grid, (at.x, at.y), &placement.id, height) })
    }

    /// Makes the sheet, cropped to the receivers, and passes it to `draw`.
    pub(super) fn with_sheet<T>(&self, draw: impl FnOnce(&CompareSheet<'_>) -> T) -> T {
        let Comparison { scene, report, .. } = self.of;
        let grid = scene.field.grid();
        let window = window_of_receivers(grid, self.of.overlay.union());
        let shown = grid.part(window);
        let masks: Vec<Vec<u8>> = self.of.masks.iter().map(|mask| shown_classes(mask, &scene.field, window)).collect();
        let surface = crop(&scene.field.above_ground_m(), grid.n_cols(), window);
        let details: Vec<String> = report
            .placements
            .iter()
            .map(|p| match p.groups[0].p_los.value {
                Some(value) => format!("P_LoS = {value:.4}{}", interval_words(&p.groups[0].p_los, plain)),
                None => "P_LoS undefined: no receiver".to_string(),
            })
            .collect();
        let maps: Vec<CompareMap<'_>> = (0..masks.len())
            .map(|k| CompareMap {
                title: &self.labels[k],
                detail: &details[k],
                mask: &masks[k],
                mark: self.mark_of(&report.placements[k], &self.heights[k], &shown),
            })
            .collect();
        let is_shown = |pair: &&PairFacts| maps.len() <= MOST_WITH_ALL_PAIRS || pair.first == 0;
        let pairs: Vec<(&PairFacts, String, String)> = report
            .pairs
            .iter()
            .filter(is_shown)
            .map(|pair| {
                let [first, second] = [pair.first, pair.second].map(|k| &report.placements[k].id);
                let difference = &pair.groups[0].difference;
                let detail = match difference.value {
                    Some(value) => format!("by {}{}", short(value), interval_words(difference, short)),
                    None => "no receiver of both".to_string(),
                };
                (pair, format!("{first} → {second}"), detail)
            })
            .collect();
        let pairs: Vec<ComparePair<'_>> = pairs
            .iter()
            .map(|(pair, title, detail)| ComparePair { title, detail, first: pair.first, second: pair.second })
            .collect();
        let mut caption = self.caption.clone();
        if maps.len() > MOST_WITH_ALL_PAIRS {
            let text = format!("Differences are drawn from {} to each other placement.", report.placements[0].id);
            caption.insert(1, text);
        }
        let unit = grid.meters_per_unit();
        draw(&CompareSheet {
            title: &self.title,
            verdict: &self.verdict,
            caption: &caption,
            n_cols: window.n_cols,
            n_rows: window.n_rows,
            cell_m: (grid.cell_width() * unit, grid.cell_height() * unit),
            maps: &maps,
            pairs: &pairs,
            surface_m: Some(&surface),
            others_name: report.sight.receivers().cell_names(&scene.field).1,
        })
    }

    /// Writes the page, which contains the document.
    pub(super) fn page(&self, document: &Value, live: Option<&LivePacked>) -> Result<String, String> {
        let Comparison { scene, report, masks, .. } = self.of;
        let grid = scene.field.grid();
        let placements: Vec<PagePlacement<'_>> = report
            .placements
            .iter()
            .zip(self.labels.iter().zip(&self.heights))
            .zip(masks)
            .map(|((p, (label, height)), mask)| PagePlacement {
                id: &p.id,
                label,
                mask: mask.as_slice(),
                mark: self.mark_of(p, height, grid),
            })
            .collect();
        let sentences: Vec<String> = report.pairs.iter().map(|pair| report.sentence(pair)).collect();
        render::compare_page(&ComparePage {
            title: &self.title,
            verdict: &self.verdict,
            matrix: &matrix(report),
            caption: &self.caption,
            n_cols: grid.n_cols(),
            n_rows: grid.n_rows(),
            corner: (grid.x_min(), grid.y_max()),
            cell: (grid.cell_width(), grid.cell_height()),
            meters_per_unit: grid.meters_per_unit(),
            placements: &placements,
            above_ground_m: &scene.field.above_ground_m(),
            sentences: &sentences,
            tables: &[placements_table(report), shares_table(report), differences_table(report), margins_table(report)],
            document,
            live: live.map(|live| LiveDoor { page: &live.page, sight: &live.sight, uavs: &live.uavs }),
        })
    }
}

/// Returns the lines of the caption: intervals, receivers, and attribution.
fn caption(of: &Comparison, look: &Look) -> Vec<String> {
    let Comparison { scene, report, .. } = of;
    let intervals = &report.intervals;
    let (receivers, _) = report.sight.receivers().cell_names(&scene.field);
    let range = if report.sight.is_limited() { " in range" } else { "" };
    let share = format!("P_LoS is the share of {receivers}{range} in line of sight");
    let mut lines = if report.has_intervals() {
        vec![
            format!(
                "{share}; brackets hold its {:.0} % interval from {} resamplings of blocks of {} m, seed {}.",
                100.0 * intervals.confidence,
                grouped(RESAMPLINGS),
                tidy(intervals.block_m),
                intervals.seed
            ),
            format!("In each resampling {}.", report.meaning()),
        ]
    } else {
        vec![format!("{share}.")]
    };
    lines.push(report.sight.in_words(scene.grid(), scene, report.facts.method));
    lines.extend(scene.last_lines(look));
    lines.iter().map(|line| unbreakable(line)).collect()
}

/// Returns the cells of receivers of any placement, with a border of a twentieth. Without a
/// receiver these are all cells.
fn window_of_receivers(grid: &GeoRef, union: &[u8]) -> CellWindow {
    let (n_rows, n_cols) = (grid.n_rows(), grid.n_cols());
    let is_receiver = |class: &u8| matches!(*class, class::NLOS | class::LOS);
    let (mut rows, mut cols) = ((n_rows, 0), (n_cols, 0));
    for (row, classes) in union.chunks_exact(n_cols).enumerate() {
        if let Some(first) = classes.iter().position(is_receiver) {
            let last = classes.iter().rposition(is_receiver).unwrap_or(first);
            rows = (rows.0.min(row), row + 1);
            cols = (cols.0.min(first), cols.1.max(last + 1));
        }
    }
    if rows.0 >= rows.1 {
        return grid.window();
    }
    let border = (rows.1 - rows.0).max(cols.1 - cols.0) / 20;
    let grown = |(low, high): (usize, usize), n: usize| (low.saturating_sub(border), (high + border).min(n));
    let (rows, cols) = (grown(rows, n_rows), grown(cols, n_cols));
    CellWindow { row: rows.0, col: cols.0, n_rows: rows.1 - rows.0, n_cols: cols.1 - cols.0 }
}

/// Returns a difference with three decimals and a true minus.
fn short(difference: f64) -> String {
    quantity::signed(difference, 3)
}

fn plain(p_los: f64) -> String {
    format!("{p_los:.4}")
}

/// Returns an interval in brackets, after a space; empty without one.
fn interval_words(estimate: &RatioEstimate, number: fn(f64) -> String) -> String {
    estimate.interval.map_or(String::new(), |(low, high)| format!(" [{}, {}]", number(low), number(high)))
}

/// Returns a remark for captions that a table has intervals, or none.
fn with_intervals(report: &CompareReport) -> &'static str {
    match report.reason_without_intervals() {
        Some(_) => ", without intervals",
        None => ", with intervals",
    }
}

/// Returns the head of a table with one column for each group.
fn head(report: &CompareReport, first: &str) -> Vec<String> {
    let names = group_names().into_iter().take(report.n_told());
    std::iter::once(first).chain(names).map(str::to_string).collect()
}

/// Returns the table of P_LoS of each placement less that of each other one.
fn matrix(report: &CompareReport) -> PageTable {
    let cell = |row: usize, col: usize| {
        let pair = report.pairs.iter().find(|p| (p.first, p.second) == (row.min(col), row.max(col)));
        let Some(difference) = pair.map(|pair| pair.groups[0].difference) else { return "–".to_string() };
        let star = if difference.exceeds() == Some(true) { "*" } else { "" };
        match difference.value {
            // A pair holds the second less the first.
            Some(value) => format!("{}{star}", signed(if row > col { value } else { -value })),
            None => "no receiver of both".to_string(),
        }
    };
    let n = report.placements.len();
    let row = |k: usize| -> Vec<String> {
        std::iter::once(report.placements[k].id.clone()).chain((0..n).map(|col| cell(k, col))).collect()
    };
    let percent = 100.0 * report.intervals.confidence;
    PageTable {
        caption: format!(
            "Difference of P_LoS: row less column, over the receivers of both; * clear, its {percent:.0} % interval does not \
             hold 0"
        ),
        head: std::iter::once("placement".to_string()).chain(report.placements.iter().map(|p| p.id.clone())).collect(),
        rows: (0..n).map(row).collect(),
    }
}

/// Returns the table of the placements' positions.
fn placements_table(report: &CompareReport) -> PageTable {
    let has_degrees = report.placements.iter().any(|p| p.position().is_some_and(|at| at.lonlat.is_some()));
    let row = |p: &PlacementFacts| {
        let number = |v: Option<f64>| v.map_or("–".to_string(), |v| tidy(v).to_string());
        let at = p.position();
        let mut cells = vec![p.id.clone(), number(at.map(|at| at.x)), number(at.map(|at| at.y))];
        if has_degrees {
            let degrees =
                |k: usize| at.and_then(|at| at.lonlat).map_or("–".to_string(), |lonlat| lonlat[k].to_string());
            cells.extend([degrees(0), degrees(1)]);
        }
        cells.extend(match &p.origin {
            Origin::Uav(site) => [site.height_words(), site.placement.to_string()],
            Origin::File { path, .. } => [format!("saved map {path}"), "–".to_string()],
        });
        cells.extend([grouped(p.tally.receivers), grouped(p.tally.los)]);
        cells
    };
    let degrees: &[&str] = if has_degrees { &["longitude", "latitude"] } else { &[] };
    let head = [&["placement", "x", "y"], degrees, &["height", "over", "receivers", "in line of sight"]].concat();
    PageTable {
        caption: "Placements".into(),
        head: head.into_iter().map(str::to_string).collect(),
        rows: report.placements.iter().map(row).collect(),
    }
}

fn shares_table(report: &CompareReport) -> PageTable {
    let row = |p: &PlacementFacts| {
        let cell = |k: usize| match p.groups[k].p_los.value {
            Some(value) => format!("{value:.4}\n{}", interval_words(&p.groups[k].p_los, plain).trim_start()),
            None => "no receiver".to_string(),
        };
        std::iter::once(p.id.clone()).chain((0..report.n_told()).map(cell)).collect()
    };
    PageTable {
        caption: format!("P_LoS by zone{}", with_intervals(report)),
        head: head(report, "placement"),
        rows: report.placements.iter().map(row).collect(),
    }
}

fn differences_table(report: &CompareReport) -> PageTable {
    let row = |pair: &PairFacts| {
        let [first, second] = [pair.first, pair.second].map(|k| &report.placements[k].id);
        let cell = |k: usize| {
            let difference = &pair.groups[k].difference;
            let exceeds = match difference.exceeds() {
                Some(true) => ", exceeds",
                Some(false) => ", does not exceed",
                None => "",
            };
            match difference.value {
                Some(value) => {
                    format!("{}{exceeds}\n{}", signed(value), interval_words(difference, signed).trim_start())
                }
                None => "no receiver".to_string(),
            }
        };
        std::iter::once(format!("{first} → {second}")).chain((0..report.n_told()).map(cell)).collect()
    };
    PageTable {
        caption: format!("Difference of P_LoS by zone{}; it exceeds one that does not hold 0", with_intervals(report)),
        head: head(report, "from → to"),
        rows: report.pairs.iter().map(row).collect(),
    }
}

fn margins_table(report: &CompareReport) -> PageTable {
    let meters = |v: f32| {
        if v.is_finite() {
            format!("{} m", quantity::fixed(v.into(), 1).replace('-', "−"))
        } else {
            "none is enough".into()
        }
    };
    let row = |p: &PlacementFacts| {
        let cells = match p.margins.and_then(|m| m.groups[0].map(|stats| (m.every, stats))) {
            Some((every, stats)) => {
                let [low, median, high] = stats.quantiles.map(meters);
                let grazing = percent(stats.grazing, stats.receivers);
                let sample = match every {
                    1 => format!("all {}", grouped(stats.receivers)),
                    n => format!("{}, every {n}th", grouped(stats.receivers)),
                };
                [low, median, high, grazing, sample]
            }
            None => ["–", "–", "–", "–", "saved map: no margins"].map(str::to_string),
        };
        std::iter::once(p.id.clone()).chain(cells).collect()
    };
    let head = ["placement", "5 % quantile", "median", "95 % quantile", "within ±1 m of grazing", "receivers asked"];
    PageTable {
        caption: "Margins: receiver height less the least height in line of sight".into(),
        head: head.map(str::to_string).to_vec(),
        rows: report.placements.iter().map(row).collect(),
    }
}
