//! Receivers, their height, the radius and the engine as the library takes them, checked; what captions say of them.

use schemars::JsonSchema;
use serde::Serialize;

use crate::city::{Antenna, GivenSite};
use crate::coverage::{self, CheckedNumbers, HoversOver, MapOptions, SightNumbers, Tally, Uav};
use crate::error::{OddRun, RequestError, Result, Warning};
use crate::height_field::{Curvature, HeightField};
use crate::los::{Method, MethodChoice};
use crate::picture::{crs_words, program};
use crate::quantity::{VOID, meters, tidy};
use crate::raster::GeoRef;
use crate::scene::Scene;
use crate::zones::{Zone, ZoneMap};

/// Which cells hold receivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Receivers {
    /// All cells of open ground
    #[default]
    Ground,
    /// Open ground that is neither crossroad nor courtyard.
    Street,
    /// Where three or more streets meet.
    Crossroad,
    /// Open ground that buildings enclose.
    Courtyard,
    /// Building cells, standing on the roof.
    Roof,
    /// Ground and roofs.
    All,
    /// Over all ground, buildings that reach no higher included: places of a drone above the ground.
    Air,
}

impl Receivers {
    /// All of them.
    pub const ALL: [Receivers; 7] = [
        Receivers::Ground,
        Receivers::Street,
        Receivers::Crossroad,
        Receivers::Courtyard,
        Receivers::Roof,
        Receivers::All,
        Receivers::Air,
    ];

    /// The word in documents and tables.
    pub fn name(self) -> &'static str {
        match self {
            Receivers::Ground => "ground",
            Receivers::Street => "street",
            Receivers::Crossroad => "crossroad",
            Receivers::Courtyard => "courtyard",
            Receivers::Roof => "roof",
            Receivers::All => "all",
            Receivers::Air => "air",
        }
    }

    /// What whoever looks at them is called: a UAV, or an observer of places in the air.
    pub(crate) fn looked_at_by(self) -> &'static str {
        if self == Receivers::Air { "observer" } else { "UAV" }
    }

    /// One of those.
    pub(crate) fn looked_at_by_one(self) -> &'static str {
        if self == Receivers::Air { "an observer" } else { "a UAV" }
    }

    /// Whether whoever looks at them from a place and a height above the datum \[m\] is an observer on what is below, and no UAV in the
    /// air. The live page draws the same line.
    pub(crate) fn has_observer(self, field: &HeightField, (x, y): (f64, f64), height_amsl_m: f64) -> bool {
        const OBSERVER_BELOW_M: f64 = 20.0;
        let place = field.place(x, y);
        let below = field.roof_at(&place).unwrap_or_else(|| field.ground_at(&place));
        self == Receivers::Air && below != VOID && height_amsl_m - meters(below) < OBSERVER_BELOW_M
    }

    /// What they are counted as.
    pub(crate) fn counted_as(self) -> &'static str {
        if self == Receivers::Air { "places in the air" } else { "receivers" }
    }

    /// The zone that it restricts open ground to, if it does.
    pub(crate) fn zone(self) -> Option<Zone> {
        match self {
            Receivers::Street => Some(Zone::Street),
            Receivers::Crossroad => Some(Zone::Crossroad),
            Receivers::Courtyard => Some(Zone::Courtyard),
            Receivers::Ground | Receivers::Roof | Receivers::All | Receivers::Air => None,
        }
    }

    /// Refuses roofs and zones of a surface model alone, of which no building is known.
    ///
    /// # Errors
    /// E117.
    pub(crate) fn check(self, is_surface_only: bool) -> Result<()> {
        if is_surface_only && (self == Receivers::Roof || self.zone().is_some()) {
            let what = if self == Receivers::Roof { "roof" } else { "zone" };
            return Err(RequestError::NoReceivers { receivers: self.name(), what }.into());
        }
        Ok(())
    }

    /// What receivers, and the cells of a picture that hold none and have no class of their own there, are called in the plural.
    pub(crate) fn cell_names(self, field: &HeightField) -> (&'static str, &'static str) {
        match self {
            _ if field.is_surface_only() => ("surface cells", "Nodata"),
            Receivers::Ground => ("open-ground cells", "Buildings"),
            Receivers::Street => ("street cells", "Buildings"),
            Receivers::Crossroad => ("crossroad cells", "Buildings"),
            Receivers::Courtyard => ("courtyard cells", "Buildings"),
            Receivers::Roof => ("roof cells", "Open ground"),
            Receivers::All => ("cells", "Nodata"),
            Receivers::Air => ("places in the air", "Higher buildings"),
        }
    }
}

/// How line of sight is asked for, not yet checked.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AskedSight {
    /// Which cells hold receivers.
    pub(crate) receivers: Receivers,
    /// Their height above ground or roof \[m\].
    pub(crate) rx_height_m: f64,
    /// Range \[m\], if it is limited.
    pub(crate) radius_m: Option<f64>,
    /// What the antennas of UAVs serve that do not say so themselves.
    pub(crate) antenna: Antenna,
    /// K of a curved earth, if it is not taken as flat.
    pub(crate) earth_k: Option<f64>,
    /// The engine.
    pub(crate) method: MethodChoice,
}

impl Default for AskedSight {
    /// Receivers 1.5 m above open ground at any distance, by the fastest exact engine.
    fn default() -> Self {
        AskedSight {
            receivers: Receivers::Ground,
            rx_height_m: 1.5,
            radius_m: None,
            antenna: Antenna::default(),
            earth_k: None,
            method: MethodChoice::Auto,
        }
    }
}

impl AskedSight {
    /// Refuses numbers out of range.
    ///
    /// # Errors
    /// E113.
    pub(crate) fn checked(self) -> Result<Sight> {
        let AskedSight { receivers, rx_height_m, radius_m, antenna, earth_k, method } = self;
        let numbers = SightNumbers { rx_height_m, radius_m, antenna, earth_k };
        let CheckedNumbers { rx_height, antenna, curvature } = numbers.checked()?;
        Ok(Sight { receivers, rx_height_m, rx_height, radius_m, antenna, curvature, method })
    }
}

/// The receivers' height on the lattice.
///
/// # Errors
/// E113.
pub(crate) fn receivers_height(height_m: f64) -> Result<i32> {
    Ok(coverage::receiver_height(height_m)?)
}

/// How line of sight is asked for, checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sight {
    receivers: Receivers,
    rx_height_m: f64,
    /// On the lattice \[1/1024 m\].
    rx_height: i32,
    radius_m: Option<f64>,
    antenna: Antenna,
    curvature: Option<Curvature>,
    method: MethodChoice,
}

/// How line of sight was asked for, in documents and tables.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(crate) struct SightFacts {
    /// Height of the receivers above what they stand on [m].
    pub(crate) rx_height_m: f64,
    /// Which cells hold receivers: ground, street, crossroad, courtyard, roof or all.
    pub(crate) receivers: &'static str,
    /// Largest horizontal distance from the UAV [m]; null without a limit.
    pub(crate) radius_m: Option<f64>,
    /// What the antennas of UAVs serve that have none of their own; null if that is all.
    pub(crate) antenna: Option<AntennaFacts>,
    /// K by which the radius of the earth is multiplied; null over a flat earth.
    pub(crate) earth_k: Option<f64>,
}

/// Which receivers an antenna serves; null what is not limited.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(crate) struct AntennaFacts {
    /// Least horizontal distance [m], included.
    min_radius_m: Option<f64>,
    /// Azimuths from the first, clockwise, to before the second [deg from grid north].
    sector_deg: Option<[f64; 2]>,
    /// Least and largest elevation of receivers [deg above the UAV's horizontal], both included.
    elevation_deg: Option<[f64; 2]>,
    /// Full angle of a cone straight down [deg].
    beam_deg: Option<f64>,
}

/// What tables say of an antenna; nothing of one that serves all.
pub(crate) fn antenna_words(antenna: Antenna) -> Option<String> {
    Some(antenna.in_words()).filter(|words| !words.is_empty())
}

impl AntennaFacts {
    /// Those of an antenna; nothing of one that serves all.
    pub(crate) fn of(antenna: Antenna) -> Option<AntennaFacts> {
        let Antenna { min_radius_m, sector_deg, elevation_deg, beam_deg } = antenna;
        (antenna != Antenna::default()).then_some(AntennaFacts { min_radius_m, sector_deg, elevation_deg, beam_deg })
    }
}

impl Sight {
    /// Which cells hold receivers.
    pub(crate) fn receivers(&self) -> Receivers {
        self.receivers
    }

    /// For other receivers.
    #[must_use]
    pub(crate) fn of(self, receivers: Receivers) -> Sight {
        Sight { receivers, ..self }
    }

    /// With another antenna.
    #[must_use]
    pub(crate) fn with_antenna(self, antenna: Antenna) -> Sight {
        Sight { antenna, ..self }
    }

    /// Height of the receivers above ground or roof \[m\].
    pub(crate) fn rx_height_m(&self) -> f64 {
        self.rx_height_m
    }

    /// Height of the receivers on the lattice \[1/1024 m\].
    pub(crate) fn rx_height(&self) -> i32 {
        self.rx_height
    }

    /// Range \[m\], if it is limited.
    pub(crate) fn radius_m(&self) -> Option<f64> {
        self.radius_m
    }

    /// What the antennas of UAVs serve that do not say so themselves.
    pub(crate) fn antenna(&self) -> Antenna {
        self.antenna
    }

    /// The curve of the earth, if it is not taken as flat.
    pub(crate) fn curvature(&self) -> Option<Curvature> {
        self.curvature
    }

    /// Whether a receiver may be out of range, but for antennas of single UAVs.
    pub(crate) fn is_limited(&self) -> bool {
        self.radius_m.is_some() || self.antenna != Antenna::default()
    }

    /// The engine that was asked for.
    pub(crate) fn method(&self) -> MethodChoice {
        self.method
    }

    /// The range in units of a grid.
    pub(crate) fn radius_on(&self, grid: &GeoRef) -> Option<f64> {
        self.radius_m.map(|r| r / grid.meters_per_unit())
    }

    /// The box around all that is in range of some places: west, south, east, north \[CRS units\]; `None` without a limit, and
    /// without a place.
    pub(crate) fn box_in_range(&self, sites: &[GivenSite], grid: &GeoRef) -> Option<[f64; 4]> {
        let radius = self.radius_on(grid)?;
        let boxes = sites.iter().map(|site| [site.x - radius, site.y - radius, site.x + radius, site.y + radius]);
        boxes.reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])])
    }

    /// The options of a map on a grid, without layers of heights.
    pub(crate) fn options(&self, grid: &GeoRef, zones: Option<&ZoneMap>) -> MapOptions {
        MapOptions {
            rx_height: self.rx_height,
            receivers: match self.receivers {
                Receivers::Roof => coverage::Receivers::Roof,
                Receivers::All => coverage::Receivers::All,
                Receivers::Air => coverage::Receivers::Air,
                _ => coverage::Receivers::Ground,
            },
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

    /// As documents tell it.
    pub(crate) fn facts(&self) -> SightFacts {
        SightFacts {
            rx_height_m: self.rx_height_m,
            receivers: self.receivers.name(),
            radius_m: self.radius_m,
            antenna: AntennaFacts::of(self.antenna),
            earth_k: self.curvature.map(Curvature::earth_k),
        }
    }

    /// What captions say of the range, after a comma; nothing where it has no limit.
    pub(crate) fn range_in_words(&self) -> String {
        let radius = self.radius_m.map_or(String::new(), |r| format!(", range {} m", tidy(r)));
        let antenna = self.antenna.in_words();
        if antenna.is_empty() { radius } else { format!("{radius}, {antenna}") }
    }

    /// The line of a caption that says for whom a map of a grid was made, and how. `scene` may show less than the grid.
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

/// What captions say of the curve of the earth.
pub(crate) fn earth_words(curvature: Curvature) -> String {
    let k = curvature.earth_k();
    // Five digits are told.
    let k = format!("{k:.4e}").parse().unwrap_or(k);
    format!("curved earth, K = {k}")
}

/// W205 for UAVs over no data, if there are any; returns whether there are.
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

/// W202 for each UAV or placement, by its id, that has no receiver, and W205 for those that have, and are over no data.
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
