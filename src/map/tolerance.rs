//! Scene made as coarse as a tolerance of P_LoS allows, as measured.

use schemars::JsonSchema;
use serde::Serialize;

use crate::accuracy::{CONFIDENCE, Choice, Measured, Question, Simpler, Tried, coarsest_within};
use crate::coverage::Uav;
use crate::error::{RequestError, Result};
use crate::height_field::HeightField;
use crate::los::MethodChoice;
use crate::quantity::tidy;
use crate::render::grouped;
use crate::scene::Scene;
use crate::sight::SightPlan;

/// Checks the error of P_LoS that is allowed, and the method.
///
/// # Errors
/// E113, E116.
pub(crate) fn check_tolerance(tolerance: Option<f64>, method: MethodChoice) -> Result<()> {
    let Some(tolerance) = tolerance else { return Ok(()) };
    if !(tolerance > 0.0 && tolerance < 1.0) {
        return Err(RequestError::Tolerance(tolerance).into());
    }
    if matches!(method, MethodChoice::Step(_) | MethodChoice::Xdraw | MethodChoice::R2) {
        return Err(RequestError::ToleranceOfApproximate.into());
    }
    Ok(())
}

/// Result of a tolerance.
#[derive(Debug, Clone)]
pub(crate) struct ToleranceFacts {
    /// Largest error of P_LoS that is allowed.
    tolerance: f64,
    /// Width of a cell of the scene itself \[m\].
    cell_m: f64,
    /// Form that was taken; the scene itself if no simpler form is within the tolerance.
    pub(crate) taken: Simpler,
    /// Forms that were tried, the coarsest first.
    tried: Vec<Tried>,
}

/// Result of a tolerance.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ToleranceDocument {
    /// Largest error of P_LoS that is allowed.
    tolerance: f64,
    /// Confidence of the bounds.
    confidence: f64,
    /// Form of the scene that was taken.
    taken: FormDocument,
    /// Forms that were tried, the coarsest first.
    tried: Vec<TriedDocument>,
}

/// Form of a scene, on its own cells or on larger ones.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct FormDocument {
    /// Width of its cells [m].
    cell_m: f64,
    /// Width of its cells in cells of the scene.
    factor: usize,
    /// Rule for the height of a larger cell from the cells in it; null for footprints.
    pooling: Option<&'static str>,
}

/// Form that was tried.
#[derive(Debug, Serialize, JsonSchema)]
struct TriedDocument {
    #[serde(flatten)]
    form: FormDocument,
    /// Bound on the error of P_LoS of any UAV; null if it is not known.
    bound: Option<f64>,
    /// Measurements, by UAV.
    #[serde(skip_serializing_if = "Option::is_none")]
    sites: Option<Vec<MeasuredDocument>>,
    /// Reason why nothing was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

/// Measurement of a UAV.
#[derive(Debug, Serialize, JsonSchema)]
struct MeasuredDocument {
    /// P_LoS over the form.
    p_los: f64,
    /// Mean difference to the scene itself.
    difference: f64,
    /// Bound on the error of P_LoS.
    bound: f64,
    /// Receivers that were compared.
    sample: u64,
    /// All receivers.
    receivers: u64,
}

impl FormDocument {
    /// Returns the document of a form, for a scene with cells of a width `cell_m` \[m\].
    pub(crate) fn of(form: Simpler, cell_m: f64) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "a small factor")]
        let cell_m = cell_m * form.factor as f64;
        FormDocument { cell_m, factor: form.factor, pooling: form.pooling.map(|p| p.name()) }
    }
}

impl ToleranceFacts {
    /// Returns the facts of a choice, for a scene with cells of a width `cell_m` \[m\].
    fn of(choice: &Choice, tolerance: f64, cell_m: f64) -> Self {
        let taken = choice.taken.as_ref().map_or(Simpler::SAME, |(form, ..)| *form);
        ToleranceFacts { tolerance, cell_m, taken, tried: choice.tried.clone() }
    }

    /// Returns the measurement with the largest bound over the form that was taken. `None` if that
    /// is the scene itself.
    fn worst(&self) -> Option<&Measured> {
        let taken = self.tried.last().filter(|tried| tried.form == self.taken)?;
        taken.measured.as_ref().ok()?.iter().max_by(|a, b| a.bound.total_cmp(&b.bound))
    }

    pub(crate) fn document(&self) -> ToleranceDocument {
        let measured = |m: &Measured| MeasuredDocument {
            p_los: m.p_los,
            difference: m.difference,
            bound: m.bound,
            sample: m.sample,
            receivers: m.receivers,
        };
        let tried = |t: &Tried| TriedDocument {
            form: FormDocument::of(t.form, self.cell_m),
            bound: t.bound(),
            sites: t.measured.as_ref().ok().map(|all| all.iter().map(measured).collect()),
            reason: t.measured.as_ref().err().cloned(),
        };
        ToleranceDocument {
            tolerance: self.tolerance,
            confidence: CONFIDENCE,
            taken: FormDocument::of(self.taken, self.cell_m),
            tried: self.tried.iter().map(tried).collect(),
        }
    }
}

/// Replaces a scene by its coarsest form within a tolerance, and its UAVs by the same UAVs over
/// that form.
pub(crate) fn simplify(
    scene: &mut Scene,
    uavs: &mut Vec<Uav>,
    sight: &SightPlan,
    tolerance: f64,
) -> Result<ToleranceFacts> {
    let (built_up, seed) = (scene.built_up, scene.seed);
    let options = |field: &HeightField| Ok(sight.options_over(field, built_up.as_ref())?);
    let choice = coarsest_within(&Question { field: &scene.field, uavs, tolerance, seed }, &options)?;
    let grid = scene.field.grid();
    let facts = ToleranceFacts::of(&choice, tolerance, grid.cell_width() * grid.meters_per_unit());
    if let Some((_, field, moved)) = choice.taken {
        scene.replace_field(field);
        *uavs = moved;
    }
    Ok(facts)
}

/// Returns the choice and its measurement in a sentence.
pub(super) fn in_words(facts: &ToleranceFacts) -> String {
    let scene = format!("{} m", tidy(facts.cell_m));
    let Some(m) = facts.worst() else {
        let tried: Vec<String> = facts.tried.iter().map(|t| t.form.in_words(facts.cell_m)).collect();
        let tried = if tried.is_empty() { String::new() } else { format!(" (tried: {})", tried.join(", ")) };
        return format!("Tolerance {}: no simpler form will do{tried}; exact, on cells of {scene}", facts.tolerance);
    };
    let form = facts.taken.in_words(facts.cell_m);
    let measured = if m.sample == m.receivers {
        format!("by {:.4}, all {} receivers compared", m.bound, grouped(m.receivers))
    } else {
        let (n, all) = (grouped(m.sample), grouped(m.receivers));
        let percent = tidy(100.0 * CONFIDENCE);
        format!("by at most {:.4} with {percent} % confidence, {n} of {all} receivers asked", m.bound)
    };
    format!("Tolerance {}: {form} instead of {scene}; P_LoS is off {measured}", facts.tolerance)
}
