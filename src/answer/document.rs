//! What all documents have in common.
//!
//! Keys are stable within a version. A number that does not exist is null with a reason, never 0 or NaN.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::city::Source;
use crate::coverage::Tally;
use crate::digest::Sha256;
use crate::error::Warning;
use crate::los::Method;
use crate::raster::GeoRef;
use crate::words::version;

/// What every document says of a run over a scene.
#[derive(Debug, Clone)]
pub(crate) struct RunFacts {
    /// The words of the command line; none of a call of the library.
    pub(crate) command: Vec<String>,
    /// The engine that ran.
    pub(crate) method: Option<Method>,
    pub(crate) scene_name: String,
    /// The grid of receivers.
    pub(crate) grid: GeoRef,
    /// The input files.
    pub(crate) sources: Vec<Source>,
    /// Seed, for generated cities.
    pub(crate) seed: Option<u64>,
    pub(crate) warnings: Vec<Warning>,
    /// The question, of a map.
    pub(crate) request: Option<Value>,
    /// A hash of all that the run depends on, if it may be asked for again and found done.
    pub(crate) unit: Option<String>,
}

/// The method of a run that decided no link: it drew, described, or compared what was saved.
const NO_METHOD: &str = "none";

impl RunFacts {
    /// The word for the method in documents and tables.
    pub(crate) fn method_name(&self) -> String {
        self.method.map_or(NO_METHOD.into(), |method| method.name().into_owned())
    }

    /// The method with what it is worth, for captions.
    pub(crate) fn method_in_words(&self) -> String {
        self.method.map_or(NO_METHOD.into(), Method::in_words)
    }

    /// Length of a unit of the grid's reference system \[m\].
    pub(crate) fn unit_m(&self) -> f64 {
        self.grid.meters_per_unit()
    }

    /// The beginning of a document.
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
            request: self.request.clone(),
            method: self.method_name(),
            exact: self.method.map(Method::is_exact),
            scene,
            unit: self.unit.clone(),
        }
    }

    /// Where a result comes from, for answers whose document is no more than that.
    pub(crate) fn provenance(&self, schema: &'static str) -> Provenance {
        Provenance { head: self.head(schema), warnings: warnings_of(&self.warnings) }
    }
}

/// What every document begins with.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct Head {
    /// Kind of document and its version.
    schema: &'static str,
    /// Version of the program.
    version: &'static str,
    /// Words of the command line after the program's name; empty for a call of the library.
    command: Vec<String>,
    /// The question: every option that was set, by the name of its flag.
    #[serde(skip_serializing_if = "Option::is_none")]
    request: Option<Value>,
    /// Engine that decided line of sight; `none` where no link was decided.
    method: String,
    /// Whether the answer is exact on the scene as it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) exact: Option<bool>,
    /// The city.
    scene: SceneFacts,
    /// Hash of all that the run depends on, of a run that may be resumed.
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<String>,
}

/// The city of a run.
#[derive(Debug, Clone, Serialize, JsonSchema)]
struct SceneFacts {
    /// What it is called in titles.
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
    /// Seed of a generated city; null of a file.
    seed: Option<u64>,
    /// Files that were read.
    sources: Vec<SourceFacts>,
}

/// A file that was read.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct SourceFacts {
    /// As it was given.
    path: String,
    /// SHA-256 of its bytes; null of a file above 64 MB that was not to be hashed.
    sha256: Option<String>,
}

impl SourceFacts {
    pub(crate) fn of(sources: &[Source]) -> Vec<SourceFacts> {
        let facts = |s: &Source| SourceFacts { path: s.path.clone(), sha256: s.sha256.clone() };
        sources.iter().map(facts).collect()
    }
}

/// Something odd that did not stop the work.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct WarningFacts {
    /// Stable code, such as W320.
    code: String,
    /// What was found, and what was done instead.
    text: String,
}

/// Warnings as documents tell them.
pub(crate) fn warnings_of(warnings: &[Warning]) -> Vec<WarningFacts> {
    warnings.iter().map(|w| WarningFacts { code: w.code(), text: w.to_string() }).collect()
}

/// A document that says no more than where something is from.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Provenance {
    #[serde(flatten)]
    pub(crate) head: Head,
    /// What was odd.
    pub(crate) warnings: Vec<WarningFacts>,
}

/// Seconds spent.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
pub(crate) struct Timing {
    /// Reading and checking inputs.
    pub(crate) read: f64,
    /// Building the height field and making it ready for the UAVs: zones, simpler forms that are tried, the engine.
    pub(crate) build: f64,
    /// Deciding line of sight, and writing the cells of a mask that is written while it is made.
    pub(crate) los: f64,
    /// Encoding and writing outputs, but for such cells.
    pub(crate) write: f64,
    /// All of it.
    pub(crate) total: f64,
}

impl Timing {
    /// With its parts as the total: of an answer of which nothing is written.
    pub(crate) fn summed(self) -> Timing {
        Timing { total: self.read + self.build + self.los + self.write, ..self }
    }

    /// With what writing took.
    pub(crate) fn with(self, spent: Spent) -> Timing {
        Timing { write: spent.write, total: spent.total, ..self }
    }
}

/// Receivers and those in line of sight.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct Share {
    /// Receivers in range.
    pub(crate) receivers: u64,
    /// Those in line of sight.
    pub(crate) los: u64,
    /// Share of the receivers in line of sight; null without a receiver.
    pub(crate) p_los: Option<f64>,
    /// Why there is no share.
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

/// A document of serde as a value.
pub(crate) fn document_of(document: &impl Serialize) -> Value {
    serde_json::to_value(document).unwrap_or(Value::Null)
}

/// A digest as documents tell it: `sha256:` and its hexadecimal digits.
pub(crate) fn digest_words(hasher: Sha256) -> String {
    format!("sha256:{}", hasher.hex_digits())
}

/// What writing took, which is known only when all is written.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Spent {
    /// Encoding and writing \[s\].
    pub(crate) write: f64,
    /// Everything \[s\].
    pub(crate) total: f64,
}
