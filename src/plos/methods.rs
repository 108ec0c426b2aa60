//! Methods of a study, from their words.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

use super::curve_file::read_curve;
use super::document::MethodFacts;
use super::plan::PlosPlan;
use crate::error::{Error, RequestError, Result, Warning, warned};
use crate::los::MethodChoice;
use crate::los_probability::models::{Model, UserCurve};
use crate::los_probability::study::Estimator;
use crate::os_words::split;
use crate::read::read_text;
use crate::uav::bad_rows;

/// A method of computing P_LoS.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Way {
    Estimator(Estimator),
    /// Maps of a real city by this engine.
    Maps(MethodChoice),
    Model(Model),
    Curve(UserCurve),
}

/// Methods of a request.
#[derive(Debug, Clone)]
pub(super) struct Ways {
    pub(super) ways: Vec<Way>,
    /// `true` if models that do not apply are left out (`models`, `all`) instead of refused.
    pub(super) leave_out: bool,
}

impl Ways {
    /// Returns the methods for a generated or a real city.
    pub(super) fn of(plan: &PlosPlan, is_real: bool, curves: &[UserCurve]) -> Result<Ways> {
        let mut ways: Vec<Way> = Vec::new();
        let mut leave_out = false;
        let estimators = [Estimator::Product, Estimator::City, Estimator::Geometry].map(Way::Estimator);
        let maps = Way::Maps(MethodChoice::Auto);
        for word in &plan.methods {
            let word = word.trim().to_lowercase();
            let found = match word.as_str() {
                "auto" if is_real => vec![maps.clone(), Way::Estimator(Estimator::Product)],
                "auto" => vec![Way::Estimator(Estimator::Product)],
                "product" => vec![estimators[0].clone()],
                "city" => vec![estimators[1].clone()],
                "geometry" => vec![estimators[2].clone()],
                "maps" => vec![maps.clone()],
                "models" => all_models(plan, &mut leave_out),
                "all" => {
                    let maps = is_real.then(|| maps.clone());
                    maps.into_iter().chain(estimators.clone()).chain(all_models(plan, &mut leave_out)).collect()
                }
                other => match Model::from_id(other) {
                    Some(model) => vec![Way::Model(model)],
                    None => vec![Way::Maps(other.parse().map_err(|_| unknown(other))?)],
                },
            };
            for way in found {
                if matches!(way, Way::Maps(_)) && !is_real {
                    return Err(RequestError::MapsOfGenerated(word.to_string()).into());
                }
                if !ways.contains(&way) {
                    ways.push(way);
                }
            }
        }
        ways.extend(curves.iter().cloned().map(Way::Curve));
        Ok(Ways { ways, leave_out })
    }
}

/// Returns all models once. If a model has two versions, the published formula is taken. The model
/// for φ = 0 is taken only if the request has azimuths.
fn all_models(plan: &PlosPlan, leave_out: &mut bool) -> Vec<Way> {
    *leave_out = true;
    let twice = [Model::AlHourani2014Table, Model::Tr38811Linear];
    let is_wanted = |m: &Model| !twice.contains(m) && (*m != Model::Saboor2024 || plan.sweeps.phis != [None]);
    Model::ALL.into_iter().filter(is_wanted).map(Way::Model).collect()
}

fn unknown(word: &str) -> Error {
    RequestError::UnknownMethod(word.to_string()).into()
}

/// Returns the path of a curve's word `NAME=FILE`.
pub(crate) fn curve_path(word: &OsStr) -> Option<PathBuf> {
    named_file(word).map(|(_, path)| path)
}

/// Reads the curves of the user, each with the path of its file.
///
/// # Errors
/// E123 for a word that is not `NAME=FILE`, or a name that is taken; errors of the files.
pub(crate) fn read_curves(
    words: &[OsString],
    skips_bad: bool,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<(UserCurve, PathBuf)>> {
    let mut curves: Vec<(UserCurve, PathBuf)> = Vec::new();
    for word in words {
        let Some((name, path)) = named_file(word) else {
            return Err(RequestError::CurveWord(word.display().to_string()).into());
        };
        let name = name.as_str();
        let is_taken = Model::from_id(name).is_some()
            || ["product", "city", "geometry", "maps"].contains(&name)
            || curves.iter().any(|(c, _)| c.name() == name);
        if is_taken {
            return Err(RequestError::CurveNameTaken(name.to_string()).into());
        }
        let text = read_text(&path)?;
        let curve = warned(warnings, |odd| read_curve(name, &text, bad_rows(skips_bad, odd)))?;
        curves.push((curve, path));
    }
    Ok(curves)
}

/// Returns the parts of `NAME=FILE`. The file need not be Unicode.
fn named_file(word: &OsStr) -> Option<(String, PathBuf)> {
    let parts = split(word, "=");
    let (name, path) = (parts.first()?.to_str()?, parts[1..].join(OsStr::new("=")));
    (!name.is_empty() && !path.is_empty()).then(|| (name.to_string(), PathBuf::from(path)))
}

impl Way {
    /// Returns the word in tables.
    pub(super) fn id(&self) -> &str {
        match self {
            Way::Estimator(estimator) => estimator.name(),
            Way::Maps(_) => "maps",
            Way::Model(model) => model.id(),
            Way::Curve(curve) => curve.name(),
        }
    }

    /// Returns the name for legends.
    pub(super) fn name(&self) -> &str {
        match self {
            Way::Estimator(Estimator::Product) => "Product over buildings",
            Way::Estimator(Estimator::City) => "3-D city simulator",
            Way::Estimator(Estimator::Geometry) => "Geometry simulator",
            Way::Maps(_) => "Maps of the city",
            Way::Model(model) => model.name(),
            Way::Curve(curve) => curve.name(),
        }
    }

    /// Returns the facts for documents.
    pub(super) fn facts(&self) -> MethodFacts {
        let facts = |source: &str, domain: &str| MethodFacts {
            id: self.id().to_string(),
            name: self.name().to_string(),
            source: source.to_string(),
            domain: domain.to_string(),
        };
        match self {
            Way::Estimator(Estimator::Product) => facts(
                "skyshed: product over the crossed buildings of the Rayleigh distribution at the obstructing point, averaged \
                 over position and azimuth by a randomly shifted lattice",
                "any α, β, γ; exact but for the standard error",
            ),
            Way::Estimator(Estimator::City) => facts(
                "Saboor, Vinogradov, Cui & Pollin 2023, section III-A: a new city per draw",
                "any α, β, γ; intervals clustered by city",
            ),
            Way::Estimator(Estimator::Geometry) => facts(
                "Saboor, Vinogradov, Cui & Pollin 2023, section III-B: only the buildings that a link meets",
                "any α, β, γ; draws are independent",
            ),
            Way::Maps(_) => facts(
                "skyshed: exact maps from UAV positions over the city",
                "one real city; intervals from resampled positions and blocks",
            ),
            Way::Model(model) => facts(model.source(), &format!("{} {}", model.about(), model.domain())),
            Way::Curve(_) => facts("a table of the user's", "as given"),
        }
    }
}
