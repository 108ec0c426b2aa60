//! Features out of ways and relations.
//!
//! A closed way is an area. A relation of type `multipolygon` is one out of several ways: its outer
//! rings, without its inner ones. Where it is no building itself, its outer ways may be: then each of
//! its areas is named by such a way, and has the tags of both. A relation of type `building` names
//! an outline and its parts.
//!
//! What is incomplete is no area: a way that lacks a node or does not end where it begins, and rings
//! of a relation that do not close.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::mem::size_of;

use super::super::super::polygon::Polygon;
use super::super::feature::{Feature, Properties};
use super::super::rings::{assembled, surrounds};
use super::collected::{Collected, Compound, CompoundKind};
use super::joined::{Ring, joined};
use super::{Budget, Id, Kind, Role};
use crate::error::Result;

/// Memory of a feature, about \[bytes\].
const BYTES_EACH: usize = 400;

/// Returns the buildings and their parts: ways, then relations, each by number.
///
/// # Errors
/// E502 for more than the file should hold.
pub(super) fn features(collected: Collected, budget: &mut Budget) -> Result<Vec<Feature>> {
    let groups = Groups::of(&collected);
    let mut areas = Vec::new();
    // Ways that are an area with others, and no building beside it.
    let mut joined_ways = HashSet::new();
    for (number, relation) in &collected.relations {
        let id = Id { kind: Kind::Relation, number: *number };
        let is_described = relation.kind == CompoundKind::Area || groups.has(id);
        if relation.kind != CompoundKind::Building {
            add_areas(&collected, (id, relation, is_described), (&mut areas, &mut joined_ways), budget)?;
        }
    }
    let mut features = Vec::new();
    for (number, line) in &collected.ways {
        let id = Id { kind: Kind::Way, number: *number };
        if (line.tags.is_empty() && !groups.has(id)) || joined_ways.contains(number) {
            continue;
        }
        let ring = collected.places(line).filter(|places| places.len() > 3 && places.first() == places.last());
        budget.take(1, BYTES_EACH + size_of::<[f64; 2]>() * ring.as_ref().map_or(0, Vec::len))?;
        let polygons = ring.into_iter().map(|ring| vec![ring]).collect();
        features.push(groups.feature(id, line.tags.clone(), polygons));
    }
    for Area { id, tags, polygons, is_incomplete } in areas {
        features.push(Feature { has_other_parts: is_incomplete, ..groups.feature(id, tags, polygons) });
    }
    Ok(features)
}

/// Buildings and their parts, by relations of type `building`.
#[derive(Debug, Default)]
struct Groups<'a> {
    /// Tags of the relation of each outline.
    outlines: HashMap<Id, &'a Properties>,
    /// Building of each part.
    part_of: HashMap<Id, Id>,
}

impl<'a> Groups<'a> {
    fn of(collected: &'a Collected) -> Groups<'a> {
        let mut groups = Groups::default();
        for (number, relation) in collected.relations.iter().filter(|(_, of)| of.kind == CompoundKind::Building) {
            let with =
                |wanted: Role| relation.members.iter().filter(move |(_, role)| *role == wanted).map(|(id, _)| *id);
            let outline = with(Role::Outline).next();
            let building = outline.unwrap_or(Id { kind: Kind::Relation, number: *number });
            if let Some(outline) = outline {
                groups.outlines.entry(outline).or_insert(&relation.tags);
            }
            for part in with(Role::Part).filter(|part| *part != building) {
                groups.part_of.entry(part).or_insert(building);
            }
        }
        groups
    }

    /// Returns `true` for the outline of a building and for parts.
    fn has(&self, id: Id) -> bool {
        self.outlines.contains_key(&id) || self.part_of.contains_key(&id)
    }

    /// Returns a feature. An outline has the tags of its building, too.
    fn feature(&self, id: Id, mut tags: Properties, polygons: Vec<Polygon>) -> Feature {
        if let Some(others) = self.outlines.get(&id) {
            add_missing(&mut tags, others);
        }
        let part_of = self.part_of.get(&id).map(Id::to_string);
        Feature { id: Some(id.to_string()), properties: tags, polygons, part_of, ..Feature::default() }
    }
}

/// Adds the tags of a relation that an element of it does not have itself.
fn add_missing(tags: &mut Properties, of_relation: &Properties) {
    for (name, value) in of_relation {
        if **name != *"type" && tags.iter().all(|(known, _)| known != name) {
            tags.push((name.clone(), value.clone()));
        }
    }
}

/// Area of a relation, or of some of its ways.
struct Area {
    id: Id,
    tags: Properties,
    polygons: Vec<Polygon>,
    /// `true` if any of it is missing.
    is_incomplete: bool,
}

/// Appends the areas of a relation, and the ways that are a part of them and not buildings by
/// themselves.
fn add_areas(
    collected: &Collected,
    (id, relation, is_described): (Id, &Compound, bool),
    (areas, joined_ways): (&mut Vec<Area>, &mut HashSet<i64>),
    budget: &mut Budget,
) -> Result<()> {
    let tags_of = |number: &i64| collected.ways.get(number).map(|line| &line.tags).filter(|tags| !tags.is_empty());
    let is_outer = |(_, role): &&(Id, Role)| *role != Role::Inner;
    let outer = || relation.members.iter().filter(is_outer).map(|(id, _)| id.number);
    if !is_described && !outer().any(|number| tags_of(&number).is_some()) {
        return Ok(());
    }
    let Shells { polygons, ways, is_incomplete } = Shells::of(collected, relation, budget)?;
    let points: usize = polygons.iter().flatten().map(Vec::len).sum();
    budget.take(points, size_of::<[f64; 2]>())?;
    budget.take(1 + polygons.len(), BYTES_EACH)?;
    // An outer way that is open is no building by itself, whatever its tags.
    let is_closed = |number: &i64| {
        let places = collected.ways.get(number).and_then(|line| collected.places(line));
        places.is_some_and(|places| places.first() == places.last())
    };
    joined_ways.extend(outer().filter(|number| tags_of(number).is_some() && !is_closed(number)));
    if is_described {
        areas.push(Area { id, tags: relation.tags.clone(), polygons, is_incomplete });
        return Ok(());
    }
    // The areas of each way with tags.
    let mut by_way: BTreeMap<i64, Vec<Polygon>> = BTreeMap::new();
    for (polygon, ways) in polygons.into_iter().zip(ways) {
        if let Some(first) = ways.iter().find(|number| tags_of(number).is_some()) {
            joined_ways.extend(&ways);
            by_way.entry(*first).or_default().push(polygon);
        }
    }
    if by_way.is_empty()
        && let Some(first) = outer().find(|number| tags_of(number).is_some() && !is_closed(number))
    {
        by_way.insert(first, Vec::new());
    }
    for (number, polygons) in by_way {
        let mut tags = tags_of(&number).cloned().unwrap_or_default();
        add_missing(&mut tags, &relation.tags);
        areas.push(Area { id: Id { kind: Kind::Way, number }, tags, polygons, is_incomplete });
    }
    Ok(())
}

/// Outer rings of a relation, each with its inner ones.
struct Shells {
    polygons: Vec<Polygon>,
    /// Ways of each outer ring.
    ways: Vec<Vec<i64>>,
    /// `true` if a way or a node is missing, or if a ring does not close or lies outside.
    is_incomplete: bool,
}

impl Shells {
    fn of(collected: &Collected, relation: &Compound, budget: &mut Budget) -> Result<Shells> {
        let mut is_incomplete = false;
        let (mut outer, mut inner): (Members, Members) = Default::default();
        let mut seen = HashSet::new();
        for (Id { number, .. }, role) in &relation.members {
            if !seen.insert(*number) {
                continue;
            }
            match collected.ways.get(number).and_then(|line| collected.places(line)) {
                Some(places) => {
                    budget.take(places.len(), size_of::<[f64; 2]>())?;
                    let list = if *role == Role::Inner { &mut inner } else { &mut outer };
                    list.numbers.push(*number);
                    list.is_outer.push(*role == Role::Outer);
                    list.lines.push(places);
                }
                None => is_incomplete = true,
            }
        }
        let (mut rings, holes) = (outer.joined(&mut is_incomplete), inner.joined(&mut is_incomplete));
        let mut holes: Vec<Vec<[f64; 2]>> = holes.into_iter().map(|ring| ring.points).collect();
        let corners = |rings: &[Ring]| rings.iter().map(|ring| ring.points.len()).sum::<usize>();
        budget.compare(corners(&rings) + holes.iter().map(Vec::len).sum::<usize>(), corners(&rings))?;
        // A ring without a role is a hole if it lies in an odd number of others.
        let is_hole = |k: usize| {
            let ring: &Ring = &rings[k];
            let around = |(j, other): &(usize, &Ring)| *j != k && surrounds(&other.points, &ring.points);
            !ring.lines.iter().any(|line| outer.is_outer[*line])
                && rings.iter().enumerate().filter(around).count() % 2 == 1
        };
        let hole: Vec<bool> = (0..rings.len()).map(is_hole).collect();
        let mut is_a_hole = hole.iter();
        holes.extend(rings.extract_if(.., |_| *is_a_hole.next().unwrap_or(&false)).map(|ring| ring.points));
        let number = |line: &usize| outer.numbers[*line];
        let ways: Vec<Vec<i64>> = rings.iter().map(|ring| ring.lines.iter().map(number).collect()).collect();
        let mut polygons = assembled(rings.into_iter().map(|ring| ring.points).collect(), holes);
        // A hole in no area comes after them.
        is_incomplete |= polygons.len() > ways.len();
        polygons.truncate(ways.len());
        Ok(Shells { polygons, ways, is_incomplete })
    }
}

/// Ways of a relation.
#[derive(Default)]
struct Members {
    numbers: Vec<i64>,
    is_outer: Vec<bool>,
    lines: Vec<Vec<[f64; 2]>>,
}

impl Members {
    /// Returns their rings; sets `is_incomplete` where any of them is part of none.
    fn joined(&self, is_incomplete: &mut bool) -> Vec<Ring> {
        let found = joined(&self.lines.iter().map(Vec::as_slice).collect::<Vec<_>>());
        *is_incomplete |= found.has_loose;
        found.rings
    }
}
