//! Every engine against the text cases, and against the oracle on random scenes.
//!
//! Three independent answers of the crate are compared each time: the decision itself, the ceiling at the receiver's
//! place (met exactly when the link is LoS, and equal to the oracle's as a number), and the least UAV height.

use num_bigint::BigInt;
use num_rational::Ratio;
use skyshed_core::height_field::{Columns, Prisms};
use skyshed_core::los::{
    LeastHeight, columns_least_height, columns_least_receiver_height, columns_los, prisms_least_height,
    prisms_least_receiver_height, prisms_los,
};

use crate::case_file::{CaseKind, N_CASES, all_cases};
use crate::oracle::{self, P3};
use crate::support::{Random, columns_of, point, prisms_of, slow};

/// Whether the crate's ceiling [steps] is the oracle's, to within the rounding of one f64.
fn same_height(ours: &LeastHeight, oracle: &oracle::Ceiling) -> bool {
    let ours = ours.height_steps();
    match oracle {
        oracle::Ceiling::Clear => ours == f64::NEG_INFINITY,
        oracle::Ceiling::Never => ours == f64::INFINITY,
        oracle::Ceiling::At(exact) => {
            let exact = to_f64(exact);
            (ours - exact).abs() <= 1e-9 * exact.abs().max(1.0)
        }
    }
}

/// The nearest double, to within two roundings.
fn to_f64(exact: &Ratio<BigInt>) -> f64 {
    let text = |n: &BigInt| n.to_string().parse::<f64>().unwrap();
    text(exact.numer()) / text(exact.denom())
}

/// Checks all engines for columns on one link and returns the common answer.
fn check_columns(columns: &Columns, exact: &oracle::Columns, uav: P3, receiver: P3, place: &str) -> bool {
    let expected = oracle::columns_los(exact, uav, receiver);
    let (u, r) = (point(uav), point(receiver));
    let context = || format!("{place}: UAV {uav:?}, receiver {receiver:?}, {exact:?}");
    assert_eq!(columns_los(columns, u, r), expected, "ray: {}", context());
    let ceiling = columns_least_receiver_height(columns, u, r);
    assert_eq!(ceiling.is_met_by(r.z), expected, "ceiling: {}", context());
    let exact_ceiling = oracle::columns_ceiling(exact, uav, [receiver[0], receiver[1]]);
    assert!(same_height(&ceiling, &exact_ceiling), "ceiling {ceiling:?}, oracle {exact_ceiling:?}: {}", context());
    let least = columns_least_height(columns, u, r);
    assert_eq!(least.is_met_by(u.z), expected, "least height: {}", context());
    let exact_least = oracle::columns_least_uav_height(exact, [uav[0], uav[1]], receiver);
    assert!(same_height(&least, &exact_least), "least height {least:?}, oracle {exact_least:?}: {}", context());
    expected
}

/// Checks all engines for prisms on one link and returns the common answer.
fn check_prisms(prisms: &Prisms, exact: &[oracle::Prism], uav: P3, receiver: P3, place: &str) -> bool {
    let expected = oracle::prisms_los(exact, uav, receiver);
    let (u, r) = (point(uav), point(receiver));
    let context = || format!("{place}: UAV {uav:?}, receiver {receiver:?}, {exact:?}");
    assert_eq!(prisms_los(prisms, u, r), expected, "ray: {}", context());
    let ceiling = prisms_least_receiver_height(prisms, u, r);
    if uav != receiver {
        assert_eq!(ceiling.is_met_by(r.z), expected, "ceiling: {}", context());
    }
    let exact_ceiling = oracle::prisms_ceiling(exact, uav, [receiver[0], receiver[1]]);
    assert!(same_height(&ceiling, &exact_ceiling), "ceiling {ceiling:?}, oracle {exact_ceiling:?}: {}", context());
    let least = prisms_least_height(prisms, u, r);
    let exact_least = oracle::prisms_least_uav_height(exact, [uav[0], uav[1]], receiver);
    assert!(same_height(&least, &exact_least), "least height {least:?}, oracle {exact_least:?}: {}", context());
    expected
}

#[test]
fn every_engine_answers_every_text_case() {
    let mut n = 0;
    for case in all_cases() {
        let place = format!("{}:{} {}", case.file, case.line, case.title);
        let answer = match &case.kind {
            CaseKind::Columns { columns } => {
                check_columns(&columns_of(columns), columns, case.uav, case.receiver, &place)
            }
            CaseKind::Prisms { prisms } => check_prisms(&prisms_of(prisms), prisms, case.uav, case.receiver, &place),
        };
        assert_eq!(answer, case.expect_los, "{place}");
        n += 1;
    }
    assert_eq!(n, N_CASES);
}

/// Columns with heights that often tie, some void, some towers.
fn random_columns(random: &mut Random) -> oracle::Columns {
    let n_cols = usize::try_from(random.within(1, 10)).unwrap();
    let n_rows = usize::try_from(random.within(1, 10)).unwrap();
    let built = 10 * u64::try_from(random.within(0, 9)).unwrap();
    let heights = (0..n_cols * n_rows)
        .map(|_| match random.next() % 100 {
            0..4 => None,
            p if p < built => Some(random.choose(&[1024, 2048, 2048, 3072, 4096, 20_480])),
            _ => Some(random.choose(&[0, 0, 0, 1, 512])),
        })
        .collect();
    oracle::Columns { n_cols, n_rows, heights }
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

#[test]
fn ray_over_columns_agrees_with_the_oracle_on_random_rasters() {
    let n_links = if slow() { 600_000 } else { 30_000 };
    let mut random = Random(1);
    let (mut n, mut n_los) = (0, 0);
    while n < n_links {
        let exact = random_columns(&mut random);
        let columns = columns_of(&exact);
        for _ in 0..50 {
            let uav = random_end(&mut random, exact.n_cols, exact.n_rows, 16_384);
            let receiver = random_end(&mut random, exact.n_cols, exact.n_rows, 4096);
            n_los += i32::from(check_columns(&columns, &exact, uav, receiver, "random raster"));
            n += 1;
        }
    }
    assert!(n_los > n / 10 && n_los < n - n / 10, "{n_los} of {n} links are LoS: both answers must be common");
}

/// Footprints on a coarse lattice, so that walls are shared, corners touch and rays run along edges.
fn random_prisms(random: &mut Random) -> Vec<oracle::Prism> {
    let unit = 1024;
    let n = random.within(1, 7);
    let shape = |random: &mut Random| -> Vec<Vec<[i64; 2]>> {
        let (x, y) = (random.within(0, 8) * unit, random.within(0, 8) * unit);
        let (w, h) = (random.within(1, 4) * unit, random.within(1, 4) * unit);
        let rectangle = |x0: i64, y0: i64, x1: i64, y1: i64| vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
        match random.next() % 7 {
            0 | 1 => vec![rectangle(x, y, x + w, y + h)],
            2 => vec![vec![
                [x, y],
                [x + 2 * w, y],
                [x + 2 * w, y + h],
                [x + w, y + h],
                [x + w, y + 2 * h],
                [x, y + 2 * h],
            ]],
            3 => vec![
                rectangle(x, y, x + 4 * unit, y + 4 * unit),
                rectangle(x + unit, y + unit, x + random.within(2, 3) * unit, y + 3 * unit),
            ],
            4 => {
                vec![vec![[x, y], [x + w, y + random.within(0, 2) * unit], [x + random.within(0, 1) * unit, y + 3 * h]]]
            }
            5 => {
                // A comb with teeth of the same width as the gaps.
                vec![vec![
                    [x, y],
                    [x + 5 * unit, y],
                    [x + 5 * unit, y + 3 * unit],
                    [x + 4 * unit, y + 3 * unit],
                    [x + 4 * unit, y + unit],
                    [x + 3 * unit, y + unit],
                    [x + 3 * unit, y + 3 * unit],
                    [x + 2 * unit, y + 3 * unit],
                    [x + 2 * unit, y + unit],
                    [x + unit, y + unit],
                    [x + unit, y + 3 * unit],
                    [x, y + 3 * unit],
                ]]
            }
            _ => {
                let fine = |random: &mut Random| random.within(-700, 700);
                vec![vec![
                    [x + fine(random), y + fine(random)],
                    [x + 3000 + fine(random), y + fine(random)],
                    [x + 3000 + fine(random), y + 3000 + fine(random)],
                    [x + fine(random), y + 3000 + fine(random)],
                ]]
            }
        }
    };
    (0..n)
        .map(|_| oracle::Prism { rings: shape(random), top: random.choose(&[1024, 2048, 2048, 3072, 4096, 12_288]) })
        .collect()
}

#[test]
fn ray_over_prisms_agrees_with_the_oracle_on_random_footprints() {
    let n_links = if slow() { 600_000 } else { 30_000 };
    let mut random = Random(2);
    let (mut n, mut n_los) = (0, 0);
    while n < n_links {
        let exact = random_prisms(&mut random);
        let prisms = prisms_of(&exact);
        for _ in 0..50 {
            let uav = random_end(&mut random, 12, 12, 16_384);
            let receiver = random_end(&mut random, 12, 12, 4096);
            n_los += i32::from(check_prisms(&prisms, &exact, uav, receiver, "random footprints"));
            n += 1;
        }
    }
    assert!(n_los > n / 10 && n_los < n - n / 10, "{n_los} of {n} links are LoS: both answers must be common");
}

#[test]
fn what_is_inside_a_solid_agrees_with_the_oracle_at_lattice_points() {
    let mut random = Random(3);
    let (mut n, mut n_inside) = (0, 0);
    for _ in 0..300 {
        let exact = random_prisms(&mut random);
        let prisms = prisms_of(&exact);
        for _ in 0..60 {
            let p = random_end(&mut random, 12, 12, 5000);
            let inside = i64::from(prisms.solid_below(p[0], p[1])) > p[2];
            assert_eq!(inside, oracle::prisms_cover(&exact, [p[0], p[1]], p[2]), "point {p:?} in {exact:?}");
            n += 1;
            n_inside += i32::from(inside);
        }
    }
    assert!(n_inside > n / 20, "{n_inside} of {n} points are inside");
}
