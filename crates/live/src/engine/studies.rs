//! Questions that take longer than a map: P_LoS against height, the best place near, sets of UAVs
//! side by side.

use skyshed_core::coverage::{self, Control, HoversOver, LeastHeights, Uav, check_radius};
use skyshed_core::quantity::meters;
use skyshed_core::raster::BitGrid;

use super::{Engine, mapper, p_los_of};
use crate::answers::{ComparedFacts, CurveFacts, False, True};
use crate::best_place::Search;
use crate::questions::Kept;

/// Curve that is being made.
#[derive(Debug)]
pub(super) struct Curve {
    uav: Uav,
    /// Least heights of the rows before the next one.
    found: Vec<i32>,
    next_row: usize,
}

/// Cells of a set of UAVs.
#[derive(Debug)]
struct SeenTogether {
    /// Receivers in range of any UAV.
    receivers: BitGrid,
    /// Receivers that any UAV sees.
    los: BitGrid,
    /// `true` if one of the UAVs is over no data.
    is_over_nodata: bool,
}

impl Engine {
    pub(super) fn begin_curve(&mut self, which: usize) -> Result<(), String> {
        if self.mapper.limits_heights() {
            return Err(
                "Who is within the elevations, the beam or the slant range changes with the height, so that there is no curve".into()
            );
        }
        let found = self.found(which)?;
        let uav = found.uav.clone();
        self.curve = Some(Curve { uav, found: Vec::new(), next_row: 0 });
        Ok(())
    }

    pub(super) fn curve_rows(&mut self, rows: usize) -> Result<CurveFacts, String> {
        let n_rows = self.shape().1;
        let curve = self.curve.as_mut().ok_or("no curve was begun")?;
        let view = self.mapper.seen_from(&curve.uav).map_err(|e| e.to_string())?;
        let mut least = LeastHeights::of(&view).after(std::mem::take(&mut curve.found));
        let end = n_rows.min(curve.next_row + rows.max(1));
        least.add(curve.next_row..end, &Control::default());
        curve.next_row = end;
        if end < n_rows {
            curve.found = least.into_found();
            return Ok(CurveFacts::Going { share: end as f64 / n_rows as f64 });
        }
        let curve = least.curve();
        self.curve = None;
        Ok(CurveFacts::Done {
            done: True,
            receivers: curve.receivers(),
            ground_m: curve.ground().map(meters),
            lowest_m: meters(curve.lowest_height()),
            heights_m: curve.steps().iter().map(|step| meters(step.0)).collect(),
            los: curve.steps().iter().map(|step| step.1).collect(),
        })
    }

    pub(super) fn begin_search(&mut self, which: usize, radius_m: f64) -> Result<(), String> {
        let grid = self.field.grid();
        let asked = &self.maps.get(which).ok_or("there is no such UAV")?.asked;
        check_radius(radius_m).map_err(|e| e.to_string())?;
        let cell = grid.cell_width().max(grid.cell_height());
        self.search = Some(Search::around(asked, radius_m / grid.meters_per_unit(), cell));
        Ok(())
    }

    /// Compares what each set of UAVs sees with one of the sets.
    pub(super) fn compare(&self, kept: &[Kept], base: usize) -> Vec<ComparedFacts> {
        let seen: Vec<Result<SeenTogether, String>> = kept.iter().map(|kept| self.seen_by(kept)).collect();
        let reference = seen.get(base).and_then(|seen| seen.as_ref().ok()).map(|seen| &seen.los);
        let facts = seen.iter().map(|seen| match seen {
            Ok(SeenTogether { receivers, los, is_over_nodata }) => {
                let (n_receivers, n_los) = (receivers.count(), los.count());
                let (p_los, reason) = p_los_of((n_receivers, n_los), *is_over_nodata);
                let both = reference.map_or(n_los, |base| los.count_in(base));
                ComparedFacts::Found {
                    ok: True,
                    receivers: n_receivers,
                    los: n_los,
                    p_los,
                    reason,
                    gained: n_los - both,
                    lost: reference.map_or(0, |base| base.count() - both),
                }
            }
            Err(words) => ComparedFacts::Refused { ok: False, words: words.clone() },
        });
        facts.collect()
    }

    fn seen_by(&self, kept: &Kept) -> Result<SeenTogether, String> {
        let own;
        let mapper = if kept.sight == self.sight {
            &self.mapper
        } else {
            own = mapper(self.field, &kept.sight, self.zones.as_ref())?;
            &own
        };
        let (n_cols, n_rows) = self.shape();
        let none = || BitGrid::new(n_rows, n_cols);
        let mut sum = SeenTogether { receivers: none(), los: none(), is_over_nodata: false };
        let radius = kept.sight.radius_on(self.field.grid());
        for asked in &kept.uavs {
            let uav = coverage::Uav::place(&asked.site(), self.field, radius).map_err(|e| e.to_string())?;
            let seen = mapper.seen_from(&uav).map_err(|e| e.to_string())?.seen();
            sum = SeenTogether {
                receivers: sum.receivers.or(&seen.receivers),
                los: sum.los.or(&seen.los),
                is_over_nodata: sum.is_over_nodata || uav.placement == HoversOver::Nodata,
            };
        }
        Ok(sum)
    }
}
