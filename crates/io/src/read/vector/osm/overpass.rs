//! Answers of the Overpass API in JSON: a list of elements, with their places where it was told to.
//!
//! A server that runs out of time or memory ends its answer early and remarks upon it. Such an
//! answer is refused.

use std::borrow::Cow;

use serde::Deserialize;
use serde_json::error::Category;
use serde_json::value::RawValue;

use super::super::feature::malformed;
use super::super::unique::Members;
use super::{Element, Encoding, Id, Kind, Member, NOWHERE, Node, Relation, Role, Visitor, Way};
use crate::error::{Cause, Error, MOST_FOUND, Place, Result, shortened};
use crate::input::Input;

/// Text of an answer.
pub(super) struct Answer<'a> {
    pub(super) input: &'a Input,
    pub(super) text: String,
}

/// Outermost level of an answer.
#[derive(Deserialize)]
struct Document<'a> {
    #[serde(borrow)]
    elements: Vec<&'a RawValue>,
    remark: Option<String>,
}

#[derive(Deserialize)]
struct Item<'a> {
    #[serde(rename = "type", borrow)]
    kind: Cow<'a, str>,
    id: i64,
    lat: Option<f64>,
    lon: Option<f64>,
    #[serde(default)]
    nodes: Vec<i64>,
    #[serde(default)]
    geometry: Vec<Option<Position>>,
    #[serde(default, borrow)]
    members: Vec<ItemMember<'a>>,
    tags: Option<Members<String>>,
}

#[derive(Deserialize)]
struct ItemMember<'a> {
    #[serde(rename = "type", borrow)]
    kind: Cow<'a, str>,
    #[serde(rename = "ref")]
    number: i64,
    #[serde(borrow, default)]
    role: Cow<'a, str>,
    #[serde(default)]
    geometry: Vec<Option<Position>>,
}

#[derive(Deserialize)]
struct Position {
    lat: f64,
    lon: f64,
}

impl Encoding for Answer<'_> {
    fn visit(&mut self, kind: Kind, each: Visitor<'_>) -> Result<()> {
        let text = self.text.strip_prefix('\u{feff}').unwrap_or(&self.text);
        let wrong = |error: &serde_json::Error| match error.classify() {
            Category::Eof => Error::truncated(self.input, "it ends inside of a value").because(Cause::CutShort),
            _ => malformed(self.input, &shortened(&error.to_string(), MOST_FOUND), "an answer of Overpass"),
        };
        let document: Document<'_> = serde_json::from_str(text).map_err(|e| wrong(&e))?;
        check_remark(self.input, document.remark.as_deref())?;
        for (k, raw) in document.elements.iter().enumerate() {
            let item: Item<'_> =
                serde_json::from_str(raw.get()).map_err(|e| wrong(&e).at(Place::Feature(k as u64 + 1)))?;
            if Kind::of(item.kind.as_bytes()) == Some(kind)
                && let Some(element) = item.element(kind)
            {
                each(element)?;
            }
        }
        Ok(())
    }
}

impl<'a> Item<'a> {
    /// Returns the element; `None` for a node without a place.
    fn element(self, kind: Kind) -> Option<Element<'a>> {
        let number = self.id;
        let tags = self.tags.into_iter().flat_map(|Members(tags)| tags);
        let tags = tags.map(|(key, value)| (key.into(), value.into())).collect();
        Some(match kind {
            Kind::Node => Element::Node(Node { number, place: [self.lon?, self.lat?] }),
            Kind::Way => Element::Way(Way { number, tags, nodes: self.nodes, places: places(&self.geometry) }),
            Kind::Relation => {
                let member = |of: ItemMember<'_>| {
                    let id = Id { kind: Kind::of(of.kind.as_bytes())?, number: of.number };
                    Some(Member { id, role: Role::of(&of.role), places: places(&of.geometry) })
                };
                let members = self.members.into_iter().filter_map(member).collect();
                Element::Relation(Relation { number, tags, members })
            }
        })
    }
}

/// Returns places. Those outside of the asked box are `null`.
fn places(geometry: &[Option<Position>]) -> Vec<[f64; 2]> {
    geometry.iter().map(|place| place.as_ref().map_or(NOWHERE, |of| [of.lon, of.lat])).collect()
}

/// Refuses an answer that a server ended early.
///
/// # Errors
/// E303 with the remark.
pub(super) fn check_remark(input: &Input, remark: Option<&str>) -> Result<()> {
    match remark.map(str::trim).filter(|remark| remark.contains("error")) {
        Some(remark) => {
            let what = format!("the server ended it early: `{}`", shortened(remark, MOST_FOUND));
            Err(Error::truncated(input, what))
        }
        None => Ok(()),
    }
}
