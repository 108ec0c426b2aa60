//! Words of the command line with a meaning of their own: numbers, lengths with a unit, lists, sizes, names.

use std::ffi::{OsStr, OsString};

pub(crate) use skyshed_request::words::{number, one_of};

pub(crate) use crate::quantity::read_length as length;
use skyshed_request::one_unit;

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
