//! Documents of `skyshed info`.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use super::output::OutputInfo;
use super::places::PlacesInfo;
use super::tiles::TilesDocument;
use crate::answer::{CommandFacts, Provenance, SourceFacts, WarningFacts};
use crate::city::{BuiltUp, FootprintFault, FootprintFaults, HeightSource, HeightSources, SourceShare};
use crate::crs::VerticalCrs;

/// Schema of all documents of `skyshed info`.
pub(super) const INFO_SCHEMA: &str = "skyshed/info/1";

/// Any of these documents, distinguished by `kind`. A document beside a picture has no `kind`.
#[derive(JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, clippy::large_enum_variant, reason = "a type of its schema alone")]
pub(crate) enum InfoDocument<'a> {
    Scene(SceneInfo),
    Places(PlacesInfo),
    Output(OutputInfo<'a>),
    Provenance(Provenance),
}

/// Provenance of tiles.
#[derive(Serialize, JsonSchema)]
pub(crate) struct TilesProvenance {
    #[serde(flatten)]
    pub(super) provenance: Provenance,
    /// Tiles, and the values of all of them together.
    pub(super) tiles: TilesDocument,
}

/// Description of a scene.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SceneInfo {
    /// Kind of document and its version.
    pub(super) schema: &'static str,
    /// Version of the program.
    pub(super) version: &'static str,
    #[serde(flatten)]
    pub(super) command: CommandFacts,
    /// footprints or raster.
    pub(super) kind: &'static str,
    /// Name in titles.
    pub(super) name: String,
    /// Format of its files; null for a generated city.
    pub(super) format: Option<&'static str>,
    /// Number of its files.
    pub(super) files: Option<usize>,
    /// Columns of cells.
    pub(super) cols: usize,
    /// Rows of cells.
    pub(super) rows: usize,
    /// Width and height of a cell [m].
    pub(super) cell_m: [f64; 2],
    /// Width and height of the grid [m].
    pub(super) size_m: [f64; 2],
    /// West, south, east, north [units of the reference system].
    pub(super) extent: [f64; 4],
    /// Reference system; null for local coordinates in meters.
    pub(super) crs: Option<String>,
    /// Name of the reference system.
    pub(super) crs_name: Option<String>,
    /// Vertical reference of the heights in raster files.
    pub(super) vertical: Vec<VerticalInfo>,
    /// Lowest and highest ground [m above the datum].
    pub(super) ground_m: Option<[f64; 2]>,
    /// Lowest and highest surface [m above the datum].
    pub(super) surface_m: Option<[f64; 2]>,
    /// Cells by kind.
    pub(super) cells: CellsInfo,
    /// Buildings; null unless the scene has footprints.
    pub(super) buildings: Option<usize>,
    /// Convex pieces that footprints are cut into.
    pub(super) convex_pieces: Option<usize>,
    /// Parameters of a generated city.
    pub(super) built_up: Option<GeneratedInfo>,
    /// Parameters estimated from the buildings.
    pub(super) estimated_built_up: Option<BuiltUpInfo>,
    /// Parameters by tile, where requested.
    pub(super) tiles: Option<TilesDocument>,
    /// Sources of the heights of footprints.
    pub(super) height_sources: Option<Vec<HeightSourceInfo>>,
    /// Numbers of footprints that were mended or left out, by fault.
    pub(super) faults: Option<FaultsInfo>,
    /// Files that were read.
    pub(super) sources: Vec<SourceFacts>,
    /// Warnings.
    pub(super) warnings: Vec<WarningFacts>,
}

/// Vertical reference of the heights of a file.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct VerticalInfo {
    /// Path of the file.
    pub(super) path: String,
    /// Code of the vertical system; null where it has none.
    pub(super) crs: Option<String>,
    /// Name of the vertical system.
    pub(super) name: Option<String>,
    /// Reason for a missing name.
    pub(super) reason: Option<&'static str>,
}

impl VerticalInfo {
    pub(super) fn of((path, vertical): &(PathBuf, Option<VerticalCrs>)) -> Self {
        VerticalInfo {
            path: path.display().to_string(),
            crs: vertical.as_ref().and_then(VerticalCrs::epsg).map(|code| format!("EPSG:{code}")),
            name: vertical.as_ref().map(|vertical| vertical.name().to_string()),
            reason: vertical.is_none().then_some("the file names no vertical datum"),
        }
    }
}

/// Cells by kind.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct CellsInfo {
    /// Open ground.
    pub(super) open: u64,
    /// Buildings.
    pub(super) building: u64,
    /// Cells without data.
    pub(super) nodata: u64,
}

/// Parameters of ITU-R P.1410.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct BuiltUpInfo {
    /// Share of the ground that is built on.
    pub(super) alpha: f64,
    /// Buildings per km².
    beta_per_km2: f64,
    /// Scale of the Rayleigh distribution of heights [m].
    pub(super) gamma_m: f64,
}

impl BuiltUpInfo {
    pub(super) fn of(b: &BuiltUp) -> Self {
        BuiltUpInfo { alpha: b.built_up_ratio, beta_per_km2: b.buildings_per_km2, gamma_m: b.height_scale }
    }
}

/// A generated city.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct GeneratedInfo {
    #[serde(flatten)]
    pub(super) parameters: BuiltUpInfo,
    /// Width of the buildings [m].
    pub(super) building_width_m: f64,
    /// Width of the streets [m].
    pub(super) street_width_m: f64,
    /// Seed of the city.
    pub(super) seed: u64,
}

/// Heights of footprints that come from one source.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct HeightSourceInfo {
    /// file, storeys, median, number, or nowhere (left out).
    pub(super) source: &'static str,
    /// Footprints.
    pub(super) footprints: usize,
    /// Share of the area of all footprints.
    pub(super) area_share: f64,
}

impl HeightSourceInfo {
    pub(super) fn of_all(heights: &HeightSources) -> Vec<Self> {
        let of = |source: HeightSource| {
            let SourceShare { n, area_share } = heights.from(source);
            HeightSourceInfo { source: source.word(), footprints: n, area_share }
        };
        HeightSource::ALL.map(of).into_iter().filter(|of| of.footprints > 0).collect()
    }
}

/// Footprints by fault.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct FaultsInfo {
    /// Features that are no areas.
    pub(super) not_areas: usize,
    /// Outlines that were repaired.
    pub(super) repaired: usize,
    /// Rings that were closed.
    pub(super) unclosed: usize,
    /// Outlines without area.
    pub(super) degenerate: usize,
    /// Holes outside their shell.
    pub(super) stray_holes: usize,
    /// Footprints without a usable height.
    pub(super) missing_height: usize,
    /// Footprints with a negative height.
    pub(super) negative_height: usize,
    /// Heights written with a decimal comma.
    pub(super) decimal_comma: usize,
    /// Footprints without ground below.
    pub(super) no_ground: usize,
    /// Footprints too far from the others.
    pub(super) too_far: usize,
    /// Footprints with a height from the number of storeys.
    pub(super) from_levels: usize,
    /// Features that are no buildings.
    pub(super) not_buildings: usize,
    /// Parts that float above the ground.
    pub(super) floating: usize,
    /// Buildings that are drawn by their parts.
    pub(super) parts: usize,
    /// Footprints with a top at or below the ground.
    pub(super) below_ground: usize,
}

impl FaultsInfo {
    pub(super) fn of(f: FootprintFaults) -> Self {
        FaultsInfo {
            not_areas: f.of(FootprintFault::NotAnArea),
            repaired: f.of(FootprintFault::SelfIntersection),
            unclosed: f.of(FootprintFault::UnclosedRing),
            degenerate: f.of(FootprintFault::TooSmall),
            stray_holes: f.of(FootprintFault::StrayHole),
            missing_height: f.of(FootprintFault::MissingHeight),
            negative_height: f.of(FootprintFault::NegativeHeight),
            decimal_comma: f.of(FootprintFault::DecimalComma),
            no_ground: f.of(FootprintFault::NoGround),
            too_far: f.of(FootprintFault::TooFar),
            from_levels: f.of(FootprintFault::HeightFromLevels),
            not_buildings: f.of(FootprintFault::NotABuilding),
            floating: f.of(FootprintFault::Floating),
            parts: f.of(FootprintFault::Part),
            below_ground: f.of(FootprintFault::BelowGround),
        }
    }
}
