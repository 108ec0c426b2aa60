//! Which places and heights can be flown, and why the others cannot.

use crate::city::{Antenna, Area, Site};
use crate::coverage::{HoversOver, Uav, surface_under};
use crate::error::Result;
use crate::height_field::HeightField;
use crate::quantity::{Height, VOID, whole};
use crate::raster::GeoRef;
use crate::zones::{Zone, ZoneMap};
use skyshed_core::Error as Core;
use skyshed_core::error::UavError;

/// A grid of places: the centers of square cells over the extent of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaceGrid {
    /// The cells whose centers are the places.
    pub grid: GeoRef,
}

impl PlaceGrid {
    /// As many cells of `step` \[CRS units\] as fit into the extent of a scene, at least one along each axis, with what is
    /// left shared by both sides. `None` unless the step is finite and above 0, or if there are too many to count.
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

    /// The places at each of some heights: lowest height first as they are given, then row by row from the north-west.
    pub fn spots(&self, heights: &[Height]) -> Vec<Spot> {
        let n_cols = self.grid.n_cols();
        let spot = |level: usize, place: usize| {
            let (x, y) = self.grid.world_from_cell(place / n_cols, place % n_cols);
            Spot { place, level, x, y, height: heights[level], antenna: Antenna::default() }
        };
        (0..heights.len()).flat_map(|level| (0..self.grid.n_cells()).map(move |place| spot(level, place))).collect()
    }
}

/// A place with a height that is asked about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Number of the place; spots over one place share it.
    pub place: usize,
    /// Number of the height among those of the list.
    pub level: usize,
    /// East \[CRS units\].
    pub x: f64,
    /// North \[CRS units\].
    pub y: f64,
    /// Height and what it is above.
    pub height: Height,
    /// Antenna of a UAV there; what it does not limit, that of the run may.
    pub antenna: Antenna,
}

/// Where a UAV may hover.
#[derive(Debug, Clone, Default)]
pub struct CandidateRules<'a> {
    /// Only over these zones of the map, if there are any.
    pub over: Option<(&'a [Zone], &'a ZoneMap)>,
    /// Only inside of this area.
    pub within: Option<&'a Area>,
    /// Not inside of these areas.
    pub keep_out: Option<&'a Area>,
    /// At least so high above the roof, the surface or the ground directly below \[1/1024 m\].
    pub clearance: i32,
    /// Range \[CRS units\], if it is limited.
    pub radius: Option<f64>,
}

/// Spots that are no candidates, by the first reason that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Skipped {
    /// Outside the data area of the scene.
    pub no_data: u64,
    /// Outside the area that they must be in.
    pub outside: u64,
    /// Over other zones than those asked for.
    pub other_zone: u64,
    /// Inside an area that is to be kept out of.
    pub keep_out: u64,
    /// Without the ground or roof that the height is above.
    pub no_base: u64,
    /// Inside a building or below the ground.
    pub inside: u64,
    /// Closer to what is directly below than the clearance.
    pub clearance: u64,
}

impl Skipped {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.reasons().iter().map(|(_, n)| n).sum()
    }

    /// Every reason in words with its count.
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

/// A spot where a UAV can hover.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Where it was asked for.
    pub spot: Spot,
    /// The UAV there.
    pub uav: Uav,
    /// The zone below it, if zones are known.
    pub zone: Option<Zone>,
}

/// The spots where UAVs can hover, in their order.
#[derive(Debug, Clone)]
pub struct Candidates {
    /// The candidates.
    pub kept: Vec<Candidate>,
    /// How many spots were left out, and why.
    pub skipped: Skipped,
}

/// Why a spot is no candidate, as a count to raise.
type Reason = fn(&mut Skipped) -> &mut u64;

impl Candidates {
    /// Sorts out the spots where UAVs can hover.
    ///
    /// # Errors
    /// Site errors that no other spot would mend: outside the lattice (E203), a height beyond ±32 768 m (E205).
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

/// The candidate at a spot, or why there is none.
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
