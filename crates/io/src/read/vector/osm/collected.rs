//! Elements that buildings are made of, out of all elements of a file.

use std::collections::{BTreeMap, HashSet};
use std::mem::size_of;
use std::sync::Arc;

use super::super::feature::{Properties, Property, malformed};
use super::{Budget, Element, Encoding, Id, Kind, Member, NOWHERE, Node, Relation, Role, Tags, Way};
use crate::error::{Error, ReadFault, Result};
use crate::input::Input;

/// Most nodes of a way and members of a relation. The servers of OpenStreetMap accept 2000 and
/// 32 000.
pub(super) const MOST_REFERENCES: usize = 100_000;
/// Keys of areas that are no buildings, whatever ways they share with buildings.
const OTHER_AREAS: [&str; 9] =
    ["area:highway", "barrier", "boundary", "highway", "landuse", "leisure", "natural", "place", "waterway"];
/// Memory of an element in a map, about \[bytes\].
const BYTES_EACH: usize = 200;

/// Elements that buildings are made of.
#[derive(Debug, Default)]
pub(super) struct Collected {
    pub(super) relations: BTreeMap<i64, Compound>,
    pub(super) ways: BTreeMap<i64, Line>,
    nodes: Places,
}

/// A relation.
#[derive(Debug)]
pub(super) struct Compound {
    pub(super) kind: CompoundKind,
    pub(super) tags: Properties,
    pub(super) members: Vec<(Id, Role)>,
}

/// Kind of a relation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum CompoundKind {
    /// Area that its own tags make a building.
    Area,
    /// Area that is a building if the tags of its outer ways say so.
    AreaOfWays,
    /// A building with its parts.
    Building,
}

/// A way.
#[derive(Debug, Default)]
pub(super) struct Line {
    /// Its tags, if it is a building or a part of one; none for any other way.
    pub(super) tags: Properties,
    nodes: Vec<i64>,
    places: Vec<[f64; 2]>,
}

/// Places of nodes, sorted by number.
#[derive(Debug, Default)]
struct Places {
    numbers: Vec<i64>,
    places: Vec<[f64; 2]>,
}

impl Collected {
    /// Collects the elements of buildings.
    ///
    /// # Errors
    /// Faults of the file; E502 for more than it should hold.
    pub(super) fn of(input: &Input, file: &mut dyn Encoding, budget: &mut Budget) -> Result<Collected> {
        let mut collecting =
            Collecting { input, budget, names: HashSet::new(), named: HashSet::new(), found: Collected::default() };
        file.visit(Kind::Relation, &mut |element| match element {
            Element::Relation(relation) => collecting.relation(relation),
            _ => Ok(()),
        })?;
        file.visit(Kind::Way, &mut |element| match element {
            Element::Way(way) => collecting.way(way),
            _ => Ok(()),
        })?;
        let lines = || collecting.found.ways.values().filter(|line| line.places.is_empty());
        let mut numbers: Vec<i64> = lines().flat_map(|line| &line.nodes).copied().collect();
        numbers.sort_unstable();
        numbers.dedup();
        collecting.found.nodes = Places { places: vec![NOWHERE; numbers.len()], numbers };
        file.visit(Kind::Node, &mut |element| match element {
            Element::Node(node) => collecting.node(node),
            _ => Ok(()),
        })?;
        Ok(collecting.found)
    }

    /// Returns the places of a way; `None` where any is missing.
    pub(super) fn places(&self, line: &Line) -> Option<Vec<[f64; 2]>> {
        let places: Vec<[f64; 2]> = match line.places.is_empty() {
            true => line.nodes.iter().map(|number| self.nodes.of(*number)).collect::<Option<_>>()?,
            false => line.places.clone(),
        };
        let is_whole = places.len() > 1 && places.iter().flatten().all(|v| v.is_finite());
        is_whole.then_some(places)
    }
}

impl Places {
    fn of(&self, number: i64) -> Option<[f64; 2]> {
        self.numbers.binary_search(&number).ok().map(|k| self.places[k])
    }
}

/// Elements found so far.
struct Collecting<'a> {
    input: &'a Input,
    budget: &'a mut Budget,
    /// Keys of tags.
    names: HashSet<Arc<str>>,
    /// Ways that relations name as outlines and parts.
    named: HashSet<i64>,
    found: Collected,
}

impl Collecting<'_> {
    /// Keeps a relation that is a building, or that may be one by the tags of its ways.
    fn relation(&mut self, relation: Relation<'_>) -> Result<()> {
        let Relation { number, tags, members } = relation;
        let id = Id { kind: Kind::Relation, number };
        let kind = match tags.iter().find(|(key, _)| key == "type").map(|(_, value)| &**value) {
            Some("building") => CompoundKind::Building,
            Some("multipolygon") if is_building(&tags) => CompoundKind::Area,
            Some("multipolygon") if !tags.iter().any(|(key, _)| OTHER_AREAS.contains(&&**key)) => {
                CompoundKind::AreaOfWays
            }
            _ => return Ok(()),
        };
        self.check_number(id, members.len(), "members")?;
        self.budget.take(1, BYTES_EACH)?;
        let tags = self.properties(tags)?;
        let mut kept = Vec::new();
        for Member { id, role, places } in members {
            let is_wanted = match (kind, id.kind) {
                (_, Kind::Node) => false,
                (CompoundKind::Building, _) => matches!(role, Role::Outline | Role::Part),
                // An area of areas is none.
                (_, kind) => kind == Kind::Way,
            };
            if !is_wanted {
                continue;
            }
            self.budget.take(1, size_of::<(Id, Role)>())?;
            kept.push((id, role));
            if id.kind == Kind::Way {
                self.line(id.number, Vec::new(), places)?;
                if kind == CompoundKind::Building {
                    self.named.insert(id.number);
                }
            }
        }
        self.found.relations.entry(number).or_insert(Compound { kind, tags, members: kept });
        Ok(())
    }

    /// Keeps a way that is a building, or that a relation needs.
    fn way(&mut self, way: Way<'_>) -> Result<()> {
        let Way { number, tags, nodes, places } = way;
        let is_building = is_building(&tags) || self.named.contains(&number);
        if !is_building && !self.found.ways.contains_key(&number) {
            return Ok(());
        }
        self.line(number, nodes, places)?;
        if is_building {
            let tags = self.properties(tags)?;
            self.found.ways.entry(number).or_default().tags = tags;
        }
        Ok(())
    }

    /// Keeps the line of a way. It may stand in the file several times, with less or more.
    fn line(&mut self, number: i64, nodes: Vec<i64>, places: Vec<[f64; 2]>) -> Result<()> {
        let id = Id { kind: Kind::Way, number };
        self.check_number(id, nodes.len().max(places.len()), "nodes")?;
        places.iter().try_for_each(|place| self.check_place(id, *place))?;
        let is_new = !self.found.ways.contains_key(&number);
        self.budget.take(usize::from(is_new), BYTES_EACH)?;
        // The number of each node, and its number and place among the others.
        self.budget.take(nodes.len(), 2 * size_of::<i64>() + size_of::<[f64; 2]>())?;
        self.budget.take(places.len(), size_of::<[f64; 2]>())?;
        let line = self.found.ways.entry(number).or_default();
        if line.nodes.is_empty() {
            line.nodes = nodes;
        }
        if line.places.is_empty() {
            line.places = places;
        }
        Ok(())
    }

    /// Keeps the place of a node that a way needs.
    fn node(&mut self, Node { number, place }: Node) -> Result<()> {
        if let Ok(k) = self.found.nodes.numbers.binary_search(&number) {
            self.check_place(Id { kind: Kind::Node, number }, place)?;
            self.found.nodes.places[k] = place;
        }
        Ok(())
    }

    /// Converts tags to properties, in the order of their keys.
    fn properties(&mut self, mut tags: Tags<'_>) -> Result<Properties> {
        tags.sort();
        tags.dedup_by(|one, other| one.0 == other.0);
        let mut properties = Vec::with_capacity(tags.len());
        for (key, value) in tags {
            self.budget.take(1, size_of::<(Arc<str>, Property)>() + value.len())?;
            let name = match self.names.get(&*key) {
                Some(name) => Arc::clone(name),
                None => {
                    self.budget.take(1, BYTES_EACH + key.len())?;
                    let name: Arc<str> = (&*key).into();
                    self.names.insert(Arc::clone(&name));
                    name
                }
            };
            properties.push((name, Property::Text(value.into_owned())));
        }
        Ok(properties)
    }

    fn check_number(&self, id: Id, n: usize, of: &str) -> Result<()> {
        if n > MOST_REFERENCES {
            let what = format!("{id} has {n} {of}, wanted at most {MOST_REFERENCES}");
            return Err(Error::read(self.input, ReadFault::TooMany(what)));
        }
        Ok(())
    }

    /// Checks the place of a node, or of a node of a way.
    fn check_place(&self, id: Id, [lon, lat]: [f64; 2]) -> Result<()> {
        if lon.abs() > 180.0 || lat.abs() > 90.0 {
            let found = format!("{id} lies at longitude {lon} and latitude {lat}");
            return Err(malformed(self.input, &found, "degrees"));
        }
        Ok(())
    }
}

/// Returns `true` for the tags of a building or of a part of one.
fn is_building(tags: &Tags<'_>) -> bool {
    tags.iter().any(|(key, _)| key == "building" || key == "building:part")
}
