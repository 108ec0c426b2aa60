//! Where results go, how they look, how much is said, and what a run may take.

use std::path::PathBuf;

use clap::Args;

use super::words::memory_size;
use crate::answer::Output;
use crate::cli::failure::{Result, refusal, refusal_with};
use crate::export::{Format, OutputRules, check_outputs};
use crate::picture::Look;

/// Where results go and what a run may take.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputArgs {
    #[arg(short, long = "output", value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
    /// Print one JSON document on standard output
    #[arg(long)]
    pub(crate) json: bool,
    /// Replace files that exist
    #[arg(long)]
    pub(crate) overwrite: bool,
    /// Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind
    /// a ' (docs/tables.md)
    #[arg(long, hide_short_help = true)]
    pub(crate) csv_text: bool,
    /// Threads to use, at most four for each core; default one for each core
    #[arg(short = 'j', long = "threads", value_name = "N", value_parser = clap::value_parser!(u16).range(1..),
          hide_short_help = true)]
    pub(crate) threads: Option<u16>,
    /// Most memory that the run may take, such as 800M or 4G; default: what the machine, the container and the limit of
    /// address space have left. `map` sweeps a raster that takes more strip by strip; what cannot do with it is refused, or
    /// ended
    #[arg(long, value_name = "SIZE", value_parser = memory_size, allow_hyphen_values = true, hide_short_help = true)]
    pub(crate) max_memory: Option<u64>,
    /// Say nothing but errors
    #[arg(short, long, hide_short_help = true)]
    pub(crate) quiet: bool,
}

impl OutputArgs {
    /// The files to write with their formats, checked before any work.
    ///
    /// # Errors
    /// E104–E106.
    pub(crate) fn checked(&self, allowed: &[Format], inputs: &[PathBuf]) -> Result<Vec<Output>> {
        self.checked_with(None, allowed, inputs)
    }

    /// The files of `-o`, and after them the table of `--csv FILE`, all checked together.
    pub(crate) fn checked_with(
        &self,
        csv: Option<&PathBuf>,
        allowed: &[Format],
        inputs: &[PathBuf],
    ) -> Result<Vec<Output>> {
        if let Some(path) = csv.filter(|path| !path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"))) {
            let text = format!("cannot write {}: `--csv` writes a table", path.display());
            return Err(refusal_with(105, text, "give it a name that ends in .csv: `--csv NAME.csv`"));
        }
        let all: Vec<PathBuf> = self.output.iter().chain(csv).cloned().collect();
        Ok(check_outputs(&all, OutputRules { allowed, inputs, overwrite: self.overwrite, bare: false })?)
    }

    /// How files without pictures look.
    pub(crate) fn look(&self) -> Look {
        Look { csv_text: self.csv_text, ..Look::default() }
    }

    /// Whether a document goes to standard output.
    pub(crate) fn is_told(&self) -> bool {
        self.json || self.output.iter().any(|path| path.as_os_str() == "-")
    }
}

/// How pictures look.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Picture")]
pub(crate) struct PictureArgs {
    /// Title of the picture, or of the page
    #[arg(long, value_name = "TEXT", hide_short_help = true)]
    title: Option<String>,
    /// Attribution line in the caption; default: the `attribution` member of the GeoJSON file
    #[arg(long, value_name = "TEXT", hide_short_help = true)]
    attribution: Option<String>,
    /// Width of the picture, 100 to 10000 [px]; the height follows, and words grow with it. Default: as it is laid out
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(100..=10_000), hide_short_help = true)]
    width: Option<u32>,
    /// Pixels of the width per inch of paper, 10 to 2400: the size in print, of .svg and .pdf too; default 200
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=2400), hide_short_help = true)]
    dpi: Option<u32>,
}

impl PictureArgs {
    /// How files look. Where no picture is made, its words and its size would be lost in silence.
    ///
    /// # Errors
    /// E116.
    pub(crate) fn look(&self, out: &OutputArgs, outputs: &[Output]) -> Result<Look> {
        let has = |wanted: fn(Format) -> bool| outputs.iter().any(|(_, format)| wanted(*format));
        let (has_picture, has_page) = (has(Format::is_picture), has(|format| format == Format::Html));
        let words = [("--title", self.title.is_some()), ("--attribution", self.attribution.is_some())];
        let sizes = [("--width", self.width.is_some()), ("--dpi", self.dpi.is_some())];
        let lost_words = words.iter().filter(|_| !has_picture && !has_page);
        match lost_words.chain(sizes.iter().filter(|_| !has_picture)).find(|(_, is_typed)| *is_typed) {
            Some((flag, _)) => {
                let text = format!("`{flag}` has no meaning without a .png, .svg or .pdf output");
                Err(refusal(116, text))
            }
            None => Ok(Look {
                title: self.title.clone(),
                attribution: self.attribution.clone(),
                width_px: self.width,
                dpi: self.dpi,
                csv_text: out.csv_text,
            }),
        }
    }
}
