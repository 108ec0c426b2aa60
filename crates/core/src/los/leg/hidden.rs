//! The hidden parts of a leg as they are found: sorted, disjoint, each with its main obstacle.

use super::place::{FRACTION_ERROR, LegPart, LegPlace};

/// An obstacle of the links to a leg.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LegObstacle {
    /// A piece of the prisms, by its index in [`Prisms::pieces`](crate::height_field::Prisms::pieces).
    Piece(usize),
    /// A cell of the columns, by its index in [`Columns::tops`](crate::height_field::Columns::tops).
    Cell(usize),
}

/// An open part of a leg without line of sight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HiddenPart {
    /// Start.
    pub from: LegPlace,
    /// End, after the start.
    pub to: LegPlace,
    /// Obstacle that alone hides the longest stretch of it, of equal ones the first.
    pub obstacle: LegObstacle,
    /// Length that the obstacle hides, as a fraction of the leg.
    hides: f64,
}

impl HiddenPart {
    /// Returns the part without its obstacle.
    pub fn part(&self) -> LegPart {
        LegPart { from: self.from, to: self.to }
    }
}

/// Hidden parts of a window of a leg, which grow as obstacles are found.
#[derive(Debug)]
pub(super) struct HiddenParts {
    window: LegPart,
    parts: Vec<HiddenPart>,
}

impl HiddenParts {
    pub(super) fn within(window: LegPart) -> HiddenParts {
        HiddenParts { window, parts: Vec::new() }
    }

    /// Adds a part that one obstacle hides, and merges it with those that it meets.
    pub(super) fn add(&mut self, part: LegPart, obstacle: LegObstacle) {
        let mut added = HiddenPart { from: part.from, to: part.to, obstacle, hides: part.length() };
        let first = self.parts.partition_point(|known| known.to < added.from);
        let met = self.parts[first..].partition_point(|known| known.from <= added.to);
        for known in &self.parts[first..first + met] {
            (added.from, added.to) = (added.from.min(known.from), added.to.max(known.to));
            if known.hides > added.hides || (known.hides >= added.hides && known.obstacle < added.obstacle) {
                (added.obstacle, added.hides) = (known.obstacle, known.hides);
            }
        }
        if met == 1 {
            self.parts[first] = added;
        } else {
            self.parts.splice(first..first + met, [added]);
        }
    }

    /// Returns `true` if obstacles change nothing that hide at most `each` between two fractions of
    /// the leg: those are hidden, by an obstacle that hides more.
    pub(super) fn are_hidden(&self, from: f64, to: f64, each: f64) -> bool {
        let begins = self.parts.partition_point(|known| known.from.fraction() <= from - 2.0 * FRACTION_ERROR);
        let known = match begins.checked_sub(1).map(|last| &self.parts[last]) {
            Some(known) => known,
            // A part that begins with the window hides whatever begins before it.
            None => match self.parts.first() {
                Some(first) if first.from == self.window.from => first,
                _ => return false,
            },
        };
        let ends_after = known.to.fraction() >= to + 2.0 * FRACTION_ERROR || known.to == self.window.to;
        ends_after && each + 4.0 * FRACTION_ERROR < known.hides
    }

    pub(super) fn into_parts(self) -> Vec<HiddenPart> {
        self.parts
    }
}
