//! Buildings of a file become footprints on the lattice: each has a shape that is mended, a height that is known or treated, and a top.

use std::collections::HashMap;

use rayon::prelude::*;

use super::building::{Buildings, RawFootprint};
use super::faults::{Said, warn_of_faults};
use super::file_heights::{FileHeights, Height};
use super::footprint_options::{FootprintOptions, GroundChoice};
use super::height_value::FoundHeight;
use super::missing_heights::WithoutHeight;
use super::outline::{Shaped, polygon_area, shape};
use super::parts::{Grouping, rest_of};
use super::repairs::FaultLog;
use crate::city::{Footprint, FootprintFault, Ground, HeightSource, LEFT_OUT};
use crate::error::{Error, HeightOf, HeightsMissing, ReadFault, Result, Warning};
use crate::input::Input;
use crate::overlay::Polygon;
use crate::quantity::{Frame, STEPS_PER_UNIT, height_steps, meters};

/// The largest share of the footprint area that may go without heights unless a policy was chosen.
const FEW: f64 = 0.02;

/// What prisms are made of buildings with.
#[derive(Clone, Copy)]
pub(super) struct Making<'a> {
    pub(super) input: &'a Input,
    pub(super) options: &'a FootprintOptions,
    pub(super) ground: &'a Ground,
    pub(super) frame: Frame,
    /// Length of a unit of the grid \[m\].
    pub(super) meters_per_unit: f64,
    /// Facts of all heights of the file.
    pub(super) heights: &'a FileHeights,
    /// Which of its footprints are parts of others.
    pub(super) grouping: &'a Grouping,
}

/// A height of a footprint above the datum \[1/1024 m\], and where it comes from.
#[derive(Debug, Clone, Copy)]
struct Top {
    top: i32,
    base: Option<i32>,
}

impl Making<'_> {
    /// Positions to the lattice, repair, parts in place of outlines, heights; of those that meet a box, if one is given \[CRS units\].
    pub(super) fn prisms(
        self,
        mut raw: Buildings,
        near: Option<[f64; 4]>,
        log: &mut FaultLog,
        warnings: &mut Vec<Warning>,
    ) -> Result<Vec<Footprint>> {
        if self.options.missing.rest() != WithoutHeight::Drop && self.heights.sources.from(HeightSource::Nowhere).n > 0
        {
            self.refuse_missing()?;
        }
        let is_near = |footprint: &RawFootprint| near.is_none_or(|near| footprint.meets(near));
        // What is counted is of the typed extent, whatever is read beyond it.
        let is_asked = |footprint: &RawFootprint| self.options.extent.is_none_or(|extent| footprint.meets(extent));
        let grouping = self.grouping;
        // What an outline is hangs on all of its parts.
        if grouping.is_empty() {
            raw.footprints.retain(is_near);
        }
        let of_ground = (self.ground, self.options.base);
        let mut shaped: Vec<Shaped> = raw.footprints.into_par_iter().map(|f| shape(f, of_ground, self.frame)).collect();
        if self.options.needs_bases() && self.options.ground == GroundChoice::Buildings {
            // Corners of cells may be lower or higher than the ground that the file tells of.
            shaped.iter_mut().for_each(|s| s.base = s.raw.base_m.and_then(height_steps).or(s.base));
        }
        if let Some((found, tangle)) = shaped.iter().find_map(|s| Some((s, s.tangle?))) {
            let fault = ReadFault::Tangle(found.raw.id.clone(), tangle.to_string());
            return Err(Error::read(self.input, fault));
        }
        if let Some((found, height)) = shaped.iter().find_map(|s| Some((s, s.bad_height?))) {
            let of = HeightOf::Feature(found.raw.id.clone());
            return Err(Error::read(self.input, ReadFault::HeightRange(of, height)));
        }
        // Parts come before outlines, whose rest hangs on their tops.
        let mut tops: Vec<Option<Top>> = vec![None; shaped.len()];
        for k in (0..shaped.len()).filter(|k| grouping.parts_of(*k).is_none()) {
            let is_asked = is_asked(&shaped[k].raw);
            if is_asked {
                note_shape(&shaped[k], log);
            }
            tops[k] = self.top(&shaped, k, is_asked.then_some(&mut *log))?;
        }
        // Areas of what has a height, and is left out.
        let mut left_out: HashMap<FootprintFault, f64> = HashMap::new();
        let mut area_with_height = 0.0;
        for of in shaped.iter().map(|s| &s.raw).filter(|of| is_asked(of)) {
            area_with_height += of.height.meters().map_or(0.0, |_| of.area());
            if of.height.meters().is_some_and(|m| m < 0.0) && !of.above_datum {
                *left_out.entry(FootprintFault::NegativeHeight).or_default() += of.area();
            }
        }
        let mut rests: Vec<Option<Vec<Polygon>>> = vec![None; shaped.len()];
        let mut rest_area = 0.0;
        for k in 0..shaped.len() {
            let Some(parts) = grouping.parts_of(k) else { continue };
            let is_asked = is_asked(&shaped[k].raw);
            if is_asked {
                note_shape(&shaped[k], log);
                log.note(FootprintFault::Part, shaped[k].raw.culprit());
            }
            // A height that was made up is none of its own.
            let own = match shaped[k].raw.height.meters() {
                Some(_) => self.top(&shaped, k, None)?,
                None => None,
            };
            let of_parts = || parts.iter().filter_map(|part| tops[*part]);
            let Some((lowest, highest)) = of_parts().map(|t| t.top).min().zip(of_parts().map(|t| t.top).max()) else {
                // No part stands: the outline does.
                tops[k] = self.top(&shaped, k, is_asked.then_some(&mut *log))?;
                continue;
            };
            let standing = parts.iter().filter(|part| tops[**part].is_some());
            let rest = rest_of(&shaped[k].polygons, standing.map(|part| shaped[*part].polygons.as_slice()));
            let below = own.filter(|own| own.top < highest);
            if below.is_none() && !rest.is_empty() && is_asked {
                rest_area += rest.iter().map(|p| polygon_area(p)).sum::<f64>();
            }
            tops[k] = Some(below.unwrap_or(Top { top: lowest, base: shaped[k].base })).filter(|_| !rest.is_empty());
            rests[k] = Some(rest);
        }
        let mut footprints = Vec::with_capacity(shaped.len());
        let bases: Vec<Option<i32>> = shaped.iter().map(|s| s.base).collect();
        for (k, shaped) in shaped.into_iter().enumerate() {
            let Some(Top { top, base }) = tops[k].filter(|_| is_near(&shaped.raw)) else { continue };
            if base.is_some_and(|base| top <= base) && shaped.raw.above_datum {
                if is_asked(&shaped.raw) {
                    log.note(FootprintFault::BelowGround, shaped.raw.culprit());
                    *left_out.entry(FootprintFault::BelowGround).or_default() += shaped.raw.area();
                }
                continue;
            }
            if let Some(error) = shaped.raw.height_error_m.filter(|m| !(0.0..=1000.0).contains(m)) {
                let id = shaped.raw.id.clone();
                return Err(Error::read(self.input, ReadFault::HeightError(id, error)));
            }
            let is_rest = rests[k].is_some();
            let top = if is_rest { top } else { shaped.roof.top().unwrap_or(top) };
            footprints.push(Footprint {
                id: shaped.raw.id,
                polygons: rests[k].take().unwrap_or(shaped.polygons),
                top,
                roof: if is_rest { Vec::new() } else { shaped.roof.triangles },
                base: grouping.outline_of(k).map_or(base, |outline| bases[outline]),
                height_error: shaped.raw.height_error_m.and_then(height_steps),
                part_of: grouping.group_of(k),
            });
        }
        let step_m = self.meters_per_unit / f64::from(STEPS_PER_UNIT);
        // Shares of all that have a height, of which a share is not there.
        let there = (1.0 - raw.not_there_share) / area_with_height;
        let left_out = left_out.into_iter().map(|(fault, area)| (fault, area * there));
        let left_out = left_out.chain([(FootprintFault::NotABuilding, raw.not_there_share)]).collect();
        let said = Said { heights: self.heights, rest_area_m2: 0.5 * rest_area * step_m * step_m, left_out: &left_out };
        warn_of_faults(&log.counts, self.input, self.options, &said, warnings);
        Ok(footprints)
    }

    /// Refuses a file of which too much has no height.
    fn refuse_missing(self) -> Result<()> {
        let left_out = self.heights.sources.from(HeightSource::Nowhere);
        let rest = self.options.missing.rest();
        if rest == WithoutHeight::Few && left_out.area_share <= FEW {
            return Ok(());
        }
        let property = self.options.height_property().to_string();
        if let (WithoutHeight::Fail, Some(first)) = (rest, &self.heights.without) {
            return Err(Error::read(self.input, ReadFault::HeightMissing(first.clone(), property)));
        }
        let fault = HeightsMissing {
            n_missing: left_out.n,
            n: self.heights.sources.n(),
            share: left_out.area_share,
            most: FEW,
            property,
            rules: self.options.missing.to_string(),
            is_top: self.options.top_field.is_some(),
            n_storeys: if self.options.missing.counts_storeys() { 0 } else { self.heights.n_storeys },
            median_m: self.heights.median_m(),
        };
        Err(Error::read(self.input, ReadFault::HeightsMissing(fault)))
    }

    /// The top of a footprint on the lattice; `None` if it is left out, which is noted.
    fn top(self, shaped: &[Shaped], k: usize, mut log: Option<&mut FaultLog>) -> Result<Option<Top>> {
        let of = &shaped[k];
        if !is_usable(of) {
            return Ok(None);
        }
        let mut note = |fault: FootprintFault, done: &'static str| {
            if let Some(log) = log.as_deref_mut() {
                log.note_done(fault, of.raw.culprit(), done);
            }
        };
        let outline = self.grouping.outline_of(k).map(|outline| &shaped[outline]);
        let (source, found) = self.heights.height(&of.raw, outline.map(|outline| &outline.raw), &self.options.missing);
        match source {
            HeightSource::File => {}
            HeightSource::Storeys => {
                note(FootprintFault::MissingHeight, "given the height of its storeys");
                note(FootprintFault::HeightFromLevels, FootprintFault::HeightFromLevels.done());
            }
            HeightSource::Median => note(FootprintFault::MissingHeight, "given the median height"),
            HeightSource::Number => note(FootprintFault::MissingHeight, "given a height"),
            HeightSource::Nowhere => note(FootprintFault::MissingHeight, LEFT_OUT),
        }
        if let FoundHeight::DecimalComma(_) = of.raw.height {
            note(FootprintFault::DecimalComma, FootprintFault::DecimalComma.done());
        }
        let Some(Height { m, above_datum }) = found else { return Ok(None) };
        if !above_datum && m < 0.0 {
            note(FootprintFault::NegativeHeight, LEFT_OUT);
            return Ok(None);
        }
        let base = outline.map_or(of.base, |outline| outline.base);
        if base.is_none() && !above_datum {
            note(FootprintFault::NoGround, LEFT_OUT);
            return Ok(None);
        }
        self.on_lattice(of, (m, above_datum), base).map(|top| Some(Top { top, base }))
    }

    /// The top on the lattice.
    fn on_lattice(self, shaped: &Shaped, (height, above_datum): (f64, bool), base: Option<i32>) -> Result<i32> {
        let above = if above_datum { Some(0) } else { base };
        height_steps(height)
            .and_then(|steps| above?.checked_add(steps))
            .filter(|top| height_steps(meters(*top)).is_some())
            .ok_or_else(|| {
                let of = HeightOf::Feature(shaped.raw.id.clone());
                Error::read(self.input, ReadFault::HeightRange(of, height))
            })
    }
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
