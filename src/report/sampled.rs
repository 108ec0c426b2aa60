//! P_LoS by zone of sampled placements as reported: the document `skyshed/place-sample/1` and its table.

use serde_json::{Map, Value, json};

use super::documents::RunFacts;
use crate::los_probability::estimate::{Estimate, FEWEST_CLUSTERS};
use crate::zones::Zone;

/// P_LoS of receivers in one zone from placements over another.
#[derive(Debug, Clone)]
pub struct SampledRow {
    /// What the UAVs hover over.
    pub placement: Zone,
    /// Height of the UAVs above ground \[m\].
    pub height_m: f64,
    /// Where the receivers are; `None`: all of them.
    pub receivers: Option<Zone>,
    /// Placements that were mapped, in all cities together.
    pub n_placements: usize,
    /// Placements that were left out because they are inside a building at this height.
    pub n_inside: usize,
    /// Placements that were tried and left out because their disc is cut by the border of the data.
    pub n_cut: usize,
    /// P_LoS.
    pub estimate: Estimate,
}

impl SampledRow {
    /// The word for the receivers in tables.
    pub fn receivers_name(&self) -> &'static str {
        self.receivers.map_or("all", Zone::name)
    }

    /// Why there is no P_LoS, or no interval.
    pub fn reason(&self) -> Option<String> {
        let zone = self.placement.name();
        match self.estimate {
            Estimate { p_los: None, .. } if self.n_placements == 0 && self.n_inside > 0 => {
                Some(format!("every sampled {zone} place is inside a building at this height"))
            }
            Estimate { p_los: None, .. } if self.n_placements == 0 && self.n_cut > 0 => {
                Some(format!("no {zone} place was found whose disc lies in the data"))
            }
            Estimate { p_los: None, .. } if self.n_placements == 0 => Some(format!("the scene has no {zone} place")),
            Estimate { p_los: None, .. } => Some("no receiver of the kind is in range".into()),
            Estimate { interval: None, .. } => Some(format!(
                "no interval: it needs at least {FEWEST_CLUSTERS} cities, or {FEWEST_CLUSTERS} placements and blocks of one"
            )),
            _ => None,
        }
    }
}

/// A study of sampled placements.
#[derive(Debug, Clone)]
pub struct SampledReport {
    /// The run.
    pub facts: RunFacts,
    /// Height of the receivers above what they stand on \[m\].
    pub rx_height_m: f64,
    /// Range \[m\], if it is limited.
    pub radius_m: Option<f64>,
    /// Cities that were drawn; 1 for a city in a file.
    pub n_cities: u64,
    /// Whether placements are over the middles of the zones' parts.
    pub is_centered: bool,
    /// Edge of a block of ground \[m\].
    pub block_m: f64,
    /// Confidence of the intervals.
    pub confidence: f64,
    /// The values.
    pub rows: Vec<SampledRow>,
}

impl SampledReport {
    /// What is resampled, or is independent, behind the intervals.
    pub fn clusters(&self) -> &'static str {
        if self.n_cities > 1 { "cities" } else { "blocks of ground and placements" }
    }

    /// The document; the same for equal runs.
    pub fn document(&self) -> Value {
        let mut document = self.head();
        let row = |row: &SampledRow| {
            let e = &row.estimate;
            let mut object = Map::new();
            object.insert("placement".into(), row.placement.name().into());
            object.insert("height_m".into(), row.height_m.into());
            object.insert("receivers_zone".into(), row.receivers_name().into());
            object.insert("placements".into(), row.n_placements.into());
            object.insert("inside_building".into(), row.n_inside.into());
            object.insert("disc_cut".into(), row.n_cut.into());
            object.insert("p_los".into(), e.p_los.into());
            object.insert("ci_low".into(), e.interval.map(|i| i.0).into());
            object.insert("ci_high".into(), e.interval.map(|i| i.1).into());
            object.insert("std_error".into(), e.std_error.into());
            object.insert("samples".into(), e.samples.into());
            object.insert("clusters".into(), e.clusters.into());
            object.extend(row.reason().map(|reason| ("reason".to_string(), Value::from(reason))));
            Value::Object(object)
        };
        document.insert("rows".into(), self.rows.iter().map(row).collect::<Vec<_>>().into());
        document.insert("warnings".into(), self.facts.warnings());
        Value::Object(document)
    }

    /// The document without the rows, as stored in pictures and beside tables.
    pub fn provenance(&self) -> Value {
        let mut document = self.head();
        document.insert("warnings".into(), self.facts.warnings());
        Value::Object(document)
    }

    fn head(&self) -> Map<String, Value> {
        let mut document = self.facts.head("skyshed/place-sample/1");
        document.insert("rx_height_m".into(), self.rx_height_m.into());
        document.insert("radius_m".into(), self.radius_m.into());
        document.insert("cities".into(), self.n_cities.into());
        document.insert(
            "discs".into(),
            match self.radius_m {
                Some(_) => "whole: the disc of each placement lies in the data".into(),
                None => Value::Null,
            },
        );
        document.insert("places".into(), if self.is_centered { "centers" } else { "anywhere in the zone" }.into());
        document.insert(
            "interval".into(),
            json!({"confidence": self.confidence, "clusters": self.clusters(), "block_m": self.block_m}),
        );
        document
    }

    /// The table: one row per placement zone, height and receivers.
    pub fn table(&self) -> Vec<Vec<String>> {
        let header = "placement,height_m,receivers_zone,radius_m,rx_height_m,cities,placements,inside_building,p_los,\
                      ci_low,ci_high,std_error,samples,clusters,reason,disc_cut";
        let mut rows = vec![header.split(',').map(str::to_string).collect::<Vec<_>>()];
        let optional = |v: Option<f64>| v.map_or(String::new(), |v| v.to_string());
        rows.extend(self.rows.iter().map(|row| {
            let e = &row.estimate;
            vec![
                row.placement.name().to_string(),
                row.height_m.to_string(),
                row.receivers_name().to_string(),
                optional(self.radius_m),
                self.rx_height_m.to_string(),
                self.n_cities.to_string(),
                row.n_placements.to_string(),
                row.n_inside.to_string(),
                optional(e.p_los),
                optional(e.interval.map(|i| i.0)),
                optional(e.interval.map(|i| i.1)),
                optional(e.std_error),
                e.samples.to_string(),
                e.clusters.to_string(),
                row.reason().unwrap_or_default(),
                row.n_cut.to_string(),
            ]
        }));
        rows
    }
}
