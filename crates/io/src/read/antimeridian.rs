//! Positions on both sides of 180 degrees: brought side by side, so that their middle lies between them.

use super::building::Buildings;
use crate::crs::is_web_mercator;
use crate::raster::{Crs, CrsKind};

/// Circumference of the earth in web Mercator \[CRS units\].
const AROUND_IN_MERCATOR: f64 = 2.0 * std::f64::consts::PI * 6_378_137.0;

/// Takes positions a turn on where they lie on both sides of 180 degrees. Those that span at most half a turn stay.
///
/// The turn begins after the widest gap between longitudes.
pub(super) fn unwrap(buildings: &mut Buildings, crs: &Crs) {
    let turn = match crs.kind() {
        CrsKind::Geographic => 360.0,
        _ if is_web_mercator(crs) => AROUND_IN_MERCATOR,
        _ => return,
    };
    let Some([west, _, east, _]) = buildings.bounds() else { return };
    if east - west <= turn / 2.0 {
        return;
    }
    let mut longitudes: Vec<f64> = Vec::new();
    for_each_x(buildings, |x| longitudes.push(x.rem_euclid(turn)));
    let start = after_widest_gap(longitudes, turn);
    for_each_x(buildings, |x| *x = start + (*x - start).rem_euclid(turn));
}

/// The longitude that follows the widest gap; all are from 0 to less than a turn.
fn after_widest_gap(mut longitudes: Vec<f64>, turn: f64) -> f64 {
    longitudes.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (longitudes.first().copied(), longitudes.last().copied()) else { return 0.0 };
    let gaps = longitudes.windows(2).map(|pair| (pair[1] - pair[0], pair[1]));
    let around = (first + turn - last, first);
    gaps.fold(around, |widest, gap| if gap.0 > widest.0 { gap } else { widest }).1
}

fn for_each_x(buildings: &mut Buildings, mut visit: impl FnMut(&mut f64)) {
    for footprint in &mut buildings.footprints {
        let positions = footprint.polygons.iter_mut().chain(&mut footprint.ground).flatten().flatten();
        positions.for_each(|position| visit(&mut position[0]));
        footprint.roof.iter_mut().flatten().flatten().for_each(|corner| visit(&mut corner[0]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_turn_begins_after_the_widest_gap() {
        for (longitudes, wanted) in
            [(vec![179.9, 180.1], 179.9), (vec![0.0, 359.0, 1.0], 359.0), (vec![10.0, 20.0], 10.0), (vec![5.0], 5.0)]
        {
            let found = after_widest_gap(longitudes.clone(), 360.0);
            assert!((found - wanted).abs() < 1e-9, "{longitudes:?}: {found}, wanted {wanted}");
        }
    }
}
