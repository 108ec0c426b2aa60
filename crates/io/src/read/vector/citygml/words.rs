//! Texts of CityGML: characters, positions, and values of attributes.

use super::super::feature::Property;

/// Longest tag or text \[bytes\]; a ring of a million corners takes as much.
pub(super) const LONGEST_BYTES: usize = 64 << 20;

/// Returns the character of a reference; entities of the file are not expanded.
pub(super) fn resolved(name: &[u8]) -> Option<String> {
    let name = std::str::from_utf8(name).ok()?;
    if let Some(number) = name.strip_prefix('#') {
        let code = match number.strip_prefix('x') {
            Some(digits) => u32::from_str_radix(digits, 16).ok()?,
            None => number.parse().ok()?,
        };
        return char::from_u32(code).map(String::from);
    }
    let known = [("amp", "&"), ("lt", "<"), ("gt", ">"), ("quot", "\""), ("apos", "'")];
    known.iter().find(|(known, _)| *known == name).map(|(_, text)| (*text).to_string())
}

/// Returns `true` for the encodings whose bytes are the first 256 characters.
pub(super) fn is_latin(name: &[u8]) -> bool {
    [&b"iso-8859-1"[..], b"latin1", b"iso-8859-15", b"windows-1252"]
        .iter()
        .any(|known| name.eq_ignore_ascii_case(known))
}

/// Appends positions of a text to a ring. Returns `true` if they have no heights.
pub(super) fn positions(
    text: &str,
    dimension: Option<usize>,
    ring: &mut Vec<[f64; 3]>,
) -> std::result::Result<bool, String> {
    let words = || text.split(|c: char| c.is_ascii_whitespace() || c == ',').filter(|word| !word.is_empty());
    let n = words().count();
    // Some writers leave out that positions have three numbers, or two.
    let dimension = dimension.filter(|d| n % d == 0).unwrap_or(if n % 3 == 0 { 3 } else { 2 });
    if n % dimension != 0 {
        return Err(format!("{n} numbers of positions"));
    }
    let (mut position, mut k) = ([0.0; 3], 0);
    for word in words() {
        let number: f64 = word.parse().map_err(|_| format!("`{word}` in positions"))?;
        if !number.is_finite() {
            return Err(format!("`{word}` in positions"));
        }
        position[k] = number;
        k += 1;
        if k == dimension {
            ring.push(position);
            k = 0;
        }
    }
    Ok(dimension == 2)
}

/// Returns a text as a property: a number \[m\] where it is one.
pub(super) fn property(text: &str, unit_m: f64) -> Property {
    let text = text.trim();
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Property::Number(number * unit_m),
        _ => Property::Text(text.to_string()),
    }
}
