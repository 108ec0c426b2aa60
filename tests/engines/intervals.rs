//! Intervals tell the truth: over many repetitions a 95 % interval covers the value 95 % of the time.

use skyshed_study::los_probability::city::CitySimulator;
use skyshed_study::los_probability::estimate::{Count, clopper_pearson, clustered, wilson};
use skyshed_study::los_probability::geometry::GeometrySimulator;
use skyshed_study::los_probability::product::Product;
use skyshed_study::los_probability::setting::Setting;

use crate::los_probability::setting;
use crate::support::is_long;

/// P_LoS to a standard error far below what intervals of few draws can resolve.
fn truth(setting: &Setting) -> f64 {
    let mut product = Product::new(*setting, 1);
    product.add_points(if is_long() { 1 << 14 } else { 1 << 12 });
    product.estimate(0.95).p_los.unwrap()
}

/// Repetitions, and the share of intervals \[%\] that may cover: what 95 % leaves to chance.
fn repetitions() -> (u64, std::ops::RangeInclusive<f64>) {
    if is_long() { (2000, 93.5..=96.5) } else { (400, 91.5..=98.0) }
}

/// Written past the capture of the test harness: these figures are a result.
fn report(text: &str) {
    use std::io::Write;
    if is_long() {
        let _ = writeln!(std::io::stderr(), "{text}");
    }
}

fn covers(interval: Option<(f64, f64)>, truth: f64) -> bool {
    interval.is_some_and(|(low, high)| low <= truth && truth <= high)
}

/// The share of repetitions \[%\] whose interval covers, clustered by city and as if all links were independent.
fn coverage_of_cities(setting: &Setting, n_cities: u64, n_repetitions: u64) -> (f64, f64, f64) {
    let truth = truth(setting);
    let simulator = CitySimulator::new(&[*setting], 360).unwrap();
    let counts: Vec<Count> = simulator.count_many(99, 0, n_cities * n_repetitions).iter().map(|c| c[0]).collect();
    let (mut n_clustered, mut n_naive) = (0_u32, 0_u32);
    for draws in counts.chunks(usize::try_from(n_cities).unwrap()) {
        n_clustered += u32::from(covers(clustered(draws, 0.95).interval, truth));
        let (los, receivers) = draws.iter().fold((0, 0), |sum, c| (sum.0 + c.los, sum.1 + c.receivers));
        n_naive += u32::from(covers(wilson(los, receivers, 0.95).interval, truth));
    }
    let share = |n: u32| 100.0 * f64::from(n) / n_repetitions as f64;
    (truth, share(n_clustered), share(n_naive))
}

#[test]
fn intervals_clustered_by_city_cover_and_naive_ones_do_not() {
    let (n_repetitions, allowed) = repetitions();
    // Angles of 30 cities, and of 100.
    let cases: &[(&str, &[f64], &[f64])] = if is_long() {
        &[
            ("suburban", &[10.0, 45.0, 65.0], &[]),
            ("urban", &[10.0, 30.0, 75.0, 80.0], &[60.0]),
            ("dense", &[15.0, 45.0, 75.0, 80.0], &[60.0]),
            ("high-rise", &[30.0, 60.0, 85.0], &[75.0]),
            ("ghent", &[20.0, 45.0, 85.0], &[]),
        ]
    } else {
        &[("urban", &[45.0], &[]), ("dense", &[60.0], &[]), ("high-rise", &[75.0], &[])]
    };
    let cases = cases.iter().flat_map(|(city, of_30, of_100)| {
        let of_30 = of_30.iter().map(move |theta| (*city, *theta, 30));
        of_30.chain(of_100.iter().map(move |theta| (*city, *theta, 100)))
    });
    for (city, theta, n_cities) in cases {
        let (truth, covered, naive) = coverage_of_cities(&setting(city, theta), n_cities, n_repetitions);
        let case = format!("{city} at {theta}°, P_LoS {truth:.4}, {n_cities} cities");
        assert!((0.05..=0.95).contains(&truth), "{case}");
        assert!(allowed.contains(&covered), "{case}: {covered} % of the intervals cover");
        report(&format!("{case}: {covered} % of the intervals cover; as if links were independent: {naive} %"));
        if theta >= 45.0 && ["urban", "dense", "high-rise"].contains(&city) {
            // Users of one city share its buildings, and these cities have large ones.
            assert!(naive < 75.0, "{case}: naive intervals cover {naive} %");
        }
    }
}

#[test]
fn high_rise_at_low_angles_needs_many_cities() {
    // P_LoS is below 0.05 there and a few cities hold most of it. What is covered is reported, and bounded from below.
    let (n_repetitions, _) = repetitions();
    let n_cities = if is_long() { 100 } else { 30 };
    let angles: &[f64] = if is_long() { &[5.0, 10.0, 20.0] } else { &[20.0] };
    for &theta in angles {
        let (truth, covered, naive) = coverage_of_cities(&setting("high-rise", theta), n_cities, n_repetitions);
        report(&format!(
            "high-rise at {theta}°, P_LoS {truth:.4}, {n_cities} cities: {covered} % cover; naive {naive} %"
        ));
        assert!(truth < 0.05 && covered > 85.0, "{theta}: {covered} %");
    }
}

#[test]
fn intervals_of_independent_links_cover() {
    let (n_repetitions, allowed) = repetitions();
    for (city, theta, n_links) in [("urban", 30.0, 1000), ("dense", 10.0, 1000), ("suburban", 60.0, 200)] {
        let asked = setting(city, theta);
        let truth = truth(&asked);
        let simulator = GeometrySimulator::new(&asked);
        let (mut n_wilson, mut n_exact) = (0_u32, 0_u32);
        for k in 0..n_repetitions {
            let count = simulator.count(5, k * n_links, n_links);
            n_wilson += u32::from(covers(wilson(count.los, count.receivers, 0.95).interval, truth));
            n_exact += u32::from(covers(Some(clopper_pearson(count.los, count.receivers, 0.95)), truth));
        }
        let share = |n: u32| 100.0 * f64::from(n) / n_repetitions as f64;
        assert!(allowed.contains(&share(n_wilson)), "{city} at {theta}: Wilson covers {} %", share(n_wilson));
        assert!(share(n_exact) >= *allowed.start(), "{city} at {theta}: {} %", share(n_exact));
        assert!(n_exact >= n_wilson, "the exact interval is never the shorter one");
    }
}

#[test]
fn intervals_of_the_product_cover() {
    let (n_repetitions, allowed) = repetitions();
    for (city, theta) in [("urban", 20.0), ("high-rise", 60.0)] {
        let asked = setting(city, theta);
        let truth = truth(&asked);
        let covered = (0..n_repetitions).filter(|seed| {
            let mut product = Product::new(asked, 1000 + seed);
            product.add_points(64);
            covers(product.estimate(0.95).interval, truth)
        });
        let share = 100.0 * covered.count() as f64 / n_repetitions as f64;
        assert!(allowed.contains(&share), "{city} at {theta}: {share} %");
    }
}

#[test]
fn textbook_intervals_are_reproduced() {
    // Brown, Cai & DasGupta 2001 use n = 20; these values are computed by hand from the formulas.
    let e = wilson(8, 20, 0.95);
    let (low, high) = e.interval.unwrap();
    assert!((low - 0.218_8).abs() < 5e-4 && (high - 0.613_4).abs() < 5e-4, "{low} {high}");
    // 0 of 10: 1 − 0.025^(1/10).
    let (low, high) = clopper_pearson(0, 10, 0.95);
    assert!(low <= 0.0 && (high - (1.0 - 0.025_f64.powf(0.1))).abs() < 1e-9, "{high}");
    let (low, high) = clopper_pearson(10, 10, 0.95);
    assert!(high >= 1.0 && (low - 0.025_f64.powf(0.1)).abs() < 1e-9, "{low}");
}

#[test]
fn few_clusters_have_no_interval_and_empty_ones_do_not_count() {
    let some = |n: usize| vec![Count { receivers: 10, los: 4 }; n];
    assert_eq!(clustered(&some(9), 0.95).interval, None);
    assert_eq!(clustered(&some(9), 0.95).p_los, Some(0.4));
    assert!(clustered(&some(10), 0.95).interval.is_some());
    let mut with_empty = some(9);
    with_empty.extend(vec![Count::default(); 5]);
    assert_eq!(clustered(&with_empty, 0.95).clusters, 9);
    assert_eq!(clustered(&with_empty, 0.95).interval, None);
    assert_eq!(clustered(&[Count::default(); 20], 0.95).p_los, None);
    // All alike: no spread is seen, but the interval is not a point.
    let (low, high) = clustered(&some(30), 0.95).interval.unwrap();
    assert!(low < 0.4 && 0.4 < high);
}
