//! The engine of a page: one scene for its life, the UAVs of the last question, and their masks.

use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use skyshed_core::city::{BuiltUp, Site};
use skyshed_core::coverage::{
    self, Control, LeastHeights, MapOptions, Mapper, ObstacleKind, Overlay, SiteCoverage, StepKind, Tally, class,
    explain_link, link_profile, place_receiver, surface_under, which_layer,
};
use skyshed_core::error::Error;
use skyshed_core::height_field::{CellKind, HeightField, Station};
use skyshed_core::los::MethodChoice;
use skyshed_core::quantity::{Height, VOID, height_steps, meters, share};
use skyshed_core::raster::BitGrid;
use skyshed_core::zones::{N_CODES, Zone, ZoneMap};

use crate::answers::{
    ByZone, CellFacts, ComparedFacts, Counts, CurveFacts, End, False, LinkFacts, Mapped, Obstruction, Opened, Seen,
    Step, Together, True,
};
use crate::backdrop::backdrop;
use crate::best_place::Search;
use crate::pack::{NotPacked, PackedCity, unpack};
use crate::questions::{Kept, Layer, Question, Receivers, Shown, Sight, Uav};

/// Pictures of counts and of who sees a cell begin here; classes are below.
const FIRST_COUNT: u8 = 16;
/// As many UAVs as a picture of counts tells apart.
const MOST_UAVS: usize = 32;
/// As many UAVs as a picture of who sees a cell tells apart.
const MOST_WHO: usize = 4;

/// A scene, and what was asked of it.
#[derive(Debug)]
pub struct Engine {
    /// PERF: kept for the life of the page, so that what is made ready for it can be kept, too.
    field: &'static HeightField,
    built_up: Option<BuiltUp>,
    zones: Option<ZoneMap>,
    sight: Sight,
    mapper: Mapper<'static>,
    maps: Vec<Map>,
    /// All masks together, where there are several.
    overlay: Option<Overlay>,
    picture: Vec<u8>,
    curve: Option<Curve>,
    search: Option<Search>,
}

/// A UAV of the last question.
#[derive(Debug)]
struct Map {
    asked: Uav,
    /// The error where it cannot hover.
    found: Result<Found, Seen>,
}

#[derive(Debug)]
struct Found {
    coverage: SiteCoverage,
    zones: Option<ByZone>,
}

/// A curve that is being made.
#[derive(Debug)]
struct Curve {
    least: LeastHeights<'static>,
    mask: Vec<u8>,
    next_row: usize,
}

impl Engine {
    /// Builds the scene of packed bytes.
    ///
    /// # Errors
    /// If they are damaged.
    pub fn open(bytes: &[u8]) -> Result<Engine, NotPacked> {
        let PackedCity { grid, solids, built_up } = unpack(bytes)?;
        let field: &'static HeightField = Box::leak(Box::new(HeightField::build(&grid, solids).field));
        let sight = Sight { rx_height_m: 1.5, receivers: Receivers::Ground, radius_m: None };
        Ok(Engine {
            field,
            built_up,
            zones: None,
            sight,
            mapper: mapper(field, &sight, None).map_err(|_| NotPacked)?,
            maps: Vec::new(),
            overlay: None,
            picture: Vec::new(),
            curve: None,
            search: None,
        })
    }

    /// What is said of the scene.
    pub fn opened(&self) -> Opened {
        let surface_only = self.field.is_surface_only();
        let has_buildings = self.field.cells().building.count() > 0;
        Opened { has_zones: !surface_only, has_buildings, surface_only }
    }

    /// Columns and rows of the grid.
    pub fn shape(&self) -> (usize, usize) {
        (self.field.grid().n_cols(), self.field.grid().n_rows())
    }

    /// What lies below the mask: see the page's script for the bytes.
    pub fn backdrop(&self) -> Vec<u8> {
        backdrop(self.field)
    }

    /// The picture of the last question: a class for each cell, or from 16 on how many UAVs see it or who.
    pub fn picture(&self) -> &[u8] {
        &self.picture
    }

    /// Answers a question; the answer is JSON, and for maps and masks there is a picture, too.
    ///
    /// # Errors
    /// What cannot be answered, in words.
    pub fn answer(&mut self, question: Question) -> Result<Value, String> {
        match question {
            Question::Map { uavs, sight, shown } => {
                let mapped = self.map(uavs, sight, shown)?;
                Ok(json!(mapped))
            }
            Question::Zones => {
                self.find_zones();
                let zones = self.zones.as_ref();
                self.maps.iter_mut().for_each(|map| map.count_by(zones));
                Ok(json!({ "has_zones": self.zones.is_some() }))
            }
            Question::Digest => Ok(json!({ "digest": self.digest() })),
            Question::Cell { x, y, which } => Ok(json!(self.cell(x, y, which))),
            Question::Link { which, x, y } => Ok(json!(self.link(which, x, y))),
            Question::Curve { which } => self.begin_curve(which).map(|()| json!({ "share": 0.0 })),
            Question::CurveRows { rows } => self.curve_rows(rows).map(|facts| json!(facts)),
            Question::Best { which, radius_m } => self.begin_search(which, radius_m).map(|()| json!({ "share": 0.0 })),
            Question::BestNext => {
                let radius = self.mapper_radius();
                let search = self.search.as_mut().ok_or("no search was begun")?;
                Ok(json!(search.step(self.field, &self.mapper, radius)))
            }
            Question::Compare { kept, base } => Ok(json!({ "rows": self.compare(&kept, base) })),
            Question::Mask { which } => {
                self.picture.clear();
                match (which, &self.overlay) {
                    (None, Some(overlay)) => self.picture.extend_from_slice(overlay.union()),
                    (which, _) => {
                        let found = self.found(which.unwrap_or(0))?;
                        let mask = found.coverage.mask.to_vec();
                        self.picture = mask;
                    }
                }
                Ok(json!({}))
            }
        }
    }

    fn find_zones(&mut self) {
        if self.zones.is_none() {
            self.zones = ZoneMap::if_known(self.field, self.built_up.as_ref());
        }
    }

    /// The range in units of the grid.
    fn mapper_radius(&self) -> Option<f64> {
        self.sight.radius_m.map(|r| r / self.field.grid().meters_per_unit())
    }

    fn map(&mut self, uavs: Vec<Uav>, sight: Sight, shown: Shown) -> Result<Mapped, String> {
        if uavs.len() > MOST_UAVS {
            return Err(format!("{} UAVs; a page has at most {MOST_UAVS}", uavs.len()));
        }
        if sight != self.sight {
            if zone_of(sight.receivers).is_some() {
                self.find_zones();
            }
            self.mapper = mapper(self.field, &sight, self.zones.as_ref())?;
            self.sight = sight;
            self.maps.clear();
        }
        let mut known = std::mem::take(&mut self.maps);
        for asked in uavs {
            // The mask of a UAV that stays is there already.
            let map = match known.iter().position(|map| map.asked == asked) {
                Some(k) => known.swap_remove(k),
                None => self.map_one(asked)?,
            };
            self.maps.push(map);
        }
        drop(known);
        let all = self.lay_over();
        self.draw(shown);
        let uavs = self.maps.iter().map(Map::seen).collect();
        Ok(Mapped { uavs, all })
    }

    fn map_one(&self, asked: Uav) -> Result<Map, String> {
        let found = match coverage::Uav::place(&site_of(&asked), self.field, self.mapper_radius()) {
            Ok(uav) => {
                let coverage = self.mapper.map(&uav, &Control::default()).map_err(|e| e.to_string())?;
                let mut map = Map { asked, found: Ok(Found { coverage, zones: None }) };
                map.count_by(self.zones.as_ref());
                return Ok(map);
            }
            Err(error) => Err(self.refused(&asked, &error)),
        };
        Ok(Map { asked, found })
    }

    /// Why a UAV cannot hover somewhere.
    fn refused(&self, asked: &Uav, error: &Error) -> Seen {
        let words = match error {
            Error::Uav { why, .. } => why.to_string(),
            error => error.to_string(),
        };
        let lowest = surface_under(self.field, &self.field.place(asked.x, asked.y));
        let lowest_amsl_m = (lowest != VOID && lowest < skyshed_core::quantity::BLOCKS_ALL).then(|| meters(lowest));
        Seen::Refused { ok: False, code: error.code(), words, lowest_amsl_m }
    }

    /// Lays all masks over each other, and counts.
    fn lay_over(&mut self) -> Together {
        let coverages: Vec<&SiteCoverage> =
            self.maps.iter().filter_map(|map| map.found.as_ref().ok()).map(|found| &found.coverage).collect();
        self.overlay = None;
        match coverages.as_slice() {
            [] => Together::default(),
            [one] => {
                let Tally { receivers, los, .. } = one.tally;
                Together { receivers, los, seen_by: vec![receivers - los, los] }
            }
            several => {
                let mut overlay = Overlay::new(self.field.grid().n_cells());
                several.iter().for_each(|coverage| overlay.add(&coverage.mask));
                let seen_by = overlay.seen_by(several.len());
                self.overlay = Some(overlay);
                Together { receivers: seen_by.iter().sum(), los: seen_by.iter().skip(1).sum(), seen_by }
            }
        }
    }

    /// Fills the picture.
    fn draw(&mut self, shown: Shown) {
        self.picture.clear();
        let of_one = |k: usize| self.maps.get(k).and_then(|map| map.found.as_ref().ok()).map(|f| &f.coverage.mask);
        let first = self.maps.iter().position(|map| map.found.is_ok());
        match (shown.layer, &self.overlay) {
            (Layer::Union, Some(overlay)) => self.picture.extend_from_slice(overlay.union()),
            (Layer::Count, Some(overlay)) => {
                let cells = overlay.union().iter().zip(overlay.count());
                self.picture.extend(cells.map(|(class, n)| of_receiver(*class, *n)));
            }
            (Layer::Who, Some(overlay)) => {
                let masks: Vec<&[u8]> =
                    (0..self.maps.len()).filter_map(of_one).take(MOST_WHO).map(|m| &m[..]).collect();
                let who = which_layer(&masks);
                let cells = overlay.union().iter().zip(&who[0]);
                self.picture.extend(cells.map(|(class, bits)| {
                    let who = match bits.count_ones() {
                        0 => 0,
                        1 => bits.trailing_zeros() + 1,
                        _ => 5,
                    };
                    of_receiver(*class, who)
                }));
            }
            // A UAV that cannot hover leaves the picture of another.
            (_, overlay) => match (of_one(shown.which), overlay, first.and_then(of_one)) {
                (Some(mask), ..) => self.picture.extend_from_slice(mask),
                (None, Some(overlay), _) => self.picture.extend_from_slice(overlay.union()),
                (None, None, Some(mask)) => self.picture.extend_from_slice(mask),
                (None, None, None) => {}
            },
        }
    }

    /// The digest of all masks, as the program makes it; none while a UAV cannot hover.
    fn digest(&self) -> Option<String> {
        let (n_cols, n_rows) = self.shape();
        let mut hasher = Sha256::new();
        [n_cols, n_rows].into_iter().for_each(|n| hasher.update((n as u64).to_le_bytes()));
        for map in &self.maps {
            hasher.update(&map.found.as_ref().ok()?.coverage.mask[..]);
        }
        let hex: String = hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        (!self.maps.is_empty()).then(|| format!("sha256:{hex}"))
    }

    fn found(&self, which: usize) -> Result<&Found, String> {
        let map = self.maps.get(which).ok_or("there is no such UAV")?;
        map.found.as_ref().map_err(|_| "the UAV cannot hover there".to_string())
    }

    fn cell(&self, x: f64, y: f64, which: usize) -> CellFacts {
        let grid = self.field.grid();
        let Some((row, col)) = grid.cell_at(x, y) else {
            let (ground_m, roof_m, zone, margin_m) = (None, None, None, None);
            let sees = Vec::new();
            return CellFacts { inside: false, row: 0, col: 0, ground_m, roof_m, kind: "void", zone, sees, margin_m };
        };
        let index = row * grid.n_cols() + col;
        let place = self.field.positions().center(row, col);
        let ground = self.field.ground_at(&place);
        let (kind, roof_m) = match self.field.cell_kind(index, &place) {
            CellKind::Open(_) => ("open", None),
            CellKind::Building(roof) => ("building", Some(meters(roof))),
            CellKind::Void => ("void", None),
        };
        let sees = self.maps.iter().map(|map| {
            let mask = &map.found.as_ref().ok()?.coverage.mask;
            matches!(mask[index], class::LOS | class::NLOS).then(|| mask[index] == class::LOS)
        });
        let sees: Vec<Option<bool>> = sees.collect();
        let is_asked = sees.get(which).is_some_and(Option::is_some);
        let margin = || {
            let receiver = self.receiver_at(row, col).ok()?;
            explain_link(self.field, &self.found(which).ok()?.coverage.uav, &receiver).margin_m
        };
        CellFacts {
            inside: true,
            row,
            col,
            ground_m: (ground != VOID).then(|| meters(ground)),
            roof_m,
            kind,
            zone: self.zones.as_ref().and_then(|zones| zones.of_cell(row, col)).map(Zone::name),
            sees,
            margin_m: if is_asked { margin() } else { None },
        }
    }

    /// The receiver of a cell, on the roof of a building.
    fn receiver_at(&self, row: usize, col: usize) -> Result<Station, String> {
        let (x, y) = self.field.grid().world_from_cell(row, col);
        let height_m = self.sight.rx_height_m;
        let is_building = self.field.cells().building.contains(row, col);
        let height = if is_building { Height::roof(height_m) } else { Height::agl(height_m) };
        place_receiver(self.field, (x, y), height).map_err(|why| why.to_string())
    }

    fn link(&self, which: usize, x: f64, y: f64) -> LinkFacts {
        let ends = || {
            let (row, col) = self.field.grid().cell_at(x, y).ok_or("outside of the scene")?;
            Ok((&self.found(which)?.coverage.uav, self.receiver_at(row, col)?))
        };
        let (uav, receiver) = match ends() {
            Ok(ends) => ends,
            Err(words) => return LinkFacts::Refused { ok: False, words },
        };
        let found = explain_link(self.field, uav, &receiver);
        let steps = link_profile(self.field, uav, &receiver, found.distance_m);
        let end = |at: &Station| {
            let amsl_m = i32::try_from(at.z).map_or(f64::NAN, meters);
            End { x: at.place.x, y: at.place.y, amsl_m }
        };
        LinkFacts::Found {
            ok: True,
            los: found.los,
            margin_m: found.margin_m,
            distance_m: found.distance_m,
            elevation_deg: found.elevation_deg,
            uav: end(&uav.station),
            receiver: end(&receiver),
            obstruction: found.obstruction.map(|obstacle| {
                let of_cell = |(row, col): (usize, usize)| Some(format!("{row}, {col}"));
                let (kind, name) = match obstacle.kind {
                    ObstacleKind::Building(k) => ("building", Some(self.field.building_id(k).to_string())),
                    ObstacleKind::Terrain(cell) => ("terrain", of_cell(cell)),
                    ObstacleKind::Cell(cell) => ("cell", of_cell(cell)),
                    ObstacleKind::Nodata(cell) => ("nodata", of_cell(cell)),
                };
                let (x, y, ray_height_m) = (obstacle.x, obstacle.y, obstacle.ray_height_m);
                Obstruction { kind, name, x, y, ray_height_m, roof_height_m: obstacle.top_m }
            }),
            steps: steps
                .into_iter()
                .map(|step| Step {
                    from_m: step.from_m,
                    to_m: step.to_m,
                    height_m: step.height_m,
                    kind: if step.kind == StepKind::Terrain { "terrain" } else { "building" },
                })
                .collect(),
        }
    }

    fn begin_curve(&mut self, which: usize) -> Result<(), String> {
        let rx_height = rx_height(&self.sight)?;
        let coverage = &self.found(which)?.coverage;
        let least = LeastHeights::of(self.field, &coverage.uav, rx_height);
        self.curve = Some(Curve { least, mask: coverage.mask.to_vec(), next_row: 0 });
        Ok(())
    }

    fn curve_rows(&mut self, rows: usize) -> Result<CurveFacts, String> {
        let (n_cols, n_rows) = self.shape();
        let curve = self.curve.as_mut().ok_or("no curve was begun")?;
        let end = n_rows.min(curve.next_row + rows.max(1));
        let cells = curve.next_row * n_cols..end * n_cols;
        curve.least.add(&curve.mask[cells], curve.next_row, &Control::default());
        curve.next_row = end;
        if end < n_rows {
            return Ok(CurveFacts::Going { share: end as f64 / n_rows as f64 });
        }
        let curve = self.curve.take().ok_or("no curve was begun")?.least.curve();
        Ok(CurveFacts::Done {
            done: True,
            receivers: curve.receivers(),
            ground_m: curve.ground().map(meters),
            lowest_m: meters(curve.lowest_height()),
            heights_m: curve.steps().iter().map(|step| meters(step.0)).collect(),
            los: curve.steps().iter().map(|step| step.1).collect(),
        })
    }

    fn begin_search(&mut self, which: usize, radius_m: f64) -> Result<(), String> {
        let grid = self.field.grid();
        let asked = &self.maps.get(which).ok_or("there is no such UAV")?.asked;
        if !(radius_m > 0.0 && radius_m.is_finite()) {
            return Err(format!("{radius_m} m is no radius"));
        }
        let cell = grid.cell_width().max(grid.cell_height());
        self.search = Some(Search::around(asked, radius_m / grid.meters_per_unit(), cell));
        Ok(())
    }

    /// What each set of UAVs sees, held against one of the sets.
    fn compare(&mut self, kept: &[Kept], base: usize) -> Vec<ComparedFacts> {
        if kept.iter().any(|kept| zone_of(kept.sight.receivers).is_some()) {
            self.find_zones();
        }
        let seen: Vec<Result<(BitGrid, BitGrid), String>> = kept.iter().map(|kept| self.seen_by(kept)).collect();
        let reference = seen.get(base).and_then(|seen| seen.as_ref().ok()).map(|(_, los)| los);
        let facts = seen.iter().map(|seen| match seen {
            Ok((receivers, los)) => {
                let (n_receivers, n_los) = (receivers.count(), los.count());
                let both = reference.map_or(n_los, |base| los.count_in(base));
                ComparedFacts::Found {
                    ok: True,
                    receivers: n_receivers,
                    los: n_los,
                    p_los: share(n_los, n_receivers),
                    gained: n_los - both,
                    lost: reference.map_or(0, |base| base.count() - both),
                }
            }
            Err(words) => ComparedFacts::Refused { ok: False, words: words.clone() },
        });
        facts.collect()
    }

    /// The receivers of a set of UAVs, and those that any of them sees.
    fn seen_by(&self, kept: &Kept) -> Result<(BitGrid, BitGrid), String> {
        let own;
        let mapper = if kept.sight == self.sight {
            &self.mapper
        } else {
            own = mapper(self.field, &kept.sight, self.zones.as_ref())?;
            &own
        };
        let (n_cols, n_rows) = self.shape();
        let mut sum = (BitGrid::new(n_rows, n_cols), BitGrid::new(n_rows, n_cols));
        let radius = kept.sight.radius_m.map(|r| r / self.field.grid().meters_per_unit());
        for asked in &kept.uavs {
            let uav = coverage::Uav::place(&site_of(asked), self.field, radius).map_err(|e| e.to_string())?;
            let seen = mapper.seen(&uav);
            sum = (sum.0.or(&seen.receivers), sum.1.or(&seen.los));
        }
        Ok(sum)
    }
}

impl Map {
    /// Counts the mask by zone, where there are zones.
    fn count_by(&mut self, zones: Option<&ZoneMap>) {
        let (Ok(found), Some(zones)) = (&mut self.found, zones) else { return };
        let by_code: [Tally; N_CODES] = Tally::by_group(&found.coverage.mask, zones.codes());
        let of = |zone: Zone| {
            let tally = by_code[usize::from(zone.code())];
            Counts { receivers: tally.receivers, los: tally.los }
        };
        found.zones = Some(ByZone {
            street: of(Zone::Street),
            crossroad: of(Zone::Crossroad),
            courtyard: of(Zone::Courtyard),
            rooftop: of(Zone::Rooftop),
        });
    }

    fn seen(&self) -> Seen {
        match &self.found {
            Err(refused) => refused.clone(),
            Ok(Found { coverage, zones }) => Seen::Found {
                ok: True,
                amsl_m: coverage.uav.height_amsl_m(),
                agl_m: coverage.uav.height_agl_m,
                over: coverage.uav.placement.name(),
                receivers: coverage.tally.receivers,
                los: coverage.tally.los,
                p_los: coverage.tally.p_los(),
                zones: *zones,
            },
        }
    }
}

/// A UAV of the page as a site.
pub(crate) fn site_of(uav: &Uav) -> Site {
    Site { id: uav.id.clone(), x: uav.x, y: uav.y, height: uav.height.into() }
}

/// The byte of a cell whose receiver has a number; other cells keep their class.
fn of_receiver(class: u8, number: u32) -> u8 {
    match class {
        class::LOS | class::NLOS => u8::try_from(number).map_or(u8::MAX, |n| FIRST_COUNT + n),
        class => class,
    }
}

fn zone_of(receivers: Receivers) -> Option<Zone> {
    match receivers {
        Receivers::Street => Some(Zone::Street),
        Receivers::Crossroad => Some(Zone::Crossroad),
        Receivers::Courtyard => Some(Zone::Courtyard),
        Receivers::Ground | Receivers::Roof | Receivers::All => None,
    }
}

fn rx_height(sight: &Sight) -> Result<i32, String> {
    height_steps(sight.rx_height_m).filter(|h| *h >= 0).ok_or_else(|| format!("receivers at {} m", sight.rx_height_m))
}

/// What makes maps for some receivers.
fn mapper(field: &'static HeightField, sight: &Sight, zones: Option<&ZoneMap>) -> Result<Mapper<'static>, String> {
    let meters_per_unit = field.grid().meters_per_unit();
    if sight.radius_m.is_some_and(|r| !(r > 0.0 && r.is_finite())) {
        return Err("the radius must be above 0 m".into());
    }
    let options = MapOptions {
        rx_height: rx_height(sight)?,
        receivers: match sight.receivers {
            Receivers::Roof => coverage::Receivers::Roof,
            Receivers::All => coverage::Receivers::All,
            _ => coverage::Receivers::Ground,
        },
        within: zone_of(sight.receivers).and_then(|zone| zones.map(|zones| zones.cells(zone))),
        radius: sight.radius_m.map(|r| r / meters_per_unit),
        meters_per_unit,
        method: MethodChoice::Auto,
        ..MapOptions::default()
    };
    Mapper::new(field, &options).map_err(|e| e.to_string())
}
