//! Every engine against the text cases, and against the oracle on random scenes.
//!
//! Three independent answers of the crate are compared each time: the decision itself, the ceiling at the receiver's
//! place, and the least UAV height. Of both heights the same lattice heights meet the crate's and the oracle's.

use crate::case_file::{CaseKind, N_CASES, all_cases};
use crate::oracle::{self, Columns, P3, Prism};
use crate::referee::{Count, Footprints, Raster, Scene, over_seeds};
use crate::shapes::{M, plan, rectangle};
use crate::support::{Random, is_long};

#[test]
fn every_engine_answers_every_text_case() {
    let cases = all_cases();
    for case in &cases {
        let scene: Box<dyn Scene> = match &case.kind {
            CaseKind::Columns(columns) => Box::new(Raster::new(columns.clone())),
            CaseKind::Prisms(prisms) => Box::new(Footprints::new(prisms.clone())),
        };
        let answer = scene.check_all(case.uav, case.receiver, &mut Count::default());
        assert_eq!(answer, case.expect_los, "{}:{}: {} ({})", case.file, case.line, case.title, case.source);
    }
    assert_eq!(cases.len(), N_CASES);
}

/// Columns with heights that often tie, some void, some towers.
fn random_columns(random: &mut Random) -> Columns {
    let (n_cols, n_rows) = (random.index(1, 10), random.index(1, 10));
    let built = 10 * random.below(10);
    let heights = (0..n_cols * n_rows)
        .map(|_| match random.below(100) {
            0..4 => None,
            p if p < built => Some(random.choose(&[1024, 2048, 2048, 3072, 4096, 20_480])),
            _ => Some(random.choose(&[0, 0, 0, 1, 512])),
        })
        .collect();
    Columns { n_cols, n_rows, heights }
}

/// An end of a link: often on the lattice of corners and centers, in and around the raster.
fn random_end(random: &mut Random, n_cols: usize, n_rows: usize, highest: i64) -> P3 {
    let along = |random: &mut Random, n: usize| {
        let n = i64::try_from(n).unwrap() * 1024;
        match random.next() % 4 {
            0 => random.within(0, n),
            1 => random.within(0, n / 256) * 256,
            2 => random.within(-2, n / 512 + 2) * 512,
            _ => random.within(0, n / 1024 - 1) * 1024 + 512,
        }
    };
    let z = match random.next() % 3 {
        0 => random.within(-1024, highest),
        1 => random.within(0, highest / 512) * 512,
        _ => random.choose(&[1536, 1024, 2048, 4096, 4097, 4095]),
    };
    [along(random, n_cols), along(random, n_rows), z]
}

/// Compares fifty links of a scene.
fn fifty_links(scene: &impl Scene, (n_cols, n_rows): (usize, usize), random: &mut Random, count: &mut Count) {
    for _ in 0..50 {
        let uav = random_end(random, n_cols, n_rows, 16_384);
        let receiver = random_end(random, n_cols, n_rows, 4096);
        scene.check_all(uav, receiver, count);
    }
}

#[test]
fn ray_over_columns_agrees_with_the_oracle_on_random_rasters() {
    let n_scenes = if is_long() { 12_000 } else { 300 };
    let count = over_seeds(n_scenes, 1, |_, random, count| {
        let raster = Raster::new(random_columns(random));
        fifty_links(&raster, (raster.oracle.n_cols, raster.oracle.n_rows), random, count);
    });
    count.assert_both(50 * n_scenes);
}

/// Footprints on a coarse lattice, so that walls are shared, corners touch and rays run along edges.
fn random_prisms(random: &mut Random) -> Vec<Prism> {
    (0..random.within(1, 7))
        .map(|_| Prism { rings: random_rings(random), top: random.choose(&[1024, 2048, 2048, 3072, 4096, 12_288]) })
        .collect()
}

fn random_rings(random: &mut Random) -> Vec<Vec<[i64; 2]>> {
    let (x, y) = (random.within(0, 8) * M, random.within(0, 8) * M);
    let (w, h) = (random.within(1, 4), random.within(1, 4));
    let meters = |ring: &[[i64; 2]]| ring.iter().map(|p| [x + p[0] * M, y + p[1] * M]).collect();
    match random.next() % 7 {
        0 | 1 => vec![meters(&rectangle(0, 0, w, h))],
        2 => vec![meters(&[[0, 0], [2 * w, 0], [2 * w, h], [w, h], [w, 2 * h], [0, 2 * h]])],
        3 => vec![meters(&rectangle(0, 0, 4, 4)), meters(&rectangle(1, 1, random.within(2, 3), 3))],
        4 => vec![meters(&[[0, 0], [w, random.within(0, 2)], [random.within(0, 1), 3 * h]])],
        5 => {
            // A comb with teeth of the same width as the gaps.
            let comb = [[0, 0], [5, 0], [5, 3], [4, 3], [4, 1], [3, 1], [3, 3], [2, 3], [2, 1], [1, 1], [1, 3], [0, 3]];
            vec![meters(&comb)]
        }
        _ => {
            let corners = [[0, 0], [3000, 0], [3000, 3000], [0, 3000]];
            let mut near = |k: i64| k + random.within(-700, 700);
            vec![corners.iter().map(|p| [near(x + p[0]), near(y + p[1])]).collect()]
        }
    }
}

#[test]
fn ray_over_prisms_agrees_with_the_oracle_on_random_footprints() {
    let n_scenes = if is_long() { 12_000 } else { 300 };
    let count = over_seeds(n_scenes, 2, |_, random, count| {
        fifty_links(&Footprints::new(random_prisms(random)), (12, 12), random, count);
    });
    count.assert_both(50 * n_scenes);
}

#[test]
fn what_is_inside_a_solid_agrees_with_the_oracle_at_lattice_points() {
    let mut random = Random(3);
    let (mut n, mut n_inside) = (0, 0);
    for _ in 0..300 {
        let scene = Footprints::new(random_prisms(&mut random));
        for _ in 0..60 {
            let p = random_end(&mut random, 12, 12, 5000);
            let inside = i64::from(scene.engine.solid_below(p[0], p[1])) > p[2];
            assert_eq!(inside, oracle::prisms_cover(&scene.oracle, plan(p), p[2]), "point {p:?} in {:?}", scene.oracle);
            n += 1;
            n_inside += i32::from(inside);
        }
    }
    assert!(n_inside > n / 20, "{n_inside} of {n} points are inside");
}
