//! `skyshed plos`: P_LoS by every method, over generated and real cities.

mod args;
mod coarser;
mod curve_file;
mod heat;
mod methods;
mod plot;
mod plot_words;
mod real;
mod sweep;

use std::path::PathBuf;
use std::time::Instant;

pub(super) use args::PlosArgs;
use methods::{Way, Ways, read_curves};
use real::Real;
use sweep::Sweeps;

use super::args::SceneArgs;
use super::plan::outputs_with_table;
use super::typed::SceneWord;
use super::{interrupt, messages};
use crate::accuracy::CONFIDENCE;
use crate::city::BuiltUp;
use crate::error::{Error, Result, Warning};
use crate::export::{Batch, Format, OutputRules, with_suffix};
use crate::formats::{NpyArray, write_npz};
use crate::los::MethodChoice;
use crate::los_probability::estimate::student_quantile;
use crate::los_probability::models::{ModelLink, UserCurve};
use crate::los_probability::product::SHIFTS;
use crate::los_probability::setting::{Placement, Reach, Setting};
use crate::los_probability::study::{Effort, Estimator, estimate_all};
use crate::map::check_tolerance;
use crate::quantity::{counted, tidy};
use crate::read::source_of;
use crate::report::{PlosReport, PlosRow, PlosValue};
use crate::words::pretty;

/// Formats of `skyshed plos`.
const FORMATS: [Format; 7] =
    [Format::Png, Format::Svg, Format::Pdf, Format::Csv, Format::Json, Format::Npz, Format::Stdout];

pub(super) fn run(args: &PlosArgs, command: Vec<String>) -> Result<()> {
    let start = Instant::now();
    check(args)?;
    let sweeps = Sweeps::of(args)?;
    let words: Vec<&SceneWord> = std::iter::once(&args.scene.scene).chain(&args.more_cities).collect();
    let mut warnings = Vec::new();
    let curves = read_curves(args, &mut warnings)?;
    let inputs: Vec<PathBuf> = words
        .iter()
        .filter(|w| w.built_up().is_none())
        .map(PathBuf::from)
        .chain(args.scene.terrain.clone())
        .chain(args.scene.data_area_file())
        .chain(curves.iter().map(|(_, path)| path.clone()))
        .collect();
    let rules = OutputRules { allowed: &FORMATS, inputs: &inputs, overwrite: args.out.overwrite, bare: false };
    let outputs = outputs_with_table(&args.output, args.csv.as_ref(), rules)?;
    let makes_picture = outputs.iter().any(|(_, f)| f.is_picture());
    if args.title.is_some() && !makes_picture {
        return Err(Error::usage(116, "`--title` has no meaning without a .png, .svg or .pdf output"));
    }
    args.size.refuse_without_picture(&outputs)?;
    refuse_flags_without_meaning(args, &words)?;

    let mut report = PlosReport {
        command,
        seed: args.scene.seed,
        confidence: args.ci,
        methods: Vec::new(),
        real_cities: Vec::new(),
        sources: Vec::new(),
        rows: Vec::new(),
        tolerance: args.tolerance,
        warnings,
    };
    let mut plot = plot::Facts::default();
    let mut cautions = Cautions::default();
    for (_, path) in &curves {
        report.sources.push(source_of(path, args.scene.hash)?);
    }
    let curves: Vec<UserCurve> = curves.into_iter().map(|(curve, _)| curve).collect();
    plot.curves.clone_from(&curves);
    for scene in words {
        let word = &scene.to_string();
        let (real, built_up) = match scene.built_up() {
            Some(built_up) => (None, Some(built_up?)),
            None => {
                let scene = SceneArgs { scene: scene.clone(), ..args.scene.clone() };
                refuse_for_real_city(args, &sweeps, word)?;
                let real = Real::read(&scene, &sweeps, &mut report.warnings)?;
                report.sources.extend(real.sources.clone());
                plot.attributions.extend(real.attribution.clone());
                let built_up = real.built_up();
                (Some(real), built_up)
            }
        };
        let Ways { ways, leave_out } = Ways::of(args, real.is_some(), &curves)?;
        for way in &ways {
            let facts = way.facts();
            let rows = match (way, &real, built_up) {
                (Way::Maps(engine), Some(real), _) => {
                    let (rows, facts) = real.rows(args, &sweeps, *engine)?;
                    report.real_cities.push(facts);
                    rows
                }
                (_, _, None) if leave_out || args.method == ["auto"] => {
                    let text = format!("method `{}` is left out over {word}: {UNKNOWN_CITY}", way.id());
                    report.warnings.push(Warning::new(210, text));
                    Vec::new()
                }
                (_, _, None) => {
                    let text = format!("cannot use `--method {}` over {word}: {UNKNOWN_CITY}", way.id());
                    return Err(Error::usage(122, text).with_hint(
                        "`--method maps` needs no α, β, γ; `itu:α,β,γ` beside it lays a city of yours over it",
                    ));
                }
                (_, _, Some(built_up)) => {
                    statistical_rows(args, &sweeps, (word, built_up), way, leave_out, &mut cautions)?
                }
            };
            let is_model = matches!(way, Way::Model(_));
            if let (true, true, Some(built_up), Some(fine)) = (makes_picture, is_model, built_up, sweeps.refined())
                && !rows.is_empty()
            {
                let (city, mut unheard) = ((word.as_str(), built_up), Cautions::default());
                plot.fine_rows.extend(statistical_rows(args, &fine, city, way, true, &mut unheard)?);
            }
            let is_product = *way == Way::Estimator(Estimator::Product);
            if let (true, true, Some(built_up)) = (makes_picture, is_product, built_up) {
                plot.between.extend(between(args, &sweeps, (word, built_up), &rows)?);
            }
            if !rows.is_empty() && !report.methods.contains(&facts) {
                report.methods.push(facts);
            }
            report.rows.extend(rows);
        }
    }
    report.warnings.extend(cautions.warnings());
    warn_of_intervals(args, &mut report);
    write(args, &sweeps, &plot, &report, &outputs, start)
}

const UNKNOWN_CITY: &str = "its α, β, γ are unknown, because its buildings are not known one by one";

/// Numbers that do not depend on a city.
fn check(args: &PlosArgs) -> Result<()> {
    if !(args.ci > 0.0 && args.ci < 1.0) {
        return Err(Error::usage(120, format!("`--ci` is `{}`, wanted above 0 and below 1", args.ci)));
    }
    // Each height must be possible with the receivers', whatever the sweep.
    for height in &args.height.0 {
        Setting::reach_at_distance(0.0, *height, args.rx_height)?;
    }
    Ok(())
}

/// An ignored input is an error, never silence.
fn refuse_flags_without_meaning(args: &PlosArgs, words: &[&SceneWord]) -> Result<()> {
    let is_typed = |name: &str| args.scene.typed.iter().any(|typed| typed == name);
    let has_file = words.iter().any(|w| w.built_up().is_none());
    let uses = |names: &[&str]| args.method.iter().any(|m| names.contains(&m.trim().to_lowercase().as_str()));
    let refuse =
        |flag: &str, why: &str| Err(Error::usage(116, format!("`--{}` has no meaning {why}", flag.replace('_', "-"))));
    let of_files = [
        "terrain",
        "extent",
        "cell",
        "crs",
        "building_threshold",
        "height_field",
        "top_field",
        "missing",
        "nodata_as",
        "ground",
        "hash",
        "positions",
        "block",
        "base",
        "data_area",
        "height_unit",
        "levels_field",
        "layer",
        "theta_band",
    ];
    if let Some(flag) = of_files.iter().find(|f| is_typed(f)).filter(|_| !has_file) {
        return refuse(flag, "without a city in a file");
    }
    if is_typed("theta_band") && (args.distance.is_some() || args.radius.is_some()) {
        return refuse("theta_band", "without `--theta`");
    }
    if is_typed("size") {
        return refuse("size", "here: a city is as large as the links over it");
    }
    if is_typed("cities") && !uses(&["city", "all"]) {
        return refuse("cities", "without `--method city`");
    }
    if is_typed("users_per_city") && !uses(&["city", "all"]) {
        return refuse("users_per_city", "without `--method city`");
    }
    if is_typed("links") && !uses(&["geometry", "all"]) {
        return refuse("links", "without `--method geometry`");
    }
    check_tolerance(args.tolerance, MethodChoice::Auto)?;
    let has_bound = |m: &String| ["auto", "product", "maps", "sweep", "shadow", "ray"].contains(&m.trim());
    if args.tolerance.is_some() && !args.method.iter().all(has_bound) {
        return refuse(
            "tolerance",
            "beside methods other than product and maps: the others have no bound on their error",
        );
    }
    if args.until.is_some() && (is_typed("cities") || is_typed("links")) {
        return refuse("until", "together with `--cities` or `--links`, which fix the effort");
    }
    if is_typed("plot") && !args.output.iter().any(|o| Format::of(o).is_ok_and(Format::is_picture)) {
        return refuse("plot", "without a .png, .svg or .pdf output");
    }
    Ok(())
}

fn refuse_for_real_city(args: &PlosArgs, sweeps: &Sweeps, word: &str) -> Result<()> {
    let refuse = |what: &str, hint: &str| {
        Err(Error::usage(116, format!("{what} has no meaning over {word}, a real city")).with_hint(hint))
    };
    if sweeps.vary_the_city() {
        return refuse("`--alpha`, `--beta` or `--gamma`", "sweep a generated city: itu:α,β,γ");
    }
    if args.phi.is_some() {
        return refuse("`--phi`", "its streets have no common direction");
    }
    let centers = [Placement::StreetCenter, Placement::CrossroadCenter, Placement::RooftopCenter];
    if sweeps.placements.iter().any(|p| centers.contains(p)) {
        return refuse("this `--placement`", "wanted anywhere, street, crossroad or rooftop");
    }
    Ok(())
}

/// Half-width of an interval at the confidence that was typed whose bound, one-sided at that of a tolerance, is the tolerance.
fn half_width_within(args: &PlosArgs) -> Option<f64> {
    let freedom = (SHIFTS - 1) as f64;
    let one_sided = student_quantile(2.0 * CONFIDENCE - 1.0, freedom);
    args.tolerance.map(|tolerance| tolerance * student_quantile(args.ci, freedom) / one_sided)
}

/// The rows of one method over a city that is known by α, β, γ.
fn statistical_rows(
    args: &PlosArgs,
    sweeps: &Sweeps,
    (word, built_up): (&str, BuiltUp),
    way: &Way,
    leave_out: bool,
    cautions: &mut Cautions,
) -> Result<Vec<PlosRow>> {
    let settings = sweeps.settings(built_up, args)?;
    match way {
        Way::Estimator(estimator) => {
            let effort = Effort {
                seed: args.scene.seed,
                confidence: args.ci,
                until: args.until.or_else(|| half_width_within(args)),
                n_cities: args.cities,
                n_users: args.users_per_city,
                n_links: args.links,
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

/// Rows of the product between some of its rows, where a curve through these turns: users of a street or a crossroad see a
/// grid of streets, whose period the steps of angles meet again and again.
fn between(args: &PlosArgs, sweeps: &Sweeps, city: (&str, BuiltUp), rows: &[PlosRow]) -> Result<Vec<PlosRow>> {
    /// Each pass halves the steps next to a turn.
    const PASSES: usize = 3;
    let (mut known, mut found) = (rows.to_vec(), Vec::new());
    for _ in 0..PASSES {
        let far = sweeps.turns(&known);
        if far.is_empty() {
            break;
        }
        let finer = Sweeps { far, ..sweeps.clone() };
        let way = Way::Estimator(Estimator::Product);
        let more = statistical_rows(args, &finer, city, &way, true, &mut Cautions::default())?;
        known.extend(more.iter().cloned());
        found.extend(more);
    }
    Ok(found)
}

/// The rows of a model: it knows neither placements nor kinds of users, so it has one row for all of them.
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
            let text = format!("cannot use model `{id}` over {word}: {reason}");
            return Err(Error::usage(122, text).with_hint("`--method models` takes all that apply"));
        }
        cautions.add(210, format!("model `{id}` is left out: {reason}"), word);
        return Ok(Vec::new());
    }
    if let Some(reason) = reasons.first() {
        cautions.add(211, format!("model `{id}` has no value for {} of {}: {reason}", reasons.len(), rows.len()), word);
    }
    if let Some(care) = cares.first() {
        let more = if cares.len() > 1 { format!(" (and {} more cautions)", cares.len() - 1) } else { String::new() };
        cautions.add(212, format!("model `{id}`: {care}{more}"), word);
    }
    Ok(rows)
}

/// What is to be said of models, each once for all cities.
#[derive(Debug, Default)]
struct Cautions(Vec<(u16, String, Vec<String>)>);

impl Cautions {
    fn add(&mut self, code: u16, text: String, city: &str) {
        match self.0.iter_mut().find(|(c, t, _)| *c == code && *t == text) {
            Some((_, _, cities)) => cities.push(city.to_string()),
            None => self.0.push((code, text, vec![city.to_string()])),
        }
    }

    fn warnings(self) -> impl Iterator<Item = Warning> {
        self.0.into_iter().map(|(code, text, cities)| Warning::new(code, format!("{text}; over {}", cities.join(", "))))
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

/// Says where intervals are missing, or wider than was asked for.
fn warn_of_intervals(args: &PlosArgs, report: &mut PlosReport) {
    let estimates = || report.rows.iter().filter_map(PlosRow::estimate).filter(|e| e.p_los.is_some());
    let have = |n: usize, one: &str, many: &str| counted(n as u64, one, many);
    let n_missing = estimates().filter(|e| e.interval.is_none()).count();
    let n_empty = report.rows.iter().filter(|r| r.estimate().is_some_and(|e| e.p_los.is_none())).count();
    let until = args.until.or_else(|| half_width_within(args).filter(|_| report.real_cities.is_empty()));
    let until = until.unwrap_or(f64::INFINITY);
    let n_wide = estimates().filter(|e| e.half_width().is_some_and(|reach| reach > until)).count();
    if n_missing > 0 {
        let text = format!(
            "{} no interval: it needs at least 10 clusters (cities, positions, blocks)",
            have(n_missing, "value has", "values have")
        );
        report.warnings.push(Warning::new(213, text));
    }
    if n_wide > 0 {
        let text = format!(
            "{} wider than ±{until}: the effort was spent before",
            have(n_wide, "interval is", "intervals are")
        );
        report.warnings.push(Warning::new(214, text));
    }
    if n_empty > 0 {
        let text = format!("{} no P_LoS: no user of the kind is there", have(n_empty, "value has", "values have"));
        report.warnings.push(Warning::new(202, text));
    }
}

fn write(
    args: &PlosArgs,
    sweeps: &Sweeps,
    plot: &plot::Facts,
    report: &PlosReport,
    outputs: &[(PathBuf, Format)],
    start: Instant,
) -> Result<()> {
    interrupt::begin_writing();
    let mut batch = Batch::new(args.out.overwrite);
    for (path, format) in outputs {
        interrupt::check()?;
        match format {
            Format::Csv => {
                batch.add(path, &args.out.table(&report.table())?)?;
                batch.add(&with_suffix(path, ".json"), pretty(&report.provenance()).as_bytes())?;
            }
            Format::Json => {
                let seconds = start.elapsed().as_secs_f64();
                batch.add(path, pretty(&report.document(Some(seconds))).as_bytes())?;
            }
            Format::Npz => batch.add(path, &encode_arrays(report)?)?,
            Format::Png | Format::Svg | Format::Pdf => {
                batch.add(path, &plot::draw(args, sweeps, plot, report, &args.size.form(*format))?)?;
            }
            _ => {}
        }
    }
    let files = batch.commit()?;
    let seconds = start.elapsed().as_secs_f64();
    if !args.out.quiet {
        messages::warnings(&report.warnings);
        report.real_cities.iter().filter_map(|c| c.tolerance.as_ref()).for_each(|t| messages::note(&t.in_words()));
        if let (Some(tolerance), Some(bound)) = (report.tolerance, report.product_bound()) {
            let percent = tidy(100.0 * CONFIDENCE);
            messages::note(&format!(
                "tolerance {tolerance}: product, off by at most {bound:.2e} with {percent} % confidence"
            ));
        }
        messages::note(&format!("{} of P_LoS in {seconds:.2} s", counted(report.rows.len() as u64, "value", "values")));
    }
    messages::wrote(&files, args.out.quiet);
    if args.out.json || outputs.iter().any(|(_, f)| *f == Format::Stdout) {
        return messages::answer(&pretty(&report.document(Some(seconds))));
    }
    if outputs.is_empty() {
        let table = args.out.table(&report.table())?;
        return messages::answer(&String::from_utf8_lossy(&table));
    }
    Ok(())
}

/// One array per column of the table.
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
