//! Common parts of all documents.
//!
//! Keys are stable within a version. A number that does not exist is null with a reason, never 0 or
//! NaN.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::command::CommandFacts;
use crate::city::Source;
use crate::coverage::Tally;
use crate::digest::Sha256;
use crate::error::Warning;
use crate::los::Method;
use crate::raster::GeoRef;
use crate::words::version;

/// Facts of a run over a scene, for the head of its document.
#[derive(Debug, Clone)]
pub(crate) struct RunFacts {
    /// Command line and question.
    pub(crate) command: CommandFacts,
    /// Engine that decided line of sight; `None` if the run decided no link.
    pub(crate) method: Option<Method>,
    pub(crate) scene_name: String,
    /// Grid of receivers.
    pub(crate) grid: GeoRef,
    /// Input files.
    pub(crate) sources: Vec<Source>,
    /// Seed of a generated city.
    pub(crate) seed: Option<u64>,
    pub(crate) warnings: Vec<Warning>,
    /// Hash of all that the run depends on; `None` if the run cannot be resumed.
    pub(crate) unit: Option<String>,
}

/// Name of the method of a run that decided no link: it drew, described, or compared saved results.
const NO_METHOD: &str = "none";

impl RunFacts {
    /// Returns the word for the method in documents and tables.
    pub(crate) fn method_name(&self) -> String {
        self.method.map_or(NO_METHOD.into(), |method| method.name().into_owned())
    }

    /// Returns the method and its accuracy in words, for captions.
    pub(crate) fn method_in_words(&self) -> String {
        self.method.map_or(NO_METHOD.into(), Method::in_words)
    }

    /// Returns the length of a unit of the grid's reference system \[m\].
    pub(crate) fn unit_m(&self) -> f64 {
        self.grid.meters_per_unit()
    }

    /// Returns the head of a document.
    pub(crate) fn head(&self, schema: &'static str) -> Head {
        let (grid, unit) = (&self.grid, self.unit_m());
        let scene = SceneFacts {
            name: self.scene_name.clone(),
            cols: grid.n_cols(),
            rows: grid.n_rows(),
            cell_m: [grid.cell_width() * unit, grid.cell_height() * unit],
            extent: [grid.x_min(), grid.y_min(), grid.x_max(), grid.y_max()],
            crs: grid.crs().map(crate::raster::Crs::label),
            seed: self.seed,
            sources: SourceFacts::of(&self.sources),
        };
        Head {
            schema,
            version: version(),
            command: self.command.clone(),
            method: self.method_name(),
            exact: self.method.map(Method::is_exact),
            scene,
            unit: self.unit.clone(),
        }
    }

    /// Returns the provenance of a result, for answers whose document holds no more.
    pub(crate) fn provenance(&self, schema: &'static str) -> Provenance {
        Provenance { head: self.head(schema), warnings: warnings_of(&self.warnings) }
    }
}

/// Head of every document.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct Head {
    /// Kind of document and its version.
    schema: &'static str,
    /// Version of the program.
    version: &'static str,
    #[serde(flatten)]
    command: CommandFacts,
    /// Engine that decided line of sight; `none` where no link was decided.
    method: String,
    /// true if the answer is exact on the scene as it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) exact: Option<bool>,
    /// The city.
    scene: SceneFacts,
    /// Hash of all that the run depends on; absent for a run that cannot be resumed.
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<String>,
}

/// The city of a run.
#[derive(Debug, Clone, Serialize, JsonSchema)]
struct SceneFacts {
    /// Name in titles.
    name: String,
    /// Columns of cells.
    cols: usize,
    /// Rows of cells.
    rows: usize,
    /// Width and height of a cell [m].
    cell_m: [f64; 2],
    /// West, south, east, north [units of the reference system].
    extent: [f64; 4],
    /// Reference system; null for local coordinates in meters.
    crs: Option<String>,
    /// Seed of a generated city; null for a city in a file.
    seed: Option<u64>,
    /// Files that were read.
    sources: Vec<SourceFacts>,
}

/// A file that was read.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct SourceFacts {
    /// Path as the user wrote it.
    path: String,
    /// SHA-256 of the bytes; null for a file above 64 MB that the user did not ask to hash.
    sha256: Option<String>,
}

impl SourceFacts {
    pub(crate) fn of(sources: &[Source]) -> Vec<SourceFacts> {
        let facts = |s: &Source| SourceFacts { path: s.path.clone(), sha256: s.sha256.clone() };
        sources.iter().map(facts).collect()
    }
}

/// A warning: a finding that did not stop the work.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct WarningFacts {
    /// Stable code, such as W320.
    code: String,
    /// The finding, and what was done instead.
    text: String,
}

/// Converts warnings for documents.
pub(crate) fn warnings_of(warnings: &[Warning]) -> Vec<WarningFacts> {
    warnings.iter().map(|w| WarningFacts { code: w.code(), text: w.to_string() }).collect()
}

/// A document that holds only the provenance of a result.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Provenance {
    #[serde(flatten)]
    pub(crate) head: Head,
    /// Warnings.
    pub(crate) warnings: Vec<WarningFacts>,
}

/// Seconds spent.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
pub(crate) struct Timing {
    /// Reading and checking inputs.
    pub(crate) read: f64,
    /// Building and preparing the height field: zones, trials of simpler forms, the engine.
    pub(crate) build: f64,
    /// Deciding line of sight, and writing masks that are written while they are computed.
    pub(crate) los: f64,
    /// Encoding and writing all other outputs.
    pub(crate) write: f64,
    /// Sum of all parts.
    pub(crate) total: f64,
}

impl Timing {
    /// Sets the total to the sum of the parts, for an answer that writes nothing.
    pub(crate) fn summed(self) -> Timing {
        Timing { total: self.read + self.build + self.los + self.write, ..self }
    }

    /// Adds the time of writing and the total.
    pub(crate) fn with(self, spent: Spent) -> Timing {
        Timing { write: spent.write, total: spent.total, ..self }
    }
}

/// Numbers of receivers in range and in line of sight.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct Share {
    /// Receivers in range.
    pub(crate) receivers: u64,
    /// Receivers in line of sight.
    pub(crate) los: u64,
    /// Share of the receivers in line of sight; null without a receiver.
    pub(crate) p_los: Option<f64>,
    /// Reason for having no share.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) reason: Option<String>,
}

impl From<&Tally> for Share {
    fn from(tally: &Tally) -> Self {
        let p_los = tally.p_los();
        let reason = p_los.is_none().then(|| tally.reason().to_string());
        Share { receivers: tally.receivers, los: tally.los, p_los, reason }
    }
}

/// Serializes a document.
pub(crate) fn document_of(document: &impl Serialize) -> Value {
    serde_json::to_value(document).unwrap_or(Value::Null)
}

/// Returns a digest in the form of documents: `sha256:` and its hexadecimal digits.
pub(crate) fn digest_words(hasher: Sha256) -> String {
    format!("sha256:{}", hasher.hex_digits())
}

/// Times of writing, known only after everything is written.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Spent {
    /// Encoding and writing \[s\].
    pub(crate) write: f64,
    /// Everything \[s\].
    pub(crate) total: f64,
}
