//! Heights of UAVs to try.

use std::fmt;
use std::str::FromStr;

use skyshed_core::quantity::{Height, MAX_HEIGHT_M, parse_meters};

/// More heights than this are refused.
const MOST_HEIGHTS: f64 = 1000.0;

/// Heights to try: `60,100`, `60:120:20`, `30roof`. The lowest is first where all have one reference.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Heights(pub Vec<Height>);

impl From<Height> for Heights {
    fn from(height: Height) -> Self {
        Heights(vec![height])
    }
}

impl From<Vec<Height>> for Heights {
    fn from(heights: Vec<Height>) -> Self {
        Heights(heights)
    }
}

impl FromIterator<Height> for Heights {
    fn from_iter<I: IntoIterator<Item = Height>>(heights: I) -> Self {
        Heights(heights.into_iter().collect())
    }
}

impl FromStr for Heights {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        read_heights(text).map(Heights)
    }
}

impl fmt::Display for Heights {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let texts: Vec<String> = self.0.iter().map(ToString::to_string).collect();
        f.write_str(&texts.join(","))
    }
}

skyshed_core::text!(Heights);

fn read_heights(text: &str) -> Result<Vec<Height>, String> {
    let refuse = |found: String| format!("{found} in `{text}`");
    let mut heights: Vec<Height> = match text.split(':').collect::<Vec<_>>()[..] {
        [from, to, step] => {
            one_unit(text).map_err(refuse)?;
            let of = |text: &str| text.parse::<Height>().map_err(refuse);
            let (from, to, step) = (of(from)?, of(to)?, parse_meters(step).map_err(refuse)?);
            let (a, b) = (from.value(), to.value());
            // The reference may be written once, behind the last height.
            let is_bare = matches!(from, Height::AboveGround(_));
            if !(is_bare || std::mem::discriminant(&from) == std::mem::discriminant(&to)) {
                return Err(refuse("found two references, wanted one".into()));
            }
            if a > b || step <= 0.0 || (b - a) / step >= MOST_HEIGHTS {
                return Err(refuse("wanted A:B:S with A not above B, S above 0 and at most 1000 heights".into()));
            }
            let n = ((b - a) / step * (1.0 + 1e-12)).floor();
            let values = (0..1000).map(f64::from).take_while(|k| *k <= n).map(|k| a + k * step).chain([b]);
            values.map(|value| with_value(to, value)).collect()
        }
        [list] => list.split(',').map(|h| h.parse::<Height>().map_err(refuse)).collect::<Result<_, _>>()?,
        _ => return Err(refuse("wanted a list or A:B:S".into())),
    };
    if let Some(beyond) = heights.iter().find(|h| h.value().abs() > MAX_HEIGHT_M) {
        return Err(refuse(format!("found `{beyond}`, wanted within ±32768 m")));
    }
    if have_one_reference(&heights) {
        heights.sort_by(|a, b| a.value().total_cmp(&b.value()));
    }
    heights.dedup();
    Ok(heights)
}

/// Returns `true` if heights are all above the ground, all above the roof or all above the datum.
pub fn have_one_reference(heights: &[Height]) -> bool {
    heights.windows(2).all(|pair| std::mem::discriminant(&pair[0]) == std::mem::discriminant(&pair[1]))
}

fn with_value(like: Height, value: f64) -> Height {
    match like {
        Height::AboveGround(_) => Height::AboveGround(value),
        Height::AboveRoof(_) => Height::AboveRoof(value),
        Height::AboveDatum(_) => Height::AboveDatum(value),
    }
}

/// Refuses a range of which some numbers are in feet and others are not.
///
/// # Errors
/// The text that was found, and the form wanted.
pub fn one_unit(range: &str) -> Result<(), String> {
    let parts: Vec<&str> = range.split(':').collect();
    match parts.iter().filter(|part| part.contains("ft")).count() {
        0 => Ok(()),
        n if n == parts.len() => Ok(()),
        _ => Err("found feet and bare numbers, wanted one unit, such as 100ft:400ft:50ft".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_a_list_or_a_range_with_both_ends() {
        let values =
            |text: &str| text.parse::<Heights>().map(|h| h.0.iter().map(ToString::to_string).collect::<Vec<_>>());
        assert_eq!(values("100,60,60"), Ok(vec!["60agl".into(), "100agl".into()]));
        assert!(values("10:35:10amsl").is_err());
        assert_eq!(values("10:35amsl:10"), Ok(["10amsl", "20amsl", "30amsl", "35amsl"].map(String::from).to_vec()));
        assert_eq!(values("10:30:10"), Ok(["10agl", "20agl", "30agl"].map(String::from).to_vec()));
        assert_eq!(values("30roof,100"), Ok(vec!["30roof".into(), "100agl".into()]));
        assert_eq!(values("100ft:200ft:50ft"), Ok(["30.48agl", "45.72agl", "60.96agl"].map(String::from).to_vec()));
        assert!(values("100:400ft:50").is_err_and(|e| e.contains("wanted one unit")));
        for wrong in ["", "a", "1:2", "9:1:1", "1:9:0", "1:9:-1", "0:9:1e-9", "1e9", "nan", "10roof:20amsl:1"] {
            assert!(wrong.parse::<Heights>().is_err(), "{wrong}");
        }
    }
}
