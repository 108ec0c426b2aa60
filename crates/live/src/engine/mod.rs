//! Engine of a page: one scene for its life, the UAVs of the last question, and their coverage.

mod fields;
mod places;
mod studies;
mod tracks;

use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use skyshed_core::coverage::{
    self, CheckedNumbers, HeightBounds, HoversOver, MapOptions, Mapper, Seen as SeenCells, Sure, Tally, check_drop,
    check_height_error, class, surface_under,
};
use skyshed_core::error::Error;
use skyshed_core::height_field::{CellSets, HeightField};
use skyshed_core::quantity::{BLOCKS_ALL, VOID, meters};
use skyshed_core::raster::BitGrid;
use skyshed_core::zones::{Zone, ZoneBasis, ZoneMap};

use crate::answers::{ByZone, Counts, False, Mapped, Opened, Seen, Together, True};
use crate::backdrop::backdrop;
use crate::best_place::Search;
use crate::cell_picture::{CellPicture, seen_by};
use crate::pack::{NotPacked, PackedCity, unpack};
use crate::questions::{Layer, PageSight, PageTrack, Question, Shown, Uav};

/// Largest number of UAVs of a page: the picture of counts can tell apart no more.
pub const MOST_UAVS: usize = 32;
/// Largest number of UAVs that the picture of who sees a cell can tell apart.
const MOST_WHO: usize = 4;

/// Scene, with the state of the questions about it.
#[derive(Debug)]
pub struct Engine {
    /// PERF: kept for the life of the page, so that data prepared for it can be kept, too.
    field: &'static HeightField,
    zones: Option<Zones>,
    sight: PageSight,
    mapper: Mapper<'static>,
    /// Cells that hold receivers, in range or not.
    receivers: BitGrid,
    cells: CellPicture,
    /// Scene with buildings as low and as high as they may be, if heights may be off.
    bounds: Option<HeightBounds>,
    maps: Vec<Map>,
    picture: Vec<u8>,
    curve: Option<studies::Curve>,
    search: Option<Search>,
    tracks: Vec<PageTrack>,
}

/// Zones of the scene, and the cells of each.
#[derive(Debug)]
struct Zones {
    map: ZoneMap,
    cells: [(Zone, BitGrid); 4],
}

/// UAV of the last question.
#[derive(Debug)]
struct Map {
    asked: Uav,
    /// Coverage, or the refusal of a UAV that cannot hover.
    found: Result<Found, Seen>,
}

/// Coverage by a UAV.
#[derive(Debug)]
struct Found {
    uav: coverage::Uav,
    /// Height above the ground or roof below, if one is known there \[m\].
    above_m: Option<f64>,
    /// All cells in range; `None` without a limit.
    in_range: Option<BitGrid>,
    seen: SeenCells,
    /// Receivers that are surely and possibly in line of sight, if heights may be off.
    sure: Option<Sure>,
    zones: Option<ByZone>,
}

impl Engine {
    /// Builds the scene from packed bytes.
    ///
    /// # Errors
    /// [`NotPacked`] if they are damaged.
    pub fn open(bytes: &[u8]) -> Result<Engine, NotPacked> {
        let PackedCity { grid, solids, zones } = unpack(bytes)?;
        let field: &'static HeightField = Box::leak(Box::new(HeightField::build(&grid, solids).field));
        let sight = PageSight::start();
        let zones = zones.and_then(|zones| {
            let CellSets { open, building } = field.cells();
            let mut codes = zones.codes(open);
            building.cells().for_each(|(row, col)| codes[row * open.n_cols() + col] = Zone::Rooftop.code());
            ZoneMap::of_codes(field, codes, ZoneBasis::OpenGround).map(Zones::of)
        });
        let mapper = mapper(field, &sight, zones.as_ref()).map_err(|_| NotPacked)?;
        let receivers = mapper.receiver_cells();
        Ok(Engine {
            field,
            zones,
            sight,
            mapper,
            cells: CellPicture::new(field, &receivers),
            receivers,
            bounds: None,
            maps: Vec::new(),
            picture: Vec::new(),
            curve: None,
            search: None,
            tracks: Vec::new(),
        })
    }

    /// Returns the description of the scene.
    pub fn opened(&self) -> Opened {
        let CellSets { open, building } = self.field.cells();
        Opened {
            has_zones: self.zones.is_some(),
            has_buildings: building.count() > 0,
            has_no_data: open.count() + building.count() < self.field.grid().n_cells() as u64,
        }
    }

    /// Returns the numbers of columns and rows of the grid.
    pub fn shape(&self) -> (usize, usize) {
        (self.field.grid().n_cols(), self.field.grid().n_rows())
    }

    /// Returns the backdrop of the mask: one byte per cell, which the page colors. The module
    /// `backdrop` describes the bytes.
    pub fn backdrop(&self) -> Vec<u8> {
        backdrop(self.field)
    }

    /// Returns the picture of the last question: a class for each cell. From 16 on, values count
    /// the UAVs that see a cell, or name them.
    pub fn picture(&self) -> &[u8] {
        &self.picture
    }

    /// Answers a question in JSON. Maps and masks also make a picture.
    ///
    /// # Errors
    /// Reason why it cannot be answered, in words.
    pub fn answer(&mut self, question: Question) -> Result<Value, String> {
        match question {
            Question::Map { uavs, sight, shown } => self.map(uavs, sight, shown).map(|mapped| json!(mapped)),
            Question::Digest { which } => Ok(json!({ "digest": self.digest(which) })),
            Question::Read { field, text, x, y } if field == "height" => Ok(self.read_height(&text, (x, y))),
            Question::Read { field, text, .. } => Ok(self.read_number(&field, &text)),
            Question::Cell { x, y, which } => Ok(json!(self.cell(x, y, which))),
            Question::Link { which, x, y } => Ok(json!(self.link(which, x, y))),
            Question::Tracks { tracks } => self.take_tracks(tracks).map(|()| json!({})),
            Question::Stretches { which, every_m } => self.stretches(which, every_m).map(|facts| json!(facts)),
            Question::TrackHeights => self.track_heights().map(|places| json!({ "places": places })),
            Question::Curve { which } => self.begin_curve(which).map(|()| json!({ "share": 0.0 })),
            Question::CurveRows { rows } => self.curve_rows(rows).map(|facts| json!(facts)),
            Question::Best { which, radius_m } => self.begin_search(which, radius_m).map(|()| json!({ "share": 0.0 })),
            Question::BestNext => {
                let radius = self.mapper_radius();
                let search = self.search.as_mut().ok_or("no search was begun")?;
                Ok(json!(search.step(self.field, &self.mapper, radius)))
            }
            Question::Compare { kept, base } => Ok(json!({ "rows": self.compare(&kept, base) })),
            Question::Mask { which } => self.mask(which).map(|()| json!({})),
        }
    }

    /// Replaces the picture by the mask of a UAV, or of all together.
    fn mask(&mut self, which: Option<usize>) -> Result<(), String> {
        let (los, in_range) = match which {
            None => self.together(),
            Some(which) => {
                let found = self.found(which)?;
                (found.seen.los.clone(), found.in_range.clone())
            }
        };
        self.cells.mask(&mut self.picture, &los, in_range.as_ref());
        Ok(())
    }

    /// Returns the radius in units of the grid.
    fn mapper_radius(&self) -> Option<f64> {
        self.sight.radius_on(self.field.grid())
    }

    fn map(&mut self, uavs: Vec<Uav>, sight: PageSight, shown: Shown) -> Result<Mapped, String> {
        if uavs.len() > MOST_UAVS {
            return Err(format!("{} UAVs; a page has at most {MOST_UAVS}", uavs.len()));
        }
        if sight != self.sight {
            let mapper = mapper(self.field, &sight, self.zones.as_ref())?;
            // Steps that may fail come before steps that change the engine.
            if sight.heights != self.sight.heights {
                let of = |m: f64| {
                    check_height_error("the error of heights", m).map_err(|e| e.to_string())?;
                    let bounds = HeightBounds::of(self.field, m);
                    bounds.ok_or_else(|| format!("heights that are off by {m} m"))
                };
                self.bounds = sight.heights.height_error.map(of).transpose()?;
            }
            self.mapper = mapper;
            self.receivers = self.mapper.receiver_cells();
            self.cells = CellPicture::new(self.field, &self.receivers);
            self.sight = sight;
            self.maps.clear();
        }
        let mut known = std::mem::take(&mut self.maps);
        for asked in uavs {
            // A UAV that was in the last map keeps its coverage.
            let map = match known.iter().position(|map| map.asked == asked) {
                Some(k) => known.swap_remove(k),
                None => self.map_one(asked),
            };
            self.maps.push(map);
        }
        self.draw(shown);
        Ok(Mapped {
            uavs: self.maps.iter().map(Map::seen).collect(),
            all: self.count_together(),
            has_out_of_range: self.picture.contains(&class::OUT_OF_RANGE),
        })
    }

    fn map_one(&self, asked: Uav) -> Map {
        let uav = coverage::Uav::place(&asked.site(), self.field, self.mapper_radius());
        let found = uav.and_then(|uav| self.see(uav)).map_err(|error| self.refused(&asked, &error));
        Map { asked, found }
    }

    fn see(&self, uav: coverage::Uav) -> skyshed_core::Result<Found> {
        let view = self.mapper.seen_from(&uav)?;
        let (seen, in_range) = (view.seen(), view.cells_in_range());
        let zones = self.zones.as_ref().map(|zones| zones.count(&seen));
        let sure = self.bounds.as_ref().and_then(|bounds| view.sure(bounds).ok());
        let above_m = self.height_above(&uav);
        Ok(Found { uav, above_m, in_range, seen, sure, zones })
    }

    fn height_above(&self, uav: &coverage::Uav) -> Option<f64> {
        let place = &uav.station.place;
        let below = self.field.roof_at(place).unwrap_or_else(|| self.field.ground_at(place));
        (below != VOID).then(|| uav.height_amsl_m() - meters(below))
    }

    /// Returns the reason why a UAV cannot hover somewhere.
    fn refused(&self, asked: &Uav, error: &Error) -> Seen {
        let words = match error {
            Error::Uav { why, .. } => why.to_string(),
            error => error.to_string(),
        };
        let lowest = surface_under(self.field, &self.field.place(asked.x, asked.y));
        let lowest_amsl_m = (lowest != VOID && lowest < BLOCKS_ALL).then(|| meters(lowest));
        Seen::Refused { ok: False, code: error.code(), words, lowest_amsl_m }
    }

    /// Returns the UAVs that hover.
    fn hovering(&self) -> impl Iterator<Item = &Found> {
        self.maps.iter().filter_map(Map::found)
    }

    /// Returns the cells that any UAV sees, and the cells in range of any; `None` for the latter if
    /// any UAV has no limit.
    fn together(&self) -> (BitGrid, Option<BitGrid>) {
        let (n_cols, n_rows) = self.shape();
        let none = || BitGrid::new(n_rows, n_cols);
        let los = self.hovering().fold(none(), |sum, found| sum.or(&found.seen.los));
        let has_limit = self.hovering().all(|found| found.in_range.is_some());
        let in_range =
            || self.hovering().filter_map(|found| found.in_range.as_ref()).fold(none(), |sum, set| sum.or(set));
        (los, has_limit.then(in_range))
    }

    fn count_together(&self) -> Together {
        let is_over_nodata = || self.hovering().any(|found| found.uav.placement == HoversOver::Nodata);
        let reason = || p_los_of((1, 0), is_over_nodata()).1;
        let mut hovering = self.hovering();
        match (hovering.next(), hovering.next()) {
            (None, _) => Together::default(),
            (Some(one), None) => {
                let (receivers, los) = (one.seen.receivers.count(), one.seen.los.count());
                Together { receivers, los, seen_by: vec![receivers - los, los], reason: reason() }
            }
            (Some(one), Some(_)) => {
                let receivers =
                    self.hovering().fold(one.seen.receivers.clone(), |sum, found| sum.or(&found.seen.receivers));
                let sets: Vec<&BitGrid> = self.hovering().map(|found| &found.seen.los).collect();
                let seen_by = seen_by(&receivers, &sets);
                let (receivers, los) = (seen_by.iter().sum(), seen_by.iter().skip(1).sum());
                Together { receivers, los, seen_by, reason: reason() }
            }
        }
    }

    /// Fills the picture; it is empty if no UAV hovers.
    fn draw(&mut self, shown: Shown) {
        let mut picture = std::mem::take(&mut self.picture);
        picture.clear();
        let one = self.maps.get(shown.which).and_then(|map| map.found.as_ref().ok());
        match (shown.layer, one) {
            _ if self.hovering().next().is_none() => {}
            (Layer::One, Some(found)) => {
                self.cells.mask(&mut picture, &found.seen.los, found.in_range.as_ref());
                if let Some(sure) = &found.sure {
                    self.cells.unsure(&mut picture, sure);
                }
            }
            // For a UAV that cannot hover, the picture shows all others together.
            (Layer::One | Layer::Union, _) => {
                let (los, in_range) = self.together();
                self.cells.mask(&mut picture, &los, in_range.as_ref());
            }
            (Layer::Count, _) => {
                let sets = self.hovering().map(|found| &found.seen.los);
                self.cells.counts(&mut picture, &self.receivers, sets, self.together().1.as_ref());
            }
            (Layer::Who, _) => {
                // A UAV that cannot hover keeps its place among the colors.
                let (n_cols, n_rows) = self.shape();
                let none = BitGrid::new(n_rows, n_cols);
                let los = |map| Map::found(map).map_or(&none, |found| &found.seen.los);
                let sets: Vec<&BitGrid> = self.maps.iter().take(MOST_WHO).map(los).collect();
                self.cells.who(&mut picture, &self.receivers, &sets, self.together().1.as_ref());
            }
        }
        self.picture = picture;
    }

    /// Returns the digest of all masks, or of one, as the program makes it. `None` if one of the
    /// UAVs cannot hover.
    fn digest(&self, which: Option<usize>) -> Option<String> {
        let maps = match which {
            None => &self.maps[..],
            Some(which) => self.maps.get(which..=which)?,
        };
        let (n_cols, n_rows) = self.shape();
        let mut hasher = Sha256::new();
        [n_cols, n_rows].into_iter().for_each(|n| hasher.update((n as u64).to_le_bytes()));
        let mut mask = Vec::new();
        for map in maps {
            let found = map.found.as_ref().ok()?;
            self.cells.mask(&mut mask, &found.seen.los, found.in_range.as_ref());
            hasher.update(&mask);
        }
        let hex: String = hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        (!maps.is_empty()).then(|| format!("sha256:{hex}"))
    }

    fn found(&self, which: usize) -> Result<&Found, String> {
        let map = self.maps.get(which).ok_or("there is no such UAV")?;
        map.found.as_ref().map_err(|_| "the UAV cannot hover there".to_string())
    }
}

impl Zones {
    fn of(map: ZoneMap) -> Self {
        let cells = Zone::ALL.map(|zone| (zone, map.cells(zone)));
        Zones { map, cells }
    }

    /// Returns the cells of a zone.
    fn cells(&self, wanted: Zone) -> Option<BitGrid> {
        self.cells.iter().find(|(zone, _)| *zone == wanted).map(|(_, cells)| cells.clone())
    }

    /// Counts receivers zone by zone.
    fn count(&self, seen: &SeenCells) -> ByZone {
        let of = |wanted: Zone| {
            let cells = self.cells.iter().find(|(zone, _)| *zone == wanted).map(|(_, cells)| cells);
            cells.map_or(Counts::default(), |cells| Counts {
                receivers: seen.receivers.count_in(cells),
                los: seen.los.count_in(cells),
            })
        };
        ByZone {
            street: of(Zone::Street),
            crossroad: of(Zone::Crossroad),
            courtyard: of(Zone::Courtyard),
            rooftop: of(Zone::Rooftop),
        }
    }
}

impl Map {
    /// Returns its coverage, if it hovers.
    fn found(&self) -> Option<&Found> {
        self.found.as_ref().ok()
    }

    fn seen(&self) -> Seen {
        match &self.found {
            Err(refused) => refused.clone(),
            Ok(Found { uav, above_m, seen, sure, zones, .. }) => {
                let surely = |sure: &Sure| sure.surely.count();
                let sure = sure.as_ref().map(|sure| [surely(sure), sure.possibly.count() - surely(sure)]);
                let (receivers, los) = (seen.receivers.count(), seen.los.count());
                let (p_los, reason) = p_los_of((receivers, los), uav.placement == HoversOver::Nodata);
                Seen::Found {
                    ok: True,
                    amsl_m: uav.height_amsl_m(),
                    agl_m: uav.height_agl_m,
                    above_m: *above_m,
                    over: uav.placement.name(),
                    receivers,
                    los,
                    p_los,
                    reason,
                    sure,
                    zones: *zones,
                }
            }
        }
    }
}

/// Returns P_LoS, and the reason why there is none though there are receivers.
fn p_los_of((receivers, los): (u64, u64), is_over_nodata: bool) -> (Option<f64>, Option<&'static str>) {
    let mut tally = Tally::of_receivers(receivers, los);
    tally.is_over_nodata = is_over_nodata;
    (tally.p_los(), is_over_nodata.then(|| tally.reason()))
}

/// Returns the mapper of a question.
fn mapper(field: &'static HeightField, sight: &PageSight, zones: Option<&Zones>) -> Result<Mapper<'static>, String> {
    let meters_per_unit = field.grid().meters_per_unit();
    let numbers = sight.sight.numbers().map_err(|_| "`curvature_coefficient` says what `earth_k` says")?;
    let CheckedNumbers { rx_height, antenna, curvature } = numbers.checked().map_err(|e| e.to_string())?;
    if let Some(curvature) = curvature {
        let grid = field.grid();
        let across = (grid.x_max() - grid.x_min()).hypot(grid.y_max() - grid.y_min()) * meters_per_unit;
        let reach = sight.sight.range.radius.map_or(across, |r| r.min(across));
        check_drop(curvature.drop_m(2.0 * reach), field.lowest_known()).map_err(|e| e.to_string())?;
    }
    let options = MapOptions {
        rx_height,
        receivers: sight.receivers().cells(),
        within: sight.receivers().zone().and_then(|zone| zones.and_then(|zones| zones.cells(zone))),
        radius: sight.radius_on(field.grid()),
        antenna,
        curvature,
        meters_per_unit,
        ..MapOptions::default()
    };
    Mapper::new(field, &options).map_err(|e| e.to_string())
}
