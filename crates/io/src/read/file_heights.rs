//! Facts about the heights of a whole file: median, bases, sources.
//!
//! They cover all features in the typed extent, not only those near a radius, in a tile or in a
//! block of the file. A building thus has one height, however the run is cut.

use std::collections::{HashMap, HashSet};

use super::building::RawFootprint;
use super::height_value::FoundHeight;
use super::parts::Grouping;
use crate::city::{HeightSource, HeightSources};
use skyshed_request::{HeightRule, MissingHeights};

/// Meters per storey where only the number of storeys is known (the default of OpenStreetMap
/// renderers).
pub const METERS_PER_LEVEL: f64 = 3.0;

/// A height \[m\], and its reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Height {
    pub(super) m: f64,
    pub(super) above_datum: bool,
}

/// Facts of the heights of a file.
#[derive(Debug, Clone, Default)]
pub(super) struct FileHeights {
    /// Lower middle of all heights above the ground that were read; without any, of the tops above
    /// the datum.
    median: Option<Height>,
    /// Ground below buildings: lowest, lower middle and highest \[m above the datum\]; `None` where
    /// the file holds none.
    pub(super) bases: Option<BaseRange>,
    /// Number and area of footprints by the source of their height.
    pub(super) sources: HeightSources,
    /// Id of the first footprint without a height.
    pub(super) without: Option<String>,
    /// Number of footprints that have storeys and no height.
    pub(super) n_storeys: usize,
    /// `true` if any height is above the datum.
    pub(super) has_tops: bool,
}

/// The ground below the buildings of a file \[m above the datum\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BaseRange {
    pub(super) lowest: f64,
    pub(super) middle: f64,
    pub(super) highest: f64,
}

impl FileHeights {
    /// Collects the facts of the footprints in the typed extent.
    pub(super) fn of(footprints: &[RawFootprint], grouping: &Grouping, missing: &MissingHeights) -> FileHeights {
        let asked: Vec<usize> = (0..footprints.len()).filter(|k| footprints[*k].is_asked).collect();
        let all = || asked.iter().map(|k| &footprints[*k]);
        let height_of =
            |height: &dyn Fn(&RawFootprint) -> Option<f64>| by_building(footprints, &asked, grouping, height);
        let above_ground = height_of(&|f| f.height_above_ground().filter(|m| *m > 0.0));
        let tops = height_of(&|f| f.height.meters().filter(|_| f.above_datum));
        let height = |above_datum: bool| move |m: f64| Height { m, above_datum };
        let median = lower_middle(above_ground).map(height(false)).or_else(|| lower_middle(tops).map(height(true)));
        let bases: Vec<f64> = all().filter_map(|footprint| footprint.base_m).collect();
        let bases = bases
            .iter()
            .copied()
            .reduce(f64::min)
            .zip(bases.iter().copied().reduce(f64::max))
            .and_then(|(lowest, highest)| Some(BaseRange { lowest, highest, middle: lower_middle(bases)? }));
        let has_tops = all().any(|footprint| footprint.above_datum && footprint.height.meters().is_some());
        let facts = FileHeights { median, bases, has_tops, ..FileHeights::default() };
        let source_of = |k: usize| {
            let outline = grouping.outline_of(k).map(|outline| &footprints[outline]);
            facts.height(&footprints[k], outline, missing).0
        };
        // Parts replace an outline, whose height is then not missing.
        let is_replaced = |k: usize| {
            grouping.parts_of(k).is_some_and(|parts| parts.iter().any(|part| source_of(*part) != HeightSource::Nowhere))
        };
        let own = || asked.iter().copied().filter(|k| !is_replaced(*k));
        let is_missing = |of: &RawFootprint| of.height == FoundHeight::Missing;
        let n_storeys = own().filter(|k| is_missing(&footprints[*k]) && footprints[*k].levels.is_some()).count();
        let sources = HeightSources::of(own().map(|k| (source_of(k), footprints[k].area())));
        let without = own().find(|k| source_of(*k) == HeightSource::Nowhere).map(|k| footprints[k].id.clone());
        FileHeights { sources, without, n_storeys, ..facts }
    }

    /// Returns the median \[m\] that rules use.
    pub(super) fn median_m(&self) -> Option<f64> {
        self.median.map(|height| height.m)
    }

    /// Returns the height of a footprint, and its source. A part uses its own storeys, else those
    /// of its outline.
    pub(super) fn height(
        &self,
        of: &RawFootprint,
        outline: Option<&RawFootprint>,
        missing: &MissingHeights,
    ) -> (HeightSource, Option<Height>) {
        if let Some(m) = of.height.meters() {
            return (HeightSource::File, Some(Height { m, above_datum: of.above_datum }));
        }
        // Storeys are counted from the ground, even if the property is measured from the datum.
        let above_ground = |m: f64| Height { m, above_datum: false };
        let of_storeys = of.levels.map(|levels| above_ground(levels * METERS_PER_LEVEL));
        let of_outline = || outline?.levels.map(|levels| above_ground(levels * METERS_PER_LEVEL));
        if let Some(height) = of_storeys.or_else(of_outline).filter(|_| of.part_of.is_some()) {
            return (HeightSource::Storeys, Some(height));
        }
        let found = missing.rules().iter().find_map(|rule| match rule {
            HeightRule::Levels => of_storeys.map(|height| (HeightSource::Storeys, height)),
            HeightRule::Median => self.median.map(|height| (HeightSource::Median, height)),
            HeightRule::Meters(m) => Some((HeightSource::Number, above_ground(*m))),
        });
        found.map_or((HeightSource::Nowhere, None), |(source, height)| (source, Some(height)))
    }
}

/// Returns one height for each building in the typed extent that has any: its outline's, else its
/// highest part's.
fn by_building(
    footprints: &[RawFootprint],
    asked: &[usize],
    grouping: &Grouping,
    height: &dyn Fn(&RawFootprint) -> Option<f64>,
) -> Vec<f64> {
    let mut found = Vec::new();
    // Highest parts of buildings without an outline, by group.
    let (mut undrawn, mut drawn): (HashMap<u32, f64>, HashSet<u32>) = Default::default();
    // Without a grouping, parts count only if no outline is drawn.
    let has_outlines = asked.iter().any(|k| footprints[*k].part_of.is_none());
    for k in asked.iter().copied() {
        let (own, parts) = (height(&footprints[k]), grouping.parts_of(k));
        if let Some(parts) = parts {
            found.extend(own.or_else(|| parts.iter().filter_map(|part| height(&footprints[*part])).reduce(f64::max)));
        } else if footprints[k].part_of.is_none() {
            drawn.extend(grouping.group_of(k));
            found.extend(own);
        } else if grouping.is_empty() {
            found.extend(own.filter(|_| !has_outlines));
        } else if grouping.outline_of(k).is_none() {
            match (grouping.group_of(k), own) {
                (Some(group), Some(m)) => {
                    undrawn.entry(group).and_modify(|most| *most = most.max(m)).or_insert(m);
                }
                (_, own) => found.extend(own),
            }
        }
    }
    found.extend(undrawn.into_iter().filter(|(group, _)| !drawn.contains(group)).map(|(_, m)| m));
    found
}

/// Returns the middle of some numbers, the lower one of two.
pub(super) fn lower_middle(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len().checked_sub(1)? / 2;
    let (_, m, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*m)
}
