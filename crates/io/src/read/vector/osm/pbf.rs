//! PBF: blocks of elements, each packed by itself.
//!
//! A file is a row of blocks. In front of each stand the size of its header, and its header with the
//! size of the block. Sizes are compared with the format's limits and with the file before
//! anything is reserved. Later readings of a file skip blocks without elements of their kind.
//!
//! # References
//! OpenStreetMap Wiki, PBF Format; `fileformat.proto` and `osmformat.proto` of OSM-binary.

use std::io::{BufReader, Read, Seek, SeekFrom};

use flate2::bufread::ZlibDecoder;

use super::super::feature::malformed;
use super::collected::MOST_REFERENCES;
use super::wire::{Fault, Message, Numbers, Value, signed};
use super::{Element, Encoding, Id, Kind, Member, Node, Relation, Role, Tags, Visitor, Way};
use crate::error::{Cause, Error, ReadFault, Result};
use crate::input::{Input, Reader, cannot_read};

/// Largest header of a block \[bytes\].
const MOST_HEADER: u32 = 64 << 10;
/// Largest block, packed or not \[bytes\].
const MOST_BLOCK: u64 = 32 << 20;
/// Most texts of a block, which holds 8000 elements.
const MOST_TEXTS: usize = 1 << 20;
/// Features that a reader must know. Others change the meaning of a file.
const KNOWN_FEATURES: [&[u8]; 2] = [b"OsmSchema-V0.6", b"DenseNodes"];

/// File of blocks.
pub(super) struct Pbf<'a> {
    input: &'a Input,
    file: BufReader<Reader>,
    length: u64,
    /// Kinds of the elements of each block, once all have been read.
    contents: Option<Vec<Contents>>,
}

/// Kinds of elements in a block.
#[derive(Debug, Clone, Copy, Default)]
struct Contents {
    has_nodes: bool,
    has_ways: bool,
    has_relations: bool,
}

impl Contents {
    fn has(self, kind: Kind) -> bool {
        match kind {
            Kind::Node => self.has_nodes,
            Kind::Way => self.has_ways,
            Kind::Relation => self.has_relations,
        }
    }
}

impl Encoding for Pbf<'_> {
    fn visit(&mut self, kind: Kind, each: Visitor<'_>) -> Result<()> {
        self.file.seek(SeekFrom::Start(0)).map_err(|e| cannot_read(self.input, &e))?;
        let known = self.contents.take();
        let mut contents = Vec::new();
        let mut at = 0;
        while at < self.length {
            let (is_header, size, start) = self.next_header(at)?;
            if at == 0 && !is_header {
                return Err(malformed(self.input, "no header in the first block", "OpenStreetMap data in PBF"));
            }
            let of_block = known.as_ref().map(|known| known.get(contents.len()).copied().unwrap_or_default());
            if of_block.is_some_and(|of| !of.has(kind)) {
                self.file.seek_relative(size.cast_signed()).map_err(|e| cannot_read(self.input, &e))?;
                contents.push(of_block.unwrap_or_default());
            } else {
                let packed = self.bytes(size)?;
                let bytes = unpacked(self.input, start, &packed)?;
                contents.push(match is_header {
                    true => check_features(self.input, start, &bytes)?,
                    false => Block::of(self.input, start, &bytes)?.visit(&bytes, kind, each)?,
                });
            }
            at = start + size;
        }
        self.contents = Some(contents);
        Ok(())
    }
}

impl<'a> Pbf<'a> {
    pub(super) fn new(input: &'a Input, file: Reader, length: u64) -> Pbf<'a> {
        Pbf { input, file: BufReader::with_capacity(1 << 16, file), length, contents: None }
    }

    /// Reads the header of a block at a byte of the file. Returns `true` for the header of the file,
    /// the size of the block and its first byte.
    fn next_header(&mut self, at: u64) -> Result<(bool, u64, u64)> {
        let wrong = |fault: &str| fault_at(self.input, at, fault);
        if self.length - at < 4 {
            return Err(self.cut());
        }
        let mut size = [0; 4];
        self.file.read_exact(&mut size).map_err(|e| cannot_read(self.input, &e))?;
        let size = u32::from_be_bytes(size);
        if size >= MOST_HEADER {
            return Err(wrong(&format!("a header of {size} bytes")));
        }
        let start = at + 4 + u64::from(size);
        if start > self.length {
            return Err(self.cut());
        }
        let header = self.bytes(u64::from(size))?;
        let (mut message, mut name, mut size) = (Message(&header), None, None);
        while let Some((field, value)) = message.next_field().map_err(wrong)? {
            match field {
                1 => name = Some(value.bytes().map_err(wrong)?),
                3 => size = Some(value.number().map_err(wrong)?),
                _ => {}
            }
        }
        let (name, size) = name.zip(size).ok_or_else(|| wrong("a block without a name or a size"))?;
        if size > MOST_BLOCK {
            let what = format!("a block of {size} bytes at byte {at}, wanted at most {MOST_BLOCK}");
            return Err(Error::read(self.input, ReadFault::TooMany(what)));
        }
        if size > self.length - start {
            return Err(self.cut());
        }
        if ![&b"OSMHeader"[..], b"OSMData"].contains(&name) {
            return Err(wrong(&format!("a block named `{}`", String::from_utf8_lossy(name).escape_debug())));
        }
        Ok((name == b"OSMHeader", size, start))
    }

    /// Reads some bytes that the file has.
    fn bytes(&mut self, size: u64) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        (&mut self.file).take(size).read_to_end(&mut bytes).map_err(|e| cannot_read(self.input, &e))?;
        if (bytes.len() as u64) < size { Err(self.cut()) } else { Ok(bytes) }
    }

    fn cut(&self) -> Error {
        Error::truncated(self.input, "it ends inside of a block").because(Cause::CutShort)
    }
}

/// Returns E302 for a block at a byte of a file.
fn fault_at(input: &Input, at: u64, fault: &str) -> Error {
    malformed(input, &format!("at byte {at}: {fault}"), "OpenStreetMap data in PBF")
}

/// Unpacks a block at a byte of a file.
fn unpacked(input: &Input, at: u64, packed: &[u8]) -> Result<Vec<u8>> {
    let wrong = |fault: &str| fault_at(input, at, fault);
    let (mut message, mut size, mut content) = (Message(packed), None, None);
    while let Some((field, value)) = message.next_field().map_err(wrong)? {
        match field {
            1 => return Ok(value.bytes().map_err(wrong)?.to_vec()),
            2 => size = Some(value.number().map_err(wrong)?),
            3 => content = Some(value.bytes().map_err(wrong)?),
            4..=7 => {
                let name = ["LZMA", "bzip2", "LZ4", "Zstandard"][usize::try_from(field - 4).unwrap_or(0)];
                return Err(Error::unsupported(input, format!("blocks packed with {name}, wanted zlib")));
            }
            _ => {}
        }
    }
    let (content, size) = content.zip(size).ok_or_else(|| wrong("a block without content"))?;
    if size > MOST_BLOCK {
        let what = format!("a block at byte {at} of {size} bytes unpacked, wanted at most {MOST_BLOCK}");
        return Err(Error::read(input, ReadFault::TooMany(what)));
    }
    let mut bytes = Vec::new();
    let read = ZlibDecoder::new(content).take(size + 1).read_to_end(&mut bytes);
    read.map_err(|e| wrong(&format!("a block that cannot be unpacked ({e})")).because(Cause::CutShort))?;
    if bytes.len() as u64 != size {
        return Err(wrong(&format!("a block that is not of {size} bytes as it says")).because(Cause::CutShort));
    }
    Ok(bytes)
}

/// Checks the features that the header of a file requires. Returns the contents of that block: none.
fn check_features(input: &Input, at: u64, bytes: &[u8]) -> Result<Contents> {
    let wrong = |fault: Fault| fault_at(input, at, fault);
    let mut message = Message(bytes);
    while let Some((field, value)) = message.next_field().map_err(wrong)? {
        if field == 4 {
            let feature = value.bytes().map_err(wrong)?;
            if !KNOWN_FEATURES.contains(&feature) {
                let feature = String::from_utf8_lossy(feature);
                let what = format!("it requires `{}`, wanted a plain extract", feature.escape_debug());
                return Err(Error::unsupported(input, what));
            }
        }
    }
    Ok(Contents::default())
}

/// A block of elements.
struct Block<'a> {
    input: &'a Input,
    /// Its place in the file \[bytes\].
    at: u64,
    texts: Vec<&'a [u8]>,
    /// Unit of positions \[10⁻⁹ degrees\].
    granularity: i32,
    /// Longitude and latitude that positions count from \[10⁻⁹ degrees\].
    origin: [i64; 2],
}

impl<'a> Block<'a> {
    /// Reads the texts of a block and the unit of its positions.
    fn of(input: &'a Input, at: u64, bytes: &'a [u8]) -> Result<Block<'a>> {
        let mut block = Block { input, at, texts: Vec::new(), granularity: 100, origin: [0; 2] };
        let mut message = Message(bytes);
        while let Some((field, value)) = block.checked(message.next_field())? {
            match field {
                1 => {
                    let mut table = Message(block.checked(value.bytes())?);
                    while let Some((field, text)) = block.checked(table.next_field())? {
                        if field == 1 {
                            let text = block.checked(text.bytes())?;
                            block.texts.push(text);
                        }
                        if block.texts.len() > MOST_TEXTS {
                            return Err(block.too_many(&format!("more than {MOST_TEXTS} texts in a block")));
                        }
                    }
                }
                #[expect(clippy::cast_possible_truncation, reason = "numbers of 32 bits")]
                17 => block.granularity = block.checked(value.number())? as i32,
                19 => block.origin[1] = block.checked(value.number())?.cast_signed(),
                20 => block.origin[0] = block.checked(value.number())?.cast_signed(),
                _ => {}
            }
        }
        Ok(block)
    }

    /// Hands over the elements of a kind; returns the kinds that the block has.
    fn visit(&self, bytes: &[u8], kind: Kind, each: Visitor<'_>) -> Result<Contents> {
        let mut contents = Contents::default();
        let mut message = Message(bytes);
        while let Some((field, value)) = self.checked(message.next_field())? {
            if field != 2 {
                continue;
            }
            let mut group = Message(self.checked(value.bytes())?);
            while let Some((field, value)) = self.checked(group.next_field())? {
                let of = match field {
                    1 | 2 => Kind::Node,
                    3 => Kind::Way,
                    4 => Kind::Relation,
                    _ => continue,
                };
                match of {
                    Kind::Node => contents.has_nodes = true,
                    Kind::Way => contents.has_ways = true,
                    Kind::Relation => contents.has_relations = true,
                }
                if of != kind {
                    continue;
                }
                let element = Message(self.checked(value.bytes())?);
                match field {
                    1 => each(Element::Node(self.node(element)?))?,
                    2 => self.dense(element, each)?,
                    3 => each(Element::Way(self.way(element)?))?,
                    _ => each(Element::Relation(self.relation(element)?))?,
                }
            }
        }
        Ok(contents)
    }

    fn node(&self, mut message: Message<'_>) -> Result<Node> {
        let (mut number, mut lon, mut lat) = (None, None, None);
        while let Some((field, value)) = self.checked(message.next_field())? {
            let to = match field {
                1 => &mut number,
                8 => &mut lat,
                9 => &mut lon,
                _ => continue,
            };
            *to = Some(signed(self.checked(value.number())?));
        }
        let (Some(number), Some(lon), Some(lat)) = (number, lon, lat) else {
            return Err(self.fault("a node without a number or a place"));
        };
        Ok(Node { number, place: self.place(lon, lat) })
    }

    /// Hands over nodes that stand as lists of differences.
    fn dense(&self, mut message: Message<'_>, each: Visitor<'_>) -> Result<()> {
        let mut lists: [Option<Numbers<'_>>; 3] = [None; 3];
        while let Some((field, value)) = self.checked(message.next_field())? {
            let k = match field {
                1 => 0,
                9 => 1,
                8 => 2,
                _ => continue,
            };
            if lists[k].replace(self.checked(value.numbers())?).is_some() {
                return Err(self.fault("a list of nodes in several pieces"));
            }
        }
        let mut sums = [0_i64; 3];
        loop {
            let mut n_ended = 0;
            for (list, sum) in lists.iter_mut().zip(&mut sums) {
                match list.as_mut().map_or(Ok(None), Numbers::next_number).map_err(|fault| self.fault(fault))? {
                    Some(number) => *sum = sum.wrapping_add(signed(number)),
                    None => n_ended += 1,
                }
            }
            match n_ended {
                0 => each(Element::Node(Node { number: sums[0], place: self.place(sums[1], sums[2]) }))?,
                3 => return Ok(()),
                _ => return Err(self.fault("lists of nodes and places that differ in length")),
            }
        }
    }

    fn way(&self, mut message: Message<'_>) -> Result<Way<'_>> {
        let mut way = Way::default();
        let (mut keys, mut values, mut nodes, mut lons, mut lats) = (vec![], vec![], vec![], vec![], vec![]);
        while let Some((field, value)) = self.checked(message.next_field())? {
            match field {
                1 => way.number = self.checked(value.number())?.cast_signed(),
                2 => self.append(&mut keys, value)?,
                3 => self.append(&mut values, value)?,
                8 => self.append(&mut nodes, value)?,
                9 => self.append(&mut lats, value)?,
                10 => self.append(&mut lons, value)?,
                _ => {}
            }
        }
        way.tags = self.tags(&keys, &values)?;
        way.nodes = sums(&nodes).collect();
        // Some programs add the places of the nodes.
        if lons.len() == nodes.len() && lats.len() == nodes.len() {
            way.places = sums(&lons).zip(sums(&lats)).map(|(lon, lat)| self.place(lon, lat)).collect();
        }
        Ok(way)
    }

    fn relation(&self, mut message: Message<'_>) -> Result<Relation<'_>> {
        let mut relation = Relation::default();
        let (mut keys, mut values, mut roles, mut numbers, mut kinds) = (vec![], vec![], vec![], vec![], vec![]);
        while let Some((field, value)) = self.checked(message.next_field())? {
            match field {
                1 => relation.number = self.checked(value.number())?.cast_signed(),
                2 => self.append(&mut keys, value)?,
                3 => self.append(&mut values, value)?,
                8 => self.append(&mut roles, value)?,
                9 => self.append(&mut numbers, value)?,
                10 => self.append(&mut kinds, value)?,
                _ => {}
            }
        }
        if roles.len() != numbers.len() || kinds.len() != numbers.len() {
            return Err(self.fault("lists of members and roles that differ in length"));
        }
        relation.tags = self.tags(&keys, &values)?;
        for ((role, number), kind) in roles.iter().zip(sums(&numbers)).zip(&kinds) {
            let kind = match kind {
                0 => Kind::Node,
                1 => Kind::Way,
                2 => Kind::Relation,
                _ => return Err(self.fault("a member of an unknown kind")),
            };
            let role = Role::of(self.text(*role)?);
            relation.members.push(Member { id: Id { kind, number }, role, places: Vec::new() });
        }
        Ok(relation)
    }

    /// Appends the numbers of a list.
    fn append(&self, to: &mut Vec<u64>, value: Value<'_>) -> Result<()> {
        let mut numbers = self.checked(value.numbers())?;
        while let Some(number) = self.checked(numbers.next_number())? {
            if to.len() > MOST_REFERENCES {
                return Err(self.too_many(&format!("an element with more than {MOST_REFERENCES} nodes or members")));
            }
            to.push(number);
        }
        Ok(())
    }

    fn tags(&self, keys: &[u64], values: &[u64]) -> Result<Tags<'_>> {
        if keys.len() != values.len() {
            return Err(self.fault("lists of keys and values that differ in length"));
        }
        let tag = |(key, value): (&u64, &u64)| Ok((self.text(*key)?.into(), self.text(*value)?.into()));
        keys.iter().zip(values).map(tag).collect()
    }

    fn text(&self, number: u64) -> Result<&str> {
        let text = usize::try_from(number).ok().and_then(|k| self.texts.get(k));
        let text = text.ok_or_else(|| self.fault("the number of a text that the block does not have"))?;
        std::str::from_utf8(text).map_err(|_| self.fault("a text that is not UTF-8"))
    }

    #[expect(clippy::cast_precision_loss, reason = "positions on earth are exact")]
    fn place(&self, lon: i64, lat: i64) -> [f64; 2] {
        let degrees = |origin: i64, v: i64| {
            let nano = i128::from(origin) + i128::from(self.granularity) * i128::from(v);
            // The nearest number to the decimal one, as text is read.
            nano as f64 / 1e9
        };
        [degrees(self.origin[0], lon), degrees(self.origin[1], lat)]
    }

    fn checked<T>(&self, found: std::result::Result<T, Fault>) -> Result<T> {
        found.map_err(|fault| self.fault(fault))
    }

    fn fault(&self, fault: Fault) -> Error {
        fault_at(self.input, self.at, fault)
    }

    fn too_many(&self, found: &str) -> Error {
        let what = format!("at byte {}: {found}, wanted OpenStreetMap data in PBF", self.at);
        Error::read(self.input, ReadFault::TooMany(what))
    }
}

/// Returns the sums of differences.
fn sums(differences: &[u64]) -> impl Iterator<Item = i64> {
    differences.iter().scan(0_i64, |sum, of| {
        *sum = sum.wrapping_add(signed(*of));
        Some(*sum)
    })
}
