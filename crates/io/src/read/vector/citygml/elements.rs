//! Elements of CityGML by their local names.

use std::sync::Arc;

use super::super::super::solid::FaceKind;

/// Meaning of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Element {
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
    /// The box around a file.
    Envelope,
    /// A corner of the box.
    Corner,
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
    pub(super) fn of(name: &[u8]) -> Element {
        match name {
            b"Building" => Element::Building,
            b"BuildingPart" => Element::Part,
            b"RoofSurface" | b"OuterFloorSurface" => Element::Surface(FaceKind::Roof),
            b"GroundSurface" => Element::Surface(FaceKind::Ground),
            b"WallSurface" | b"OuterCeilingSurface" | b"ClosureSurface" => Element::Surface(FaceKind::Other),
            b"Polygon" | b"Triangle" | b"Rectangle" | b"PolygonPatch" => Element::Polygon,
            b"LinearRing" => Element::Ring,
            b"posList" | b"pos" | b"coordinates" => Element::Positions,
            b"Envelope" => Element::Envelope,
            b"lowerCorner" | b"upperCorner" => Element::Corner,
            b"Height" | b"HeightAboveGround" => Element::Height,
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
pub(super) struct Elements {
    pub(super) open: Vec<Open>,
    pub(super) n_hidden: usize,
    /// Rings of the current polygon.
    pub(super) rings: Option<Vec<Vec<[f64; 3]>>>,
    pub(super) ring: Option<Vec<[f64; 3]>>,
    /// `true` if the current polygon has positions without a height.
    pub(super) is_plane: bool,
    /// Corners of the current envelope.
    pub(super) corners: Vec<[f64; 3]>,
    /// Corners of the envelope of the file, just read.
    pub(super) envelope: Option<Vec<[f64; 2]>>,
    /// Name of the current generic attribute.
    pub(super) name: Option<String>,
}

/// An element that is open.
#[derive(Debug)]
pub(super) struct Open {
    pub(super) element: Element,
    /// Numbers of a position, where the element says so.
    pub(super) dimension: Option<usize>,
    /// Local name of what may be a property.
    pub(super) name: Option<Arc<str>>,
    /// Length of its unit \[m\].
    pub(super) unit_m: f64,
}

impl Elements {
    /// Returns `true` where text matters.
    pub(super) fn holds_text(&self) -> bool {
        self.n_hidden == 0
            && self.open.last().is_some_and(|open| {
                let is_known =
                    [Element::Positions, Element::Corner, Element::Value, Element::Name].contains(&open.element);
                is_known || open.name.is_some()
            })
    }

    /// Returns the innermost element but one, the parent of the current one.
    pub(super) fn parent(&self) -> Option<&Open> {
        self.open.len().checked_sub(2).map(|k| &self.open[k])
    }

    /// Returns the level of detail and the meaning of the current polygon.
    pub(super) fn place(&self) -> Option<(usize, FaceKind)> {
        let around = || self.open.iter().rev().map(|open| open.element);
        let level =
            around().find_map(|element| if let Element::Level(level) = element { Some(level) } else { None })?;
        let kind = around().find_map(|element| if let Element::Surface(kind) = element { Some(kind) } else { None });
        Some((level, kind.unwrap_or(FaceKind::Unknown)))
    }

    /// Returns the number of coordinates of a position that the elements around it tell.
    pub(super) fn dimension(&self) -> Option<usize> {
        self.open.iter().rev().find_map(|open| open.dimension)
    }
}
