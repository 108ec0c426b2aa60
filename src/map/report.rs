//! Report of a map: the document `skyshed/map/1` and its features.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::over_time::{Span, SpanFacts};
use super::stability_report::{StabilityDocument, StabilityFacts};
use super::tiles::TileFacts;
use super::tolerance::{ToleranceDocument, ToleranceFacts};
use crate::answer::{
    Head, Position, PositionFields, RunFacts, Share, Timing, WarningFacts, closed_rings, digest_words, document_of,
    feature, feature_collection, warnings_of,
};
use crate::city::Antenna;
use crate::coverage::{CoveragePolygon, HoversOver, IdleFootprints, SiteCoverage, Tally};
use crate::digest::Sha256;
use crate::height_errors::{HeightErrorsDocument, HeightErrorsPlan, UncertainFacts};
use crate::raster::GeoRef;
use crate::sight::{AntennaFacts, SightFacts, SightPlan};
use crate::zones::{N_CODES, Zone, ZoneMap};

/// UAV of a map: its position, the place below it, and its counts.
#[derive(Debug, Clone)]
pub struct SiteFacts {
    /// Name.
    pub id: String,
    /// East \[CRS units\].
    pub x: f64,
    /// North \[CRS units\].
    pub y: f64,
    /// Longitude and latitude \[deg\], if its position was given by these.
    pub lonlat: Option<[f64; 2]>,
    /// Height above the datum \[m\].
    pub height_amsl_m: f64,
    /// Height above the ground \[m\], if one is known there.
    pub height_agl_m: Option<f64>,
    /// Antenna of its own.
    pub antenna: Antenna,
    /// Place below it: a zone where zones are known, else `ground`, `rooftop` or `nodata`.
    pub placement: &'static str,
    /// Counts.
    pub tally: Tally,
    /// Counts by zone of the receivers, in the order of [`Zone::ALL`]. `None` if zones were not
    /// requested, or no building is known.
    pub zones: Option<[Tally; 4]>,
    /// Receivers that each move by one lattice step turns, if that was requested.
    pub(crate) stability: Option<StabilityFacts>,
    /// Dependence on the heights of buildings, if these may be off.
    pub(crate) uncertain: Option<UncertainFacts>,
}

impl SiteFacts {
    pub(crate) fn position(&self) -> Position {
        Position { x: self.x, y: self.y, lonlat: self.lonlat }
    }

    /// Returns the facts of a coverage, by zone if zones are known.
    pub(crate) fn of(site: &SiteCoverage, zones: Option<&ZoneMap>) -> Self {
        let place = &site.uav.station.place;
        let is_building = site.uav.placement == HoversOver::Rooftop;
        let zones_below = zones.filter(|_| site.uav.placement != HoversOver::Nodata);
        let zone = zones_below.and_then(|zones| zones.over(place.x, place.y, is_building)).map(Zone::name);
        SiteFacts {
            id: site.uav.id.clone(),
            x: place.x,
            y: place.y,
            lonlat: None,
            height_amsl_m: site.uav.height_amsl_m(),
            height_agl_m: site.uav.height_agl_m,
            antenna: site.uav.antenna,
            placement: zone.unwrap_or(site.uav.placement.name()),
            tally: site.tally,
            zones: zones
                .filter(|_| !site.mask.is_empty())
                .map(|zones| zone_tallies(zones, &site.mask).map(|tally| tally.of_uav(&site.uav))),
            stability: site.stability.as_ref().map(StabilityFacts::of),
            uncertain: UncertainFacts::of(site),
        }
    }

    /// Returns the height in words.
    pub(crate) fn height_words(&self) -> String {
        crate::words::height_words(self.height_agl_m, self.height_amsl_m)
    }

    pub(super) fn hovering(&self) -> Hovering {
        Hovering {
            id: self.id.clone(),
            position: self.position().into(),
            height_amsl_m: self.height_amsl_m,
            height_agl_m: self.height_agl_m,
            placement: self.placement,
        }
    }

    fn document(&self) -> SiteDocument {
        let band = |b: &crate::coverage::ElevationBand| BandDocument {
            from_deg: b.from_deg,
            to_deg: b.to_deg,
            receivers: b.receivers,
            los: b.los,
        };
        SiteDocument {
            hovering: self.hovering(),
            antenna: AntennaFacts::of(self.antenna),
            seen: (&self.tally).into(),
            zones: self.zones.as_ref().map(ZoneShares::of),
            stability: self.stability.as_ref().map(StabilityFacts::document),
            uncertain: self.uncertain,
            elevation_bands: self.tally.elevation_bands().iter().map(band).collect(),
        }
    }
}

/// Returns the counts of a mask by zone, in the order of [`Zone::ALL`].
pub(crate) fn zone_tallies(zones: &ZoneMap, mask: &[u8]) -> [Tally; 4] {
    let of_codes: [Tally; N_CODES] = Tally::by_group(mask, zones.codes());
    Zone::ALL.map(|zone| of_codes[usize::from(zone.code())])
}

/// Report of a map.
#[derive(Debug, Clone)]
pub(crate) struct MapReport {
    pub(crate) facts: RunFacts,
    /// Receivers, range, antenna, earth and method.
    pub(crate) sight: SightPlan,
    /// Errors of heights.
    pub(crate) heights: HeightErrorsPlan,
    /// The UAVs.
    pub(crate) sites: Vec<SiteFacts>,
    /// Counts of all UAVs together.
    pub(crate) union: Tally,
    /// Counts of all UAVs together by zone, in the order of [`Zone::ALL`].
    pub(crate) union_zones: Option<[Tally; 4]>,
    /// Footprints that were dropped before work started, in a scene of footprints.
    pub(crate) idle: Option<IdleFootprints>,
    /// Result of a tolerance, if one was given.
    pub(crate) tolerance: Option<ToleranceFacts>,
    /// Tile of the ground, if the map is one.
    pub(crate) tile: Option<TileFacts>,
    /// Span of time that it tells about, if it was asked about time.
    pub(crate) span: Option<Span>,
    /// Digest of the masks, see [`MaskDigest`].
    pub(crate) digest: String,
}

/// SHA-256 of the number of columns and of rows (u64, little endian), then per site its mask, north
/// row first.
#[derive(Debug, Clone)]
pub(crate) struct MaskDigest(Sha256);

impl MaskDigest {
    /// Returns the digest of a map without sites.
    pub(crate) fn new(grid: &GeoRef) -> Self {
        let mut hasher = Sha256::default();
        hasher.update((grid.n_cols() as u64).to_le_bytes());
        hasher.update((grid.n_rows() as u64).to_le_bytes());
        MaskDigest(hasher)
    }

    /// Adds the mask of the next site.
    pub(crate) fn add(&mut self, mask: &[u8]) {
        self.0.update(mask);
    }

    /// Returns `sha256:` and the hexadecimal digest.
    pub(crate) fn finish(self) -> String {
        digest_words(self.0)
    }

    /// Returns the digest of some masks.
    pub(crate) fn of<'a>(grid: &GeoRef, masks: impl Iterator<Item = &'a [u8]>) -> String {
        let mut digest = MaskDigest::new(grid);
        masks.for_each(|mask| digest.add(mask));
        digest.finish()
    }
}

impl MapReport {
    /// Schema of its documents.
    pub(crate) const SCHEMA: &'static str = "skyshed/map/1";

    /// Returns the report of one of the sites alone, with the digest of its mask.
    #[must_use]
    pub(crate) fn of_site(&self, site: &SiteFacts, digest: String) -> MapReport {
        MapReport { sites: vec![site.clone()], union: site.tally, union_zones: site.zones, digest, ..self.clone() }
    }

    /// Returns the document. Without `timing` it is the same for equal runs.
    pub(crate) fn document(&self, timing: Option<Timing>) -> Value {
        document_of(&self.as_document(Self::SCHEMA, timing))
    }

    /// Returns the timing for documents; `None` for a unit of work, so that equal units are equal
    /// to the last byte.
    pub(crate) fn timing(&self, timing: Timing) -> Option<Timing> {
        Some(timing).filter(|_| self.facts.unit.is_none())
    }

    /// Returns the document under a schema that adds to its own.
    pub(crate) fn as_document(&self, schema: &'static str, timing_s: Option<Timing>) -> MapDocument {
        let mut head = self.facts.head(schema);
        if self.tolerance.as_ref().is_some_and(|tolerance| !tolerance.taken.is_same()) {
            // The engine is exact, but the simplified scene is not.
            head.exact = Some(false);
        }
        MapDocument {
            head,
            tile: self.tile.clone(),
            span: self.span.map(Span::facts),
            tolerance: self.tolerance.as_ref().map(ToleranceFacts::document),
            footprints: self.idle.as_ref().map(IdleDocument::of),
            sight: self.sight.facts(),
            height_errors: self.heights.document(),
            sites: self.sites.iter().map(SiteFacts::document).collect(),
            union: UnionDocument { seen: (&self.union).into(), zones: self.union_zones.as_ref().map(ZoneShares::of) },
            timing_s,
            warnings: warnings_of(&self.facts.warnings),
            digest: self.digest.clone(),
        }
    }

    /// Returns the sites as GeoJSON points with their results, in the scene's CRS.
    pub(crate) fn geojson(&self) -> Value {
        let point = |s: &SiteFacts| feature(document_of(&s.document()), Some(("Point", vec![s.x, s.y].into())));
        let provenance = document_of(&MapProvenance {
            head: self.facts.head(Self::SCHEMA),
            warnings: warnings_of(&self.facts.warnings),
            digest: self.digest.clone(),
        });
        feature_collection(&self.facts.grid, provenance, self.sites.iter().map(point).collect())
    }

    /// Returns polygons of this run with `site`, `class`, `cells` and `area_m2`, in the grid's CRS.
    pub(crate) fn polygons(&self, polygons: &[CoveragePolygon]) -> Value {
        let of = |polygon: &CoveragePolygon| {
            let properties = PolygonFields {
                site: &polygon.site,
                class: polygon.class_name(),
                cells: polygon.n_cells,
                area_m2: polygon.area_m2,
            };
            feature(document_of(&properties), Some(("Polygon", document_of(&closed_rings(&polygon.rings)))))
        };
        feature_collection(&self.facts.grid, self.document(None), polygons.iter().map(of).collect())
    }
}

/// Coverage of one or many UAVs.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct MapDocument {
    #[serde(flatten)]
    head: Head,
    /// Tile of the ground that the counts belong to; left out for a whole map.
    #[serde(skip_serializing_if = "Option::is_none")]
    tile: Option<TileFacts>,
    /// Span of time that layers of time refer to; left out if none is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    span: Option<SpanFacts>,
    /// Result of the tolerance, if one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    tolerance: Option<ToleranceDocument>,
    /// Footprints that were dropped before work started, in a scene of footprints.
    #[serde(skip_serializing_if = "Option::is_none")]
    footprints: Option<IdleDocument>,
    #[serde(flatten)]
    sight: SightFacts,
    /// Errors of the heights of buildings, if any were given.
    #[serde(skip_serializing_if = "Option::is_none")]
    height_errors: Option<HeightErrorsDocument>,
    /// The UAVs.
    sites: Vec<SiteDocument>,
    /// Counts of the union: a receiver is in sight if at least one UAV sees it.
    union: UnionDocument,
    /// Seconds spent; left out of the documents in pictures and rasters.
    #[serde(skip_serializing_if = "Option::is_none")]
    timing_s: Option<Timing>,
    /// Warnings.
    warnings: Vec<WarningFacts>,
    /// SHA-256 of columns, rows (u64, little endian) and each site's mask, north row first.
    digest: String,
}

/// Description of the run in a file of features; the rest is in the features' properties.
#[derive(Serialize, JsonSchema)]
pub(crate) struct MapProvenance {
    #[serde(flatten)]
    head: Head,
    /// Warnings.
    warnings: Vec<WarningFacts>,
    /// SHA-256 of columns, rows (u64, little endian) and each site's mask, north row first.
    digest: String,
}

/// Document of a map, or the description of the run in a file of features.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, clippy::large_enum_variant, reason = "a type of its schema alone")]
pub(crate) enum AnyMapDocument {
    Map(MapDocument),
    Features(MapProvenance),
}

/// Properties of a polygon of coverage.
#[derive(Serialize)]
struct PolygonFields<'a> {
    site: &'a str,
    class: &'static str,
    cells: u64,
    area_m2: f64,
}

/// Position of a UAV, and the place below it.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(super) struct Hovering {
    /// Name of the UAV.
    id: String,
    #[serde(flatten)]
    position: PositionFields,
    /// Height above the datum [m].
    height_amsl_m: f64,
    /// Height above the ground [m]; null where none is known.
    height_agl_m: Option<f64>,
    /// Place below the UAV: a zone, or ground, rooftop or nodata where zones are not known.
    placement: &'static str,
}

/// UAV of a map.
#[derive(Debug, Serialize, JsonSchema)]
struct SiteDocument {
    #[serde(flatten)]
    hovering: Hovering,
    /// Limits of its own antenna; null without one. The run's antenna may set further limits.
    antenna: Option<AntennaFacts>,
    #[serde(flatten)]
    seen: Share,
    /// Shares by zone of the receivers; null if zones were not requested or are not known.
    zones: Option<ZoneShares>,
    /// Receivers that moves by one lattice step turn; with the layer `stability`.
    #[serde(skip_serializing_if = "Option::is_none")]
    stability: Option<StabilityDocument>,
    /// Dependence on the heights of buildings, if these may be off.
    #[serde(skip_serializing_if = "Option::is_none")]
    uncertain: Option<UncertainFacts>,
    /// Receivers by elevation angle of the UAV.
    elevation_bands: Vec<BandDocument>,
}

/// Receivers for which the UAV is between two elevation angles.
#[derive(Debug, Serialize, JsonSchema)]
struct BandDocument {
    /// Lower end of the band [deg].
    from_deg: i32,
    /// Upper end of the band [deg].
    to_deg: i32,
    /// Receivers in the band.
    receivers: u64,
    /// Receivers in line of sight.
    los: u64,
}

/// Counts of the union of all UAVs.
#[derive(Debug, Serialize, JsonSchema)]
struct UnionDocument {
    #[serde(flatten)]
    seen: Share,
    /// Shares by zone of the receivers; null if zones were not requested or are not known.
    zones: Option<ZoneShares>,
}

/// Receivers in range and in line of sight, by zone.
#[derive(Debug, Serialize, JsonSchema)]
struct ZoneShares {
    street: Share,
    crossroad: Share,
    courtyard: Share,
    rooftop: Share,
}

impl ZoneShares {
    fn of(tallies: &[Tally; 4]) -> Self {
        let of = |zone: Zone| {
            let tally = &tallies[usize::from(zone.code()) - 1];
            let share = Share::from(tally);
            Share { reason: share.reason.is_some().then(|| reason_in(zone, tally)), ..share }
        };
        ZoneShares {
            street: of(Zone::Street),
            crossroad: of(Zone::Crossroad),
            courtyard: of(Zone::Courtyard),
            rooftop: of(Zone::Rooftop),
        }
    }
}

/// Returns the reason why a zone has no P_LoS.
fn reason_in(zone: Zone, tally: &Tally) -> String {
    let name = zone.name();
    if tally.receivers > 0 {
        return tally.reason().into();
    }
    if tally.not_receivers > 0 {
        format!("no {name} cell in range holds a receiver")
    } else if tally.out_of_range > 0 {
        format!("no {name} cell in range")
    } else {
        format!("the scene has no {name} cell")
    }
}

/// Footprints that were dropped, because they can hide no receiver.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct IdleDocument {
    /// Footprints of the scene.
    total: u64,
    /// Footprints that were dropped.
    dropped: u64,
    /// Dropped because they are too low.
    too_low: u64,
    /// Dropped because they are too far from all links.
    out_of_reach: u64,
}

impl IdleDocument {
    pub(crate) fn of(idle: &IdleFootprints) -> Self {
        IdleDocument {
            total: idle.footprints,
            dropped: idle.dropped(),
            too_low: idle.too_low,
            out_of_reach: idle.out_of_reach,
        }
    }
}
