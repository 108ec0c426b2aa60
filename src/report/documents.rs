//! The documents of a run: `skyshed/map/1` and `skyshed/link/1`, and the table of a map.
//!
//! Keys are stable within a version. A number that does not exist is null with a reason, never 0 or NaN.

use serde_json::{Map, Value, json};

use super::ToleranceFacts;
use super::features::feature_collection;
use super::position::{Position, PositionCells};
use super::stability::StabilityFacts;
use crate::city::Source;
use crate::coverage::{IdleFootprints, Placement, SiteCoverage, Tally};
use crate::digest::Sha256;
use crate::error::Warning;
use crate::los::Method;
use crate::raster::GeoRef;
use crate::zones::{N_CODES, Zone, ZoneMap};

/// What every document says of a run.
#[derive(Debug, Clone)]
pub struct RunFacts {
    /// The words of the command line.
    pub command: Vec<String>,
    /// The engine that ran.
    pub method: Option<Method>,
    /// What the scene is called.
    pub scene_name: String,
    /// The grid of receivers.
    pub grid: GeoRef,
    /// Length of a unit of the grid's CRS \[m\].
    pub meters_per_unit: f64,
    /// The input files.
    pub sources: Vec<Source>,
    /// Seed, for generated cities.
    pub seed: Option<u64>,
    /// What was odd.
    pub warnings: Vec<Warning>,
    /// A hash of all that the run depends on, if it may be asked for again and found done.
    pub unit: Option<String>,
}

/// Seconds spent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Timing {
    /// Reading and checking inputs.
    pub read: f64,
    /// Building the height field and, in memory, making it ready for the UAVs: zones, simpler forms that are tried, the engine.
    pub build: f64,
    /// Deciding line of sight, and writing the cells of a mask that is written while it is made.
    pub los: f64,
    /// Encoding and writing outputs, but for such cells.
    pub write: f64,
    /// All of it.
    pub total: f64,
}

impl Timing {
    pub(super) fn json(&self) -> Value {
        json!({"read": self.read, "build": self.build, "los": self.los, "write": self.write, "total": self.total})
    }
}

/// One UAV of a map, as reported.
#[derive(Debug, Clone)]
pub struct SiteFacts {
    /// Name.
    pub id: String,
    /// East \[CRS units\].
    pub x: f64,
    /// North \[CRS units\].
    pub y: f64,
    /// Longitude and latitude \[deg\], if it was given by these.
    pub lonlat: Option<[f64; 2]>,
    /// Height above the datum \[m\].
    pub height_amsl_m: f64,
    /// Height above the ground \[m\], if one is known there.
    pub height_agl_m: Option<f64>,
    /// What it hovers over: a zone where zones are known, else `ground` or `rooftop`.
    pub placement: &'static str,
    /// Counts.
    pub tally: Tally,
    /// What each move by one lattice step turns, where that was asked for, and the receivers that any turns.
    pub stability: Option<StabilityFacts>,
    /// Counts by zone of the receivers, in the order of [`Zone::ALL`]; `None` where zones were not asked for or no building
    /// is known.
    pub zones: Option<[Tally; 4]>,
}

impl SiteFacts {
    /// Where it is.
    pub fn position(&self) -> Position {
        Position { x: self.x, y: self.y, lonlat: self.lonlat }
    }

    /// The facts of a coverage, by zone if zones are known.
    pub fn of(site: &SiteCoverage, zones: Option<&ZoneMap>) -> Self {
        let place = &site.uav.station.place;
        let is_building = site.uav.placement == Placement::Rooftop;
        let zone = zones.and_then(|zones| zones.over(place.x, place.y, is_building)).map(Zone::name);
        SiteFacts {
            id: site.uav.id.clone(),
            x: site.uav.station.place.x,
            y: site.uav.station.place.y,
            lonlat: None,
            height_amsl_m: site.uav.height_amsl_m(),
            height_agl_m: site.uav.height_agl_m,
            placement: zone.unwrap_or(site.uav.placement.name()),
            tally: site.tally,
            stability: site.stability.as_ref().map(StabilityFacts::of),
            zones: zones.filter(|_| !site.mask.is_empty()).map(|zones| zone_tallies(zones, &site.mask)),
        }
    }
}

/// The counts of a mask by zone, in the order of [`Zone::ALL`].
pub fn zone_tallies(zones: &ZoneMap, mask: &[u8]) -> [Tally; 4] {
    let of_codes: [Tally; N_CODES] = Tally::by_group(mask, zones.codes());
    Zone::ALL.map(|zone| of_codes[usize::from(zone.code())])
}

/// Why a zone has no P_LoS.
fn reason_in(zone: Zone, tally: &Tally) -> String {
    let name = zone.name();
    if tally.not_receivers > 0 {
        format!("no {name} cell in range holds a receiver")
    } else if tally.out_of_range > 0 {
        format!("no {name} cell in range")
    } else {
        format!("the scene has no {name} cell")
    }
}

/// Counts by zone, each with P_LoS or the reason why there is none.
fn zones_json(zones: Option<&[Tally; 4]>) -> Value {
    let of = |(zone, tally): (Zone, &Tally)| {
        let mut counts = tally_json(tally);
        if tally.p_los().is_none() {
            counts.insert("reason".into(), reason_in(zone, tally).into());
        }
        (zone.name().to_string(), Value::Object(counts))
    };
    zones.map_or(Value::Null, |zones| Zone::ALL.into_iter().zip(zones).map(of).collect::<Map<_, _>>().into())
}

/// A map as reported.
#[derive(Debug, Clone)]
pub struct MapReport {
    /// The run.
    pub facts: RunFacts,
    /// Height of the receivers above what they stand on \[m\].
    pub rx_height_m: f64,
    /// Which cells hold receivers.
    pub receivers: &'static str,
    /// Range \[m\], if it is limited.
    pub radius_m: Option<f64>,
    /// The UAVs.
    pub sites: Vec<SiteFacts>,
    /// All UAVs together.
    pub union: Tally,
    /// The same by zone, as those of a site.
    pub union_zones: Option<[Tally; 4]>,
    /// Footprints that were dropped before work started, in a scene of footprints.
    pub idle: Option<IdleFootprints>,
    /// What a tolerance led to, where one was given.
    pub tolerance: Option<ToleranceFacts>,
    /// Digest of the masks, see [`digest`].
    pub digest: String,
}

/// SHA-256 of the number of columns and of rows (u64, little endian), then per site its mask, north row first.
#[derive(Debug, Clone)]
pub struct MaskDigest(Sha256);

impl MaskDigest {
    /// The digest of a map without sites.
    pub fn new(grid: &GeoRef) -> Self {
        let mut hasher = Sha256::default();
        hasher.update((grid.n_cols() as u64).to_le_bytes());
        hasher.update((grid.n_rows() as u64).to_le_bytes());
        MaskDigest(hasher)
    }

    /// Adds the mask of the next site.
    pub fn add(&mut self, mask: &[u8]) {
        self.0.update(mask);
    }

    /// `sha256:` and the hexadecimal digest.
    pub fn finish(self) -> String {
        digest_words(self.0)
    }
}

/// A digest as documents tell it: `sha256:` and its hexadecimal digits.
pub(crate) fn digest_words(hasher: Sha256) -> String {
    format!("sha256:{}", hasher.hex_digits())
}

/// The digest of some masks.
pub fn digest<'a>(grid: &GeoRef, masks: impl Iterator<Item = &'a [u8]>) -> String {
    let mut digest = MaskDigest::new(grid);
    masks.for_each(|mask| digest.add(mask));
    digest.finish()
}

/// The method of a run that decided no link: it drew, described, or compared what was saved.
const NO_METHOD: &str = "none";

impl RunFacts {
    /// The word for the method in documents and tables.
    pub fn method_name(&self) -> String {
        self.method.map_or(NO_METHOD.into(), |method| method.name().into_owned())
    }

    /// The method with what it is worth, for captions.
    pub fn method_in_words(&self) -> String {
        self.method.map_or(NO_METHOD.into(), Method::in_words)
    }

    fn scene(&self) -> Value {
        let grid = &self.grid;
        let sources: Vec<Value> = self.sources.iter().map(|s| json!({"path": s.path, "sha256": s.sha256})).collect();
        json!({
            "name": self.scene_name,
            "cols": grid.n_cols(),
            "rows": grid.n_rows(),
            "cell_m": [grid.cell_width() * self.meters_per_unit, grid.cell_height() * self.meters_per_unit],
            "extent": [grid.x_min(), grid.y_min(), grid.x_max(), grid.y_max()],
            "crs": grid.crs().map(crate::raster::Crs::label),
            "seed": self.seed,
            "sources": sources,
        })
    }

    pub(super) fn head(&self, schema: &str) -> Map<String, Value> {
        let mut document = Map::new();
        document.insert("schema".into(), schema.into());
        document.insert("version".into(), env!("CARGO_PKG_VERSION").into());
        document.insert("command".into(), self.command.clone().into());
        document.insert("method".into(), self.method_name().into());
        document.extend(self.method.map(|method| ("exact".to_string(), Value::from(method.is_exact()))));
        document.insert("scene".into(), self.scene());
        document.extend(self.unit.clone().map(|unit| ("unit".to_string(), unit.into())));
        document
    }

    pub(super) fn warnings(&self) -> Value {
        self.warnings.iter().map(|w| json!({"code": w.code(), "text": w.text()})).collect::<Vec<_>>().into()
    }

    /// Where a result comes from, as stored in every output: no times, so that equal runs give equal files.
    pub fn provenance(&self, schema: &str, digest: Option<&str>) -> Value {
        let mut document = self.head(schema);
        document.insert("warnings".into(), self.warnings());
        document.extend(digest.map(|d| ("digest".to_string(), Value::from(d))));
        Value::Object(document)
    }
}

/// Footprints, and how many of them can hide no receiver.
pub fn idle_json(idle: &IdleFootprints) -> Value {
    json!({
        "total": idle.footprints, "dropped": idle.dropped(), "too_low": idle.too_low, "out_of_reach": idle.out_of_reach,
    })
}

/// Counts with P_LoS, or null and the reason.
pub(super) fn tally_json(tally: &Tally) -> Map<String, Value> {
    let mut counts = Map::new();
    counts.insert("receivers".into(), tally.receivers.into());
    counts.insert("los".into(), tally.los.into());
    counts.insert("p_los".into(), tally.p_los().into());
    if tally.p_los().is_none() {
        counts.insert("reason".into(), tally.reason().into());
    }
    counts
}

impl MapReport {
    /// The report of one of the sites alone, with the digest of its mask.
    #[must_use]
    pub fn of_site(&self, site: &SiteFacts, digest: String) -> MapReport {
        MapReport { sites: vec![site.clone()], union: site.tally, union_zones: site.zones, digest, ..self.clone() }
    }

    /// The document `skyshed/map/1`; without `timing` it is the same for equal runs.
    pub fn document(&self, timing: Option<Timing>) -> Value {
        let mut document = self.facts.head("skyshed/map/1");
        if let Some(tolerance) = &self.tolerance {
            if !tolerance.taken.is_same() {
                // The engine is exact on a scene that is not.
                document.insert("exact".into(), false.into());
            }
            document.insert("tolerance".into(), tolerance.json());
        }
        document.extend(self.idle.map(|idle| ("footprints".to_string(), idle_json(&idle))));
        document.insert("rx_height_m".into(), self.rx_height_m.into());
        document.insert("receivers".into(), self.receivers.into());
        document.insert("radius_m".into(), self.radius_m.into());
        document.insert("sites".into(), self.sites.iter().map(site_json).collect::<Vec<_>>().into());
        let mut union = tally_json(&self.union);
        union.insert("zones".into(), zones_json(self.union_zones.as_ref()));
        document.insert("union".into(), union.into());
        if let Some(t) = timing {
            document.insert("timing_s".into(), t.json());
        }
        document.insert("warnings".into(), self.facts.warnings());
        document.insert("digest".into(), self.digest.clone().into());
        Value::Object(document)
    }

    /// The table: one row per site and zone, and one for the union of several sites.
    pub fn table(&self) -> Vec<Vec<String>> {
        let positions = PositionCells::of(self.sites.iter().map(SiteFacts::position));
        let header = format!(
            "site,{},height_amsl_m,height_agl_m,placement,zone,receivers,los,p_los,not_receivers,out_of_range,nodata,\
             rx_height_m,radius_m,method,crs,cell_width,cell_height",
            positions.names()
        );
        let mut rows = vec![header.split(',').map(str::to_string).collect::<Vec<_>>()];
        let optional = |v: Option<f64>| v.map_or(String::new(), |v| v.to_string());
        let run = [
            self.rx_height_m.to_string(),
            optional(self.radius_m),
            self.facts.method_name(),
            self.facts.grid.crs().map_or(String::new(), crate::raster::Crs::label),
            self.facts.grid.cell_width().to_string(),
            self.facts.grid.cell_height().to_string(),
        ];
        let mut push = |site: Vec<String>, zone: &str, tally: &Tally| {
            let counts = [
                zone.to_string(),
                tally.receivers.to_string(),
                tally.los.to_string(),
                optional(tally.p_los()),
                tally.not_receivers.to_string(),
                tally.out_of_range.to_string(),
                tally.nodata.to_string(),
            ];
            rows.push(site.into_iter().chain(counts).chain(run.clone()).collect());
        };
        for s in &self.sites {
            let mut site = vec![s.id.clone()];
            site.extend(positions.cells(Some(s.position())));
            site.extend([s.height_amsl_m.to_string(), optional(s.height_agl_m), s.placement.to_string()]);
            push(site.clone(), "all", &s.tally);
            for (zone, tally) in Zone::ALL.into_iter().zip(s.zones.iter().flatten()) {
                push(site.clone(), zone.name(), tally);
            }
        }
        if self.sites.len() > 1 {
            let mut site = vec!["union".to_string()];
            site.extend(positions.cells(None));
            site.resize(site.len() + 3, String::new());
            push(site.clone(), "all", &self.union);
            for (zone, tally) in Zone::ALL.into_iter().zip(self.union_zones.iter().flatten()) {
                push(site.clone(), zone.name(), tally);
            }
        }
        rows
    }

    /// The sites as GeoJSON points with their results, in the scene's CRS.
    pub fn geojson(&self) -> Value {
        let features: Vec<Value> = self
            .sites
            .iter()
            .map(|s| {
                json!({
                    "type": "Feature",
                    "properties": site_json(s),
                    "geometry": {"type": "Point", "coordinates": [s.x, s.y]},
                })
            })
            .collect();
        feature_collection(&self.facts.grid, self.facts.provenance("skyshed/map/1", Some(&self.digest)), features)
    }
}

fn site_json(site: &SiteFacts) -> Value {
    let mut object = Map::new();
    object.insert("id".into(), site.id.clone().into());
    site.position().tell(&mut object);
    object.insert("height_amsl_m".into(), site.height_amsl_m.into());
    object.insert("height_agl_m".into(), site.height_agl_m.into());
    object.insert("placement".into(), site.placement.into());
    object.extend(tally_json(&site.tally));
    object.insert("zones".into(), zones_json(site.zones.as_ref()));
    object.extend(site.stability.as_ref().map(|s| ("stability".to_string(), s.json())));
    let bands: Vec<Value> = site
        .tally
        .elevation_bands()
        .iter()
        .map(|b| json!({"from_deg": b.from_deg, "to_deg": b.to_deg, "receivers": b.receivers, "los": b.los}))
        .collect();
    object.insert("elevation_bands".into(), bands.into());
    Value::Object(object)
}

/// What stands in the way of a link.
#[derive(Debug, Clone, PartialEq)]
pub struct ObstructionReport {
    /// `building`, `terrain`, or `cell` of a surface model.
    pub kind: &'static str,
    /// Id of the building.
    pub id: Option<String>,
    /// Row and column of the cell.
    pub cell: Option<(usize, usize)>,
    /// Obstructing point \[CRS units\].
    pub x: f64,
    /// Obstructing point \[CRS units\].
    pub y: f64,
    /// Height of the ray there \[m above the datum\].
    pub ray_height_m: f64,
    /// Height of the obstacle there \[m above the datum\]; `None` for nodata that blocks everything.
    pub roof_height_m: Option<f64>,
}

/// One link as reported.
#[derive(Debug, Clone)]
pub struct LinkReport {
    /// The run.
    pub facts: RunFacts,
    /// UAV: x, y \[CRS units\], height above the datum \[m\].
    pub uav: [f64; 3],
    /// Receiver: x, y \[CRS units\], height above the datum \[m\].
    pub receiver: [f64; 3],
    /// Whether the link is in line of sight.
    pub los: bool,
    /// Receiver height less the least visible height \[m\]; `None` if no receiver height is enough.
    pub margin_m: Option<f64>,
    /// Horizontal distance \[m\].
    pub distance_m: f64,
    /// Elevation angle of the UAV from the receiver \[deg\].
    pub elevation_deg: f64,
    /// What stands in the way; `None` if nothing does.
    pub obstruction: Option<ObstructionReport>,
}

impl LinkReport {
    /// The document `skyshed/link/1`.
    pub fn document(&self) -> Value {
        let mut document = self.facts.head("skyshed/link/1");
        let end = |e: &[f64; 3]| json!({"x": e[0], "y": e[1], "height_amsl_m": e[2]});
        document.insert("uav".into(), end(&self.uav));
        document.insert("receiver".into(), end(&self.receiver));
        document.insert("los".into(), self.los.into());
        document.insert("margin_m".into(), self.margin_m.into());
        document.insert("distance_m".into(), self.distance_m.into());
        document.insert("elevation_deg".into(), self.elevation_deg.into());
        let obstruction = self.obstruction.as_ref().map_or(Value::Null, |o| {
            let mut object = Map::new();
            object.insert("kind".into(), o.kind.into());
            object.extend(o.id.as_ref().map(|id| ("id".to_string(), Value::from(id.clone()))));
            if let Some((row, col)) = o.cell {
                object.insert("row".into(), row.into());
                object.insert("col".into(), col.into());
            }
            object.insert("x".into(), o.x.into());
            object.insert("y".into(), o.y.into());
            object.insert("ray_height_m".into(), o.ray_height_m.into());
            object.insert("roof_height_m".into(), o.roof_height_m.into());
            Value::Object(object)
        });
        document.insert("obstruction".into(), obstruction);
        document.insert("warnings".into(), self.facts.warnings());
        Value::Object(document)
    }
}
