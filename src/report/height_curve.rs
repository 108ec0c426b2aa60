//! P_LoS against the UAV's height as reported: the document `skyshed/height-curve/1` and its table.

use serde_json::{Map, Value, json};

use super::documents::{MapReport, RunFacts, SiteFacts, digest_words, tally_json};
use crate::coverage::HeightCurve;
use crate::digest::Sha256;
use crate::los::Method;
use crate::quantity::meters;

/// Shares of receivers for which the document tells the least height \[%\].
pub const QUANTILES: [u8; 9] = [5, 10, 25, 50, 75, 90, 95, 99, 100];

/// One height of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Height of the UAV \[1/1024 m above the datum\].
    pub height: i32,
    /// Receivers in line of sight; `None` where the UAV cannot be, below the surface at its place.
    pub los: Option<u64>,
    /// P_LoS; `None` there too, and without a receiver.
    pub p_los: Option<f64>,
}

/// The curve of one UAV, as reported.
#[derive(Debug, Clone)]
pub struct CurveFacts {
    /// The UAV, with its counts at the height that was asked for.
    pub site: SiteFacts,
    /// Ground below the UAV \[1/1024 m above the datum\], if one is known there.
    pub ground: Option<i32>,
    /// The lowest height that the UAV may have at its place \[1/1024 m above the datum\].
    pub lowest: i32,
    /// Receivers that no height sees.
    pub never_los: u64,
    /// Shares \[%\] and the least height that reaches them \[1/1024 m above the datum\].
    pub quantiles: Vec<(u8, Option<i32>)>,
    /// The heights of the table.
    pub points: Vec<CurvePoint>,
}

impl CurveFacts {
    /// The facts of a curve at the given heights \[1/1024 m above the datum\].
    pub fn of(curve: &HeightCurve, site: &SiteFacts, heights: &[i32]) -> Self {
        let point = |height: i32| CurvePoint {
            height,
            los: (height >= curve.lowest_height()).then(|| curve.los_at(height)),
            p_los: curve.p_los_at(height),
        };
        CurveFacts {
            site: site.clone(),
            ground: curve.ground(),
            lowest: curve.lowest_height(),
            never_los: curve.never_los(),
            quantiles: QUANTILES.iter().map(|p| (*p, curve.least_height_reaching(*p))).collect(),
            points: heights.iter().copied().map(point).collect(),
        }
    }

    /// A height above the ground below the UAV \[m\], if one is known there.
    pub fn agl_m(&self, height: i32) -> Option<f64> {
        self.ground.map(|ground| meters(height) - meters(ground))
    }

    fn json(&self) -> Value {
        let mut object = Map::new();
        object.insert("id".into(), self.site.id.clone().into());
        self.site.position().tell(&mut object);
        object.insert("height_amsl_m".into(), self.site.height_amsl_m.into());
        object.insert("height_agl_m".into(), self.site.height_agl_m.into());
        object.insert("placement".into(), self.site.placement.into());
        object.extend(tally_json(&self.site.tally));
        object.insert("lowest_height_agl_m".into(), self.agl_m(self.lowest).into());
        object.insert("lowest_height_amsl_m".into(), meters(self.lowest).into());
        object.insert("never_los".into(), self.never_los.into());
        let heights = |height: Option<i32>| json!({"height_agl_m": height.and_then(|h| self.agl_m(h)), "height_amsl_m": height.map(meters)});
        let quantile = |(percent, height): &(u8, Option<i32>)| {
            let mut row = Map::new();
            row.insert("p_los".into(), (f64::from(*percent) / 100.0).into());
            row.extend(heights(*height).as_object().cloned().unwrap_or_default());
            if height.is_none() {
                let reason = if self.site.tally.receivers == 0 {
                    self.site.tally.reason()
                } else {
                    "no height within ±32768 m of the datum is enough"
                };
                row.insert("reason".into(), reason.into());
            }
            Value::Object(row)
        };
        object.insert("least_heights".into(), self.quantiles.iter().map(quantile).collect::<Vec<_>>().into());
        let point = |p: &CurvePoint| {
            let mut row = heights(Some(p.height)).as_object().cloned().unwrap_or_default();
            row.insert("receivers".into(), self.site.tally.receivers.into());
            row.insert("los".into(), p.los.into());
            row.insert("p_los".into(), p.p_los.into());
            match (p.los, p.p_los) {
                (None, _) => {
                    row.insert("reason".into(), "below the surface under the UAV".into());
                }
                (Some(_), None) => {
                    row.insert("reason".into(), self.site.tally.reason().into());
                }
                _ => {}
            }
            Value::Object(row)
        };
        object.insert("curve".into(), self.points.iter().map(point).collect::<Vec<_>>().into());
        Value::Object(object)
    }
}

/// The curves of a run as reported.
#[derive(Debug, Clone)]
pub struct HeightCurveReport {
    /// The run.
    pub facts: RunFacts,
    /// Height of the receivers above what they stand on \[m\].
    pub rx_height_m: f64,
    /// Which cells hold receivers.
    pub receivers: &'static str,
    /// Range \[m\], if it is limited.
    pub radius_m: Option<f64>,
    /// The UAVs.
    pub sites: Vec<CurveFacts>,
    /// Digest of the curves, see [`curve_digest`].
    pub digest: String,
}

/// SHA-256 of the curves: per site in order the number of its receivers (u64), then for each height at which receivers
/// come into sight that height (i32, 1/1024 m above the datum) and the number in sight from there up (u64); little endian.
pub fn curve_digest<'a>(curves: impl Iterator<Item = &'a HeightCurve>) -> String {
    let mut hasher = Sha256::default();
    for curve in curves {
        hasher.update(curve.receivers().to_le_bytes());
        for (height, in_sight) in curve.steps() {
            hasher.update(height.to_le_bytes());
            hasher.update(in_sight.to_le_bytes());
        }
    }
    digest_words(hasher)
}

impl HeightCurveReport {
    /// The report of the curves of a map, one per site of it.
    pub fn of(map: &MapReport, curves: &[HeightCurve], sites: Vec<CurveFacts>) -> Self {
        HeightCurveReport {
            // Whatever engine made the map, least heights are found by a walk along each link.
            facts: RunFacts { method: Some(Method::Ray), ..map.facts.clone() },
            rx_height_m: map.rx_height_m,
            receivers: map.receivers,
            radius_m: map.radius_m,
            sites,
            digest: curve_digest(curves.iter()),
        }
    }

    /// The document `skyshed/height-curve/1`; the same for equal runs.
    pub fn document(&self) -> Value {
        let mut document = self.head();
        document.insert("sites".into(), self.sites.iter().map(CurveFacts::json).collect::<Vec<_>>().into());
        self.close(document)
    }

    /// The document without the curves themselves, as stored in pictures and beside tables.
    pub fn provenance(&self) -> Value {
        self.close(self.head())
    }

    fn head(&self) -> Map<String, Value> {
        let mut document = self.facts.head("skyshed/height-curve/1");
        document.insert("rx_height_m".into(), self.rx_height_m.into());
        document.insert("receivers".into(), self.receivers.into());
        document.insert("radius_m".into(), self.radius_m.into());
        document
    }

    fn close(&self, mut document: Map<String, Value>) -> Value {
        document.insert("warnings".into(), self.facts.warnings());
        document.insert("digest".into(), self.digest.clone().into());
        Value::Object(document)
    }

    /// The table: one row per site and height. `los` and `p_los` are empty where the UAV cannot be.
    pub fn table(&self) -> Vec<Vec<String>> {
        let header = "site,height_agl_m,height_amsl_m,receivers,los,p_los";
        let mut rows = vec![header.split(',').map(str::to_string).collect::<Vec<_>>()];
        for site in &self.sites {
            rows.extend(site.points.iter().map(|p| {
                vec![
                    site.site.id.clone(),
                    site.agl_m(p.height).map_or(String::new(), |v| v.to_string()),
                    meters(p.height).to_string(),
                    site.site.tally.receivers.to_string(),
                    p.los.map_or(String::new(), |v| v.to_string()),
                    p.p_los.map_or(String::new(), |v| v.to_string()),
                ]
            }));
        }
        rows
    }
}
