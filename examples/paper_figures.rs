//! The figures of Saboor, Vinogradov, Cui & Pollin 2023 (arXiv 2303.03197), drawn anew: pictures, tables, and a page that
//! says which of the paper's takeaways these numbers bear out, and where they do not.
//!
//! `cargo run --release --example paper_figures [FOLDER]` writes `index.html` and all it shows to `out/paper_figures`.
//! Each figure is made by `skyshed plos`, with commands that stand on the page as they are run. Verdicts are computed from
//! the tables just written; no result is fixed here.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use std::collections::HashMap;
use std::error::Error;
use std::ffi::OsString;
use std::process::ExitCode;
use std::time::Instant;

#[path = "paper_figures/figures.rs"]
mod figures;

use figures::{FIGURES, Figure};

/// P_LoS that differ by no more count as the same.
const SAME: f64 = 0.01;
/// P_LoS that differ by no more are near.
const NEAR: f64 = 0.05;
const CITIES: [&str; 4] = ["suburban", "urban", "dense-urban", "high-rise"];
const GHENT: &str = "0.435,4679,8.8";

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).unwrap_or_else(|| "out/paper_figures".into());
    std::fs::create_dir_all(&folder)?;
    // So that the commands on the page need no folder.
    std::env::set_current_dir(&folder)?;
    for figure in &FIGURES {
        let start = Instant::now();
        for line in figure.commands() {
            run(&line)?;
        }
        println!("{}: {} ({:.1} s)", figure.0, figure.1, start.elapsed().as_secs_f64());
    }
    let verdicts = verdicts()?;
    for verdict in &verdicts {
        println!("{} {}", verdict.0, verdict.grade());
    }
    std::fs::write("index.html", page(&verdicts))?;
    println!("wrote {}/index.html", folder.display());
    Ok(())
}

/// Runs a command line of `skyshed`; words with blanks are between double quotes.
fn run(line: &str) -> Result<(), String> {
    let mut words = vec![OsString::from("skyshed")];
    for (k, part) in line.split('"').enumerate() {
        match k % 2 {
            0 => words.extend(part.split_whitespace().map(OsString::from)),
            _ => words.push(part.into()),
        }
    }
    if skyshed::cli::run(words) == ExitCode::SUCCESS { Ok(()) } else { Err(format!("this failed: skyshed {line}")) }
}

/// A table of `skyshed plos`: each row by its columns.
struct Table(Vec<HashMap<String, String>>);

/// P_LoS over a quantity.
type Curve = Vec<(f64, f64)>;

impl Table {
    fn read(id: &str) -> csv::Result<Self> {
        Ok(Table(csv::Reader::from_path(format!("{id}.csv"))?.deserialize().collect::<Result<_, _>>()?))
    }

    /// The values of a column of texts, each once.
    fn words(&self, column: &str) -> Vec<&str> {
        let mut words: Vec<&str> = self.0.iter().filter_map(|row| row.get(column)).map(String::as_str).collect();
        words.sort_unstable();
        words.dedup();
        words
    }

    /// The rows that have all these values.
    fn rows<'a>(&'a self, wanted: &'a [(&str, &str)]) -> impl Iterator<Item = &'a HashMap<String, String>> {
        self.0.iter().filter(|row| wanted.iter().all(|(column, v)| row.get(*column).is_some_and(|found| found == v)))
    }

    /// P_LoS over a column, of the rows with these values.
    fn curve(&self, x: &str, wanted: &[(&str, &str)]) -> Curve {
        self.rows(wanted).filter_map(|row| number(row, x).zip(number(row, "p_los"))).collect()
    }
}

fn number(row: &HashMap<String, String>, column: &str) -> Option<f64> {
    row.get(column)?.parse().ok()
}

/// By how much the first curve is above the second, at the values of both.
fn excess(a: &Curve, b: &Curve) -> Curve {
    let at = |x: f64| b.iter().find(|point| (point.0 - x).abs() < 1e-9).map(|point| point.1);
    a.iter().filter_map(|(x, p)| at(*x).map(|other| (*x, p - other))).collect()
}

/// Where the largest absolute value is, and which it is.
fn largest(curve: &[(f64, f64)]) -> (f64, f64) {
    curve.iter().copied().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap_or((f64::NAN, f64::NAN))
}

/// The stretches of values of which something is so, such as `5–20°, 85°`.
fn stretches(curve: &Curve, unit: &str, is_so: impl Fn(f64) -> bool) -> String {
    let mut found: Vec<(f64, f64)> = Vec::new();
    let mut goes_on = false;
    for (x, v) in curve {
        match found.last_mut() {
            Some(last) if is_so(*v) && goes_on => last.1 = *x,
            _ if is_so(*v) => found.push((*x, *x)),
            _ => {}
        }
        goes_on = is_so(*v);
    }
    let text =
        |(from, to): &(f64, f64)| if from < to { format!("{from}–{to}{unit}") } else { format!("{from}{unit}") };
    if found.is_empty() { "nowhere".into() } else { found.iter().map(text).collect::<Vec<_>>().join(", ") }
}

fn mean(curve: &Curve) -> f64 {
    curve.iter().map(|point| point.1).sum::<f64>() / curve.len() as f64
}

/// A claim, and the cases in which the numbers bear it out or do not.
struct Verdict(&'static str, Vec<(bool, String)>);

impl Verdict {
    fn grade(&self) -> String {
        match (self.1.iter().filter(|case| case.0).count(), self.1.len()) {
            (n, all) if n == all => "Holds.".into(),
            (0, _) => "Does not hold.".into(),
            (n, all) => format!("Holds in {n} of {all} cases."),
        }
    }
}

fn verdicts() -> csv::Result<Vec<Verdict>> {
    let mut verdicts = vec![simulators_agree()?];
    verdicts.extend(models_overestimate(&Table::read("takeaway1")?));
    verdicts.extend(models_do_not_adapt(&Table::read("takeaway2")?, &Table::read("takeaway1")?));
    verdicts.extend(azimuth_matters()?);
    for (id, suffix, claim) in [
        ("centers", "-center", "Placement: a UAV over the middle of a crossroad sees at least as much as elsewhere."),
        ("anywhere", "", "Placement: a UAV anywhere over a crossroad sees at least as much as elsewhere."),
    ] {
        verdicts.push(Verdict(claim, crossroads_win(&Table::read(id)?, suffix)));
    }
    Ok(verdicts)
}

fn simulators_agree() -> csv::Result<Verdict> {
    let mut cases = Vec::new();
    for id in ["fig6a", "fig6b", "fig6c", "fig7"] {
        let table = Table::read(id)?;
        for method in ["city", "geometry"] {
            let (mut n, mut inside, mut widest) = (0, 0, 0.0_f64);
            for (row, exact) in table.rows(&[("method", method)]).zip(table.rows(&[("method", "product")])) {
                let [low, high] = ["ci_low", "ci_high"].map(|column| number(row, column).unwrap_or(f64::NAN));
                let exact = number(exact, "p_los").unwrap_or(f64::NAN);
                (n, widest) = (n + 1, widest.max(0.5 * (high - low)));
                inside += usize::from(low <= exact && exact <= high);
            }
            let text =
                format!("{id}, {method}: {inside} of {n} intervals hold the exact value; the widest is ±{widest:.3}");
            cases.push((10 * inside >= 9 * n, text));
        }
    }
    Ok(Verdict("Simulators: at least 90 % of their 95 % intervals hold the exact value.", cases))
}

fn models_overestimate(table: &Table) -> [Verdict; 4] {
    let curve = |city, method| table.curve("theta_deg", &[("city", &format!("itu:{city}")), ("method", method)]);
    let (mut average, mut strict, mut near, mut ends) = (vec![], vec![], vec![], vec![]);
    for city in CITIES {
        let exact = curve(city, "product");
        for model in ["itu", "alhourani2014", "mohammed2023"] {
            let values = curve(city, model);
            let over = excess(&values, &exact);
            let (mean, (theta, most)) = (mean(&over), largest(&over));
            let overhead = values.last().map_or(f64::NAN, |point| point.1);
            let is_rising = values.windows(2).all(|pair| pair[1].1 >= pair[0].1);
            let text =
                format!("{city}, {model}: {} with θ, {overhead:.3} at 90°", if is_rising { "grows" } else { "falls" });
            ends.push((is_rising && overhead > 1.0 - SAME, text));
            let text = format!("{city}, {model}: {mean:+.3} on average over θ, {most:+.3} at {theta}°");
            if model == "mohammed2023" {
                near.push((most.abs() <= NEAR, text));
                continue;
            }
            average.push((mean > SAME, text));
            let [above, below] = [1.0, -1.0].map(|sign| stretches(&over, "°", |d| sign * d > SAME));
            let same = stretches(&over, "°", |d| d.abs() <= SAME);
            let text = format!("{city}, {model}: above at {above}; below at {below}; within {SAME} at {same}");
            strict.push((below == "nowhere", text));
        }
    }
    [
        Verdict("Takeaway 1: ITU-R P.1410 and Al-Hourani 2014 overestimate P_LoS, on average over θ.", average),
        Verdict("Takeaway 1, read strictly: at no θ are they below the exact value.", strict),
        Verdict("Takeaway 1: the model of Mohammed et al. (2023, for 2021) is near the exact value.", near),
        Verdict("Models grow with θ, and are 1 right below the UAV.", ends),
    ]
}

fn models_do_not_adapt(table: &Table, standard: &Table) -> [Verdict; 2] {
    let of = |city, method| table.curve("theta_deg", &[("city", &format!("itu:{city}")), ("method", method)]);
    let exact = of(GHENT, "product");
    let models = table.words("method").into_iter().filter(|method| *method != "product");
    let cases = models.map(|model| {
        let (ghent, dense) = (of(GHENT, model), of("dense-urban", model));
        let (theta, most) = largest(&excess(&ghent, &exact));
        let adapts = largest(&excess(&ghent, &dense)).1.abs() > 1e-9;
        let how = if adapts { "follows α, β, γ" } else { "has the same values for both cities" };
        match ghent.is_empty() {
            true => (true, format!("{model} refuses Ghent")),
            false => (!adapts, format!("{model} {how}; {most:+.3} from the exact value of Ghent at {theta}°")),
        }
    });
    let cases = cases.collect();
    let apart = CITIES.map(|city| {
        let off =
            excess(&standard.curve("theta_deg", &[("city", &format!("itu:{city}")), ("method", "product")]), &exact);
        let (theta, most) = largest(&off);
        (most.abs() > NEAR, format!("{city}: {:+.3} on average over θ, {most:+.3} at {theta}°", mean(&off)))
    });
    [
        Verdict("Takeaway 2: models do not adapt to α, β, γ such as those of Ghent.", cases),
        Verdict("Takeaway 2: no standard environment is near Ghent.", apart.to_vec()),
    ]
}

fn azimuth_matters() -> csv::Result<[Verdict; 3]> {
    let ends = |curve: &Curve| {
        let values = curve.iter().map(|point| point.1);
        [f64::min, f64::max].map(|of| values.clone().reduce(of).unwrap_or(f64::NAN))
    };
    let on = |id: &str, clear: &[&str]| -> csv::Result<Vec<(bool, String)>> {
        let table = Table::read(id)?;
        let ones = clear.iter().map(|phi| {
            let [low, _] = ends(&table.curve("theta_deg", &[("phi_deg", phi)]));
            (low > 1.0 - SAME, format!("φ = {phi}°: at least {low:.4} at all θ"))
        });
        let spreads = ["5", "25", "45", "65", "85"].map(|theta| {
            let [low, high] = ends(&table.curve("phi_deg", &[("theta_deg", theta)]));
            (high - low > SAME, format!("θ = {theta}°: from {low:.3} to {high:.3} over φ"))
        });
        Ok(ones.chain(spreads).collect())
    };
    let table = Table::read("takeaway3")?;
    let models = table.words("method").into_iter().filter(|method| *method != "product").map(|model| {
        let [low, high] = ends(&table.curve("phi_deg", &[("method", model)]));
        (high - low < 1e-9, format!("{model}: from {low:.3} to {high:.3} over φ"))
    });
    Ok([
        Verdict("Takeaway 3: on the street P_LoS varies with φ, and is 1 at 90°.", on("fig11", &["90"])?),
        Verdict("Takeaway 3: on the crossroad P_LoS varies with φ, and is 1 at 0 and 90°.", on("fig12", &["0", "90"])?),
        Verdict("Takeaway 3: models do not know φ.", models.collect()),
    ])
}

fn crossroads_win(table: &Table, suffix: &str) -> Vec<(bool, String)> {
    let of_city = |city| {
        let over = |place| {
            table.curve("radius_m", &[("city", &format!("itu:{city}")), ("placement", &format!("{place}{suffix}"))])
        };
        let [crossroad, street, rooftop] = ["crossroad", "street", "rooftop"].map(over);
        let best: Curve = street.iter().zip(&rooftop).map(|(a, b)| (a.0, a.1.max(b.1))).collect();
        let ahead = excess(&crossroad, &best);
        let [wins, loses] = [1.0, -1.0].map(|sign| stretches(&ahead, " m", |d| sign * d > SAME));
        let (radius, most) = largest(&ahead);
        let text = format!("{city}: ahead of the next best by more than {SAME} at R = {wins}; behind at {loses}");
        (loses == "nowhere", format!("{text}; {most:+.3} at {radius} m"))
    };
    CITIES.map(of_city).to_vec()
}

/// The page: verdicts, then figures.
fn page(verdicts: &[Verdict]) -> String {
    let html = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;").replace("P_LoS", "P<sub>LoS</sub>");
    let mut page = String::from(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>Figures of arXiv 2303.03197, drawn anew</title>\n\
         <style>body{font:16px/1.5 sans-serif;max-width:62em;margin:2em auto;padding:0 1em}img{max-width:100%;max-height:40em}\
         pre{background:#f3f3f3;padding:.7em;white-space:pre-wrap}</style>\n\
         <h1>Figures of Saboor, Vinogradov, Cui &amp; Pollin 2023, drawn anew</h1>\n\
         <p>Made by the example <code>paper_figures</code> of skyshed. ",
    );
    page += &html(&format!(
        "Receivers are at 0 m and the UAV at 100 m unless a figure says otherwise. The exact value is the product over \
         buildings. Each verdict is computed from the tables beside this page, ✓ and ✗ being its cases; methods have the names \
         of the tables. P_LoS that differ by at most {SAME} count as the same, by at most {NEAR} as near."
    ));
    page += "</p>\n<h2>Takeaways</h2>\n";
    for verdict in verdicts {
        page += &format!("<details open><summary>{} <b>{}</b></summary>\n<ul>\n", html(verdict.0), verdict.grade());
        for (holds, text) in &verdict.1 {
            page += &format!("<li>{} {}\n", if *holds { '✓' } else { '✗' }, html(text));
        }
        page += "</ul></details>\n";
    }
    for figure in &FIGURES {
        let Figure(id, title, _, choices) = figure;
        let commands: Vec<String> = figure.commands().iter().map(|line| format!("skyshed {line}")).collect();
        page += &format!(
            "<h2 id=\"{id}\">{}</h2>\n<p>{}</p>\n<a href=\"{id}.svg\"><img src=\"{id}.png\" alt=\"{title}\"></a>\n\
             <p><a href=\"{id}.csv\">{id}.csv</a> <a href=\"{id}.svg\">{id}.svg</a></p>\n<pre>{}</pre>\n",
            html(title),
            html(choices),
            commands.join("\n")
        );
    }
    page
}
