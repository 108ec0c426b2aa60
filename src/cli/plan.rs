//! What was typed, resolved: how scenes are read, where UAVs and receivers are, files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::args::{Base, Command, HeightUnitArg, Missing, Nodata, SceneArgs};
use crate::city::{NodataAs, Site};
use crate::crs;
use crate::error::{Error, Result, Warning};
use crate::export::{Format, OutputRules, check_outputs};
use crate::quantity::{Height, parse_number};
use crate::read::{BaseRule, DataAreaChoice, HeightUnit, MissingHeight};
use crate::scene::{Scene, SceneOptions, built_up};
use crate::uav::UavsAsked;

/// Refuses a scene that is no file but the name of a built-up environment, which stands behind `itu:`.
///
/// # Errors
/// E301.
pub(super) fn check_scene(command: &Command) -> Result<()> {
    let more = if let Command::Plos(args) = command { &args.more_cities[..] } else { &[] };
    for scene in std::iter::once(&command.scene().scene).chain(more) {
        let word = format!("itu:{scene}");
        if matches!(built_up(word.as_ref()), Some(Ok(_))) && !Path::new(scene).exists() {
            let text = format!("cannot read {scene}: no such file");
            return Err(Error::file(301, text).with_hint(format!("`{word}` is a generated city")));
        }
    }
    Ok(())
}

/// How a scene is read.
pub(super) fn scene_options(args: &SceneArgs) -> Result<SceneOptions> {
    let crs = args.crs.as_deref().map(crs::parse).transpose();
    let data_area = args.data_area.as_ref().map(|word| match word.to_str() {
        Some("auto") => DataAreaChoice::Auto,
        Some("all") => DataAreaChoice::All,
        _ => DataAreaChoice::Within(word.into()),
    });
    Ok(SceneOptions {
        terrain: args.terrain.clone(),
        ground_m: args.ground,
        building_threshold_m: args.building_threshold,
        height_field: args.height_field.clone(),
        top_field: args.top_field.clone(),
        height_unit: args.height_unit.map(|unit| match unit {
            HeightUnitArg::M => HeightUnit::Meters,
            HeightUnitArg::Ft => HeightUnit::Feet,
        }),
        levels_field: args.levels_field.clone(),
        layer: args.layer.clone(),
        missing: args.missing.map(|missing| match missing {
            Missing::Fail => MissingHeight::Fail,
            Missing::Drop => MissingHeight::Drop,
            Missing::Levels => MissingHeight::Levels,
            Missing::Median => MissingHeight::Median,
        }),
        base: args.base.map(|base| match base {
            Base::Lowest => BaseRule::Lowest,
            Base::Mean => BaseRule::Mean,
            Base::Highest => BaseRule::Highest,
        }),
        data_area,
        extent: args.extent,
        cell_m: args.cell,
        crs: crs.map_err(|e| Error::usage(115, format!("`--crs`: {e}")))?,
        project: args.project.clone(),
        size_m: args.size,
        margin_m: args.margin_m,
        seed: Some(args.seed),
        nodata_as: args.nodata_as.map(|nodata| match nodata {
            Nodata::Block => NodataAs::Block,
            Nodata::Clear => NodataAs::Clear,
        }),
        hash: args.hash,
        repairs: args.repairs.is_some().then(|| Arc::clone(&args.found_repairs)),
    })
}

/// Reads a scene without building it.
pub(super) fn read_scene(args: &SceneArgs, warnings: &mut Vec<Warning>) -> Result<crate::city::City> {
    scene_options(args)?.read(args.scene.as_ref(), warnings)
}

/// Reads a scene and builds its height field.
pub(super) fn ready(args: &SceneArgs) -> Result<Scene> {
    scene_options(args)?.open(&args.scene)
}

/// The input files that a scene names, for the refusal to overwrite them.
pub(super) fn input_paths(args: &SceneArgs) -> Vec<PathBuf> {
    std::iter::once(PathBuf::from(&args.scene)).chain(args.terrain.clone()).chain(args.data_area_file()).collect()
}

/// A UAV as typed: `X,Y,H`.
pub(super) fn parse_uav(text: &str, id: String) -> Result<Site> {
    let wrong = |found: String| {
        Error::usage(102, format!("cannot read `--uav {text}`: {found}"))
            .with_hint("write X,Y,H, for example 500,500,100 or 691549.7,5334762.2,30roof")
    };
    let parts: Vec<&str> = text.split(',').collect();
    let [x, y, h] = parts[..] else { return Err(wrong(format!("found {} values, wanted X,Y,H", parts.len()))) };
    let x = parse_number(x).map_err(|e| wrong(format!("x: {e}")))?;
    let y = parse_number(y).map_err(|e| wrong(format!("y: {e}")))?;
    Ok(Site { id, x, y, height: h.parse().map_err(wrong)? })
}

/// A receiver as typed: `X,Y[,H]`.
pub(super) fn parse_receiver(text: &str, rx_height_m: f64) -> Result<(f64, f64, Height)> {
    let wrong = |found: String| {
        Error::usage(103, format!("cannot read `--rx {text}`: {found}"))
            .with_hint("write X,Y or X,Y,H, for example 630,480 or 620,480,1.5roof")
    };
    let parts: Vec<&str> = text.split(',').collect();
    let (x, y, h) = match parts[..] {
        [x, y] => (x, y, None),
        [x, y, h] => (x, y, Some(h)),
        _ => return Err(wrong(format!("found {} values, wanted X,Y or X,Y,H", parts.len()))),
    };
    let x = parse_number(x).map_err(|e| wrong(format!("x: {e}")))?;
    let y = parse_number(y).map_err(|e| wrong(format!("y: {e}")))?;
    let height = h.map_or(Ok(Height::AboveGround(rx_height_m)), str::parse).map_err(wrong)?;
    Ok((x, y, height))
}

/// The outputs, and after them the table of `--csv FILE`, all checked together.
pub(super) fn outputs_with_table(
    outputs: &[PathBuf],
    csv: Option<&PathBuf>,
    rules: OutputRules<'_>,
) -> Result<Vec<(PathBuf, Format)>> {
    if let Some(path) = csv.filter(|path| !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"))) {
        let text = format!("cannot write {}: `--csv` writes a table", path.display());
        return Err(Error::usage(105, text).with_hint("give it a name that ends in .csv"));
    }
    let all: Vec<PathBuf> = outputs.iter().chain(csv).cloned().collect();
    Ok(check_outputs(&all, rules)?)
}

/// Where UAVs are told: as typed, and in a table.
pub(super) fn uavs_asked(
    typed: &[String],
    table: Option<&PathBuf>,
    (skips_bad, hash): (bool, bool),
) -> Result<UavsAsked> {
    let typed = typed.iter().enumerate().map(|(k, text)| parse_uav(text, (k + 1).to_string()));
    Ok(UavsAsked { typed: typed.collect::<Result<_>>()?, table: table.cloned(), skips_bad, hash })
}
