//! What a search makes large, and the heights that it tries.

use crate::error::{Error, RequestError, Result};
use crate::quantity::{Height, MAX_HEIGHT_M, parse_meters, parse_number};
use crate::sight::Receivers;
use crate::zones::Zone;

/// What is made large.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Measure {
    /// The share of receivers seen.
    Share,
    /// The margin of the worst receiver.
    Margin,
}

/// Whose sight counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Whom {
    /// All of those that were asked for.
    Receivers,
    /// Those of a zone.
    Zone(Zone),
    /// Those inside of an area.
    Area,
    /// All, each as much as a raster of weights says.
    Weights,
}

/// A goal.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Goal {
    pub(crate) measure: Measure,
    pub(crate) whom: Whom,
    /// The share to reach, where the least height is looked for.
    pub(crate) at_least: Option<f64>,
    /// As it was written.
    pub(crate) text: String,
}

impl Goal {
    /// Reads a goal: `p_los` or `margin`, alone or with `(street)` and so on; `p_los>=0.8` is a share to reach.
    ///
    /// # Errors
    /// E101.
    pub(crate) fn parse(text: &str) -> Result<Goal> {
        let wrong = |found: &str| Error::from(RequestError::Goal { text: text.to_string(), found: found.to_string() });
        let plain: String = text.chars().filter(|c| !c.is_whitespace()).collect();
        let (subject, share) = match plain.split_once(">=") {
            Some((subject, share)) => {
                let share = parse_number(share).map_err(|found| wrong(&found))?;
                if !(share > 0.0 && share <= 1.0) {
                    return Err(wrong(&format!("found a share of `{share}`, wanted above 0 and at most 1")));
                }
                (subject, Some(share))
            }
            None => (plain.as_str(), None),
        };
        let (measure, whom) = match subject.split_once('(') {
            Some((measure, rest)) => (measure, rest.strip_suffix(')').ok_or_else(|| wrong("found no `)` at the end"))?),
            None => (subject, ""),
        };
        let has_whom = subject.contains('(');
        let measure = match measure {
            "p_los" => Measure::Share,
            "margin" => Measure::Margin,
            other => return Err(wrong(&format!("found `{other}`"))),
        };
        let whom = match (whom, Zone::named(whom)) {
            (_, Some(zone)) => Whom::Zone(zone),
            ("area", _) => Whom::Area,
            ("weights", _) if measure == Measure::Share => Whom::Weights,
            ("population" | "persons" | "people", _) => {
                let no_persons = "weights are scores: each receiver counts the whole value of its cell, so persons would count many times";
                return Err(wrong(&format!("found `({whom})`; {no_persons}")));
            }
            ("", _) if !has_whom => Whom::Receivers,
            (other, _) => return Err(wrong(&format!("found `({other})`"))),
        };
        if share.is_some() && measure == Measure::Margin {
            return Err(wrong("found a share of a margin"));
        }
        Ok(Goal { measure, whom, at_least: share, text: text.to_string() })
    }

    /// The receivers that count, as those of a map.
    pub(crate) fn receivers(&self, asked: Receivers) -> Receivers {
        match self.whom {
            Whom::Zone(Zone::Street) => Receivers::Street,
            Whom::Zone(Zone::Crossroad) => Receivers::Crossroad,
            Whom::Zone(Zone::Courtyard) => Receivers::Courtyard,
            Whom::Zone(Zone::Rooftop) => Receivers::Roof,
            Whom::Receivers | Whom::Area | Whom::Weights => asked,
        }
    }
}

/// More heights than this are refused.
const MOST_HEIGHTS: f64 = 1000.0;

/// Heights as typed: a list, or A:B:S; the lowest first where all are above the same.
pub(crate) fn heights(text: &str) -> Result<Vec<Height>> {
    let refuse = |found: String| Error::from(RequestError::Heights { text: text.to_string(), found });
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
        [list] => list.split(',').map(|h| h.parse::<Height>().map_err(refuse)).collect::<Result<_>>()?,
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

/// Whether heights are all above the ground, all above the roof or all above the datum.
pub(crate) fn have_one_reference(heights: &[Height]) -> bool {
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
/// What was found and wanted.
pub(crate) fn one_unit(range: &str) -> std::result::Result<(), String> {
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
    fn goals_say_what_and_whom() {
        let goal = |text: &str| Goal::parse(text).map(|g| (g.measure, g.whom, g.at_least));
        assert_eq!(goal("p_los"), Ok((Measure::Share, Whom::Receivers, None)));
        assert_eq!(goal("p_los (street) >= 0.8"), Ok((Measure::Share, Whom::Zone(Zone::Street), Some(0.8))));
        assert_eq!(goal("margin(area)"), Ok((Measure::Margin, Whom::Area, None)));
        for wrong in
            "|los|p_los(|p_los()|p_los(park)|margin(weights)|margin>=1|p_los>=0|p_los>=nan|p_los>=1.5".split('|')
        {
            assert!(Goal::parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn heights_are_a_list_or_a_range_with_both_ends() {
        let values = |text: &str| heights(text).map(|h| h.iter().map(ToString::to_string).collect::<Vec<_>>());
        assert_eq!(values("100,60,60"), Ok(vec!["60agl".into(), "100agl".into()]));
        assert!(values("10:35:10amsl").is_err());
        assert_eq!(values("10:35amsl:10"), Ok(["10amsl", "20amsl", "30amsl", "35amsl"].map(String::from).to_vec()));
        assert_eq!(values("10:30:10"), Ok(["10agl", "20agl", "30agl"].map(String::from).to_vec()));
        assert_eq!(values("30roof,100"), Ok(vec!["30roof".into(), "100agl".into()]));
        assert_eq!(values("100ft:200ft:50ft"), Ok(["30.48agl", "45.72agl", "60.96agl"].map(String::from).to_vec()));
        assert!(values("100:400ft:50").is_err_and(|e| e.to_string().contains("wanted one unit")));
        for wrong in ["", "a", "1:2", "9:1:1", "1:9:0", "1:9:-1", "0:9:1e-9", "1e9", "nan", "10roof:20amsl:1"] {
            assert!(heights(wrong).is_err(), "{wrong}");
        }
    }
}
