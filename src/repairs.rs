//! File of `--repairs`: every fault of footprints as a row of a table or a point.

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::answer::{
    Answer, CommandFacts, Provenance, Rows, RunFacts, Spent, document_of, feature, feature_collection, rows,
};
use crate::error::Result;
use crate::export::{Batch, Format};
use crate::picture::Look;
use crate::quantity::counted;
use crate::read::Repair;
use crate::scene::FoundRepairs;

/// Output formats of the list.
pub(crate) const FORMATS: [Format; 2] = [Format::Csv, Format::GeoJson];

/// List of repairs of a run.
#[derive(Debug)]
pub(crate) struct Repairs {
    facts: RunFacts,
    repairs: Vec<Repair>,
    /// Layer of the file that was read.
    layer: String,
}

/// Provenance of a list of repairs.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct RepairsDocument {
    #[serde(flatten)]
    provenance: Provenance,
    /// Number of repairs.
    repairs: usize,
}

/// A row of the list.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct RepairRow {
    /// Number of the feature in the file, from 1.
    feature: u64,
    /// Id of the feature.
    id: String,
    /// Layer of the file.
    layer: String,
    /// Fault of the feature: a stable word.
    fault: &'static str,
    /// Code of the warning that counts the fault.
    code: String,
    /// Repair that was made.
    done: &'static str,
    /// Point of the feature, east [units of the scene's reference system]; empty without area.
    x: Option<f64>,
    /// Point of the feature, north [units of the scene's reference system].
    y: Option<f64>,
}

impl Repairs {
    pub(crate) fn of(found: &FoundRepairs, layer: String, command: CommandFacts) -> Repairs {
        let FoundRepairs { repairs, facts } = found.clone();
        Repairs { facts: RunFacts { command, ..facts }, repairs, layer }
    }

    fn row(&self, repair: &Repair) -> RepairRow {
        RepairRow {
            feature: repair.feature as u64,
            id: repair.id.clone(),
            layer: self.layer.clone(),
            fault: repair.fault.word(),
            code: format!("W{}", repair.fault.code()),
            done: repair.done,
            x: repair.place.map(|place| place[0]),
            y: repair.place.map(|place| place[1]),
        }
    }
}

impl Answer for Repairs {
    fn document(&self, _: Option<Spent>) -> Value {
        document_of(&RepairsDocument {
            provenance: self.facts.provenance("skyshed/repairs/1"),
            repairs: self.repairs.len(),
        })
    }

    fn table(&self) -> Rows {
        rows(self.repairs.iter().map(|repair| self.row(repair)))
    }

    fn notes(&self, _: Spent) -> Vec<String> {
        vec![format!("{} mended or left out", counted(self.repairs.len() as u64, "thing", "things"))]
    }

    fn add(&self, batch: &mut Batch, path: &Path, _: Format, _: &Look) -> Result<()> {
        let point = |repair: &Repair| {
            let mut properties = document_of(&self.row(repair));
            // The geometry holds the place.
            properties
                .as_object_mut()
                .into_iter()
                .for_each(|row| row.retain(|name, _| !["x", "y"].contains(&name.as_str())));
            feature(properties, repair.place.map(|place| ("Point", place.to_vec().into())))
        };
        let features = self.repairs.iter().map(point).collect();
        let document = feature_collection(&self.facts.grid, self.document(None), features);
        Ok(batch.add(path, format!("{document}\n").as_bytes())?)
    }
}
