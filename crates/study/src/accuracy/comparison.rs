//! Comparison of an answer with the exact one, receiver by receiver.

use super::{CoarseAnswer, coarse_answer};
use crate::coverage::Seen;
use crate::quantity::share;

/// Counts of an answer against the exact one, summed over UAVs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Comparison {
    /// Receivers that both answer.
    pub receivers: u64,
    /// Receivers in sight by the answer and not in truth.
    pub false_los: u64,
    /// Receivers in sight in truth and not by the answer.
    pub false_nlos: u64,
    /// Receivers of the exact answer for which the compared answer has none.
    pub unanswered: u64,
    /// Receivers of the answer itself. Its cells may be larger, and other cells may be open ground.
    pub own_receivers: u64,
    /// Receivers of the answer itself that are in sight by it.
    pub own_los: u64,
}

impl Comparison {
    /// Returns the number of receivers that are decided wrongly.
    pub fn wrong(&self) -> u64 {
        self.false_los + self.false_nlos
    }

    /// Returns the share of receivers that are decided wrongly; `None` without a receiver.
    pub fn wrong_share(&self) -> Option<f64> {
        share(self.wrong(), self.receivers)
    }

    /// Returns P_LoS over the answer's own receivers; `None` without one.
    pub fn p_los(&self) -> Option<f64> {
        share(self.own_los, self.own_receivers)
    }

    /// Returns the sum of both.
    #[must_use]
    pub fn plus(self, other: Comparison) -> Comparison {
        Comparison {
            receivers: self.receivers + other.receivers,
            false_los: self.false_los + other.false_los,
            false_nlos: self.false_nlos + other.false_nlos,
            unanswered: self.unanswered + other.unanswered,
            own_receivers: self.own_receivers + other.own_receivers,
            own_los: self.own_los + other.own_los,
        }
    }

    /// Compares an answer with the exact one of the same UAV.
    /// The cells of the answer are `factor` (at least 1) times as large in both directions. They
    /// begin at the same north-west corner and cover the exact cells. A receiver takes the answer
    /// of the cell that holds its center. The center c + 1/2 lies in cell ⌊c / `factor`⌋ of the
    /// larger cells, so this is done in integers, too.
    pub fn of(answer: &Seen, exact: &Seen, factor: usize) -> Comparison {
        let mut counts = Comparison {
            own_receivers: answer.receivers.count(),
            own_los: answer.los.count_in(&answer.receivers),
            ..Comparison::default()
        };
        for (row, col) in exact.receivers.cells() {
            let said = coarse_answer(&answer.receivers, &answer.los, factor, (row, col));
            counts.receivers += u64::from(said != CoarseAnswer::None);
            match (said, exact.los.contains(row, col)) {
                (CoarseAnswer::None, _) => counts.unanswered += 1,
                (CoarseAnswer::Los, false) => counts.false_los += 1,
                (CoarseAnswer::Nlos, true) => counts.false_nlos += 1,
                _ => {}
            }
        }
        counts
    }
}
