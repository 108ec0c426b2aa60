//! Faults of footprints one by one, for `--repairs`.

use crate::city::{FootprintFault, FootprintFaults};

/// Something that was repaired or left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Repair {
    /// Number of the feature in the file, from 1.
    pub feature: usize,
    /// Id of the feature; its number where it has none.
    pub id: String,
    /// Fault of the feature.
    pub fault: FootprintFault,
    /// Treatment of the fault.
    pub done: &'static str,
    /// A point of the feature \[CRS units of the scene\]; `None` if it has no area.
    pub place: Option<[f64; 2]>,
}

/// Record of faults: listed one by one, or only counted, which costs nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Listing {
    CountsOnly,
    EachOne,
}

/// Feature that has a fault.
#[derive(Debug, Clone, Copy)]
pub(super) struct Culprit<'a> {
    pub(super) feature: usize,
    pub(super) id: &'a str,
    pub(super) place: Option<[f64; 2]>,
    /// `true` if it lies in the typed extent. Faults of other features are not counted, whatever is
    /// read beyond it.
    pub(super) is_asked: bool,
}

/// Faults that were found: counted, and listed on request.
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

    /// Logs a fault with the fixed treatment of its kind.
    pub(super) fn note(&mut self, fault: FootprintFault, culprit: Culprit<'_>) {
        self.note_done(fault, culprit, fault.done());
    }

    /// Logs a fault and its treatment.
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

    /// Moves the places that are listed so far; places that cannot be moved become unknown.
    pub(super) fn move_places(&mut self, to: impl Fn((f64, f64)) -> Option<(f64, f64)>) {
        for repair in self.list.iter_mut().flatten() {
            repair.place = repair.place.and_then(|[x, y]| to((x, y))).map(|(x, y)| [x, y]);
        }
    }

    /// Returns `true` when the list holds anything.
    pub(super) fn has_listed(&self) -> bool {
        self.list.as_ref().is_some_and(|list| !list.is_empty())
    }

    /// Returns the list, in the order of the features and, for each, of the kinds of faults.
    pub(super) fn into_list(self) -> Vec<Repair> {
        let mut list = self.list.unwrap_or_default();
        list.sort_by_key(|repair| (repair.feature, repair.fault));
        list
    }
}
