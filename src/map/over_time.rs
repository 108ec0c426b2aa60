//! Coverage over time: counts between the moments at which UAVs come and go, and the document
//! `skyshed/over-time/1`.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::coverages::Coverages;
use crate::answer::{Answer, Head, Output, Rows, RunFacts, Spent, WarningFacts, document_of, rows, warnings_of};
use crate::city::Clock;
use crate::coverage::{Tally, TimeCount, Uav};
use crate::error::Result;
use crate::export::{Batch, Format, OutputRules, check_outputs};
use crate::picture::Look;
use crate::quantity::tidy;
use crate::read::moment_words;
use crate::sight::{SightFacts, SightPlan};

/// Formats of counts over time.
const FORMATS: [Format; 2] = [Format::Csv, Format::Json];

/// Files of counts over time.
#[derive(Debug, Clone, Default)]
pub(crate) struct OverTimePlan {
    pub(crate) outputs: Vec<PathBuf>,
}

impl OverTimePlan {
    /// Checks the files before any work, and returns them with their formats. `others` are the other files of
    /// the run.
    pub(crate) fn checked<'a>(
        &self,
        others: impl Iterator<Item = &'a PathBuf>,
        rules: OutputRules<'_>,
    ) -> Result<Vec<Output>> {
        let outputs = check_outputs(&self.outputs, OutputRules { allowed: &FORMATS, bare: false, ..rules })?;
        let all: Vec<PathBuf> = others.cloned().chain(self.outputs.iter().cloned()).collect();
        check_outputs(&all, OutputRules { bare: false, ..rules })?;
        Ok(outputs)
    }

    /// Returns `true` if files are requested.
    pub(crate) fn is_wanted(&self) -> bool {
        !self.outputs.is_empty()
    }

    /// Makes the counts of a map; `None` if none are wanted.
    pub(crate) fn make(&self, map: &Coverages) -> Option<OverTime> {
        if self.is_wanted() { OverTime::of(map) } else { None }
    }
}

/// Span of the times in which UAVs are up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Span {
    /// First and last moment \[s\].
    pub(crate) ends_s: [f64; 2],
    pub(crate) clock: Clock,
}

impl Span {
    /// Returns the first and the last moment and the minutes between them, for captions.
    pub(crate) fn words(self) -> (String, String, String) {
        let SpanFacts { from, to, minutes } = self.facts();
        (from, to, tidy((minutes * 1000.0).round() / 1000.0))
    }

    /// Returns the span for documents.
    pub(crate) fn facts(self) -> SpanFacts {
        let [from, to] = self.ends_s.map(|s| moment_words(self.clock, s));
        SpanFacts { from, to, minutes: (self.ends_s[1] - self.ends_s[0]) / 60.0 }
    }
}

/// Span of the times in which UAVs are up, in documents.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct SpanFacts {
    /// First moment at which a UAV comes or goes: minutes, or ISO 8601.
    from: String,
    /// Last moment at which a UAV comes or goes.
    to: String,
    /// Time from the first to the last [min].
    minutes: f64,
}

/// Receivers between two moments at which UAVs come or go.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct TimeRow {
    /// First moment, included: minutes, or ISO 8601.
    from: String,
    /// Last moment, excluded.
    to: String,
    /// Time between them [min].
    minutes: f64,
    /// Number of UAVs that are up.
    n_up: usize,
    /// Their names, separated by `; `.
    up: String,
    /// Receivers in range of one of them.
    receivers: u64,
    /// Receivers in line of sight of one of them.
    los: u64,
    /// Share of the receivers in line of sight; empty without a receiver in range, and for a UAV over no data.
    p_los: Option<f64>,
    /// Receivers in line of sight as a share of the receivers of all UAVs together, 0 while none is up. Empty
    /// without such a receiver, and if one of the UAVs is over no data.
    share: Option<f64>,
}

/// Counts over time.
#[derive(Debug, Clone)]
pub(crate) struct OverTime {
    facts: RunFacts,
    sight: SightPlan,
    span: Span,
    /// Receivers of all UAVs together.
    receivers: u64,
    rows: Vec<TimeRow>,
    digest: String,
}

impl OverTime {
    /// Returns the counts of a map; `None` if it is not about time.
    fn of(map: &Coverages) -> Option<OverTime> {
        let (report, times) = (&map.report, map.overlay.as_ref()?.times()?);
        let (span, union) = (report.span?, report.union);
        let row = |count: TimeCount| {
            let TimeCount { from_s, to_s, receivers, los } = count;
            let is_up = |uav: &&Uav| uav.up.is_none_or(|up| up.from_s <= from_s && to_s <= up.to_s);
            let up: Vec<&Uav> = map.sites.iter().map(|site| &site.uav).filter(is_up).collect();
            let names: Vec<&str> = up.iter().map(|uav| uav.id.as_str()).collect();
            let tally = up.iter().fold(Tally::of_receivers(receivers, los), |tally, uav| tally.of_uav(uav));
            TimeRow {
                from: moment_words(span.clock, from_s),
                to: moment_words(span.clock, to_s),
                minutes: (to_s - from_s) / 60.0,
                n_up: up.len(),
                up: names.join("; "),
                receivers,
                los,
                p_los: tally.p_los(),
                share: union.p_los().map(|_| los as f64 / union.receivers as f64),
            }
        };
        let rows = times.counts().into_iter().map(row).collect();
        let (facts, digest) = (report.facts.clone(), report.digest.clone());
        Some(OverTime { facts, sight: report.sight, span, receivers: union.receivers, rows, digest })
    }

    /// Returns the mean share of the receivers of all UAVs together that are in line of sight, weighted by
    /// time; `None` where shares are not known.
    fn mean_share(&self) -> Option<f64> {
        let weighted = self.rows.iter().map(|row| Some(row.share? * row.minutes)).sum::<Option<f64>>();
        Some(weighted? / self.span.facts().minutes)
    }

    fn as_document(&self, with_rows: bool) -> Value {
        document_of(&OverTimeDocument {
            head: self.facts.head("skyshed/over-time/1"),
            sight: self.sight.facts(),
            span: self.span.facts(),
            receivers: self.receivers,
            mean_share: self.mean_share(),
            rows: with_rows.then(|| self.rows.clone()),
            warnings: warnings_of(&self.facts.warnings),
            digest: self.digest.clone(),
        })
    }
}

impl Answer for OverTime {
    fn document(&self, _spent: Option<Spent>) -> Value {
        self.as_document(true)
    }

    fn provenance(&self) -> Value {
        self.as_document(false)
    }

    fn table(&self) -> Rows {
        rows(self.rows.iter())
    }

    fn notes(&self, _spent: Spent) -> Vec<String> {
        let (from, to, minutes) = self.span.words();
        let mean = self.mean_share().map_or("undefined".to_string(), |share| format!("{share:.4}"));
        vec![format!("over time, {from} to {to} ({minutes} min): mean share of receivers in line of sight {mean}")]
    }

    fn add(&self, _: &mut Batch, _: &Path, _: Format, _: &Look) -> Result<()> {
        Ok(())
    }
}

/// Coverage over time, between the moments at which UAVs come and go.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct OverTimeDocument {
    #[serde(flatten)]
    head: Head,
    #[serde(flatten)]
    sight: SightFacts,
    #[serde(flatten)]
    span: SpanFacts,
    /// Receivers of all UAVs together.
    receivers: u64,
    /// Mean of the rows' `share`, weighted by time; null where these are.
    mean_share: Option<f64>,
    /// Rows between moments, in order; left out beside a table.
    #[serde(skip_serializing_if = "Option::is_none")]
    rows: Option<Vec<TimeRow>>,
    /// Warnings of the run.
    warnings: Vec<WarningFacts>,
    /// SHA-256 of the masks of all UAVs.
    digest: String,
}
