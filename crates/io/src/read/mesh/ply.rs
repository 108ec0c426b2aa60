//! PLY, as text or binary in either byte order: elements `vertex` with x, y, z and `face` with a
//! list of vertices.
//!
//! # References
//! Turk, The PLY Polygon File Format (1994).

use std::io::BufReader;

use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

use super::faces::Mesh;
use crate::error::{Error, Result};
use crate::input::Input;

/// Reads the vertices and faces of a file.
pub(super) fn read(input: &Input) -> Result<Mesh> {
    let wrong = |found: String| Error::malformed(input, format!("{found}, wanted a PLY mesh"));
    let (file, length) = input.open()?;
    let mut reader = Reader::new(BufReader::new(file));
    let parser = Parser::<Element>::new();
    let header = parser.read_header(&mut reader).map_err(|e| wrong(e.to_string()))?;
    for (name, element) in &header.elements {
        let is_empty = element.properties.is_empty() && element.count > 0;
        if is_empty || element.count as u64 > length {
            return Err(wrong(format!("{} elements `{name}` in {length} bytes", element.count)));
        }
    }
    let mut payload = parser.read_payload(&mut reader, &header).map_err(|e| wrong(e.to_string()))?;
    let mut mesh = Mesh::default();
    let vertices = payload.swap_remove("vertex").unwrap_or_default();
    mesh.vertices = vertices.into_iter().map(|v| v.position).collect();
    for (number, face) in payload.swap_remove("face").unwrap_or_default().into_iter().enumerate() {
        let face_of = |found: String| wrong(format!("face {}: {found}", number + 1));
        if face.corners.len() < 3 {
            return Err(face_of(format!("a face of {} vertices", face.corners.len())));
        }
        mesh.add_face(&face.corners).map_err(face_of)?;
    }
    Ok(mesh)
}

/// Kept properties of an element.
#[derive(Debug)]
struct Element {
    position: [f64; 3],
    corners: Vec<u32>,
}

impl PropertyAccess for Element {
    /// Creates an element. A coordinate that the file lacks stays NaN, and is refused as such.
    fn new() -> Self {
        Element { position: [f64::NAN; 3], corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let axis = ["x", "y", "z"].iter().position(|axis| *axis == name);
        match (axis, number(&value)) {
            (Some(axis), Some(v)) => self.position[axis] = v,
            _ if ["vertex_indices", "vertex_index"].contains(&name) => self.corners = corners(value),
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

fn number(value: &Property) -> Option<f64> {
    match *value {
        Property::Char(v) => Some(v.into()),
        Property::UChar(v) => Some(v.into()),
        Property::Short(v) => Some(v.into()),
        Property::UShort(v) => Some(v.into()),
        Property::Int(v) => Some(v.into()),
        Property::UInt(v) => Some(v.into()),
        Property::Float(v) => Some(v.into()),
        Property::Double(v) => Some(v),
        _ => None,
    }
}

/// Returns numbers of vertices; a negative one becomes one beyond any vertex.
fn corners(value: Property) -> Vec<u32> {
    fn unsigned<T: TryInto<u32>>(list: Vec<T>) -> Vec<u32> {
        list.into_iter().map(|k| k.try_into().unwrap_or(u32::MAX)).collect()
    }
    match value {
        Property::ListChar(list) => unsigned(list),
        Property::ListUChar(list) => unsigned(list),
        Property::ListShort(list) => unsigned(list),
        Property::ListUShort(list) => unsigned(list),
        Property::ListInt(list) => unsigned(list),
        Property::ListUInt(list) => list,
        _ => Vec::new(),
    }
}
