//! The files of a chart, and what is said of it.

use std::path::{Path, PathBuf};

use super::ChartArgs;
use super::show::Picture;
use crate::cli::{interrupt, messages};
use crate::error::{Error, ErrorClass, Result, Warning};
use crate::export::{Batch, Format, with_suffix};
use crate::words::{picture_provenance, pretty};

/// A chart of a scene or of P_LoS, ready to be written.
pub(super) struct Chart<'a> {
    pub(super) document: serde_json::Value,
    pub(super) provenance: serde_json::Value,
    pub(super) table: Vec<Vec<String>>,
    pub(super) picture: Picture,
    /// A line per contestant.
    pub(super) said: Vec<String>,
    pub(super) warnings: &'a [Warning],
    pub(super) is_interrupted: bool,
}

/// Writes all files and says what came out.
///
/// # Errors
/// If a file cannot be made or written; and, with all files written, if the user interrupted the run.
pub(super) fn write(args: &ChartArgs, chart: &Chart<'_>, outputs: &[(PathBuf, Format)]) -> Result<()> {
    interrupt::begin_writing();
    let mut batch = Batch::new(args.out.overwrite);
    for (path, format) in outputs {
        add(args, chart, &mut batch, path, *format)?;
    }
    let files = batch.commit()?;
    if !args.out.quiet {
        messages::warnings(chart.warnings);
        chart.said.iter().for_each(|line| messages::note(line));
    }
    messages::wrote(&files, args.out.quiet);
    if args.out.json || outputs.iter().any(|(_, f)| *f == Format::Stdout) {
        messages::answer(&pretty(&chart.document))?;
    } else if outputs.is_empty() {
        messages::answer(&String::from_utf8_lossy(&args.out.table(&chart.table)?))?;
    }
    if chart.is_interrupted {
        let text = "interrupted; the contestants that had their turn were written";
        return Err(Error::new(ErrorClass::Interrupted, 130, text));
    }
    Ok(())
}

/// Adds the files of one output to a batch.
fn add(args: &ChartArgs, chart: &Chart<'_>, batch: &mut Batch, path: &Path, format: Format) -> Result<()> {
    match format {
        Format::Json => Ok(batch.add(path, pretty(&chart.document).as_bytes())?),
        Format::Csv => {
            batch.add(path, &args.out.table(&chart.table)?)?;
            Ok(batch.add(&with_suffix(path, ".json"), pretty(&chart.provenance).as_bytes())?)
        }
        Format::Png | Format::Svg | Format::Pdf => {
            let form = args.words.size.form(format);
            Ok(batch.add(path, &chart.picture.draw(&form, &picture_provenance(&chart.provenance))?)?)
        }
        _ => Ok(()),
    }
}
