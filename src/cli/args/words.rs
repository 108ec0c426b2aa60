//! Words of the command line with a meaning of their own: numbers, lengths with a unit, lists, sizes, names.

use std::ffi::{OsStr, OsString};

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::formats::Band;
use crate::placements::one_unit;
use crate::quantity::read_numbers;
pub(crate) use crate::quantity::{
    read_angles as pair, read_fraction as fraction, read_length as length, read_number as number,
};
use crate::read::{GroundChoice, Projection};
use crate::sight::Receivers;
use crate::uav::Shard;
use crate::zones::Zone;

/// Words that may be typed, what each means, and its value. Help does not name those without a meaning, which are old.
pub(crate) type Words<T> = &'static [(&'static str, &'static str, T)];

/// Takes one of some words.
pub(crate) fn one_of<T: Copy + Send + Sync + 'static>(words: Words<T>) -> impl TypedValueParser<Value = T> {
    let possible = words.iter().map(|(word, help, _)| match help.is_empty() {
        true => PossibleValue::new(*word).hide(true),
        false => PossibleValue::new(*word).help(*help),
    });
    PossibleValuesParser::new(possible).map(move |typed| {
        // Any other word was refused.
        words.iter().find(|(word, ..)| *word == typed).map_or(words[0].2, |(.., value)| *value)
    })
}

pub(crate) const RECEIVERS: Words<Receivers> = &[
    ("ground", "All cells of open ground", Receivers::Ground),
    ("street", "Open ground that is neither crossroad nor courtyard", Receivers::Street),
    ("crossroad", "Where three or more streets meet", Receivers::Crossroad),
    ("courtyard", "Open ground that buildings enclose", Receivers::Courtyard),
    ("roof", "Building cells, standing on the roof", Receivers::Roof),
    ("all", "Ground and roofs", Receivers::All),
    ("air", "Over all ground, lower buildings included: where a drone may be", Receivers::Air),
];

pub(crate) const ZONES: Words<Zone> = &[
    ("street", "Open ground that is neither crossroad nor courtyard", Zone::Street),
    ("crossroad", "Where three or more streets meet", Zone::Crossroad),
    ("courtyard", "Open ground that buildings enclose", Zone::Courtyard),
    ("rooftop", "Buildings", Zone::Rooftop),
];

pub(crate) fn projection(text: &str) -> Result<Projection, String> {
    Projection::parse(text).map_err(|e| e.to_string())
}

pub(crate) fn band(text: &str) -> Result<Band, String> {
    Band::parse(text).ok_or_else(|| "wanted the number of a band, counted from 1, or its name".into())
}

/// The ground of a scene: a height, or `buildings`.
pub(crate) fn ground(text: &str) -> Result<GroundChoice, String> {
    if text == "buildings" {
        return Ok(GroundChoice::Buildings);
    }
    number(text).map(GroundChoice::Flat).map_err(|what| format!("{what}, or `buildings`"))
}

pub(crate) fn range(text: &str) -> Result<[f64; 3], String> {
    read_numbers(text, ':', "A:B:S")
}

pub(crate) fn extent(text: &str) -> Result<[f64; 4], String> {
    read_numbers(text, ',', "W,S,E,N")
}

/// One of several parts: `3/16`.
pub(crate) fn shard(text: &str) -> Result<Shard, String> {
    let wrong = || format!("found `{text}`, wanted K/N with K from 1 to N");
    let (k, of) = text.split_once('/').ok_or_else(wrong)?;
    let (k, of): (usize, usize) = k.trim().parse().ok().zip(of.trim().parse().ok()).ok_or_else(wrong)?;
    if (1..=of).contains(&k) { Ok(Shard { k, of }) } else { Err(wrong()) }
}

/// A tile, row and column: `3,12`.
pub(crate) fn tile(text: &str) -> Result<(usize, usize), String> {
    let wrong = || format!("found `{text}`, wanted ROW,COL counted from 0");
    let (row, col) = text.split_once(',').ok_or_else(wrong)?;
    row.trim().parse().ok().zip(col.trim().parse().ok()).ok_or_else(wrong)
}

/// The cells along a side of a tile, at least those of a block of a GeoTIFF.
pub(crate) fn cells_per_side(text: &str) -> Result<usize, String> {
    const BLOCK: usize = 16;
    let is_wanted = |n: &usize| *n >= BLOCK && n.is_multiple_of(BLOCK);
    let wrong = || format!("found `{text}`, wanted a multiple of {BLOCK}");
    text.trim().parse().ok().filter(is_wanted).ok_or_else(wrong)
}

/// A number of bytes: `800M`, `4G`, `1.5GiB`, or bytes alone.
pub(crate) fn memory_size(text: &str) -> Result<u64, String> {
    let wrong = || format!("found `{text}`, wanted a size such as 800M or 4G");
    let upper = text.trim().to_ascii_uppercase();
    let digits = upper.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match &upper[digits.len()..] {
        "" | "B" => 1.0,
        "K" | "KB" | "KIB" => 1024.0,
        "M" | "MB" | "MIB" => 1_048_576.0,
        "G" | "GB" | "GIB" => 1_073_741_824.0,
        "T" | "TB" | "TIB" => 1_099_511_627_776.0,
        _ => return Err(wrong()),
    };
    let number = number(digits).map_err(|_| wrong())?;
    if number <= 0.0 {
        return Err(wrong());
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive; saturates")]
    let bytes = (number * unit) as u64;
    Ok(bytes)
}

/// A zone and how many placements are over it.
pub(crate) fn zone_and_count(text: &str) -> Result<(Zone, usize), String> {
    let wanted = "wanted ZONE:N, such as crossroad:200";
    let (zone, count) = text.split_once(':').ok_or_else(|| format!("found `{text}`, {wanted}"))?;
    let zone = Zone::named(zone.trim())
        .ok_or_else(|| format!("found `{zone}`, wanted street, crossroad, courtyard or rooftop"))?;
    match count.trim().parse::<usize>() {
        Ok(count @ 1..=100_000) => Ok((zone, count)),
        _ => Err(format!("found `{count}` placements, wanted 1 to 100000")),
    }
}

/// Numbers as typed: `A:B:S`, `a,b,c`, or one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Numbers(pub(crate) Vec<f64>);

/// More numbers than this are refused.
const MOST_NUMBERS: f64 = 100_000.0;

pub(crate) fn numbers(text: &str) -> Result<Numbers, String> {
    numbers_of(text, number)
}

pub(crate) fn lengths(text: &str) -> Result<Numbers, String> {
    one_unit(text)?;
    numbers_of(text, length)
}

fn numbers_of(text: &str, number: fn(&str) -> Result<f64, String>) -> Result<Numbers, String> {
    if !text.contains(':') {
        return Ok(Numbers(text.split(',').map(number).collect::<Result<_, _>>()?));
    }
    let parts: Vec<f64> = text.split(':').map(number).collect::<Result<_, _>>()?;
    let [from, to, step] = parts[..] else {
        return Err(format!("found {} numbers, wanted A:B:S, a list, or one number", parts.len()));
    };
    if step <= 0.0 || from > to {
        return Err(format!("found {from}:{to}:{step}, wanted A not above B and S above 0"));
    }
    let n = ((to - from) / step + 1e-9).floor();
    if n >= MOST_NUMBERS {
        return Err(format!("{from}:{to}:{step} are {n} numbers, wanted at most {MOST_NUMBERS}"));
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "small and positive by the check above"
    )]
    let n = n as u32;
    // Each number from its index, so that errors do not add up; to 12 digits, so that 0.1:0.7:0.1 holds 0.3.
    let tidy = |v: f64| format!("{v:.12}").parse::<f64>().unwrap_or(v);
    let mut values: Vec<f64> = (0..=n).map(|k| tidy(from + f64::from(k) * step)).collect();
    if values.last().is_some_and(|last| to - last > 1e-9 * step) {
        values.push(to);
    }
    Ok(Numbers(values))
}

pub(crate) fn plus_minus(text: &str) -> Result<f64, String> {
    let digits = text.trim().trim_start_matches('±').trim_start_matches("+-").trim_start_matches("+/-");
    match number(digits) {
        Ok(p) if p > 0.0 && p < 0.5 => Ok(p),
        Ok(p) => Err(format!("found `{p}`, wanted above 0 and below 0.5")),
        Err(found) => Err(found),
    }
}

/// Whether a word asks for standard input.
pub(crate) fn is_standard_input(word: &OsString) -> bool {
    word == OsStr::new("-") || word.as_encoded_bytes().ends_with(b"=-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_both_ends_and_lists_what_they_say() {
        let of = |text: &str| numbers(text).map(|n| n.0);
        assert_eq!(of("5:90:5").map(|n| (n.len(), n[0], n[17])), Ok((18, 5.0, 90.0)));
        assert_eq!(of("0.1:0.7:0.1"), Ok(vec![0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]));
        assert_eq!(of("0:10:4"), Ok(vec![0.0, 4.0, 8.0, 10.0]));
        assert_eq!(of("45"), Ok(vec![45.0]));
        assert_eq!(of("30, 60"), Ok(vec![30.0, 60.0]));
        assert!(of("5:90").is_err() && of("90:5:5").is_err() && of("5:90:0").is_err() && of("5:nan:1").is_err());
        assert!(of("0:1e9:1").is_err());
        assert_eq!((plus_minus("±0.005"), plus_minus("+-0.01")), (Ok(0.005), Ok(0.01)));
        assert!(plus_minus("0").is_err() && plus_minus("nan").is_err());
    }
}
