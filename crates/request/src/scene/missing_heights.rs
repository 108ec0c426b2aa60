//! Heights of footprints whose files hold none.

use std::fmt;
use std::str::FromStr;

use skyshed_core::quantity::{parse_meters, tidy};

/// Rule that gives a footprint its missing height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HeightRule {
    /// Three meters for each storey.
    Levels,
    /// The median of the heights that the file holds, the lower one of two in the middle.
    Median,
    /// A height above the ground \[m\].
    Meters(f64),
}

/// Fate of a footprint that no rule gives a height.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WithoutHeight {
    /// It is left out. The file is refused where such footprints cover more than 2 % of the area of
    /// all.
    #[default]
    Few,
    /// It is left out.
    Drop,
    /// The file is refused.
    Fail,
}

/// Rules for missing heights, of which the first that gives a height wins.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MissingHeights {
    rules: Vec<HeightRule>,
    rest: WithoutHeight,
}

impl MissingHeights {
    /// Returns a list without rules.
    pub fn only(rest: WithoutHeight) -> Self {
        MissingHeights { rules: Vec::new(), rest }
    }

    /// Leaves out footprints without a height from any rule, whatever they cover, unless the list
    /// ends otherwise.
    #[must_use]
    pub fn with_rest_dropped(self) -> Self {
        let rest = if self.rest == WithoutHeight::Few { WithoutHeight::Drop } else { self.rest };
        MissingHeights { rest, ..self }
    }

    /// Returns the rules, in their order.
    pub fn rules(&self) -> &[HeightRule] {
        &self.rules
    }

    /// Returns the fate of footprints that no rule gives a height.
    pub fn rest(&self) -> WithoutHeight {
        self.rest
    }

    /// Returns `true` if storeys count.
    pub fn counts_storeys(&self) -> bool {
        self.rules.contains(&HeightRule::Levels)
    }

    /// Returns `true` if a number gives every footprint a height.
    pub fn gives_all(&self) -> bool {
        matches!(self.rules.last(), Some(HeightRule::Meters(_)))
    }
}

/// Words separated by commas: `levels`, `median`, a number of meters, and at the end `drop` or
/// `fail`.
impl FromStr for MissingHeights {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const WANTED: &str = "levels, median, a number of meters, and drop or fail as the last";
        let mut missing = MissingHeights::default();
        let mut words = text.split(',').map(str::trim).peekable();
        while let Some(word) = words.next() {
            if missing.gives_all() {
                return Err(format!("found `{word}` after a number, which gives all a height: it has nothing to do"));
            }
            let rule = match word {
                "levels" => HeightRule::Levels,
                "median" => HeightRule::Median,
                "drop" | "fail" => {
                    if words.peek().is_some() {
                        return Err(format!("found `{word}` before others, wanted it as the last"));
                    }
                    missing.rest = if word == "drop" { WithoutHeight::Drop } else { WithoutHeight::Fail };
                    break;
                }
                word => match parse_meters(word) {
                    Ok(m) if (0.1..=1000.0).contains(&m) => HeightRule::Meters(m),
                    Ok(m) => {
                        return Err(format!("found a height of {} m, wanted 0.1 m to 1000 m", tidy(m)));
                    }
                    Err(_) => return Err(format!("found `{word}`, wanted {WANTED}")),
                },
            };
            if missing.rules.contains(&rule) {
                return Err(format!("found `{word}` twice"));
            }
            missing.rules.push(rule);
        }
        Ok(missing)
    }
}

impl fmt::Display for MissingHeights {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rule = |rule: &HeightRule| match rule {
            HeightRule::Levels => "levels".to_string(),
            HeightRule::Median => "median".to_string(),
            HeightRule::Meters(m) => tidy(*m),
        };
        let rest = match self.rest {
            WithoutHeight::Few => None,
            WithoutHeight::Drop => Some("drop".to_string()),
            WithoutHeight::Fail => Some("fail".to_string()),
        };
        let words: Vec<String> = self.rules.iter().map(rule).chain(rest).collect();
        f.write_str(&words.join(","))
    }
}

skyshed_core::text!(MissingHeights);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_is_read_in_its_order_and_idle_words_are_refused() {
        let read = |text: &str| text.parse::<MissingHeights>();
        let list = read("levels,median,drop").expect("a list");
        assert_eq!((list.rules(), list.rest()), (&[HeightRule::Levels, HeightRule::Median][..], WithoutHeight::Drop));
        assert_eq!(read("levels, 30ft").expect("feet").rules()[1], HeightRule::Meters(9.144));
        assert_eq!(read("fail").expect("an end").rest(), WithoutHeight::Fail);
        for text in ["levels,median,drop", "levels,9", "fail", "median"] {
            assert_eq!(read(text).expect("a list").to_string(), text);
        }
        for (text, told) in [
            ("9,median", "after a number"),
            ("9,drop", "after a number"),
            ("drop,levels", "as the last"),
            ("levels,levels", "twice"),
            ("0", "0.1 m to 1000 m"),
            ("-1", "0.1 m to 1000 m"),
            ("mean", "wanted levels, median"),
            ("", "wanted levels, median"),
        ] {
            let error = read(text).expect_err(text);
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
