//! What does a P_LoS curve cost, by method and standard error?
//!
//! `cargo bench --bench probability` prints Markdown. A curve has the 18 elevation angles 5°, 10° … 90°, UAV at 100 m,
//! outdoor receivers on the ground, all cores. The standard error of a row is the largest of the 18. Before anything is timed,
//! both simulators are compared with the product: every angle within 4.5 standard errors.
//!
//! The program is not written with divan because a row is a time *and* an error, and times are the CPU's, of all threads:
//! the median of five runs, each repeated until it takes at least half a second.

#![expect(clippy::print_stdout, reason = "a bench prints its table")]

use std::time::Instant;

use skyshed_core::city::BuiltUp;
use skyshed_request::{Placement, Users};
use skyshed_study::los_probability::city::CitySimulator;
use skyshed_study::los_probability::estimate::{Count, Estimate, clustered, wilson};
use skyshed_study::los_probability::geometry::GeometrySimulator;
use skyshed_study::los_probability::product::Product;
use skyshed_study::los_probability::setting::Setting;

const CITIES: [&str; 5] = ["suburban", "urban", "dense-urban", "high-rise", "ghent"];
const RUNS: usize = 5;

fn main() {
    // Only `cargo bench` measures; whatever else runs this program wants to know that it starts.
    if !std::env::args().any(|word| word == "--bench") {
        return;
    }
    println!("| city | method | effort | largest standard error | CPU [ms] | wall [ms] |");
    println!("|---|---|---|---:|---:|---:|");
    for city in CITIES {
        let settings = curve(city);
        compare(&settings);
        for log in [9_u32, 12, 14, 15] {
            row(city, "product", &format!("32 × 2^{log} points"), || product(&settings, 1 << log));
        }
        for n in [50, 500] {
            row(city, "city", &format!("{n} cities × 360 users"), || cities(&settings, n));
        }
        for n in [1000, 100_000] {
            row(city, "geometry", &format!("{n} links per angle"), || geometry(&settings, n));
        }
    }
}

fn curve(city: &str) -> Vec<Setting> {
    let built_up = BuiltUp::named(city).expect("a known name");
    let setting = |k: u32| Setting {
        built_up,
        uav_height_m: 100.0,
        rx_height_m: 0.0,
        reach: Setting::reach_at_elevation(5.0 * f64::from(k), 100.0, 0.0).expect("an angle"),
        phi_deg: None,
        users: Users::Outdoor,
        placement: Placement::Anywhere,
        uav_clear_of_roof: false,
    };
    (1..=18).map(setting).collect()
}

fn product(settings: &[Setting], points: u64) -> Vec<Estimate> {
    let estimate = |setting: &Setting| {
        let mut product = Product::new(*setting, 1);
        product.add_points(points);
        product.estimate(0.95)
    };
    settings.iter().map(estimate).collect()
}

fn cities(settings: &[Setting], n: u64) -> Vec<Estimate> {
    let counts = CitySimulator::new(settings, 360).expect("a city of a few kilometers").count_many(1, 0, n);
    let column = |k: usize| counts.iter().map(|draw| draw[k]).collect::<Vec<Count>>();
    (0..settings.len()).map(|k| clustered(&column(k), 0.95)).collect()
}

fn geometry(settings: &[Setting], n: u64) -> Vec<Estimate> {
    let estimate = |setting: &Setting| {
        let count = GeometrySimulator::new(setting).count(1, 0, n);
        wilson(count.los, count.receivers, 0.95)
    };
    settings.iter().map(estimate).collect()
}

fn compare(settings: &[Setting]) {
    let reference = product(settings, 1 << 13);
    for estimates in [cities(settings, 200), geometry(settings, 20_000)] {
        for (found, wanted) in estimates.iter().zip(&reference) {
            let (p, q) = (found.p_los.expect("users"), wanted.p_los.expect("users"));
            let error = found.std_error.expect("draws").hypot(wanted.std_error.expect("shifts"));
            assert!((p - q).abs() <= 4.5 * error + 1e-4, "{p} ± {error}, the product gives {q}");
        }
    }
}

fn row(city: &str, method: &str, effort: &str, curve: impl Fn() -> Vec<Estimate>) {
    let error = curve().iter().filter_map(|e| e.std_error).fold(0.0, f64::max);
    let mut times: Vec<(f64, f64)> = (0..RUNS).map(|_| time(&curve)).collect();
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    let cpu = times[RUNS / 2].0;
    times.sort_by(|a, b| a.1.total_cmp(&b.1));
    println!("| {city} | {method} | {effort} | {error:.1e} | {:.0} | {:.0} |", 1e3 * cpu, 1e3 * times[RUNS / 2].1);
}

/// CPU and wall time of one curve \[s\].
fn time(curve: &impl Fn() -> Vec<Estimate>) -> (f64, f64) {
    const LEAST_SECONDS: f64 = 0.5;
    let (start, cpu) = (Instant::now(), cpu_seconds());
    let mut n = 0.0;
    while start.elapsed().as_secs_f64() < LEAST_SECONDS {
        std::hint::black_box(curve());
        n += 1.0;
    }
    ((cpu_seconds() - cpu) / n, start.elapsed().as_secs_f64() / n)
}

/// CPU time of the process so far \[s\], in hundredths; where the system does not tell, NaN.
fn cpu_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // Behind the name in parentheses: state is field 0, user and system time are fields 11 and 12, in ticks of 10 ms.
    let fields: Vec<&str> = text.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |k: usize| fields.get(k).and_then(|f| f.parse::<f64>().ok()).unwrap_or(f64::NAN);
    (ticks(11) + ticks(12)) / 100.0
}
