//! Conversion of buildings of a file to footprints on the lattice: each gets a repaired shape, a
//! known or substitute height, and a top.

use std::collections::HashMap;

use rayon::prelude::*;

use super::building::{Buildings, RawFootprint};
use super::faults::{Said, warn_of_faults};
use super::file_heights::{FileHeights, Height};
use skyshed_request::{GroundChoice, WithoutHeight};

use super::footprint_options::FootprintOptions;
use super::height_value::FoundHeight;
use super::lattice_polygon::polygon_area;
use super::outline::{Shaped, shape};
use super::parts::{Grouping, rest_of};
use super::repairs::FaultLog;
use crate::city::{Footprint, FootprintFault, Ground, HeightSource};
use crate::error::{Error, HeightOf, HeightsMissing, ReadFault, Result, Warning};
use crate::input::Input;
use crate::overlay::Polygon;
use crate::quantity::{Frame, STEPS_PER_UNIT, height_steps, meters};

/// Largest share of the footprint area that may lack heights unless a policy was chosen.
const FEW: f64 = 0.02;

/// Inputs for making prisms of buildings.
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
    /// Outlines of the file, and their parts.
    pub(super) grouping: &'a Grouping,
}

/// Top and base of a footprint or of its rest \[1/1024 m above the datum\].
#[derive(Debug, Clone)]
struct Standing {
    top: i32,
    base: Option<i32>,
    /// Rest of an outline beside its parts; `None` for a whole footprint.
    rest: Option<Rest>,
}

/// Rest of an outline beside its parts.
#[derive(Debug, Clone)]
struct Rest {
    polygons: Vec<Polygon>,
    /// `true` if it is as high as the lowest part, for want of a height of its own.
    is_as_lowest: bool,
}

impl Making<'_> {
    /// Returns the prisms of the footprints that meet the box `near` \[CRS units\], of all without
    /// one.
    ///
    /// # Errors
    /// E309 for missing heights, E205 and E504 for shapes and heights beyond the lattice, E365 for
    /// a bad error of a height.
    pub(super) fn prisms(
        self,
        mut raw: Buildings,
        near: Option<[f64; 4]>,
        log: &mut FaultLog,
        warnings: &mut Vec<Warning>,
    ) -> Result<Vec<Footprint>> {
        self.refuse_missing()?;
        let is_near = |footprint: &RawFootprint| near.is_none_or(|near| footprint.meets(near));
        // The shape of an outline depends on all of its parts.
        if self.grouping.is_empty() {
            raw.footprints.retain(is_near);
        }
        let shaped = self.shapes(raw.footprints)?;
        let mut standing: Vec<Option<Standing>> = vec![None; shaped.len()];
        let is_outline = |k: &usize| self.grouping.parts_of(*k).is_some();
        for k in (0..shaped.len()).filter(|k| !is_outline(k)) {
            note_shape(&shaped[k], log);
            standing[k] = self.whole(&shaped, k, log)?;
        }
        // The rest of an outline depends on the tops of its parts.
        for k in (0..shaped.len()).filter(is_outline) {
            note_shape(&shaped[k], log);
            log.note(FootprintFault::Part, shaped[k].raw.culprit());
            standing[k] = self.beside_parts(&shaped, k, &standing, log)?;
        }
        let (rest_area_m2, left_out) = self.areas(&shaped, &standing, raw.not_there_share);
        let mut footprints = Vec::with_capacity(shaped.len());
        for (k, (shaped, standing)) in shaped.into_iter().zip(standing).enumerate() {
            let Some(standing) = standing.filter(|_| is_near(&shaped.raw)) else { continue };
            if standing.is_below_ground(&shaped.raw) {
                log.note(FootprintFault::BelowGround, shaped.raw.culprit());
                continue;
            }
            footprints.push(self.footprint(k, shaped, standing)?);
        }
        let said = Said { heights: self.heights, rest_area_m2, left_out: &left_out };
        warn_of_faults(&log.counts, self.input, self.options, &said, warnings);
        Ok(footprints)
    }

    /// Brings footprints onto the lattice, and repairs them.
    fn shapes(self, raw: Vec<RawFootprint>) -> Result<Vec<Shaped>> {
        let of_ground = (self.ground, self.options.base);
        let mut shaped: Vec<Shaped> = raw.into_par_iter().map(|f| shape(f, of_ground, self.frame)).collect();
        if self.options.needs_bases() && self.options.ground == Some(GroundChoice::Buildings) {
            // Corners of cells may be lower or higher than the ground that the file holds.
            shaped.iter_mut().for_each(|s| s.base = s.raw.base_m.and_then(height_steps).or(s.base));
        }
        if let Some((found, tangle)) = shaped.iter().find_map(|s| Some((s, s.tangle?))) {
            return Err(Error::tangled(self.input, &found.raw.id, tangle));
        }
        if let Some((found, height)) = shaped.iter().find_map(|s| Some((s, s.bad_height?))) {
            let of = HeightOf::Feature(found.raw.id.clone());
            return Err(Error::read(self.input, ReadFault::HeightRange(of, height)));
        }
        Ok(shaped)
    }

    /// Returns top and base of a whole footprint; `None` if it is left out. Logs oddities of its
    /// height.
    fn whole(self, shaped: &[Shaped], k: usize, log: &mut FaultLog) -> Result<Option<Standing>> {
        let of = &shaped[k];
        if !is_usable(of) {
            return Ok(None);
        }
        let culprit = of.raw.culprit();
        let (source, height) = self.height(shaped, k);
        if source != HeightSource::File {
            log.note_done(FootprintFault::MissingHeight, culprit, source.done());
        }
        if source == HeightSource::Storeys {
            log.note(FootprintFault::HeightFromLevels, culprit);
        }
        if let FoundHeight::DecimalComma(_) = of.raw.height {
            log.note(FootprintFault::DecimalComma, culprit);
        }
        let Some(height) = height else { return Ok(None) };
        let standing = self.on_lattice(shaped, k, height)?;
        if standing.is_none() {
            let is_negative = height.m < 0.0 && !height.above_datum;
            log.note(if is_negative { FootprintFault::NegativeHeight } else { FootprintFault::NoGround }, culprit);
        }
        Ok(standing)
    }

    /// Returns the rest of an outline beside its parts. The rest has the outline's own height where
    /// that was read and is below the highest part, else that of the lowest part. Without any part
    /// it is the whole outline; `None` if parts cover nine tenths of it.
    fn beside_parts(
        self,
        shaped: &[Shaped],
        k: usize,
        standing: &[Option<Standing>],
        log: &mut FaultLog,
    ) -> Result<Option<Standing>> {
        let parts = self.grouping.parts_of(k).unwrap_or_default();
        let tops = || parts.iter().filter_map(|part| standing[*part].as_ref()).map(|part| part.top);
        let Some((lowest, highest)) = tops().min().zip(tops().max()) else { return self.whole(shaped, k, log) };
        let is_standing = |part: &&usize| standing[**part].is_some();
        let covered = parts.iter().filter(is_standing).map(|part| shaped[*part].polygons.as_slice());
        let rest = rest_of(&shaped[k].polygons, covered)
            .map_err(|tangle| Error::tangled(self.input, &shaped[k].raw.id, tangle))?;
        if rest.is_empty() {
            return Ok(None);
        }
        // A substitute height is not the outline's own.
        let own = match self.height(shaped, k) {
            (HeightSource::File, Some(height)) if is_usable(&shaped[k]) => self.on_lattice(shaped, k, height)?,
            _ => None,
        };
        let own = own.map(|own| own.top).filter(|top| *top < highest);
        let rest = Rest { polygons: rest, is_as_lowest: own.is_none() };
        Ok(Some(Standing { top: own.unwrap_or(lowest), base: shaped[k].base, rest: Some(rest) }))
    }

    /// Returns the area of the rests of outlines that are as high as the lowest part \[m²\].
    /// Returns also, by fault, the share of left-out footprints in the area of all that have a
    /// height. Both count footprints in the typed extent.
    fn areas(
        self,
        shaped: &[Shaped],
        standing: &[Option<Standing>],
        not_there_share: f64,
    ) -> (f64, HashMap<FootprintFault, f64>) {
        let (mut rests, mut with_height) = (0.0, 0.0);
        let mut left_out: HashMap<FootprintFault, f64> = HashMap::new();
        for (of, standing) in shaped.iter().zip(standing).filter(|(of, _)| of.raw.is_asked) {
            let (area, height) = (of.raw.area(), of.raw.height.meters());
            with_height += height.map_or(0.0, |_| area);
            let fault = match standing {
                Some(standing) if standing.is_below_ground(&of.raw) => Some(FootprintFault::BelowGround),
                None if height.is_some_and(|m| m < 0.0) && !of.raw.above_datum => Some(FootprintFault::NegativeHeight),
                _ => None,
            };
            fault.into_iter().for_each(|fault| *left_out.entry(fault).or_default() += area);
            let rest = standing.as_ref().and_then(|standing| standing.rest.as_ref()).filter(|rest| rest.is_as_lowest);
            rests += rest.map_or(0.0, |rest| rest.polygons.iter().map(|polygon| polygon_area(polygon)).sum());
        }
        let step_m = self.meters_per_unit / f64::from(STEPS_PER_UNIT);
        // `not_there_share` is a share of the whole; other faults divide the remainder.
        let shares = left_out.into_iter().map(|(fault, area)| (fault, area / with_height * (1.0 - not_there_share)));
        let shares = shares.chain([(FootprintFault::NotABuilding, not_there_share)]).collect();
        (0.5 * rests * step_m * step_m, shares)
    }

    /// Returns the footprint of `standing`.
    fn footprint(self, k: usize, shaped: Shaped, standing: Standing) -> Result<Footprint> {
        if let Some(error) = shaped.raw.height_error_m.filter(|m| !(0.0..=1000.0).contains(m)) {
            return Err(Error::read(self.input, ReadFault::HeightError(shaped.raw.id, error)));
        }
        let Standing { top, base, rest } = standing;
        let (top, roof) = match &rest {
            Some(_) => (top, Vec::new()),
            None => (shaped.roof.top().unwrap_or(top), shaped.roof.triangles),
        };
        Ok(Footprint {
            id: shaped.raw.id,
            polygons: rest.map_or(shaped.polygons, |rest| rest.polygons),
            top,
            roof,
            base,
            height_error: shaped.raw.height_error_m.and_then(height_steps),
            part_of: self.grouping.group_of(k),
        })
    }

    /// Refuses a file if too much of its footprint area has no height.
    fn refuse_missing(self) -> Result<()> {
        let left_out = self.heights.sources.from(HeightSource::Nowhere);
        let rest = self.options.missing.rest();
        let is_few = rest == WithoutHeight::Few && left_out.area_share <= FEW;
        if left_out.n == 0 || rest == WithoutHeight::Drop || is_few {
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

    /// Returns the height of a footprint, and its source.
    fn height(self, shaped: &[Shaped], k: usize) -> (HeightSource, Option<Height>) {
        let outline = self.grouping.outline_of(k).map(|outline| &shaped[outline].raw);
        self.heights.height(&shaped[k].raw, outline, &self.options.missing)
    }

    /// Puts a footprint at a height, on the ground of its outline if it has one. `None` for a
    /// height below 0, or where that ground is not known.
    fn on_lattice(self, shaped: &[Shaped], k: usize, Height { m, above_datum }: Height) -> Result<Option<Standing>> {
        let base = self.grouping.outline_of(k).map_or(shaped[k].base, |outline| shaped[outline].base);
        let above = match (above_datum, base) {
            (true, _) => 0,
            (false, Some(base)) if m >= 0.0 => base,
            (false, _) => return Ok(None),
        };
        let top = height_steps(m).and_then(|steps| above.checked_add(steps));
        let top = top.filter(|top| height_steps(meters(*top)).is_some()).ok_or_else(|| {
            let of = HeightOf::Feature(shaped[k].raw.id.clone());
            Error::read(self.input, ReadFault::HeightRange(of, m))
        })?;
        Ok(Some(Standing { top, base, rest: None }))
    }
}

impl Standing {
    /// Returns `true` when a top that is read above the datum is not above the ground.
    fn is_below_ground(&self, of: &RawFootprint) -> bool {
        of.above_datum && self.base.is_some_and(|base| self.top <= base)
    }
}

/// Returns `true` when a building is near enough, and has an area after repair.
fn is_usable(shaped: &Shaped) -> bool {
    !shaped.too_far && !shaped.polygons.is_empty()
}

/// Logs oddities of a building that do not depend on its height.
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
