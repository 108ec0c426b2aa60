//! `skyshed info SCENE --uav`: what a scene needs for a map, and what limits that map.

use serde_json::{Value, json};

use crate::accuracy::{
    BudgetLine, CellEffect, NO_CHANGE, Setup, Simpler, TerrainEffect, Uncertain, cell_effects, coarsest_unchanged,
    error_budget, terrain_effect,
};
use crate::city::{BuiltUp, BuiltUpCity};
use crate::cli::args::InfoArgs;
use crate::cli::plan::parse_uav;
use crate::coverage::{IdleFootprints, Mapper, Uav};
use crate::error::{Error, Result};
use crate::height_field::HeightField;
use crate::map::{Asked, Expected, check_receivers, checked_radius, receiver_height};
use crate::quantity::tidy;
use crate::render::grouped;
use crate::report::idle_json;
use crate::scene::outside::place_uav;
use crate::words::idle_in_words;
use crate::zones::ZoneMap;

/// Footprints that are rectangles, of all.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rectangles {
    pub(super) rectangles: usize,
    pub(super) footprints: usize,
}

/// What a scene needs for a map from some UAVs.
pub(super) struct Needs {
    p_los: Option<f64>,
    receivers: u64,
    cell_m: f64,
    cells: Vec<CellEffect>,
    terrain: TerrainEffect,
    idle: IdleFootprints,
    rectangles: Option<Rectangles>,
    /// The engine that `auto` takes, why, and how long it is expected to take \[s\].
    engine: (String, &'static str, f64),
    budget: Vec<BudgetLine>,
}

/// Refuses what says how a map is to be judged where none is.
pub(super) fn refuse_without_uav(args: &InfoArgs) -> Result<()> {
    let of_needs = ["rx_height", "receivers", "uav_error", "height_error", "cities"];
    let typed = of_needs.iter().find(|flag| args.scene.typed.iter().any(|typed| typed == *flag));
    match typed.filter(|_| args.uav.is_empty()) {
        Some(flag) => {
            let text = format!("`--{}` has no meaning without `--uav`", flag.replace('_', "-"));
            Err(Error::usage(116, text).with_hint("`--uav X,Y,H` tells what a map from there needs"))
        }
        None => Ok(()),
    }
}

impl Needs {
    /// Finds out, by making the map in several ways.
    pub(super) fn of(
        args: &InfoArgs,
        field: &HeightField,
        built_up: Option<BuiltUp>,
        rectangles: Option<Rectangles>,
    ) -> Result<Needs> {
        let unit = field.grid().meters_per_unit();
        let radius = checked_radius(args.engine.radius)?.map(|r| r / unit);
        let rx_height = receiver_height(args.rx_height)?;
        for (flag, value) in [("--uav-error", args.uav_error), ("--height-error", args.height_error)] {
            if !(0.0..=1000.0).contains(&value) {
                return Err(Error::usage(113, format!("`{flag}` is `{value}`, wanted 0 to 1000 m")));
            }
        }
        check_receivers(args.receivers, field)?;
        let place = |(k, text): (usize, &String)| {
            place_uav(&parse_uav(text, (k + 1).to_string())?, field, field.grid(), radius)
        };
        let uavs: Vec<Uav> = args.uav.iter().enumerate().map(place).collect::<Result<_>>()?;
        let asked = Asked { receivers: args.receivers, rx_height, radius, method: args.engine.method };
        let options = |field: &HeightField| {
            let zones = asked.receivers.zone().and_then(|_| ZoneMap::if_known(field, built_up.as_ref()));
            asked.options(field.grid(), zones.as_ref())
        };
        let setup = Setup { field, uavs: &uavs, options: &options };
        let own = options(field);
        let mut mapper = Mapper::new(field, &own)?;
        let (method, why) = mapper.method();
        let idle = mapper.drop_idle(&uavs);
        let (receivers, los) =
            uavs.iter().map(|uav| mapper.count(uav)).fold((0, 0), |sum, c| (sum.0 + c.0, sum.1 + c.1));
        drop(mapper);
        #[expect(clippy::cast_precision_loss, reason = "counts of cells")]
        let (in_range, p_los) = (receivers as f64, (receivers > 0).then(|| los as f64 / receivers as f64));
        let threads = (method, rayon::current_num_threads());
        let expected =
            Expected::of(threads, (field.grid().n_cells(), in_range / uavs.len() as f64), (uavs.len(), 0), 1);
        let uncertain = Uncertain { uav_m: args.uav_error, roofs_m: args.height_error, meters_per_unit: unit };
        let budget = match p_los {
            Some(p_los) => error_budget(&setup, p_los, &uncertain, &other_cities(args, built_up)?)?,
            None => Vec::new(),
        };
        Ok(Needs {
            p_los,
            receivers,
            cell_m: field.grid().cell_width() * unit,
            cells: cell_effects(&setup),
            terrain: terrain_effect(&setup)?,
            idle,
            rectangles,
            engine: (method.name().into_owned(), why, expected.seconds()),
            budget,
        })
    }

    fn coarsest(&self) -> Option<Simpler> {
        coarsest_unchanged(&self.cells, self.p_los?)
    }

    /// As documents hold it.
    pub(super) fn json(&self) -> Value {
        let cell = |e: &CellEffect| {
            #[expect(clippy::cast_precision_loss, reason = "a small factor")]
            let cell_m = self.cell_m * e.form.factor as f64;
            json!({
                "cell_m": cell_m, "pooling": e.form.pooling.map(|p| p.name()), "p_los": e.p_los.as_ref().ok(),
                "change": e.p_los.as_ref().ok().zip(self.p_los).map(|(p, own)| p - own), "reason": e.p_los.as_ref().err(),
            })
        };
        let line = |line: &BudgetLine| {
            json!({
                "part": line.part.name(), "changed": line.changed, "p_los_change": line.change.as_ref().ok(),
                "reason": line.change.as_ref().err(),
            })
        };
        let (method, why, seconds) = &self.engine;
        json!({
            "p_los": self.p_los,
            "receivers": self.receivers,
            "cells": self.cells.iter().map(cell).collect::<Vec<_>>(),
            "coarsest_unchanged": self.coarsest().map(|form| form.in_words(self.cell_m)),
            "unchanged_below": NO_CHANGE,
            "terrain": match self.terrain {
                TerrainEffect::None => Value::Null,
                TerrainEffect::Hides { hidden, receivers } => json!({"hidden": hidden, "receivers": receivers}),
            },
            "footprints": (self.idle.footprints > 0).then(|| idle_json(&self.idle)),
            "rectangles": self.rectangles.map(|r| json!({"rectangles": r.rectangles, "footprints": r.footprints})),
            "method": method,
            "why": why,
            "expected_s": seconds,
            "budget": self.budget.iter().map(line).collect::<Vec<_>>(),
        })
    }

    /// The table of the budget: one row per line.
    pub(super) fn table(&self) -> Vec<Vec<String>> {
        let header = ["part", "changed", "p_los", "p_los_change", "reason"].map(str::to_string).to_vec();
        let own = self.p_los.map_or(String::new(), |p| p.to_string());
        let row = |line: &BudgetLine| {
            let change = line.change.as_ref().map_or(String::new(), f64::to_string);
            let reason = line.change.as_ref().err().cloned().unwrap_or_default();
            vec![line.part.name().to_string(), line.changed.clone(), own.clone(), change, reason]
        };
        std::iter::once(header).chain(self.budget.iter().map(row)).collect()
    }

    /// For reading.
    pub(super) fn text(&self) -> String {
        let Some(p_los) = self.p_los else { return "map        no receiver in range\n".into() };
        let (method, why, seconds) = &self.engine;
        let mut text = format!("map        P_LoS {p_los:.4} of {} receivers\n", grouped(self.receivers));
        let time = if *seconds < 0.1 { "less than 0.1 s".into() } else { format!("about {seconds:.1} s") };
        text += &format!("method     auto takes {method} ({why}): {time} of line of sight\n");
        text += &match self.coarsest() {
            Some(form) => {
                format!("cells      {} would do: P_LoS changes by less than 0.1 %\n", form.in_words(self.cell_m))
            }
            None => {
                format!("cells      {} m are needed: any coarser, P_LoS changes by 0.1 % or more\n", tidy(self.cell_m))
            }
        };
        text += &match self.terrain {
            TerrainEffect::None => "terrain    flat, or not known apart from the surface\n".to_string(),
            TerrainEffect::Hides { hidden: 0, .. } => "terrain    hides no receiver: only buildings do\n".to_string(),
            TerrainEffect::Hides { hidden, receivers } => {
                format!("terrain    hides {} of {} receivers by itself\n", grouped(hidden), grouped(receivers))
            }
        };
        if let Some(r) = self.rectangles {
            text += &format!(
                "outlines   {} of {} footprints are rectangles\n",
                grouped(r.rectangles as u64),
                grouped(r.footprints as u64)
            );
        }
        if self.idle.footprints > 0 {
            text += &format!("footprints {}\n", idle_in_words(&self.idle));
        }
        text += "\nWhat limits P_LoS, the largest first:\n";
        let width = self.budget.iter().map(|line| line.part.name().len()).max().unwrap_or(0);
        for line in &self.budget {
            let change = match &line.change {
                Ok(change) => format!("{change:+.5}"),
                Err(_) => "unknown".into(),
            };
            let why = line.change.as_ref().err().map_or(String::new(), |why| format!(": {why}"));
            text += &format!("  {:<width$}  {change:<9} {}{why}\n", line.part.name(), line.changed);
        }
        text
    }
}

/// Cities of the same kind by other seeds, for a generated scene.
fn other_cities(args: &InfoArgs, built_up: Option<BuiltUp>) -> Result<Vec<HeightField>> {
    let Some(built_up) = built_up else { return Ok(Vec::new()) };
    let city = |k: u64| {
        let city = BuiltUpCity {
            built_up,
            size_m: args.scene.size.unwrap_or(1000.0),
            margin_m: 0.0,
            cell_m: args.scene.cell.unwrap_or(1.0),
            seed: args.scene.seed.wrapping_add(k),
            ground_m: args.scene.ground.unwrap_or(0.0),
        };
        let scene = city.city()?;
        Ok(HeightField::build(&scene.grid, scene.solids).field)
    };
    (1..=u64::from(args.cities)).map(city).collect()
}
