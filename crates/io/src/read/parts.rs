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
use crate::overlay::{Polygon, Ring, Tangle, difference, doubled_area, intersection, union, wound};
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
    /// Cost: the overlay of each part with the outlines whose boxes meet its own, from the smallest on
    /// to the first that holds it.
    ///
    /// # Errors
    /// The part whose edges and those of outlines cross too often.
    pub(super) fn of(footprints: &[RawFootprint], rule: Parts, frame: Frame) -> Result<Grouping, (usize, Tangle)> {
        let mut grouping = Grouping::default();
        if rule == Parts::Join || footprints.iter().all(|of| of.part_of.is_none()) {
            return Ok(grouping);
        }
        let outlines = || footprints.iter().enumerate().filter(|(_, of)| of.part_of.is_none());
        let mut by_name: HashMap<&str, usize> = HashMap::new();
        outlines().for_each(|(k, of)| {
            by_name.entry(of.id.as_str()).or_insert(k);
        });
        let boxes = BoxIndex::new(outlines().filter_map(|(k, of)| Some((k, bounds(of.polygons.iter())?))));
        let mut outlines = Outlines { footprints, frame, boxes, regions: HashMap::new(), n_compared: 0 };
        let mut groups: HashMap<String, u32> = HashMap::new();
        for (k, part) in footprints.iter().enumerate() {
            let Some(part_of) = &part.part_of else { continue };
            let named = match part_of {
                PartOf::Named(name) => by_name.get(name.as_str()).copied(),
                PartOf::Outline => None,
            };
            let outline = match named {
                Some(named) => Some(named),
                None => outlines.holding(part).map_err(|tangle| (k, tangle))?,
            };
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
                if named.is_none() || outlines.covers(outline, part).map_err(|tangle| (k, tangle))? {
                    grouping.outline.insert(k, outline);
                    grouping.parts.entry(outline).or_default().push(k);
                }
            }
        }
        Ok(grouping)
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
    /// Number of outlines that parts were compared with.
    n_compared: usize,
}

/// Outlines that parts may be compared with, in addition to [`COMPARED_PER_FOOTPRINT`].
const MOST_COMPARED: usize = 100_000;

/// Outlines that parts may be compared with, for each footprint.
const COMPARED_PER_FOOTPRINT: usize = 64;

impl Outlines<'_> {
    /// Returns the smallest outline that holds most of a part.
    fn holding(&mut self, part: &RawFootprint) -> Result<Option<usize>, Tangle> {
        let Some(bounds) = bounds(part.polygons.iter()) else { return Ok(None) };
        let region = region_of(part, self.frame);
        let meeting: Vec<usize> = self.boxes.meeting(bounds).collect();
        let mut by_area =
            meeting.into_iter().map(|k| Ok((doubled(self.region(k)?), k))).collect::<Result<Vec<_>, _>>()?;
        by_area.sort_unstable();
        // A smaller outline holds less than half of the part.
        let first = by_area.partition_point(|(area, _)| 2 * area <= doubled(&region));
        for (_, k) in by_area.drain(first..) {
            if 2 * doubled(&intersection(&region, self.region(k)?)?.concat()) > doubled(&region) {
                return Ok(Some(k));
            }
        }
        Ok(None)
    }

    /// Returns `true` when an outline covers any of a part.
    fn covers(&mut self, outline: usize, part: &RawFootprint) -> Result<bool, Tangle> {
        let part = region_of(part, self.frame);
        Ok(doubled(&intersection(&part, self.region(outline)?)?.concat()) > 0)
    }

    /// Returns the region of an outline that a part is compared with.
    ///
    /// # Errors
    /// More comparisons than the footprints are worth.
    fn region(&mut self, outline: usize) -> Result<&[Ring], Tangle> {
        let most = MOST_COMPARED + COMPARED_PER_FOOTPRINT * self.footprints.len();
        self.n_compared += 1;
        if self.n_compared > most {
            return Err(Tangle::Outlines(most));
        }
        let (footprints, frame) = (self.footprints, self.frame);
        Ok(self.regions.entry(outline).or_insert_with(|| region_of(&footprints[outline], frame)))
    }
}

/// Returns the region that a footprint covers on the lattice.
fn region_of(footprint: &RawFootprint, frame: Frame) -> Vec<Ring> {
    rings_of(&lattice_polygons(&footprint.polygons, frame))
}

/// Returns the rest of an outline beside its parts; nothing if they cover nine tenths of it.
///
/// # Errors
/// Edges that cross too often.
pub(super) fn rest_of<'a>(
    outline: &[Polygon],
    parts: impl Iterator<Item = &'a [Polygon]>,
) -> Result<Vec<Polygon>, Tangle> {
    let parts: Vec<Polygon> = parts.flatten().map(wound).collect();
    let rings = rings_of(outline);
    let rest = difference(&rings, &union(parts)?.concat())?;
    Ok(if 10 * doubled(&rest.concat()) <= doubled(&rings) { Vec::new() } else { rest })
}

/// Returns all rings: shells wound alike, holes the other way.
fn rings_of(polygons: &[Polygon]) -> Vec<Ring> {
    polygons.iter().flat_map(wound).collect()
}

/// Returns twice the area that rings of the same winding enclose.
fn doubled(rings: &[Ring]) -> i128 {
    rings.iter().map(|ring| doubled_area(ring)).sum()
}
