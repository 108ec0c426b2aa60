//! Common form of all formats of vector data: features with properties and polygons.

use std::sync::Arc;

use serde_json::{Map, Value};

use super::super::polygon::Polygon;
use super::super::solid::{Face, Solid};
use super::surfaces::CornerHeights;
use crate::crs;
use crate::error::{Error, OddFile, ReadFault, Result};
use crate::input::Input;
use crate::raster::Crs;

/// Content of a file of vector data.
#[derive(Debug)]
pub(in crate::read) struct FeatureSet {
    /// CRS that the file names; an error counts only where no other CRS is given.
    pub(in crate::read) crs: Result<Option<Crs>>,
    /// Name of the place in the file, capitalized.
    pub(in crate::read) name: Option<String>,
    /// Credit that a picture must show.
    pub(in crate::read) attribution: Option<String>,
    /// Largest number of characters that the format keeps of a property's name.
    pub(in crate::read) name_limit: Option<usize>,
    /// Features in the order of the file.
    pub(in crate::read) features: Vec<Feature>,
    /// `true` if the file lies outside of what is wanted, and was left unread.
    pub(in crate::read) is_outside: bool,
    /// An oddity of the file, if any.
    pub(in crate::read) oddity: Option<OddFile>,
}

/// A feature as the file holds it.
#[derive(Debug, Default)]
pub(in crate::read) struct Feature {
    /// Id in the file, if any.
    pub(in crate::read) id: Option<String>,
    /// Properties by name.
    pub(in crate::read) properties: Properties,
    /// Properties of its building, of a part: they count where its own do not have the name.
    pub(in crate::read) of_building: Option<Arc<Properties>>,
    /// Its areas; empty without any.
    pub(in crate::read) polygons: Vec<Polygon>,
    /// `true` if it has points or lines beside its areas.
    pub(in crate::read) has_other_parts: bool,
    /// Lowest and highest point of a solid \[m above the datum\].
    pub(in crate::read) heights: Option<[f64; 2]>,
    /// Surfaces of its roof; none where the file holds areas alone.
    pub(in crate::read) roof: Vec<Face>,
    /// Polygons that a solid covers of the ground, where known.
    pub(in crate::read) ground: Vec<Polygon>,
    /// Height from another source than its surfaces.
    pub(in crate::read) height: Option<SolidHeight>,
    /// Heights in its geometry that may make it a building of surfaces.
    pub(in crate::read) z: CornerHeights,
    /// `true` for a solid that neither walls nor a ground surface lead to the ground.
    pub(in crate::read) is_lofty: bool,
    /// Name of the building that it is a part of.
    pub(in crate::read) part_of: Option<String>,
}

/// Height of a building whose surfaces do not define it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::read) enum SolidHeight {
    /// Height above the ground \[m\].
    Measured(f64),
    /// Missing.
    Unknown,
}

/// Properties by name; formats with columns share the names.
pub(in crate::read) type Properties = Vec<(Arc<str>, Property)>;

/// Value of a property.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::read) enum Property {
    /// A number.
    Number(f64),
    /// Text.
    Text(String),
    /// Nothing, or a value that can be neither a height nor a word.
    Null,
}

impl FeatureSet {
    /// Creates the content of a file that lies outside of what is wanted.
    pub(super) fn outside(crs: Result<Option<Crs>>) -> FeatureSet {
        FeatureSet { crs, is_outside: true, ..FeatureSet::default() }
    }
}

impl Default for FeatureSet {
    fn default() -> Self {
        FeatureSet {
            crs: Ok(None),
            name: None,
            attribution: None,
            name_limit: None,
            features: Vec::new(),
            is_outside: false,
            oddity: None,
        }
    }
}

impl Feature {
    /// Creates a feature of a solid, without properties.
    pub(in crate::read) fn of_solid(Solid { polygons, heights, roof, ground, .. }: Solid) -> Feature {
        Feature { polygons, heights, roof, ground, ..Feature::default() }
    }

    /// Returns the id in the file, or the property `id`.
    pub(in crate::read) fn known_id(&self) -> Option<String> {
        self.id.clone().or_else(|| self.property("id", None).and_then(Property::text))
    }

    /// Exchanges x and y.
    pub(super) fn swap_axes(&mut self) {
        for [x, y] in self.polygons.iter_mut().chain(&mut self.ground).flatten().flatten() {
            std::mem::swap(x, y);
        }
        let surfaces = match &mut self.z {
            CornerHeights::Surfaces(faces) => faces.as_mut_slice(),
            CornerHeights::None | CornerHeights::Level => &mut [],
        };
        for [x, y, _] in self.roof.iter_mut().chain(surfaces).flatten().flatten() {
            std::mem::swap(x, y);
        }
    }

    /// Lists its own properties, then those of its building.
    pub(in crate::read) fn all_properties(&self) -> impl Iterator<Item = &(Arc<str>, Property)> {
        self.properties.iter().chain(self.of_building.iter().flat_map(|all| all.iter()))
    }

    /// Returns the value of a property. Where the format cuts names, `name` also matches its cut
    /// form.
    pub(in crate::read) fn property(&self, name: &str, name_limit: Option<usize>) -> Option<&Property> {
        self.column(name, name_limit).filter(|value| **value != Property::Null)
    }

    /// Returns the value of a property, `null` included.
    pub(in crate::read) fn column(&self, name: &str, name_limit: Option<usize>) -> Option<&Property> {
        let find = |name: &str| {
            let of =
                |is_it: &dyn Fn(&str) -> bool| self.all_properties().find(|(n, _)| is_it(n)).map(|(_, value)| value);
            // GDAL writes an underscore for a colon.
            let is_like = |n: &str| {
                let pairs = || n.bytes().zip(name.bytes());
                n.len() == name.len() && pairs().all(|(a, b)| a == b || (a, b) == (b'_', b':'))
            };
            of(&|n| n == name).or_else(|| of(&is_like).filter(|_| name.contains(':')))
        };
        find(name).or_else(|| find(&name.chars().take(name_limit?).collect::<String>()))
    }
}

/// Appends other properties: those of an object `tags`, or of the building of a part. The first
/// value of a name that is not `null` counts.
pub(super) fn with_others(mut properties: Properties, others: &Map<String, Value>) -> Properties {
    for (name, value) in others {
        match properties.iter_mut().find(|(known, _)| **known == **name) {
            Some((_, known)) if *known == Property::Null => *known = Property::of_json(value),
            Some(_) => {}
            None => properties.push((name.as_str().into(), Property::of_json(value))),
        }
    }
    properties
}

impl Feature {
    /// Appends the tags that a format holds as the text of a JSON object, as GDAL writes them.
    pub(super) fn open_tags(&mut self) {
        let text = self.properties.iter().find(|(name, _)| **name == *"tags").and_then(|(_, value)| value.text());
        let tags = text.filter(|text| text.starts_with('{')).and_then(|text| serde_json::from_str(&text).ok());
        if let Some(Value::Object(tags)) = tags {
            self.properties = with_others(std::mem::take(&mut self.properties), &tags);
        }
    }
}

impl Property {
    /// Returns the value as text.
    pub(in crate::read) fn text(&self) -> Option<String> {
        match self {
            Property::Number(n) => Some(n.to_string()),
            Property::Text(text) => Some(text.clone()),
            Property::Null => None,
        }
    }
}

/// Returns E302 for a file that is not what its name promises.
pub(super) fn malformed(input: &Input, found: &str, wanted: &str) -> Error {
    Error::malformed(input, format!("{found}, wanted {wanted}"))
}

/// Returns the CRS that a text in a file describes.
pub(super) fn crs_of(input: &Input, text: &str) -> Result<Option<Crs>> {
    if text.trim().is_empty() {
        return Ok(None);
    }
    let said = || "its coordinate reference system".to_string();
    crs::parse(text).map(Some).map_err(|e| Error::read(input, ReadFault::Crs(said(), e.to_string())))
}

/// Returns west, south, east, north of polygons; `None` if they have no position.
pub(in crate::read) fn bounds<'a>(polygons: impl Iterator<Item = &'a Polygon>) -> Option<[f64; 4]> {
    polygons.flatten().flatten().fold(None, |bounds, &[x, y]| {
        let [w, s, e, n] = bounds.unwrap_or([x, y, x, y]);
        Some([w.min(x), s.min(y), e.max(x), n.max(y)])
    })
}

/// Drops a last point of rings that repeats the first. Returns the polygons, and the number of
/// rings that do not end where they begin.
pub(in crate::read) fn opened(mut polygons: Vec<Polygon>) -> (Vec<Polygon>, usize) {
    let mut unclosed = 0;
    for ring in polygons.iter_mut().flatten() {
        if ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        } else {
            unclosed += usize::from(!ring.is_empty());
        }
    }
    (polygons, unclosed)
}
