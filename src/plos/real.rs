//! A real city of a P_LoS study: reading, UAV positions, and the fitted statistical city.

use std::ffi::OsStr;

use skyshed_request::{Placement, Users};

use super::plan::PlosPlan;
use super::report::{PlosRow, PlosValue};
use super::sweep::{Far, Sweeps};
use crate::city::{BuiltUp, Source};
use crate::city_statistics::fit::BuiltUpFit;
use crate::earth::warn_of_drop_across;
use crate::error::{Error, PlacesError, RequestError, Result, Warning};
use crate::height_field::{Built, HeightField, Place, Station};
use crate::los::{MethodChoice, WrongMethod};
use crate::los_probability::estimate::{Count, Estimate};
use crate::los_probability::points::Points;
use crate::los_probability::real_city::{Band, RealCity};
use crate::memory::{FIELD_BYTES_PER_CELL, check_memory};
use crate::placement::{MOST_CUT, WholeDiscs};
use crate::quantity::{VOID, height_steps};
use crate::raster::BitGrid;
use crate::scene::SceneReader;
use crate::scene::limits::limits_in_words;
use crate::sight::receivers_height;
use crate::zones::{Zone, ZoneMap};

/// Values that share their UAV positions and their users.
#[derive(Debug, Clone, Copy)]
pub(super) struct Group {
    pub(super) users: Users,
    placement: Placement,
    height: f64,
}

impl Group {
    /// Returns all groups of a sweep, in the order of its rows.
    pub(super) fn all(sweeps: &Sweeps) -> Vec<Group> {
        let of = |users: Users| {
            let heights = move |placement: &Placement| {
                sweeps.heights.iter().map({
                    let placement = *placement;
                    move |height| Group { users, placement, height: *height }
                })
            };
            sweeps.placements.iter().flat_map(heights)
        };
        sweeps.users.iter().flat_map(|users| of(*users)).collect()
    }
}

/// Engine, blocks and bands of the maps.
pub(super) struct View {
    /// Choice of the engine. It may give another engine for coarser cells.
    pub(super) choice: MethodChoice,
    pub(super) block_m: f64,
    pub(super) bands: Vec<Band>,
}

impl View {
    /// Returns the number of angles, distances or radii.
    pub(super) fn n_bands(&self) -> usize {
        self.bands.len()
    }

    /// Counts the users in range of a UAV and in line of sight, `[block][band]`.
    pub(super) fn count(&self, city: &RealCity<'_>, uav: &Station) -> Vec<Count> {
        city.count(uav, &self.bands)
    }
}

/// A real city, read and built.
pub(super) struct Real {
    pub(super) word: String,
    pub(super) field: HeightField,
    /// Zones of the city, if the sweep needs them.
    pub(super) zones: Option<ZoneMap>,
    pub(super) fit: Option<BuiltUpFit>,
    /// Limits of the accuracy of its pictures, in words.
    pub(super) limits: Option<String>,
    pub(super) sources: Vec<Source>,
    pub(super) attribution: Option<String>,
}

impl Real {
    /// Reads a city and fits α, β, γ to its buildings, if single buildings are known.
    pub(super) fn read(
        options: &SceneReader,
        word: &OsStr,
        sweeps: &Sweeps,
        warnings: &mut Vec<Warning>,
    ) -> Result<Real> {
        let scene = options.read(word, warnings)?;
        let grid = scene.grid.clone();
        let heights = scene.solids.building_heights();
        check_memory(&word.display(), &grid, 2.0 * FIELD_BYTES_PER_CELL)?;
        let Built { field, warnings: odd } = HeightField::build(&grid, scene.solids);
        warnings.extend(odd.into_iter().map(Warning::from));
        let zones = if sweeps.need_zones() { ZoneMap::if_known(&field, None)? } else { None };
        let (open, building) = (field.cells().open.count(), field.cells().building.count());
        let unit = grid.meters_per_unit();
        let area_km2 = (building + open) as f64 * grid.cell_width() * grid.cell_height() * unit * unit / 1e6;
        let fit = BuiltUpFit::of(building as f64 / (building + open) as f64, field.heights_in_data(&heights), area_km2);
        let mut own = Vec::new();
        warn_of_drop_across(&grid, sweeps.farthest_m(), false, &mut own);
        let limits = limits_in_words(scene.heights.as_ref(), &field, &own);
        warnings.extend(own);
        Ok(Real {
            word: word.display().to_string(),
            limits,
            field,
            zones,
            fit,
            sources: scene.sources,
            attribution: scene.attribution,
        })
    }

    /// Returns the fitted statistical city.
    pub(super) fn built_up(&self) -> Option<BuiltUp> {
        self.fit.as_ref().map(|fit| fit.built_up)
    }

    /// Returns the zones of a form of the city, if the sweep needs them.
    pub(super) fn zones_of(&self, field: &HeightField) -> Result<Option<ZoneMap>> {
        let zones = self.zones.as_ref().map(|_| ZoneMap::if_known(field, None)).transpose()?;
        Ok(zones.flatten())
    }

    /// Prepares a form of the city for counting some users.
    pub(super) fn city<'a>(
        &self,
        plan: &PlosPlan,
        (field, zones): (&'a HeightField, Option<&ZoneMap>),
        users: Users,
        sight: &View,
    ) -> Result<RealCity<'a>> {
        let rx_height = receivers_height(plan.rx_height_m)?;
        let city = RealCity::new(field, sight.choice, rx_height, field.grid().meters_per_unit(), sight.block_m)
            .map_err(|wrong| self.refuse(wrong))?;
        Ok(match self.cells_of(users, zones)? {
            Some(cells) => city.with_users(&cells),
            None => city,
        })
    }

    pub(super) fn refuse(&self, wrong: WrongMethod) -> Error {
        let (word, instead) = (self.word.to_string(), wrong.instead.name().into());
        RequestError::Engine { word, why: wrong.why, instead }.into()
    }

    /// Returns the cells of a zone's users; `None` for all open ground.
    fn cells_of(&self, users: Users, zones: Option<&ZoneMap>) -> Result<Option<BitGrid>> {
        let zone = match users {
            Users::Outdoor => return Ok(None),
            Users::Street => Zone::Street,
            Users::Crossroad => Zone::Crossroad,
        };
        let cells = zones.map(|zones| zones.cells(zone)).filter(|cells| cells.count() > 0);
        cells.map(Some).ok_or_else(|| PlacesError::NoUsers { zone: zone.name(), word: self.word.to_string() }.into())
    }

    pub(super) fn row(
        &self,
        plan: &PlosPlan,
        (Group { users, placement, height }, far): (Group, Far),
        estimate: Estimate,
    ) -> PlosRow {
        let rise = height - plan.rx_height_m;
        let (theta_deg, distance_m, radius_m) = match far {
            // Over uneven ground, an angle does not fix a distance.
            Far::Theta(theta) => (Some(theta), None, None),
            Far::Distance(distance) => (Some(rise.atan2(distance).to_degrees()), Some(distance), None),
            Far::Radius(radius) => (None, None, Some(radius)),
        };
        PlosRow {
            city: self.word.clone(),
            built_up: self.built_up(),
            method: "maps".into(),
            height_m: height,
            rx_height_m: plan.rx_height_m,
            theta_deg,
            theta_band_deg: matches!(far, Far::Theta(_)).then_some(plan.theta_band_deg),
            phi_deg: None,
            distance_m,
            radius_m,
            placement: Some(placement.name()),
            users: Some(users.name()),
            uav_in_building: Some(if plan.uav_clear_of_roof { "excluded" } else { "nlos" }),
            value: PlosValue::Estimate(estimate),
        }
    }

    /// Returns evenly spread positions over the data of the city, and the number of positions with
    /// cut discs.
    pub(super) fn positions(&self, plan: &PlosPlan, far: &[Far], group: &Group) -> Result<(Vec<Station>, usize)> {
        let Group { placement, height, .. } = *group;
        let grid = self.field.grid();
        let above = height_steps(height).ok_or_else(|| Error::number("the height", height, "within 32768 m"))?;
        let zone_below = |x: f64, y: f64, place: &Place| {
            self.zones.as_ref().and_then(|zones| zones.over(x, y, self.field.roof_at(place).is_some()))
        };
        let station = |[u, v, ..]: [f64; 4]| {
            let x = grid.x_min() + u * (grid.x_max() - grid.x_min());
            let y = grid.y_min() + v * (grid.y_max() - grid.y_min());
            let place = self.field.place(x, y);
            let ground = self.field.ground_at(&place);
            let is_wanted = match placement {
                Placement::Rooftop => self.field.roof_at(&place).is_some(),
                Placement::Street => zone_below(x, y, &place) == Some(Zone::Street),
                Placement::Crossroad => zone_below(x, y, &place) == Some(Zone::Crossroad),
                _ => true,
            } && self.field.is_known_at(x, y);
            (ground != VOID && is_wanted).then(|| Station { place, z: i64::from(ground) + i64::from(above) })
        };
        let unit = grid.meters_per_unit();
        let widest = far.iter().filter_map(|far| match far {
            Far::Radius(radius) => Some(*radius / unit),
            _ => None,
        });
        let radius = widest.fold(None, |a: Option<f64>, b| Some(a.map_or(b, |a| a.max(b))));
        let whole = radius.map(|radius| WholeDiscs::of(&self.field, Some(radius)));
        let n = usize::try_from(plan.n_positions).unwrap_or(usize::MAX);
        // A zone that so many points miss is too small.
        let most = n.saturating_mul(10_000);
        let mut n_cut = 0;
        let mut found: Vec<Station> = Vec::with_capacity(n.min(most));
        for station in Points::new(plan.seed, 0).take(most).filter_map(station) {
            if whole.as_ref().is_none_or(|discs| discs.contains(station.place.x, station.place.y)) {
                found.push(station);
            } else {
                n_cut += 1;
            }
            if found.len() == n || n_cut > MOST_CUT * n {
                break;
            }
        }
        if found.is_empty() && n_cut > 0 {
            return Err(PlacesError::NoDisc(self.word.to_string()).into());
        }
        if found.is_empty() {
            return Err(PlacesError::NoPlace(self.word.to_string()).into());
        }
        Ok((found, n_cut))
    }
}

/// Checks the half-width of a band of elevation angles \[deg\].
pub(super) fn checked_theta_band(plan: &PlosPlan) -> Result<f64> {
    let band = plan.theta_band_deg;
    if band > 0.0 && band <= 45.0 {
        return Ok(band);
    }
    Err(Error::number("the band of elevation angles", band, "above 0° and at most 45°"))
}

/// Returns a band for each angle, distance or radius, independent of the others. An angle takes θ ±
/// the half-width. A distance takes 5 %, at least 0.5 m, to both sides. A radius takes all users
/// within it.
pub(super) fn bands(far: &[Far], theta_band: f64) -> Vec<Band> {
    let band = |far: &Far| match *far {
        Far::Theta(v) => Band::elevation((v - theta_band).max(0.0), (v + theta_band).min(90.0)),
        Far::Distance(v) => {
            let half = (0.05 * v).max(0.5);
            Band::distance((v - half).max(0.0), v + half)
        }
        Far::Radius(v) => Band::distance(0.0, v.next_up()),
    };
    far.iter().map(band).collect()
}
