//! `skyshed info`: what a scene is.

use serde_json::{Map, Value, json};

use super::args::InfoArgs;
use super::needs::{Needs, Rectangles, refuse_without_uav};
use super::plan::{FIELD_BYTES_PER_CELL, check_memory, input_paths, meters_per_unit, read_scene};
use super::words::pretty;
use super::zones::ZoneFiles;
use super::{interrupt, messages};
use crate::error::{Error, Result};
use crate::export::{Batch, Format, OutputRules, check_outputs, encode_table, with_suffix};
use crate::height_field::{CellKind, HeightField};
use crate::quantity::{VOID, counted, meters, tidy};
use crate::raster::Crs;
use crate::render::grouped;
use crate::report::RunFacts;
use crate::scene::{BuiltUp, FootprintFaults, Solids};
use crate::zones::{Zone, ZoneBasis, ZoneMap};

const FORMATS: [Format; 7] =
    [Format::Png, Format::Svg, Format::GeoTiff, Format::GeoJson, Format::Json, Format::Csv, Format::Stdout];

pub(super) fn run(args: &InfoArgs, command: Vec<String>) -> Result<()> {
    let inputs = input_paths(&args.scene);
    let rules = OutputRules { allowed: &FORMATS, inputs: &inputs, overwrite: args.out.overwrite, bare: false };
    let outputs = check_outputs(&args.output, rules)?;
    args.words.refuse_without_picture(&outputs)?;
    refuse_without_uav(args)?;
    if let Some((path, _)) = outputs.iter().find(|(_, f)| args.uav.is_empty() && *f == Format::Csv) {
        return Err(Error::usage(116, format!("cannot write {}: it holds what limits a map", path.display()))
            .with_hint("`--uav X,Y,H` says of which"));
    }
    let needs_no_zones = |f: &Format| matches!(f, Format::Json | Format::Csv | Format::Stdout);
    if let Some((path, _)) = outputs.iter().find(|(_, f)| !args.zones && !needs_no_zones(f)) {
        return Err(Error::usage(116, format!("cannot write {}: it holds zones", path.display()))
            .with_hint("`--zones` finds them"));
    }
    let mut warnings = Vec::new();
    let scene = read_scene(&args.scene, &mut warnings)?;
    let kind = match &scene.solids {
        Solids::Vector { .. } => "footprints",
        Solids::Raster { .. } => "raster",
    };
    let faults = match &scene.solids {
        Solids::Vector { faults, .. } => Some(*faults),
        Solids::Raster { .. } => None,
    };
    let grid = scene.grid.clone();
    let heights: Vec<f64> = match &scene.solids {
        Solids::Vector { footprints, .. } => footprints.iter().map(|f| meters(f.top) - meters(f.base)).collect(),
        Solids::Raster { .. } => Vec::new(),
    };
    let rectangles = match &scene.solids {
        Solids::Vector { footprints, .. } => Some(Rectangles {
            rectangles: footprints.iter().filter(|f| f.is_rectangle()).count(),
            footprints: footprints.len(),
        }),
        Solids::Raster { .. } => None,
    };
    check_memory(&args.scene.scene, &grid, (0, FIELD_BYTES_PER_CELL), args.engine.max_memory)?;
    let field = HeightField::build(&grid, scene.solids, &mut warnings);
    let counts = Counts::of(&field);
    let needs = match args.uav.is_empty() {
        true => None,
        false => Some(Needs::of(args, &field, scene.built_up, rectangles)?),
    };
    let zones = args.zones.then(|| ZoneMap::of(&field, scene.built_up.as_ref()));
    if zones.as_ref().is_some_and(|zones| zones.basis() == ZoneBasis::Unknown) {
        return Err(Error::usage(117, "`--zones` with a surface model alone: no building is known")
            .with_hint("give `--terrain FILE` or `--ground Z`"));
    }

    let unit = meters_per_unit(&grid);
    let (width, height) = ((grid.x_max() - grid.x_min()) * unit, (grid.y_max() - grid.y_min()) * unit);
    #[expect(clippy::cast_precision_loss, reason = "counts of cells are far below 2^53")]
    let built_up_ratio = counts.building as f64 / (counts.building + counts.open) as f64;
    let estimate = BuiltUp::estimated(built_up_ratio, &heights, width * height / 1e6);
    let pieces = field.prisms().map(|p| p.pieces().len());
    let document = json!({
        "schema": "skyshed/info/1",
        "version": env!("CARGO_PKG_VERSION"),
        "command": command.clone(),
        "kind": kind,
        "name": scene.name,
        "cols": grid.n_cols(),
        "rows": grid.n_rows(),
        "cell_m": [grid.cell_width() * unit, grid.cell_height() * unit],
        "size_m": [width, height],
        "extent": [grid.x_min(), grid.y_min(), grid.x_max(), grid.y_max()],
        "crs": grid.crs().map(Crs::label),
        "crs_name": grid.crs().map(Crs::name),
        "ground_m": range_json(counts.ground),
        "surface_m": range_json(counts.surface),
        "cells": {"open": counts.open, "building": counts.building, "nodata": counts.void},
        "buildings": (kind == "footprints").then(|| field.n_buildings()),
        "convex_pieces": pieces,
        "built_up": scene.built_up.map(|b| json!({
            "alpha": b.built_up_ratio, "beta_per_km2": b.buildings_per_km2, "gamma_m": b.height_scale,
            "building_width_m": b.building_width(), "street_width_m": b.street_width(), "seed": args.scene.seed,
        })),
        "estimated_built_up": estimate.map(|b| json!({
            "alpha": b.built_up_ratio, "beta_per_km2": b.buildings_per_km2, "gamma_m": b.height_scale,
        })),
        "zones": zones.as_ref().map(|zones| zones_json(zones, unit)),
        "needs": needs.as_ref().map(Needs::json),
        "faults": faults.map(faults_json),
        "sources": scene.sources.iter().map(|s| json!({"path": s.path, "sha256": s.sha256})).collect::<Vec<_>>(),
        "warnings": warnings.iter().map(|w| json!({"code": w.code(), "text": w.text()})).collect::<Vec<_>>(),
    });
    interrupt::begin_writing();
    let mut batch = Batch::new(args.out.overwrite);
    if let Some(zones) = &zones {
        let facts = RunFacts {
            command,
            method: None,
            scene_name: scene.name.clone(),
            grid: grid.clone(),
            meters_per_unit: unit,
            sources: scene.sources.clone(),
            seed: scene.built_up.map(|_| args.scene.seed),
            warnings: warnings.clone(),
        };
        let attribution = args.words.credit(scene.attribution.as_ref());
        let files = ZoneFiles { zones, field: &field, facts: &facts, title: args.words.title.as_deref(), attribution };
        files.add(&mut batch, &outputs)?;
    }
    for (path, _) in outputs.iter().filter(|(_, format)| *format == Format::Json) {
        batch.add(path, pretty(&document).as_bytes())?;
    }
    for (path, _) in outputs.iter().filter(|(_, format)| *format == Format::Csv) {
        let Some(needs) = &needs else { continue };
        batch.add(path, &encode_table(&needs.table())?)?;
        batch.add(&with_suffix(path, ".json"), pretty(&document).as_bytes())?;
    }
    batch.commit()?;
    if !args.out.quiet {
        messages::warnings(&warnings);
    }
    if args.out.json || outputs.iter().any(|(_, format)| *format == Format::Stdout) {
        return messages::answer(&pretty(&document));
    }

    let range = |r: Option<(i32, i32)>| {
        r.map_or("unknown".to_string(), |(a, b)| {
            format!("{} to {} m above the datum", tidy(meters(a)), tidy(meters(b)))
        })
    };
    let crs = grid.crs().map_or("none: local meters".to_string(), |c| format!("{}, {}", c.label(), c.name()));
    let mut text = format!("{} ({kind})\n", scene.name);
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
    text += &format!("ground     {}\n", range(counts.ground));
    text += &format!("surface    {}\n", range(counts.surface));
    #[expect(clippy::cast_precision_loss, reason = "a percentage for reading")]
    let percent = |n: u64| format!("{:.1} %", 100.0 * n as f64 / grid.n_cells() as f64);
    text += &format!(
        "cells      {} open ground ({}), {} building ({}), {} nodata\n",
        grouped(counts.open),
        percent(counts.open),
        grouped(counts.building),
        percent(counts.building),
        grouped(counts.void)
    );
    if let Some(pieces) = pieces {
        text += &format!(
            "buildings  {}, cut into {} convex pieces\n",
            grouped(field.n_buildings() as u64),
            grouped(pieces as u64)
        );
    }
    if let Some(b) = scene.built_up {
        text += &format!(
            "built-up   {b}: buildings {} m wide, streets {} m wide\n",
            tidy(b.building_width()),
            tidy(b.street_width())
        );
    }
    if let Some(b) = estimate {
        text += &format!(
            "estimated  α = {:.3}, β = {:.0}/km², γ = {:.1} m, over the whole extent\n",
            b.built_up_ratio, b.buildings_per_km2, b.height_scale
        );
    }
    for zone in zones.iter().flat_map(|_| Zone::ALL) {
        let found = zones.as_ref().map_or((0, 0), |zones| (zones.count(zone), zones.n_parts(zone)));
        let parts = counted(found.1 as u64, "part", "parts");
        text += &format!("{:<10} {} cells ({}) in {parts}\n", zone.name(), grouped(found.0), percent(found.0));
    }
    if field.is_surface_only() {
        text += "receivers  stand on the surface: no terrain is known\n";
    }
    if let Some(needs) = &needs {
        text += &format!("\n{}", needs.text());
    }
    messages::answer(&text)
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
        "missing_height": f.missing_height, "negative_height": f.negative_height, "decimal_comma": f.decimal_comma,
        "no_ground": f.no_ground, "too_far": f.too_far, "from_levels": f.from_levels, "not_buildings": f.not_buildings,
        "floating": f.floating, "parts": f.parts,
    })
}
