//! Parameters α, β and γ by tile, as a raster or a table.

use std::ffi::OsStr;
use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use skyshed_request::TiffLayout;

use crate::answer::{Rows, rows};
use crate::city::Footprint;
use crate::city_statistics::tiles::{BuiltUpTile, BuiltUpTiles, FEWEST_BUILDINGS, MOST_TILES, TileSize};
use crate::error::{Error, LimitError, RequestError, Result};
use crate::export::Batch;
use crate::formats::{Bands, GeoTiffImage, encode_geotiff};
use crate::height_field::HeightField;
use crate::quantity::{Frame, tidy};
use crate::raster::GeoRef;
use crate::render::{FirstBand, grouped, qgis_style};

/// Value of a tile without data.
const NODATA: f32 = -9999.0;

/// Tiles of a scene.
#[derive(Debug)]
pub(super) struct Tiles {
    tiles: BuiltUpTiles,
    edge_m: f64,
}

/// Returns the size of tiles over a grid, from their edge \[m\].
///
/// # Errors
/// E113 for an edge shorter than a cell, E502 for too many tiles.
pub(super) fn checked_size(edge_m: f64, grid: &GeoRef, word: &OsStr) -> Result<TileSize> {
    let meters_per_unit = grid.meters_per_unit();
    let cell_m = grid.cell_width().max(grid.cell_height()) * meters_per_unit;
    if edge_m < cell_m {
        return Err(Error::number("the edge of tiles", edge_m, format!("at least a cell of {} m", tidy(cell_m))));
    }
    let size = TileSize { edge: edge_m / meters_per_unit, meters_per_unit };
    if size.shape(grid).is_none() {
        return Err(LimitError::Tiles { word: word.display().to_string(), edge_m, most: MOST_TILES }.into());
    }
    Ok(size)
}

impl Tiles {
    /// Computes the tiles of footprints, or of the cells of a raster scene.
    ///
    /// # Errors
    /// E117 if no building is known.
    pub(super) fn of(
        field: &HeightField,
        footprints: Option<&(Vec<Footprint>, Frame)>,
        size: TileSize,
    ) -> Result<Tiles> {
        if field.is_surface_only() {
            return Err(RequestError::NoTiles.into());
        }
        let tiles = match footprints {
            Some((footprints, frame)) => BuiltUpTiles::of_footprints(footprints, *frame, field, size)?,
            None => BuiltUpTiles::of_cells(field, size),
        };
        let tiles = tiles.ok_or(Error::fault("a checked scene has tiles"))?;
        Ok(Tiles { tiles, edge_m: size.edge * size.meters_per_unit })
    }

    /// Returns the values of a tile: α, β, γ.
    fn values(&self, tile: &BuiltUpTile) -> [Option<f64>; 3] {
        [tile.built_up_ratio(), self.tiles.buildings_per_km2(tile), tile.height_scale()]
    }

    /// Adds the values of all tiles as a raster, with a style that shows the first band.
    pub(super) fn add_raster(&self, batch: &mut Batch, path: &Path, provenance: &Value) -> Result<()> {
        #[expect(clippy::cast_possible_truncation, reason = "bands are f32; counts are exact to 2^24")]
        let band = |value: &dyn Fn(&BuiltUpTile) -> Option<f64>| -> Vec<f32> {
            self.tiles.tiles().iter().map(|tile| value(tile).map_or(NODATA, |v| v as f32)).collect()
        };
        let [alpha, beta, gamma] = [0, 1, 2].map(|k| band(&|tile| self.values(tile)[k]));
        #[expect(clippy::cast_precision_loss, reason = "a city has fewer than 2^53 buildings")]
        let buildings = band(&|tile| tile.built_up_ratio().map(|_| tile.buildings() as f64));
        let raster = encode_geotiff(&GeoTiffImage {
            georef: self.tiles.georef(),
            bands: Bands::Float(vec![
                ("alpha".into(), &alpha),
                ("beta_per_km2".into(), &beta),
                ("gamma_m".into(), &gamma),
                ("buildings".into(), &buildings),
            ]),
            nodata: Some(f64::from(NODATA)),
            palette: None,
            metadata: &[("SKYSHED".into(), provenance.to_string())],
            layout: TiffLayout::Cog,
        })?;
        batch.add(path, &raster)?;
        Ok(batch.add(&path.with_extension("qml"), qgis_style(FirstBand::Values(&alpha)).as_bytes())?)
    }

    pub(super) fn table(&self) -> Rows {
        let georef = self.tiles.georef();
        let row = |(at, tile): (usize, &BuiltUpTile)| {
            let (row, col) = (at / georef.n_cols(), at % georef.n_cols());
            let (x, y) = georef.world_from_cell(row, col);
            TileRow { row, col, x, y, tile: self.facts(tile) }
        };
        rows(self.tiles.tiles().iter().enumerate().map(row))
    }

    fn facts(&self, tile: &BuiltUpTile) -> TileFacts {
        let [alpha, beta_per_km2, gamma_m] = self.values(tile);
        TileFacts {
            area_m2: self.tiles.area_m2(tile),
            buildings: tile.buildings(),
            alpha,
            beta_per_km2,
            gamma_m,
            reason: reason(tile),
        }
    }

    /// Returns the tiles for the document, with the values of all of them together.
    pub(super) fn document(&self) -> TilesDocument {
        TilesDocument {
            tile_m: self.edge_m,
            cols: self.tiles.georef().n_cols(),
            rows: self.tiles.georef().n_rows(),
            whole: self.facts(&self.tiles.whole()),
            buildings_outside: self.tiles.buildings_outside(),
        }
    }

    /// Returns a line of text.
    pub(super) fn text(&self) -> String {
        let georef = self.tiles.georef();
        let range = |k: usize, decimals: usize| {
            let values = || self.tiles.tiles().iter().filter_map(move |tile| self.values(tile)[k]);
            let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
            if low > high { "unknown".to_string() } else { format!("{low:.decimals$} to {high:.decimals$}") }
        };
        format!(
            "tiles      {} × {} of {} m: α {}, β {}/km², γ {} m\n",
            grouped(georef.n_cols() as u64),
            grouped(georef.n_rows() as u64),
            tidy(self.edge_m),
            range(0, 3),
            range(1, 0),
            range(2, 1)
        )
    }
}

/// Returns the reason for a missing value of a tile; `None` if no value is missing.
fn reason(tile: &BuiltUpTile) -> Option<&'static str> {
    if tile.built_up_ratio().is_none() {
        return Some("no open or built ground");
    }
    match (tile.height_scale(), tile.buildings() < FEWEST_BUILDINGS) {
        (Some(_), _) => None,
        (None, true) => Some("no γ of fewer than 2 buildings"),
        (None, false) => Some("no γ of buildings without a height"),
    }
}

/// Tiles, and the values of all of them together.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct TilesDocument {
    /// Edge of a tile [m].
    tile_m: f64,
    /// Columns of tiles.
    cols: usize,
    /// Rows of tiles.
    rows: usize,
    #[serde(flatten)]
    whole: TileFacts,
    /// Buildings outside all tiles.
    buildings_outside: u64,
}

/// A row of the table of tiles; a tile that the extent cuts holds the values of its part inside.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct TileRow {
    /// Row, counted from the north.
    row: usize,
    /// Column, counted from the west.
    col: usize,
    /// Middle of the tile, east [units of the scene's reference system].
    x: f64,
    /// Middle of the tile, north [units of the scene's reference system].
    y: f64,
    #[serde(flatten)]
    tile: TileFacts,
}

/// Values of a tile.
#[derive(Debug, Serialize, JsonSchema)]
struct TileFacts {
    /// Ground with data [m²].
    area_m2: f64,
    /// Buildings whose middle is on the tile.
    buildings: u64,
    /// Share of the ground that is built on.
    alpha: Option<f64>,
    /// Buildings per km².
    beta_per_km2: Option<f64>,
    /// Scale of the Rayleigh distribution of heights [m].
    gamma_m: Option<f64>,
    /// Reason for a missing value.
    reason: Option<&'static str>,
}
