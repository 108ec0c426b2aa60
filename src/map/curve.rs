//! P_LoS against the UAV's height, as plot, table and document.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::Value;

use skyshed_request::Receivers;

use super::coverages::Coverages;
use super::curve_report::{CurveFacts, HeightCurveReport};
use crate::answer::{Answer, Output, Rows, Spent};
use crate::coverage::{HeightCurve, HeightLayers, MapOptions, Mapper, SiteCoverage};
use crate::error::{Error, OddRun, RequestError, Result, Warning};
use crate::export::{Batch, Format, OutputRules, check_outputs};
use crate::picture::{Look, crs_words, picture_provenance, program, written};
use crate::progress::Progress;
use crate::quantity::{MAX_HEIGHT_M, height_steps, meters, tidy};
use crate::render::{self, HeightCurveLine, HeightCurvePlot};
use crate::scene::Scene;
use crate::words::{capitalized, unbreakable};

/// Formats of a curve.
const FORMATS: [Format; 5] = [Format::Png, Format::Svg, Format::Pdf, Format::Csv, Format::Json];

/// Approximate number of rows of a table by default.
const ROWS: f64 = 150.0;

/// Largest number of heights of a curve; more are refused.
const MOST_HEIGHTS: f64 = 1e6;

/// Files of curves, and the heights in them.
#[derive(Debug, Clone, Default)]
pub(crate) struct CurvePlan {
    pub(crate) outputs: Vec<PathBuf>,
    /// From, to, step \[m\].
    pub(crate) heights: Option<[f64; 3]>,
}

impl CurvePlan {
    /// Checks the files and heights before any work, and returns the files with their formats.
    /// `others` are the files of the map.
    pub(crate) fn checked(&self, others: &[PathBuf], rules: OutputRules<'_>) -> Result<Vec<Output>> {
        let outputs = check_outputs(&self.outputs, OutputRules { allowed: &FORMATS, bare: false, ..rules })?;
        // No file may be an output of both kinds.
        let all: Vec<PathBuf> = others.iter().chain(&self.outputs).cloned().collect();
        check_outputs(&all, OutputRules { bare: false, ..rules })?;
        check_heights(self.heights)?;
        Ok(outputs)
    }

    /// Returns `true` if files of curves are requested.
    pub(crate) fn is_wanted(&self) -> bool {
        !self.outputs.is_empty()
    }

    /// Makes the curves of a map; `None` if none are wanted.
    pub(crate) fn make(&self, map: &Coverages, progress: &Progress) -> Result<Option<Curves>> {
        if self.is_wanted() { map.height_curves(self.heights, progress).map(Some) } else { Ok(None) }
    }
}

impl Coverages {
    /// Returns P_LoS against the height of each UAV. `asked` holds heights above the ground below
    /// it: from, to, step \[m\]. `None` chooses them.
    ///
    /// # Errors
    /// E113; E116 for antennas that limit elevations or the slant range; `Interrupted`.
    pub(crate) fn height_curves(&self, asked: Option<[f64; 3]>, progress: &Progress) -> Result<Curves> {
        check_heights(asked)?;
        let run = self.report.sight.antenna();
        if self.sites.iter().any(|site| site.uav.antenna.or(run).limits_heights()) {
            let why = "with elevations, a beam or a slant range: who is in range would change with the height";
            return Err(Error::idle("a height curve", why));
        }
        let start = Instant::now();
        let (field, report) = (&self.scene.field, &self.report);
        let options = MapOptions { layers: HeightLayers::default(), ..self.options.clone() };
        let mapper = Mapper::new(field, &options)?;
        progress.begin(field.grid().n_cells() as u64 * self.sites.len() as u64);
        let of = |site: &SiteCoverage| mapper.seen_from(&site.uav)?.height_curve(progress.control());
        let curves: Vec<HeightCurve> = self.sites.iter().map(of).collect::<std::result::Result<_, _>>()?;
        progress.end();
        let range = asked.unwrap_or_else(|| default_range(&curves, field.max_top()));
        let heights = heights_in(range);
        let mut warnings = Vec::new();
        let mut sites = Vec::new();
        for (curve, site) in curves.into_iter().zip(&report.sites) {
            let base = curve.ground().unwrap_or(0);
            let on_lattice =
                |h: &f64| height_steps(*h).map(|steps| base + steps).filter(|z| meters(*z) <= MAX_HEIGHT_M);
            let mut heights: Vec<i32> = heights.iter().filter_map(on_lattice).collect();
            let n_below = heights.partition_point(|z| *z < curve.lowest_height());
            if asked.is_none() {
                heights.drain(..n_below);
            } else if n_below > 0 {
                let lowest = above_base(&curve, curve.lowest_height());
                let (id, n, of) = (site.id.clone(), n_below, heights.len());
                warnings.push(OddRun::LowHeights { id, lowest, n, of }.into());
            }
            sites.push(CurveFacts { site: site.clone(), curve, heights });
        }
        let mut report = HeightCurveReport::of(report, sites);
        report.facts.warnings.extend(warnings.iter().cloned());
        let seconds = start.elapsed().as_secs_f64();
        Ok(Curves { scene: self.scene.clone(), report, range, warnings, seconds })
    }
}

/// Refuses heights that make no curve.
///
/// # Errors
/// E113.
fn check_heights(asked: Option<[f64; 3]>) -> Result<()> {
    if let Some(heights @ [from, to, step]) = asked {
        let refuse = |wanted| Err(RequestError::CurveHeights { heights, wanted }.into());
        if from > to {
            return refuse("A:B:S with A not above B");
        }
        if step <= 0.0 {
            return refuse("a step above 0 m");
        }
        if from < to && step > to - from {
            return refuse("a step that fits between A and B");
        }
        if from.abs().max(to.abs()) > MAX_HEIGHT_M {
            return refuse("heights within ±32768 m");
        }
        if (to - from) / step >= MOST_HEIGHTS {
            return refuse("at most 1000000 heights");
        }
    }
    Ok(())
}

/// Curves of a run, ready for files.
#[derive(Debug)]
pub(crate) struct Curves {
    scene: Scene,
    report: HeightCurveReport,
    range: [f64; 3],
    warnings: Vec<Warning>,
    seconds: f64,
}

impl Answer for Curves {
    fn document(&self, _spent: Option<Spent>) -> Value {
        self.report.document(true)
    }

    fn provenance(&self) -> Value {
        self.report.document(false)
    }

    fn table(&self) -> Rows {
        self.report.table()
    }

    /// Returns the warnings about the curves alone.
    fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    fn notes(&self, _spent: Spent) -> Vec<String> {
        let curves = self.curves().filter(|curve| curve.receivers() > 0);
        let found = curves.map(|curve| format!("{}: {}", self.name_of(&curve.uav().id), reaches(curve)));
        let method = self.report.facts.method_name();
        found.chain([format!("height curve, method {method} (exact): {:.2} s", self.seconds)]).collect()
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
        Ok(batch.add(path, &self.plot(look, format)?)?)
    }
}

impl Curves {
    fn curves(&self) -> impl Iterator<Item = &HeightCurve> + Clone {
        self.report.sites.iter().map(|site| &site.curve)
    }

    fn plot(&self, look: &Look, format: Format) -> Result<Vec<u8>> {
        // All curves share one axis: above ground, or above the datum if the ground below any UAV
        // is unknown.
        let is_agl = self.curves().all(|c| c.ground().is_some());
        let base = |curve: &HeightCurve| if is_agl { curve.ground().unwrap_or(0) } else { 0 };
        let above = |curve: &HeightCurve, z: i32| meters(z) - meters(base(curve));
        let asked = |curve: &HeightCurve| curve.uav().height_amsl_m() - meters(base(curve));
        let [from, to, _] = self.range;
        // The range is above each UAV's ground; above a common datum it covers all of them.
        let shift = |curve: &HeightCurve| meters(curve.ground().unwrap_or(0)) - meters(base(curve));
        let low = self.curves().map(|c| (from + shift(c)).min(asked(c))).fold(f64::INFINITY, f64::min);
        let high = self.curves().map(|c| (to + shift(c)).max(asked(c))).fold(f64::NEG_INFINITY, f64::max);
        let heights_m = if low < high { [low, high] } else { [low - 1.0, low + 1.0] };

        let steps: Vec<Vec<(f64, f64)>> = self
            .curves()
            .map(|c| c.steps().iter().filter_map(|(z, _)| Some((above(c, *z), c.p_los_at(*z)?))).collect())
            .collect();
        let labels: Vec<String> = self.curves().map(|c| self.name_of(&c.uav().id)).collect();
        let lines: Vec<HeightCurveLine<'_>> = self
            .curves()
            .zip(steps.iter().zip(&labels))
            .map(|(curve, (steps, label))| HeightCurveLine {
                label,
                lowest_m: above(curve, curve.lowest_height()),
                steps,
                marked_m: asked(curve),
            })
            .collect();
        let title = look
            .title_or(|| unbreakable(&format!("P_LoS against the height of {} over {}", self.whom(), self.scene.name)));
        let caption = self.caption(look);
        let plot = HeightCurvePlot {
            title: &title,
            caption: &caption,
            height_name: &self.name_of(if is_agl { "height above ground" } else { "height above the datum" }),
            heights_m,
            curves: &lines,
        };
        let provenance = picture_provenance(&self.provenance());
        written(render::draw_height_curve(&plot), &look.form(format), &provenance)
    }

    /// Returns the noun for the sites.
    fn looked_at_by(&self) -> &'static str {
        self.report.sight.receivers().other_end()
    }

    /// Returns the noun for the sites and `what`, capitalized for the beginning of a line.
    fn name_of(&self, what: &str) -> String {
        capitalized(&format!("{} {what}", self.looked_at_by()))
    }

    /// Returns the noun for the sites with its article, or its plural for several.
    fn whom(&self) -> String {
        match self.report.sites.len() {
            1 => self.report.sight.receivers().an_other_end().to_string(),
            _ => format!("{}s", self.looked_at_by()),
        }
    }

    fn caption(&self, look: &Look) -> Vec<String> {
        const MOST_SITES: usize = 4;
        let mut lines: Vec<String> = Vec::new();
        for CurveFacts { site, curve, .. } in self.report.sites.iter().take(MOST_SITES) {
            let asked = curve.uav().height_amsl_m() - meters(curve.ground().unwrap_or(0));
            let base = if curve.ground().is_some() { "ground" } else { "the datum" };
            let place = site.position().in_words();
            let p_los = match site.tally.p_los() {
                Some(p) => format!("P_LoS = {p:.4} at {} m above {base}; {}", tidy(asked), reaches(curve)),
                None => format!("P_LoS undefined: {}", site.tally.reason()),
            };
            let is_above_ground = curve.ground().is_some_and(|ground| curve.lowest_height() > ground);
            let roof = if is_above_ground {
                format!("; the curve begins at the roof, {}", above_base(curve, curve.lowest_height()))
            } else {
                String::new()
            };
            lines.push(format!("{} at {place}: {p_los}{roof}", self.name_of(&site.id)));
        }
        if self.report.sites.len() > MOST_SITES {
            lines.push(format!("and {} more {}s", self.report.sites.len() - MOST_SITES, self.looked_at_by()));
        }
        let sight = &self.report.sight;
        let stands = match sight.receivers() {
            _ if self.scene.field.is_surface_only() => "the surface",
            Receivers::Roof => "roofs",
            Receivers::All => "ground and roofs",
            Receivers::Air => "the ground, buildings included,",
            Receivers::Street => "the ground of streets",
            Receivers::Crossroad => "the ground of crossroads",
            Receivers::Courtyard => "the ground of courtyards",
            _ => "ground",
        };
        let range = sight.range_in_words();
        let receivers = format!(
            "Receivers {} m above {stands}{range}; method {} (exact at every height); {}; {}",
            tidy(sight.rx_height_m()),
            self.report.facts.method_name(),
            crs_words(self.scene.grid()),
            program()
        );
        // The first line is emphasized, which suits no single one of several UAVs.
        lines.insert(if self.report.sites.len() > 1 { 0 } else { lines.len() }, receivers);
        lines.extend(self.scene.last_lines(look));
        lines
    }
}

/// Returns a height in words. It is rounded up to a centimeter, so that the written height is high
/// enough.
fn above_base(curve: &HeightCurve, height: i32) -> String {
    let centimeters = |m: f64| tidy((m * 100.0 - 1e-6).ceil() / 100.0);
    match curve.ground() {
        Some(ground) => format!("{} m above ground", centimeters(meters(height) - meters(ground))),
        None => format!("{} m above the datum", centimeters(meters(height))),
    }
}

/// Returns the least heights of the UAV for half and for nine tenths of the receivers, in words.
fn reaches(curve: &HeightCurve) -> String {
    match (curve.least_height_reaching(50), curve.least_height_reaching(90)) {
        (Some(half), Some(most)) => {
            let half = above_base(curve, half);
            let short = half.split(" above").next().unwrap_or_default();
            format!("half of the receivers from {short}, 90 % from {}", above_base(curve, most))
        }
        (Some(half), None) => format!("half of the receivers from {}, 90 % at no height", above_base(curve, half)),
        _ => "half of the receivers at no height".to_string(),
    }
}

/// Returns the heights of a table above each UAV's ground by default, in round steps. They begin at
/// the lowest height that a UAV may have. They end at three times the highest UAV or obstacle, or
/// earlier if nearly all receivers are in sight there.
fn default_range(curves: &[HeightCurve], max_top: i32) -> [f64; 3] {
    const SHORTEST_M: f64 = 10.0;
    /// Share that is nearly all \[%\].
    const NEARLY_ALL: u8 = 99;
    let over = |z: i32, curve: &HeightCurve| meters(z) - meters(curve.ground().unwrap_or(0));
    let most = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::NEG_INFINITY, f64::max);
    let low = curves.iter().map(|c| over(c.lowest_height(), c)).fold(f64::INFINITY, f64::min);
    let asked = most(&mut curves.iter().map(|c| c.uav().height_amsl_m() - meters(c.ground().unwrap_or(0))));
    // Nodata that blocks everything is no obstacle to rise above.
    let obstacle =
        if meters(max_top).abs() <= MAX_HEIGHT_M { most(&mut curves.iter().map(|c| over(max_top, c))) } else { 0.0 };
    let reached = |c: &HeightCurve| c.least_height_reaching(NEARLY_ALL).map_or(f64::INFINITY, |z| over(z, c));
    let enough = most(&mut curves.iter().filter(|c| c.receivers() > 0).map(reached));
    let high = (3.0 * asked.max(obstacle)).min(enough).max(1.1 * asked).max(low + SHORTEST_M);
    let step = round_step((high - low) / ROWS);
    let low = (low / step).ceil() * step;
    [low, (high / step).ceil() * step, step]
}

/// Returns the least of 1, 2 and 5 times powers of ten that is at least `wanted` (above 0).
fn round_step(wanted: f64) -> f64 {
    let power = 10_f64.powf(wanted.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power).into_iter().find(|step| *step >= wanted).unwrap_or(wanted)
}

/// Returns the heights of a range in equal steps, both ends included.
fn heights_in([from, to, step]: [f64; 3]) -> Vec<f64> {
    // A height within a thousandth of a step of the end counts as the end.
    let mut heights: Vec<f64> =
        (0..).map(|k| from + f64::from(k) * step).take_while(|h| *h < to - 1e-3 * step).collect();
    heights.push(to);
    heights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_makes_no_step_more() {
        let (found, wanted) = (heights_in([-0.3, 0.3, 0.1]), [-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3]);
        assert_eq!(found.len(), wanted.len(), "{found:?}");
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
    }

    #[test]
    fn steps_are_round() {
        for (wanted, step) in [(0.9, 1.0), (1.0, 1.0), (1.3, 2.0), (2.4, 5.0), (6.0, 10.0), (0.03, 0.05)] {
            assert!((round_step(wanted) - step).abs() < 1e-12, "{wanted}: {}", round_step(wanted));
        }
    }
}
