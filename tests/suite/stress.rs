//! Families of scenes where methods fail: the truth about them is that of the oracle, exact engines are right on all of
//! them, approximate ones are not; and the command says so.

#![expect(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use rayon::prelude::*;
use skyshed::accuracy::stress::{
    AtRisk, Contender, Effort, FAMILIES, Family, FamilyScore, Outcome, Ready, StressScene, StressSolid, Symmetry,
    stress, truth,
};
use skyshed::quantity::{LatticePoint, VOID};

use crate::oracle;
use crate::support::{Random, slow};

fn contenders(names: &[&str]) -> Vec<Contender> {
    names.iter().map(|name| Contender::named(name).unwrap()).collect()
}

/// The answer of the tests' own oracle.
fn by_oracle(scene: &StressScene, receiver: LatticePoint) -> bool {
    let (uav, receiver) = ([scene.uav.x, scene.uav.y, scene.uav.z], [receiver.x, receiver.y, receiver.z]);
    match &scene.solid {
        StressSolid::Columns { board, .. } => {
            let heights = board.tops.iter().map(|top| (*top != VOID).then_some(i64::from(*top))).collect();
            let columns = oracle::Columns { n_cols: board.n_cols, n_rows: board.n_rows, heights };
            oracle::columns_los(&columns, uav, receiver)
        }
        StressSolid::Prisms(prisms) => {
            let ring = |r: &Vec<[i32; 2]>| r.iter().map(|v| v.map(i64::from)).collect();
            let prism = |p: &skyshed::accuracy::stress::StressPrism| oracle::Prism {
                rings: p.rings.iter().map(ring).collect(),
                top: i64::from(p.top),
            };
            oracle::prisms_los(&prisms.iter().map(prism).collect::<Vec<_>>(), uav, receiver)
        }
    }
}

#[test]
fn the_truth_of_every_family_is_that_of_the_oracle() {
    let n_scenes = if slow() { 40 } else { 4 };
    FAMILIES.par_iter().for_each(|family| {
        let (mut n, mut n_los) = (0, 0);
        for number in 0..n_scenes {
            let scene = family.scene(7, number).unwrap();
            let ready = scene.ready().unwrap();
            let answers = truth(&scene, &ready).unwrap();
            let mut random = Random(u64::from(number));
            for (k, (cell, receiver)) in ready.receivers.iter().enumerate().filter(|_| random.chance(15)) {
                assert_eq!(answers[k], by_oracle(&scene, *receiver), "{}, cell {cell}: {scene:?}", scene.name);
                n += 1;
                n_los += u32::from(answers[k]);
            }
        }
        assert!(n > 100 && n_los > 0 && n_los < n, "{}: {n_los} of {n}", family.name);
    });
}

fn decided(score: &FamilyScore, k: usize) -> Option<u64> {
    match &score.outcomes[k] {
        Outcome::Decided(wrong) => Some(wrong.total()),
        Outcome::Cannot(_) => None,
    }
}

#[test]
fn exact_engines_are_right_on_every_family_and_approximate_ones_fail_where_they_should() {
    let all = contenders(&Contender::ALL);
    let families: Vec<&Family> = FAMILIES.iter().collect();
    let efforts: Vec<Effort> = if slow() {
        (1..=3).map(|seed| Effort { scenes: 160, seed }).collect()
    } else {
        vec![Effort { scenes: 16, seed: 5 }]
    };
    for effort in efforts {
        for (family, score) in families.iter().zip(stress(&families, &all, effort).unwrap()) {
            let mut n_decided = 0;
            let mut n_failing = 0;
            for (k, method) in all.iter().enumerate() {
                let Some(wrong) = decided(&score, k) else { continue };
                n_decided += 1;
                if method.is_exact() {
                    assert_eq!(wrong, 0, "{} on {}: {:?}", method.name, family.name, score.outcomes[k]);
                } else {
                    n_failing += u32::from(wrong > 0);
                }
            }
            // Boards: all but `shadow`; footprints: `ray` and `shadow`.
            let (expected, fails) = match family.at_risk {
                AtRisk::Approximate => (9, true),
                AtRisk::ExactOnly => (2, false),
            };
            assert_eq!((n_decided, n_failing > 0), (expected, fails), "{}: {score:?}", family.name);
            assert!(score.los > 0 && score.los < score.receivers, "{score:?}");
        }
    }
}

#[test]
fn samples_of_a_ray_err_towards_line_of_sight_alone() {
    let steps = contenders(&["step:0.25", "step:1", "step:4"]);
    let families: Vec<&Family> = FAMILIES.iter().filter(|f| f.at_risk == AtRisk::Approximate).collect();
    let mut totals = [0; 3];
    for score in stress(&families, &steps, Effort { scenes: 6, seed: 2 }).unwrap() {
        for (total, outcome) in totals.iter_mut().zip(&score.outcomes) {
            let Outcome::Decided(wrong) = outcome else { panic!("{score:?}") };
            assert_eq!(wrong.false_nlos, 0, "{score:?}");
            *total += wrong.false_los;
        }
    }
    assert!(0 < totals[0] && totals[0] < totals[1] && totals[1] < totals[2], "{totals:?}");
}

#[test]
fn a_scene_is_a_function_of_its_seed_and_number() {
    for family in &FAMILIES {
        let scene = |seed: u64, number: u32| family.scene(seed, number).unwrap();
        assert_eq!(scene(1, 9), scene(1, 9));
        assert_ne!(scene(1, 9), StressScene { name: scene(1, 9).name, ..scene(2, 9) }, "{}", family.name);
        assert_ne!(scene(1, 9), StressScene { name: scene(1, 9).name, ..scene(1, 17) }, "{}", family.name);
    }
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let all = contenders(&["ray", "step:1", "r2"]);
        let families = [Family::named("cell-slots").unwrap(), Family::named("prism-mirrors").unwrap()];
        pool.install(|| stress(&families, &all, Effort { scenes: 9, seed: 3 }).unwrap())
    };
    assert_eq!(run(1), run(7));
    assert!(Family::named("cell-slot").is_none());
}

/// The answers of a scene by the engine that its kind calls for, cell by cell, with the heights of the receivers.
fn seen(scene: &StressScene, ready: &Ready) -> Vec<Option<(i64, bool)>> {
    let options = scene.options();
    let seen = skyshed::coverage::Mapper::new(&ready.field, &options).unwrap().seen(&ready.uav);
    let mut answers = vec![None; scene.n_rows * scene.n_cols];
    for (cell, receiver) in &ready.receivers {
        answers[*cell] = Some((receiver.z, seen.los.contains(cell / scene.n_cols, cell % scene.n_cols)));
    }
    answers
}

#[test]
fn the_eight_images_of_a_scene_have_the_eight_images_of_its_answer() {
    for name in ["cell-mirrors", "prism-mirrors", "cell-slots", "cell-diagonals", "prism-walls", "prism-slivers"] {
        let family = Family::named(name).unwrap();
        for number in [0, 8, 16] {
            let original = family.scene(11, number).unwrap();
            let answers = seen(&original, &original.ready().unwrap());
            for k in 0..8 {
                let symmetry = Symmetry::number(k);
                let image = symmetry.of(&original);
                let mirrored = seen(&image, &image.ready().unwrap());
                let mut n_same = 0;
                for (cell, answer) in answers.iter().enumerate() {
                    let place = (cell / original.n_cols, cell % original.n_cols);
                    let (row, col) = symmetry.cell(place, (original.n_rows, original.n_cols));
                    // A receiver over the wall of two houses stands on the one to its north-east, in every image.
                    let found = mirrored[row * image.n_cols + col];
                    assert_eq!(found.is_some(), answer.is_some(), "{name} {number}, image {k}, {place:?}");
                    if found.map(|f| f.0) == answer.map(|a| a.0) {
                        assert_eq!(found, *answer, "{name} {number}, image {k}, {place:?}");
                        n_same += 1;
                    }
                }
                assert!(n_same * 10 > answers.len() * 9, "{n_same} of {}", answers.len());
            }
        }
    }
}

#[test]
fn a_wrong_known_answer_is_told() {
    let mut scene = Family::named("cell-cliffs").unwrap().scene(1, 0).unwrap();
    scene.known[0].is_los = !scene.known[0].is_los;
    let error = truth(&scene, &scene.ready().unwrap()).unwrap_err();
    assert_eq!((error.code().as_str(), error.class().exit_code()), ("E601", 6), "{error}");
}
