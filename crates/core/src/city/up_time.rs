//! Times in which UAVs are up.

/// Clock of a moment. Moments of two clocks cannot be compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    /// A number.
    Number,
    /// A date and a time with its zone.
    Zoned,
    /// A date and a time of a zone that is not named.
    Local,
}

impl Clock {
    /// Returns the words for a moment of this clock in messages.
    pub fn name(self) -> &'static str {
        match self {
            Clock::Number => "a number",
            Clock::Zoned => "a time with its zone",
            Clock::Local => "a time without a zone",
        }
    }
}

/// Time in which a UAV is up: from its first moment on, and no longer at its last one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UpTime {
    /// First moment \[s since 1970, or since the 0 of numbers\]; minus infinity without one.
    pub from_s: f64,
    /// Last moment \[s\], after the first; infinity without one.
    pub to_s: f64,
    /// Clock of both.
    pub clock: Clock,
}

impl UpTime {
    /// Returns the times from the first to the last moment of some UAVs: the span that shares of time refer to
    /// \[s\]. `None` without two moments.
    pub fn span(all: impl Iterator<Item = UpTime>) -> Option<[f64; 2]> {
        let moments = all.flat_map(|up| [up.from_s, up.to_s]).filter(|s| s.is_finite());
        let span = moments.map(|s| [s, s]).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
        Some(span).filter(|[first, last]| first < last)
    }
}
