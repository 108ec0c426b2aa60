//! Zones of a scene: streets, crossroads, courtyards and rooftops, counted, drawn and as files.

use std::path::Path;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Value, json};

use crate::answer::{
    Answer, CommandFacts, Head, RunFacts, Spent, WarningFacts, closed_rings, document_of, feature, feature_collection,
    warnings_of,
};
use crate::coverage::class;
use crate::error::{RequestError, Result, Warning};
use crate::export::{Batch, Format, add_zones};
use crate::picture::{Look, crs_words, picture_provenance, program, written};
use crate::quantity::{counted, tidy};
use crate::render::{self, MapClass, MapPicture, grouped, percent};
use crate::scene::Scene;
use crate::words::title_of;
use crate::zones::{NONE, Zone, ZoneBasis, ZoneMap};

/// Output formats of zones.
pub(crate) const FORMATS: [Format; 7] =
    [Format::Png, Format::Svg, Format::Pdf, Format::GeoTiff, Format::GeoJson, Format::Json, Format::Stdout];

/// Zones of a scene.
#[derive(Debug)]
pub(crate) struct ZoneFiles {
    scene: Scene,
    facts: RunFacts,
    zones: Arc<ZoneMap>,
}

/// Zones of a scene.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ZonesDocument {
    #[serde(flatten)]
    head: Head,
    /// Basis of the zones: the streets of a generated city, or the open ground.
    basis: &'static str,
    /// Open ground that is neither crossroad nor courtyard.
    street: ZoneCounts,
    /// Open ground where three or more streets meet.
    crossroad: ZoneCounts,
    /// Open ground that buildings enclose.
    courtyard: ZoneCounts,
    /// Buildings.
    rooftop: ZoneCounts,
    /// Warnings.
    warnings: Vec<WarningFacts>,
}

/// Size of a zone.
#[derive(Debug, Serialize, JsonSchema)]
struct ZoneCounts {
    /// Number of cells.
    cells: u64,
    /// Area [m²].
    area_m2: f64,
    /// Share of all cells.
    share: f64,
    /// Number of connected parts.
    parts: usize,
}

impl ZoneFiles {
    /// Finds the zones of a scene.
    ///
    /// # Errors
    /// E117 if the scene is only a surface model, where no building is known.
    pub(crate) fn of(scene: Scene, command: CommandFacts) -> Result<ZoneFiles> {
        let Some(zones) = scene.zones()? else {
            return Err(RequestError::NoZones.into());
        };
        Ok(ZoneFiles { facts: RunFacts { command, ..scene.facts(None) }, scene, zones })
    }

    fn cell_m2(&self) -> f64 {
        let (grid, unit) = (self.zones.grid(), self.facts.unit_m());
        grid.cell_width() * grid.cell_height() * unit * unit
    }

    #[expect(clippy::cast_precision_loss, reason = "counts of cells are far below 2^53")]
    fn counts(&self, zone: Zone) -> ZoneCounts {
        let cells = self.zones.count(zone);
        let share = cells as f64 / self.zones.grid().n_cells() as f64;
        ZoneCounts { cells, area_m2: cells as f64 * self.cell_m2(), share, parts: self.zones.n_parts(zone) }
    }

    /// Returns the parts of all zones as polygons along the cell edges, in the grid's CRS.
    fn features(&self) -> Value {
        let (zones, cell_m2) = (&self.zones, self.cell_m2());
        let grid = zones.grid();
        let parts = |zone: Zone| zones.parts(zone).into_iter().enumerate().map(move |(k, part)| (zone, k, part));
        let features: Vec<Value> = Zone::ALL
            .into_iter()
            .flat_map(parts)
            .map(|(zone, k, part)| {
                #[expect(clippy::cast_precision_loss, reason = "counts of cells are far below 2^53")]
                let area = part.n_cells as f64 * cell_m2;
                let rings: Vec<Vec<[f64; 2]>> =
                    part.rings.iter().map(|ring| ring.iter().map(|c| grid.world_from_corner(*c)).collect()).collect();
                let id = format!("{}-{}", zone.name(), k + 1);
                let properties = json!({"zone": zone.name(), "id": id, "cells": part.n_cells, "area_m2": area});
                feature(properties, Some(("Polygon", json!(closed_rings(&rings)))))
            })
            .collect();
        feature_collection(grid, self.provenance(), features)
    }

    fn picture(&self, format: Format, look: &Look) -> Result<Vec<u8>> {
        let grid = &self.facts.grid;
        let unit = self.facts.unit_m();
        let open = [Zone::Street, Zone::Crossroad, Zone::Courtyard];
        let share = |zone| percent(self.zones.count(zone), open.map(|z| self.zones.count(z)).iter().sum());
        let detail = |zone: Zone| {
            let parts = self.zones.n_parts(zone) as u64;
            format!("{} of open ground · {}", share(zone), counted(parts, "part", "parts"))
        };
        let details = open.map(detail);
        let names = ["Street", "Crossroad", "Courtyard"];
        let palette: Vec<MapClass<'_>> =
            (0..open.len()).map(|k| MapClass { name: names[k], detail: &details[k], color: open[k].color() }).collect();
        let codes = self.zones.codes();
        let index: Vec<u8> = codes.iter().map(|code| code.saturating_sub(1)).collect();
        let mask: Vec<u8> = codes
            .iter()
            .map(|code| match *code {
                NONE => class::NODATA,
                code if code == Zone::Rooftop.code() => class::NOT_A_RECEIVER,
                _ => class::LOS,
            })
            .collect();
        let surface = self.scene.field.above_ground_m();
        let how = match self.zones.basis() {
            ZoneBasis::StreetGrid => "Zones by construction: the streets of the generated city",
            _ => "Zones from the triangulation of the open ground between the buildings",
        };
        let mut caption = vec![
            format!(
                "{how}; {} cells of {} × {} m",
                grouped(grid.n_cells() as u64),
                tidy(grid.cell_width() * unit),
                tidy(grid.cell_height() * unit)
            ),
            format!(
                "South-west corner at ({}, {}), {}; {}",
                tidy(grid.x_min()),
                tidy(grid.y_min()),
                crs_words(grid),
                program()
            ),
        ];
        caption.extend(self.scene.last_lines(look));
        let title = look.title_or(|| title_of(&format!("Zones of {}", self.facts.scene_name)));
        let picture = MapPicture {
            title: &title,
            caption: &caption,
            n_cols: grid.n_cols(),
            n_rows: grid.n_rows(),
            cell_m: (grid.cell_width() * unit, grid.cell_height() * unit),
            layer: render::Layer::Classes { index: &index, palette: &palette, mask: &mask },
            surface_m: Some(&surface),
            uavs: &[],
            is_in_air: false,
            receivers_name: "open-ground cells",
            others_name: "Rooftop",
            counts: None,
        };
        written(render::draw_map(&picture), &look.form(format), &picture_provenance(&self.provenance()))
    }
}

impl Answer for ZoneFiles {
    fn is_in_words(&self) -> bool {
        true
    }

    fn document(&self, _: Option<Spent>) -> Value {
        document_of(&ZonesDocument {
            head: self.facts.head("skyshed/zones/1"),
            basis: self.zones.basis().name(),
            street: self.counts(Zone::Street),
            crossroad: self.counts(Zone::Crossroad),
            courtyard: self.counts(Zone::Courtyard),
            rooftop: self.counts(Zone::Rooftop),
            warnings: warnings_of(&self.facts.warnings),
        })
    }

    fn warnings(&self) -> &[Warning] {
        &self.facts.warnings
    }

    fn text(&self, _: &Look) -> Result<String> {
        let line = |zone: Zone| {
            let ZoneCounts { cells, parts, .. } = self.counts(zone);
            let share = percent(cells, self.zones.grid().n_cells() as u64);
            let (cells, parts) = (grouped(cells), counted(parts as u64, "part", "parts"));
            format!("{:<10} {cells} cells ({share}) in {parts}\n", zone.name())
        };
        Ok(Zone::ALL.map(line).concat())
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
        match format {
            Format::GeoTiff => Ok(add_zones(batch, &self.zones, &self.provenance().to_string(), path)?),
            Format::GeoJson => Ok(batch.add(path, format!("{}\n", self.features()).as_bytes())?),
            _ => Ok(batch.add(path, &self.picture(format, look)?)?),
        }
    }
}
