//! The picture of a map, as `map` and `stress` draw it: layer, marks, title, caption.

use super::args::{PictureWords, ReceiversArg};
use super::map::{crop, height_words, mark, undrawable};
use super::plan::{Ready, meters_per_unit};
use super::receivers::{cell_names, setting_line_on};
use super::tolerance::in_words as tolerance_in_words;
use super::words::unbreakable;
use crate::coverage::{Overlay, SiteCoverage, Stability, Tally};
use crate::error::Result;
use crate::export::Layer;
use crate::quantity::tidy;
use crate::raster::CellWindow;
use crate::render::{self, MapPicture, Mark};
use crate::report::{MapReport, SiteFacts};

/// A map to draw.
pub(super) struct MapDrawing<'a> {
    pub(super) scene: &'a Ready,
    pub(super) coverages: &'a [SiteCoverage],
    /// All masks together, for more than one UAV.
    pub(super) overlay: Option<&'a Overlay>,
    /// The layers that were asked for; the first is drawn.
    pub(super) layers: &'a [Layer],
    pub(super) report: &'a MapReport,
    pub(super) receivers: ReceiversArg,
    pub(super) words: &'a PictureWords,
    /// The counts of the legend, where they are not those of what is drawn.
    pub(super) counts: Option<Tally>,
    /// What else must be said of the picture.
    pub(super) note: Option<String>,
}

impl MapDrawing<'_> {
    /// The picture as PNG, or as vectors.
    pub(super) fn draw(&self, as_vectors: bool, provenance: &[(String, String)]) -> Result<Vec<u8>> {
        let grid = self.scene.field.grid();
        let shown = grid.part(self.window_in_range());
        let unit = meters_per_unit(grid);
        let heights: Vec<String> = self.report.sites.iter().map(height_words).collect();
        let labels: Vec<String> = self.report.sites.iter().map(|s| format!("UAV {}", s.id)).collect();
        let marks: Vec<Mark<'_>> = self
            .report
            .sites
            .iter()
            .zip(heights.iter().zip(&labels))
            .map(|(site, (height, label))| mark(&shown, (site.x, site.y), label, height))
            .collect();
        // What is out of range is not drawn.
        let window = self.window_in_range();
        let cropped = |values: Vec<f32>| crop(&values, grid.n_cols(), window);
        let surface = cropped(self.scene.field.above_ground_m());
        let (union, count, only);
        let layer = match (self.overlay, self.coverages) {
            (None, [site]) => {
                only = self.cropped(site, window);
                self.single_layer(&only)
            }
            (overlay, sites) => {
                union = crop(overlay.map_or(&[], Overlay::union), grid.n_cols(), window);
                count = crop(overlay.map_or(&[], Overlay::count), grid.n_cols(), window);
                let n_sites = u32::try_from(sites.len()).unwrap_or(u32::MAX);
                render::Layer::Count { count: &count, mask: &union, n_sites }
            }
        };
        let (receivers_name, others_name) = cell_names(self.receivers, &self.scene.field);
        let title = self.words.title_or(|| {
            let subject = match (&layer, self.coverages.len()) {
                (render::Layer::Field { .. }, _) => match self.layers.first() {
                    Some(Layer::Margin) => "Margin of line of sight in",
                    Some(Layer::Ceiling) => "Least receiver height in line of sight in",
                    _ => "Least UAV height that sees",
                },
                (render::Layer::Stability { .. }, _) => "Stability of line of sight in",
                (_, 1) => "What a UAV sees of",
                _ => "What the UAVs see of",
            };
            unbreakable(&format!("{subject} {}", self.scene.name))
        });
        let caption = self.caption(receivers_name);
        let picture = MapPicture {
            title: &title,
            caption: &caption,
            n_cols: window.n_cols,
            n_rows: window.n_rows,
            cell_m: (grid.cell_width() * unit, grid.cell_height() * unit),
            layer,
            surface_m: Some(&surface),
            uavs: &marks,
            receivers_name,
            others_name,
            counts: self.counts,
        };
        if as_vectors {
            render::draw_map_svg(&picture, provenance).map(String::into_bytes).map_err(undrawable)
        } else {
            render::draw_map(&picture, provenance).map_err(undrawable)
        }
    }

    /// The cells that may be in range of a UAV, with a border of a tenth; all of them without a radius.
    fn window_in_range(&self) -> CellWindow {
        let grid = self.scene.field.grid();
        let Some(radius) = self.report.radius_m.map(|r| self.scene.crs_units(r) * 1.1) else { return grid.window() };
        // Rows count from the north, positions from the south.
        let span = |low: f64, high: f64, n: usize| {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the grid")]
            let (low, high) = (low.floor().clamp(0.0, n as f64) as usize, high.ceil().clamp(0.0, n as f64) as usize);
            (low < high).then_some(low..high)
        };
        let union = |a: Option<std::ops::Range<usize>>, b: std::ops::Range<usize>| match a {
            Some(a) => a.start.min(b.start)..a.end.max(b.end),
            None => b,
        };
        let (mut cols, mut rows) = (None, None);
        for site in &self.report.sites {
            let (west, south) = grid.cells_from_world(site.x - radius, site.y - radius);
            let (east, north) = grid.cells_from_world(site.x + radius, site.y + radius);
            let height = grid.n_rows() as f64;
            let found = span(west, east, grid.n_cols()).zip(span(height - north, height - south, grid.n_rows()));
            if let Some((c, r)) = found {
                (cols, rows) = (Some(union(cols, c)), Some(union(rows, r)));
            }
        }
        match (cols, rows) {
            (Some(c), Some(r)) => {
                CellWindow { row: r.start, col: c.start, n_rows: r.end - r.start, n_cols: c.end - c.start }
            }
            _ => grid.window(),
        }
    }

    /// The part of a coverage that a picture shows.
    fn cropped(&self, site: &SiteCoverage, window: CellWindow) -> SiteCoverage {
        let n_cols = self.scene.field.grid().n_cols();
        let part = |values: &Option<Vec<f32>>| values.as_ref().map(|v| crop(v, n_cols, window));
        SiteCoverage {
            uav: site.uav.clone(),
            mask: crop(&site.mask, n_cols, window).into(),
            margin: part(&site.margin),
            ceiling: part(&site.ceiling),
            least_height: part(&site.least_height),
            stability: site
                .stability
                .as_ref()
                .map(|s| Stability { turns: crop(&s.turns, n_cols, window), ..s.clone() }),
            tally: site.tally,
        }
    }

    /// The layer that a picture of one site shows: the mask, or the first height layer if the mask was not asked for.
    fn single_layer<'b>(&self, site: &'b SiteCoverage) -> render::Layer<'b> {
        let mask = &site.mask;
        let field = |values: &'b Option<Vec<f32>>, name| {
            values.as_deref().map(|values| render::Layer::Field { values, name, unit: "m", mask })
        };
        let wanted = self.layers.iter().find_map(|layer| match layer {
            Layer::Los | Layer::Count | Layer::Which => Some(render::Layer::Los(mask)),
            Layer::Margin => field(&site.margin, "Margin: receiver height less ceiling"),
            Layer::Ceiling => field(&site.ceiling, "Ceiling, above the datum"),
            Layer::LeastHeight => field(&site.least_height, "Least UAV height, above the datum"),
            Layer::Stability => site.stability.as_ref().map(|s| render::Layer::Stability { turns: &s.turns, mask }),
        });
        wanted.unwrap_or(render::Layer::Los(mask))
    }

    fn caption(&self, receivers_name: &str) -> Vec<String> {
        let place = |s: &SiteFacts| format!("({}, {})", tidy(s.x), tidy(s.y));
        let in_range = if self.report.radius_m.is_some() { " in range" } else { "" };
        let share = |t: &Tally| match t.p_los() {
            Some(p) => format!(
                "P_LoS = {p:.4} ({} of {} {receivers_name}{in_range})",
                render::grouped(t.los),
                render::grouped(t.receivers)
            ),
            None => format!("P_LoS undefined: {}", t.reason()),
        };
        let mut lines: Vec<String> = Vec::new();
        const MOST_SITES: usize = 4;
        for s in self.report.sites.iter().take(MOST_SITES) {
            lines.push(format!("UAV {}: {} at {}, {}", s.id, height_words(s), place(s), share(&s.tally)));
        }
        if self.report.sites.len() > MOST_SITES {
            lines.push(format!("and {} more UAVs", self.report.sites.len() - MOST_SITES));
        }
        if self.report.sites.len() > 1 {
            lines.push(format!("Seen by at least one: {}", share(&self.report.union)));
        }
        if let (Some(Layer::Stability), [SiteFacts { stability: Some(stability), .. }]) =
            (self.layers.first(), self.report.sites.as_slice())
        {
            lines.push(stability.in_words());
        }
        let heights = (self.report.rx_height_m, self.report.radius_m);
        let facts = &self.report.facts;
        lines.push(setting_line_on(&facts.grid, self.scene, self.receivers, heights, facts.method));
        lines.extend(self.note.clone());
        lines.extend(self.report.tolerance.as_ref().map(tolerance_in_words));
        lines.extend(self.words.credit(self.scene.attribution.as_ref()));
        lines
    }
}
