//! Moments in tables and paths: ISO 8601, or a number since a beginning that nobody names.

use chrono::{DateTime, NaiveDateTime};

use super::table::RowFault;
use crate::error::{MOST_FOUND, shortened};
use crate::quantity::parse_number;

/// A moment, and how it is counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moment {
    /// Seconds since the beginning of its clock: since 1970 for a date, else since 0.
    pub(super) seconds: f64,
    /// Clock that it is read from.
    pub(super) clock: Clock,
}

/// Clock of a moment. Moments of two clocks cannot be compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Clock {
    /// A number.
    Number,
    /// A date and a time with its zone.
    Zoned,
    /// A date and a time of a zone that is not named.
    Local,
}

impl Clock {
    /// Returns what a moment of this clock is called.
    fn name(self) -> &'static str {
        match self {
            Clock::Number => "a number",
            Clock::Zoned => "a time with its zone",
            Clock::Local => "a time without a zone",
        }
    }
}

impl Moment {
    /// Reads a moment; a bare number counts units of some seconds.
    ///
    /// # Errors
    /// What was found, and what is wanted.
    pub(super) fn parse(text: &str, unit_s: f64) -> Result<Moment, String> {
        let text = text.trim();
        if let Ok(number) = parse_number(text) {
            return Ok(Moment { seconds: number * unit_s, clock: Clock::Number });
        }
        #[expect(clippy::cast_precision_loss, reason = "seconds since 1970 are far below 2^53")]
        let seconds = |s: i64, nanos: u32| s as f64 + f64::from(nanos) * 1e-9;
        if let Ok(time) = DateTime::parse_from_rfc3339(text) {
            let seconds = seconds(time.timestamp(), time.timestamp_subsec_nanos());
            return Ok(Moment { seconds, clock: Clock::Zoned });
        }
        let formats = ["%Y-%m-%dT%H:%M:%S%.f", "%Y-%m-%d %H:%M:%S%.f", "%Y-%m-%dT%H:%M", "%Y-%m-%d %H:%M"];
        let local = formats.iter().find_map(|format| NaiveDateTime::parse_from_str(text, format).ok());
        let utc = local.map(|time| time.and_utc()).ok_or_else(|| {
            format!("found `{}`, wanted a number or a time such as 2026-05-01T14:30:00Z", shortened(text, MOST_FOUND))
        })?;
        Ok(Moment { seconds: seconds(utc.timestamp(), utc.timestamp_subsec_nanos()), clock: Clock::Local })
    }
}

/// The clock of the moments of a file, which is one for all.
#[derive(Debug, Default)]
pub(super) struct OneClock(Option<Clock>);

impl OneClock {
    /// Returns the seconds of a moment.
    ///
    /// # Errors
    /// If its clock is not that of the moments before it.
    pub(super) fn seconds(&mut self, moment: Moment) -> Result<f64, RowFault> {
        let first = *self.0.get_or_insert(moment.clock);
        if first == moment.clock {
            return Ok(moment.seconds);
        }
        let (found, wanted) = (moment.clock.name(), first.name());
        Err(RowFault::Text(format!("found {found}, wanted {wanted} as in the rows before")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_seconds_of_their_clock() {
        let of = |text: &str| Moment::parse(text, 60.0).map(|m| (m.seconds, m.clock));
        assert_eq!(of("1.5"), Ok((90.0, Clock::Number)));
        assert_eq!(of("1970-01-02T00:00:00Z"), Ok((86_400.0, Clock::Zoned)));
        assert_eq!(of("1970-01-01T02:00:00.25+01:00"), Ok((3600.25, Clock::Zoned)));
        assert_eq!(of("1970-01-01 00:01"), Ok((60.0, Clock::Local)));
        assert_eq!(of("1970-01-01T00:01:30"), Ok((90.0, Clock::Local)));
        for text in ["", "noon", "2026-13-01T00:00", "2026-05-01", "NaN", "inf"] {
            assert!(of(text).is_err(), "{text}");
        }
    }
}
