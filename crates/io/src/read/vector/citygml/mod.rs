//! CityGML 1, 2 and 3, and buildings of INSPIRE: buildings and their parts, read as a stream.
//!
//! Only local names of elements count, since each version has namespaces of its own. A polygon
//! belongs to the innermost building or part around it. The nearest `lodN…` tells its level of
//! detail, the nearest surface its meaning. References need no resolving: all surfaces that a solid
//! refers to lie in the same building. What is inside a building, its openings, installations and
//! intersections with the terrain are left out.
//!
//! The highest of the levels 1 to 3 counts, else 4, else 0. A building is made of its parts, if
//! these are more detailed. A file whose envelope does not meet the wanted box is left unread.
//!
//! Positions in degrees are latitude, longitude. In a system whose authority puts the northing
//! first, writers disagree: names of the OGC promise that order, others the easting first. The
//! other order is taken where only it lies in the domain of the system.
//!
//! # References
//! OGC 08-007r1 (1.0), 12-019 (2.0), 20-010 and 21-006r2 (3.0); INSPIRE D2.8.III.2.

mod elements;
mod words;

use std::io::BufReader;
use std::sync::Arc;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::super::height_value::found_height;
use super::super::solid::{Face, FaceKind, Solid};
use super::bounded::Bounded;
use super::cityjson::height_of;
use super::feature::{Feature, FeatureSet, Properties, SolidHeight, bounds, crs_of};
use super::selection::{Selection, meets};
use crate::crs;
use crate::error::{Cause, Error, OddFile, ReadFault, Result, Wanted};
use crate::input::Input;
use crate::raster::{Crs, CrsKind};
use elements::{Element, Elements, Open};
use skyshed_request::HeightUnit;
use words::{LONGEST_BYTES, is_latin, positions, property, resolved};

/// Deepest nesting of elements; real files have some twenty.
const MOST_NESTED: usize = 256;
/// Most attributes of a building, which are looked through for each of its parts; real ones have some
/// hundred.
const MOST_ATTRIBUTES: usize = 500;
/// Levels of detail, from 0.
const N_LEVELS: usize = 5;

/// Reads the buildings of a file.
///
/// # Errors
/// E302 for XML that is broken, and numbers that are none; E305 for an early end; E502 for nesting
/// and texts beyond what a city needs.
pub(super) fn read(input: &Input, selection: Selection<'_>) -> Result<FeatureSet> {
    let (file, _) = input.open()?;
    let mut xml = Reader::from_reader(Bounded::new(BufReader::with_capacity(1 << 16, file), LONGEST_BYTES));
    let mut city = City::new(input);
    let (mut elements, mut text) = (Elements::default(), Vec::new());
    let mut buffer = Vec::new();
    loop {
        buffer.clear();
        xml.get_mut().begin_event();
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
                if city.n_attributes > MOST_ATTRIBUTES {
                    let what =
                        format!("{} attributes of a building, wanted at most {MOST_ATTRIBUTES}", city.n_attributes);
                    return Err(Error::read(input, ReadFault::TooMany(what)));
                }
                if let Some(outside) = city.outside(&mut elements, selection) {
                    return Ok(outside);
                }
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

/// A building or a part of one that is being read.
#[derive(Debug, Default)]
struct Owner {
    id: Option<String>,
    is_part: bool,
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
    /// Most attributes of one of them.
    n_attributes: usize,
}

impl<'a> City<'a> {
    fn new(input: &'a Input) -> Self {
        City { input, system: None, is_latin: false, owners: Vec::new(), features: Vec::new(), n_attributes: 0 }
    }

    /// Returns the content of a file whose envelope, just read, lies outside of what is wanted.
    fn outside(&self, elements: &mut Elements, selection: Selection<'_>) -> Option<FeatureSet> {
        let corners = elements.envelope.take()?;
        let crs = self.crs();
        let named = crs.as_ref().ok().and_then(Option::as_ref);
        let is_swapped = named.is_some_and(|crs| Axes::of(self.system_name(), crs, &corners).is_swapped);
        let order = |[x, y]: [f64; 2]| if is_swapped { [y, x] } else { [x, y] };
        let envelope = bounds(std::iter::once(&vec![corners.into_iter().map(order).collect()]))?;
        let wanted = selection.bounds_in(named)?;
        (!meets(envelope, wanted)).then(|| FeatureSet::outside(crs))
    }

    fn system_name(&self) -> &str {
        self.system.as_deref().unwrap_or_default()
    }

    fn crs(&self) -> Result<Option<Crs>> {
        crs_of(self.input, self.system_name())
    }

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
        for attribute in start.attributes().with_checks(false) {
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
                self.owners.push(Owner { id, is_part: element == Element::Part, ..Owner::default() });
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
            Element::Corner if elements.open.len() == 4 => {
                positions(text, elements.dimension().or(Some(3)), &mut elements.corners)?;
            }
            // The box around all, not that of a building.
            Element::Envelope if elements.open.len() == 3 => {
                let corners = std::mem::take(&mut elements.corners);
                elements.envelope =
                    (corners.len() == 2).then(|| corners.iter().map(|corner| [corner[0], corner[1]]).collect());
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
        self.n_attributes = self.n_attributes.max(owner.properties.len());
        let level = [3, 2, 1, 4, 0].into_iter().find(|level| !owner.faces[*level].is_empty());
        let own = level.map(|level| (level, owner.feature(level)));
        let building = owner.id.clone();
        // Parts of a cadastre stand in a file of their own.
        let of_cadastre = if owner.is_part { cadastral_building(owner.id.as_deref()) } else { None };
        let own = own.map(|(level, own)| (level, Feature { part_of: of_cadastre, ..own }));
        let of_parts = owner.parts.iter().map(|(level, _)| *level).max();
        let is_finest = own.as_ref().is_some_and(|(level, _)| of_parts.is_none_or(|parts| parts <= *level));
        let properties = Arc::new(owner.properties);
        for (level, part) in owner.parts {
            let part_of = part.part_of.or_else(|| building.clone());
            self.keep(
                level,
                Feature { part_of, of_building: part.of_building.or_else(|| Some(Arc::clone(&properties))), ..part },
            );
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
        let crs = self.crs();
        let mut oddity = None;
        let name = self.system.unwrap_or_default();
        let mut features = self.features;
        if let Ok(Some(crs)) = &crs {
            let firsts: Vec<[f64; 2]> =
                features.iter().filter_map(|feature| feature.polygons.first()?.first()?.first().copied()).collect();
            let axes = Axes::of(&name, crs, &firsts);
            if axes.is_swapped {
                features.iter_mut().for_each(Feature::swap_axes);
            }
            oddity = axes.oddity(crs, &firsts);
        }
        Ok(FeatureSet { crs, features, oddity, ..FeatureSet::default() })
    }
}

impl Owner {
    /// Returns the feature of a level of detail.
    fn feature(&mut self, level: usize) -> Feature {
        let solid = Solid::of(std::mem::take(&mut self.faces[level]));
        let measured = self.properties.iter().find(|(name, _)| **name == *"measuredHeight").map(|(_, value)| value);
        let (id, properties) = (self.id.clone(), self.properties.clone());
        if self.is_plane {
            let height = measured.and_then(|value| found_height(value, HeightUnit::Meters).meters());
            let height = height.filter(|m| *m > 0.0).map(SolidHeight::Measured);
            return Feature { id, height, properties, polygons: solid.polygons, ..Feature::default() };
        }
        #[expect(clippy::cast_precision_loss, reason = "0 to 4")]
        let height = height_of(measured, level as f64, solid.heights);
        Feature { id, height, properties, ..Feature::of_solid(solid) }
    }
}

/// Returns the building of a part of a Spanish cadastre, whose id ends in `_part` and a number.
fn cadastral_building(part: Option<&str>) -> Option<String> {
    let (building, number) = part?.rsplit_once("_part")?;
    (!number.is_empty() && number.bytes().all(|b| b.is_ascii_digit())).then(|| building.to_string())
}

/// Order of the numbers of a position.
#[derive(Debug, Clone, Copy)]
struct Axes {
    /// `true` if latitude or northing come first.
    is_swapped: bool,
    /// `true` if another writer would mean the other order by the same name.
    is_disputed: bool,
}

impl Axes {
    /// Determines the order of the numbers of some positions by the name of their system.
    fn of(name: &str, crs: &Crs, some: &[[f64; 2]]) -> Axes {
        if matches!(crs.kind(), CrsKind::Geographic) {
            let is_named_so = name.contains("CRS84") || name.contains("adv:");
            let can_be = some.iter().all(|[first, _]| first.abs() <= 90.0);
            return Axes { is_swapped: !is_named_so && can_be, is_disputed: false };
        }
        let is_disputed = !name.contains("adv:") && crs::is_north_first(crs);
        // Writers of the compound form, `urn:ogc:def:crs,crs:EPSG:…`, mean the easting first.
        let is_formal = name.starts_with("urn:ogc:def:crs:") || name.starts_with("http");
        let can_be = |is_swapped: bool| {
            some.first().is_none_or(|&[x, y]| crs::is_in_domain(crs, if is_swapped { (y, x) } else { (x, y) }))
        };
        let promised = is_disputed && is_formal;
        let is_swapped = if can_be(promised) || !can_be(!promised) { promised } else { !promised };
        Axes { is_swapped: is_swapped && is_disputed, is_disputed }
    }

    /// Returns the oddity of an order that writers disagree about.
    fn oddity(self, crs: &Crs, some: &[[f64; 2]]) -> Option<OddFile> {
        let first = *some.first().filter(|_| self.is_disputed)?;
        Some(OddFile::NorthFirst { system: crs.label(), is_swapped: self.is_swapped, first })
    }
}
