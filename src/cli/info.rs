//! `skyshed info`: what a scene is.

use serde_json::{Value, json};

use super::args::InfoArgs;
use super::messages;
use super::plan::{FIELD_BYTES_PER_CELL, check_memory, meters_per_unit, read_scene};
use super::words::pretty;
use crate::error::Result;
use crate::height_field::{CellKind, HeightField};
use crate::quantity::{VOID, meters, tidy};
use crate::raster::Crs;
use crate::render::grouped;
use crate::scene::{BuiltUp, FootprintFaults, Solids};

pub(super) fn run(args: &InfoArgs, command: Vec<String>) -> Result<()> {
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
    check_memory(&args.scene.scene, &grid, (0, FIELD_BYTES_PER_CELL), args.engine.max_memory)?;
    let field = HeightField::build(&grid, scene.solids, &mut warnings);
    let counts = Counts::of(&field);

    let unit = meters_per_unit(&grid);
    let (width, height) = ((grid.x_max() - grid.x_min()) * unit, (grid.y_max() - grid.y_min()) * unit);
    #[expect(clippy::cast_precision_loss, reason = "counts of cells are far below 2^53")]
    let built_up_ratio = counts.building as f64 / (counts.building + counts.open) as f64;
    let estimate = BuiltUp::estimated(built_up_ratio, &heights, width * height / 1e6);
    let pieces = field.prisms().map(|p| p.pieces().len());
    let document = json!({
        "schema": "skyshed/info/1",
        "version": env!("CARGO_PKG_VERSION"),
        "command": command,
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
        "zones": Value::Null,
        "faults": faults.map(faults_json),
        "sources": scene.sources.iter().map(|s| json!({"path": s.path, "sha256": s.sha256})).collect::<Vec<_>>(),
        "warnings": warnings.iter().map(|w| json!({"code": w.code(), "text": w.text()})).collect::<Vec<_>>(),
    });
    if !args.out.quiet {
        messages::warnings(&warnings);
    }
    if args.out.json {
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
    if field.is_surface_only() {
        text += "receivers  stand on the surface: no terrain is known\n";
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

fn faults_json(f: FootprintFaults) -> Value {
    json!({
        "not_areas": f.not_areas, "repaired": f.repaired, "unclosed": f.unclosed, "degenerate": f.degenerate,
        "missing_height": f.missing_height, "negative_height": f.negative_height, "decimal_comma": f.decimal_comma,
        "no_ground": f.no_ground, "too_far": f.too_far,
    })
}
