//! Vertical systems, the datum and unit of heights: from the EPSG registry, or as a file names its
//! own.

use proj_core::lookup_vertical_epsg;

use super::wkt;

/// A vertical coordinate reference system.
#[derive(Debug, Clone, PartialEq)]
pub struct VerticalCrs {
    epsg: Option<u32>,
    name: String,
    meters_per_unit: Option<f64>,
    reference: Reference,
}

/// Surface that heights are measured from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reference {
    /// A datum of the registry, near mean sea level.
    Datum(u32),
    /// An ellipsoid: tens of meters from any sea level.
    Ellipsoid,
    /// A surface known only by name.
    Named,
}

/// Difference between two vertical systems.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VerticalDifference {
    /// No difference, except perhaps in the unit.
    None,
    /// Different or unknown datums: heights differ by an amount not known here, centimeters to
    /// meters, or anything.
    Datum,
    /// One is above an ellipsoid and the other above a datum: heights are tens of meters apart.
    Ellipsoid,
}

/// Three-dimensional geographic systems, whose heights are above their ellipsoid: WGS 84, ETRS89,
/// NAD83(2011), NAD83.
const ELLIPSOIDAL: [u32; 4] = [4979, 4937, 6319, 4957];

impl VerticalCrs {
    /// Returns the system with an EPSG code, by its name in the registry. An unregistered code is
    /// known by `name` alone, or by its number. Codes of three-dimensional geographic systems give
    /// heights above the ellipsoid.
    pub fn from_epsg(code: u32, name: Option<&str>) -> VerticalCrs {
        if let Some(known) = lookup_vertical_epsg(code) {
            let reference = known.vertical_datum_epsg().map_or(Reference::Ellipsoid, Reference::Datum);
            let meters_per_unit = Some(known.linear_unit_to_meter());
            return VerticalCrs { epsg: Some(code), name: known.name().to_string(), meters_per_unit, reference };
        }
        let is_ellipsoidal = ELLIPSOIDAL.contains(&code);
        let reference = if is_ellipsoidal { Reference::Ellipsoid } else { Reference::Named };
        let name = match name {
            Some(name) => name.to_string(),
            None if is_ellipsoidal => "ellipsoidal height".to_string(),
            None => format!("EPSG:{code}"),
        };
        VerticalCrs { epsg: Some(code), name, meters_per_unit: is_ellipsoidal.then_some(1.0), reference }
    }

    /// Returns the vertical system in the text of a reference system. That is the vertical part of
    /// a compound WKT or of `EPSG:n+n`, or the ellipsoid of a three-dimensional WKT.
    pub(crate) fn in_text(text: &str) -> Option<VerticalCrs> {
        if let Some(node) = wkt::vertical_node(text) {
            let name = wkt::name_of(node).unwrap_or("unnamed");
            let known = wkt::epsg_of(node).map(|code| VerticalCrs::from_epsg(code, Some(name)));
            let named = known.unwrap_or_else(|| VerticalCrs::named(name));
            let unit = named.meters_per_unit.or_else(|| wkt::unit_of(node));
            return Some(VerticalCrs { meters_per_unit: unit, ..named });
        }
        if wkt::is_three_dimensional(text) {
            return Some(VerticalCrs::from_epsg(ELLIPSOIDAL[0], None));
        }
        let (_, code) = text.split_once('+').filter(|_| !text.contains('['))?;
        let code = code.trim().trim_start_matches("EPSG:").parse().ok()?;
        Some(VerticalCrs::from_epsg(code, None))
    }

    /// Returns a system that a file describes by name.
    pub fn named(name: &str) -> VerticalCrs {
        let name = name.trim().to_string();
        VerticalCrs { epsg: None, name, meters_per_unit: None, reference: Reference::Named }
    }

    /// Returns the EPSG code.
    pub fn epsg(&self) -> Option<u32> {
        self.epsg
    }

    /// Returns the name, for example `NAVD88 height (ftUS)`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the name with the code, for messages.
    pub fn in_words(&self) -> String {
        match self.epsg {
            Some(code) if self.name != format!("EPSG:{code}") => format!("{} (EPSG:{code})", self.name),
            _ => self.name.clone(),
        }
    }

    /// Returns the length of the unit of heights \[m\]; `None` if it is not known.
    pub fn meters_per_unit(&self) -> Option<f64> {
        self.meters_per_unit
    }

    /// Returns the difference to another system, units apart.
    pub fn difference(&self, other: &VerticalCrs) -> VerticalDifference {
        match (self.reference, other.reference) {
            (Reference::Datum(a), Reference::Datum(b)) if a == b => VerticalDifference::None,
            (Reference::Ellipsoid, Reference::Ellipsoid) => VerticalDifference::None,
            (Reference::Named, Reference::Named) if self.name == other.name => VerticalDifference::None,
            (Reference::Ellipsoid, Reference::Datum(_)) | (Reference::Datum(_), Reference::Ellipsoid) => {
                VerticalDifference::Ellipsoid
            }
            _ => VerticalDifference::Datum,
        }
    }
}
