//! `--repairs FILE`: what was mended or left out while reading footprints, thing by thing.
//!
//! Any command that reads footprints takes the flag. The list is kept while the command runs and written when it has
//! succeeded, so that a run that fails leaves nothing behind.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::args::SceneArgs;
use super::messages;
use super::plan::input_paths;
use crate::error::{Error, Result};
use crate::export::{Batch, Format, OutputRules, as_text, check_outputs, encode_table, with_suffix};
use crate::quantity::counted;
use crate::read::{Repair, VectorFormat};
use crate::report::{RunFacts, repairs_geojson, repairs_table};
use crate::scene::FoundRepairs;
use crate::words::pretty;

/// Refuses a list of a scene that is no file of footprints, and a file that cannot be written, before any work.
///
/// # Errors
/// E116; E104–E106, as for every output.
pub(super) fn check(args: &SceneArgs) -> Result<()> {
    target(args).map(|_| ())
}

/// The file and its format, if there is to be one.
fn target(args: &SceneArgs) -> Result<Option<(PathBuf, Format)>> {
    let Some(path) = &args.repairs else { return Ok(None) };
    let extension = Path::new(&args.scene).extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if VectorFormat::of_extension(&extension).is_none() {
        return Err(Error::usage(116, "`--repairs` has no meaning for a scene that is no file of footprints"));
    }
    let rules = OutputRules {
        allowed: &[Format::Csv, Format::GeoJson],
        inputs: &input_paths(args),
        overwrite: is_typed(args, "overwrite"),
        bare: false,
    };
    let checked = check_outputs(std::slice::from_ref(path), rules)?;
    if let Some(other) = args.paths.iter().find(|other| is_same_file(path, other)) {
        let text = format!("cannot write {}: it is {}, which this run needs too", path.display(), other.display());
        return Err(Error::usage(105, text).with_hint("give the repairs a name of their own"));
    }
    Ok(checked.into_iter().next())
}

/// Writes the list that was kept.
///
/// # Errors
/// E116 if no footprints were read; E106, E401 if the file cannot be written.
pub(super) fn write(args: &SceneArgs, command: Vec<String>) -> Result<()> {
    let Some(path) = &args.repairs else { return Ok(()) };
    let Some(FoundRepairs { repairs, facts }) = args.found_repairs.get() else {
        return Err(Error::usage(116, "`--repairs` has no meaning here: no footprints were read"));
    };
    let facts = RunFacts { command, ..facts.clone() };
    let mut provenance = facts.provenance("skyshed/repairs/1", None);
    provenance["repairs"] = repairs.len().into();
    let mut batch = Batch::new(is_typed(args, "overwrite"));
    add(&mut batch, path, (repairs, &layer_of(args)), (&facts, &provenance), is_typed(args, "csv_text"))?;
    let files = batch.commit()?;
    if !is_typed(args, "quiet") {
        messages::note(&format!("{} mended or left out", counted(repairs.len() as u64, "thing", "things")));
        messages::wrote(&files, false);
    }
    Ok(())
}

fn add(
    batch: &mut Batch,
    path: &Path,
    (repairs, layer): (&[Repair], &str),
    (facts, provenance): (&RunFacts, &Value),
    is_text: bool,
) -> Result<()> {
    if Format::of(path)? == Format::GeoJson {
        let document = repairs_geojson(repairs, layer, &facts.grid, provenance);
        return Ok(batch.add(path, format!("{document}\n").as_bytes())?);
    }
    let table = repairs_table(repairs, layer);
    batch.add(path, &encode_table(&if is_text { as_text(&table) } else { table })?)?;
    Ok(batch.add(&with_suffix(path, ".json"), pretty(provenance).as_bytes())?)
}

/// The layer that was read: as typed, else the file's own name, which stands for its only one.
fn layer_of(args: &SceneArgs) -> String {
    let stem = || Path::new(&args.scene).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    args.layer.clone().unwrap_or_else(stem)
}

fn is_typed(args: &SceneArgs, name: &str) -> bool {
    args.typed.iter().any(|typed| typed == name)
}

/// Whether two paths are one file, which need not exist yet.
fn is_same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        (std::fs::canonicalize(folder).ok(), path.file_name().map(std::ffi::OsStr::to_os_string))
    };
    place(a) == place(b)
}
