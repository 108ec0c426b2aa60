//! Quantities that are easily swapped, and the lattice on which line of sight is decided.
//!
//! All decisions about visibility are made in integers. Heights are in 1/1024 m above the datum.
//! Horizontal positions are in 1/1024 of a unit: the meter in vector scenes, the cell in raster
//! scenes. Numbers are rounded once, on entry, by at most half a lattice step (0.5 mm in height).
//! After that nothing is rounded.

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

/// Lattice steps per meter of height, and per horizontal unit.
pub const STEPS_PER_UNIT: i32 = 1024;

/// The largest height above or below the datum \[m\]; larger heights are refused.
pub const MAX_HEIGHT_M: f64 = 32_768.0;

/// The largest extent of the box around one UAV and the cells in its range \[units\].
pub const MAX_EXTENT_UNITS: f64 = 65_536.0;

/// The height of a cell without one (nodata, or outside a raster). It is below every height, so the
/// cell blocks nothing.
pub const VOID: i32 = i32::MIN;

/// The top of a nodata cell that blocks every link. It is above every height, so no receiver behind
/// it is high enough.
pub const BLOCKS_ALL: i32 = 1 << 26;

/// Rounds a height above the datum to lattice steps of 1/1024 m. Halves are rounded up.
///
/// Returns `None` if `meters` is not finite or beyond ±32 768 m.
pub fn height_steps(meters: f64) -> Option<i32> {
    if !meters.is_finite() || meters.abs() > MAX_HEIGHT_M {
        return None;
    }
    #[expect(clippy::cast_possible_truncation, reason = "within ±2^25 by the check above")]
    let steps = (meters * f64::from(STEPS_PER_UNIT) + 0.5).floor() as i32;
    Some(steps)
}

/// Converts lattice steps of height to meters.
pub fn meters(steps: i32) -> f64 {
    f64::from(steps) / f64::from(STEPS_PER_UNIT)
}

/// A point on the lattice of a scene: x east, y north, z up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LatticePoint {
    /// East of the local origin \[1/1024 unit\].
    pub x: i64,
    /// North of the local origin \[1/1024 unit\].
    pub y: i64,
    /// Above the datum \[1/1024 m\].
    pub z: i64,
}

/// Transform from plane coordinates to lattice positions: a local origin and the length of the
/// horizontal unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// World x of the local origin \[CRS units\].
    pub x_origin: f64,
    /// World y of the local origin \[CRS units\].
    pub y_origin: f64,
    /// Length of one unit along x \[CRS units\]: 1 in a vector scene, the cell width in a raster
    /// scene.
    pub unit_x: f64,
    /// Length of one unit along y \[CRS units\].
    pub unit_y: f64,
}

impl Frame {
    /// Returns the lattice position nearest to world `(x, y)`; halves go north-east.
    ///
    /// Saturates far outside the lattice, where the extent check of a site refuses it.
    pub fn lattice_from_world(&self, x: f64, y: f64) -> (i64, i64) {
        let steps = f64::from(STEPS_PER_UNIT);
        #[expect(clippy::cast_possible_truncation, reason = "saturating is what is documented")]
        let round = |v: f64| (v * steps + 0.5).floor().clamp(-1e15, 1e15) as i64;
        (round((x - self.x_origin) / self.unit_x), round((y - self.y_origin) / self.unit_y))
    }

    /// Returns the world coordinates of a lattice position in (possibly fractional) lattice steps.
    pub fn world_from_lattice(&self, x: f64, y: f64) -> (f64, f64) {
        let steps = f64::from(STEPS_PER_UNIT);
        (self.x_origin + x / steps * self.unit_x, self.y_origin + y / steps * self.unit_y)
    }
}

/// A height and its reference: the ground, the roof or the datum.
///
/// Written `120agl`, `30roof`, `150amsl`; a bare number is above ground. Feet are written `400ft`,
/// `400ft amsl`; heights are shown in meters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Height {
    /// Above the ground under the point \[m\].
    AboveGround(f64),
    /// Above the roof under the point \[m\].
    AboveRoof(f64),
    /// Above the datum of the scene \[m\].
    AboveDatum(f64),
}

impl Height {
    /// Returns a height above the ground under the point \[m\].
    pub fn agl(meters: f64) -> Height {
        Height::AboveGround(meters)
    }

    /// Returns a height above the roof under the point \[m\].
    pub fn roof(meters: f64) -> Height {
        Height::AboveRoof(meters)
    }

    /// Returns a height above the datum of the scene \[m\].
    pub fn amsl(meters: f64) -> Height {
        Height::AboveDatum(meters)
    }

    /// Returns the number without its reference \[m\].
    pub fn value(self) -> f64 {
        match self {
            Height::AboveGround(v) | Height::AboveRoof(v) | Height::AboveDatum(v) => v,
        }
    }
}

impl fmt::Display for Height {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Height::AboveGround(v) => write!(f, "{v}agl"),
            Height::AboveRoof(v) => write!(f, "{v}roof"),
            Height::AboveDatum(v) => write!(f, "{v}amsl"),
        }
    }
}

impl FromStr for Height {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        type Kind = fn(f64) -> Height;
        let kinds: [(&str, Kind); 3] = [("agl", Height::agl), ("roof", Height::roof), ("amsl", Height::amsl)];
        let typed = kinds.into_iter().find_map(|(suffix, make)| Some((text.strip_suffix(suffix)?.trim_end(), make)));
        let (number, make) = typed.unwrap_or((text, Height::agl));
        parse_meters(number).map(make).map_err(|found| {
            format!("height `{text}`: {found}, wanted meters, or feet (`400ft`), bare or with `agl`, `roof` or `amsl`")
        })
    }
}

/// Returns a part as a share of the whole, such as P_LoS of receivers; `None` if the whole is 0.
pub fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

/// Formats a count with its noun: `1 cell`, `2 cells`.
pub fn counted(n: u64, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// Formats a number with at most two decimals and no trailing zeros.
pub fn tidy(v: f64) -> String {
    let text = format!("{v:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.to_string() }
}

/// Formats a number with `n` decimals, never as −0.
pub fn fixed(v: f64, n: usize) -> String {
    let text = format!("{v:.n$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|byte| matches!(byte, b'0' | b'.')) => digits.to_string(),
        _ => text,
    }
}

/// Formats a difference with `n` decimals: `+0.01`, `−0.01` or `0.00`.
pub fn signed(v: f64, n: usize) -> String {
    let text = fixed(v, n);
    if text.bytes().all(|byte| matches!(byte, b'0' | b'.')) {
        return text;
    }
    text.strip_prefix('-').map_or_else(|| format!("+{text}"), |digits| format!("−{digits}"))
}

/// Rounds a quotient of lengths to the nearest integer if it is within 10^-6 of it.
///
/// Coordinates far from the origin are rounded, which must not add a row or a column.
pub fn whole(quotient: f64) -> f64 {
    let nearest = quotient.round();
    if (quotient - nearest).abs() <= 1e-6 { nearest } else { quotient }
}

/// A number out of range: its name, its value and the wanted range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{what} is `{found}`, wanted {wanted}")]
#[expect(missing_docs, reason = "the docs of the type say what its fields are")]
pub struct OutOfRange {
    pub what: &'static str,
    pub found: f64,
    pub wanted: Cow<'static, str>,
}

/// Reads a finite number as typed.
///
/// # Errors
/// Text that states what was found and what was wanted.
pub fn read_number(text: &str) -> Result<f64, String> {
    parse_number(text).map_err(|found| format!("{found}, wanted a finite number"))
}

/// Reads a length as typed, in meters, or in feet with `ft` \[m\].
///
/// # Errors
/// Text that states what was found and what was wanted.
pub fn read_length(text: &str) -> Result<f64, String> {
    parse_meters(text).map_err(|found| format!("{found}, wanted meters, or feet such as 5ft"))
}

/// Reads a number, a fraction such as `4/3`, or `inf`, as typed.
///
/// # Errors
/// Text that states what was found and what was wanted.
pub fn read_fraction(text: &str) -> Result<f64, String> {
    match text.split_once('/') {
        _ if text == "inf" => Ok(f64::INFINITY),
        Some((a, b)) => Ok(read_number(a)? / read_number(b)?),
        None => read_number(text),
    }
}

/// Reads `N` numbers between separators. `wanted` describes them in the error.
///
/// # Errors
/// Text that states what was found and what was wanted.
pub fn read_numbers<const N: usize>(text: &str, separator: char, wanted: &str) -> Result<[f64; N], String> {
    let numbers: Result<Vec<f64>, String> = text.split(separator).map(read_number).collect();
    <[f64; N]>::try_from(numbers?).map_err(|n| format!("found {} numbers, wanted {wanted}", n.len()))
}

/// Reads two angles as typed, such as `90,180`.
///
/// # Errors
/// Text that states what was found and what was wanted.
pub fn read_angles(text: &str) -> Result<[f64; 2], String> {
    read_numbers(text, ',', "two, such as 90,180")
}

/// Reads a length as typed, in meters (`120`, `120m`) or in international feet (`400ft`) \[m\]. The
/// error states what was found.
pub fn parse_meters(text: &str) -> Result<f64, String> {
    let text = text.trim();
    // A foot is 0.3048 m. The division comes last, so that 10ft are exactly 3.048.
    let length = match (text.strip_suffix("ft"), text.strip_suffix('m')) {
        (Some(feet), _) => parse_number(feet).map(|feet| feet * 3048.0 / 10_000.0),
        (None, Some(meters)) => parse_number(meters),
        (None, None) => return parse_number(text),
    };
    length.ok().filter(|length| length.is_finite()).map_or_else(|| parse_number(text), Ok)
}

/// Reads a finite number. The error states what was found.
pub fn parse_number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        Ok(v) => Err(format!("found `{v}`, which is not finite")),
        Err(_) => Err(format!("found `{}`, which is not a number", text.trim())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_round_to_the_nearest_lattice_step_and_refuse_what_is_out_of_range() {
        assert_eq!(height_steps(1.5), Some(1536));
        assert_eq!(height_steps(-0.5 / 1024.0), Some(0));
        assert_eq!(height_steps(32_768.0), Some(1 << 25));
        assert_eq!(height_steps(32_768.001), None);
        assert_eq!(height_steps(f64::NAN), None);
        assert_eq!(height_steps(f64::NEG_INFINITY), None);
    }

    #[test]
    fn feet_are_turned_into_meters() {
        for (text, height) in [
            ("200ft", Height::AboveGround(60.96)),
            ("200ftagl", Height::AboveGround(60.96)),
            ("-10 ft", Height::AboveGround(-3.048)),
            ("200 ft amsl", Height::AboveDatum(60.96)),
            ("100ftroof", Height::AboveRoof(30.48)),
            ("120m", Height::AboveGround(120.0)),
            ("120 m amsl", Height::AboveDatum(120.0)),
        ] {
            assert_eq!(text.parse(), Ok(height), "{text}");
            assert_eq!(height.to_string().parse(), Ok(height), "{text}");
        }
        for wrong in ["ft", "m", "nanft", "1e999ft", "10ftm", "10mft", "10 feet", "10amsl ft", "10km"] {
            assert!(wrong.parse::<Height>().is_err(), "{wrong}");
        }
    }
}
