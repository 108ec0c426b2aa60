//! Picture of a map: layer, marks, title, caption.

use skyshed_request::{Layer, Receivers};

use super::class_pictures::{ClassMap, MOST_COLORS, least_heights, nearest, seen_alone, what_is_sure, who_sees};
use super::coverages::Coverages;
use super::report::SiteFacts;
use super::tolerance::in_words as tolerance_in_words;
use crate::city::Antenna;
use crate::coverage::{Overlay, SiteCoverage, Stability, Tally, Uav};
use crate::error::Result;
use crate::export::Format;
use crate::picture::{Look, crop, mark, shown_classes, window_of, written};
use crate::quantity::tidy;
use crate::raster::CellWindow;
use crate::render::{self, MOST_MAP_PANELS, MOST_WITH_HEIGHTS, MapClass, MapPanel, MapPanels, MapPicture, Mark};
use crate::words::{capitalized, unbreakable};

/// Map to draw.
pub(crate) struct MapDrawing<'a> {
    pub(crate) of: &'a Coverages,
    pub(crate) look: &'a Look,
    /// Counts of the legend, if they are not those of the drawn cells.
    pub(crate) counts: Option<Tally>,
    /// Further line of the caption.
    pub(crate) note: Option<String>,
}

/// Subject of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Subject {
    /// A layer of the only UAV.
    One,
    /// Number of UAVs that see a cell.
    Count,
    /// UAVs, of a few, that see a cell.
    Who,
    /// Cells that any UAV sees.
    Any,
    /// Cells that every UAV sees.
    All,
    /// Nearest of a few UAVs that see a cell.
    Best,
    /// Time in which a cell is seen, or is not.
    Time,
    /// A layer of each UAV, side by side.
    Each,
}

/// Map before it is drawn.
enum Shown<'a> {
    Layer(render::Layer<'a>),
    /// Classes, with the mask that marks the receivers.
    Classes(ClassMap, &'a [u8]),
}

impl Shown<'_> {
    fn palette(&self) -> Vec<MapClass<'_>> {
        match self {
            Shown::Layer(_) => Vec::new(),
            Shown::Classes(map, _) => map.palette(),
        }
    }

    fn layer<'b>(&'b self, palette: &'b [MapClass<'b>]) -> render::Layer<'b> {
        match self {
            Shown::Layer(layer) => *layer,
            Shown::Classes(map, mask) => render::Layer::Classes { index: map.index(), palette, mask },
        }
    }
}

/// Returns `true` if the picture of several UAVs shows each of them, so that their masks are kept.
pub(crate) fn draws_each(layers: &[Layer]) -> bool {
    match layers.first() {
        None | Some(Layer::Los) => false,
        Some(layer) => *layer == Layer::Which || !layer.is_of_all(),
    }
}

impl MapDrawing<'_> {
    /// Draws the picture as a file of a format.
    pub(crate) fn draw(&self, format: Format, provenance: &[(String, String)]) -> Result<Vec<u8>> {
        let grid = self.of.scene.field.grid();
        // Cells out of range are not drawn.
        let window = self.window_in_range();
        let n_cols = grid.n_cols();
        let subject = self.subject();
        let overlay = self.of.overlay.as_ref();
        let all = overlay.filter(|_| subject == Subject::All).and_then(Overlay::all);
        let union = self.classes(all.or(overlay.map(Overlay::union)).unwrap_or_default(), window);
        let count = crop(self.of.overlay.as_ref().map_or(&[], Overlay::count), n_cols, window);
        let best = self.of.overlay.as_ref().and_then(Overlay::best_server).unwrap_or_default();
        let best = if best.is_empty() { Vec::new() } else { crop(best, n_cols, window) };
        let n_drawn = match subject {
            Subject::Count | Subject::Any | Subject::All | Subject::Best | Subject::Time => 0,
            Subject::Who => self.of.sites.len(),
            Subject::One | Subject::Each => self.of.sites.len().min(MOST_MAP_PANELS),
        };
        let sites: Vec<SiteCoverage> = self.of.sites[..n_drawn].iter().map(|s| self.cropped(s, window)).collect();
        let time = self.layer_of_time().map_or_else(Vec::new, |values| crop(values, n_cols, window));
        let shown = self.shown(subject, &sites, (&count, &best, &time), &union);
        let palettes: Vec<Vec<MapClass<'_>>> = shown.iter().map(Shown::palette).collect();
        let layers: Vec<render::Layer<'_>> = shown.iter().zip(&palettes).map(|(map, p)| map.layer(p)).collect();

        let part = grid.part(window);
        let heights: Vec<String> = self.of.report.sites.iter().map(SiteFacts::height_words).collect();
        let labels = self.labels(subject);
        let words = heights.iter().zip(&labels);
        let marks: Vec<Mark<'_>> = self
            .of
            .report
            .sites
            .iter()
            .zip(words)
            .map(|(site, (height, label))| Mark {
                is_observer: self.is_observer(site),
                ..mark(&part, (site.x, site.y), label, height)
            })
            .collect();
        let surface = crop(&self.of.scene.field.above_ground_m(), n_cols, window);
        let (receivers_name, others_name) = self.of.report.sight.receivers().cell_names(&self.of.scene.field);
        let title =
            self.look.title_or(|| unbreakable(&format!("{} {}", self.subject_words(subject), self.of.scene.name)));
        let caption = self.caption(subject, receivers_name);
        let unit = grid.meters_per_unit();
        let cell_m = (grid.cell_width() * unit, grid.cell_height() * unit);
        let form = self.look.form(format);
        let CellWindow { n_cols, n_rows, .. } = window;
        let (title, caption, surface_m) = (title.as_str(), caption.as_slice(), Some(surface.as_slice()));
        if subject == Subject::Each {
            let details: Vec<String> =
                self.of.report.sites.iter().zip(&palettes).map(|(s, p)| self.detail(s, p)).collect();
            let titles: Vec<String> = labels.iter().zip(&heights).map(|(l, h)| format!("{l} · {h}")).collect();
            let words = titles.iter().zip(&details);
            let maps: Vec<MapPanel<'_>> = layers
                .iter()
                .zip(words.zip(&marks))
                .map(|(layer, ((title, detail), mark))| MapPanel {
                    title,
                    detail,
                    layer: *layer,
                    mark: Mark { height: "", ..*mark },
                })
                .collect();
            let sheet = MapPanels { title, caption, n_cols, n_rows, cell_m, maps: &maps, surface_m, others_name };
            return written(render::draw_map_panels(&sheet), &form, provenance);
        }
        let picture = MapPicture {
            title,
            caption,
            n_cols,
            n_rows,
            cell_m,
            layer: layers[0],
            surface_m,
            uavs: &marks,
            is_in_air: self.is_in_air(),
            receivers_name,
            others_name,
            counts: self.counts,
        };
        written(render::draw_map(&picture), &form, provenance)
    }

    /// Returns the maps that the picture shows.
    fn shown<'b>(
        &self,
        subject: Subject,
        sites: &'b [SiteCoverage],
        (count, best, time): (&'b [u32], &[u32], &'b [f32]),
        union: &'b [u8],
    ) -> Vec<Shown<'b>> {
        let who = self.looked_at_by();
        match subject {
            Subject::Count => {
                let n_sites = u32::try_from(self.of.sites.len()).unwrap_or(u32::MAX);
                vec![Shown::Layer(render::Layer::Count { count, mask: union, n_sites })]
            }
            Subject::Any | Subject::All => vec![Shown::Layer(render::Layer::Los(union))],
            Subject::Time => {
                let (name, unit) = match self.drawn_layer() {
                    Layer::Gap => ("Longest time out of sight", "min"),
                    _ => ("Share of time in line of sight", ""),
                };
                vec![Shown::Layer(render::Layer::Field { values: time, name, unit, mask: union })]
            }
            Subject::Best => {
                let names: Vec<&str> = self.of.report.sites.iter().map(|site| site.id.as_str()).collect();
                vec![Shown::Classes(nearest(who, &names, best, union), union)]
            }
            Subject::Who => {
                let named: Vec<(&str, &[u8])> = sites.iter().map(|s| (s.uav.id.as_str(), s.mask.as_slice())).collect();
                vec![Shown::Classes(who_sees(who, &named, count, union), union)]
            }
            Subject::One | Subject::Each => sites.iter().map(|site| self.shown_of(site, count, union)).collect(),
        }
    }

    /// Returns the labels of the marks; in a crowd, ids alone.
    fn labels(&self, subject: Subject) -> Vec<String> {
        let is_crowd = subject != Subject::Each && self.of.sites.len() > MOST_WITH_HEIGHTS;
        let label = |s: &SiteFacts| {
            if is_crowd { s.id.clone() } else { capitalized(&format!("{} {}", self.looks(s), s.id)) }
        };
        self.of.report.sites.iter().map(label).collect()
    }

    /// Returns the drawn layer: the first one requested.
    fn drawn_layer(&self) -> Layer {
        self.of.layers.first().copied().unwrap_or(Layer::Los)
    }

    fn subject(&self) -> Subject {
        match (self.drawn_layer(), self.of.sites.len()) {
            (Layer::Uptime | Layer::Gap, _) => Subject::Time,
            (_, 1) if self.of.report.tile.is_none() => Subject::One,
            (Layer::Union, _) => Subject::Any,
            (Layer::All, _) => Subject::All,
            (Layer::BestServer, n) if n <= MOST_COLORS => Subject::Best,
            (Layer::BestServer, _) => Subject::Count,
            (Layer::Los | Layer::Count, _) => Subject::Count,
            (Layer::Which, n) if n <= MOST_COLORS => Subject::Who,
            _ => Subject::Each,
        }
    }

    /// Returns the values of the drawn layer of time; `None` if another one is drawn.
    fn layer_of_time(&self) -> Option<&[f32]> {
        match self.drawn_layer() {
            Layer::Uptime => self.of.uptime(),
            Layer::Gap => self.of.gap(),
            _ => None,
        }
    }

    fn is_in_air(&self) -> bool {
        self.of.report.sight.receivers() == Receivers::Air
    }

    /// Returns `true` if a site is an observer, who stands on the ground or a roof.
    fn is_observer(&self, site: &SiteFacts) -> bool {
        let of = &self.of;
        of.report.sight.receivers().has_observer(&of.scene.field, (site.x, site.y), site.height_amsl_m)
    }

    /// Returns `true` if receivers are in the air and all sites are observers.
    fn are_observers(&self) -> bool {
        self.is_in_air() && self.of.report.sites.iter().all(|site| self.is_observer(site))
    }

    /// Returns the noun for a site.
    fn looks(&self, site: &SiteFacts) -> &'static str {
        if self.is_observer(site) { "observer" } else { "UAV" }
    }

    /// Returns the noun for all sites.
    fn looked_at_by(&self) -> &'static str {
        if self.are_observers() { "observer" } else { "UAV" }
    }

    fn subject_words(&self, subject: Subject) -> &'static str {
        if self.is_in_air() {
            return match (self.drawn_layer(), subject, self.are_observers()) {
                (Layer::Margin, ..) => "Margin of a drone's line of sight over",
                (Layer::LeastReceiverHeight, ..) => "Least height of a drone in sight over",
                (Layer::LeastHeight, _, true) => "How high an observer must be to see a drone over",
                (Layer::LeastHeight, _, false) => "How high a UAV must hover to see a drone over",
                (Layer::Stability, ..) => "Stability of a drone's line of sight over",
                (Layer::Sure, ..) => "What is sure of a drone's line of sight over",
                (Layer::PLos, ..) => "Probability of a drone's line of sight over",
                (Layer::Uptime, ..) => "How much of the time a drone is seen over",
                (Layer::Gap, ..) => "How long a drone is not seen over",
                (_, Subject::One, true) => "Where an observer sees a drone over",
                (_, Subject::One, false) => "Where a UAV sees a drone over",
                (_, Subject::Any, true) => "Where at least one observer sees a drone over",
                (_, Subject::Any, false) => "Where at least one UAV sees a drone over",
                (_, Subject::All, true) => "Where all observers see a drone over",
                (_, Subject::All, false) => "Where all UAVs see a drone over",
                (_, Subject::Best, true) => "The nearest observer who sees a drone over",
                (_, Subject::Best, false) => "The nearest UAV that sees a drone over",
                (_, _, true) => "Where the observers see a drone over",
                (_, _, false) => "Where the UAVs see a drone over",
            };
        }
        match (self.drawn_layer(), subject) {
            (Layer::Margin, _) => "Margin of line of sight in",
            (Layer::LeastReceiverHeight, _) => "Least receiver height in line of sight in",
            (Layer::LeastHeight, _) => "How high a UAV must hover to see each place of",
            (Layer::Stability, _) => "Stability of line of sight in",
            (Layer::Sure, _) => "What is sure of line of sight in",
            (Layer::PLos, _) => "Probability of line of sight in",
            (Layer::Uptime, _) => "How much of the time UAVs see each place of",
            (Layer::Gap, _) => "How long no UAV sees each place of",
            (_, Subject::One) => "What a UAV sees of",
            (Layer::Which, _) => "Which UAV sees what of",
            (_, Subject::Any) => "What at least one UAV sees of",
            (_, Subject::All) => "What every UAV sees of",
            (_, Subject::Best) => "The nearest UAV that sees each place of",
            _ => "What the UAVs see of",
        }
    }

    /// Returns the cells that may be in range of a UAV, with a border of a tenth of its reach; all cells if
    /// a UAV has no limit.
    fn window_in_range(&self) -> CellWindow {
        let grid = self.of.scene.field.grid();
        let around = |s: &SiteFacts| {
            let reach = 1.1 * self.of.report.sight.reach_m(s.antenna)? / grid.meters_per_unit();
            Some([s.x - reach, s.y - reach, s.x + reach, s.y + reach])
        };
        let boxes = self.of.report.sites.iter().map(around).collect::<Option<Vec<_>>>();
        boxes.map_or_else(|| grid.window(), |boxes| window_of(grid, boxes.into_iter()))
    }

    /// Returns the classes of a mask in a window as they are drawn. A map that is drawn smaller
    /// keeps the classes that were counted.
    fn classes(&self, mask: &[u8], window: CellWindow) -> Vec<u8> {
        let field = &self.of.scene.field;
        match self.counts {
            Some(_) => crop(mask, field.grid().n_cols(), window),
            None => shown_classes(mask, field, window),
        }
    }

    /// Returns the part of a coverage that the picture shows.
    fn cropped(&self, site: &SiteCoverage, window: CellWindow) -> SiteCoverage {
        let n_cols = self.of.scene.field.grid().n_cols();
        let part = |values: &Option<Vec<f32>>| values.as_ref().map(|v| crop(v, n_cols, window));
        SiteCoverage {
            uav: site.uav.clone(),
            mask: self.classes(&site.mask, window).into(),
            margin: part(&site.margin),
            least_receiver_height: part(&site.least_receiver_height),
            least_height: part(&site.least_height),
            stability: site
                .stability
                .as_ref()
                .map(|s| Stability { turns: crop(&s.turns, n_cols, window), ..s.clone() }),
            sure: part(&site.sure),
            p_los: part(&site.p_los),
            tally: site.tally,
        }
    }

    /// Returns the drawn layer of one UAV.
    fn shown_of<'b>(&self, site: &'b SiteCoverage, count: &[u32], union: &'b [u8]) -> Shown<'b> {
        let mask = &site.mask;
        let field = |values: &'b Option<Vec<f32>>, name| {
            values.as_deref().map(|values| Shown::Layer(render::Layer::Field { values, name, unit: "m", mask }))
        };
        let wanted = match self.drawn_layer() {
            Layer::Which if !union.is_empty() => {
                Some(Shown::Classes(seen_alone(self.looked_at_by(), mask, count, union), union))
            }
            Layer::Margin => field(&site.margin, "Margin: receiver height less least visible height"),
            Layer::LeastReceiverHeight => field(&site.least_receiver_height, "Least receiver height, above the datum"),
            Layer::LeastHeight => site.least_height.as_deref().map(|least| {
                let (base_m, above) = ground_below(&site.uav);
                Shown::Classes(least_heights(least, mask, base_m, above), mask)
            }),
            Layer::Sure => site.sure.as_deref().map(|sure| Shown::Classes(what_is_sure(sure, mask), mask)),
            Layer::PLos => site.p_los.as_deref().map(|values| {
                Shown::Layer(render::Layer::Field { values, name: "Probability of line of sight", unit: "", mask })
            }),
            Layer::Stability => {
                site.stability.as_ref().map(|s| Shown::Layer(render::Layer::Stability { turns: &s.turns, mask }))
            }
            _ => None,
        };
        wanted.unwrap_or(Shown::Layer(render::Layer::Los(mask)))
    }

    /// Returns the line below the title of a small map.
    fn detail(&self, site: &SiteFacts, palette: &[MapClass<'_>]) -> String {
        let p_los = site.tally.p_los().map_or("P_LoS undefined".to_string(), |p| format!("P_LoS = {p:.4}"));
        match (self.drawn_layer(), palette) {
            (Layer::Which, [.., alone]) => format!("{p_los}, alone {}", alone.detail),
            (Layer::LeastHeight, _) if site.height_agl_m.is_some() => {
                format!("{p_los}, ground at {} m", tidy(site.height_amsl_m - site.height_agl_m.unwrap_or(0.0)))
            }
            _ => p_los,
        }
    }

    /// Returns lines that explain the drawn layer.
    fn reading(&self, subject: Subject) -> Vec<String> {
        let n = self.of.sites.len();
        let mut lines = Vec::new();
        if self.drawn_layer() == Layer::LeastHeight {
            let who = self.looked_at_by();
            let above = match self.of.report.sites.as_slice() {
                [SiteFacts { height_agl_m: None, .. }] => format!("the datum; no ground is known below the {who}"),
                [SiteFacts { height_agl_m: Some(agl), height_amsl_m, .. }] => {
                    format!("the ground below the {who}, which is {} m above the datum", tidy(height_amsl_m - agl))
                }
                _ => format!("the ground below each {who}"),
            };
            lines.push(format!("Colors tell the least height of the {who} over its place from which a cell is in line of sight, above {above}"));
            lines.push("Files hold these heights above the datum".to_string());
        }
        if self.drawn_layer() == Layer::BestServer && subject == Subject::Count {
            lines.push(format!(
                "Of {n} UAVs the nearest is not drawn, but how many see a place; a .tif file holds both"
            ));
        }
        if let Some(span) = self.of.report.span.filter(|_| subject == Subject::Time) {
            let (from, to, minutes) = span.words();
            lines.push(format!("Time from {from} to {to} ({minutes} min), in which UAVs come and go"));
        }
        if subject == Subject::Each && n > MOST_MAP_PANELS {
            let rest = if self.drawn_layer() == Layer::Which { "; the rest are among the others" } else { "" };
            lines.push(format!("Of {n} UAVs the first {MOST_MAP_PANELS} are drawn{rest}; a .tif file holds all"));
        }
        lines
    }

    fn caption(&self, subject: Subject, receivers_name: &str) -> Vec<String> {
        let of = &self.of.report;
        let is_limited = of.sight.is_limited() || of.sites.iter().any(|site| site.antenna != Antenna::default());
        let in_range = if is_limited { " in range" } else { "" };
        let share = |t: &Tally| match t.p_los() {
            Some(p) => format!(
                "P_LoS = {p:.4} ({} of {} {receivers_name}{in_range})",
                render::grouped(t.los),
                render::grouped(t.receivers)
            ),
            None => format!("P_LoS undefined: {}", t.reason()),
        };
        let mut lines: Vec<String> = Vec::new();
        // The first line is emphasized, which suits no single one of several UAVs.
        if let Some(all) = self.of.overlay.as_ref().and_then(Overlay::all).filter(|_| subject == Subject::All) {
            let tally = self.of.sites.iter().fold(Tally::of_mask(all), |tally, site| tally.of_uav(&site.uav));
            lines.push(format!("Seen by every {}: {}", self.looked_at_by(), share(&tally)));
        }
        if self.of.report.sites.len() > 1 {
            lines.push(format!("Seen by at least one: {}", share(&self.of.report.union)));
        }
        const MOST_SITES: usize = 4;
        for s in self.of.report.sites.iter().take(MOST_SITES) {
            let who = self.looks(s);
            let (id, height, place, own) = (&s.id, s.height_words(), s.position().in_words(), s.antenna.in_words());
            let own = if own.is_empty() { own } else { format!(", {own}") };
            let interval = s.uncertain.and_then(|uncertain| uncertain.interval);
            let interval = interval.map_or(String::new(), |interval| format!(", {}", interval.in_words()));
            lines.push(capitalized(&format!("{who} {id}: {height} at {place}{own}, {}{interval}", share(&s.tally))));
        }
        if self.of.report.sites.len() > MOST_SITES {
            lines.push(format!("and {} more {}s", self.of.report.sites.len() - MOST_SITES, self.looked_at_by()));
        }
        lines.extend(self.reading(subject));
        lines.extend(of.heights.in_words());
        if let (Layer::Stability, [SiteFacts { stability: Some(stability), .. }]) =
            (self.drawn_layer(), self.of.report.sites.as_slice())
        {
            lines.push(stability.in_words());
        }
        let facts = &self.of.report.facts;
        lines.push(self.of.report.sight.in_words(&facts.grid, &self.of.scene, facts.method));
        lines.extend(self.of.scene.limits_in_words());
        lines.extend(self.note.clone());
        lines.extend(self.of.report.tolerance.as_ref().map(tolerance_in_words));
        lines.extend(self.look.credit(self.of.scene.attribution.as_ref()));
        lines
    }
}

/// Returns the level from which heights are counted \[m above the datum\], and its name.
fn ground_below(uav: &Uav) -> (f64, &'static str) {
    uav.height_agl_m.map_or((0.0, "the datum"), |agl| (uav.height_amsl_m() - agl, "ground"))
}
