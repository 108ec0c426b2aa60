//! Lists of numbers.

use std::fmt;
use std::str::FromStr;

use skyshed_core::quantity::{read_length, read_number};

use crate::one_unit;

/// Most numbers of a list.
const MOST_NUMBERS: f64 = 100_000.0;

/// Numbers: `5:90:5`, `30,60`, or one.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NumberList(pub Vec<f64>);

/// Lengths \[m\]: `60:120:20`, `60,400ft`, or one.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LengthList(pub Vec<f64>);

impl FromStr for NumberList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        numbers_of(text, read_number).map(NumberList)
    }
}

impl FromStr for LengthList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        one_unit(text)?;
        numbers_of(text, read_length).map(LengthList)
    }
}

/// Implements writing, and setting from arrays.
macro_rules! list {
    ($Name:ident) => {
        impl fmt::Display for $Name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let texts: Vec<String> = self.0.iter().map(ToString::to_string).collect();
                f.write_str(&texts.join(","))
            }
        }

        impl<const N: usize> crate::IntoValue<$Name> for [f64; N] {
            fn into_value(self) -> $Name {
                $Name(self.into())
            }
        }

        impl crate::IntoValue<$Name> for Vec<f64> {
            fn into_value(self) -> $Name {
                $Name(self)
            }
        }

        skyshed_core::text!($Name);
    };
}

list!(NumberList);
list!(LengthList);

fn numbers_of(text: &str, number: fn(&str) -> Result<f64, String>) -> Result<Vec<f64>, String> {
    if !text.contains(':') {
        return text.split(',').map(number).collect();
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
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_both_ends_and_lists_what_they_say() {
        let of = |text: &str| text.parse::<NumberList>().map(|n| n.0);
        assert_eq!(of("5:90:5").map(|n| (n.len(), n[0], n[17])), Ok((18, 5.0, 90.0)));
        assert_eq!(of("0.1:0.7:0.1"), Ok(vec![0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]));
        assert_eq!(of("0:10:4"), Ok(vec![0.0, 4.0, 8.0, 10.0]));
        assert_eq!(of("45"), Ok(vec![45.0]));
        assert_eq!(of("30, 60"), Ok(vec![30.0, 60.0]));
        assert!(of("5:90").is_err() && of("90:5:5").is_err() && of("5:90:0").is_err() && of("5:nan:1").is_err());
        assert!(of("0:1e9:1").is_err());
        assert_eq!("200ft,100".parse::<LengthList>(), Ok(LengthList(vec![60.96, 100.0])));
    }
}
