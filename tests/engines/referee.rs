//! One link, or every cell of a map, decided by an engine and by the oracle or by `ray`, and a count of the answers.

#![expect(clippy::unwrap_used, reason = "a panic is a failed test")]

use std::iter::Sum;
use std::ops::AddAssign;

use num_bigint::BigInt;
use num_rational::Ratio;
use rayon::prelude::*;
use skyshed_core::height_field::{Columns, Prisms};
use skyshed_core::los;
use skyshed_core::raster::BitGrid;

use crate::oracle::{self, Ceiling, P3};
use crate::shapes::{around, plan};
use crate::support::{Random, is_long};
use crate::translation::{columns_of, point, prisms_of};

/// How many links were compared, and how they came out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Count {
    pub(crate) links: u64,
    pub(crate) los: u64,
    /// Links whose receiver is exactly at the ceiling.
    pub(crate) ties: u64,
    /// Links that an engine left to `ray`.
    pub(crate) asked: u64,
}

impl Count {
    pub(crate) fn add(&mut self, is_los: bool) {
        self.links += 1;
        self.los += u64::from(is_los);
    }

    /// Asserts that at least `links` were compared, and that at least one in ten came out either way.
    pub(crate) fn assert_both(&self, links: u64) {
        assert!(self.links >= links, "{self:?}, wanted {links} links");
        assert!(self.los * 10 >= self.links && (self.links - self.los) * 10 >= self.links, "{self:?}");
    }
}

impl AddAssign for Count {
    fn add_assign(&mut self, other: Count) {
        self.links += other.links;
        self.los += other.los;
        self.ties += other.ties;
        self.asked += other.asked;
    }
}

impl Sum for Count {
    fn sum<I: Iterator<Item = Count>>(counts: I) -> Count {
        let mut sum = Count::default();
        counts.for_each(|count| sum += count);
        sum
    }
}

/// The counts of `n` random scenes together, each with a stream of random numbers of its own.
pub(crate) fn over_seeds(n: u64, salt: u64, check: impl Fn(u64, &mut Random, &mut Count) + Sync) -> Count {
    let count_one = |seed: u64| {
        let mut count = Count::default();
        check(seed, &mut Random(seed ^ salt), &mut count);
        count
    };
    (0..n).into_par_iter().map(count_one).sum()
}

/// Runs a property on `n` random scenes, a third of them in short tests; it returns whether a link is LoS, and both answers must be
/// frequent.
pub(crate) fn both_answers(n: u64, seed: u64, property: impl Fn(&mut Random) -> bool) {
    let n = if is_long() { n } else { n / 3 };
    let (mut random, mut count) = (Random(seed), Count::default());
    (0..n).for_each(|_| count.add(property(&mut random)));
    count.assert_both(n);
}

/// Asserts that an engine found those of the wanted cells that `ray` calls LoS, and no others.
pub(crate) fn check_cells(
    found: &BitGrid,
    wanted: &BitGrid,
    ray: impl Fn(usize, usize) -> bool + Sync,
    what: impl Fn() -> String + Sync,
) -> Count {
    let check_row = |row: usize| {
        let mut count = Count::default();
        for col in 0..wanted.n_cols() {
            let is_wanted = wanted.contains(row, col);
            let expected = is_wanted && ray(row, col);
            assert_eq!(found.contains(row, col), expected, "row {row}, column {col}: {}", what());
            if is_wanted {
                count.add(expected);
            }
        }
        count
    };
    (0..wanted.n_rows()).into_par_iter().map(check_row).sum()
}

/// A scene as the oracle and as the engines see it.
pub(crate) trait Scene {
    /// Compares the engine with the oracle; true if the link is LoS.
    fn check(&self, uav: P3, receiver: P3, count: &mut Count) -> bool;

    /// Compares the least heights of both ends with the oracle's; true if the receiver is exactly at its own.
    fn check_heights(&self, uav: P3, receiver: P3, count: &mut Count) -> bool;

    /// Compares both; true if the link is LoS.
    fn check_all(&self, uav: P3, receiver: P3, count: &mut Count) -> bool {
        self.check_heights(uav, receiver, count);
        self.check(uav, receiver, count)
    }

    /// Compares the least heights, and where the receiver is at its own `n` links between neighboring lattice points.
    fn check_tie(&self, uav: P3, receiver: P3, n: usize, random: &mut Random, count: &mut Count) {
        if self.check_heights(uav, receiver, count) {
            for (uav, receiver) in around(uav, receiver, n, random) {
                self.check(uav, receiver, count);
            }
        }
    }
}

/// A raster as the oracle and as the engines see it.
pub(crate) struct Raster {
    pub(crate) oracle: oracle::Columns,
    pub(crate) engine: Columns,
}

impl Raster {
    pub(crate) fn new(columns: oracle::Columns) -> Raster {
        Raster { engine: columns_of(&columns), oracle: columns }
    }
}

impl Scene for Raster {
    fn check(&self, uav: P3, receiver: P3, count: &mut Count) -> bool {
        let wanted = oracle::columns_los(&self.oracle, uav, receiver);
        let found = los::columns_los(&self.engine, point(uav), point(receiver));
        assert_eq!(found, wanted, "{:?}\nuav {uav:?} receiver {receiver:?}", self.oracle);
        count.add(wanted);
        wanted
    }

    fn check_heights(&self, uav: P3, receiver: P3, count: &mut Count) -> bool {
        let what = || format!("{:?}\nuav {uav:?} receiver {receiver:?}", self.oracle);
        let wanted = oracle::columns_ceiling(&self.oracle, uav, plan(receiver));
        compare(&los::columns_least_receiver_height(&self.engine, point(uav), point(receiver)), &wanted, what);
        let least = oracle::columns_least_uav_height(&self.oracle, plan(uav), receiver);
        compare(&los::columns_least_height(&self.engine, point(uav), point(receiver)), &least, what);
        let is_tie = is_at(&wanted, receiver[2]);
        count.ties += u64::from(is_tie);
        is_tie
    }
}

/// Footprints as the oracle and as the engines see them.
pub(crate) struct Footprints {
    pub(crate) oracle: Vec<oracle::Prism>,
    pub(crate) engine: Prisms,
}

impl Footprints {
    pub(crate) fn new(prisms: Vec<oracle::Prism>) -> Footprints {
        Footprints { engine: prisms_of(&prisms), oracle: prisms }
    }
}

impl Scene for Footprints {
    /// From both ends.
    fn check(&self, uav: P3, receiver: P3, count: &mut Count) -> bool {
        let wanted = oracle::prisms_los(&self.oracle, uav, receiver);
        for (from, to) in [(uav, receiver), (receiver, uav)] {
            let found = los::prisms_los(&self.engine, point(from), point(to));
            assert_eq!(found, wanted, "{:?}\nfrom {from:?} to {to:?}, uav {uav:?}", self.oracle);
        }
        count.add(wanted);
        wanted
    }

    fn check_heights(&self, uav: P3, receiver: P3, count: &mut Count) -> bool {
        let what = || format!("{:?}\nuav {uav:?} receiver {receiver:?}", self.oracle);
        let (u, r) = (point(uav), point(receiver));
        let wanted = oracle::prisms_ceiling(&self.oracle, uav, plan(receiver));
        compare(&los::prisms_least_receiver_height(&self.engine, u, r), &wanted, what);
        let least = oracle::prisms_least_uav_height(&self.oracle, plan(uav), receiver);
        compare(&los::prisms_least_height(&self.engine, u, r), &least, what);
        compare(&los::prisms_least_receiver_height(&self.engine, r, u), &least, what);
        let is_tie = is_at(&wanted, receiver[2]);
        count.ties += u64::from(is_tie);
        is_tie
    }
}

fn is_at(ceiling: &Ceiling, z: i64) -> bool {
    matches!(ceiling, Ceiling::At(height) if *height == Ratio::from(BigInt::from(z)))
}

/// The nearest double of a ceiling, to within two roundings.
pub(crate) fn in_steps(ceiling: &Ceiling) -> f64 {
    let double = |n: &BigInt| n.to_string().parse::<f64>().unwrap();
    match ceiling {
        Ceiling::Clear => f64::NEG_INFINITY,
        Ceiling::At(height) => double(height.numer()) / double(height.denom()),
        Ceiling::Never => f64::INFINITY,
    }
}

/// Asserts that a ceiling is the oracle's: the same lattice heights meet it, and its value is that number.
fn compare(found: &los::LeastHeight, wanted: &Ceiling, what: impl Fn() -> String) {
    let (value, exact) = (found.height_steps(), in_steps(wanted));
    // A height below 2^26 is added to a quotient, and both are rounded.
    let is_near = exact.is_finite() && (value - exact).abs() <= 1e-7 + 1e-9 * exact.abs();
    assert!(is_near || value.total_cmp(&exact).is_eq(), "{found:?} = {value}, wanted {wanted:?} = {exact}\n{}", what());
    if let Ceiling::At(height) = wanted {
        let least = i64::try_from(height.ceil().to_integer()).unwrap();
        let is_least = found.is_met_by(least) && !found.is_met_by(least - 1);
        assert!(is_least, "{found:?}, wanted {height}, first met by {least}\n{}", what());
    }
}
