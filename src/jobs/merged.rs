//! Merged results of all units of work: a table of the UAVs, a mosaic of the tiles, a document.

use std::collections::HashMap;
use std::path::Path;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use skyshed_request::{Layer, TiffLayout};

use super::Jobs;
use super::stac::item;
use crate::answer::{
    Answer, CommandFacts, Head, Rows, RunFacts, Share, Spent, WarningFacts, columns_of, document_of, rows, warnings_of,
};
use crate::city::GivenSite;
use crate::coverage::Tally;
use crate::error::{CheckError, RequestError, Result, Warning};
use crate::export::{Batch, Format, MosaicTile, encode_parquet, vrt};
use crate::map::{Part, style_of};
use crate::picture::Look;
use crate::quantity::{counted, share};
use crate::words::pretty;

/// Merged results of the units of a run, all of them done.
#[derive(Debug)]
pub(crate) struct Merged {
    facts: RunFacts,
    layers: Vec<Layer>,
    /// `true` if rasters are optimized for the cloud.
    is_cog: bool,
    rows: Vec<MergedRow>,
    n_units: usize,
    /// Tiles, and their union; `None` if the units are UAVs.
    tiles: Option<Tiles>,
    /// Time of the latest file, in seconds since 1970.
    last_written: u64,
}

#[derive(Debug)]
struct Tiles {
    cells_per_side: usize,
    union: Tally,
    /// Tiles that are GeoTIFF files.
    rasters: Vec<MosaicTile>,
}

/// UAV in the table of all.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct MergedRow {
    /// Name of the UAV.
    site: String,
    /// East [units of the reference system].
    x: f64,
    /// North [units of the reference system].
    y: f64,
    /// Height above the datum [m]; empty for a UAV without a tile in range.
    height_amsl_m: Option<f64>,
    /// Height above the ground [m]; empty where none is known.
    height_agl_m: Option<f64>,
    /// Place below the UAV.
    placement: Option<String>,
    /// Receivers in range.
    receivers: u64,
    /// Receivers in line of sight.
    los: u64,
    /// Share of receivers in line of sight; empty without receivers, and for a UAV over no data.
    p_los: Option<f64>,
    #[serde(skip)]
    is_over_nodata: bool,
    /// Number of tiles with cells in its range, if the units are tiles.
    #[serde(skip_serializing_if = "Option::is_none")]
    tiles: Option<u64>,
    /// Digest of the mask, if the units are UAVs.
    #[serde(skip_serializing_if = "Option::is_none")]
    digest: Option<String>,
}

/// Merged results of all units of a run.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct MergeDocument {
    #[serde(flatten)]
    head: Head,
    /// Kind of the units: sites or tiles.
    units_are: &'static str,
    /// Number of units.
    units: usize,
    /// Cells along a side of a tile; null if the units are sites.
    cells_per_side: Option<usize>,
    /// Layers of the files.
    layers: Vec<&'static str>,
    /// Number of UAVs.
    sites: usize,
    /// Union over all tiles; null if the units are sites, whose masks overlap.
    union: Option<Share>,
    /// Warnings.
    warnings: Vec<WarningFacts>,
}

/// Returns a number of a document.
fn number(of: &Value, name: &str) -> Option<f64> {
    of.get(name)?.as_f64()
}

fn count(of: &Value, name: &str) -> u64 {
    of.get(name).and_then(Value::as_u64).unwrap_or(0)
}

fn text(of: &Value, name: &str) -> Option<String> {
    Some(of.get(name)?.as_str()?.to_string())
}

impl MergedRow {
    /// Returns the row of a UAV in the document of a map.
    fn of(site: &Value, digest: Option<String>) -> Option<MergedRow> {
        let (receivers, los) = (count(site, "receivers"), count(site, "los"));
        Some(MergedRow {
            site: text(site, "id")?,
            x: number(site, "x")?,
            y: number(site, "y")?,
            height_amsl_m: number(site, "height_amsl_m"),
            height_agl_m: number(site, "height_agl_m"),
            placement: text(site, "placement"),
            receivers,
            los,
            p_los: number(site, "p_los"),
            is_over_nodata: receivers > 0 && number(site, "p_los").is_none(),
            tiles: None,
            digest,
        })
    }

    /// Adds the UAV's counts in a tile.
    fn add(&mut self, part: MergedRow) {
        self.receivers += part.receivers;
        self.los += part.los;
        self.is_over_nodata |= part.is_over_nodata;
        self.p_los = share(self.los, self.receivers).filter(|_| !self.is_over_nodata);
        self.tiles = self.tiles.map(|n| n + 1);
        (self.height_amsl_m, self.height_agl_m) = (part.height_amsl_m, part.height_agl_m);
        self.placement = part.placement;
    }
}

/// Facts that are read of a unit.
struct OfUnit {
    rows: Vec<MergedRow>,
    union: Tally,
    written_at: u64,
}

impl OfUnit {
    fn of(document: &Value, written_at: u64) -> OfUnit {
        let sites = document.get("sites").and_then(Value::as_array);
        let digest = || text(document, "digest");
        let rows = sites.into_iter().flatten().filter_map(|site| MergedRow::of(site, digest())).collect();
        let of_union = document.get("union").unwrap_or(&Value::Null);
        let (receivers, los) = (count(of_union, "receivers"), count(of_union, "los"));
        let mut union = Tally::of_receivers(receivers, los);
        union.is_over_nodata = receivers > 0 && number(of_union, "p_los").is_none();
        OfUnit { rows, union, written_at }
    }
}

/// Sum of the units that were read so far.
#[derive(Default)]
struct Sum {
    rows: Vec<MergedRow>,
    /// Row of each UAV, if the units are tiles.
    place: HashMap<String, usize>,
    tiles: Option<Tiles>,
    last_written: u64,
}

impl Sum {
    /// Returns the sum of no tiles yet. Some of the UAVs may have no tile in range.
    fn of_tiles(cells_per_side: usize, sites: &[GivenSite]) -> Sum {
        let row = |given: &GivenSite| MergedRow {
            site: given.id.clone(),
            x: given.x,
            y: given.y,
            height_amsl_m: None,
            height_agl_m: None,
            placement: None,
            receivers: 0,
            los: 0,
            p_los: None,
            is_over_nodata: false,
            tiles: Some(0),
            digest: None,
        };
        Sum {
            rows: sites.iter().map(row).collect(),
            place: sites.iter().enumerate().map(|(k, site)| (site.id.clone(), k)).collect(),
            tiles: Some(Tiles { cells_per_side, union: Tally::default(), rasters: Vec::new() }),
            last_written: 0,
        }
    }

    fn add(&mut self, unit: OfUnit) {
        self.last_written = self.last_written.max(unit.written_at);
        let Some(tiles) = &mut self.tiles else {
            self.rows.extend(unit.rows.into_iter().take(1));
            return;
        };
        tiles.union = tiles.union.plus(&unit.union);
        for row in unit.rows {
            if let Some(k) = self.place.get(&row.site) {
                self.rows[*k].add(row);
            }
        }
    }
}

impl Jobs<'_> {
    /// Merges the results of all units.
    ///
    /// Cost: one document is read for each unit.
    ///
    /// # Errors
    /// E116 for a part of the units; E603 unless all of them are done.
    pub(crate) fn merged(&self, command: CommandFacts) -> Result<Merged> {
        // A mosaic of some tiles would have holes that look like nodata.
        if self.job.uavs.shard.is_some() || !self.job.tiles.only.is_empty() {
            return Err(RequestError::PartOfUnits.into());
        }
        self.status(command.clone()).check()?;
        let read = |part: &Part| {
            let unit = self.runs.unit(&self.units, part);
            let document = unit.document().ok_or_else(|| CheckError::NoDocument(part.name()))?;
            Ok(OfUnit::of(&document, unit.written_at()))
        };
        let mut sum = match self.units.parts.first() {
            Some(Part::Tile(first)) => Sum::of_tiles(first.cells_per_side, &self.units.uavs.sites),
            _ => Sum::default(),
        };
        // Units are read in groups, so that no more than their rows stays in memory.
        const AT_ONCE: usize = 1024;
        for parts in self.units.parts.chunks(AT_ONCE) {
            let found: Vec<OfUnit> = parts.par_iter().map(read).collect::<Result<_>>()?;
            found.into_iter().for_each(|unit| sum.add(unit));
        }
        if let Some(tiles) = &mut sum.tiles {
            let raster = |part: &Part| {
                let Part::Tile(tile) = part else { return None };
                let files = self.runs.unit(&self.units, part).job.outputs;
                let is_raster = |path: &std::path::PathBuf| Format::of(path).is_ok_and(|f| f == Format::GeoTiff);
                Some((files.into_iter().find(is_raster)?, tile.window))
            };
            tiles.rasters = self.units.parts.iter().filter_map(raster).collect();
        }
        let Sum { rows, tiles, last_written, .. } = sum;
        let is_cog = self.job.save.forms.tif_layout.unwrap_or_default() == TiffLayout::Cog;
        let (n_units, layers) = (self.units.parts.len(), self.job.plan.layers.clone());
        Ok(Merged { facts: self.facts(command), layers, is_cog, rows, n_units, tiles, last_written })
    }
}

impl Merged {
    /// Returns the tiles that are rasters.
    fn rasters(&self, path: &Path) -> Result<&[MosaicTile]> {
        let rasters = self.tiles.as_ref().map_or(&[][..], |tiles| &tiles.rasters);
        if rasters.is_empty() {
            return Err(RequestError::NoTilesToJoin(path.display().to_string()).into());
        }
        Ok(rasters)
    }
}

impl Answer for Merged {
    fn document(&self, _: Option<Spent>) -> Value {
        document_of(&MergeDocument {
            head: self.facts.head("skyshed/jobs-merge/1"),
            units_are: if self.tiles.is_some() { "tiles" } else { "sites" },
            units: self.n_units,
            cells_per_side: self.tiles.as_ref().map(|tiles| tiles.cells_per_side),
            layers: self.layers.iter().map(|layer| layer.name()).collect(),
            sites: self.rows.len(),
            union: self.tiles.as_ref().map(|tiles| Share::from(&tiles.union)),
            warnings: warnings_of(&self.facts.warnings),
        })
    }

    fn table(&self) -> Rows {
        rows(self.rows.iter().cloned())
    }

    fn warnings(&self) -> &[Warning] {
        &self.facts.warnings
    }

    fn notes(&self, _: Spent) -> Vec<String> {
        let units = if self.tiles.is_some() { ("tile", "tiles") } else { ("UAV", "UAVs") };
        vec![format!("{} merged", counted(self.n_units as u64, units.0, units.1))]
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, _: &Look) -> Result<()> {
        let bytes = match format {
            Format::Parquet => {
                encode_parquet(&columns_of(self.rows.iter().cloned()), &self.document(None).to_string())?
            }
            Format::Vrt => {
                let of_list = (self.layers.as_slice(), self.rows.len());
                if let Some(style) = style_of(&self.layers, self.rows.len(), &[], None) {
                    batch.add(&path.with_extension("qml"), style.as_bytes())?;
                }
                vrt(path, &self.facts.grid, self.rasters(path)?, of_list)?.into_bytes()
            }
            _ => {
                let tiles = (self.rasters(path)?, self.layers.as_slice(), self.is_cog);
                pretty(&item(path, &self.facts.grid, tiles, self.last_written, &self.document(None))?).into_bytes()
            }
        };
        Ok(batch.add(path, &bytes)?)
    }
}
