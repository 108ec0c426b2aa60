//! Checked question of line of sight: receivers, their height, range, antenna and engine, and their
//! text in captions.

use schemars::JsonSchema;
use serde::Serialize;
use skyshed_request::{Earth, Receivers, Sight};

use crate::city::{Antenna, BuiltUp, GivenSite};
use crate::coverage::{self, CheckedNumbers, HoversOver, MapOptions, Tally, Uav};
use crate::error::{OddRun, RequestError, Result, Warning};
use crate::height_field::{Curvature, HeightField};
use crate::los::{Method, MethodChoice};
use crate::picture::{crs_words, program};
use crate::quantity::tidy;
use crate::raster::GeoRef;
use crate::scene::Scene;
use crate::zones::ZoneMap;

/// Refuses receivers on roofs and in zones if the scene is only a surface model, where no building
/// is known.
///
/// # Errors
/// E117.
pub(crate) fn check_receivers(receivers: Receivers, is_surface_only: bool) -> Result<()> {
    if is_surface_only && (receivers == Receivers::Roof || receivers.zone().is_some()) {
        let what = if receivers == Receivers::Roof { "roof" } else { "zone" };
        return Err(RequestError::NoReceivers { receivers: receivers.name(), what }.into());
    }
    Ok(())
}

/// Returns the receivers' height on the lattice \[1/1024 m\].
///
/// # Errors
/// E113.
pub(crate) fn receivers_height(height_m: f64) -> Result<i32> {
    Ok(coverage::receiver_height(height_m)?)
}

/// Checked question of line of sight, with all defaults filled in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SightPlan {
    question: Sight,
    receivers: Receivers,
    rx_height_m: f64,
    /// Height of the receivers on the lattice \[1/1024 m\].
    rx_height: i32,
    radius_m: Option<f64>,
    antenna: Antenna,
    curvature: Option<Curvature>,
    method: MethodChoice,
}

/// Question of line of sight, in documents and tables.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(crate) struct SightFacts {
    /// Height of the receivers above the surface they stand on [m].
    pub(crate) rx_height_m: f64,
    /// Cells with receivers: ground, street, crossroad, courtyard, roof or all.
    pub(crate) receivers: &'static str,
    /// Largest horizontal distance from the UAV [m]; null without a limit.
    pub(crate) radius_m: Option<f64>,
    /// Limits of the antenna of UAVs without their own; null without limits.
    pub(crate) antenna: Option<AntennaFacts>,
    /// Effective earth radius factor k; null over a flat earth.
    pub(crate) earth_k: Option<f64>,
}

/// Limits of an antenna; null for a quantity without a limit.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(crate) struct AntennaFacts {
    /// Least horizontal distance [m], included.
    min_radius_m: Option<f64>,
    /// Azimuths from the first, clockwise, to before the second [deg from grid north].
    sector_deg: Option<[f64; 2]>,
    /// Least and largest elevation angle of receivers [deg above the UAV's horizontal], included.
    elevation_deg: Option<[f64; 2]>,
    /// Full angle of a cone straight down [deg].
    beam_deg: Option<f64>,
    /// Largest distance in space [m], included.
    slant_range_m: Option<f64>,
}

/// Returns the limits of an antenna in words, for tables; `None` without limits.
pub(crate) fn antenna_words(antenna: Antenna) -> Option<String> {
    Some(antenna.in_words()).filter(|words| !words.is_empty())
}

impl AntennaFacts {
    /// Returns the limits of an antenna; `None` without limits.
    pub(crate) fn of(antenna: Antenna) -> Option<AntennaFacts> {
        let Antenna { min_radius_m, sector_deg, elevation_deg, beam_deg, slant_range_m } = antenna;
        let facts = AntennaFacts { min_radius_m, sector_deg, elevation_deg, beam_deg, slant_range_m };
        (antenna != Antenna::default()).then_some(facts)
    }
}

impl SightPlan {
    /// Checks a question and fills in its defaults.
    ///
    /// # Errors
    /// E113 for numbers out of range; E116 for two options that set the curve of the earth.
    pub(crate) fn of(sight: &Sight) -> Result<SightPlan> {
        let numbers = sight.numbers()?;
        let (rx_height_m, radius_m) = (numbers.rx_height_m, numbers.radius_m);
        let CheckedNumbers { rx_height, antenna, curvature } = numbers.checked()?;
        let (receivers, method) = (sight.range.receiver_cells(), sight.range.engine());
        Ok(SightPlan { question: *sight, receivers, rx_height_m, rx_height, radius_m, antenna, curvature, method })
    }

    /// Returns the cells that hold receivers.
    pub(crate) fn receivers(&self) -> Receivers {
        self.receivers
    }

    /// Returns the plan for other receivers.
    #[must_use]
    pub(crate) fn with_receivers(self, receivers: Receivers) -> SightPlan {
        SightPlan { receivers, ..self }
    }

    /// Returns the plan for another antenna.
    #[must_use]
    pub(crate) fn with_antenna(self, antenna: Antenna) -> SightPlan {
        SightPlan { antenna, ..self }
    }

    /// Returns the height of the receivers above ground or roof \[m\].
    pub(crate) fn rx_height_m(&self) -> f64 {
        self.rx_height_m
    }

    /// Returns the height of the receivers on the lattice \[1/1024 m\].
    pub(crate) fn rx_height(&self) -> i32 {
        self.rx_height
    }

    /// Returns the range \[m\]; `None` without a limit.
    pub(crate) fn radius_m(&self) -> Option<f64> {
        self.radius_m
    }

    /// Returns the antenna of UAVs without their own.
    pub(crate) fn antenna(&self) -> Antenna {
        self.antenna
    }

    /// Returns the curve of the earth; `None` for a flat earth.
    pub(crate) fn curvature(&self) -> Option<Curvature> {
        self.curvature
    }

    /// Returns `true` if receivers may be out of range, antennas of single UAVs aside.
    pub(crate) fn is_limited(&self) -> bool {
        self.radius_m.is_some() || self.antenna != Antenna::default()
    }

    /// Returns the requested engine.
    pub(crate) fn method(&self) -> MethodChoice {
        self.method
    }

    /// Returns the range in units of a grid.
    pub(crate) fn radius_on(&self, grid: &GeoRef) -> Option<f64> {
        self.radius_m.map(|r| r / grid.meters_per_unit())
    }

    /// Returns the box around everything in range of some places: west, south, east, north \[CRS
    /// units\]. `None` without a limit of the run, and without a place.
    pub(crate) fn box_in_range(&self, sites: &[GivenSite], grid: &GeoRef) -> Option<[f64; 4]> {
        if !self.is_near() {
            return None;
        }
        let around = |site: &GivenSite| {
            let reach_m = self.reach_m(site.antenna)?;
            let reach = reach_m / grid.meters_per_unit();
            Some([site.x - reach, site.y - reach, site.x + reach, site.y + reach])
        };
        let boxes: Vec<[f64; 4]> = sites.iter().map(around).collect::<Option<_>>()?;
        boxes.into_iter().reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])])
    }

    /// Returns `true` if the run limits distances, whatever the antennas of single UAVs.
    pub(crate) fn is_near(&self) -> bool {
        self.reach_m(Antenna::default()).is_some()
    }

    /// Returns the distance beyond which nothing is in range of a UAV with an antenna \[m\]; `None` without a
    /// limit.
    pub(crate) fn reach_m(&self, own: Antenna) -> Option<f64> {
        let limits = [self.radius_m, own.or(self.antenna).slant_range_m];
        limits.into_iter().flatten().reduce(f64::min)
    }

    /// Returns the options of a map of a scene, without layers of heights. Its zones are found if they
    /// hold the receivers.
    ///
    /// # Errors
    /// E504, as [`ZoneMap::of`].
    pub(crate) fn options_over(
        &self,
        field: &HeightField,
        built_up: Option<&BuiltUp>,
    ) -> skyshed_core::Result<MapOptions> {
        let zones = self.receivers.zone().map(|_| ZoneMap::if_known(field, built_up)).transpose()?.flatten();
        Ok(self.options(field.grid(), zones.as_ref()))
    }

    /// Returns the options of a map on a grid, without layers of heights.
    pub(crate) fn options(&self, grid: &GeoRef, zones: Option<&ZoneMap>) -> MapOptions {
        MapOptions {
            rx_height: self.rx_height,
            receivers: self.receivers.cells(),
            within: self.receivers.zone().and_then(|zone| zones.map(|zones| zones.cells(zone))),
            window: None,
            radius: self.radius_on(grid),
            antenna: self.antenna,
            curvature: self.curvature,
            meters_per_unit: grid.meters_per_unit(),
            method: self.method,
            ..MapOptions::default()
        }
    }

    /// Returns the question as a live page asks it, whose engine is its own.
    pub(crate) fn of_page(&self) -> Sight {
        let mut question = self.question;
        question.receiver.rx_height = Some(self.rx_height_m.into());
        question.range.receivers = Some(self.receivers);
        question.range.method = None;
        question.antenna = self.antenna.into();
        question.earth = Earth { earth_k: self.curvature.map(|c| c.earth_k().into()), ..Earth::default() };
        question
    }

    /// Returns the facts for documents.
    pub(crate) fn facts(&self) -> SightFacts {
        SightFacts {
            rx_height_m: self.rx_height_m,
            receivers: self.receivers.name(),
            radius_m: self.radius_m,
            antenna: AntennaFacts::of(self.antenna),
            earth_k: self.curvature.map(Curvature::earth_k),
        }
    }

    /// Returns the range in words, after a comma, for captions; empty without a limit.
    pub(crate) fn range_in_words(&self) -> String {
        let radius = self.radius_m.map_or(String::new(), |r| format!(", range {} m", tidy(r)));
        let antenna = self.antenna.in_words();
        if antenna.is_empty() { radius } else { format!("{radius}, {antenna}") }
    }

    /// Returns the line of a caption about cells, receivers and engine of a map of a grid. `scene`
    /// may show less than the grid.
    pub(crate) fn in_words(&self, grid: &GeoRef, scene: &Scene, method: Option<Method>) -> String {
        let unit = grid.meters_per_unit();
        let (width, height) = (grid.cell_width() * unit, grid.cell_height() * unit);
        let cell = if (width - height).abs() < 1e-9 * width {
            format!("{} m", tidy(width))
        } else {
            format!("{} × {} m", tidy(width), tidy(height))
        };
        let stands = match self.receivers {
            _ if scene.field.is_surface_only() => "the surface",
            Receivers::Roof => "roofs",
            Receivers::All => "ground and roofs",
            _ => "ground",
        };
        let range = self.range_in_words();
        let method = method.map_or("none".into(), Method::in_words);
        let earth = self.curvature.map_or(String::new(), |curvature| format!("; {}", earth_words(curvature)));
        let who = if self.receivers == Receivers::Air { "places of a drone" } else { "receivers" };
        format!(
            "Cells of {cell}, {who} {} m above {stands}{range}; method {method}{earth}; {}; {}",
            tidy(self.rx_height_m),
            crs_words(grid),
            program()
        )
    }
}

/// Returns the curve of the earth in words, for captions.
pub(crate) fn earth_words(curvature: Curvature) -> String {
    let k = curvature.earth_k();
    // Captions show five digits.
    let k = format!("{k:.4e}").parse().unwrap_or(k);
    format!("curved earth, K = {k}")
}

/// Adds W205 for UAVs over no data. Returns `true` if there are any.
pub(crate) fn warn_of_nodata(uavs: &[Uav], warnings: &mut Vec<Warning>) -> bool {
    let over_nodata = uavs.iter().filter(|uav| uav.placement == HoversOver::Nodata);
    let ids: Vec<String> = over_nodata.map(|uav| uav.id.clone()).collect();
    let are_any = !ids.is_empty();
    push_over_nodata(ids, warnings);
    are_any
}

fn push_over_nodata(ids: Vec<String>, warnings: &mut Vec<Warning>) {
    if !ids.is_empty() {
        warnings.push(OddRun::OverNodata(ids).into());
    }
}

/// Adds W202 for each UAV or placement without a receiver, by its id, and W205 for the others
/// without P_LoS, which are over no data.
pub(crate) fn warn_of_no_p_los<'a>(
    what: &'static str,
    tallies: impl Iterator<Item = (&'a str, &'a Tally)>,
    warnings: &mut Vec<Warning>,
) {
    let mut over_nodata = Vec::new();
    for (id, tally) in tallies.filter(|(_, tally)| tally.p_los().is_none()) {
        if tally.receivers == 0 {
            warnings.push(OddRun::NoReceiver { what, id: id.into(), why: tally.reason() }.into());
        } else {
            over_nodata.push(id.to_string());
        }
    }
    push_over_nodata(over_nodata, warnings);
}
