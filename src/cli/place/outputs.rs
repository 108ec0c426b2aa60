//! The files of a search, and what is said of it.

use std::path::{Path, PathBuf};

use super::super::interrupt;
use super::args::PlaceArgs;
use super::goal::{Goal, Measure, Whom};
use super::{picture, winner_map};
use crate::coverage::{Mapper, Uav};
use crate::error::{Error, Result};
use crate::export::{Batch, Format, with_suffix};
use crate::formats::{Bands, GeoTiffImage, TiffLayout, encode_geotiff};
use crate::placement::PlaceGrid;
use crate::quantity::tidy;
use crate::report::{PlaceFacts, PlaceReport, PlaceValue, Timing};
use crate::scene::Scene;
use crate::words::pretty;

/// Nodata of the raster.
const NODATA: f32 = -9999.0;

/// Everything that outputs are made from.
#[derive(Debug)]
pub(super) struct Writer<'a> {
    pub(super) args: &'a PlaceArgs,
    pub(super) goal: Goal,
    pub(super) scene: &'a Scene,
    pub(super) mapper: &'a Mapper<'a>,
    pub(super) report: &'a PlaceReport,
    pub(super) places: Option<&'a PlaceGrid>,
    pub(super) heat: &'a [(usize, f32)],
    /// The winner, or those chosen together.
    pub(super) winners: &'a [Uav],
    pub(super) timing: Timing,
}

impl Writer<'_> {
    /// Writes all files of a run, or none, and returns their names.
    pub(super) fn write(&self, outputs: &[(PathBuf, Format)], map: Option<&(PathBuf, Format)>) -> Result<Vec<PathBuf>> {
        interrupt::begin_writing();
        let mut batch = Batch::new(self.args.out.overwrite);
        for (path, format) in outputs {
            self.add(&mut batch, path, *format)?;
        }
        if let Some((path, format)) = map {
            winner_map::add(self, &mut batch, path, *format)?;
        }
        Ok(batch.commit()?)
    }

    /// Adds the files of one output to a batch.
    fn add(&self, batch: &mut Batch, path: &Path, format: Format) -> Result<()> {
        interrupt::check()?;
        match format {
            Format::Json => Ok(batch.add(path, pretty(&self.report.document(Some(self.timing))).as_bytes())?),
            Format::GeoJson => Ok(batch.add(path, pretty(&self.report.geojson()).as_bytes())?),
            Format::Csv => {
                batch.add(path, &self.args.out.table(&self.report.table())?)?;
                Ok(batch.add(&with_suffix(path, ".json"), pretty(&self.report.provenance()).as_bytes())?)
            }
            Format::Png | Format::Svg | Format::Pdf | Format::GeoTiff => {
                let Some(places) = self.places else {
                    return Err(Error::usage(109, "only candidates on a grid make a picture or a raster"));
                };
                let bytes = match format {
                    Format::GeoTiff => self.raster(places)?,
                    _ => picture::draw(self, places, format)?,
                };
                Ok(batch.add(path, &bytes)?)
            }
            _ => Ok(()),
        }
    }

    /// The value of each place, `none` where there is no candidate.
    pub(super) fn values(&self, places: &PlaceGrid, none: f32) -> Vec<f32> {
        let mut values = vec![none; places.grid.n_cells()];
        self.heat.iter().for_each(|(place, value)| values[*place] = *value);
        values
    }

    fn raster(&self, places: &PlaceGrid) -> Result<Vec<u8>> {
        let values = self.values(places, NODATA);
        Ok(encode_geotiff(&GeoTiffImage {
            georef: &places.grid,
            bands: Bands::Float(vec![(self.quantity().0.to_string(), &values)]),
            nodata: Some(f64::from(NODATA)),
            palette: None,
            metadata: &[("SKYSHED".into(), self.report.provenance().to_string())],
            layout: TiffLayout::Cog,
        })?)
    }

    /// What is shown over each place, and its unit.
    pub(super) fn quantity(&self) -> (&'static str, &'static str) {
        match (self.goal.measure, self.goal.at_least) {
            (Measure::Margin, _) => ("Margin of the worst receiver, at most", "m"),
            (Measure::Share, Some(_)) => ("Least UAV height that reaches the share", "m"),
            (Measure::Share, None) if self.report.heights.len() == 1 => ("P_LoS", ""),
            (Measure::Share, None) => ("P_LoS at the best height", ""),
        }
    }
}

/// The height of a place in words.
pub(super) fn height_words(place: &PlaceFacts) -> String {
    match place.height_agl_m {
        Some(agl) => format!("{} m above ground", tidy(agl)),
        None => format!("{} m above the datum", tidy(place.height_amsl_m)),
    }
}

/// What a place is worth in words, over some receivers.
fn value_words(place: &PlaceFacts, receivers: &str) -> String {
    match place.value {
        PlaceValue::Counts(score) => match score.share() {
            Some(p) => format!("P_LoS {p:.4}, {} of {} {receivers}", score.seen, score.wanted),
            None => "P_LoS undefined".into(),
        },
        PlaceValue::Weighted(score) => {
            score.share().map_or("P_LoS undefined".into(), |p| format!("weighted P_LoS {p:.4}"))
        }
        PlaceValue::Margin(Some(m)) if m.margin_m.is_finite() => {
            format!("worst margin {} m", tidy(f64::from(m.margin_m)))
        }
        PlaceValue::Margin(_) => "no receiver height is enough for the worst".into(),
    }
}

/// Where a place is in words, with its name if it has one.
fn at_words(place: &PlaceFacts) -> String {
    let name = place.id.as_ref().map_or(String::new(), |id| format!("{id} "));
    name + &place.position().in_words()
}

/// A place in words.
fn place_words(place: &PlaceFacts, receivers: &str) -> String {
    let value = value_words(place, receivers);
    format!("{} at {} over {}: {value}", height_words(place), at_words(place), place.placement)
}

/// The receivers that count for a goal.
fn wanted(report: &PlaceReport, goal: Goal) -> String {
    let receivers = if report.receivers == "all" { "ground and roof" } else { report.receivers };
    let area = if goal.whom == Whom::Area { " in the area" } else { "" };
    format!("{receivers} receivers{area}")
}

/// All of them, at any distance.
fn all_wanted(report: &PlaceReport, goal: Goal) -> String {
    let weight = if goal.whom == Whom::Weights { "the weight of " } else { "" };
    format!("{weight}all {}{}", wanted(report, goal), in_range_or_not(report))
}

/// Whom a share is a share of, where a range says who may be seen.
fn in_range_or_not(report: &PlaceReport) -> &'static str {
    if report.radius_m.is_some() { ", in range or not" } else { "" }
}

/// What is said of a search: the winner, the refined place, several together with the bound and the gap, what was left out.
pub(super) fn in_words(report: &PlaceReport, goal: Goal) -> Vec<String> {
    let receivers = wanted(report, goal) + in_range_or_not(report);
    let mut lines = vec![match &report.winner {
        Ok(winner) => format!("best of {} candidates: {}", report.n_candidates, place_words(winner, &receivers)),
        Err(reason) => format!("no winner among {} candidates: {reason}", report.n_candidates),
    }];
    let refined = |(place, tried): &(PlaceFacts, u64)| {
        format!("refined ({tried} more places): {}", place_words(place, &receivers))
    };
    lines.extend(report.refined.iter().map(refined));
    if let Some(several) = &report.several {
        let share = |v: u128| several.share(v).map_or("undefined".to_string(), |p| format!("{p:.4}"));
        let chosen: Vec<String> = several.places.iter().map(at_words).collect();
        let gap = several.cover.gap().map_or("undefined".to_string(), |gap| format!("{:.2} %", 100.0 * gap));
        lines.push(format!(
            "{} UAVs see together {} of {}; no {} of these candidates see more than {} (gap {gap}): {}",
            several.places.len(),
            share(several.cover.covered()),
            all_wanted(report, goal),
            several.count,
            share(several.cover.bound),
            chosen.join(", ")
        ));
    }
    let skipped: Vec<String> =
        report.skipped.reasons().iter().filter(|r| r.1 > 0).map(|(why, n)| format!("{n} {why}")).collect();
    if !skipped.is_empty() {
        lines.push(format!("left out: {}", skipped.join(", ")));
    }
    lines
}
