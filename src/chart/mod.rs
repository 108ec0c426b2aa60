//! Speed against accuracy: every method on a scene, or every method of P_LoS of a generated city,
//! timed and compared with the truth.

mod figure;
mod measure;
mod peers;
mod plos;
mod plos_report;
mod report;
mod scene;

use std::path::Path;

use serde_json::Value;

pub(crate) use plos::PlosChartPlan;
use plos_report::PlosChartReport;
pub(crate) use plos_report::{PlosChartDocument, PlosChartTableRow};
use report::ChartReport;
pub(crate) use report::{ChartDocument, ChartTableRow};

use crate::answer::{Answer, Rows, Spent};
use crate::error::{Error, Result, Warning};
use crate::export::{Batch, Format};
use crate::picture::{Look, picture_provenance};
use crate::progress::Progress;
use crate::scene::Scene;
use crate::sight::SightPlan;
use crate::threads::in_pool;

/// Output formats of a chart.
pub(crate) const FORMATS: [Format; 6] =
    [Format::Png, Format::Svg, Format::Pdf, Format::Csv, Format::Json, Format::Stdout];

/// Longest time that can be requested for a contestant \[s\].
const LONGEST_S: f64 = 60.0;

/// Plan of a chart of a scene.
#[derive(Debug)]
pub(crate) struct ChartPlan {
    pub(crate) sight: SightPlan,
    /// `true` if other programs take part.
    pub(crate) peers: bool,
    /// Least time for each contestant \[s\].
    pub(crate) time_s: f64,
    /// Threads of the timed runs.
    pub(crate) threads: u16,
}

impl ChartPlan {
    /// Checks the numbers, before any work.
    ///
    /// # Errors
    /// E113.
    pub(crate) fn check(&self) -> Result<()> {
        check_time(self.time_s)
    }
}

/// A chart, ready to be written.
#[derive(Debug)]
pub(crate) struct Chart {
    contest: Contest,
}

/// Subject of a chart, and its report.
#[derive(Debug)]
enum Contest {
    Scene(Box<(Scene, ChartReport)>),
    PLos(Box<PlosChartReport>),
}

fn check_time(time_s: f64) -> Result<()> {
    if (0.0..=LONGEST_S).contains(&time_s) {
        return Ok(());
    }
    Err(Error::number("the time of a contestant", time_s, format!("0 s to {LONGEST_S} s")))
}

/// Runs `work`, which has a turn for each of `n` contestants, on the threads of the timed runs.
fn in_turns<T: Send>(threads: u16, n: usize, progress: &Progress, work: impl FnOnce() -> T + Send) -> Result<T> {
    progress.begin(n as u64);
    let done = in_pool(Some(threads), work);
    progress.end();
    done
}

impl Answer for Chart {
    fn interrupted(&self) -> Option<&'static str> {
        let is_interrupted = match &self.contest {
            Contest::Scene(of) => of.1.is_interrupted(),
            Contest::PLos(report) => report.is_interrupted(),
        };
        is_interrupted.then_some("the contestants that had their turn")
    }

    fn document(&self, _: Option<Spent>) -> Value {
        match &self.contest {
            Contest::Scene(of) => of.1.document(true),
            Contest::PLos(report) => report.document(true),
        }
    }

    fn provenance(&self) -> Value {
        match &self.contest {
            Contest::Scene(of) => of.1.document(false),
            Contest::PLos(report) => report.document(false),
        }
    }

    fn table(&self) -> Rows {
        match &self.contest {
            Contest::Scene(of) => of.1.table(),
            Contest::PLos(report) => report.table(),
        }
    }

    fn warnings(&self) -> &[Warning] {
        match &self.contest {
            Contest::Scene(of) => &of.1.facts.warnings,
            Contest::PLos(report) => &report.warnings,
        }
    }

    /// Returns one line for each contestant.
    fn notes(&self, _: Spent) -> Vec<String> {
        match &self.contest {
            Contest::Scene(of) => of.1.rows.iter().map(|row| scene::in_words(row, &of.1)).collect(),
            Contest::PLos(report) => report.rows.iter().filter_map(|row| plos::in_words(row, report)).collect(),
        }
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
        let picture = match &self.contest {
            Contest::Scene(of) => figure::of_scene(look, &of.0, &of.1),
            Contest::PLos(report) => figure::of_plos(look, report),
        };
        Ok(batch.add(path, &picture.draw(&look.form(format), &picture_provenance(&self.provenance()))?)?)
    }
}

/// A chart of maps or of P_LoS, distinguished by `kind`.
#[derive(schemars::JsonSchema)]
#[schemars(untagged)]
#[expect(dead_code, clippy::large_enum_variant, reason = "a type of its schema alone")]
pub(crate) enum AnyChartDocument {
    Maps(ChartDocument),
    PLos(PlosChartDocument),
}
