//! Candidates: the places and heights that can be flown, and the reasons against all other spots.

use crate::city::{Antenna, Area, Site};
use crate::coverage::{HoversOver, Uav, surface_under};
use crate::error::Result;
use crate::height_field::HeightField;
use crate::quantity::{Height, VOID, whole};
use crate::raster::GeoRef;
use crate::zones::{Zone, ZoneMap};
use skyshed_core::Error as Core;
use skyshed_core::error::UavError;

/// Grid of places: the centers of square cells over the extent of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaceGrid {
    /// Cells whose centers are the places.
    pub grid: GeoRef,
}

impl PlaceGrid {
    /// Makes as many cells of `step` \[CRS units\] as fit into the extent of a scene, at least one
    /// along each axis. The remainder is split between both sides. `None` unless the step is finite
    /// and above 0, or if there are too many to count.
    pub fn over(scene: &GeoRef, step: f64) -> Option<Self> {
        let (width, height) = (scene.x_max() - scene.x_min(), scene.y_max() - scene.y_min());
        let count = |length: f64| whole(length / step).floor().max(1.0);
        let (n_cols, n_rows) = (count(width), count(height));
        if step.is_nan() || step <= 0.0 || n_cols * n_rows > f64::from(u32::MAX) {
            return None;
        }
        let corner = (scene.x_min() + (width - n_cols * step) / 2.0, scene.y_max() - (height - n_rows * step) / 2.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 1 and below 2^32")]
        let shape = (n_rows as usize, n_cols as usize);
        let grid = GeoRef::new(corner, (step, step), shape, scene.crs().cloned())?;
        Some(PlaceGrid { grid })
    }

    /// Returns the places at heights in the given order, then row by row from the north-west.
    pub fn spots(&self, heights: &[Height]) -> Vec<Spot> {
        let n_cols = self.grid.n_cols();
        let spot = |level: usize, place: usize| {
            let (x, y) = self.grid.world_from_cell(place / n_cols, place % n_cols);
            Spot { place, level, x, y, height: heights[level], antenna: Antenna::default() }
        };
        (0..heights.len()).flat_map(|level| (0..self.grid.n_cells()).map(move |place| spot(level, place))).collect()
    }
}

/// Place with a height, to be checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Number of the place; spots over one place share it.
    pub place: usize,
    /// Index of the height in its list.
    pub level: usize,
    /// East \[CRS units\].
    pub x: f64,
    /// North \[CRS units\].
    pub y: f64,
    /// Height and its reference.
    pub height: Height,
    /// Antenna of a UAV there. The antenna of the run may set limits that this one does not.
    pub antenna: Antenna,
}

/// Rules that a UAV's place must obey.
#[derive(Debug, Clone, Default)]
pub struct CandidateRules<'a> {
    /// Zones that it must be over, with their map; no zones allow all.
    pub over: Option<(&'a [Zone], &'a ZoneMap)>,
    /// Area that it must be in.
    pub within: Option<&'a Area>,
    /// Area that it must not be in.
    pub keep_out: Option<&'a Area>,
    /// Least height above the roof, the surface or the ground directly below \[1/1024 m\].
    pub clearance: i32,
    /// Range \[CRS units\]; `None` without a limit.
    pub radius: Option<f64>,
}

/// Numbers of spots that are no candidates, by the first reason that applies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Skipped {
    /// Spots outside the data area of the scene.
    pub no_data: u64,
    /// Spots outside the required area.
    pub outside: u64,
    /// Spots over other zones than the required ones.
    pub other_zone: u64,
    /// Spots inside a forbidden area.
    pub keep_out: u64,
    /// Spots without the ground or roof to which the height refers.
    pub no_base: u64,
    /// Spots inside a building or below the ground.
    pub inside: u64,
    /// Spots closer than the clearance to the surface directly below.
    pub clearance: u64,
}

impl Skipped {
    /// Returns the sum over all reasons.
    pub fn total(&self) -> u64 {
        self.reasons().iter().map(|(_, n)| n).sum()
    }

    /// Returns every reason in words with its count.
    pub fn reasons(&self) -> [(&'static str, u64); 7] {
        [
            ("where there are no data", self.no_data),
            ("outside the area", self.outside),
            ("over other zones", self.other_zone),
            ("kept out", self.keep_out),
            ("without the ground or roof that the height is above", self.no_base),
            ("inside a building or below ground", self.inside),
            ("too close to what is below", self.clearance),
        ]
    }
}

/// Spot where a UAV can hover.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Spot that was checked.
    pub spot: Spot,
    /// UAV at the spot.
    pub uav: Uav,
    /// Zone below it, if zones are known.
    pub zone: Option<Zone>,
}

/// Spots where UAVs can hover, in their order.
#[derive(Debug, Clone)]
pub struct Candidates {
    /// Candidates.
    pub kept: Vec<Candidate>,
    /// Numbers of spots left out, by reason.
    pub skipped: Skipped,
}

/// Count to raise for a spot that is no candidate.
type Reason = fn(&mut Skipped) -> &mut u64;

impl Candidates {
    /// Selects the spots where UAVs can hover.
    ///
    /// # Errors
    /// Site errors that are no reason of [`Skipped`]: outside the lattice (E203), a height
    /// beyond ±32 768 m (E205).
    pub fn of(spots: &[Spot], field: &HeightField, rules: &CandidateRules<'_>) -> Result<Self> {
        let mut found = Candidates { kept: Vec::new(), skipped: Skipped::default() };
        for spot in spots {
            match candidate(spot, field, rules)? {
                Ok(candidate) => found.kept.push(candidate),
                Err(reason) => *reason(&mut found.skipped) += 1,
            }
        }
        Ok(found)
    }
}

/// Returns the candidate at a spot, or the reason why there is none.
pub(super) fn candidate(
    spot: &Spot,
    field: &HeightField,
    rules: &CandidateRules<'_>,
) -> Result<std::result::Result<Candidate, Reason>> {
    if !field.is_known_at(spot.x, spot.y) {
        return Ok(Err(|s| &mut s.no_data));
    }
    if rules.within.is_some_and(|area| !area.contains(spot.x, spot.y)) {
        return Ok(Err(|s| &mut s.outside));
    }
    if rules.keep_out.is_some_and(|area| area.contains(spot.x, spot.y)) {
        return Ok(Err(|s| &mut s.keep_out));
    }
    let site = Site { antenna: spot.antenna, ..Site::new("", (spot.x, spot.y), spot.height) };
    let uav = match Uav::place(&site, field, rules.radius) {
        Ok(uav) => uav,
        Err(Core::Uav { why: UavError::InsideBuilding { .. } | UavError::BelowGround { .. }, .. }) => {
            return Ok(Err(|s| &mut s.inside));
        }
        Err(Core::Uav {
            why: UavError::NoGround | UavError::NoRoofKnown | UavError::NoBuilding | UavError::OverNodata,
            ..
        }) => return Ok(Err(|s| &mut s.no_base)),
        Err(error) => return Err(error.into()),
    };
    let is_building = uav.placement == HoversOver::Rooftop;
    let mut zone = None;
    if let Some((over, zones)) = rules.over {
        zone = zones.over(spot.x, spot.y, is_building);
        if !over.is_empty() && !zone.is_some_and(|zone| over.contains(&zone)) {
            return Ok(Err(|s| &mut s.other_zone));
        }
    }
    let surface = surface_under(field, &uav.station.place);
    if surface != VOID && uav.station.z - i64::from(surface) < i64::from(rules.clearance) {
        return Ok(Err(|s| &mut s.clearance));
    }
    Ok(Ok(Candidate { spot: *spot, uav, zone }))
}
