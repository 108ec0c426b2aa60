//! Speed against accuracy: `skyshed/chart/1` of a scene, and its table.

use serde_json::{Map, Value, json};

use super::documents::{RunFacts, digest_words};
use super::position::Position;
use crate::accuracy::chart::{Family, Truth};
use crate::accuracy::comparison::Comparison;
use crate::accuracy::front::pareto_front;
use crate::coverage::Uav;
use crate::digest::Sha256;

/// The schema of charts.
pub const CHART_SCHEMA: &str = "skyshed/chart/1";

/// What a contestant costs on the machine of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// User CPU time of one run \[s\]; `None` where the system does not tell.
    pub cpu_s: Option<f64>,
    /// Wall time of one run \[s\].
    pub wall_s: f64,
    /// Peak of resident memory meanwhile \[MB\]; `None` where the system does not tell.
    pub peak_mb: Option<f64>,
    /// Runs that were timed.
    pub runs: u32,
}

/// What the numbers of a chart mean, for documents.
pub(super) fn meaning() -> Value {
    json!({
        "cpu_s": "user time of all threads for one run over all UAVs, the scene read and made ready; the median of groups of \
                  runs after a warm-up, or the first run where it takes long; a peer is a whole process",
        "wall_s": "time on the clock for the same",
        "peak_mb": "largest resident set of the process meanwhile, the program and the scene included, with what the \
                    allocator kept from before; of a peer its own",
        "runs": "runs that were timed",
    })
}

/// Why a number of a cost is missing.
const NO_CPU: &str = "the system does not tell CPU time";
const NO_PEAK: &str = "the system does not let a process count its peak memory anew";

impl Cost {
    /// The columns `cpu_s`, `wall_s`, `peak_mb`; all empty without a cost.
    pub(super) fn cells(cost: Option<&Cost>) -> [String; 3] {
        let number = |of: &dyn Fn(&Cost) -> Option<f64>| text(cost.and_then(of));
        [number(&|c| c.cpu_s), number(&|c| Some(c.wall_s)), number(&|c| c.peak_mb)]
    }

    /// The cost of one run, in documents.
    pub(super) fn json(&self) -> Map<String, Value> {
        let mut object = Map::new();
        object.insert("cpu_s".into(), self.cpu_s.into());
        object.insert("wall_s".into(), self.wall_s.into());
        object.insert("peak_mb".into(), self.peak_mb.into());
        object.insert("runs".into(), self.runs.into());
        let reasons = [(self.cpu_s, "cpu_reason", NO_CPU), (self.peak_mb, "peak_reason", NO_PEAK)];
        let missing = reasons.into_iter().filter(|(value, ..)| value.is_none());
        object.extend(missing.map(|(_, key, reason)| (key.to_string(), Value::from(reason))));
        object
    }
}

pub(super) fn text<T: ToString>(value: Option<T>) -> String {
    value.map_or(String::new(), |v| v.to_string())
}

/// A contestant's result.
#[derive(Debug, Clone)]
pub struct ChartRow {
    /// The engine as it is typed after `--method`, or the program.
    pub method: String,
    /// What it decides on, and versions; empty for the scene itself.
    pub parameters: String,
    /// A short name for pictures.
    pub label: String,
    /// Which kind it is.
    pub family: Family,
    /// What it costs and how far it errs, or why there is no answer.
    pub result: Result<(Cost, Comparison), String>,
}

impl ChartRow {
    /// CPU time per receiver of the scene \[ns\] and share of wrong receivers; `None` where one of them is missing.
    pub fn place(&self) -> Option<(f64, f64)> {
        let (cost, counts) = self.result.as_ref().ok()?;
        let cpu_ns = 1e9 * cost.cpu_s? / (counts.receivers + counts.unanswered) as f64;
        Some((cpu_ns, counts.wrong_share()?)).filter(|(cpu_ns, _)| cpu_ns.is_finite() && *cpu_ns > 0.0)
    }
}

/// A chart of a scene as reported.
#[derive(Debug, Clone)]
pub struct ChartReport {
    /// The run.
    pub facts: RunFacts,
    /// Height of the receivers above what they stand on \[m\].
    pub rx_height_m: f64,
    /// Which cells hold receivers.
    pub receivers: &'static str,
    /// Range \[m\], if it is limited.
    pub radius_m: Option<f64>,
    /// The UAVs, each with longitude and latitude \[deg\] if it was given by these.
    pub uavs: Vec<(Uav, Option<[f64; 2]>)>,
    /// The exact answer.
    pub truth: Truth,
    /// Threads of the timed runs.
    pub threads: usize,
    /// What it costs to read each height once and to write the mask once, for all UAVs.
    pub floor: Cost,
    /// The contestants that had their turn.
    pub rows: Vec<ChartRow>,
    /// How many were to have it.
    pub planned: usize,
}

impl ChartReport {
    /// Whether the user ended the run before all contestants had their turn.
    pub fn is_interrupted(&self) -> bool {
        self.rows.len() < self.planned
    }

    /// The memory floor per receiver \[ns of CPU time\].
    pub fn floor_ns(&self) -> Option<f64> {
        let receivers = self.truth.receivers();
        let floor = 1e9 * self.floor.cpu_s? / receivers as f64;
        (receivers > 0 && floor > 0.0).then_some(floor)
    }

    /// Rows on the Pareto front of CPU time and wrong receivers, by rising CPU time.
    pub fn front(&self) -> Vec<usize> {
        let places = self.rows.iter().map(|row| row.place().unwrap_or((f64::NAN, f64::NAN)));
        pareto_front(&places.collect::<Vec<_>>())
    }

    /// SHA-256 of what does not depend on the machine: a line of method, parameters and counts per row.
    fn digest(&self) -> String {
        let mut hasher = Sha256::default();
        for row in self.rows.iter().filter(|row| row.family != Family::Peer) {
            let counts = row.result.as_ref().map(|(_, counts)| format!("{:?}", count_cells(counts)));
            hasher.update(format!("{},{},{counts:?}\n", row.method, row.parameters));
        }
        digest_words(hasher)
    }

    /// The document; it holds times of this machine.
    pub fn document(&self) -> Value {
        let mut document = self.head();
        document.insert("memory_floor".into(), self.floor.json().into());
        let rows = self.rows.iter().map(|row| self.row_json(row));
        document.insert("contestants".into(), with_front(rows, &self.front()));
        self.close(document)
    }

    /// The document without contestants and times, as stored in pictures and beside tables.
    pub fn provenance(&self) -> Value {
        self.close(self.head())
    }

    fn head(&self) -> Map<String, Value> {
        let mut document = self.facts.head(CHART_SCHEMA);
        document.insert("kind".into(), "scene".into());
        document.insert("rx_height_m".into(), self.rx_height_m.into());
        document.insert("receivers".into(), self.receivers.into());
        document.insert("radius_m".into(), self.radius_m.into());
        document.insert("threads".into(), self.threads.into());
        document.insert("interrupted".into(), self.is_interrupted().into());
        let uav = |(uav, lonlat): &(Uav, Option<[f64; 2]>)| {
            let mut object = Map::new();
            object.insert("id".into(), uav.id.clone().into());
            Position { x: uav.station.place.x, y: uav.station.place.y, lonlat: *lonlat }.tell(&mut object);
            object.insert("height_amsl_m".into(), uav.height_amsl_m().into());
            object.insert("height_agl_m".into(), uav.height_agl_m.into());
            object.insert("placement".into(), uav.placement.name().into());
            Value::Object(object)
        };
        document.insert("uavs".into(), self.uavs.iter().map(uav).collect::<Vec<_>>().into());
        let mut exact = json!({
            "method": self.truth.method.name(), "receivers": self.truth.receivers(), "los": self.truth.los(),
            "p_los": self.truth.p_los(), "links_checked_by_ray": self.truth.checked,
        });
        if self.truth.p_los().is_none() {
            exact["reason"] = "no receiver in range".into();
        }
        document.insert("exact".into(), exact);
        document.insert("meaning".into(), meaning());
        document
    }

    fn close(&self, mut document: Map<String, Value>) -> Value {
        document.insert("warnings".into(), self.facts.warnings());
        document.insert("digest".into(), self.digest().into());
        Value::Object(document)
    }

    fn row_json(&self, row: &ChartRow) -> Map<String, Value> {
        let mut object = Map::new();
        object.insert("method".into(), row.method.clone().into());
        object.insert("parameters".into(), row.parameters.clone().into());
        object.insert("family".into(), row.family.name().into());
        match &row.result {
            Ok((cost, counts)) => {
                object.extend(cost.json());
                object.insert("cpu_ns_per_receiver".into(), row.place().map(|place| place.0).into());
                let names = COUNTS.split(',').map(str::to_string);
                object.extend(names.zip(count_cells(counts).map(Value::from)));
                object.insert("wrong_share".into(), counts.wrong_share().into());
                object.insert("p_los".into(), counts.p_los().into());
                object.insert("p_los_error".into(), self.truth.p_los_error(counts).into());
                if counts.wrong_share().is_none() {
                    object.insert("reason".into(), "no receiver that both answer".into());
                }
            }
            Err(reason) => {
                let names = format!("cpu_s,wall_s,peak_mb,{COUNTS},wrong_share,p_los,p_los_error");
                object.extend(names.split(',').map(|name| (name.to_string(), Value::Null)));
                object.insert("reason".into(), reason.clone().into());
            }
        }
        object
    }

    /// The table: one row per contestant; what it could not answer is empty, with a reason.
    pub fn table(&self) -> Vec<Vec<String>> {
        let header = "method,parameters,cpu_s,wall_s,peak_mb,wrong_cells,receivers,false_los,false_nlos,p_los,p_los_error,\
                      unanswered,own_receivers,own_los,runs,family,reason";
        let mut rows = vec![header.split(',').map(str::to_string).collect::<Vec<_>>()];
        rows.extend(self.rows.iter().map(|row| {
            let (cost, counts) = row.result.as_ref().map_or((None, None), |(cost, counts)| (Some(cost), Some(counts)));
            let cells = counts.map(|counts| count_cells(counts).map(|count| count.to_string()));
            let [wrong, receivers, false_los, false_nlos, unanswered, own_receivers, own_los] =
                cells.unwrap_or_else(|| std::array::from_fn(|_| String::new()));
            let mut line = vec![row.method.clone(), row.parameters.clone()];
            line.extend(Cost::cells(cost));
            line.extend([wrong, receivers, false_los, false_nlos]);
            line.extend([
                text(counts.and_then(Comparison::p_los)),
                text(counts.and_then(|counts| self.truth.p_los_error(counts))),
            ]);
            line.extend([unanswered, own_receivers, own_los, text(cost.map(|cost| cost.runs))]);
            line.extend([row.family.name().to_string(), text(row.result.as_ref().err())]);
            line
        }));
        rows
    }
}

/// Names of the counts of a contestant.
const COUNTS: &str = "wrong_cells,receivers,false_los,false_nlos,unanswered,own_receivers,own_los";

/// The counts, in the order of their names.
fn count_cells(counts: &Comparison) -> [u64; 7] {
    [
        counts.wrong(),
        counts.receivers,
        counts.false_los,
        counts.false_nlos,
        counts.unanswered,
        counts.own_receivers,
        counts.own_los,
    ]
}

/// Contestants, each with whether it is on the Pareto front, which is given by numbers.
pub(super) fn with_front(rows: impl Iterator<Item = Map<String, Value>>, front: &[usize]) -> Value {
    let row = |(k, mut row): (usize, Map<String, Value>)| {
        row.insert("pareto".into(), front.contains(&k).into());
        Value::Object(row)
    };
    rows.enumerate().map(row).collect::<Vec<_>>().into()
}
