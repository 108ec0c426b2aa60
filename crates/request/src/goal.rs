//! Goals of placement.

use std::fmt;
use std::str::FromStr;

use skyshed_core::quantity::parse_number;
use skyshed_core::zones::Zone;

use crate::Receivers;

/// Quantity to make large.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measure {
    /// The share of receivers in line of sight.
    Share,
    /// The margin of the worst receiver.
    Margin,
}

/// Receivers that count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Whom {
    /// All receivers of the question.
    Receivers,
    /// The receivers of a zone.
    Zone(Zone),
    /// The receivers inside of an area.
    Area,
    /// All receivers, each with the weight of a raster.
    Weights,
}

/// Goal of placement: `p_los`, `margin`, `p_los(street)`, `p_los>=0.8`.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Goal {
    /// Quantity to make large.
    pub measure: Measure,
    /// Receivers that count.
    pub whom: Whom,
    /// Share to reach, where the least height is wanted.
    pub at_least: Option<f64>,
    /// Text that the goal was read from.
    pub text: String,
}

impl Goal {
    /// Returns the goal of the largest share of all receivers.
    pub fn p_los() -> Goal {
        Goal { measure: Measure::Share, whom: Whom::Receivers, at_least: None, text: "p_los".into() }
    }

    /// Returns the receivers that count, as those of a map.
    pub fn receivers(&self, asked: Receivers) -> Receivers {
        match self.whom {
            Whom::Zone(Zone::Street) => Receivers::Street,
            Whom::Zone(Zone::Crossroad) => Receivers::Crossroad,
            Whom::Zone(Zone::Courtyard) => Receivers::Courtyard,
            Whom::Zone(Zone::Rooftop) => Receivers::Roof,
            Whom::Receivers | Whom::Area | Whom::Weights => asked,
        }
    }
}

impl FromStr for Goal {
    type Err = String;

    fn from_str(text: &str) -> Result<Goal, String> {
        const WANTED: &str = "wanted p_los or margin, alone or with (street), (crossroad), (courtyard), (rooftop), (area), or \
                              p_los(weights)";
        let wrong = |found: &str| format!("{found}, {WANTED}");
        let plain: String = text.chars().filter(|c| !c.is_whitespace()).collect();
        let (subject, share) = match plain.split_once(">=") {
            Some((subject, share)) => {
                let share = parse_number(share).map_err(|found| wrong(&found))?;
                if !(share > 0.0 && share <= 1.0) {
                    return Err(format!("found a share of `{share}`, wanted above 0 and at most 1"));
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
        let whom = match (whom, whom.parse::<Zone>().ok()) {
            (_, Some(zone)) => Whom::Zone(zone),
            ("area", _) => Whom::Area,
            ("weights", _) if measure == Measure::Share => Whom::Weights,
            ("population" | "persons" | "people", _) => {
                let no_persons = "weights are scores: each receiver counts the whole value of its cell, so persons would count \
                                  many times";
                return Err(format!("found `({whom})`; {no_persons}"));
            }
            ("", _) if !has_whom => Whom::Receivers,
            (other, _) => return Err(wrong(&format!("found `({other})`"))),
        };
        if share.is_some() && measure == Measure::Margin {
            return Err(wrong("found a share of a margin"));
        }
        Ok(Goal { measure, whom, at_least: share, text: text.to_string() })
    }
}

impl fmt::Display for Goal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

skyshed_core::text!(Goal);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_say_what_and_whom() {
        let goal = |text: &str| text.parse::<Goal>().map(|g| (g.measure, g.whom, g.at_least));
        assert_eq!(goal("p_los"), Ok((Measure::Share, Whom::Receivers, None)));
        assert_eq!(goal("p_los (street) >= 0.8"), Ok((Measure::Share, Whom::Zone(Zone::Street), Some(0.8))));
        assert_eq!(goal("margin(area)"), Ok((Measure::Margin, Whom::Area, None)));
        for wrong in
            "|los|p_los(|p_los()|p_los(park)|margin(weights)|margin>=1|p_los>=0|p_los>=nan|p_los>=1.5".split('|')
        {
            assert!(goal(wrong).is_err(), "{wrong}");
        }
    }
}
