//! Places of a leg as exact fractions of its way, and open parts between them.

use std::cmp::Ordering;

use ethnum::I256;

/// Bound on the relative error of [`LegPlace::fraction`].
///
/// Two conversions of two roundings each and a quotient are off by at most 5·2^-53 together.
pub(super) const FRACTION_ERROR: f64 = 1e-15;

/// An exact place of a leg: a fraction of the way from its start to its end.
#[derive(Debug, Clone, Copy)]
pub struct LegPlace {
    num: I256,
    /// Above 0.
    den: I256,
    near: f64,
}

impl LegPlace {
    /// Start of a leg.
    pub const START: LegPlace = LegPlace { num: I256::ZERO, den: I256::ONE, near: 0.0 };

    /// End of a leg.
    pub const END: LegPlace = LegPlace { num: I256::ONE, den: I256::ONE, near: 1.0 };

    /// Returns the place at `num / den` of the way.
    ///
    /// # Panics
    /// If `den` is 0.
    pub fn new(num: i128, den: i128) -> LegPlace {
        assert!(den != 0, "a place of a leg is a fraction");
        let sign = I256::from(den.signum());
        LegPlace::of_terms(I256::from(num) * sign, I256::from(den) * sign)
    }

    /// Returns the place at `num / den` of the way, for `den` above 0.
    pub(super) fn of_terms(num: I256, den: I256) -> LegPlace {
        LegPlace { num, den, near: num.as_f64() / den.as_f64() }
    }

    /// Returns the fraction of the way, rounded.
    pub fn fraction(&self) -> f64 {
        self.near
    }

    /// Returns numerator and denominator of the exact fraction, not reduced; the denominator is above
    /// 0.
    pub fn terms(&self) -> (I256, I256) {
        (self.num, self.den)
    }
}

impl Ord for LegPlace {
    fn cmp(&self, other: &Self) -> Ordering {
        // PERF: fractions that differ by more than both errors need no products.
        let (a, b) = (self.near, other.near);
        if (a - b).abs() > 2.0 * FRACTION_ERROR * (a.abs() + b.abs()) {
            return a.total_cmp(&b);
        }
        if (self.num, self.den) == (other.num, other.den) {
            return Ordering::Equal;
        }
        let bits = |v: I256| 256 - v.unsigned_abs().leading_zeros();
        if bits(self.num) + bits(other.den) < 255 && bits(other.num) + bits(self.den) < 255 {
            return (self.num * other.den).cmp(&(other.num * self.den));
        }
        compare_by_quotients((self.num, self.den), (other.num, other.den))
    }
}

impl PartialOrd for LegPlace {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for LegPlace {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for LegPlace {}

/// Orders two fractions with positive denominators by their continued fractions: no product
/// overflows.
fn compare_by_quotients(mut a: (I256, I256), mut b: (I256, I256)) -> Ordering {
    loop {
        let (qa, qb) = (a.0.div_euclid(a.1), b.0.div_euclid(b.1));
        if qa != qb {
            return qa.cmp(&qb);
        }
        let (ra, rb) = (a.0.rem_euclid(a.1), b.0.rem_euclid(b.1));
        match (ra == I256::ZERO, rb == I256::ZERO) {
            (true, true) => return Ordering::Equal,
            (true, false) => return Ordering::Less,
            (false, true) => return Ordering::Greater,
            // a < b  ⇔  ra/da < rb/db  ⇔  db/rb < da/ra
            (false, false) => (a, b) = ((b.1, rb), (a.1, ra)),
        }
    }
}

/// An open part of a leg.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LegPart {
    /// Start.
    pub from: LegPlace,
    /// End, after the start.
    pub to: LegPlace,
}

impl LegPart {
    /// The whole leg.
    pub const WHOLE: LegPart = LegPart { from: LegPlace::START, to: LegPlace::END };

    /// Returns the length as a fraction of the leg, rounded.
    pub fn length(&self) -> f64 {
        self.to.near - self.from.near
    }

    /// Returns the places at which `at_start + s·rate` is above 0; `None` if they have no length.
    #[must_use]
    pub(super) fn where_above_zero(self, at_start: i128, rate: i128) -> Option<LegPart> {
        let mut part = self;
        match rate.cmp(&0) {
            Ordering::Equal => return (at_start > 0).then_some(part),
            Ordering::Greater => part.from = part.from.max(LegPlace::new(-at_start, rate)),
            Ordering::Less => part.to = part.to.min(LegPlace::new(-at_start, rate)),
        }
        (part.from < part.to).then_some(part)
    }

    /// Returns the places in both parts; `None` if they have no length.
    #[must_use]
    pub fn and(&self, other: &LegPart) -> Option<LegPart> {
        let (from, to) = (self.from.max(other.from), self.to.min(other.to));
        (from < to).then_some(LegPart { from, to })
    }

    /// Returns the places before and after another part.
    pub(super) fn without(&self, other: &LegPart) -> impl Iterator<Item = LegPart> {
        let before = LegPart { from: self.from, to: self.to.min(other.from) };
        let after = LegPart { from: self.from.max(other.to), to: self.to };
        [before, after].into_iter().filter(|part| part.from < part.to)
    }
}

/// Returns the length of disjoint parts together, as a fraction of the leg, rounded.
pub fn total_length(parts: impl IntoIterator<Item = LegPart>) -> f64 {
    parts.into_iter().map(|part| part.length()).sum()
}

/// Returns the parts sorted, with those that overlap or abut as one.
pub fn merged_parts(mut parts: Vec<LegPart>) -> Vec<LegPart> {
    parts.sort_unstable_by_key(|part| part.from);
    let mut merged: Vec<LegPart> = Vec::new();
    for part in parts {
        match merged.last_mut() {
            Some(last) if part.from <= last.to => last.to = last.to.max(part.to),
            _ => merged.push(part),
        }
    }
    merged
}

/// Returns the places that are in a part of every list. Each list is sorted and disjoint; without a
/// list it is the whole leg.
pub fn common_parts<'a>(lists: impl IntoIterator<Item = &'a [LegPart]>) -> Vec<LegPart> {
    let mut lists = lists.into_iter();
    let first = lists.next().map_or_else(|| vec![LegPart::WHOLE], <[LegPart]>::to_vec);
    lists.fold(first, |a, b| {
        let (mut i, mut k, mut common) = (0, 0, Vec::new());
        while i < a.len() && k < b.len() {
            common.extend(a[i].and(&b[k]));
            if a[i].to <= b[k].to { i += 1 } else { k += 1 }
        }
        common
    })
}
