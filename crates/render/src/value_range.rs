//! Mapping of values to colors: the scale of a layer, or of several.

use super::colors::{self, Ramp, Rgb};
use super::furniture::Scale;
use super::paint::quantiles;

/// Mapping of values to colors.
#[derive(Debug)]
pub(crate) struct ValueRange {
    ramp: Ramp,
    pub(crate) scale: Scale,
    /// True if positive values are few and small beside the negative ones, as margins are. They
    /// then share one color.
    pub(crate) flat_above_zero: bool,
}

/// Share of the negative side below which a positive side is not worth half of a ramp.
const SMALL_SIDE: f64 = 0.1;

impl ValueRange {
    /// Spans the middle 98 % of the receivers' values in all maps, from a sample of at most about a
    /// million.
    pub(crate) fn of_receivers(maps: &[(&[f32], &[u8])]) -> Self {
        let n: usize = maps.iter().map(|(values, _)| values.len()).sum();
        let step = (n / 1_000_000).max(1) | 1;
        let of_map = |(values, mask): &(&[f32], &[u8])| -> Vec<f32> {
            (0..values.len()).step_by(step).filter(|&cell| mask[cell] <= 1).map(|cell| values[cell]).collect()
        };
        let sample: Vec<f32> = maps.iter().flat_map(of_map).collect();
        let infinite = [f32::NEG_INFINITY, f32::INFINITY].map(|end| sample.iter().any(|v| v.total_cmp(&end).is_eq()));
        let [least, mut low, most_are_below, mut high, most] =
            quantiles(sample, [0.0, 0.01, 0.9, 0.99, 1.0]).unwrap_or([0.0, 0.0, 1.0, 1.0, 1.0]);
        let signed = least < 0.0 && most > 0.0;
        let flat_above_zero = signed && high <= -low * SMALL_SIDE;
        if flat_above_zero {
            high = 0.0;
        } else if signed {
            high = low.abs().max(high.abs());
            low = -high;
        } else if high > 3.0 * most_are_below.abs() {
            // A few extreme cells beside walls would leave all other cells one color.
            high = most_are_below;
        }
        (low, high) = widened(low, high);
        let slack = 1e-9 * (high - low);
        let scale = Scale {
            low,
            high,
            open_low: infinite[0] || least < low - slack,
            open_high: !flat_above_zero && (infinite[1] || most > high + slack),
        };
        Self { ramp: if signed { Ramp::Diverging } else { Ramp::Sequential }, scale, flat_above_zero }
    }

    /// Spans the whole range of some values.
    pub(crate) fn whole(values: &[f32]) -> Self {
        let [low, high] = quantiles(values.to_vec(), [0.0, 1.0]).unwrap_or([0.0, 1.0]);
        let (low, high) = widened(low, high);
        let scale = Scale { low, high, open_low: false, open_high: false };
        Self { ramp: Ramp::Sequential, scale, flat_above_zero: false }
    }

    /// Returns one of the 256 colors of receivers.
    pub(crate) fn color(&self, k: u8) -> Rgb {
        let t = f64::from(k) / 255.0;
        match (self.flat_above_zero, k) {
            (false, _) => self.ramp.at(t),
            (true, 255) => colors::LOS,
            // The orange half, short of the white in the middle.
            (true, _) => self.ramp.at(0.46 * t),
        }
    }

    /// Returns the index of a value's color, from 0 to `last`; `None` for NaN.
    pub(crate) fn index(&self, value: f32, last: u8) -> Option<usize> {
        if self.flat_above_zero && value >= 0.0 {
            return Some(last.into());
        }
        let last = usize::from(last) - usize::from(self.flat_above_zero);
        let t = (f64::from(value) - self.scale.low) / (self.scale.high - self.scale.low);
        (!value.is_nan()).then(|| colors::index(t * last as f64 + 0.5, last))
    }
}

/// Widens two ends that are nearly equal.
fn widened(low: f64, high: f64) -> (f64, f64) {
    if high - low < 1e-6 * (1.0 + high.abs()) { (low - 0.5, high + 0.5) } else { (low, high) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn margins_keep_one_color_for_line_of_sight_and_the_ramp_for_what_is_missing() {
        let mask = [1_u8; 6];
        let range = ValueRange::of_receivers(&[(&[-80.0, -60.0, -40.0, -20.0, 0.0, 1.5], &mask)]);
        assert!(range.flat_above_zero);
        assert_eq!((range.index(0.0, 255), range.index(1.5, 255)), (Some(255), Some(255)));
        assert!(range.index(-0.1, 255).is_some_and(|k| k < 255));
        assert_eq!(range.color(255), colors::LOS);
    }

    #[test]
    fn signed_fields_are_centered_on_zero_and_unsigned_are_not() {
        let mask = [1_u8; 4];
        let range = ValueRange::of_receivers(&[(&[-2.0, 0.0, 1.0, f32::NAN], &mask)]);
        assert_eq!((range.ramp, range.index(0.0, 255)), (Ramp::Diverging, Some(128)));
        assert!((range.scale.low + range.scale.high).abs() < 1e-12);
        assert_eq!(range.index(f32::NAN, 255), None);
        assert_eq!(ValueRange::of_receivers(&[(&[1.0, 2.0, 3.0, 4.0], &mask)]).ramp, Ramp::Sequential);
    }
}
