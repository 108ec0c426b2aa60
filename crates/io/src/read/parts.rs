//! Parts of buildings in place of their outlines (Simple 3D Buildings of OpenStreetMap, Overture,
//! CityJSON).
//!
//! An outline has the height of its highest part, so it is too high everywhere else. Parts replace
//! it where they are drawn. If they cover nine tenths of it, the rest is dropped; else the rest
//! stands by itself.
//!
//! The outline of a part is the footprint that it names, else the smallest that holds most of its
//! area. A part that lies beside the building it names, as an annex does, replaces nothing. All
//! areas are compared on the lattice.

use std::collections::HashMap;

use super::box_index::BoxIndex;
use super::building::{PartOf, RawFootprint};
use super::lattice_polygon::lattice_polygons;
use super::vector::bounds;
use crate::overlay::{Polygon, Ring, difference, doubled_area, intersection, union, wound};
use crate::quantity::Frame;
use skyshed_request::Parts;

/// Groups of footprints that belong together, by their indices in a list.
#[derive(Debug, Default)]
pub(super) struct Grouping {
    /// Parts by their outline.
    parts: HashMap<usize, Vec<usize>>,
    outline: HashMap<usize, usize>,
    /// Number of each building of parts.
    group: HashMap<usize, u32>,
}

impl Grouping {
    /// Groups footprints; the grouping is empty for [`Parts::Join`].
    ///
    /// Cost: the overlay of each part with the outlines whose boxes meet its own.
    pub(super) fn of(footprints: &[RawFootprint], rule: Parts, frame: Frame) -> Grouping {
        let mut grouping = Grouping::default();
        if rule == Parts::Join || footprints.iter().all(|of| of.part_of.is_none()) {
            return grouping;
        }
        let outlines = || footprints.iter().enumerate().filter(|(_, of)| of.part_of.is_none());
        let mut by_name: HashMap<&str, usize> = HashMap::new();
        outlines().for_each(|(k, of)| {
            by_name.entry(of.id.as_str()).or_insert(k);
        });
        let boxes = BoxIndex::new(outlines().filter_map(|(k, of)| Some((k, bounds(of.polygons.iter())?))));
        let mut outlines = Outlines { footprints, frame, boxes, regions: HashMap::new() };
        let mut groups: HashMap<String, u32> = HashMap::new();
        for (k, part) in footprints.iter().enumerate() {
            let Some(part_of) = &part.part_of else { continue };
            let named = match part_of {
                PartOf::Named(name) => by_name.get(name.as_str()).copied(),
                PartOf::Outline => None,
            };
            let outline = named.or_else(|| outlines.holding(part));
            let key = match (outline, part_of) {
                (Some(outline), _) => format!("#{outline}"),
                (None, PartOf::Named(name)) => format!("={name}"),
                (None, PartOf::Outline) => continue,
            };
            let n = u32::try_from(groups.len()).unwrap_or(u32::MAX);
            let group = *groups.entry(key).or_insert(n);
            grouping.group.insert(k, group);
            if let Some(outline) = outline {
                grouping.group.insert(outline, group);
                // A part beside its building, such as an annex, takes nothing from it.
                if named.is_none() || outlines.covers(outline, part) {
                    grouping.outline.insert(k, outline);
                    grouping.parts.entry(outline).or_default().push(k);
                }
            }
        }
        grouping
    }

    /// Returns `true` when every footprint is a building by itself.
    pub(super) fn is_empty(&self) -> bool {
        self.group.is_empty()
    }

    /// Returns the parts of an outline.
    pub(super) fn parts_of(&self, outline: usize) -> Option<&[usize]> {
        self.parts.get(&outline).map(Vec::as_slice)
    }

    /// Returns the outline of a part.
    pub(super) fn outline_of(&self, part: usize) -> Option<usize> {
        self.outline.get(&part).copied()
    }

    /// Returns the number of the building of parts that a footprint belongs to.
    pub(super) fn group_of(&self, footprint: usize) -> Option<u32> {
        self.group.get(&footprint).copied()
    }
}

/// Outlines in which parts are looked up.
struct Outlines<'a> {
    footprints: &'a [RawFootprint],
    frame: Frame,
    boxes: BoxIndex<f64>,
    /// Regions of the outlines that were looked up.
    regions: HashMap<usize, Vec<Ring>>,
}

impl Outlines<'_> {
    /// Returns the smallest outline that holds most of a part.
    fn holding(&mut self, part: &RawFootprint) -> Option<usize> {
        let region = region_of(part, self.frame);
        let mut smallest: Option<(i128, usize)> = None;
        for k in self.boxes.meeting(bounds(part.polygons.iter())?) {
            let (footprints, frame) = (self.footprints, self.frame);
            let outline = self.regions.entry(k).or_insert_with(|| region_of(&footprints[k], frame));
            let found = (doubled(outline), k);
            let is_smaller = smallest.is_none_or(|smallest| found < smallest);
            if is_smaller && 2 * doubled(&intersection(&region, outline).concat()) > doubled(&region) {
                smallest = Some(found);
            }
        }
        smallest.map(|(_, k)| k)
    }

    /// Returns `true` when an outline covers any of a part.
    fn covers(&mut self, outline: usize, part: &RawFootprint) -> bool {
        let (footprints, frame) = (self.footprints, self.frame);
        let outline = self.regions.entry(outline).or_insert_with(|| region_of(&footprints[outline], frame));
        doubled(&intersection(&region_of(part, frame), outline).concat()) > 0
    }
}

/// Returns the region that a footprint covers on the lattice.
fn region_of(footprint: &RawFootprint, frame: Frame) -> Vec<Ring> {
    rings_of(&lattice_polygons(&footprint.polygons, frame))
}

/// Returns the rest of an outline beside its parts; nothing if they cover nine tenths of it.
pub(super) fn rest_of<'a>(outline: &[Polygon], parts: impl Iterator<Item = &'a [Polygon]>) -> Vec<Polygon> {
    let parts: Vec<Polygon> = parts.flatten().map(wound).collect();
    let rings = rings_of(outline);
    let rest = difference(&rings, &union(parts).concat());
    if 10 * doubled(&rest.concat()) <= doubled(&rings) { Vec::new() } else { rest }
}

/// Returns all rings: shells wound alike, holes the other way.
fn rings_of(polygons: &[Polygon]) -> Vec<Ring> {
    polygons.iter().flat_map(wound).collect()
}

/// Returns twice the area that rings of the same winding enclose.
fn doubled(rings: &[Ring]) -> i128 {
    rings.iter().map(|ring| doubled_area(ring)).sum()
}
