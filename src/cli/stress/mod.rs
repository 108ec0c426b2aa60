//! `skyshed stress`: where methods fail, on families of scenes; and where the answers of a scene hang by a step.
//!
//! `args` holds what can be typed, `families` tries methods on families of scenes, `scene` moves the UAV and the roofs of
//! a scene by a lattice step.

mod args;
mod families;
mod scene;

use std::path::PathBuf;

pub(super) use args::StressArgs;

use super::messages;
use crate::error::{Error, Result};
use crate::export::Format;
use crate::words::pretty;

/// Formats of `skyshed stress`.
const FORMATS: [Format; 6] = [Format::Png, Format::Svg, Format::Pdf, Format::Csv, Format::Json, Format::Stdout];

pub(super) fn run(args: &StressArgs, command: Vec<String>) -> Result<()> {
    let is_typed = |name: &&&str| args.scene.typed.iter().any(|typed| typed == **name);
    if args.scene.scene.is_empty() {
        if let Some(flag) = OF_A_SCENE.iter().find(is_typed) {
            let text = format!("`--{}` has no meaning without a scene", flag.replace('_', "-"));
            return Err(Error::usage(116, text).with_hint("skyshed stress SCENE --uav X,Y,H"));
        }
        return families::run(args, command);
    }
    if let Some(flag) = OF_FAMILIES.iter().find(is_typed) {
        return Err(Error::usage(116, format!("`--{flag}` has no meaning with a scene"))
            .with_hint("families of scenes are tried without one"));
    }
    scene::run(args, command)
}

/// Arguments that only a scene can use.
const OF_A_SCENE: [&str; 18] = [
    "uav",
    "rx_height",
    "receivers",
    "attribution",
    "radius",
    "terrain",
    "ground",
    "building_threshold",
    "height_field",
    "top_field",
    "missing",
    "extent",
    "cell",
    "crs",
    "size",
    "nodata_as",
    "hash",
    "scene",
];

/// Arguments that only families can use.
const OF_FAMILIES: [&str; 2] = ["families", "scenes"];

/// What is answered on standard output: the document, or the table if nothing else was asked for.
fn answer(
    args: &StressArgs,
    outputs: &[(PathBuf, Format)],
    document: impl FnOnce() -> serde_json::Value,
    table: impl FnOnce() -> Vec<Vec<String>>,
) -> Result<()> {
    if args.out.json || outputs.iter().any(|(_, f)| *f == Format::Stdout) {
        return messages::answer(&pretty(&document()));
    }
    if outputs.is_empty() {
        return messages::answer(&String::from_utf8_lossy(&args.out.table(&table())?));
    }
    Ok(())
}
