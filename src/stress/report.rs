//! Reports of stress tests: the documents `skyshed/stress/1` of families and
//! `skyshed/stress-scene/1` of a scene, and their tables.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::accuracy::stress::{Contender, Effort, FamilyScore, Outcome};
use crate::answer::{CommandFacts, Rows, Spent, Timing, digest_words, document_of, rows};
use crate::coverage::MarginSample;
use crate::digest::Sha256;
use crate::map::{MapDocument, MapReport};
use crate::words::version;

/// Report of methods on families of scenes.
#[derive(Debug, Clone)]
pub(super) struct StressReport {
    /// Command line and question.
    pub(super) command: CommandFacts,
    /// Number of scenes and seed.
    pub(super) effort: Effort,
    pub(super) methods: Vec<Contender>,
    /// Outcomes of all methods on each family.
    pub(super) scores: Vec<FamilyScore>,
}

/// Returns a share; `None` without a whole.
fn share(part: u64, of: u64) -> Option<f64> {
    #[expect(clippy::cast_precision_loss, reason = "counts of receivers are far below 2^53")]
    let share = part as f64 / of as f64;
    (of > 0).then_some(share)
}

impl StressReport {
    /// Returns the wrong receivers of a method over all families that it decides, and all their
    /// receivers. `None` if it decides no family.
    pub(super) fn total(&self, method: usize) -> Option<[u64; 2]> {
        let decided = self.scores.iter().filter_map(|score| match &score.outcomes[method] {
            Outcome::Decided(wrong) => Some([wrong.total(), score.receivers]),
            Outcome::Cannot(_) => None,
        });
        decided.reduce(|a, b| [a[0] + b[0], a[1] + b[1]])
    }

    /// Returns the wrong receivers of a method on a family, and all receivers. `None` if it cannot
    /// decide the family.
    pub(super) fn rate(score: &FamilyScore, method: usize) -> Option<[u64; 2]> {
        match &score.outcomes[method] {
            Outcome::Decided(wrong) => Some([wrong.total(), score.receivers]),
            Outcome::Cannot(_) => None,
        }
    }

    /// Returns the document. Without `spent` it is the same for equal runs.
    pub(super) fn document(&self, spent: Option<Spent>) -> Value {
        let method = |(k, method): (usize, &Contender)| {
            let total = self.total(k);
            MethodDocument {
                method: method.name.clone(),
                exact: method.is_exact(),
                receivers: total.map(|[_, receivers]| receivers),
                wrong: total.map(|[wrong, _]| wrong),
                failure_rate: total.and_then(|[wrong, of]| share(wrong, of)),
            }
        };
        document_of(&StressDocument {
            schema: "skyshed/stress/1",
            version: version(),
            command: self.command.clone(),
            seed: self.effort.seed,
            scenes_per_family: self.effort.scenes,
            methods: self.methods.iter().enumerate().map(method).collect(),
            families: self.scores.iter().map(|score| self.family(score)).collect(),
            timing_s: spent.map(|spent| TotalTiming { total: spent.total }),
            digest: self.digest(),
        })
    }

    fn family(&self, score: &FamilyScore) -> FamilyDocument {
        let method = |(method, outcome): (&Contender, &Outcome)| {
            let first = match outcome {
                Outcome::Decided(wrong) => wrong.first.as_ref(),
                Outcome::Cannot(_) => None,
            };
            let first = first.map(|(scene, row, col)| FirstWrong { scene: scene.clone(), row: *row, col: *col });
            OutcomeDocument {
                method: method.name.clone(),
                outcome: OutcomeFields::of(score, outcome),
                first_wrong: matches!(outcome, Outcome::Decided(_)).then_some(first),
            }
        };
        FamilyDocument {
            family: score.family,
            breaks: score.breaks,
            receivers: score.receivers,
            los: score.los,
            methods: self.methods.iter().zip(&score.outcomes).map(method).collect(),
        }
    }

    /// Returns the table: one row for each family and method.
    pub(super) fn table(&self) -> Rows {
        let of = |score: &FamilyScore| {
            let row = |(method, outcome): (&Contender, &Outcome)| StressRow {
                family: score.family,
                method: method.name.clone(),
                exact: method.is_exact(),
                scenes: self.effort.scenes,
                seed: self.effort.seed,
                receivers: score.receivers,
                los: score.los,
                outcome: OutcomeFields { reason: Some(reason(outcome)), ..OutcomeFields::of(score, outcome) },
            };
            self.methods.iter().zip(&score.outcomes).map(row).collect::<Vec<_>>()
        };
        rows(self.scores.iter().flat_map(of))
    }

    /// Returns the SHA-256 of the table, its cells and rows each ended by a line break.
    fn digest(&self) -> String {
        let mut hasher = Sha256::default();
        for cell in self.table().iter().flat_map(|row| row.iter().map(String::as_str).chain([""])) {
            hasher.update(cell.as_bytes());
            hasher.update(b"\n");
        }
        digest_words(hasher)
    }
}

/// Returns the reason why a method cannot decide a family; empty if it can.
fn reason(outcome: &Outcome) -> &'static str {
    match outcome {
        Outcome::Decided(_) => "",
        Outcome::Cannot(why) => why,
    }
}

/// Report of the stability of a scene's answers: a map with its stability, and margins near
/// grazing.
#[derive(Debug, Clone)]
pub(super) struct StressSceneReport {
    /// Map of the one UAV, with its stability.
    pub(super) map: MapReport,
    /// Margins of its receivers, or of a sample of them.
    pub(super) margins: MarginSample,
}

/// Distances from grazing at which receivers are counted \[m\], ascending: a lattice step, then
/// powers of ten.
pub(super) const NEAR_M: [f32; 5] = [1.0 / 1024.0, 0.01, 0.1, 1.0, 10.0];

impl StressSceneReport {
    /// Counts the sampled receivers within each of [`NEAR_M`] of grazing.
    pub(super) fn near(&self) -> [u64; NEAR_M.len()] {
        NEAR_M.map(|reach| self.margins.near(reach))
    }

    /// Returns the document of the map, with the margins.
    pub(super) fn document(&self, timing: Option<Timing>) -> Value {
        let sampled = self.margins.margins.len() as u64;
        let bin = |(within_m, receivers)| BinDocument { within_m, receivers, share: share(receivers, sampled) };
        document_of(&StressSceneDocument {
            map: self.map.as_document("skyshed/stress-scene/1", timing),
            margins: NearDocument {
                every: self.margins.every,
                sampled,
                near_grazing: NEAR_M.into_iter().zip(self.near()).map(bin).collect(),
                reason: (sampled == 0).then(|| self.map.union.reason()),
            },
        })
    }

    /// Returns the table: one row for each move by a lattice step, then one for each distance from
    /// grazing.
    pub(super) fn table(&self) -> Rows {
        let of_site = |site: &crate::map::SiteFacts| {
            let receivers = site.tally.receivers;
            let moves = site.stability.clone().map(|s| s.moves).unwrap_or_default();
            let row = move |(which, turned): (crate::coverage::Move, Result<crate::coverage::Turned, String>)| {
                let both = turned.as_ref().ok().map(|t| t.gained + t.lost);
                StressSceneRow {
                    measure: "move",
                    name: which.name().to_string(),
                    receivers,
                    gained: turned.as_ref().ok().map(|t| t.gained),
                    lost: turned.as_ref().ok().map(|t| t.lost),
                    turned: both,
                    share: both.and_then(|both| share(both, receivers)),
                    reason: turned.err(),
                }
            };
            moves.into_iter().map(row)
        };
        let sampled = self.margins.margins.len() as u64;
        let near = NEAR_M.into_iter().zip(self.near()).map(|(reach, n)| StressSceneRow {
            measure: "margin",
            name: format!("within {reach} m"),
            receivers: sampled,
            gained: None,
            lost: None,
            turned: Some(n),
            share: share(n, sampled),
            reason: None,
        });
        rows(self.map.sites.iter().flat_map(of_site).chain(near))
    }
}

/// Failures of methods.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct StressDocument {
    /// Kind of document and its version.
    schema: &'static str,
    /// Version of the program.
    version: &'static str,
    #[serde(flatten)]
    command: CommandFacts,
    /// Seed of the scenes.
    seed: u64,
    /// Scenes of each family.
    scenes_per_family: u32,
    /// Methods, over all families.
    methods: Vec<MethodDocument>,
    /// Families of scenes.
    families: Vec<FamilyDocument>,
    /// Seconds spent; absent in the copies that pictures and tables store.
    #[serde(skip_serializing_if = "Option::is_none")]
    timing_s: Option<TotalTiming>,
    /// SHA-256 of the table.
    digest: String,
}

/// Seconds spent.
#[derive(Debug, Serialize, JsonSchema)]
struct TotalTiming {
    /// Whole run.
    total: f64,
}

/// A method over all families that it decides.
#[derive(Debug, Serialize, JsonSchema)]
struct MethodDocument {
    /// Word for the method.
    method: String,
    /// true if the method is exact.
    exact: bool,
    /// Receivers that the method decides; null for none.
    receivers: Option<u64>,
    /// Receivers that the method decides wrongly.
    wrong: Option<u64>,
    /// Share of the receivers that are wrong.
    failure_rate: Option<f64>,
}

/// A family of scenes.
#[derive(Debug, Serialize, JsonSchema)]
struct FamilyDocument {
    /// Name of the family.
    family: &'static str,
    /// Assumption that the family breaks.
    breaks: &'static str,
    /// Receivers of all scenes of the family.
    receivers: u64,
    /// Receivers in line of sight.
    los: u64,
    /// Outcome of each method.
    methods: Vec<OutcomeDocument>,
}

/// Outcome of a method on a family.
#[derive(Debug, Serialize, JsonSchema)]
struct OutcomeDocument {
    /// Word for the method.
    method: String,
    #[serde(flatten)]
    outcome: OutcomeFields,
    /// First wrong receiver; null for none.
    #[serde(skip_serializing_if = "Option::is_none")]
    first_wrong: Option<Option<FirstWrong>>,
}

/// A wrong receiver.
#[derive(Debug, Serialize, JsonSchema)]
struct FirstWrong {
    /// Scene of the receiver.
    scene: String,
    /// Row of the receiver.
    row: usize,
    /// Column of the receiver.
    col: usize,
}

/// Errors of a method on a family.
#[derive(Debug, Serialize, JsonSchema)]
struct OutcomeFields {
    /// Receivers decided wrongly; none where the method cannot decide the family.
    wrong: Option<u64>,
    /// Share of the receivers that are wrong.
    failure_rate: Option<f64>,
    /// Wrong receivers that the method called LoS.
    false_los: Option<u64>,
    /// Wrong receivers that the method called NLoS.
    false_nlos: Option<u64>,
    /// Reason why the method cannot decide the family.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'static str>,
}

impl OutcomeFields {
    fn of(score: &FamilyScore, outcome: &Outcome) -> Self {
        let wrong = match outcome {
            Outcome::Decided(wrong) => Some(wrong),
            Outcome::Cannot(_) => None,
        };
        OutcomeFields {
            wrong: wrong.map(|w| w.total()),
            failure_rate: wrong.and_then(|w| share(w.total(), score.receivers)),
            false_los: wrong.map(|w| w.false_los),
            false_nlos: wrong.map(|w| w.false_nlos),
            reason: wrong.is_none().then(|| reason(outcome)),
        }
    }
}

/// A row of the table of families.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct StressRow {
    /// Family of scenes.
    family: &'static str,
    /// Method.
    method: String,
    /// true if the method is exact.
    exact: bool,
    /// Scenes of the family.
    scenes: u32,
    /// Seed of the scenes.
    seed: u64,
    /// Receivers of all scenes.
    receivers: u64,
    /// Receivers in line of sight.
    los: u64,
    #[serde(flatten)]
    outcome: OutcomeFields,
}

/// Stability of a scene's answers: the document of the map, with margins near grazing.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct StressSceneDocument {
    #[serde(flatten)]
    map: MapDocument,
    /// Margins near grazing.
    margins: NearDocument,
}

/// Margins near grazing.
#[derive(Debug, Serialize, JsonSchema)]
struct NearDocument {
    /// Step between sampled receivers, in row order.
    every: usize,
    /// Sampled receivers.
    sampled: u64,
    /// Sampled receivers near grazing, by distance.
    near_grazing: Vec<BinDocument>,
    /// Reason for having no sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<&'static str>,
}

/// Receivers within a distance of grazing.
#[derive(Debug, Serialize, JsonSchema)]
struct BinDocument {
    /// Distance [m].
    within_m: f32,
    /// Receivers within that distance.
    receivers: u64,
    /// Share of the sampled receivers.
    share: Option<f64>,
}

/// A row of the table of a scene.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct StressSceneRow {
    /// move (by one lattice step) or margin (near grazing).
    measure: &'static str,
    /// Name of the move, or distance from grazing.
    name: String,
    /// Receivers.
    receivers: u64,
    /// Receivers that come into line of sight.
    gained: Option<u64>,
    /// Receivers that lose line of sight.
    lost: Option<u64>,
    /// Receivers whose answer changes, or that are within the distance.
    turned: Option<u64>,
    /// Share of the receivers whose answer changes, or that are within the distance.
    share: Option<f64>,
    /// Reason why the move is impossible.
    reason: Option<String>,
}
