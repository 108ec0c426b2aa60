//! Report of P_LoS against the UAV's height: the document `skyshed/height-curve/1` and its table.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::report::{Hovering, MapReport, SiteFacts};
use crate::answer::{Head, Rows, RunFacts, Share, WarningFacts, digest_words, document_of, rows, warnings_of};
use crate::coverage::HeightCurve;
use crate::digest::Sha256;
use crate::quantity::meters;
use crate::sight::{SightFacts, SightPlan};

/// Shares of receivers for which the document holds the least height \[%\].
const QUANTILES: [u8; 9] = [5, 10, 25, 50, 75, 90, 95, 99, 100];

/// Curves of a run.
#[derive(Debug, Clone)]
pub(crate) struct HeightCurveReport {
    pub(crate) facts: RunFacts,
    pub(crate) sight: SightPlan,
    pub(crate) sites: Vec<CurveFacts>,
    digest: String,
}

/// Curve of one UAV: the UAV with its counts at the requested height, and the heights of the table.
#[derive(Debug, Clone)]
pub(crate) struct CurveFacts {
    pub(crate) site: SiteFacts,
    pub(crate) curve: HeightCurve,
    /// Heights of the table \[1/1024 m above the datum\].
    pub(crate) heights: Vec<i32>,
}

impl CurveFacts {
    fn heights_of(&self, height: Option<i32>) -> Heights {
        let above = |h: i32| self.curve.ground().map(|ground| meters(h) - meters(ground));
        Heights { height_agl_m: height.and_then(above), height_amsl_m: height.map(meters) }
    }

    fn point(&self, height: i32) -> PointDocument {
        let los = (height >= self.curve.lowest_height()).then(|| self.curve.los_at(height));
        let p_los = self.curve.p_los_at(height);
        PointDocument {
            heights: self.heights_of(Some(height)),
            receivers: self.site.tally.receivers,
            los,
            p_los,
            reason: match (los, p_los) {
                (None, _) => Some("below the surface under the UAV"),
                (Some(_), None) => Some(self.site.tally.reason()),
                _ => None,
            },
        }
    }

    fn quantile(&self, percent: u8) -> QuantileDocument {
        let height = self.curve.least_height_reaching(percent);
        let reason = match self.site.tally.p_los() {
            None => self.site.tally.reason(),
            Some(_) => "no height within ±32768 m of the datum is enough",
        };
        QuantileDocument {
            p_los: f64::from(percent) / 100.0,
            heights: self.heights_of(height),
            reason: height.is_none().then_some(reason),
        }
    }

    fn document(&self) -> CurveDocument {
        let lowest = self.heights_of(Some(self.curve.lowest_height()));
        CurveDocument {
            hovering: self.site.hovering(),
            seen: (&self.site.tally).into(),
            lowest_height_agl_m: lowest.height_agl_m,
            lowest_height_amsl_m: lowest.height_amsl_m,
            never_los: self.curve.never_los(),
            least_heights: QUANTILES.map(|percent| self.quantile(percent)).to_vec(),
            curve: self.heights.iter().map(|height| self.point(*height)).collect(),
        }
    }
}

impl HeightCurveReport {
    /// Returns the report of the curves of a map.
    pub(crate) fn of(map: &MapReport, sites: Vec<CurveFacts>) -> Self {
        // Least heights have their own engine, whichever engine made the map.
        let facts = RunFacts { method: sites.first().map(|site| site.curve.method()), ..map.facts.clone() };
        let digest = digest(&sites);
        HeightCurveReport { facts, sight: map.sight, sites, digest }
    }

    /// Returns the document, which is the same for equal runs. `with_curves` adds the UAVs.
    pub(crate) fn document(&self, with_curves: bool) -> Value {
        document_of(&HeightCurveDocument {
            head: self.facts.head("skyshed/height-curve/1"),
            sight: self.sight.facts(),
            sites: with_curves.then(|| self.sites.iter().map(CurveFacts::document).collect()),
            warnings: warnings_of(&self.facts.warnings),
            digest: self.digest.clone(),
        })
    }

    /// Returns the table: one row per site and height.
    pub(crate) fn table(&self) -> Rows {
        let of = |facts: &CurveFacts| {
            let row = |height: &i32| {
                let PointDocument { heights, receivers, los, p_los, .. } = facts.point(*height);
                CurveRow { site: facts.site.id.clone(), heights, receivers, los, p_los }
            };
            facts.heights.iter().map(row).collect::<Vec<_>>()
        };
        rows(self.sites.iter().flat_map(of))
    }
}

/// Returns the SHA-256 of the curves, in little endian. For each site in order it covers the number
/// of receivers (u64), then each step of the curve. A step is a height at which receivers come into
/// sight (i32, 1/1024 m above the datum) and the number in sight from there up (u64).
fn digest(sites: &[CurveFacts]) -> String {
    let mut hasher = Sha256::default();
    for CurveFacts { curve, .. } in sites {
        hasher.update(curve.receivers().to_le_bytes());
        for (height, in_sight) in curve.steps() {
            hasher.update(height.to_le_bytes());
            hasher.update(in_sight.to_le_bytes());
        }
    }
    digest_words(hasher)
}

/// P_LoS against the UAV's height.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct HeightCurveDocument {
    #[serde(flatten)]
    head: Head,
    #[serde(flatten)]
    sight: SightFacts,
    /// UAVs; left out of the documents in pictures and beside tables.
    #[serde(skip_serializing_if = "Option::is_none")]
    sites: Option<Vec<CurveDocument>>,
    /// Warnings.
    warnings: Vec<WarningFacts>,
    /// SHA-256 of the curves.
    digest: String,
}

/// Curve of a UAV, with its counts at the requested height.
#[derive(Debug, Serialize, JsonSchema)]
struct CurveDocument {
    #[serde(flatten)]
    hovering: Hovering,
    #[serde(flatten)]
    seen: Share,
    /// Lowest height that the UAV may have above the ground [m].
    lowest_height_agl_m: Option<f64>,
    /// Lowest height that the UAV may have above the datum [m].
    lowest_height_amsl_m: Option<f64>,
    /// Receivers that are in line of sight from no height.
    never_los: u64,
    /// Least heights at which given shares of receivers are in line of sight.
    least_heights: Vec<QuantileDocument>,
    /// Curve at the heights of the table.
    curve: Vec<PointDocument>,
}

/// Height of the UAV.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
struct Heights {
    /// Above the ground below the UAV [m]; null where none is known.
    height_agl_m: Option<f64>,
    /// Above the datum [m].
    height_amsl_m: Option<f64>,
}

/// Least height that reaches a share.
#[derive(Debug, Clone, Serialize, JsonSchema)]
struct QuantileDocument {
    /// Share of the receivers.
    p_los: f64,
    #[serde(flatten)]
    heights: Heights,
    /// Reason why no height reaches it.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'static str>,
}

/// Height of a curve.
#[derive(Debug, Serialize, JsonSchema)]
struct PointDocument {
    #[serde(flatten)]
    heights: Heights,
    /// Receivers in range.
    receivers: u64,
    /// Receivers in line of sight; null at a height where the UAV cannot be.
    los: Option<u64>,
    /// Share of the receivers in line of sight.
    p_los: Option<f64>,
    /// Reason why there is no share.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'static str>,
}

/// Row of the table of curves.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct CurveRow {
    /// Name of the UAV.
    site: String,
    #[serde(flatten)]
    heights: Heights,
    /// Receivers in range.
    receivers: u64,
    /// Receivers in line of sight; empty at a height where the UAV cannot be.
    los: Option<u64>,
    /// Share of the receivers in line of sight; empty at such a height, and without a receiver.
    p_los: Option<f64>,
}
