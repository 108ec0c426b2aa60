//! Results of a run: files, their looks, and the effort.

use crate::FilePath;
use crate::part::{group, part};

part! {
    /// Files of a run.
    #[cfg_attr(feature = "words", command(next_help_heading = "Output"))]
    pub struct Files, SetFiles {
        /// File to write; repeat for more
        #[arg(short, long = "output", value_name = "FILE")]
        output: Vec<FilePath>,
        /// Print one JSON document on standard output
        #[arg(long)]
        json: bool,
    }
}

part! {
    /// Rules of writing.
    #[cfg_attr(feature = "words", command(next_help_heading = "Output"))]
    pub struct Writing, SetWriting {
        /// Replace files that exist
        #[arg(long)]
        overwrite: bool,
        /// Write cells of tables that a spreadsheet would run (they begin with =, +, - or @ and are no numbers) as text, behind
        /// a ' (docs/tables.md)
        #[arg(long, hide_short_help = true)]
        csv_text: bool,
    }
}

part! {
    /// Effort of a run.
    #[cfg_attr(feature = "words", command(next_help_heading = "Output"))]
    pub struct Effort, SetEffort {
        /// Threads to use, at most four for each core; default one for each core
        #[arg(short = 'j', long = "threads", value_name = "N", value_parser = clap::value_parser!(u16).range(1..),
              hide_short_help = true)]
        threads: Option<u16>,
        /// Most memory that the run may take, such as 800M or 4G
        ///
        /// By default it is what the machine, the container and the limit of address space have left. `map` sweeps a raster
        /// that takes more strip by strip. Everything else that takes more is refused, or ended.
        #[arg(long, value_name = "SIZE", value_parser = crate::words::memory_size, allow_hyphen_values = true, hide_short_help = true)]
        max_memory: Option<u64>,
        /// Say nothing but errors
        #[arg(short, long, hide_short_help = true)]
        quiet: bool,
    }
}

group! {
    /// Files of a run, rules of writing, and the effort.
    pub struct OutputOptions {
        /// Files.
        files: Files,
        /// Rules of writing.
        writing: Writing,
        /// Effort.
        effort: Effort,
    }
}

crate::holds!(OutputOptions: files Files, writing Writing, effort Effort);

part! {
    /// Looks of pictures.
    #[cfg_attr(feature = "words", command(next_help_heading = "Picture"))]
    pub struct PictureOptions, SetPictureOptions {
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
}
