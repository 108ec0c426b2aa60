//! Parts of a line, or of a circle, that others leave uncovered.

/// An end of an interval, where it is exactly and where it is with [ties](super::TIE) left free.
#[derive(Debug, Clone, Copy)]
pub(super) struct End {
    pub(super) exact: f64,
    pub(super) loose: f64,
}

impl End {
    pub(super) fn at(t: f64) -> End {
        End { exact: t, loose: t }
    }
}

/// Closed intervals that nothing covers, in order.
#[derive(Debug, Clone)]
pub(super) struct Free {
    pub(super) intervals: Vec<[End; 2]>,
}

impl Free {
    pub(super) fn between(from: f64, to: f64) -> Free {
        Free { intervals: vec![[End::at(from), End::at(to)]] }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.intervals.is_empty()
    }

    /// Takes an open interval away; returns whether that changes anything.
    pub(super) fn cover(&mut self, [from, to]: [End; 2]) -> bool {
        let is_met = |[first, last]: &[End; 2]| from.loose < last.loose && first.loose < to.loose;
        if from.loose >= to.loose || !self.intervals.iter().any(is_met) {
            return false;
        }
        let mut k = 0;
        while k < self.intervals.len() {
            let [first, last] = self.intervals[k];
            let left = if is_met(&self.intervals[k]) {
                let before = (first.loose <= from.loose).then_some([first, from]);
                [before, (to.loose <= last.loose).then_some([to, last])]
            } else {
                [Some([first, last]), None]
            };
            self.intervals.splice(k..=k, left.into_iter().flatten());
            k += left.iter().flatten().count();
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn covers_leave_closed_intervals() {
        let mut free = Free::between(0.0, 10.0);
        let left = |free: &Free| free.intervals.iter().map(|i| i.map(|end| end.loose)).collect::<Vec<_>>();
        assert!(!free.cover([10.0, 12.0].map(End::at)));
        assert!(free.cover([2.0, 4.0].map(End::at)));
        assert!(free.cover([4.0, 5.0].map(End::at)));
        assert_eq!(left(&free), [[0.0, 2.0], [4.0, 4.0], [5.0, 10.0]]);
        assert!(!free.cover([2.0, 4.0].map(End::at)));
        assert!(free.cover([3.0, 7.0].map(End::at)));
        assert!(free.cover([-1.0, 1.0].map(End::at)));
        assert_eq!(left(&free), [[1.0, 2.0], [7.0, 10.0]]);
        free.cover([0.0, 11.0].map(End::at));
        assert!(free.is_empty());
    }
}
