//! Buildings of a file become footprints on the lattice: each has a shape that is mended, a height that is known or treated, and a top.

use rayon::prelude::*;

use super::building::{Buildings, FoundHeight, METERS_PER_LEVEL};
use super::faults::{HeightWords, warn_of_faults};
use super::footprint_options::{FootprintOptions, MissingHeight};
use super::outline::{Shaped, polygon_area, shape};
use super::repairs::FaultLog;
use crate::city::{Footprint, FootprintFault, Ground, HeightGap, LEFT_OUT};
use crate::error::{Error, HeightOf, HeightsMissing, ReadFault, Result, Warning};
use crate::input::Input;
use crate::quantity::{Frame, height_steps, meters};

/// The largest share of the footprint area that may go without heights unless a policy was chosen.
const FEW: f64 = 0.02;

/// What prisms are made of buildings with.
#[derive(Clone, Copy)]
pub(super) struct Making<'a> {
    pub(super) input: &'a Input,
    pub(super) options: &'a FootprintOptions,
    pub(super) ground: &'a Ground,
    pub(super) frame: Frame,
}

impl Making<'_> {
    /// Positions to the lattice, repair, heights; and what of the footprints has none.
    pub(super) fn prisms(
        self,
        raw: Buildings,
        log: &mut FaultLog,
        warnings: &mut Vec<Warning>,
    ) -> Result<(Vec<Footprint>, Option<HeightGap>)> {
        let of_ground = (self.ground, self.options.base);
        let shaped: Vec<Shaped> = raw.footprints.into_par_iter().map(|f| shape(f, of_ground, self.frame)).collect();
        if let Some((found, tangle)) = shaped.iter().find_map(|s| Some((s, s.tangle?))) {
            let fault = ReadFault::Tangle(found.raw.id.clone(), tangle.to_string());
            return Err(Error::read(self.input, fault));
        }
        if let Some((found, height)) = shaped.iter().find_map(|s| Some((s, s.bad_height?))) {
            let of = HeightOf::Feature(found.raw.id.clone());
            return Err(Error::read(self.input, ReadFault::HeightRange(of, height)));
        }
        let median = median_height(&shaped);
        let words = HeightWords::of(self.options);
        let missing_share = missing_area_share(&shaped);
        if self.options.missing == MissingHeight::Few && missing_share > FEW {
            return Err(self.too_many_missing(&shaped, (missing_share, median), &words));
        }
        let mut footprints = Vec::with_capacity(shaped.len());
        for shaped in shaped {
            note_shape(&shaped, log);
            if !is_usable(&shaped) {
                continue;
            }
            let Some((height, above_datum)) = self.height(&shaped, median, &words, log)? else { continue };
            if !above_datum && height < 0.0 {
                log.note(FootprintFault::NegativeHeight, shaped.raw.culprit());
                continue;
            }
            if shaped.base.is_none() && !above_datum {
                log.note(FootprintFault::NoGround, shaped.raw.culprit());
                continue;
            }
            if let Some(error) = shaped.raw.height_error_m.filter(|m| !(0.0..=1000.0).contains(m)) {
                let id = shaped.raw.id.clone();
                return Err(Error::read(self.input, ReadFault::HeightError(id, error)));
            }
            let top = self.top(&shaped, (height, above_datum))?;
            let top = shaped.roof.top().unwrap_or(top);
            let base = shaped.base;
            footprints.push(Footprint {
                id: shaped.raw.id,
                polygons: shaped.polygons,
                top,
                roof: shaped.roof.triangles,
                base,
                height_error: shaped.raw.height_error_m.and_then(height_steps),
            });
        }
        warn_of_faults(&log.counts, self.input, &words, missing_share, warnings);
        let gap = HeightGap { area_share: missing_share, done: words.treated };
        Ok((footprints, (missing_share > 0.0).then_some(gap)))
    }

    /// The refusal of a file that lacks heights, with what each policy would do.
    fn too_many_missing(self, shaped: &[Shaped], (share, median): (f64, Option<f64>), words: &HeightWords) -> Error {
        let missing: Vec<&Shaped> = shaped.iter().filter(|s| is_without_height(s)).collect();
        let fault = HeightsMissing {
            n_missing: missing.len(),
            n: shaped.iter().filter(|s| is_usable(s)).count(),
            share,
            most: FEW,
            property: words.property.clone(),
            n_storeys: missing.iter().filter(|s| s.raw.levels.is_some()).count(),
            levels_field: self.options.levels_field.clone(),
            median_m: median,
        };
        Error::read(self.input, ReadFault::HeightsMissing(fault))
    }

    /// The height of a building \[m\], and whether it is above the datum; `None` if it is left out.
    fn height(
        self,
        shaped: &Shaped,
        median: Option<f64>,
        words: &HeightWords,
        log: &mut FaultLog,
    ) -> Result<Option<(f64, bool)>> {
        let culprit = shaped.raw.culprit();
        match shaped.raw.height {
            FoundHeight::Meters(m) => return Ok(Some((m, shaped.raw.above_datum))),
            FoundHeight::DecimalComma(m) => {
                log.note(FootprintFault::DecimalComma, culprit);
                return Ok(Some((m, shaped.raw.above_datum)));
            }
            FoundHeight::Missing => {}
        }
        let found = match self.options.missing {
            MissingHeight::Fail => {
                let fault = ReadFault::HeightMissing(culprit.id.to_string(), words.property.clone());
                return Err(Error::read(self.input, fault));
            }
            MissingHeight::Few | MissingHeight::Drop => None,
            // Storeys are counted from the ground, whatever the property would have been measured from.
            MissingHeight::Levels => {
                let height = shaped.raw.levels.map(|levels| (levels * METERS_PER_LEVEL, false));
                height.map(|height| (height, "given the height of its storeys"))
            }
            MissingHeight::Median => median.map(|height| ((height, shaped.raw.above_datum), "given the median height")),
        };
        log.note_done(FootprintFault::MissingHeight, culprit, found.map_or(LEFT_OUT, |(_, done)| done));
        if self.options.missing == MissingHeight::Levels && found.is_some() {
            log.note(FootprintFault::HeightFromLevels, culprit);
        }
        Ok(found.map(|(height, _)| height))
    }

    /// The top on the lattice.
    fn top(self, shaped: &Shaped, (height, above_datum): (f64, bool)) -> Result<i32> {
        let above = if above_datum { Some(0) } else { shaped.base };
        height_steps(height)
            .and_then(|steps| above?.checked_add(steps))
            .filter(|top| height_steps(meters(*top)).is_some())
            .ok_or_else(|| {
                let of = HeightOf::Feature(shaped.raw.id.clone());
                Error::read(self.input, ReadFault::HeightRange(of, height))
            })
    }
}

/// Whether a building that can be used has no height.
fn is_without_height(shaped: &Shaped) -> bool {
    is_usable(shaped) && shaped.raw.height == FoundHeight::Missing
}

/// Whether anything is left of a building after repair, and near enough.
fn is_usable(shaped: &Shaped) -> bool {
    !shaped.too_far && !shaped.polygons.is_empty()
}

/// Notes what is odd about a building whatever its height is.
fn note_shape(shaped: &Shaped, log: &mut FaultLog) {
    let raw = &shaped.raw;
    shaped.repaired.iter().for_each(|k| log.note(FootprintFault::SelfIntersection, raw.culprit_at(*k)));
    shaped.stray_holes.iter().for_each(|k| log.note(FootprintFault::StrayHole, raw.culprit_at(*k)));
    (0..raw.unclosed).for_each(|_| log.note(FootprintFault::UnclosedRing, raw.culprit()));
    shaped.degenerate.iter().for_each(|k| log.note(FootprintFault::TooSmall, raw.culprit_at(*k)));
    if shaped.too_far {
        log.note(FootprintFault::TooFar, raw.culprit());
    } else if is_usable(shaped) && raw.floats {
        log.note(FootprintFault::Floating, raw.culprit());
    }
    if is_usable(shaped) && shaped.overhangs {
        log.note(FootprintFault::Overhang, raw.culprit());
    }
    if is_usable(shaped) && shaped.bares_ground {
        log.note(FootprintFault::BareGround, raw.culprit());
    }
    if is_usable(shaped) && raw.lacks_roof {
        log.note(FootprintFault::NoRoof, raw.culprit());
    }
    if shaped.roof.n_flattened > 0 {
        log.note(FootprintFault::RoughRoof, raw.culprit());
    }
    if shaped.roof.n_uneven > 0 {
        log.note(FootprintFault::UnevenRoof, raw.culprit());
    }
}

/// The median of the heights that are known \[m\].
fn median_height(shaped: &[Shaped]) -> Option<f64> {
    let known = |s: &Shaped| match s.raw.height {
        FoundHeight::Meters(m) | FoundHeight::DecimalComma(m) if m >= 0.0 || s.raw.above_datum => Some(m),
        _ => None,
    };
    median(shaped.iter().filter_map(known).collect())
}

/// The share of the area of all footprints that those without a height have.
fn missing_area_share(shaped: &[Shaped]) -> f64 {
    let area = |s: &Shaped| s.polygons.iter().map(|p| polygon_area(p)).sum::<f64>();
    let total: f64 = shaped.iter().map(area).sum();
    let missing: f64 = shaped.iter().filter(|s| is_without_height(s)).map(area).sum();
    if total > 0.0 { missing / total } else { 0.0 }
}

pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    let (_, m, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*m)
}
