//! `skyshed info SCENE --tile M`: α, β and γ by tile as a raster, a table or heat maps.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::city::Footprint;
use crate::cli::args::InfoArgs;
use crate::cli::interrupt;
use crate::error::{Error, Result};
use crate::export::{Batch, Format, encode_table, with_suffix};
use crate::formats::{Bands, GeoTiffImage, TiffLayout, encode_geotiff};
use crate::height_field::HeightField;
use crate::los_probability::tiles::{BuiltUpTile, BuiltUpTiles, FEWEST_BUILDINGS, MOST_TILES, TileSize};
use crate::quantity::{Frame, tidy};
use crate::raster::GeoRef;
use crate::render::grouped;
use crate::words::pretty;

/// What tiles hold where a value does not exist.
const NODATA: f32 = -9999.0;

/// The tiles that were asked for.
pub(super) struct Tiles {
    tiles: BuiltUpTiles,
    edge_m: f64,
}

impl Tiles {
    /// Checks the size of tiles over a grid.
    ///
    /// # Errors
    /// E113 for a size that is not above 0 or below that of a cell, E502 for too many tiles.
    pub(super) fn size(args: &InfoArgs, grid: &GeoRef, meters_per_unit: f64) -> Result<Option<TileSize>> {
        let Some(edge_m) = args.tile else { return Ok(None) };
        let cell_m = grid.cell_width().max(grid.cell_height()) * meters_per_unit;
        if edge_m < cell_m {
            let text = format!("`--tile` is `{edge_m}`, wanted at least a cell of {} m", tidy(cell_m));
            return Err(Error::usage(113, text));
        }
        let size = TileSize { edge: edge_m / meters_per_unit, meters_per_unit };
        if size.shape(grid).is_none() {
            let text = format!("cannot cut {} into tiles of {edge_m} m: more than {MOST_TILES}", args.scene.scene);
            return Err(Error::limit(502, text).with_hint("choose a larger `--tile`"));
        }
        Ok(Some(size))
    }

    /// The tiles of footprints, or else of the cells of a raster scene.
    ///
    /// # Errors
    /// E117 if no building is known.
    pub(super) fn of(
        field: &HeightField,
        footprints: Option<&(Vec<Footprint>, Frame)>,
        size: TileSize,
    ) -> Result<Tiles> {
        if field.is_surface_only() {
            return Err(Error::usage(117, "`--tile` with a surface model alone: no building is known")
                .with_hint("give `--terrain FILE` or `--ground Z`"));
        }
        let tiles = match footprints {
            Some((footprints, frame)) => BuiltUpTiles::of_footprints(footprints, *frame, field, size),
            None => BuiltUpTiles::of_cells(field, size),
        };
        let tiles = tiles.ok_or_else(|| Error::internal(901, "a checked scene has tiles"))?;
        Ok(Tiles { tiles, edge_m: size.edge * size.meters_per_unit })
    }

    /// Adds the files among the outputs that hold tiles.
    pub(super) fn add(&self, batch: &mut Batch, outputs: &[(PathBuf, Format)], provenance: &Value) -> Result<()> {
        for (path, format) in outputs {
            interrupt::check()?;
            match format {
                Format::GeoTiff => batch.add(path, &self.raster(provenance)?)?,
                Format::Csv => {
                    batch.add(path, &encode_table(&self.table())?)?;
                    batch.add(&with_suffix(path, ".json"), pretty(provenance).as_bytes())?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The values of a tile: α, β, γ.
    fn values(&self, tile: &BuiltUpTile) -> [Option<f64>; 3] {
        [tile.built_up_ratio(), self.tiles.buildings_per_km2(tile), tile.height_scale()]
    }

    fn raster(&self, provenance: &Value) -> Result<Vec<u8>> {
        #[expect(clippy::cast_possible_truncation, reason = "bands are f32; counts are exact to 2^24")]
        let band = |value: &dyn Fn(&BuiltUpTile) -> Option<f64>| -> Vec<f32> {
            self.tiles.tiles().iter().map(|tile| value(tile).map_or(NODATA, |v| v as f32)).collect()
        };
        let [alpha, beta, gamma] = [0, 1, 2].map(|k| band(&|tile| self.values(tile)[k]));
        #[expect(clippy::cast_precision_loss, reason = "a city has fewer than 2^53 buildings")]
        let buildings = band(&|tile| tile.built_up_ratio().map(|_| tile.buildings() as f64));
        Ok(encode_geotiff(&GeoTiffImage {
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
        })?)
    }

    /// A row for each tile; x and y are its middle, also where the extent cuts it.
    fn table(&self) -> Vec<Vec<String>> {
        let header = ["row", "col", "x", "y", "area_m2", "buildings", "alpha", "beta_per_km2", "gamma_m", "reason"];
        let georef = self.tiles.georef();
        let row = |(at, tile): (usize, &BuiltUpTile)| {
            let (row, col) = (at / georef.n_cols(), at % georef.n_cols());
            let (x, y) = georef.world_from_cell(row, col);
            let numbers = [x, y, self.tiles.area_m2(tile)].map(|v| v.to_string());
            let values = self.values(tile).map(|v| v.map_or(String::new(), |v| v.to_string()));
            let reason = reason(tile).unwrap_or_default().to_string();
            [row.to_string(), col.to_string()]
                .into_iter()
                .chain(numbers)
                .chain([tile.buildings().to_string()])
                .chain(values)
                .chain([reason])
                .collect()
        };
        let rows = self.tiles.tiles().iter().enumerate().map(row);
        std::iter::once(header.map(str::to_string).to_vec()).chain(rows).collect()
    }

    /// What the document says of the tiles, all of them together.
    pub(super) fn json(&self) -> Value {
        let (georef, whole) = (self.tiles.georef(), self.tiles.whole());
        let [alpha, beta, gamma] = self.values(&whole);
        json!({
            "tile_m": self.edge_m,
            "cols": georef.n_cols(),
            "rows": georef.n_rows(),
            "area_m2": self.tiles.area_m2(&whole),
            "buildings": whole.buildings(),
            "buildings_outside": self.tiles.buildings_outside(),
            "alpha": alpha,
            "beta_per_km2": beta,
            "gamma_m": gamma,
            "reason": reason(&whole),
        })
    }

    /// A line for reading.
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

/// Why a tile lacks a value, if it does.
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

/// Refuses what tiles have no room beside, or no meaning without.
///
/// # Errors
/// E116.
pub(super) fn check(args: &InfoArgs, outputs: &[(PathBuf, Format)]) -> Result<()> {
    if args.tile.is_none() {
        return Ok(());
    }
    let refuse = |path: &Path| {
        let text = format!("cannot write {}: tiles are a raster or a table", path.display());
        Err(Error::usage(116, text).with_hint("-o tiles.tif -o tiles.csv"))
    };
    let holds_tiles = |f: &Format| matches!(f, Format::GeoTiff | Format::Csv | Format::Json | Format::Stdout);
    outputs.iter().find(|(_, format)| !holds_tiles(format)).map_or(Ok(()), |(path, _)| refuse(path))
}
