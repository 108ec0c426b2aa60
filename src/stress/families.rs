//! Comparison of methods with the truth on families of scenes.

use std::path::Path;

use serde_json::Value;

use super::report::StressReport;
use crate::accuracy::stress::{Contender, Effort, FAMILIES, Family, check_exact, stress};
use crate::answer::{Answer, CommandFacts, Rows, Spent};
use crate::error::Result;
use crate::export::{Batch, Format};
use crate::los::MethodChoice;
use crate::picture::{Look, picture_provenance, program, written};
use crate::quantity::counted;
use crate::render::{self, RateColumn, RateSheet, grouped};

/// Errors of methods on families of scenes.
#[derive(Debug)]
pub(crate) struct Stress {
    report: StressReport,
}

impl Stress {
    /// Runs a method on `scenes` scenes of some families. `auto` runs all methods, and no family
    /// means all families.
    ///
    /// # Errors
    /// E601 if the computed truth of a scene contradicts its known answer.
    pub(crate) fn run(
        families: &[&'static str],
        method: MethodChoice,
        (scenes, seed): (u32, u64),
        command: CommandFacts,
    ) -> Result<Stress> {
        let is_wanted = |f: &&Family| families.is_empty() || families.contains(&f.name);
        let families: Vec<&Family> = FAMILIES.iter().filter(is_wanted).collect();
        let methods = match method {
            MethodChoice::Auto => Contender::all(),
            choice => vec![Contender::of(choice)],
        };
        let effort = Effort { scenes, seed };
        let scores = stress(&families, &methods, effort)?;
        Ok(Stress { report: StressReport { command, effort, methods, scores } })
    }

    /// Checks that all exact methods are right.
    ///
    /// # Errors
    /// E602 if one is not.
    pub(crate) fn check(&self) -> Result<()> {
        Ok(check_exact(&self.report.methods, &self.report.scores)?)
    }
}

impl Answer for Stress {
    fn document(&self, spent: Option<Spent>) -> Value {
        self.report.document(spent)
    }

    fn table(&self) -> Rows {
        self.report.table()
    }

    fn notes(&self, spent: Spent) -> Vec<String> {
        let scenes = counted(u64::from(self.report.effort.scenes), "scene", "scenes");
        let families = counted(self.report.scores.len() as u64, "family", "families");
        let last = format!("{scenes} of each of {families} in {:.2} s", spent.total);
        words(&self.report).into_iter().chain([last]).collect()
    }

    fn add(&self, batch: &mut Batch, path: &Path, format: Format, look: &Look) -> Result<()> {
        Ok(batch.add(path, &picture(&self.report, format, look)?)?)
    }
}

/// Returns the errors of each method, in a line.
fn words(report: &StressReport) -> Vec<String> {
    let line = |(k, method): (usize, &Contender)| {
        let Some([wrong, receivers]) = report.total(k) else {
            return format!("{}: decides none of these families", method.name);
        };
        let worst = report.scores.iter().filter_map(|score| Some((score.family, StressReport::rate(score, k)?)));
        // Compares two rates by products.
        let worst = worst.max_by(|(_, a), (_, b)| (a[0] * b[1]).cmp(&(b[0] * a[1])));
        let worst = worst
            .filter(|_| wrong > 0)
            .map_or(String::new(), |(family, [wrong, of])| format!(", worst on {family} ({wrong} of {of})"));
        format!("{}: {wrong} of {} wrong{worst}", method.name, counted(receivers, "receiver", "receivers"))
    };
    report.methods.iter().enumerate().map(line).collect()
}

fn picture(report: &StressReport, format: Format, look: &Look) -> Result<Vec<u8>> {
    let columns: Vec<RateColumn<'_>> = report
        .methods
        .iter()
        .map(|method| RateColumn { name: &method.name, group: if method.is_exact() { "exact" } else { "approximate" } })
        .collect();
    let happens = |name: &str| Family::named(name).map_or("", |family| family.happens);
    let rows: Vec<[&str; 2]> = report.scores.iter().map(|score| [happens(score.family), score.family]).collect();
    let rates: Vec<Option<[u64; 2]>> =
        report.scores.iter().flat_map(|score| (0..columns.len()).map(|k| StressReport::rate(score, k))).collect();
    let title = look.title_or(|| "Where methods fail".into());
    let caption = caption(report);
    let blank = "the method does not take such scenes";
    let sheet = RateSheet { title: &title, caption: &caption, rows: &rows, columns: &columns, rates: &rates, blank };
    let provenance = picture_provenance(&report.document(None));
    written(render::draw_rate_sheet(&sheet), &look.form(format), &provenance)
}

fn caption(report: &StressReport) -> Vec<String> {
    let receivers: u64 = report.scores.iter().map(|score| score.receivers).sum();
    vec![
        "Receivers decided wrongly [%], against exact integers from the definition of line of sight. 0 is none at all."
            .into(),
        format!(
            "{} of each of {}, {} receivers, seed {}; boards of cells (cell-…) and footprints (prism-…); {}",
            counted(u64::from(report.effort.scenes), "scene", "scenes"),
            counted(report.scores.len() as u64, "family", "families"),
            grouped(receivers),
            report.effort.seed,
            program()
        ),
    ]
}
