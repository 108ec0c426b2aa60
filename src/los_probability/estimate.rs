//! An estimate is a value with its interval, its standard error, and what it rests on.

use statrs::distribution::{Beta, ContinuousCDF, Normal, StudentsT};

/// Fewer clusters than this tell too little about their spread: there is no interval.
pub const FEWEST_CLUSTERS: u64 = 10;

/// P_LoS with what is known about its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// P_LoS; `None` without a single user who counts.
    pub p_los: Option<f64>,
    /// Confidence interval, within \[0, 1\]; `None` where there are too few clusters.
    pub interval: Option<(f64, f64)>,
    /// Standard error; `None` where there are too few clusters.
    pub std_error: Option<f64>,
    /// Links behind it.
    pub samples: u64,
    /// Independent groups of links behind it.
    pub clusters: u64,
}

impl Estimate {
    /// A value known without sampling.
    pub fn exact(p_los: f64) -> Self {
        Estimate { p_los: Some(p_los), interval: Some((p_los, p_los)), std_error: Some(0.0), samples: 0, clusters: 0 }
    }

    /// Half of the interval's width.
    pub fn half_width(&self) -> Option<f64> {
        self.interval.map(|(low, high)| 0.5 * (high - low))
    }
}

/// Links that were counted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Count {
    /// Links whose user counts.
    pub receivers: u64,
    /// Those in line of sight.
    pub los: u64,
}

/// The two-sided quantile of Student's t distribution.
pub fn student_quantile(confidence: f64, degrees_of_freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees_of_freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(0.5 + 0.5 * confidence))
}

/// The two-sided quantile of the normal distribution.
pub fn normal_quantile(confidence: f64) -> f64 {
    Normal::standard().inverse_cdf(0.5 + 0.5 * confidence)
}

/// A ratio Σx / Σw over independent clusters, and its standard error by linearization.
struct Ratio {
    value: f64,
    std_error: f64,
    n_clusters: u64,
}

fn ratio(clusters: impl Iterator<Item = (f64, f64)> + Clone) -> Option<Ratio> {
    let (x, w) = clusters.clone().fold((0.0, 0.0), |sum, c| (sum.0 + c.0, sum.1 + c.1));
    if w <= 0.0 {
        return None;
    }
    let value = x / w;
    let n_clusters = clusters.clone().filter(|c| c.1 > 0.0).count() as u64;
    let squares: f64 = clusters.map(|(x, w)| (x - value * w).powi(2)).sum();
    let n = n_clusters as f64;
    let std_error = if n_clusters > 1 { (n / (n - 1.0) * squares).sqrt() / w } else { f64::INFINITY };
    Some(Ratio { value, std_error, n_clusters })
}

/// The estimate Σx / Σw of means over independent randomizations (x, w), with Student's interval.
pub fn ratio_of_clusters(
    clusters: impl Iterator<Item = (f64, f64)> + Clone,
    samples: u64,
    confidence: f64,
) -> Estimate {
    let Some(ratio) = ratio(clusters) else {
        return Estimate { p_los: None, interval: None, std_error: None, samples, clusters: 0 };
    };
    let is_enough = ratio.n_clusters >= FEWEST_CLUSTERS;
    let reach = student_quantile(confidence, ratio.n_clusters as f64 - 1.0) * ratio.std_error;
    let p_los = ratio.value.clamp(0.0, 1.0);
    Estimate {
        p_los: Some(p_los),
        interval: is_enough.then(|| ((p_los - reach).max(0.0), (p_los + reach).min(1.0))),
        std_error: is_enough.then_some(ratio.std_error),
        samples,
        clusters: ratio.n_clusters,
    }
}

/// P_LoS from counts in independent clusters, whose users share their buildings.
///
/// The standard error is that of a ratio over clusters. The interval is Wilson's, for as many independent links as would
/// have that standard error, p(1 − p)/se², and with Student's quantile for the number of clusters: unlike p ± t·se it
/// stays within \[0, 1\] and is not centered on p, which matters where P_LoS is small and few cities contribute most of it.
///
/// # References
/// Korn & Graubard 1998, Survey Methodology 24, 193–201 (effective sample size); Wilson 1927, JASA 22, 209–212.
pub fn clustered(clusters: &[Count], confidence: f64) -> Estimate {
    let samples = clusters.iter().map(|c| c.receivers).sum();
    let Some(ratio) = ratio(clusters.iter().map(|c| (c.los as f64, c.receivers as f64))) else {
        return Estimate { p_los: None, interval: None, std_error: None, samples, clusters: 0 };
    };
    let is_enough = ratio.n_clusters >= FEWEST_CLUSTERS;
    let p = ratio.value;
    let interval = is_enough.then(|| {
        let quantile = student_quantile(confidence, ratio.n_clusters as f64 - 1.0);
        // All links alike tell no spread: as many independent links as clusters, at least.
        let n = if ratio.std_error > 0.0 { p * (1.0 - p) / ratio.std_error.powi(2) } else { ratio.n_clusters as f64 };
        wilson_for(p, n, quantile)
    });
    Estimate {
        p_los: Some(p),
        interval,
        std_error: is_enough.then_some(ratio.std_error),
        samples,
        clusters: ratio.n_clusters,
    }
}

/// P_LoS from `los` of `n` independent links, with Wilson's interval.
///
/// # References
/// Wilson 1927, JASA 22, 209–212.
pub fn wilson(los: u64, n: u64, confidence: f64) -> Estimate {
    if n == 0 {
        return Estimate { p_los: None, interval: None, std_error: None, samples: 0, clusters: 0 };
    }
    let p = los as f64 / n as f64;
    let is_enough = n >= FEWEST_CLUSTERS;
    Estimate {
        p_los: Some(p),
        interval: is_enough.then(|| wilson_for(p, n as f64, normal_quantile(confidence))),
        std_error: is_enough.then(|| (p * (1.0 - p) / n as f64).sqrt()),
        samples: n,
        clusters: n,
    }
}

/// The exact interval of `los` of `n` independent links: it covers at least as often as it says.
///
/// # References
/// Clopper & Pearson 1934, Biometrika 26, 404–413.
pub fn clopper_pearson(los: u64, n: u64, confidence: f64) -> (f64, f64) {
    let tail = 0.5 * (1.0 - confidence);
    let (k, rest) = (los as f64, (n - los) as f64);
    let quantile = |a: f64, b: f64, p: f64| Beta::new(a, b).map_or(f64::NAN, |beta| beta.inverse_cdf(p));
    let low = if los == 0 { 0.0 } else { quantile(k, rest + 1.0, tail) };
    let high = if los == n { 1.0 } else { quantile(k + 1.0, rest, 1.0 - tail) };
    (low, high)
}

/// Wilson's interval about `p` for `n` independent links (any positive number) and a quantile.
fn wilson_for(p: f64, n: f64, quantile: f64) -> (f64, f64) {
    let z2 = quantile * quantile;
    let middle = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let reach = quantile / (1.0 + z2 / n) * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    ((middle - reach).clamp(0.0, 1.0).min(p), (middle + reach).clamp(0.0, 1.0).max(p))
}
