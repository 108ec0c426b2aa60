//! Positions on both sides of 180 degrees, brought side by side.

use super::is_web_mercator;
use crate::raster::{Crs, CrsKind};

/// Circumference of the earth in web Mercator \[CRS units\].
const AROUND_IN_MERCATOR: f64 = 2.0 * std::f64::consts::PI * 6_378_137.0;

/// One turn around the earth. It begins after the widest gap between positions, so that all lie
/// within it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Turn {
    start: f64,
    length: f64,
}

impl Turn {
    /// Returns the length of a turn in a system \[CRS units\]; `None` where coordinates do not go
    /// around the earth.
    pub(crate) fn length_in(crs: &Crs) -> Option<f64> {
        match crs.kind() {
            CrsKind::Geographic => Some(360.0),
            _ => is_web_mercator(crs).then_some(AROUND_IN_MERCATOR),
        }
    }

    /// Finds the turn for some eastings; `None` where they span at most half a turn.
    pub(crate) fn over(eastings: &[f64], length: f64) -> Option<Turn> {
        let (low, high) = eastings.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
        if high - low <= length / 2.0 {
            return None;
        }
        let mut around: Vec<f64> = eastings.iter().map(|x| x.rem_euclid(length)).collect();
        around.sort_by(f64::total_cmp);
        let (first, last) = (around.first()?, around.last()?);
        let gaps = around.windows(2).map(|pair| (pair[1] - pair[0], pair[1]));
        let widest =
            gaps.fold((first + length - last, *first), |widest, gap| if gap.0 > widest.0 { gap } else { widest });
        Some(Turn { start: widest.1, length })
    }

    /// Shifts an easting by whole turns into this one.
    pub(crate) fn apply(self, easting: f64) -> f64 {
        self.start + (easting - self.start).rem_euclid(self.length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_turn_begins_after_the_widest_gap() {
        for (eastings, wanted) in
            [(vec![179.9, -179.9], 179.9), (vec![0.0, 359.0, 1.0], 359.0), (vec![190.0, -10.0], 190.0)]
        {
            let turn = Turn::over(&eastings, 360.0).expect("a turn");
            assert!((turn.start - wanted).abs() < 1e-9, "{eastings:?}: {turn:?}, wanted {wanted}");
            assert!(eastings.iter().all(|x| (0.0..180.0).contains(&(turn.apply(*x) - turn.start))), "{eastings:?}");
        }
        for eastings in [vec![10.0, 20.0], vec![5.0], vec![]] {
            assert_eq!(Turn::over(&eastings, 360.0), None, "{eastings:?}");
        }
    }
}
