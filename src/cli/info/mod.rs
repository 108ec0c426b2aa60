//! `skyshed info`: what a file is, what is wrong with it, and what to do with it.
//!
//! A scene is told in full; files of UAVs and tracks, and what this program wrote, by what they hold. Any other file is
//! refused by the reader of scenes, which says what kind of file it is.

mod needs;
mod output;
mod places;
mod scene;
mod tiles;

use std::path::Path;

use serde_json::Value;

use super::args::{InfoArgs, Missing};
use super::messages;
use crate::error::{Error, Result};
use crate::export::{Batch, Format, OutputRules, check_outputs};
use crate::words::pretty;
use output::Output;
use places::Places;

pub(super) fn run(args: &InfoArgs, command: Vec<String>) -> Result<()> {
    // What is wrong with a file is told, not refused.
    let mut args = args.clone();
    args.scene.missing.get_or_insert(Missing::Drop);
    let args = &args;
    let path = Path::new(&args.scene.scene);
    if let Some(output) = Output::of(path) {
        return answer(args, &output.document(&command), &output.text());
    }
    if let Some(places) = Places::of(&args.scene)? {
        return answer(args, &places.document(&command), &places.text());
    }
    scene::run(args, command)
}

/// Flags that say something of a scene.
const OF_SCENES: [&str; 18] = [
    "uav",
    "zones",
    "tile",
    "terrain",
    "ground",
    "building_threshold",
    "height_field",
    "top_field",
    "height_unit",
    "levels_field",
    "missing",
    "base",
    "data_area",
    "layer",
    "extent",
    "cell",
    "project",
    "repairs",
];

/// Answers for a file that is no scene: its document, also as a file, or its text.
///
/// # Errors
/// E116 for a flag that only a scene can use; E104–E106 for outputs.
fn answer(args: &InfoArgs, document: &Value, text: &str) -> Result<()> {
    let path = Path::new(&args.scene.scene);
    if let Some(flag) = OF_SCENES.iter().find(|flag| args.scene.typed.iter().any(|typed| typed == *flag)) {
        let (flag, path) = (flag.replace('_', "-"), path.display());
        return Err(Error::usage(116, format!("`--{flag}` has no meaning for {path}, which is no scene")));
    }
    let rules = OutputRules {
        allowed: &[Format::Json, Format::Stdout],
        inputs: &[path.to_path_buf()],
        overwrite: args.out.overwrite,
        bare: false,
    };
    let outputs = check_outputs(&args.output, rules)?;
    let mut batch = Batch::new(args.out.overwrite);
    for (path, _) in outputs.iter().filter(|(_, format)| *format == Format::Json) {
        batch.add(path, pretty(document).as_bytes())?;
    }
    messages::wrote(&batch.commit()?, args.out.quiet);
    if args.out.json || outputs.iter().any(|(_, format)| *format == Format::Stdout) {
        return messages::answer(&pretty(document));
    }
    messages::answer(text)
}
