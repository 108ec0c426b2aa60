//! XML of OpenStreetMap, of its editors and of the Overpass API, read as a stream.

use std::io::{BufReader, Seek, SeekFrom};

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader as XmlReader, XmlVersion};

use super::super::bounded::Bounded;
use super::super::feature::malformed;
use super::collected::MOST_REFERENCES;
use super::overpass::check_remark;
use super::{Element, Encoding, Id, Kind, Member, NOWHERE, Node, Relation, Role, Visitor, Way};
use crate::error::{Cause, Error, MOST_FOUND, ReadFault, Result, shortened};
use crate::input::{Input, Reader, cannot_read};

/// Deepest nesting of elements; real files have four.
const MOST_NESTED: usize = 16;
/// Longest tag or text \[bytes\].
const LONGEST_BYTES: usize = 1 << 20;

/// XML of a file.
pub(super) struct Xml<'a> {
    pub(super) input: &'a Input,
    pub(super) file: Reader,
}

impl Encoding for Xml<'_> {
    fn visit(&mut self, kind: Kind, each: Visitor<'_>) -> Result<()> {
        let input = self.input;
        self.file.seek(SeekFrom::Start(0)).map_err(|e| cannot_read(input, &e))?;
        let inner = BufReader::with_capacity(1 << 16, &mut self.file);
        let mut xml = XmlReader::from_reader(Bounded::new(inner, LONGEST_BYTES));
        let mut reading = Reading { input, kind, current: None, remark: None, depth: 0 };
        let (mut buffer, mut is_osm) = (Vec::new(), false);
        loop {
            buffer.clear();
            xml.get_mut().begin_event();
            let at = xml.buffer_position();
            let failed = |error: String| {
                let found = format!("at byte {at}: {}", shortened(&error, MOST_FOUND));
                malformed(input, &found, "XML of OpenStreetMap")
            };
            match xml.read_event_into(&mut buffer).map_err(|e| parser_error(input, &e, at))? {
                Event::Start(start) => {
                    is_osm |= start.name().as_ref() == b"osm";
                    reading.enter(&start).map_err(failed)?;
                    reading.depth += 1;
                    if reading.depth > MOST_NESTED {
                        let what = format!("elements nested more than {MOST_NESTED} deep, wanted XML of OpenStreetMap");
                        return Err(Error::read(input, ReadFault::TooMany(what)));
                    }
                }
                Event::Empty(start) => {
                    is_osm |= start.name().as_ref() == b"osm";
                    reading.enter(&start).map_err(failed)?;
                    reading.leave(start.name().as_ref(), each)?;
                }
                Event::Text(text) => {
                    if let Some(remark) = &mut reading.remark {
                        remark.push_str(&String::from_utf8_lossy(&text));
                    }
                }
                Event::End(end) => {
                    reading.depth = reading.depth.saturating_sub(1);
                    reading.leave(end.name().as_ref(), each)?;
                }
                Event::Eof => break,
                _ => {}
            }
        }
        if reading.depth > 0 {
            return Err(Error::truncated(input, "it ends inside of an element").because(Cause::CutShort));
        }
        if !is_osm {
            return Err(malformed(input, "no element `osm`", "XML of OpenStreetMap"));
        }
        Ok(())
    }
}

/// Returns the error of the parser: E303 at the end of the file, else E302.
fn parser_error(input: &Input, error: &quick_xml::Error, at: u64) -> Error {
    match error {
        // The end of the file inside of a tag.
        quick_xml::Error::Syntax(_) => {
            Error::truncated(input, format!("at byte {at}: {error}")).because(Cause::CutShort)
        }
        _ => {
            let found = format!("at byte {at}: {}", shortened(&error.to_string(), MOST_FOUND));
            malformed(input, &found, "XML of OpenStreetMap")
        }
    }
}

/// Elements of one kind that are being read.
struct Reading<'a> {
    input: &'a Input,
    kind: Kind,
    current: Option<Element<'static>>,
    /// Remark of a server.
    remark: Option<String>,
    depth: usize,
}

impl Reading<'_> {
    /// Begins an element of XML.
    fn enter(&mut self, start: &BytesStart<'_>) -> std::result::Result<(), String> {
        let name = start.name();
        let name = name.as_ref();
        if name == b"remark" {
            self.remark = Some(String::new());
        }
        if let Some(kind) = Kind::of(name) {
            // One that an editor has removed, or that a history holds no more.
            let is_gone = || -> std::result::Result<bool, String> {
                let is = |name: &str, value: &str| Ok::<_, String>(text(start, name)?.is_some_and(|of| of == value));
                Ok(is("action", "delete")? || is("visible", "false")?)
            };
            if kind == self.kind && !is_gone()? {
                self.current = Some(begun(kind, start)?);
            }
            return Ok(());
        }
        match (name, &mut self.current) {
            (b"tag", Some(Element::Way(Way { tags, .. }) | Element::Relation(Relation { tags, .. }))) => {
                let tag = text(start, "k")?.zip(text(start, "v")?).ok_or("a tag without `k` or `v`")?;
                tags.push((tag.0.into(), tag.1.into()));
            }
            (b"nd", Some(Element::Way(way))) => {
                way.nodes.push(number(start, "ref")?.ok_or("a node of a way without `ref`")?);
                let place = place_of(start)?;
                if place.is_some() || !way.places.is_empty() {
                    way.places.resize(way.nodes.len() - 1, NOWHERE);
                    way.places.push(place.unwrap_or(NOWHERE));
                }
            }
            (b"member", Some(Element::Relation(relation))) => {
                let kind = text(start, "type")?.and_then(|kind| Kind::of(kind.as_bytes()));
                let kind = kind.ok_or("a member without a known `type`")?;
                let number = number(start, "ref")?.ok_or("a member without `ref`")?;
                let role = Role::of(&text(start, "role")?.unwrap_or_default());
                relation.members.push(Member { id: Id { kind, number }, role, places: Vec::new() });
            }
            (b"nd", Some(Element::Relation(relation))) => {
                if let Some(member) = relation.members.last_mut() {
                    member.places.push(place_of(start)?.unwrap_or(NOWHERE));
                }
            }
            _ => {}
        }
        let n = match &self.current {
            Some(Element::Way(way)) => way.nodes.len().max(way.tags.len()),
            Some(Element::Relation(relation)) => relation.members.len().max(relation.tags.len()),
            _ => 0,
        };
        // One more, of which the error is made.
        if n > MOST_REFERENCES + 1 {
            Err(format!("an element with more than {MOST_REFERENCES} others"))
        } else {
            Ok(())
        }
    }

    /// Ends an element of XML.
    fn leave(&mut self, name: &[u8], each: Visitor<'_>) -> Result<()> {
        if name == b"remark" {
            check_remark(self.input, self.remark.take().as_deref())?;
        }
        match self.current.take_if(|_| Kind::of(name).is_some()) {
            Some(element) => each(element),
            None => Ok(()),
        }
    }
}

/// Returns an element without what stands inside of it.
fn begun(kind: Kind, start: &BytesStart<'_>) -> std::result::Result<Element<'static>, String> {
    let number = number(start, "id")?.ok_or("an element without `id`")?;
    Ok(match kind {
        Kind::Node => Element::Node(Node { number, place: place_of(start)?.ok_or("a node without `lat` or `lon`")? }),
        Kind::Way => Element::Way(Way { number, ..Way::default() }),
        Kind::Relation => Element::Relation(Relation { number, ..Relation::default() }),
    })
}

/// Returns the value of an attribute.
fn text(start: &BytesStart<'_>, name: &str) -> std::result::Result<Option<String>, String> {
    let attribute = start.try_get_attribute(name).map_err(|e| e.to_string())?;
    let value = attribute.map(|of| of.normalized_value(XmlVersion::Implicit1_0).map(|text| text.into_owned()));
    value.transpose().map_err(|e| format!("`{name}`: {e}"))
}

fn number(start: &BytesStart<'_>, name: &str) -> std::result::Result<Option<i64>, String> {
    let number = |text: String| text.trim().parse().map_err(|_| format!("`{name}` is `{text}`, no number"));
    text(start, name)?.map(number).transpose()
}

/// Returns the longitude and latitude of an element; `None` where it has none.
fn place_of(start: &BytesStart<'_>) -> std::result::Result<Option<[f64; 2]>, String> {
    let degrees = |name: &str| -> std::result::Result<Option<f64>, String> {
        let number = |text: String| text.trim().parse().map_err(|_| format!("`{name}` is `{text}`, no number"));
        text(start, name)?.map(number).transpose()
    };
    Ok(degrees("lon")?.zip(degrees("lat")?).map(|(lon, lat)| [lon, lat]))
}
