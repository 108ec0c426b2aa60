//! Text that several answers share: titles, P_LoS in words, indented documents.

use crate::coverage::IdleFootprints;
use crate::quantity::tidy;
pub(crate) use crate::render::capitalized;
use crate::render::grouped;

/// Returns the version of the program.
pub(crate) fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}

/// Returns a document as indented text with a final line break.
pub(crate) fn pretty(document: &serde_json::Value) -> String {
    format!("{document:#}\n")
}

/// Returns a name as a title: capitalized, without line breaks inside `β = 500/km²`.
pub(crate) fn title_of(name: &str) -> String {
    unbreakable(&capitalized(name))
}

/// Returns text whose equations and lengths do not break across lines.
pub(crate) fn unbreakable(text: &str) -> String {
    const UNIT: &str = " m";
    let text = text.replace(" = ", "\u{a0}=\u{a0}");
    let mut joined = String::new();
    let mut rest = text.as_str();
    while let Some(at) = rest.find(UNIT) {
        let (before, after) = (&rest[..at], &rest[at + UNIT.len()..]);
        let is_length = before.ends_with(|c: char| c.is_ascii_digit()) && !after.starts_with(char::is_alphanumeric);
        joined += before;
        joined += if is_length { "\u{a0}m" } else { UNIT };
        rest = after;
    }
    joined + rest
}

/// Returns the height of a UAV in words.
pub(crate) fn height_words(agl_m: Option<f64>, amsl_m: f64) -> String {
    match agl_m {
        Some(agl) => format!("{} m above ground", tidy(agl)),
        None => format!("{} m above the datum", tidy(amsl_m)),
    }
}

/// Returns P_LoS with four digits, or `undefined`.
pub(crate) fn p_los_words(p_los: Option<f64>) -> String {
    p_los.map_or("undefined".to_string(), |p| format!("{p:.4}"))
}

/// Returns the footprints that were dropped before work started, in words.
pub(crate) fn idle_in_words(idle: &IdleFootprints) -> String {
    format!(
        "{} of {} footprints can hide no receiver and were dropped: {} too low, {} out of reach",
        grouped(idle.dropped()),
        grouped(idle.footprints),
        grouped(idle.too_low),
        grouped(idle.out_of_reach)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equations_and_lengths_stay_together() {
        assert_eq!(unbreakable("γ = 8.8 m, 50 maps; 5 m"), "γ\u{a0}=\u{a0}8.8\u{a0}m, 50 maps; 5\u{a0}m");
        assert_eq!(title_of("within 20 m of me"), "Within 20\u{a0}m of me");
    }
}
