//! One link, decided by an engine and by the oracle, and a count of the answers.

#![expect(clippy::unwrap_used, reason = "a panic is a failed test")]

use num_bigint::BigInt;
use num_rational::Ratio;
use skyshed_core::height_field::{Columns, Prisms};
use skyshed_core::los;

use crate::oracle::{self, P3};
use crate::shapes::plan;
use crate::support::{columns_of, point, prisms_of};

/// How many links were compared, and how they came out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Count {
    pub(crate) links: u64,
    pub(crate) los: u64,
    /// Links whose receiver is exactly at the ceiling.
    pub(crate) ties: u64,
}

impl Count {
    fn add(&mut self, is_los: bool) {
        self.links += 1;
        self.los += u64::from(is_los);
    }

    pub(crate) fn plus(self, other: Count) -> Count {
        Count { links: self.links + other.links, los: self.los + other.los, ties: self.ties + other.ties }
    }

    /// Asserts that at least `links` were compared, and that at least one in ten came out either way.
    pub(crate) fn assert_both(&self, links: u64) {
        assert!(self.links >= links, "{self:?}, wanted {links} links");
        assert!(self.los * 10 >= self.links && (self.links - self.los) * 10 >= self.links, "{self:?}");
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

    /// Compares the engine with the oracle.
    pub(crate) fn check(&self, uav: P3, receiver: P3, count: &mut Count) -> bool {
        let wanted = oracle::columns_los(&self.oracle, uav, receiver);
        let found = los::columns_los(&self.engine, point(uav), point(receiver));
        assert_eq!(found, wanted, "{:?}\nuav {uav:?} receiver {receiver:?}", self.oracle);
        count.add(wanted);
        wanted
    }

    /// Compares ceiling and least UAV height with the oracle's; true if the receiver is exactly at the ceiling.
    pub(crate) fn check_heights(&self, uav: P3, receiver: P3, count: &mut Count) -> bool {
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

    /// Compares the engine, from both ends, with the oracle.
    pub(crate) fn check(&self, uav: P3, receiver: P3, count: &mut Count) -> bool {
        let wanted = oracle::prisms_los(&self.oracle, uav, receiver);
        let found = los::prisms_los(&self.engine, point(uav), point(receiver));
        assert_eq!(found, wanted, "{:?}\nuav {uav:?} receiver {receiver:?}", self.oracle);
        let swapped = los::prisms_los(&self.engine, point(receiver), point(uav));
        assert_eq!(swapped, wanted, "swapped: {:?}\nuav {uav:?} receiver {receiver:?}", self.oracle);
        count.add(wanted);
        wanted
    }

    /// Compares ceiling and least UAV height with the oracle's; true if the receiver is exactly at the ceiling.
    pub(crate) fn check_heights(&self, uav: P3, receiver: P3, count: &mut Count) -> bool {
        let what = || format!("{:?}\nuav {uav:?} receiver {receiver:?}", self.oracle);
        let wanted = oracle::prisms_ceiling(&self.oracle, uav, plan(receiver));
        compare(&los::prisms_least_receiver_height(&self.engine, point(uav), point(receiver)), &wanted, what);
        let least = oracle::prisms_least_uav_height(&self.oracle, plan(uav), receiver);
        compare(&los::prisms_least_receiver_height(&self.engine, point(receiver), point(uav)), &least, what);
        let is_tie = is_at(&wanted, receiver[2]);
        count.ties += u64::from(is_tie);
        is_tie
    }
}

fn is_at(ceiling: &oracle::Ceiling, z: i64) -> bool {
    matches!(ceiling, oracle::Ceiling::At(height) if *height == Ratio::from(BigInt::from(z)))
}

/// Asserts that a ceiling is the oracle's: the same lattice heights meet it, and its value in meters is near.
pub(crate) fn compare(found: &los::LeastHeight, wanted: &oracle::Ceiling, what: impl Fn() -> String) {
    let value = found.height_steps();
    match wanted {
        oracle::Ceiling::Clear => assert!(*found == los::LeastHeight::Clear, "{found:?}, wanted none\n{}", what()),
        oracle::Ceiling::Never => assert!(value == f64::INFINITY, "{found:?}, wanted none is enough\n{}", what()),
        oracle::Ceiling::At(height) => {
            let least = i64::try_from(height.ceil().to_integer()).unwrap();
            assert!(
                found.is_met_by(least) && !found.is_met_by(least - 1),
                "{found:?} = {value}, wanted {height}, first met by {least}\n{}",
                what()
            );
            let above = least as f64 - value;
            assert!(above > -1e-9 * (1.0 + value.abs()) && above < 1.0 + 1e-9 * value.abs(), "{value} {height}");
        }
    }
}
