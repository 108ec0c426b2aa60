//! A scene made as coarse as its P_LoS allows, as measured.

use super::receivers::Asked;
use crate::accuracy::{CONFIDENCE, Question, coarsest_within};
use crate::coverage::Uav;
use crate::error::{Error, Result};
use crate::height_field::HeightField;
use crate::los::MethodChoice;
use crate::quantity::tidy;
use crate::render::grouped;
use crate::report::ToleranceFacts;
use crate::scene::Scene;
use crate::zones::ZoneMap;

/// A share of P_LoS that may be wrong.
///
/// # Errors
/// E113, E116.
pub(crate) fn check_tolerance(tolerance: Option<f64>, method: MethodChoice) -> Result<()> {
    let Some(tolerance) = tolerance else { return Ok(()) };
    if !(tolerance > 0.0 && tolerance < 1.0) {
        let text = format!("`--tolerance` is `{tolerance}`, wanted a P_LoS above 0 and below 1");
        return Err(Error::usage(113, text).with_hint("`--tolerance 0.005` is half a percentage point"));
    }
    if matches!(method, MethodChoice::Step(_) | MethodChoice::Xdraw | MethodChoice::R2) {
        let text = "`--tolerance` has no meaning beside an approximate `--method`: it chooses itself";
        return Err(Error::usage(116, text).with_hint("leave `--method` out"));
    }
    Ok(())
}

/// Replaces a scene by the coarsest form within a tolerance, and its UAVs by the same over that form.
pub(crate) fn simplify(
    scene: &mut Scene,
    uavs: &mut Vec<Uav>,
    asked: &Asked,
    tolerance: f64,
) -> Result<ToleranceFacts> {
    let (built_up, seed) = (scene.built_up, scene.seed);
    let options = |field: &HeightField| {
        let zones = asked.receivers.zone().and_then(|_| ZoneMap::if_known(field, built_up.as_ref()));
        asked.options(field.grid(), zones.as_ref())
    };
    let choice = coarsest_within(&Question { field: &scene.field, uavs, tolerance, seed }, &options)?;
    let grid = scene.field.grid();
    let facts = ToleranceFacts::of(&choice, tolerance, grid.cell_width() * grid.meters_per_unit());
    if let Some((_, field, moved)) = choice.taken {
        scene.field = std::sync::Arc::new(field);
        *uavs = moved;
    }
    Ok(facts)
}

/// What was chosen and what was measured, in a sentence.
pub(crate) fn in_words(facts: &ToleranceFacts) -> String {
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
