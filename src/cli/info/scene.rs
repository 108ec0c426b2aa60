//! `skyshed info` of a scene: size, system, heights, zones, α β γ, faults.

use std::path::PathBuf;

use serde_json::{Map, Value, json};

use super::needs::{Needs, Rectangles, refuse_without_uav};
use super::tiles::{self, Tiles};
use crate::city::City;
use crate::city::{BuiltUp, Footprint, FootprintFaults, HeightGap, Solids, Source};
use crate::cli::args::InfoArgs;
use crate::cli::plan::uavs_asked;
use crate::cli::plan::{input_paths, read_scene};
use crate::cli::zones::ZoneFiles;
use crate::cli::{interrupt, messages};
use crate::crs::VerticalCrs;
use crate::error::{Error, Result, Warning};
use crate::export::{Batch, Format, OutputRules, check_outputs, with_suffix};
use crate::height_field::{CellKind, HeightField};
use crate::memory::{FIELD_BYTES_PER_CELL, check_memory};
use crate::quantity::{Frame, VOID, counted, meters, tidy};
use crate::raster::Crs;
use crate::read::vertical_of;
use crate::render::grouped;
use crate::report::RunFacts;
use crate::scene::is_raster;
use crate::scene::limits::limits_in_words;
use crate::scene::outside::warn_of_uavs_outside;
use crate::words::pretty;
use crate::zones::{Zone, ZoneMap};

const FORMATS: [Format; 8] = [
    Format::Png,
    Format::Svg,
    Format::Pdf,
    Format::GeoTiff,
    Format::GeoJson,
    Format::Json,
    Format::Csv,
    Format::Stdout,
];

pub(super) fn run(args: &InfoArgs, command: Vec<String>) -> Result<()> {
    let outputs = checked_outputs(args)?;
    let mut warnings = Vec::new();
    let scene = read_scene(&args.scene, &mut warnings)?;
    let found = Found::of(args, scene, warnings)?;
    let facts = found.facts(args, command);
    let document = found.document(args, &facts);
    interrupt::begin_writing();
    let files = found.write(args, &facts, (&document, &outputs))?;
    if !args.out.quiet {
        messages::warnings(&facts.warnings);
    }
    messages::wrote(&files, args.out.quiet);
    if args.out.json || outputs.iter().any(|(_, format)| *format == Format::Stdout) {
        return messages::answer(&pretty(&document));
    }
    messages::answer(&found.text())
}

/// The outputs, each of which something that was asked for fills.
fn checked_outputs(args: &InfoArgs) -> Result<Vec<(PathBuf, Format)>> {
    let inputs = input_paths(&args.scene);
    let rules = OutputRules { allowed: &FORMATS, inputs: &inputs, overwrite: args.out.overwrite, bare: false };
    let outputs = check_outputs(&args.output, rules)?;
    args.words.refuse_without_picture(&outputs)?;
    refuse_without_uav(args)?;
    tiles::check(args, &outputs)?;
    if args.tile.is_some() {
        return Ok(outputs);
    }
    if let Some((path, _)) = outputs.iter().find(|(_, f)| args.uav.is_empty() && *f == Format::Csv) {
        return Err(Error::usage(
            116,
            format!("cannot write {}: it holds what limits a map, or tiles", path.display()),
        )
        .with_hint("`--uav X,Y,H` says of which map, `--tile M` how large tiles are"));
    }
    let needs_no_zones = |f: &Format| matches!(f, Format::Json | Format::Csv | Format::Stdout);
    if let Some((path, _)) = outputs.iter().find(|(_, f)| !args.zones && !needs_no_zones(f)) {
        return Err(Error::usage(116, format!("cannot write {}: it holds zones", path.display()))
            .with_hint("`--zones` finds them"));
    }
    Ok(outputs)
}

/// What was found of a scene.
struct Found {
    scene: Named,
    field: HeightField,
    counts: Counts,
    /// Of footprints.
    faults: Option<FootprintFaults>,
    estimate: Option<BuiltUp>,
    needs: Option<Needs>,
    zones: Option<ZoneMap>,
    tiles: Option<Tiles>,
    /// The raster files that hold heights, with what these are above.
    vertical: Vec<(PathBuf, Option<VerticalCrs>)>,
    warnings: Vec<Warning>,
}

/// What a scene is called and where it comes from.
struct Named {
    name: String,
    built_up: Option<BuiltUp>,
    sources: Vec<Source>,
    attribution: Option<String>,
    height_gap: Option<HeightGap>,
}

impl Found {
    fn of(args: &InfoArgs, scene: City, mut warnings: Vec<Warning>) -> Result<Found> {
        let City { name, grid, solids, built_up, sources, attribution, height_gap } = scene;
        let unit = grid.meters_per_unit();
        let size = Tiles::size(args, &grid, unit)?;
        let heights = solids.building_heights();
        let (faults, rectangles) = match &solids {
            Solids::Vector { footprints, faults, .. } => {
                let rectangles = footprints.iter().filter(|f| f.is_rectangle()).count();
                (Some(*faults), Some(Rectangles { rectangles, footprints: footprints.len() }))
            }
            Solids::Raster { .. } => (None, None),
        };
        let footprints: Option<(Vec<Footprint>, Frame)> = match &solids {
            Solids::Vector { footprints, frame, .. } if size.is_some() => Some((footprints.clone(), *frame)),
            _ => None,
        };
        check_memory(&args.scene.scene, &grid, FIELD_BYTES_PER_CELL)?;
        let field = HeightField::build(&grid, solids, &mut warnings);
        let counts = Counts::of(&field);
        let asked = uavs_asked(&args.uav, None, (false, false))?;
        warn_of_uavs_outside(&asked.typed, &grid, &mut warnings);
        let needs = match args.uav.is_empty() {
            true => None,
            false => Some(Needs::of(args, &field, built_up, rectangles)?),
        };
        let zones = if args.zones { ZoneMap::if_known(&field, built_up.as_ref()) } else { None };
        if args.zones && zones.is_none() {
            return Err(Error::usage(117, "`--zones` with a surface model alone: no building is known")
                .with_hint("give `--terrain FILE` or `--ground Z`"));
        }
        let tiles = size.map(|size| Tiles::of(&field, footprints.as_ref(), size)).transpose()?;
        #[expect(clippy::cast_precision_loss, reason = "counts of cells are far below 2^53")]
        let (n_known, n_built) = ((counts.building + counts.open) as f64, counts.building as f64);
        let area_km2 = n_known * grid.cell_width() * grid.cell_height() * unit * unit / 1e6;
        let estimate = BuiltUp::estimated(n_built / n_known, &field.heights_in_data(&heights), area_km2);
        let scene = Named { name, built_up, sources, attribution, height_gap };
        let rasters =
            std::iter::once(PathBuf::from(&args.scene.scene)).filter(|path| is_raster(path) && path.is_file());
        let vertical =
            rasters.chain(args.scene.terrain.clone()).map(|path| (path.clone(), vertical_of(&path))).collect();
        Ok(Found { scene, field, counts, faults, estimate, needs, zones, tiles, vertical, warnings })
    }

    fn kind(&self) -> &'static str {
        if self.faults.is_some() { "footprints" } else { "raster" }
    }

    fn facts(&self, args: &InfoArgs, command: Vec<String>) -> RunFacts {
        let grid = self.field.grid().clone();
        RunFacts {
            command,
            method: None,
            scene_name: self.scene.name.clone(),
            meters_per_unit: grid.meters_per_unit(),
            grid,
            sources: self.scene.sources.clone(),
            seed: self.scene.built_up.map(|_| args.scene.seed),
            warnings: self.warnings.clone(),
            unit: None,
        }
    }

    /// Edge lengths of the grid \[m\].
    fn size_m(&self) -> [f64; 2] {
        let grid = self.field.grid();
        let unit = grid.meters_per_unit();
        [(grid.x_max() - grid.x_min()) * unit, (grid.y_max() - grid.y_min()) * unit]
    }

    fn document(&self, args: &InfoArgs, facts: &RunFacts) -> Value {
        let (grid, unit, counts) = (self.field.grid(), facts.meters_per_unit, &self.counts);
        let sources = facts.sources.iter().map(|s| json!({"path": s.path, "sha256": s.sha256})).collect::<Vec<_>>();
        let warnings = facts.warnings.iter().map(|w| json!({"code": w.code(), "text": w.text()})).collect::<Vec<_>>();
        json!({
            "schema": "skyshed/info/1",
            "version": env!("CARGO_PKG_VERSION"),
            "command": facts.command,
            "kind": self.kind(),
            "name": self.scene.name,
            "cols": grid.n_cols(),
            "rows": grid.n_rows(),
            "cell_m": [grid.cell_width() * unit, grid.cell_height() * unit],
            "size_m": self.size_m(),
            "extent": [grid.x_min(), grid.y_min(), grid.x_max(), grid.y_max()],
            "crs": grid.crs().map(Crs::label),
            "crs_name": grid.crs().map(Crs::name),
            "vertical": self.vertical.iter().map(vertical_json).collect::<Vec<_>>(),
            "ground_m": range_json(counts.ground),
            "surface_m": range_json(counts.surface),
            "cells": {"open": counts.open, "building": counts.building, "nodata": counts.void},
            "buildings": self.faults.map(|_| self.field.n_buildings()),
            "convex_pieces": self.field.prisms().map(|p| p.pieces().len()),
            "built_up": self.scene.built_up.map(|b| json!({
                "alpha": b.built_up_ratio, "beta_per_km2": b.buildings_per_km2, "gamma_m": b.height_scale,
                "building_width_m": b.building_width(), "street_width_m": b.street_width(), "seed": args.scene.seed,
            })),
            "estimated_built_up": self.estimate.map(|b| json!({
                "alpha": b.built_up_ratio, "beta_per_km2": b.buildings_per_km2, "gamma_m": b.height_scale,
            })),
            "tiles": self.tiles.as_ref().map(Tiles::json),
            "zones": self.zones.as_ref().map(|zones| zones_json(zones, unit)),
            "needs": self.needs.as_ref().map(Needs::json),
            "faults": self.faults.map(faults_json),
            "sources": sources,
            "warnings": warnings,
        })
    }

    /// Writes the files that were asked for and returns their names.
    fn write(
        &self,
        args: &InfoArgs,
        facts: &RunFacts,
        (document, outputs): (&Value, &[(PathBuf, Format)]),
    ) -> Result<Vec<PathBuf>> {
        let mut batch = Batch::new(args.out.overwrite);
        if let Some(tiles) = &self.tiles {
            let mut provenance = facts.provenance("skyshed/tiles/1", None);
            provenance["tiles"] = tiles.json();
            tiles.add(&mut batch, outputs, &provenance)?;
        }
        if let Some(zones) = &self.zones {
            let attribution = args.words.credit(self.scene.attribution.as_ref());
            let (field, title) = (&self.field, args.words.title.as_deref());
            let limits = limits_in_words(self.scene.height_gap.as_ref(), field, &self.warnings);
            ZoneFiles { zones, field, facts, title, attribution, limits, size: args.words.size }
                .add(&mut batch, outputs)?;
        }
        for (path, _) in outputs.iter().filter(|(_, format)| *format == Format::Json) {
            batch.add(path, pretty(document).as_bytes())?;
        }
        for (path, _) in outputs.iter().filter(|(_, format)| *format == Format::Csv) {
            let Some(needs) = &self.needs else { continue };
            batch.add(path, &args.out.table(&needs.table())?)?;
            batch.add(&with_suffix(path, ".json"), pretty(document).as_bytes())?;
        }
        Ok(batch.commit()?)
    }

    fn text(&self) -> String {
        let mut text = self.text_of_grid();
        text += &self.text_of_buildings();
        for zone in self.zones.iter().flat_map(|_| Zone::ALL) {
            let found = self.zones.as_ref().map_or((0, 0), |zones| (zones.count(zone), zones.n_parts(zone)));
            let parts = counted(found.1 as u64, "part", "parts");
            let share = self.percent(found.0);
            text += &format!("{:<10} {} cells ({share}) in {parts}\n", zone.name(), grouped(found.0));
        }
        if self.field.is_surface_only() {
            text += "receivers  stand on the surface: no terrain is known\n";
        }
        if let Some(needs) = &self.needs {
            text += &format!("\n{}", needs.text());
        }
        text
    }

    #[expect(clippy::cast_precision_loss, reason = "a percentage for reading")]
    fn percent(&self, n: u64) -> String {
        format!("{:.1} %", 100.0 * n as f64 / self.field.grid().n_cells() as f64)
    }

    fn text_of_grid(&self) -> String {
        let (grid, counts) = (self.field.grid(), &self.counts);
        let unit = grid.meters_per_unit();
        let [width, height] = self.size_m();
        let range = |r: Option<(i32, i32)>| {
            r.map_or("unknown".to_string(), |(a, b)| {
                format!("{} to {} m above the datum", tidy(meters(a)), tidy(meters(b)))
            })
        };
        let crs = grid.crs().map_or("none: local meters".to_string(), |c| format!("{}, {}", c.label(), c.name()));
        let mut text = format!("{} ({})\n", self.scene.name, self.kind());
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
        if let Some(pieces) = self.field.prisms().map(|p| p.pieces().len()) {
            text += &format!(
                "buildings  {}, cut into {} convex pieces\n",
                grouped(self.field.n_buildings() as u64),
                grouped(pieces as u64)
            );
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

/// Cells by kind and ranges of heights.
#[derive(Default)]
struct Counts {
    open: u64,
    building: u64,
    void: u64,
    ground: Option<(i32, i32)>,
    surface: Option<(i32, i32)>,
}

impl Counts {
    fn of(field: &HeightField) -> Self {
        let grid = field.grid();
        let positions = field.positions();
        let mut counts = Counts::default();
        let widen = |range: &mut Option<(i32, i32)>, z: i32| {
            if z != VOID {
                let (a, b) = range.unwrap_or((z, z));
                *range = Some((a.min(z), b.max(z)));
            }
        };
        for row in 0..grid.n_rows() {
            for col in 0..grid.n_cols() {
                let center = positions.center(row, col);
                let surface = match field.cell_kind(row * grid.n_cols() + col, &center) {
                    CellKind::Open(z) => {
                        counts.open += 1;
                        z
                    }
                    CellKind::Building(z) => {
                        counts.building += 1;
                        z
                    }
                    CellKind::Void => {
                        counts.void += 1;
                        continue;
                    }
                };
                widen(&mut counts.surface, surface);
                widen(&mut counts.ground, field.ground_at(&center));
            }
        }
        counts
    }
}

/// What the heights of a file are above, null where it does not say so.
fn vertical_json((path, vertical): &(PathBuf, Option<VerticalCrs>)) -> Value {
    json!({
        "path": path.display().to_string(),
        "crs": vertical.as_ref().and_then(VerticalCrs::epsg).map(|code| format!("EPSG:{code}")),
        "name": vertical.as_ref().map(VerticalCrs::name),
        "reason": vertical.is_none().then_some("the file names no vertical datum"),
    })
}

fn range_json(range: Option<(i32, i32)>) -> Value {
    range.map_or(Value::Null, |(a, b)| json!([meters(a), meters(b)]))
}

/// Cells, area and parts of each zone, and how zones were found.
fn zones_json(zones: &ZoneMap, meters_per_unit: f64) -> Value {
    let grid = zones.grid();
    let cell_m2 = grid.cell_width() * grid.cell_height() * meters_per_unit * meters_per_unit;
    let of = |zone: Zone| {
        let n = zones.count(zone);
        #[expect(clippy::cast_precision_loss, reason = "counts of cells are far below 2^53")]
        let (area, share) = (n as f64 * cell_m2, n as f64 / grid.n_cells() as f64);
        let counts = json!({"cells": n, "area_m2": area, "share": share, "parts": zones.n_parts(zone)});
        (zone.name().to_string(), counts)
    };
    let mut object: Map<String, Value> = Zone::ALL.into_iter().map(of).collect();
    object.insert("basis".into(), zones.basis().name().into());
    object.into()
}

fn faults_json(f: FootprintFaults) -> Value {
    json!({
        "not_areas": f.not_areas, "repaired": f.repaired, "unclosed": f.unclosed, "degenerate": f.degenerate,
        "stray_holes": f.stray_holes, "missing_height": f.missing_height, "negative_height": f.negative_height, "decimal_comma": f.decimal_comma,
        "no_ground": f.no_ground, "too_far": f.too_far, "from_levels": f.from_levels, "not_buildings": f.not_buildings,
        "floating": f.floating, "parts": f.parts,
    })
}
