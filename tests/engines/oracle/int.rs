//! Integers of any size, for the oracle.

use std::cmp::Ordering;

use num_bigint::BigInt;

/// An integer of any size, a machine integer as long as it fits.
#[derive(Clone, Debug)]
pub(super) enum Int {
    Small(i128),
    Big(BigInt),
}

impl Int {
    pub(super) fn to_big(&self) -> BigInt {
        match self {
            Int::Small(value) => BigInt::from(*value),
            Int::Big(value) => value.clone(),
        }
    }

    pub(super) fn from(value: i64) -> Int {
        Int::Small(i128::from(value))
    }

    pub(super) fn cmp(&self, other: &Int) -> Ordering {
        match (self, other) {
            (Int::Small(a), Int::Small(b)) => a.cmp(b),
            _ => self.to_big().cmp(&other.to_big()),
        }
    }

    /// The value compared with 0.
    pub(super) fn sign(&self) -> Ordering {
        self.cmp(&Int::Small(0))
    }
}

macro_rules! exact_operator {
    ($operator:ident, $method:ident, $checked:ident) => {
        impl std::ops::$operator for &Int {
            type Output = Int;

            fn $method(self, other: &Int) -> Int {
                if let (Int::Small(a), Int::Small(b)) = (self, other)
                    && let Some(result) = a.$checked(*b)
                {
                    return Int::Small(result);
                }
                Int::Big(self.to_big().$method(other.to_big()))
            }
        }
    };
}

exact_operator!(Add, add, checked_add);
exact_operator!(Sub, sub, checked_sub);
exact_operator!(Mul, mul, checked_mul);
