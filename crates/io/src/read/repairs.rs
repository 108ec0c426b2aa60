//! Faults of footprints one by one, where `--repairs` asks for them.

use crate::city::{FootprintFault, FootprintFaults};

/// One thing that was mended or left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Repair {
    /// Number of the feature in the file, from 1.
    pub feature: usize,
    /// Its id; its number where it has none.
    pub id: String,
    /// What was wrong.
    pub fault: FootprintFault,
    /// What was done.
    pub done: &'static str,
    /// A point of it \[CRS units of the scene\]; `None` for what has no area.
    pub place: Option<[f64; 2]>,
}

/// Whether faults are listed one by one, or only counted, which costs nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Listing {
    CountsOnly,
    EachOne,
}

/// The feature that a fault is of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Culprit<'a> {
    pub(super) feature: usize,
    pub(super) id: &'a str,
    pub(super) place: Option<[f64; 2]>,
    /// Whether it lies in the typed extent; faults of others are not counted, whatever is read beyond it.
    pub(super) is_asked: bool,
}

/// Faults as they are met: counted, and listed if that was asked for.
#[derive(Debug)]
pub(super) struct FaultLog {
    pub(super) counts: FootprintFaults,
    list: Option<Vec<Repair>>,
}

impl FaultLog {
    pub(super) fn new(listing: Listing) -> FaultLog {
        let list = match listing {
            Listing::CountsOnly => None,
            Listing::EachOne => Some(Vec::new()),
        };
        FaultLog { counts: FootprintFaults::default(), list }
    }

    /// Notes a fault that is treated as its kind always is.
    pub(super) fn note(&mut self, fault: FootprintFault, culprit: Culprit<'_>) {
        self.note_done(fault, culprit, fault.done());
    }

    /// Notes a fault and what was done about it.
    pub(super) fn note_done(
        &mut self,
        fault: FootprintFault,
        Culprit { feature, id, place, is_asked }: Culprit<'_>,
        done: &'static str,
    ) {
        if !is_asked {
            return;
        }
        self.counts.add(fault);
        if let Some(list) = &mut self.list {
            list.push(Repair { feature, id: id.to_string(), fault, done, place });
        }
    }

    /// Moves the places that are listed so far; those that cannot be moved are not known any more.
    pub(super) fn move_places(&mut self, to: impl Fn((f64, f64)) -> Option<(f64, f64)>) {
        for repair in self.list.iter_mut().flatten() {
            repair.place = repair.place.and_then(|[x, y]| to((x, y))).map(|(x, y)| [x, y]);
        }
    }

    /// Whether there is anything in the list.
    pub(super) fn has_listed(&self) -> bool {
        self.list.as_ref().is_some_and(|list| !list.is_empty())
    }

    /// What was listed, in the order of the features and, for each, of the kinds.
    pub(super) fn into_list(self) -> Vec<Repair> {
        let mut list = self.list.unwrap_or_default();
        list.sort_by_key(|repair| (repair.feature, repair.fault));
        list
    }
}
