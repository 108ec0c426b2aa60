//! Moments in tables and paths: ISO 8601, or a number since a beginning that nobody names.

use chrono::{DateTime, NaiveDateTime};

use super::table::RowFault;
use crate::city::{Clock, UpTime};
use crate::error::{MOST_FOUND, shortened};
use crate::quantity::{parse_number, tidy};

/// A moment, and how it is counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moment {
    /// Seconds since the beginning of its clock: since 1970 for a date, else since 0.
    pub(super) seconds: f64,
    /// Clock that it is read from.
    pub(super) clock: Clock,
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
        let (text_of_zone, clock) = text.strip_suffix('Z').map_or((text, Clock::Local), |text| (text, Clock::Zoned));
        let formats = ["%Y-%m-%dT%H:%M:%S%.f", "%Y-%m-%d %H:%M:%S%.f", "%Y-%m-%dT%H:%M", "%Y-%m-%d %H:%M"];
        let local = formats.iter().find_map(|format| NaiveDateTime::parse_from_str(text_of_zone, format).ok());
        let utc = local.map(|time| time.and_utc()).ok_or_else(|| {
            format!("found `{}`, wanted a number or a time such as 2026-05-01T14:30:00Z", shortened(text, MOST_FOUND))
        })?;
        Ok(Moment { seconds: seconds(utc.timestamp(), utc.timestamp_subsec_nanos()), clock })
    }
}

/// Reads the time in which a UAV is up from the texts of its columns `from` and `to`; numbers are minutes.
/// `None` for one that is always up.
///
/// # Errors
/// What was found, and what is wanted.
pub fn up_time(from: Option<&str>, to: Option<&str>) -> Result<Option<UpTime>, String> {
    const MINUTE_S: f64 = 60.0;
    let read = |name: &str, text: Option<&str>| {
        let moment = text.filter(|text| !text.trim().is_empty()).map(|text| Moment::parse(text, MINUTE_S)).transpose();
        moment.map_err(|found| format!("`{name}`: {found}"))
    };
    let (from, to) = (read("from", from)?, read("to", to)?);
    let Some(first) = from.or(to) else { return Ok(None) };
    if let (Some(from), Some(to)) = (from, to) {
        if from.clock != to.clock {
            return Err(format!("`to`: found {}, wanted {} as in `from`", to.clock.name(), from.clock.name()));
        }
        if from.seconds >= to.seconds {
            let of = |moment: Moment| moment_words(moment.clock, moment.seconds);
            return Err(format!("`to`: found {}, wanted a time after {}", of(to), of(from)));
        }
    }
    let end = |moment: Option<Moment>, open: f64| moment.map_or(open, |moment| moment.seconds);
    let (from_s, to_s) = (end(from, f64::NEG_INFINITY), end(to, f64::INFINITY));
    Ok(Some(UpTime { from_s, to_s, clock: first.clock }))
}

/// Returns a moment as tables hold it: minutes, or ISO 8601 (in UTC if its zone is known).
pub fn moment_words(clock: Clock, seconds: f64) -> String {
    #[expect(clippy::cast_possible_truncation, reason = "years of four digits")]
    let micros = (seconds * 1e6).round() as i64;
    let time = DateTime::from_timestamp_micros(micros).filter(|_| clock != Clock::Number);
    let format = if clock == Clock::Zoned { "%Y-%m-%dT%H:%M:%S%.fZ" } else { "%Y-%m-%dT%H:%M:%S%.f" };
    time.map_or_else(|| tidy(seconds / 60.0), |time| time.format(format).to_string())
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
    fn times_of_uavs_are_half_open_and_of_one_clock() {
        let of = |from: &str, to: &str| up_time(Some(from), Some(to));
        let up = of("0", "1.5").expect("a time").expect("limits");
        assert_eq!((up.from_s, up.to_s, up.clock), (0.0, 90.0, Clock::Number));
        assert_eq!(of("", " ").expect("no time"), None);
        let open = of("2026-05-01T14:30:00+02:00", "").expect("a time").expect("a limit");
        assert_eq!(
            (moment_words(open.clock, open.from_s).as_str(), open.to_s),
            ("2026-05-01T12:30:00Z", f64::INFINITY)
        );
        for (from, to) in [("1", "1"), ("2", "1"), ("1", "2026-05-01T12:30:00Z"), ("1", "soon")] {
            assert!(of(from, to).is_err(), "{from} {to}");
        }
        assert_eq!(of("2026-05-01T12:30Z", "").expect("a time"), Some(open));
        let words = ["2026-05-01T12:30:15.250", "1999-12-31T23:59:59"];
        for text in words {
            let moment = Moment::parse(text, 1.0).expect("a moment");
            assert_eq!(moment_words(moment.clock, moment.seconds), text);
        }
        assert_eq!(moment_words(Clock::Number, 90.0), "1.5");
    }

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
