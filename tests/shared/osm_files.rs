//! Writes small cities of OpenStreetMap as XML, as PBF and as answers of the Overpass API.

#![allow(dead_code, reason = "each test uses a part")]

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde_json::{Value, json};

/// Position \[10⁻⁷ degrees\]: longitude, latitude.
pub(crate) type Place = [i64; 2];

#[derive(Debug, Clone, Default)]
pub(crate) struct Osm {
    pub(crate) nodes: Vec<(i64, Place)>,
    pub(crate) ways: Vec<Way>,
    pub(crate) relations: Vec<Relation>,
}

#[derive(Debug, Clone)]
pub(crate) struct Way {
    pub(crate) id: i64,
    pub(crate) nodes: Vec<i64>,
    pub(crate) tags: Tags,
}

#[derive(Debug, Clone)]
pub(crate) struct Relation {
    pub(crate) id: i64,
    /// Kind, number, role.
    pub(crate) members: Vec<(&'static str, i64, &'static str)>,
    pub(crate) tags: Tags,
}

pub(crate) type Tags = Vec<(&'static str, &'static str)>;

/// Form of an answer of Overpass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    /// `out geom`.
    Places,
    /// `out geom` of relations alone: ways stand in them.
    PlacesOfMembers,
    /// `out body; >; out skel`.
    Nodes,
}

/// A number of 10⁻⁷ degrees as text.
fn degrees(v: i64) -> String {
    format!("{}{}.{:07}", if v < 0 { "-" } else { "" }, v.abs() / 10_000_000, v.abs() % 10_000_000)
}

impl Osm {
    fn place(&self, node: i64) -> Option<Place> {
        self.nodes.iter().find(|(id, _)| *id == node).map(|(_, place)| *place)
    }

    pub(crate) fn xml(&self) -> String {
        let tags = |tags: &Tags| tags.iter().map(|(k, v)| format!("<tag k='{k}' v=\"{v}\"/>")).collect::<String>();
        let mut text = "<?xml version='1.0' encoding='UTF-8'?>\n<osm version='0.6' generator='test'>\n".to_string();
        for (id, [lon, lat]) in &self.nodes {
            text += &format!("<node id='{id}' lat='{}' lon='{}'/>\n", degrees(*lat), degrees(*lon));
        }
        for Way { id, nodes, tags: of } in &self.ways {
            let nodes: String = nodes.iter().map(|id| format!("<nd ref='{id}'/>")).collect();
            text += &format!("<way id='{id}'>{nodes}{}</way>\n", tags(of));
        }
        for Relation { id, members, tags: of } in &self.relations {
            let member =
                |(kind, id, role): &(&str, i64, &str)| format!("<member type='{kind}' ref='{id}' role='{role}'/>");
            let members: String = members.iter().map(member).collect();
            text += &format!("<relation id='{id}'>{members}{}</relation>\n", tags(of));
        }
        text + "</osm>\n"
    }

    pub(crate) fn overpass(&self, form: Form) -> String {
        let number = |v: i64| degrees(v).parse::<f64>().unwrap_or(f64::NAN);
        let places = |nodes: &[i64]| -> Vec<Value> {
            nodes
                .iter()
                .map(|id| {
                    self.place(*id).map_or(Value::Null, |[lon, lat]| json!({"lat": number(lat), "lon": number(lon)}))
                })
                .collect()
        };
        let tags = |tags: &Tags| json!(tags.iter().copied().collect::<std::collections::BTreeMap<_, _>>());
        let (mut ways, mut relations) = (Vec::new(), Vec::new());
        for Way { id, nodes, tags: of } in &self.ways {
            let mut way = json!({"type": "way", "id": id, "nodes": nodes, "tags": tags(of)});
            if form != Form::Nodes {
                way["geometry"] = json!(places(nodes));
            }
            if !of.is_empty() || form != Form::PlacesOfMembers {
                ways.push(way);
            }
        }
        for Relation { id, members, tags: of } in &self.relations {
            let member = |(kind, id, role): &(&str, i64, &str)| {
                let mut member = json!({"type": kind, "ref": id, "role": role});
                let way = self.ways.iter().find(|way| *kind == "way" && way.id == *id);
                if let (Some(way), true) = (way, form != Form::Nodes) {
                    member["geometry"] = json!(places(&way.nodes));
                }
                member
            };
            let members: Vec<Value> = members.iter().map(member).collect();
            relations.push(json!({"type": "relation", "id": id, "members": members, "tags": tags(of)}));
        }
        let nodes = self.nodes.iter().filter(|_| form == Form::Nodes);
        let nodes =
            nodes.map(|(id, [lon, lat])| json!({"type": "node", "id": id, "lat": number(*lat), "lon": number(*lon)}));
        let elements: Vec<Value> = relations.into_iter().chain(ways).chain(nodes).collect();
        let server = json!({"timestamp_osm_base": "2026-11-20T10:00:00Z"});
        json!({"version": 0.6, "generator": "Overpass API", "osm3s": server, "elements": elements}).to_string()
    }

    /// A file of PBF, and the bytes where its blocks begin. Nodes are written one by one or `dense`.
    pub(crate) fn pbf(&self, dense: bool) -> (Vec<u8>, Vec<usize>) {
        let mut texts = Texts(vec![""]);
        let mut blocks = vec![header_block()];
        blocks.push(self.nodes_block(dense));
        let ways: Vec<u8> = self.ways.iter().flat_map(|way| bytes(3, &way_of(way, &mut texts))).collect();
        blocks.push(data_block(&texts.0, &ways));
        let relations: Vec<u8> = self.relations.iter().flat_map(|of| bytes(4, &relation_of(of, &mut texts))).collect();
        blocks.push(data_block(&texts.0, &relations));
        let starts = blocks.iter().scan(0, |at, block| Some(std::mem::replace(at, *at + block.len()))).collect();
        (blocks.concat(), starts)
    }

    fn nodes_block(&self, dense: bool) -> Vec<u8> {
        let group: Vec<u8> = if dense {
            let list = |of: &dyn Fn(&(i64, Place)) -> i64| packed(&differences(self.nodes.iter().map(of)));
            bytes(2, &[bytes(1, &list(&|n| n.0)), bytes(8, &list(&|n| n.1[1])), bytes(9, &list(&|n| n.1[0]))].concat())
        } else {
            let node = |(id, [lon, lat]): &(i64, Place)| {
                let of = [(1, *id), (8, *lat), (9, *lon)].map(|(field, v)| number(field, zigzag(v)));
                bytes(1, &of.concat())
            };
            self.nodes.iter().flat_map(node).collect()
        };
        data_block(&[""], &group)
    }
}

/// Texts of a block, to which elements refer by number.
struct Texts(Vec<&'static str>);

impl Texts {
    fn number(&mut self, text: &'static str) -> u64 {
        let known = self.0.iter().position(|of| *of == text);
        known.unwrap_or_else(|| {
            self.0.push(text);
            self.0.len() - 1
        }) as u64
    }
}

fn tags_of(tags: &Tags, texts: &mut Texts) -> Vec<u8> {
    let (keys, values): (Vec<u64>, Vec<u64>) = tags.iter().map(|(k, v)| (texts.number(k), texts.number(v))).unzip();
    [bytes(2, &packed(&keys)), bytes(3, &packed(&values))].concat()
}

fn way_of(way: &Way, texts: &mut Texts) -> Vec<u8> {
    let nodes = bytes(8, &packed(&differences(way.nodes.iter().copied())));
    [number(1, way.id.cast_unsigned()), tags_of(&way.tags, texts), nodes].concat()
}

fn relation_of(relation: &Relation, texts: &mut Texts) -> Vec<u8> {
    let roles: Vec<u64> = relation.members.iter().map(|(_, _, role)| texts.number(role)).collect();
    let kinds = relation.members.iter().map(|(kind, ..)| match *kind {
        "node" => 0,
        "way" => 1,
        _ => 2,
    });
    let numbers = packed(&differences(relation.members.iter().map(|(_, id, _)| *id)));
    let lists = [bytes(8, &packed(&roles)), bytes(9, &numbers), bytes(10, &packed(&kinds.collect::<Vec<u64>>()))];
    [number(1, relation.id.cast_unsigned()), tags_of(&relation.tags, texts), lists.concat()].concat()
}

/// The first block of a file.
pub(crate) fn header_block() -> Vec<u8> {
    let features = ["OsmSchema-V0.6", "DenseNodes"].map(|name| bytes(4, name.as_bytes()));
    block("OSMHeader", &features.concat())
}

/// A block of one group of elements.
pub(crate) fn data_block(texts: &[&str], group: &[u8]) -> Vec<u8> {
    let table: Vec<u8> = texts.iter().flat_map(|text| bytes(1, text.as_bytes())).collect();
    block("OSMData", &[bytes(1, &table), bytes(2, group)].concat())
}

/// A packed block with its header.
pub(crate) fn block(name: &str, content: &[u8]) -> Vec<u8> {
    block_of_size(name, content, content.len() as u64)
}

/// A packed block that says to be of some size.
pub(crate) fn block_of_size(name: &str, content: &[u8], size: u64) -> Vec<u8> {
    let mut zlib = ZlibEncoder::new(Vec::new(), Compression::best());
    zlib.write_all(content).expect("memory");
    framed(name, &[number(2, size), bytes(3, &zlib.finish().expect("memory"))].concat())
}

/// A block with its header.
pub(crate) fn framed(name: &str, blob: &[u8]) -> Vec<u8> {
    let header = [bytes(1, name.as_bytes()), number(3, blob.len() as u64)].concat();
    let size = u32::try_from(header.len()).expect("a small header").to_be_bytes();
    [size.as_slice(), &header, blob].concat()
}

pub(crate) fn varint(mut v: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while v > 0x7f {
        bytes.push((v & 0x7f) as u8 | 0x80);
        v >>= 7;
    }
    bytes.push((v & 0x7f) as u8);
    bytes
}

pub(crate) fn number(field: u64, v: u64) -> Vec<u8> {
    [varint(field << 3), varint(v)].concat()
}

pub(crate) fn bytes(field: u64, of: &[u8]) -> Vec<u8> {
    [varint(field << 3 | 2), varint(of.len() as u64), of.to_vec()].concat()
}

pub(crate) fn packed(numbers: &[u64]) -> Vec<u8> {
    numbers.iter().flat_map(|v| varint(*v)).collect()
}

fn zigzag(v: i64) -> u64 {
    ((v << 1) ^ (v >> 63)).cast_unsigned()
}

fn differences(numbers: impl Iterator<Item = i64>) -> Vec<u64> {
    let mut last = 0;
    numbers.map(|v| zigzag(v - std::mem::replace(&mut last, v))).collect()
}
