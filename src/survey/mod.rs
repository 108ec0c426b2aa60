//! Description of a scene: size, reference system, heights, faults of its files, α, β and γ, also
//! by tile.

mod document;
mod output;
mod places;
mod tiles;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde_json::Value;

use document::{
    BuiltUpInfo, CellsInfo, FaultsInfo, GeneratedInfo, HeightSourceInfo, INFO_SCHEMA, SceneInfo, VerticalInfo,
};
pub(crate) use document::{InfoDocument, TilesProvenance};
use output::Output;
use places::Places;
pub(crate) use tiles::TileRow;
use tiles::Tiles;

use crate::answer::{Answer, CommandFacts, Rows, RunFacts, SourceFacts, Spent, document_of, warnings_of};
use crate::city::{BuiltUp, Footprint, FootprintFaults, HeightSource, Solids};
use crate::crs::VerticalCrs;
use crate::error::{Result, Warning};
use crate::export::{Batch, Format};
use crate::height_field::CellCounts;
use crate::memory::Needs;
use crate::picture::Look;
use crate::quantity::{Frame, meters, tidy};
use crate::raster::Crs;
use crate::read::vertical_of;
use crate::render::{grouped, percent};
use crate::scene::{Scene, SceneReader, built_up, files_of, has_heights_above_datum};
use crate::words::{capitalized, version};
use skyshed_io::FileFormat;

/// Output formats of a description without tiles.
pub(crate) const FORMATS: [Format; 2] = [Format::Json, Format::Stdout];
/// Output formats of a description with tiles.
pub(crate) const TILE_FORMATS: [Format; 4] = [Format::GeoTiff, Format::Csv, Format::Json, Format::Stdout];

/// Returns the options that describe a file of UAVs, a track or an output of this program; `None` for
/// a scene, which can use all.
pub(crate) fn options_of_other(path: &Path) -> Option<&'static [&'static str]> {
    match (Output::is_one(path), Places::is_one(path)) {
        (true, _) => Some(&["scene"]),
        (false, true) => Some(&["scene", "crs"]),
        (false, false) => None,
    }
}

/// Describes a file: an output of this program, UAVs, a track, or a scene. `tile_m` is the edge of
/// tiles of a scene \[m\].
///
/// # Errors
/// As [`Survey::open`].
pub(crate) fn facts_of(
    options: &SceneReader,
    word: &OsStr,
    tile_m: Option<f64>,
    command: &CommandFacts,
) -> Result<Box<dyn Answer + Send + Sync>> {
    let path = Path::new(word);
    if let Some(output) = Output::of(path, command) {
        return Ok(Box::new(output));
    }
    if let Some(places) = Places::of(path, options.crs()?, command)? {
        return Ok(Box::new(places));
    }
    Ok(Box::new(Survey::open(options, word, tile_m, command.clone())?))
}

/// Description of a scene.
#[derive(Debug)]
pub(crate) struct Survey {
    scene: Scene,
    facts: RunFacts,
    counts: CellCounts,
    /// Faults of footprints; `None` for a raster.
    faults: Option<FootprintFaults>,
    n_buildings: usize,
    estimate: Option<BuiltUp>,
    tiles: Option<Tiles>,
    /// Format and number of the files of the scene.
    files: Option<(FileFormat, usize)>,
    /// Raster files that hold heights, with the vertical reference of each.
    vertical: Vec<(PathBuf, Option<VerticalCrs>)>,
}

impl Survey {
    /// Reads a scene and describes it; `tile_m` is the edge of tiles \[m\]. Faults of files are
    /// reported instead of refused where a scene can be built without the faulty part.
    ///
    /// # Errors
    /// As [`SceneReader::open`]; E113, E117 or E502 for impossible tiles.
    pub(crate) fn open(
        options: &SceneReader,
        word: &OsStr,
        tile_m: Option<f64>,
        command: CommandFacts,
    ) -> Result<Survey> {
        let (start, mut warnings) = (Instant::now(), Vec::new());
        let reader = SceneReader { tells_faults: true, within: options.options.extent, ..options.clone() };
        let city = reader.read(word, &mut warnings)?;
        let size = tile_m.map(|edge| tiles::checked_size(edge, &city.grid, word)).transpose()?;
        let (heights, n_buildings) = (city.solids.building_heights(), city.solids.n_buildings());
        let (faults, footprints): (_, Option<(Vec<Footprint>, Frame)>) = match &city.solids {
            Solids::Vector { footprints, faults, frame, .. } => {
                (Some(*faults), size.map(|_| (footprints.clone(), *frame)))
            }
            Solids::Raster { .. } => (None, None),
        };
        let scene = Scene::built(options, (word, city), warnings, start)?;
        let counts = scene.field.cell_counts();
        size.map_or(Ok(()), |_| Needs::TILES.check(&scene))?;
        let tiles = size.map(|size| Tiles::of(&scene.field, footprints.as_ref(), size)).transpose()?;
        let grid = scene.grid();
        #[expect(clippy::cast_precision_loss, reason = "counts of cells are far below 2^53")]
        let (n_known, n_built) = ((counts.building + counts.open) as f64, counts.building as f64);
        let cell_m = grid.meters_per_unit();
        let area_km2 = n_known * grid.cell_width() * grid.cell_height() * cell_m * cell_m / 1e6;
        let estimate = BuiltUp::estimated(n_built / n_known, &scene.field.heights_in_data(&heights), area_km2);
        let rasters =
            std::iter::once(PathBuf::from(word)).filter(|path| has_heights_above_datum(path) && path.is_file());
        let vertical = rasters
            .chain(options.options.terrain.clone().map(Into::into))
            .map(|path| (path.clone(), vertical_of(&path)))
            .collect();
        let facts = RunFacts { command, ..scene.facts(None) };
        let files = if built_up(word).is_some() { None } else { files_of(Path::new(word)) };
        Ok(Survey { scene, facts, counts, faults, n_buildings, estimate, tiles, vertical, files })
    }

    fn kind(&self) -> &'static str {
        if self.faults.is_some() { "footprints" } else { "raster" }
    }

    /// Returns the edge lengths of the grid \[m\].
    fn size_m(&self) -> [f64; 2] {
        let (grid, unit) = (self.scene.grid(), self.facts.unit_m());
        [(grid.x_max() - grid.x_min()) * unit, (grid.y_max() - grid.y_min()) * unit]
    }

    fn percent(&self, n: u64) -> String {
        percent(n, self.scene.grid().n_cells() as u64)
    }

    fn text_of_grid(&self) -> String {
        let (grid, counts) = (self.scene.field.grid(), &self.counts);
        let unit = grid.meters_per_unit();
        let [width, height] = self.size_m();
        let range = |r: Option<(i32, i32)>| {
            r.map_or("unknown".to_string(), |(a, b)| {
                format!("{} to {} m above the datum", tidy(meters(a)), tidy(meters(b)))
            })
        };
        let crs = grid.crs().map_or("none: local meters".to_string(), |c| format!("{}, {}", c.label(), c.name()));
        let mut text = format!("{} ({})\n", capitalized(&self.scene.name), self.kind());
        text += &format!(
            "grid       {} × {} cells of {} × {} m, {} × {} m\n",
            grid.n_cols(),
            grid.n_rows(),
            tidy(grid.cell_width() * unit),
            tidy(grid.cell_height() * unit),
            tidy(width),
            tidy(height)
        );
        text += &format!(
            "extent     x {} to {}, y {} to {}\n",
            tidy(grid.x_min()),
            tidy(grid.x_max()),
            tidy(grid.y_min()),
            tidy(grid.y_max())
        );
        text += &format!("CRS        {crs}\n");
        if let Some((format, n_files)) = self.files {
            let of = if n_files > 1 { format!(", {} files", grouped(n_files as u64)) } else { String::new() };
            text += &format!("format     {}{of}\n", format.noun());
        }
        for (path, vertical) in &self.vertical {
            let system = vertical.as_ref().map_or("a datum that it does not name".to_string(), VerticalCrs::in_words);
            text += &format!("heights    of {} above {system}\n", path.display());
        }
        text += &format!("ground     {}\n", range(counts.ground));
        text += &format!("surface    {}\n", range(counts.surface));
        text += &format!(
            "cells      {} open ground ({}), {} building ({}), {} nodata\n",
            grouped(counts.open),
            self.percent(counts.open),
            grouped(counts.building),
            self.percent(counts.building),
            grouped(counts.void)
        );
        text
    }

    fn text_of_buildings(&self) -> String {
        let mut text = String::new();
        if let Some(pieces) = self.scene.field.prisms().map(|p| p.pieces().len()) {
            text += &format!(
                "buildings  {}, cut into {} convex pieces\n",
                grouped(self.n_buildings as u64),
                grouped(pieces as u64)
            );
        }
        if let Some(heights) = self.scene.heights.as_ref().filter(|heights| heights.n() > 0) {
            text += &format!("heights    {}\n", heights.told(&HeightSource::ALL));
        }
        if let Some(b) = self.scene.built_up {
            text += &format!(
                "built-up   {b}: buildings {} m wide, streets {} m wide\n",
                tidy(b.building_width()),
                tidy(b.street_width())
            );
        }
        if let Some(b) = self.estimate {
            text += &format!(
                "estimated  α = {:.3}, β = {:.0}/km², γ = {:.1} m, over the ground with data\n",
                b.built_up_ratio, b.buildings_per_km2, b.height_scale
            );
        }
        text + &self.tiles.as_ref().map(Tiles::text).unwrap_or_default()
    }
}

impl Answer for Survey {
    fn is_in_words(&self) -> bool {
        true
    }

    fn document(&self, _: Option<Spent>) -> Value {
        let (grid, unit, counts) = (self.scene.grid(), self.facts.unit_m(), &self.counts);
        let range = |range: Option<(i32, i32)>| range.map(|(low, high)| [meters(low), meters(high)]);
        document_of(&SceneInfo {
            schema: INFO_SCHEMA,
            version: version(),
            command: self.facts.command.clone(),
            kind: self.kind(),
            name: self.scene.name.clone(),
            format: self.files.map(|(format, _)| format.noun()),
            files: self.files.map(|(_, n)| n),
            cols: grid.n_cols(),
            rows: grid.n_rows(),
            cell_m: [grid.cell_width() * unit, grid.cell_height() * unit],
            size_m: self.size_m(),
            extent: [grid.x_min(), grid.y_min(), grid.x_max(), grid.y_max()],
            crs: grid.crs().map(Crs::label),
            crs_name: grid.crs().map(|crs| crs.name().to_string()),
            vertical: self.vertical.iter().map(VerticalInfo::of).collect(),
            ground_m: range(counts.ground),
            surface_m: range(counts.surface),
            cells: CellsInfo { open: counts.open, building: counts.building, nodata: counts.void },
            buildings: self.faults.map(|_| self.n_buildings),
            convex_pieces: self.scene.field.prisms().map(|p| p.pieces().len()),
            built_up: self.scene.built_up.map(|b| GeneratedInfo {
                parameters: BuiltUpInfo::of(&b),
                building_width_m: b.building_width(),
                street_width_m: b.street_width(),
                seed: self.scene.seed,
            }),
            estimated_built_up: self.estimate.as_ref().map(BuiltUpInfo::of),
            tiles: self.tiles.as_ref().map(Tiles::document),
            height_sources: self.scene.heights.as_ref().map(HeightSourceInfo::of_all),
            faults: self.faults.map(FaultsInfo::of),
            sources: SourceFacts::of(&self.facts.sources),
            warnings: warnings_of(&self.facts.warnings),
        })
    }

    fn provenance(&self) -> Value {
        match &self.tiles {
            Some(tiles) => document_of(&TilesProvenance {
                provenance: self.facts.provenance("skyshed/tiles/1"),
                tiles: tiles.document(),
            }),
            None => document_of(&self.facts.provenance(INFO_SCHEMA)),
        }
    }

    fn table(&self) -> Rows {
        self.tiles.as_ref().map(Tiles::table).unwrap_or_default()
    }

    fn warnings(&self) -> &[Warning] {
        &self.facts.warnings
    }

    fn text(&self, _: &Look) -> Result<String> {
        let mut text = self.text_of_grid() + &self.text_of_buildings();
        if self.scene.field.is_surface_only() {
            text += "receivers  stand on the surface: no terrain is known\n";
        }
        Ok(text)
    }

    fn add(&self, batch: &mut Batch, path: &Path, _: Format, _: &Look) -> Result<()> {
        match &self.tiles {
            Some(tiles) => tiles.add_raster(batch, path, &self.provenance()),
            None => Ok(()),
        }
    }
}
