//! Height that a property holds: a number, or text with a unit.

use super::vector::Property;
use skyshed_request::{HeightUnit, METERS_PER_FOOT};

/// Content of a height property.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FoundHeight {
    Meters(f64),
    DecimalComma(f64),
    Missing,
}

impl FoundHeight {
    /// Returns the height \[m\], if there is one.
    pub(super) fn meters(self) -> Option<f64> {
        match self {
            FoundHeight::Meters(m) | FoundHeight::DecimalComma(m) => Some(m),
            FoundHeight::Missing => None,
        }
    }

    /// Returns [`FoundHeight::Missing`] if `is_missing` holds for the number.
    pub(super) fn unless(self, is_missing: impl FnOnce(f64) -> bool) -> FoundHeight {
        match self.meters() {
            Some(m) if is_missing(m) => FoundHeight::Missing,
            _ => self,
        }
    }
}

/// Returns `true` when a top above the datum \[m\] is a number that means none.
pub(super) fn is_no_top(m: f64) -> bool {
    /// Largest distance of any roof on Earth from the datum \[m\].
    const MOST_M: f64 = 9000.0;
    // −9999, −99999, −32768, ±1e30 are beyond.
    m.abs() > MOST_M
}

/// Reads a height from a property: a number, or text such as `12`, `12.5 m`, `40 ft`, `39'4"`,
/// `12,5`. `unit` is that of numbers without one.
pub(super) fn found_height(value: &Property, unit: HeightUnit) -> FoundHeight {
    let text = match value {
        Property::Number(n) if n.is_finite() => return FoundHeight::Meters(n * unit.meters()),
        Property::Number(_) | Property::Null => return FoundHeight::Missing,
        Property::Text(text) => text.trim(),
    };
    if let Some((feet, inches)) = text.split_once('\'') {
        return feet_and_inches(feet, inches).map_or(FoundHeight::Missing, FoundHeight::Meters);
    }
    const UNITS: [(&str, f64); 8] = [
        ("ft", METERS_PER_FOOT),
        ("feet", METERS_PER_FOOT),
        ("foot", METERS_PER_FOOT),
        ("meters", 1.0),
        ("metres", 1.0),
        ("meter", 1.0),
        ("metre", 1.0),
        ("m", 1.0),
    ];
    let named = UNITS.iter().find_map(|(name, meters)| text.strip_suffix(name).map(|n| (n.trim_end(), *meters)));
    let (number, meters) = named.unwrap_or((text, unit.meters()));
    if let Ok(v) = number.parse::<f64>() {
        return if v.is_finite() { FoundHeight::Meters(v * meters) } else { FoundHeight::Missing };
    }
    // One comma and no point: a decimal comma, not a thousands separator followed by three digits.
    match number.split_once(',') {
        Some((whole, decimals)) if decimals.len() != 3 && !number.contains('.') => format!("{whole}.{decimals}")
            .parse::<f64>()
            .map_or(FoundHeight::Missing, |v| FoundHeight::DecimalComma(v * meters)),
        _ => FoundHeight::Missing,
    }
}

/// Converts `39` and `4"` to meters; inches may be left out, and are below 12.
fn feet_and_inches(feet: &str, inches: &str) -> Option<f64> {
    let feet: f64 = feet.trim().parse().ok().filter(|v: &f64| v.is_finite())?;
    let inches = inches.trim().trim_end_matches(['"', '\'']).trim();
    let inches: f64 = if inches.is_empty() { 0.0 } else { inches.parse().ok()? };
    (0.0..12.0).contains(&inches).then_some((feet + inches / 12.0) * METERS_PER_FOOT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_read_with_their_units_and_nonsense_is_missing() {
        let read = |text: &str| found_height(&Property::Text(text.into()), HeightUnit::Meters);
        for (text, meters) in [("12 m", 12.0), ("12.5m", 12.5), ("12.5", 12.5), ("100 ft", 30.48), ("100'", 30.48)] {
            assert_eq!(read(text), FoundHeight::Meters(meters), "{text}");
        }
        // 39 feet and 4 inches are 472 inches of 25.4 mm.
        let FoundHeight::Meters(mixed) = read("39'4\"") else { panic!("no height") };
        assert!((mixed - 472.0 * 0.0254).abs() < 1e-12, "{mixed}");
        assert_eq!(read("12,5"), FoundHeight::DecimalComma(12.5));
        for nonsense in ["1,200", "tall", "inf", "", "m", "39'14\"", "39'x", "nan ft"] {
            assert_eq!(read(nonsense), FoundHeight::Missing, "{nonsense}");
        }
        assert_eq!(found_height(&Property::Number(100.0), HeightUnit::Feet), FoundHeight::Meters(30.48));
        assert_eq!(found_height(&Property::Text("100 m".into()), HeightUnit::Feet), FoundHeight::Meters(100.0));
        assert_eq!(found_height(&Property::Number(f64::NAN), HeightUnit::Meters), FoundHeight::Missing);
    }
}
