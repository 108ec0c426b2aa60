//! What is sure of a map where heights of buildings are known to within an error.
//!
//! The lower all buildings are, the more receivers on the ground a UAV sees. So two exact maps bound all others: with every building as
//! low, and with every building as high as its error lets it be. Nothing is said of how likely errors are, nor whether buildings
//! share them. A receiver on a roof is as much higher or lower as its roof: on footprints each link says what is sure of it
//! ([`super::on_roofs`]). On a raster, where buildings are not known, such a receiver is taken as high where columns are low, and as low where they are
//! high. That holds whatever the heights are, but such receivers are seldom surely in line of sight then. On a surface model alone all cells are
//! roofs.

use std::borrow::Cow;

use rayon::prelude::*;

use super::super::curved::CurvedScene;
use super::on_roofs::RoofLink;
use crate::city::Antenna;
use crate::coverage::{HeightErrors, MapOptions, Mapper, OwnErrors, Receivers, Uav};
use crate::error::{MapError, Result};
use crate::height_field::{HeightField, StandsOn, Station};
use crate::los::{GridLos, GridReceivers, WrongMethod};
use crate::quantity::STEPS_PER_UNIT;
use crate::raster::{BitGrid, set_bits};

/// A scene with all buildings as low, and as high, as errors of their heights let them be. Of a surface model alone, where buildings are
/// not known, all columns are lower and higher, and receivers with them.
#[derive(Debug)]
pub struct HeightBounds {
    low: HeightField,
    high: HeightField,
    /// By how much, of any of them \[1/1024 m\].
    most: i32,
    /// By how much each building of a scene of footprints is \[1/1024 m\]; none of a raster.
    by_building: Vec<i32>,
}

/// The receivers of a UAV, by what is sure of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sure {
    /// Those in range, by the heights that are known.
    pub receivers: BitGrid,
    /// Those in line of sight whatever the heights within their bounds are.
    pub surely: BitGrid,
    /// Those in line of sight for some heights within them: `surely`, and others.
    pub possibly: BitGrid,
}

impl HeightBounds {
    /// The scene with heights of buildings that are off by at most so much \[m\], rounded up to 1/1024 m; `None` if that is
    /// no length, or a roof would leave ±32 768 m.
    pub fn of(field: &HeightField, error_m: f64) -> Option<Self> {
        HeightBounds::by_building(field, |_| error_m)
    }

    /// The scene with heights that are off by so many standard deviations of their errors; `None` as of [`HeightBounds::of`], or if there is
    /// no error for each building.
    pub fn within(field: &HeightField, errors: &HeightErrors, deviations: f64) -> Option<Self> {
        let is_raster_by_building = field.prisms().is_none() && matches!(errors.own, OwnErrors::ByBuilding(_));
        if is_raster_by_building || !errors.are_valid(field.n_buildings()) {
            return None;
        }
        HeightBounds::by_building(field, |building| deviations * errors.of_building_m(building))
    }

    fn by_building(field: &HeightField, error_m: impl Fn(u32) -> f64) -> Option<Self> {
        #[expect(clippy::cast_possible_truncation, reason = "saturates, and is refused then")]
        let steps = |building: u32| (error_m(building) * f64::from(STEPS_PER_UNIT)).ceil() as i32;
        let n_buildings = match field.prisms() {
            Some(_) => u32::try_from(field.n_buildings()).ok()?,
            None => 1,
        };
        let is_length = |building: u32| error_m(building) >= 0.0 && steps(building) <= 1 << 25;
        (0..n_buildings).all(is_length).then_some(())?;
        let most = (0..n_buildings).map(steps).max().unwrap_or(0);
        let (low, high) = (field.with_roofs_raised_by(|b| -steps(b))?, field.with_roofs_raised_by(steps)?);
        let by_building = (0..u32::try_from(field.n_buildings()).ok()?).map(steps);
        let by_building = if field.prisms().is_some() { by_building.collect() } else { Vec::new() };
        Some(HeightBounds { low, high, most, by_building })
    }

    /// By how much a building of a scene of footprints may be off \[1/1024 m\].
    pub(super) fn of_building(&self, building: u32) -> i32 {
        self.by_building[building as usize]
    }
}

impl Mapper<'_> {
    /// What is sure of the receivers of a UAV, whatever heights buildings have within some bounds of the same scene. Who is in range does
    /// not change. A UAV that is inside a building as high as it may be surely sees none.
    ///
    /// Cost: twice the line of sight of a map, by the same engine; a walk for each receiver on a roof of footprints.
    ///
    /// # Errors
    /// E118 for an earth so curved that heights would leave the lattice.
    pub fn sure(&self, uav: &Uav, bounds: &HeightBounds) -> Result<Sure> {
        let in_range = match CurvedScene::checked_around(self, uav)? {
            Some(curved) => curved.mapper(self).in_range_by_kind(uav),
            None => self.in_range_by_kind(uav),
        };
        self.sure_of(uav, bounds, &in_range)
    }

    /// What is sure of some receivers, kind by kind.
    pub(super) fn sure_of(&self, uav: &Uav, bounds: &HeightBounds, in_range: &[BitGrid]) -> Result<Sure> {
        let HeightBounds { low, high, most, by_building } = bounds;
        let none = || BitGrid::new(self.field.grid().n_rows(), self.field.grid().n_cols());
        let is_inside = uav.moved(high, [0; 3], self.options.radius).is_err();
        let moves_with_building = |kind: usize| self.field.prisms().is_some() && self.is_on_roofs(kind);
        let (on_buildings, others): (Vec<usize>, Vec<usize>) =
            (0..in_range.len()).partition(|kind| moves_with_building(*kind));
        let of_kinds = |kinds: &[usize]| {
            let of_kind = |kind| if kinds.contains(&kind) { in_range[kind].clone() } else { none() };
            (0..in_range.len()).map(of_kind).collect::<Vec<BitGrid>>()
        };
        let mut sure = Sure {
            possibly: none(),
            surely: none(),
            receivers: in_range.iter().fold(none(), |all, of_kind| all.or(of_kind)),
        };
        if !others.is_empty() {
            let in_range = of_kinds(&others);
            sure.possibly = self.with_buildings(low, *most)?.los_of(uav, &in_range);
            if !is_inside {
                sure.surely = self.with_buildings(high, -most)?.los_of(uav, &in_range);
            }
        }
        if !on_buildings.is_empty() {
            let curved = CurvedScene::around(self, uav);
            let curved = curved.as_ref().map(|curved| curved.mapper(self));
            let seen = curved.as_ref().unwrap_or(self);
            for kind in on_buildings {
                let (surely, possibly) = seen.sure_on_roofs(uav, kind, &in_range[kind], by_building);
                sure.surely = sure.surely.or(&surely);
                sure.possibly = sure.possibly.or(&possibly);
            }
        }
        Ok(sure)
    }

    /// The receivers on roofs of footprints that surely are in line of sight, and those that may be.
    fn sure_on_roofs(&self, uav: &Uav, kind: usize, in_range: &BitGrid, most: &[i32]) -> (BitGrid, BitGrid) {
        let none = || BitGrid::new(in_range.n_rows(), in_range.n_cols());
        let (mut surely, mut possibly) = (none(), none());
        let (n_cols, per_row) = (in_range.n_cols(), in_range.words_per_row().max(1));
        let rows = surely.words_mut().par_chunks_mut(per_row).zip(possibly.words_mut().par_chunks_mut(per_row));
        rows.enumerate().for_each(|(row, (surely, possibly))| {
            for col in set_bits(in_range.row(row)) {
                let place = self.engine.positions().center(row, col);
                let receiver = Station { place, z: self.receivers[kind].height(row * n_cols + col) };
                let Some(own) = self.field.building_at(&place) else { continue };
                let sure = RoofLink::new(self.field, &uav.station, &receiver, own, most).sure();
                surely[col / 64] |= u64::from(sure.is_surely_los) << (col % 64);
                possibly[col / 64] |= u64::from(sure.is_possibly_los) << (col % 64);
            }
        });
        (surely, possibly)
    }

    /// The receivers in range of a UAV over a flat earth, kind by kind.
    pub(super) fn in_range_by_kind(&self, uav: &Uav) -> Vec<BitGrid> {
        let range = self.range_of(uav);
        self.receivers.iter().map(|receivers| range.cut_receivers(receivers)).collect()
    }

    /// Whether receivers of a kind stand on what is redrawn, and move with it: on roofs, or on a surface model alone.
    pub(super) fn is_on_roofs(&self, kind: usize) -> bool {
        match self.options.receivers {
            _ if self.field.is_surface_only() => true,
            Receivers::Ground | Receivers::Air => false,
            Receivers::Roof => true,
            Receivers::All => kind == 1,
        }
    }

    /// What maps a scene with buildings of other heights, for these receivers, of which those on roofs are so much higher \[1/1024 m\].
    fn with_buildings<'b>(&'b self, field: &'b HeightField, roofs_by: i32) -> Result<Mapper<'b>> {
        let of_kind = |(k, receivers): (usize, &'b GridReceivers<'_>)| {
            if self.is_on_roofs(k) { receivers.raised(roofs_by) } else { receivers.borrowed() }
        };
        self.over(field, self.receivers.iter().enumerate().map(of_kind).collect())
    }

    /// What maps a scene with buildings of other heights, for these receivers, of which those on roofs stand on others \[1/1024 m above the datum\].
    pub(super) fn with_redrawn<'b>(&'b self, field: &'b HeightField, roofs: Option<&'b [i32]>) -> Result<Mapper<'b>> {
        let of_kind = |(k, receivers): (usize, &'b GridReceivers<'_>)| match roofs.filter(|_| self.is_on_roofs(k)) {
            Some(roofs) => {
                let cells = Cow::Borrowed(&*receivers.cells);
                GridReceivers::new(cells, StandsOn::Cells(Cow::Borrowed(roofs)), self.options.rx_height)
            }
            None => receivers.borrowed(),
        };
        self.over(field, self.receivers.iter().enumerate().map(of_kind).collect())
    }

    /// What maps another scene for some receivers, whatever their elevation.
    fn over<'b>(&self, field: &'b HeightField, receivers: Vec<GridReceivers<'b>>) -> Result<Mapper<'b>> {
        let refuse = |wrong: WrongMethod| MapError::Method { why: wrong.why, instead: wrong.instead.name() };
        let engine = GridLos::new(field, self.engine.method()).map_err(refuse)?;
        // Who is in range is known, and heights do not change it.
        let antenna = Antenna { elevation_deg: None, beam_deg: None, ..self.options.antenna };
        Ok(Mapper {
            field,
            alone: engine.clone(),
            engine,
            why: self.why,
            receivers,
            xs: Vec::new(),
            roofs: None,
            uncertain: None,
            options: MapOptions { antenna, ..self.options.clone() },
        })
    }

    /// Some receivers, kind by kind, that are in line of sight, whatever their elevation.
    pub(super) fn los_of(&self, uav: &Uav, wanted: &[BitGrid]) -> BitGrid {
        let antenna = Antenna { elevation_deg: None, beam_deg: None, ..uav.antenna };
        let uav = Uav { antenna, ..uav.clone() };
        if let Some(curved) = CurvedScene::around(self, &uav) {
            return curved.mapper(self).los_of(&uav, wanted);
        }
        let window = self.range_of(&uav).window();
        let los = self
            .receivers
            .iter()
            .zip(wanted)
            .map(|(receivers, wanted)| self.engine.los(&uav.station, receivers, wanted, window));
        los.reduce(|all, of_kind| all.or(&of_kind)).unwrap_or_else(|| BitGrid::new(0, 0))
    }
}
