//! Methods against the truth on families of scenes.

use std::path::Path;
use std::time::Instant;

use super::{FORMATS, StressArgs, answer};
use crate::accuracy::stress::{Contender, Effort, FAMILIES, Family, check_exact, stress};
use crate::cli::{interrupt, messages};
use crate::error::Result;
use crate::export::{Batch, Format, OutputRules, check_outputs, with_suffix};
use crate::los::MethodChoice;
use crate::picture::undrawable;
use crate::quantity::counted;
use crate::render::{self, RateColumn, RateSheet, grouped};
use crate::report::StressReport;
use crate::words::{picture_provenance, pretty};

pub(super) fn run(args: &StressArgs, command: Vec<String>) -> Result<()> {
    let start = Instant::now();
    let rules = OutputRules { allowed: &FORMATS, inputs: &[], overwrite: args.out.overwrite, bare: false };
    let outputs = check_outputs(&args.output, rules)?;
    args.words.refuse_without_picture(&outputs)?;
    let families: Vec<&Family> =
        FAMILIES.iter().filter(|f| args.families.is_empty() || args.families.contains(&f.name)).collect();
    let methods = match args.engine.method {
        MethodChoice::Auto => Contender::all(),
        choice => vec![Contender::of(choice)],
    };
    let effort = Effort { scenes: args.scenes, seed: args.scene.seed };
    let scores = stress(&families, &methods, effort)?;
    let report = StressReport { command, effort, methods, scores };

    interrupt::begin_writing();
    let mut batch = Batch::new(args.out.overwrite);
    for (path, format) in &outputs {
        interrupt::check()?;
        add(args, &report, &mut batch, (path, *format), start)?;
    }
    let files = batch.commit()?;
    if !args.out.quiet {
        words(&report).iter().for_each(|line| messages::note(line));
        let scenes = counted(u64::from(effort.scenes), "scene", "scenes");
        let seconds = start.elapsed().as_secs_f64();
        let n = report.scores.len();
        messages::note(&format!("{scenes} of each of {} in {seconds:.2} s", counted(n as u64, "family", "families")));
    }
    messages::wrote(&files, args.out.quiet);
    let seconds = start.elapsed().as_secs_f64();
    answer(args, &outputs, || report.document(Some(seconds)), || report.table())?;
    // What failed is written before it is told.
    Ok(check_exact(&report.methods, &report.scores)?)
}

fn add(
    args: &StressArgs,
    report: &StressReport,
    batch: &mut Batch,
    (path, format): (&Path, Format),
    start: Instant,
) -> Result<()> {
    match format {
        Format::Csv => {
            batch.add(path, &args.out.table(&report.table())?)?;
            Ok(batch.add(&with_suffix(path, ".json"), pretty(&report.document(None)).as_bytes())?)
        }
        Format::Json => Ok(batch.add(path, pretty(&report.document(Some(start.elapsed().as_secs_f64()))).as_bytes())?),
        Format::Png | Format::Svg | Format::Pdf => Ok(batch.add(path, &picture(args, report, format)?)?),
        _ => Ok(()),
    }
}

/// What each method got wrong, in a line.
fn words(report: &StressReport) -> Vec<String> {
    let line = |(k, method): (usize, &Contender)| {
        let Some([wrong, receivers]) = report.total(k) else {
            return format!("{}: decides none of these families", method.name);
        };
        let worst = report.scores.iter().filter_map(|score| Some((score.family, StressReport::rate(score, k)?)));
        // The larger of two rates, by products.
        let worst = worst.max_by(|(_, a), (_, b)| (a[0] * b[1]).cmp(&(b[0] * a[1])));
        let worst = worst
            .filter(|_| wrong > 0)
            .map_or(String::new(), |(family, [wrong, of])| format!(", worst on {family} ({wrong} of {of})"));
        format!("{}: {wrong} of {} wrong{worst}", method.name, counted(receivers, "receiver", "receivers"))
    };
    report.methods.iter().enumerate().map(line).collect()
}

fn picture(args: &StressArgs, report: &StressReport, format: Format) -> Result<Vec<u8>> {
    let columns: Vec<RateColumn<'_>> = report
        .methods
        .iter()
        .map(|method| RateColumn { name: &method.name, group: if method.is_exact() { "exact" } else { "approximate" } })
        .collect();
    let rows: Vec<&str> = report.scores.iter().map(|score| score.family).collect();
    let rates: Vec<Option<[u64; 2]>> =
        report.scores.iter().flat_map(|score| (0..columns.len()).map(|k| StressReport::rate(score, k))).collect();
    let title = args.words.title_or(|| "Where methods fail".into());
    let caption = caption(report);
    let sheet = RateSheet { title: &title, caption: &caption, rows: &rows, columns: &columns, rates: &rates };
    let provenance = picture_provenance(&report.document(None));
    let form = args.words.size.form(format);
    render::draw_rate_sheet(&sheet, &form, &provenance).map_err(undrawable)
}

fn caption(report: &StressReport) -> Vec<String> {
    let receivers: u64 = report.scores.iter().map(|score| score.receivers).sum();
    vec![
        "Receivers decided wrongly [%], against exact integers from the definition of line of sight. 0 is none at all."
            .into(),
        format!(
            "{} of each of {}, {} receivers, seed {}; boards of cells (cell-…) and footprints (prism-…); skyshed {}",
            counted(u64::from(report.effort.scenes), "scene", "scenes"),
            counted(report.scores.len() as u64, "family", "families"),
            grouped(receivers),
            report.effort.seed,
            env!("CARGO_PKG_VERSION")
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_family_is_that_of_the_highest_rate() {
        let families: Vec<&Family> = FAMILIES.iter().filter(|f| f.name.starts_with("cell-")).collect();
        let methods = vec![Contender::of(MethodChoice::Ray), Contender::of(MethodChoice::R2)];
        let effort = Effort { scenes: 2, seed: 1 };
        let scores = stress(&families, &methods, effort).expect("all scenes can be decided");
        let report = StressReport { command: Vec::new(), effort, methods, scores };
        let lines = words(&report);
        assert!(lines[0].starts_with("ray: 0 of ") && !lines[0].contains("worst"), "{lines:?}");
        assert!(lines[1].contains(", worst on cell-"), "{lines:?}");
        assert_eq!(report.total(0).map(|t| t[1]), report.total(1).map(|t| t[1]));
    }
}
