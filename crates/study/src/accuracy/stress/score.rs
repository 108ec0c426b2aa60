//! Scores of methods against the truth: the wrong receivers of each method on each family.

use rayon::prelude::*;

use super::families::Family;
use super::scene::{Ready, StressScene};
use super::truth;
use crate::coverage::{MapOptions, Mapper};
use crate::error::{Result, StressError};
use crate::los::{Method, MethodChoice, StepLength};

/// Method that is tried.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Contender {
    /// Name on the command line.
    pub name: String,
    /// Engine.
    pub choice: MethodChoice,
}

impl Contender {
    /// Returns all engines, `step:K` at several lengths \[cells\].
    pub fn all() -> Vec<Self> {
        let steps = [0.25, 0.5, 1.0, 2.0, 4.0].into_iter().filter_map(StepLength::new).map(MethodChoice::Step);
        let exact = [MethodChoice::Ray, MethodChoice::Sweep, MethodChoice::Shadow];
        exact.into_iter().chain(steps).chain([MethodChoice::Xdraw, MethodChoice::R2]).map(Contender::of).collect()
    }

    /// Returns the contender of an engine.
    pub fn of(choice: MethodChoice) -> Self {
        let name = choice.method().map_or_else(|| "auto".into(), Method::name);
        Contender { name: name.into_owned(), choice }
    }

    /// Returns `true` if all its answers must be right.
    pub fn is_exact(&self) -> bool {
        self.choice.method().is_none_or(Method::is_exact)
    }
}

/// Amount of work of a stress test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Scenes of each family.
    pub scenes: u32,
    /// Seed of everything random.
    pub seed: u64,
}

/// Result of a method on the scenes of a family.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// The method decided all scenes.
    Decided(Wrong),
    /// The method cannot decide such scenes, for this reason.
    Cannot(&'static str),
}

/// Receivers that a method decides wrongly.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Wrong {
    /// Number of LoS answers for NLoS receivers.
    pub false_los: u64,
    /// Number of NLoS answers for LoS receivers.
    pub false_nlos: u64,
    /// First wrong receiver: its scene, row and column.
    pub first: Option<(String, usize, usize)>,
}

impl Wrong {
    /// Returns the sum of both kinds.
    pub fn total(&self) -> u64 {
        self.false_los + self.false_nlos
    }

    fn plus(self, other: Wrong) -> Wrong {
        Wrong {
            false_los: self.false_los + other.false_los,
            false_nlos: self.false_nlos + other.false_nlos,
            first: self.first.or(other.first),
        }
    }
}

/// Results of methods on a family.
#[derive(Debug, Clone, PartialEq)]
pub struct FamilyScore {
    /// Name of the family.
    pub family: &'static str,
    /// Methods that it breaks, and the reason.
    pub breaks: &'static str,
    /// Number of receivers in all its scenes.
    pub receivers: u64,
    /// Number of receivers that are LoS and served.
    pub los: u64,
    /// Outcome of each method, in the order of the request.
    pub outcomes: Vec<Outcome>,
}

/// Runs methods on the scenes of some families.
///
/// Cost: mostly that of the [`truth()`], shared by all threads; scenes are small. The result
/// depends on the effort alone.
///
/// # Errors
/// E601 if an answer that is known by construction is not the truth. E902 for a scene that cannot
/// be built, or if its receivers are not those of the methods.
pub fn stress(families: &[&Family], methods: &[Contender], effort: Effort) -> Result<Vec<FamilyScore>> {
    families
        .iter()
        .map(|family| {
            let scores =
                (0..effort.scenes).into_par_iter().map(|number| scene_score(family, methods, effort.seed, number));
            let scores: Vec<FamilyScore> = scores.collect::<Result<_>>()?;
            let none = FamilyScore {
                family: family.name,
                breaks: family.breaks,
                receivers: 0,
                los: 0,
                outcomes: vec![Outcome::Decided(Wrong::default()); methods.len()],
            };
            Ok(scores.into_iter().fold(none, together))
        })
        .collect()
}

/// Fails if an exact method is wrong.
///
/// # Errors
/// E602, naming the first such receiver.
pub fn check_exact(methods: &[Contender], scores: &[FamilyScore]) -> Result<()> {
    for score in scores {
        for (method, outcome) in methods.iter().zip(&score.outcomes).filter(|(method, _)| method.is_exact()) {
            if let Outcome::Decided(Wrong { first: Some((scene, row, col)), false_los, false_nlos }) = outcome {
                let error = StressError::ExactIsWrong {
                    method: method.name.clone(),
                    wrong: false_los + false_nlos,
                    receivers: score.receivers,
                    family: score.family,
                    scene: scene.clone(),
                    row: *row,
                    col: *col,
                };
                return Err(error.into());
            }
        }
    }
    Ok(())
}

fn together(a: FamilyScore, b: FamilyScore) -> FamilyScore {
    let outcome = |pair: (Outcome, Outcome)| match pair {
        (Outcome::Decided(a), Outcome::Decided(b)) => Outcome::Decided(a.plus(b)),
        (Outcome::Cannot(why), _) | (_, Outcome::Cannot(why)) => Outcome::Cannot(why),
    };
    FamilyScore {
        receivers: a.receivers + b.receivers,
        los: a.los + b.los,
        outcomes: a.outcomes.into_iter().zip(b.outcomes).map(outcome).collect(),
        ..a
    }
}

fn scene_score(family: &Family, methods: &[Contender], seed: u64, number: u32) -> Result<FamilyScore> {
    let scene = family.scene(seed, number)?;
    let ready = scene.ready()?;
    let answers = truth(&scene, &ready)?;
    let outcome = |method: &Contender| outcome(&scene, &ready, &answers, method.choice);
    Ok(FamilyScore {
        family: family.name,
        breaks: family.breaks,
        receivers: answers.len() as u64,
        los: answers.iter().filter(|is_los| **is_los).count() as u64,
        outcomes: methods.iter().map(outcome).collect::<Result<_>>()?,
    })
}

fn outcome(scene: &StressScene, ready: &Ready, answers: &[bool], method: MethodChoice) -> Result<Outcome> {
    if let Err(wrong) = Method::choose(&ready.field, method) {
        return Ok(Outcome::Cannot(wrong.why));
    }
    let options = MapOptions { method, ..scene.options() };
    let seen = Mapper::new(&ready.field, &options)?.seen_from(&ready.uav)?.seen();
    let n_cols = scene.n_cols;
    let served = || ready.receivers.iter().filter(|(_, receiver)| scene.serves(*receiver));
    let is_in_range = |cell: &usize| seen.receivers.contains(cell / n_cols, cell % n_cols);
    if seen.receivers.count() != served().count() as u64 || !served().all(|(cell, _)| is_in_range(cell)) {
        return Err(StressError::Receivers { scene: scene.name.clone() }.into());
    }
    let mut wrong = Wrong::default();
    for ((cell, _), is_los) in ready.receivers.iter().zip(answers) {
        let (row, col) = (cell / n_cols, cell % n_cols);
        let found = seen.los.contains(row, col);
        if found != *is_los {
            wrong.false_los += u64::from(found);
            wrong.false_nlos += u64::from(!found);
            wrong.first.get_or_insert_with(|| (scene.name.clone(), row, col));
        }
    }
    Ok(Outcome::Decided(wrong))
}
