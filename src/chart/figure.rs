//! Contents of a chart: words, points and lines.

use super::plos_report::{PlosChartReport, PlosChartRow};
use super::report::ChartReport;
use crate::accuracy::chart::Family;
use crate::accuracy::plos_cost::PlosWay;
use crate::answer::Position;
use crate::coverage::Uav;
use crate::error::Result;
use crate::los_probability::models::Model;
use crate::method_looks::look_of;
use crate::picture::{Look, program, written};
use crate::quantity::{counted, tidy};
use crate::render::{PictureForm, Tradeoff, TradeoffPoint, draw_tradeoff, grouped};
use crate::scene::Scene;
use crate::words::unbreakable;

/// A picture with its words.
#[derive(Debug)]
pub(super) struct Picture {
    title: String,
    caption: Vec<String>,
    names: Names,
    floor_ns: Option<f64>,
    points: Vec<Point>,
    front: Vec<usize>,
}

/// Names of the axes.
#[derive(Debug)]
struct Names {
    cost: &'static str,
    error: &'static str,
    zero: &'static str,
}

/// A contestant.
#[derive(Debug)]
struct Point {
    label: String,
    family: &'static str,
    look: usize,
    place: Option<(f64, f64)>,
    bias: Option<f64>,
}

/// Most UAVs that a caption lists.
const MOST_UAVS: usize = 4;

impl Picture {
    /// Draws the picture as a file.
    pub(super) fn draw(&self, form: &PictureForm, provenance: &[(String, String)]) -> Result<Vec<u8>> {
        let points: Vec<TradeoffPoint<'_>> = self
            .points
            .iter()
            .map(|p| {
                let Point { label, family, look, place, bias } = p;
                TradeoffPoint { label, family, look: *look, place: *place, bias: *bias }
            })
            .collect();
        let plot = Tradeoff {
            title: &self.title,
            caption: &self.caption,
            cost_name: self.names.cost,
            error_name: self.names.error,
            zero_name: self.names.zero,
            bias_name: "Bias of P_LoS [percentage points]",
            floor: self.floor_ns.map(|floor| (floor, "memory floor: read heights, write mask")),
            points: &points,
            front: &self.front,
        };
        written(draw_tradeoff(&plot), form, provenance)
    }
}

/// Returns the picture of a scene.
pub(super) fn of_scene(look: &Look, scene: &Scene, report: &ChartReport) -> Picture {
    let mut points = Vec::new();
    let mut front = Vec::new();
    let on_front = report.front();
    // Families stay together, in whatever order the rows are.
    for (marker, family) in Family::ALL.into_iter().enumerate() {
        for (k, row) in report.rows.iter().enumerate().filter(|(_, row)| row.family == family) {
            if let Some(rank) = on_front.iter().position(|on| *on == k) {
                front.push((rank, points.len()));
            }
            let bias = row.result.as_ref().ok().and_then(|(_, counts)| report.truth.p_los_error(counts));
            points.push(Point {
                label: row.label.clone(),
                family: family.in_words(),
                look: marker,
                place: row.place(),
                bias: bias.map(|bias| 100.0 * bias),
            });
        }
    }
    front.sort_unstable();
    Picture {
        title: title(look, &scene.name, report.is_interrupted()),
        caption: caption_of_scene(look, scene, report),
        names: Names {
            cost: "CPU time per receiver [ns]",
            error: "Wrong receivers [share of all]",
            zero: "0: none wrong",
        },
        floor_ns: report.floor_ns(),
        points,
        front: front.into_iter().map(|(_, point)| point).collect(),
    }
}

fn title(look: &Look, name: &str, is_interrupted: bool) -> String {
    let title = look.title_or(|| format!("Speed against accuracy: {name}"));
    unbreakable(&if is_interrupted { format!("{title} (interrupted)") } else { title })
}

fn uav_words((uav, lonlat): &(Uav, Option<[f64; 2]>)) -> String {
    let at = Position { x: uav.station.place.x, y: uav.station.place.y, lonlat: *lonlat }.in_words();
    match uav.height_agl_m {
        Some(agl) => format!("UAV {} at {at}, {} m above ground", uav.id, tidy(agl)),
        None => format!("UAV {} at {at}, {} m above the datum", uav.id, tidy(uav.height_amsl_m())),
    }
}

fn caption_of_scene(look: &Look, scene: &Scene, report: &ChartReport) -> Vec<String> {
    let truth = &report.truth;
    let (receivers, _) = report.sight.receivers().cell_names(&scene.field);
    let uavs: Vec<String> = report.uavs.iter().take(MOST_UAVS).map(uav_words).collect();
    let more = report.uavs.len().saturating_sub(MOST_UAVS);
    let more = if more > 0 { format!("; and {more} more, counts summed") } else { String::new() };
    let p_los = truth.p_los().filter(|_| !report.is_over_nodata).map_or("undefined".to_string(), |p| format!("{p:.4}"));
    let exact = match truth.checked {
        None => format!("exact by {}", truth.method),
        Some(checked) => format!("exact by {}, which ray confirms on {} links", truth.method, grouped(checked)),
    };
    let mut lines = vec![
        format!("{}{more}; {} {receivers}, P_LoS = {p_los}, {exact}.", uavs.join("; "), grouped(truth.receivers())),
        format!("{} The line joins what nothing beats in both.", timing_words(report.threads)),
        "Wrong receivers and P_LoS are counts: the same on every machine. A receiver takes the answer of the cell that holds \
         its center; P_LoS is over each one's own receivers. Scenes are read and cells made larger before the clock starts."
            .to_string(),
    ];
    if report.rows.iter().any(|row| row.family == Family::Peer && row.result.is_ok()) {
        let peer = report.rows.iter().find(|row| row.family == Family::Peer);
        let version = peer.map_or("", |row| row.parameters.as_str());
        lines.push(format!("gdal_viewshed ({version}) reads the surface from a file and writes its mask into one."));
    }
    if report.is_interrupted() {
        lines.push(format!("Interrupted: {} of {} contestants had their turn.", report.rows.len(), report.planned));
    }
    let reasons = report.rows.iter().filter_map(|row| Some((row, row.result.as_ref().err()?)));
    lines.extend(reasons.map(|(row, reason)| format!("No answer of {}: {reason}.", row.label)));
    lines.push(report.sight.in_words(scene.grid(), scene, report.facts.method));
    lines.extend(scene.last_lines(look));
    lines.iter().map(|line| unbreakable(line)).collect()
}

/// Returns the remark on all times.
fn timing_words(threads: u16) -> String {
    let threads = counted(u64::from(threads), "thread", "threads");
    format!(
        "CPU time is user time of this machine, {threads}, warm, the median of groups of runs, whose number the table tells."
    )
}

/// Returns the picture of the methods of P_LoS.
pub(super) fn of_plos(look: &Look, report: &PlosChartReport) -> Picture {
    let point = |row: &PlosChartRow| {
        let family = match row.way {
            PlosWay::Product(_) => "Product over buildings",
            PlosWay::City(_) => "3-D city simulator",
            PlosWay::Geometry(_) => "Geometry simulator",
            PlosWay::Model(_) => "Published models",
        };
        let (_, marker) = look_of(row.way.method(), &[]);
        let bias = report.p_los_error(row).map(|error| 100.0 * error);
        Point { label: plos_label(row.way), family, look: marker, place: report.place(row), bias }
    };
    // Models without a value are listed in the caption, not drawn.
    let shown: Vec<usize> = (0..report.rows.len()).filter(|k| report.rows[*k].result.is_ok()).collect();
    let front = report.front().into_iter().filter_map(|k| shown.iter().position(|s| *s == k)).collect();
    Picture {
        title: title(look, &format!("P_LoS of {}", report.city), report.is_interrupted()),
        caption: caption_of_plos(look, report),
        names: Names { cost: "CPU time [s]", error: "Standard error of P_LoS; |bias| of models", zero: "0: no error" },
        floor_ns: None,
        points: shown.iter().map(|k| point(&report.rows[*k])).collect(),
        front,
    }
}

fn plos_label(way: PlosWay) -> String {
    match way {
        PlosWay::Product(points) => format!("{} points", grouped(points * 32)),
        PlosWay::City(cities) => format!("{} cities", grouped(cities)),
        PlosWay::Geometry(links) => format!("{} links", grouped(links)),
        PlosWay::Model(model) => model.id().to_string(),
    }
}

fn caption_of_plos(look: &Look, report: &PlosChartReport) -> Vec<String> {
    let setting = &report.setting;
    let reference = match (report.reference.p_los, report.reference.std_error) {
        (Some(p_los), Some(error)) => format!("P_LoS = {p_los:.6} ± {error:.0e}"),
        _ => "P_LoS undefined".to_string(),
    };
    let mut lines = vec![
        format!(
            "{}, {}: θ = {}°, UAV {} m and users {} m above ground, users outdoors, mean over all azimuths and places.",
            report.city,
            setting.built_up,
            tidy(setting.theta_deg().unwrap_or_default()),
            tidy(setting.uav_height_m),
            tidy(setting.rx_height_m)
        ),
        format!(
            "Bias is the difference to the converged product, {reference}, of other points; for an estimate it is chance, of the \
             size of its standard error. {}",
            timing_words(report.threads)
        ),
        "Standard errors and biases are the same on every machine. The line joins what nothing beats in both."
            .to_string(),
    ];
    if report.is_interrupted() {
        lines.push(format!("Interrupted: {} of {} contestants had their turn.", report.rows.len(), report.planned));
    }
    let silent: Vec<&str> = report
        .rows
        .iter()
        .filter(|row| row.result.is_err())
        .map(|row| match row.way {
            PlosWay::Model(model) => Model::id(model),
            way => way.method(),
        })
        .collect();
    if !silent.is_empty() {
        lines.push(format!("Without an answer here: {}; the table tells why.", silent.join(", ")));
    }
    lines.push(format!("Seed {}; {}", report.seed, program()));
    lines.extend(look.credit(None));
    lines.iter().map(|line| unbreakable(line)).collect()
}
