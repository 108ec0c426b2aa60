//! P_LoS by every method, over generated and real cities.

mod coarser;
mod curve_file;
mod document;
mod heat;
mod maps;
mod methods;
mod panels;
mod plan;
mod plot;
mod plot_words;
mod real;
mod report;
mod request;
mod sweep;

use std::path::Path;

use serde_json::Value;

pub(crate) use document::{PlosDocument, PlosTableRow};
use methods::{Way, Ways};
pub(crate) use methods::{curve_path, read_curves};
pub(crate) use plan::PlosPlan;
use real::Real;
use report::{PlosReport, PlosRow, PlosValue};
pub use request::{PLos, PLosRequest, PLosValue};
pub(crate) use sweep::Sweeps;

use skyshed_request::Placement;

use crate::accuracy::CONFIDENCE;
use crate::answer::{Answer, Rows, Spent};
use crate::city::BuiltUp;
use crate::error::{Caution, OddRun, OfGenerated, RequestError, Result, Warning};
use crate::export::{Batch, Format};
use crate::formats::{NpyArray, write_npz};
use crate::los_probability::estimate::student_quantile;
use crate::los_probability::models::{ModelLink, UserCurve};
use crate::los_probability::product::SHIFTS;
use crate::los_probability::setting::{Reach, Setting};
use crate::los_probability::study::{Effort, Estimator, estimate_all};
use crate::picture::Look;
use crate::quantity::{counted, tidy};
use crate::read::source_of;
use crate::scene::built_up;

/// Output formats of a study.
pub(crate) const FORMATS: [Format; 7] =
    [Format::Png, Format::Svg, Format::Pdf, Format::Csv, Format::Json, Format::Npz, Format::Stdout];

/// Results of a study.
#[derive(Debug)]
pub(crate) struct PlosStudy {
    plan: PlosPlan,
    report: PlosReport,
    plot: panels::Facts,
}

const UNKNOWN_CITY: &str = "its α, β, γ are unknown, because its buildings are not known one by one";

impl PlosPlan {
    /// Computes P_LoS of every city by every method.
    ///
    /// # Errors
    /// E113, E116, E118, E12x for an impossible request; errors of reading the cities; E2xx; E5xx.
    pub(crate) fn run(self) -> Result<PlosStudy> {
        self.check()?;
        let mut report = PlosReport {
            command: self.command.clone(),
            seed: self.seed,
            confidence: self.confidence,
            methods: Vec::new(),
            real_cities: Vec::new(),
            sources: Vec::new(),
            rows: Vec::new(),
            tolerance: self.tolerance,
            warnings: self.warnings.clone(),
        };
        for (_, path) in &self.curves {
            report.sources.push(source_of(path, self.hash)?);
        }
        let curves: Vec<UserCurve> = self.curves.iter().map(|(curve, _)| curve.clone()).collect();
        let mut plot = panels::Facts { curves: curves.clone(), ..panels::Facts::default() };
        let mut cautions = Cautions::default();
        for scene in &self.scenes {
            let word = scene.display().to_string();
            let (real, built_up) = match built_up(scene) {
                Some(built_up) => (None, Some(built_up?)),
                None => {
                    self.refuse_for_real_city(&word)?;
                    let real = Real::read(&self.options, scene, &self.sweeps, &mut report.warnings)?;
                    report.sources.extend(real.sources.clone());
                    plot.attributions.extend(real.attribution.clone());
                    let built_up = real.built_up();
                    (Some(real), built_up)
                }
            };
            let city = StudiedCity { word, real, built_up };
            let Ways { ways, leave_out } = Ways::of(&self, city.real.is_some(), &curves)?;
            for way in &ways {
                let rows = self.rows(&city, way, leave_out, &mut report, &mut cautions)?;
                self.add_to_plot(&city, way, &rows, &mut plot)?;
                let facts = way.facts();
                if !rows.is_empty() && !report.methods.contains(&facts) {
                    report.methods.push(facts);
                }
                report.rows.extend(rows);
            }
        }
        report.warnings.extend(cautions.warnings());
        warn_of_intervals(&self, &mut report);
        Ok(PlosStudy { plan: self, report, plot })
    }

    /// Returns the rows of a method over a city.
    fn rows(
        &self,
        city: &StudiedCity,
        way: &Way,
        leave_out: bool,
        report: &mut PlosReport,
        cautions: &mut Cautions,
    ) -> Result<Vec<PlosRow>> {
        let word = &city.word;
        match (way, &city.real, city.built_up) {
            (Way::Maps(engine), Some(real), _) => {
                let (rows, facts) = real.rows(self, &self.sweeps, *engine)?;
                report.real_cities.push(facts);
                Ok(rows)
            }
            (_, _, None) if leave_out || self.methods == ["auto"] => {
                let (method, city) = (way.id().to_string(), word.to_string());
                report.warnings.push(OddRun::MethodLeftOut { method, city, why: UNKNOWN_CITY }.into());
                Ok(Vec::new())
            }
            (_, _, None) => {
                let method = way.id().to_string();
                Err(RequestError::UnknownCity { method, word: word.to_string(), why: UNKNOWN_CITY }.into())
            }
            (_, _, Some(built_up)) => statistical_rows(self, &self.sweeps, (word, built_up), way, leave_out, cautions),
        }
    }

    /// Adds values that only the picture shows.
    fn add_to_plot(&self, city: &StudiedCity, way: &Way, rows: &[PlosRow], plot: &mut panels::Facts) -> Result<()> {
        let Some(built_up) = city.built_up.filter(|_| self.is_drawn) else { return Ok(()) };
        let city = (city.word.as_str(), built_up);
        if let (Way::Model(_), Some(fine)) = (way, self.sweeps.refined())
            && !rows.is_empty()
        {
            plot.fine_rows.extend(statistical_rows(self, &fine, city, way, true, &mut Cautions::default())?);
        }
        if *way == Way::Estimator(Estimator::Product) {
            plot.between.extend(between(self, &self.sweeps, city, rows)?);
        }
        Ok(())
    }

    fn refuse_for_real_city(&self, word: &str) -> Result<()> {
        let refuse = |what| Err(RequestError::RealCity { what, word: word.to_string() }.into());
        if self.sweeps.vary_the_city() {
            return refuse(OfGenerated::Sweep);
        }
        if self.sweeps.phis != [None] {
            return refuse(OfGenerated::Azimuth);
        }
        let centers = [Placement::StreetCenter, Placement::CrossroadCenter, Placement::RooftopCenter];
        if self.sweeps.placements.iter().any(|p| centers.contains(p)) {
            return refuse(OfGenerated::Middle);
        }
        Ok(())
    }
}

/// A city of a study.
struct StudiedCity {
    word: String,
    /// City of a file; `None` for a generated one.
    real: Option<Real>,
    /// Built-up parameters, if they are known.
    built_up: Option<BuiltUp>,
}

/// Returns the half-width of an interval at the plan's confidence whose one-sided bound, at the
/// confidence of tolerances, equals the tolerance.
fn half_width_within(plan: &PlosPlan) -> Option<f64> {
    let freedom = (SHIFTS - 1) as f64;
    let one_sided = student_quantile(2.0 * CONFIDENCE - 1.0, freedom);
    plan.tolerance.map(|tolerance| tolerance * student_quantile(plan.confidence, freedom) / one_sided)
}

/// Returns the rows of one method over a city with known α, β, γ.
fn statistical_rows(
    plan: &PlosPlan,
    sweeps: &Sweeps,
    (word, built_up): (&str, BuiltUp),
    way: &Way,
    leave_out: bool,
    cautions: &mut Cautions,
) -> Result<Vec<PlosRow>> {
    let settings = sweeps.settings(built_up, (plan.rx_height_m, plan.uav_clear_of_roof))?;
    match way {
        Way::Estimator(estimator) => {
            let effort = Effort {
                seed: plan.seed,
                confidence: plan.confidence,
                until: plan.until.or_else(|| half_width_within(plan)),
                n_cities: plan.n_cities,
                n_users: plan.n_users,
                n_links: plan.n_links,
            };
            let estimates = estimate_all(*estimator, &settings, &effort)?;
            let value = |e| PlosValue::Estimate(e);
            Ok(settings.iter().zip(estimates).map(|(s, e)| row(word, s, estimator.name(), value(e))).collect())
        }
        Way::Model(model) => {
            let of = |link: &ModelLink| match model.p_los(link) {
                Ok(value) => (PlosValue::Model(value.p_los), value.caution),
                Err(outside) => (PlosValue::None(outside.to_string()), None),
            };
            model_rows(&settings, (word, way.id()), leave_out, of, cautions)
        }
        Way::Curve(curve) => {
            let of = |link: &ModelLink| match curve.p_los(link.theta_deg, link.distance_m) {
                Ok(p_los) => (PlosValue::Model(p_los), None),
                Err(outside) => (PlosValue::None(outside.to_string()), None),
            };
            model_rows(&settings, (word, way.id()), leave_out, of, cautions)
        }
        Way::Maps(_) => Ok(Vec::new()),
    }
}

/// Returns rows of the product between existing rows, where the curve through these bends. Users of
/// a street or a crossroad see a periodic grid, which makes the curve bend repeatedly.
fn between(plan: &PlosPlan, sweeps: &Sweeps, city: (&str, BuiltUp), rows: &[PlosRow]) -> Result<Vec<PlosRow>> {
    /// Number of passes. Each halves the steps next to a bend.
    const PASSES: usize = 3;
    let (mut known, mut found) = (rows.to_vec(), Vec::new());
    for _ in 0..PASSES {
        let far = sweeps.turns(&known);
        if far.is_empty() {
            break;
        }
        let finer = Sweeps { far, ..sweeps.clone() };
        let way = Way::Estimator(Estimator::Product);
        let more = statistical_rows(plan, &finer, city, &way, true, &mut Cautions::default())?;
        known.extend(more.iter().cloned());
        found.extend(more);
    }
    Ok(found)
}

/// Returns the rows of a model. A model does not distinguish placements and kinds of users, so one
/// row covers all of them.
fn model_rows(
    settings: &[Setting],
    (word, id): (&str, &str),
    leave_out: bool,
    of: impl Fn(&ModelLink) -> (PlosValue, Option<String>),
    cautions: &mut Cautions,
) -> Result<Vec<PlosRow>> {
    let first = settings.first().map(|s| (s.placement, s.users));
    let mut rows = Vec::new();
    let (mut cares, mut reasons): (Vec<String>, Vec<String>) = (Vec::new(), Vec::new());
    for setting in settings.iter().filter(|s| Some((s.placement, s.users)) == first) {
        let (value, caution) = match ModelLink::of(setting) {
            Ok(link) => of(&link),
            Err(why) => (PlosValue::None(why.into()), None),
        };
        cares.extend(caution.filter(|c| !cares.contains(c)));
        if let PlosValue::None(reason) = &value {
            reasons.push(reason.clone());
        }
        let row = PlosRow { placement: None, users: None, uav_in_building: None, ..row(word, setting, id, value) };
        rows.push(row);
    }
    if reasons.len() == rows.len() {
        let reason = reasons.first().cloned().unwrap_or_default();
        if !leave_out {
            return Err(RequestError::OutsideModel { id: id.to_string(), word: word.to_string(), reason }.into());
        }
        cautions.add(id, Caution::LeftOut(reason), word);
        return Ok(Vec::new());
    }
    if let Some(reason) = reasons.first() {
        cautions.add(id, Caution::NoValue { n: reasons.len(), of: rows.len(), why: reason.clone() }, word);
    }
    if let Some(care) = cares.first() {
        cautions.add(id, Caution::Care { care: care.clone(), n_more: cares.len() - 1 }, word);
    }
    Ok(rows)
}

/// Cautions about models. Each is reported once for all cities.
#[derive(Debug, Default)]
struct Cautions(Vec<(String, Caution, Vec<String>)>);

impl Cautions {
    fn add(&mut self, id: &str, caution: Caution, city: &str) {
        match self.0.iter_mut().find(|(of, known, _)| of == id && *known == caution) {
            Some((_, _, cities)) => cities.push(city.to_string()),
            None => self.0.push((id.to_string(), caution, vec![city.to_string()])),
        }
    }

    fn warnings(self) -> impl Iterator<Item = Warning> {
        self.0.into_iter().map(|(id, caution, cities)| OddRun::Model { id, caution, cities }.into())
    }
}

fn row(word: &str, setting: &Setting, method: &str, value: PlosValue) -> PlosRow {
    let (distance_m, radius_m) = match setting.reach {
        Reach::Ring { distance_m, .. } => (Some(distance_m), None),
        Reach::Disc { radius_m } => (None, Some(radius_m)),
    };
    PlosRow {
        city: word.to_string(),
        built_up: Some(setting.built_up),
        method: method.to_string(),
        height_m: setting.uav_height_m,
        rx_height_m: setting.rx_height_m,
        theta_deg: setting.theta_deg(),
        theta_band_deg: None,
        phi_deg: setting.phi_deg,
        distance_m,
        radius_m,
        placement: Some(setting.placement.name()),
        users: Some(setting.users.name()),
        uav_in_building: Some(if setting.uav_clear_of_roof { "excluded" } else { "nlos" }),
        value,
    }
}

/// Warns about intervals that are missing, or wider than requested.
fn warn_of_intervals(plan: &PlosPlan, report: &mut PlosReport) {
    let estimates = || report.rows.iter().filter_map(PlosRow::estimate).filter(|e| e.p_los.is_some());
    let n_missing = estimates().filter(|e| e.interval.is_none()).count() as u64;
    let n_empty = report.rows.iter().filter(|r| r.estimate().is_some_and(|e| e.p_los.is_none())).count() as u64;
    let until = plan.until.or_else(|| half_width_within(plan).filter(|_| report.real_cities.is_empty()));
    let until = until.unwrap_or(f64::INFINITY);
    let n_wide = estimates().filter(|e| e.half_width().is_some_and(|reach| reach > until)).count() as u64;
    if n_missing > 0 {
        report.warnings.push(OddRun::NoIntervals(n_missing).into());
    }
    if n_wide > 0 {
        report.warnings.push(OddRun::WideIntervals { n: n_wide, until }.into());
    }
    if n_empty > 0 {
        report.warnings.push(OddRun::NoValues { n: n_empty, why: "no user of the kind is there".into() }.into());
    }
}

impl Answer for PlosStudy {
    fn document(&self, spent: Option<Spent>) -> Value {
        self.report.document(spent)
    }

    fn provenance(&self) -> Value {
        self.report.provenance()
    }

    fn table(&self) -> Rows {
        self.report.table()
    }

    fn warnings(&self) -> &[Warning] {
        &self.report.warnings
    }

    fn notes(&self, spent: Spent) -> Vec<String> {
        let of_cities = self.report.real_cities.iter().filter_map(|c| c.tolerance.as_ref()).map(|t| t.in_words());
        let mut notes: Vec<String> = of_cities.collect();
        if let (Some(tolerance), Some(bound)) = (self.report.tolerance, self.report.product_bound()) {
            let percent = tidy(100.0 * CONFIDENCE);
            notes.push(format!(
                "tolerance {tolerance}: product, off by at most {bound:.2e} with {percent} % confidence"
            ));
        }
        let values = counted(self.report.rows.len() as u64, "value", "values");
        notes.push(format!("{values} of P_LoS in {:.2} s", spent.total));
        notes
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
        match format {
            Format::Npz => Ok(batch.add(path, &encode_arrays(&self.report)?)?),
            _ => Ok(batch.add(path, &plot::draw(self, format, look)?)?),
        }
    }
}

/// Encodes one array for each column of the table.
fn encode_arrays(report: &PlosReport) -> Result<Vec<u8>> {
    let rows = &report.rows;
    let numbers =
        |of: &dyn Fn(&PlosRow) -> Option<f64>| -> Vec<f64> { rows.iter().map(|r| of(r).unwrap_or(f64::NAN)).collect() };
    let interval = |r: &PlosRow| r.estimate().and_then(|e| e.interval);
    let columns: Vec<(&str, Vec<f64>)> = vec![
        ("alpha", numbers(&|r| r.built_up.map(|b| b.built_up_ratio))),
        ("beta_per_km2", numbers(&|r| r.built_up.map(|b| b.buildings_per_km2))),
        ("gamma_m", numbers(&|r| r.built_up.map(|b| b.height_scale))),
        ("height_m", numbers(&|r| Some(r.height_m))),
        ("rx_height_m", numbers(&|r| Some(r.rx_height_m))),
        ("theta_deg", numbers(&|r| r.theta_deg)),
        ("phi_deg", numbers(&|r| r.phi_deg)),
        ("distance_m", numbers(&|r| r.distance_m)),
        ("radius_m", numbers(&|r| r.radius_m)),
        ("p_los", numbers(&PlosRow::p_los)),
        ("ci_low", numbers(&|r| interval(r).map(|i| i.0))),
        ("ci_high", numbers(&|r| interval(r).map(|i| i.1))),
        ("std_error", numbers(&|r| r.estimate().and_then(|e| e.std_error))),
    ];
    let counts: Vec<(&str, Vec<i64>)> = vec![
        ("samples", rows.iter().map(|r| signed(r.estimate().map_or(0, |e| e.samples))).collect()),
        ("clusters", rows.iter().map(|r| signed(r.estimate().map_or(0, |e| e.clusters))).collect()),
    ];
    let texts = |of: &dyn Fn(&PlosRow) -> &str| -> Vec<String> { rows.iter().map(|r| of(r).to_string()).collect() };
    let words = [
        ("city", texts(&|r| &r.city)),
        ("method", texts(&|r| &r.method)),
        ("placement", texts(&|r| r.placement.unwrap_or_default())),
        ("users", texts(&|r| r.users.unwrap_or_default())),
    ];
    let provenance = report.provenance().to_string();
    let mut arrays: Vec<(String, NpyArray<'_>)> =
        columns.iter().map(|(name, v)| ((*name).to_string(), NpyArray::F64(v, vec![v.len()]))).collect();
    arrays.extend(counts.iter().map(|(name, v)| ((*name).to_string(), NpyArray::I64(v, vec![v.len()]))));
    arrays.extend(words.iter().map(|(name, texts)| ((*name).to_string(), NpyArray::Texts(texts))));
    arrays.push(("provenance".to_string(), NpyArray::Text(&provenance)));
    let mut bytes = std::io::Cursor::new(Vec::new());
    write_npz(&mut bytes, &arrays)?;
    Ok(bytes.into_inner())
}

fn signed(n: u64) -> i64 {
    i64::try_from(n).unwrap_or(i64::MAX)
}
