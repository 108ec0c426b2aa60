//! OpenStreetMap data: XML, PBF, and answers of the Overpass API in JSON.
//!
//! Positions stand in nodes, lines of nodes in ways, areas of several ways in relations. A file may
//! hold a whole country, of which buildings need little. It is therefore read three times:
//! relations first, then the ways that are buildings or that relations name, then the nodes of
//! these.
//!
//! The encodings ([`xml`], [`pbf`], [`overpass`]) hand over elements and know nothing of buildings.
//!
//! # References
//! OpenStreetMap Wiki: OSM XML, PBF Format, Overpass API/Output formats, Relation:multipolygon,
//! Relation:building, Simple 3D Buildings.

mod budget;
mod buildings;
mod collected;
mod joined;
mod overpass;
mod pbf;
mod wire;
mod xml;

use std::borrow::Cow;
use std::fmt;

use budget::Budget;
use collected::Collected;

use super::feature::{FeatureSet, bounds};
use super::selection::{Selection, meets};
use crate::crs;
use crate::error::Result;
use crate::input::Input;

/// Credit that the licence of the data asks for.
const ATTRIBUTION: &str = "© OpenStreetMap contributors";
/// First bytes that tell the encoding.
const HEAD_BYTES: u64 = 64;

/// Reads the buildings of a file. With bounds, only those that meet the box are kept.
///
/// # Errors
/// E302 for a damaged file and positions that are none; E303 for an early end; E304 for features of
/// PBF that are not read; E502 for more than the buildings of the file's size need.
pub(super) fn read(input: &Input, selection: Selection<'_>) -> Result<FeatureSet> {
    let head = input.head(HEAD_BYTES)?;
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&head).trim_ascii_start();
    let (mut file, length): (Box<dyn Encoding + '_>, u64) = match text.first() {
        Some(b'<') => {
            let (file, length) = input.open()?;
            (Box::new(xml::Xml { input, file }), length)
        }
        Some(b'{') => {
            let text = input.text("an answer of Overpass")?;
            let length = text.len() as u64;
            (Box::new(overpass::Answer { input, text }), length)
        }
        _ => {
            let (file, length) = input.open()?;
            (Box::new(pbf::Pbf::new(input, file, length)), length)
        }
    };
    let mut budget = Budget::of(input, length);
    let collected = Collected::of(input, &mut *file, &mut budget)?;
    let mut features = buildings::features(collected, &mut budget)?;
    let crs = crs::from_epsg(4326)?;
    if let Some(within) = selection.bounds_in(Some(&crs)) {
        features.retain(|feature| bounds(feature.polygons.iter()).is_none_or(|of| meets(of, within)));
    }
    Ok(FeatureSet { crs: Ok(Some(crs)), attribution: Some(ATTRIBUTION.to_string()), features, ..FeatureSet::default() })
}

/// Encoding of a file, which is read once for each kind of elements.
trait Encoding {
    /// Calls `each` with all elements of a kind, in the order of the file.
    fn visit(&mut self, kind: Kind, each: Visitor<'_>) -> Result<()>;
}

/// Receiver of elements.
type Visitor<'a> = &'a mut dyn FnMut(Element<'_>) -> Result<()>;

/// Kind of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Kind {
    Node,
    Way,
    Relation,
}

/// Identity of an element, written as `way/123`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Id {
    kind: Kind,
    number: i64,
}

/// An element.
#[derive(Debug)]
enum Element<'a> {
    Node(Node),
    Way(Way<'a>),
    Relation(Relation<'a>),
}

/// A place.
#[derive(Debug, Clone, Copy)]
struct Node {
    number: i64,
    /// Longitude and latitude \[degrees\].
    place: [f64; 2],
}

/// A line of nodes.
#[derive(Debug, Default)]
struct Way<'a> {
    number: i64,
    tags: Tags<'a>,
    /// Numbers of its nodes.
    nodes: Vec<i64>,
    /// Their places, where the file holds them here; [`NOWHERE`] for one that is missing.
    places: Vec<[f64; 2]>,
}

/// Elements that belong together.
#[derive(Debug, Default)]
struct Relation<'a> {
    number: i64,
    tags: Tags<'a>,
    members: Vec<Member>,
}

/// An element of a relation.
#[derive(Debug)]
struct Member {
    id: Id,
    role: Role,
    /// Places of a way, where the file holds them here.
    places: Vec<[f64; 2]>,
}

/// Role of a member.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    Outer,
    Inner,
    Outline,
    Part,
    /// Any other, or none.
    Other,
}

/// Keys and values.
type Tags<'a> = Vec<(Cow<'a, str>, Cow<'a, str>)>;

/// Place of a node that is not in the file.
const NOWHERE: [f64; 2] = [f64::NAN; 2];

impl Kind {
    /// Returns the kind of a name in XML and JSON.
    fn of(name: &[u8]) -> Option<Kind> {
        match name {
            b"node" => Some(Kind::Node),
            b"way" => Some(Kind::Way),
            b"relation" => Some(Kind::Relation),
            _ => None,
        }
    }
}

impl Role {
    fn of(name: &str) -> Role {
        match name {
            "outer" => Role::Outer,
            "inner" => Role::Inner,
            "outline" => Role::Outline,
            "part" => Role::Part,
            _ => Role::Other,
        }
    }
}

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = match self.kind {
            Kind::Node => "node",
            Kind::Way => "way",
            Kind::Relation => "relation",
        };
        write!(f, "{kind}/{}", self.number)
    }
}
