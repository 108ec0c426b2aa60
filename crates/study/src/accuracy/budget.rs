//! Error budget of a map: the change of P_LoS when each of its inputs changes by its uncertainty.

use super::economy::Setup;
use super::simpler::Simpler;
use crate::coverage::{MapOptions, Mapper, MovedRoofs, Uav};
use crate::error::Result;
use crate::height_field::{Curvature, HeightField, Pooling, Station};
use crate::los::MethodChoice;
use crate::quantity::height_steps;

/// A part of the error budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// Sampling of ground and roofs.
    Cells,
    /// The engine.
    Method,
    /// Position of the UAV.
    UavPlace,
    /// Height of the UAV.
    UavHeight,
    /// Heights of the buildings, all wrong by the same amount.
    RoofHeights,
    /// Shapes of roofs, where they are known.
    RoofShapes,
    /// The curve of the earth.
    Earth,
    /// Random draw of the city, one of many.
    Cities,
}

impl Part {
    /// Returns the word for it.
    pub fn name(self) -> &'static str {
        match self {
            Part::Cells => "cell size",
            Part::Method => "method",
            Part::UavPlace => "UAV position",
            Part::UavHeight => "UAV height",
            Part::RoofHeights => "building heights",
            Part::RoofShapes => "roof shapes",
            Part::Earth => "shape of the earth",
            Part::Cities => "one city of many",
        }
    }
}

/// A line of the budget.
#[derive(Debug, Clone, PartialEq)]
pub struct BudgetLine {
    /// Part of the budget.
    pub part: Part,
    /// Change that was made, in words.
    pub changed: String,
    /// Largest change of P_LoS that followed, signed; or the reason why there is none.
    pub change: std::result::Result<f64, String>,
}

/// Uncertainties of the inputs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertain {
    /// Position and height of a UAV \[m\].
    pub uav_m: f64,
    /// Heights of buildings \[m\].
    pub roofs_m: f64,
    /// Length of a CRS unit \[m\].
    pub meters_per_unit: f64,
}

/// K of radio rays in a standard atmosphere.
const RADIO_K: f64 = 4.0 / 3.0;

/// Most receivers that are compared with `ray`.
const MOST_RAYS: u64 = 1 << 23;

/// Computes the budget of a map whose P_LoS is known. The largest change comes first, lines without
/// a number last.
///
/// `cities` are other cities of the same kind; none for a real city.
pub fn error_budget(
    setup: &Setup<'_>,
    p_los: f64,
    uncertain: &Uncertain,
    cities: &[HeightField],
) -> Result<Vec<BudgetLine>> {
    let mut lines = cell_lines(setup, p_los, uncertain);
    lines.push(method_line(setup, p_los)?);
    lines.push(place_line(setup, p_los, uncertain));
    lines.push(height_line(setup, p_los, uncertain));
    lines.push(roof_line(setup, p_los, uncertain));
    lines.extend(shape_line(setup, p_los));
    lines.push(earth_line(setup, p_los));
    lines.push(city_line(setup, cities));
    let size = |line: &BudgetLine| line.change.as_ref().map_or(-1.0, |c| c.abs());
    lines.sort_by(|a, b| size(b).total_cmp(&size(a)).then(a.part.cmp(&b.part)));
    Ok(lines)
}

/// Returns the change of P_LoS to that of a form of the scene.
fn change_to(setup: &Setup<'_>, p_los: f64, field: Option<HeightField>) -> std::result::Result<f64, String> {
    let field = field.ok_or_else(|| "a scene of this kind has no such form".to_string())?;
    change_of(setup.p_los_of(&field), p_los)
}

fn cell_lines(setup: &Setup<'_>, p_los: f64, uncertain: &Uncertain) -> Vec<BudgetLine> {
    let cell_m = setup.field.grid().cell_width() * uncertain.meters_per_unit;
    let line = |changed: String, field: Option<HeightField>| BudgetLine {
        part: Part::Cells,
        changed,
        change: change_to(setup, p_los, field),
    };
    if setup.field.prisms().is_some() {
        let finer = setup.field.with_finer_receivers(2);
        let half = crate::quantity::tidy(cell_m / 2.0);
        return vec![
            line(format!("receivers every {half} m"), finer),
            line("the raster of its cells instead of footprints".into(), setup.field.rasterized()),
        ];
    }
    let of = |pooling: Pooling| {
        let form = Simpler { factor: 2, pooling: Some(pooling) };
        line(form.in_words(cell_m), form.of(setup.field))
    };
    vec![of(Pooling::Mean), of(Pooling::Maximum)]
}

fn method_line(setup: &Setup<'_>, p_los: f64) -> Result<BudgetLine> {
    let rays = |field: &HeightField| Ok(MapOptions { method: MethodChoice::Ray, ..(setup.options)(field)? });
    let options = rays(setup.field)?;
    let mapper = Mapper::new(setup.field, &options)?;
    let in_range = |uav| Ok(mapper.seen_from(uav)?.receivers_in_range().count());
    let n = setup.uavs.iter().map(in_range).sum::<Result<u64>>()?;
    let change = if n > MOST_RAYS {
        Err(format!("{n} receivers are too many to compare with a ray each"))
    } else {
        change_of(Setup { options: &rays, ..*setup }.p_los(), p_los)
    };
    Ok(BudgetLine { part: Part::Method, changed: format!("a ray for each of {n} receivers"), change })
}

fn change_of(other: Result<Option<f64>>, p_los: f64) -> std::result::Result<f64, String> {
    match other {
        Ok(Some(other)) => Ok(other - p_los),
        Ok(None) => Err("no receiver in range".into()),
        Err(why) => Err(why.to_string()),
    }
}

/// Returns the largest of some changes of P_LoS; an error if any of them is one.
fn largest(changes: impl Iterator<Item = std::result::Result<f64, String>>) -> std::result::Result<f64, String> {
    changes.reduce(|a, b| Ok(if a.clone()?.abs() >= b.clone()?.abs() { a? } else { b? })).unwrap_or(Ok(0.0))
}

fn place_line(setup: &Setup<'_>, p_los: f64, uncertain: &Uncertain) -> BudgetLine {
    let reach = uncertain.uav_m / uncertain.meters_per_unit;
    let moved = |k: i32| {
        let (sin, cos) = (f64::from(k) * std::f64::consts::FRAC_PI_4).sin_cos();
        change_with(setup, p_los, |field, station| {
            let place = field.place(station.place.x + reach * sin, station.place.y + reach * cos);
            Station { place, ..station }
        })
    };
    BudgetLine {
        part: Part::UavPlace,
        changed: format!("{} m to each of eight sides, at the same height", crate::quantity::tidy(uncertain.uav_m)),
        change: largest((0..8).map(moved)),
    }
}

fn height_line(setup: &Setup<'_>, p_los: f64, uncertain: &Uncertain) -> BudgetLine {
    let steps = i64::from(height_steps(uncertain.uav_m).unwrap_or(0));
    let moved = |by: i64| change_with(setup, p_los, |_, station| Station { z: station.z + by, ..station });
    BudgetLine {
        part: Part::UavHeight,
        changed: format!("{} m up and down", crate::quantity::tidy(uncertain.uav_m)),
        change: largest([steps, -steps].into_iter().map(moved)),
    }
}

/// Returns the change of P_LoS when all UAVs are elsewhere.
fn change_with(
    setup: &Setup<'_>,
    p_los: f64,
    to: impl Fn(&HeightField, Station) -> Station,
) -> std::result::Result<f64, String> {
    let moved: Vec<Uav> =
        setup.uavs.iter().map(|uav| Uav { station: to(setup.field, uav.station), ..uav.clone() }).collect();
    let setup = Setup { uavs: &moved, ..*setup };
    // If a building is at the new place, there is no P_LoS to compare with.
    change_of(setup.p_los_of(setup.field), p_los)
}

fn roof_line(setup: &Setup<'_>, p_los: f64, uncertain: &Uncertain) -> BudgetLine {
    let steps = height_steps(uncertain.roofs_m).unwrap_or(0);
    let raised = |by: i32| match MovedRoofs::by_building(setup.field, |_| by) {
        Some(moved) => change_of(setup.p_los_of(&moved.field), p_los),
        None => Err("a roof would leave the proven range".into()),
    };
    BudgetLine {
        part: Part::RoofHeights,
        changed: format!("all roofs {} m higher and lower", crate::quantity::tidy(uncertain.roofs_m)),
        change: largest([steps, -steps].into_iter().map(raised)),
    }
}

/// Returns the effect of flat roofs in place of shaped ones; `None` if all roofs are flat.
fn shape_line(setup: &Setup<'_>, p_los: f64) -> Option<BudgetLine> {
    let flat = setup.field.with_flat_roofs()?;
    let changed = "all roofs flat, each as high as it is highest".into();
    Some(BudgetLine { part: Part::RoofShapes, changed, change: change_of(setup.p_los_of(&flat), p_los) })
}

/// Returns the effect of the earth's curvature as radio sees it if the earth was taken as flat,
/// else the effect of a flat earth.
fn earth_line(setup: &Setup<'_>, p_los: f64) -> BudgetLine {
    let is_flat = (setup.options)(setup.field).is_ok_and(|options| options.curvature.is_none());
    let curvature = if is_flat { Curvature::of_earth_k(RADIO_K) } else { None };
    let options = |field: &HeightField| Ok(MapOptions { curvature, ..(setup.options)(field)? });
    let changed = if is_flat { "curved, with the refraction of radio (K = 4/3)" } else { "a flat earth" };
    BudgetLine {
        part: Part::Earth,
        changed: changed.into(),
        change: change_of(Setup { options: &options, ..*setup }.p_los(), p_los),
    }
}

/// Returns the standard deviation of P_LoS among cities of one kind, seen from the same places.
fn city_line(setup: &Setup<'_>, cities: &[HeightField]) -> BudgetLine {
    let values: Vec<f64> = cities.iter().filter_map(|city| setup.p_los_of(city).ok().flatten()).collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let (changed, change) = if cities.is_empty() {
        ("another city of the same kind".to_string(), Err("the scene is one real city".to_string()))
    } else if values.len() < 2 {
        ("other cities of the same kind".to_string(), Err("no UAV is clear of their roofs".to_string()))
    } else {
        (format!("{} other cities of the same kind: standard deviation", values.len()), Ok(variance.sqrt()))
    };
    BudgetLine { part: Part::Cities, changed, change }
}
