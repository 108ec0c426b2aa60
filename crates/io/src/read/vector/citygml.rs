//! CityGML 1, 2 and 3, and buildings of INSPIRE: buildings and their parts, read as a stream.
//!
//! Only local names of elements count, since each version has namespaces of its own. A polygon
//! belongs to the innermost building or part around it. The nearest `lodN…` tells its level of
//! detail, the nearest surface its meaning. References need no resolving: all surfaces that a solid
//! refers to lie in the same building. What is inside a building, its openings, installations and
//! intersections with the terrain are left out.
//!
//! The highest of the levels 1 to 3 counts, else 4, else 0. A building is made of its parts, if
//! these are more detailed.
//!
//! # References
//! OGC 08-007r1 (1.0), 12-019 (2.0), 20-010 and 21-006r2 (3.0); INSPIRE D2.8.III.2.

use std::io::{BufRead, BufReader, Read};
use std::sync::Arc;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::super::solid::{Face, FaceKind, Solid};
use super::cityjson::height_of;
use super::feature::{Feature, FeatureSet, Properties, Property};
use crate::crs;
use crate::error::{Cause, Error, ReadFault, Result, Wanted};
use crate::input::Input;
use crate::raster::{Crs, CrsKind};

/// Deepest nesting of elements; real files have some twenty.
const MOST_NESTED: usize = 256;
/// Longest tag or text \[bytes\]; a ring of a million corners takes as much.
const LONGEST_BYTES: usize = 64 << 20;
/// Levels of detail, from 0.
const N_LEVELS: usize = 5;

/// Reads the buildings of a file.
///
/// # Errors
/// E302 for XML that is broken, and numbers that are none; E305 for an early end; E502 for nesting
/// and texts beyond what a city needs.
pub(super) fn read(input: &Input) -> Result<FeatureSet> {
    let (file, _) = input.open()?;
    let mut xml = Reader::from_reader(Bounded { inner: BufReader::with_capacity(1 << 16, file), left: LONGEST_BYTES });
    let mut city = City { input, system: None, is_latin: false, owners: Vec::new(), features: Vec::new() };
    let (mut elements, mut text) = (Elements::default(), Vec::new());
    let mut buffer = Vec::new();
    loop {
        buffer.clear();
        xml.get_mut().left = LONGEST_BYTES;
        let at = xml.buffer_position();
        let failed = |error: &dyn std::fmt::Display| city_error(input, at, error);
        match xml.read_event_into(&mut buffer).map_err(|e| failed(&e))? {
            Event::Start(start) => {
                text.clear();
                city.enter(&mut elements, &start).map_err(|found| failed(&found))?;
                if elements.open.len() > MOST_NESTED {
                    let what = format!("elements nested more than {MOST_NESTED} deep, wanted CityGML");
                    return Err(Error::read(input, ReadFault::TooMany(what)));
                }
            }
            Event::Empty(start) => {
                text.clear();
                city.enter(&mut elements, &start).map_err(|found| failed(&found))?;
                city.leave(&mut elements, "").map_err(|found| failed(&found))?;
            }
            Event::Text(part) => append(&mut text, &part, elements.holds_text()),
            Event::CData(part) => append(&mut text, &part, elements.holds_text()),
            Event::GeneralRef(name) if elements.holds_text() => {
                text.extend(resolved(&name).unwrap_or_default().bytes());
            }
            Event::End(_) => {
                let words = city.decoded(&text);
                city.leave(&mut elements, &words).map_err(|found| failed(&found))?;
                text.clear();
            }
            Event::Decl(decl) => {
                city.is_latin = decl.encoding().is_some_and(|name| is_latin(name.as_deref().unwrap_or_default()))
            }
            Event::Eof => break,
            _ => {}
        }
    }
    if !elements.open.is_empty() {
        return Err(Error::truncated(input, "it ends inside of an element").because(Cause::CutShort));
    }
    city.set()
}

/// Returns E302 at a byte of a file.
fn city_error(input: &Input, at: u64, found: &dyn std::fmt::Display) -> Error {
    Error::malformed(input, format!("at byte {at}: {found}, wanted CityGML"))
}

fn append(text: &mut Vec<u8>, part: &[u8], is_wanted: bool) {
    if is_wanted {
        text.extend_from_slice(part);
    }
}

/// Returns the character of a reference; entities of the file are not expanded.
fn resolved(name: &[u8]) -> Option<String> {
    let name = std::str::from_utf8(name).ok()?;
    if let Some(number) = name.strip_prefix('#') {
        let code = match number.strip_prefix('x') {
            Some(digits) => u32::from_str_radix(digits, 16).ok()?,
            None => number.parse().ok()?,
        };
        return char::from_u32(code).map(String::from);
    }
    let known = [("amp", "&"), ("lt", "<"), ("gt", ">"), ("quot", "\""), ("apos", "'")];
    known.iter().find(|(known, _)| *known == name).map(|(_, text)| (*text).to_string())
}

/// Returns `true` for the encodings whose bytes are the first 256 characters.
fn is_latin(name: &[u8]) -> bool {
    [&b"iso-8859-1"[..], b"latin1", b"iso-8859-15", b"windows-1252"]
        .iter()
        .any(|known| name.eq_ignore_ascii_case(known))
}

/// Reader that refuses to go on without an event.
struct Bounded<R> {
    inner: R,
    /// Bytes that may be read until the next event.
    left: usize,
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        self.inner.read(bytes)
    }
}

impl<R: BufRead> BufRead for Bounded<R> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        if self.left == 0 {
            return Err(std::io::Error::other(format!("a tag or text of more than {} MiB", LONGEST_BYTES >> 20)));
        }
        self.inner.fill_buf()
    }

    fn consume(&mut self, n: usize) {
        self.left = self.left.saturating_sub(n);
        self.inner.consume(n);
    }
}

/// Meaning of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Element {
    Building,
    /// Part of a building, or a building of a cadastre's floors.
    Part,
    /// A geometry of a level of detail.
    Level(usize),
    /// A surface with a meaning.
    Surface(FaceKind),
    /// Something that is not seen from outside, and all in it.
    Hidden,
    Polygon,
    Ring,
    Positions,
    /// A generic attribute.
    Attribute,
    /// The value of a generic attribute, or of a height.
    Value,
    /// The name of a generic attribute.
    Name,
    /// A height of version 3.
    Height,
    Other,
}

impl Element {
    /// Returns the meaning of an element by its local name.
    fn of(name: &[u8]) -> Element {
        match name {
            b"Building" => Element::Building,
            b"BuildingPart" => Element::Part,
            b"RoofSurface" | b"OuterFloorSurface" => Element::Surface(FaceKind::Roof),
            b"GroundSurface" => Element::Surface(FaceKind::Ground),
            b"WallSurface" | b"OuterCeilingSurface" | b"ClosureSurface" => Element::Surface(FaceKind::Other),
            b"Polygon" | b"Triangle" | b"Rectangle" | b"PolygonPatch" => Element::Polygon,
            b"LinearRing" => Element::Ring,
            b"posList" | b"pos" | b"coordinates" => Element::Positions,
            b"Height" => Element::Height,
            b"value" => Element::Value,
            b"name" => Element::Name,
            b"appearance"
            | b"appearanceMember"
            | b"Appearance"
            | b"opening"
            | b"fillingSurface"
            | b"Door"
            | b"Window"
            | b"address"
            | b"geometry2DWithLevel"
            | b"IntBuildingInstallation"
            | b"BuildingInstallation"
            | b"BuildingFurniture"
            | b"Room"
            | b"BuildingRoom"
            | b"Storey"
            | b"BuildingUnit"
            | b"InteriorWallSurface"
            | b"CeilingSurface"
            | b"FloorSurface" => Element::Hidden,
            _ if name.ends_with(b"TerrainIntersection") || name.starts_with(b"terrainIntersection") => Element::Hidden,
            _ if name.ends_with(b"Attribute") => Element::Attribute,
            [b'l', b'o', b'd', digit @ b'0'..=b'4', ..] => Element::Level(usize::from(digit - b'0')),
            // INSPIRE has one level, of outlines.
            b"geometry" => Element::Level(0),
            _ => Element::Other,
        }
    }
}

/// Elements around the current place.
#[derive(Debug, Default)]
struct Elements {
    open: Vec<Open>,
    n_hidden: usize,
    /// Rings of the current polygon.
    rings: Option<Vec<Vec<[f64; 3]>>>,
    ring: Option<Vec<[f64; 3]>>,
    /// `true` if the current polygon has positions without a height.
    is_plane: bool,
    /// Name of the current generic attribute.
    name: Option<String>,
}

/// An element that is open.
#[derive(Debug)]
struct Open {
    element: Element,
    /// Numbers of a position, where the element says so.
    dimension: Option<usize>,
    /// Local name of what may be a property.
    name: Option<Arc<str>>,
    /// Length of its unit \[m\].
    unit_m: f64,
}

impl Elements {
    /// Returns `true` where text matters.
    fn holds_text(&self) -> bool {
        self.n_hidden == 0
            && self.open.last().is_some_and(|open| {
                let is_known = [Element::Positions, Element::Value, Element::Name].contains(&open.element);
                is_known || open.name.is_some()
            })
    }

    /// Returns the innermost element but one, the parent of the current one.
    fn parent(&self) -> Option<&Open> {
        self.open.len().checked_sub(2).map(|k| &self.open[k])
    }

    /// Returns the level of detail and the meaning of the current polygon.
    fn place(&self) -> Option<(usize, FaceKind)> {
        let around = || self.open.iter().rev().map(|open| open.element);
        let level =
            around().find_map(|element| if let Element::Level(level) = element { Some(level) } else { None })?;
        let kind = around().find_map(|element| if let Element::Surface(kind) = element { Some(kind) } else { None });
        Some((level, kind.unwrap_or(FaceKind::Unknown)))
    }

    /// Returns the number of coordinates of a position that the elements around it tell.
    fn dimension(&self) -> Option<usize> {
        self.open.iter().rev().find_map(|open| open.dimension)
    }
}

/// A building or a part of one that is being read.
#[derive(Debug, Default)]
struct Owner {
    id: Option<String>,
    properties: Properties,
    /// Surfaces by level of detail.
    faces: [Vec<(Face, FaceKind)>; N_LEVELS],
    /// `true` if it has polygons without heights.
    is_plane: bool,
    /// Parts with their levels of detail.
    parts: Vec<(usize, Feature)>,
}

/// City that is being read.
struct City<'a> {
    input: &'a Input,
    /// Name of the reference system.
    system: Option<String>,
    /// `true` if bytes are characters.
    is_latin: bool,
    /// Buildings and parts around the current place.
    owners: Vec<Owner>,
    features: Vec<Feature>,
}

impl City<'_> {
    /// Returns bytes as text in the encoding of the file.
    fn decoded(&self, bytes: &[u8]) -> String {
        match std::str::from_utf8(bytes) {
            Ok(text) if !self.is_latin || text.is_ascii() => text.to_string(),
            _ if self.is_latin => bytes.iter().map(|byte| char::from(*byte)).collect(),
            _ => String::from_utf8_lossy(bytes).into_owned(),
        }
    }

    /// Begins an element.
    fn enter(&mut self, elements: &mut Elements, start: &BytesStart<'_>) -> std::result::Result<(), String> {
        let local = start.local_name();
        let element = Element::of(local.as_ref());
        let parent = elements.open.last().map(|open| open.element);
        let mut open = Open { element, dimension: None, name: None, unit_m: 1.0 };
        let mut id = None;
        for attribute in start.attributes() {
            let attribute = attribute.map_err(|e| e.to_string())?;
            match attribute.key.local_name().as_ref() {
                b"id" if matches!(element, Element::Building | Element::Part) => {
                    id = Some(self.decoded(&attribute.value))
                }
                b"srsName" => self.see_system(&attribute.value)?,
                b"srsDimension" | b"dimension" => {
                    open.dimension = self.decoded(&attribute.value).trim().parse().ok().filter(|d| [2, 3].contains(d));
                }
                b"uom" => {
                    let unit = self.decoded(&attribute.value).to_lowercase();
                    open.unit_m = if unit.ends_with("ft") || unit.contains("foot") { 0.3048 } else { 1.0 };
                }
                b"name" if element == Element::Attribute => elements.name = Some(self.decoded(&attribute.value)),
                _ => {}
            }
        }
        match element {
            Element::Building | Element::Part if elements.n_hidden == 0 => {
                self.owners.push(Owner { id, ..Owner::default() });
            }
            Element::Polygon => {
                elements.rings = Some(Vec::new());
                elements.is_plane = false;
            }
            Element::Ring if elements.rings.is_some() => elements.ring = Some(Vec::new()),
            Element::Hidden => elements.n_hidden += 1,
            Element::Other | Element::Name if matches!(parent, Some(Element::Building | Element::Part)) => {
                open.name = Some(self.decoded(local.as_ref()).into());
            }
            _ => {}
        }
        elements.open.push(open);
        Ok(())
    }

    /// Notes the name of a reference system.
    fn see_system(&mut self, name: &[u8]) -> std::result::Result<(), String> {
        let name = self.decoded(name);
        match &self.system {
            None => self.system = Some(name),
            Some(known) if *known == name => {}
            Some(known) => {
                let differ = crs::parse(known).ok().zip(crs::parse(&name).ok());
                if differ.is_some_and(|(one, other)| crs::contradicts(&one, &other)) {
                    return Err(format!("geometries in `{name}` beside others in `{known}`"));
                }
            }
        }
        Ok(())
    }

    /// Ends the current element, which holds some text.
    fn leave(&mut self, elements: &mut Elements, text: &str) -> std::result::Result<(), String> {
        let Some(open) = elements.open.last() else { return Ok(()) };
        match open.element {
            Element::Hidden => elements.n_hidden -= 1,
            _ if elements.n_hidden > 0 => {}
            Element::Positions if elements.ring.is_some() => {
                let plane = positions(text, elements.dimension(), elements.ring.get_or_insert_default())?;
                elements.is_plane |= plane;
            }
            Element::Ring => {
                if let (Some(mut ring), Some(rings)) = (elements.ring.take(), elements.rings.as_mut()) {
                    if ring.len() > 1 && ring.first() == ring.last() {
                        ring.pop();
                    }
                    rings.push(ring);
                }
            }
            Element::Polygon => {
                let face = elements.rings.take().filter(|face| !face.is_empty());
                if let (Some(owner), Some(face), Some((level, kind))) = (self.owners.last_mut(), face, elements.place())
                {
                    owner.faces[level].push((face, kind));
                    owner.is_plane |= elements.is_plane;
                }
            }
            Element::Name if elements.parent().is_some_and(|parent| parent.element == Element::Attribute) => {
                elements.name = Some(text.trim().to_string());
            }
            Element::Value => self.see_value(elements, text),
            Element::Building | Element::Part => self.end_owner(),
            _ => {
                if let (Some(name), Some(owner)) = (&open.name, self.owners.last_mut())
                    && !text.trim().is_empty()
                {
                    owner.properties.push((Arc::clone(name), property(text, open.unit_m)));
                }
            }
        }
        elements.open.pop();
        Ok(())
    }

    /// Notes the value of a generic attribute, or of a height.
    fn see_value(&mut self, elements: &mut Elements, text: &str) {
        let (Some(owner), Some(open)) = (self.owners.last_mut(), elements.open.last()) else { return };
        let name: Option<Arc<str>> = match elements.parent().map(|parent| parent.element) {
            Some(Element::Height) => Some("measuredHeight".into()),
            Some(Element::Attribute) => elements.name.take().map(Into::into),
            _ => None,
        };
        if let Some(name) = name {
            owner.properties.push((name, property(text, open.unit_m)));
        }
    }

    /// Ends a building or a part.
    fn end_owner(&mut self) {
        let Some(mut owner) = self.owners.pop() else { return };
        let level = [3, 2, 1, 4, 0].into_iter().find(|level| !owner.faces[*level].is_empty());
        let own = level.map(|level| (level, owner.feature(level)));
        let building = owner.id.clone();
        let of_parts = owner.parts.iter().map(|(level, _)| *level).max();
        let is_finest = own.as_ref().is_some_and(|(level, _)| of_parts.is_none_or(|parts| parts <= *level));
        for (level, part) in owner.parts {
            let mut part = Feature { part_of: part.part_of.or_else(|| building.clone()), ..part };
            // A part has the attributes of its building, except those of its own.
            for (name, value) in &owner.properties {
                if part.properties.iter().all(|(known, _)| known != name) {
                    part.properties.push((Arc::clone(name), value.clone()));
                }
            }
            self.keep(level, part);
        }
        if let Some((level, own)) = own.filter(|_| is_finest) {
            self.keep(level, own);
        }
    }

    /// Hands a feature to the building around it, or to the city.
    fn keep(&mut self, level: usize, feature: Feature) {
        match self.owners.last_mut() {
            Some(owner) => owner.parts.push((level, feature)),
            None => self.features.push(feature),
        }
    }

    /// Returns all buildings, east before north.
    fn set(self) -> Result<FeatureSet> {
        if self.features.is_empty() {
            return Err(Error::read(self.input, ReadFault::Nothing(Wanted::Building)));
        }
        let mut features = self.features;
        let name = self.system.unwrap_or_default();
        let crs = super::feature::crs_of(self.input, &name);
        if let Ok(Some(crs)) = &crs
            && is_north_first(&name, crs, &features)
        {
            features.iter_mut().for_each(swap);
        }
        Ok(FeatureSet { crs, name: None, attribution: None, name_limit: None, features })
    }
}

impl Owner {
    /// Returns the feature of a level of detail.
    fn feature(&mut self, level: usize) -> Feature {
        let solid = Solid::of(std::mem::take(&mut self.faces[level]));
        let measured = self.properties.iter().find(|(name, _)| **name == *"measuredHeight").map(|(_, value)| value);
        let (id, properties) = (self.id.clone(), self.properties.clone());
        if self.is_plane {
            return Feature { id, properties, polygons: solid.polygons, ..Feature::default() };
        }
        #[expect(clippy::cast_precision_loss, reason = "0 to 4")]
        let height = height_of(measured, level as f64, solid.heights);
        Feature { id, height, properties, ..Feature::of_solid(solid) }
    }
}

/// Appends positions of a text to a ring. Returns `true` if they have no heights.
fn positions(text: &str, dimension: Option<usize>, ring: &mut Vec<[f64; 3]>) -> std::result::Result<bool, String> {
    let words = || text.split(|c: char| c.is_ascii_whitespace() || c == ',').filter(|word| !word.is_empty());
    let n = words().count();
    // Some writers leave out that positions have three numbers, or two.
    let dimension = dimension.filter(|d| n % d == 0).unwrap_or(if n % 3 == 0 { 3 } else { 2 });
    if n % dimension != 0 {
        return Err(format!("{n} numbers of positions"));
    }
    let (mut position, mut k) = ([0.0; 3], 0);
    for word in words() {
        let number: f64 = word.parse().map_err(|_| format!("`{word}` in positions"))?;
        if !number.is_finite() {
            return Err(format!("`{word}` in positions"));
        }
        position[k] = number;
        k += 1;
        if k == dimension {
            ring.push(position);
            k = 0;
        }
    }
    Ok(dimension == 2)
}

/// Returns a text as a property: a number \[m\] where it is one.
fn property(text: &str, unit_m: f64) -> Property {
    let text = text.trim();
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Property::Number(number * unit_m),
        _ => Property::Text(text.to_string()),
    }
}

/// Returns `true` where positions are latitude and longitude. Names of surveys, and CRS84, have the
/// easting first.
fn is_north_first(name: &str, crs: &Crs, features: &[Feature]) -> bool {
    let is_geographic = matches!(crs.kind(), CrsKind::Geographic);
    let firsts = || features.iter().flat_map(|feature| feature.polygons.iter().flatten().flatten()).map(|p| p[0]);
    is_geographic && !name.contains("CRS84") && !name.contains("adv:") && firsts().all(|first| first.abs() <= 90.0)
}

/// Exchanges the axes of a feature.
fn swap(feature: &mut Feature) {
    for [x, y] in feature.polygons.iter_mut().chain(&mut feature.ground).flatten().flatten() {
        std::mem::swap(x, y);
    }
    for [x, y, _] in feature.roof.iter_mut().flatten().flatten() {
        std::mem::swap(x, y);
    }
}
