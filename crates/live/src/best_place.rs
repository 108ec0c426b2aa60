//! Best place near a UAV: places on a square grid within a circle, tried one by one.

use skyshed_core::coverage::{self, HoversOver, Mapper};
use skyshed_core::height_field::HeightField;

use crate::answers::{BestFacts, BestPlace};
use crate::questions::Uav;

/// Approximate number of places that are tried.
const N_PLACES: f64 = 400.0;

/// Search that continues place by place.
#[derive(Debug)]
pub(crate) struct Search {
    uav: Uav,
    places: Vec<(f64, f64)>,
    next: usize,
    tried: usize,
    best: Option<BestPlace>,
}

impl Search {
    /// Begins a search around a UAV, whose own place is tried first. `radius` is in units of the
    /// scene's reference system; `cell` is the least distance between places.
    pub(crate) fn around(uav: &Uav, radius: f64, cell: f64) -> Search {
        let spacing = (radius * (std::f64::consts::PI / N_PLACES).sqrt()).max(cell);
        #[expect(clippy::cast_possible_truncation, reason = "some ten steps")]
        let n = (radius / spacing) as i32;
        let steps = |n: i32| (-n..=n).map(f64::from).map(move |k| k * spacing);
        let around = steps(n).flat_map(|dy| steps(n).map(move |dx| (dx, dy)));
        let inside = around.filter(|(dx, dy)| (*dx, *dy) != (0.0, 0.0) && dx.hypot(*dy) <= radius);
        let places = std::iter::once((0.0, 0.0)).chain(inside).map(|(dx, dy)| (uav.x + dx, uav.y + dy)).collect();
        Search { uav: uav.clone(), places, next: 0, tried: 0, best: None }
    }

    /// Tries the next place.
    pub(crate) fn step(&mut self, field: &HeightField, mapper: &Mapper<'_>, radius: Option<f64>) -> BestFacts {
        if let Some((x, y)) = self.places.get(self.next).copied() {
            self.next += 1;
            let site = Uav { x, y, ..self.uav.clone() }.site();
            let is_over_grid = field.grid().cell_at(x, y).is_some();
            // A place over no data has no share to compare.
            let is_place = |uav: &coverage::Uav| is_over_grid && uav.placement != HoversOver::Nodata;
            if let Some(uav) = coverage::Uav::place(&site, field, radius).ok().filter(is_place) {
                self.tried += 1;
                // An earth that is too curved has no view.
                if let Ok((receivers, los)) = mapper.seen_from(&uav).map(|view| view.count())
                    && self.best.is_none_or(|best| los > best.los)
                {
                    self.best = Some(BestPlace { x, y, los, receivers });
                }
            }
        }
        let done = self.next == self.places.len();
        BestFacts { share: self.next as f64 / self.places.len() as f64, tried: self.tried, best: self.best, done }
    }
}
