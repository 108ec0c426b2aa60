//! Where methods fail, as reported: the documents `skyshed/stress/1` of families and `skyshed/stress-scene/1` of a scene,
//! and their tables.

use serde_json::{Map, Value, json};

use super::documents::{MapReport, Timing, digest_words};
use crate::accuracy::stress::{Contender, Effort, FamilyScore, Outcome};
use crate::coverage::MarginSample;
use crate::digest::Sha256;

/// Methods tried on families of scenes.
#[derive(Debug, Clone)]
pub struct StressReport {
    /// The words of the command line.
    pub command: Vec<String>,
    /// Scenes and seed.
    pub effort: Effort,
    /// The methods.
    pub methods: Vec<Contender>,
    /// What they did on each family.
    pub scores: Vec<FamilyScore>,
}

/// A share; `None` of nothing.
fn share(part: u64, of: u64) -> Option<f64> {
    #[expect(clippy::cast_precision_loss, reason = "counts of receivers are far below 2^53")]
    let share = part as f64 / of as f64;
    (of > 0).then_some(share)
}

impl StressReport {
    /// Receivers that a method gets wrong on all families that it decides, and how many it decides; `None` if none.
    pub fn total(&self, method: usize) -> Option<[u64; 2]> {
        let decided = self.scores.iter().filter_map(|score| match &score.outcomes[method] {
            Outcome::Decided(wrong) => Some([wrong.total(), score.receivers]),
            Outcome::Cannot(_) => None,
        });
        decided.reduce(|a, b| [a[0] + b[0], a[1] + b[1]])
    }

    /// Failures and trials of a method on a family; `None` where it cannot decide it.
    pub fn rate(score: &FamilyScore, method: usize) -> Option<[u64; 2]> {
        match &score.outcomes[method] {
            Outcome::Decided(wrong) => Some([wrong.total(), score.receivers]),
            Outcome::Cannot(_) => None,
        }
    }

    /// The document; without `seconds` it is the same for equal runs.
    pub fn document(&self, seconds: Option<f64>) -> Value {
        let mut document = Map::new();
        document.insert("schema".into(), "skyshed/stress/1".into());
        document.insert("version".into(), env!("CARGO_PKG_VERSION").into());
        document.insert("command".into(), self.command.clone().into());
        document.insert("seed".into(), self.effort.seed.into());
        document.insert("scenes_per_family".into(), self.effort.scenes.into());
        let method = |(k, method): (usize, &Contender)| {
            let [wrong, receivers] = self.total(k).map_or([None; 2], |total| total.map(Some));
            let rate = self.total(k).and_then(|[wrong, of]| share(wrong, of));
            json!({"method": method.name, "exact": method.is_exact(), "receivers": receivers, "wrong": wrong,
                   "failure_rate": rate})
        };
        document.insert("methods".into(), self.methods.iter().enumerate().map(method).collect::<Vec<_>>().into());
        document.insert("families".into(), self.scores.iter().map(|s| self.family(s)).collect::<Vec<_>>().into());
        if let Some(seconds) = seconds {
            document.insert("timing_s".into(), json!({"total": seconds}));
        }
        document.insert("digest".into(), self.digest().into());
        Value::Object(document)
    }

    fn family(&self, score: &FamilyScore) -> Value {
        let method = |(method, outcome): (&Contender, &Outcome)| match outcome {
            Outcome::Decided(wrong) => {
                let first = wrong.first.as_ref();
                let first = first.map(|(scene, row, col)| json!({"scene": scene, "row": row, "col": col}));
                json!({"method": method.name, "wrong": wrong.total(),
                       "failure_rate": share(wrong.total(), score.receivers),
                       "false_los": wrong.false_los, "false_nlos": wrong.false_nlos, "first_wrong": first})
            }
            Outcome::Cannot(why) => {
                json!({"method": method.name, "wrong": null, "failure_rate": null, "false_los": null,
                       "false_nlos": null, "reason": why})
            }
        };
        let methods: Vec<Value> = self.methods.iter().zip(&score.outcomes).map(method).collect();
        json!({"family": score.family, "breaks": score.breaks, "receivers": score.receivers, "los": score.los,
               "methods": methods})
    }

    /// The table: one row per family and method.
    pub fn table(&self) -> Vec<Vec<String>> {
        let header = "family,method,exact,scenes,seed,receivers,los,wrong,failure_rate,false_los,false_nlos,reason";
        let mut rows = vec![header.split(',').map(str::to_string).collect::<Vec<_>>()];
        for score in &self.scores {
            for (method, outcome) in self.methods.iter().zip(&score.outcomes) {
                let mut row = vec![
                    score.family.to_string(),
                    method.name.clone(),
                    method.is_exact().to_string(),
                    self.effort.scenes.to_string(),
                    self.effort.seed.to_string(),
                    score.receivers.to_string(),
                    score.los.to_string(),
                ];
                row.extend(match outcome {
                    Outcome::Decided(wrong) => [
                        wrong.total().to_string(),
                        share(wrong.total(), score.receivers).map_or(String::new(), |rate| rate.to_string()),
                        wrong.false_los.to_string(),
                        wrong.false_nlos.to_string(),
                        String::new(),
                    ],
                    Outcome::Cannot(why) => {
                        [String::new(), String::new(), String::new(), String::new(), (*why).to_string()]
                    }
                });
                rows.push(row);
            }
        }
        rows
    }

    /// SHA-256 of the table, its cells and rows each ended by a line break.
    fn digest(&self) -> String {
        let mut hasher = Sha256::default();
        for cell in self.table().iter().flat_map(|row| row.iter().map(String::as_str).chain([""])) {
            hasher.update(cell.as_bytes());
            hasher.update(b"\n");
        }
        digest_words(hasher)
    }
}

/// How stable the answers on a scene are: a map with its stability, and margins near grazing.
#[derive(Debug, Clone)]
pub struct StressSceneReport {
    /// The map of the one UAV, its stability with it.
    pub map: MapReport,
    /// Margins of its receivers, or of a sample of them.
    pub margins: MarginSample,
}

/// How near to grazing receivers are counted \[m\], ascending: a lattice step, then powers of ten.
pub const NEAR_M: [f32; 5] = [1.0 / 1024.0, 0.01, 0.1, 1.0, 10.0];

impl StressSceneReport {
    /// How many of the sampled receivers are within each of [`NEAR_M`] of grazing.
    pub fn near(&self) -> [u64; NEAR_M.len()] {
        NEAR_M.map(|reach| self.margins.near(reach))
    }

    /// The document: that of the map, with the margins.
    pub fn document(&self, timing: Option<Timing>) -> Value {
        let sampled = self.margins.margins.len() as u64;
        let bin = |(reach, n): (f32, u64)| json!({"within_m": reach, "receivers": n, "share": share(n, sampled)});
        let bins: Vec<Value> = NEAR_M.into_iter().zip(self.near()).map(bin).collect();
        let mut margins = json!({"every": self.margins.every, "sampled": sampled, "near_grazing": bins});
        if let (0, Some(object)) = (sampled, margins.as_object_mut()) {
            object.insert("reason".into(), self.map.union.reason().into());
        }
        let mut document = self.map.document(timing);
        if let Some(object) = document.as_object_mut() {
            object.insert("schema".into(), "skyshed/stress-scene/1".into());
            object.insert("margins".into(), margins);
        }
        document
    }

    /// The table: one row per move by a lattice step, then one per distance from grazing.
    pub fn table(&self) -> Vec<Vec<String>> {
        let header = "measure,name,receivers,gained,lost,turned,share,reason";
        let mut rows = vec![header.split(',').map(str::to_string).collect::<Vec<_>>()];
        let words = |share: Option<f64>| share.map_or(String::new(), |share| share.to_string());
        for site in &self.map.sites {
            let receivers = site.tally.receivers;
            for (which, turned) in site.stability.iter().flat_map(|s| &s.moves) {
                let numbers = match turned {
                    Ok(turned) => {
                        let both = turned.gained + turned.lost;
                        let counts = [turned.gained, turned.lost, both].map(|n| n.to_string());
                        [counts.to_vec(), vec![words(share(both, receivers)), String::new()]].concat()
                    }
                    Err(reason) => vec![String::new(), String::new(), String::new(), String::new(), reason.clone()],
                };
                let name = ["move".to_string(), which.name().to_string(), receivers.to_string()];
                rows.push([name.to_vec(), numbers].concat());
            }
        }
        let sampled = self.margins.margins.len() as u64;
        for (reach, n) in NEAR_M.into_iter().zip(self.near()) {
            let cells =
                ["margin".into(), format!("within {reach} m"), sampled.to_string(), String::new(), String::new()];
            rows.push([cells.to_vec(), vec![n.to_string(), words(share(n, sampled)), String::new()]].concat());
        }
        rows
    }
}
